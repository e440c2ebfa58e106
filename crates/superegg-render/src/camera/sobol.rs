//! Low-discrepancy random numbers. They are equal on every machine and for any order of tiles.

use std::f64::consts::TAU;

use superegg_geom::glam::{DVec2, DVec3};

/// The seed of the random numbers of one sample of a pixel, at one node of its tree of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleKey {
    seed: u32,
    index: u32,
}

impl SampleKey {
    /// For a sample of a pixel.
    pub(crate) fn new(pixel: (u32, u32), index: u32) -> Self {
        Self { seed: hash(hash(pixel.0.wrapping_add(0x9e37_79b9)) ^ pixel.1), index }
    }

    /// The key of a child node: a reflected ray, a light. Children have different choices.
    pub(crate) fn branch(self, choice: u32) -> Self {
        Self { seed: hash(self.seed ^ hash(choice.wrapping_add(1))), ..self }
    }

    /// Point `index` of `count` for this sample, in [0, 1)^2. The points of all samples of the
    /// pixel together are a prefix of one sequence.
    pub(crate) fn point(self, index: u32, count: u32) -> DVec2 {
        let (index, seed) = self.index_and_seed(index, count);
        sobol(index, seed)
    }

    /// A seed for another generator of random numbers.
    pub(crate) fn bits(self) -> u64 {
        u64::from(self.seed) << 32 | u64::from(self.index)
    }

    /// The arguments of [`sobol`] for point `index` of `count`.
    #[inline]
    pub(crate) fn index_and_seed(self, index: u32, count: u32) -> (u32, u32) {
        (self.index.wrapping_mul(count).wrapping_add(index), self.seed)
    }
}

/// A point of the first two dimensions of the Sobol sequence, shuffled and Owen-scrambled by
/// hashing (Burley, "Practical Hash-based Owen Scrambling", 2020). The 2^k points from a multiple
/// of 2^k on have one point in each cell of every division into 2^k equal rectangles.
pub(crate) fn sobol(index: u32, seed: u32) -> DVec2 {
    let (across, down) = sobol_digits(index, seed);
    DVec2::new(f64::from(across), f64::from(down)) / (f64::from(u32::MAX) + 1.0)
}

/// The 32 binary digits of both coordinates of [`sobol`]. Without branches, so that a loop over it becomes lanes.
#[inline(always)]
pub(crate) fn sobol_digits(index: u32, seed: u32) -> (u32, u32) {
    let index = scramble(index, seed);
    let across = scramble(index.reverse_bits(), hash(seed ^ 0x68bc_21eb));
    let down = scramble(second_dimension(index), hash(seed ^ 0x02e5_be93));
    (across, down)
}

/// The second dimension of the Sobol sequence: the XOR of the direction numbers of the bits of the
/// index. The direction numbers are the reversed rows of Pascal's triangle modulo 2, so the sum takes five steps of shifts.
#[inline(always)]
fn second_dimension(index: u32) -> u32 {
    let mut x = index.reverse_bits();
    x ^= (x & 0x5555_5555) << 1;
    x ^= (x & 0x3333_3333) << 2;
    x ^= (x & 0x0f0f_0f0f) << 4;
    x ^= (x & 0x00ff_00ff) << 8;
    x ^ (x << 16)
}

/// Owen scrambling of binary digits: whether a digit is flipped depends on the digits before it and
/// the seed. Uses the hash of Laine and Karras on the reversed digits.
#[inline(always)]
fn scramble(digits: u32, seed: u32) -> u32 {
    let mut x = digits.reverse_bits();
    x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// A hash: every bit of the result depends on all bits of the argument.
#[inline(always)]
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Maps the unit square uniformly to the unit disc. Concentric squares become circles (Shirley and
/// Chiu 1997).
pub(crate) fn disc(square: DVec2) -> DVec2 {
    let DVec2 { x, y } = 2.0 * square - 1.0;
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, turn) = if x.abs() > y.abs() { (x, 0.125 * y / x) } else { (y, 0.25 - 0.125 * x / y) };
    radius * DVec2::from_angle(TAU * turn)
}

/// Maps the unit square to unit directions around a normal with density cos / pi.
pub(crate) fn cosine_direction(square: DVec2, normal: DVec3) -> DVec3 {
    let on_disc = disc(square);
    let (across, down) = normal.any_orthonormal_pair();
    let up = (1.0 - on_disc.length_squared()).max(0.0).sqrt();
    (on_disc.x * across + on_disc.y * down + up * normal).normalize()
}

/// Maps the unit square to unit directions around an axis with density proportional to
/// cos^`exponent`.
pub(crate) fn power_cosine_direction(square: DVec2, axis: DVec3, exponent: f64) -> DVec3 {
    let cos = (1.0 - square.x).powf(1.0 / (exponent + 1.0));
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (across, down) = axis.any_orthonormal_pair();
    let around = DVec2::from_angle(TAU * square.y);
    (sin * (around.x * across + around.y * down) + cos * axis).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_of_a_power_of_two_fills_all_cells() {
        for (seed, first) in [(1, 0), (77, 64), (0xdead_beef, 1024)] {
            for rows in 0..=6 {
                let (rows, columns) = (1 << rows, 64 >> rows);
                let mut cells: Vec<u32> = (first..first + 64)
                    .map(|i| {
                        let point = sobol(i, seed);
                        (point.y * f64::from(rows)) as u32 * columns + (point.x * f64::from(columns)) as u32
                    })
                    .collect();
                cells.sort_unstable();
                assert!(cells.iter().copied().eq(0..64), "{rows} rows, seed {seed}");
            }
        }
    }

    #[test]
    fn pixels_and_branches_draw_different_numbers() {
        let key = SampleKey::new((3, 4), 5);
        let points =
            [key, key.branch(0), key.branch(1), SampleKey::new((4, 3), 5), SampleKey::new((3, 4), 6)]
                .map(|key| key.point(0, 1));
        for (i, a) in points.iter().enumerate() {
            assert!(a.cmpge(DVec2::ZERO).all() && a.cmplt(DVec2::ONE).all());
            assert!(points[..i].iter().all(|b| a != b));
        }
    }

    #[test]
    fn directions_have_the_means_of_their_densities() {
        let normal = DVec3::new(0.36, -0.48, 0.8);
        let count = 4096;
        let mean = |direction: &dyn Fn(DVec2) -> DVec3| {
            let sum: DVec3 = (0..count).map(|i| direction(sobol(i, 9))).sum();
            (
                sum / f64::from(count) - normal.dot(sum) / f64::from(count) * normal,
                normal.dot(sum) / f64::from(count),
            )
        };
        // The mean cosine is 2/3 for cos, (n + 1) / (n + 2) for cos^n.
        for (expected, (across, along)) in [
            (2.0 / 3.0, mean(&|square| cosine_direction(square, normal))),
            (21.0 / 22.0, mean(&|square| power_cosine_direction(square, normal, 20.0))),
        ] {
            assert!(across.length() < 2e-3 && (along - expected).abs() < 1e-3, "{across} {along} {expected}");
        }
        let squares = (0..count).map(|i| disc(sobol(i, 3)).length_squared());
        assert!((squares.sum::<f64>() / f64::from(count) - 0.5).abs() < 1e-3);
    }
}
