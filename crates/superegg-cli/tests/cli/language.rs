//! Commands that reach beyond one scene: include, frame, up; colours; and files that are no scenes.

use crate::support::Sandbox;

const WHEEL: &str = "prm tyre\ncoeff 1 1 .3\ncolor #222\nobj wheel\nap tyre\n";

/// The brightest value of a picture, and the number of pixels that are not black.
fn brightness(sandbox: &Sandbox, picture: &str) -> (u8, usize) {
    let picture = image::open(sandbox.path(picture)).unwrap().to_rgb8();
    let values = || picture.pixels().map(|pixel| pixel.0.into_iter().max().unwrap_or(0));
    (values().max().unwrap(), values().filter(|value| *value > 0).count())
}

#[test]
fn an_included_file_is_added_relative_to_the_file_that_includes_it() {
    let sandbox = Sandbox::new();
    std::fs::create_dir_all(sandbox.path("parts/more")).unwrap();
    sandbox.write("parts/wheel.scn", WHEEL);
    sandbox.write("parts/axle.scn", "include wheel.scn\nobj axle\nao wheel left\nao wheel right\nxs 0 0 3\n");
    sandbox.write("car.scn", "obj car\ninclude parts/axle.scn\ninclude parts/wheel.scn\nao axle\n");
    let report = sandbox.run("check car.scn").fine();
    assert!(report.contains("1 primitive, 3 objects, 2 instances in the picture"), "{report}");
    // The saved scene needs no other file.
    sandbox.run_with("", "load car.scn\nsave whole.scn\n").fine();
    let report = sandbox.run("check whole.scn").fine();
    assert!(report.contains("2 instances in the picture"), "{report}");
}

#[test]
fn include_at_the_prompt_is_one_change_that_undo_takes_back() {
    let sandbox = Sandbox::new();
    sandbox.write("wheel.scn", WHEEL);
    let out = sandbox
        .run_with("", "obj car\ninclude wheel.scn\nao wheel\nundo 2\ninfo\nredo\ninfo\nsave car.scn\n")
        .fine();
    let (undone, redone) = out.split_once("redone: include wheel.scn").expect(&out);
    assert!(undone.contains("primitives (0)") && undone.contains("selected: car"), "{undone}");
    assert!(redone.contains("  tyre") && redone.contains("selected: car"), "{redone}");
    assert!(sandbox.read("car.scn").contains("object wheel"));
}

#[test]
fn names_that_mean_two_things_are_not_included() {
    let sandbox = Sandbox::new();
    sandbox.write("wheel.scn", WHEEL);
    sandbox.write("car.scn", "prm tyre\nlight l 1 2 3\nobj car\nap tyre\ninclude wheel.scn\n");
    let err = sandbox.run("check car.scn").failed(1);
    assert!(err.contains("car.scn:5:") && err.contains("'tyre'"), "{err}");
    sandbox.write("self.scn", "include self.scn\n");
    let err = sandbox.run("check self.scn").failed(1);
    assert!(err.contains("would be read within itself"), "{err}");
    sandbox.write("lost.scn", "include nowhere.scn\n");
    assert!(sandbox.run("check lost.scn").failed(1).contains("nowhere.scn"));
}

#[test]
fn what_is_not_in_sight_is_framed_at_any_scale_and_lit_alike() {
    let sandbox = Sandbox::new();
    let mut seen = Vec::new();
    for radius in ["0.001", "1e6", "1e-9"] {
        sandbox.write("ball.scn", format!("prm ball\ncoeff {radius} {radius} {radius}\n"));
        let answer = sandbox.run("render ball.scn --size 60x40 --quiet -o ball.png");
        assert!(answer.code == Some(0) && answer.err.contains("framed"), "{}", answer.err);
        assert_eq!(answer.err.lines().count(), 1, "{}", answer.err);
        seen.push(brightness(&sandbox, "ball.png"));
    }
    assert!(seen[0].0 > 150 && seen[0].1 > 900, "{seen:?}");
    // The rounding of other numbers moves few pixels at the rim.
    assert!(
        seen.iter().all(|&(most, count)| most.abs_diff(seen[0].0) <= 1 && count.abs_diff(seen[0].1) <= 8)
    );
    // A camera of its own stays, and so does what is in sight.
    sandbox.write("ball.scn", "camera 0 0 10 0 0 0\nprm ball\ncoeff .001 .001 .001\n");
    let err = sandbox.run("render ball.scn --size 60x40 --quiet -o ball.png").err;
    assert!(!err.contains("framed"), "{err}");
    sandbox.write("ball.scn", "prm ball\n");
    sandbox.run("render ball.scn --size 60x40 --quiet -o ball.png").fine();
}

