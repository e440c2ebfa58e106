//! A superquadric and its measures, on columns.

use std::collections::TryReserveError;
use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use superegg::geom::glam::DVec3;
use superegg::geom::{
    Exponents, HitBatch, HitColumns, InteriorSampler, Ray, RayStart, SearchLimits, Superquadric,
    SurfaceSampler,
};

use crate::columns::{Array, Column, Rays, array, flat, numbers, points, rows};
use crate::errors;
use crate::work::{abandonable, by_length, detached, in_parallel, in_slices, thread_count};

/// The columns of hits: t, position, normal, u and v, leaving.
type HitArrays<'py> = (Array<'py, f64>, Array<'py, f64>, Array<'py, f64>, Array<'py, f64>, Array<'py, bool>);

/// A distance takes as long as this many other answers.
const ROWS_OF_A_DISTANCE: usize = 50;
/// The number of rays between two looks at the flag that cancels.
const SLICE: usize = 1 << 15;

/// A superquadric centred at the origin.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Shape(pub(crate) Superquadric);

#[pymethods]
impl Shape {
    #[new]
    fn new(radii: [f64; 3], exponents: [f64; 2]) -> PyResult<Self> {
        let [e, n] = exponents;
        let exponents = Exponents::new(e, n).map_err(errors::value)?;
        Ok(Self(Superquadric::new(radii.into(), exponents).map_err(errors::value)?))
    }

    fn value<'py>(&self, py: Python<'py>, at: Column<'py>) -> PyResult<Array<'py, f64>> {
        let values = of_rows(py, points(&at)?, |&p| self.0.inside_outside(p.into()))?;
        Ok(array(py, values))
    }

    fn normal<'py>(&self, py: Python<'py>, at: Column<'py>) -> PyResult<Array<'py, f64>> {
        let normals = of_rows(py, points(&at)?, |&p| self.0.normal(p.into()).to_array())?;
        Ok(array(py, normals.into_flattened()))
    }

    fn uv<'py>(&self, py: Python<'py>, at: Column<'py>) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let found = of_rows(py, points(&at)?, |&p| self.0.uv_at(p.into()))?;
        let (u, v) = detached(py, || found.into_iter().unzip())?;
        Ok((array(py, u), array(py, v)))
    }

    /// Points and their normals at longitudes and latitudes, rows of two.
    fn point<'py>(&self, py: Python<'py>, uv: Column<'py>) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let uv = rows::<2>(&uv)?;
        let points = of_rows(py, uv, |&[u, v]| self.0.point_at(u, v).to_array())?;
        let normals = of_rows(py, uv, |&[u, v]| self.0.normal_at(u, v).to_array())?;
        Ok((array(py, points.into_flattened()), array(py, normals.into_flattened())))
    }

    /// The closest points, the signed distances and their proven errors.
    fn closest<'py>(
        &self,
        py: Python<'py>,
        at: Column<'py>,
        tolerance: f64,
        threads: usize,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>, Array<'py, f64>)> {
        let at = points(&at)?;
        let limits = SearchLimits { relative_tolerance: tolerance, ..SearchLimits::default() };
        let nothing = (DVec3::NAN, f64::NAN, f64::NAN);
        let of_point = |&point: &[f64; 3]| {
            let closest = self.0.closest_point_within(point.into(), &limits);
            closest.map_or(nothing, |closest| (closest.point, closest.distance, closest.error))
        };
        let found = by_length(py, at.len().saturating_mul(ROWS_OF_A_DISTANCE), |cancel| {
            in_parallel(at.len(), threads, |range| {
                let unless = |_: &&[f64; 3]| !cancel.load(Ordering::Relaxed);
                at[range].iter().take_while(unless).map(of_point).collect()
            })
        })?;
        let columns = (
            flat(found.iter().map(|found| found.0)),
            found.iter().map(|found| found.1).collect(),
            found.iter().map(|found| found.2).collect(),
        );
        Ok((array(py, columns.0), array(py, columns.1), array(py, columns.2)))
    }

    /// Points spread evenly over the surface, and their normals.
    fn sample_surface<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        seed: u64,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let (points, normals) = by_length(py, count, |cancel| {
            let (mut points, mut normals) = (room(count)?, room(count)?);
            let mut sampler = SurfaceSampler::new(&self.0, seed);
            in_slices(count, cancel, |slice| {
                for sample in sampler.by_ref().take(slice.len()) {
                    points.extend(sample.point.to_array());
                    normals.extend(sample.normal.to_array());
                }
            });
            Ok::<_, TryReserveError>((points, normals))
        })?
        .map_err(errors::memory)?;
        Ok((array(py, points), array(py, normals)))
    }

    /// Points spread evenly over the inside.
    fn sample_inside<'py>(&self, py: Python<'py>, count: usize, seed: u64) -> PyResult<Array<'py, f64>> {
        let points = by_length(py, count, |cancel| {
            let mut points = room(count)?;
            let mut sampler = InteriorSampler::new(&self.0, seed);
            in_slices(count, cancel, |slice| {
                slice.for_each(|_| points.extend(sampler.sample().to_array()));
            });
            Ok::<_, TryReserveError>(points)
        })?
        .map_err(errors::memory)?;
        Ok(array(py, points))
    }

    fn volume(&self) -> f64 {
        self.0.volume()
    }

    fn area(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        let area = detached(py, || self.0.surface_area_with_error())?;
        Ok((area.value, area.value * area.relative_error))
    }

    fn inertia(&self) -> [f64; 3] {
        self.0.inertia().to_array()
    }

    /// Vertices, normals and triangles.
    fn mesh<'py>(
        &self,
        py: Python<'py>,
        tolerance: f64,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>, Array<'py, u32>)> {
        let shape = self.0;
        let mesh = abandonable(py, move || shape.mesh(tolerance))?.map_err(errors::value)?;
        let vertices = flat(mesh.positions.into_iter());
        let normals = flat(mesh.normals.into_iter());
        Ok((array(py, vertices), array(py, normals), array(py, mesh.triangles.into_flattened())))
    }

    #[pyo3(signature = (origins, directions, t_min, t_max, threads))]
    fn intersect<'py>(
        &self,
        py: Python<'py>,
        origins: Column<'py>,
        directions: Column<'py>,
        t_min: Option<Column<'py>>,
        t_max: Option<Column<'py>>,
        threads: usize,
    ) -> PyResult<HitArrays<'py>> {
        let rays = Rays { origins, directions, t_min, t_max };
        let batch = rays.batch()?;
        let parts = by_length(py, batch.len(), |cancel| {
            let slices = batch.len().div_ceil(SLICE);
            in_parallel(slices, thread_count(threads), |range| {
                let mut parts = Vec::new();
                for slice in range.take_while(|_| !cancel.load(Ordering::Relaxed)) {
                    let first = slice * SLICE;
                    let slice = batch.slice(first..batch.len().min(first + SLICE));
                    let mut hits = HitBatch::new();
                    slice.into_iter().for_each(|rays| self.0.intersect_batch(&rays, &mut hits));
                    parts.push(hits.into_columns());
                }
                parts
            })
        })?;
        Ok(hit_arrays(py, detached(py, || joined(parts))?))
    }

    #[pyo3(signature = (origins, directions, t_min, t_max))]
    fn occluded<'py>(
        &self,
        py: Python<'py>,
        origins: Column<'py>,
        directions: Column<'py>,
        t_min: Option<Column<'py>>,
        t_max: Column<'py>,
    ) -> PyResult<Array<'py, bool>> {
        let ends = numbers(&t_max)?.to_vec();
        let rays = Rays { origins, directions, t_min, t_max: Some(t_max) };
        let batch = rays.batch()?;
        let occluded = by_length(py, batch.len(), |cancel| {
            let of_ray = |i: usize| match (batch.ray(i), batch.range(i)) {
                (Some(ray), Some((t_min, _))) if t_min > 0.0 => {
                    let later = Ray::new(ray.point_at(t_min), ray.direction);
                    self.0.occluded(&later, RayStart::Free, ends[i] - t_min)
                }
                (Some(ray), _) => self.0.occluded(&ray, RayStart::Free, ends[i]),
                (None, _) => false,
            };
            (0..batch.len()).take_while(|_| !cancel.load(Ordering::Relaxed)).map(of_ray).collect()
        })?;
        Ok(array(py, occluded))
    }
}

