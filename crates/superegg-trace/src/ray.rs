//! Rays and hits.

pub(crate) mod footprint;
pub(crate) mod limits;
pub(crate) mod lottery;
pub(crate) mod query;
