//! Clouds of known shapes.
#![allow(dead_code, unreachable_pub, reason = "each test file uses some of it")]

use superegg_fit::Fit;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, SearchLimits, SplitMix, Superquadric, SurfaceSampler};

/// A shape in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub(crate) shape: Superquadric,
    pub(crate) rotation: DQuat,
    pub(crate) center: DVec3,
}

/// A number of the standard normal distribution.
pub(crate) fn gaussian(random: &mut SplitMix) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

pub(crate) fn gaussian_vector(random: &mut SplitMix) -> DVec3 {
    DVec3::new(gaussian(random), gaussian(random), gaussian(random))
}

pub(crate) fn random_rotation(random: &mut SplitMix) -> DQuat {
    let v = gaussian_vector(random);
    DQuat::from_xyzw(v.x, v.y, v.z, gaussian(random)).normalize()
}

/// The faults of a cloud.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Faults {
    /// The noise of each coordinate as a part of the size.
    pub(crate) noise: f64,
    /// The share of outliers, even in a box 1.2 times as wide as the shape's diagonal.
    pub(crate) outliers: f64,
    /// Whether only points whose normal faces the viewer are there.
    pub(crate) is_half: bool,
}

impl Placed {
    /// Exponents even from 0.1 to 2, semi-axes from 1 to 3.
    pub(crate) fn random(random: &mut SplitMix) -> Self {
        let mut exponent = || 0.1 + 1.9 * random.unit();
        let exponents = Exponents::new(exponent(), exponent()).unwrap();
        let mut radius = || 3f64.powf(random.unit());
        let radii = DVec3::new(radius(), radius(), radius());
        let shape = Superquadric::new(radii, exponents).unwrap();
        Self { shape, rotation: random_rotation(random), center: 3.0 * gaussian_vector(random) }
    }

    pub(crate) fn of(fit: &Fit) -> Self {
        Self { shape: fit.shape, rotation: fit.rotation, center: fit.center }
    }

    /// The geometric mean of the semi-axes.
    pub(crate) fn size(&self) -> f64 {
        self.shape.radii().element_product().cbrt()
    }

    pub(crate) fn cloud(&self, count: usize, faults: Faults, random: &mut SplitMix) -> Vec<DVec3> {
        let inliers = ((1.0 - faults.outliers) * count as f64).round() as usize;
        let view = gaussian_vector(random);
        let is_seen = |normal: DVec3| !faults.is_half || normal.dot(view) > 0.0;
        let sampler = SurfaceSampler::new(&self.shape, random.bits()).filter(|at| is_seen(at.normal));
        let mut points: Vec<DVec3> =
            sampler.take(inliers).map(|at| self.rotation * at.point + self.center).collect();
        for point in &mut points {
            *point += faults.noise * self.size() * gaussian_vector(random);
        }
        let reach = 1.2 * self.shape.radii().length();
        while points.len() < count {
            let even = DVec3::new(random.unit(), random.unit(), random.unit());
            points.push(self.center + reach * (2.0 * even - 1.0));
        }
        points
    }

    /// The distance of a point from the surface.
    pub(crate) fn distance_of(&self, point: DVec3) -> f64 {
        let limits = SearchLimits { relative_tolerance: 1e-4, ..SearchLimits::default() };
        let own = self.rotation.inverse() * (point - self.center);
        self.shape.closest_point_within(own, &limits).unwrap().distance.abs()
    }

    /// The mean distance from this surface to another one.
    fn distance_to(&self, other: &Self) -> f64 {
        let points = self.shape.sample_surface(200, 3);
        let distance = |point: DVec3| other.distance_of(self.rotation * point + self.center);
        points.iter().map(|at| distance(at.point)).sum::<f64>() / points.len() as f64
    }

    /// The mean distance between two surfaces, both ways, over the size.
    pub(crate) fn error_of(&self, fit: &Fit) -> f64 {
        let fit = Self::of(fit);
        0.5 * (self.distance_to(&fit) + fit.distance_to(self)) / self.size()
    }
}
