//! Small pieces of careful floating-point arithmetic.

use glam::DVec3;

/// `a b - c d` with an error of at most 1.5 ulp of the result (Kahan's algorithm; Jeannerod, Louvet
/// and Muller 2013), however much the two products cancel.
pub(crate) fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let cd_error = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + cd_error
}

/// A vector times the power of two that brings its largest component into [1, 2), as far as the
/// range of f64 lets it, and that power: the scaling is exact. `None` for zero and for what is not
/// finite.
#[inline]
pub fn scale_to_unit(v: DVec3) -> Option<(DVec3, f64)> {
    let largest = v.abs().max_element();
    if !v.is_finite() || largest == 0.0 {
        return None;
    }
    let exponent = (largest.to_bits() >> 52) as i32 - 1023;
    // Both ends stay normal numbers, so that multiplying by the scale is exact.
    let scale = f64::from_bits(((-exponent).clamp(-1000, 1000) + 1023) as u64 * (1 << 52));
    Some((v * scale, scale))
}

/// `v` at unit length, however long it is: the largest component is divided out first, so that no
/// square leaves the range of f64. Infinite components count as equal among themselves. `None` for
/// zero.
#[inline]
pub fn unit_vector(v: DVec3) -> Option<DVec3> {
    let square = v.length_squared();
    if (1e-200..1e200).contains(&square) {
        return Some(v * square.sqrt().recip());
    }
    let largest = v.abs().max_element();
    let scaled = if largest.is_infinite() {
        DVec3::from_array(v.to_array().map(|c| if c.is_infinite() { 1f64.copysign(c) } else { 0.0 }))
    } else {
        v / largest
    };
    (largest > 0.0).then(|| scaled.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_of_products_survives_cancellation() {
        // (1 + u)(1 - u) - 1 = -u^2 exactly; plain arithmetic gives 0.
        let u = 2f64.powi(-30);
        assert_eq!(difference_of_products(1.0 + u, 1.0 - u, 1.0, 1.0), -(u * u));
    }

    #[test]
    fn scale_to_unit_is_an_exact_power_of_two() {
        for x in [1.0, 1.5, 2.0, 3e-200, 7e200, 0.1, 1e-12] {
            let (scaled, scale) = scale_to_unit(DVec3::new(0.1 * x, -x, 0.0)).unwrap();
            assert!((1.0..2.0).contains(&scaled.y.abs()), "{x}: {scaled}");
            assert_eq!(scaled.y / scale, -x);
        }
        for x in [f64::MIN_POSITIVE, 5e-324, f64::MAX] {
            assert!(scale_to_unit(DVec3::splat(x)).unwrap().1.is_normal());
        }
        for v in [DVec3::ZERO, DVec3::INFINITY, DVec3::new(f64::NAN, 1.0, 0.0)] {
            assert_eq!(scale_to_unit(v), None);
        }
    }
}
