//! Laws of light: what is lost, what is bent, what is blurred, and by how much.

mod support;

use superegg_render::Film;

use crate::support::{centre, close, color, difference, film, rendered};

/// A world that is white all round, without lights.
const FURNACE: &str = "sky 1 1 1\nlight off 0 0 0 0 0 0\n";

fn pixels(film: &Film) -> impl Iterator<Item = [f32; 3]> + '_ {
    (0..film.height()).flat_map(move |y| (0..film.width()).map(move |x| color(film, x, y)))
}

fn range(film: &Film) -> (f32, f32) {
    pixels(film)
        .flatten()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)))
}

#[test]
fn in_a_white_furnace_nothing_is_visible() {
    for surface in [
        "reflected 1",
        "reflected 1\nfresnel on\nambient 1",
        "reflected .5\ngloss .5\nambient 1",
        "refracted 1",
        "refracted .6\nreflected .4\nindex 2.4",
        "refracted 1\nfresnel on\nreflected .3\nambient 1",
        "ambient 1",
    ] {
        for shape in ["exp 1 1", "exp .2 .2", "exp 2 2"] {
            // Convex shapes: a ray that leaves one sees the sky.
            let text = format!(
                "{FURNACE}ao 16 1\nset glossRays 3\nprm s\n{shape}\ndiffuse 0\nspecular 0\nambient 0\n{surface}\ncamera 2 3 4 0 0 0 40\n"
            );
            let (least, most) = range(&film(&text, 24));
            // The light after the last internal reflection is that of the sky.
            assert!(least > 0.999 && most < 1.0001, "{surface} {shape}: {least} to {most}");
        }
    }
}

#[test]
fn a_closed_box_of_mirrors_that_shine_is_as_bright_as_its_walls_alone() {
    // Each wall emits (1 - k) and reflects k: (1 - k) (1 + k + k^2 + ...) = 1. After the last
    // bounce the sky gives the rest.
    for k in [0.2, 0.5, 0.9] {
        let bounces = 12;
        let text = format!(
            "background 0 0 0\nlight off 0 0 0 0 0 0\nset bounces {bounces}\nset leastWeight 0\nprm room\nexp .0001 .0001\ncoeff 3 4 5\nambient 1\n\
             diffuse 0\nspecular 0\nreflected {k}\ncamera .1 .2 .3 1 -.4 .2 70\n"
        );
        let expected = 1.0 - f64::powi(k, bounces + 1);
        for color in pixels(&film(&text, 16)) {
            assert!((f64::from(color[0]) - expected).abs() < 1e-5, "{k}: {color:?} {expected}");
        }
    }
}

#[test]
fn a_slab_of_glass_moves_what_is_behind_it_by_snells_law() {
    // A sphere behind a slab of thickness d, tilted by a, appears displaced by
    // d sin a (1 - cos a / sqrt(n^2 - sin^2 a)).
    let picture = |slab: &str| {
        let text = format!(
            "orthographic 4\ncamera 0 0 20 0 0 0\nlight off 0 0 0 0 0 0\nprm ball\ncoeff .5 .5 .5\nambient 1\ndiffuse 0\nspecular 0\nprm slab\ncoeff 8 8 1\n\
             exp .0001 .0001\nambient 0\ndiffuse 0\nspecular 0\nrefracted 1\nobj o\nap ball\nxs 0 0 -5\n{slab}"
        );
        film(&text, 200)
    };
    let middle = |film: &Film| {
        let bright = (0..200u32).flat_map(|y| (0..200u32).map(move |x| (x, y)));
        let (sum, weight) = bright.fold((0.0, 0.0), |(sum, weight), (x, y)| {
            // The threshold removes fainter images from internal reflection in the slab.
            let value = if color(film, x, y)[0] > 0.5 { 1.0 } else { 0.0 };
            (sum + value * (f64::from(x) + 0.5), weight + value)
        });
        sum / weight * 4.0 / 200.0 - 2.0
    };
    assert!(middle(&picture("")).abs() < 1e-3);
    for (angle_deg, index) in [(30.0f64, 1.5f64), (45.0, 1.33), (-50.0, 2.4)] {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let expected = 2.0 * sin * (1.0 - cos / (index * index - sin * sin).sqrt());
        let film = picture(&format!("ap slab\nrs 0 1 0 {angle_deg}\nprm slab\nindex {index}\nobj o\n"));
        // A positive rotation about +y tilts the normal towards +x. The ray is refracted to the
        // other side, so the sphere appears towards +x.
        let offset = middle(&film);
        assert!((offset.abs() - expected.abs()).abs() < 0.01, "{angle_deg} {index}: {offset} {expected}");
        assert!(offset * expected > 0.0, "{angle_deg}: the wrong side, {offset}");
    }
}

