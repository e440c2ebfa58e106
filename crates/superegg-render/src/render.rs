//! A compiled scene into a film, in tiles over threads.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::{Camera, Light};

use crate::compiled::CompiledScene;
use crate::film::Film;
use crate::integrator::{Integrator, RayCounts};
use crate::sampler::Sampler;
use crate::view::View;

/// What picture is to be made. The same settings give the same picture, whatever the budget.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples a pixel, at least 1.
    pub samples: u32,
    /// The camera.
    pub camera: Camera,
    /// The lights.
    pub lights: Vec<Light>,
    /// The linear colour where nothing is.
    pub background: DVec3,
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
}

/// The edge of a tile in pixels.
const TILE_PX: u32 = 16;

/// Renders a compiled scene.
///
/// # Errors
/// The threads cannot be started.
pub fn render(
    scene: &CompiledScene,
    settings: &RenderSettings,
    budget: &RenderBudget<'_>,
) -> Result<Rendered, rayon::ThreadPoolBuildError> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(budget.threads).build()?;
    let job = Job { scene, settings, view: View::new(&settings.camera, settings.width, settings.height) };
    let done = AtomicU64::new(0);
    let tiles = tiles(settings.width, settings.height);
    let finished: Vec<(Tile, Vec<[f32; 3]>, RayCounts)> = threads.install(|| {
        let unless_cancelled = tiles.into_par_iter().filter(|_| !budget.cancel.load(Ordering::Relaxed));
        unless_cancelled
            .map(|tile| {
                let (colors, rays) = job.render_tile(&tile);
                let pixels = colors.len() as u64;
                (budget.progress)(done.fetch_add(pixels, Ordering::Relaxed) + pixels);
                (tile, colors, rays)
            })
            .collect()
    });

    let mut film = Film::new(settings.width, settings.height);
    let mut rays = RayCounts::default();
    for (tile, colors, tile_rays) in finished {
        tile.pixels().zip(colors).for_each(|((x, y), color)| film.set(x, y, color));
        rays += tile_rays;
    }
    Ok(Rendered { film, rays })
}

struct Tile {
    x: std::ops::Range<u32>,
    y: std::ops::Range<u32>,
}

impl Tile {
    fn pixels(&self) -> impl Iterator<Item = (u32, u32)> {
        let x = self.x.clone();
        self.y.clone().flat_map(move |y| x.clone().map(move |x| (x, y)))
    }
}

fn tiles(width: u32, height: u32) -> Vec<Tile> {
    let ranges =
        |length: u32| (0..length.div_ceil(TILE_PX)).map(move |i| i * TILE_PX..length.min((i + 1) * TILE_PX));
    ranges(height).flat_map(|y| ranges(width).map(move |x| Tile { x, y: y.clone() })).collect()
}

struct Job<'a> {
    scene: &'a CompiledScene,
    settings: &'a RenderSettings,
    view: View,
}

impl Job<'_> {
    fn render_tile(&self, tile: &Tile) -> (Vec<[f32; 3]>, RayCounts) {
        let mut integrator = Integrator {
            scene: self.scene,
            lights: &self.settings.lights,
            background: self.settings.background,
            counts: RayCounts::default(),
        };
        let sampler = Sampler::new(self.settings.samples);
        let colors = tile
            .pixels()
            .map(|(x, y)| {
                let corner = DVec2::new(f64::from(x), f64::from(y));
                let sum: DVec3 =
                    sampler.places().map(|place| integrator.camera_ray(&self.view.ray(corner + place))).sum();
                (sum / f64::from(self.settings.samples.max(1))).as_vec3().to_array()
            })
            .collect();
        (colors, integrator.counts)
    }
}
