//! The work of one thread: renders tiles, one after the other.

use std::sync::atomic::{AtomicBool, Ordering};

use superegg_geom::glam::DVec3;
use superegg_scene::AmbientOcclusion;
use superegg_trace::packet::{LANES, MOST_RAYS};
use superegg_trace::{CompiledScene, InstanceNumbers, TraceRay};

use crate::camera::placement::{SamplePlacement, SamplePosition};
use crate::camera::sample::FilmSample;
use crate::camera::view::View;
use crate::film::accumulate::{AccumulatorLayout, TileAccumulator};
use crate::film::adaptive::StoppingRule;
use crate::film::buffer::Film;
use crate::film::first::{FirstHit, FirstLight, SampleResults};
use crate::film::matte::MatteLevel;
use crate::film::tile::Tile;
use crate::render::output::color_of_id;
use crate::render::surface_ids::SurfaceIdTable;
use crate::render::tracer::{SampleNeeds, TileTracer};
use crate::settings::{Output, RenderSettings};
use crate::shade::context::RenderContext;
use crate::shade::path_resources::PathResources;
use crate::stats::TraceStats;

/// The data of a render that all threads read.
pub(crate) struct RenderJob<'a> {
    context: RenderContext<'a>,
    settings: &'a RenderSettings,
    view: View,
    placement: SamplePlacement,
    stopping: StoppingRule,
    /// The rays of [`Output::Occlusion`].
    occlusion: AmbientOcclusion,
    layout: AccumulatorLayout,
    needs: SampleNeeds,
    /// The small numbers of layers.
    numbers: Option<InstanceNumbers<'a>>,
    cancel: Option<&'a AtomicBool>,
}

impl<'a> RenderJob<'a> {
    /// The job of a picture. The settings are those of [`RenderSettings::for_output`].
    pub(crate) fn new(
        scene: &'a CompiledScene,
        settings: &'a RenderSettings,
        paths: &'a PathResources,
        cancel: Option<&'a AtomicBool>,
    ) -> Self {
        let picture = &settings.picture;
        let stopping = StoppingRule::of(picture, settings.development());
        let layout = AccumulatorLayout {
            squares: !stopping.is_fixed(),
            layers: settings.keeps_layers(),
            passes: settings.keeps_passes(),
            mattes: settings.keeps_mattes(),
        };
        let is_first_hit_output = matches!(settings.output, Output::Normal | Output::Albedo | Output::Id);
        Self {
            context: RenderContext::new(scene, settings, paths),
            settings,
            view: View::new(&settings.camera, picture.width, picture.height),
            placement: SamplePlacement::of(picture),
            stopping,
            occlusion: Output::occlusion(settings, scene),
            layout,
            needs: SampleNeeds {
                first_hits: layout.layers || picture.transparent || is_first_hit_output,
                passes: layout.passes,
            },
            numbers: layout.layers.then(|| InstanceNumbers::of(scene)),
            cancel,
        }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    /// Replaces the light of samples by the output of the picture.
    fn apply_output(&self, samples: &[FilmSample], results: &mut SampleResults) {
        let SampleResults { colors, passes, first_hits } = results;
        let mut paint = |color: &dyn Fn(&FirstHit) -> DVec3| {
            for (to, first) in colors.iter_mut().zip(&*first_hits) {
                *to = first.as_ref().map_or(DVec3::ZERO, color);
            }
        };
        match self.settings.output {
            Output::Light | Output::Depth | Output::Occlusion => {}
            Output::Normal => paint(&|first| (0.5 + 0.5 * first.normal).as_dvec3()),
            Output::Albedo => paint(&|first| first.albedo.as_dvec3()),
            Output::Id => paint(&|first| color_of_id(first.ids.id)),
            Output::Steps => {
                let footprint = self.view.footprint(self.settings.picture.samples);
                for (to, sample) in colors.iter_mut().zip(samples) {
                    let ray = TraceRay::new(self.view.sample_ray(sample)).with_footprint(footprint);
                    *to = DVec3::splat(self.context.scene.visited(&ray) as f64);
                }
            }
        }
        if self.settings.picture.transparent {
            for (i, _) in first_hits.iter().enumerate().filter(|(_, first)| first.is_none()) {
                colors[i] = DVec3::ZERO;
                if let Some(pass) = passes.get_mut(i) {
                    *pass = FirstLight::default();
                }
            }
        }
    }
}

/// Renders tiles and reuses its memory.
pub(crate) struct Worker<'j, 'a> {
    job: &'j RenderJob<'a>,
    tracer: TileTracer<'j>,
    batch: Batch,
    accumulator: TileAccumulator,
    /// The pixels of a tile of `size` whose corner is the origin, ordered by blocks of neighbours.
    block_order: Vec<(u32, u32)>,
    size: (u32, u32),
}

impl<'j, 'a> Worker<'j, 'a> {
    pub(crate) fn new(job: &'j RenderJob<'a>) -> Self {
        let samples = job.settings.picture.samples;
        Self {
            job,
            tracer: TileTracer::new(
                job.context,
                &job.view,
                samples,
                job.needs,
                SurfaceIdTable::new(job.context.scene, job.numbers.as_ref(), job.layout.mattes),
            ),
            batch: Batch::default(),
            accumulator: TileAccumulator::new(job.placement.mass()),
            block_order: Vec::new(),
            size: (0, 0),
        }
    }

