//! Renders a compiled scene into a film: tiles in parallel.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use superegg_scene::Picture;
use superegg_trace::CompiledScene;
use thiserror::Error;

use crate::film::buffer::Film;
use crate::film::tile::{Tile, tiles};
use crate::render::worker::{RenderJob, Worker};
use crate::settings::{RenderSettings, SettingsError};
use crate::shade::path_resources::PathResources;
use crate::stats::TraceStats;

/// How a picture is rendered: threads, cancellation and progress. None of it changes the picture.
///
/// The default uses all available threads, cannot be cancelled and reports no progress.
#[derive(Clone, Copy, Default)]
#[non_exhaustive]
pub struct RenderOptions<'a> {
    /// Number of threads; 0 for all that are available.
    pub threads: usize,
    /// When this becomes true, the render stops; tiles that are not finished stay black.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with the number of finished pixels, from any thread.
    pub progress: Option<&'a (dyn Fn(u64) + Sync)>,
}

impl fmt::Debug for RenderOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { threads, cancel, progress } = self;
        let mut fields = f.debug_struct("RenderOptions");
        fields.field("threads", threads).field("cancel", cancel);
        fields.field("progress", &progress.map(|_| "Fn(u64)")).finish()
    }
}

impl<'a> RenderOptions<'a> {
    /// Sets the number of threads; 0 for all that are available.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Sets the flag that stops the render.
    #[must_use]
    pub fn with_cancel(self, cancel: &'a AtomicBool) -> Self {
        Self { cancel: Some(cancel), ..self }
    }

    /// Sets the function that is called with the number of finished pixels.
    #[must_use]
    pub fn with_progress(self, progress: &'a (dyn Fn(u64) + Sync)) -> Self {
        Self { progress: Some(progress), ..self }
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}

/// Why a picture was not rendered.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting that no picture can have.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The film does not have the size of the picture.
    #[error("the film has {} x {} pixels; expected {} x {}", .found.0, .found.1, .expected.0, .expected.1)]
    FilmSize {
        /// Width and height of the film.
        found: (u32, u32),
        /// Width and height of the picture.
        expected: (u32, u32),
    },
    /// The system does not start the threads.
    #[error("cannot start the threads: {0}")]
    Threads(Box<dyn std::error::Error + Send + Sync>),
}

/// A film and the counters of its render.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rendered {
    /// The film.
    pub film: Film,
    /// The counters.
    pub stats: TraceStats,
}

/// The tiles of a picture that are rendered, and their destination.
#[derive(Clone, Copy)]
pub struct TileWork<'a> {
    /// A film of the picture's size. Each finished tile is copied into it.
    pub film: &'a Mutex<Film>,
    /// Whether to render a tile, by its index in [`tiles`]. Other tiles stay as they are and cost
    /// no ray.
    pub wanted: &'a (dyn Fn(usize) -> bool + Sync),
    /// Called with the index and the pixels of each tile after it was copied, from the threads that
    /// trace, in any order.
    pub finished: &'a (dyn Fn(usize, &Film) + Sync),
}

/// Renders a compiled scene.
///
/// The film depends on scene and settings alone, to the bit: neither on the number of threads nor
/// on their order. Each call starts its own thread pool.
///
/// ```
/// use superegg_render::{RenderOptions, RenderSettings, render};
/// use superegg_scene::{Picture, Scene};
/// use superegg_trace::CompiledScene;
///
/// let mut scene = Scene::default();
/// scene.ensure_primitive("egg")?;
/// let compiled = CompiledScene::compile(&scene, Some("egg"), scene.depth);
/// let picture = Picture { width: 64, height: 48, samples: 1, ..Picture::default() };
/// let settings = RenderSettings::of(&scene).with_picture(picture);
/// let film = render(&compiled, &settings, &RenderOptions::default())?.film;
/// let center = film.pixel(32, 24).expect("a pixel inside the film");
/// // The camera is 10 units from the centre of the unit sphere; the ray passes half a pixel beside it.
/// assert!((center.depth - 9.0).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A setting is invalid ([`RenderSettings::validate`]), or the threads cannot be started.
pub fn render(
    scene: &CompiledScene,
    settings: &RenderSettings,
    options: &RenderOptions<'_>,
) -> Result<Rendered, RenderError> {
    settings.validate()?;
    let film = Mutex::new(settings.film());
    let work = TileWork { film: &film, wanted: &|_| true, finished: &|_, _| () };
    let stats = render_tiles(scene, settings, options, &work)?;
    Ok(Rendered { film: film.into_inner().unwrap_or_else(PoisonError::into_inner), stats })
}

