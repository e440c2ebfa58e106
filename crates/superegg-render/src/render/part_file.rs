//! The partial file: finished tiles of a picture, and the picture that they belong to. This module
//! turns them into bytes and back; opening files is up to the caller.
//!
//! ```text
//! superegg part 4\n                                  the format and its version
//! length u32, check u128, `length` bytes of text     the header: lines of a name, a blank and a value
//! then for each finished tile, in any order:
//! "TILE", tile u32, length u32, check u32            the head of a record; its check covers the twelve
//!                                                    bytes before it
//! `length` bytes, check u128                         the tile ([`crate::render::part_tile`]); the check covers
//!                                                    head and tile
//! ```
//!
//! Integers are little-endian. Checks are XXH3; those of records are seeded with the fingerprint of
//! the header, so that a record is valid only in a file of the same picture. A reader skips to the
//! next valid record: after a kill or damage every tile whose bytes are whole still counts, and no
//! length is trusted before its check. It holds a window of the file and the tiles that it found, so
//! a file takes memory for its tiles, whatever size of picture the header claims.
//!
//! A floating-point value of the header is `0x` and its 64 bits in hexadecimal. Camera, environment
//! and scene are only compared, by hashes of explicit bytes ([`crate::render::part_words`]). In
//! version 2 floating-point values were decimal, and the hashed bytes were another text. In versions 2 and 3 pixels have no
//! small numbers, and tiles neither passes nor mattes. These files are read and merged; a render does not continue them.

use std::io::{self, Read};
use std::ops::RangeInclusive;

use superegg_scene::{Encoding, Filter, LightModel, Picture, Tone};
use thiserror::Error;
use twox_hash::XxHash3_128;

use crate::film::buffer::Film;
use crate::film::tile::{Tile, tiles};
use crate::render::part_tile::TileParts;
use crate::render::part_words::{
    self, ENCODINGS, FILTERS, FLAGS, LIGHT_MODELS, OUTPUTS, TONES, value_of_word, word_of,
};
use crate::render::shard::Shard;
use crate::settings::{Output, RenderSettings};

/// A version of the format. Any change of the bytes is a new version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Two,
    Three,
    Four,
}

impl Version {
    /// The version that is written.
    const CURRENT: Self = Self::Four;
    /// All versions that are read.
    const READ: [Self; 3] = [Self::Two, Self::Three, Self::Four];

    /// The first line of a file; all have the same length.
    const fn first_line(self) -> &'static [u8] {
        match self {
            Self::Two => b"superegg part 2\n",
            Self::Three => b"superegg part 3\n",
            Self::Four => b"superegg part 4\n",
        }
    }

    fn number(self) -> &'static str {
        match self {
            Self::Two => "2",
            Self::Three => "3",
            Self::Four => "4",
        }
    }

    /// The text of a number.
    fn number_text(self, number: f64) -> String {
        match self {
            Self::Two => number.to_string(),
            Self::Three | Self::Four => format!("{BITS}{:016x}", number.to_bits()),
        }
    }

    /// The number of a text.
    fn number_of(self, text: &str) -> Option<f64> {
        match self {
            Self::Two => text.parse().ok(),
            Self::Three | Self::Four => {
                let digits = text.strip_prefix(BITS)?;
                let is_number = digits.len() == 16 && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
                if !is_number {
                    return None;
                }
                u64::from_str_radix(digits, 16).ok().map(f64::from_bits)
            }
        }
    }
}

const FIRST_LINE: &[u8] = Version::CURRENT.first_line();
/// The longest header, in bytes.
const LONGEST_HEADER: usize = 1 << 16;
const MARK: &[u8] = b"TILE";
const HEAD: usize = 16;
const CHECK: usize = 16;
/// The prefix of the bits of a number.
const BITS: &str = "0x";

/// Why bytes are not a usable partial file.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PartError {
    /// The first bytes are those of another kind of file.
    #[error("it is not a partial file of superegg")]
    NotAPart,
    /// The format has a version that is not read.
    #[error("it has another version of the format: it was written by an older or newer superegg")]
    OtherVersion,
    /// The header is cut off: the writer was stopped before the first tile.
    #[error("it breaks off in its header, so it has no tiles")]
    BrokenOff,
    /// The header is damaged.
    #[error("its header is damaged: {0}")]
    DamagedHeader(String),
    /// The file has more bytes than [`PartHeader::most_bytes`].
    #[error("it is longer than its picture can be")]
    TooLong,
    /// The stream cannot be read.
    #[error("{0}")]
    Unreadable(String),
}

