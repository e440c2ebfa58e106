//! From a film's linear values to those of a screen and a PNG file.
//!
//! ```text
//! colour / alpha  -> exposure: times 2^stops -> tone -> cut to [0, 1] -> encoding -> 8 or 16 bits
//! ```
//!
//! The division by alpha only where the background is transparent: PNG files keep colour apart from alpha, so that an edge has its surface's
//! full colour and no dark fringe.

use png::{BitDepth, ColorType};
use superegg_scene::{Encoding, Picture, Tone};
use thiserror::Error;

use crate::film::buffer::Film;

/// Why a picture could not be written.
#[derive(Debug, Error)]
#[error("the picture could not be encoded: {0}")]
pub struct ImageError(#[from] png::EncodingError);

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
    /// Stops by which it is brighter: linear values are multiplied by 2^exposure.
    pub exposure: f64,
    /// How bright light is brought into range.
    pub tone: Tone,
    /// How linear values become numbers of a file.
    pub encoding: Encoding,
    /// Bits a channel in a PNG file: 16, or 8.
    pub bits: u32,
    /// Whether a PNG file has alpha.
    pub transparent: bool,
}

impl Development {
    /// The one that a picture asks for.
    pub fn of(picture: &Picture) -> Self {
        Self {
            exposure: picture.exposure,
            tone: picture.tone,
            encoding: picture.encoding,
            bits: picture.bits,
            transparent: picture.transparent,
        }
    }

    /// The same for values that are no light: they are those of the file.
    pub fn undeveloped(picture: &Picture) -> Self {
        Self { exposure: 0.0, tone: Tone::None, encoding: Encoding::Linear, ..Self::of(picture) }
    }

    /// The value of a linear colour on a screen, each part in [0, 1]: exposure, tone and encoding. NaN, which no shading should give, becomes 0.
    pub fn value(&self, linear: [f32; 3]) -> [f32; 3] {
        self.toning().of(linear).map(|value| encoded(value, self.encoding))
    }

    fn toning(&self) -> ToneCurve {
        ToneCurve { gain: self.exposure.exp2() as f32, tone: self.tone }
    }

    /// The linear colour of each pixel after exposure and tone, and its alpha.
    fn developed(&self, film: &Film) -> impl Iterator<Item = ([f32; 3], f32)> {
        let (toning, transparent) = (self.toning(), self.transparent);
        film.light().map(move |(color, alpha)| {
            if !transparent {
                return (toning.of(color), 1.0);
            }
            // NaN counts as nothing there.
            let alpha = alpha.clamp(0.0, 1.0).max(0.0);
            if alpha == 0.0 {
                return ([0.0; 3], 0.0);
            }
            (toning.of(color.map(|value| value / alpha)), alpha)
        })
    }

    /// The picture as bytes, red, green and blue of each pixel, without alpha: a transparent background is black.
    pub fn rgb8(&self, film: &Film) -> Vec<u8> {
        let (steps, toning) = (ByteTable::new(self.encoding), self.toning());
        let mut bytes = vec![0; 3 * film.colors().len()];
        for (to, &color) in bytes.as_chunks_mut().0.iter_mut().zip(film.colors()) {
            let [r, g, b] = toning.of(color);
            *to = [steps.byte(r), steps.byte(g), steps.byte(b)];
        }
        bytes
    }

    /// Red, green, blue and alpha of each pixel, colour apart from alpha.
    fn rgba8(&self, film: &Film) -> Vec<u8> {
        let steps = ByteTable::new(self.encoding);
        self.developed(film)
            .flat_map(|([r, g, b], alpha)| {
                [steps.byte(r), steps.byte(g), steps.byte(b), (255.0 * alpha).round() as u8]
            })
            .collect()
    }

    /// Red, green, blue and, where the background is transparent, alpha of each pixel in 16 bits, the high byte first.
    fn deep(&self, film: &Film) -> Vec<u8> {
        let channels = if self.transparent { 4 } else { 3 };
        let values = self.developed(film).flat_map(|(color, alpha)| {
            let [r, g, b] = color.map(|value| encoded(value, self.encoding));
            [r, g, b, alpha].into_iter().take(channels)
        });
        values.flat_map(|value| ((65535.0 * value).round() as u16).to_be_bytes()).collect()
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// The encoder refuses it, for instance for its size.
    pub fn png(&self, film: &Film) -> Result<Vec<u8>, ImageError> {
        let color = if self.transparent { ColorType::Rgba } else { ColorType::Rgb };
        let (values, depth) = match (self.bits > 8, self.transparent) {
            (false, false) => (self.rgb8(film), BitDepth::Eight),
            (false, true) => (self.rgba8(film), BitDepth::Eight),
            (true, _) => (self.deep(film), BitDepth::Sixteen),
        };
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, film.width(), film.height());
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.write_header()?.write_image_data(&values)?;
        Ok(file)
    }
}

/// Exposure and tone.
#[derive(Clone, Copy)]
struct ToneCurve {
    /// The factor of the exposure.
    gain: f32,
    tone: Tone,
}

impl ToneCurve {
    /// Linear values after both, not yet cut to [0, 1].
    fn of(self, [r, g, b]: [f32; 3]) -> [f32; 3] {
        let exposed = [r * self.gain, g * self.gain, b * self.gain];
        match self.tone {
            Tone::None => exposed,
            Tone::Reinhard => reinhard(exposed),
            Tone::Filmic => exposed.map(filmic),
        }
    }
}

/// The luminance that becomes white by [`reinhard`].
const REINHARD_WHITE: f32 = 4.0;