#[test]
fn a_lens_is_sharp_at_its_focus_and_spreads_a_point_over_a_disc_elsewhere() {
    // A sphere that fills 0.01 of the film at distance 1. A lens of radius r focused at f adds a
    // disc of radius r |d - f| / (d f).
    let size_px = |distance: f64| {
        let size = 0.01 * distance;
        let text = format!(
            "camera 0 0 0 0 0 -1 30\nlens .2 4\nlight off 0 0 0 0 0 0\nprm ball\nambient 1\ndiffuse 0\nspecular 0\nobj o\nap ball\nss {size} {size} {size}\nxs 0 0 {}\n",
            -distance
        );
        let film = rendered(&text, 100, 64, 2).film;
        let is_visible = |&(x, y): &(u32, u32)| color(&film, x, y)[0] > 0.0;
        let visible = (0..100u32).flat_map(|y| (0..100u32).map(move |x| (x, y))).filter(is_visible);
        (visible.count() as f64 / std::f64::consts::PI).sqrt()
    };
    let px = 100.0 / (2.0 * 15f64.to_radians().tan());
    for distance in [4.0f64, 2.0, 8.0, 3.0] {
        let expected = px * (0.2 * (distance - 4.0).abs() / (4.0 * distance) + 0.01);
        let size = size_px(distance);
        // Pixels that are partly in it may have no sample there.
        assert!((size - expected).abs() < 0.7 + 0.1 * expected, "{distance}: {size} {expected}");
    }
}

#[test]
fn what_is_inside_absorbs_by_the_way_through_it() {
    for (absorb, thickness) in [(0.5f64, 1.0), (2.0, 0.3), (0.0, 4.0)] {
        let text = format!(
            "{FURNACE}set leastWeight 0\nprm ink\nexp .0001 .0001\ncoeff 1 1 {}\nambient 0\ndiffuse 0\nspecular 0\nrefracted 1\nindex 1\nabsorb {absorb} 0 {absorb}\n",
            thickness / 2.0
        );
        let left = (-absorb * thickness).exp();
        close(centre(&film(&text, 1)), [left, 1.0, left]);
    }
}

#[test]
fn what_is_clear_and_coloured_throws_a_coloured_shadow() {
    // A pane of the floor's own air: its colour once in and once out, and what it absorbs.
    let base = "light lamp 0 0 8\ncamera 3 0 6 0 0 0\nprm floor\ncoeff 9 9 .5\nexp .0001 .0001\nambient 0\nspecular 0\nprm pane\ncoeff 1 1 .1\nexp .0001 .0001\n\
        color .2 .5 1\nrefracted 1\nindex 1\nabsorb 1 0 0\nobj o\nap floor\nxs 0 0 -.5\n";
    let lit = centre(&film(base, 1));
    let shadowed = centre(&film(&format!("{base}ap pane\nxs 0 0 4\n"), 1));
    let share = [0.2 * (-0.2f64).exp(), 0.5, 1.0];
    close(shadowed, [0, 1, 2].map(|i| f64::from(lit[i]) * share[i]));
    let opaque = centre(&film(&format!("{base}ap pane\nxs 0 0 4\nprm pane\nrefracted 0\nobj o\n"), 1));
    close(opaque, [0.0; 3]);
}

#[test]
fn a_shadow_through_glass_in_glass_is_absorbed_by_both() {
    // A pane of thickness 2 that contains one of 0.4: the path is 1.6 in the outer and 0.4 in the
    // inner one.
    let pane = |index: f64| {
        let base = "light lamp 0 0 8\ncamera 9 0 6 0 0 0\nprm floor\ncoeff 9 9 .5\nexp .0001 .0001\nambient 0\nspecular 0\nobj o\nap floor\nxs 0 0 -.5\n";
        let inner =
            format!("prm inner\ncoeff 1 1 .2\nexp .0001 .0001\nrefracted 1\nindex {index}\nabsorb .5 .1 0\n");
        let outer =
            format!("prm outer\ncoeff 2 2 1\nexp .0001 .0001\nrefracted 1\nindex {index}\nabsorb 0 .3 1\n");
        let lit = centre(&film(base, 1));
        let shadowed =
            centre(&film(&format!("{base}{inner}{outer}obj o\nap outer\nxs 0 0 4\nap inner\nxs 0 0 4\n"), 1));
        [0, 1, 2].map(|i| shadowed[i] / lit[i])
    };
    let absorbed = [(-0.2f64).exp(), (-0.04 - 0.48f64).exp(), (-1.6f64).exp()];
    close(pane(1.0), absorbed);
    // An inner pane of the same glass reflects nothing.
    close(pane(1.5), absorbed.map(|left| left * 0.96 * 0.96));
}

