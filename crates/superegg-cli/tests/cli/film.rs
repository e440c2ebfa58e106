//! Pictures as files: formats, development, sampling, views and warnings.

use std::collections::BTreeMap;

use image::{ColorType, DynamicImage};

use crate::support::Sandbox;

/// A ball before a background, and a way to look at it.
const BALL: &str = "background .1 .2 .5\nprm ball\ncolor .9 .5 .2\nspecular 0\n";

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("ball.scn", BALL);
    sandbox
}

fn picture(sandbox: &Sandbox, name: &str) -> DynamicImage {
    image::open(sandbox.path(name)).unwrap()
}

/// A PNG of the ball, 32 by 24 pixels.
fn rendered(options: &str) -> DynamicImage {
    let sandbox = sandbox();
    sandbox.run(&format!("render ball.scn --size 32x24 --quiet -o a.png {options}")).fine();
    picture(&sandbox, "a.png")
}

#[test]
fn bits_and_transparency_make_four_kinds_of_png() {
    for (options, kind) in [
        ("", ColorType::Rgb8),
        ("--transparent", ColorType::Rgba8),
        ("--bits 16", ColorType::Rgb16),
        ("--bits 16 --transparent", ColorType::Rgba16),
    ] {
        assert_eq!(rendered(options).color(), kind, "{options}");
    }
}

#[test]
fn sixteen_bits_round_to_the_eight() {
    let (deep, plain) = (rendered("--bits 16").to_rgb16(), rendered("").to_rgb8());
    for (deep, plain) in deep.pixels().zip(plain.pixels()) {
        for (deep, plain) in deep.0.into_iter().zip(plain.0) {
            assert!((f64::from(deep) / 257.0 - f64::from(plain)).abs() <= 0.51, "{deep} {plain}");
        }
    }
}

