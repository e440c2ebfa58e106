//! Many rays at once: columns in, columns out.

use glam::DVec3;
use thiserror::Error;

#[cfg(feature = "simd")]
use crate::kernels;
use crate::math::ray::{Ray, RayStart};
use crate::shape::ShapeHit;
#[cfg(feature = "simd")]
use crate::superquadric::Convex;
use crate::superquadric::Superquadric;

/// The reason why columns do not make a batch.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum BatchError {
    /// A column has another length than the column of origins.
    #[error("expected {expected} entries in the column {column}, found {found}")]
    Length {
        /// The name of the column.
        column: &'static str,
        /// The number of rays: the length of the column of origins.
        expected: usize,
        /// The length of this column.
        found: usize,
    },
}

/// The rays of a batch query, borrowed as columns: row i of each column belongs to ray i.
///
/// | column | type | meaning |
/// |---|---|---|
/// | `origins` | `[f64; 3]` | where the ray starts |
/// | `directions` | `[f64; 3]` | where it goes, of any length but zero |
/// | `t_min`, optional | `f64` | the smallest t that counts, default: 0 |
/// | `t_max`, optional | `f64` | hits count below this t, default: infinity |
///
/// All t count in lengths of the ray's direction. Only the lengths of the columns are checked: a
/// ray that is not finite, or whose direction is zero, hits nothing. A numpy array of shape (n, 3)
/// and type float64 has the layout of a column of `[f64; 3]`.
///
/// ```
/// use superegg_geom::{BatchError, RayBatch};
/// let origins = [[0.0, 0.0, 5.0], [3.0, 0.0, 5.0]];
/// let directions = [[0.0, 0.0, -1.0]; 2];
/// let rays = RayBatch::new(&origins, &directions)?;
/// assert_eq!(rays.len(), 2);
/// assert!(RayBatch::new(&origins, &directions[..1]).is_err());
/// # Ok::<(), BatchError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RayBatch<'a> {
    origins: &'a [[f64; 3]],
    directions: &'a [[f64; 3]],
    t_min: Option<&'a [f64]>,
    t_max: Option<&'a [f64]>,
}

impl<'a> RayBatch<'a> {
    /// The rays `origins[i] + t directions[i]`, t >= 0.
    ///
    /// # Errors
    /// [`BatchError::Length`] if the columns have different lengths.
    pub fn new(origins: &'a [[f64; 3]], directions: &'a [[f64; 3]]) -> Result<Self, BatchError> {
        check_length("directions", origins.len(), directions.len())?;
        Ok(Self { origins, directions, t_min: None, t_max: None })
    }

    /// The same rays, whose hits count only from `t_min[i]` on. Values below 0 count as 0.
    ///
    /// # Errors
    /// [`BatchError::Length`] if the column has another length than the batch.
    pub fn with_t_min(self, t_min: &'a [f64]) -> Result<Self, BatchError> {
        check_length("t_min", self.len(), t_min.len())?;
        Ok(Self { t_min: Some(t_min), ..self })
    }

    /// The same rays, whose hits count only below `t_max[i]`.
    ///
    /// # Errors
    /// [`BatchError::Length`] if the column has another length than the batch.
    pub fn with_t_max(self, t_max: &'a [f64]) -> Result<Self, BatchError> {
        check_length("t_max", self.len(), t_max.len())?;
        Ok(Self { t_max: Some(t_max), ..self })
    }

    /// The number of rays.
    pub fn len(&self) -> usize {
        self.origins.len()
    }

    /// Whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.origins.is_empty()
    }

    /// Ray `i`; `None` past the end.
    pub fn ray(&self, i: usize) -> Option<Ray> {
        let (&origin, &direction) = (self.origins.get(i)?, self.directions.get(i)?);
        Some(Ray::new(origin.into(), direction.into()))
    }

    /// The range of t in which hits of ray `i` count: from the first, below the second. `None` past
    /// the end.
    pub fn range(&self, i: usize) -> Option<(f64, f64)> {
        (i < self.len()).then(|| {
            let t_min = self.t_min.map_or(0.0, |t_min| t_min[i]);
            let t_max = self.t_max.map_or(f64::INFINITY, |t_max| t_max[i]);
            (t_min, t_max)
        })
    }

    /// The column of origins.
    pub fn origins(&self) -> &'a [[f64; 3]] {
        self.origins
    }

    /// The column of directions.
    pub fn directions(&self) -> &'a [[f64; 3]] {
        self.directions
    }

    /// The rays `range` of the batch, for a query that is split over threads. `None` if the range
    /// is not within the batch.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Option<Self> {
        let of = |column: Option<&'a [f64]>| column.map(|column| column.get(range.clone()));
        Some(Self {
            origins: self.origins.get(range.clone())?,
            directions: self.directions.get(range.clone())?,
            t_min: of(self.t_min).map_or(Some(None), |column| column.map(Some))?,
            t_max: of(self.t_max).map_or(Some(None), |column| column.map(Some))?,
        })
    }
}