impl From<io::Error> for PartError {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error.to_string())
    }
}

/// The picture that the tiles of a partial file belong to.
#[derive(Clone, Debug, PartialEq)]
pub struct PartHeader {
    /// The tiles of the complete file.
    pub shard: Shard,
    version: Version,
    /// Everything that the picture depends on, as names and values. Tiles belong to the same
    /// picture if these are equal.
    fields: Vec<(String, String)>,
    picture: Picture,
    output: Output,
}

/// The first difference between two pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Difference {
    /// Its name, such as "samples".
    pub name: String,
    /// The two values; `None` if only hashes of them are known.
    pub values: Option<(String, String)>,
}

impl PartHeader {
    /// The header of a shard of a picture. `program` is the version of the program, `scene` the
    /// text of the scene as the program writes it.
    pub fn new(
        program: &str,
        scene: &str,
        root: Option<&str>,
        depth: u32,
        settings: &RenderSettings,
        shard: Shard,
    ) -> Self {
        let RenderSettings { picture, camera, environment, output, layers: _, textures } = settings;
        let hash = |bytes: &[u8]| format!("{HASHED}{:032x}", XxHash3_128::oneshot(bytes));
        let mut fields = vec![("program", program.to_owned())];
        fields.extend(picture_fields(picture));
        fields.push((OUTPUT, word_of(*output, &OUTPUTS).to_owned()));
        fields.push((LAYERS, word_of(settings.keeps_layers(), &FLAGS).to_owned()));
        fields.push(("root", root.unwrap_or_default().to_owned()));
        fields.push(("depth", depth.to_string()));
        fields.push(("camera", hash(&part_words::camera_bytes(camera))));
        fields.push(("surroundings", hash(&part_words::environment_bytes(environment))));
        fields.push(("scene", hash(scene.as_bytes())));
        if !textures.is_empty() {
            fields.push(("textures", hash(&textures.bytes())));
        }
        // A value is the rest of a line.
        let line = |value: String| value.replace(['\n', '\r'], " ");
        Self {
            shard,
            version: Version::CURRENT,
            fields: fields.into_iter().map(|(name, value)| (name.to_owned(), line(value))).collect(),
            picture: *picture,
            output: *output,
        }
    }

    /// Size, quality and development of the picture.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// The quantity that the picture has.
    pub fn output(&self) -> Output {
        self.output
    }

    /// Whether the pixels have depth, normal, albedo and id.
    pub fn has_layers(&self) -> bool {
        self.field(LAYERS) == Some(word_of(true, &FLAGS))
    }

    /// Whether the pixels have small numbers of instances and objects.
    pub fn has_numbers(&self) -> bool {
        self.version == Version::Four && self.has_layers()
    }

    /// Whether the tiles have the parts of light ([`Film::passes`]).
    pub fn has_passes(&self) -> bool {
        self.has_numbers() && self.output == Output::Light && self.picture.light_model == LightModel::Path
    }

    /// Whether the tiles have mattes ([`Film::matte`]).
    pub fn has_mattes(&self) -> bool {
        self.has_numbers() && self.picture.cryptomatte
    }

    fn tile_parts(&self) -> TileParts {
        let (passes, mattes) = (self.has_passes(), self.has_mattes());
        TileParts { numbers: self.version == Version::Four, passes, mattes }
    }

    /// The tiles of the whole picture.
    pub fn tiles(&self) -> Vec<Tile> {
        tiles(self.picture.width, self.picture.height)
    }

    fn field(&self, name: &str) -> Option<&str> {
        value_of(&self.fields, name)
    }

