//! A picture that is rendered in slices of time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use superegg_render::{
    Development, Film, Output, RayCounts, RenderOptions, RenderResources, RenderSettings, Shard, Tile,
    TileWork, TraceStats, render_tiles_with, tiles,
};
use superegg_scene::Camera;
use superegg_trace::CompiledScene;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::answers::{PictureRequest, error};
use crate::clock::now;
use crate::eye::{camera_of, map_of};

/// A picture, or a shard of it, whose tiles are rendered one after the other.
#[wasm_bindgen]
pub struct Picture {
    compiled: Arc<CompiledScene>,
    resources: Arc<RenderResources>,
    settings: RenderSettings,
    film: Mutex<Film>,
    tiles: Vec<Tile>,
    /// Whether each tile is rendered, or belongs to another shard.
    is_done: Vec<bool>,
    left: usize,
    stats: TraceStats,
}

/// The settings of a request.
///
/// # Errors
/// A word or number that no picture has.
pub(crate) fn settings_of(
    settings: RenderSettings,
    request: &PictureRequest,
) -> Result<RenderSettings, JsError> {
    let mut settings = settings;
    let picture = &mut settings.picture;
    picture.width = request.width.unwrap_or(picture.width);
    picture.height = request.height.unwrap_or(picture.height);
    picture.samples = request.samples.unwrap_or(picture.samples);
    picture.noise = request.noise.unwrap_or(picture.noise);
    if let Some(word) = &request.output {
        settings.output = Output::of_word(word).ok_or_else(|| {
            let words: Vec<&str> = Output::ALL.iter().map(|output| output.word()).collect();
            error(format!("there is no output '{word}'; expected one of {}", words.join(", ")))
        })?;
    }
    if let Some(numbers) = &request.camera {
        settings.camera = Camera { lens: settings.camera.lens, ..camera_of(numbers) };
    }
    if let Some(numbers) = &request.light_map {
        let map = map_of(numbers);
        settings.environment.lights =
            settings.environment.lights.iter().map(|light| light.through(&map)).collect();
    }
    settings.validate().map_err(error)?;
    Ok(settings)
}

impl Picture {
    pub(crate) fn new(
        compiled: Arc<CompiledScene>,
        resources: Arc<RenderResources>,
        settings: RenderSettings,
        shard: Option<&str>,
    ) -> Result<Self, JsError> {
        let shard = shard.map_or(Ok(Shard::WHOLE), str::parse).map_err(error)?;
        // Depth and steps are coloured by their range, so they need their columns.
        let is_depth = settings.output == Output::Depth;
        let settings = settings.with_layers(is_depth);
        let film = Mutex::new(settings.film());
        let tiles = tiles(settings.picture.width, settings.picture.height);
        let is_done: Vec<bool> = (0..tiles.len()).map(|index| !shard.takes(index)).collect();
        let left = is_done.iter().filter(|is_done| !**is_done).count();
        Ok(Self { compiled, resources, settings, film, tiles, is_done, left, stats: TraceStats::default() })
    }

    /// The development for the bytes of a screen.
    fn development(&self) -> Development {
        Development { bits: 8, ..self.settings.development() }
    }

    fn rgba(&self, values: &[u8]) -> Vec<u8> {
        if self.development().transparent {
            return values.to_vec();
        }
        values.as_chunks().0.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect()
    }

    fn colored(&self) -> Film {
        let film = self.film.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.settings.output.into_colored(film)
    }
}

#[wasm_bindgen]
impl Picture {
    /// Renders tiles until this many milliseconds have passed, at least one, and returns their indexes.
    ///
    /// # Errors
    /// The settings are invalid.
    pub fn step(&mut self, milliseconds: f64) -> Result<Vec<u32>, JsError> {
        let deadline = now() + milliseconds;
        let is_late = AtomicBool::new(false);
        let finished = Mutex::new(Vec::new());
        let is_done = &self.is_done;
        let work = TileWork {
            film: &self.film,
            wanted: &|index| !is_done[index],
            finished: &|index, _| {
                finished.lock().unwrap_or_else(PoisonError::into_inner).push(index);
                if now() >= deadline {
                    is_late.store(true, Ordering::Relaxed);
                }
            },
        };
        let options = RenderOptions::default().with_cancel(&is_late);
        let stats = render_tiles_with(&self.compiled, &self.resources, &self.settings, &options, &work)
            .map_err(error)?;
        self.stats += stats;
        let finished = finished.into_inner().unwrap_or_else(PoisonError::into_inner);
        finished.iter().for_each(|&index| self.is_done[index] = true);
        self.left -= finished.len();
        Ok(finished.into_iter().map(|index| index as u32).collect())
    }

    /// The number of tiles that are not rendered yet.
    #[wasm_bindgen(getter)]
    pub fn left(&self) -> usize {
        self.left
    }

    /// The width in pixels.
    #[wasm_bindgen(getter)]
    pub fn width(&self) -> u32 {
        self.settings.picture.width
    }

    /// The height in pixels.
    #[wasm_bindgen(getter)]
    pub fn height(&self) -> u32 {
        self.settings.picture.height
    }

    /// The number of rays traced so far: camera, shadow and all others.
    #[wasm_bindgen(getter)]
    pub fn rays(&self) -> f64 {
        let RayCounts { camera, shadow, ambient, reflection, refraction, .. } = self.stats.rays;
        (camera + shadow + ambient + reflection + refraction) as f64
    }

    /// Left, top, width and height of a tile in pixels.
    ///
    /// # Errors
    /// There is no such tile.
    pub fn tile(&self, index: usize) -> Result<Vec<u32>, JsError> {
        let tile = self.tiles.get(index).ok_or_else(|| error("there is no such tile"))?;
        let (width, height) = tile.size();
        Ok(vec![tile.x.start, tile.y.start, width, height])
    }

    /// Red, green, blue and alpha of the pixels of a tile. Depth and steps are coloured only in the whole picture.
    ///
    /// # Errors
    /// There is no such tile.
    pub fn pixels(&self, index: usize) -> Result<Vec<u8>, JsError> {
        let tile = self.tiles.get(index).ok_or_else(|| error("there is no such tile"))?;
        let film = self.film.lock().unwrap_or_else(PoisonError::into_inner).tile(tile);
        Ok(self.rgba(self.development().encode_tile(&film, tile).values()))
    }

    /// Red, green, blue and alpha of all pixels, row by row.
    pub fn data(&self) -> Vec<u8> {
        self.rgba(self.development().encode(&self.colored()).values())
    }

    /// The picture as a PNG file, developed as the scene says.
    ///
    /// # Errors
    /// The encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, JsError> {
        self.settings.development().png(&self.colored()).map_err(error)
    }
}
