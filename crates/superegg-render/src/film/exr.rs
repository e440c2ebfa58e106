//! OpenEXR files with all layers of a film.

use std::io::Cursor;

use exr::meta::attribute::{Chromaticities, Text};
use exr::prelude::{Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage};
use thiserror::Error;

use crate::film::buffer::Film;
use crate::film::encoded::{PictureNote, SOFTWARE};
use crate::film::pixel::Pixel;

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

/// Encodes a film as an OpenEXR file: linear light before exposure and tone mapping, in 32-bit
/// floats with lossless compression. The channels have the names that compositing programs use:
///
/// | channels | values |
/// |---|---|
/// | `R G B A` | [`crate::Pixel::color`], premultiplied, and alpha |
/// | `Z` | [`crate::Pixel::depth`] in world units, infinity without a hit |
/// | `N.X N.Y N.Z` | [`crate::Pixel::normal`] |
/// | `albedo.R albedo.G albedo.B` | [`crate::Pixel::albedo`] |
/// | `id` | [`crate::Pixel::id`], a whole number |
/// | `samples` | [`crate::Pixel::samples`], a whole number |
///
/// Notes are in the attribute `comments`, each as a line with its name and the lines of its text.
///
/// # Errors
/// The encoder rejects the film, for instance for its size.
pub fn exr_file(film: &Film, notes: &[PictureNote]) -> Result<Vec<u8>, ExrError> {
    exr_of_pixels((film.width(), film.height()), |x, y| film.pixel(x, y), notes)
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

/// As [`exr_file`], of pixels that need not be in one film. A pixel of `None` is [`Pixel::EMPTY`].
///
/// # Errors
/// The encoder rejects the picture, for instance for its size.
pub fn exr_of_pixels(
    size: (u32, u32),
    pixel: impl Fn(u32, u32) -> Option<Pixel> + Sync,
    notes: &[PictureNote],
) -> Result<Vec<u8>, ExrError> {
    let channels = SpecificChannels::build()
        .with_channel("R")
        .with_channel("G")
        .with_channel("B")
        .with_channel("A")
        .with_channel("Z")
        .with_channel("N.X")
        .with_channel("N.Y")
        .with_channel("N.Z")
        .with_channel("albedo.R")
        .with_channel("albedo.G")
        .with_channel("albedo.B")
        .with_channel("id")
        .with_channel("samples")
        .with_pixel_fn(|position: Vec2<usize>| {
            let pixel = pixel(position.x() as u32, position.y() as u32).unwrap_or(Pixel::EMPTY);
            let ([r, g, b], [x, y, z], [ar, ag, ab]) = (pixel.color, pixel.normal, pixel.albedo);
            (r, g, b, pixel.alpha, pixel.depth, x, y, z, ar, ag, ab, pixel.id, pixel.samples)
        });
    let comments: String =
        notes.iter().map(|PictureNote { name, text }| format!("{name}\n{text}\n")).collect();
    let attributes = LayerAttributes {
        software_name: Some(SOFTWARE.into()),
        // `None` for a text that is not of Latin letters.
        comments: Text::new_or_none(&comments).filter(|_| !notes.is_empty()),
        ..LayerAttributes::default()
    };
    let size = (size.0 as usize, size.1 as usize);
    let layer = Layer::new(size, attributes, exr::prelude::Encoding::SMALL_LOSSLESS, channels);
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(REC_709);
    let mut file = Vec::new();
    image.write().non_parallel().to_buffered(Cursor::new(&mut file))?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use exr::prelude::*;

    use super::*;

    /// The name of a channel and its value in a pixel.
    type Channel<T> = (&'static str, fn(&Pixel) -> T);

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
                samples: y + 1,
            };
            film.set(x, y, pixel);
        }
        let note = PictureNote { name: "superegg:scene", text: "prm ball".to_owned() };
        let file = exr_file(&film, &[note]).unwrap();
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
        let floats: [Channel<f32>; 11] = [
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
        assert_eq!(image.layer_data.channel_data.list.len(), 13);
        assert_eq!(image.attributes.chromaticities, Some(REC_709));
    }
}