fn check_length(column: &'static str, expected: usize, found: usize) -> Result<(), BatchError> {
    if expected == found { Ok(()) } else { Err(BatchError::Length { column, expected, found }) }
}

/// One row of a [`HitBatch`]: the geometry of a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct BatchHit {
    /// The ray parameter of the hit, >= 0, in lengths of the ray's direction.
    pub t: f64,
    /// The point of the hit.
    pub point: DVec3,
    /// The outward unit normal there.
    pub normal: DVec3,
    /// Longitude and latitude on the shape, in radians: see [`Superquadric::uv_at`].
    pub uv: [f64; 2],
    /// Whether the ray leaves the shape here.
    pub leaving: bool,
}

impl BatchHit {
    /// A row from its parts.
    pub fn new(t: f64, point: DVec3, normal: DVec3, uv: [f64; 2], leaving: bool) -> Self {
        Self { t, point, normal, uv, leaving }
    }
}

/// The answers of a batch query as columns: row i belongs to ray i.
///
/// | column | type | for a miss |
/// |---|---|---|
/// | [`t`](Self::t) | `f64` | infinity |
/// | [`points`](Self::points) | `[f64; 3]` | NaN |
/// | [`normals`](Self::normals) | `[f64; 3]` | NaN |
/// | [`uv`](Self::uv) | `[f64; 2]` | NaN |
/// | [`leaving`](Self::leaving) | `bool` | false |
///
/// A query empties the batch before it fills it, so that no row of an earlier query stays. The
/// memory is kept. A batch that no query has filled is empty, and [`HitBatch::hit`] of any row is
/// `None`.
///
/// ```
/// use superegg_geom::{HitBatch, RayBatch, Superquadric};
/// let (origins, directions) = ([[0.0, 0.0, 5.0], [3.0, 0.0, 5.0]], [[0.0, 0.0, -1.0]; 2]);
/// let mut hits = HitBatch::new();
/// Superquadric::unit_sphere().intersect_batch(&RayBatch::new(&origins, &directions)?, &mut hits);
/// assert_eq!(hits.t(), [4.0, f64::INFINITY]);
/// assert_eq!(hits.hit(0).map(|hit| hit.point.z), Some(1.0));
/// assert_eq!((hits.hit(1), hits.hit(99)), (None, None));
/// # Ok::<(), superegg_geom::BatchError>(())
/// ```
///
/// Rows can only be written by whoever holds the batch mutably, and only as a whole, so the columns
/// always have the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitBatch {
    t: Vec<f64>,
    points: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    uv: Vec<[f64; 2]>,
    leaving: Vec<bool>,
}

impl HitBatch {
    /// A batch without rows.
    pub fn new() -> Self {
        Self::default()
    }

