//! How the picture of a scene is taken, where the command that takes it does not say.

/// How linear values become bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// The sRGB curve (IEC 61966-2-1): what screens expect.
    Srgb,
    /// The values as they are: 255 times each.
    Linear,
}

/// How the samples of a pixel are weighted: the share of each point of the film in a pixel's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The pixel's own square, evenly.
    Box,
    /// A tent that falls to 0 one pixel away from the centre.
    Tent,
    /// A bell of standard deviation 0.5 pixels, cut off at 2 pixels.
    Gaussian,
    /// The window of Blackman and Harris, 2 pixels to each side: hardly any ringing, hardly any stairs.
    Blackman,
    /// The cubic of Mitchell and Netravali (1988), B = C = 1/3, 2 pixels to each side: sharper, with slight ringing.
    Mitchell,
}

/// How light of any strength is brought into the range of a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// What is above 1 is cut off.
    None,
    /// x (1 + x / 16) / (1 + x) of the luminance (Reinhard et al. 2002): 4 becomes white, less is bent gently.
    Reinhard,
    /// A film's curve in each channel (Narkowicz's fit of ACES, 2015): more contrast, bright colours turn white.
    Filmic,
}

/// Size and quality of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels, 1 to [`Picture::LONGEST_SIDE`].
    pub width: u32,
    /// Height in pixels, 1 to [`Picture::LONGEST_SIDE`].
    pub height: u32,
    /// Samples a pixel, 1 to [`Picture::MOST_SAMPLES`].
    pub samples: u32,
    /// Where above 0: a pixel takes more samples until the standard error of its value on the screen (0 to 1) is below this.
    pub noise: f64,
    /// The most samples that a pixel takes for `noise`, 1 to [`Picture::MOST_SAMPLES`].
    pub most_samples: u32,
    /// How samples are weighted.
    pub filter: Filter,
    /// How linear values become numbers of a file.
    pub encoding: Encoding,
    /// Stops by which the picture is brighter: linear values are multiplied by 2^exposure.
    pub exposure: f64,
    /// How bright light is brought into range.
    pub tone: Tone,
    /// Bits a channel in a PNG file: 8 or 16.
    pub bits: u32,
    /// Whether the background is left transparent.
    pub transparent: bool,
    /// After so many mirrorings and transmissions a ray sees the sky.
    pub bounces: u32,
    /// A ray that adds less than this share to its pixel is not followed, [0, 1].
    pub least_weight: f64,
    /// Shadow rays to each light of some radius, for each point that a camera ray meets, at least 1.
    pub light_rays: u32,
    /// Rays into which a surface's gloss spreads what it mirrors, for each point that a camera ray meets; 0 mirrors sharply, whatever the
    /// gloss.
    pub gloss_rays: u32,
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
        Self {
            width: 1280,
            height: 960,
            samples: 4,
            noise: 0.0,
            most_samples: 1024,
            filter: Filter::Box,
            encoding: Encoding::Srgb,
            exposure: 0.0,
            tone: Tone::None,
            bits: 8,
            transparent: false,
            bounces: 16,
            least_weight: 1.0 / 1280.0,
            light_rays: 4,
            gloss_rays: 0,
        }
    }
}
