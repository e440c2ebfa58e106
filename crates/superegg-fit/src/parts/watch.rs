//! Progress of a search for parts, and its end before time.

use std::cell::{Cell, RefCell};

/// How far a search for parts is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PartsProgress {
    /// The fits of groups of points so far. Their number is not known before the end: the mesh of a chair
    /// of eight parts takes some 350.
    pub fits: usize,
    /// The number of parts of the best description of all points so far; 0 before the first one.
    pub parts: usize,
}

/// Counts fits and asks before each whether the search goes on.
pub(super) struct Watch<'a> {
    goes_on: RefCell<&'a mut dyn FnMut(PartsProgress) -> bool>,
    fits: Cell<usize>,
    parts: Cell<usize>,
    has_stopped: Cell<bool>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(goes_on: &'a mut dyn FnMut(PartsProgress) -> bool) -> Self {
        Self {
            goes_on: RefCell::new(goes_on),
            fits: Cell::new(0),
            parts: Cell::new(0),
            has_stopped: Cell::new(false),
        }
    }

    pub(super) fn has_stopped(&self) -> bool {
        self.has_stopped.get()
    }

    /// All points are described by this many parts.
    pub(super) fn described(&self, parts: usize) {
        self.parts.set(parts);
    }

    /// A group is about to be fitted.
    pub(super) fn before_fit(&self) {
        if !self.has_stopped() {
            let progress = PartsProgress { fits: self.fits.get(), parts: self.parts.get() };
            self.has_stopped.set(!(self.goes_on.borrow_mut())(progress));
        }
        self.fits.set(self.fits.get() + 1);
    }
}
