//! Direct light of groups of neighbouring points.
//!
//! The samples of a light from the points of a group are drawn and shaded in lanes. All their shadow rays lie in one shaft,
//! for which one search of the scene finds the shapes that may occlude them: usually none, and all samples are unoccluded.
//! Otherwise the rays are tested against these shapes alone.

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray};
use superegg_scene::{Light, Picture};
use superegg_simd::Arch;
use superegg_trace::shaft::{Occluder, Shaft, ShaftRays, ShaftStart};

use crate::shade::context::{RenderContext, transmits};
use crate::shade::lane_math::MOST_EXPONENT;
use crate::shade::light_kernel::{BLOCK, LightBlock, SampleLight};
use crate::shade::light_sample::{LIGHTS, LightSample, toward, unoccluded_light};
use crate::shade::point::{SurfaceOwner, SurfacePoint};
use crate::shade::point_groups::PointGroups;
use crate::shade::shadow_batch::ShadowBatch;
use crate::shade::state::ShadingState;

/// Shadow rays that are left to be traced through the scene.
#[derive(Default)]
pub(crate) struct RemainingRays {
    /// Rays of which nothing is known.
    pub(crate) single: ShadowBatch,
    /// Rays that only transparent shapes occlude.
    pub(crate) dimmed: ShadowBatch,
}

/// Adds direct light to surface points, with memory for one group after the other.
pub(crate) struct GroupedLight<'a> {
    context: RenderContext<'a>,
    /// Whether the points are first hits, which get several samples of each area light.
    is_first: bool,
    arch: Arch,
    groups: PointGroups,
    blocks: Vec<LightBlock>,
    lit: Vec<LitPoint>,
    occluders: Vec<Occluder>,
    rays: ShaftRays,
    samples: Vec<Sample>,
    /// A shadow ray that can add no more light than this is not traced.
    least_light: f64,
    /// The rays to lights at a position, and to suns.
    remaining: [RemainingRays; 2],
}

/// A point that a light may reach.
#[derive(Clone, Copy, Debug)]
struct LitPoint {
    /// The index of the point.
    point: usize,
    /// From the point to the centre of the light, which is a unit vector for a sun.
    to_centre: DVec3,
    /// The light of each sample is `diffuse` times a cosine, plus `specular` times a highlight.
    diffuse: DVec3,
    specular: DVec3,
}

/// A sample of a light.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The index of the point.
    point: usize,
    /// From the point to the sample.
    to_light: DVec3,
    /// Its light if it is unoccluded.
    color: DVec3,
}

/// The light below which a sample does not matter: a small part of the least weight of a ray, as the exposure shows it.
fn least_light(picture: &Picture) -> f64 {
    1e-3 * picture.least_weight * (-picture.exposure.max(0.0)).exp2()
}

/// Coordinates and lengths outside of this range are left to f64.
const F32_RANGE: std::ops::Range<f64> = 1e-12..1e12;

/// Samples are placed in f32: they lie in a disc that is larger by this factor.
const MARGIN: f64 = 1.001;

