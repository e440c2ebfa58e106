//! Mirrors that receive the sky in f32 lanes, against the rays of f64.

mod support;

use superegg_geom::SplitMix;
use superegg_render::Rendered;

use crate::support::{color, rendered};

/// A plate that mirrors, with mirrors and matt shapes on it, before a sky that depends on the direction.
fn scene(random: &mut SplitMix) -> String {
    let mut text = String::from("camera 6 -9 7 0 0 0 35\nbackground .1 .2 .3\nlight a 3 -5 9 .8 .7 .6\n");
    if random.unit() < 0.7 {
        text += "sky .2 .3 .5 .9 .8 .7\n";
    }
    text += "prm plate\ncoeff 5 5 .2\nexp .4 .1\nreflected .4\nobj all\nap plate\nxs 0 0 -.2\n";
    for i in 0..(1.0 + 9.0 * random.unit()) as usize {
        let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
        let (e, n, mirror) = (number(0.1, 2.4), number(0.1, 1.9), number(-0.4, 0.9).max(0.0));
        let (x, y, size, angle) =
            (number(-4.0, 4.0), number(-4.0, 4.0), number(0.2, 0.8), number(0.0, 360.0));
        text += &format!(
            "prm p{i}\ncoeff {size} .6 {size}\nexp {e} {n}\nreflected {mirror}\nobj all\nap p{i}\nrs 1 2 3 {angle}\nxs {x} {y} .5\n"
        );
    }
    text
}

/// The same picture in f64: a shape transmits light somewhere behind the camera, too small to be hit.
fn in_f64(text: &str, side: u32) -> Rendered {
    rendered(
        &format!("{text}prm g\ncoeff 1e-6 1e-6 1e-6\nrefracted 1\nobj all\nap g\nxs 9 -14 11\n"),
        side,
        1,
        2,
    )
}

#[test]
fn mirrors_in_lanes_show_what_those_in_f64_show() {
    const SIDE: u32 = 96;
    let mut random = SplitMix::new(11);
    let mut reflected = 0;
    for case in 0..24 {
        let text = scene(&mut random);
        let (lanes, exact) = (rendered(&text, SIDE, 1, 2), in_f64(&text, SIDE));
        let (found, expected) = (lanes.stats.rays.reflection, exact.stats.rays.reflection);
        assert!(found.abs_diff(expected) <= 40, "case {case}: {found} {expected} rays\n{text}");
        reflected += found;
        let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
        let mut apart: Vec<f32> = pixels
            .map(|(x, y)| {
                let pairs = color(&lanes.film, x, y).into_iter().zip(color(&exact.film, x, y));
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
            })
            .collect();
        apart.sort_by(f32::total_cmp);
        // Rays at the rim of a shape may see the other side of it.
        let at_rims = 12;
        let largest = apart[apart.len() - 1 - at_rims];
        assert!(largest < 2e-4, "case {case}: {largest}\n{text}");
    }
    assert!(reflected > 50_000, "{reflected}");
}
