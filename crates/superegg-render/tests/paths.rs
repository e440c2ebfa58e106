//! Light by paths: pictures whose light is known in closed form, and laws of energy.

mod support;

use std::sync::Arc;

use superegg_geom::glam::DVec3;
use superegg_lang::load_text;
use superegg_render::{EnvironmentMap, EnvironmentPixels, Film, RenderOptions, RenderSettings, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

use crate::support::{centre, close, color, film, rendered};

/// The scene of a text, and what it selects last.
fn scene_of(text: &str) -> (Scene, String) {
    let (session, diagnostics) = load_text("known.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    (session.scene().clone(), session.selected().unwrap_or_default().to_owned())
}

/// The mean of the red channel.
fn mean(film: &Film, size: u32) -> f64 {
    let pixels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
    pixels.map(|(x, y)| f64::from(color(film, x, y)[0])).sum::<f64>() / f64::from(size * size)
}

const PATH: &str = "set light path\nlight off 0 0 9 0 0 0\n";

#[test]
fn in_a_white_world_white_surfaces_are_white_and_grey_ones_grey() {
    for (surface, expected) in [
        ("diffuse 1", 1.0),
        ("diffuse .25", 0.25),
        ("diffuse 1\nreflected .3", 1.0),
        ("diffuse .5\nreflected .4", 0.4 + 0.6 * 0.5),
        ("reflected 1\nfresnel on\ndiffuse 1", 1.0),
    ] {
        let text = format!(
            "{PATH}background 1 1 1\nprm s\nexp .3 .7\nspecular 0\n{surface}\ncamera 2 3 4 0 0 0 10\n"
        );
        let film = film(&text, 8);
        for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
            // One surface alone scatters each path once, so there is no noise.
            assert!((f64::from(color(&film, x, y)[0]) - expected).abs() < 1e-5, "{surface} {x} {y}");
        }
    }
}

#[test]
fn a_white_world_of_many_surfaces_is_white() {
    for surface in ["diffuse 1", "refracted 1", "refracted .5\ndiffuse 1", "reflected .5\ndiffuse 1"] {
        let text = format!(
            "{PATH}background 1 1 1\nprm s\nexp .3 .7\ncoeff .4 .4 .4\nspecular 0\n{surface}\n\
             prm star\nexp 3 3\nspecular 0\ndiffuse 1\nobj all\nap s\nxs .5 0 .4\nap s b\nxs -.5 .1 .3\nap star\n\
             floor -.5 star\ncamera 2 3 4 0 0 0 12\nup z\n"
        );
        let mean = mean(&rendered(&text, 16, 256, 2).film, 16);
        assert!((mean - 1.0).abs() < 3e-3, "{surface}: {mean}");
    }
}

#[test]
fn a_plane_under_a_sky_reflects_its_irradiance() {
    // The colour of the sky is linear in the sine s of the elevation: its mean over the cosine is that at s = 2/3.
    let text = "set light path\nlight off 0 0 9 0 0 0\nup z\nsky .1 .4 .2 .7 .1 .8\nprm s\ndiffuse .5\n\
                specular 0\nobj o\nfloor 0 s\ncamera 0 -1 4 0 0 0 20\n";
    let at = |horizon: f64, zenith: f64| 0.5 * (horizon + (zenith - horizon) * 2.0 / 3.0);
    let found = centre(&rendered(text, 1, 4096, 2).film);
    for (found, expected) in found.iter().zip([at(0.1, 0.7), at(0.4, 0.1), at(0.2, 0.8)]) {
        assert!((f64::from(*found) - expected).abs() < 2e-3, "{found} {expected}");
    }
}

#[test]
fn light_in_a_closed_sphere_is_a_geometric_series() {
    // A light in the centre shines straight onto the wall, which is lit by itself, too: r + r^2 + ...
    for reflectance in [0.2, 0.5, 0.8] {
        let text = format!(
            "set light path\nlight l 0 0 0 1 1 1 0\nprm s\nspecular 0\ndiffuse {reflectance}\n\
             camera 0 0 0.5 0 0 1 30\n"
        );
        let found = mean(&rendered(&text, 4, 1024, 2).film, 4);
        let expected = reflectance / (1.0 - reflectance);
        assert!((found / expected - 1.0).abs() < 2e-2, "{reflectance}: {found} {expected}");
    }
}

#[test]
fn a_coloured_wall_colours_its_neighbour() {
    // A red wall stands on a white floor: beside it the floor is redder than far from it.
    let text = "set light path\nlight off 0 0 9 0 0 0\nup z\nbackground 1 1 1\nprm wall\nexp .01 .01\n\
                coeff .1 4 2\ncolor 1 0 0\nspecular 0\ndiffuse 1\nprm ground\ndiffuse 1\nspecular 0\nobj o\nap wall\nxs 0 0 2\n\
                floor 0 ground\n";
    let ratio = |x: f64| {
        let [r, g, _] = centre(&rendered(&format!("{text}camera {x} -.1 3 {x} 0 0 .1\n"), 1, 4096, 2).film);
        f64::from(r) / f64::from(g)
    };
    let (near, far) = (ratio(0.3), ratio(30.0));
    assert!(near > 1.5 && far < 1.05, "{near} {far}");
    // A vertical wall of height h, long beside its distance d, takes (1 - cos(atan(h / d))) / 2 of the floor's view.
    assert!((ratio(0.15) - 1.97).abs() < 0.15);
}

#[test]
fn a_lone_convex_shape_under_a_lamp_is_as_in_the_model_of_the_course() {
    let scene = "prm s\nexp .4 .8\nambient 0\nspecular .3\ncamera 2 3 4 0 0 0 30\nlight l 4 1 6 1 1 1 0\n";
    let (course, path) = (film(scene, 24), film(&format!("set light path\n{scene}"), 24));
    for (x, y) in (0..24).flat_map(|y| (0..24).map(move |x| (x, y))) {
        close(color(&path, x, y), color(&course, x, y).map(f64::from));
    }
}

#[test]
fn a_sphere_that_shines_lights_by_its_solid_angle() {
    // A sphere of radius r and radiance L at height h lights the floor below with pi L (r / h)^2.
    let (radius, height, emission) = (0.5, 2.0, 3.0);
    let lit = |map: &str| {
        let text = format!(
            "set light path\nlight off 0 0 9 0 0 0\nup z\nprm lamp\ncoeff {radius} {radius} {radius}\nemission {emission}\n\
             diffuse 0\nspecular 0\nprm ground\ndiffuse .6\nspecular 0\nobj o\nap lamp\n{map}\nxs 0 0 {height}\n\
             floor 0 ground\ncamera 0 -1 .5 0 0 0 .1\n"
        );
        f64::from(centre(&rendered(&text, 1, 1 << 16, 2).film)[0])
    };
    let expected = 0.6 * emission * (radius / height) * (radius / height);
    for map in ["", "ss -1 1 1\nrs 1 2 3 40"] {
        let found = lit(map);
        assert!((found / expected - 1.0).abs() < 1e-2, "{map}: {found} {expected}");
    }
    // A flat disc of radius R at height h: L pi R^2 / (h^2 + R^2).
    let disc = 0.6 * emission / (height * height + 1.0);
    let found = lit("ss 2 2 .002");
    assert!((found / disc - 1.0).abs() < 1e-2, "{found} {disc}");
}

#[test]
fn inside_a_shape_that_shines_all_is_bright_as_it() {
    // A ball in a closed world of radiance 2 is a white furnace of that radiance.
    let text = "set light path\nlight off 0 0 9 0 0 0\nprm world\nexp .4 .6\ncoeff 4 4 4\nemission 2\ndiffuse 0\nspecular 0\n\
                prm ball\ndiffuse .5\nspecular 0\nobj o\nap world\nap ball\ncamera 0 0 3 0 0 0 30\n";
    let film = film(text, 8);
    for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
        assert!((color(&film, x, y)[0] - 1.0).abs() < 1e-5);
    }
}