#[test]
fn a_transparent_picture_over_its_background_is_the_opaque_one() {
    let (clear, opaque) = (rendered("--transparent").to_rgba8(), rendered("").to_rgb8());
    let linear = |byte: u8| {
        let value = f64::from(byte) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    let background = [0.1, 0.2, 0.5];
    let mut edges = 0;
    for (clear, opaque) in clear.pixels().zip(opaque.pixels()) {
        let alpha = f64::from(clear[3]) / 255.0;
        edges += u32::from(clear[3] > 0 && clear[3] < 255);
        for channel in 0..3 {
            let over = alpha * linear(clear[channel]) + (1.0 - alpha) * background[channel];
            assert!((over - linear(opaque[channel])).abs() < 0.01, "{clear:?} {opaque:?}");
        }
    }
    assert!(edges >= 4);
    assert_eq!(clear.get_pixel(0, 0).0, [0; 4]);
}

#[test]
fn exposure_and_tone_change_what_is_bright() {
    let middle =
        |options: &str| rendered(&format!("--encoding linear {options}")).to_rgb8().get_pixel(16, 10).0;
    let (plain, up, down) = (middle(""), middle("--exposure 1"), middle("--exposure -1"));
    for i in 0..3 {
        assert!(up[i].abs_diff(plain[i].saturating_mul(2)) <= 1, "{up:?} {plain:?}");
        assert!(down[i].abs_diff(plain[i] / 2) <= 1, "{down:?} {plain:?}");
    }
    assert!(middle("--tone reinhard")[0] < plain[0]);
    let bright = middle("--exposure 3 --tone filmic");
    assert!(bright[2] > middle("--exposure 3 --tone reinhard")[2] / 2 && bright[0] > 200, "{bright:?}");
    // The scene's own settings count until an option overrides them.
    let sandbox = sandbox();
    sandbox.write(
        "up.scn",
        format!("{BALL}set exposure 1\nset encoding linear\nset filter tent\nset bits 16\n"),
    );
    let run = |options: &str| {
        sandbox.run(&format!("render up.scn --size 32x24 --quiet -o a.png {options}")).fine();
        picture(&sandbox, "a.png")
    };
    assert_eq!(run("--bits 8 --filter box").to_rgb8().get_pixel(16, 10).0, up);
    assert_eq!(run("--bits 8 --filter box --exposure 0").to_rgb8().get_pixel(16, 10).0, plain);
    assert_eq!(run("").color(), ColorType::Rgb16);
}

#[test]
fn an_exr_file_has_light_depth_and_instances() {
    use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
    let sandbox = sandbox();
    sandbox.run("render ball.scn --size 32x24 --quiet --exposure 3 --tone filmic -o a.exr").fine();
    let image = read_all_flat_layers_from_file(sandbox.path("a.exr")).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    let expected = "A B G N.X N.Y N.Z R Z albedo.B albedo.G albedo.R id instance object samples";
    assert_eq!(names.join(" "), expected);
    let floats = |name: &str| match &channels.iter().find(|c| c.name.eq(name)).unwrap().sample_data {
        FlatSamples::F32(values) => values.clone(),
        _ => panic!("{name} is no float"),
    };
    // Neither exposure nor tone is in it: the corner is the background.
    assert_eq!([floats("R")[0], floats("G")[0], floats("B")[0]], [0.1, 0.2, 0.5]);
    let middle = 12 * 32 + 16;
    assert!((floats("Z")[middle] - 9.0).abs() < 0.2 && floats("Z")[0] == f32::INFINITY);
    assert!((floats("albedo.R")[middle] - 0.9).abs() < 1e-6 && floats("N.Z")[middle] > 0.9);
    assert_eq!(floats("A")[0], 1.0);
}

/// The float channels of an OpenEXR file by name.
fn float_channels(sandbox: &Sandbox, name: &str) -> BTreeMap<String, Vec<f32>> {
    use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
    let image = read_all_flat_layers_from_file(sandbox.path(name)).unwrap();
    let channels = image.layer_data[0].channel_data.list.iter();
    let floats = channels.filter_map(|channel| match &channel.sample_data {
        FlatSamples::F32(values) => Some((channel.name.to_string(), values.clone())),
        _ => None,
    });
    floats.collect()
}

#[test]
fn numbers_and_mattes_name_what_covers_a_pixel() {
    let sandbox = Sandbox::new();
    sandbox.write(
        "s.scn",
        "set size 32x24\nset samples 16\nset cryptomatte on\nset transparent on\nprm ball\ncoeff .6 .6 .6\n\
         obj pair\nap ball left\nxs -1 0 0\nap ball right\nxs 1 0 0\nobj all\nao pair\nap ball top\nxs 0 2 0\n",
    );
    sandbox.run("render s.scn -o a.exr --quiet").fine();
    let channels = float_channels(&sandbox, "a.exr");
    let of = |name: &str| &channels[name];
    let whole = |name: &str| {
        let mut found: Vec<u32> = of(name).iter().map(|value| *value as u32).collect();
        assert!(of(name).iter().all(|value| value.fract() == 0.0));
        found.sort_unstable();
        found.dedup();
        found
    };
    assert_eq!((whole("instance"), whole("object")), (vec![0, 2, 3, 4], vec![0, 2, 3]));
    for level in ["CryptoInstance", "CryptoObject"] {
        for (i, alpha) in of("A").iter().enumerate() {
            let share = |name: &str| of(&format!("{level}{name}"))[i];
            let shares = ["00.g", "00.a", "01.g", "01.a", "02.g", "02.a"].map(share);
            assert!(shares.windows(2).all(|pair| pair[0] >= pair[1]));
            assert!((shares.iter().sum::<f32>() - alpha).abs() < 1e-6, "{level} {i}");
        }
    }
    // A name's share over the picture is that of its part, and the ids are those of the names.
    let id = f32::from_bits(superegg_render::matte_id("all/pair/left"));
    let covered = |id: f32| -> f32 {
        let [ids, shares] = ["CryptoInstance00.r", "CryptoInstance00.g"].map(of);
        ids.iter().zip(shares).filter(|(found, _)| **found == id).map(|(_, share)| share).sum()
    };
    assert!(covered(id) > 1.0 && covered(-id) == 0.0);
    let bytes = std::fs::read(sandbox.path("a.exr")).unwrap();
    let manifest = format!("\"all/pair/left\":\"{:08x}\"", id.to_bits());
    assert!(bytes.windows(manifest.len()).any(|window| window == manifest.as_bytes()));
}

#[test]
fn parts_of_light_add_up_and_survive_shards() {
    let sandbox = Sandbox::new();
    sandbox.write(
        "s.scn",
        "set size 48x24\nset samples 8\nset light path\nset cryptomatte on\nset filter mitchell\nprm ball\nfloor -1\nprm lamp\n\
         coeff .3 .3 .3\nsetEmission 4\nobj all\nap ball\nap lamp\nxs 1.5 1 0\nsky .2 .3 .4 .5 .6 .9\n",
    );
    sandbox.run("render s.scn -o whole.exr --quiet").fine();
    let channels = float_channels(&sandbox, "whole.exr");
    for color in ["R", "G", "B"] {
        let part = |name: &str| &channels[&format!("{name}.{color}")];
        let parts = ["emission", "direct", "indirect"].map(part);
        for (i, whole) in channels[color].iter().enumerate() {
            let sum: f32 = parts.iter().map(|part| part[i]).sum();
            assert!((sum - whole).abs() <= 1e-5 * (1.0 + whole.abs()), "{color} {i}: {sum} {whole}");
        }
        let total = |part: &[f32]| part.iter().sum::<f32>();
        assert!(parts.iter().all(|part| total(part) > 1.0), "{color}");
    }
    // The same bytes by shards, and without the parts the same light.
    for k in 1..=2 {
        sandbox.run(&format!("render s.scn --shard {k}/2 -o {k}.part --quiet")).fine();
    }
    sandbox.run("merge 1.part 2.part -o merged.exr --quiet").fine();
    let file = |name: &str| std::fs::read(sandbox.path(name)).unwrap();
    assert!(file("merged.exr") == file("whole.exr"));
    sandbox.run("render s.scn -o whole.png --quiet").fine();
    sandbox.run("merge 1.part 2.part -o merged.png --quiet").fine();
    assert!(file("merged.png") == file("whole.png"));
}

#[test]
fn the_modeller_writes_exr_files_too() {
    let sandbox = sandbox();
    let out = sandbox.run_with("ball.scn", "render small.exr 16x12\n").fine();
    assert!(out.contains("small.exr: 16x12"), "{out}");
    assert!(std::fs::read(sandbox.path("small.exr")).unwrap().starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    // A PNG is not overwritten by an EXR of its name, nor another file.
    sandbox.write("text.exr", "not a picture");
    let answer = sandbox.run_with("ball.scn", "render text.exr 16x12\n");
    assert!(answer.err.contains("is no picture"), "{answer:?}");
    let answer = sandbox.run_with("ball.scn", "render a.jpg 16x12\n");
    assert!(answer.err.contains(".png") && answer.err.contains(".exr"), "{answer:?}");
}

#[test]
fn another_ending_is_refused_before_any_work() {
    let sandbox = sandbox();
    let err = sandbox.run("render ball.scn -o picture.jpg").failed(2);
    assert!(err.contains("'.jpg'") && err.contains(".png") && err.contains(".exr"), "{err}");
    assert_eq!(sandbox.files(), ["ball.scn"]);
}

#[test]
fn noise_spends_samples_where_they_are_needed() {
    let sandbox = sandbox();
    let stats = |options: &str| -> serde_json::Value {
        let words = format!("render ball.scn --size 32x24 --stats s.json --quiet -o a.png {options}");
        sandbox.run(&words).fine();
        serde_json::from_str(&sandbox.read("s.json")).unwrap()
    };
    let fixed = stats("--samples 3");
    assert_eq!((&fixed["samples_taken"], &fixed["rays"]["camera"]), (&serde_json::Value::Null, &2304.into()));
    let adaptive = stats("--noise 0.02 --max-samples 77");
    let (mean, most) = (
        adaptive["samples_taken"]["mean"].as_f64().unwrap(),
        adaptive["samples_taken"]["most"].as_u64().unwrap(),
    );
    assert!(mean > 4.0 && mean < 60.0 && most == 77, "{mean} {most}");
    assert_eq!(adaptive["rays"]["camera"].as_f64().unwrap(), (mean * 32.0 * 24.0).round());
    let out = sandbox.run("render ball.scn --size 32x24 --noise 0.02 -o a.png").fine();
    assert!(out.contains("samples a pixel, "), "{out}");
}

#[test]
fn views_are_written_as_pictures() {
    let of = |view: &str| rendered(&format!("--view {view}")).to_rgb8();
    let middle = |view: &str| of(view).get_pixel(16, 12).0;
    let corner = |view: &str| of(view).get_pixel(0, 0).0;
    let normal = middle("normal");
    assert!(normal[2] > 240 && normal[0].abs_diff(128) < 40 && corner("normal") == [0; 3], "{normal:?}");
    assert!(middle("depth")[0] > 200 && corner("depth") == [0; 3]);
    assert!(middle("id").iter().any(|&value| value > 100) && corner("id") == [0; 3]);
    assert!(middle("steps")[0] > 100);
    assert_eq!((middle("ao"), corner("ao")), ([255; 3], [0; 3]));
    let sandbox = sandbox();
    let out = sandbox.run("render ball.scn --size 32x24 --view steps -o a.png").fine();
    assert!(out.contains("boxes and shapes a ray"), "{out}");
}

#[test]
fn a_pointless_picture_is_warned_of_by_both() {
    for (text, part) in [
        ("prm s\nlight l 0 0 9 0 0 0\n", "does not reach anything"),
        ("prm s\ncamera 0 0 10 0 0 20\n", "behind the camera"),
        ("prm s\ncamera 0 0 10 30 0 0\n", "looks past"),
        ("prm s\ncamera 0 0 .5 0 0 0\n", "inside 's'"),
    ] {
        let sandbox = Sandbox::new();
        sandbox.write("odd.scn", text);
        let answer = sandbox.run("render odd.scn --size 8x6 -o a.png");
        assert!(answer.code == Some(0) && answer.err.contains("superegg: warning: "), "{answer:?}");
        assert!(answer.err.contains(part), "{part}: {answer:?}");
        let out = sandbox.run_with("odd.scn", "render b.png 8x6\n").out;
        assert!(out.contains("warning: ") && out.contains(part), "{part}: {out}");
    }
    let answer = sandbox().run("render ball.scn --size 8x6 --max-samples 9 --quiet -o a.png");
    assert!(answer.err.contains("--noise"), "{answer:?}");
}

#[test]
fn options_out_of_range_are_refused() {
    for options in [
        "--bits 12",
        "--noise -1",
        "--noise 2",
        "--noise x",
        "--exposure 99",
        "--exposure nan",
        "--tone loud",
        "--filter sinc",
        "--view x",
        "--bounces 257",
        "--max-samples 0",
        "--max-samples 65537",
    ] {
        sandbox().run(&format!("render ball.scn {options} -o a.png")).failed(2);
    }
}

#[test]
fn a_picture_says_how_it_was_made() {
    let sandbox = Sandbox::new();
    sandbox.write("s.scn", "set size 16x12\nset tone agx\nset dither on\nprm ball\ncolor .5 .2 .1\n");
    for name in ["a.png", "a.exr"] {
        assert_eq!(
            sandbox.run(&format!("render s.scn --scene-text --samples 3 -o {name} --quiet")).code,
            Some(0)
        );
        let said = sandbox.run(&format!("info {name}")).out;
        for line in [
            "superegg ",
            "set samples 3",
            "set tone agx",
            "set dither on",
            "prm ball",
            "primitive ball",
            "setColor 0.5 0.2 0.1",
        ] {
            let is_there = said.lines().any(|found| found.starts_with(line));
            assert_eq!(is_there, line != "prm ball", "{name}: {line}\n{said}");
        }
        assert_eq!(sandbox.run(&format!("render s.scn -o b{name} --quiet")).code, Some(0));
        assert!(!sandbox.run(&format!("info b{name}")).out.contains("ball"));
    }
    std::fs::write(sandbox.path("worse.png"), b"\x89PNG\r\n\x1a\n1234").unwrap();
    assert!(sandbox.run("info worse.png").failed(2).contains("worse.png"));
}

#[test]
fn surroundings_are_found_beside_the_scene_and_missing_ones_are_faults() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("far")).unwrap();
    let mut grey = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    grey.extend([128, 64, 128, 128].repeat(2));
    sandbox.write("far/grey.hdr", &grey);
    sandbox.write("far/s.scn", "set size 8x6\nprm ball\nenvironment grey.hdr 0 .5\n");
    let corner = |name: &str| picture(&sandbox, name).to_rgb8().get_pixel(0, 0).0;
    sandbox.run("render far/s.scn -o a.png --encoding linear --quiet").fine();
    assert_eq!(corner("a.png"), [64, 32, 64]);
    // Saved and loaded again it is the same scene, and sun and sky have two spellings.
    sandbox.run_with("", "load far/s.scn\nunenvironment\nsky sun 30 3 180\nsave b.scn\nstop\n");
    assert!(sandbox.read("b.scn").contains("daylight 30 3 180"), "{}", sandbox.read("b.scn"));
    sandbox.run("render b.scn -o b.png --size 8x6 --quiet").fine();
    let [r, _, b] = corner("b.png");
    assert!(b > r, "{r} {b}");
    for (file, cause) in [("none.hdr", "none.hdr"), ("s.scn", "neither a Radiance picture")] {
        sandbox.write("far/bad.scn", format!("environment {file}\nprm ball\n"));
        let said = sandbox.run("check far/bad.scn");
        assert_eq!(said.code, Some(1), "{}", said.out);
        assert!((said.out + &said.err).contains(cause), "{cause}");
    }
}

