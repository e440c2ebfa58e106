//! OpenEXR files with all layers of a film.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{Image, Layer, LayerAttributes, Vec2, WritableImage};
use thiserror::Error;

use crate::film::buffer::Film;
use crate::film::encoded::{PictureNote, SOFTWARE};
use crate::film::exr_channels::{Channels, FilmPixel};
use crate::film::matte::{MatteLevel, Mattes, matte_id};

/// Why an OpenEXR file could not be made.
#[derive(Debug, Error)]
#[error("the picture could not be encoded: {0}")]
pub struct ExrError(#[from] exr::error::Error);

/// The primaries and the white point of sRGB and Rec. 709 (CIE 1931 x, y).
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// A picture for an OpenEXR file: linear light before exposure and tone mapping, in 32-bit floats with lossless compression.
/// The channels have the names that compositing programs use:
///
/// | channels | values |
/// |---|---|
/// | `R G B A` | [`crate::Pixel::color`], premultiplied, and alpha |
/// | `Z` | [`crate::Pixel::depth`] in world units, `far_depth` without a hit |
/// | `N.X N.Y N.Z` | [`crate::Pixel::normal`] |
/// | `albedo.R albedo.G albedo.B` | [`crate::Pixel::albedo`] |
/// | `id` | [`crate::Pixel::id`], a whole number |
/// | `samples` | [`crate::Pixel::samples`], a whole number |
/// | `instance object` | [`crate::Pixel::instance`] and [`crate::Pixel::object`], floats of whole values |
/// | `emission.R`.. `direct.R`.. `indirect.R`.. | [`crate::LightPasses`], whose sum is `R G B` |
/// | `CryptoInstance00.r`.. `CryptoObject00.r`.. | [`Film::matte`], as Cryptomatte 1.2.0 stores it |
///
/// The names of mattes are in the attributes `cryptomatte/KEY/manifest`.
#[derive(Clone)]
pub struct ExrPicture<'f> {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The film that has the pixel in a column and row of the picture, with column and row in that film; `None` for a pixel
    /// that is [`crate::Pixel::EMPTY`].
    pub film_at: &'f (dyn Fn(u32, u32) -> Option<(&'f Film, u32, u32)> + Sync),
    /// The films with the names of mattes.
    pub films: Vec<&'f Film>,
    /// Whether pixels have small numbers of instances and objects.
    pub has_numbers: bool,
    /// Whether the films have the parts of light.
    pub has_passes: bool,
    /// Whether the films have mattes.
    pub has_mattes: bool,
    /// The depth of pixels without a hit, in world units; 0 for infinity.
    pub far_depth: f64,
}

/// Encodes a film as an OpenEXR file with all that it keeps: [`ExrPicture`].
///
/// # Errors
/// The encoder rejects the film, for instance for its size.
pub fn exr_file(film: &Film, far_depth: f64, notes: &[PictureNote]) -> Result<Vec<u8>, ExrError> {
    let picture = ExrPicture {
        size: (film.width(), film.height()),
        film_at: &|x, y| Some((film, x, y)),
        films: vec![film],
        has_numbers: film.has_layers(),
        has_passes: film.has_passes(),
        has_mattes: film.has_mattes(),
        far_depth,
    };
    picture.encode(notes)
}

/// The attribute `comments` of an OpenEXR file.
///
/// # Errors
/// It is no OpenEXR file, or it is damaged.
pub fn notes_of_exr(file: &[u8]) -> Result<Option<String>, ExrError> {
    let meta = exr::meta::MetaData::read_from_buffered(file, false)?;
    let comments = meta.headers.iter().find_map(|header| header.own_attributes.comments.as_ref());
    Ok(comments.map(ToString::to_string))
}

