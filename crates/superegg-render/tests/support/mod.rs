//! Scenes as text, rendered small.

#![allow(dead_code, reason = "each file of tests uses a part")]

use std::sync::atomic::AtomicBool;

use superegg_lang::load_text;
use superegg_render::{Film, RenderBudget, RenderSettings, Rendered, render};
use superegg_scene::Picture;
use superegg_trace::CompiledScene;

pub(crate) fn rendered(text: &str, side: u32, samples: u32, threads: usize) -> Rendered {
    let (session, diagnostics) = load_text("known.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
    let settings = RenderSettings {
        picture: Picture { width: side, height: side, samples, ..scene.picture },
        ..RenderSettings::of(scene)
    };
    let budget = RenderBudget { threads, cancel: &AtomicBool::new(false), progress: &|_| {} };
    render(&compiled, &settings, &budget).unwrap()
}

pub(crate) fn film(text: &str, side: u32) -> Film {
    rendered(text, side, 1, 2).film
}

/// The largest difference of any channel of any pixel.
pub(crate) fn difference(a: &Film, b: &Film) -> f32 {
    let pixels = (0..a.height()).flat_map(|y| (0..a.width()).map(move |x| (x, y)));
    let channels = pixels.flat_map(|(x, y)| a.pixel(x, y).color.into_iter().zip(b.pixel(x, y).color));
    channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

pub(crate) fn centre(film: &Film) -> [f32; 3] {
    film.pixel(film.width() / 2, film.height() / 2).color
}

pub(crate) fn close(actual: [f32; 3], expected: [f64; 3]) {
    let off = actual.into_iter().zip(expected).map(|(a, e)| (f64::from(a) - e).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6, "{actual:?} is not {expected:?}");
}
