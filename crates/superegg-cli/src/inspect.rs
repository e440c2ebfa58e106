//! Questions about a scene: ray hits, test points, the tree of an object, and warnings about a
//! picture.

pub(crate) mod framing;
pub(crate) mod grid;
pub(crate) mod picture_warnings;
pub(crate) mod ray;
pub(crate) mod tree;