impl<'f> ExrPicture<'f> {
    /// Encodes the picture. Notes are in the attribute `comments`, each as a line with its name and the lines of its text.
    ///
    /// # Errors
    /// The encoder rejects the picture, for instance for its size.
    pub fn encode(&self, notes: &[PictureNote]) -> Result<Vec<u8>, ExrError> {
        let comments: String =
            notes.iter().map(|PictureNote { name, text }| format!("{name}\n{text}\n")).collect();
        let mattes = if self.has_mattes { self.cryptomatte() } else { BTreeMap::new() };
        let mattes =
            mattes.into_iter().map(|(name, value)| (name.as_str().into(), AttributeValue::Text(value)));
        let attributes = LayerAttributes {
            software_name: Some(SOFTWARE.into()),
            // `None` for a text that is not of Latin letters.
            comments: Text::new_or_none(&comments).filter(|_| !notes.is_empty()),
            other: mattes.collect(),
            ..LayerAttributes::default()
        };
        let size = (self.size.0 as usize, self.size.1 as usize);
        let at = |x: u32, y: u32| FilmPixel::new((self.film_at)(x, y), self.far_depth);
        let channels = Channels::new(self.has_numbers, self.has_passes, self.has_mattes, at);
        let layer = Layer::new(size, attributes, exr::prelude::Encoding::SMALL_LOSSLESS, channels);
        let mut image = Image::from_layer(layer);
        image.attributes.chromaticities = Some(REC_709);
        let mut file = Vec::new();
        image.write().non_parallel().to_buffered(Cursor::new(&mut file))?;
        sort_attributes(&mut file, CRYPTOMATTE);
        Ok(file)
    }

    /// The attributes of Cryptomatte with their values.
    fn cryptomatte(&self) -> BTreeMap<String, Text> {
        let mut attributes = BTreeMap::new();
        for level in MatteLevel::ALL {
            let name = level.type_name();
            // The key is the beginning of a hash, as the specification suggests.
            let key = &format!("{:08x}", matte_id(name))[..7];
            for (field, value) in [
                ("name", name),
                ("hash", "MurmurHash3_32"),
                ("conversion", "uint32_to_float32"),
                ("manifest", &self.manifest(level)),
            ] {
                let value = Text::from_slice_unchecked(value.as_bytes());
                attributes.insert(format!("{CRYPTOMATTE}{key}/{field}"), value);
            }
        }
        attributes
    }

    /// The names and ids of a level as JSON.
    fn manifest(&self, level: MatteLevel) -> String {
        let (mut names, mut used) = (Mattes::default(), BTreeSet::new());
        for film in &self.films {
            names.add_names(film.matte_names());
            used.append(&mut film.matte_ids(level));
        }
        let names = names.names().iter().filter(|(id, _)| used.contains(id));
        let named: BTreeMap<&str, u32> = names.map(|(id, name)| (name.as_str(), *id)).collect();
        let entries: Vec<String> =
            named.into_iter().map(|(name, id)| format!("{}:\"{id:08x}\"", json_string(name))).collect();
        format!("{{{}}}", entries.join(","))
    }
}

/// The beginning of the names of attributes of Cryptomatte.
const CRYPTOMATTE: &str = "cryptomatte/";

/// A JSON string of ASCII characters alone: attributes have no encoding.
fn json_string(text: &str) -> String {
    let mut json = String::from("\"");
    for unit in text.encode_utf16() {
        match char::from_u32(unit.into()) {
            Some(c @ ('"' | '\\')) => json.extend(['\\', c]),
            Some(c @ ' '..='~') => json.push(c),
            _ => json += &format!("\\u{unit:04x}"),
        }
    }
    json.push('"');
    json
}

/// Sorts the attributes of a file whose names begin so. The encoder writes them by a hash that differs from run to run.
fn sort_attributes(file: &mut [u8], prefix: &str) {
    /// The length of the magic number and the version.
    const START: usize = 8;
    let mut at = START;
    let (mut first, mut found) = (None, Vec::new());
    while let Some(length) = file.get(at..).and_then(attribute_length) {
        let attribute = &file[at..at + length];
        if attribute.starts_with(prefix.as_bytes()) {
            first.get_or_insert(at);
            found.push(attribute.to_vec());
        } else if first.is_some() {
            // The attributes lie side by side.
            break;
        }
        at += length;
    }
    let Some(first) = first else { return };
    found.sort_unstable();
    let sorted = found.concat();
    file[first..first + sorted.len()].copy_from_slice(&sorted);
}

/// The length of the attribute that bytes begin with: a name and a type, each with a zero at its end, the length of the value
/// as 32 bits, and the value. `None` at the end of a header.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|&byte| byte == 0).filter(|&length| length > 0)?;
    let kind = bytes[name + 1..].iter().position(|&byte| byte == 0)?;
    let start = name + kind + 2;
    let value = u32::from_le_bytes(*bytes.get(start..)?.first_chunk()?) as usize;
    (start + 4 + value <= bytes.len()).then_some(start + 4 + value)
}

#[cfg(test)]
mod tests {
    use exr::prelude::*;

    use super::*;
    use crate::film::matte::Coverage;
    use crate::film::pixel::Pixel;