/// The data that all pictures of a scene share, whatever their camera, size and samples: for paths the
/// shapes that shine, and tables of rough surfaces. The tables are computed at their first use, which
/// takes a part of a second: whoever renders a picture in many calls keeps them.
#[derive(Default)]
pub struct RenderResources(PathResources);

impl RenderResources {
    /// The resources of pictures with these settings.
    pub fn of(scene: &CompiledScene, settings: &RenderSettings) -> Self {
        Self(PathResources::of(scene, settings))
    }
}

impl fmt::Debug for RenderResources {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RenderResources").finish_non_exhaustive()
    }
}

/// Renders the wanted tiles of a picture. The pixels of a tile depend on scene and settings alone,
/// not on the other tiles.
///
/// # Errors
/// A setting is invalid, the film has another size, or the threads cannot be started.
pub fn render_tiles(
    scene: &CompiledScene,
    settings: &RenderSettings,
    options: &RenderOptions<'_>,
    work: &TileWork<'_>,
) -> Result<TraceStats, RenderError> {
    let resources = RenderResources::of(scene, &settings.for_output());
    render_tiles_with(scene, &resources, settings, options, work)
}

/// [`render_tiles`] with resources that are kept. They are those of the same scene and settings, but for
/// camera, size, samples and output.
///
/// # Errors
/// As for [`render_tiles`].
pub fn render_tiles_with(
    scene: &CompiledScene,
    RenderResources(paths): &RenderResources,
    settings: &RenderSettings,
    options: &RenderOptions<'_>,
    work: &TileWork<'_>,
) -> Result<TraceStats, RenderError> {
    settings.validate()?;
    let Picture { width, height, .. } = settings.picture;
    let found = {
        let film = work.film.lock().unwrap_or_else(PoisonError::into_inner);
        (film.width(), film.height())
    };
    if found != (width, height) {
        return Err(RenderError::FilmSize { found, expected: (width, height) });
    }
    let settings = &settings.for_output();
    let job = RenderJob::new(scene, settings, paths, options.cancel);
    let finished_pixels = AtomicU64::new(0);
    let stats = Mutex::new(TraceStats::default());
    let wanted: Vec<(usize, Tile)> =
        tiles(width, height).into_iter().enumerate().filter(|(index, _)| (work.wanted)(*index)).collect();
    // Tiles take very different times, so each thread takes the next one when it is done with its last.
    let next = AtomicUsize::new(0);
    let render_next_tiles = || {
        let mut worker = None;
        while let Some((index, tile)) = wanted.get(next.fetch_add(1, Ordering::Relaxed)) {
            if options.is_cancelled() {
                return;
            }
            let worker = worker.get_or_insert_with(|| Worker::new(&job));
            let Some((pixels, tile_stats)) = worker.render_tile(tile) else { return };
            let count = tile.pixel_count() as u64;
            work.film.lock().unwrap_or_else(PoisonError::into_inner).set_tile(tile, &pixels);
            *stats.lock().unwrap_or_else(PoisonError::into_inner) += tile_stats;
            (work.finished)(*index, &pixels);
            let finished = finished_pixels.fetch_add(count, Ordering::Relaxed) + count;
            if let Some(progress) = options.progress {
                progress(finished);
            }
        }
    };
    on_threads(options.threads, || {
        let threads = (0..rayon::current_num_threads()).into_par_iter();
        threads.with_max_len(1).for_each(|_| render_next_tiles());
    })?;
    Ok(stats.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Does work on a thread pool of its own; in the calling thread where the system has none, in WebAssembly.
fn on_threads(count: usize, work: impl FnOnce() + Send) -> Result<(), RenderError> {
    if cfg!(target_family = "wasm") {
        work();
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    pool.map_err(|error| RenderError::Threads(error.into()))?.install(work);
    Ok(())
}