#[test]
fn frames_and_shards_belong_to_the_pictures_that_they_show() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("far")).unwrap();
    let paint = |color: [u8; 3]| {
        image::RgbImage::from_pixel(2, 2, image::Rgb(color)).save(sandbox.path("far/t.png")).unwrap();
    };
    sandbox.write(
        "far/s.scn",
        "set size 40x40\nprm ball\ntexture color t.png\nambient 1\ndiffuse 0\nspecular 0\n",
    );
    paint([255, 0, 0]);
    let animate = || sandbox.run("animate far/s.scn --turntable 2 -o frames").fine();
    animate();
    let red = std::fs::read(sandbox.path("frames/frame_0000.png")).unwrap();
    assert!(animate().contains("2 kept from before"));
    assert_eq!(std::fs::read(sandbox.path("frames/frame_0000.png")).unwrap(), red);
    sandbox.run("render far/s.scn --shard 1/2 -o one.part --quiet").fine();
    paint([0, 255, 0]);
    animate();
    assert_ne!(std::fs::read(sandbox.path("frames/frame_0000.png")).unwrap(), red);
    sandbox.run("render far/s.scn --shard 2/2 -o two.part --quiet").fine();
    let report = sandbox.run("merge one.part two.part -o a.png").failed(2);
    assert!(report.contains("the scene"), "{report}");
}

