//! From pixels to camera rays: sample positions, filters and projections.

pub(crate) mod filter;
pub(crate) mod framing;
pub(crate) mod framing_of_data;
pub(crate) mod placement;
pub(crate) mod sample;
pub(crate) mod sobol;
pub(crate) mod stratified;
pub(crate) mod view;
