//! Encoded pictures: the values of a picture file, which can be drawn on.

use std::io::Write;

use png::{BitDepth, ColorType};
use superegg_scene::Encoding;
use thiserror::Error;

/// The PNG encoder rejected a picture.
#[derive(Debug, Error)]
#[error("the picture could not be encoded: {0}")]
pub struct ImageError(#[from] png::EncodingError);

/// A developed picture with the values of its file.
///
/// ```
/// use superegg_render::{Development, Film};
/// use superegg_scene::Picture;
///
/// let mut picture = Development::of(&Picture::default()).encode(&Film::new(2, 1));
/// picture.blend(1, 0, [1.0; 3], 0.5);
/// assert_eq!(picture.value(0, 0), [0.0, 0.0, 0.0, 1.0]);
/// assert!((picture.value(1, 0)[0] - 0.5).abs() < 0.01);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedPicture {
    /// Width and height in pixels.
    pub(crate) size: (u32, u32),
    /// Whether a value has 16 bits, big-endian, and not 8.
    pub(crate) is_deep: bool,
    /// Whether each pixel has an alpha value behind red, green and blue, which are not
    /// premultiplied.
    pub(crate) has_alpha: bool,
    /// The encoding of the values, which the file states.
    pub(crate) encoding: Encoding,
    /// The values, row by row.
    pub(crate) values: Vec<u8>,
}

/// A text in a picture file, such as how it was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureNote {
    /// The keyword: 1 to 79 characters of ASCII.
    pub name: &'static str,
    /// The text.
    pub text: String,
}

impl EncodedPicture {
    /// The width in pixels.
    pub fn width(&self) -> u32 {
        self.size.0
    }

    /// The height in pixels.
    pub fn height(&self) -> u32 {
        self.size.1
    }

    /// The values, row by row: red, green, blue and, for a transparent background, alpha of each pixel;
    /// one byte each, or two, big-endian.
    pub fn values(&self) -> &[u8] {
        &self.values
    }

    fn channels(&self) -> usize {
        if self.has_alpha { 4 } else { 3 }
    }

    /// The index of the first value of a pixel, counted in values; `None` outside the picture.
    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let is_inside = x < self.size.0 && y < self.size.1;
        is_inside.then(|| (y as usize * self.size.0 as usize + x as usize) * self.channels())
    }

    fn get(&self, index: usize) -> f32 {
        if self.is_deep {
            f32::from(u16::from_be_bytes([self.values[2 * index], self.values[2 * index + 1]])) / 65535.0
        } else {
            f32::from(self.values[index]) / 255.0
        }
    }

    fn set(&mut self, index: usize, value: f32) {
        if self.is_deep {
            let bytes = ((65535.0 * value).round() as u16).to_be_bytes();
            self.values[2 * index..2 * index + 2].copy_from_slice(&bytes);
        } else {
            self.values[index] = (255.0 * value).round() as u8;
        }
    }

    /// Red, green, blue and alpha of a pixel, as encoded, from 0 to 1; black and transparent outside
    /// the picture.
    pub fn value(&self, x: u32, y: u32) -> [f32; 4] {
        let Some(index) = self.index(x, y) else { return [0.0; 4] };
        let alpha = if self.has_alpha { self.get(index + 3) } else { 1.0 };
        [self.get(index), self.get(index + 1), self.get(index + 2), alpha]
    }

    /// Covers a part of a pixel, from 0 to 1, by an encoded colour. A pixel outside the picture does
    /// nothing.
    pub fn blend(&mut self, x: u32, y: u32, color: [f32; 3], part: f32) {
        let Some(index) = self.index(x, y).filter(|_| part > 0.0) else { return };
        let part = part.min(1.0);
        let [r, g, b, alpha] = self.value(x, y);
        let covered = part + alpha * (1.0 - part);
        for (channel, (old, new)) in [r, g, b].into_iter().zip(color).enumerate() {
            self.set(index + channel, (new * part + old * alpha * (1.0 - part)) / covered);
        }
        if self.has_alpha {
            self.set(index + 3, covered);
        }
    }

    /// Encodes the picture as a PNG file. It states its encoding in an `sRGB` chunk, or as gamma 1 with the primaries of
    /// sRGB. Notes become `iTXt` chunks.
    ///
    /// # Errors
    /// The encoder rejects the picture, for instance for its size.
    pub fn png(&self, notes: &[PictureNote]) -> Result<Vec<u8>, ImageError> {
        let mut file = Vec::new();
        let mut writer = header(&mut file, self.size, &self.layout(), notes)?;
        writer.write_image_data(&self.values)?;
        writer.finish()?;
        Ok(file)
    }

    fn layout(&self) -> Layout {
        Layout { has_alpha: self.has_alpha, is_deep: self.is_deep, encoding: self.encoding }
    }
}

/// The program that pictures name as their maker, in the chunk `Software` of PNG and the attribute
/// `software` of OpenEXR.
pub const SOFTWARE: &str = "superegg";

/// The properties of a file's values.
struct Layout {
    has_alpha: bool,
    is_deep: bool,
    encoding: Encoding,
}

/// The texts of a PNG file in its `iTXt` chunks before the picture, as [`EncodedPicture::png`] writes them.
///
/// # Errors
/// It is no PNG file, or a text is damaged.
pub fn notes_of_png(file: &[u8]) -> Result<Vec<(String, String)>, NotesError> {
    let reader = png::Decoder::new(std::io::Cursor::new(file)).read_info()?;
    let texts = &reader.info().utf8_text;
    texts.iter().map(|chunk| Ok((chunk.keyword.clone(), chunk.get_text()?))).collect()
}