#[test]
fn samples_of_emitters_change_the_noise_and_not_the_light() {
    // Two lamps, one of them a star with a pattern, seen directly, in a mirror and through glass.
    let scene = "set light path\nlight off 0 0 9 0 0 0\nup z\nprm lamp\nexp 3 2.5\ncoeff .6 .4 .5\nemission 5\npattern checker .2 .9 .1 .2\n\
                 specular 0\nprm disc\nexp 1 .3\ncoeff .4 .4 .1\nemission 8\ncolor .9 .5 .2\ndiffuse .3\nspecular 0\n\
                 prm glass\nrefracted .9\nspecular 0\nprm mirror\nreflected .8\nspecular 0\nprm ground\ndiffuse .7\nspecular 0\n\
                 obj o\nap lamp\nrs 1 2 3 40\nxs -1 0 1.5\nap disc\nrs 0 1 0 160\nxs 1 .3 2\nap glass\nss .5 .5 .5\nxs .4 -.6 .6\n\
                 ap mirror\nss .4 .4 .4\nxs -.8 -.8 .5\nfloor 0 ground\ncamera 0 -5 2 0 0 .8 40\n";
    // More instances than are sampled: a thousand lamps far away, behind the camera and below the floor.
    let mut many = String::from("prm far\nemission 1e-9\nobj block\n");
    for i in 0..1100 {
        many.push_str(&format!("ap far f{i}\nxs 0 -900 {}\n", -500 - 3 * i));
    }
    let unsampled = format!("{many}{scene}ao block\n");
    let light = |text: &str| mean(&rendered(text, 16, 1024, 2).film, 16);
    let (sampled, by_chance) = (light(scene), light(&unsampled));
    assert!((sampled / by_chance - 1.0).abs() < 0.02, "{sampled} {by_chance}");
}

