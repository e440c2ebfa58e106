//! Legend and scale bar: whole runs on data that the tests write.

use std::fmt::Write;

use image::RgbImage;

use crate::support::Sandbox;

/// A row of spheres with a column `temp` from 0 to 9 and a column `type` from 1 to 3.
fn grains() -> String {
    let mut text = "x,y,z,radius,temp,type\n".to_owned();
    for row in 0..10 {
        let _ = writeln!(text, "{row},0,0,0.4,{row},{}", row % 3 + 1);
    }
    text
}

/// A dump of three frames whose speeds are 1, 2 and 5.
fn dump() -> String {
    let mut text = String::new();
    for (step, speed) in [(0, 1.0), (10, 2.0), (20, 5.0)] {
        let _ = write!(
            text,
            "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n-2 2\n-2 2\n-2 2\n\
             ITEM: ATOMS id type x y z vx vy vz radius\n1 1 0 0 0 {speed} 0 0 0.5\n2 1 0 1 0 0 0 0 0.5\n"
        );
    }
    text
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("grains.csv", grains()).write("run.dump", dump()).write("ball.scn", "prm ball\n");
    sandbox
}

fn picture(sandbox: &Sandbox, options: &str) -> RgbImage {
    let answer = sandbox.run(&format!("render {options} --quiet -o a.png"));
    // A column that is not read is a warning.
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    image::open(sandbox.path("a.png")).unwrap().to_rgb8()
}

/// The columns and rows of the pixels that differ, from the first to the last.
fn changed(a: &RgbImage, b: &RgbImage) -> Option<[u32; 4]> {
    let differs = a.enumerate_pixels().filter(|(x, y, pixel)| *pixel != b.get_pixel(*x, *y));
    differs.map(|(x, y, _)| [x, y, x, y]).reduce(|[left, top, right, bottom], [x, y, ..]| {
        [left.min(x), top.min(y), right.max(x), bottom.max(y)]
    })
}

/// Without light only the annotations are left.
const DARK: &str = "--samples 1 --exposure -30";

#[test]
fn a_legend_is_at_the_right_and_a_scale_bar_at_the_lower_left() {
    let sandbox = sandbox();
    for size in ["320x240", "640x480"] {
        let of_data = format!("grains.csv --size {size} {DARK} --color-by temp");
        let plain = picture(&sandbox, &of_data);
        let (width, height) = plain.dimensions();
        let [left, top, right, bottom] =
            changed(&plain, &picture(&sandbox, &format!("{of_data} --legend"))).unwrap();
        assert!(left > width * 3 / 4 && right < width, "{left} {right}");
        assert!(top > height / 8 && bottom < height * 7 / 8, "{top} {bottom}");
        let [left, top, right, bottom] =
            changed(&plain, &picture(&sandbox, &format!("{of_data} --scale-bar"))).unwrap();
        assert!(left < width / 10 && right < width / 2, "{left} {right}");
        assert!(top > height * 3 / 4 && bottom < height, "{top} {bottom}");
    }
}

#[test]
fn a_legend_covers_nothing_of_data() {
    let sandbox = sandbox();
    // A row along the right of the picture: the widest data there is.
    for size in ["640x480", "900x300", "300x900"] {
        let of_data = format!("grains.csv --size {size} --color-by temp --legend");
        let legend = picture(&sandbox, &format!("{of_data} {DARK}"));
        let left =
            legend.enumerate_pixels().filter(|(_, _, pixel)| pixel[0] > 60).map(|(x, ..)| x).min().unwrap();
        let lit = picture(&sandbox, &format!("{of_data} --samples 1"));
        let paper = image::Rgb([255; 3]);
        let beside = (0..lit.height()).filter(|y| *lit.get_pixel(left - 4, *y) != paper).count();
        assert_eq!(beside, 0, "{size}: data at column {left}");
    }
}