/// x (1 + x / w^2) / (1 + x) of the luminance (Reinhard et al. 2002, equation 4); the colour keeps its hue.
fn reinhard(color: [f32; 3]) -> [f32; 3] {
    let [r, g, b] = color;
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let scale = (1.0 + luminance / (REINHARD_WHITE * REINHARD_WHITE)) / (1.0 + luminance);
    // It is NaN for infinite light, which is white as it is.
    if luminance > 0.0 && scale > 0.0 { color.map(|value| value * scale) } else { color }
}

/// The fit of Narkowicz (2015) to the ACES film curve, of one channel.
fn filmic(value: f32) -> f32 {
    // Far above 1 the curve is flat, and its squares would overflow.
    let x = value.clamp(0.0, 1e6);
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The byte of a linear value by one look into a table, the same as by [`encoded`].
struct ByteTable(Vec<Segment>);

/// One of many nearly equal parts of [0, 1], within which the byte goes up by one at most.
#[derive(Clone, Copy)]
struct Segment {
    /// The value where it does; infinity where it does not.
    step: f32,
    /// The byte before.
    byte: u32,
}

/// Parts of [0, 1] in the table; the steepest part of the sRGB curve goes up by one byte in 3e-4.
const SEGMENTS: usize = 4096;
/// The numbers from here to its double are whole, so what is added to it is rounded to a whole number, in the last bits.
const WHOLE: f32 = (1 << 23) as f32;

impl ByteTable {
    fn new(encoding: Encoding) -> Self {
        let mut parts = vec![Segment { step: f32::INFINITY, byte: 0 }; SEGMENTS + 1];
        for byte in 1..=255u32 {
            let near = decoded((byte as f32 - 0.5) / 255.0, encoding);
            // Bits of floats >= 0 are in the order of the floats.
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
            parts[segment_of(step)].step = step;
        }
        let mut byte = 0;
        for part in &mut parts {
            part.byte = byte;
            byte += u32::from(part.step <= 1.0);
        }
        Self(parts)
    }

    fn byte(&self, value: f32) -> u8 {
        // NaN becomes 0, like what is below.
        let value = if value > 0.0 { value } else { 0.0 };
        let value = if value < 1.0 { value } else { 1.0 };
        let Segment { step, byte } = self.0[segment_of(value)];
        (byte + u32::from(step <= value)) as u8
    }
}

/// The part in which a value from 0 to 1 is.
fn segment_of(value: f32) -> usize {
    ((value * SEGMENTS as f32 + WHOLE).to_bits() - WHOLE.to_bits()) as usize
}

fn byte_of(value: f32, encoding: Encoding) -> u8 {
    (255.0 * encoded(value, encoding)).round() as u8
}

/// One linear value, cut to [0, 1], on the curve of the encoding (sRGB: IEC 61966-2-1); 0 for NaN.
fn encoded(value: f32, encoding: Encoding) -> f32 {
    let value = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
    match encoding {
        Encoding::Linear => value,
        Encoding::Srgb if value <= 0.003_130_8 => 12.92 * value,
        Encoding::Srgb => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    }
}

/// The linear value of one on the curve of the encoding, from 0 to 1.
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
    };

    fn film(pixels: &[([f32; 3], f32)]) -> Film {
        let mut film = Film::new(pixels.len() as u32, 1);
        for (x, &(color, alpha)) in pixels.iter().enumerate() {
            film.set(x as u32, 0, Pixel { color, alpha, ..Pixel::EMPTY });
        }
        film
    }

    #[test]
    fn encodings_meet_known_values() {
        let known =
            [(0.0, 0, 0), (1.0, 255, 255), (0.5, 188, 128), (0.2140, 127, 55), (7.0, 255, 255), (-1.0, 0, 0)];
        for (value, srgb, linear) in known {
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
            let steps = ByteTable::new(encoding);
            let bits = (0..0x3f90_0000u32).step_by(997).map(f32::from_bits);
            for value in bits.chain(steps.0.iter().map(|part| part.step)).chain([
                f32::NAN,
                f32::INFINITY,
                -1.0,
                -0.0,
                0.999_999_94,
            ]) {
                assert_eq!(steps.byte(value), byte_of(value, encoding), "{value}");
                assert_eq!(steps.byte(value.next_down()), byte_of(value.next_down(), encoding), "{value}");
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
    fn tone_curves_meet_known_values() {
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

    proptest! {
        #[test]
        fn every_curve_rises_and_stays_within_bounds(a in 0f32..20.0, b in 0f32..20.0, exposure in -4f64..4.0) {
            for tone in [Tone::None, Tone::Reinhard, Tone::Filmic] {
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
        // Two thirds of a pixel are an orange surface before a blue background.
        let (surface, background) = ([0.9f32, 0.5, 0.1], [0.1f32, 0.2, 0.7]);
        for share in [0.0f32, 1.0 / 255.0, 0.1, 0.5, 2.0 / 3.0, 0.999, 1.0] {
            let film = film(&[(surface.map(|value| share * value), share)]);
            for bits in [8, 16] {
                let file = Development { transparent: true, bits, ..PLAIN }.png(&film).unwrap();
                let pixel = image::load_from_memory(&file).unwrap().to_rgba32f().get_pixel(0, 0).0;
                let linear = |value: f32| decoded(value, Encoding::Srgb);
                for channel in 0..3 {
                    let over = pixel[3] * linear(pixel[channel]) + (1.0 - pixel[3]) * background[channel];
                    let opaque = share * surface[channel] + (1.0 - share) * background[channel];
                    assert!((over - opaque).abs() < 0.006, "{share}, {bits} bits: {over} {opaque}");
                    if share > 0.0 {
                        assert!(
                            (linear(pixel[channel]) - surface[channel]).abs() < 0.005,
                            "a fringe at {share}"
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