#[test]
fn textures_are_found_beside_the_scene_and_missing_ones_are_faults() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("far")).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0])).save(sandbox.path("far/red.png")).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([0, 255, 0])).save(sandbox.path("far/green.jpg")).unwrap();
    let text = "set size 32x24\nprm ball\ntexture color red.png\nambient 1\ndiffuse 0\nspecular 0\n";
    sandbox.write("far/s.scn", text);
    let middle = |name: &str| picture(&sandbox, name).to_rgb8().get_pixel(16, 12).0;
    sandbox.run("render far/s.scn -o a.png --quiet").fine();
    assert_eq!(middle("a.png"), [255, 0, 0]);
    // Saved and loaded again it is the same scene.
    sandbox.run_with("", "load far/s.scn\nsave far/b.scn\nstop\n");
    assert!(sandbox.read("far/b.scn").contains("setTexture color \"red.png\" 1 around"));
    sandbox.run("render far/b.scn -o b.png --quiet").fine();
    assert_eq!(middle("b.png"), [255, 0, 0]);
    sandbox.write("far/g.scn", text.replace("red.png", "green.jpg .5 box"));
    sandbox.run("render far/g.scn -o g.png --quiet").fine();
    let [r, g, b] = middle("g.png");
    assert!(r < 40 && g > 200 && b < 40);
    sandbox.write("far/n.scn", text.to_owned() + "texture color none\n");
    sandbox.run("render far/n.scn -o n.png --quiet").fine();
    assert_eq!(middle("n.png"), [255; 3]);
    for (file, cause) in [("none.png", "none.png"), ("s.scn", "is no texture")] {
        sandbox.write("far/bad.scn", format!("prm ball\ntexture color {file}\n"));
        let said = sandbox.run("check far/bad.scn");
        assert_eq!(said.code, Some(1), "{}", said.out);
        assert!((said.out + &said.err).contains(cause), "{cause}");
    }
}

