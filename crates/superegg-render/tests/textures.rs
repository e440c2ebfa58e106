//! Textures and noise on surfaces.

use superegg_lang::load_text;
use superegg_render::{Film, Output, RenderOptions, RenderSettings, TexturePixels, TextureSet, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

fn scene(text: &str) -> Scene {
    let (session, diagnostics) = load_text("textures.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    session.scene().clone()
}

/// A Radiance picture of these linear greys, row by row; exact for powers of two.
fn picture(width: usize, greys: &[f64]) -> Vec<u8> {
    let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {width}\n", greys.len() / width);
    let mut bytes = head.into_bytes();
    for grey in greys {
        let exponent = grey.log2().floor() as i32 + 1;
        let mantissa = (grey / f64::from(exponent).exp2() * 256.0) as u8;
        bytes.extend([mantissa, mantissa, mantissa, (exponent + 128) as u8]);
    }
    bytes
}

fn film(text: &str, file: &[u8], output: Output) -> Film {
    let scene = scene(text);
    let compiled = CompiledScene::compile(&scene, Some("shape"), 1);
    let picture = Picture { width: 48, height: 48, ..scene.picture };
    let textures = TextureSet::of(&scene, |_, _| TexturePixels::of_file(file, true)).unwrap();
    let settings =
        RenderSettings::of(&scene).with_picture(picture).with_output(output).with_textures(textures);
    render(&compiled, &settings, &RenderOptions::default()).unwrap().film
}

fn grey(film: &Film, x: u32, y: u32) -> f64 {
    f64::from(film.pixel(x, y).unwrap().color[0])
}

#[test]
fn a_texture_lies_around_a_shape_and_is_tinted_by_the_colour() {
    // Four quarters, the bottom half darker.
    let file = picture(4, &[1.0, 0.5, 0.25, 0.125, 0.0625, 0.0625, 0.0625, 0.0625]);
    for (position, quarter) in [("5 0 0", 0.375), ("0 5 0", 0.1875), ("0 -5 0", 0.75)] {
        let text = format!(
            "up z\nset samples 1\nprm shape\ncolor 1 .5 1\ntexture color a.hdr\ncamera {position} 0 0 0 30\n"
        );
        let film = film(&text, &file, Output::Albedo);
        // The centre is on the equator between both halves; above it the picture's upper row.
        let above = grey(&film, 24, 12);
        assert!(above > 0.4 * quarter && above < 1.6 * quarter, "{position}: {above}");
        // The lower row, with a little of the upper one.
        let below = grey(&film, 24, 36);
        assert!((0.06..0.0625 + 0.15 * quarter).contains(&below), "{position}: {below}");
        let pixel = film.pixel(24, 12).unwrap();
        assert!((pixel.color[1] - 0.5 * pixel.color[0]).abs() < 1e-6 && pixel.albedo == pixel.color);
    }
    // Half the size repeats it.
    let text = "up z\nset samples 1\nprm shape\ntexture color a.hdr .5\ncamera 5 0 0 0 0 0 30\n";
    assert!(grey(&film(text, &file, Output::Albedo), 24, 36) > 0.15);
}

#[test]
fn a_box_has_the_picture_on_every_side_and_far_ones_blend() {
    let file = picture(2, &[1.0, 0.25, 0.25, 1.0]);
    let text = |scale: &str, distance: f64| {
        format!(
            "set samples 4\nprm shape\nexp .02 .02\ntexture color a.hdr {scale} box\ncamera 0 0 {distance} 0 0 0 30\n"
        )
    };
    // The whole side is one picture of 2 units.
    let near = film(&text("2", 5.0), &file, Output::Albedo);
    assert!(grey(&near, 14, 14) > 0.8 && grey(&near, 34, 14) < 0.4, "{}", grey(&near, 14, 14));
    // Fine pictures are their mean, whatever the samples.
    let fine = film(&text("0.001", 5.0), &file, Output::Albedo);
    for (x, y) in [(20, 20), (24, 30), (31, 17)] {
        assert!((grey(&fine, x, y) - 0.625).abs() < 1e-3);
    }
}

#[test]
fn a_roughness_of_one_value_is_that_of_the_material() {
    let file = picture(1, &[0.25]);
    let text = |line: &str| {
        format!(
            "set samples 4\nset light path\nsky .2 .3 .4 .9 .9 1\nprm shape\nmetallic 1\n{line}\nfloor -1\n"
        )
    };
    let textured = film(&text("texture roughness a.hdr"), &file, Output::Light);
    let plain = film(&text("roughness 0.25"), &file, Output::Light);
    assert_eq!(textured.colors(), plain.colors());
    assert_ne!(film(&text("roughness 0.5"), &file, Output::Light).colors(), plain.colors());
}

#[test]
fn floors_have_textures_and_layers_change_no_light() {
    let file = picture(2, &[1.0, 0.25, 0.25, 1.0]);
    let text = "set samples 2\nprm ground\ntexture color a.hdr 2\nprm shape\ntexture color a.hdr\nfloor -1 ground\nlight l 4 9 5 1 1 1\n\
        camera 0 2 6 0 0 0 40\n";
    let with = film(text, &file, Output::Light);
    let scene = scene(text);
    let textures = TextureSet::of(&scene, |_, _| TexturePixels::of_file(&file, true)).unwrap();
    let compiled = CompiledScene::compile(&scene, Some("shape"), 1);
    let picture = Picture { width: 48, height: 48, ..scene.picture };
    let settings =
        RenderSettings::of(&scene).with_picture(picture).with_layers(false).with_textures(textures);
    let without = render(&compiled, &settings, &RenderOptions::default()).unwrap().film;
    assert_eq!(with.colors(), without.colors());
    let plain = render(&compiled, &settings.with_textures(TextureSet::default()), &RenderOptions::default());
    assert_ne!(plain.unwrap().film.colors(), with.colors());
    let albedos: Vec<f32> = with.pixels().map(|pixel| pixel.albedo[0]).collect();
    assert!(albedos.iter().any(|grey| *grey > 0.9) && albedos.iter().any(|grey| *grey > 0.2 && *grey < 0.3));
}

#[test]
fn a_texture_that_is_missing_leaves_its_surface_plain() {
    let file = picture(2, &[1.0, 0.25, 0.25, 1.0]);
    let of = |lines: &str| scene(&format!("prm ground\n{lines}prm shape\ntexture color here.hdr\n"));
    let both = of("texture color gone.hdr\ntexture roughness here.hdr\n");
    let pixels = std::sync::Arc::new(TexturePixels::of_file(&file, true).unwrap());
    let available = |scene: &Scene| {
        TextureSet::available(scene, |texture, _| (&*texture.file == "here.hdr").then(|| pixels.clone()))
    };
    // As a scene that does not name the missing one.
    let named = of("texture roughness here.hdr\n");
    let read = |scene: &Scene| TextureSet::of(scene, |_, _| TexturePixels::of_file(&file, true)).unwrap();
    assert_eq!(available(&both), read(&named));
    assert_ne!(available(&both), read(&both));
    assert!(TextureSet::available(&both, |_, _| None).is_empty() && !available(&both).is_empty());
}

#[test]
fn noise_has_the_same_shade_from_every_side_and_blends_from_afar() {
    for pattern in ["noise", "marble", "wood"] {
        let text = |distance: f64, fov: f64| {
            format!(
                "set samples 1\nprm shape\npattern {pattern} 0 0 0 .3\ncamera 0 0 {distance} 0 0 0 {fov}\n"
            )
        };
        let shades = |film: &Film| -> Vec<f64> {
            film.pixels()
                .filter(|pixel| pixel.depth.is_finite())
                .map(|pixel| f64::from(pixel.color[0]))
                .collect()
        };
        let near = shades(&film(&text(5.0, 20.0), &[], Output::Albedo));
        let spread = |shades: &[f64]| {
            let mean = shades.iter().sum::<f64>() / shades.len() as f64;
            shades.iter().map(|shade| (shade - mean).powi(2)).sum::<f64>() / shades.len() as f64
        };
        assert!(spread(&near) > 1e-3 && near.iter().all(|shade| (0.0..=1.0).contains(shade)), "{pattern}");
        // A ball of a few pixels.
        let far = shades(&film(&text(50.0, 60.0), &[], Output::Albedo));
        assert!(spread(&far) < 0.5 * spread(&near) && far.len() > 1, "{pattern}");
        let same = shades(&film(&text(5.0, 20.0), &[], Output::Albedo));
        assert_eq!(near, same);
    }
}
