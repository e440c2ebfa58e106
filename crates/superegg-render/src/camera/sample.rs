//! A sample of the picture.

use superegg_geom::glam::DVec2;

/// A sample of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmSample {
    /// Column and row of the pixel, from the top left corner.
    pub(crate) pixel: (u32, u32),
    /// The index of the sample in the pixel. Pixel and index seed the random numbers.
    pub(crate) index: u32,
    /// The position on the film, in pixels from the top left corner. The centre of the first pixel
    /// is (0.5, 0.5).
    pub(crate) film_px: DVec2,
}
