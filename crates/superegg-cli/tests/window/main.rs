//! The real program in a real window: every key is pressed and the picture looked at. Where there
//! is no Xvfb, xdotool, ImageMagick or graphics driver the tests say so and pass.

// A test that is skipped says so.
#![allow(clippy::print_stderr)]

mod display;

use std::path::Path;
use std::process::Command;

use image::RgbImage;

use crate::display::Viewer;

/// A coarse ball that shines, before a box that it casts a shadow on.
const SCENE: &str = "
primitive ball
  setPatch 9 7
  setColor 0.9 0.1 0.1
  setSpecular 0.7
  setGloss 0.2
primitive wall
  setExponent 0.01 0.01
  setColor 0.8 0.8 0.8
object scene
  addPrimitive ball
    scale 1.5 1.5 1.5
    translate 0 0 1.5
  addPrimitive wall
    scale 4 3 0.2
    translate 0 0 -1
light lamp -4 6 9
camera 0 0 14 0 0 0 45
";

/// A viewer of the scene as in the course program with the panel away, or none with a word on why.
fn open() -> Option<(Viewer, RgbImage)> {
    match Viewer::open_file("scene.scn", SCENE, &["--course"]) {
        Ok(viewer) => {
            let bare =
                viewer.until("the panel away", |viewer| viewer.key("Tab"), |picture| blue(picture) > 1000);
            Some((viewer, bare))
        }
        Err(reason) => {
            eprintln!("skipped: {reason}");
            None
        }
    }
}

fn count(picture: &RgbImage, is: impl Fn(i32, i32, i32) -> bool) -> usize {
    picture.pixels().filter(|pixel| is(pixel.0[0].into(), pixel.0[1].into(), pixel.0[2].into())).count()
}

/// Pixels of the marks outside, over black.
fn blue(picture: &RgbImage) -> usize {
    count(picture, |r, g, b| b > g + 8 && g > r)
}

/// Pixels of the ball.
fn red(picture: &RgbImage) -> usize {
    count(picture, |r, g, b| r > g + 40 && r > b + 40)
}

/// Pixels of the normals.
fn yellow(picture: &RgbImage) -> usize {
    count(picture, |r, g, b| r > 180 && g > 180 && b < 130)
}

/// Pixels of the normal at the hit.
fn green(picture: &RgbImage) -> usize {
    count(picture, |r, g, b| g > r + 60 && b > r && g > b + 40)
}

/// Pixels that differ visibly.
fn difference(a: &RgbImage, b: &RgbImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(x, y)| x.abs_diff(y) > 12)).count()
}

fn is_same(a: &RgbImage, b: &RgbImage) -> bool {
    difference(a, b) < 60
}

/// Presses a key that changes the picture so, and again to have it back.
fn switch(viewer: &Viewer, key: &str, before: &RgbImage, holds: impl Fn(&RgbImage) -> bool) -> RgbImage {
    let press = |viewer: &Viewer| viewer.key(key);
    let after = viewer.until(key, press, |picture| !is_same(picture, before) && holds(picture));
    viewer.until(&format!("{key} again"), press, |picture| is_same(picture, before));
    after
}

