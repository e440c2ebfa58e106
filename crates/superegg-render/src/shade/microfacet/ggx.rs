//! The GGX distribution of the normals of facets (Trowbridge and Reitz 1975; Walter et al. 2007), isotropic, with the
//! masking of Smith. Directions are unit vectors in the frame of the surface: z is its normal.

use std::f64::consts::{PI, TAU};

use superegg_geom::glam::{DVec2, DVec3};

/// The distribution of a roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ggx {
    /// The slope of a typical facet: the square of the roughness.
    alpha: f64,
}

impl Ggx {
    /// Smoother surfaces are blurred by two hundred-thousandths of a radian, which nobody sees.
    const LEAST_ALPHA: f64 = 1e-5;
    /// The highlight of a light without a size is brighter than 1e5 times the light, and smaller than a pixel, below this.
    const LEAST_ALPHA_OF_HIGHLIGHTS: f64 = 1e-3;

    /// For a roughness in [0, 1].
    pub(crate) fn new(roughness: f64) -> Self {
        Self { alpha: (roughness * roughness).max(Self::LEAST_ALPHA) }
    }

    /// Whether a light without a size has a highlight that can be sampled.
    pub(crate) fn has_highlights(self) -> bool {
        self.alpha >= Self::LEAST_ALPHA_OF_HIGHLIGHTS
    }

    /// The area of facets of this normal, for each unit of area and of solid angle:
    /// `alpha^2 / (pi (sin^2 + alpha^2 cos^2)^2)`.
    pub(crate) fn density(self, facet: DVec3) -> f64 {
        if facet.z <= 0.0 {
            return 0.0;
        }
        let squared = self.alpha * self.alpha;
        let sum = facet.x * facet.x + facet.y * facet.y + squared * facet.z * facet.z;
        squared / (PI * sum * sum)
    }

    /// Smith's Lambda: the area of hidden facets in that of visible ones, from either side of the surface.
    pub(crate) fn hidden(self, direction: DVec3) -> f64 {
        let DVec3 { x, y, z } = direction;
        let tangent_squared = (x * x + y * y) / (z * z);
        0.5 * ((self.alpha * self.alpha * tangent_squared + 1.0).sqrt() - 1.0)
    }

    /// The part of the facets that a direction sees.
    pub(crate) fn visible(self, direction: DVec3) -> f64 {
        (1.0 + self.hidden(direction)).recip()
    }

    /// The part of the facets that two directions on the same side see both: those that one sees from high up the other
    /// does, too.
    pub(crate) fn visible_to_both(self, a: DVec3, b: DVec3) -> f64 {
        (1.0 + self.hidden(a) + self.hidden(b)).recip()
    }

    /// A random normal of a facet that a direction with z > 0 sees, by a point of the unit square (Dupuy and Benyoub
    /// 2023). Its density is [`Ggx::density_of_visible`].
    pub(crate) fn visible_facet(self, direction: DVec3, square: DVec2) -> DVec3 {
        let stretched =
            DVec3::new(self.alpha * direction.x, self.alpha * direction.y, direction.z).normalize();
        let z = (1.0 - square.y) * (1.0 + stretched.z) - stretched.z;
        let around = DVec2::from_angle(TAU * square.x) * (1.0 - z * z).max(0.0).sqrt();
        let sum = around.extend(z) + stretched;
        DVec3::new(self.alpha * sum.x, self.alpha * sum.y, sum.z.max(f64::MIN_POSITIVE)).normalize()
    }

    /// The density of [`Ggx::visible_facet`], for each unit of solid angle.
    pub(crate) fn density_of_visible(self, direction: DVec3, facet: DVec3) -> f64 {
        self.visible(direction) * direction.dot(facet).max(0.0) * self.density(facet) / direction.z
    }
}

/// Schlick's part of the Fresnel reflectance (1994): `(1 - cos)^5`.
pub(crate) fn grazing(cos: f64) -> f64 {
    let rest = (1.0 - cos).clamp(0.0, 1.0);
    let squared = rest * rest;
    squared * squared * rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::sobol::sobol;

    /// A unit direction with this cosine.
    fn at(cos: f64) -> DVec3 {
        DVec3::new(0.6 * (1.0 - cos * cos).sqrt(), -0.8 * (1.0 - cos * cos).sqrt(), cos)
    }

    #[test]
    fn the_facets_cover_the_surface_and_their_visible_area_is_the_projection_of_it() {
        for roughness in [0.2, 0.5, 1.0] {
            let ggx = Ggx::new(roughness);
            for cos in [0.05, 0.4, 1.0] {
                let (eye, count) = (at(cos), 1 << 18);
                let (mut area, mut projected) = (0.0, 0.0);
                for i in 0..count {
                    let DVec2 { x: z, y } = sobol(i, 5);
                    let facet = (DVec2::from_angle(TAU * y) * (1.0 - z * z).sqrt()).extend(z);
                    let rate = TAU * ggx.density(facet);
                    area += rate * z;
                    projected += rate * eye.dot(facet).max(0.0) * ggx.visible(eye);
                }
                let mean = |sum: f64| sum / f64::from(count);
                assert!((mean(area) - 1.0).abs() < 2e-2, "{roughness} {}", mean(area));
                assert!(
                    (mean(projected) / cos - 1.0).abs() < 2e-2,
                    "{roughness} {cos} {}",
                    mean(projected) / cos
                );
            }
        }
    }

    #[test]
    fn facets_are_drawn_with_their_density() {
        // The mean of a function over drawn facets is its integral times the density.
        for (roughness, cos) in [(0.3, 0.9), (0.6, 0.3), (1.0, 0.1), (1.0, 1.0)] {
            let (ggx, eye, count) = (Ggx::new(roughness), at(cos), 1 << 17);
            let (mut drawn, mut integral) = ([0.0; 3], [0.0; 3]);
            let test = |facet: DVec3| [facet.z, facet.x + facet.y, facet.x * facet.x];
            for i in 0..count {
                let facet = ggx.visible_facet(eye, sobol(i, 1));
                assert!((facet.length() - 1.0).abs() < 1e-12 && facet.z >= 0.0);
                drawn.iter_mut().zip(test(facet)).for_each(|(sum, x)| *sum += x / f64::from(count));
                let square = sobol(i, 2);
                let facet =
                    (DVec2::from_angle(TAU * square.y) * (1.0 - square.x * square.x).sqrt()).extend(square.x);
                let weight = TAU * ggx.density_of_visible(eye, facet) / f64::from(count);
                integral.iter_mut().zip(test(facet)).for_each(|(sum, x)| *sum += weight * x);
            }
            for (a, b) in drawn.into_iter().zip(integral) {
                assert!((a - b).abs() < 5e-3, "{roughness} {cos}: {a} {b}");
            }
        }
    }
}
