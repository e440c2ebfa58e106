//! Pictures whose light is known.

mod support;

use superegg_render::Film;

use crate::support::{centre, close, color, difference, film, rendered};

#[test]
fn a_sphere_seen_along_its_normal_has_the_light_of_the_formula() {
    // Light and eye in one direction: N.L = N.H = 1, at distance 3 from the surface point.
    let text = "prm s\ncolor 1 .5 0\nambient .2\ndiffuse .6\nspecular .3\nlight l 0 0 4 1 1 .5 .1\ncamera 0 0 10 0 0 0\n";
    let light = 1.0 / (1.0 + 0.1 * 9.0);
    let expected = [0.2 + light * 0.9, 0.1 + light * 0.6, 0.5 * light * 0.3];
    close(centre(&film(text, 1)), expected);
}

#[test]
fn the_highlight_has_the_exponent_of_gloss_or_the_one_given() {
    // The light is 60 degrees off the normal, so H is 30 degrees off: N.H = cos 30.
    let base = "prm s\nambient 0\ndiffuse 0\nspecular 1\nlight l 86602540.37844387 0 50000001\n";
    let n_h = 30f64.to_radians().cos();
    for (setting, exponent) in [("gloss .3", 2.0 / 0.09 - 2.0), ("gloss 1", 0.0), ("shininess 5", 5.0)] {
        let expected = n_h.powf(exponent);
        let value = f64::from(centre(&film(&format!("{base}{setting}\n"), 1))[0]);
        assert!((value - expected).abs() < 1e-5, "{setting}: {value} {expected}");
    }
}

#[test]
fn a_shadow_is_only_ambient() {
    let floor = "prm floor\ncoeff 9 9 .5\nexp .01 .01\nambient .25\nprm ball\nobj o\nap floor\nxs 0 0 -.5\n";
    let camera = "camera 3 0 6 0 0 0\nlight l 0 0 8\n";
    let lit = centre(&film(&format!("{floor}{camera}"), 1));
    let shadowed = centre(&film(&format!("{floor}ap ball\nxs 0 0 4\n{camera}camera 6 0 2 0 0 0\n"), 1));
    assert!(lit[0] > 0.9);
    close(shadowed, [0.25; 3]);
}

#[test]
fn the_default_light_is_there_only_while_none_is_named() {
    let lit = centre(&film("prm s\nambient 0\n", 1));
    let dark = centre(&film("prm s\nambient 0\nlight off 0 0 9 0 0 0\n", 1));
    let lit_again = centre(&film("prm s\nambient 0\nlight off 0 0 9 0 0 0\nunlight off\n", 1));
    assert!(lit[0] > 0.1 && dark == [0.0; 3] && lit_again == lit);
}

#[test]
fn glass_of_index_one_is_not_seen() {
    let behind = "background .2 .4 .6\nprm ball\ncolor 1 0 0\nambient 1\ndiffuse 0\nspecular 0\nprm pane\nexp .3 .7\ncoeff 2 2 1\nspecular 0\nrefracted 1\nindex 1\nobj o\nap ball\nxs 0 0 -4\n";
    let without = film(behind, 40);
    let with = film(&format!("{behind}ap pane\n"), 40);
    // But for the silhouette, where a ray may graze.
    let pixels = (0..40).flat_map(|y| (0..40).map(move |x| (x, y)));
    let different = pixels.filter(|&(x, y)| {
        color(&with, x, y).iter().zip(color(&without, x, y)).any(|(a, b)| (a - b).abs() > 2e-3)
    });
    assert_eq!(different.count(), 0);
}

#[test]
fn clear_glass_and_mirrors_in_a_white_world_are_white() {
    for surface in [
        "refracted 1",
        "reflected 1",
        "refracted .5\nreflected .5",
        "refracted 1\nindex 2.4",
        "reflected 1\nrefracted 1",
    ] {
        for shape in ["exp 1 1", "exp .2 .2", "exp 2 2", "exp 3 .5"] {
            let text = format!(
                "background 1 1 1\nprm s\n{shape}\nspecular 0\n{surface}\nlight l 5 5 5\ncamera 2 3 4 0 0 0 40\n"
            );
            let film = film(&text, 24);
            let white = Film::new(24, 24);
            let least = (0..24)
                .flat_map(|y| (0..24).map(move |x| (x, y)))
                .map(|(x, y)| color(&film, x, y)[0])
                .fold(2.0, f32::min);
            assert!(difference(&film, &white) <= 1.0001 && least > 0.98, "{surface} {shape}: {least}");
        }
    }
}

#[test]
fn energy_that_goes_out_is_never_more_than_came_in() {
    let text = "background 1 1 1\nprm s\nexp .5 .5\nambient 0\ndiffuse 1\nspecular 0\nreflected .4\nrefracted .4\nlight off 0 0 0 0 0 0\nobj o\nap s\nap s b\nxs 1 .5 0\n";
    let film = film(text, 32);
    assert!(difference(&film, &Film::new(32, 32)) <= 1.0001);
}

