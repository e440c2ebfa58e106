//! A compiled scene into a film, in tiles over threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::{AmbientOcclusion, Camera, Floor, Light, Material, Picture, Scene, Sky};

use crate::compiled::CompiledScene;
use crate::film::{Film, Pixel};
use crate::gather::Gathered;
use crate::integrator::{RayCounts, Setting, Taken};
use crate::sampler::Sampler;
use crate::tile::{FilmSample, TileTracer};
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
    let job = Job { scene, settings, view: View::new(&settings.camera, width, height) };
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
            let (pixels, taken) = job.render_tile(&tile);
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

struct Job<'a> {
    scene: &'a CompiledScene,
    settings: &'a RenderSettings,
    view: View,
}

impl Job<'_> {
    /// The pixels of a tile, row by row.
    fn render_tile(&self, tile: &Tile) -> (Vec<Pixel>, Taken) {
        let setting = Setting::new(self.scene, self.settings);
        let pixels = tile.pixels_by_block();
        let count = self.settings.picture.samples.max(1);
        let mut tracer = TileTracer::new(setting, &self.view, count);
        let mut sums = vec![Gathered::default(); pixels.len()];
        for (place, index) in Sampler::new(count).places().zip(0..) {
            let sample = |&(x, y): &(u32, u32)| FilmSample {
                pixel: (x, y),
                index,
                film_px: DVec2::new(f64::from(x), f64::from(y)) + place,
            };
            let samples: Vec<FilmSample> = pixels.iter().map(sample).collect();
            for (sum, seen) in sums.iter_mut().zip(tracer.trace(&samples)) {
                sum.add(&seen);
            }
        }
        let mut by_row = vec![Pixel::EMPTY; pixels.len()];
        for ((x, y), sum) in pixels.into_iter().zip(sums) {
            let place = (y - tile.y.start) as usize * tile.x.len() + (x - tile.x.start) as usize;
            by_row[place] = sum.pixel();
        }
        (by_row, tracer.taken)
    }
}