#[test]
fn every_key_works() {
    let Some((mut viewer, with_grid)) = open() else { return };
    switch(&viewer, "o", &with_grid, |picture| blue(picture) < blue(&with_grid) / 20);
    viewer.key("o");
    let base = viewer.until("o", |_| (), |picture| blue(picture) < 500);

    switch(&viewer, "i", &base, |picture| green(picture) < green(&base) / 2);
    viewer.key("i");
    let base = viewer.until("i", |_| (), |picture| !is_same(picture, &base));

    switch(&viewer, "m", &base, |picture| red(picture).abs_diff(red(&base)) < red(&base) / 2);
    switch(&viewer, "a", &base, |_| true);
    for key in ["h", "question", "Tab"] {
        switch(&viewer, key, &base, |_| true);
    }

    // n changes nothing but in wireframe.
    viewer.until("n on surfaces", |viewer| viewer.key("n"), |picture| is_same(picture, &base));
    viewer.key("n");
    let wires = viewer.until(
        "t",
        |viewer| viewer.key("t"),
        |picture| red(picture) < red(&base) / 2 && red(picture) > 300,
    );
    switch(&viewer, "n", &wires, |picture| yellow(picture) > yellow(&wires) + 100);
    // The grid is seen in wireframe too, the points inside through the wires.
    switch(&viewer, "o", &wires, |picture| blue(picture) > 1000 && red(picture) > red(&wires));
    viewer.until("t again", |viewer| viewer.key("t"), |picture| is_same(picture, &base));

    viewer.until("w", |viewer| viewer.key("w"), |picture| red(picture) > red(&base) * 11 / 10);
    viewer.until("s", |viewer| viewer.key("s"), |picture| is_same(picture, &base));
    viewer.until("s again", |viewer| viewer.key("s"), |picture| red(picture) < red(&base) * 9 / 10);
    viewer.until("Home", |viewer| viewer.key("Home"), |picture| is_same(picture, &base));
    viewer.xdotool(&["mousemove", "500", "300"]);
    viewer.settled();
    let nearer = |picture: &RgbImage| red(picture) > red(&base) * 21 / 20;
    viewer.until("wheel", |viewer| viewer.xdotool(&["click", "--repeat", "3", "--delay", "80", "4"]), nearer);
    viewer.until("Home", |viewer| viewer.key("Home"), |picture| is_same(picture, &base));
    viewer.until("f", |viewer| viewer.key("f"), |picture| !is_same(picture, &base));
    viewer.until("Home", |viewer| viewer.key("Home"), |picture| is_same(picture, &base));
    viewer.until(
        "pan",
        |viewer| viewer.drag("2", (500, 300), (600, 350)),
        |picture| !is_same(picture, &base),
    );
    viewer.until("Home", |viewer| viewer.key("Home"), |picture| is_same(picture, &base));

    // The arcball, there and back.
    let turned = viewer.until(
        "drag",
        |viewer| viewer.drag("1", (500, 380), (620, 330)),
        |picture| !is_same(picture, &base),
    );
    switch(&viewer, "b", &turned, |_| true);
    viewer.until("r", |viewer| viewer.key("r"), |picture| is_same(picture, &turned));

    // Ray traced there are shadows; it follows the drag.
    let traced = viewer.until("p", |viewer| viewer.key("p"), |picture| difference(picture, &turned) > 5000);
    viewer.until(
        "drag while traced",
        |viewer| viewer.drag("1", (500, 380), (420, 420)),
        |picture| difference(picture, &traced) > 5000,
    );
    viewer.until("Home while traced", |viewer| viewer.key("Home"), |picture| !is_same(picture, &traced));
    viewer.until("p again", |viewer| viewer.key("p"), |picture| is_same(picture, &base));

    // The view becomes the camera, by commands that are undone.
    viewer.until(
        "drag",
        |viewer| viewer.drag("1", (500, 380), (620, 330)),
        |picture| is_same(picture, &turned),
    );
    viewer.until("c", |viewer| viewer.key("c"), |picture| is_same(picture, &turned));
    viewer.wait_until_said("> camera ");
    viewer.until("Home is there now", |viewer| viewer.key("Home"), |picture| is_same(picture, &turned));
    viewer.key("ctrl+z");
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| is_same(picture, &base));
    viewer.key("ctrl+y");
    viewer.until("redo", |viewer| viewer.key("ctrl+y"), |picture| is_same(picture, &turned));
    viewer.key("ctrl+z");
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| is_same(picture, &base));

    for (key, name) in [("F12", "superegg-0001.png"), ("Print", "superegg-0002.png")] {
        viewer.key(key);
        viewer.wait_until_said(name);
        let picture = image::open(viewer.path(name)).expect("a picture").to_rgb8();
        assert!(
            picture.dimensions() == (1000, 760) && red(&picture) > red(&base) / 2,
            "{:?}",
            picture.dimensions()
        );
    }

    // A click casts its ray, a double click selects, and beside everything the whole.
    viewer.key("i");
    viewer.xdotool(&["mousemove", "560", "330", "click", "1"]);
    let cast = viewer.until("click", |_| (), |picture| green(picture) > 20 && !is_same(picture, &base));
    viewer.xdotool(&["mousemove", "500", "380", "click", "--repeat", "2", "1"]);
    viewer.wait_until_said("selected ball at scene/ball");
    viewer.until("double click", |_| (), |picture| !is_same(picture, &cast));
    viewer.xdotool(&["mousemove", "20", "20", "click", "--repeat", "2", "1"]);
    viewer.wait_until_said("> object scene");

    viewer.key("q");
    assert_eq!(viewer.exit_code(), Some(0));
}

