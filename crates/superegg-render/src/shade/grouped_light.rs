//! Direct light of groups of neighbouring points.
//!
//! The samples of a light from the points of a group are drawn and shaded in lanes. All their shadow rays lie in one shaft,
//! for which one search of the scene finds the shapes that may occlude them: usually none, and all samples are unoccluded.
//! Otherwise the rays are tested against these shapes alone.

use std::cell::Cell;
use std::rc::Rc;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray};
use superegg_scene::{Light, Picture};
use superegg_trace::shaft::{IndexGroups, Occluder, Shaft, ShaftRays, ShaftStart};

use crate::shade::clear_shadows::{ClearShadows, Passage};
use crate::shade::context::{RenderContext, transmits};
use crate::shade::light_sample::{LIGHTS, LightSample, toward, unoccluded_light};
use crate::shade::lit_points::{LitPoints, SampledLight};
use crate::shade::point::{SurfaceOwner, SurfacePoint};
use crate::shade::reach::MARGIN;
use crate::shade::shadow_batch::ShadowBatch;
use crate::shade::state::ShadingState;

/// The most points of a group. Neighbours in the order of points are neighbours in the picture.
const MOST_POINTS: usize = 32;

/// The search for the shapes in a shaft costs more than fewer rays through the scene.
const LEAST_SAMPLES: usize = 5;

/// Searches that fail are followed by less than two to the power of this many groups without one.
const MOST_DOUBLINGS: u32 = 4;

/// The last searches for occluders. Where some fail, because shapes are many, those of the next groups are likely to fail too.
#[derive(Clone, Copy, Debug, Default)]
struct SearchHistory {
    /// The failures since the last success.
    failures: u32,
    /// The groups that are not searched.
    to_skip: u32,
}

impl SearchHistory {
    /// Whether to search for the next group.
    fn allows_next(&mut self) -> bool {
        let is_allowed = self.to_skip == 0;
        self.to_skip = self.to_skip.saturating_sub(1);
        is_allowed
    }

    /// Takes in the result of a search.
    fn take(&mut self, is_success: bool) {
        self.failures = if is_success { 0 } else { (self.failures + 1).min(MOST_DOUBLINGS) };
        self.to_skip = (1 << self.failures) - 1;
    }
}

/// Shadow rays that are left to be traced through the scene.
#[derive(Default)]
pub(crate) struct RemainingRays {
    /// Rays of which nothing is known.
    pub(crate) single: ShadowBatch,
    /// Rays that only transparent shapes occlude.
    pub(crate) dimmed: ShadowBatch,
}

/// Memory for the light of one group after the other.
#[derive(Default)]
struct Scratch {
    /// The points of the current group.
    lit: LitPoints,
    /// The points of the current group that the current light reaches, but f32 does not hold.
    beyond: Vec<usize>,
    occluders: Vec<Occluder>,
    rays: ShaftRays,
    clear_shadows: ClearShadows,
    samples: Vec<SampledLight>,
    /// By light.
    histories: Vec<SearchHistory>,
    /// The rays to lights at a position, and to suns.
    remaining: [RemainingRays; 2],
}

thread_local! {
    /// The memory of the last points of this thread.
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

/// Adds direct light to surface points.
pub(crate) struct GroupedLight<'a> {
    context: RenderContext<'a>,
    /// Whether the points are first hits, which get several samples of each area light.
    is_first: bool,
    /// A shadow ray that can add no more light than this is not traced.
    least_light: f64,
    scratch: Box<Scratch>,
}

/// The light below which a sample does not matter: a small part of the least weight of a ray, as the exposure shows it.
fn least_light(picture: &Picture) -> f64 {
    1e-3 * picture.least_weight * (-picture.exposure.max(0.0)).exp2()
}

impl<'a> GroupedLight<'a> {
    /// With no light so far.
    pub(crate) fn new(context: RenderContext<'a>, is_first: bool) -> Self {
        let scratch = SCRATCH.take().unwrap_or_default();
        Self { context, is_first, least_light: least_light(context.picture), scratch }
    }

    /// Keeps the memory for the next points.
    pub(crate) fn finish(self) {
        SCRATCH.set(Some(self.scratch));
    }

    /// The rays that are left, with the t of their ends. They must be empty in the end.
    pub(crate) fn remaining(&mut self) -> impl Iterator<Item = (&mut RemainingRays, f64)> {
        self.scratch.remaining.iter_mut().zip([1.0, f64::INFINITY])
    }

