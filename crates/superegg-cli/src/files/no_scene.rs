//! Files that are no scenes, by their first bytes.

use superegg_exchange::read::mesh_kind;

/// The kind of a file that is certainly no scene, with the next step: "a PLY file; 'superegg
/// import' reads it". `None` for a scene, and for a file that begins like nothing known.
pub(crate) fn kind_of_no_scene(bytes: &[u8]) -> Option<String> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let starts = |head: &&[u8]| bytes.starts_with(head) || text.starts_with(head);
    let kind_in =
        |kinds: &[(&[u8], &'static str)]| kinds.iter().find(|(head, _)| starts(head)).map(|(_, kind)| *kind);
    if let Some(kind) = kind_in(READ_BY_IMPORT) {
        return Some(format!("{kind}; 'superegg import' reads it"));
    }
    if let Some(kind) = mesh_kind(bytes, bytes.len() as u64) {
        return Some(format!("{kind}; 'superegg fit' fits superquadrics to .stl, .obj and .ply"));
    }
    kind_in(OTHERS).map(str::to_owned)
}

/// The first bytes of files that other programs write for shapes and points.
const READ_BY_IMPORT: &[(&[u8], &str)] = &[
    (b"ply\n", "a PLY point cloud or mesh"),
    (b"ply\r", "a PLY point cloud or mesh"),
    (b"ITEM: ", "a particle dump (LIGGGHTS, LAMMPS)"),
    (b"# vtk DataFile", "a VTK file"),
    (b"<VTKFile", "a VTK file"),
    (b"<?xml", "an XML file, perhaps of VTK"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"PK\x03\x04", "a ZIP archive, perhaps of NumPy arrays"),
    (b"MATLAB 5.0 MAT-file", "a MATLAB file"),
    (b"NRRD000", "a Teem NRRD file"),
    (b"%YAML", "a YAML file"),
    (b"{\n", "a JSON file"),
    (b"{\"", "a JSON file"),
    (b"[{", "a JSON file"),
    (b"[[", "a JSON file"),
];

/// The first bytes of other files.
const OTHERS: &[(&[u8], &str)] = &[
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (b"\x1f\x8b", "a gzip archive; unpack it first"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"<!DOCTYPE", "a web page"),
    (b"<html", "a web page"),
    (b"# superegg journal", "the journal of a session; 'recover' at the prompt restores it"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_programs_are_named() {
        for (head, part) in [
            (&b"ply\nformat ascii 1.0\n"[..], "PLY"),
            (b"ITEM: TIMESTEP\n0\n", "particle dump"),
            (b"\xef\xbb\xbf\n<VTKFile type=\"PolyData\"", "VTK"),
            (b"\x93NUMPY\x01\0", "NumPy"),
            (b"\x89PNG\r\n", "PNG"),
            (b"solid x\nfacet normal 0 0 1\n", "an STL mesh; 'superegg fit'"),
            (&[0; 84], "an STL mesh"),
            (b"# by hand\nv 0 0 1\nf 1 1 1\n", "an OBJ mesh"),
            (b"glTF\x02\0", "a glTF mesh"),
        ] {
            assert!(kind_of_no_scene(head).is_some_and(|kind| kind.contains(part)), "{part}");
        }
        for scene in
            ["", "prm egg\n", "# superegg scene\n", "\n\n# a comment\nobject o\n", "solid\n", "plymouth\n"]
        {
            assert_eq!(kind_of_no_scene(scene.as_bytes()), None, "{scene:?}");
        }
    }
}
