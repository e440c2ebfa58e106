//! Dithering to 8 bits: the fraction that a byte cannot hold becomes a pattern, so that gradients have no bands.

/// The byte of an encoded value in [0, 1] at a pixel: rounded up where the fraction exceeds a threshold. The thresholds
/// are a sequence of low discrepancy over the plane (multiples of the powers of the plastic number), so each small region
/// has the right mean, and no line or grid is seen.
pub(crate) fn byte(value: f32, x: u32, y: u32) -> u8 {
    const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
    let threshold = (0.5 + f64::from(x) * STEPS[0] + f64::from(y) * STEPS[1]).fract() as f32;
    // A whole byte stays that byte, whatever is lost in rounding.
    let scaled = 255.0 * value;
    let whole = (scaled + 1e-4).floor();
    (whole + f32::from(u8::from(scaled - whole > threshold.max(1e-4)))) as u8
}
