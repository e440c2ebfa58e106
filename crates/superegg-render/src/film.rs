//! The picture as linear values, and as a file.

use image::{ExtendedColorType, ImageEncoder};
use superegg_scene::Encoding;
use thiserror::Error;

/// Why a picture could not be written.
#[derive(Debug, Error)]
#[error("the picture could not be encoded: {0}")]
pub struct ImageError(#[from] image::ImageError);

/// A picture of linear colours, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Film {
    /// A black picture.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// Its width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Its height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The linear colour of a pixel.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 3] {
        self.pixels[self.place(x, y)]
    }

    pub(crate) fn set(&mut self, x: u32, y: u32, color: [f32; 3]) {
        let place = self.place(x, y);
        self.pixels[place] = color;
    }

    fn place(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// The picture as bytes, red, green and blue of each pixel. Values above 1 are cut off.
    pub fn to_bytes(&self, encoding: Encoding) -> Vec<u8> {
        let steps = Steps::new(encoding);
        self.pixels.iter().flatten().map(|&value| steps.byte(value)).collect()
    }

    /// The picture as a PNG file of 8 bits a channel.
    ///
    /// # Errors
    /// The encoder refuses it, for instance for its size.
    pub fn to_png(&self, encoding: Encoding) -> Result<Vec<u8>, ImageError> {
        let mut file = Vec::new();
        image::codecs::png::PngEncoder::new(&mut file).write_image(
            &self.to_bytes(encoding),
            self.width,
            self.height,
            ExtendedColorType::Rgb8,
        )?;
        Ok(file)
    }
}

/// The linear values at which the byte goes up by one: as fast as a look into a table, and the same to the byte as [`encode`].
struct Steps {
    /// The least value of each byte.
    least: [f32; 256],
    /// The byte of the least value of each of many equal parts of [0, 1].
    first: Vec<u8>,
}

/// Parts of [0, 1] in the table; the steepest part of the sRGB curve goes up by one byte in 3e-4.
const PARTS: usize = 4096;

impl Steps {
    fn new(encoding: Encoding) -> Self {
        let least = std::array::from_fn(|byte| {
            // Bits of floats >= 0 are in the order of the floats.
            let (mut low, mut high) = (0u32, 1f32.to_bits());
            while low < high {
                let middle = low.midpoint(high);
                if usize::from(encode(f32::from_bits(middle), encoding)) >= byte {
                    high = middle;
                } else {
                    low = middle + 1;
                }
            }
            f32::from_bits(low)
        });
        let first = (0..=PARTS).map(|part| encode(part as f32 / PARTS as f32, encoding)).collect();
        Self { least, first }
    }

    fn byte(&self, value: f32) -> u8 {
        // NaN becomes 0, like what is below.
        let value = value.clamp(0.0, 1.0);
        let mut byte = self.first[(value * PARTS as f32) as usize];
        while byte < 255 && self.least[usize::from(byte) + 1] <= value {
            byte += 1;
        }
        byte
    }
}

/// One linear value as a byte. NaN, which no shading should give, becomes 0.
fn encode(value: f32, encoding: Encoding) -> u8 {
    let value = value.clamp(0.0, 1.0);
    let curved = match encoding {
        Encoding::Linear => value,
        Encoding::Srgb if value <= 0.003_130_8 => 12.92 * value,
        Encoding::Srgb => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    };
    (255.0 * curved).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_meet_known_values() {
        let known =
            [(0.0, 0, 0), (1.0, 255, 255), (0.5, 188, 128), (0.2140, 127, 55), (7.0, 255, 255), (-1.0, 0, 0)];
        for (value, srgb, linear) in known {
            assert_eq!(
                (encode(value, Encoding::Srgb), encode(value, Encoding::Linear)),
                (srgb, linear),
                "{value}"
            );
        }
        assert_eq!(encode(f32::NAN, Encoding::Srgb), 0);
    }

    #[test]
    fn the_table_gives_the_same_bytes() {
        for encoding in [Encoding::Srgb, Encoding::Linear] {
            let steps = Steps::new(encoding);
            let bits = (0..0x3f90_0000u32).step_by(997).map(f32::from_bits);
            for value in bits.chain(steps.least).chain([f32::NAN, f32::INFINITY, -1.0, -0.0, 0.999_999_94]) {
                assert_eq!(steps.byte(value), encode(value, encoding), "{value}");
                assert_eq!(steps.byte(value.next_down()), encode(value.next_down(), encoding), "{value}");
            }
        }
    }
}
