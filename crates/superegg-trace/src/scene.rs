//! The compiled scene as data.

pub(crate) mod bvh;
pub(crate) mod compiled;
pub(crate) mod group;
pub(crate) mod id;
pub(crate) mod node;
pub(crate) mod path;
pub(crate) mod primitive;
pub(crate) mod proxy;
