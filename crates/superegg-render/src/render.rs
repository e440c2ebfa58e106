//! A compiled scene into a film, in tiles over threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_scene::{AmbientOcclusion, Camera, Floor, Light, Material, Picture, Scene, Sky};
use superegg_trace::CompiledScene;

use crate::adaptive::Stopping;
use crate::develop::Development;
use crate::film::Film;
use crate::gather::{Gathered, Keeps};
use crate::integrator::{RayCounts, Setting, Taken};
use crate::placement::{Place, Placement};
use crate::shows::{Shows, color_of_id};
use crate::tile::{FilmSample, FirstSurface, Sightings, TileTracer};
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
    /// Whether the film is to know more of its pixels than their light: depth, normals, albedo and ids. That takes some time and two and a half
    /// times the memory.
    pub layers: bool,
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

    /// Whether the film knows more of its pixels than their light; a picture of depth needs it.
    pub fn keeps_layers(&self) -> bool {
        self.layers || self.shows == Shows::Depth
    }

    /// A film for the picture, of which no pixel has been made.
    pub fn film(&self) -> Film {
        let Picture { width, height, .. } = self.picture;
        if self.keeps_layers() { Film::new(width, height) } else { Film::without_layers(width, height) }
    }

    /// The picture that a scene describes, with layers.
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
            layers: true,
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

