//! The film: filters, adaptive sampling, transparency, and what is shown instead of light.

use superegg_lang::load_text;
use superegg_render::{Development, Film, Output, RenderOptions, RenderSettings, Rendered, render};
use superegg_scene::{Filter, Picture};
use superegg_trace::CompiledScene;

/// A picture of a scene, 48 by 36 pixels unless the settings are changed.
fn made(text: &str, threads: usize, change: impl FnOnce(&mut RenderSettings)) -> (Rendered, RenderSettings) {
    let (session, diagnostics) = load_text("film.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
    let picture = Picture { width: 48, height: 36, ..scene.picture };
    let mut settings = RenderSettings::of(scene).with_picture(picture);
    change(&mut settings);
    let options = RenderOptions::default().with_threads(threads);
    (render(&compiled, &settings, &options).unwrap(), settings)
}

/// The root of the mean square of the differences of developed values, over all channels.
fn difference(a: &Film, b: &Film, development: &Development) -> f64 {
    let squares = a.pixels().zip(b.pixels()).flat_map(|(a, b)| {
        let (a, b) = (development.value(a.color), development.value(b.color));
        (0..3).map(move |i| f64::from(a[i] - b[i]).powi(2))
    });
    (squares.sum::<f64>() / (3.0 * a.pixels().len() as f64)).sqrt()
}

/// Soft shadows, corners and edges.
const NOISY: &str = "prm s\ncolor .9 .7 .5\nprm slab\nexp .1 .1\ncoeff 4 .2 4\nobj o\nap slab\nxs 0 -1.2 0\nap s\nlight l 3 6 4 1 1 1\nlightRadius l 2\ncamera 2 3 7 0 0 0 50\nset lightRays 1\n";

#[test]
fn a_white_film_stays_white_under_every_filter() {
    for filter in [Filter::Box, Filter::Tent, Filter::Gaussian, Filter::Blackman, Filter::Mitchell] {
        for (samples, noise) in [(1, 0.0), (2, 0.0), (5, 0.0), (3, 0.001)] {
            let (rendered, _) = made("background 1 1 1\nobj o\n", 1, |settings| {
                settings.picture = Picture { filter, samples, noise, ..settings.picture };
            });
            let off = rendered.film.pixels().flat_map(|p| p.color).map(|value| (value - 1.0).abs());
            assert!(off.fold(0.0, f32::max) < 1e-6, "{filter:?}, {samples} samples");
        }
    }
}

#[test]
fn filters_of_many_samples_agree_on_what_is_smooth_and_differ_at_edges() {
    let of = |filter, samples| {
        let (rendered, settings) = made("prm s\n", 2, |settings| {
            settings.picture = Picture { filter, samples, ..settings.picture };
        });
        (rendered.film, settings.development())
    };
    let (sharp, development) = of(Filter::Box, 64);
    for (filter, most) in
        [(Filter::Tent, 0.05), (Filter::Gaussian, 0.05), (Filter::Blackman, 0.05), (Filter::Mitchell, 0.05)]
    {
        let (film, _) = of(filter, 64);
        let off = difference(&sharp, &film, &development);
        assert!(off > 1e-4 && off < most, "{filter:?}: {off}");
        // The middle of the ball is the same to the eye.
        let middle = (film.pixel(24, 18).unwrap().color[0] - sharp.pixel(24, 18).unwrap().color[0]).abs();
        assert!(middle < 0.01, "{filter:?}: {middle}");
    }
}

fn small(picture: Picture) -> Picture {
    Picture { width: 32, height: 24, ..picture }
}

#[test]
fn the_error_falls_below_what_is_asked_for() {
    let (truth, settings) = made(NOISY, 2, |settings| {
        settings.picture = Picture { samples: 2048, ..small(settings.picture) };
    });
    let development = settings.development();
    let mut before = f64::INFINITY;
    for noise in [0.04, 0.02, 0.01] {
        let (adaptive, _) = made(NOISY, 2, |settings| {
            settings.picture = Picture { noise, most_samples: 4096, ..small(settings.picture) };
        });
        let off = difference(&adaptive.film, &truth.film, &development);
        assert!(off < noise && off < before, "{noise}: {off}");
        before = off;
        let counts: Vec<u32> = adaptive.film.pixels().map(|pixel| pixel.samples).collect();
        let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
        assert_eq!(total, adaptive.stats.rays.camera);
        assert!(counts.iter().all(|&count| (4..=4096).contains(&count)));
        // Work goes where the noise is.
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*least == 4 && *most >= 32, "{noise}: {least} to {most}");
    }
}

#[test]
fn no_pixel_takes_more_than_the_most() {
    let (rendered, _) = made(NOISY, 2, |settings| {
        settings.picture = Picture { noise: 1e-6, most_samples: 23, ..settings.picture };
    });
    assert_eq!(rendered.film.pixels().map(|pixel| pixel.samples).max(), Some(23));
}

