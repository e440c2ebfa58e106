//! The light of one source at many points, before shadows, in f32 lanes.

use superegg_geom::glam::DVec3;
use superegg_scene::Light;
use superegg_simd::Arch;

use crate::shade::lane_math::MOST_EXPONENT;
use crate::shade::light_kernel::{BLOCK, LightBlock, SampleLight};
use crate::shade::light_sample::{LIGHTS, toward_centre};
use crate::shade::point::SurfacePoint;

/// Coordinates and lengths outside of this range are left to f64.
const F32_RANGE: std::ops::Range<f64> = 1e-12..1e12;

/// Samples are placed in f32: they lie in a disc that is larger by this factor.
pub(crate) const MARGIN: f64 = 1.001;

/// A point that a light may reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LitPoint {
    /// The index of the point.
    pub(crate) point: usize,
    /// From the point to the centre of the light, which is a unit vector for a sun.
    pub(crate) to_centre: DVec3,
    /// The light of each sample is `diffuse` times a cosine, plus `specular` times a highlight.
    diffuse: DVec3,
    specular: DVec3,
    /// The exponent of the highlight.
    exponent: f32,
}

/// A sample of a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampledLight {
    /// The index of the point.
    pub(crate) point: usize,
    /// From the point to the sample.
    pub(crate) to_light: DVec3,
    /// Its light if it is unoccluded.
    pub(crate) color: DVec3,
}

/// Whether a light reaches a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// No sample of the light reaches the point.
    Dark,
    /// The point is listed.
    Listed,
    /// f32 does not hold the numbers of the point.
    BeyondF32,
}

/// Points that one light may reach, with its samples.
pub(crate) struct LitPoints {
    arch: Arch,
    lit: Vec<LitPoint>,
    blocks: Vec<LightBlock>,
    /// The samples of each point.
    count: usize,
}

impl LitPoints {
    pub(crate) fn new() -> Self {
        Self { arch: Arch::new(), lit: Vec::new(), blocks: Vec::new(), count: 1 }
    }

    /// Whether f32 holds the light.
    pub(crate) fn fit(light: &Light) -> bool {
        light.radius == 0.0 || F32_RANGE.contains(&light.radius)
    }

    /// Removes all points.
    pub(crate) fn clear(&mut self) {
        self.lit.clear();
    }

    /// The points that are listed.
    pub(crate) fn points(&self) -> &[LitPoint] {
        &self.lit
    }

    /// Lists a point if one of `count` samples of the light may reach it.
    pub(crate) fn add(&mut self, index: usize, point: &SurfacePoint<'_>, light: &Light, count: u32) -> Reach {
        let Some((direction, color)) = toward_centre(light, point.position) else {
            return Reach::Dark;
        };
        let reach = point.facing_normal().dot(direction) + MARGIN * light.radius;
        if reach <= 0.0 {
            return Reach::Dark;
        }
        let SurfacePoint { material, weights, .. } = point;
        let share = point.state.weight * color / f64::from(count);
        let diffuse = share * (weights.local * material.diffuse) * point.albedo;
        let specular = share * material.specular;
        if diffuse == DVec3::ZERO && specular == DVec3::ZERO {
            return Reach::Dark;
        }
        let exponent = material.highlight_exponent();
        let has_power = specular == DVec3::ZERO || (0.0..MOST_EXPONENT).contains(&exponent);
        if !has_power || !F32_RANGE.contains(&direction.abs().max_element()) {
            return Reach::BeyondF32;
        }
        let exponent = exponent as f32;
        self.lit.push(LitPoint { point: index, to_centre: direction, diffuse, specular, exponent });
        Reach::Listed
    }

    /// Draws `count` samples of the light for each listed point.
    pub(crate) fn sample(
        &mut self,
        points: &[SurfacePoint<'_>],
        (light_index, light): (u32, &Light),
        count: u32,
    ) {
        self.count = count as usize;
        let has_highlights = self.lit.iter().any(|lit| lit.specular != DVec3::ZERO);
        self.fill_blocks(points, (light_index, light), count);
        let (blocks, radius) = (&mut self.blocks[..], light.radius as f32);
        self.arch.dispatch(SampleLight { blocks, radius, has_highlights });
    }

    fn fill_blocks(&mut self, points: &[SurfacePoint<'_>], (light_index, light): (u32, &Light), count: u32) {
        let samples = self.lit.len() * count as usize;
        self.blocks.resize(samples.div_ceil(BLOCK), LightBlock::EMPTY);
        let mut at = 0;
        for lit in &self.lit {
            let point = &points[lit.point];
            let key = point.state.key.branch(LIGHTS + light_index);
            let (to_centre, normal) = (lit.to_centre.as_vec3(), point.facing_normal().as_vec3());
            let to_eye = point.to_eye.as_vec3();
            for sample in 0..count {
                let (block, lane) = (&mut self.blocks[at / BLOCK], at % BLOCK);
                if light.radius > 0.0 {
                    (block.index[lane], block.seed[lane]) = key.index_and_seed(sample, count);
                }
                for axis in 0..3 {
                    block.to_centre[axis].0[lane] = to_centre[axis];
                    block.normal[axis].0[lane] = normal[axis];
                    block.to_eye[axis].0[lane] = to_eye[axis];
                }
                block.exponent.0[lane] = lit.exponent;
                at += 1;
            }
        }
        for unused in at..self.blocks.len() * BLOCK {
            self.blocks[unused / BLOCK].reset(unused % BLOCK);
        }
    }

    /// Lists the samples with more light than `least`, in the order of the points.
    pub(crate) fn list_samples(&self, least: f64, samples: &mut Vec<SampledLight>) {
        samples.clear();
        samples.reserve(self.lit.len() * self.count);
        let mut at = 0;
        for lit in &self.lit {
            for _ in 0..self.count {
                let (block, lane) = (&self.blocks[at / BLOCK], at % BLOCK);
                at += 1;
                let (cos, highlight) = (f64::from(block.cos.0[lane]), f64::from(block.highlight.0[lane]));
                let color = lit.diffuse * cos + lit.specular * highlight;
                if color.max_element() > least {
                    let [x, y, z] = block.offset.each_ref().map(|column| f64::from(column.0[lane]));
                    let to_light = lit.to_centre + DVec3::new(x, y, z);
                    samples.push(SampledLight { point: lit.point, to_light, color });
                }
            }
        }
    }
}
