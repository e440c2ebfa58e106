//! A render whose finished tiles are kept, so that it can be stopped, killed and gone on with, or be one share of a picture.

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

use crate::commands::counted;
use crate::files;
use crate::part_file::{self, PartFile, Tiles};

/// A render that takes no longer leaves no partial file.
const SHORT: Duration = Duration::from_secs(2);

/// A render in progress, with what it had to begin with.
pub(crate) struct LongRender<'a> {
    /// Nothing is kept for what is no file.
    part: Option<PartFile<'a>>,
    /// `None` for the whole picture, which is another file than its tiles.
    share: Option<Shard>,
    tiles: Vec<Tile>,
    /// What a person sees where no tile is.
    blank: &'static str,
    /// What an earlier render did.
    had: Tiles,
    is_had: Vec<bool>,
    /// How many tiles this one has done.
    finished: AtomicUsize,
}

impl<'a> LongRender<'a> {
    /// The render of a picture, or of a share of one, into `output`; with `is_resumed` it goes on from what is there.
    ///
    /// # Errors
    /// There is nothing that it can go on from, or the partial file cannot be written.
    pub(crate) fn new(
        output: &Path,
        share: Option<Shard>,
        is_resumed: bool,
        picture: &Picture,
        header: impl FnOnce() -> PartHeader + Send + 'a,
        tell: &dyn Fn(&str),
    ) -> Result<Self> {
        let is_file = !files::is_standard_stream(output) && (output.is_file() || !output.exists());
        let part = match share {
            Some(_) => Some(output.to_owned()),
            None => is_file.then(|| part_file::beside(output)),
        };
        if part.is_none() && is_resumed {
            bail!("--resume needs a picture that is a file, and '{}' is none", output.display());
        }
        let tiles = tiles(picture.width, picture.height);
        let part = part.map(|path| PartFile::later(path, share.is_none(), header));
        let mut had = Tiles::new();
        if let Some(part) = &part {
            let name = part.path().display();
            let left = if is_resumed { part.resume()? } else { None };
            if is_resumed && left.is_none() {
                tell(&format!("there is no '{name}' to go on from; begun anew"));
            }
            if let Some(left) = left {
                had = left.tiles;
                let damage = match left.damaged {
                    0 => String::new(),
                    bytes => format!("; {} of it are damaged and left out", counted(bytes, "byte")),
                };
                tell(&format!("going on from '{name}' with {}{damage}", of_tiles(had.len(), tiles.len())));
            } else if is_resumed || share.is_some() {
                part.begin_now()?;
            } else if part.has_older() {
                tell(&format!(
                    "'{name}' is there from an earlier render; --resume would go on from it, this render is to take its place"
                ));
            }
        }
        let mut is_had = vec![false; tiles.len()];
        had.iter().for_each(|(tile, _)| is_had[*tile] = true);
        let blank = if picture.transparent { "transparent" } else { "black" };
        Ok(Self { part, share, tiles, blank, had, is_had, finished: AtomicUsize::new(0) })
    }

    fn takes(&self, tile: usize) -> bool {
        self.share.is_none_or(|share| share.takes(tile))
    }

    /// Whether a tile is still to be made.
    fn wants(&self, tile: usize) -> bool {
        self.takes(tile) && !self.is_had[tile]
    }

    /// How many pixels are to be made.
    pub(crate) fn wanted_pixels(&self) -> u64 {
        let wanted = self.tiles.iter().enumerate().filter(|(index, _)| self.wants(*index));
        wanted.map(|(_, tile)| tile.pixel_count() as u64).sum()
    }

    /// Makes what is to be made, until `cancel` of the options is set.
    ///
    /// # Errors
    /// The threads cannot be started, or a share cannot be written.
    pub(crate) fn render(
        &mut self,
        scene: &CompiledScene,
        settings: &RenderSettings,
        options: &RenderOptions<'_>,
        tell: &(dyn Fn(&str) + Sync),
    ) -> Result<(Film, TraceStats)> {
        let part = self.part.as_ref();
        let failure = Mutex::new(None);
        let tell_not_kept =
            |error: &anyhow::Error| tell(&format!("warning: finished tiles are not kept: {error:#}"));
        let finished = |index: usize, pixels: &Film| {
            self.finished.fetch_add(1, Ordering::Relaxed);
            let Some(Err(error)) = part.map(|part| part.add(index, pixels)) else { return };
            if self.share.is_some() {
                // Without its file the work is for nothing.
                if let Some(cancel) = options.cancel {
                    cancel.store(true, Ordering::Relaxed);
                }
                *failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            } else {
                tell_not_kept(&error);
            }
        };
        let film = Mutex::new(settings.film());
        let work = TileWork { film: &film, wanted: &|index| self.wants(index), finished: &finished };
        let pixels_of =
            |index: usize| film.lock().unwrap_or_else(PoisonError::into_inner).tile(&self.tiles[index]);
        let stats = std::thread::scope(|threads| {
            let (end, ended) = channel::<()>();
            // Beside the work, for telling what picture it is may take a while in a large scene.
            let pixels_of = &pixels_of;
            threads.spawn(move || {
                let is_long = ended.recv_timeout(SHORT) == Err(RecvTimeoutError::Timeout);
                if let Some(Err(error)) = part.filter(|_| is_long).map(|part| part.begin_late(pixels_of)) {
                    tell_not_kept(&error);
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
        for (index, pixels) in self.had.drain(..) {
            film.set_tile(&self.tiles[index], &pixels);
        }
        Ok((film, stats))
    }

    /// How many tiles are done, of all that it is to do.
    pub(crate) fn done(&self) -> (usize, usize) {
        let mine = || (0..self.tiles.len()).filter(|&tile| self.takes(tile));
        let had = mine().filter(|&tile| self.is_had[tile]).count();
        (had + self.finished.load(Ordering::Relaxed), mine().count())
    }

    /// Ends the work: writes the picture, or as much of it as there is, unless this is a share. The partial file stays where a later render is to go
    /// on from it, and else goes. Returns what to say of a render that was stopped.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn conclude(
        self,
        output: &Path,
        film: &Film,
        write: impl FnOnce() -> Result<()>,
    ) -> Result<Option<String>> {
        let (done, total) = self.done();
        let told = of_tiles(done, total);
        let Some(part) = self.part else {
            write()?;
            return Ok(
                (done < total).then(|| format!("{told} are done, the rest of the picture is {}", self.blank))
            );
        };
        let name = part.path().display().to_string();
        if self.share.is_some() {
            part.sync()?;
            return Ok((done < total).then(|| format!("{told} are in '{name}'; --resume goes on from there")));
        }
        if done == 0 {
            return Ok(Some("no tile was done, and nothing is written".to_owned()));
        }
        if done == total {
            match write() {
                Err(error) if part.is_kept() => {
                    bail!("{error:#}; the tiles are kept in '{name}', for --resume")
                }
                written => written?,
            }
            part.remove()?;
            return Ok(None);
        }
        let kept = part.keep(&|index| film.tile(&self.tiles[index])).and_then(|()| part.sync());
        write()?;
        let next = match kept {
            Ok(()) if part.is_kept() => format!("--resume goes on from '{name}'"),
            Ok(()) => format!("they are not kept, '{name}' is still that of an earlier render"),
            Err(error) => format!("they are not kept: {error:#}"),
        };
        Ok(Some(format!("{told} are done, the rest of '{}' is {}; {next}", output.display(), self.blank)))
    }
}

/// "120 of 300 tiles".
pub(crate) fn of_tiles(done: usize, total: usize) -> String {
    format!("{done} of {}", counted(total, "tile"))
}
