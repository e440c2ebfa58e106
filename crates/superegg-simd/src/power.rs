//! Logarithms and powers of two in f64, as plain arithmetic: in a loop over an array the compiler computes them for all
//! lanes of the machine at once.

/// `a * b + c`, fused where the machine can.
#[inline(always)]
pub fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// k and m of x = 2^k m with m in [sqrt 1/2, sqrt 2), for a normal x.
#[inline(always)]
pub fn exponent_and_mantissa(x: f64) -> (f64, f64) {
    const TO_ROOT: u64 = 0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd;
    let k = x.to_bits().wrapping_add(TO_ROOT) >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub(k << 52).wrapping_add(0x3ff0_0000_0000_0000));
    // Converts k to f64: these are the bits of 2^52 + k.
    (f64::from_bits(k | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0), m)
}

/// `k + log2 m` for s = (m - 1) / (m + 1), |s| < 0.172: (2 / ln 2) artanh s.
#[inline(always)]
pub fn log2_of<const FUSED: bool>(k: f64, s: f64) -> f64 {
    let z = s * s;
    // 1/3 + z/5 + ... + z^10/23, by pairs.
    let pair = |odd: f64| fma::<FUSED>(z, 1.0 / (odd + 2.0), 1.0 / odd);
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = fma::<FUSED>(pair(7.0), z2, pair(3.0));
    let middle = fma::<FUSED>(pair(15.0), z2, pair(11.0));
    let high = fma::<FUSED>(z2, 1.0 / 23.0, pair(19.0));
    let series = fma::<FUSED>(fma::<FUSED>(high, z4, middle), z4, low);
    let tail = s * z * series;
    fma::<FUSED>(2.0 * std::f64::consts::LOG2_E, s + tail, k)
}

/// log2 x of a normal x > 0, to a few units of the last place of the result, or to 1e-16.
#[inline(always)]
pub fn log2<const FUSED: bool>(x: f64) -> f64 {
    let (k, m) = exponent_and_mantissa(x);
    log2_of::<FUSED>(k, (m - 1.0) / (m + 1.0))
}

/// 2^x for x <= 1000, to a few units of the last place; 2^-1000 for x < -1000.
#[inline(always)]
pub fn exp2<const FUSED: bool>(x: f64) -> f64 {
    let x = if x > -1000.0 { x } else { -1000.0 };
    // Adding 1.5 * 2^52 leaves the nearest integer in the low bits.
    let magic = 6_755_399_441_055_744.0;
    let whole = x + magic;
    let f = (x - (whole - magic)) * std::f64::consts::LN_2;
    // The series of e^f, by pairs of terms.
    let pair = |a: f64, b: f64| fma::<FUSED>(f, b, a);
    let f2 = f * f;
    let f4 = f2 * f2;
    let low = fma::<FUSED>(pair(1.0 / 24.0, 1.0 / 120.0), f2, pair(0.5, 1.0 / 6.0));
    let middle = fma::<FUSED>(pair(1.0 / 40_320.0, 1.0 / 362_880.0), f2, pair(1.0 / 720.0, 1.0 / 5_040.0));
    let high = fma::<FUSED>(
        pair(1.0 / 479_001_600.0, 1.0 / 6_227_020_800.0),
        f2,
        pair(1.0 / 3_628_800.0, 1.0 / 39_916_800.0),
    );
    let series = fma::<FUSED>(fma::<FUSED>(high, f4, middle), f4, low);
    let series = fma::<FUSED>(series, f2, f) + 1.0;
    f64::from_bits(series.to_bits().wrapping_add(whole.to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_agree_with_the_standard_library() {
        for i in 1..200_000 {
            let x = f64::from(i) * 1e-5;
            assert!((log2::<true>(x) - x.log2()).abs() <= 7e-16 * x.log2().abs().max(0.5), "{x}");
            let y = f64::from(i - 100_000) * 0.009;
            assert!((exp2::<true>(y) / y.exp2() - 1.0).abs() < 1e-15, "{y}");
        }
        assert_eq!((log2::<false>(1.0), exp2::<false>(0.0)), (0.0, 1.0));
        assert_eq!(exp2::<true>(-5e5), exp2::<false>(-1000.0));
    }
}
