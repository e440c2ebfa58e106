//! The bytes of a tile in a partial file.
//!
//! ```text
//! for each pixel           Pixel::to_bytes; 52 bytes in versions 2 and 3, which lack the two small numbers
//! with passes, for each    LightPasses::to_bytes
//! with mattes, for each    the number of instances u8, that of objects u8, then for each id u32 and share f32
//!          at their end    for each name, to the end of the bytes: id u32, length u16, UTF-8
//! ```

use crate::film::buffer::Film;
use crate::film::matte::{Coverage, LONGEST_NAME, MATTE_RANKS, MatteLevel, Mattes};
use crate::film::pixel::{LightPasses, Pixel};

/// The parts of the tiles of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileParts {
    /// Whether pixels have small numbers of instances and objects.
    pub(crate) numbers: bool,
    pub(crate) passes: bool,
    pub(crate) mattes: bool,
}

/// The bytes of a pixel without small numbers.
const WITHOUT_NUMBERS: usize = Pixel::BYTES - 8;
/// The most bytes of the matte of a pixel.
const MOST_MATTE: usize = 2 + 2 * MATTE_RANKS * 8;
/// The most bytes of the names of a pixel.
const MOST_NAMES: usize = 2 * MATTE_RANKS * (6 + LONGEST_NAME);

impl TileParts {
    /// The bytes of each pixel without its matte.
    fn fixed(self) -> usize {
        let pixel = if self.numbers { Pixel::BYTES } else { WITHOUT_NUMBERS };
        pixel + if self.passes { LightPasses::BYTES } else { 0 }
    }

    /// Whether a tile of so many pixels can have so many bytes.
    pub(crate) fn is_length(self, length: usize, pixels: usize) -> bool {
        let fixed = pixels * self.fixed();
        if self.mattes { (fixed..=self.most_bytes(pixels)).contains(&length) } else { length == fixed }
    }

    /// The most bytes of a tile of so many pixels.
    pub(crate) fn most_bytes(self, pixels: usize) -> usize {
        pixels * (self.fixed() + if self.mattes { MOST_MATTE + MOST_NAMES } else { 0 })
    }

    /// The bytes of a tile.
    pub(crate) fn to_bytes(self, tile: &Film) -> Vec<u8> {
        let pixel_bytes = self.fixed() - if self.passes { LightPasses::BYTES } else { 0 };
        let mut bytes = Vec::with_capacity(tile.pixels().len() * self.fixed());
        tile.pixels().for_each(|pixel| bytes.extend_from_slice(&pixel.to_bytes()[..pixel_bytes]));
        let positions = || (0..tile.height()).flat_map(|y| (0..tile.width()).map(move |x| (x, y)));
        if self.passes {
            let passes = positions().map(|(x, y)| tile.passes(x, y).unwrap_or_default());
            passes.for_each(|passes| bytes.extend(passes.to_bytes()));
        }
        if self.mattes {
            for (x, y) in positions() {
                let levels = MatteLevel::ALL.map(|level| tile.matte(level, x, y));
                bytes.extend(levels.map(|things| things.len() as u8));
                for Coverage { id, share } in levels.concat() {
                    bytes.extend(id.to_le_bytes());
                    bytes.extend(share.to_le_bytes());
                }
            }
            for (id, name) in tile.matte_names() {
                bytes.extend(id.to_le_bytes());
                bytes.extend((name.len() as u16).to_le_bytes());
                bytes.extend(name.as_bytes());
            }
        }
        bytes
    }

    /// The tile of this size that [`TileParts::to_bytes`] wrote; `None` if the bytes are not those of one.
    pub(crate) fn film(self, (width, height): (u32, u32), bytes: &[u8]) -> Option<Film> {
        let count = width as usize * height as usize;
        let pixel_bytes = if self.numbers { Pixel::BYTES } else { WITHOUT_NUMBERS };
        let (pixels, rest) = bytes.split_at_checked(count * pixel_bytes)?;
        let pixels = pixels.chunks_exact(pixel_bytes).map(|bytes| {
            let mut whole = [0; Pixel::BYTES];
            whole[..pixel_bytes].copy_from_slice(bytes);
            Pixel::from_bytes(&whole)
        });
        let film = Film::of_pixels(width, height, pixels);
        let (passes, rest) =
            rest.split_at_checked(if self.passes { count * LightPasses::BYTES } else { 0 })?;
        let (passes, _) = passes.as_chunks();
        let film = film.with_passes(passes.iter().map(LightPasses::from_bytes).collect());
        if self.mattes {
            Some(film.with_mattes(mattes_of(count, rest)?))
        } else {
            rest.is_empty().then_some(film)
        }
    }
}