/// Why the texts of a PNG file cannot be read.
#[derive(Debug, Error)]
#[error("the picture cannot be read: {0}")]
pub struct NotesError(#[from] png::DecodingError);

/// Begins a file: its header, its colour chunks and its notes.
fn header<'f>(
    file: &'f mut Vec<u8>,
    size: (u32, u32),
    layout: &Layout,
    notes: &[PictureNote],
) -> Result<png::Writer<&'f mut Vec<u8>>, ImageError> {
    let mut encoder = png::Encoder::new(file, size.0, size.1);
    encoder.set_color(if layout.has_alpha { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(if layout.is_deep { BitDepth::Sixteen } else { BitDepth::Eight });
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned())?;
    match layout.encoding {
        Encoding::Srgb => encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual),
        Encoding::Linear => {
            encoder.set_source_gamma(png::ScaledFloat::new(1.0));
            encoder.set_source_chromaticities(png::SourceChromaticities::new(
                (0.3127, 0.3290),
                (0.64, 0.33),
                (0.30, 0.60),
                (0.15, 0.06),
            ));
        }
    }
    let mut writer = encoder.write_header()?;
    for PictureNote { name, text } in notes {
        writer.write_text_chunk(&png::text_metadata::ITXtChunk::new(*name, text.clone()))?;
    }
    Ok(writer)
}

/// Encodes strips of whole rows, from the top, as one PNG file. Only one strip has to be in memory.
/// The strips have the layout that the first one has, and `size` together.
///
/// # Errors
/// The encoder rejects the picture, for instance because rows are missing.
pub(crate) fn png_of_strips(
    size: (u32, u32),
    strips: impl Iterator<Item = EncodedPicture>,
    notes: &[PictureNote],
) -> Result<Vec<u8>, ImageError> {
    let mut file = Vec::new();
    let mut strips = strips.peekable();
    let none = Layout { has_alpha: false, is_deep: false, encoding: Encoding::Srgb };
    let layout = strips.peek().map_or(none, EncodedPicture::layout);
    let mut writer = header(&mut file, size, &layout, notes)?;
    let mut rows = writer.stream_writer()?;
    for strip in strips {
        rows.write_all(&strip.values).map_err(png::EncodingError::from)?;
    }
    rows.finish()?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use superegg_scene::{Encoding, Picture};

    use super::{PictureNote, notes_of_png};
    use crate::film::buffer::Film;
    use crate::film::develop::Development;
    use crate::film::pixel::Pixel;

    #[test]
    fn a_covered_pixel_is_the_mean_of_both_colours_in_every_layout() {
        let grey = Pixel { color: [0.25; 3], alpha: 1.0, ..Pixel::EMPTY };
        for (bits, transparent) in [(8, false), (8, true), (16, false), (16, true)] {
            let development = Development { bits, transparent, ..Development::of(&Picture::default()) };
            let mut picture = development.encode(&Film::of_pixels(3, 2, [grey; 6]));
            let before = picture.clone();
            let old = picture.value(1, 1);
            picture.blend(1, 1, [1.0, 0.0, 0.5], 0.25);
            for (channel, new) in [1.0, 0.0, 0.5].into_iter().enumerate() {
                let expected = 0.75 * old[channel] + 0.25 * new;
                assert!(
                    (picture.value(1, 1)[channel] - expected).abs() < 0.51 / 255.0,
                    "{bits} {transparent}"
                );
            }
            for (x, y) in [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1)] {
                assert_eq!(picture.value(x, y), before.value(x, y));
            }
            // Outside, and nothing.
            let mut same = before.clone();
            same.blend(3, 0, [1.0; 3], 1.0);
            same.blend(0, 2, [1.0; 3], 1.0);
            same.blend(u32::MAX, u32::MAX, [1.0; 3], 1.0);
            same.blend(0, 0, [1.0; 3], 0.0);
            same.blend(0, 0, [1.0; 3], f32::NAN);
            assert_eq!(same, before);
        }
    }

    #[test]
    fn a_file_states_its_encoding_and_its_notes() {
        let long = "box ball \u{e9}\n".repeat(500);
        let notes =
            ["short", &long].map(|text| PictureNote { name: "superegg:scene", text: text.to_owned() });
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            let development = Development { encoding, ..Development::of(&Picture::default()) };
            let file = development.encode(&Film::new(5, 3)).png(&notes).unwrap();
            let texts: Vec<String> = notes_of_png(&file).unwrap().into_iter().map(|(_, text)| text).collect();
            assert_eq!(texts, ["short", &long]);
            let has = |chunk: &[u8]| file.windows(4).any(|window| window == chunk);
            assert_eq!(
                (has(b"sRGB"), has(b"cHRM")),
                (encoding == Encoding::Srgb, encoding == Encoding::Linear)
            );
        }
        assert!(notes_of_png(b"no picture").is_err());
    }

    #[test]
    fn a_clear_pixel_takes_the_colour_and_the_part_as_alpha() {
        let development = Development { transparent: true, ..Development::of(&Picture::default()) };
        let mut picture = development.encode(&Film::new(1, 1));
        picture.blend(0, 0, [0.2, 0.4, 0.6], 0.5);
        for (value, expected) in picture.value(0, 0).into_iter().zip([0.2, 0.4, 0.6, 0.5]) {
            assert!((value - expected).abs() < 0.51 / 255.0, "{value}");
        }
    }
}