    /// The name of a channel and its value in a pixel.
    type Channel<T> = (&'static str, fn(&Pixel) -> T);

    #[test]
    fn attributes_of_mattes_are_sorted_and_their_names_ascii() {
        let thing = |name| Coverage { id: matte_id(name), share: 0.5 };
        let mut mattes = Mattes::new(2);
        let names = ["all/\"ä\\", "all/😀", "other"];
        mattes.set(0, [&[thing(names[0]), thing(names[1])], &[thing(names[2])]]);
        mattes.add_names(names.map(|name| (matte_id(name), name)));
        let film = Film::new(2, 1).with_mattes(mattes);
        let file = exr_file(&film, 0.0, &[]).unwrap();
        for _ in 0..5 {
            assert!(exr_file(&film, 0.0, &[]).unwrap() == file);
        }
        let meta = exr::meta::MetaData::read_from_buffered(&*file, true).unwrap();
        let other = &meta.headers[0].own_attributes.other;
        assert_eq!(other.len(), 8);
        let id = |name| format!("{:08x}", matte_id(name));
        let expected = [
            format!(r#"{{"all/\"\u00e4\\":"{}","all/\ud83d\ude00":"{}"}}"#, id(names[0]), id(names[1])),
            format!(r#"{{"other":"{}"}}"#, id(names[2])),
        ];
        for (level, expected) in MatteLevel::ALL.into_iter().zip(expected) {
            let key = &id(level.type_name())[..7];
            let value = |field| match &other[&Text::from(&*format!("cryptomatte/{key}/{field}"))] {
                AttributeValue::Text(text) => text.to_string(),
                other => panic!("{other:?}"),
            };
            let found = ["name", "hash", "conversion", "manifest"].map(value);
            assert_eq!(found, [level.type_name(), "MurmurHash3_32", "uint32_to_float32", &expected]);
        }
    }

    #[test]
    fn a_file_read_back_has_every_value_to_the_bit() {
        let mut film = Film::new(37, 21);
        for (x, y) in (0..21).flat_map(|y| (0..37).map(move |x| (x, y))) {
            let value = |k: u32| (x * 13 + y * 7 + k) as f32 / 3.0;
            let pixel = Pixel {
                color: [value(0), -value(1), 1e30],
                alpha: 0.5,
                depth: if x > 30 { f32::INFINITY } else { value(2) },
                normal: [value(3), value(4), value(5)],
                albedo: [value(6), value(7), value(8)],
                id: u32::MAX - x,
                instance: (1 << 24) - x,
                object: y,
                samples: y + 1,
            };
            film.set(x, y, pixel);
        }
        let note = PictureNote { name: "superegg:scene", text: "prm ball".to_owned() };
        let file = exr_file(&film, 0.0, &[note]).unwrap();
        assert_eq!(notes_of_exr(&file).unwrap().unwrap(), "superegg:scene\nprm ball\n");
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(&file))
            .unwrap();
        let channel = |name: &str| {
            let mut channels = image.layer_data.channel_data.list.iter();
            &channels.find(|channel| channel.name.eq(name)).unwrap().sample_data
        };
        let floats: [Channel<f32>; 13] = [
            ("instance", |p| p.instance as f32),
            ("object", |p| p.object as f32),
            ("R", |p| p.color[0]),
            ("G", |p| p.color[1]),
            ("B", |p| p.color[2]),
            ("A", |p| p.alpha),
            ("Z", |p| p.depth),
            ("N.X", |p| p.normal[0]),
            ("N.Y", |p| p.normal[1]),
            ("N.Z", |p| p.normal[2]),
            ("albedo.R", |p| p.albedo[0]),
            ("albedo.G", |p| p.albedo[1]),
            ("albedo.B", |p| p.albedo[2]),
        ];
        for (name, of) in floats {
            let FlatSamples::F32(values) = channel(name) else { panic!("{name} is no float") };
            let expected: Vec<f32> = film.pixels().map(|pixel| of(&pixel)).collect();
            assert_eq!(values, &expected, "{name}");
        }
        let numbers: [Channel<u32>; 2] = [("id", |p| p.id), ("samples", |p| p.samples)];
        for (name, of) in numbers {
            let FlatSamples::U32(values) = channel(name) else { panic!("{name} is no whole number") };
            assert_eq!(values, &film.pixels().map(|pixel| of(&pixel)).collect::<Vec<u32>>(), "{name}");
        }
        assert_eq!(image.layer_data.channel_data.list.len(), 15);
        assert_eq!(image.attributes.chromaticities, Some(REC_709));
    }
}
