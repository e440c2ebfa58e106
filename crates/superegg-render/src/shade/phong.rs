//! The reflection model of a surface point.
//!
//! The local part is the Blinn-Phong model on linear colours:
//!
//! ```text
//! emission * color + ambient * color * A
//!   + sum over lights of C * (diffuse * color * max(0, N.L) + specular * max(0, N.H)^exponent)
//! ```
//!
//! C is the attenuated colour of the light, N the unit normal, L the unit vector to the light, H
//! the half vector between light and eye, and A the ambient light: 1, or its unoccluded part with
//! ambient occlusion. Reflection (`reflected` = kr) and transmission (`refracted` = kt) reduce the
//! ambient and diffuse part by the same amount, so that the sum does not exceed 1:
//!
//! ```text
//! (1 - kr - kt) * (ambient and diffuse) + highlight
//!   + (kr + kt F) * reflected + kt (1 - F) * tint * transmitted
//! ```
//!
//! F is the Fresnel reflectance of the interface, 1 at total internal reflection. The tint is the
//! square root of the colour, so that entering and leaving a shape together apply the colour once.
//! If kr + kt exceeds 1, both are scaled to the sum 1. The default of both is 0. With `fresnel`, kr
//! is multiplied by F for the index of the material.

use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::Material;

use crate::camera::sobol::power_cosine_direction;

/// The weights of the local, reflected and transmitted light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LobeWeights {
    /// 1 - kr - kt.
    pub(crate) local: f64,
    /// kr.
    pub(crate) mirror: f64,
    /// kt.
    pub(crate) transmitted: f64,
}

impl LobeWeights {
    /// The weights at a cosine of the angle between ray and normal.
    pub(crate) fn of(material: &Material, cos: f64) -> Self {
        let mut mirror = material.reflected.unwrap_or(0.0);
        if material.fresnel && mirror > 0.0 {
            mirror *= reflectance(cos, material.index);
        }
        let transmitted = material.refracted.unwrap_or(0.0);
        let total = (mirror + transmitted).max(1.0);
        Self {
            local: (1.0 - mirror - transmitted).max(0.0),
            mirror: mirror / total,
            transmitted: transmitted / total,
        }
    }

    /// Whether the surface neither reflects nor transmits rays.
    pub(crate) fn is_local(&self) -> bool {
        self.mirror == 0.0 && self.transmitted == 0.0
    }
}

/// The light that the surface gives off, whatever shines onto it.
pub(crate) fn emitted(material: &Material, albedo: DVec3) -> DVec3 {
    material.emission * albedo
}

/// The diffuse reflectance.
pub(crate) fn diffuse(material: &Material, weights: &LobeWeights, albedo: DVec3) -> DVec3 {
    weights.local * material.diffuse * albedo
}

/// The reflected ambient light, for white ambient light.
pub(crate) fn ambient(material: &Material, weights: &LobeWeights, albedo: DVec3) -> DVec3 {
    weights.local * material.ambient * albedo
}

/// The reflected light of one unoccluded light source. `normal`, `to_eye` and `to_light` are unit
/// vectors on the same side of the surface.
pub(crate) fn direct(
    material: &Material,
    weights: &LobeWeights,
    albedo: DVec3,
    light_color: DVec3,
    normal: DVec3,
    to_eye: DVec3,
    to_light: DVec3,
) -> DVec3 {
    let diffuse = weights.local * material.diffuse * normal.dot(to_light).max(0.0) * albedo;
    if material.specular == 0.0 {
        return light_color * diffuse;
    }
    let half = (to_eye + to_light).normalize_or_zero();
    let highlight = material.specular * normal.dot(half).max(0.0).powf(material.highlight_exponent());
    light_color * (diffuse + highlight)
}

/// The Fresnel reflectance for unpolarised light from air, at a cosine of the angle to the normal.
pub(crate) fn reflectance(cos: f64, index: f64) -> f64 {
    let cos = cos.clamp(0.0, 1.0);
    let direction = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos);
    refract(direction, DVec3::Z, index.recip()).map_or(1.0, |(_, reflectance)| reflectance)
}