    /// The number of rows: of the rays of the query that filled it.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// A batch without rows, with room for `count`.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            t: Vec::with_capacity(count),
            points: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            uv: Vec::with_capacity(count),
            leaving: Vec::with_capacity(count),
        }
    }

    /// Removes all rows, and makes `count` misses of them.
    pub fn reset(&mut self, count: usize) {
        self.clear();
        self.t.resize(count, f64::INFINITY);
        self.points.resize(count, [f64::NAN; 3]);
        self.normals.resize(count, [f64::NAN; 3]);
        self.uv.resize(count, [f64::NAN; 2]);
        self.leaving.resize(count, false);
    }

    /// Removes all rows, and keeps the memory.
    pub fn clear(&mut self) {
        self.t.clear();
        self.points.clear();
        self.normals.clear();
        self.uv.clear();
        self.leaving.clear();
    }

    /// Appends a row: a hit, or a miss.
    pub fn push(&mut self, hit: Option<BatchHit>) {
        let row = self.len();
        self.t.push(f64::INFINITY);
        self.points.push([f64::NAN; 3]);
        self.normals.push([f64::NAN; 3]);
        self.uv.push([f64::NAN; 2]);
        self.leaving.push(false);
        if let Some(hit) = hit {
            self.write(row, hit);
        }
    }

    /// Makes row `i` a hit, and returns whether there is such a row.
    pub fn set(&mut self, i: usize, hit: BatchHit) -> bool {
        let is_row = i < self.len();
        if is_row {
            self.write(i, hit);
        }
        is_row
    }

    fn write(&mut self, i: usize, hit: BatchHit) {
        self.t[i] = hit.t;
        self.points[i] = hit.point.to_array();
        self.normals[i] = hit.normal.to_array();
        self.uv[i] = hit.uv;
        self.leaving[i] = hit.leaving;
    }

    /// Appends the rows of another batch, for a query that was split over threads.
    pub fn append(&mut self, other: &Self) {
        self.t.extend_from_slice(&other.t);
        self.points.extend_from_slice(&other.points);
        self.normals.extend_from_slice(&other.normals);
        self.uv.extend_from_slice(&other.uv);
        self.leaving.extend_from_slice(&other.leaving);
    }

    /// The hit of ray `i`; `None` for a miss and past the end.
    pub fn hit(&self, i: usize) -> Option<BatchHit> {
        let t = *self.t.get(i)?;
        (t < f64::INFINITY).then(|| BatchHit {
            t,
            point: self.points[i].into(),
            normal: self.normals[i].into(),
            uv: self.uv[i],
            leaving: self.leaving[i],
        })
    }

    /// The hits in the order of their rays, `None` for a miss.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Option<BatchHit>> + '_ {
        (0..self.len()).map(|i| self.hit(i))
    }

    /// The ray parameters of the hits, infinity for a miss.
    pub fn t(&self) -> &[f64] {
        &self.t
    }

    /// The points of the hits, NaN for a miss.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// The outward unit normals, NaN for a miss.
    pub fn normals(&self) -> &[[f64; 3]] {
        &self.normals
    }

    /// Longitudes and latitudes on the shape, in radians, NaN for a miss.
    pub fn uv(&self) -> &[[f64; 2]] {
        &self.uv
    }

    /// Whether the rays leave the shape at their hits, false for a miss.
    pub fn leaving(&self) -> &[bool] {
        &self.leaving
    }

    /// The columns, without a copy.
    pub fn into_columns(self) -> HitColumns {
        let Self { t, points, normals, uv, leaving } = self;
        HitColumns { t, points, normals, uv, leaving }
    }
}

/// The columns of a [`HitBatch`].
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct HitColumns {
    /// See [`HitBatch::t`].
    pub t: Vec<f64>,
    /// See [`HitBatch::points`].
    pub points: Vec<[f64; 3]>,
    /// See [`HitBatch::normals`].
    pub normals: Vec<[f64; 3]>,
    /// See [`HitBatch::uv`].
    pub uv: Vec<[f64; 2]>,
    /// See [`HitBatch::leaving`].
    pub leaving: Vec<bool>,
}

impl Superquadric {
    /// The first crossing in its range of t of each ray with this shape:
    /// [`Superquadric::intersect`] for many rays, with normals and (u, v). The rows of `hits` are
    /// replaced by those of `rays`.
    ///
    /// Any number of rays and every shape are allowed. With the feature `simd` rays against a convex
    /// shape go through the stream kernels and are refined in f64: t agrees with
    /// [`Superquadric::intersect`] to 1e-12 (1 + t), and only the rounding of f64 decides between hit
    /// and miss. Every other shape goes through that method. The same batch gives the same rows.
    ///
    /// ```
    /// use superegg_geom::{Exponents, HitBatch, RayBatch, Superquadric};
    /// let star = Superquadric::unit(Exponents::new(3.0, 3.0)?);
    /// let (origins, directions) = ([[0.0, 0.0, 4.0]], [[0.0, 0.0, -2.0]]);
    /// let mut hits = HitBatch::new();
    /// star.intersect_batch(&RayBatch::new(&origins, &directions)?, &mut hits);
    /// assert_eq!(hits.t(), [1.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect_batch(&self, rays: &RayBatch<'_>, hits: &mut HitBatch) {
        hits.reset(rays.len());
        #[cfg(feature = "simd")]
        if let Some(convex) = self.as_convex() {
            return intersect_convex(&convex, rays, hits);
        }
        for i in 0..rays.len() {
            if let (Some(ray), Some((t_min, t_max))) = (rays.ray(i), rays.range(i))
                && let Some(hit) = self.first_in_range(&ray, t_min, t_max)
            {
                hits.write(i, self.batch_hit(&hit));
            }
        }
    }

    /// The first crossing with `t_min <= t < t_max`.
    fn first_in_range(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<ShapeHit> {
        let hit = self.intersect(ray, RayStart::Free)?;
        if hit.t >= t_min {
            return (hit.t < t_max).then_some(hit);
        }
        // The range begins beyond the first crossing: the search begins where the range does.
        let later = Ray::new(ray.point_at(t_min), ray.direction);
        let hit = self.intersect(&later, RayStart::Free)?;
        let t = t_min + hit.t;
        (t < t_max).then_some(ShapeHit { t, ..hit })
    }

    /// The row of a crossing.
    fn batch_hit(&self, hit: &ShapeHit) -> BatchHit {
        let (u, v) = self.uv_at(hit.point);
        BatchHit::new(hit.t, hit.point, self.normal(hit.point), [u, v], hit.leaving)
    }
}

