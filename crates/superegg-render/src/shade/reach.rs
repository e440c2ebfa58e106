//! The points that a light may reach, and the light that it has there, in f64 lanes.

use superegg_geom::glam::DVec3;
use superegg_scene::{Light, LightKind};
use superegg_simd::{Simd, WithSimd};

/// Coordinates and lengths outside of this range are left to f64.
pub(crate) const F32_RANGE: std::ops::Range<f64> = 1e-12..1e12;

/// Samples are placed in f32: they lie in a disc that is larger by this factor.
pub(crate) const MARGIN: f64 = 1.001;

/// The points of a block.
pub(crate) const LANES: usize = 8;

type Row = [f64; LANES];

/// Whether a light reaches a point. As wide as f64, so that answers are lanes beside the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u64)]
pub(crate) enum Reach {
    /// No sample of the light reaches the point.
    #[default]
    Dark,
    /// One may.
    Lit,
    /// f32 does not hold the numbers of the point.
    BeyondF32,
}

/// Points as columns, with what the last light is to them.
#[derive(Clone, Debug, Default)]
pub(crate) struct PointBlock {
    position: [Row; 3],
    /// The unit normal on the side of the ray.
    normal: [Row; 3],
    /// The light of a sample is its colour times this times a cosine, plus its colour times `specular` times a highlight.
    diffuse: [Row; 3],
    specular: [Row; 3],
    /// 0 where f32 does not hold the exponent of the highlight, and 1 otherwise.
    fits: Row,
    /// The factor of a spot's cone. 1 for other lights.
    cone: Row,
    /// The result: whether the light reaches the point.
    pub(crate) reach: [Reach; LANES],
    /// The result: from the point to the centre of the light, which is a unit vector for a sun.
    pub(crate) to_centre: [Row; 3],
    /// The results: `diffuse` and `specular` times the colour of a sample.
    lit_diffuse: [Row; 3],
    lit_specular: [Row; 3],
}

impl PointBlock {
    /// Sets a point: its position, its unit normal on the side of the ray, and its `diffuse` and `specular`. `fits` states
    /// whether f32 holds the exponent of its highlight.
    #[inline]
    pub(crate) fn set(&mut self, lane: usize, vectors: [DVec3; 4], fits: bool) {
        let Self { position, normal, diffuse, specular, fits: fitting, .. } = self;
        for (columns, vector) in [position, normal, diffuse, specular].into_iter().zip(vectors) {
            for (column, coordinate) in columns.iter_mut().zip(vector.to_array()) {
                column[lane] = coordinate;
            }
        }
        fitting[lane] = f64::from(u8::from(fits));
    }

    /// The factors of a light's cone.
    fn cones(&self, light: &Light) -> Row {
        let LightKind::Spot { .. } = light.kind else { return [1.0; LANES] };
        let position = |lane: usize| self.position.each_ref().map(|column| column[lane]);
        std::array::from_fn(|lane| light.cone_factor(DVec3::from_array(position(lane))))
    }

    /// The diffuse and specular light at a point, before cosines and highlights, and the vector to the centre of the light.
    #[inline(always)]
    pub(crate) fn lit(&self, lane: usize) -> [[f64; 3]; 3] {
        [&self.lit_diffuse, &self.lit_specular, &self.to_centre].map(|columns| {
            let [x, y, z] = columns;
            [x[lane], y[lane], z[lane]]
        })
    }

    /// Whether a point that the light reaches has a highlight.
    pub(crate) fn has_highlight(&self, lane: usize) -> bool {
        self.lit_specular.iter().any(|column| column[lane] != 0.0)
    }
}

/// Finds what a light is to the points of blocks.
pub(crate) struct ReachKernel<'a> {
    blocks: &'a mut [PointBlock],
    /// The position of the light, or the unit vector to a sun.
    centre: [f64; 3],
    /// 1 for a light at a position, 0 for a sun.
    is_near: f64,
    /// The colour of one of its samples.
    color: [f64; 3],
    falloff: f64,
    /// The samples lie within this distance of the centre.
    radius: f64,
}

impl<'a> ReachKernel<'a> {
    /// For a light of `count` samples. `None` for a sun without a direction, which reaches no point.
    pub(crate) fn new(blocks: &'a mut [PointBlock], light: &Light, count: u32) -> Option<Self> {
        let (centre, is_near, falloff) = match light.kind {
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                (position, 1.0, light.falloff)
            }
            LightKind::Sun { .. } => (light.direction_from(DVec3::ZERO)?, 0.0, 0.0),
        };
        for block in &mut *blocks {
            block.cone = block.cones(light);
        }
        let color = (light.color / f64::from(count)).to_array();
        Some(Self {
            blocks,
            centre: centre.to_array(),
            is_near,
            color,
            falloff,
            radius: MARGIN * light.radius,
        })
    }
}