#[test]
fn the_first_view_is_clean_and_the_tests_are_readable() {
    let Some((mut viewer, clean)) = open_plain() else { return };
    // Inside points show through the wall, and the points outside are few and can be left out.
    let points = switch(&viewer, "o", &clean, |picture| blue(picture) > 500);
    viewer.until("o", |viewer| viewer.key("o"), |picture| is_same(picture, &points));
    assert!(red(&points) > red(&clean) + 500);
    let inside = switch(&viewer, "u", &points, |picture| blue(picture) < 50);
    assert!(red(&inside) > red(&clean) + 500);
    viewer.until("o again", |viewer| viewer.key("o"), |picture| is_same(picture, &clean));
    switch(&viewer, "i", &clean, |picture| green(picture) > 20);
    viewer.key("q");
    assert_eq!(viewer.exit_code(), Some(0));
}

/// A viewer of the scene without menu, panel and axes, or none with a word on why.
fn open_plain() -> Option<(Viewer, RgbImage)> {
    match Viewer::open_file("scene.scn", SCENE, &[]) {
        Ok(viewer) => {
            viewer.key("a");
            let red_alone = |picture: &RgbImage| blue(picture) + green(picture) < 50 && red(picture) > 5000;
            let bare = viewer.until("menu and panel away", |viewer| viewer.key("Tab"), red_alone);
            Some((viewer, bare))
        }
        Err(reason) => {
            eprintln!("skipped: {reason}");
            None
        }
    }
}

#[test]
fn a_clicked_child_is_moved_duplicated_and_removed_and_all_of_it_undoes() {
    let Some((mut viewer, bare)) = open_plain() else { return };
    let click = |at: [&str; 2]| viewer.xdotool(&["mousemove", at[0], at[1], "click", "1"]);
    let outlined = viewer.until("a click", |_| click(["500", "380"]), |picture| !is_same(picture, &bare));
    viewer.wait_until_said("> setCursor ball");
    assert!(red(&outlined).abs_diff(red(&bare)) < red(&bare) / 5);
    // A handle under the pointer is drawn in another colour.
    viewer.xdotool(&["mousemove", "20", "700"]);
    let handles = viewer.until("1", |viewer| viewer.key("1"), |picture| !is_same(picture, &outlined));
    // The arrow of x, from the origin of the ball to the right.
    let moved = viewer.until(
        "an arrow",
        |viewer| viewer.drag("1", (560, 380), (640, 380)),
        |picture| difference(picture, &handles) > 2000,
    );
    viewer.wait_until_said("> translate ");
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| is_same(picture, &handles));
    viewer.until("redo", |viewer| viewer.key("ctrl+y"), |picture| is_same(picture, &moved));
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| is_same(picture, &handles));
    viewer.until("1 again", |viewer| viewer.key("1"), |picture| is_same(picture, &outlined));

    viewer.until("Delete", |viewer| viewer.key("Delete"), |picture| red(picture) < red(&bare) / 10);
    viewer.wait_until_said("> remove ball");
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| is_same(picture, &bare));
    click(["500", "380"]);
    viewer.until("the ball again", |_| (), |picture| is_same(picture, &outlined));
    viewer.key("ctrl+d");
    viewer.wait_until_said("> addPrimitive ball ball2");
    viewer.key("ctrl+z");
    viewer.wait_until_said("undone: duplicate as ball2");

    // f frames the ball, Shift+F everything; the background deselects.
    let near = |picture: &RgbImage| red(picture) > red(&bare) * 12 / 10;
    click(["500", "380"]);
    viewer.until("f", |viewer| viewer.key("f"), near);
    viewer.until("Shift+F", |viewer| viewer.key("shift+f"), |picture| !near(picture));
    viewer.until("Home", |viewer| viewer.key("Home"), |picture| red(picture).abs_diff(red(&bare)) < 2000);
    viewer.until("the background", |_| click(["20", "700"]), |picture| is_same(picture, &bare));
    viewer.until("7", |viewer| viewer.key("7"), |picture| is_same(picture, &bare));
    viewer.until("9", |viewer| viewer.key("9"), |picture| !is_same(picture, &bare));
    viewer.until("Home", |viewer| viewer.key("Home"), |picture| is_same(picture, &bare));
    for (modifier, button) in [(None, "3"), (Some("shift"), "1")] {
        modifier.iter().for_each(|key| viewer.xdotool(&["keydown", key]));
        let drag = |viewer: &Viewer| viewer.drag(button, (500, 380), (560, 420));
        viewer.until("a drag", drag, |picture| !is_same(picture, &bare));
        modifier.iter().for_each(|key| viewer.xdotool(&["keyup", key]));
        viewer.until("Home", |viewer| viewer.key("Home"), |picture| is_same(picture, &bare));
    }
    // A turned view is two lines as the camera, and one undo.
    viewer.until(
        "a turn",
        |viewer| viewer.drag("1", (300, 300), (420, 380)),
        |picture| !is_same(picture, &bare),
    );
    viewer.key("c");
    viewer.wait_until_said("> cameraUp ");
    viewer.wait_until_said("> camera ");
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| is_same(picture, &bare));
    viewer.wait_until_said("undone: cameraUp ");
    viewer.key("q");
    assert_eq!(viewer.exit_code(), Some(0));
}

