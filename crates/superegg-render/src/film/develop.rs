//! Development: from linear light to encoded values and PNG files.
//!
//! ```text
//! colour / alpha -> times 2^exposure -> tone mapping -> clamp to [0, 1] -> encoding -> dither -> 8, 16 bits
//! ```
//!
//! The division by alpha applies to transparent backgrounds only. The colour of PNG files is not
//! premultiplied, so that edges have no dark fringe.

use superegg_scene::{Encoding, Picture, Tone};

use crate::film::buffer::Film;
use crate::film::dither;
use crate::film::encoded::{EncodedPicture, ImageError, PictureNote, png_of_strips};
use crate::film::tile::Tile;
use crate::film::tone::ToneCurve;

/// How a film becomes a picture: exposure, tone mapping, encoding and the layout of the file.
///
/// ```
/// use superegg_render::{Development, Film, Pixel};
/// use superegg_scene::Picture;
///
/// let white = Pixel { color: [1.0; 3], alpha: 1.0, samples: 1, ..Pixel::EMPTY };
/// let film = Film::of_pixels(2, 1, [white]);
/// assert_eq!(Development::of(&Picture::default()).rgb8(&film), [255, 255, 255, 0, 0, 0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Exposure in stops: linear values are multiplied by 2^exposure.
    pub exposure: f64,
    /// The tone mapping of bright light.
    pub tone: Tone,
    /// The encoding of linear values.
    pub encoding: Encoding,
    /// The bits per channel of a PNG file: 8 or 16.
    pub bits: u32,
    /// Whether a PNG file has an alpha channel.
    pub transparent: bool,
    /// Whether 8 bits are dithered, so that gradients have no bands.
    pub dither: bool,
}

impl Development {
    /// The development that the settings of a picture describe.
    pub fn of(picture: &Picture) -> Self {
        Self {
            exposure: picture.exposure,
            tone: picture.tone,
            encoding: picture.encoding,
            bits: picture.bits,
            transparent: picture.transparent,
            dither: picture.dither,
        }
    }

    /// The development for values that are no light: they go to the file unchanged.
    pub fn undeveloped(picture: &Picture) -> Self {
        Self {
            exposure: 0.0,
            tone: Tone::None,
            encoding: Encoding::Linear,
            dither: false,
            ..Self::of(picture)
        }
    }

    /// The encoded value of a linear colour, with each channel in [0, 1], after exposure and tone
    /// mapping. NaN becomes 0.
    pub fn value(&self, linear: [f32; 3]) -> [f32; 3] {
        self.tone_curve().apply(linear).map(|value| encoded(value, self.encoding))
    }

    fn tone_curve(&self) -> ToneCurve {
        ToneCurve { gain: self.exposure.exp2() as f32, tone: self.tone }
    }

    /// The linear colour of each pixel after exposure and tone mapping, and its alpha. The colour
    /// is not premultiplied.
    fn developed(&self, film: &Film) -> impl Iterator<Item = ([f32; 3], f32)> {
        let (curve, transparent) = (self.tone_curve(), self.transparent);
        film.light().map(move |(color, alpha)| {
            if !transparent {
                return (curve.apply(color), 1.0);
            }
            // NaN becomes 0.
            let alpha = alpha.clamp(0.0, 1.0).max(0.0);
            if alpha == 0.0 {
                return ([0.0; 3], 0.0);
            }
            (curve.apply(color.map(|value| value / alpha)), alpha)
        })
    }

    /// The picture in 8 bits: red, green and blue of each pixel. A transparent background is black.
    pub fn rgb8(&self, film: &Film) -> Vec<u8> {
        self.rgb8_from(film, (0, 0))
    }

    /// [`Development::rgb8`] of a part of a picture, whose top left pixel is `origin`.
    fn rgb8_from(&self, film: &Film, origin: (u32, u32)) -> Vec<u8> {
        if self.dither {
            let developed = film.colors().iter().map(|&color| self.value(color));
            return self.dithered(film.width(), origin, developed).flatten().collect();
        }
        let (table, curve) = (ByteTable::new(self.encoding), self.tone_curve());
        let mut bytes = vec![0; 3 * film.colors().len()];
        for (to, &color) in bytes.as_chunks_mut().0.iter_mut().zip(film.colors()) {
            let [r, g, b] = curve.apply(color);
            *to = [table.byte(r), table.byte(g), table.byte(b)];
        }
        bytes
    }

