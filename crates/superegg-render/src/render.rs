//! A compiled scene into a film, in tiles over threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_scene::{AmbientOcclusion, Camera, Floor, Light, Material, Picture, Scene, Sky};

use crate::adaptive::Stopping;
use crate::compiled::CompiledScene;
use crate::develop::Development;
use crate::film::{Film, Pixel};
use crate::gather::Gathered;
use crate::integrator::{RayCounts, Setting, Taken};
use crate::lighting;
use crate::placement::{Place, Placement};
use crate::shows::{Shows, color_of_id};
use crate::tile::{FilmSample, FirstSurface, Sighting, TileTracer};
use crate::tiling::{Tile, tiles};
use crate::view::View;

/// What picture is to be made. The same settings give the same picture, whatever the budget.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Size and quality.
    pub picture: Picture,
    /// The camera.
    pub camera: Camera,
    /// What is around the objects.
    pub surroundings: Surroundings,
    /// What the picture shows.
    pub shows: Shows,
}

/// What is around the objects of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// The lights that shine.
    pub lights: Vec<Light>,
    /// The linear colour where nothing is, unless there is a sky.
    pub background: DVec3,
    /// What is seen where nothing is, instead of the background.
    pub sky: Option<Sky>,
    /// A plane without end, and its surface.
    pub floor: Option<(Floor, Material)>,
    /// Whether, and how, ambient light is kept from corners.
    pub ambient_occlusion: Option<AmbientOcclusion>,
}

impl RenderSettings {
    /// How the film becomes a picture, once it has the colours that are looked at ([`Shows::colored`]).
    pub fn development(&self) -> Development {
        match self.shows {
            Shows::Light => Development::of(&self.picture),
            _ => Development::undeveloped(&self.picture),
        }
    }

    /// The picture that a scene describes.
    pub fn of(scene: &Scene) -> Self {
        Self {
            picture: scene.picture,
            camera: scene.camera,
            surroundings: Surroundings {
                lights: scene.lights(),
                background: scene.background,
                sky: scene.sky,
                floor: scene.floor.clone().map(|floor| (floor, scene.floor_material())),
                ambient_occlusion: scene.ambient_occlusion,
            },
            shows: Shows::Light,
        }
    }
}

/// What making it may take, and how it is watched.
#[derive(Clone, Copy)]
pub struct RenderBudget<'a> {
    /// Threads to use, at least 1.
    pub threads: usize,
    /// When this turns true the rest of the picture is left black.
    pub cancel: &'a AtomicBool,
    /// Is told, from any thread, how many pixels are done.
    pub progress: &'a (dyn Fn(u64) + Sync),
}

/// A picture and what it took.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub film: Film,
    /// The rays traced.
    pub rays: RayCounts,
    /// How many of them ended at a group that was too small to be opened, and saw its average ([`crate::LEAST_FOOTPRINT`]).
    pub stand_ins: u64,
}

/// Which tiles are made, and who is given them.
#[derive(Clone, Copy)]
pub struct TileWork<'a> {
    /// Whether a tile is to be made, by its index in [`tiles`]. Those that are not stay [`Pixel::EMPTY`]; no ray is traced for them.
    pub wanted: &'a (dyn Fn(usize) -> bool + Sync),
    /// Is given each tile as it is finished: its index and its pixels, row by row. Called from the threads that trace, one call at a time,
    /// in any order.
    pub finished: &'a (dyn Fn(usize, &[Pixel]) + Sync),
}

/// Renders a compiled scene.
///
/// # Errors
/// The threads cannot be started.
pub fn render(
    scene: &CompiledScene,
    settings: &RenderSettings,
    budget: &RenderBudget<'_>,
) -> Result<Rendered, rayon::ThreadPoolBuildError> {
    render_tiles(scene, settings, budget, &TileWork { wanted: &|_| true, finished: &|_, _| () })
}