#[test]
fn frame_and_up_are_commands_that_are_saved() {
    let sandbox = Sandbox::new();
    let out = sandbox
        .run_with("", "up z\nprm ball\ncoeff 100 100 100\nfloor -100\nframe\nsave s.scn\nundo\ninfo\n")
        .fine();
    assert!(out.contains("camera at 0 0 10"), "undone: {out}");
    let saved = sandbox.read("s.scn");
    assert!(saved.contains("up 0 0 1\ncamera 0 -"), "{saved}");
    assert!(saved.contains("floor -100\n") && saved.contains("light light"), "{saved}");
    sandbox.run("render s.scn --size 60x40 --quiet -o s.png").fine();
    assert!(brightness(&sandbox, "s.png").0 > 150);
    let err = sandbox.run_with("", "obj o\nframe\nframe nothing\n").failed(1);
    assert!(err.contains("nothing to see") && err.contains("'nothing'"), "{err}");
}

#[test]
fn colours_are_seen_as_in_other_programs() {
    let sandbox = Sandbox::new();
    for color in ["#ff8000", "#F80", "darkorange", "CornflowerBlue"] {
        sandbox.write("c.scn", format!("background {color}\nprm p\ncamera 0 0 10 0 0 20\n"));
        sandbox.run("render c.scn --size 2x2 --quiet -o c.png");
        let pixel = image::open(sandbox.path("c.png")).unwrap().to_rgb8().get_pixel(0, 0).0;
        let expected = match color {
            "#ff8000" => [255, 128, 0],
            "#F80" => [255, 136, 0],
            "darkorange" => [255, 140, 0],
            _ => [100, 149, 237],
        };
        assert_eq!(pixel, expected, "{color}");
    }
    sandbox.write("c.scn", "prm p\ncolor organge\n");
    let err = sandbox.run("check c.scn").failed(1);
    assert!(err.contains("'organge' is not a colour") && err.contains("did you mean 'orange'?"), "{err}");
}

#[test]
fn a_quaternion_of_another_length_is_taken_and_reported() {
    let sandbox = Sandbox::new();
    sandbox.write("q.scn", "prm p\nobj o\nap p\norient 2 0 0 2\n");
    let answer = sandbox.run("check q.scn");
    assert!(answer.code == Some(0) && answer.err.contains("warning[quaternion]"), "{}", answer.err);
    sandbox.write("q.scn", "prm p\nobj o\nap p\norient 0 0 0 0\nmatrix 1 2 3 0 4 5 6 0 7 8 9 0\n");
    let err = sandbox.run("check q.scn").failed(1);
    assert!(err.contains("q.scn:4:") && err.contains("q.scn:5:") && err.contains("no inverse"), "{err}");
}

#[test]
fn files_that_are_no_scenes_are_named_in_one_line_and_faults_are_capped() {
    let sandbox = Sandbox::new();
    sandbox.write("mesh.stl", "solid thing\n".to_owned() + &"facet normal 0 0 1\n".repeat(5000));
    let err = sandbox.run("check mesh.stl").failed(2);
    assert!(err.contains("an STL mesh") && err.lines().count() == 1, "{err}");
    // A file that can be read is loaded; its fault is one line, too.
    let head = "ply\nformat ascii 1.0\nelement vertex 1\n";
    sandbox.write("cloud.ply", format!("{head}end_header\n1 2 3\n"));
    let err = sandbox.run("check cloud.ply").failed(2);
    assert!(err.contains("'vertex'") && err.lines().count() == 1, "{err}");
    let properties = "property float x\nproperty float y\nproperty float z\n";
    sandbox.write("cloud.ply", format!("{head}{properties}end_header\n1 2 3\n"));
    assert_eq!(sandbox.run("check cloud.ply").code, Some(0));
    sandbox.write("words.scn", "so it goes\n".repeat(5000));
    let answer = sandbox.run("check words.scn");
    assert!(answer.err.contains("4900 more errors in this file"), "{}", answer.err);
    assert!(answer.out.contains("5000 errors"), "{}", answer.out);
    assert!(answer.err.lines().count() < 600);
    let err = sandbox.run_with("", "load words.scn\n").failed(1);
    assert!(err.contains("has 5000 errors") && err.lines().count() < 600, "{err}");
}