    /// The first difference between the pictures of two headers. Shards of one picture have none.
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        self.difference_except(other, None)
    }

    /// The first difference apart from whether pixels have layers.
    pub fn difference_of_light(&self, other: &Self) -> Option<Difference> {
        self.difference_except(other, Some(LAYERS))
    }

    fn difference_except(&self, other: &Self, ignored: Option<&str>) -> Option<Difference> {
        if self.version != other.version {
            let values = [self, other].map(|header| header.version.number().to_owned());
            return Some(Difference { name: "format_version".to_owned(), values: Some(values.into()) });
        }
        let names = self.fields.iter().chain(&other.fields).map(|(name, _)| name.as_str());
        let mut differing =
            names.filter(|name| Some(*name) != ignored && self.field(name) != other.field(name));
        let name = differing.next()?;
        let is_hash = [self, other]
            .iter()
            .any(|header| header.field(name).is_some_and(|value| value.starts_with(HASHED)));
        let values = (!is_hash).then(|| (self.readable(name), other.readable(name)));
        Some(Difference { name: name.to_owned(), values })
    }

    /// A value as text for a person.
    fn readable(&self, name: &str) -> String {
        let Some(value) = self.field(name) else { return "(nothing)".to_owned() };
        if !NUMBERS.contains(&name) {
            return value.to_owned();
        }
        self.version.number_of(value).map_or_else(|| value.to_owned(), |number| number.to_string())
    }

    /// Equal for all shards of one picture.
    fn fingerprint(&self) -> u64 {
        let mut text = String::new();
        self.write_fields(&mut text);
        XxHash3_128::oneshot(text.as_bytes()) as u64
    }

    fn write_fields(&self, text: &mut String) {
        for (name, value) in &self.fields {
            text.extend([name.as_str(), " ", value, "\n"]);
        }
    }

    /// The first bytes of the partial file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut text = format!("{SHARD} {}\n", self.shard);
        self.write_fields(&mut text);
        let mut bytes = self.version.first_line().to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(XxHash3_128::oneshot(text.as_bytes()).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes
    }

    /// The first bytes of partial files of every version.
    pub const FAMILY: &[u8] = b"superegg part ";

    /// The length of the longest header.
    pub const MOST_BYTES: u64 = (FIRST_LINE.len() + 4 + CHECK + LONGEST_HEADER) as u64;

    /// The greatest sensible length of a file of this picture: each tile twice.
    pub fn most_bytes(&self) -> u64 {
        let parts = self.tile_parts();
        let record = |tile: &Tile| (HEAD + parts.most_bytes(tile.pixel_count()) + CHECK) as u64;
        Self::MOST_BYTES + 2 * self.tiles().iter().map(record).sum::<u64>()
    }

    /// The record of a finished tile.
    pub fn record(&self, tile: usize, pixels: &Film) -> Vec<u8> {
        let content = self.tile_parts().to_bytes(pixels);
        let mut bytes = Vec::with_capacity(HEAD + content.len() + CHECK);
        bytes.extend(MARK);
        bytes.extend((tile as u32).to_le_bytes());
        bytes.extend((content.len() as u32).to_le_bytes());
        bytes.extend(head_check(&bytes).to_le_bytes());
        bytes.extend(content);
        bytes.extend(check(self.fingerprint(), &bytes).to_le_bytes());
        bytes
    }

    /// Reads the header of a partial file. Returns it and its length.
    ///
    /// # Errors
    /// The bytes are no partial file, or the header is cut off or damaged.
    pub fn read(bytes: &[u8]) -> Result<(Self, usize), PartError> {
        let damaged = |why: &str| PartError::DamagedHeader(why.to_owned());
        if bytes.len() < FIRST_LINE.len()
            && Version::READ.iter().any(|version| version.first_line().starts_with(bytes))
        {
            return Err(PartError::BrokenOff);
        }
        let versions = Version::READ.into_iter();
        let found =
            versions.filter_map(|version| Some((version, bytes.strip_prefix(version.first_line())?))).next();
        let Some((version, rest)) = found else {
            let is_part = bytes.starts_with(Self::FAMILY);
            return Err(if is_part { PartError::OtherVersion } else { PartError::NotAPart });
        };
        let (length, rest) = rest.split_first_chunk().ok_or(PartError::BrokenOff)?;
        let length = u32::from_le_bytes(*length) as usize;
        if length > LONGEST_HEADER {
            return Err(damaged("it cannot be so long"));
        }
        let (check, rest) = rest.split_first_chunk().ok_or(PartError::BrokenOff)?;
        let text = rest.get(..length).ok_or(PartError::BrokenOff)?;
        if XxHash3_128::oneshot(text) != u128::from_le_bytes(*check) {
            return Err(damaged("its checksum does not fit"));
        }
        let text = std::str::from_utf8(text).map_err(|_| damaged("it is no text"))?;
        let mut fields = Vec::new();
        let mut shard = None;
        for line in text.lines() {
            match line.split_once(' ').ok_or_else(|| damaged("a line has no value"))? {
                (SHARD, value) => shard = Some(value.parse().map_err(|error: String| damaged(&error))?),
                (name, value) => fields.push((name.to_owned(), value.to_owned())),
            }
        }
        let shard = shard.ok_or_else(|| damaged("it names no share"))?;
        let picture = read_picture(version, &|name| value_of(&fields, name))?;
        let output = value_of_word(value_of(&fields, OUTPUT), &OUTPUTS);
        let output = output.ok_or_else(|| damaged("it has no view"))?;
        let header = Self { shard, version, fields, picture, output };
        Ok((header, FIRST_LINE.len() + 4 + CHECK + length))
    }
}