/// Which tiles are made, where they go, and who is told of them.
#[derive(Clone, Copy)]
pub struct TileWork<'a> {
    /// Of the picture's size. Tiles are put in their places as they are finished.
    pub film: &'a Mutex<Film>,
    /// Whether a tile is to be made, by its index in [`tiles`]. Those that are not stay as they are; no ray is traced for them.
    pub wanted: &'a (dyn Fn(usize) -> bool + Sync),
    /// Is given each tile after it was put in its place, with its index. Called from the threads that trace, in any order.
    pub finished: &'a (dyn Fn(usize, &Film) + Sync),
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
    let film = Mutex::new(settings.film());
    let work = TileWork { film: &film, wanted: &|_| true, finished: &|_, _| () };
    let Taken { rays, stand_ins } = render_tiles(scene, settings, budget, &work)?;
    Ok(Rendered { film: film.into_inner().unwrap_or_else(PoisonError::into_inner), rays, stand_ins })
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
) -> Result<Taken, rayon::ThreadPoolBuildError> {
    let Picture { width, height, .. } = settings.picture;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(budget.threads).build()?;
    let settings = &settings.shows.stripped(settings);
    let job = Job::new(scene, settings, budget.cancel);
    let done = AtomicU64::new(0);
    let taken = Mutex::new(Taken::default());
    let wanted: Vec<(usize, Tile)> =
        tiles(width, height).into_iter().enumerate().filter(|(index, _)| (work.wanted)(*index)).collect();
    threads.install(|| {
        wanted.into_par_iter().for_each_init(
            || Worker::new(&job),
            |worker, (index, tile)| {
                if budget.cancel.load(Ordering::Relaxed) {
                    return;
                }
                let Some((pixels, tile_taken)) = worker.render_tile(&tile) else { return };
                let count = tile.pixel_count() as u64;
                work.film.lock().unwrap_or_else(PoisonError::into_inner).set_tile(&tile, &pixels);
                *taken.lock().unwrap_or_else(PoisonError::into_inner) += tile_taken;
                (work.finished)(index, &pixels);
                (budget.progress)(done.fetch_add(count, Ordering::Relaxed) + count);
            },
        );
    });
    Ok(taken.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// One picture in the making.
struct Job<'a> {
    setting: Setting<'a>,
    settings: &'a RenderSettings,
    view: View,
    placement: Placement,
    stopping: Stopping,
    /// The rays of a picture of ambient occlusion alone.
    occlusion: AmbientOcclusion,
    keeps: Keeps,
    /// Whether it is to be known what samples meet first.
    asks_firsts: bool,
    cancel: &'a AtomicBool,
}

impl<'a> Job<'a> {
    fn new(scene: &'a CompiledScene, settings: &'a RenderSettings, cancel: &'a AtomicBool) -> Self {
        let picture = &settings.picture;
        let placement = Placement::of(picture);
        let stopping = Stopping::of(picture, settings.development());
        let keeps = Keeps { squares: !stopping.is_fixed(), layers: settings.keeps_layers() };
        let shows_firsts = matches!(settings.shows, Shows::Normal | Shows::Id);
        Self {
            setting: Setting::new(scene, settings),
            settings,
            view: View::new(&settings.camera, picture.width, picture.height),
            placement,
            stopping,
            occlusion: Shows::occlusion(settings, scene),
            keeps,
            asks_firsts: keeps.layers || picture.transparent || shows_firsts,
            cancel,
        }
    }
}

/// What makes tiles, one after the other, in the same memory.
struct Worker<'j, 'a> {
    job: &'j Job<'a>,
    tracer: TileTracer<'j>,
    batch: Batch,
    gathered: Gathered,
    /// The pixels of a tile of the last one's size that begins at the top left corner, by blocks of neighbours.
    by_block: Vec<(u32, u32)>,
    size: (u32, u32),
}

impl<'j, 'a> Worker<'j, 'a> {
    fn new(job: &'j Job<'a>) -> Self {
        let tracer = TileTracer::new(job.setting, &job.view, job.settings.picture.samples, job.asks_firsts);
        Self {
            job,
            tracer,
            batch: Batch::default(),
            gathered: Gathered::new(job.placement.shares()),
            by_block: Vec::new(),
            size: (0, 0),
        }
    }

    /// The pixels of a tile; `None` when it was cancelled.
    fn render_tile(&mut self, tile: &Tile) -> Option<(Film, Taken)> {
        let job = self.job;
        if self.size != tile.size() {
            self.size = tile.size();
            self.by_block = Tile { x: 0..self.size.0, y: 0..self.size.1 }.pixels_by_block();
        }
        self.gathered.start(tile.pixel_count(), job.keeps);
        self.batch.clear();
        self.tracer.taken = Taken::default();
        if job.stopping.is_fixed() {
            self.take_as_many(tile)?;
        } else {
            self.take_rounds(tile)?;
        }
        Some((self.gathered.film(tile.size(), job.settings.picture.transparent), self.tracer.taken))
    }

    /// As many samples of each pixel; `None` when it was cancelled.
    fn take_as_many(&mut self, tile: &Tile) -> Option<()> {
        let job = self.job;
        for index in 0..job.stopping.first {
            let same_place = job.placement.same_place(index);
            let place_in = |pixel| {
                same_place.map_or_else(|| job.placement.place(pixel, index), |same| same.in_pixel(pixel))
            };
            let columns = tile.x.len() as u32;
            let Batch { samples, of } = &mut self.batch;
            samples.extend(self.by_block.iter().map(|&(x, y)| {
                let pixel = (tile.x.start + x, tile.y.start + y);
                FilmSample { pixel, index, film_px: place_in(pixel).film_px }
            }));
            of.extend(self.by_block.iter().map(|&(x, y)| {
                let place = place_in((tile.x.start + x, tile.y.start + y));
                (y * columns + x, place.is_negative)
            }));
            self.take();
            if job.cancel.load(Ordering::Relaxed) {
                return None;
            }
        }
        Some(())
    }

    /// Samples of each pixel until it needs no more; `None` when it was cancelled.
    fn take_rounds(&mut self, tile: &Tile) -> Option<()> {
        let job = self.job;
        let columns = tile.x.len();
        let mut round = vec![job.stopping.first; tile.pixel_count()];
        while let Some(&longest) = round.iter().max().filter(|longest| **longest > 0) {
            let begun: Vec<u32> = (0..tile.pixel_count()).map(|place| self.gathered.count(place)).collect();
            // One sample of each pixel that goes on, then the next of each.
            for step in 0..longest {
                for i in 0..self.by_block.len() {
                    let (x, y) = self.by_block[i];
                    let place = y as usize * columns + x as usize;
                    if step >= round[place] {
                        continue;
                    }
                    let (pixel, index) = ((tile.x.start + x, tile.y.start + y), begun[place] + step);
                    let Place { film_px, is_negative } = job.placement.place(pixel, index);
                    self.batch.samples.push(FilmSample { pixel, index, film_px });
                    self.batch.of.push((place as u32, is_negative));
                    if self.batch.of.len() == tile.pixel_count() {
                        self.take();
                    }
                }
                if job.cancel.load(Ordering::Relaxed) {
                    return None;
                }
            }
            self.take();
            round = job.stopping.next_round(columns, &self.gathered);
        }
        Some(())
    }

    /// Traces the samples of the batch, and adds what they see to their pixels.
    fn take(&mut self) {
        let Self { job, tracer, batch: Batch { samples, of }, gathered, .. } = self;
        let seen = if job.settings.shows == Shows::Occlusion {
            tracer.trace_occlusion(samples, job.occlusion)
        } else {
            tracer.trace(samples)
        };
        job.show(samples, seen);
        let mut firsts = seen.firsts.iter();
        for (&(place, is_negative), &color) in of.iter().zip(&seen.colors) {
            let first = firsts.next().and_then(Option::as_ref);
            gathered.add(place as usize, color, first, is_negative);
        }
        self.batch.clear();
    }
}

impl Job<'_> {
    /// Brings what samples see to what the picture shows.
    fn show(&self, samples: &[FilmSample], Sightings { colors, firsts }: &mut Sightings) {
        let mut paint = |color: &dyn Fn(&FirstSurface) -> DVec3| {
            for (to, first) in colors.iter_mut().zip(&*firsts) {
                *to = first.as_ref().map_or(DVec3::ZERO, color);
            }
        };
        match self.settings.shows {
            Shows::Light | Shows::Depth | Shows::Occlusion => {}
            Shows::Normal => paint(&|first| (0.5 + 0.5 * first.normal).as_dvec3()),
            Shows::Id => paint(&|first| color_of_id(first.id)),
            Shows::Steps => {
                let footprint = self.view.footprint(self.settings.picture.samples);
                for (to, sample) in colors.iter_mut().zip(samples) {
                    let ray = self.view.sample_ray(sample);
                    *to = DVec3::splat(self.setting.scene.steps(&ray, footprint) as f64);
                }
            }
        }
        if self.settings.picture.transparent {
            for (color, _) in colors.iter_mut().zip(firsts).filter(|(_, first)| first.is_none()) {
                *color = DVec3::ZERO;
            }
        }
    }
}

/// Samples that go through the scene together.
#[derive(Default)]
struct Batch {
    samples: Vec<FilmSample>,
    /// The place of each one's pixel in its tile, and whether the filter is negative there.
    of: Vec<(u32, bool)>,
}

impl Batch {
    fn clear(&mut self) {
        self.samples.clear();
        self.of.clear();
    }
}
