//! Volume, centre, inertia and area: of each instance, of all together, and of their union.

use rayon::prelude::*;
use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::{Aabb, InteriorSampler, SplitMix, SurfaceArea, symmetric_eigen};

use crate::instances::PlacedPrimitive;
use crate::point::PointLimits;
use crate::sample::{ScenePoint, SceneSurfaces, systematic_shares};
use crate::scene::compiled::CompiledScene;

/// The mass properties of a solid of density 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MassProperties {
    /// The volume.
    pub volume: f64,
    /// The centre of mass.
    pub center: DVec3,
    /// The inertia tensor about the centre of mass, along the world's axes: the integral of `|r|^2 1 - r r^T`.
    pub inertia: DMat3,
}

impl MassProperties {
    /// From the volume, the integral of r, and the integral of `r r^T`, all about the origin.
    fn of_moments(volume: f64, first: DVec3, second: &DMat3) -> Self {
        if volume <= 0.0 {
            return Self { volume, center: DVec3::ZERO, inertia: DMat3::ZERO };
        }
        let center = first / volume;
        let about_center = *second - outer(center, center) * volume;
        Self { volume, center, inertia: inertia_of(&about_center) }
    }

    /// The principal moments of inertia, in ascending order.
    ///
    /// The eigenvalues of the tensor, by Jacobi's rotations.
    pub fn principal_moments(&self) -> [f64; 3] {
        let (mut moments, _) = symmetric_eigen(self.inertia.to_cols_array_2d());
        moments.sort_by(f64::total_cmp);
        moments
    }
}

/// The inertia tensor from the integral of `r r^T`. The diagonal is summed, not the trace without an entry, so that a
/// long row of instances loses no digits.
fn inertia_of(second: &DMat3) -> DMat3 {
    let diagonal = DVec3::new(second.x_axis.x, second.y_axis.y, second.z_axis.z);
    let DVec3 { x, y, z } = diagonal;
    DMat3::from_diagonal(DVec3::new(y + z, x + z, x + y)) - (*second - DMat3::from_diagonal(diagonal))
}

/// a b^T.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// An estimate with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate<T> {
    /// The value.
    pub value: T,
    /// The standard error of the value.
    pub error: T,
}

/// The union of all instances, estimated from samples.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnionProperties {
    /// Volume, centre and inertia.
    pub mass: MassProperties,
    /// The standard error of the volume.
    pub volume_error: f64,
    /// The standard error of the centre, along each axis.
    pub center_error: DVec3,
    /// The area of the surface: that of all primitives without what is inside others.
    pub area: Estimate<f64>,
    /// The number of samples of each kind.
    pub samples: usize,
}

/// The instances of a scene with their surfaces, to be measured.
pub struct SceneMeasures<'a> {
    scene: &'a CompiledScene,
    surfaces: SceneSurfaces<'a>,
}

impl<'a> SceneMeasures<'a> {
    /// The measures of a scene; `None` if it has more than `most` instances.
    pub fn of(scene: &'a CompiledScene, most: usize) -> Option<Self> {
        Some(Self { scene, surfaces: SceneSurfaces::of(scene, most)? })
    }

    /// The instances, in the order of children.
    pub fn instances(&self) -> &[PlacedPrimitive] {
        self.surfaces.instances()
    }

    /// The area of each instance, with its error.
    pub fn areas(&self) -> &[SurfaceArea] {
        self.surfaces.areas()
    }

    /// The sum of all areas.
    pub fn total_area(&self) -> f64 {
        self.surfaces.total_area()
    }

    /// The volume, centre and inertia of an instance, exact to rounding.
    ///
    /// For the unit shape with volume V and second moments D, the image under `M p + c` has the volume `|det M| V`, the
    /// centre c, and the second moments `|det M| M D M^T` about it.
    pub fn mass_of(&self, placed: &PlacedPrimitive) -> MassProperties {
        let (volume, about_center) = self.moments(placed);
        let center = placed.world_from_unit.translation;
        MassProperties { volume, center, inertia: inertia_of(&about_center) }
    }

    /// The volume and the second moments about the centre.
    fn moments(&self, placed: &PlacedPrimitive) -> (f64, DMat3) {
        let shape = self.scene.primitive(placed.primitive).unit_shape();
        let matrix = placed.world_from_unit.matrix3;
        let growth = matrix.determinant().abs();
        let second = matrix * DMat3::from_diagonal(shape.second_moments()) * matrix.transpose();
        (growth * shape.volume(), second * growth)
    }

    /// The smallest axis-aligned world box of an instance.
    pub fn bounds_of(&self, placed: &PlacedPrimitive) -> Aabb {
        let shape = self.scene.primitive(placed.primitive).unit_shape();
        let map = placed.world_from_unit;
        Aabb::around(map.translation, shape.half_extent_under(&map.matrix3))
    }

    /// The smallest axis-aligned world box of all instances; empty for none.
    pub fn bounds(&self) -> Aabb {
        self.instances().iter().fold(Aabb::EMPTY, |whole, placed| whole.union(&self.bounds_of(placed)))
    }

    /// The sum over all instances: where they overlap, space counts as often as it is covered.
    pub fn total_mass(&self) -> MassProperties {
        // About the centre of the box, so that scenes far from the origin lose no digits.
        let middle = self.bounds().center();
        let middle = if middle.is_finite() { middle } else { DVec3::ZERO };
        let mut sum = Moments::NONE;
        for placed in self.instances() {
            let (volume, second) = self.moments(placed);
            let offset = placed.world_from_unit.translation - middle;
            sum.add(&Moments {
                weight: volume,
                first: offset * volume,
                second: second + outer(offset, offset) * volume,
                ..Moments::NONE
            });
        }
        let mass = MassProperties::of_moments(sum.weight, sum.first, &sum.second);
        MassProperties { center: mass.center + middle, ..mass }
    }