#[test]
fn pictures_that_only_keys_name_are_looked_for() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("far")).unwrap();
    image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0])).save(sandbox.path("far/red.png")).unwrap();
    let material = "ambient 1\ndiffuse 0\nspecular 0\n";
    let good =
        format!("set size 32x24\nprm ball\n{material}texture color red.png\nkey 0 texture color red.png 2\n");
    sandbox.write("far/good.scn", &good);
    sandbox.run("check far/good.scn").fine();
    // The line changes nothing: the texture and the key before it stay.
    for (line, cause) in [
        ("key 0 texture color none.png 3", ":8:21: error[unreadable]: a texture of the scene is missing"),
        ("key 4 texture bump good.scn 2 box 1", ":8:20: error[unreadable]: 'far/good.scn' is no texture"),
        (
            "key 2 environment \"none at all.hdr\" 2",
            ":8:19: error[unreadable]: the scene's environment is missing",
        ),
        ("texture color none.png", ":8:15: error[unreadable]: a texture of the scene is missing"),
        ("environment none.hdr", ":8:13: error[unreadable]: the scene's environment is missing"),
    ] {
        sandbox.write("far/bad.scn", format!("{good}{line}\n"));
        for command in ["check far/bad.scn", "render far/bad.scn --frame 0 -o a.png"] {
            let said = sandbox.run(command).failed(1);
            assert!(said.contains(&format!("far/bad.scn{cause}")), "{command}: {said}");
            // The name of a file that is there need not be corrected.
            let help = if cause.ends_with("missing") {
                "help: correct the name, or put the file there"
            } else {
                "help: correct the file, or name another one"
            };
            assert!(said.contains(help), "{said}");
        }
        assert_eq!(picture(&sandbox, "a.png").to_rgb8().get_pixel(16, 12).0, [255, 0, 0], "{line}");
    }
    // A binary scene has the same lines.
    sandbox.run_with("", "load far/good.scn\nsave far/good.sqb\nstop\n");
    sandbox.run("check far/good.sqb").fine();
    std::fs::rename(sandbox.path("far/red.png"), sandbox.path("far/blue.png")).unwrap();
    let said = sandbox.run("check far/good.sqb").failed(1);
    assert_eq!(said.matches("error[unreadable]").count(), 2, "{said}");
}