/// Renders those tiles of a picture that are wanted. A tile's pixels depend on the scene and the settings alone, not on what other tiles are made,
/// on the threads or their order.
///
/// # Errors
/// The threads cannot be started.
pub fn render_tiles(
    scene: &CompiledScene,
    settings: &RenderSettings,
    budget: &RenderBudget<'_>,
    work: &TileWork<'_>,
) -> Result<Rendered, rayon::ThreadPoolBuildError> {
    let Picture { width, height, .. } = settings.picture;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(budget.threads).build()?;
    let settings = &settings.shows.stripped(settings);
    let job = Job::new(scene, settings, budget.cancel);
    let done = AtomicU64::new(0);
    let rendered = Rendered { film: Film::new(width, height), rays: RayCounts::default(), stand_ins: 0 };
    let rendered = Mutex::new(rendered);
    let wanted: Vec<(usize, Tile)> =
        tiles(width, height).into_iter().enumerate().filter(|(index, _)| (work.wanted)(*index)).collect();
    threads.install(|| {
        wanted.into_par_iter().for_each(|(index, tile)| {
            if budget.cancel.load(Ordering::Relaxed) {
                return;
            }
            let Some((pixels, taken)) = job.render_tile(&tile) else { return };
            let count = pixels.len() as u64;
            {
                let mut rendered = rendered.lock().unwrap_or_else(PoisonError::into_inner);
                rendered.film.set_tile(&tile, &pixels);
                rendered.rays += taken.rays;
                rendered.stand_ins += taken.stand_ins;
                (work.finished)(index, &pixels);
            }
            (budget.progress)(done.fetch_add(count, Ordering::Relaxed) + count);
        });
    });
    Ok(rendered.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// One picture in the making.
struct Job<'a> {
    scene: &'a CompiledScene,
    setting: Setting<'a>,
    settings: &'a RenderSettings,
    view: View,
    placement: Placement,
    stopping: Stopping,
    /// The rays of a picture of ambient occlusion alone.
    occlusion: AmbientOcclusion,
    cancel: &'a AtomicBool,
}

impl<'a> Job<'a> {
    fn new(scene: &'a CompiledScene, settings: &'a RenderSettings, cancel: &'a AtomicBool) -> Self {
        let picture = &settings.picture;
        let placement = Placement::of(picture);
        let stopping = Stopping::of(picture, settings.development(), placement.shares());
        Self {
            scene,
            setting: Setting::new(scene, settings),
            settings,
            view: View::new(&settings.camera, picture.width, picture.height),
            placement,
            stopping,
            occlusion: Shows::occlusion(settings, scene),
            cancel,
        }
    }

    /// The pixels of a tile, row by row; `None` when it was cancelled.
    fn render_tile(&self, tile: &Tile) -> Option<(Vec<Pixel>, Taken)> {
        let picture = &self.settings.picture;
        let setting = self.setting;
        let mut tracer = TileTracer::new(setting, &self.view, picture.samples);
        let columns = tile.x.len();
        let row_place =
            |(x, y): (u32, u32)| (y - tile.y.start) as usize * columns + (x - tile.x.start) as usize;
        let by_block: Vec<(usize, (u32, u32))> =
            tile.pixels_by_block().into_iter().map(|pixel| (row_place(pixel), pixel)).collect();
        let mut pixels = vec![Gathered::default(); by_block.len()];
        let mut batch = Batch::default();
        let mut round = vec![self.stopping.first; pixels.len()];
        while let Some(&longest) = round.iter().max().filter(|longest| **longest > 0) {
            let begun: Vec<u32> = pixels.iter().map(Gathered::count).collect();
            // One sample of each pixel that goes on, then the next of each.
            for step in 0..longest {
                for &(place, pixel) in by_block.iter().filter(|(place, _)| step < round[*place]) {
                    let index = begun[place] + step;
                    let Place { film_px, is_negative } = self.placement.place(pixel, index);
                    batch.samples.push(FilmSample { pixel, index, film_px });
                    batch.of.push((place, is_negative));
                    if batch.of.len() == by_block.len() {
                        self.take(&mut batch, setting, &mut tracer, &mut pixels);
                    }
                }
                if self.cancel.load(Ordering::Relaxed) {
                    return None;
                }
            }
            self.take(&mut batch, setting, &mut tracer, &mut pixels);
            round = self.stopping.next_round(columns, &pixels);
        }
        let is_transparent = picture.transparent;
        let pixel = |gathered: &Gathered| gathered.pixel(self.placement.shares(), is_transparent);
        Some((pixels.iter().map(pixel).collect(), tracer.taken))
    }

    /// Traces samples, and adds what they see to their pixels.
    fn take(
        &self,
        batch: &mut Batch,
        setting: Setting<'a>,
        tracer: &mut TileTracer<'a>,
        pixels: &mut [Gathered],
    ) {
        let sightings = self.sightings(setting, tracer, &batch.samples);
        for (&(place, is_negative), seen) in batch.of.iter().zip(&sightings) {
            pixels[place].add(seen, is_negative);
        }
        batch.samples.clear();
        batch.of.clear();
    }

    /// What samples see of what the picture shows.
    fn sightings(
        &self,
        setting: Setting<'a>,
        tracer: &mut TileTracer<'a>,
        samples: &[FilmSample],
    ) -> Vec<Sighting> {
        let mut sightings = match self.settings.shows {
            Shows::Light | Shows::Depth => tracer.trace(samples),
            Shows::Normal => {
                let color = |first: &FirstSurface| 0.5 + 0.5 * first.normal;
                with_colors(tracer.trace(samples), color)
            }
            Shows::Id => with_colors(tracer.trace(samples), |first| color_of_id(first.id)),
            Shows::Steps => {
                let steps = |sample: &FilmSample| {
                    self.scene.steps(&tracer.ray(sample), self.view.footprint(setting.picture.samples))
                };
                let steps: Vec<u64> = samples.iter().map(steps).collect();
                let seen = tracer.trace(samples).into_iter().zip(steps);
                seen.map(|(seen, steps)| Sighting { color: DVec3::splat(steps as f64), ..seen }).collect()
            }
            Shows::Occlusion => {
                let mut colors = vec![DVec3::ZERO; samples.len()];
                let points = tracer.first_points(samples, &mut colors);
                let firsts = tracer.first_surfaces(samples.len(), &points);
                let open = lighting::open_shares(setting, self.occlusion, &points, &mut tracer.taken);
                colors.fill(DVec3::ZERO);
                for (point, share) in points.iter().zip(open) {
                    colors[point.arrival.pixel] = DVec3::splat(share);
                }
                colors.into_iter().zip(firsts).map(|(color, first)| Sighting { color, first }).collect()
            }
        };
        if self.settings.picture.transparent {
            for seen in sightings.iter_mut().filter(|seen| seen.first.is_none()) {
                seen.color = DVec3::ZERO;
            }
        }
        sightings
    }
}

/// Samples that go through the scene together.
#[derive(Default)]
struct Batch {
    samples: Vec<FilmSample>,
    /// The place of each one's pixel in its tile, and whether the filter is negative there.
    of: Vec<(usize, bool)>,
}

/// What surfaces show instead of light; black where there is none.
fn with_colors(seen: Vec<Sighting>, color: impl Fn(&FirstSurface) -> DVec3) -> Vec<Sighting> {
    let colored =
        |seen: Sighting| Sighting { color: seen.first.as_ref().map_or(DVec3::ZERO, &color), ..seen };
    seen.into_iter().map(colored).collect()
}