#[test]
fn a_white_world_of_rough_surfaces_is_white() {
    for surface in [
        "metallic 1\nroughness .2",
        "metallic 1\nroughness 1",
        "metallic 1",
        "roughness .5",
        "metallic .3\nroughness .7\nindex 2",
        "refracted 1\nroughness .3",
        "refracted .5\nroughness .6\nindex 1.3",
    ] {
        let text = format!(
            "{PATH}background 1 1 1\nprm s\nexp .3 .7\ncoeff .4 .4 .4\ndiffuse 1\n{surface}\n\
             prm star\nexp 3 3\ndiffuse 1\nspecular 0\nobj all\nap s\nxs .5 0 .4\nap s b\nxs -.5 .1 .3\nap star\n\
             floor -.5 s\ncamera 2 3 4 0 0 0 12\nup z\n"
        );
        let mean = mean(&rendered(&text, 16, 256, 2).film, 16);
        assert!((mean - 1.0).abs() < 6e-3, "{surface}: {mean}");
    }
}

#[test]
fn a_rough_metal_shows_a_lamp_by_the_formula() {
    // Seen and lit head on: D / 4 = 1 / (4 pi alpha^2), and what further bounces give back: 0.175 of the light is lost once.
    let alpha: f64 = 0.36;
    let text = "set light path\nlight l 0 0 9 .8 .8 .8 0\nup z\nprm s\nmetallic 1\nroughness .6\nobj o\nfloor 0 s\n\
                camera 0 -.0001 4 0 0 0 .01\n";
    let found = f64::from(centre(&rendered(text, 1, 16, 2).film)[0]);
    let once = 0.8 / (4.0 * alpha * alpha);
    assert!(found > once && found < once * 1.1, "{found} {once}");
    // A coat of index 1.5 on black has 4 % of it.
    let coat = text.replace("metallic 1", "diffuse 0\nmetallic 0");
    let of_coat = f64::from(centre(&rendered(&coat, 1, 16, 2).film)[0]);
    assert!((of_coat / (0.04 * once) - 1.0).abs() < 0.02, "{of_coat}");
}

#[test]
fn both_ways_to_a_lamp_agree_for_rough_surfaces() {
    let scene = "set light path\nlight off 0 0 9 0 0 0\nup z\nprm lamp\nexp .7 1.2\ncoeff .6 .4 .5\nemission 5\nspecular 0\n\
                 prm metal\nmetallic 1\nroughness .35\ncolor .9 .7 .3\nprm glass\nrefracted 1\nroughness .4\n\
                 prm ground\nroughness .3\ndiffuse .7\nobj o\nap lamp\nrs 1 2 3 40\nxs 0 .2 1.9\nap metal\nss .5 .5 .5\nxs -.6 -.6 .5\n\
                 ap glass\nss .5 .5 .5\nxs .6 -.6 .6\nfloor 0 ground\ncamera 0 -5 2 0 0 .6 34\n";
    let mut many = String::from("prm far\nemission 1e-9\nobj block\n");
    for i in 0..1100 {
        many.push_str(&format!("ap far f{i}\nxs 0 -900 {}\n", -500 - 3 * i));
    }
    let unsampled = format!("{many}{scene}ao block\n");
    let light = |text: &str| mean(&rendered(text, 16, 512, 2).film, 16);
    let (sampled, by_chance) = (light(scene), light(&unsampled));
    assert!((sampled / by_chance - 1.0).abs() < 0.02, "{sampled} {by_chance}");
}