#[test]
fn adaptive_pictures_do_not_depend_on_the_threads() {
    let of = |threads| {
        let (rendered, _) = made(NOISY, threads, |settings| {
            settings.picture = Picture { noise: 0.02, filter: Filter::Mitchell, ..settings.picture };
        });
        (rendered.film, rendered.stats.rays)
    };
    let one = of(1);
    assert!(of(2) == one && of(5) == one);
}

#[test]
fn transparent_surfaces_over_the_background_are_the_opaque_picture() {
    let text = "background .1 .3 .6\nprm s\nspecular 0\nobj o\nap s\nap s b\nxs 1.5 1 -1\n";
    for filter in [Filter::Box, Filter::Mitchell] {
        let of = |transparent| {
            made(text, 2, |settings| {
                settings.picture = Picture { transparent, filter, samples: 16, ..settings.picture };
            })
            .0
            .film
        };
        let (clear, opaque) = (of(true), of(false));
        let background = [0.1, 0.3, 0.6];
        for (clear, opaque) in clear.pixels().zip(opaque.pixels()) {
            assert_eq!(opaque.alpha, 1.0);
            assert!((0.0..=1.0).contains(&clear.alpha));
            for (i, behind) in background.into_iter().enumerate() {
                let over = clear.color[i] + (1.0 - clear.alpha) * behind;
                // A negative share of coverage is cut off.
                let slack = if filter == Filter::Box { 1e-6 } else { 0.1 };
                assert!((over - opaque.color[i]).abs() < slack, "{over} {}", opaque.color[i]);
            }
        }
        let alphas: Vec<f32> = clear.pixels().map(|pixel| pixel.alpha).collect();
        assert!(
            alphas.contains(&0.0) && alphas.contains(&1.0) && alphas.iter().any(|a| *a > 0.2 && *a < 0.8)
        );
    }
}

#[test]
fn the_film_knows_depth_normal_albedo_and_instance() {
    // The middle of a ball of radius 1, 10 away from the camera.
    let (rendered, _) = made("prm s\ncolor .2 .4 .6\n", 1, |settings| settings.picture.samples = 16);
    let middle = rendered.film.pixel(24, 18).unwrap();
    assert!((middle.depth - 9.0).abs() < 0.05, "{}", middle.depth);
    assert!(middle.normal[2] > 0.96 && middle.id != 0 && middle.samples == 16);
    assert!((middle.albedo[1] - 0.4).abs() < 1e-6);
    let corner = rendered.film.pixel(0, 0).unwrap();
    assert_eq!((corner.depth, corner.normal, corner.id), (f32::INFINITY, [0.0; 3], 0));
}

#[test]
fn views_show_what_they_say() {
    let text = "background 1 0 0\nprm s\nobj o\nap s\nxs -1 0 0\nap s b\nxs 1 0 -3\n";
    let of = |output: Output| {
        let (rendered, settings) = made(text, 2, |settings| settings.output = output);
        (rendered.film.clone(), output.colored(&rendered.film).into_owned(), settings)
    };
    // The middles of the balls, and a place beside them.
    let (near, far, beside) = ((20, 18), (26, 18), (2, 2));
    let at = |film: &Film, (x, y): (u32, u32)| film.pixel(x, y).unwrap().color;

    let (_, normal, settings) = of(Output::Normal);
    assert!(at(&normal, near)[2] > 0.9 && at(&normal, beside) == [0.0; 3]);
    // Not developed: half is half.
    assert!((settings.development().value([0.5; 3])[0] - 0.5).abs() < 1e-6);

    let (_, depth, _) = of(Output::Depth);
    assert!(at(&depth, near)[0] > at(&depth, far)[0] && at(&depth, beside) == [0.0; 3]);

    let (_, id, _) = of(Output::Id);
    assert!(at(&id, near) != at(&id, far) && at(&id, beside) == [0.0; 3]);

    let (counts, steps, _) = of(Output::Steps);
    assert!(at(&counts, near)[0] >= 2.0 && at(&counts, near)[0].fract() == 0.0);
    assert!(steps.pixels().any(|pixel| pixel.color == [1.0; 3]));

    let (_, open, _) = of(Output::Occlusion);
    let share = at(&open, near)[0];
    assert!(share > 0.5 && share <= 1.0 && at(&open, beside) == [0.0; 3], "{share}");
}

#[test]
fn occlusion_is_that_of_a_corner() {
    // Beside a high wall, half of the sky is visible from a wide floor. By symmetry that is also
    // half of the cosine-weighted rays.
    let text = "prm slab\nexp .01 .01\ncoeff 50 1 50\nobj o\nap slab\nxs 0 -1 0\nap slab wall\nrs 1 0 0 90\nxs 0 0 -2\ncamera 0 4 2 0 0 -.99\nAO\n";
    let text = text.replace("AO\n", "ambientOcclusion 256 40\n");
    let (rendered, _) = made(&text, 2, |settings| {
        settings.output = Output::Occlusion;
        settings.picture.samples = 1;
    });
    let share = rendered.film.pixel(24, 19).unwrap().color[0];
    assert!((share - 0.5).abs() < 0.06, "{share}");
}
