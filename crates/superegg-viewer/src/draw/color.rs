//! Encoding of colours for the screen.

use superegg_geom::glam::DVec3;
use superegg_scene::Encoding;

/// The screen values of a linear colour, clamped to 0..=1.
pub(crate) fn encoded(color: DVec3, encoding: Encoding) -> [f64; 3] {
    let curve = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        match encoding {
            Encoding::Linear => x,
            Encoding::Srgb if x <= 0.003_130_8 => 12.92 * x,
            Encoding::Srgb => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        }
    };
    color.to_array().map(curve)
}