#[test]
fn files_are_found_beside_the_scene_that_names_them() {
    let sandbox = Sandbox::new();
    for folder in ["top", "lib", "lib/deep", "other"] {
        std::fs::create_dir(sandbox.path(folder)).unwrap();
    }
    let red = image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0]));
    red.save(sandbox.path("lib/deep/red.png")).unwrap();
    // Another file of that name, which nobody means.
    image::RgbImage::from_pixel(2, 2, image::Rgb([0, 0, 255])).save(sandbox.path("top/red.png")).unwrap();
    let mut grey = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n".to_vec();
    grey.extend([128, 64, 128, 128].repeat(2));
    sandbox.write("lib/grey.hdr", &grey);
    let material = "ambient 1\ndiffuse 0\nspecular 0\n";
    sandbox.write("lib/deep/ball.scn", format!("prm ball\ntexture color red.png\n{material}"));
    sandbox.write(
        "lib/b.scn",
        "load deep/ball.scn\nenvironment grey.hdr\nset encoding linear\nset size 32x24\n",
    );
    let size = "set encoding linear\nset size 32x24\n";
    sandbox.write("top/load.scn", "load ../lib/b.scn\n");
    sandbox.write(
        "top/include.scn",
        format!("include ../lib/b.scn\ninclude ../lib/deep/plain.scn\nprm ball\n{size}"),
    );
    sandbox.write("lib/deep/plain.scn", "prm plain\n");
    sandbox.write("top/key.scn", "include ../lib/deep/key.scn\nprm ball\nset size 32x24\n");
    sandbox.write("lib/deep/key.scn", format!("prm ball\n{material}key 0 texture color red.png 1\n"));
    let pixel = |name: &str, x, y| picture(&sandbox, name).to_rgb8().get_pixel(x, y).0;
    let check = |scene: &str| {
        sandbox.run(&format!("render {scene} -o a.png --quiet")).fine();
        assert_eq!((pixel("a.png", 16, 12), pixel("a.png", 0, 0)), ([255, 0, 0], [128, 64, 128]), "{scene}");
    };
    check("top/load.scn");
    // A prompt loads from its folder, and saves into that of the file.
    for (load, save) in [
        ("top/load.scn", "other/a.scn"),
        ("top/load.scn", "lib/deep/a.scn"),
        ("lib/b.scn", "b.scn"),
        ("other/a.scn", "other/b.sqb"),
        ("other/b.sqb", "top/c.scn"),
    ] {
        sandbox.run_with("", &format!("load {load}\nrender {save}.png --wait\nsave {save}\nstop\n"));
        check(save);
    }
    assert!(sandbox.read("lib/deep/a.scn").contains("\"red.png\""), "{}", sandbox.read("lib/deep/a.scn"));
    assert!(sandbox.read("other/a.scn").contains("\"../lib/grey.hdr\""), "{}", sandbox.read("other/a.scn"));
    assert!(sandbox.read("b.scn").contains("\"lib/deep/red.png\""), "{}", sandbox.read("b.scn"));
    sandbox.run("render top/include.scn -o i.png --quiet").fine();
    assert_eq!(pixel("i.png", 16, 12), [255, 0, 0]);
    sandbox.run("render top/key.scn --frame 0 -o k.png --quiet").fine();
    assert_eq!(pixel("k.png", 16, 12), [255, 0, 0]);
    // A name beside the outer scene alone is a fault of the inner one.
    sandbox.write("top/blue.scn", "load ../lib/blue.scn\n");
    std::fs::rename(sandbox.path("top/red.png"), sandbox.path("top/blue.png")).unwrap();
    sandbox.write("lib/blue.scn", "prm ball\ntexture color blue.png\n");
    let said = sandbox.run("check top/blue.scn");
    assert_eq!(said.code, Some(1), "{}", said.out);
}