    /// The bytes of encoded colours of a part of a picture, row by row, dithered.
    fn dithered(
        &self,
        width: u32,
        (left, top): (u32, u32),
        colors: impl Iterator<Item = [f32; 3]>,
    ) -> impl Iterator<Item = [u8; 3]> {
        let pixels = (top..).flat_map(move |y| (left..left + width).map(move |x| (x, y)));
        pixels.zip(colors).map(|((x, y), color)| color.map(|value| dither::byte(value, x, y)))
    }

    /// Red, green, blue and alpha of each pixel in 8 bits. The colour is not premultiplied.
    fn rgba8(&self, film: &Film, origin: (u32, u32)) -> Vec<u8> {
        if self.dither {
            let encode = |value| encoded(value, self.encoding);
            let colors = self.developed(film).map(|(color, _)| color.map(encode));
            let alphas = self.developed(film).map(|(_, alpha)| (255.0 * alpha).round() as u8);
            let dithered = self.dithered(film.width(), origin, colors);
            return dithered.zip(alphas).flat_map(|([r, g, b], alpha)| [r, g, b, alpha]).collect();
        }
        let table = ByteTable::new(self.encoding);
        self.developed(film)
            .flat_map(|([r, g, b], alpha)| {
                [table.byte(r), table.byte(g), table.byte(b), (255.0 * alpha).round() as u8]
            })
            .collect()
    }

    /// Red, green, blue and, for a transparent background, alpha of each pixel in 16 bits,
    /// big-endian.
    fn channels16(&self, film: &Film) -> Vec<u8> {
        let channels = if self.transparent { 4 } else { 3 };
        let values = self.developed(film).flat_map(|(color, alpha)| {
            let [r, g, b] = color.map(|value| encoded(value, self.encoding));
            [r, g, b, alpha].into_iter().take(channels)
        });
        values.flat_map(|value| ((65535.0 * value).round() as u16).to_be_bytes()).collect()
    }

    /// The encoded picture.
    pub fn encode(&self, film: &Film) -> EncodedPicture {
        self.encode_from(film, (0, 0))
    }

    /// The encoded pixels of a tile: those of the whole picture there.
    ///
    /// ```
    /// use superegg_render::{Development, Film, tiles};
    /// use superegg_scene::Picture;
    ///
    /// let development = Development::of(&Picture { transparent: true, ..Picture::default() });
    /// let film = Film::new(40, 20);
    /// let tile = &tiles(40, 20)[3];
    /// assert_eq!(development.encode_tile(&film.tile(tile), tile).values().len(), 4 * tile.pixel_count());
    /// ```
    pub fn encode_tile(&self, film: &Film, tile: &Tile) -> EncodedPicture {
        self.encode_from(film, (tile.x.start, tile.y.start))
    }

    /// The encoded pixels of a part of a picture, whose top left pixel is `origin`.
    fn encode_from(&self, film: &Film, origin: (u32, u32)) -> EncodedPicture {
        let values = match (self.bits > 8, self.transparent) {
            (false, false) => self.rgb8_from(film, origin),
            (false, true) => self.rgba8(film, origin),
            (true, _) => self.channels16(film),
        };
        let size = (film.width(), film.height());
        EncodedPicture {
            size,
            is_deep: self.bits > 8,
            has_alpha: self.transparent,
            encoding: self.encoding,
            values,
        }
    }

    /// Encodes the picture as a PNG file.
    ///
    /// # Errors
    /// The encoder rejects the picture, for instance for its size.
    pub fn png(&self, film: &Film) -> Result<Vec<u8>, ImageError> {
        self.encode(film).png(&[])
    }

    /// Encodes strips of whole rows, from the top, as one PNG file of this width and height. Only one
    /// strip has to be in memory.
    ///
    /// # Errors
    /// The encoder rejects the picture, for instance because rows are missing.
    pub fn png_of_strips(
        &self,
        size: (u32, u32),
        strips: impl Iterator<Item = Film>,
        notes: &[PictureNote],
    ) -> Result<Vec<u8>, ImageError> {
        let mut next_row = 0;
        let rows = strips.map(|strip| {
            let first_row = next_row;
            next_row += strip.height();
            self.encode_from(&strip, (0, first_row))
        });
        png_of_strips(size, rows, notes)
    }
}

