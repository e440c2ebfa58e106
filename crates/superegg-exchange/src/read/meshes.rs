//! Triangle meshes as points of their surface: STL, OBJ, and the faces of PLY files.

mod obj;
mod stl;
mod triangles;

pub(crate) use obj::{read as read_obj, recognize as is_obj};
pub(crate) use stl::{read as read_stl, recognize as is_stl};
pub(crate) use triangles::{Triangle, sample};
