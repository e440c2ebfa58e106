//! Scenes as text, rendered small.

#![allow(dead_code, reason = "each file of tests uses a part")]

use superegg_lang::load_text;
use superegg_render::{Film, RenderOptions, RenderSettings, Rendered, render};
use superegg_scene::Picture;
use superegg_trace::CompiledScene;

pub(crate) fn rendered(text: &str, side: u32, samples: u32, threads: usize) -> Rendered {
    let (session, diagnostics) = load_text("known.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
    let picture = Picture { width: side, height: side, samples, ..scene.picture };
    let settings = RenderSettings::of(scene).with_picture(picture);
    render(&compiled, &settings, &RenderOptions::default().with_threads(threads)).unwrap()
}

pub(crate) fn film(text: &str, side: u32) -> Film {
    rendered(text, side, 1, 2).film
}

/// The largest difference of any channel of any pixel.
pub(crate) fn difference(a: &Film, b: &Film) -> f32 {
    let pixels = (0..a.height()).flat_map(|y| (0..a.width()).map(move |x| (x, y)));
    let channels = pixels.flat_map(|(x, y)| color(a, x, y).into_iter().zip(color(b, x, y)));
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// The linear colour of a pixel.
pub(crate) fn color(film: &Film, x: u32, y: u32) -> [f32; 3] {
    film.pixel(x, y).expect("a pixel inside the film").color
}

pub(crate) fn centre(film: &Film) -> [f32; 3] {
    color(film, film.width() / 2, film.height() / 2)
}

pub(crate) fn close(actual: [f32; 3], expected: [f64; 3]) {
    let off = actual.into_iter().zip(expected).map(|(a, e)| (f64::from(a) - e).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6, "{actual:?} is not {expected:?}");
}
