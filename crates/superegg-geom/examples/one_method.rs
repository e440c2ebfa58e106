//! One method over many rays, for counting instructions: `bench/instructions.sh` runs it under callgrind.
//!
//! `one_method METHOD E N COUNT`, METHOD one of textbook, f64, certified, lanes, none.

use std::hint::black_box;

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::batch;
use superegg_geom::{Exponents, RayStart, Superquadric, textbook};

#[path = "../benches/rays/mod.rs"]
#[allow(dead_code, reason = "the benchmarks use the rest")]
mod rays;

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let number = |i: usize| words.get(i).and_then(|word| word.parse::<f64>().ok()).unwrap_or(1.0);
    let exponents = Exponents::new(number(2), number(3)).expect("good exponents");
    let shape = Superquadric::new(DVec3::ONE, exponents).expect("good exponents");
    let rays = rays::camera_rays(number(4) as usize);
    match words.get(1).map(String::as_str) {
        Some("textbook") => rays.iter().for_each(|ray| {
            black_box(textbook::intersect(ray, exponents));
        }),
        Some("f64") => rays.iter().for_each(|ray| {
            black_box(shape.intersect(ray, RayStart::Free));
        }),
        Some("certified") => rays.iter().for_each(|ray| {
            black_box(shape.intersect_certified(ray, RayStart::Free));
        }),
        Some("lanes") => {
            if let Some(convex) = shape.as_convex() {
                batch::intersect(&convex, black_box(&rays), black_box(&mut Vec::new()));
            }
        }
        _ => {}
    }
}
