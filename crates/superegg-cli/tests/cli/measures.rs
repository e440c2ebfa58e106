//! `superegg sample` and `superegg measure`.

use crate::support::Sandbox;

const PAIR: &str = "prm ball\nobj pair\nap ball left\nap ball right\nss 2 2 2\nxs 1 0 0\n";

fn numbers(line: &str) -> Vec<f64> {
    line.split(',').filter_map(|field| field.parse().ok()).collect()
}

#[test]
fn samples_are_written_in_each_format_and_the_same_for_a_seed() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", PAIR);
    for name in ["cloud.ply", "cloud.csv", "cloud.xyz", "cloud.npy"] {
        let report = sandbox.run(&format!("sample pair.scn -n 500 -o {name}")).fine();
        assert!(report.contains("500 points of 2 instances, total area 62.83"), "{report}");
    }
    let csv = sandbox.read("cloud.csv");
    assert_eq!(csv.lines().next(), Some("x,y,z,nx,ny,nz,instance_id,path"));
    assert_eq!(csv.lines().count(), 501);
    assert_eq!(csv.lines().filter(|line| line.ends_with("pair/left")).count(), 100);
    let first = numbers(csv.lines().nth(1).unwrap());
    let xyz = sandbox.read("cloud.xyz");
    let words: Vec<f64> = xyz.lines().next().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    assert_eq!(words, first[..6]);
    let ply = std::fs::read(sandbox.path("cloud.ply")).unwrap();
    let start = ply.len() - 500 * 28;
    assert!(ply[..start].ends_with(b"end_header\n"));
    assert_eq!(f32::from_le_bytes(ply[start..start + 4].try_into().unwrap()), first[0] as f32);
    let npy = std::fs::read(sandbox.path("cloud.npy")).unwrap();
    let start = npy.len() - 500 * 56;
    assert_eq!(f64::from_le_bytes(npy[start..start + 8].try_into().unwrap()), first[0]);
    assert_eq!(f64::from_le_bytes(npy[start + 48..start + 56].try_into().unwrap()), first[6]);

    assert_eq!(sandbox.run("sample pair.scn -n 500 -o -").fine(), csv);
    assert_ne!(sandbox.run("sample pair.scn -n 500 --seed 2 -o -").fine(), csv);
}

#[test]
fn samples_of_the_union_leave_out_what_is_inside() {
    let sandbox = Sandbox::new();
    // The left ball touches the right one from within.
    sandbox.write("pair.scn", PAIR);
    let out = sandbox.run("sample pair.scn -n 500 --union -o -").fine();
    assert_eq!(out.lines().count(), 401);
    assert!(!out.contains("pair/left"), "{out}");
}

#[test]
fn wrong_samples_write_nothing() {
    let sandbox = Sandbox::new();
    let children: String = (0..20).map(|i| format!("ao o c{i}\nss .1 .1 .1\nxs {i} 0 0\n")).collect();
    sandbox.write("pair.scn", PAIR).write("deep.scn", format!("prm p\nobj o\nap p\n{children}setDepth 64\n"));
    sandbox.write("empty.scn", "obj o\n");
    for (words, report) in [
        ("sample pair.scn -o cloud.las", "end it in .ply, .csv, .xyz or .npy"),
        ("sample pair.scn -n 0 -o cloud.ply", "0 is not in 1.."),
        ("sample deep.scn -o cloud.ply", "instances, more than the"),
        ("measure deep.scn", "instances, more than the"),
        ("sample empty.scn -o cloud.ply", "no surface to sample"),
    ] {
        let err = sandbox.run(words).failed(2);
        assert!(err.contains(report), "{words}: {err}");
    }
    assert_eq!(sandbox.files(), ["deep.scn", "empty.scn", "pair.scn"]);
}

#[test]
fn measures_are_exact_and_those_of_the_union_have_their_error() {
    let sandbox = Sandbox::new();
    sandbox.write("pair.scn", PAIR);
    let text = sandbox.run("measure pair.scn -n 2000").fine();
    assert!(text.contains("pair/left\n  volume 4.18879"), "{text}");
    assert!(text.contains("sum of 2 instances\n  volume 37.699"), "{text}");
    assert!(text.contains("union, from 2000 samples"), "{text}");

    let json: serde_json::Value =
        serde_json::from_str(&sandbox.run("measure pair.scn --json -n 20000 --seed 5").fine()).unwrap();
    let number = |pointer: &str| json.pointer(pointer).and_then(serde_json::Value::as_f64).unwrap();
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    assert!((number("/instances/1/volume") / (8.0 * ball) - 1.0).abs() < 1e-12);
    assert!((number("/instances/1/area") / (12.0 * ball) - 1.0).abs() < 1e-12);
    assert!((number("/instances/1/inertia/0/0") / (12.8 * ball) - 1.0).abs() < 1e-12);
    assert!((number("/instances/1/box/1/0") - 3.0).abs() < 1e-12);
    assert!((number("/sum/volume") / (9.0 * ball) - 1.0).abs() < 1e-12);
    // The left ball is within the right one.
    assert!((number("/union/volume") - 8.0 * ball).abs() < 5.0 * number("/union/volume_error"));
    assert!((number("/union/area") - 12.0 * ball).abs() < 5.0 * number("/union/area_error") + 1e-6);

    let short: serde_json::Value =
        serde_json::from_str(&sandbox.run("measure pair.scn --json -n 0 --rows 1").fine()).unwrap();
    assert!(short["instances"].as_array().unwrap().is_empty() && short.get("union").is_none());
    assert!(short["note"].as_str().unwrap().starts_with("2 instances, more than 1"));
    assert!(!sandbox.run("measure pair.scn --object nobody").failed(2).is_empty());
}
