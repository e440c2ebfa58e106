//! The image settings of a scene: size, sampling, filter, tone mapping.

/// The transfer function from linear values to file values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// The sRGB curve (IEC 61966-2-1), which screens expect.
    Srgb,
    /// Linear values.
    Linear,
}

/// The reconstruction filter: the weight of each film sample in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Constant over the pixel.
    Box,
    /// A tent of radius 1 pixel.
    Tent,
    /// A Gaussian of standard deviation 0.5 pixels and radius 2 pixels.
    Gaussian,
    /// The Blackman-Harris window of radius 2 pixels: little ringing, little aliasing.
    Blackman,
    /// The cubic of Mitchell and Netravali (1988), B = C = 1/3, radius 2 pixels: sharper, with
    /// slight ringing.
    Mitchell,
}

/// The tone mapping operator, from linear values to [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// Values above 1 are clipped.
    None,
    /// x (1 + x / 16) / (1 + x) of the luminance (Reinhard et al. 2002); luminance 4 becomes white.
    Reinhard,
    /// A filmic curve in each channel (Narkowicz's fit of ACES, 2015): more contrast, and bright
    /// colours desaturate.
    Filmic,
    /// Hill's fit of the reference rendering transform of ACES 1.0: channels are mixed before and after the curve, so that
    /// bright colours turn white.
    Aces,
    /// AgX (Sobotka) in Wrensch's approximation: soft contrast over sixteen stops, and bright colours that fade to white
    /// without a turn of hue.
    Agx,
}

/// How light reaches a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightModel {
    /// Light straight from the lights, a constant ambient light, mirrors and glass: the model of the course.
    #[default]
    Course,
    /// Light by any number of surfaces: path tracing (Kajiya 1986). The sky lights surfaces, and there is no ambient
    /// light.
    Path,
}

/// Size and quality of the image. The fields are settings of the language; `superegg_lang` has
/// their help.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels, 1 to [`Picture::LONGEST_SIDE`].
    pub width: u32,
    /// Height in pixels, 1 to [`Picture::LONGEST_SIDE`].
    pub height: u32,
    /// Samples per pixel, 1 to [`Picture::MOST_SAMPLES`].
    pub samples: u32,
    /// The noise threshold: if above 0, a pixel takes more samples until the standard error of its
    /// display value (0 to 1) is below this.
    pub noise: f64,
    /// The maximal samples per pixel for `noise`, 1 to [`Picture::MOST_SAMPLES`].
    pub most_samples: u32,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The transfer function of the file.
    pub encoding: Encoding,
    /// Exposure in stops: linear values are multiplied by 2^exposure.
    pub exposure: f64,
    /// The tone mapping operator.
    pub tone: Tone,
    /// Bits per channel in a PNG file: 8 or 16.
    pub bits: u32,
    /// Whether a file of 8 bits is dithered, so that gradients have no bands.
    pub dither: bool,
    /// The depth of pixels without a hit in OpenEXR files, in world units; 0 for infinity, which other programs make NaN
    /// of when they scale a picture.
    pub far_depth: f64,
    /// Whether OpenEXR files have the coverage of each pixel by instances and by objects, as Cryptomatte.
    pub cryptomatte: bool,
    /// Whether the finished picture is denoised, by whoever writes its file.
    pub denoise: bool,
    /// Whether the background is transparent.
    pub transparent: bool,
    /// How light reaches a surface.
    pub light_model: LightModel,
    /// The maximal number of reflections and refractions of a path; after that it sees the sky. Not for
    /// [`LightModel::Path`], whose paths end at random.
    pub bounces: u32,
    /// Rays whose weight in their pixel is below this are not traced, [0, 1]. Not for [`LightModel::Path`].
    pub least_weight: f64,
    /// Shadow rays to each area light, for each hit of a camera ray, at least 1.
    pub light_rays: u32,
    /// Glossy reflection rays for each hit of a camera ray; 0 makes reflections sharp, whatever the
    /// gloss.
    pub gloss_rays: u32,
}

impl Picture {
    /// The maximal width and height, in pixels.
    pub const LONGEST_SIDE: u32 = 32_768;
    /// The maximal number of pixels.
    pub const MOST_PIXELS: u64 = 1 << 27;
    /// The maximal samples per pixel.
    pub const MOST_SAMPLES: u32 = 65_536;

    /// Whether this is an allowed image size, in pixels.
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
            dither: false,
            far_depth: 0.0,
            cryptomatte: false,
            denoise: false,
            transparent: false,
            light_model: LightModel::Course,
            bounces: 16,
            least_weight: 1.0 / 1280.0,
            light_rays: 4,
            gloss_rays: 0,
        }
    }
}