#[test]
fn a_name_keeps_meaning_its_file_in_every_working_folder() {
    let sandbox = Sandbox::new();
    for folder in ["top", "other", "other/deep"] {
        std::fs::create_dir(sandbox.path(folder)).unwrap();
    }
    let red = image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0]));
    red.save(sandbox.path("tile.png")).unwrap();
    let blue = image::RgbImage::from_pixel(2, 2, image::Rgb([0, 0, 255]));
    for name in ["other/tile.png", "other/deep/own tile.png"] {
        blue.save(sandbox.path(name)).unwrap();
    }
    let ball = "set size 32x24\nprm ball\nambient 1\ndiffuse 0\nspecular 0\n";
    sandbox.write("other/deep/ball.scn", format!("{ball}texture color \"own tile.png\"\n"));
    let lines = "texture color tile.png\nrender a.png\ncd other\nrender b.png\ntexture color tile.png # blue\nrender c.png\n\
        save deep/blue\nundo\nrender d.png\nkey 0 texture color tile.png 2\nsave deep/red\nsave --history deep/typed\ncd ..\n\
        save top/red\nsave here\ncd other\nload deep/ball\ncd deep\nrender e.png\ncd ../../top\nsave loaded\nstop\n";
    sandbox.run_with("", &format!("{ball}{lines}")).fine();
    let middle = |name: &str| picture(&sandbox, name).to_rgb8().get_pixel(16, 12).0;
    let (red, blue) = ([255, 0, 0], [0, 0, 255]);
    for (name, color) in
        [("a", red), ("other/b", red), ("other/c", blue), ("other/d", red), ("other/deep/e", blue)]
    {
        assert_eq!(middle(&format!("{name}.png")), color, "{name}");
    }
    for (scene, color, name) in [
        ("other/deep/blue", blue, "color \"../tile.png\""),
        ("other/deep/red", red, "color \"../../tile.png\""),
        ("other/deep/red", red, "key 0 setTexture color ../tile.png 2"),
        ("other/deep/typed", red, "texture color \"../../tile.png\"\n"),
        ("other/deep/typed", red, "key 0 texture color \"../tile.png\" 2\n"),
        ("top/red", red, "color \"../tile.png\""),
        ("here", red, "key 0 setTexture color other/tile.png 2"),
        ("top/loaded", blue, "color \"../other/deep/own tile.png\""),
    ] {
        let text = sandbox.read(&format!("{scene}.scn"));
        assert!(text.contains(name), "{scene}: {name}: {text}");
        sandbox.run(&format!("render {scene}.scn -o r.png --quiet")).fine();
        assert_eq!(middle("r.png"), color, "{scene}");
    }
    // A file that is not there cannot be found from another folder, either.
    for save in ["save top/none", "save --history top/none", "save top/none.sqb"] {
        let said = sandbox.run_with("", &format!("prm ball\ntexture color none.png\n{save}\nstop\n")).fine();
        assert!(said.contains("warning: the scene names 'none.png', which is not found"), "{save}: {said}");
    }
}