/// A table from linear values to bytes. Gives the same bytes as [`byte_of`].
struct ByteTable(Vec<Segment>);

/// One segment of [0, 1], in which the byte increases by at most one.
#[derive(Clone, Copy)]
struct Segment {
    /// The value where the byte increases; infinity if it does not.
    step: f32,
    /// The byte below `step`.
    byte: u32,
}

/// The number of segments. A segment is shorter than 3e-4, the least distance between two steps of
/// the sRGB curve.
const SEGMENTS: usize = 4096;
/// f32 has no fractions from 2^23 to 2^24. So adding a number to 2^23 rounds it to an integer,
/// which is in the lowest bits.
const ROUNDING: f32 = (1 << 23) as f32;

impl ByteTable {
    fn new(encoding: Encoding) -> Self {
        let mut segments = vec![Segment { step: f32::INFINITY, byte: 0 }; SEGMENTS + 1];
        for byte in 1..=255u32 {
            let near = decoded((byte as f32 - 0.5) / 255.0, encoding);
            // The bits of floats >= 0 have the same order as the floats.
            let (mut low, mut high) = ((0.9999 * near).to_bits(), (1.0001 * near).to_bits());
            while low < high {
                let middle = low.midpoint(high);
                if u32::from(byte_of(f32::from_bits(middle), encoding)) >= byte {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            let step = f32::from_bits(low);
            segments[segment_of(step)].step = step;
        }
        let mut byte = 0;
        for segment in &mut segments {
            segment.byte = byte;
            byte += u32::from(segment.step <= 1.0);
        }
        Self(segments)
    }

    fn byte(&self, value: f32) -> u8 {
        // NaN becomes 0, like negative values.
        let value = if value > 0.0 { value } else { 0.0 };
        let value = if value < 1.0 { value } else { 1.0 };
        let Segment { step, byte } = self.0[segment_of(value)];
        (byte + u32::from(step <= value)) as u8
    }
}

/// The index of the segment of a value in [0, 1].
fn segment_of(value: f32) -> usize {
    ((value * SEGMENTS as f32 + ROUNDING).to_bits() - ROUNDING.to_bits()) as usize
}

fn byte_of(value: f32, encoding: Encoding) -> u8 {
    (255.0 * encoded(value, encoding)).round() as u8
}

/// Encodes a linear value, clamped to [0, 1] (sRGB: IEC 61966-2-1). NaN becomes 0.
fn encoded(value: f32, encoding: Encoding) -> f32 {
    let value = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
    match encoding {
        Encoding::Linear => value,
        Encoding::Srgb if value <= 0.003_130_8 => 12.92 * value,
        Encoding::Srgb => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    }
}

/// Decodes an encoded value in [0, 1]. The inverse of [`encoded`].
fn decoded(value: f32, encoding: Encoding) -> f32 {
    match encoding {
        Encoding::Linear => value,
        Encoding::Srgb if value <= 0.04045 => value / 12.92,
        Encoding::Srgb => ((value + 0.055) / 1.055).powf(2.4),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::film::pixel::Pixel;

    const PLAIN: Development = Development {
        exposure: 0.0,
        tone: Tone::None,
        encoding: Encoding::Srgb,
        bits: 8,
        transparent: false,
        dither: false,
    };

    fn film(pixels: &[([f32; 3], f32)]) -> Film {
        let mut film = Film::new(pixels.len() as u32, 1);
        for (x, &(color, alpha)) in pixels.iter().enumerate() {
            film.set(x as u32, 0, Pixel { color, alpha, ..Pixel::EMPTY });
        }
        film
    }

    #[test]
    fn encodings_have_reference_values() {
        let references =
            [(0.0, 0, 0), (1.0, 255, 255), (0.5, 188, 128), (0.2140, 127, 55), (7.0, 255, 255), (-1.0, 0, 0)];
        for (value, srgb, linear) in references {
            assert_eq!(
                (byte_of(value, Encoding::Srgb), byte_of(value, Encoding::Linear)),
                (srgb, linear),
                "{value}"
            );
        }
        assert_eq!(byte_of(f32::NAN, Encoding::Srgb), 0);
    }

    #[test]
    fn the_table_gives_the_same_bytes() {
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            let table = ByteTable::new(encoding);
            let bits = (0..0x3f90_0000u32).step_by(997).map(f32::from_bits);
            for value in bits.chain(table.0.iter().map(|segment| segment.step)).chain([
                f32::NAN,
                f32::INFINITY,
                -1.0,
                -0.0,
                0.999_999_94,
            ]) {
                assert_eq!(table.byte(value), byte_of(value, encoding), "{value}");
                assert_eq!(table.byte(value.next_down()), byte_of(value.next_down(), encoding), "{value}");
            }
        }
    }

    #[test]
    fn a_stop_is_a_factor_of_two() {
        let linear = Development { encoding: Encoding::Linear, ..PLAIN };
        let up = Development { exposure: 1.0, ..linear };
        let down = Development { exposure: -2.0, ..linear };
        assert_eq!(up.value([0.25, 0.5, 0.75]), [0.5, 1.0, 1.0]);
        assert_eq!(down.value([1.0, 0.5, 4.0]), [0.25, 0.125, 1.0]);
        let extreme = Development { exposure: 1e9, ..PLAIN };
        let [black, white, below] = extreme.value([0.0, 1.0, -1.0]);
        assert!(black == 0.0 && below == 0.0 && white > 0.999_999);
    }

    #[test]
    fn tone_curves_have_reference_values() {
        let of =
            |tone, value: f32| Development { tone, encoding: Encoding::Linear, ..PLAIN }.value([value; 3])[0];
        for (value, reinhard, filmic) in [
            (0.0, 0.0, 0.0),
            (0.18, 0.18 * (1.0 + 0.18 / 16.0) / 1.18, 0.2669),
            (1.0, 17.0 / 32.0, 0.8038),
            (4.0, 1.0, 0.9734),
            (1e30, 1.0, 1.0),
            (f32::INFINITY, 1.0, 1.0),
            (f32::NAN, 0.0, 0.0),
        ] {
            assert!((of(Tone::Reinhard, value) - reinhard).abs() < 1e-6, "reinhard {value}");
            assert!((of(Tone::Filmic, value) - filmic).abs() < 1e-3, "filmic {value}");
        }
    }

    #[test]
    fn reinhard_keeps_the_hue() {
        let linear = Development { tone: Tone::Reinhard, encoding: Encoding::Linear, ..PLAIN };
        let [r, g, b] = linear.value([0.8, 0.4, 0.2]);
        assert!((r / g - 2.0).abs() < 1e-5 && (g / b - 2.0).abs() < 1e-5);
    }

    #[test]
    fn curves_of_film_keep_greys_grey_and_end_in_white() {
        let of =
            |tone, value: [f32; 3]| Development { tone, encoding: Encoding::Linear, ..PLAIN }.value(value);
        for (tone, grey) in [(Tone::Aces, 0.1063), (Tone::Agx, 0.2145)] {
            assert!(of(tone, [0.0; 3]).iter().all(|x| *x < 1e-3), "{tone:?}");
            let [r, g, b] = of(tone, [0.18; 3]);
            assert!(
                (r - grey).abs() < 5e-3 && (r - g).abs() < 1e-3 && (g - b).abs() < 1e-3,
                "{tone:?} {r} {g} {b}"
            );
            assert!(of(tone, [1e6; 3]).iter().all(|x| *x > 0.98), "{tone:?}");
            // Bright colours go to white.
            let [r, g, b] = of(tone, [300.0, 30.0, 3.0]);
            assert!(r > 0.9 && g > 0.6 && b > 0.3, "{tone:?} {r} {g} {b}");
            for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                assert!(of(tone, [odd, 1.0, 0.5]).iter().all(|x| (0.0..=1.0).contains(x)), "{tone:?} {odd}");
            }
        }
    }

    #[test]
    fn dither_keeps_the_mean_and_what_is_a_whole_byte() {
        let dithered = Development { dither: true, encoding: Encoding::Linear, ..PLAIN };
        for value in [0.0, 1.0, 128.0 / 255.0, 100.3 / 255.0, 7.75 / 255.0] {
            let film = Film::of_pixels(64, 64, vec![Pixel { color: [value; 3], ..Pixel::EMPTY }; 64 * 64]);
            let bytes = dithered.rgb8(&film);
            let mean = bytes.iter().map(|byte| f64::from(*byte)).sum::<f64>() / bytes.len() as f64;
            assert!((mean - 255.0 * f64::from(value)).abs() < 0.01, "{value}: {mean}");
            let (least, most) = (bytes.iter().min().unwrap(), bytes.iter().max().unwrap());
            assert!(most - least <= u8::from((255.0 * value).fract() > 1e-3), "{value}: {least} {most}");
        }
        // Strips have the pattern of the whole.
        let gradient = |rows: std::ops::Range<u32>| {
            let values = rows.flat_map(|y| (0..16).map(move |x| (x + 16 * y) as f32 / 3000.0));
            Film::of_pixels(16, 8, values.map(|value| Pixel { color: [value; 3], ..Pixel::EMPTY }))
        };
        let whole = {
            let values = (0..256u32).map(|i| Pixel { color: [i as f32 / 3000.0; 3], ..Pixel::EMPTY });
            dithered.png(&Film::of_pixels(16, 16, values)).unwrap()
        };
        let strips =
            dithered.png_of_strips((16, 16), [gradient(0..8), gradient(8..16)].into_iter(), &[]).unwrap();
        let pixels = |file: &[u8]| image::load_from_memory(file).unwrap().to_rgb8();
        assert_eq!(pixels(&whole), pixels(&strips));
    }

    proptest! {
        #[test]
        fn every_curve_rises_and_stays_within_bounds(a in 0f32..20.0, b in 0f32..20.0, exposure in -4f64..4.0) {
            for tone in [Tone::None, Tone::Reinhard, Tone::Filmic, Tone::Aces, Tone::Agx] {
                for encoding in [Encoding::Srgb, Encoding::Linear] {
                    let one = Development { exposure, tone, encoding, ..PLAIN };
                    let [low, high] = [a.min(b), a.max(b)].map(|value| one.value([value; 3])[0]);
                    prop_assert!((0.0..=1.0).contains(&low) && (0.0..=1.0).contains(&high));
                    prop_assert!(low <= high + 1e-6, "{tone:?}: {low} {high}");
                }
            }
        }
    }

    #[test]
    fn sixteen_bits_have_the_values_of_the_curve() {
        let values: Vec<f32> = (0..=64).map(|i| i as f32 / 64.0).collect();
        let film = film(&values.iter().map(|&value| ([value; 3], 1.0)).collect::<Vec<_>>());
        let file = Development { bits: 16, ..PLAIN }.png(&film).unwrap();
        let picture = image::load_from_memory(&file).unwrap();
        let image::DynamicImage::ImageRgb16(picture) = picture else { panic!("{:?}", picture.color()) };
        for (pixel, value) in picture.pixels().zip(values) {
            let value = f64::from(value);
            let exact =
                if value <= 0.0031308 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(pixel[0]) - 65535.0 * exact).abs() <= 0.51, "{value}: {}", pixel[0]);
        }
    }

    #[test]
    fn a_transparent_edge_over_the_background_is_the_opaque_edge() {
        // An orange surface covers part of a pixel in front of a blue background.
        let (surface, background) = ([0.9f32, 0.5, 0.1], [0.1f32, 0.2, 0.7]);
        for coverage in [0.0f32, 1.0 / 255.0, 0.1, 0.5, 2.0 / 3.0, 0.999, 1.0] {
            let film = film(&[(surface.map(|value| coverage * value), coverage)]);
            for bits in [8, 16] {
                let file = Development { transparent: true, bits, ..PLAIN }.png(&film).unwrap();
                let pixel = image::load_from_memory(&file).unwrap().to_rgba32f().get_pixel(0, 0).0;
                let linear = |value: f32| decoded(value, Encoding::Srgb);
                for channel in 0..3 {
                    let over = pixel[3] * linear(pixel[channel]) + (1.0 - pixel[3]) * background[channel];
                    let opaque = coverage * surface[channel] + (1.0 - coverage) * background[channel];
                    assert!((over - opaque).abs() < 0.006, "{coverage}, {bits} bits: {over} {opaque}");
                    if coverage > 0.0 {
                        assert!(
                            (linear(pixel[channel]) - surface[channel]).abs() < 0.005,
                            "a fringe at {coverage}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn pixels_out_of_range_are_brought_into_it() {
        let odd = film(&[([f32::NAN, -1.0, 9.0], 1.5), ([0.5; 3], -0.2), ([0.5; 3], f32::NAN)]);
        let file = Development { transparent: true, ..PLAIN }.png(&odd).unwrap();
        let bytes = image::load_from_memory(&file).unwrap().to_rgba8().into_raw();
        assert_eq!(bytes, [0, 0, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0]);
    }
}
