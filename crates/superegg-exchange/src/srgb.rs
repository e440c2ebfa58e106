//! The sRGB curve (IEC 61966-2-1), for formats whose colours are those of the screen.

/// The linear value of an sRGB value in [0, 1].
pub(crate) fn linear_of_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB value of a linear value in [0, 1].
pub(crate) fn srgb_of_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255_u8 {
            let back = srgb_of_linear(linear_of_srgb(f64::from(byte) / 255.0)) * 255.0;
            assert!((back - f64::from(byte)).abs() < 1e-4, "{byte}: {back}");
        }
    }
}
