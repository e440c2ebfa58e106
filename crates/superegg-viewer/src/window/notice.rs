//! A line of text that is shown for a while.

use std::time::{Duration, Instant};

const DURATION: Duration = Duration::from_secs(5);
/// Added to the end of a notice, so that the frame after it does not show it any more.
const MARGIN: Duration = Duration::from_millis(20);

/// The current notice.
#[derive(Debug, Default)]
pub(super) struct Notice {
    current: Option<(String, Instant)>,
}

impl Notice {
    pub(super) fn show(&mut self, text: String) {
        self.current = Some((text, Instant::now()));
    }

    pub(super) fn text(&self) -> Option<&str> {
        self.current.as_ref().map(|(text, _)| text.as_str())
    }

    /// Removes a notice whose time is over.
    pub(super) fn expire(&mut self) {
        if self.current.as_ref().is_some_and(|(_, since)| since.elapsed() > DURATION) {
            self.current = None;
        }
    }

    /// The time at which the next frame is due.
    pub(super) fn ends_at(&self) -> Option<Instant> {
        self.current.as_ref().map(|(_, since)| *since + DURATION + MARGIN)
    }
}