/// Answers for rows, in slices between which a signal is looked for.
fn of_rows<R: Sync, T: Send>(py: Python<'_>, rows: &[R], of: impl Fn(&R) -> T + Sync) -> PyResult<Vec<T>> {
    by_length(py, rows.len(), |cancel| {
        let mut answers = Vec::with_capacity(rows.len());
        in_slices(rows.len(), cancel, |slice| answers.extend(rows[slice].iter().map(&of)));
        answers
    })
}

/// Room for the coordinates of so many points, if memory has it.
fn room(points: usize) -> Result<Vec<f64>, TryReserveError> {
    let mut room = Vec::new();
    room.try_reserve_exact(points.saturating_mul(3))?;
    Ok(room)
}

/// The columns of parts, one behind the other.
fn joined(parts: Vec<HitColumns>) -> HitColumns {
    let mut all = with_room(parts.iter().map(|part| part.t.len()).sum());
    parts.into_iter().for_each(|part| append(&mut all, part));
    all
}

/// Columns with room for this many hits.
pub(crate) fn with_room(count: usize) -> HitColumns {
    let mut all = HitColumns::default();
    all.t.reserve_exact(count);
    all.points.reserve_exact(count);
    all.normals.reserve_exact(count);
    all.uv.reserve_exact(count);
    all.leaving.reserve_exact(count);
    all
}

/// Moves the rows of a part behind the others.
pub(crate) fn append(all: &mut HitColumns, part: HitColumns) {
    all.t.extend(part.t);
    all.points.extend(part.points);
    all.normals.extend(part.normals);
    all.uv.extend(part.uv);
    all.leaving.extend(part.leaving);
}

/// Columns of hits as arrays.
pub(crate) fn hit_arrays(py: Python<'_>, hits: HitColumns) -> HitArrays<'_> {
    let HitColumns { t, points, normals, uv, leaving, .. } = hits;
    (
        array(py, t),
        array(py, points.into_flattened()),
        array(py, normals.into_flattened()),
        array(py, uv.into_flattened()),
        array(py, leaving),
    )
}
