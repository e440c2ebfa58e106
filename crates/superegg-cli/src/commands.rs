//! The subcommands, one module each.

pub(crate) mod animate;
pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod export;
pub(crate) mod fit;
pub(crate) mod import;
pub(crate) mod info;
mod input;
pub(crate) mod install;
pub(crate) mod intersect;
pub(crate) mod iotest;
pub(crate) mod measure;
pub(crate) mod merge;
pub(crate) mod model;
pub(crate) mod render;
pub(crate) mod run;
pub(crate) mod sample;
pub(crate) mod view;
