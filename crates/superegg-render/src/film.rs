//! The film: pixels, tiles, sums of samples, and picture files.

pub(crate) mod accumulate;
pub(crate) mod adaptive;
pub(crate) mod buffer;
pub(crate) mod develop;
pub(crate) mod dither;
pub(crate) mod encoded;
#[cfg(feature = "exr")]
pub(crate) mod exr;
#[cfg(feature = "exr")]
pub(crate) mod exr_channels;
pub(crate) mod first;
pub(crate) mod matte;
pub(crate) mod pixel;
pub(crate) mod tile;
pub(crate) mod tone;
