//! `superegg fit`.

use serde_json::Value;

use crate::support::Sandbox;

const SUPEREGG: &str = env!("CARGO_BIN_EXE_superegg");

const EGG: &str = "primitive egg\nsetCoeff 1 2 1.5\nsetExponent 0.6 1.2\nobject world\naddPrimitive egg\nrotate z 30\ntranslate 5 0 -2\n";

/// A sandbox with a scene and points of its surface.
fn sampled(name: &str) -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("egg.scn", EGG);
    sandbox.run(&format!("sample egg.scn -n 2000 -o {name} --quiet")).fine();
    sandbox
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn number(json: &Value, pointer: &str) -> f64 {
    json.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} of {json}"))
}

#[test]
fn clouds_of_each_format_have_their_shape() {
    for name in ["cloud.ply", "cloud.csv", "cloud.xyz", "cloud.npy"] {
        let sandbox = sampled(name);
        let fit = json(&sandbox.run(&format!("fit {name} --json --quiet")).fine());
        let mut semi_axes = [0, 1, 2].map(|axis| number(&fit, &format!("/semi_axes/{axis}")));
        semi_axes.sort_by(f64::total_cmp);
        for (found, expected) in semi_axes.into_iter().zip([1.0, 1.5, 2.0]) {
            assert!((found - expected).abs() < 1e-4, "{name}: {fit}");
        }
        assert!((number(&fit, "/center/0") - 5.0).abs() < 1e-4);
        assert!((number(&fit, "/exponents/e") - 0.6).abs() < 1e-3);
        assert!((number(&fit, "/exponents/n") - 1.2).abs() < 1e-3);
        assert!(number(&fit, "/rms") < 1e-5 && number(&fit, "/hausdorff") < 1e-3);
        assert_eq!(number(&fit, "/points"), 2000.0);
        assert!(fit["warnings"].as_array().unwrap().is_empty(), "{fit}");
    }
}

#[test]
fn the_scene_is_the_shape() {
    let sandbox = sampled("cloud.ply");
    let report = sandbox.run("fit cloud.ply -o fit.scn --with-cloud --residuals far.csv");
    assert!(report.err.contains("cloud.ply: a PLY file: 2000 points"), "{}", report.err);
    assert!(
        report.out.contains("semi-axes a b c: ") && report.out.ends_with("fit.scn: written\n"),
        "{report:?}"
    );
    let measures = json(&sandbox.run("measure fit.scn --json -n 0 --rows 3000").fine());
    let volume = json(&sandbox.run("measure egg.scn --json -n 0").fine());
    assert_eq!(number(&measures, "/instance_count"), 2001.0);
    let found = number(&measures, "/instances/0/volume");
    assert!((found / number(&volume, "/sum/volume") - 1.0).abs() < 1e-3);
    let csv = sandbox.read("far.csv");
    assert_eq!(csv.lines().next(), Some("x,y,z,distance,inlier,shape"));
    assert_eq!(csv.lines().count(), 2001);
    sandbox.run("check fit.scn --strict").fine();
}

#[test]
fn parameters_of_other_programs() {
    let sandbox = sampled("cloud.npy");
    let fit = json(&sandbox.run("fit cloud.npy --json --quiet --convention liggghts").fine());
    let sizes = ["shapex", "shapey", "shapez"].map(|name| number(&fit, &format!("/parameters/{name}")));
    assert!((sizes.iter().product::<f64>() - 3.0).abs() < 1e-3, "{fit}");
    assert!((number(&fit, "/parameters/blockiness1") - 2.0 / 1.2).abs() < 1e-2);
    let text = sandbox.run("fit cloud.npy --convention ems").out;
    assert!(text.contains("ems: e1 ") && text.contains("eul_z "), "{text}");
    sandbox.run("fit cloud.npy --convention nobody").failed(2);
}

#[test]
fn meshes_are_sampled() {
    let sandbox = Sandbox::new();
    sandbox.write("egg.scn", EGG);
    for name in ["egg.stl", "egg.obj", "egg.ply"] {
        sandbox.run(&format!("export egg.scn -o {name}"));
        let report = sandbox.run(&format!("fit {name} --json"));
        assert!(report.err.contains("points of") && report.err.contains("triangles"), "{}", report.err);
        let fit = json(&report.out);
        let volume: f64 = (0..3).map(|axis| number(&fit, &format!("/semi_axes/{axis}"))).product();
        assert!((volume - 3.0).abs() < 0.02, "{name}: {fit}");
    }
}

