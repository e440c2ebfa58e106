//! `superegg merge`: merges the shards of a picture.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, bail, ensure};
use superegg_render::{ExrPicture, Film, PartHeader, Pixel, RenderSettings, Tile};
use superegg_scene::{Picture, Scene};

use crate::args::MergeArgs;
use crate::console;
use crate::denoise;
use crate::files;
use crate::files::notes::notes;
use crate::files::picture::PictureFormat;
use crate::long::checkpoint::{CheckpointData, describe_difference, read};
use crate::long::resumable::tile_progress;
use crate::outcome::Outcome;
use crate::text::counted;

pub(crate) fn run(args: &MergeArgs) -> Result<Outcome> {
    for part in &args.parts {
        files::check_output(Some(&args.output), part, args.overwrite.into())?;
    }
    let format = PictureFormat::of(&args.output)?;
    let merged = MergedTiles::read(&args.parts)?;
    let missing = merged.describe_missing();
    if let Some(missing) = &missing {
        ensure!(args.partial, "{missing}; --partial writes what there is");
        ensure!(!merged.tiles.is_empty(), "{missing}, so there is nothing to write");
        console::warn(format_args!("superegg: warning: {missing}"));
    }
    let picture = args.develop.apply(*merged.header.picture());
    let far_depth = args.far_depth.unwrap_or(picture.far_depth);
    let picture = Picture { far_depth, ..picture };
    // The tiles contain the effect of all other settings of the scene.
    let settings = RenderSettings::of(&Scene::default())
        .with_picture(picture)
        .with_output(merged.header.output())
        .with_layers(merged.has_layers);
    ensure!(
        settings.keeps_layers() || format != PictureFormat::Exr,
        "not all tiles have depth and normals, because some were made for a .png: name a .png file, or render them again for an .exr"
    );
    denoise::check(&settings)?;
    let file = match (format, missing) {
        (PictureFormat::Exr, missing) if missing.is_some() || !denoise::is_wanted(&settings) => {
            merged.exr(&settings)?
        }
        (_, None) => {
            let film = merged.into_film(settings.film());
            format.encode(&film, &settings, &notes(&settings, denoise::applies(&film, &settings), None))?
        }
        (_, Some(_)) => merged.incomplete_png(&settings)?,
    };
    files::write(&args.output, &file)?;
    if !args.quiet && !files::is_standard_stream(&args.output) {
        let (width, height) = (picture.width, picture.height);
        let parts = counted(args.parts.len(), "partial file");
        console::print(format_args!("{}: {width}x{height}, from {parts}", args.output.display()))?;
    }
    Ok(Outcome::Fine)
}

/// The tiles of one picture from several partial files.
struct MergedTiles {
    header: PartHeader,
    tiles: HashMap<usize, Film>,
    /// The number of shards, if all files agree.
    shard_count: Option<u32>,
    /// Whether all pixels have AOV layers.
    has_layers: bool,
    /// Whether all pixels have small numbers of instances and objects, which older programs did not write.
    has_numbers: bool,
}

impl MergedTiles {
    /// Reads all tiles of these files.
    ///
    /// # Errors
    /// A file is unreadable, belongs to another picture, or has other pixels for the same tile.
    fn read(paths: &[PathBuf]) -> Result<Self> {
        let mut merged: Option<Self> = None;
        for path in paths {
            let data = read(path)?;
            if data.damaged_bytes > 0 {
                console::warn(format_args!(
                    "superegg: warning: {} of '{}' are damaged and left out",
                    counted(data.damaged_bytes, "byte"),
                    path.display()
                ));
            }
            merged.get_or_insert_with(|| Self::empty(&data.header)).add(data, &paths[0], path)?;
        }
        merged.ok_or_else(|| anyhow!("there is nothing to merge"))
    }

    fn empty(header: &PartHeader) -> Self {
        let shard_count = Some(header.shard.count());
        let (header, tiles) = (header.clone(), HashMap::new());
        Self { header, tiles, shard_count, has_layers: true, has_numbers: true }
    }

    /// Adds the tiles of the file at `path`; `first` is the path of the first file.
    fn add(&mut self, data: CheckpointData, first: &Path, path: &Path) -> Result<()> {
        self.has_layers &= data.header.has_layers();
        self.has_numbers &= data.header.has_numbers();
        self.shard_count = self.shard_count.filter(|known| *known == data.header.shard.count());
        let (one, two) = (first.display(), path.display());
        if let Some(difference) = self.header.difference_of_light(&data.header) {
            let text = describe_difference(&difference, &format!("in '{one}'"), &format!("in '{two}'"));
            bail!("'{one}' and '{two}' are of different pictures: {text}");
        }
        for (index, pixels) in data.tiles {
            ensure!(
                self.tiles.get(&index).is_none_or(|known| self.is_same(known, &pixels)),
                "tile {index} is in '{two}' and in a file before it, and not the same: they were made by different programs or on different kinds of machines; leave one of them out"
            );
            self.tiles.insert(index, pixels);
        }
        Ok(())
    }