/// The name of the shard.
const SHARD: &str = "share";
/// The name of the field for the output.
const OUTPUT: &str = "view";
/// The name of the field for layers.
const LAYERS: &str = "layers";
/// The names of the fields that are floating-point values.
const NUMBERS: [&str; 4] = ["noise", "exposure", "least_weight", "far_depth"];

/// The prefix of values that are hashes.
const HASHED: &str = "xxh3:";

/// Every value of a picture with its name.
fn picture_fields(picture: &Picture) -> Vec<(&'static str, String)> {
    // Names all fields, so that none is forgotten.
    let &Picture {
        width,
        height,
        samples,
        noise,
        most_samples,
        filter,
        encoding,
        exposure,
        tone,
        bits,
        dither,
        far_depth,
        cryptomatte,
        denoise,
        transparent,
        light_model,
        bounces,
        least_weight,
        light_rays,
        gloss_rays,
    } = picture;
    let number = |number| Version::CURRENT.number_text(number);
    let mut fields = vec![
        ("width", width.to_string()),
        ("height", height.to_string()),
        ("samples", samples.to_string()),
        ("noise", number(noise)),
        ("most_samples", most_samples.to_string()),
        ("filter", word_of(filter, &FILTERS).to_owned()),
        ("encoding", word_of(encoding, &ENCODINGS).to_owned()),
        ("exposure", number(exposure)),
        ("tone", word_of(tone, &TONES).to_owned()),
        ("bits", bits.to_string()),
        ("transparent", word_of(transparent, &FLAGS).to_owned()),
        ("bounces", bounces.to_string()),
        ("least_weight", number(least_weight)),
        ("light_rays", light_rays.to_string()),
        ("gloss_rays", gloss_rays.to_string()),
    ];
    // Older programs made pictures of the course's model only, and their files have no such field.
    if light_model != LightModel::default() {
        fields.push(("light", word_of(light_model, &LIGHT_MODELS).to_owned()));
    }
    if dither {
        fields.push(("dither", word_of(dither, &FLAGS).to_owned()));
    }
    if cryptomatte {
        fields.push(("cryptomatte", word_of(cryptomatte, &FLAGS).to_owned()));
    }
    if denoise {
        fields.push(("denoise", word_of(denoise, &FLAGS).to_owned()));
    }
    if far_depth != 0.0 {
        fields.push(("far_depth", number(far_depth)));
    }
    fields
}

fn read_picture<'a>(version: Version, field: &dyn Fn(&str) -> Option<&'a str>) -> Result<Picture, PartError> {
    let wrong = |name: &str| PartError::DamagedHeader(format!("it has no {name} that a picture can have"));
    let whole = |name: &str, range: RangeInclusive<u32>| {
        let number = field(name).and_then(|text| text.parse().ok());
        number.filter(|number| range.contains(number)).ok_or_else(|| wrong(name))
    };
    let number = |name: &str| {
        let number = field(name).and_then(|text| version.number_of(text));
        number.filter(|number| number.is_finite()).ok_or_else(|| wrong(name))
    };
    let filter: Option<Filter> = value_of_word(field("filter"), &FILTERS);
    let encoding: Option<Encoding> = value_of_word(field("encoding"), &ENCODINGS);
    let tone: Option<Tone> = value_of_word(field("tone"), &TONES);
    let transparent = value_of_word(field("transparent"), &FLAGS);
    let light_model = match field("light") {
        None => LightModel::default(),
        word => value_of_word(word, &LIGHT_MODELS).ok_or_else(|| wrong("light"))?,
    };
    let flag = |name: &str| match field(name) {
        None => Ok(false),
        word => value_of_word(word, &FLAGS).ok_or_else(|| wrong(name)),
    };
    let (dither, cryptomatte, denoise) = (flag("dither")?, flag("cryptomatte")?, flag("denoise")?);
    let far_depth = if field("far_depth").is_some() { number("far_depth")? } else { 0.0 };
    let picture = Picture {
        light_model,
        dither,
        far_depth,
        cryptomatte,
        denoise,
        width: whole("width", 1..=Picture::LONGEST_SIDE)?,
        height: whole("height", 1..=Picture::LONGEST_SIDE)?,
        samples: whole("samples", 1..=Picture::MOST_SAMPLES)?,
        noise: number("noise")?,
        most_samples: whole("most_samples", 1..=Picture::MOST_SAMPLES)?,
        filter: filter.ok_or_else(|| wrong("filter"))?,
        encoding: encoding.ok_or_else(|| wrong("encoding"))?,
        exposure: number("exposure")?,
        tone: tone.ok_or_else(|| wrong("tone"))?,
        bits: whole("bits", 8..=16)?,
        transparent: transparent.ok_or_else(|| wrong("transparent"))?,
        bounces: whole("bounces", 0..=u32::MAX)?,
        least_weight: number("least_weight")?,
        light_rays: whole("light_rays", 0..=u32::MAX)?,
        gloss_rays: whole("gloss_rays", 0..=u32::MAX)?,
    };
    if !Picture::is_size(picture.width, picture.height) {
        return Err(wrong("size"));
    }
    Ok(picture)
}