#[test]
fn unsaved_changes_are_marked_and_asked_about() {
    let Some((mut viewer, bare)) = open_plain() else { return };
    let file = |viewer: &Viewer| std::fs::read_to_string(viewer.path("scene.scn")).expect("the scene");
    viewer.wait_for_title("scene.scn - Superegg");
    let change = |viewer: &Viewer| {
        viewer.xdotool(&["mousemove", "500", "300", "click", "4"]);
        viewer.settled();
        viewer.key("c");
        viewer.wait_for_title("scene.scn. - Superegg");
    };
    change(&viewer);
    let before = viewer.settled();
    // Escape asks, and Escape takes it back.
    let asked = |picture: &RgbImage| difference(picture, &before) > 2000;
    viewer.until("Escape", |viewer| viewer.key("Escape"), asked);
    viewer.until("Escape again", |viewer| viewer.key("Escape"), |picture| is_same(picture, &before));
    viewer.key("ctrl+s");
    viewer.wait_until_said("saved as scene.scn");
    viewer.wait_for_title("scene.scn - Superegg");
    let saved = file(&viewer);
    assert!(saved.starts_with("# superegg scene") && saved.contains("camera 0 0 1"), "{saved}");
    // A new scene asks, too; the answer that has the keyboard saves first.
    change(&viewer);
    let before = viewer.settled();
    let asked = |picture: &RgbImage| difference(picture, &before) > 2000;
    viewer.until("Ctrl+N", |viewer| viewer.key("ctrl+n"), asked);
    viewer.key("Return");
    viewer.wait_for_title("Superegg");
    assert!(file(&viewer) != saved, "{}", file(&viewer));
    // The scene before comes back, without its file.
    viewer.until("undo", |viewer| viewer.key("ctrl+z"), |picture| red(picture) > red(&bare) / 2);
    viewer.wait_for_title("untitled. - Superegg");
    let before = viewer.settled();
    let asked = |picture: &RgbImage| difference(picture, &before) > 2000;
    viewer.until("q", |viewer| viewer.key("q"), asked);
    viewer.key("Tab");
    viewer.settled();
    viewer.key("Return");
    assert_eq!(viewer.exit_code(), Some(0), "{}", viewer.report());
    assert_eq!(journals(viewer.folder.path()), Vec::<String>::new());
}

