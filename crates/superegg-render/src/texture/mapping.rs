//! The coordinates of textures on surfaces.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::TextureMapping;

use crate::texture::pixels::{Rows, TexturePixels};

/// A point of a surface with the footprint of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexturePlace {
    /// The point in the primitive's own space; on a floor in its plane.
    pub(crate) local: DVec3,
    /// The point on the unit shape; `None` on a floor.
    pub(crate) unit: Option<DVec3>,
    /// The normal in the primitive's own space, of any length.
    pub(crate) normal: DVec3,
    /// The extent of the footprint along the axes of the primitive's own space.
    pub(crate) extents: DVec3,
    /// The semi-axes.
    pub(crate) radii: DVec3,
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MappedTexture {
    pub(crate) pixels: Arc<TexturePixels>,
    pub(crate) mapping: TextureMapping,
    pub(crate) scale: f64,
}

impl MappedTexture {
    /// The mean of the picture over the footprint at a point.
    pub(crate) fn value(&self, place: &TexturePlace) -> DVec3 {
        match (self.mapping, place.unit) {
            (TextureMapping::Around, Some(unit)) => {
                let (at, footprint) = around(unit, place.extents / place.radii);
                self.pixels.mean(at / self.scale, footprint / self.scale, self.rows())
            }
            _ => {
                let (at, footprint) = self.in_pictures(on_side(place));
                self.pixels.mean(at, footprint, Rows::Repeat)
            }
        }
    }

    /// The gradient of the red channel along the surface in the primitive's own space, of which the part along the normal has
    /// no meaning; as [`MappedTexture::value`] over the footprint.
    pub(crate) fn gradient(&self, place: &TexturePlace) -> DVec3 {
        match (self.mapping, place.unit) {
            (TextureMapping::Around, Some(unit)) => {
                let (at, footprint) = around(unit, place.extents / place.radii);
                // Next to a pole a pixel is narrow, and what it shows is as wide as a pixel is high.
                let rise = self.scale / self.pixels.height();
                let turn = 0.5 * rise * unit.length() / unit.truncate().length();
                let footprint = DVec2::new(footprint.x.max(turn).min(1.0), footprint.y);
                let mut slope = self.pixels.slope(at / self.scale, footprint / self.scale, self.rows());
                if footprint.x == 1.0 {
                    slope.x = 0.0;
                }
                gradient_around(unit, slope / self.scale) / place.radii
            }
            _ => {
                let (at, footprint) = self.in_pictures(on_side(place));
                let slope = self.pixels.slope(at, footprint, Rows::Repeat);
                gradient_on_side(place, slope * DVec2::new(1.0, self.pixels.aspect()) / self.scale)
            }
        }
    }

    /// The rows from pole to pole. Beyond a pole lies no other end of the picture.
    fn rows(&self) -> Rows {
        Rows::UpTo(self.scale.recip())
    }

    /// A point and a footprint of a side in pictures. The picture has one width for both directions, and its centre lies at the
    /// origin.
    fn in_pictures(&self, (at, footprint): (DVec2, DVec2)) -> (DVec2, DVec2) {
        let aspect = DVec2::new(1.0, self.pixels.aspect());
        (at * aspect / self.scale + 0.5, footprint * aspect / self.scale)
    }
}

/// Longitude and latitude of a point of the unit shape, each from 0 to 1, and the footprint in both.
fn around(unit: DVec3, extents: DVec3) -> (DVec2, DVec2) {
    let across = unit.truncate().length();
    let at = DVec2::new(0.5 + unit.y.atan2(unit.x) / TAU, 0.5 + unit.z.atan2(across) / PI);
    let turn = (unit.y.abs() * extents.x + unit.x.abs() * extents.y) / (across * across).max(1e-12);
    let sideways = extents.truncate().max_element();
    let rise = (across * extents.z + unit.z.abs() * sideways) / unit.length_squared().max(1e-12);
    (at, DVec2::new((turn / TAU).min(1.0), (rise / PI).min(1.0)))
}

