//! Mesh files, read back: closed, outward, in the right place.

use std::collections::HashMap;

use superegg_exchange::write::flatten::{Instances, flatten};
use superegg_exchange::write::gltf::to_glb;
use superegg_exchange::write::meshes::Tolerance;
use superegg_exchange::write::obj::to_obj;
use superegg_exchange::write::ply::{Precision, to_ply};
use superegg_exchange::write::stl::to_stl;
use superegg_exchange::write::written::WriteError;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, Superquadric, TransformStep};
use superegg_scene::{Material, Scene, TableBuilder};

/// Three instances of two shapes: one plain, one mirrored, one sheared; and two rows of a table.
fn scene() -> Scene {
    let mut scene = Scene::default();
    for (name, e, n, color) in [("egg", 1.0, 0.7, [0.5, 0.1, 0.2]), ("star", 3.0, 2.5, [0.0, 1.0, 0.0])] {
        scene.ensure_primitive(name).unwrap();
        let primitive = scene.primitive_mut(name).unwrap();
        primitive.shape =
            Superquadric::new(DVec3::new(1.0, 1.0, 1.3), Exponents::new(e, n).unwrap()).unwrap();
        primitive.material.color = color.into();
    }
    scene.ensure_object("all").unwrap();
    scene.add_child("all", "plain", "egg").unwrap();
    scene.add_child("all", "mirrored", "egg").unwrap();
    for step in [
        TransformStep::Rotate { axis: DVec3::new(1.0, 2.0, 3.0), angle_deg: 40.0 },
        TransformStep::Scale(DVec3::new(-2.0, 2.0, 2.0)),
        TransformStep::Translate(DVec3::new(10.0, 0.0, 0.0)),
    ] {
        scene.transform_child("all", step).unwrap();
    }
    scene.add_child("all", "sheared", "star").unwrap();
    for step in [
        TransformStep::Rotate { axis: DVec3::new(1.0, 0.5, 0.0), angle_deg: 30.0 },
        TransformStep::Scale(DVec3::new(1.0, 2.0, -0.5)),
        TransformStep::Translate(DVec3::new(0.0, 10.0, 0.0)),
    ] {
        scene.transform_child("all", step).unwrap();
    }
    let mut table = TableBuilder::default();
    let material = table.material(Material::default());
    let shape = table.shape(DVec3::new(0.5, 1.0, 0.25), Exponents::ROUND, material).unwrap();
    table.push(shape, DVec3::new(0.0, 0.0, 5.0), DQuat::from_rotation_x(1.0), Some(7));
    table.push(shape, DVec3::new(0.0, 0.0, -5.0), DQuat::from_rotation_y(1.0), Some(8));
    scene.add_table("grains", table.finish()).unwrap();
    scene.add_child("all", "grains", "grains").unwrap();
    scene
}

fn exact_volume(instances: &Instances) -> f64 {
    let of = |instance| {
        let instances: &Instances = instances;
        let instance: &superegg_exchange::write::flatten::Instance = instance;
        instances.part(instance).shape.volume() * instance.map.matrix3.determinant()
    };
    instances.list.iter().map(of).sum()
}

/// The volume of triangles that form closed surfaces once equal corners are merged.
fn closed_volume(triangles: &[[DVec3; 3]]) -> f64 {
    let mut edges: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
    let mut volume = 0.0;
    for [a, b, c] in triangles {
        volume += a.dot(b.cross(*c)) / 6.0;
        let bits = [a, b, c].map(|p| (p + 0.0).to_array().map(f64::to_bits));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            *edges.entry([bits[from], bits[to]]).or_default() += 1;
        }
    }
    assert!(edges.iter().all(|([a, b], count)| *count == 1 && edges.get(&[*b, *a]) == Some(&1)));
    volume
}

fn f32_at(bytes: &[u8], at: usize) -> f64 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()).into()
}

fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

const TOLERANCE: Tolerance = Tolerance::Relative(2e-3);

#[test]
fn stl_has_closed_outward_surfaces() {
    let scene = scene();
    let instances = flatten(&scene, "all", 25).unwrap();
    assert_eq!(
        instances.list.iter().map(|i| i.path.as_str()).collect::<Vec<_>>(),
        ["all/plain", "all/mirrored", "all/sheared", "all/grains/p7", "all/grains/p8"]
    );
    let written = to_stl(&scene, &instances, TOLERANCE).unwrap();
    let bytes = &written.bytes;
    let count = u32_at(bytes, 80);
    assert_eq!(bytes.len(), 84 + 50 * count);
    let triangles: Vec<[DVec3; 3]> = (0..count)
        .map(|i| {
            [1, 2, 3]
                .map(|k| DVec3::from_array([0, 1, 2].map(|j| f32_at(bytes, 84 + 50 * i + 12 * k + 4 * j))))
        })
        .collect();
    let (volume, exact) = (closed_volume(&triangles), exact_volume(&instances));
    assert!((volume / exact - 1.0).abs() < 0.01, "{volume} {exact}");
    assert!(written.losses.iter().any(|loss| loss.contains("colours")), "{:?}", written.losses);
}