    /// Whether two tiles have equal pixels; layers count only if all files have them.
    fn is_same(&self, a: &Film, b: &Film) -> bool {
        let bytes = |pixel: Pixel| {
            let Pixel { color, alpha, samples, .. } = pixel;
            let light = Pixel { color, alpha, samples, ..Pixel::EMPTY };
            if self.has_layers { pixel.to_bytes() } else { light.to_bytes() }
        };
        a.pixels().map(bytes).eq(b.pixels().map(bytes))
    }

    /// Describes the missing tiles and shards; `None` for a complete picture.
    fn describe_missing(&self) -> Option<String> {
        let total = self.header.tiles().len();
        let missing: Vec<usize> = (0..total).filter(|tile| !self.tiles.contains_key(tile)).collect();
        if missing.is_empty() {
            return None;
        }
        let text =
            format!("the picture is not complete: there are {}", tile_progress(self.tiles.len(), total));
        let Some(count) = self.shard_count.filter(|&count| count > 1) else { return Some(text) };
        let shards: BTreeSet<u32> =
            missing.iter().map(|tile| (*tile as u64 % u64::from(count)) as u32 + 1).collect();
        Some(format!("{text}; of {count} shards these are missing or not complete: {}", in_ranges(&shards)))
    }

    /// Encodes an OpenEXR file, in memory for the tiles that there are: the size of the picture is only a claim of the
    /// header.
    fn exr(&self, settings: &RenderSettings) -> Result<Vec<u8>> {
        let (width, height) = (settings.picture.width, settings.picture.height);
        // Every tile but the last of a row or column has the size of the first one.
        let (tile_width, tile_height) = self.header.tiles().first().map_or((1, 1), Tile::size);
        let across = width.div_ceil(tile_width);
        let film_at = |x: u32, y: u32| {
            let index = y / tile_height * across + x / tile_width;
            Some((self.tiles.get(&(index as usize))?, x % tile_width, y % tile_height))
        };
        let picture = ExrPicture {
            size: (width, height),
            film_at: &film_at,
            films: self.tiles.values().collect(),
            has_numbers: self.has_numbers,
            has_passes: self.has_numbers && self.header.has_passes(),
            has_mattes: self.has_numbers && self.header.has_mattes(),
            far_depth: settings.picture.far_depth,
        };
        Ok(picture.encode(&notes(settings, false, None))?)
    }

    /// Encodes a PNG file of a picture that lacks tiles, in memory for one row of tiles.
    fn incomplete_png(&self, settings: &RenderSettings) -> Result<Vec<u8>> {
        let (width, height) = (settings.picture.width, settings.picture.height);
        let all = self.header.tiles();
        let coloring = settings.output.coloring(self.tiles.values());
        let mut first = 0;
        let strips = all.chunk_by(|a, b| a.y == b.y).map(|row| {
            let strip = self.strip(first, row, settings);
            first += row.len();
            coloring.apply(&strip).into_owned()
        });
        Ok(settings.development().png_of_strips((width, height), strips, &notes(settings, false, None))?)
    }

    /// The film of one row of tiles; the first one has this index.
    fn strip(&self, first: usize, row: &[Tile], settings: &RenderSettings) -> Film {
        let height = row.first().map_or(0, |tile| tile.size().1);
        let picture = Picture { height, ..settings.picture };
        let mut film = settings.clone().with_picture(picture).film();
        for (index, tile) in (first..).zip(row) {
            if let Some(pixels) = self.tiles.get(&index) {
                film.set_tile(&Tile { x: tile.x.clone(), y: 0..height }, pixels);
            }
        }
        film
    }

    /// Copies the tiles into an empty film.
    fn into_film(mut self, mut film: Film) -> Film {
        for (index, tile) in self.header.tiles().iter().enumerate() {
            if let Some(pixels) = self.tiles.remove(&index) {
                film.set_tile(tile, &pixels);
            }
        }
        film
    }
}

/// Formats numbers as ranges, as schedulers accept them: "1,3-5".
fn in_ranges(numbers: &BTreeSet<u32>) -> String {
    let mut text = String::new();
    for &number in numbers {
        let is_first = number == 0 || !numbers.contains(&(number - 1));
        let is_last = number == u32::MAX || !numbers.contains(&(number + 1));
        let before = match (is_first, is_last) {
            (true, _) if text.is_empty() => "",
            (true, _) => ",",
            (false, true) => "-",
            (false, false) => continue,
        };
        // Writing to a String cannot fail.
        let _ = write!(text, "{before}{number}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_ranges() {
        for (numbers, text) in [
            (&[][..], ""),
            (&[3], "3"),
            (&[1, 2], "1-2"),
            (&[1, 3, 4, 5, 7, 9, 10], "1,3-5,7,9-10"),
            (&[0, u32::MAX - 1, u32::MAX], "0,4294967294-4294967295"),
        ] {
            assert_eq!(in_ranges(&numbers.iter().copied().collect()), text);
        }
    }
}
