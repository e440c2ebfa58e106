//! Area and even samples of the surface's image under a linear map.

use glam::{DAffine3, DMat3, DVec3};

use super::area::{AreaElement, SurfaceArea, refine};
use super::closest::rotation_and_lengths;
use super::sample::{SurfacePoint, SurfaceSampler};
use crate::math::numeric::unit_vector;
use crate::math::random::SplitMix;
use crate::math::transform::inverse_of;
use crate::superquadric::Superquadric;

/// The shape that a map makes of this one, up to a rotation: with the lengths of the map's columns
/// as factors of the semi-axes. Its image is the rest of the map.
fn stretched(shape: &Superquadric, lengths: DVec3) -> Option<Superquadric> {
    Superquadric::new(shape.radii() * lengths, shape.exponents()).ok()
}

fn column_lengths(linear: &DMat3) -> DVec3 {
    DVec3::new(linear.x_axis.length(), linear.y_axis.length(), linear.z_axis.length())
}

impl Superquadric {
    /// The surface area of the shape's image under a linear map, with an estimate of its relative
    /// error. `None` for a map that is singular or leaves the range of f64.
    ///
    /// Rotations, mirrors and scales along the shape's axes leave a superquadric, whose area is
    /// [`Superquadric::surface_area_with_error`]. Under any other map M (a shear) the area element is
    /// `|cof(M) (P_t x P_tau)|`, and the same quadrature runs over four octants; the other four are
    /// their mirror images through the centre.
    ///
    /// ```
    /// use superegg_geom::Superquadric;
    /// use superegg_geom::glam::{DMat3, DVec3};
    /// let map = DMat3::from_diagonal(DVec3::splat(3.0));
    /// let area = Superquadric::unit_sphere().surface_area_under(&map).unwrap();
    /// assert!((area.value / (36.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
    /// ```
    pub fn surface_area_under(&self, linear: &DMat3) -> Option<SurfaceArea> {
        if let Some((_, lengths)) = rotation_and_lengths(linear) {
            return Some(stretched(self, lengths)?.surface_area_with_error());
        }
        let frame = *linear * DMat3::from_diagonal(self.radii());
        let largest =
            [frame.x_axis, frame.y_axis, frame.z_axis].map(DVec3::length).into_iter().fold(0.0, f64::max);
        let scaled = frame * (1.0 / largest);
        let cofactors = DMat3::from_cols(
            scaled.y_axis.cross(scaled.z_axis),
            scaled.z_axis.cross(scaled.x_axis),
            scaled.x_axis.cross(scaled.y_axis),
        );
        if !(largest > 0.0 && largest.is_finite()) || scaled.determinant() == 0.0 {
            return None;
        }
        let element = AreaElement::of(self);
        let sum = |nodes: usize| image_sum(&element, &cofactors, nodes);
        let SurfaceArea { value, relative_error } = refine(&element, sum);
        Some(SurfaceArea { value: 2.0 * value * largest * largest, relative_error })
    }
}

/// The trapezoidal sum of the area elements of four octants.
fn image_sum(element: &AreaElement, cofactors: &DMat3, nodes: usize) -> f64 {
    let half = nodes / 2;
    let [around_step, profile_step] = element.ends().map(|end| end / half as f64);
    let parameters = |step: f64| (0..=2 * half).map(move |i| (i as f64 - half as f64) * step);
    let around: Vec<_> = parameters(around_step).map(|s| (element.around.at(s.sinh()), s.cosh())).collect();
    let octants = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let rows = parameters(profile_step).map(|s| {
        let profile = element.profile.at(s.sinh());
        let row: f64 = around
            .iter()
            .map(|(point, weight)| {
                let x = cofactors.x_axis * (point.y_rise * profile.y_rise);
                let y = cofactors.y_axis * (point.x_fall * profile.y_rise);
                let cap = profile.x_fall * (point.x * point.y_rise + point.y * point.x_fall);
                let z = cofactors.z_axis * cap;
                let of_octant = |(i, j): (f64, f64)| (i * x + j * y + z).length();
                weight * octants.into_iter().map(of_octant).sum::<f64>()
            })
            .sum();
        row * profile.x * s.cosh()
    });
    rows.sum::<f64>() * around_step * profile_step
}

