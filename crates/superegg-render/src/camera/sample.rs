//! A sample of the picture.

use superegg_geom::glam::DVec2;

/// A sample of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmSample {
    /// The pixel, from the top left corner, and the number of the sample within it: what its random numbers are drawn from.
    pub(crate) pixel: (u32, u32),
    pub(crate) index: u32,
    /// The place on the film in pixels from the top left corner: the centre of the first pixel is (0.5, 0.5).
    pub(crate) film_px: DVec2,
}