    /// Adds the light of some sources to points.
    pub(crate) fn add_light<'l>(
        &mut self,
        points: &[SurfacePoint<'_>],
        lights: &(impl Iterator<Item = (u32, &'l Light)> + Clone),
        shading: &mut ShadingState<'_, '_>,
    ) {
        let surfaces = points.iter().map(|point| surface_of(&self.context, point));
        let groups = IndexGroups::of(surfaces, MOST_POINTS);
        for &index in groups.single() {
            lights.clone().for_each(|light| self.sample_single(&points[index], light));
        }
        self.scratch.histories.clear();
        self.scratch.histories.resize(lights.clone().count(), SearchHistory::default());
        for group in groups.groups() {
            self.scratch.lit.clear();
            group.iter().for_each(|&index| self.scratch.lit.add(index, &points[index]));
            let least_height = self.least_height(group, points);
            for (number, light) in lights.clone().enumerate() {
                if LitPoints::fit(light.1) && self.is_clear_of_floor(least_height, light.1) {
                    self.light_group(points, number, light, shading);
                } else {
                    group.iter().for_each(|&index| self.sample_single(&points[index], light));
                }
            }
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
            let Some(color) = unoccluded_light(&context, point, &sample) else { continue };
            let ray = toward(point, sample.direction);
            let past_floor = context.transmittance_past_floor(&ray.ray, point.is_on_floor(), end);
            let color = past_floor * point.state.weight * color / f64::from(count);
            // NaN is kept.
            if color.max_element() <= self.least_light {
                continue;
            }
            let RemainingRays { single, dimmed } = &mut self.scratch.remaining[kind_of(light)];
            // A ray that goes through its own shape meets at least that.
            let goes_through = context.has_transmission && point.leaving;
            if goes_through { dimmed.push(point, ray, color) } else { single.push(point, ray, color) }
        }
    }

    /// Adds the light of one source, which has this number among all, to the points of the current group.
    fn light_group(
        &mut self,
        points: &[SurfacePoint<'_>],
        number: usize,
        (index, light): (u32, &Light),
        shading: &mut ShadingState<'_, '_>,
    ) {
        let count = self.sample_count(light);
        self.scratch.beyond.clear();
        self.scratch.lit.find(light, count, |point| self.scratch.beyond.push(point));
        for i in 0..self.scratch.beyond.len() {
            self.sample_single(&points[self.scratch.beyond[i]], (index, light));
        }
        self.scratch.lit.sample((index, light));
        self.scratch.lit.list_samples(self.least_light, &mut self.scratch.samples);
        let Some(first) = self.scratch.samples.first().map(|sample| &points[sample.point]) else { return };
        if first.leaving {
            // The rays go through their own shape.
            self.queue(points, light, |rays| &mut rays.dimmed);
            return;
        }
        if self.scratch.samples.len() < LEAST_SAMPLES || !self.scratch.histories[number].allows_next() {
            self.queue(points, light, |rays| &mut rays.single);
            return;
        }
        let own = match &first.owner {
            SurfaceOwner::Instance(path) => Some(&**path),
            SurfaceOwner::Floor => None,
        };
        let (shaft, width) = self.shaft(points, light);
        let start = ShaftStart { own, width };
        let is_found = self.context.scene.find_occluders(&shaft, start, &mut self.scratch.occluders);
        self.scratch.histories[number].take(is_found);
        if !is_found {
            self.queue(points, light, |rays| &mut rays.single);
            return;
        }
        // Rays that are left to others are counted where they are traced.
        shading.stats.rays.shadow += self.scratch.samples.len() as u64;
        if self.scratch.occluders.is_empty() {
            for sample in &self.scratch.samples {
                shading.colors[points[sample.point].state.pixel] += sample.color;
            }
        } else {
            self.add_past_occluders(points, light, shading);
        }
    }

    /// The least height of a point of a group above the floor. `None` without a floor, or if all lie on it.
    fn least_height(&self, group: &[usize], points: &[SurfacePoint<'_>]) -> Option<f64> {
        let ground = self.context.ground?;
        let mut group = group.iter().map(|&index| &points[index]);
        let heights = group.clone().map(|point| ground.height_of(point.position));
        let least = heights.fold(f64::INFINITY, f64::min);
        (!group.all(SurfacePoint::is_on_floor)).then_some(least)
    }

    /// Whether no shadow ray from points of this least height above the floor crosses it.
    fn is_clear_of_floor(&self, least_height: Option<f64>, light: &Light) -> bool {
        let (Some(ground), Some(least)) = (self.context.ground, least_height) else { return true };
        let of_light = match light.position() {
            Some(position) => ground.height_of(position) - MARGIN * light.radius,
            None => light
                .direction_from(DVec3::ZERO)
                .map_or(-1.0, |direction| direction.dot(ground.up()) - MARGIN * light.radius),
        };
        least > 0.0 && of_light > 0.0
    }

    /// The shaft of all shadow rays of the lit points, and the largest width of one.
    fn shaft(&self, points: &[SurfacePoint<'_>], light: &Light) -> (Shaft, f64) {
        let none = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        let (mut origins, mut width) = (none, 0.0f64);
        for point in self.scratch.lit.lit().map(|index| &points[index]) {
            origins = origins.union(&Aabb::around(point.position, DVec3::splat(point.position_error)));
            width = width.max(point.footprint.width);
        }
        // Samples are placed in f32.
        let around = |centre: DVec3| Aabb::around(centre, DVec3::splat(MARGIN * light.radius));
        let shaft = match light.position() {
            Some(position) => Shaft::between(&origins, &around(position)),
            None => Shaft::along(&origins, &around(light.direction_from(DVec3::ZERO).unwrap_or_default())),
        };
        (shaft, width)
    }

    /// Tests the shadow rays against the shapes in their shaft.
    fn add_past_occluders(
        &mut self,
        points: &[SurfacePoint<'_>],
        light: &Light,
        shading: &mut ShadingState<'_, '_>,
    ) {
        let Self { context, scratch, .. } = self;
        let Scratch { samples, rays, occluders, remaining, clear_shadows, .. } = &mut **scratch;
        let RemainingRays { dimmed, .. } = &mut remaining[kind_of(light)];
        rays.clear();
        for sample in &*samples {
            let SurfacePoint { position, position_error, .. } = points[sample.point];
            rays.push(&Ray { origin: position, direction: sample.to_light, origin_error: position_error });
        }
        let (scene, end) = (context.scene, end_of(light));
        let is_transparent =
            |occluder: &Occluder| transmits(scene.material_of(&scene.primitive(occluder.primitive)));
        occluders.sort_by_key(is_transparent);
        let (opaque, transparent) =
            occluders.split_at(occluders.partition_point(|occluder| !is_transparent(occluder)));
        scene.occlude_rays(opaque, end, rays);
        let in_air = samples.iter().all(|sample| points[sample.point].state.media.is_air());
        if !transparent.is_empty() && in_air && clear_shadows.find(context, transparent, end, rays) {
            for (i, sample) in samples.iter().enumerate().filter(|(i, _)| rays.is_open(*i)) {
                let point = &points[sample.point];
                match clear_shadows.of(i) {
                    Passage::Passed(part) => {
                        let color = part * sample.color;
                        if part == DVec3::ONE || color.max_element() > context.picture.least_weight {
                            shading.colors[point.state.pixel] += color;
                        }
                    }
                    Passage::Unknown => dimmed.push(point, toward(point, sample.to_light), sample.color),
                }
            }
            return;
        }
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

    /// Leaves the shadow rays to be traced through the scene, with those of a kind.
    fn queue(
        &mut self,
        points: &[SurfacePoint<'_>],
        light: &Light,
        kind: impl Fn(&mut RemainingRays) -> &mut ShadowBatch,
    ) {
        let Scratch { samples, remaining, .. } = &mut *self.scratch;
        let batch = kind(&mut remaining[kind_of(light)]);
        for sample in &*samples {
            let point = &points[sample.point];
            batch.push(point, toward(point, sample.to_light), sample.color);
        }
    }
}

/// The index of a light's rays in [`Scratch::remaining`].
fn kind_of(light: &Light) -> usize {
    usize::from(light.position().is_none())
}

/// The t where the shadow rays to a light end.
fn end_of(light: &Light) -> f64 {
    if light.position().is_some() { 1.0 } else { f64::INFINITY }
}

/// The surface and side of a point if its shadow rays may share a shaft with others of them: they leave the surface in clear
/// air, or they go through its shape, which transmits light, and need none. Facets and bumps are not shaded in lanes.
fn surface_of(context: &RenderContext<'_>, point: &SurfacePoint<'_>) -> Option<(*const (), bool)> {
    let is_clear = point.leaving && context.has_transmission;
    let is_outside = !point.leaving && !point.state.media.absorbs();
    let is_groupable = !context.has_facets(point)
        && point.bump.is_none()
        && (is_clear || is_outside)
        && !point.is_proxy()
        && point.position.is_finite();
    // One path has one pointer in all points, but for surfaces that were forgotten in between.
    let owner = match &point.owner {
        SurfaceOwner::Instance(path) => Rc::as_ptr(path).cast(),
        SurfaceOwner::Floor => std::ptr::null(),
    };
    is_groupable.then_some((owner, point.leaving))
}