fn value_of<'a>(fields: &'a [(String, String)], name: &str) -> Option<&'a str> {
    fields.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
}

/// The check of the first bytes of a record, before its length is trusted.
fn head_check(head: &[u8]) -> u32 {
    XxHash3_128::oneshot(head) as u32
}

/// A partial file.
#[derive(Debug)]
pub struct PartFile {
    /// The picture that the tiles belong to.
    pub header: PartHeader,
    /// The finished tiles with their indices, in the order of the file. No tile is in it twice.
    pub tiles: Vec<(usize, Film)>,
    /// The length up to the end of the last valid record.
    pub end: u64,
    /// The number of bytes before `end` that belong to no valid record.
    pub damaged: u64,
}

impl PartFile {
    /// Reads a whole file and skips invalid records.
    ///
    /// # Errors
    /// The header cannot be read; without it no tile has a meaning. The stream is longer than its
    /// picture allows, or cannot be read.
    pub fn read(input: impl Read) -> Result<Self, PartError> {
        let mut window = Window::new(input);
        window.fill(PartHeader::MOST_BYTES as usize)?;
        let (header, start) = PartHeader::read(window.rest())?;
        window.skip(start);
        let all = header.tiles();
        let parts = header.tile_parts();
        let counts: Vec<usize> = all.iter().map(Tile::pixel_count).collect();
        let most_pixels = counts.iter().copied().max().unwrap_or(0);
        let longest_record = HEAD + parts.most_bytes(most_pixels) + CHECK;
        let (seed, most_bytes) = (header.fingerprint(), header.most_bytes());
        let mut is_known = vec![false; counts.len()];
        let mut part = Self { header, tiles: Vec::new(), end: start as u64, damaged: 0 };
        let mut at = start as u64;
        loop {
            window.fill(longest_record)?;
            let rest = window.rest();
            if rest.is_empty() {
                return Ok(part);
            }
            let record = read_record(rest, &counts, parts, seed);
            let film =
                record.and_then(|(tile, bytes)| Some((tile, bytes, parts.film(all[tile].size(), bytes)?)));
            let length = match film {
                Some((tile, bytes, film)) => {
                    let length = HEAD + bytes.len() + CHECK;
                    part.damaged += at - part.end;
                    part.end = at + length as u64;
                    if !std::mem::replace(&mut is_known[tile], true) {
                        part.tiles.push((tile, film));
                    }
                    length
                }
                None => to_next_mark(rest, window.is_at_end),
            };
            window.skip(length);
            at += length as u64;
            if at > most_bytes {
                return Err(PartError::TooLong);
            }
        }
    }
}

/// The number of bytes, at least one, before the next place where a record may begin.
fn to_next_mark(bytes: &[u8], is_at_end: bool) -> usize {
    let next = bytes[1..].windows(MARK.len()).position(|four| four == MARK);
    // A mark may go on behind the window.
    let kept = if is_at_end { 0 } else { MARK.len() - 1 };
    next.map_or_else(|| bytes.len().saturating_sub(kept).max(1), |next| 1 + next)
}

/// A part of a stream, read as it is needed.
struct Window<R> {
    input: R,
    bytes: Vec<u8>,
    /// The number of bytes that were skipped.
    start: usize,
    is_at_end: bool,
}

impl<R: Read> Window<R> {
    /// The number of bytes that are read at a time.
    const BLOCK: usize = 1 << 18;

    fn new(input: R) -> Self {
        Self { input, bytes: Vec::new(), start: 0, is_at_end: false }
    }

    /// The bytes that were read and not skipped.
    fn rest(&self) -> &[u8] {
        &self.bytes[self.start..]
    }