#[test]
fn backslashes_separate_folders_where_no_file_has_them() {
    let sandbox = Sandbox::new();
    for folder in ["far", "far/tiles", "near"] {
        std::fs::create_dir(sandbox.path(folder)).unwrap();
    }
    let tile = |name: &str, color: [u8; 3]| {
        image::RgbImage::from_pixel(2, 2, image::Rgb(color)).save(sandbox.path(name)).unwrap();
    };
    let (red, blue) = ([255, 0, 0], [0, 0, 255]);
    tile("far/tiles/red.png", red);
    let text = "set size 32x24\nprm ball\nambient 1\ndiffuse 0\nspecular 0\ntexture color tiles\\red.png\n";
    sandbox.write("far/s.scn", text);
    sandbox.write("include.scn", "include far\\s.scn\nprm ball\nset size 32x24\n");
    sandbox.write("load.scn", "load far\\s.scn\n");
    let check = |scene: &str, color: [u8; 3]| {
        sandbox.run(&format!("render {scene} -o a.png --quiet")).fine();
        assert_eq!(picture(&sandbox, "a.png").to_rgb8().get_pixel(16, 12).0, color, "{scene}");
    };
    for scene in ["far/s.scn", "include.scn", "load.scn"] {
        check(scene, red);
    }
    // The saved names are found from the folder of the saved scene.
    sandbox.run_with("", "load far\\s\ncd near\nsave near\nstop\n").fine();
    check("near/near.scn", red);
    assert!(
        sandbox.read("near/near.scn").contains("\"../far/tiles/red.png\""),
        "{}",
        sandbox.read("near/near.scn")
    );
    sandbox.write("far/none.scn", text.replace("red", "none"));
    let said = sandbox.run("check far/none.scn").failed(1);
    assert!(said.contains("cannot read './tiles\\none.png'"), "{said}");
    // A file that has the name as written comes first, and keeps it.
    if cfg!(unix) {
        tile("far/tiles\\red.png", blue);
        check("far/s.scn", blue);
        sandbox.run_with("", "load far/s\nsave near/near\nstop\n").fine();
        check("near/near.scn", blue);
    }
}
