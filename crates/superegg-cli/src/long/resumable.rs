//! A render that keeps its finished tiles, so that it can be stopped and resumed, or render one
//! shard.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Result, bail};
use superegg_render::{
    Film, PartHeader, RenderOptions, RenderSettings, Shard, Tile, TileWork, TraceStats, render_tiles, tiles,
};
use superegg_scene::Picture;
use superegg_trace::CompiledScene;

use crate::files;
use crate::long::checkpoint::{Checkpoint, Tiles, checkpoint_path};
use crate::text::counted;

/// A shorter render leaves no partial file.
const CHECKPOINT_DELAY: Duration = Duration::from_secs(2);

/// A render in progress, with the tiles of an earlier render.
pub(crate) struct ResumableRender<'a> {
    /// `None` if the output is not a file.
    checkpoint: Option<Checkpoint<'a>>,
    /// `None` for a picture; the whole picture as shard 1/1 is a partial file.
    shard: Option<Shard>,
    tiles: Vec<Tile>,
    /// How a missing tile looks: "black" or "transparent".
    blank: &'static str,
    /// The tiles of the earlier render.
    resumed: Tiles,
    is_resumed: Vec<bool>,
    /// The number of tiles that this render has finished.
    finished: AtomicUsize,
}

impl<'a> ResumableRender<'a> {
    /// A render of a picture, or of a shard of one, into `output`. With `resume` it continues an
    /// earlier render.
    ///
    /// # Errors
    /// The earlier render cannot be continued, or the partial file cannot be written.
    pub(crate) fn new(
        output: &Path,
        shard: Option<Shard>,
        resume: bool,
        picture: &Picture,
        header: impl FnOnce() -> PartHeader + Send + 'a,
        inform: &dyn Fn(&str),
    ) -> Result<Self> {
        let is_file = !files::is_standard_stream(output) && (output.is_file() || !output.exists());
        let path = match shard {
            Some(_) => Some(output.to_owned()),
            None => is_file.then(|| checkpoint_path(output)),
        };
        if path.is_none() && resume {
            bail!("--resume needs a picture that is a file, and '{}' is none", output.display());
        }
        let tiles = tiles(picture.width, picture.height);
        let checkpoint = path.map(|path| Checkpoint::deferred(path, shard.is_none(), header));
        let resumed = match &checkpoint {
            Some(checkpoint) if resume => resume_from(checkpoint, tiles.len(), inform)?,
            Some(checkpoint) => {
                if shard.is_some() {
                    checkpoint.create_now()?;
                } else if checkpoint.has_older() {
                    let name = checkpoint.path().display();
                    inform(&format!(
                        "'{name}' is there from an earlier render; --resume would go on from it, this render replaces it"
                    ));
                }
                Tiles::new()
            }
            None => Tiles::new(),
        };
        let mut is_resumed = vec![false; tiles.len()];
        resumed.iter().for_each(|(tile, _)| is_resumed[*tile] = true);
        let blank = if picture.transparent { "transparent" } else { "black" };
        Ok(Self { checkpoint, shard, tiles, blank, resumed, is_resumed, finished: AtomicUsize::new(0) })
    }

    /// Whether a tile belongs to this render.
    fn is_mine(&self, tile: usize) -> bool {
        self.shard.is_none_or(|shard| shard.takes(tile))
    }

    /// Whether a tile must be rendered.
    fn is_wanted(&self, tile: usize) -> bool {
        self.is_mine(tile) && !self.is_resumed[tile]
    }

    /// The number of pixels to render.
    pub(crate) fn wanted_pixels(&self) -> u64 {
        let wanted = self.tiles.iter().enumerate().filter(|(index, _)| self.is_wanted(*index));
        wanted.map(|(_, tile)| tile.pixel_count() as u64).sum()
    }

