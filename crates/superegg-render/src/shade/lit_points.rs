//! The light of one source after the other at many points, before shadows, in lanes.

use superegg_geom::glam::DVec3;
use superegg_scene::Light;
use superegg_simd::Arch;

use crate::camera::sobol::SampleKey;
use crate::shade::lane_math::MOST_EXPONENT;
use crate::shade::light_kernel::{BLOCK, LightBlock, SampleLight};
use crate::shade::light_sample::LIGHTS;
use crate::shade::point::SurfacePoint;
use crate::shade::reach::{F32_RANGE, LANES, PointBlock, Reach, ReachKernel};

/// A point as samples of a light need it.
#[derive(Clone, Copy, Debug)]
struct ListedPoint {
    /// The index of the point.
    point: usize,
    key: SampleKey,
    /// The unit normal on the side of the ray.
    normal: [f32; 3],
    /// The unit vector to the eye.
    to_eye: [f32; 3],
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

/// Points, those of them that a light may reach, and its samples.
#[derive(Default)]
pub(crate) struct LitPoints {
    points: Vec<ListedPoint>,
    blocks: Vec<PointBlock>,
    /// The positions in `points` of those that the last light may reach.
    lit: Vec<usize>,
    samples: Vec<LightBlock>,
    /// The samples of each point.
    count: usize,
}

impl LitPoints {
    /// Whether f32 holds the light.
    pub(crate) fn fit(light: &Light) -> bool {
        light.radius == 0.0 || F32_RANGE.contains(&light.radius)
    }

    /// Removes all points.
    pub(crate) fn clear(&mut self) {
        self.points.clear();
    }

    /// Adds a point.
    pub(crate) fn add(&mut self, index: usize, point: &SurfacePoint<'_>) {
        let lane = self.points.len() % LANES;
        let block = self.points.len() / LANES;
        if self.blocks.len() == block {
            self.blocks.push(PointBlock::default());
        }
        let SurfacePoint { material, weights, state, .. } = point;
        let normal = point.facing_normal();
        let diffuse = state.weight * (weights.local * material.diffuse) * point.albedo;
        let specular = state.weight * material.specular;
        let exponent = material.highlight_exponent();
        let fits = specular == DVec3::ZERO || (0.0..MOST_EXPONENT).contains(&exponent);
        self.blocks[block].set(lane, [point.position, normal, diffuse, specular], fits);
        self.points.push(ListedPoint {
            point: index,
            key: state.key,
            normal: normal.as_vec3().to_array(),
            to_eye: point.to_eye.as_vec3().to_array(),
            exponent: exponent as f32,
        });
    }

    /// Finds the points that one of `count` samples of the light may reach. Those whose numbers f32 does not hold are given to
    /// `beyond` instead, by their indices.
    pub(crate) fn find(&mut self, light: &Light, count: u32, mut beyond: impl FnMut(usize)) {
        self.lit.clear();
        self.count = count as usize;
        let blocks = &mut self.blocks[..self.points.len().div_ceil(LANES)];
        let Some(kernel) = ReachKernel::new(blocks, light, count) else { return };
        Arch::new().dispatch(kernel);
        for (at, listed) in self.points.iter().enumerate() {
            match self.blocks[at / LANES].reach[at % LANES] {
                Reach::Dark => {}
                Reach::Lit => self.lit.push(at),
                Reach::BeyondF32 => beyond(listed.point),
            }
        }
    }

    /// The points that the light may reach, by their indices.
    pub(crate) fn lit(&self) -> impl Iterator<Item = usize> {
        self.lit.iter().map(|&at| self.points[at].point)
    }

    /// Draws the samples of the light for each point that it may reach.
    pub(crate) fn sample(&mut self, (light_index, light): (u32, &Light)) {
        self.fill_blocks((light_index, light));
        let has_highlights = self.lit.iter().any(|&at| self.blocks[at / LANES].has_highlight(at % LANES));
        let (blocks, radius) = (&mut self.samples[..], light.radius as f32);
        Arch::new().dispatch(SampleLight { blocks, radius, has_highlights });
    }

    fn fill_blocks(&mut self, (light_index, light): (u32, &Light)) {
        let samples = self.lit.len() * self.count;
        self.samples.resize(samples.div_ceil(BLOCK), LightBlock::EMPTY);
        let mut at = 0;
        for &lit in &self.lit {
            let ListedPoint { key, normal, to_eye, exponent, .. } = self.points[lit];
            let key = key.branch(LIGHTS + light_index);
            let to_centre =
                self.blocks[lit / LANES].to_centre.each_ref().map(|column| column[lit % LANES] as f32);
            for sample in 0..self.count {
                let (block, lane) = (&mut self.samples[at / BLOCK], at % BLOCK);
                if light.radius > 0.0 {
                    (block.index[lane], block.seed[lane]) =
                        key.index_and_seed(sample as u32, self.count as u32);
                }
                for axis in 0..3 {
                    block.to_centre[axis].0[lane] = to_centre[axis];
                    block.normal[axis].0[lane] = normal[axis];
                    block.to_eye[axis].0[lane] = to_eye[axis];
                }
                block.exponent.0[lane] = exponent;
                at += 1;
            }
        }
        for unused in at..self.samples.len() * BLOCK {
            self.samples[unused / BLOCK].reset(unused % BLOCK);
        }
    }

    /// Lists the samples with more light than `least`, in the order of the points.
    pub(crate) fn list_samples(&self, least: f64, samples: &mut Vec<SampledLight>) {
        samples.clear();
        samples.reserve(self.lit.len() * self.count);
        let mut at = 0;
        for &lit in &self.lit {
            let (point, block) = (self.points[lit].point, &self.blocks[lit / LANES]);
            let [diffuse, specular, to_centre] = block.lit(lit % LANES).map(DVec3::from_array);
            for _ in 0..self.count {
                let (block, lane) = (&self.samples[at / BLOCK], at % BLOCK);
                at += 1;
                let (cos, highlight) = (f64::from(block.cos.0[lane]), f64::from(block.highlight.0[lane]));
                let color = diffuse * cos + specular * highlight;
                if color.max_element() > least {
                    let [x, y, z] = block.offset.each_ref().map(|column| f64::from(column.0[lane]));
                    samples.push(SampledLight { point, to_light: to_centre + DVec3::new(x, y, z), color });
                }
            }
        }
    }
}