/// Rays that go through the kernels together, so that their columns stay in the cache.
#[cfg(feature = "simd")]
const CHUNK: usize = 1024;

/// [`Superquadric::intersect_batch`] by kernels. `hits` has a row of no hit for each ray.
#[cfg(feature = "simd")]
fn intersect_convex(shape: &Convex, rays: &RayBatch<'_>, hits: &mut HitBatch) {
    let (mut chunk, mut rows, mut found) = (Vec::new(), Vec::new(), Vec::new());
    for first in (0..rays.len()).step_by(CHUNK) {
        chunk.clear();
        rows.clear();
        for i in first..rays.len().min(first + CHUNK) {
            if let Some(ray) = rays.ray(i) {
                chunk.push(ray);
                rows.push(i);
            }
        }
        kernels::batch::intersect(shape, &chunk, &mut found);
        for ((&i, ray), hit) in rows.iter().zip(&chunk).zip(&found) {
            let (Some(hit), Some((t_min, t_max))) = (hit, rays.range(i)) else { continue };
            // A crossing before the range is followed by one that the scalar path finds.
            let hit = if hit.t < t_min { shape.first_in_range(ray, t_min, t_max) } else { Some(*hit) };
            if let Some(hit) = hit.filter(|hit| hit.t < t_max) {
                hits.write(i, shape.batch_hit(&hit));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Exponents;

    fn hits_of(shape: &Superquadric, rays: &RayBatch<'_>) -> HitBatch {
        let mut hits = HitBatch::new();
        shape.intersect_batch(rays, &mut hits);
        hits
    }

    #[test]
    fn columns_of_different_lengths_are_refused() {
        let (two, one) = ([[0.0; 3]; 2], [[1.0; 3]; 1]);
        let error = BatchError::Length { column: "directions", expected: 2, found: 1 };
        assert_eq!(RayBatch::new(&two, &one).err(), Some(error));
        let rays = RayBatch::new(&two, &two).unwrap();
        for found in [0, 1, 3] {
            let column = vec![1.0; found];
            let error = |column| Some(BatchError::Length { column, expected: 2, found });
            assert_eq!(rays.with_t_max(&column).err(), error("t_max"));
            assert_eq!(rays.with_t_min(&column).err(), error("t_min"));
        }
        assert!(rays.with_t_max(&[1.0, 2.0]).and_then(|rays| rays.with_t_min(&[0.0, 0.0])).is_ok());
    }

    #[test]
    fn a_batch_that_no_query_has_filled_has_no_hits() {
        let hits = HitBatch::new();
        assert_eq!((hits.len(), hits.hit(0), hits.hit(usize::MAX)), (0, None, None));
    }

    #[test]
    fn no_row_of_an_earlier_query_stays() {
        let sphere = Superquadric::unit_sphere();
        let (origins, directions) = ([[0.0, 0.0, 5.0]; 3], [[0.0, 0.0, -1.0]; 3]);
        let mut hits = hits_of(&sphere, &RayBatch::new(&origins, &directions).unwrap());
        assert_eq!(hits.t(), [4.0; 3]);
        let away = [[0.0, 0.0, 1.0]];
        sphere.intersect_batch(&RayBatch::new(&origins[..1], &away).unwrap(), &mut hits);
        assert_eq!((hits.len(), hits.hit(0), hits.hit(1), hits.hit(2)), (1, None, None, None));
        assert_eq!((hits.t()[0], hits.leaving()[0]), (f64::INFINITY, false));
        assert!(hits.points()[0][0].is_nan() && hits.normals()[0][0].is_nan() && hits.uv()[0][0].is_nan());
        sphere.intersect_batch(&RayBatch::new(&[], &[]).unwrap(), &mut hits);
        assert!(hits.is_empty() && hits.hit(0).is_none());
        assert!(!hits.set(0, BatchHit::new(1.0, DVec3::X, DVec3::X, [0.0; 2], false)));
    }

    #[test]
    fn every_row_is_the_answer_of_the_query_for_one_ray() {
        for (e, n) in [(1.0, 1.0), (0.1, 0.2), (3.0, 3.0), (2.5, 0.4)] {
            let shape = Superquadric::new(DVec3::new(1.0, 2.0, 0.5), Exponents::new(e, n).unwrap()).unwrap();
            let origins: Vec<[f64; 3]> = (0..200)
                .map(|i| f64::from(i) * 0.37)
                .map(|x| [3.0 * x.sin(), 2.0 * (2.1 * x).cos(), 1.4 * (0.7 * x).sin()])
                .collect();
            let directions: Vec<[f64; 3]> = origins
                .iter()
                .enumerate()
                .map(|(i, o)| [0.02 - o[0], (i % 7) as f64 * 0.1 - o[1], -o[2]])
                .collect();
            let rays = RayBatch::new(&origins, &directions).unwrap();
            let hits = hits_of(&shape, &rays);
            assert_eq!(hits.len(), 200);
            for (i, hit) in hits.iter().enumerate() {
                let expected = shape.intersect(&rays.ray(i).unwrap(), RayStart::Free);
                assert_eq!(hit.map(|h| h.leaving), expected.map(|h| h.leaving), "{e} {n} {i}");
                if let (Some(hit), Some(expected)) = (hit, expected) {
                    let (t, point) = ((hit.t - expected.t).abs(), (hit.point - expected.point).length());
                    assert!(t <= 1e-12 * (1.0 + expected.t), "{e} {n} {hit:?} {expected:?}");
                    assert!(point <= 1e-11, "{e} {n} {hit:?} {expected:?}");
                }
                if let Some(hit) = hit {
                    assert_eq!(hit.normal, shape.normal(hit.point));
                    let back = shape.point_at(hit.uv[0], hit.uv[1]);
                    assert!(e.min(n) < 0.4 || (back - hit.point).length() < 1e-9, "{e} {n} {hit:?} {back}");
                }
            }
        }
    }

    /// The kernels of the convex solver never see a star: its crossing is that of the reference.
    #[test]
    fn a_shape_that_is_not_convex_gets_its_true_crossing() {
        let star = Superquadric::unit(Exponents::new(3.0, 3.0).unwrap());
        let (origins, directions) = ([[0.3, 0.2, 5.0]], [[-0.03, -0.02, -1.0]]);
        let rays = RayBatch::new(&origins, &directions).unwrap();
        let expected = star.intersect_certified(&rays.ray(0).unwrap(), RayStart::Free).unwrap();
        assert_eq!(hits_of(&star, &rays).t(), [expected.t]);
    }

    #[test]
    fn rays_that_are_not_finite_hit_nothing() {
        let origins = [[f64::NAN, 0.0, 0.0], [0.0, 0.0, 5.0], [f64::INFINITY, 0.0, 0.0]];
        let directions = [[0.0, 0.0, -1.0], [0.0; 3], [-1.0, 0.0, 0.0]];
        let hits = hits_of(&Superquadric::unit_sphere(), &RayBatch::new(&origins, &directions).unwrap());
        assert!(hits.iter().all(|hit| hit.is_none()));
    }

    #[test]
    fn the_range_of_t_chooses_the_crossing() {
        let (origins, directions) = ([[0.0, 0.0, 3.0]; 5], [[0.0, 0.0, -1.0]; 5]);
        let (t_min, t_max) = ([0.0, 2.5, 2.5, 4.5, 0.0], [2.0, 9.0, 3.5, 9.0, 2.5]);
        let rays = RayBatch::new(&origins, &directions).unwrap();
        let rays = rays.with_t_min(&t_min).unwrap().with_t_max(&t_max).unwrap();
        let hits = hits_of(&Superquadric::unit_sphere(), &rays);
        let infinity = f64::INFINITY;
        assert_eq!(hits.t(), [infinity, 4.0, infinity, infinity, 2.0]);
        assert_eq!(hits.leaving(), [false, true, false, false, false]);
        let part = rays.slice(1..3).unwrap();
        let mut joined = hits_of(&Superquadric::unit_sphere(), &rays.slice(0..1).unwrap());
        joined.append(&hits_of(&Superquadric::unit_sphere(), &part));
        assert_eq!(joined.t(), &hits.t()[..3]);
        assert!(rays.slice(3..6).is_none());
    }
}
