//! Writers of other programs' formats, one module each.
//!
//! [`export::export`] writes a scene in any format. [`flatten::flatten`] lists the instances below a root; the other modules write them. Each returns
//! [`written::Written`], which says what the format loses.

mod baked;
pub mod convention;
pub mod ems;
pub mod enlarge;
pub mod export;
pub mod flatten;
pub mod gltf;
pub mod grid;
pub mod liggghts;
mod looks;
mod losses;
pub mod meshes;
pub mod obj;
mod particles;
pub mod ply;
pub mod points;
pub mod povray;
pub mod rigid;
pub mod scene_mesh;
pub mod stl;
pub mod table;
pub mod vtp;
pub mod written;