impl WithSimd for ReachKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { blocks, centre, is_near, color: [red, green, blue], falloff, radius } = self;
        for block in blocks {
            let PointBlock { position, normal, diffuse, specular, fits, cone, .. } = &*block;
            let (mut reach, mut to_centre) = ([Reach::Dark; LANES], [[0.0; LANES]; 3]);
            let (mut lit_diffuse, mut lit_specular) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
            // Plain loops, which the compiler vectorises.
            for i in 0..LANES {
                let x = centre[0] - is_near * position[0][i];
                let y = centre[1] - is_near * position[1][i];
                let z = centre[2] - is_near * position[2][i];
                (to_centre[0][i], to_centre[1][i], to_centre[2][i]) = (x, y, z);
                // The square overflows only beyond the range of f32.
                let factor = cone[i] / (1.0 + falloff * (x * x + y * y + z * z));
                let (red, green, blue) = (factor * red, factor * green, factor * blue);
                let depth = x * normal[0][i] + y * normal[1][i] + z * normal[2][i];
                let [d0, d1, d2] = [red * diffuse[0][i], green * diffuse[1][i], blue * diffuse[2][i]];
                let [s0, s1, s2] = [red * specular[0][i], green * specular[1][i], blue * specular[2][i]];
                (lit_diffuse[0][i], lit_diffuse[1][i], lit_diffuse[2][i]) = (d0, d1, d2);
                (lit_specular[0][i], lit_specular[1][i], lit_specular[2][i]) = (s0, s1, s2);
                let largest = larger(larger(x.abs(), y.abs()), z.abs());
                let is_black = larger(larger(d0, d1), d2) == 0.0 && larger(larger(s0, s1), s2) == 0.0;
                // Comparisons are such that numbers that are not finite go to f64, which decides.
                let is_dark = depth + radius <= 0.0 || largest == 0.0 || is_black;
                let is_held = largest > F32_RANGE.start && largest < F32_RANGE.end && fits[i] != 0.0;
                let reached = if is_held { Reach::Lit } else { Reach::BeyondF32 };
                reach[i] = if is_dark { Reach::Dark } else { reached };
            }
            (block.reach, block.to_centre) = (reach, to_centre);
            (block.lit_diffuse, block.lit_specular) = (lit_diffuse, lit_specular);
        }
    }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;
    use superegg_simd::{Arch, Scalar};

    use super::*;
    use crate::shade::light_sample::toward_centre;

    fn vector(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
    }

    fn light(case: u32, random: &mut SplitMix) -> Light {
        let position = 4.0 * vector(random);
        let kind = match case % 3 {
            0 => LightKind::Point { position },
            1 => LightKind::Spot { position, target: vector(random), cone_deg: 70.0, soft: 0.5 },
            _ => LightKind::Sun { direction: position },
        };
        let radius = if case.is_multiple_of(2) { 0.0 } else { random.unit() };
        let falloff = if case.is_multiple_of(5) { 0.0 } else { random.unit() };
        Light { kind, color: vector(random).abs(), falloff, radius }
    }

    /// The light at a point, computed one number at a time. `None` if it does not reach the point.
    fn expected(light: &Light, [position, normal, diffuse, specular]: [DVec3; 4]) -> Option<[DVec3; 3]> {
        let (to_centre, color) = toward_centre(light, position)?;
        let is_lit = normal.dot(to_centre) + MARGIN * light.radius > 0.0;
        is_lit.then_some([color * diffuse / 3.0, color * specular / 3.0, to_centre])
    }

    /// The same blocks serve one light after the other.
    #[test]
    fn lights_reach_what_they_reach_in_f64() {
        let mut random = SplitMix::new(12);
        let (mut reached, mut dark) = (0, 0);
        for _ in 0..100 {
            let points: [[DVec3; 4]; LANES] = std::array::from_fn(|_| {
                let normal = vector(&mut random).normalize();
                [2.0 * vector(&mut random), normal, vector(&mut random).abs(), DVec3::splat(random.unit())]
            });
            let mut blocks = [PointBlock::default(), PointBlock::default()];
            for (lane, &vectors) in points.iter().enumerate() {
                blocks.iter_mut().for_each(|block| block.set(lane, vectors, true));
            }
            for case in 0..9 {
                let light = light(case, &mut random);
                let [lanes, scalar] = &mut blocks;
                Arch::new().dispatch(ReachKernel::new(std::slice::from_mut(lanes), &light, 3).unwrap());
                ReachKernel::new(std::slice::from_mut(scalar), &light, 3).unwrap().with_simd(Scalar);
                for (lane, &vectors) in points.iter().enumerate() {
                    for block in [&*lanes, &*scalar] {
                        let Some(expected) = expected(&light, vectors) else {
                            dark += 1;
                            assert_eq!(block.reach[lane], Reach::Dark, "{light:?} {vectors:?}");
                            continue;
                        };
                        reached += 1;
                        assert_eq!(block.reach[lane], Reach::Lit, "{light:?} {vectors:?}");
                        for (found, expected) in block.lit(lane).into_iter().zip(expected) {
                            let error = (DVec3::from_array(found) - expected).length();
                            assert!(error < 1e-14 * (1.0 + expected.length()), "{light:?} {vectors:?}");
                        }
                    }
                }
            }
        }
        assert!(reached > 4_000 && dark > 4_000, "{reached} {dark}");
    }

    #[test]
    fn numbers_beyond_f32_are_left_to_f64() {
        let light = Light { falloff: 0.0, ..Light::DEFAULT };
        let reach = |position: DVec3, fits: bool| {
            let mut block = PointBlock::default();
            block.set(0, [position, DVec3::Z, DVec3::ONE, DVec3::ZERO], fits);
            Arch::new().dispatch(ReachKernel::new(std::slice::from_mut(&mut block), &light, 1).unwrap());
            block.reach[0]
        };
        let centre = light.position().unwrap();
        assert_eq!(reach(DVec3::ZERO, true), Reach::Lit);
        assert_eq!(reach(DVec3::ZERO, false), Reach::BeyondF32);
        assert_eq!(reach(DVec3::new(0.0, 1e13, 0.0), true), Reach::BeyondF32);
        assert_eq!(reach(DVec3::new(f64::MAX, 0.0, -f64::MAX), true), Reach::BeyondF32);
        assert_eq!(reach(DVec3::new(0.0, 0.0, 9.0), true), Reach::Dark);
        assert_eq!(reach(centre, true), Reach::Dark);
    }
}