/// An endless sequence of independent points of the image of a surface under an affine map, spread
/// evenly by the area of the image. The same shape, map and seed give the same points.
///
/// A map is a linear map of unit columns after scales along the shape's axes. The scales leave a
/// superquadric, whose points [`SurfaceSampler`] draws. Where the columns are not perpendicular a point
/// with normal n is accepted in proportion to the growth of area there, `|det L| |L^-T n|`.
#[derive(Clone, Debug)]
pub struct ImageSampler {
    sampler: SurfaceSampler,
    /// From the stretched shape to the image.
    map: DAffine3,
    /// The inverse transpose of the linear part.
    normal_map: DMat3,
    /// The most that `normal_map` stretches a unit vector by, where it is not a rotation.
    most_growth: Option<f64>,
    random: SplitMix,
}

impl ImageSampler {
    /// The sequence of a shape, a map and a seed. `None` for a map that is singular or leaves the
    /// range of f64. Making it takes about a millisecond.
    pub fn new(shape: &Superquadric, map: &DAffine3, seed: u64) -> Option<Self> {
        Self::of_class(&Self::class(shape, &map.matrix3)?, map, seed)
    }

    /// The sampler that all images of a shape share whose maps differ by no more than a rotation, a
    /// uniform scale and a translation; it is what takes time to make.
    pub fn class(shape: &Superquadric, linear: &DMat3) -> Option<SurfaceSampler> {
        let lengths = column_lengths(linear);
        Some(SurfaceSampler::new(&stretched(shape, lengths / lengths.max_element())?, 0))
    }

    /// The sequence of a map and a seed, with the sampler of the map's class.
    pub fn of_class(class: &SurfaceSampler, map: &DAffine3, seed: u64) -> Option<Self> {
        let linear = map.matrix3;
        let lengths = column_lengths(&linear);
        let scale = lengths.max_element();
        let rotation = rotation_and_lengths(&linear).map(|(rotation, _)| rotation);
        let unit_columns = rotation.unwrap_or(linear * DMat3::from_diagonal(lengths.recip()));
        let normal_map = match rotation {
            Some(rotation) => rotation,
            None => inverse_of(&DAffine3::from_mat3(unit_columns)).matrix3.transpose(),
        };
        if !normal_map.is_finite() || !map.translation.is_finite() || !scale.is_finite() {
            return None;
        }
        let columns = [normal_map.x_axis, normal_map.y_axis, normal_map.z_axis];
        let frobenius = columns.iter().map(|column| column.length_squared()).sum::<f64>().sqrt();
        let mut random = SplitMix::new(seed);
        Some(Self {
            sampler: class.with_seed(random.bits()),
            map: DAffine3::from_mat3_translation(unit_columns * scale, map.translation),
            normal_map,
            most_growth: rotation.is_none().then_some(frobenius),
            random,
        })
    }

    /// The sequence of the same image and another seed. It shares the tables of this one.
    #[must_use]
    pub fn with_seed(&self, seed: u64) -> Self {
        let mut random = SplitMix::new(seed);
        Self { sampler: self.sampler.with_seed(random.bits()), random, ..self.clone() }
    }

    /// The next point.
    pub fn sample(&mut self) -> SurfacePoint {
        loop {
            let SurfacePoint { point, normal } = self.sampler.sample();
            let image = self.normal_map * normal;
            if self.most_growth.is_none_or(|most| self.random.unit() * most < image.length()) {
                let normal = unit_vector(image).unwrap_or(DVec3::Z);
                return SurfacePoint { point: self.map.transform_point3(point), normal };
            }
        }
    }
}

impl Iterator for ImageSampler {
    type Item = SurfacePoint;

    fn next(&mut self) -> Option<SurfacePoint> {
        Some(self.sample())
    }
}