impl<'a> GroupedLight<'a> {
    /// For all points that are given to [`GroupedLight::add_light`].
    pub(crate) fn new(context: RenderContext<'a>, points: &[SurfacePoint<'_>], is_first: bool) -> Self {
        Self {
            context,
            is_first,
            arch: Arch::new(),
            groups: PointGroups::of(points, |point| is_groupable(&context, point)),
            blocks: Vec::new(),
            lit: Vec::new(),
            occluders: Vec::new(),
            rays: ShaftRays::default(),
            samples: Vec::new(),
            least_light: least_light(context.picture),
            remaining: Default::default(),
        }
    }

    /// The rays that are left, with the t of their ends.
    pub(crate) fn into_rays(self) -> impl Iterator<Item = (f64, RemainingRays)> {
        [1.0, f64::INFINITY].into_iter().zip(self.remaining)
    }

    /// Adds the light of one source to the points given to [`GroupedLight::new`].
    pub(crate) fn add_light(
        &mut self,
        points: &[SurfacePoint<'_>],
        (index, light): (u32, &Light),
        shading: &mut ShadingState<'_, '_>,
    ) {
        for i in 0..self.groups.single().len() {
            self.sample_single(&points[self.groups.single()[i]], (index, light));
        }
        for group in 0..self.groups.len() {
            self.light_group(group, points, (index, light), shading);
        }
    }

    /// The number of samples of a light.
    fn sample_count(&self, light: &Light) -> u32 {
        if light.radius > 0.0 && self.is_first { self.context.picture.light_rays.max(1) } else { 1 }
    }

    /// Adds the shadow rays from a point to a light: one, or several for an area light.
    fn sample_single(&mut self, point: &SurfacePoint<'_>, (index, light): (u32, &Light)) {
        let Some(centre) = LightSample::to_centre(light, point.position) else { return };
        let (context, count, end) = (self.context, self.sample_count(light), end_of(light));
        let key = point.state.key.branch(LIGHTS + index);
        for i in 0..count {
            let sample =
                if light.radius > 0.0 { centre.to_disc(light.radius, key, i, count) } else { centre };
            let Some(color) = unoccluded_light(point, &sample) else { continue };
            let ray = toward(point, sample.direction);
            let past_floor = context.transmittance_past_floor(&ray.ray, point.is_on_floor(), end);
            let color = past_floor * point.state.weight * color / f64::from(count);
            // NaN is kept.
            if color.max_element() <= self.least_light {
                continue;
            }
            let RemainingRays { single, dimmed } = &mut self.remaining[kind_of(light)];
            // A ray that goes through its own shape meets at least that.
            let goes_through = context.has_transmission && point.leaving;
            if goes_through { dimmed.push(point, ray, color) } else { single.push(point, ray, color) }
        }
    }

    fn light_group(
        &mut self,
        group: usize,
        points: &[SurfacePoint<'_>],
        (index, light): (u32, &Light),
        shading: &mut ShadingState<'_, '_>,
    ) {
        let count = self.sample_count(light);
        if !(self.fits_lanes(light) && self.is_clear_of_floor(group, points, light)) {
            for i in 0..self.groups.get(group).len() {
                self.sample_single(&points[self.groups.get(group)[i]], (index, light));
            }
            return;
        }
        self.find_lit(group, points, (index, light), count);
        if self.lit.is_empty() {
            return;
        }
        let has_highlights = self.lit.iter().any(|lit| lit.specular != DVec3::ZERO);
        self.fill_blocks(points, index, count);
        let (blocks, radius) = (&mut self.blocks[..], light.radius as f32);
        self.arch.dispatch(SampleLight { blocks, radius, has_highlights });
        self.list_samples(count);
        let Some(first) = self.samples.first().map(|sample| &points[sample.point]) else { return };
        shading.stats.rays.shadow += self.samples.len() as u64;
        if first.leaving {
            self.queue_dimmed(points, light);
            return;
        }
        let own = match &first.owner {
            SurfaceOwner::Instance(path) => Some(&**path),
            SurfaceOwner::Floor => None,
        };
        let (shaft, width) = self.shaft(points, light);
        let start = ShaftStart { own, width };
        if !self.context.scene.find_occluders(&shaft, start, &mut self.occluders) {
            self.queue_single(points, light);
        } else if self.occluders.is_empty() {
            for sample in &self.samples {
                shading.colors[points[sample.point].state.pixel] += sample.color;
            }
        } else {
            self.add_past_occluders(points, light, shading);
        }
    }

    /// Whether f32 holds the light.
    fn fits_lanes(&self, light: &Light) -> bool {
        light.radius == 0.0 || F32_RANGE.contains(&light.radius)
    }

    /// Whether no shadow ray of the group crosses the floor.
    fn is_clear_of_floor(&self, group: usize, points: &[SurfacePoint<'_>], light: &Light) -> bool {
        let Some(ground) = self.context.ground else { return true };
        if self.groups.get(group).iter().all(|&i| points[i].is_on_floor()) {
            return true;
        }
        let height = |point: DVec3| ground.height_of(point);
        let least =
            self.groups.get(group).iter().map(|&i| height(points[i].position)).fold(f64::INFINITY, f64::min);
        let of_light = match light.position() {
            Some(position) => height(position) - MARGIN * light.radius,
            None => light
                .direction_from(DVec3::ZERO)
                .map_or(-1.0, |direction| direction.dot(ground.up()) - MARGIN * light.radius),
        };
        least > 0.0 && of_light > 0.0
    }

    /// Lists the points of a group that samples of the light may reach. Those that f32 does not hold are sampled one by one.
    fn find_lit(
        &mut self,
        group: usize,
        points: &[SurfacePoint<'_>],
        (light_index, light): (u32, &Light),
        count: u32,
    ) {
        self.lit.clear();
        for i in 0..self.groups.get(group).len() {
            let index = self.groups.get(group)[i];
            let point = &points[index];
            let Some(LightSample { direction, color, .. }) = LightSample::to_centre(light, point.position)
            else {
                continue;
            };
            let SurfacePoint { material, weights, .. } = point;
            let share = point.state.weight * color / f64::from(count);
            let diffuse = share * weights.local * material.diffuse * point.albedo;
            let specular = share * material.specular;
            let reach = point.facing_normal().dot(direction) + MARGIN * light.radius;
            if reach <= 0.0 || (diffuse == DVec3::ZERO && specular == DVec3::ZERO) {
                continue;
            }
            let has_power =
                specular == DVec3::ZERO || (0.0..MOST_EXPONENT).contains(&material.highlight_exponent());
            if has_power && F32_RANGE.contains(&direction.abs().max_element()) {
                self.lit.push(LitPoint { point: index, to_centre: direction, diffuse, specular });
            } else {
                self.sample_single(point, (light_index, light));
            }
        }
    }

    /// Fills the blocks with `count` samples for each lit point.
    fn fill_blocks(&mut self, points: &[SurfacePoint<'_>], light_index: u32, count: u32) {
        let samples = self.lit.len() * count as usize;
        self.blocks.resize(samples.div_ceil(BLOCK), LightBlock::EMPTY);
        let mut at = 0;
        for lit in &self.lit {
            let point = &points[lit.point];
            let key = point.state.key.branch(LIGHTS + light_index);
            let (to_centre, normal) = (lit.to_centre.as_vec3(), point.facing_normal().as_vec3());
            let to_eye = point.to_eye.as_vec3();
            let exponent = point.material.highlight_exponent() as f32;
            for sample in 0..count {
                let (block, lane) = (&mut self.blocks[at / BLOCK], at % BLOCK);
                (block.index[lane], block.seed[lane]) = key.index_and_seed(sample, count);
                for axis in 0..3 {
                    block.to_centre[axis].0[lane] = to_centre[axis];
                    block.normal[axis].0[lane] = normal[axis];
                    block.to_eye[axis].0[lane] = to_eye[axis];
                }
                block.exponent.0[lane] = exponent;
                at += 1;
            }
        }
        for unused in at..self.blocks.len() * BLOCK {
            self.blocks[unused / BLOCK].reset(unused % BLOCK);
        }
    }

    /// The shaft of all shadow rays of the lit points, and the largest width of one.
    fn shaft(&self, points: &[SurfacePoint<'_>], light: &Light) -> (Shaft, f64) {
        let none = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let (mut origins, mut width) = (none, 0.0f64);
        for lit in &self.lit {
            let point = &points[lit.point];
            origins = origins.union(&Aabb::around(point.position, DVec3::splat(point.position_error)));
            width = width.max(point.footprint.width);
        }
        // Samples are placed in f32.
        let around = |centre: DVec3| Aabb::around(centre, DVec3::splat(MARGIN * light.radius));
        let shaft = match light.position() {
            Some(position) => Shaft::between(&origins, &around(position)),
            None => Shaft::along(&origins, &around(self.lit[0].to_centre)),
        };
        (shaft, width)
    }

    /// Lists the samples that face the light and matter.
    fn list_samples(&mut self, count: u32) {
        let Self { samples, lit, blocks, least_light, .. } = self;
        samples.clear();
        for (number, lit) in lit.iter().enumerate() {
            for at in number * count as usize..(number + 1) * count as usize {
                let (block, lane) = (&blocks[at / BLOCK], at % BLOCK);
                let (cos, highlight) = (f64::from(block.cos.0[lane]), f64::from(block.highlight.0[lane]));
                let color = lit.diffuse * cos + lit.specular * highlight;
                if color.max_element() > *least_light {
                    let offset = DVec3::from_array(block.offset.map(|column| f64::from(column.0[lane])));
                    samples.push(Sample { point: lit.point, to_light: lit.to_centre + offset, color });
                }
            }
        }
    }

    /// Tests the shadow rays against the shapes in their shaft.
    fn add_past_occluders(
        &mut self,
        points: &[SurfacePoint<'_>],
        light: &Light,
        shading: &mut ShadingState<'_, '_>,
    ) {
        let Self { samples, rays, occluders, context, remaining, .. } = self;
        let RemainingRays { dimmed, .. } = &mut remaining[kind_of(light)];
        rays.clear();
        for sample in &*samples {
            let SurfacePoint { position, position_error, .. } = points[sample.point];
            rays.push(&Ray { origin: position, direction: sample.to_light, origin_error: position_error });
        }
        let (scene, end) = (context.scene, end_of(light));
        let is_transparent =
            |occluder: &Occluder| transmits(scene.material_of(scene.primitive(occluder.primitive)));
        occluders.sort_by_key(is_transparent);
        let (opaque, transparent) =
            occluders.split_at(occluders.partition_point(|occluder| !is_transparent(occluder)));
        scene.occlude_rays(opaque, end, rays);
        let after_opaque = if transparent.is_empty() { None } else { Some(rays.open()) };
        scene.occlude_rays(transparent, end, rays);
        for (i, sample) in samples.iter().enumerate() {
            let point = &points[sample.point];
            if rays.is_open(i) {
                shading.colors[point.state.pixel] += sample.color;
            } else if after_opaque.as_ref().is_some_and(|open| open.is_open(i)) {
                dimmed.push(point, toward(point, sample.to_light), sample.color);
            }
        }
    }

    /// Leaves the shadow rays to be traced through the scene.
    fn queue_single(&mut self, points: &[SurfacePoint<'_>], light: &Light) {
        for sample in &self.samples {
            let point = &points[sample.point];
            self.remaining[kind_of(light)].single.push(point, toward(point, sample.to_light), sample.color);
        }
    }

    /// Leaves shadow rays that go through their own shape.
    fn queue_dimmed(&mut self, points: &[SurfacePoint<'_>], light: &Light) {
        for sample in &self.samples {
            let point = &points[sample.point];
            self.remaining[kind_of(light)].dimmed.push(point, toward(point, sample.to_light), sample.color);
        }
    }
}

/// The index of a light's rays in [`GroupedLight::remaining`].
fn kind_of(light: &Light) -> usize {
    usize::from(light.position().is_none())
}

/// The t where the shadow rays to a light end.
fn end_of(light: &Light) -> f64 {
    if light.position().is_some() { 1.0 } else { f64::INFINITY }
}

/// Whether the shadow rays of a point may share a shaft: they leave its surface in clear air, or they go through its shape,
/// which transmits light, and need none.
fn is_groupable(context: &RenderContext<'_>, point: &SurfacePoint<'_>) -> bool {
    let is_clear = point.leaving && context.has_transmission;
    let is_outside = !point.leaving && !point.state.media.absorbs();
    (is_clear || is_outside) && !point.is_proxy() && point.position.is_finite()
}
