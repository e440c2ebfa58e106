//! Samples of a light from many points at once, in f32 lanes: the directions and the reflected light of each.

use superegg_simd::{Column, Lanes, Simd, WithSimd};

use crate::camera::sobol;
use crate::shade::lane_math::{blinn_power, dot, inverse_length};

/// The samples of one block.
pub(crate) const BLOCK: usize = 16;

type Numbers = Column<f32, BLOCK>;

/// Samples of one light. Each belongs to a surface point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightBlock {
    /// The seeds and indices of the random points on the light.
    pub(crate) seed: [u32; BLOCK],
    pub(crate) index: [u32; BLOCK],
    /// From the surface point to the centre of the light.
    pub(crate) to_centre: [Numbers; 3],
    /// The unit normal on the side of the ray.
    pub(crate) normal: [Numbers; 3],
    /// The unit vector to the eye.
    pub(crate) to_eye: [Numbers; 3],
    /// The exponent of the highlight.
    pub(crate) exponent: Numbers,
    /// The result: from the centre of the light to the sample.
    pub(crate) offset: [Numbers; 3],
    /// The result: the cosine of the angle of incidence; 0 where the point faces away from the sample.
    pub(crate) cos: Numbers,
    /// The result: the highlight; 0 where the point faces away.
    pub(crate) highlight: Numbers,
}

impl LightBlock {
    /// A block without samples: unused ones have a cosine of 0.
    pub(crate) const EMPTY: Self = Self {
        seed: [0; BLOCK],
        index: [0; BLOCK],
        to_centre: [Column([1.0; BLOCK]); 3],
        normal: [Column([0.0; BLOCK]); 3],
        to_eye: [Column([0.0; BLOCK]); 3],
        exponent: Column([0.0; BLOCK]),
        offset: [Column([0.0; BLOCK]); 3],
        cos: Column([0.0; BLOCK]),
        highlight: Column([0.0; BLOCK]),
    };

    /// Resets a sample to that of an empty block.
    pub(crate) fn reset(&mut self, sample: usize) {
        self.normal.iter_mut().for_each(|column| column.0[sample] = 0.0);
    }
}

/// Fills in the results of blocks.
pub(crate) struct SampleLight<'a> {
    pub(crate) blocks: &'a mut [LightBlock],
    /// The radius of the light; 0 for a light without area, whose samples are its centre.
    pub(crate) radius: f32,
    /// Whether any point has a highlight.
    pub(crate) has_highlights: bool,
}

impl WithSimd for SampleLight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for block in self.blocks {
            if self.radius > 0.0 {
                place_on_disc(simd, block, self.radius);
            } else {
                block.offset = LightBlock::EMPTY.offset;
            }
            reflect(simd, block, self.has_highlights);
        }
    }
}

/// The random points of seeds and indices, in [-1, 1)^2.
#[inline(always)]
pub(crate) fn square_of(index: &[u32; BLOCK], seed: &[u32; BLOCK]) -> ([f32; BLOCK], [f32; BLOCK]) {
    let (mut x, mut y) = ([0.0; BLOCK], [0.0; BLOCK]);
    for i in 0..BLOCK {
        let (across, down) = sobol::sobol_digits(index[i], seed[i]);
        // An i32 converts in one instruction.
        x[i] = (across >> 1) as i32 as f32 * (2.0 / 2_147_483_648.0) - 1.0;
        y[i] = (down >> 1) as i32 as f32 * (2.0 / 2_147_483_648.0) - 1.0;
    }
    (x, y)
}

/// A point of the unit disc.
pub(crate) struct DiscPoint<S: Simd> {
    pub(crate) x: Lanes<S>,
    pub(crate) y: Lanes<S>,
    /// The height of the unit hemisphere above the point.
    pub(crate) height: Lanes<S>,
}

/// Maps [-1, 1]^2 to the unit disc as [`sobol::disc`]: concentric squares become circles.
#[inline(always)]
pub(crate) fn concentric_disc<S: Simd>(simd: S, x: Lanes<S>, y: Lanes<S>) -> DiscPoint<S> {
    let (one, tiny) = (Lanes::<S>::splat(simd, 1.0), Lanes::splat(simd, f32::MIN_POSITIVE));
    let wide = y.abs().lt(x.abs());
    let (long, short) = (wide.select(x, y), wide.select(y, x));
    let ratio = short / long.abs().max(tiny).with_sign_of(long);
    let (sin, cos) = sin_cos_quarter(simd, ratio);
    let (along, beside) = (long * cos, long * sin);
    let radius = long.abs();
    DiscPoint {
        x: wide.select(along, beside),
        y: wide.select(beside, along),
        height: ((one - radius) * (one + radius)).sqrt(),
    }
}

/// An orthonormal basis around a unit vector (Duff et al. 2017).
#[inline(always)]
pub(crate) fn across_and_down<S: Simd>(simd: S, [x, y, z]: [Lanes<S>; 3]) -> ([Lanes<S>; 3], [Lanes<S>; 3]) {
    let one = Lanes::<S>::splat(simd, 1.0);
    let sign = z.with_unit_sign();
    let a = -(one / (sign + z));
    let b = x * y * a;
    ([(sign * x * x).mul_add(a, one), sign * b, -(sign * x)], [b, (y * y).mul_add(a, sign), -y])
}