    /// The union of all instances, from `samples` points inside and as many on the surfaces. The same scene, number and
    /// seed give the same estimate.
    ///
    /// Points are drawn evenly inside each instance, in proportion to the volumes. A point that k instances hold counts
    /// 1/k, so the mean is the volume of the union as a part of the sum of volumes (R. Karp, M. Luby, N. Madras,
    /// Monte-Carlo approximation algorithms for enumeration problems, 1989). Without overlaps the volume is exact. The
    /// area counts the points of surfaces that are inside no other instance.
    pub fn union(&self, samples: usize, seed: u64) -> UnionProperties {
        let middle = self.bounds().center();
        let middle = if middle.is_finite() { middle } else { DVec3::ZERO };
        let volumes: Vec<f64> = self.instances().iter().map(|placed| self.moments(placed).0).collect();
        let total: f64 = volumes.iter().sum();
        let mut random = SplitMix::new(seed);
        let shares = systematic_shares(&volumes, samples, &mut random);
        let seeds: Vec<u64> = shares.iter().map(|_| random.bits()).collect();
        // Summed in the order of instances, whatever the threads.
        let parts: Vec<Moments> = shares
            .par_iter()
            .zip(&seeds)
            .map(|(&(instance, count), &seed)| self.sampled_moments(instance, count, seed, middle))
            .collect();
        let mut sum = Moments::NONE;
        parts.iter().for_each(|part| sum.add(part));
        let count = sum.count.max(1.0);
        let scale = total / count;
        let mass = MassProperties::of_moments(sum.weight * scale, sum.first * scale, &(sum.second * scale));
        UnionProperties {
            mass: MassProperties { center: mass.center + middle, ..mass },
            volume_error: total * sum.error_of_mean(),
            center_error: sum.error_of_center(),
            area: self.union_area(samples, random.bits()),
            samples,
        }
    }

    /// The sums over `count` points inside an instance, about `middle`.
    fn sampled_moments(&self, instance: usize, count: usize, seed: u64, middle: DVec3) -> Moments {
        let placed = &self.instances()[instance];
        let shape = self.scene.primitive(placed.primitive).unit_shape();
        let mut sum = Moments::NONE;
        for point in InteriorSampler::new(&shape, seed).take(count) {
            let point = placed.world_from_unit.transform_point3(point);
            let (holders, _) = self.scene.primitives_holding(point, MOST_HOLDERS, &PointLimits::default());
            let weight = 1.0 / holders.len().max(1) as f64;
            sum.add(&Moments::of_sample(point - middle, weight));
        }
        sum
    }

    fn union_area(&self, samples: usize, seed: u64) -> Estimate<f64> {
        let points = self.surfaces.sample(samples, seed);
        let limits = PointLimits::default();
        let is_free = |point: &&ScenePoint| !self.surfaces.is_covered(point, &limits);
        let free = points.par_iter().filter(is_free).count() as f64;
        let count = points.len().max(1) as f64;
        let (total, part) = (self.total_area(), free / count);
        let error = total * (part * (1.0 - part) / count).sqrt();
        Estimate { value: total * part, error }
    }
}

/// The most instances around a point that are counted.
const MOST_HOLDERS: usize = 10_000;

/// Sums over samples of weight w at r.
#[derive(Clone, Debug)]
struct Moments {
    count: f64,
    weight: f64,
    first: DVec3,
    second: DMat3,
    /// The sum of w^2.
    weight_squared: f64,
    /// The sum of w^2 r.
    weighted_first: DVec3,
    /// The sum of w^2 r^2, along each axis.
    weighted_second: DVec3,
}

impl Moments {
    /// No samples.
    const NONE: Self = Self {
        count: 0.0,
        weight: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
        weight_squared: 0.0,
        weighted_first: DVec3::ZERO,
        weighted_second: DVec3::ZERO,
    };

    fn of_sample(offset: DVec3, weight: f64) -> Self {
        let square = weight * weight;
        Self {
            count: 1.0,
            weight,
            first: offset * weight,
            second: outer(offset, offset) * weight,
            weight_squared: square,
            weighted_first: offset * square,
            weighted_second: offset * offset * square,
        }
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.weight += other.weight;
        self.first += other.first;
        self.second += other.second;
        self.weight_squared += other.weight_squared;
        self.weighted_first += other.weighted_first;
        self.weighted_second += other.weighted_second;
    }

    /// The standard error of the mean weight.
    fn error_of_mean(&self) -> f64 {
        let count = self.count.max(1.0);
        let mean = self.weight / count;
        ((self.weight_squared / count - mean * mean).max(0.0) / count).sqrt()
    }

    /// The standard error of the weighted mean of r: that of a ratio, `sqrt(sum w^2 (r - c)^2) / sum w`.
    fn error_of_center(&self) -> DVec3 {
        if self.weight <= 0.0 {
            return DVec3::ZERO;
        }
        let center = self.first / self.weight;
        let squares =
            self.weighted_second - 2.0 * center * self.weighted_first + center * center * self.weight_squared;
        squares.max(DVec3::ZERO).map(f64::sqrt) / self.weight
    }
}
