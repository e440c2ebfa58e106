//! The level-of-detail proxy of a group.

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Exponents, Ray, Superquadric};
use superegg_scene::Material;

use super::primitive::Primitives;

/// The opacity of fog for a proxy that stops all light.
const MOST_OPAQUE: f64 = 0.98;

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
    pub(crate) fn material(&self, primitives: &Primitives, materials: &[Material]) -> Material {
        let seen = |primitive: u32| &materials[primitives.get(primitive).material as usize];
        let has_facets =
            self.weights.iter().any(|&(primitive, _)| seen(primitive).facet_roughness().is_some());
        let nothing = Material {
            color: DVec3::ZERO,
            ambient: 0.0,
            gloss: 0.0,
            diffuse: 0.0,
            specular: 0.0,
            // Surfaces without facets count as rough if others have some.
            roughness: has_facets.then_some(0.0),
            ..Material::default()
        };
        self.weights.iter().fold(nothing, |mut mean, &(primitive, weight)| {
            let seen = seen(primitive);
            mean.color += weight * seen.color;
            mean.ambient += weight * seen.ambient;
            mean.gloss += weight * seen.gloss;
            mean.diffuse += weight * seen.diffuse;
            mean.specular += weight * seen.specular;
            mean.emission += weight * seen.emission;
            mean.metallic += weight * seen.metallic;
            if let Some(roughness) = &mut mean.roughness {
                *roughness += weight * seen.facet_roughness().unwrap_or(1.0);
            }
            mean
        })
    }
}

/// Whether the proxy of a group with this opacity stops a ray to a light at t = `t_max`. The ray is in the space of the unit
/// sphere, and `draw` is the number that it draws.
///
/// A ray from among the parts that the proxy stands for is stopped as in fog of the same opacity: with the probability
/// 1 - (1 - opacity)^f, where f is the part of its chord that is before it.
pub(crate) fn stops_light(opacity: f64, ray: &Ray, t_max: f64, draw: f64) -> bool {
    let (a, b) = (ray.direction.length_squared(), ray.direction.dot(ray.origin));
    let c = ray.origin.length_squared() - 1.0;
    let root = (b * b - a * c).sqrt();
    let [entry, exit] = [-b - root, -b + root].map(|t| t / a);
    // The root is NaN for a ray that passes the sphere.
    if !(exit > 0.0 && entry < t_max) {
        return false;
    }
    if entry >= 0.0 {
        return draw < opacity;
    }
    let before = exit.min(t_max) / (exit - entry);
    draw < 1.0 - (1.0 - opacity.min(MOST_OPAQUE)).powf(before)
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;

    #[test]
    fn light_is_stopped_from_outside_by_opacity_and_from_within_by_what_is_before() {
        let stops = |z: f64, draw: f64| {
            stops_light(0.75, &Ray::new(DVec3::new(0.0, 0.0, z), DVec3::Z * 2.0), 1e9, draw)
        };
        assert!(stops(-3.0, 0.74) && !stops(-3.0, 0.76), "before it");
        assert!(!stops(3.0, 0.0), "behind it");
        // In the middle half of the chord is left: 1 - 0.25^0.5.
        assert!(stops(0.0, 0.49) && !stops(0.0, 0.51), "in the middle");
        assert!(stops(-0.99, 0.74) && !stops(0.99, 0.01), "at its ends");
        let short = |t_max: f64| stops_light(0.75, &Ray::new(DVec3::ZERO, DVec3::Z), t_max, 0.3);
        assert!(short(1.0) && !short(0.1), "a light within it");
        let aside = Ray::new(DVec3::X * 1.1, DVec3::Z);
        assert!(!stops_light(1.0, &aside, 1e9, 0.0));
    }
}
