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
        self.pixels.iter().flatten().map(|&value| encode(value, encoding)).collect()
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
}