    /// Reads until the rest has `wanted` bytes, or the stream ends.
    fn fill(&mut self, wanted: usize) -> io::Result<()> {
        if self.is_at_end || self.rest().len() >= wanted {
            return Ok(());
        }
        self.bytes.drain(..self.start);
        self.start = 0;
        let missing = Self::BLOCK.max(wanted) - self.bytes.len();
        let read = (&mut self.input).take(missing as u64).read_to_end(&mut self.bytes)?;
        self.is_at_end = read < missing;
        Ok(())
    }

    fn skip(&mut self, count: usize) {
        self.start += count;
    }
}

/// The valid record that some bytes begin with: its tile and the bytes of that. `counts` are the numbers of pixels of tiles.
fn read_record<'a>(
    bytes: &'a [u8],
    counts: &[usize],
    parts: TileParts,
    seed: u64,
) -> Option<(usize, &'a [u8])> {
    let number = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let (tile, length) = (number(4)? as usize, number(8)? as usize);
    if !bytes.starts_with(MARK)
        || !counts.get(tile).is_some_and(|&pixels| parts.is_length(length, pixels))
        || number(12)? != head_check(&bytes[..12])
    {
        return None;
    }
    let record = bytes.get(..HEAD + length)?;
    let written = bytes[record.len()..].first_chunk()?;
    (check(seed, record) == u128::from_le_bytes(*written)).then_some((tile, &record[HEAD..]))
}

/// The check of a record of the picture with this fingerprint.
fn check(seed: u64, record: &[u8]) -> u128 {
    XxHash3_128::oneshot_with_seed(seed, record)
}

#[cfg(test)]
mod tests {
    use superegg_scene::Scene;

    use super::*;
    use crate::film::pixel::Pixel;

    /// A random number generator (xorshift, Marsaglia 2003).
    struct Random(u64);

