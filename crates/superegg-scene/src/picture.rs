//! How the picture of a scene is taken, where the command that takes it does not say.

/// How linear values become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// The sRGB curve (IEC 61966-2-1): what screens expect.
    Srgb,
    /// The values as they are: 255 times each.
    Linear,
}

/// Size and quality of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels, 1 to [`Picture::LONGEST_SIDE`].
    pub width: u32,
    /// Height in pixels, 1 to [`Picture::LONGEST_SIDE`].
    pub height: u32,
    /// Samples a pixel, 1 to [`Picture::MOST_SAMPLES`].
    pub samples: u32,
    /// How linear values become bytes.
    pub encoding: Encoding,
}

impl Picture {
    /// The longest side, in pixels.
    pub const LONGEST_SIDE: u32 = 32_768;
    /// The most pixels.
    pub const MOST_PIXELS: u64 = 1 << 27;
    /// The most samples a pixel.
    pub const MOST_SAMPLES: u32 = 65_536;

    /// Whether a picture may have this size in pixels.
    pub fn is_size(width: u32, height: u32) -> bool {
        let is_side = |side| (1..=Self::LONGEST_SIDE).contains(&side);
        is_side(width) && is_side(height) && u64::from(width) * u64::from(height) <= Self::MOST_PIXELS
    }
}

impl Default for Picture {
    fn default() -> Self {
        Self { width: 1280, height: 960, samples: 4, encoding: Encoding::Srgb }
    }
}