/// The gradient in the space of the unit shape of a function of longitude and latitude as in [`around`], by its derivatives.
fn gradient_around(unit: DVec3, by_turn_and_rise: DVec2) -> DVec3 {
    let across = unit.truncate().length();
    if across == 0.0 {
        return DVec3::ZERO;
    }
    let (cos, sin) = (unit.x / across, unit.y / across);
    let east = DVec3::new(-sin, cos, 0.0) / (TAU * across);
    let north = DVec3::new(-cos * unit.z, -sin * unit.z, across) / (PI * unit.length_squared());
    let by_turn = if by_turn_and_rise.x == 0.0 { DVec3::ZERO } else { by_turn_and_rise.x * east };
    by_turn + by_turn_and_rise.y * north
}

/// The gradient in the primitive's own space of a function of the coordinates of [`on_side`], by its derivatives.
fn gradient_on_side(place: &TexturePlace, slope: DVec2) -> DVec3 {
    let axis = place.normal.abs().max_position();
    let sign = place.normal[axis].signum();
    match axis {
        0 => DVec3::new(0.0, sign * slope.x, slope.y),
        1 => DVec3::new(-sign * slope.x, 0.0, slope.y),
        _ => DVec3::new(sign * slope.x, slope.y, 0.0),
    }
}