#[test]
fn clouds_without_a_fit_are_errors_and_write_nothing() {
    let sandbox = Sandbox::new();
    let flat: String = (0..100).map(|i| format!("{} {} 3\n", i % 10, i / 10)).collect();
    sandbox.write("few.xyz", "1 2 3\n4 5 6\n").write("flat.xyz", flat).write("nan.xyz", "1 2 3\n4 nan 5\n");
    sandbox.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").write("words.txt", "some words\n");
    sandbox.write("scene.scn", EGG).write("same.xyz", "1 2 3\n".repeat(50));
    for (words, expected) in [
        ("fit few.xyz -o fit.scn", "at least 12 different points; found 2"),
        ("fit same.xyz -o fit.scn", "found 1 different of 50"),
        ("fit flat.xyz -o fit.scn", "all points lie on a plane"),
        ("fit nan.xyz -o fit.scn", "finite"),
        ("fit scene.scn -o fit.scn", "a scene of superegg, not points; 'superegg sample'"),
        ("fit words.txt -o fit.scn", "not recognized"),
        ("import scene.scn -o fit.scn", "a scene of superegg, not data of another program"),
        ("render scene.scn --color-by x", "a scene of superegg, not data of another program"),
        ("animate scene.scn --box", "a scene of superegg, not data of another program"),
        (
            "import mesh.obj -o fit.scn",
            "this is an OBJ mesh: its triangles are not superquadrics; 'superegg fit'",
        ),
        ("render mesh.obj -o fit.scn.png", "is not a scene but an OBJ mesh; 'superegg fit'"),
        ("fit none.xyz -o fit.scn", "cannot read 'none.xyz'"),
        ("fit flat.xyz --exponents 2 1", "increasing"),
        ("fit flat.xyz --outliers 0.95", "0.9"),
        ("fit flat.xyz --with-cloud", "--output"),
        ("fit flat.xyz --count 0", "auto or a number"),
        ("fit flat.xyz --json --residuals -", "only one of"),
    ] {
        let message = sandbox.run(words).failed(2);
        assert!(message.contains(expected), "{words}: {message}");
    }
    assert_eq!(
        sandbox.files(),
        ["few.xyz", "flat.xyz", "mesh.obj", "nan.xyz", "same.xyz", "scene.scn", "words.txt"]
    );
}

#[test]
fn doubts_are_warnings() {
    let sandbox = Sandbox::new();
    sandbox.write("ball.scn", "primitive ball\nobject world\naddPrimitive ball\n");
    sandbox.run("sample ball.scn -n 500 -o ball.csv --quiet").fine();
    let report = sandbox.run("fit ball.csv --quiet");
    assert_eq!((report.code, report.out.as_str()), (Some(0), ""));
    assert!(report.err.contains("warning: the points do not determine the rotation"), "{}", report.err);
}

#[test]
fn several_shapes() {
    let sandbox = Sandbox::new();
    sandbox.write(
        "two.scn",
        "primitive ball\nprimitive box\nsetCoeff 0.5 1 1.5\nsetExponent 0.2 0.2\nobject world\naddPrimitive ball\naddPrimitive box\ntranslate 4 0 0\n",
    );
    sandbox.run("sample two.scn -n 3000 -o two.ply --quiet").fine();
    let fit =
        json(&sandbox.run("fit two.ply --count auto --json --quiet -o fit.scn --residuals far.csv").out);
    assert_eq!(fit["shapes"].as_array().unwrap().len(), 2, "{fit}");
    assert_eq!(json(&sandbox.run("measure fit.scn --json -n 0").fine())["instance_count"], 2);
    let csv = sandbox.read("far.csv");
    for shape in [1, 2] {
        let count = csv.lines().filter(|line| line.ends_with(&format!(",{shape}"))).count();
        assert_eq!(number(&fit, &format!("/shapes/{}/inliers", shape - 1)), count as f64);
        assert!(count > 500, "{count}");
    }
    let text = sandbox.run("fit two.ply --count 2").out;
    assert!(text.contains("shape 2: ") && text.ends_with("outliers\n"), "{text}");
}

/// A search that is stopped writes the shapes that it has.
#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_shapes_so_far() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;

    let sandbox = Sandbox::new();
    let row: String = (0..8)
        .map(|i| format!("addPrimitive egg e{i}\nrotate 1 1 0 {}\ntranslate {i} 0 0\n", 17 * i))
        .collect();
    sandbox.write("row.scn", ["primitive egg\nsetExponent 0.4 1.4\nobject world\n", &row].concat());
    sandbox.run("sample row.scn -n 20000 -o cloud.ply --quiet").fine();
    let mut child = Command::new(SUPEREGG)
        .args("fit cloud.ply --count auto -o found.scn".split(' '))
        .current_dir(sandbox.path(""))
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().contains("cloud.ply"));
    kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).unwrap();
    assert!(lines.any(|line| line.unwrap().contains("stopped; the shapes are those found so far")));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(sandbox.run("info found.scn").fine().contains("fit"));
}