/// The mattes of so many pixels.
fn mattes_of(count: usize, mut bytes: &[u8]) -> Option<Mattes> {
    let mut mattes = Mattes::new(count);
    for pixel in 0..count {
        let [instances, objects] = take(&mut bytes)?;
        let mut things = |count: u8| -> Option<Vec<Coverage>> {
            let mut thing = || {
                let id = u32::from_le_bytes(take(&mut bytes)?);
                Some(Coverage { id, share: f32::from_le_bytes(take(&mut bytes)?) })
            };
            (0..count).map(|_| thing()).collect()
        };
        let levels = [things(instances)?, things(objects)?];
        mattes.set(pixel, levels.each_ref().map(Vec::as_slice));
    }
    while !bytes.is_empty() {
        let id = u32::from_le_bytes(take(&mut bytes)?);
        let length = usize::from(u16::from_le_bytes(take(&mut bytes)?));
        let (name, rest) = bytes.split_at_checked(length)?;
        mattes.add_names([(id, std::str::from_utf8(name).ok()?)]);
        bytes = rest;
    }
    Some(mattes)
}

/// Takes the first bytes.
fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tile with all parts.
    fn tile() -> Film {
        let thing = |id| Coverage { id, share: 0.25 };
        let mut mattes = Mattes::new(6);
        mattes.set(1, [&[thing(7), thing(8)], &[thing(9)]]);
        mattes.set(5, [&[thing(7)], &[]]);
        mattes.add_names([(7, "all/ball"), (9, "ä")]);
        let pixel = |i| Pixel { depth: i as f32, instance: i, object: 2 * i, samples: 4, ..Pixel::EMPTY };
        let passes =
            |i: u32| LightPasses { emission: [i as f32; 3], direct: [0.5; 3], indirect: [0.25, 0.0, -0.0] };
        let film = Film::of_pixels(3, 2, (0..6).map(pixel));
        film.with_passes((0..6).map(passes).collect()).with_mattes(mattes)
    }

    #[test]
    fn tiles_of_any_parts_are_read_back() {
        let tile = tile();
        for bits in 0..8 {
            let parts = TileParts { numbers: bits & 1 > 0, passes: bits & 2 > 0, mattes: bits & 4 > 0 };
            let bytes = parts.to_bytes(&tile);
            assert!(parts.is_length(bytes.len(), 6) && bytes.len() <= parts.most_bytes(6));
            let read = parts.film((3, 2), &bytes).unwrap();
            assert_eq!(parts.to_bytes(&read), bytes);
            assert_eq!((read.has_passes(), read.has_mattes()), (parts.passes, parts.mattes));
            assert_eq!(read == tile, bits == 7);
            assert_eq!(read.matte_names().eq(tile.matte_names()), parts.mattes);
            assert_eq!(read.pixel(2, 1).unwrap().instance, if parts.numbers { 5 } else { 0 });
        }
    }

    #[test]
    fn bytes_that_are_cut_off_or_too_long_are_no_tile() {
        let tile = tile();
        let parts = TileParts { numbers: true, passes: true, mattes: true };
        let bytes = parts.to_bytes(&tile);
        let names: usize = tile.matte_names().map(|(_, name)| 6 + name.len()).sum();
        for length in 0..bytes.len() {
            let read = parts.film((3, 2), &bytes[..length]);
            // Names may end after any of them.
            let ends = [bytes.len() - names, bytes.len() - "ä".len() - 6];
            assert_eq!(read.is_some(), ends.contains(&length), "{length}");
        }
        let parts = TileParts { mattes: false, ..parts };
        let bytes = [parts.to_bytes(&tile), vec![0]].concat();
        assert!(parts.film((3, 2), &bytes).is_none() && !parts.is_length(bytes.len(), 6));
    }
}