#[test]
fn a_picture_of_the_surroundings_lights_as_the_same_sky() {
    // One sky as a gradient and as a picture, over matt, metal and glass.
    let text = format!(
        "{PATH}up z\nsky .2 .3 .5 .9 .8 .6\nprm matt\ndiffuse .7\nspecular 0\nprm metal\nmetallic 1\nroughness .4\n\
         prm glass\nrefracted 1\nroughness .3\nprm clear\nrefracted 1\nspecular 0\nobj o\nap matt\nss .4 .4 .4\nxs -1 0 .4\nap metal\nss .4 .4 .4\nxs 0 0 .4\n\
         ap glass\nss .4 .4 .4\nxs 1 0 .4\nap clear\nss .3 .3 .3\nxs .5 -1 .3\nfloor 0 matt\ncamera 0 -5 2 0 0 .3 34\n"
    );
    let (scene, root) = scene_of(&text);
    let compiled = CompiledScene::compile(&scene, Some(&root), scene.depth);
    let picture = Picture { width: 16, height: 16, samples: 256, ..scene.picture };
    let gradient = RenderSettings::of(&scene).with_picture(picture);
    let (width, height) = (64, 512);
    let rows = (0..height).flat_map(|row| {
        let sin = (std::f64::consts::PI * (f64::from(row) + 0.5) / f64::from(height)).cos().max(0.0);
        let color = DVec3::new(0.2, 0.3, 0.5).lerp(DVec3::new(0.9, 0.8, 0.6), sin);
        std::iter::repeat_n((0.5 * color).as_vec3().to_array(), width)
    });
    let pixels = EnvironmentPixels::new(width, height as usize, rows.collect()).unwrap();
    let map = EnvironmentMap::new(Arc::new(pixels), scene.up(), 25.0, 2.0);
    let environment = gradient.environment.clone().with_map(map);
    let mapped = gradient.clone().with_environment(environment);
    let [a, b] = [gradient, mapped]
        .map(|settings| mean(&render(&compiled, &settings, &RenderOptions::default()).unwrap().film, 16));
    assert!((a / b - 1.0).abs() < 5e-3, "{a} {b}");
}

#[test]
fn a_small_sun_in_a_picture_lights_a_plane_by_its_solid_angle() {
    // One pixel near the zenith in a black picture.
    let text = "set light path\nlight off 0 0 9 0 0 0\nup z\nprm s\ndiffuse .5\nspecular 0\nobj o\nfloor 0 s\n\
                camera 0 -1 4 0 0 0 20\n";
    let (scene, root) = scene_of(text);
    let compiled = CompiledScene::compile(&scene, Some(&root), scene.depth);
    let picture = Picture { width: 2, height: 2, samples: 4096, ..scene.picture };
    let (width, height) = (256usize, 128usize);
    let mut colors = vec![[0.0; 3]; width * height];
    colors[40 * width + 17] = [1000.0; 3];
    let map = EnvironmentMap::new(
        Arc::new(EnvironmentPixels::new(width, height, colors).unwrap()),
        scene.up(),
        0.0,
        1.0,
    );
    let settings = RenderSettings::of(&scene).with_picture(picture);
    let environment = settings.environment.clone().with_map(map);
    let film =
        render(&compiled, &settings.with_environment(environment), &RenderOptions::default()).unwrap().film;
    let angle = std::f64::consts::PI * 40.5 / height as f64;
    let solid_angle =
        2.0 * (std::f64::consts::PI / height as f64) * (std::f64::consts::PI / width as f64) * angle.sin();
    let expected = 0.5 * 1000.0 * solid_angle * angle.cos() / std::f64::consts::PI;
    let found = mean(&film, 2);
    assert!((found / expected - 1.0).abs() < 1e-2, "{found} {expected}");
}
