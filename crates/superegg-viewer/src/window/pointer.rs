//! Position and double clicks of the pointer.

use std::time::{Duration, Instant};

use superegg_geom::glam::DVec2;

/// Two clicks within this time and distance are a double click.
const DOUBLE_CLICK: Duration = Duration::from_millis(400);
const DOUBLE_CLICK_PX: f64 = 6.0;

/// The pointer.
#[derive(Debug, Default)]
pub(super) struct PointerTracker {
    /// In pixels of the window.
    pub(super) position: DVec2,
    last_click: Option<(Instant, DVec2)>,
}

impl PointerTracker {
    /// Registers a click. Returns whether it is the second of a double click.
    pub(super) fn click(&mut self, now: Instant, point: DVec2) -> bool {
        let is_double = self.last_click.is_some_and(|(then, there)| {
            now - then <= DOUBLE_CLICK && (point - there).length() <= DOUBLE_CLICK_PX
        });
        self.last_click = (!is_double).then_some((now, point));
        is_double
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_near_clicks_in_a_short_time_are_a_double_click() {
        let mut pointer = PointerTracker::default();
        let start = Instant::now();
        let mut click = |ms, x| pointer.click(start + Duration::from_millis(ms), DVec2::new(x, 0.0));
        assert_eq!([click(0, 0.0), click(100, 3.0)], [false, true]);
        // The third click starts over.
        assert_eq!([click(200, 3.0), click(700, 3.0), click(800, 30.0)], [false, false, false]);
    }
}