    impl Random {
        fn below(&mut self, most: usize) -> usize {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 % most as u64) as usize
        }
    }

    fn settings() -> RenderSettings {
        let picture =
            Picture { width: 34, height: 10, exposure: 0.1, tone: Tone::Filmic, ..Picture::default() };
        RenderSettings::of(&Scene::default()).with_picture(picture)
    }

    fn header(shard: Shard) -> PartHeader {
        PartHeader::new("1.2.3", "prm egg\n", Some("egg"), 25, &settings(), shard)
    }

    fn pixels(tile: usize) -> Film {
        let area = &header(Shard::WHOLE).tiles()[tile];
        let (width, height) = area.size();
        let pixel = |i| Pixel { depth: i as f32, id: tile as u32, samples: 4, ..Pixel::EMPTY };
        Film::of_pixels(width, height, (0..area.pixel_count()).map(pixel))
    }

    /// A complete file, and the ends of its header and its two records.
    fn file() -> (Vec<u8>, [usize; 3]) {
        let header = header(Shard::WHOLE);
        let mut bytes = header.to_bytes();
        let start = bytes.len();
        bytes.extend(header.record(1, &pixels(1)));
        let middle = bytes.len();
        bytes.extend(header.record(0, &pixels(0)));
        let end = bytes.len();
        (bytes, [start, middle, end])
    }

    /// The tiles of a part. Checks that each was written.
    fn tiles_of(part: &PartFile) -> Vec<usize> {
        for (tile, found) in &part.tiles {
            assert_eq!(found, &pixels(*tile));
        }
        part.tiles.iter().map(|(tile, _)| *tile).collect()
    }

    #[test]
    fn what_is_written_is_read() {
        let (bytes, [.., end]) = file();
        let part = PartFile::read(&bytes[..]).unwrap();
        assert_eq!((tiles_of(&part), part.end, part.damaged), (vec![1, 0], end as u64, 0));
        assert_eq!((&part.header, part.header.picture()), (&header(Shard::WHOLE), &settings().picture));
        assert!(part.header.most_bytes() > end as u64);
    }

    #[test]
    fn cut_off_anywhere_it_keeps_the_tiles_that_are_whole() {
        let (bytes, [start, middle, end]) = file();
        for length in 0..=end {
            match PartFile::read(&bytes[..length]) {
                Ok(part) => {
                    let whole = [middle, end].iter().filter(|&&end| end <= length).count();
                    assert_eq!((tiles_of(&part).len(), part.damaged), (whole, 0), "{length}");
                    assert_eq!(part.end, [start, middle, end][whole] as u64);
                }
                Err(error) => assert!(length < start && error == PartError::BrokenOff, "{length}: {error}"),
            }
        }
    }

    #[test]
    fn a_changed_byte_costs_its_own_tile_and_no_other() {
        let (bytes, [start, middle, end]) = file();
        for at in 0..end {
            for flip in [1, 0x80, 0xff] {
                let mut bytes = bytes.clone();
                bytes[at] ^= flip;
                match PartFile::read(&bytes[..]) {
                    Ok(part) => {
                        let left = if at < middle { 0 } else { 1 };
                        assert_eq!(tiles_of(&part), [left], "{at}");
                        assert_eq!(part.damaged, if at < middle { (middle - start) as u64 } else { 0 });
                    }
                    Err(_) => assert!(at < start, "{at}"),
                }
            }
        }
    }

    #[test]
    fn records_in_a_row_with_garbage_between_count_once() {
        let (bytes, [start, middle, end]) = file();
        let header = header(Shard::new(1, 1).unwrap());
        let mut other = pixels(1);
        other.set(0, 0, Pixel { id: 77, ..other.pixel(0, 0).unwrap() });
        let garbage = b"TITILETILE....TILE".repeat(50);
        let joined =
            [&bytes[..middle], &garbage, &bytes, &header.record(1, &other), &bytes[middle..end]].concat();
        let part = PartFile::read(&joined[..]).unwrap();
        assert_eq!((tiles_of(&part), part.end), (vec![1, 0], joined.len() as u64));
        assert_eq!(part.damaged, (garbage.len() + start) as u64);
    }

    #[test]
    fn records_of_another_picture_are_not_taken() {
        let other = RenderSettings { picture: Picture { samples: 5, ..settings().picture }, ..settings() };
        let other = PartHeader::new("1.2.3", "prm egg\n", Some("egg"), 25, &other, Shard::WHOLE);
        let mixed = [header(Shard::WHOLE).to_bytes(), other.record(0, &pixels(0))].concat();
        assert_eq!(PartFile::read(&mixed[..]).unwrap().tiles.len(), 0);
    }

    #[test]
    fn shares_of_one_picture_differ_in_nothing_else() {
        let [one, two] = [1, 2].map(|number| header(Shard::new(number, 2).unwrap()));
        assert_eq!(one.difference(&two), None);
        assert_ne!(one.to_bytes(), two.to_bytes());
        let mixed = [one.to_bytes(), two.record(1, &pixels(1))].concat();
        assert_eq!(tiles_of(&PartFile::read(&mixed[..]).unwrap()), [1]);
    }

    #[test]
    fn what_differs_is_named() {
        let ours = header(Shard::WHOLE);
        let with = |program: &str, scene: &str, root: Option<&str>, depth, settings: &RenderSettings| {
            let other = PartHeader::new(program, scene, root, depth, settings, Shard::WHOLE);
            ours.difference(&other).map(|Difference { name, values }| (name, values))
        };
        let (egg, own) = ("prm egg\n", settings());
        let differing = |name: &str, one: &str, two: &str| {
            Some((name.to_owned(), Some((one.to_owned(), two.to_owned()))))
        };
        assert_eq!(with("1.2.3", egg, Some("egg"), 25, &own), None);
        assert_eq!(with("1.2.4", egg, Some("egg"), 25, &own), differing("program", "1.2.3", "1.2.4"));
        assert_eq!(with("1.2.3", egg, None, 25, &own), differing("root", "egg", ""));
        assert_eq!(with("1.2.3", egg, Some("egg"), 26, &own), differing("depth", "25", "26"));
        assert_eq!(with("1.2.3", "prm egg2\n", Some("egg"), 25, &own), Some(("scene".to_owned(), None)));
        for output in Output::ALL {
            let other = RenderSettings { output, ..own.clone() };
            let header = PartHeader::new("1.2.3", egg, Some("egg"), 25, &other, Shard::WHOLE);
            assert_eq!(PartHeader::read(&header.to_bytes()).unwrap().0.output(), output);
            assert_eq!(ours.difference(&header).is_some(), output != Output::Light);
        }
        let mut other = own.clone();
        other.camera.fov_deg = other.camera.fov_deg.next_up();
        assert_eq!(with("1.2.3", egg, Some("egg"), 25, &other), Some(("camera".to_owned(), None)));
        let mut other = own.clone();
        other.environment.background.x = -0.0;
        assert_eq!(with("1.2.3", egg, Some("egg"), 25, &other), Some(("surroundings".to_owned(), None)));
        let changes: [fn(&mut Picture); 16] = [
            |picture| picture.denoise = true,
            |picture| picture.cryptomatte = true,
            |picture| picture.light_model = LightModel::Path,
            |picture| picture.samples = 9,
            |picture| picture.noise = 0.1,
            |picture| picture.most_samples = 9,
            |picture| picture.filter = Filter::Mitchell,
            |picture| picture.encoding = Encoding::Linear,
            |picture| picture.exposure = -1e-300,
            |picture| picture.tone = Tone::Reinhard,
            |picture| picture.bits = 16,
            |picture| picture.transparent = true,
            |picture| picture.bounces = 0,
            |picture| picture.least_weight = 0.1 + 0.2,
            |picture| picture.light_rays = 9,
            |picture| picture.gloss_rays = 9,
        ];
        for change in changes {
            let mut other = own.clone();
            change(&mut other.picture);
            assert!(with("1.2.3", egg, Some("egg"), 25, &other).is_some_and(|(_, values)| values.is_some()));
            let bytes = PartHeader::new("", "", None, 1, &other, Shard::WHOLE).to_bytes();
            assert_eq!(PartHeader::read(&bytes).unwrap().0.picture(), &other.picture);
        }
    }

    /// A header with this text and a valid check.
    fn with_text(text: &str) -> Vec<u8> {
        let length = (text.len() as u32).to_le_bytes();
        let check = XxHash3_128::oneshot(text.as_bytes()).to_le_bytes();
        [FIRST_LINE, &length, &check, text.as_bytes()].concat()
    }

    #[test]
    fn hostile_headers_are_refused() {
        let (bytes, [start, ..]) = file();
        let text = std::str::from_utf8(&bytes[FIRST_LINE.len() + 4 + CHECK..start]).unwrap();
        assert!(PartHeader::read(&with_text(text)).is_ok());
        for (name, bad) in [
            ("share 1/1", "share 0/1"),
            ("share 1/1", "shares"),
            ("share 1/1", "share"),
            ("width 34", "width 0"),
            ("width 34", "width 4294967295"),
            ("width 34", "width -1"),
            ("height 10", "height 32769"),
            ("height 10", "height"),
            ("width 34\nheight 10", "width 32768\nheight 32768"),
            ("samples 4", "samples 0"),
            ("exposure 0x3fb999999999999a", "exposure 0x7ff8000000000000"),
            ("exposure 0x3fb999999999999a", "exposure 0x7ff0000000000000"),
            ("exposure 0x3fb999999999999a", "exposure 0x+fb999999999999a"),
            ("exposure 0x3fb999999999999a", "exposure 0.1"),
            ("bits 8", "bits 7"),
            ("tone Filmic", "tone filmic"),
            ("transparent false", "transparent"),
        ] {
            assert!(text.contains(name));
            let error = PartHeader::read(&with_text(&text.replacen(name, bad, 1))).unwrap_err();
            assert!(matches!(error, PartError::DamagedHeader(_)), "{bad}: {error}");
        }
        for (bad, error) in [
            (&b"PNG"[..], PartError::NotAPart),
            (b"superegg part 5\n", PartError::OtherVersion),
            (b"superegg part 1\n", PartError::OtherVersion),
            (b"", PartError::BrokenOff),
            (b"superegg par", PartError::BrokenOff),
            (b"superegg part 2\n\x10", PartError::BrokenOff),
        ] {
            assert_eq!(PartHeader::read(bad).unwrap_err(), error);
        }
        let long = [FIRST_LINE, &u32::MAX.to_le_bytes(), &[0; CHECK]].concat();
        assert!(matches!(PartHeader::read(&long), Err(PartError::DamagedHeader(_))));
    }

    #[test]
    fn mutated_files_give_no_tile_that_was_not_written() {
        let (original, [start, ..]) = file();
        let mut random = Random(2015);
        for _ in 0..3000 {
            let mut bytes = original.clone();
            for _ in 0..=random.below(4) {
                let at = random.below(bytes.len());
                let until = (at + random.below(400)).min(bytes.len());
                match random.below(6) {
                    0 => bytes[at] = random.below(256) as u8,
                    1 => bytes.truncate(at.max(1)),
                    2 => drop(bytes.drain(at..until)),
                    3 => bytes[at..until].fill_with(|| random.below(256) as u8),
                    4 => bytes.extend_from_within(at..until),
                    _ => bytes.splice(at..at, MARK.repeat(20)).for_each(drop),
                }
                if bytes.is_empty() {
                    bytes.push(0);
                }
            }
            if let Ok(part) = PartFile::read(&bytes[..]) {
                tiles_of(&part);
                assert!((start as u64..=bytes.len() as u64).contains(&part.end));
            }
        }
    }
}