/// The coordinates on the side that the normal faces most, and the footprint in both. From outside, the first goes to the
/// right, and the second towards z, on top and bottom towards y.
fn on_side(place: &TexturePlace) -> (DVec2, DVec2) {
    let TexturePlace { local, normal, extents, .. } = *place;
    let axis = normal.abs().max_position();
    let sign = normal[axis].signum();
    match axis {
        0 => (DVec2::new(sign * local.y, local.z), DVec2::new(extents.y, extents.z)),
        1 => (DVec2::new(-sign * local.x, local.z), DVec2::new(extents.x, extents.z)),
        _ => (DVec2::new(sign * local.x, local.y), DVec2::new(extents.x, extents.y)),
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::Vec3;

    use super::*;

    /// A picture whose red and green are its own coordinates.
    fn coordinates() -> Arc<TexturePixels> {
        let value = |i: usize| Vec3::new((i % 64) as f32 + 0.5, 63.5 - (i / 64) as f32, 0.0) / 64.0;
        Arc::new(TexturePixels::new((64, 64), (0..4096).map(value).collect()))
    }

    fn place(unit: DVec3, normal: DVec3) -> TexturePlace {
        let radii = DVec3::new(2.0, 1.0, 0.5);
        TexturePlace { local: unit * radii, unit: Some(unit), normal, extents: DVec3::ZERO, radii }
    }

    #[test]
    fn a_picture_goes_once_around() {
        let texture = MappedTexture { pixels: coordinates(), mapping: TextureMapping::Around, scale: 1.0 };
        for (turn, rise) in [(0.1, 0.2), (0.4, 0.6), (0.7, 0.9), (0.9, 0.3)] {
            let (longitude, latitude) = (TAU * (turn - 0.5), PI * (rise - 0.5));
            let across = latitude.cos();
            let unit = DVec3::new(across * longitude.cos(), across * longitude.sin(), latitude.sin());
            let value = texture.value(&place(unit, unit));
            assert!((value - DVec3::new(turn, rise, 0.0)).length() < 1e-3, "{value}");
            let half = MappedTexture { scale: 0.5, ..texture.clone() };
            let value = half.value(&place(unit, unit));
            let expected = DVec3::new((2.0 * turn).fract(), (2.0 * rise).fract(), 0.0);
            assert!((value - expected).length() < 1e-3, "{value} {expected}");
        }
    }

    #[test]
    fn gradients_are_those_of_the_heights() {
        // Smooth heights, the same at both ends.
        let height = |i: usize| {
            let [x, y] = [i % 256, i / 256].map(|at| TAU * (at as f64 + 0.5) / 256.0);
            (0.3 * x.sin() + 0.2 * (2.0 * y).cos() + 0.1 * (x + y).sin()) as f32
        };
        let pixels =
            Arc::new(TexturePixels::new((256, 256), (0..65536).map(|i| Vec3::splat(height(i))).collect()));
        for mapping in [TextureMapping::Around, TextureMapping::Box] {
            for scale in [0.5, 1.0, 1.7] {
                let texture = MappedTexture { pixels: Arc::clone(&pixels), mapping, scale };
                for i in 0..200 {
                    let part = |step: f64| (f64::from(i) * step).fract();
                    let (longitude, latitude) = (TAU * (part(0.618) - 0.5), 2.4 * (part(0.755) - 0.5));
                    let across = latitude.cos();
                    let unit = DVec3::new(across * longitude.cos(), across * longitude.sin(), latitude.sin());
                    let place = place(unit, unit / DVec3::new(2.0, 1.0, 0.5));
                    let gradient = texture.gradient(&place);
                    let (first, second) = place.normal.normalize().any_orthonormal_pair();
                    for along in [first, second] {
                        const STEP: f64 = 1e-2;
                        let value = |side: f64| {
                            let local = place.local + side * STEP * along;
                            texture.value(&TexturePlace { local, unit: Some(local / place.radii), ..place }).x
                        };
                        let expected = (value(1.0) - value(-1.0)) / (2.0 * STEP);
                        // Values repeat where the longitude does.
                        let is_seam = mapping == TextureMapping::Around && unit.x < 0.0 && unit.y.abs() < 0.1;
                        assert!(
                            is_seam || (gradient.dot(along) - expected).abs() < 0.03 * (1.0 + expected.abs()),
                            "{mapping:?} {scale} {unit}: {} {expected}",
                            gradient.dot(along)
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_poles_have_the_first_and_the_last_row_alone() {
        // Rows of red, black, black and blue; one picture, two and a quarter from pole to pole.
        let rows = [Vec3::X, Vec3::ZERO, Vec3::ZERO, Vec3::Z];
        let pixels = Arc::new(TexturePixels::new((1, 4), rows.to_vec()));
        for (scale, north) in [(1.0, DVec3::X), (0.5, DVec3::X), (4.0, DVec3::Z)] {
            let texture =
                MappedTexture { pixels: Arc::clone(&pixels), mapping: TextureMapping::Around, scale };
            for across in [0.0, 1e-9, 0.01] {
                for extent in [0.0, 1e-3] {
                    let at = |z: f64| {
                        let unit = DVec3::new(across, 0.0, z);
                        texture.value(&TexturePlace { extents: DVec3::splat(extent), ..place(unit, unit) })
                    };
                    assert!((at(1.0) - north).length() < 0.05, "{scale} {across} {extent}: {}", at(1.0));
                    assert!((at(-1.0) - DVec3::Z).length() < 0.05, "{scale} {across} {extent}: {}", at(-1.0));
                }
            }
        }
    }

    #[test]
    fn no_side_of_a_box_shows_a_mirrored_picture() {
        let texture = MappedTexture { pixels: coordinates(), mapping: TextureMapping::Box, scale: 4.0 };
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for normal in [axis, -axis] {
                let at = |unit: DVec3| texture.value(&place(unit, normal));
                let up = if axis == DVec3::Z { DVec3::Y } else { DVec3::Z };
                let right = up.cross(normal);
                let center = at(normal);
                assert!((center - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-6, "{normal} {center}");
                assert!(
                    at(normal + 0.2 * right).x > center.x && at(normal + 0.2 * up).y > center.y,
                    "{normal}"
                );
            }
        }
    }

    #[test]
    fn footprints_are_finite_and_grow_towards_the_poles() {
        let extents = DVec3::splat(0.01);
        let (_, equator) = around(DVec3::X, extents);
        let (_, pole) = around(DVec3::new(0.01, 0.0, 0.99), extents);
        assert!(pole.x > 10.0 * equator.x && pole.x <= 1.0);
        for unit in [DVec3::Z, DVec3::ZERO, DVec3::NEG_Z] {
            let (at, footprint) = around(unit, extents);
            assert!(at.is_finite() && footprint.is_finite());
        }
    }
}