/// Reflects a direction at a unit normal.
pub(crate) fn mirror(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - 2.0 * direction.dot(normal) * normal
}

/// Reflects a direction at a rough mirror, by a random point of the unit square: the highlight of a light is the image of
/// the light in that mirror. A direction into the surface is replaced by that of the sharp mirror.
pub(crate) fn rough_mirror(direction: DVec3, normal: DVec3, exponent: f64, square: DVec2) -> DVec3 {
    let rough = mirror(direction, power_cosine_direction(square, normal, exponent));
    if rough.dot(normal) > 0.0 { rough } else { mirror(direction, normal) }
}

/// The refracted direction by Snell's law, and the Fresnel reflectance for unpolarised light.
/// `direction` is a unit vector. `normal` points to the side that it comes from. `ratio` is the
/// index of refraction on that side divided by that of the other. `None` is total internal
/// reflection.
pub(crate) fn refract(direction: DVec3, normal: DVec3, ratio: f64) -> Option<(DVec3, f64)> {
    let cos_in = -direction.dot(normal);
    let sin_out_squared = ratio * ratio * (1.0 - cos_in * cos_in).max(0.0);
    if sin_out_squared >= 1.0 {
        return None;
    }
    let cos_out = (1.0 - sin_out_squared).sqrt();
    // The amplitudes of light polarised perpendicular and parallel to the plane of incidence.
    let perpendicular = (ratio * cos_in - cos_out) / (ratio * cos_in + cos_out);
    let parallel = (cos_in - ratio * cos_out) / (cos_in + ratio * cos_out);
    let out = ratio * direction + (ratio * cos_in - cos_out) * normal;
    Some((out, 0.5 * (perpendicular * perpendicular + parallel * parallel)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn head_on_glass_reflects_four_per_cent() {
        let (out, reflectance) = refract(DVec3::NEG_Z, DVec3::Z, 1.0 / 1.5).unwrap();
        assert!((out - DVec3::NEG_Z).length() < 1e-12 && (reflectance - 0.04).abs() < 1e-12);
    }

    #[test]
    fn total_internal_reflection_begins_at_the_critical_angle() {
        let at = |angle_deg: f64| {
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            refract(DVec3::new(sin, 0.0, -cos), DVec3::Z, 1.5)
        };
        let critical = (1.0f64 / 1.5).asin().to_degrees();
        assert!(at(critical - 0.01).is_some() && at(critical + 0.01).is_none());
    }

    #[test]
    fn shares_never_exceed_one() {
        let with = |reflected, refracted| {
            LobeWeights::of(&Material { reflected, refracted, ..Material::default() }, 1.0)
        };
        assert_eq!(with(None, None), LobeWeights { local: 1.0, mirror: 0.0, transmitted: 0.0 });
        let over = with(Some(0.5), Some(1.0));
        assert!((over.local + over.mirror + over.transmitted - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_varnish_mirrors_little_head_on_and_all_at_grazing_angles() {
        let varnish = Material { reflected: Some(1.0), fresnel: true, ..Material::default() };
        assert!((LobeWeights::of(&varnish, 1.0).mirror - 0.04).abs() < 1e-12);
        assert!((LobeWeights::of(&varnish, 0.0).mirror - 1.0).abs() < 1e-12);
        let at = |cos| LobeWeights::of(&varnish, cos);
        assert!(at(0.3).local + at(0.3).mirror == 1.0 && at(0.3).mirror > at(0.6).mirror);
    }

    proptest! {
        #[test]
        fn refraction_obeys_snell_and_reverses(angle_deg in 0.0..89.0f64, index in 1.0..4.0f64) {
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let direction = DVec3::new(sin, 0.0, -cos);
            let (out, entering) = refract(direction, DVec3::Z, 1.0 / index).unwrap();
            prop_assert!((out.length() - 1.0).abs() < 1e-9 && (out.x * index - sin).abs() < 1e-9);
            prop_assert!((0.0..=1.0).contains(&entering));
            let (back, leaving) = refract(-out, DVec3::NEG_Z, index).unwrap();
            prop_assert!((back + direction).length() < 1e-6 && (entering - leaving).abs() < 1e-6);
        }
    }
}