#[test]
fn pictures_are_found_beside_the_scene_of_the_window() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("far")).expect("a folder");
    RgbImage::new(2, 2).save(folder.path().join("far/t.png")).expect("a picture");
    let text = SCENE.replace("primitive wall\n", "  setTexture color t.png\nprimitive wall\n");
    std::fs::write(folder.path().join("far/s.scn"), text).expect("a file");
    let Ok(viewer) = Viewer::open_in(folder, "far/s.scn", &[]) else { return eprintln!("skipped") };
    viewer.wait_for_title("s.scn - Superegg");
    viewer.settled();
    viewer.key("ctrl+s");
    viewer.wait_until_said("saved as far/s.scn");
    assert!(!viewer.report().contains("warning"), "{}", viewer.report());
    let saved = std::fs::read_to_string(viewer.path("far/s.scn")).expect("the scene");
    assert!(saved.contains("setTexture color \"t.png\""), "{saved}");
    drop(viewer.crash());
}

#[test]
fn a_window_that_is_killed_loses_nothing() {
    let Some((viewer, _)) = open_plain() else { return };
    viewer.xdotool(&["mousemove", "500", "380", "click", "1"]);
    viewer.wait_until_said("> setCursor ball");
    viewer.key("Delete");
    viewer.wait_until_said("> remove ball");
    let folder = viewer.crash();
    let journals = journals(folder.path());
    assert_eq!(journals.len(), 1);
    assert!(
        journals[0].contains("addPrimitive ball")
            && journals[0].ends_with("\n.\n> setCursor ball\n> remove ball\n"),
        "{}",
        journals[0]
    );
    // The next window offers it in a bar at the top.
    let Ok(viewer) = Viewer::open_in(folder, "scene.scn", &[]) else { panic!("no second window") };
    viewer.key("a");
    let offered = viewer.until("the ball", |_| (), |picture| red(picture) > 2000);
    for x in (300..900).step_by(20) {
        viewer.xdotool(&["mousemove", &x.to_string(), "12", "click", "1"]);
        if viewer.report().contains("> recover") {
            break;
        }
    }
    viewer.wait_until_said("recovered: ");
    viewer.until("the ball is away again", |_| (), |picture| red(picture) < red(&offered) / 10);
    viewer.wait_for_title("untitled. - Superegg");
    drop(viewer.crash());
}

/// The texts of the journals of a home folder.
fn journals(home: &Path) -> Vec<String> {
    let files = home.join("superegg").join("journals").read_dir().into_iter().flatten().flatten();
    files.map(|file| std::fs::read_to_string(file.path()).expect("a journal")).collect()
}

#[test]
fn a_window_of_any_size_and_none_at_all_goes_on() {
    let Some((mut viewer, base)) = open() else { return };
    let window = viewer.window();
    for size in [["1", "1"], ["37", "900"], ["1280", "3"], ["300", "200"]] {
        viewer.xdotool(&["windowsize", &window, size[0], size[1]]);
        viewer.settled();
    }
    viewer.xdotool(&["windowunmap", &window]);
    viewer.settled();
    viewer.xdotool(&["windowmap", &window, "windowsize", &window, "1000", "760", "windowfocus", &window]);
    viewer.until("the size as before", |_| (), |picture| is_same(picture, &base));
    viewer.key("Escape");
    assert_eq!(viewer.exit_code(), Some(0));
}

#[test]
fn a_display_that_goes_away_is_reported_and_survived() {
    let Some((mut viewer, _)) = open() else { return };
    viewer.display.kill();
    assert_eq!(viewer.exit_code(), Some(0), "{}", viewer.report());
    viewer.wait_until_said("the display has gone away");
}

