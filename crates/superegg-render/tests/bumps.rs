//! Bumps on surfaces: which way they turn the normal, and that they add no light.

use std::io::Cursor;

use superegg_lang::load_text;
use superegg_render::{Film, Output, RenderOptions, RenderSettings, TexturePixels, TextureSet, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

const SIZE: u32 = 32;

fn scene(text: &str) -> Scene {
    let (session, diagnostics) = load_text("bumps.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    session.scene().clone()
}

/// A PNG of 16 bits with these heights from 0 to 1, from the top.
fn picture(width: u32, height: u32, value: impl Fn(u32, u32) -> f64) -> Vec<u8> {
    let pixel = |x, y| image::Luma([(65535.0 * value(x, y)).round() as u16]);
    let mut png = Vec::new();
    let picture = image::ImageBuffer::from_fn(width, height, pixel);
    image::DynamicImage::ImageLuma16(picture)
        .write_to(&mut Cursor::new(&mut png), image::ImageFormat::Png)
        .unwrap();
    png
}

/// Heights that rise from left to right.
fn ramp() -> Vec<u8> {
    picture(64, 64, |x, _| (f64::from(x) + 0.5) / 64.0)
}

/// Rough heights without an order.
fn rough() -> Vec<u8> {
    picture(32, 32, |x, y| f64::from((x * 7919 + y * 104_729 + x * y * 31) % 97) / 96.0)
}

fn film(text: &str, file: &[u8], output: Output) -> Film {
    let scene = scene(text);
    let compiled = CompiledScene::compile(&scene, Some("shape"), 1);
    let picture = Picture { width: SIZE, height: SIZE, ..scene.picture };
    let textures =
        TextureSet::of(&scene, |_, channel| TexturePixels::of_file(file, channel.word() == "color")).unwrap();
    let settings =
        RenderSettings::of(&scene).with_picture(picture).with_output(output).with_textures(textures);
    render(&compiled, &settings, &RenderOptions::default()).unwrap().film
}

/// The normal at a pixel of a picture of normals.
fn normal(film: &Film, x: u32, y: u32) -> [f64; 3] {
    film.pixel(x, y).unwrap().color.map(|part| 2.0 * f64::from(part) - 1.0)
}

fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64, what: &str) {
    let length = expected.iter().map(|part| part * part).sum::<f64>().sqrt();
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected / length).abs() < tolerance, "{what}: {found} {}", expected / length);
    }
}

#[test]
fn flat_pictures_change_no_bit() {
    let flat = picture(8, 8, |_, _| 0.7);
    for model in ["course", "path"] {
        let text = |line: &str| {
            format!(
                "set samples 4\nset light {model}\nlight l 4 9 5 1 1 1\nsky .2 .3 .4 .9 .9 1\nprm ground\n{line}\nprm shape\n{line}\n\
                reflected .2\nfloor -1 ground\n"
            )
        };
        for line in ["setTexture bump a.png 1 around 3", "setTexture bump a.png 0.3 box"] {
            let with = film(&text(line), &flat, Output::Light);
            assert_eq!(with.colors(), film(&text(""), &flat, Output::Light).colors(), "{model} {line}");
        }
        // Nor has one without a height.
        let with = film(&text("setTexture bump a.png 1 box 0"), &ramp(), Output::Light);
        assert_eq!(with.colors(), film(&text(""), &flat, Output::Light).colors());
        assert_ne!(
            film(&text("setTexture bump a.png 1 box 1"), &ramp(), Output::Light).colors(),
            with.colors()
        );
    }
}