#[test]
fn half_of_a_light_is_visible_at_the_edge_of_a_shadow() {
    // At the floor's point half way under the edge of a wide plate, the edge passes the centre of
    // the light's disc.
    for light in ["light l 0 0 8\nlightRadius l .5\n", "sun l 0 0 1\nlightRadius l .1\n"] {
        let base = format!(
            "{light}set lightRays 16\ncamera -3 0 6 0 0 0 .001\nprm floor\ncoeff 9 9 .5\nexp .0001 .0001\nambient 0\nspecular 0\nprm plate\ncoeff 2 2 .01\nexp .0001 .0001\n\
             obj o\nap floor\nxs 0 0 -.5\n"
        );
        let lit = rendered(&base, 1, 64, 1).film;
        let half = rendered(&format!("{base}ap plate\nxs 2 0 4\n"), 1, 64, 1).film;
        let share = centre(&half)[0] / centre(&lit)[0];
        assert!((share - 0.5).abs() < 0.03, "{light}: {share}");
        let far = rendered(&format!("{base}ap plate\nxs 2.6 0 4\n"), 1, 64, 1).film;
        assert_eq!(centre(&far), centre(&lit));
    }
}

#[test]
fn a_wall_takes_half_of_the_ambient_light_from_the_floor_before_it() {
    let base = "light off 0 0 0 0 0 0\nao 64 1000\ncamera 6 0 6 0 0 0 .001\nprm plain\nambient 1\nfloor 0 plain 0 0 1\nprm wall\nexp .0001 .0001\ncoeff 500 500 500\nobj o\n";
    let open = rendered(&format!("{base}prm far\nobj o\nap far\nxs 0 0 -5000\n"), 1, 16, 1).film;
    close(centre(&open), [1.0; 3]);
    let beside = rendered(&format!("{base}ap wall\nxs -500.0001 0 0\n"), 1, 16, 1).film;
    assert!((centre(&beside)[0] - 0.5).abs() < 0.02, "{:?}", centre(&beside));
    // Under a blue sky, the unoccluded ambient light is blue.
    let blue = rendered(&format!("sky 0 0 1\n{base}ap wall\nxs -500.0001 0 0\n"), 1, 16, 1).film;
    close(centre(&blue), [0.0, 0.0, f64::from(centre(&beside)[2])]);
}

#[test]
fn a_sun_lights_everything_alike_and_a_spot_only_its_cone() {
    let base =
        "camera 3 0 6 0 0 0\nprm plain\nambient 0\nspecular 0\ndiffuse 1\nfloor 0 plain 0 0 1\nobj o\n";
    let tilt = 40f64.to_radians();
    let sun = film(&format!("sun s {} 0 {}\n{base}", tilt.sin(), tilt.cos()), 8);
    for color in pixels(&sun) {
        assert!((f64::from(color[0]) - tilt.cos()).abs() < 1e-6);
    }
    for (aside, is_lit) in [(0.0, true), (1.0, true), (1.2, false)] {
        // Half an angle of atan(1.1 / 4).
        let cone = 2.0 * (1.1f64 / 4.0).atan().to_degrees();
        let spot = film(&format!("spot s {aside} 0 4 {aside} 0 0 {cone} 1 1 1 0 0\n{base}"), 1);
        assert_eq!(centre(&spot)[0] > 0.5, is_lit, "{aside}");
    }
}

#[test]
fn a_bubble_of_the_same_glass_is_not_seen_and_one_of_air_is() {
    let ball = "camera 0 0 3 0 0 0\nsky .2 .4 .6 1 1 1\nlight off 0 0 0 0 0 0\nset leastWeight 1e-5\nprm ball\nambient 0\ndiffuse 0\nspecular 0\nrefracted 1\nindex 1.5\n\
        prm bubble\ncoeff .5 .5 .5\nambient 0\ndiffuse 0\nspecular 0\nrefracted 1\n";
    let without = film(&format!("{ball}obj o\nap ball\n"), 48);
    let same = film(&format!("{ball}index 1.5\nobj o\nap ball\nap bubble\n"), 48);
    let air = film(&format!("{ball}index 1\nobj o\nap ball\nap bubble\n"), 48);
    let off =
        |film: &Film| pixels(film).zip(pixels(&without)).filter(|(a, b)| (a[0] - b[0]).abs() > 2e-3).count();
    assert!(off(&same) <= 4, "{}", off(&same));
    assert!(off(&air) > 300, "{}", off(&air));
}

