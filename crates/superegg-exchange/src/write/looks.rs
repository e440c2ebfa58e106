//! Materials in the terms of mesh formats.

use std::collections::HashMap;

use superegg_geom::glam::DVec3;
use superegg_scene::Material;

use super::flatten::Instances;
use crate::srgb::srgb_of_linear;

/// A material as mesh formats describe it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Look {
    /// The name of the first part that has it.
    pub(super) name: String,
    /// The linear base colour.
    pub(super) color: DVec3,
    /// 1 minus the weight of transmitted light.
    pub(super) opacity: f64,
    /// The weight of mirrored light.
    pub(super) mirror: f64,
    /// The weight of the highlight.
    pub(super) specular: f64,
    /// The exponent of the highlight.
    pub(super) exponent: f64,
    /// Roughness and metal of a surface of facets.
    facets: Option<(f64, f64)>,
}

impl Look {
    fn of(name: &str, material: &Material) -> Self {
        Self {
            name: name.to_owned(),
            color: material.color.clamp(DVec3::ZERO, DVec3::ONE),
            opacity: 1.0 - material.refracted.unwrap_or(0.0),
            mirror: material.reflected.unwrap_or(0.0),
            specular: material.specular,
            exponent: material.highlight_exponent(),
            facets: material.facet_roughness().map(|roughness| (roughness, material.metallic)),
        }
    }

    fn key(&self) -> [u64; 9] {
        let [r, g, b] = self.color.to_array();
        let (roughness, metal) = self.facets.unwrap_or((-1.0, -1.0));
        [r, g, b, self.opacity, self.mirror, self.specular, self.exponent, roughness, metal].map(f64::to_bits)
    }

    /// The roughness of a microfacet model (GGX): that of the material, or one whose lobe is about as wide as the
    /// highlight: alpha^2 = 2 / (exponent + 2), alpha = roughness^2.
    pub(super) fn roughness(&self) -> f64 {
        let of_highlight = || (2.0 / (self.exponent + 2.0)).powf(0.25).clamp(0.0, 1.0);
        self.facets.map_or_else(of_highlight, |(roughness, _)| roughness)
    }

    /// The metal of a microfacet model: that of the material, or the weight of mirrored light.
    pub(super) fn metallic(&self) -> f64 {
        self.facets.map_or(self.mirror, |(_, metallic)| metallic)
    }
}

/// The distinct materials of instances, and the one of each part.
pub(super) fn looks(instances: &Instances) -> (Vec<Look>, Vec<usize>) {
    let mut known = HashMap::new();
    let mut looks = Vec::new();
    let of_part = instances.parts.iter().map(|part| {
        let look = Look::of(&part.name, &part.material);
        *known.entry(look.key()).or_insert_with(|| {
            looks.push(look);
            looks.len() - 1
        })
    });
    let of_part = of_part.collect();
    (looks, of_part)
}

/// A linear colour as sRGB bytes, for formats whose colours are those of the screen.
pub(super) fn srgb_bytes(color: DVec3) -> [u8; 3] {
    srgb(color).map(|x| (x * 255.0).round() as u8)
}

/// A linear colour in the sRGB encoding (IEC 61966-2-1), each channel in [0, 1].
pub(super) fn srgb(color: DVec3) -> [f64; 3] {
    color.to_array().map(|x| srgb_of_linear(x.clamp(0.0, 1.0)))
}