#[test]
fn a_ramp_turns_the_normal_by_its_slope() {
    // Sides that the camera sees head on, the way to the right there, and the way up.
    let sides = [
        ("5 0 0", "0 0 1", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ("-5 0 0", "0 0 1", [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]),
        ("0 5 0", "0 0 1", [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]),
        ("0 -5 0", "0 0 1", [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
        ("0 0 5", "0 1 0", [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        ("0 0 -5", "0 1 0", [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]),
    ];
    for (camera, up, facing, right) in sides {
        for (scale, height, slope) in
            [(4.0, 1.0, 0.25), (4.0, 2.0, 0.5), (8.0, 2.0, 0.25), (4.0, -4.0, -1.0), (4.0, 40.0, 10.0)]
        {
            let text = format!(
                "set samples 1\nprm shape\nexp 0 0\nsetTexture bump a.png {scale} box {height}\n\
                camera {camera} 0 0 0 15\ncameraUp {up}\n"
            );
            let film = film(&text, &ramp(), Output::Normal);
            let expected = std::array::from_fn(|i| facing[i] - slope * right[i]);
            for (x, y) in [(16, 16), (10, 20), (22, 9)] {
                let what = format!("{camera} {scale} {height}");
                // The picture has steps of 1/65535, and the film f32.
                assert_near(normal(&film, x, y), expected, 2e-3, &what);
            }
        }
    }
}

#[test]
fn transforms_carry_bumps_with_the_surface() {
    // A slope of 1 towards x on top of a box. Stretched along x it is half as steep; mirrored it rises the other way.
    for (transform, expected) in [
        ("", [-1.0, 0.0, 1.0]),
        ("scale 2 1 1", [-0.5, 0.0, 1.0]),
        ("scale 1 1 2", [-2.0, 0.0, 1.0]),
        ("scale -1 1 1", [1.0, 0.0, 1.0]),
        ("scale 1 -1 1", [-1.0, 0.0, 1.0]),
        ("rotate 0 0 1 90", [0.0, -1.0, 1.0]),
        ("scale 1e-9 1e-9 1e-9\nscale 1e9 1e9 1e9", [-1.0, 0.0, 1.0]),
    ] {
        let text = format!(
            "set samples 1\nprm box\nexp 0 0\nsetTexture bump a.png 4 box 4\nobj shape\naddPrimitive box\n{transform}\n\
            camera 0.1 0.1 5 0.1 0.1 0 3\ncameraUp 0 1 0\n"
        );
        assert_near(normal(&film(&text, &ramp(), Output::Normal), 16, 16), expected, 2e-3, transform);
    }
}

#[test]
fn light_on_a_ramp_is_that_of_its_normal_and_none_comes_from_below() {
    // A floor that rises by 1 towards x, under a sun of this elevation in degrees over x or -x.
    for (elevation, side) in
        [(80.0f64, 1.0), (80.0, -1.0), (30.0, 1.0), (30.0, -1.0), (1.0, -1.0), (-5.0, -1.0), (-60.0, -1.0)]
    {
        for (model, rough) in [("course", ""), ("path", ""), ("path", "roughness 1\nindex 1\n")] {
            let (sin, cos) = elevation.to_radians().sin_cos();
            let text = format!(
                "set samples 1\nset light {model}\nprm ground\ndiffuse 1\nspecular 0\nambient 0\n{rough}setTexture bump a.png 4 box 4\nfloor 0 ground 0 0 1\n\
                prm shape\ncoeff 1e-3 1e-3 1e-3\nsun s {} 0 {}  1 1 1\ncamera 0 -1 4 0 0.2 0 3\ncameraUp 0 1 0\n",
                cos * side,
                sin
            );
            let found = f64::from(film(&text, &ramp(), Output::Light).pixel(16, 10).unwrap().color[0]);
            let facing = (sin - cos * side) / 2f64.sqrt();
            // The tilt has a squared tangent of 1.
            let open = 2.0 / (1.0 + (1.0 + 0.125 * (cos / sin).powi(2)).sqrt());
            let expected = if sin > 0.0 { facing.max(0.0) * open } else { 0.0 };
            assert!(
                (found - expected).abs() < 5e-3,
                "{elevation} {side} {model} {rough}: {found} {expected}"
            );
        }
    }
}

/// Materials that reflect all light.
const WHITE: [(&str, &str); 6] = [
    ("matt", "diffuse 1"),
    ("mirror", "diffuse 0\nreflected 1"),
    ("glass", "diffuse 0\nreflected 1\nrefracted 1\nfresnel on"),
    ("metal", "metallic 1\nroughness 0.3"),
    ("varnish", "diffuse 1\nroughness 0.2"),
    ("rough glass", "refracted 1\nroughness 0.4"),
];

#[test]
fn a_white_surface_with_bumps_is_never_brighter_than_a_white_world() {
    for model in ["course", "path"] {
        for (name, lines) in WHITE {
            if model == "course" && lines.contains("roughness") {
                continue;
            }
            for (mapping, height) in [("1 around", 0.5), ("0.3 box", 0.02), ("0.3 box", 1.0)] {
                let text = format!(
                    "set samples 16\nset bounces 64\nset light {model}\nsky 1 1 1 1 1 1\nlight none 0 0 9 0 0 0\nprm shape\ncolor 1 1 1\nambient 0\nspecular 0\n{lines}\n\
                    setTexture bump a.png {mapping} {height}\ncamera 0 0 5 0 0 0 20\n"
                );
                let film = film(&text, &rough(), Output::Light);
                let greys: Vec<f64> = film.pixels().map(|pixel| f64::from(pixel.color[0])).collect();
                let mean = greys.iter().sum::<f64>() / greys.len() as f64;
                let what = format!("{model} {name} {mapping} {height}: {mean}");
                assert!(mean.is_finite() && greys.iter().all(|grey| *grey >= 0.0), "{what}");
                // Facets are drawn with some noise, and glass sends paths on by chance.
                let bound = if ["matt", "mirror"].contains(&name) { 1.0 + 1e-6 } else { 1.01 };
                assert!(mean <= bound, "{what}");
                match (model, name) {
                    // Neither does a mirror lose any, however steep: its rays leave a ball.
                    (_, "mirror") => assert!(greys.iter().all(|grey| (grey - 1.0).abs() < 1e-6), "{what}"),
                    ("course", "matt") => {}
                    // A gentle height loses little.
                    _ if height == 0.02 => assert!(mean > 0.8, "{what}"),
                    _ => assert!(mean > 0.2, "{what}"),
                }
            }
        }
    }
}

#[test]
fn bumps_move_no_surface_and_fade_from_afar() {
    let text = |line: &str, distance: f64| {
        format!(
            "set samples 4\nprm shape\n{line}\ncamera 0 0 {distance} 0 0 0 {}\nup z\n",
            2.4 * (1.0 / distance).atan().to_degrees()
        )
    };
    for line in ["setTexture bump a.png 1 around 1", "setTexture bump a.png 0.4 box 0.5"] {
        let (with, without) = (
            film(&text(line, 5.0), &rough(), Output::Normal),
            film(&text("", 5.0), &rough(), Output::Normal),
        );
        assert_ne!(with.colors(), without.colors());
        let same = |a: &Film, b: &Film| {
            a.pixels().zip(b.pixels()).all(|(a, b)| {
                a.depth == b.depth
                    || (a.depth - b.depth).abs() < 1e-4 * b.depth
                        && a.instance == b.instance
                        && a.samples == b.samples
            })
        };
        assert!(same(&with, &without), "{line}");
        // Fine bumps of the same steepness are smooth.
        let fine = line.replace(" 1 around 1", " 1e-4 around 1e-4").replace("0.4 box 0.5", "1e-4 box 1e-4");
        let fine = film(&text(&fine, 5.0), &rough(), Output::Normal);
        let difference = |film: &Film| {
            let pairs = film.colors().iter().zip(without.colors()).collect::<Vec<_>>();
            let sum: f64 = pairs.iter().map(|(a, b)| f64::from((a[0] - b[0]).abs())).sum();
            sum / pairs.len() as f64
        };
        assert!(
            difference(&fine) < 0.1 * difference(&with),
            "{line}: {} {}",
            difference(&fine),
            difference(&with)
        );
    }
}

#[test]
fn poles_have_finite_normals() {
    let text =
        "set samples 16\nprm shape\nsetTexture bump a.png 1 around 1\ncamera 0 0 1.001 0 0 0 1e-3\nup z\n";
    let film = film(text, &rough(), Output::Normal);
    for pixel in film.pixels() {
        let [x, y, z] = pixel.color.map(|part| 2.0 * part - 1.0);
        assert!((x * x + y * y + z * z - 1.0).abs() < 0.5 && z > 0.0, "{x} {y} {z}");
    }
}