#[test]
fn a_camera_in_glass_sees_as_from_glass() {
    // Inside a slab of index n, the face reflects totally beyond the critical angle.
    let text = "sky 1 1 1\nlight off 0 0 0 0 0 0\nprm sea\ncoeff 100 100 1\nexp .0001 .0001\nambient 0\ndiffuse 0\nspecular 0\nrefracted 1\nindex 1.33\nprm ground\nambient 0\n\
        diffuse 0\nspecular 0\nfloor -.5 ground 0 0 1\nprm sea\ncamera 0 0 0 0 0 1 120\nset bounces 8\ncameraUp 0 1 0\n";
    let film = film(text, 101);
    let per_px = 60f64.to_radians().tan() / 50.5;
    let critical = (1.0f64 / 1.33).asin();
    for (angle, is_sky) in [(0.0, true), (critical - 0.05, true), (critical + 0.05, false)] {
        let x = (50.5 + angle.tan() / per_px) as u32;
        let value = color(&film, x, 50)[0];
        assert_eq!(value > 0.5, is_sky, "{angle}: {value}");
    }
}

#[test]
fn a_floor_is_the_top_of_a_wide_box() {
    let around = "light l 3 5 -2 1 1 1 .01\ncamera 4 3 9 0 0 0 40\nprm ball\ncolor .9 .4 .2\nreflected .3\nprm glass\nrefracted .8\nprm tiles\nreflected .2\n";
    let shapes = "obj o\nap ball\nxs -1 0 0\nap glass\nxs 1.2 0 1\n";
    let plane = film(&format!("{around}floor -1 tiles\n{shapes}"), 64);
    let boxed = film(&format!("{around}coeff 1e4 1 1e4\nexp .0001 .0001\n{shapes}ap tiles\nxs 0 -2 0\n"), 64);
    // Where the floor meets the sky, the box ends a little before.
    let off = pixels(&plane).zip(pixels(&boxed)).filter(|(a, b)| (a[0] - b[0]).abs() > 2e-3).count();
    assert!(off <= 70, "{off}");
}

#[test]
fn energy_never_grows_whatever_the_surfaces() {
    let share = |i: u32, j: u32| f64::from((i * 7 + j * 5) % 11) / 10.0;
    for i in 0..12 {
        let material = |j: u32| {
            format!(
                "ambient {}\ndiffuse 1\nspecular 0\nreflected {}\nrefracted {}\nindex {}\ngloss {}\nfresnel {}\nabsorb 0 {} 0\n",
                share(i, j),
                share(i + 1, j),
                share(i + 3, j + 1),
                1.0 + share(i, j + 2),
                share(i + 2, j),
                if (i + j).is_multiple_of(2) { "on" } else { "off" },
                share(j, i)
            )
        };
        let text = format!(
            "{FURNACE}ao 4 2\nset glossRays 2\nprm a\nexp .5 .5\n{}prm b\nexp 1.5 .3\n{}prm c\n{}floor -1 c\nobj o\nap a\nap b\nxs 1 .5 0\n",
            material(0),
            material(1),
            material(2)
        );
        let film = film(&text, 20);
        assert!(difference(&film, &Film::new(20, 20)) <= 1.0001, "{i}: {text}");
    }
}

#[test]
fn hostile_numbers_give_numbers() {
    for line in [
        "light l 0 0 1e300\nlightRadius l 1e300",
        "light l 1 0 0\nlightRadius l 1e-300",
        "sun s 1e-300 0 0\nlightRadius s 1e9",
        "spot s 0 0 3 0 0 1e300 180",
        "spot s 0 0 1.0000001 0 0 1 1e-9",
        "ao 3 1e300",
        "ao 2 1e-300",
        "floor 1e300 s",
        "floor -1 s 1e-300 1e-300 1e300",
        "prm s\ncolor 1 0 0\npattern checker 0 1 0 .5\nrefracted 1",
        "prm s\npattern gradient 1 0 0 1e-200 0 0\nfloor -1 s",
        "lens 1e300 1e-300",
        "lens 1e-300 1e300",
        "orthographic 1e300",
        "orthographic 1e-300",
        "sky 1e308 0 0 0 1e308 0 1e-300 0 0",
    ] {
        let text = format!(
            "prm s\npattern checker 0 0 0 1e-300\nreflected .3\nrefracted .3\nabsorb 1e300 0 0\nset glossRays 1\n{line}\nprm s\n"
        );
        for color in pixels(&film(&text, 6)) {
            assert!(color.iter().all(|value| !value.is_nan() && *value >= 0.0), "{line}: {color:?}");
        }
    }
}

#[test]
fn the_picture_of_everything_does_not_depend_on_the_threads() {
    let text = "sun s 1 2 1\nlightRadius s .1\nao 4 2\nset glossRays 2\nlens .1 5\nprm tiles\npattern checker 0 0 0\nreflected .4\nfloor -1 tiles\nprm ball\nrefracted .7\nobj o\nap ball\nxs 0 0 1\nap ball b\n";
    let one = rendered(text, 40, 3, 1);
    for threads in [2, 5] {
        let many = rendered(text, 40, 3, threads);
        assert_eq!((many.film, many.stats), (one.film.clone(), one.stats));
    }
}
