//! The grid of test points of the inside-outside test.

use anyhow::{Result, bail};
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;

/// The maximum number of points along each axis.
const MOST_ALONG_AXIS: f64 = 2001.0;

/// The points `step * (i, j, k)` with `|i|, |j|, |k| <= half / step`, as in the course text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    step: f64,
    most: i32,
}

impl Grid {
    /// A grid with spacing `step` that extends by `half` from the origin along each axis.
    ///
    /// # Errors
    /// The grid has more than 2001 points along an axis.
    pub(crate) fn new(step: f64, half: f64) -> Result<Self> {
        // A quotient just below a whole number by rounding counts as that number: 0.3 / 0.1.
        let most = (half / step * (1.0 + 4.0 * f64::EPSILON)).floor();
        if 2.0 * most + 1.0 > MOST_ALONG_AXIS || !most.is_finite() {
            bail!(
                "a grid with step {} as far as {} has more than {MOST_ALONG_AXIS} points along each axis; take a larger step",
                format_number(step),
                format_number(half)
            );
        }
        Ok(Self { step, most: most as i32 })
    }

    /// All points; z varies fastest.
    pub(crate) fn points(self) -> impl Iterator<Item = DVec3> {
        let range = move || (-self.most..=self.most).map(move |i| self.step * f64::from(i));
        range().flat_map(move |x| range().flat_map(move |y| range().map(move |z| DVec3::new(x, y, z))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_has_both_ends() {
        let count = |step, half| Grid::new(step, half).unwrap().points().count();
        assert_eq!((count(0.5, 5.0), count(0.1, 0.3), count(1.0, 0.0), count(2.0, 1.0)), (9261, 343, 1, 1));
        assert!(Grid::new(1e-9, 5.0).is_err() && Grid::new(1e-300, 1e300).is_err());
    }
}
