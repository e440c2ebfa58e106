//! The channels of OpenEXR files, as many as a picture has.

use std::ops::Range;

use exr::block::BlockIndex;
use exr::image::write::channels::{ChannelsWriter, WritableChannels};
use exr::math::RoundingMode;
use exr::meta::attribute::{ChannelDescription, ChannelList, LevelMode, SampleType};
use exr::meta::header::Header;

use crate::film::buffer::Film;
use crate::film::matte::{MATTE_RANKS, MatteLevel};
use crate::film::pixel::{LightPasses, Pixel};

/// A pixel of a film with all that the film keeps.
pub(crate) struct FilmPixel<'f> {
    pixel: Pixel,
    passes: LightPasses,
    place: Option<(&'f Film, u32, u32)>,
}

impl<'f> FilmPixel<'f> {
    /// The pixel in a column and row of a film. `far_depth` replaces an infinite depth unless it is 0.
    pub(crate) fn new(place: Option<(&'f Film, u32, u32)>, far_depth: f64) -> Self {
        let mut pixel = place.and_then(|(film, x, y)| film.pixel(x, y)).unwrap_or(Pixel::EMPTY);
        if far_depth > 0.0 && !pixel.depth.is_finite() {
            pixel.depth = far_depth as f32;
        }
        let passes = place.and_then(|(film, x, y)| film.passes(x, y)).unwrap_or_default();
        Self { pixel, passes, place }
    }
}

/// The values of a channel.
#[derive(Clone, Copy)]
enum Values {
    Float(fn(&FilmPixel<'_>) -> f32),
    Whole(fn(&FilmPixel<'_>) -> u32),
    /// The id of the thing of this rank, or with `true` its share.
    Matte(MatteLevel, usize, bool),
}

impl Values {
    /// The four bytes of a value.
    fn bytes(self, pixel: &FilmPixel<'_>) -> [u8; 4] {
        match self {
            Self::Float(of) => of(pixel).to_ne_bytes(),
            Self::Whole(of) => of(pixel).to_ne_bytes(),
            Self::Matte(level, rank, is_share) => {
                let thing = pixel.place.and_then(|(film, x, y)| film.matte(level, x, y).get(rank).copied());
                let thing = thing.unwrap_or_default();
                if is_share { thing.share.to_ne_bytes() } else { thing.id.to_ne_bytes() }
            }
        }
    }
}

/// The channels of a picture, whose pixels `at` returns by column and row.
pub(crate) struct Channels<F> {
    /// Sorted by name.
    list: Vec<(String, Values)>,
    at: F,
}

/// Channels that every file has.
const ALWAYS: [(&str, Values); 13] = [
    ("R", Values::Float(|p| p.pixel.color[0])),
    ("G", Values::Float(|p| p.pixel.color[1])),
    ("B", Values::Float(|p| p.pixel.color[2])),
    ("A", Values::Float(|p| p.pixel.alpha)),
    ("Z", Values::Float(|p| p.pixel.depth)),
    ("N.X", Values::Float(|p| p.pixel.normal[0])),
    ("N.Y", Values::Float(|p| p.pixel.normal[1])),
    ("N.Z", Values::Float(|p| p.pixel.normal[2])),
    ("albedo.R", Values::Float(|p| p.pixel.albedo[0])),
    ("albedo.G", Values::Float(|p| p.pixel.albedo[1])),
    ("albedo.B", Values::Float(|p| p.pixel.albedo[2])),
    ("id", Values::Whole(|p| p.pixel.id)),
    ("samples", Values::Whole(|p| p.pixel.samples)),
];

/// Small numbers, which floats hold exactly.
const NUMBERS: [(&str, Values); 2] = [
    ("instance", Values::Float(|p| p.pixel.instance as f32)),
    ("object", Values::Float(|p| p.pixel.object as f32)),
];

/// The parts of light.
const PASSES: [(&str, Values); 9] = [
    ("emission.R", Values::Float(|p| p.passes.emission[0])),
    ("emission.G", Values::Float(|p| p.passes.emission[1])),
    ("emission.B", Values::Float(|p| p.passes.emission[2])),
    ("direct.R", Values::Float(|p| p.passes.direct[0])),
    ("direct.G", Values::Float(|p| p.passes.direct[1])),
    ("direct.B", Values::Float(|p| p.passes.direct[2])),
    ("indirect.R", Values::Float(|p| p.passes.indirect[0])),
    ("indirect.G", Values::Float(|p| p.passes.indirect[1])),
    ("indirect.B", Values::Float(|p| p.passes.indirect[2])),
];

/// The channels of Cryptomatte: two ranks in each numbered layer, each an id and a share.
fn matte_channels() -> impl Iterator<Item = (String, Values)> {
    MatteLevel::ALL.into_iter().flat_map(|level| {
        (0..MATTE_RANKS).flat_map(move |rank| {
            let letters = if rank % 2 == 0 { ["r", "g"] } else { ["b", "a"] };
            letters.into_iter().zip([false, true]).map(move |(letter, is_share)| {
                let name = format!("{}{:02}.{letter}", level.type_name(), rank / 2);
                (name, Values::Matte(level, rank, is_share))
            })
        })
    })
}

impl<'f, F: Fn(u32, u32) -> FilmPixel<'f> + Sync> Channels<F> {
    /// The channels of a picture with these parts.
    pub(crate) fn new(numbers: bool, passes: bool, mattes: bool, at: F) -> Self {
        let named = |channels: &'static [(&str, Values)]| {
            channels.iter().map(|(name, values)| ((*name).to_owned(), *values))
        };
        let mut list: Vec<(String, Values)> = named(&ALWAYS).collect();
        list.extend(named(if numbers { &NUMBERS } else { &[] }));
        list.extend(named(if passes { &PASSES } else { &[] }));
        list.extend(matte_channels().filter(|_| mattes));
        list.sort_by(|(a, _), (b, _)| a.cmp(b));
        Self { list, at }
    }

    /// Appends the values of a part of a row, channel by channel.
    fn write_row(&self, y: u32, columns: Range<u32>, bytes: &mut Vec<u8>) {
        let pixels: Vec<FilmPixel<'_>> = columns.map(|x| (self.at)(x, y)).collect();
        for (_, values) in &self.list {
            bytes.extend(pixels.iter().flat_map(|pixel| values.bytes(pixel)));
        }
    }
}

impl<'slf, 'f, F> WritableChannels<'slf> for Channels<F>
where
    F: Fn(u32, u32) -> FilmPixel<'f> + Sync + 'slf,
    'f: 'slf,
{
    type Writer = RowWriter<'slf, F>;

    fn infer_channel_list(&self) -> ChannelList {
        let description = |(name, values): &(String, Values)| {
            let kind = if matches!(values, Values::Whole(_)) { SampleType::U32 } else { SampleType::F32 };
            ChannelDescription::named(name.as_str(), kind)
        };
        ChannelList::new(self.list.iter().map(description).collect())
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'slf self, _: &Header) -> Self::Writer {
        RowWriter(self)
    }
}

/// Writes blocks of rows.
pub(crate) struct RowWriter<'c, F>(&'c Channels<F>);

impl<'f, F: Fn(u32, u32) -> FilmPixel<'f> + Sync> ChannelsWriter for RowWriter<'_, F> {
    fn extract_uncompressed_block(&self, header: &Header, block: BlockIndex) -> Vec<u8> {
        let range = |start: usize, length: usize| start as u32..(start + length) as u32;
        let columns = range(block.pixel_position.x(), block.pixel_size.x());
        let mut bytes = Vec::with_capacity(block.pixel_size.area() * header.channels.bytes_per_pixel);
        for y in range(block.pixel_position.y(), block.pixel_size.y()) {
            self.0.write_row(y, columns.clone(), &mut bytes);
        }
        bytes
    }
}
