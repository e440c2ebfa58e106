//! One table: million rays a second and evaluations a ray, for each method, on the same rays in the same run.
//!
//! `cargo bench -p superegg-geom --bench table`. Methods take turns, and the best of several rounds counts, since machines are shared.
//! With a number as argument only that many rays are used.

// A table is for reading.
#![allow(clippy::print_stdout)]

mod rays;

use std::hint::black_box;
use std::time::Instant;

use rays::{camera_rays, random_rays};
use superegg_geom::glam::DVec3;
use superegg_geom::kernels::{batch, lane_count};
use superegg_geom::{Exponents, Ray, RayStart, Superquadric, textbook};

const ROUNDS: usize = 5;

/// The best time of a few rounds, in seconds.
fn best(mut work: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

fn measure(name: &str, e: f64, n: f64, rays: &[Ray]) {
    let exponents = Exponents::new(e, n).expect("good exponents");
    let shape = Superquadric::new(DVec3::ONE, exponents).expect("good exponents");
    let million = rays.len() as f64 * 1e-6;
    let speed = |seconds: f64| million / seconds;

    let by_textbook = speed(best(|| {
        rays.iter().for_each(|ray| {
            black_box(textbook::intersect(ray, exponents));
        });
    }));
    let by_f64 = speed(best(|| {
        rays.iter().for_each(|ray| {
            black_box(shape.intersect(ray, RayStart::Free));
        });
    }));
    let by_certified = speed(best(|| {
        rays.iter().for_each(|ray| {
            black_box(shape.intersect_certified(ray, RayStart::Free));
        });
    }));

    let textbook_hits = rays.iter().filter(|ray| textbook::intersect(ray, exponents).t.is_some()).count();
    let hits = rays.iter().filter(|ray| shape.intersect(ray, RayStart::Free).is_some()).count();
    let textbook_steps: u32 = rays.iter().map(|ray| textbook::intersect(ray, exponents).steps).sum();
    let per_ray = |count: f64| count / rays.len() as f64;

    let lanes = shape.as_convex().map_or("-".into(), |convex| {
        let mut answers = Vec::new();
        let lanes = speed(best(|| batch::intersect(&convex, rays, &mut answers)));
        format!("{lanes:.1}")
    });
    println!(
        "| {name} | {e} | {n} | {:.2} | {:.2} | {by_textbook:.2} | {by_f64:.2} | {by_certified:.2} | {lanes} | {:.1} |",
        per_ray(hits as f64),
        per_ray(textbook_hits as f64),
        per_ray(f64::from(textbook_steps)),
    );
}

fn main() {
    let count = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(250_000);
    println!("| rays | e | n | hits | textbook hits | textbook | f64 | certified | lanes | textbook steps |");
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (name, rays) in [("camera", camera_rays(count)), ("random", random_rays(count))] {
        for (e, n) in [
            (1.0, 1.0),
            (0.5, 0.5),
            (0.1, 0.1),
            (0.01, 0.01),
            (0.0001, 0.0001),
            (1.0, 0.0001),
            (2.0, 2.0),
            (0.3, 1.7),
            (2.5, 2.5),
            (4.0, 4.0),
            (0.5, 4.0),
        ] {
            measure(name, e, n, &rays);
        }
    }
    println!(
        "\nmillion rays a second, one thread, the best of {ROUNDS} rounds; hits and steps are a ray's mean; {} lanes",
        lane_count()
    );
}