#[test]
fn ply_and_obj_have_the_same_vertices() {
    let scene = scene();
    let instances = flatten(&scene, "all", 25).unwrap();
    let [single, double] = [Precision::Single, Precision::Double]
        .map(|precision| to_ply(&scene, &instances, TOLERANCE, precision).unwrap().bytes);
    let obj = to_obj(&scene, &instances, TOLERANCE, Precision::Double, "all.mtl").unwrap();
    let text = String::from_utf8(obj.bytes).unwrap();
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').skip(1).map(|x| x.parse().unwrap()).collect() };
    let vertices: Vec<DVec3> =
        text.lines().filter(|l| l.starts_with("v ")).map(|l| DVec3::from_slice(&numbers(l))).collect();
    let faces: Vec<[usize; 3]> = text
        .lines()
        .filter(|line| line.starts_with("f "))
        .map(|line| {
            let corners: Vec<usize> =
                line.split(' ').skip(1).map(|w| w.split("//").next().unwrap().parse().unwrap()).collect();
            [corners[0] - 1, corners[1] - 1, corners[2] - 1]
        })
        .collect();
    let triangles: Vec<_> = faces.iter().map(|face| face.map(|i| vertices[i])).collect();
    let exact = exact_volume(&instances);
    assert!((closed_volume(&triangles) / exact - 1.0).abs() < 0.01);
    for (bytes, size) in [(single, 4), (double, 8)] {
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.contains(&format!("element vertex {}\n", vertices.len())), "{header}");
        let vertex = 6 * size + 3;
        assert_eq!(bytes.len(), end + vertex * vertices.len() + 13 * faces.len());
        // The first part is red: 0.5 is 188 in sRGB.
        assert_eq!(bytes[end + 6 * size], 188);
        let first_face = end + vertex * vertices.len();
        assert_eq!([1, 5, 9].map(|k| u32_at(&bytes, first_face + k)), faces[0]);
        if size == 4 {
            let last = end + vertex * (vertices.len() - 1);
            let position = DVec3::from_array([0, 1, 2].map(|k| f32_at(&bytes, last + 4 * k)));
            assert!((position - vertices[vertices.len() - 1]).length() < 1e-5);
        }
    }
    let mtl = String::from_utf8(obj.companion.unwrap()).unwrap();
    assert_eq!(mtl.matches("newmtl").count(), 3);
    assert!(text.starts_with("# superegg\nmtllib all.mtl\n"));
}

#[test]
fn glb_shares_meshes_and_turns_up_to_y() {
    let mut scene = scene();
    scene.camera.up = DVec3::Z;
    let instances = flatten(&scene, "all", 25).unwrap();
    let bytes = to_glb(&scene, &instances, TOLERANCE).unwrap().bytes;
    assert_eq!((&bytes[..4], u32_at(&bytes, 4), u32_at(&bytes, 8)), (&b"glTF"[..], 2, bytes.len()));
    let length = u32_at(&bytes, 12);
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let binary = &bytes[28 + length..];
    assert_eq!(u32_at(&bytes, 20 + length), binary.len());
    let nodes = json["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), 6);
    assert_eq!(nodes[5]["name"], "z-up to y-up");
    // The egg is in the file once, in two nodes; so is the shape of the table.
    assert_eq!(json["meshes"].as_array().unwrap().len(), 3);
    assert_eq!(nodes[0]["mesh"], nodes[1]["mesh"]);
    assert_eq!(nodes[3]["mesh"], nodes[4]["mesh"]);
    assert!(nodes.iter().all(|node| node.get("matrix").is_none()));
    assert!((nodes[1]["scale"][0].as_f64().unwrap() - 2.6).abs() < 1e-6);
    for accessor in json["accessors"].as_array().unwrap() {
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let [start, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
        assert!(start % 4 == 0 && start + length <= binary.len());
        let size = match (accessor["type"].as_str().unwrap(), accessor["componentType"].as_u64().unwrap()) {
            ("VEC3", 5126) => 12,
            ("SCALAR", 5123) => 2,
            ("SCALAR", 5125) => 4,
            other => panic!("{other:?}"),
        };
        assert_eq!(accessor["count"].as_u64().unwrap() as usize * size, length);
    }
}

#[test]
fn hostile_scenes_and_tolerances() {
    let mut scene = scene();
    let instances = flatten(&scene, "all", 25).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
        for tolerance in [Tolerance::Relative(tolerance), Tolerance::Absolute(tolerance)] {
            let error = to_stl(&scene, &instances, tolerance).unwrap_err();
            assert!(matches!(error, WriteError::Mesh { .. }), "{error}");
        }
    }
    let error = to_ply(&scene, &instances, Tolerance::Relative(1e-6), Precision::Single).unwrap_err();
    assert!(error.to_string().contains("is possible"), "{error}");
    assert!(to_stl(&scene, &instances, Tolerance::Absolute(1e300)).is_ok());
    // Far away, float32 spoils the shape: that is said.
    scene.ensure_object("far").unwrap();
    scene.add_child("far", "egg", "egg").unwrap();
    scene.transform_child("far", TransformStep::Translate(DVec3::splat(1e7))).unwrap();
    let far = flatten(&scene, "far", 25).unwrap();
    let written = to_stl(&scene, &far, TOLERANCE).unwrap();
    assert!(written.losses.iter().any(|loss| loss.contains("float32")), "{:?}", written.losses);
    scene.transform_child("far", TransformStep::Translate(DVec3::splat(1e200))).unwrap();
    let far = flatten(&scene, "far", 25).unwrap();
    assert!(matches!(to_stl(&scene, &far, TOLERANCE), Err(WriteError::Range { .. })));
    assert!(matches!(to_glb(&scene, &far, TOLERANCE), Err(WriteError::Range { .. })));
}
