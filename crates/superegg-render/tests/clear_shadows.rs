//! Shadows through clear shapes, whose chords are found in f32, against rays that are traced through the scene.

mod support;

use superegg_geom::SplitMix;

use crate::support::{difference, rendered};

/// A floor under shapes of glass, some of them across one another, with area lights. With `patterned`, the
/// glass has a checker of two equal colours, whose shadows are traced through the scene.
fn scene(case: u64, patterned: bool) -> String {
    let mut random = SplitMix::new(case);
    let mut text = String::from(
        "camera 2 -8 8 0 0 0 45\nbackground .1 .2 .3\nlight a 3 -5 9 .8 .7 .6\nlightRadius a .7\nlight b -4 2 6 .3 .4 .5\n\
         prm plate\ncoeff 6 6 .2\nexp .1 .1\nobj all\nap plate\nxs 0 0 -.2\nprm stone\ncoeff .4 .4 .4\nobj all\nap stone\nxs .5 .5 .4\n",
    );
    for i in 0..4 {
        let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
        let (e, n, index) = (number(0.2, 2.0), number(0.2, 2.0), number(1.0, 2.4));
        let (x, y, z, size) = (number(-2.0, 2.0), number(-2.0, 2.0), number(1.0, 3.0), number(0.3, 1.2));
        let (red, share, absorb) = (number(0.3, 1.0), number(0.4, 1.0), number(0.0, 0.8));
        let fresnel = if i % 2 == 0 { "reflected .3\nfresnel on\n" } else { "" };
        let pattern = if patterned { format!("setPattern checker {red} .9 .8 .5\n") } else { String::new() };
        text += &format!(
            "prm g{i}\ncoeff {size} .6 {size}\nexp {e} {n}\ncolor {red} .9 .8\nrefracted {share}\nindex {index}\nabsorb {absorb} .1 .3\n\
             {fresnel}{pattern}obj all\nap g{i}\nrs 1 2 3 {}\nxs {x} {y} {z}\n",
            40 * i
        );
    }
    text
}

#[test]
fn light_through_chords_is_that_of_traced_rays() {
    for case in 0..10 {
        let (chords, traced) = (scene(case, false), scene(case, true));
        let (chords, traced) = (rendered(&chords, 64, 1, 2), rendered(&traced, 64, 1, 2));
        assert!(chords.stats.rays.shadow < traced.stats.rays.shadow, "case {case}");
        let apart = difference(&chords.film, &traced.film);
        assert!(apart < 4e-3, "case {case}: {apart}");
    }
}
