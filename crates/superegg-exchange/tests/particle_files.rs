//! Files of particles and fits: sizes, exponents and rotations in each program's convention.

use superegg_exchange::write::ems::{to_ems_npy, to_ems_text};
use superegg_exchange::write::flatten::{Instances, flatten};
use superegg_exchange::write::liggghts::{to_data_file, to_input_script};
use superegg_exchange::write::table::to_csv;
use superegg_exchange::write::vtp::to_vtp;
use superegg_exchange::write::written::Written;
use superegg_geom::glam::{DMat3, DQuat, DVec3, EulerRot};
use superegg_geom::{Exponents, Superquadric, TransformStep};
use superegg_scene::Scene;

/// One turned and stretched primitive (e = 0.25, n = 0.5), one sheared, one with an exponent above 1.
fn scene() -> Scene {
    let mut scene = Scene::default();
    for (name, e, n) in [("grain", 0.25, 0.5), ("star", 1.0, 3.0)] {
        scene.ensure_primitive(name).unwrap();
        let exponents = Exponents::new(e, n).unwrap();
        scene.primitive_mut(name).unwrap().shape =
            Superquadric::new(DVec3::new(1.0, 2.0, 3.0), exponents).unwrap();
    }
    scene.primitive_mut("grain").unwrap().material.color = DVec3::new(0.25, 0.5, 1.0);
    scene.ensure_object("all").unwrap();
    let turn = TransformStep::Rotate { axis: DVec3::new(1.0, 2.0, 3.0), angle_deg: 50.0 };
    let stretch = TransformStep::Scale(DVec3::new(2.0, 1.0, -0.5));
    let shift = TransformStep::Translate(DVec3::new(10.0, 20.0, 30.0));
    for (alias, target, steps) in [
        ("turned, stretched", "grain", vec![stretch.clone(), turn.clone(), shift]),
        ("sheared", "grain", vec![turn, stretch]),
        ("spiky", "star", vec![]),
    ] {
        scene.add_child("all", alias, target).unwrap();
        steps.into_iter().for_each(|step| scene.transform_child("all", step).unwrap());
    }
    scene
}

fn instances(scene: &Scene) -> Instances {
    flatten(scene, "all", 5).unwrap()
}

fn turn() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 50f64.to_radians())
}

/// Whether a rotation is that of the first particle, up to the shape's symmetry.
fn is_turn(rotation: &DMat3) -> bool {
    let exact = DMat3::from_quat(turn());
    (0..3).all(|axis| (rotation.col(axis).dot(exact.col(axis)).abs() - 1.0).abs() < 1e-9)
        && (rotation.determinant() - 1.0).abs() < 1e-9
}

fn text(written: &Written) -> &str {
    std::str::from_utf8(&written.bytes).unwrap()
}

fn says(written: &Written, words: &str) -> bool {
    written.losses.iter().any(|loss| loss.contains(words))
}

#[test]
fn vtp_has_the_arrays_of_liggghts() {
    let scene = scene();
    let written = to_vtp(&scene, &instances(&scene));
    let text = text(&written);
    let array = |name: &str| -> Vec<f64> {
        let (_, rest) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
        let (_, rest) = rest.split_once('>').unwrap();
        let (numbers, _) = rest.split_once('<').unwrap();
        numbers.split_whitespace().map(|x| x.parse().unwrap()).collect()
    };
    assert!(text.contains("NumberOfPoints=\"2\" NumberOfVerts=\"2\""));
    assert_eq!([array("shapex")[0], array("shapey")[0], array("shapez")[0]], [2.0, 2.0, 1.5]);
    assert_eq!([array("blockiness1"), array("blockiness2")], [vec![4.0, 2.0 / 3.0], vec![8.0, 2.0]]);
    assert_eq!(array("Points")[..3], [10.0, 20.0, 30.0]);
    let tensor = array("TENSOR");
    assert_eq!(tensor.len(), 18);
    assert!(is_turn(&DMat3::from_cols_slice(&tensor[..9]).transpose()));
    assert!(says(&written, "sheared instances") && says(&written, "all/sheared"));
}

#[test]
fn csv_has_named_columns() {
    let scene = scene();
    let written = to_csv(&scene, &instances(&scene));
    let lines: Vec<&str> = text(&written).lines().collect();
    assert_eq!(lines[0], "id,x,y,z,qw,qx,qy,qz,a,b,c,e,n,red,green,blue,name");
    assert_eq!(lines.len(), 3);
    assert!(lines[1].ends_with(",0.25,0.5,0.25,0.5,1,\"all/turned, stretched\""), "{}", lines[1]);
    let row: Vec<f64> = lines[1].split(',').take(11).map(|x| x.parse().unwrap()).collect();
    assert_eq!((&row[..4], &row[8..]), (&[1.0, 10.0, 20.0, 30.0][..], &[2.0, 2.0, 1.5][..]));
    assert!(is_turn(&DMat3::from_quat(DQuat::from_xyzw(row[5], row[6], row[7], row[4]))));
}

#[test]
fn ems_vectors_as_text_and_as_an_array() {
    let scene = scene();
    let written = to_ems_text(&scene, &instances(&scene));
    let rows: Vec<f64> = text(&written).split_whitespace().map(|x| x.parse().unwrap()).collect();
    assert_eq!(rows.len(), 22);
    // n comes first.
    assert_eq!(rows[..5], [0.5, 0.25, 2.0, 2.0, 1.5]);
    assert!(is_turn(&DMat3::from_euler(EulerRot::ZYX, rows[5], rows[6], rows[7])));
    let array = to_ems_npy(&scene, &instances(&scene)).bytes;
    assert_eq!(&array[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([array[8], array[9]]));
    assert!((10 + length).is_multiple_of(64) && array[9 + length] == b'\n');
    assert!(std::str::from_utf8(&array[10..10 + length]).unwrap().contains("'shape': (2, 11)"));
    let numbers: Vec<f64> =
        array[10 + length..].as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    assert_eq!(numbers, rows);
}

#[test]
fn liggghts_scripts_and_data() {
    let scene = scene();
    let written = to_input_script(&scene, &instances(&scene));
    let script = text(&written);
    assert!(script.contains("create_atoms 1 single 10 20 30\n"));
    let line = script.lines().find(|line| line.starts_with("set atom 1 ")).unwrap();
    let words: Vec<&str> = line.split(' ').collect();
    assert_eq!(words[3..10].join(" "), "shape 2 2 1.5 blockiness 4 8");
    let axis: Vec<f64> = words[13..17].iter().map(|x| x.parse().unwrap()).collect();
    let quat = DQuat::from_axis_angle(DVec3::new(axis[0], axis[1], axis[2]), axis[3].to_radians());
    assert!((DVec3::new(axis[0], axis[1], axis[2]).length() - 1.0).abs() < 1e-12);
    assert!(is_turn(&DMat3::from_quat(quat)));
    // The star is refused: its profile's exponent is above 1.
    assert!(says(&written, "all/spiky") && script.matches("set atom").count() == 1);
    let written = to_data_file(&scene, &instances(&scene));
    assert!(text(&written).contains("\n1 1 1000 2 2 1.5 4 8 10 20 30\n"), "{}", text(&written));
    assert!(says(&written, "Turned"));
}
