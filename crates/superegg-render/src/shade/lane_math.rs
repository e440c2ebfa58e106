//! Vectors and highlights in f32 lanes.

use superegg_simd::{Lanes, Simd};

#[inline(always)]
pub(crate) fn dot<S: Simd>(a: [Lanes<S>; 3], b: [Lanes<S>; 3]) -> Lanes<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// The reciprocal of the length; large for a zero vector.
#[inline(always)]
pub(crate) fn inverse_length<S: Simd>(v: [Lanes<S>; 3]) -> Lanes<S> {
    let square = dot(v, v);
    square.max(square.all(f32::MIN_POSITIVE)).rsqrt()
}

/// The largest exponent of [`blinn_power`].
pub(crate) const MOST_EXPONENT: f64 = 1e5;

/// The highlight max(0, N.H)^exponent, by the unit normal N and a vector along H of any length.
///
/// The cosine is computed by the difference of both unit vectors, so that sharp highlights keep their digits:
/// 1 - N.H = |N - H|^2 / 2.
#[inline(always)]
pub(crate) fn blinn_power<S: Simd>(
    normal: [Lanes<S>; 3],
    half: [Lanes<S>; 3],
    exponent: Lanes<S>,
) -> Lanes<S> {
    let scale = inverse_length(half);
    let mut between = normal;
    for axis in 0..3 {
        between[axis] = normal[axis] - half[axis] * scale;
    }
    let (one, middle) = (exponent.all(1.0), exponent.all(0.5));
    let below_one = middle * dot(between, between);
    // 0 to the power of 0 must be 1. The logarithm of the least normal number is finite, and other exponents of it still
    // give nearly 0.
    let cos = (one - below_one).max(one.all(f32::MIN_POSITIVE));
    let near = below_one.min(middle);
    let log_near = -(near / (one - near)).log2_of_one_plus();
    let log = below_one.le(middle).select(log_near, cos.log2_quick());
    // Avoids subnormal results, which are many times slower.
    (exponent * log).max(one.all(-60.0)).exp2()
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;
    use superegg_geom::glam::DVec3;
    use superegg_simd::{Arch, WithSimd};

    use super::*;

    struct Power([[f32; 16]; 3], [[f32; 16]; 3], f32);

    impl WithSimd for Power {
        type Output = [f32; 16];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> [f32; 16] {
            let mut powers = [0.0; 16];
            for i in 0..16 / S::F32_LANES {
                let load = |columns: &[[f32; 16]; 3]| columns.each_ref().map(|x| Lanes::load(simd, x, i));
                blinn_power(load(&self.0), load(&self.1), Lanes::splat(simd, self.2)).store(&mut powers, i);
            }
            powers
        }
    }

    #[test]
    fn highlights_are_those_of_f64() {
        let mut random = SplitMix::new(3);
        for exponent in [0.0f64, 1.0, 20.0, 2000.0, 1e5] {
            for _ in 0..500 {
                let (mut normals, mut halves) = ([[0.0; 16]; 3], [[0.0; 16]; 3]);
                let mut expected = [0.0; 16];
                for lane in 0..16 {
                    let mut vector =
                        |scale: f64| scale * (DVec3::from_array([0; 3].map(|_| random.unit())) - 0.5);
                    let normal = vector(1.0).normalize();
                    // Half of all near the normal, where the highlight is.
                    let spread = if lane % 2 == 0 { 3.0 } else { 3.0 / (1.0 + exponent).sqrt() };
                    let half = 1.7 * (normal + vector(spread));
                    for axis in 0..3 {
                        normals[axis][lane] = normal[axis] as f32;
                        halves[axis][lane] = half[axis] as f32;
                    }
                    expected[lane] = normal.dot(half.normalize()).max(0.0).powf(exponent);
                }
                let powers = Arch::new().dispatch(Power(normals, halves, exponent as f32));
                for lane in 0..16 {
                    let error = (f64::from(powers[lane]) - expected[lane]).abs();
                    assert!(error < 2e-4, "{exponent} {expected:?} {powers:?}");
                }
            }
        }
    }
}
