//! A compiled scene into a film, in tiles over threads.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::{AmbientOcclusion, Camera, Floor, Light, Material, Picture, Scene, Sky};

use crate::compiled::CompiledScene;
use crate::film::Film;
use crate::integrator::{RayCounts, Setting, Taken};
use crate::sampler::Sampler;
use crate::tile::{FilmSample, TileTracer};
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

/// The edge of a tile in pixels.
const TILE_PX: u32 = 16;
/// The edge of a block of pixels whose rays share a register.
const BLOCK_PX: usize = 4;

/// Renders a compiled scene.
///
/// # Errors
/// The threads cannot be started.
pub fn render(
    scene: &CompiledScene,
    settings: &RenderSettings,
    budget: &RenderBudget<'_>,
) -> Result<Rendered, rayon::ThreadPoolBuildError> {
    let Picture { width, height, .. } = settings.picture;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(budget.threads).build()?;
    let job = Job { scene, settings, view: View::new(&settings.camera, width, height) };
    let done = AtomicU64::new(0);
    let tiles = tiles(width, height);
    let finished: Vec<(Tile, Vec<[f32; 3]>, Taken)> = threads.install(|| {
        let unless_cancelled = tiles.into_par_iter().filter(|_| !budget.cancel.load(Ordering::Relaxed));
        unless_cancelled
            .map(|tile| {
                let (colors, counts) = job.render_tile(&tile);
                let pixels = colors.len() as u64;
                (budget.progress)(done.fetch_add(pixels, Ordering::Relaxed) + pixels);
                (tile, colors, counts)
            })
            .collect()
    });

    let mut film = Film::new(width, height);
    let mut total = Taken::default();
    for (tile, colors, counts) in finished {
        tile.pixels_by_block().into_iter().zip(colors).for_each(|((x, y), color)| film.set(x, y, color));
        total += counts;
    }
    Ok(Rendered { film, rays: total.rays, stand_ins: total.stand_ins })
}

struct Tile {
    x: Range<u32>,
    y: Range<u32>,
}

impl Tile {
    /// Its pixels, by blocks of neighbours that go through the scene together.
    fn pixels_by_block(&self) -> Vec<(u32, u32)> {
        let blocks = |range: &Range<u32>| {
            let end = range.end;
            range.clone().step_by(BLOCK_PX).map(move |first| first..end.min(first + BLOCK_PX as u32))
        };
        let rows = blocks(&self.y).flat_map(|y| blocks(&self.x).map(move |x| (x, y.clone())));
        rows.flat_map(|(x, y)| y.flat_map(move |y| x.clone().map(move |x| (x, y)))).collect()
    }
}

fn tiles(width: u32, height: u32) -> Vec<Tile> {
    let ranges =
        |length: u32| (0..length.div_ceil(TILE_PX)).map(move |i| i * TILE_PX..length.min((i + 1) * TILE_PX));
    ranges(height).flat_map(|y| ranges(width).map(move |x| Tile { x, y: y.clone() })).collect()
}

/// The pixels of a picture, by tiles and blocks.
pub(crate) fn tiles_of_pixels(width: u32, height: u32) -> Vec<Vec<(u32, u32)>> {
    tiles(width, height).iter().map(Tile::pixels_by_block).collect()
}

struct Job<'a> {
    scene: &'a CompiledScene,
    settings: &'a RenderSettings,
    view: View,
}

impl Job<'_> {
    fn render_tile(&self, tile: &Tile) -> (Vec<[f32; 3]>, Taken) {
        let setting = Setting::new(self.scene, self.settings);
        let pixels = tile.pixels_by_block();
        let count = self.settings.picture.samples.max(1);
        let mut tracer = TileTracer::new(setting, &self.view, count);
        let mut sums = vec![DVec3::ZERO; pixels.len()];
        for (place, index) in Sampler::new(count).places().zip(0..) {
            let sample = |&(x, y): &(u32, u32)| FilmSample {
                pixel: (x, y),
                index,
                film_px: DVec2::new(f64::from(x), f64::from(y)) + place,
            };
            let samples: Vec<FilmSample> = pixels.iter().map(sample).collect();
            for (sum, seen) in sums.iter_mut().zip(tracer.trace(&samples)) {
                *sum += seen.color;
            }
        }
        let colors = sums.iter().map(|sum| (sum / f64::from(count)).as_vec3().to_array()).collect();
        (colors, tracer.taken)
    }
}
