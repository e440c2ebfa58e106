//! Rays and hits.

pub(crate) mod footprint;
pub(crate) mod lottery;
pub(crate) mod query;