/// Draws the samples on the discs that the light presents to the points.
#[inline(always)]
fn place_on_disc<S: Simd>(simd: S, block: &mut LightBlock, radius: f32) {
    let (x, y) = square_of(&block.index, &block.seed);
    let radius = Lanes::<S>::splat(simd, radius);
    for i in 0..BLOCK / S::F32_LANES {
        let disc = concentric_disc(simd, Lanes::load(simd, &x, i), Lanes::load(simd, &y, i));
        let centre = block.to_centre.each_ref().map(|column| -> Lanes<S> { column.load(simd, i) });
        let scale = inverse_length(centre);
        let (across, down) = across_and_down(simd, [centre[0] * scale, centre[1] * scale, centre[2] * scale]);
        for axis in 0..3 {
            let offset = radius * (disc.x * across[axis] + disc.y * down[axis]);
            block.offset[axis].store(i, offset);
        }
    }
}

/// Computes the reflected light of all samples.
#[inline(always)]
fn reflect<S: Simd>(simd: S, block: &mut LightBlock, has_highlights: bool) {
    let splat = |x: f32| Lanes::<S>::splat(simd, x);
    let zero = splat(0.0);
    for i in 0..BLOCK / S::F32_LANES {
        let triple =
            |columns: &[Numbers; 3]| columns.each_ref().map(|column| -> Lanes<S> { column.load(simd, i) });
        let (centre, offset) = (triple(&block.to_centre), triple(&block.offset));
        let (normal, to_eye) = (triple(&block.normal), triple(&block.to_eye));
        let to_light = [centre[0] + offset[0], centre[1] + offset[1], centre[2] + offset[2]];
        let scale = inverse_length(to_light);
        let to_light = [to_light[0] * scale, to_light[1] * scale, to_light[2] * scale];
        let cos = dot(normal, to_light);
        let faces_light = zero.lt(cos);
        block.cos.store(i, faces_light.select(cos, zero));
        if !has_highlights {
            continue;
        }
        let half = [to_light[0] + to_eye[0], to_light[1] + to_eye[1], to_light[2] + to_eye[2]];
        let power = blinn_power(normal, half, block.exponent.load(simd, i));
        block.highlight.store(i, faces_light.select(power, zero));
    }
}

/// sin and cos of pi/4 times a number in [-1, 1], to 1e-6 (Taylor series).
#[inline(always)]
fn sin_cos_quarter<S: Simd>(simd: S, ratio: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let splat = |x: f32| Lanes::<S>::splat(simd, x);
    let angle = ratio * splat(std::f32::consts::FRAC_PI_4);
    let square = angle * angle;
    let sin = square.mul_add(splat(-1.0 / 5040.0), splat(1.0 / 120.0));
    let sin = square.mul_add(sin, splat(-1.0 / 6.0));
    let sin = (square * angle).mul_add(sin, angle);
    let cos = square.mul_add(splat(1.0 / 40320.0), splat(-1.0 / 720.0));
    let cos = square.mul_add(cos, splat(1.0 / 24.0));
    let cos = square.mul_add(cos, splat(-0.5));
    (sin, square.mul_add(cos, splat(1.0)))
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;
    use superegg_geom::glam::{DVec2, DVec3};
    use superegg_simd::{Arch, Scalar};

    use super::*;
    use crate::camera::sobol::{SampleKey, disc};

    #[test]
    fn samples_are_those_of_f64() {
        let mut random = SplitMix::new(9);
        let mut vector = || DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
        for case in 0..200u32 {
            let (radius, exponent) = (0.1 + f64::from(case % 5), f64::from(case % 7) * 30.0);
            let key = SampleKey::new((case, 7 * case), case).branch(3);
            let mut block = LightBlock::EMPTY;
            let points: Vec<[DVec3; 3]> = (0..BLOCK as u32)
                .map(|i| {
                    let at = i as usize;
                    let (centre, normal, eye) = (10.0 * vector(), vector().normalize(), vector().normalize());
                    (block.index[at], block.seed[at]) = key.index_and_seed(i, 16);
                    for axis in 0..3 {
                        block.to_centre[axis].0[at] = centre[axis] as f32;
                        block.normal[axis].0[at] = normal[axis] as f32;
                        block.to_eye[axis].0[at] = eye[axis] as f32;
                    }
                    block.exponent.0[at] = exponent as f32;
                    [centre, normal, eye]
                })
                .collect();
            let mut scalar = [block];
            let mut lanes = [block];
            let sample = |blocks: &mut [LightBlock], in_lanes: bool| {
                let kernel = SampleLight { blocks, radius: radius as f32, has_highlights: true };
                if in_lanes { Arch::new().dispatch(kernel) } else { kernel.with_simd(Scalar) }
            };
            sample(&mut lanes, true);
            sample(&mut scalar, false);
            for block in [&lanes[0], &scalar[0]] {
                for (i, [centre, normal, eye]) in points.iter().enumerate() {
                    let DVec2 { x, y } = radius * disc(key.point(i as u32, 16));
                    let (across, down) = centre.normalize().any_orthonormal_pair();
                    let to_light = (centre + x * across + y * down).normalize();
                    let offset = DVec3::from_array(block.offset.map(|column| f64::from(column.0[i])));
                    assert!((offset - (x * across + y * down)).length() < 1e-5 * radius, "{case} {i}");
                    let cos = normal.dot(to_light).max(0.0);
                    assert!((f64::from(block.cos.0[i]) - cos).abs() < 1e-5, "{case} {i}");
                    let half = normal.dot((to_light + *eye).normalize()).max(0.0).powf(exponent);
                    if cos > 1e-4 {
                        assert!((f64::from(block.highlight.0[i]) - half).abs() < 1e-3, "{case} {i}");
                    } else if cos == 0.0 {
                        assert!(block.highlight.0[i] < 1e-4 || block.cos.0[i] > 0.0);
                    }
                }
            }
        }
    }
}