#[test]
fn a_legend_has_the_colours_of_the_map_in_order_or_those_of_the_types() {
    let sandbox = sandbox();
    let count_of = |picture: &RgbImage, color: [u8; 3]| {
        picture.pixels().filter(|pixel| (0..3).all(|i| pixel[i].abs_diff(color[i]) <= 2)).count()
    };
    let dark = format!("--size 640x480 {DARK}");
    let types = picture(&sandbox, &format!("grains.csv {dark} --type-colors --legend"));
    for color in [[230, 159, 0], [86, 180, 233], [0, 158, 115]] {
        assert!(count_of(&types, color) > 50, "{color:?}");
    }
    assert_eq!(count_of(&types, [240, 228, 66]), 0, "there is no fourth type");
    let viridis = picture(&sandbox, &format!("grains.csv {dark} --color-by temp --legend"));
    // The mean row of a colour.
    let row_of = |color: [u8; 3]| {
        let is_near = |pixel: &image::Rgb<u8>| (0..3).all(|i| pixel[i].abs_diff(color[i]) <= 6);
        let rows: Vec<u32> =
            viridis.enumerate_pixels().filter(|(_, _, pixel)| is_near(pixel)).map(|(_, y, _)| y).collect();
        assert!(rows.len() > 5, "{color:?}");
        rows.iter().sum::<u32>() / rows.len() as u32
    };
    let [low, middle, high] = [[68, 1, 84], [33, 145, 140], [253, 231, 37]].map(row_of);
    assert!(low > middle + 50 && middle > high + 50, "{low} {middle} {high}");
}

#[test]
fn annotations_of_any_size_and_layout_are_drawn() {
    let sandbox = sandbox();
    for size in ["1x1", "2x700", "700x2", "64x64", "160x120"] {
        for options in ["", "--transparent", "--bits 16", "--bits 16 --transparent", "--encoding linear"] {
            let words = format!(
                "grains.csv --size {size} --samples 1 --color-by temp --legend --scale-bar {options}"
            );
            picture(&sandbox, &words);
        }
        picture(&sandbox, &format!("grains.csv --size {size} --samples 1 --type-colors --legend"));
        picture(&sandbox, &format!("ball.scn --size {size} --samples 1 --scale-bar --aov normal"));
    }
}

#[test]
fn what_cannot_be_annotated_is_an_error_in_words() {
    let sandbox = sandbox();
    for (words, text) in [
        ("grains.csv --legend -o a.png", "--color-by COLUMN or --type-colors"),
        ("ball.scn --legend -o a.png", "--color-by COLUMN or --type-colors"),
        ("grains.csv --legend --color-by temp -o a.exr", "name a .png"),
        ("ball.scn --scale-bar -o a.exr", "name a .png"),
        ("ball.scn --scale-bar --shard 1/2 -o a.part", "a shard is a part of one"),
        ("grains.csv --legend --color-by temp --aov depth -o a.png", "--aov replaces them"),
    ] {
        let error = sandbox.run(&format!("render {words}")).failed(2);
        assert!(error.contains(text), "{words}: {error}");
    }
    assert_eq!(sandbox.run("import grains.csv -o grains.sqb --quiet").code, Some(0));
    let error = sandbox.run("render grains.sqb --color-by temp --legend -o a.png").failed(2);
    assert!(error.contains("its own colours"), "{error}");
    assert_eq!(sandbox.files(), ["ball.scn", "grains.csv", "grains.sqb", "run.dump"]);
}

#[test]
fn a_legend_of_an_animation_has_the_range_of_all_frames() {
    let sandbox = sandbox();
    let animate = |options: &str| {
        sandbox
            .run(&format!("animate run.dump --size 320x240 --samples 1 --quiet -o frames {options}"))
            .fine();
        let frame = |index: u32| {
            image::open(sandbox.path(&format!("frames/frame_{index:04}.png"))).unwrap().to_rgb8()
        };
        [frame(0), frame(1), frame(2)]
    };
    animate("--color-by speed");
    // The same frames again with a legend: they are rendered anew.
    let frames = animate("--color-by speed --legend");
    // The particles are in the middle.
    let legend = |frame: &RgbImage| image::imageops::crop_imm(frame, 270, 0, 50, 240).to_image();
    assert!(legend(&frames[0]).pixels().any(|pixel| pixel[0] < 100), "there is one");
    assert_eq!(legend(&frames[0]), legend(&frames[1]));
    assert_eq!(legend(&frames[1]), legend(&frames[2]));
    // Its range is that of the last frame.
    let last = picture(&sandbox, "run.dump --frame 2 --color-by speed --legend --size 320x240 --samples 1");
    assert_eq!(legend(&frames[2]), legend(&last));
    let first = picture(&sandbox, "run.dump --frame 0 --color-by speed --legend --size 320x240 --samples 1");
    assert_ne!(legend(&frames[0]), legend(&first));
}