    /// Renders the wanted tiles until `options.cancel` becomes true. `warn` prints a warning.
    ///
    /// # Errors
    /// The threads cannot be started, or a shard cannot be written.
    pub(crate) fn render(
        &mut self,
        scene: &CompiledScene,
        settings: &RenderSettings,
        options: &RenderOptions<'_>,
        warn: &(dyn Fn(&str) + Sync),
    ) -> Result<(Film, TraceStats)> {
        let checkpoint = self.checkpoint.as_ref();
        let failure = Mutex::new(None);
        let warn_not_kept =
            |error: &anyhow::Error| warn(&format!("warning: finished tiles are not kept: {error:#}"));
        let finished = |index: usize, pixels: &Film| {
            self.finished.fetch_add(1, Ordering::Relaxed);
            let Some(Err(error)) = checkpoint.map(|checkpoint| checkpoint.add(index, pixels)) else { return };
            if self.shard.is_some() {
                // The file is the only result of a shard.
                if let Some(cancel) = options.cancel {
                    cancel.store(true, Ordering::Relaxed);
                }
                *failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            } else {
                warn_not_kept(&error);
            }
        };
        let film = Mutex::new(settings.film());
        let work = TileWork { film: &film, wanted: &|index| self.is_wanted(index), finished: &finished };
        let pixels_of =
            |index: usize| film.lock().unwrap_or_else(PoisonError::into_inner).tile(&self.tiles[index]);
        let stats = std::thread::scope(|threads| {
            let (end, ended) = channel::<()>();
            // A separate thread, because the header of a large scene takes a while.
            let pixels_of = &pixels_of;
            threads.spawn(move || {
                let is_long = ended.recv_timeout(CHECKPOINT_DELAY) == Err(RecvTimeoutError::Timeout);
                let created = checkpoint.filter(|_| is_long).map(|file| file.create_if_missing(pixels_of));
                if let Some(Err(error)) = created {
                    warn_not_kept(&error);
                }
            });
            let stats = render_tiles(scene, settings, options, &work);
            drop(end);
            stats
        });
        if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        let stats = stats?;
        let mut film = film.into_inner().unwrap_or_else(PoisonError::into_inner);
        for (index, pixels) in self.resumed.drain(..) {
            film.set_tile(&self.tiles[index], &pixels);
        }
        Ok((film, stats))
    }

    /// The number of finished tiles, and of all tiles of this render.
    fn done(&self) -> (usize, usize) {
        let mine = || (0..self.tiles.len()).filter(|&tile| self.is_mine(tile));
        let resumed = mine().filter(|&tile| self.is_resumed[tile]).count();
        (resumed + self.finished.load(Ordering::Relaxed), mine().count())
    }

    /// Ends the render: writes the picture, complete or not, unless this is a shard. Removes the
    /// partial file of a complete picture and keeps it otherwise. Returns the message of a stopped
    /// render.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn finish(
        self,
        output: &Path,
        film: &Film,
        write: impl FnOnce() -> Result<()>,
    ) -> Result<Option<String>> {
        let (done, total) = self.done();
        let progress = tile_progress(done, total);
        let Some(checkpoint) = self.checkpoint else {
            write()?;
            let message = format!("{progress} are done, the rest of the picture is {}", self.blank);
            return Ok((done < total).then_some(message));
        };
        let name = checkpoint.path().display().to_string();
        if self.shard.is_some() {
            checkpoint.sync()?;
            let message = format!("{progress} are in '{name}'; --resume goes on from there");
            return Ok((done < total).then_some(message));
        }
        if done == 0 {
            return Ok(Some("no tile was done, and nothing is written".to_owned()));
        }
        if done == total {
            match write() {
                Err(error) if checkpoint.is_complete() => {
                    bail!("{error:#}; the tiles are kept in '{name}', for --resume")
                }
                written => written?,
            }
            checkpoint.remove()?;
            return Ok(None);
        }
        let kept = checkpoint.keep(&|index| film.tile(&self.tiles[index])).and_then(|()| checkpoint.sync());
        write()?;
        let next = match kept {
            Ok(()) if checkpoint.is_complete() => format!("--resume goes on from '{name}'"),
            Ok(()) => format!("they are not kept, '{name}' is still that of an earlier render"),
            Err(error) => format!("they are not kept: {error:#}"),
        };
        let output = output.display();
        Ok(Some(format!("{progress} are done, the rest of '{output}' is {}; {next}", self.blank)))
    }
}

/// The tiles of the partial file of an earlier render. Without one, starts a new file.
fn resume_from(checkpoint: &Checkpoint<'_>, total: usize, inform: &dyn Fn(&str)) -> Result<Tiles> {
    let name = checkpoint.path().display();
    let Some(data) = checkpoint.resume()? else {
        inform(&format!("there is no '{name}' to go on from; begun anew"));
        checkpoint.create_now()?;
        return Ok(Tiles::new());
    };
    let damage = match data.damaged_bytes {
        0 => String::new(),
        bytes => format!("; {} of it are damaged and left out", counted(bytes, "byte")),
    };
    inform(&format!("going on from '{name}' with {}{damage}", tile_progress(data.tiles.len(), total)));
    Ok(data.tiles)
}

/// "120 of 300 tiles".
pub(crate) fn tile_progress(done: usize, total: usize) -> String {
    format!("{done} of {}", counted(total, "tile"))
}