#[test]
fn a_flat_mirror_shows_what_is_before_it_at_its_own_angle() {
    // A mirror in the plane z = 0 at 45 degrees to the ray: the reflected ray hits a sphere.
    let text = "prm mirror\ncoeff 5 5 1\nexp .0001 .0001\nambient 0\ndiffuse 0\nspecular 0\nreflected 1\nprm ball\ncolor 0 1 0\nambient 1\ndiffuse 0\nspecular 0\n\
        obj o\nap mirror\nxs 0 0 -1\nap ball\nxs -4 0 4\ncamera 4 0 4 0 0 0\n";
    close(centre(&film(text, 1)), [0.0, 1.0, 0.0]);
}

const ROOM: &str = "prm ball\ncolor .9 .3 .2\nreflected .2\nprm star\nexp 3 2.5\ncolor .3 .5 .9\nprm glass\nexp .7 1\nrefracted .8\nprm floor\n\
    coeff 8 8 .25\nexp .1 .1\nreflected .3\nobj room\nap floor\nxs 0 0 -1.25\nap ball\nxs -1.5 1 0\nap star\nrs 1 1 0 30\nxs 1.5 1 0\nap glass\nxs 0 -1.5 0\n";

fn room(scale: f64) -> String {
    let at = |x: f64, y: f64, z: f64| format!("{} {} {}", x * scale, y * scale, z * scale);
    format!(
        "{ROOM}sall {scale} {scale} {scale}\nlight a {} 1 1 1 {}\ncamera {} {} 45\ncameraUp 0 0 1\n",
        at(4.0, -3.0, 6.0),
        0.02 / (scale * scale),
        at(2.0, -8.0, 4.0),
        at(0.0, 0.0, 0.0)
    )
}

#[test]
fn a_scene_of_another_size_gives_the_same_picture() {
    let reference = film(&room(1.0), 64);
    for power in [-20, 20] {
        assert_eq!(difference(&film(&room(2f64.powi(power)), 64), &reference), 0.0, "2^{power}");
    }
    for scale in [1e-6, 1e-3, 1e3, 1e6] {
        let film = film(&room(scale), 64);
        let pixels = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let off = pixels.filter(|&(x, y)| {
            color(&film, x, y).iter().zip(color(&reference, x, y)).any(|(a, b)| (a - b).abs() > 1e-4)
        });
        assert!(off.count() <= 2, "{scale}");
    }
}

#[test]
fn opaque_scenes_have_the_same_picture_at_sizes_whose_squares_f32_cannot_hold() {
    let scene = |scale: f64| {
        let (far, radius) = (4.0 * scale, 0.8 * scale);
        format!(
            "prm s\nexp .7 1.2\ncoeff {radius} {radius} {radius}\nobj o\nap s\nrs 1 2 3 40\n\
             light l 0 0 {far}\ncamera 0 0 {far} 0 0 0 40\n"
        )
    };
    let reference = film(&scene(1.0), 48);
    for power in [-73, 67] {
        let film = film(&scene(2f64.powi(power)), 48);
        assert!(difference(&film, &reference) < 1e-3, "2^{power}: {}", difference(&film, &reference));
    }
}

#[test]
fn the_picture_does_not_depend_on_the_threads() {
    let one = rendered(&room(1.0), 50, 3, 1);
    for threads in [2, 3, 8] {
        let many = rendered(&room(1.0), 50, 3, threads);
        assert_eq!((many.film, many.stats), (one.film.clone(), one.stats));
    }
    assert_eq!(one.stats.rays.camera, 50 * 50 * 3);
}

#[test]
fn two_surfaces_in_the_same_place_do_not_shadow_each_other() {
    for shape in ["exp 1 1", "exp .1 .1", "exp .0001 .0001", "exp 3 3"] {
        let once = format!("prm s\n{shape}\nobj o\nrall 1 2 3 40\nxall .3 .2 .1\nap s\n");
        let twice = format!("{once}ap s again\n");
        let (once, twice) = (film(&once, 60), film(&twice, 60));
        let pixels = (0..60).flat_map(|y| (0..60).map(move |x| (x, y)));
        let off = pixels.filter(|&(x, y)| (color(&once, x, y)[0] - color(&twice, x, y)[0]).abs() > 1e-3);
        let off = off.count();
        assert!(off <= 3, "{shape}: {off} pixels");
    }
}

#[test]
fn a_flat_lit_face_has_no_speck() {
    // With light and eye far away on one side, the face of a cube has one colour except at its
    // rounded edges.
    for shape in ["exp .0001 .0001", "exp .01 .01", "exp 1 .0001", "exp 2 .0001"] {
        let text = format!(
            "prm s\n{shape}\nspecular 0\nobj o\nap s\nrs 1 2 3 20\nxs .1 .2 .3\nlight l 1e5 2e5 4e5\n"
        );
        let film = film(&text, 80);
        let is_dark = |x: u32, y: u32| color(&film, x, y)[0] < 0.15;
        let is_speck = |&(x, y): &(u32, u32)| {
            let beside = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            is_dark(x, y) && !beside.iter().any(|&(x, y)| is_dark(x, y))
        };
        let inner = || (1..79).flat_map(|y| (1..79).map(move |x| (x, y)));
        let (specks, lit) =
            (inner().filter(is_speck).count(), inner().filter(|&(x, y)| !is_dark(x, y)).count());
        assert!(specks == 0 && lit > 100, "{shape}: {specks} specks, {lit} lit pixels");
    }
}
