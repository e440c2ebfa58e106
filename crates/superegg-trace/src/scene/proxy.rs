//! The level-of-detail proxy of a group.

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Exponents, Superquadric};
use superegg_scene::Material;

use super::primitive::CompiledPrimitive;

/// The average of a group: an ellipsoid with the group's mean material and mean opacity.
#[derive(Clone, Debug)]
pub(crate) struct Proxy {
    /// From the group's space to that in which the ellipsoid is the unit sphere.
    pub(crate) unit_from_group: DAffine3,
    /// The part of the light through the ellipsoid that the group stops, 0 to 1.
    pub(crate) opacity: f64,
    /// The primitives that are seen most, with weights of sum 1, the largest first.
    pub(crate) weights: Vec<(u32, f64)>,
}

impl Proxy {
    /// The unit sphere, whose image is the ellipsoid.
    pub(crate) fn unit_shape() -> Superquadric {
        Superquadric::unit(Exponents::ROUND)
    }

    /// The primitive that is seen most.
    pub(crate) fn main_primitive(&self) -> u32 {
        self.weights.first().map_or(0, |(primitive, _)| *primitive)
    }

    /// The mean material of what is seen. It neither reflects nor refracts.
    pub(crate) fn material(&self, primitives: &[CompiledPrimitive], materials: &[Material]) -> Material {
        let nothing = Material {
            color: DVec3::ZERO,
            ambient: 0.0,
            gloss: 0.0,
            diffuse: 0.0,
            specular: 0.0,
            ..Material::default()
        };
        self.weights.iter().fold(nothing, |mut mean, &(primitive, weight)| {
            let seen = &materials[primitives[primitive as usize].material as usize];
            mean.color += weight * seen.color;
            mean.ambient += weight * seen.ambient;
            mean.gloss += weight * seen.gloss;
            mean.diffuse += weight * seen.diffuse;
            mean.specular += weight * seen.specular;
            mean
        })
    }
}
