//! Gradient noise for procedural patterns (Perlin 2002).

use superegg_geom::glam::DVec3;

/// Smooth noise at a point, in [-1, 1], with mean 0 and features of size 1.
pub(crate) fn noise(point: DVec3) -> f64 {
    // Beyond this the cells of f64 are as wide as those of the noise.
    const FARTHEST: f64 = 1e12;
    if point.abs().max_element() > FARTHEST || !point.is_finite() {
        return 0.0;
    }
    let cell = point.floor();
    let inside = point - cell;
    let fade = inside * inside * inside * (inside * (inside * 6.0 - 15.0) + 10.0);
    let cell = cell.to_array().map(|position| position as i64);
    let corner = |x: i64, y: i64, z: i64| {
        let offset = inside - DVec3::new(x as f64, y as f64, z as f64);
        slope(hash([cell[0] + x, cell[1] + y, cell[2] + z]), offset)
    };
    let mix = |a: f64, b: f64, part: f64| a + part * (b - a);
    let along = |y, z| mix(corner(0, y, z), corner(1, y, z), fade.x);
    let flat = |z| mix(along(0, z), along(1, z), fade.y);
    mix(flat(0), flat(1), fade.z)
}

/// Octaves of [`noise`], each of half the size and strength of the one before, in [-1, 1]. Octaves that are finer than
/// `width` fade to their mean.
pub(crate) fn octaves(point: DVec3, width: f64) -> f64 {
    const COUNT: i32 = 6;
    (0..COUNT)
        .map(|octave| {
            let scale = f64::from(octave).exp2();
            // From a width of half a feature on, down to 0 at a whole one.
            let visible = (2.0 - 2.0 * width * scale).clamp(0.0, 1.0);
            if visible > 0.0 { 0.5 / scale * visible * noise(point * scale) } else { 0.0 }
        })
        .sum()
}

/// The dot product of an offset and one of twelve gradients.
fn slope(hash: u64, offset: DVec3) -> f64 {
    let DVec3 { x, y, z } = offset;
    let (a, b) = match hash % 12 / 4 {
        0 => (x, y),
        1 => (x, z),
        _ => (y, z),
    };
    (if hash & 1 == 0 { a } else { -a }) + (if hash & 2 == 0 { b } else { -b })
}

/// A hash of a cell.
fn hash(cell: [i64; 3]) -> u64 {
    let mixed = cell.into_iter().fold(0x9e37_79b9_7f4a_7c15u64, |hash, position| {
        let hash = (hash ^ position as u64).wrapping_mul(0xff51_afd7_ed55_8ccd);
        hash ^ hash >> 32
    });
    mixed.wrapping_mul(0xc4ce_b9fe_1a85_ec53) >> 33
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> impl Iterator<Item = DVec3> {
        (0..20_000).map(|i| {
            let i = f64::from(i);
            DVec3::new(0.377 * i, 0.211 * i + 40.0, -0.129 * i) % 97.3
        })
    }

    #[test]
    fn noise_is_bounded_smooth_and_has_no_bias() {
        let values: Vec<f64> = points().map(noise).collect();
        assert!(values.iter().all(|value| value.abs() <= 1.0));
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let spread = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        assert!(mean.abs() < 0.02 && spread > 0.03, "{mean} {spread}");
        for point in points().take(2_000) {
            assert!((noise(point + DVec3::splat(1e-6)) - noise(point)).abs() < 2e-5);
            assert!(octaves(point, 0.0).abs() <= 1.0);
        }
        for far in [f64::NAN, f64::INFINITY, 1e300, -1e15] {
            assert_eq!(noise(DVec3::splat(far)), 0.0);
        }
    }

    #[test]
    fn wide_rays_see_the_mean() {
        assert!(points().take(100).all(|point| octaves(point, 1.0) == 0.0));
        let fine = points().take(1_000).map(|point| octaves(point, 0.0).abs()).sum::<f64>();
        let coarse = points().take(1_000).map(|point| octaves(point, 0.7).abs()).sum::<f64>();
        assert!(coarse < 0.7 * fine && coarse > 0.0);
    }
}