    /// Renders a tile; `None` if the render was cancelled.
    pub(crate) fn render_tile(&mut self, tile: &Tile) -> Option<(Film, TraceStats)> {
        let job = self.job;
        if self.size != tile.size() {
            self.size = tile.size();
            self.block_order = Tile { x: 0..self.size.0, y: 0..self.size.1 }.pixels_by_block();
        }
        self.accumulator.start(tile.pixel_count(), job.layout);
        self.batch.clear();
        self.tracer.ids.clear();
        self.tracer.stats = TraceStats::default();
        if job.stopping.is_fixed() {
            self.render_fixed(tile)?;
        } else {
            self.render_adaptive(tile)?;
        }
        let mut film = self.accumulator.film(tile.size(), job.settings.picture.transparent);
        if job.layout.mattes {
            let kept = MatteLevel::ALL.map(|level| film.matte_ids(level));
            let is_kept = |id: &u32| kept.iter().any(|ids| ids.contains(id));
            film.add_matte_names(self.tracer.ids.names().filter(|(id, _)| is_kept(id)));
        }
        Some((film, self.tracer.stats))
    }

    /// Takes the same number of samples in every pixel, all of them in some neighbours before the next: the fewer pixels a
    /// batch has, the more its rays are alike. `None` if the render was cancelled.
    fn render_fixed(&mut self, tile: &Tile) -> Option<()> {
        let (job, samples) = (self.job, self.job.stopping.first);
        let shared: Vec<_> = (0..samples).map(|index| job.placement.shared_position(index)).collect();
        let columns = tile.x.len() as u32;
        for first in (0..self.block_order.len()).step_by(LANES) {
            let neighbours = first..self.block_order.len().min(first + LANES);
            for index in 0..samples {
                let shared = &shared[index as usize];
                let position_in = |pixel| match shared {
                    Some(shared) => shared.in_pixel(pixel),
                    None => job.placement.position(pixel, index),
                };
                let neighbours = &self.block_order[neighbours.clone()];
                let Batch { samples, targets } = &mut self.batch;
                samples.extend(neighbours.iter().map(|&(x, y)| {
                    let pixel = (tile.x.start + x, tile.y.start + y);
                    FilmSample { pixel, index, film_px: position_in(pixel).film_px }
                }));
                targets.extend(neighbours.iter().map(|&(x, y)| {
                    let position = position_in((tile.x.start + x, tile.y.start + y));
                    (y * columns + x, position.is_negative)
                }));
                self.trace_full_batch()?;
            }
        }
        self.trace_batch()
    }

    /// Samples each pixel until its error is small enough; `None` if the render was cancelled.
    fn render_adaptive(&mut self, tile: &Tile) -> Option<()> {
        let job = self.job;
        let columns = tile.x.len();
        let mut round = vec![job.stopping.first; tile.pixel_count()];
        while let Some(&longest) = round.iter().max().filter(|longest| **longest > 0) {
            let begun: Vec<u32> =
                (0..tile.pixel_count()).map(|pixel| self.accumulator.count(pixel)).collect();
            for first in (0..self.block_order.len()).step_by(LANES) {
                // One sample of each unfinished pixel, then the next of each: neighbours stay together.
                for step in 0..longest {
                    for i in first..self.block_order.len().min(first + LANES) {
                        let (x, y) = self.block_order[i];
                        let target = y as usize * columns + x as usize;
                        if step >= round[target] {
                            continue;
                        }
                        let (pixel, index) = ((tile.x.start + x, tile.y.start + y), begun[target] + step);
                        let SamplePosition { film_px, is_negative } = job.placement.position(pixel, index);
                        self.batch.samples.push(FilmSample { pixel, index, film_px });
                        self.batch.targets.push((target as u32, is_negative));
                    }
                    self.trace_full_batch()?;
                }
            }
            self.trace_batch()?;
            round = job.stopping.next_round(columns, &self.accumulator);
        }
        Some(())
    }

    /// Traces the batch if another packet might not fit; `None` if the render was cancelled.
    fn trace_full_batch(&mut self) -> Option<()> {
        if self.batch.samples.len() + LANES > MOST_RAYS { self.trace_batch() } else { Some(()) }
    }

    /// Traces the samples of the batch, adds them to their pixels and empties the batch; `None` if the render was cancelled.
    fn trace_batch(&mut self) -> Option<()> {
        if self.batch.samples.is_empty() {
            return Some(());
        }
        let Self { job, tracer, batch: Batch { samples, targets }, accumulator, .. } = self;
        let results = if job.settings.output == Output::Occlusion {
            tracer.trace_occlusion(samples, job.occlusion)
        } else {
            tracer.trace(samples)
        };
        job.apply_output(samples, results);
        let mut first_hits = results.first_hits.iter();
        for (&(pixel, is_negative), &color) in targets.iter().zip(&results.colors) {
            let first = first_hits.next().and_then(Option::as_ref);
            accumulator.add(pixel as usize, color, first, is_negative);
        }
        for (&(pixel, is_negative), light) in targets.iter().zip(&results.passes) {
            accumulator.add_pass(pixel as usize, light, is_negative);
        }
        if job.layout.mattes {
            for (&(pixel, is_negative), first) in targets.iter().zip(&results.first_hits) {
                if let Some(first) = first {
                    accumulator.add_ids(pixel as usize, &first.ids, is_negative);
                }
            }
        }
        self.batch.clear();
        (!self.job.is_cancelled()).then_some(())
    }
}

/// Samples that are traced together.
#[derive(Default)]
struct Batch {
    samples: Vec<FilmSample>,
    /// For each sample the index of its pixel in the tile, and whether the filter is negative
    /// there.
    targets: Vec<(u32, bool)>,
}

impl Batch {
    fn clear(&mut self) {
        self.samples.clear();
        self.targets.clear();
    }
}
