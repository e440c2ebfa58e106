//! Points of clouds and meshes.

use std::io::Cursor;

use superegg_exchange::read::{MeshSampling, ReadError, ReadOptions, SurfacePoints, read_surface_points};
use superegg_geom::glam::DVec3;

fn read(bytes: impl AsRef<[u8]>) -> Result<SurfacePoints, ReadError> {
    let sampling = MeshSampling { count: 2000, seed: 1 };
    read_surface_points(&mut Cursor::new(bytes.as_ref()), &ReadOptions::default(), sampling)
}

/// A square of side 2 and a small triangle far away, in several formats.
fn meshes() -> Vec<(&'static str, Vec<u8>)> {
    let corners: [[f32; 3]; 7] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
        [9.0, 0.0, 0.0],
        [10.0, 0.0, 0.0],
        [9.0, 1.0, 0.0],
    ];
    let vertex = |[x, y, z]: [f32; 3]| format!("{x} {y} {z}\n");
    let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6]];
    let mut obj = String::from("# a comment\no thing\n");
    let mut ply = String::from(
        "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n\
         element face 2\nproperty list uchar int vertex_indices\nend_header\n",
    );
    for corner in corners {
        obj.push_str(&format!("v {}", vertex(corner)));
        ply.push_str(&vertex(corner));
    }
    obj.push_str("vn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -3 -2 -1\n");
    ply.push_str("4 0 1 2 3\n3 4 5 6\n");
    let mut text = String::from("solid thing\n");
    let mut binary = vec![b's'; 80];
    binary.extend(3_u32.to_le_bytes());
    for triangle in triangles {
        text.push_str("facet normal 0 0 1\nouter loop\n");
        binary.extend([0; 12]);
        for corner in triangle {
            text.push_str(&format!("vertex {}", vertex(corners[corner])));
            binary.extend(corners[corner].iter().flat_map(|x| x.to_le_bytes()));
        }
        text.push_str("endloop\nendfacet\n");
        binary.extend([0; 2]);
    }
    text.push_str("endsolid thing\n");
    vec![("OBJ", obj.into()), ("PLY", ply.into()), ("STL", text.into()), ("STL", binary)]
}

#[test]
fn meshes_are_sampled_by_area() {
    for (name, bytes) in meshes() {
        let found = read(&bytes).unwrap();
        assert!(found.reading.contains(name) && found.reading.contains("2000 points of 3"), "{found:?}");
        let is_far = |point: &&DVec3| point.x > 8.0;
        let far = found.points.iter().filter(is_far).count() as f64 / 2000.0;
        assert!((far - 0.5 / 4.5).abs() < 0.03, "{name}: {far}");
        let near = found.points.iter().filter(|point| !is_far(point));
        assert!(near.clone().all(|point| point.max_element() <= 2.0 && point.min_element() >= 0.0));
        let mean = near.map(|point| point.x).sum::<f64>() / (2000.0 * (1.0 - far));
        assert!((mean - 1.0).abs() < 0.05, "{name}: {mean}");
    }
}

#[test]
fn clouds_are_taken_as_they_are() {
    let points = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 5.0, 6.5)];
    for text in [
        "1 2 3\n-4 5 6.5\n",
        "1,2,3\n-4,5,6.5\n",
        "# x y z nx ny nz\n1 2 3 0 0 1\n-4 5 6.5 0 -1 0\n",
        "x,y,z,quality\n1,2,3,7\n-4,5,6.5,8\n",
        "v 1 2 3\nv -4 5 6.5\n",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
         end_header\n1 2 3\n-4 5 6.5\n",
    ] {
        assert_eq!(read(text).unwrap().points, points, "{text}");
    }
}

#[test]
fn what_is_no_cloud_is_an_error() {
    for (bytes, expected) in [
        ("primitive egg\nsize 1 1 1.3\n", "not recognized"),
        ("1 2 3\n4 nan 6\n", "finite"),
        ("v 1 2\n", "line 1: expected 'v' and three numbers"),
        ("v 1 2 3\nf 1 2 3\n", "line 2: expected indices of vertices, of which 1 stand above"),
        ("v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n", "no triangles"),
        ("solid x\nfacet\nvertex 1 2\n", "line 3: expected 'vertex' and three numbers"),
        ("solid x\nfacet\nvertex 1 2 3\n", "no multiple of three"),
        ("solid x\nendsolid x\n", "no triangles"),
        ("e a b\n", "not recognized"),
    ] {
        let message = read(bytes).unwrap_err().to_string();
        assert!(message.contains(expected), "{bytes}: {message}");
    }
    for (name, bytes) in meshes() {
        for end in (0..bytes.len()).step_by(7) {
            // Damage is an error or a cloud.
            let _ = read(&bytes[..end]);
        }
        assert!(read(&bytes).is_ok(), "{name}");
    }
}

#[test]
fn points_of_vtk_files_are_a_cloud_unless_they_are_particles() {
    let head = "# vtk DataFile Version 3.0\ncloud\nASCII\n";
    let points = "DATASET POLYDATA\nPOINTS 2 float\n1 2 3\n-4 5 6.5\n";
    let found = read(format!("{head}{points}POLYGONS 1 4\n3 0 1 0\n")).unwrap();
    assert_eq!(found.points, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 5.0, 6.5)]);
    assert_eq!(found.reading, "a VTK file of PolyData: 2 points; faces are not used");
    let of_particles =
        format!("{head}{points}POINT_DATA 2\nSCALARS shapex float 1\nLOOKUP_TABLE default\n1 1\n");
    for (text, expected) in [
        (of_particles, "this is a VTK file of LIGGGHTS, not a cloud of points or a mesh; 'superegg sample'"),
        (
            format!("{head}DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n"),
            "the points of a VTK file of ImageData fill a box; expected points of a surface",
        ),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
}