#[test]
fn the_window_follows_the_prompt_and_the_prompt_outlives_it() {
    let mut viewer = match Viewer::open_beside_prompt() {
        Ok(viewer) => viewer,
        Err(reason) => return eprintln!("skipped: {reason}"),
    };
    for line in ["set ioTest off", "set axes off", "camera 0 0 5 0 0 0", "primitive ball"] {
        viewer.line(line);
    }
    let white = viewer.until(
        "a white ball",
        |_| (),
        |picture| count(picture, |r, g, b| r > 150 && g > 150 && b > 150) > 5000,
    );
    viewer.line("setColor 1 0 0");
    let solid = viewer.until("a red ball", |_| (), |picture| red(picture) > 5000);
    // A key in the window is a setting at the prompt, and the window's undo is the prompt's.
    viewer.key("t");
    viewer.until("its edges", |_| (), |picture| difference(picture, &solid) > 5000);
    viewer.line("get wireframe");
    viewer.wait_until_said("wireframe      on");
    viewer.key("t");
    viewer.key("ctrl+z");
    viewer.wait_until_said("undone: setColor 1 0 0");
    viewer.until("the white ball again", |_| (), |picture| difference(picture, &white) < 200);
    viewer.display.kill();
    viewer.wait_until_said("the display has gone away");
    viewer.line("primitive after");
    viewer.line("view");
    viewer.wait_until_said("there is no viewer: its display has gone away");
    viewer.line("save after");
    viewer.wait_until_said("saved as after.scn");
    viewer.line("stop");
    assert_eq!(viewer.exit_code(), Some(0), "{}", viewer.report());
}

/// A dump of five frames with a ball of another size in each.
fn growing() -> String {
    let frame = |(step, radius): (u32, &str)| {
        format!(
            "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n-4 4\n-4 4\n-4 4\n\
             ITEM: ATOMS id x y z radius\n1 0 0 0 {radius}\n2 3.9 3.9 3.9 0.1\n"
        )
    };
    [(0, "0.5"), (1, "1"), (2, "2"), (3, "0.1"), (4, "3")].map(frame).concat()
}

#[test]
fn the_frames_of_data_are_shown_by_keys_and_by_the_slider() {
    let mut viewer = match Viewer::open_file("grow.dump", &growing(), &[]) {
        Ok(viewer) => viewer,
        Err(reason) => return eprintln!("skipped: {reason}"),
    };
    // Grey pixels of the ball beside the white background; the axes are away.
    viewer.key("a");
    let grey = |picture: &RgbImage| {
        let scene = image::imageops::crop_imm(picture, 0, 30, 640, 670).to_image();
        count(&scene, |r, g, b| r < 200 && (r - g).abs() < 12 && (g - b).abs() < 12)
    };
    let first = viewer.settled();
    let small = grey(&first);
    let second =
        viewer.until("the next frame", |viewer| viewer.key("period"), |picture| grey(picture) > 2 * small);
    let third = viewer.until(
        "the one after it",
        |viewer| viewer.key("period"),
        |picture| grey(picture) > 2 * grey(&second),
    );
    viewer.until("the one before", |viewer| viewer.key("comma"), |picture| is_same(picture, &second));
    for _ in 0..9 {
        viewer.key("period");
    }
    let last = viewer.until("the last", |_| (), |picture| grey(picture) > grey(&third));
    viewer.until("no frame after the last", |viewer| viewer.key("period"), |picture| is_same(picture, &last));
    for _ in 0..9 {
        viewer.key("comma");
    }
    viewer.until("the first", |_| (), |picture| is_same(picture, &first));
    // The slider, from its left end to the right one; each step is a frame of the window.
    for step in [&["mousemove", "784", "83"][..], &["mousedown", "1"], &["mousemove", "900", "83"]] {
        viewer.xdotool(step);
        viewer.settled();
    }
    viewer.xdotool(&["mouseup", "1"]);
    viewer.until("the end of the slider", |_| (), |picture| grey(picture) == grey(&last));
    // A click beside everything, so that keys are the window's.
    viewer.xdotool(&["mousemove", "30", "300", "click", "1"]);
    viewer.settled();
    viewer.key("q");
    assert_eq!(viewer.exit_code(), Some(0));
}

#[test]
fn without_a_display_there_is_a_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("scene.scn"), SCENE).expect("a scene");
    let output = Command::new(env!("CARGO_BIN_EXE_superegg"))
        .args(["view", "scene.scn"])
        .current_dir(folder.path())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .expect("the program");
    if cfg!(target_os = "linux") {
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("there is no display to open a window on"), "{text}");
    }
}
