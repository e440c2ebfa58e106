//! Triangle meshes as points of their surface: STL, OBJ, and the faces of PLY files.

mod obj;
mod stl;
mod triangles;

pub(crate) use obj::{read as read_obj, recognize as is_obj};
pub(crate) use stl::{read as read_stl, recognize as is_stl};
pub(crate) use triangles::{Triangle, sample};

/// The kind of a triangle mesh, from the first bytes of a file of `length` bytes: "an STL
/// mesh". `None` for any other file, and for PLY files, which are clouds too.
pub fn mesh_kind(head: &[u8], length: u64) -> Option<&'static str> {
    if head.starts_with(b"glTF") {
        Some("a glTF mesh")
    } else if stl::recognize_head(head, length) {
        Some("an STL mesh")
    } else if is_obj(head) {
        Some("an OBJ mesh")
    } else {
        None
    }
}
