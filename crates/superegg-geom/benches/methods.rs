//! Each method by criterion, with its statistics: `cargo bench -p superegg-geom --bench methods`.

#![allow(missing_docs, reason = "criterion's macros make items without documentation")]

mod rays;

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rays::{camera_rays, random_rays};
use superegg_geom::glam::DVec3;
use superegg_geom::kernels::batch;
use superegg_geom::{Exponents, RayStart, Superquadric, textbook};

const COUNT: usize = 10_000;

fn methods(criterion: &mut Criterion) {
    for (kind, rays) in [("camera", camera_rays(COUNT)), ("random", random_rays(COUNT))] {
        for (e, n) in [(1.0, 1.0), (0.5, 0.5), (0.1, 0.1), (0.0001, 0.0001), (2.5, 2.5)] {
            let exponents = Exponents::new(e, n).expect("good exponents");
            let shape = Superquadric::new(DVec3::ONE, exponents).expect("good exponents");
            let mut group = criterion.benchmark_group(format!("{kind} e={e} n={n}"));
            group.throughput(Throughput::Elements(rays.len() as u64));
            group.bench_function("textbook", |bencher| {
                bencher.iter(|| {
                    rays.iter().for_each(|ray| {
                        black_box(textbook::intersect(ray, exponents));
                    });
                });
            });
            group.bench_function("f64", |bencher| {
                bencher.iter(|| {
                    rays.iter().for_each(|ray| {
                        black_box(shape.intersect(ray, RayStart::Free));
                    });
                });
            });
            group.bench_function("occluded", |bencher| {
                bencher.iter(|| {
                    rays.iter().for_each(|ray| {
                        black_box(shape.occluded(ray, RayStart::Free, 1e9));
                    });
                });
            });
            if let Some(convex) = shape.as_convex() {
                let mut hits = Vec::new();
                group.bench_function("lanes", |bencher| {
                    bencher.iter(|| batch::intersect(&convex, &rays, &mut hits));
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, methods);
criterion_main!(benches);
