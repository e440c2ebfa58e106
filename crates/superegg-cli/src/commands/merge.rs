//! `superegg merge`: shares of a picture into the picture.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use superegg_render::{Film, PartHeader, Pixel, RenderSettings};
use superegg_scene::Scene;

use crate::args::MergeArgs;
use crate::console;
use crate::files;
use crate::files::picture::PictureFormat;
use crate::long::checkpoint::{self, describe_difference};
use crate::long::resumable::tile_progress;
use crate::outcome::Outcome;
use crate::text::counted;

pub(crate) fn run(args: &MergeArgs) -> Result<Outcome> {
    for part in &args.parts {
        files::check_output(Some(&args.output), part)?;
    }
    let format = PictureFormat::of(&args.output)?;
    let merged = Merged::read(&args.parts)?;
    let missing = merged.missing();
    if let Some(missing) = &missing {
        ensure!(args.partial, "{missing}; --partial writes what there is");
        console::warn(format_args!("superegg: warning: {missing}"));
    }
    let picture = args.develop.change(*merged.header.picture());
    // What else a scene has is in the tiles already.
    let settings = RenderSettings::of(&Scene::default())
        .with_picture(picture)
        .with_output(merged.header.output())
        .with_layers(merged.has_layers);
    ensure!(
        settings.keeps_layers() || format != PictureFormat::Exr,
        "not all tiles have depth and normals, for some were made for a .png; name one of those, or render them again for an .exr"
    );
    files::write(&args.output, &format.encode(&merged.film(settings.film()), &settings)?)?;
    if !args.quiet && !files::is_standard_stream(&args.output) {
        let (width, height) = (picture.width, picture.height);
        let parts = counted(args.parts.len(), "partial file");
        console::print(format_args!("{}: {width}x{height}, from {parts}", args.output.display()))?;
    }
    Ok(Outcome::Fine)
}

/// Tiles of one picture.
struct Merged {
    header: PartHeader,
    tiles: HashMap<usize, Film>,
    /// How many shares there are, where all files agree on it.
    shares: Option<u32>,
    /// Whether all pixels have more than their light.
    has_layers: bool,
}

impl Merged {
    /// All tiles of these files.
    fn read(paths: &[PathBuf]) -> Result<Self> {
        let mut merged: Option<Self> = None;
        for path in paths {
            let part = checkpoint::read(path)?;
            if part.damaged_bytes > 0 {
                let (name, bytes) = (path.display(), counted(part.damaged_bytes, "byte"));
                console::warn(format_args!(
                    "superegg: warning: {bytes} of '{name}' are damaged and left out"
                ));
            }
            let shares = part.header.shard.count();
            let merged = merged.get_or_insert_with(|| Self {
                header: part.header.clone(),
                tiles: HashMap::new(),
                shares: Some(shares),
                has_layers: true,
            });
            merged.has_layers &= part.header.has_layers();
            merged.shares = merged.shares.filter(|known| *known == shares);
            let (one, two) = (paths[0].display(), path.display());
            if let Some(difference) = merged.header.difference_of_light(&part.header) {
                let told = describe_difference(&difference, &format!("in '{one}'"), &format!("in '{two}'"));
                bail!("'{one}' and '{two}' are of different pictures: {told}");
            }
            for (index, pixels) in part.tiles {
                let bytes = |pixel: Pixel| {
                    let Pixel { color, alpha, samples, .. } = pixel;
                    let light = Pixel { color, alpha, samples, ..Pixel::EMPTY };
                    if merged.has_layers { pixel.to_bytes() } else { light.to_bytes() }
                };
                let is_same = |known: &Film| known.pixels().map(bytes).eq(pixels.pixels().map(bytes));
                ensure!(
                    merged.tiles.get(&index).is_none_or(is_same),
                    "tile {index} is in '{two}' and in a file before it, and not the same: they were made by different programs or on different kinds of machines; leave one of them out"
                );
                merged.tiles.insert(index, pixels);
            }
        }
        match merged {
            Some(merged) => Ok(merged),
            None => bail!("there is nothing to merge"),
        }
    }

    /// What is missing of the picture, in words.
    fn missing(&self) -> Option<String> {
        let total = self.header.tiles().len();
        let missing: Vec<usize> = (0..total).filter(|tile| !self.tiles.contains_key(tile)).collect();
        if missing.is_empty() {
            return None;
        }
        let told =
            format!("the picture is not complete: there are {}", tile_progress(self.tiles.len(), total));
        let Some(count) = self.shares.filter(|&count| count > 1) else { return Some(told) };
        let short: BTreeSet<u32> =
            missing.iter().map(|tile| (*tile as u64 % u64::from(count)) as u32 + 1).collect();
        Some(format!("{told}; of {count} shards these are missing or not complete: {}", in_ranges(&short)))
    }

    fn film(mut self, mut film: Film) -> Film {
        for (index, tile) in self.header.tiles().iter().enumerate() {
            if let Some(pixels) = self.tiles.remove(&index) {
                film.set_tile(tile, &pixels);
            }
        }
        film
    }
}

/// Numbers as schedulers take them: "1,3-5".
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
