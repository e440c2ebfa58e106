//! Scene files that other people wrote, where they stand beside the project.

use std::path::PathBuf;

use crate::support::{Sandbox, project};

/// The folder of those files, or `None` and a message where it is missing.
fn scenes() -> Option<PathBuf> {
    let folder = project("../shared/scenes");
    if !folder.is_dir() {
        eprintln!("skipped: {} is not on this machine", folder.display());
        return None;
    }
    Some(folder)
}

#[test]
fn each_loads_without_an_error_and_shows_what_it_must() {
    let Some(folder) = scenes() else { return };
    for (file, selected, instances) in [
        ("robot_arm", "whole_scene", "19"),
        ("quicksave_2015_staff", "test_obj", "0"),
        ("test_2016_staff", "test_o2", "2"),
        ("arcticmatt_s0", "o2", "4"),
        ("jaleng_myscene", "test_obj", "2"),
        ("jaleng_sphere_tl", "test_obj", "1"),
        ("jaleng_coeff", "sphere", "1"),
        ("megantj_test1", "new_obj", "1"),
    ] {
        let sandbox = Sandbox::new();
        let scene = folder.join(file).with_extension("scn");
        let list = sandbox.run(&format!("info {}", scene.display())).fine();
        assert!(list.ends_with(&format!("selected: {selected}\n")), "{file}: {list}");
        let answer =
            sandbox.run(&format!("render {} --size 32x24 --samples 1 --stats s.json", scene.display()));
        assert_eq!(answer.code, Some(0), "{answer:?}");
        assert!(sandbox.read("s.json").contains(&format!("\"instances\": \"{instances}\"")), "{file}");
    }
}

#[test]
fn translate_then_scale_puts_the_centre_at_minus_two() {
    let Some(folder) = scenes() else { return };
    let ray = "ox,oy,oz,dx,dy,dz\n-2,0,10,0,0,-1\n-2,10,0,0,-1,0\n";
    let out = Sandbox::new()
        .run_with(&format!("intersect {} --rays -", folder.join("arcticmatt_s0.scn").display()), ray)
        .fine();
    assert_eq!(out.lines().nth(1).unwrap(), "1,8,-2,0,2,0,0,1,0,o2/p3");
    assert_eq!(out.lines().nth(2).unwrap(), "1,8,-2,2,0,0,1,0,0,o2/p3");
}

/// The official picture has other shading, so shapes are compared: where its shadows and the
/// background are black, ours are, and edges lie where its edges lie.
#[test]
fn the_robot_arm_lies_where_the_official_picture_has_it() {
    let Some(folder) = scenes() else { return };
    let sandbox = Sandbox::new();
    // As the official picture: no ambient light, no mirroring, a Blinn exponent of 20, linear
    // values.
    let text: String = std::fs::read_to_string(folder.join("robot_arm.scn"))
        .unwrap()
        .lines()
        .filter(|line| !line.to_lowercase().starts_with("reflected"))
        .flat_map(|line| {
            [line, if line.starts_with("Primitive") { "\nambient 0\nshininess 20\n" } else { "\n" }]
        })
        .collect();
    sandbox.write("robot.scn", text);
    sandbox.run("render robot.scn --size 800x800 --samples 1 --encoding linear --quiet").fine();
    let ours = image::open(sandbox.path("robot.png")).unwrap().to_rgb8();
    let official = image::open(folder.join("pictures/robot_arm_staff_800.png")).unwrap().to_rgb8();
    let is_black = |picture: &image::RgbImage, x, y| picture.get_pixel(x, y).0.iter().all(|&c| c <= 2);
    let pixels = (0..800).flat_map(|y| (0..800).map(move |x| (x, y)));
    let different = pixels.filter(|&(x, y)| is_black(&ours, x, y) != is_black(&official, x, y)).count();
    assert!(different < 640_000 / 100, "{different} pixels are black in one of them only");
    for (what, x, y, main) in
        [("red box", 498, 185, 0), ("green cylinder", 283, 150, 1), ("blue base", 440, 330, 2)]
    {
        for picture in [&ours, &official] {
            let pixel = picture.get_pixel(x, y).0;
            assert!((0..3).all(|c| pixel[c] <= pixel[main]) && pixel[main] > 60, "{what}: {pixel:?}");
        }
    }
}
