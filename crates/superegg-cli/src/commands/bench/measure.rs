//! Measures a scene: compilation, camera, shadow and random rays, and a whole picture.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use superegg_geom::Ray;
use superegg_geom::Superquadric;
use superegg_geom::glam::DVec3;
use superegg_render::measure::camera_tiles;
use superegg_render::{RenderOptions, View, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::measure::{CameraTile, ShadowTiming, TileProbe, find_many};
use superegg_trace::{CompiledScene, TraceRay};

use crate::args::BenchArgs;
use crate::commands::bench::generated_scene::Random;
use crate::commands::bench::row::Row;
use crate::files::surroundings::settings_with_surroundings;
use crate::system::memory::{peak_rss_bytes, reset_peak};
use crate::system::processor::{process_seconds, thread_seconds};

/// The number of random rays of a round.
const RANDOM_RAYS: usize = 1 << 17;

/// A scene with the name of its root and the folder of its file.
pub(super) struct Subject {
    pub(super) scene: Scene,
    pub(super) root: Option<String>,
    /// `None` for a scene that names no pictures.
    pub(super) folder: Option<PathBuf>,
}

/// Measures a scene. The memory peak is valid only for the first scene of a run.
pub(super) fn measure(name: &str, subject: Subject, is_first: bool, args: &BenchArgs) -> Result<Row> {
    let Subject { mut scene, root, folder } = subject;
    let root = root.as_deref();
    let described = scene.primitives().count().max(scene.objects().map(|(_, o)| o.children().len()).sum());
    let compilation = Compilation::measure(&scene, root, is_first);
    let compiled = &compilation.compiled;
    let view = View::new(&scene.camera, args.size.width, args.size.height);
    let tiles = camera_tiles(&view, args.size.width, args.size.height);
    let ray_count: usize = tiles.iter().map(CameraTile::count).sum();
    let mut probe = TileProbe::new(compiled, view.footprint(1));
    let (hits, camera) = best(args.rounds, || tiles.iter().map(|tile| probe.find(tile)).sum::<usize>());
    let (_, settled) = best(args.rounds, || tiles.iter().map(|tile| probe.refine(tile)).sum::<usize>());
    let shadow = ShadowRound::best(&scene, &tiles, &mut probe, args.rounds)?;
    let random = random_rays(compiled, &view, args.seed);
    let (found, random_seconds) = best(args.rounds, || find_many(compiled, &random));
    let (_, random_settled_seconds) =
        best(args.rounds, || compiled.intersect_many(&random).iter().flatten().count());
    let (_, occlusion_seconds) = best(args.rounds, || {
        compiled.occluded_many(&random, f64::MAX).iter().filter(|&&is_occluded| is_occluded).count()
    });
    let picture_seconds = picture_seconds(&scene, compiled, folder.as_deref(), args)?;
    let recompile_seconds = recompile_seconds(&mut scene, compiled, root)?;

    let millions = |count: usize, seconds: f64| count as f64 / seconds / 1e6;
    let fraction = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
    let each = |bytes: f64| bytes / described.max(1) as f64;
    Ok(Row {
        scene: name.to_owned(),
        instances: compiled.instance_count().to_string(),
        described,
        camera_mrays: millions(ray_count, camera),
        camera_settled_mrays: millions(ray_count, settled),
        camera_hits: fraction(hits, ray_count),
        shadow_mrays: millions(shadow.count, shadow.seconds),
        shadow_stopped: fraction(shadow.occluded, shadow.count),
        random_mrays: millions(random.len(), random_seconds),
        random_settled_mrays: millions(random.len(), random_settled_seconds),
        random_hits: fraction(found, random.len()),
        random_occlusion_mrays: millions(random.len(), occlusion_seconds),
        picture_seconds,
        compile_seconds: compilation.seconds,
        compile_processor_seconds: compilation.processor_seconds,
        recompile_seconds,
        peak_bytes_per_primitive: compilation.peak_bytes.map(|bytes| each(bytes as f64)),
        bytes_per_primitive: each(compiled.bytes() as f64),
        compiled_bytes: compiled.bytes(),
        box_area_spared: compiled.box_inflation().mean_ratio,
    })
}

/// A compiled scene with the cost of its compilation.
struct Compilation {
    compiled: CompiledScene,
    seconds: f64,
    processor_seconds: f64,
    /// The peak memory beyond the memory before, in bytes.
    peak_bytes: Option<u64>,
}

impl Compilation {
    fn measure(scene: &Scene, root: Option<&str>, is_first: bool) -> Self {
        let before = reset_peak();
        let processor_before = process_seconds();
        let (compiled, seconds) = timed(|| CompiledScene::compile(scene, root, scene.depth));
        let processor_seconds = process_seconds() - processor_before;
        // Memory that earlier scenes have freed is reused and does not count.
        let peak_bytes = before
            .zip(peak_rss_bytes())
            .filter(|_| is_first)
            .map(|(before, peak)| peak.saturating_sub(before));
        Self { compiled, seconds, processor_seconds, peak_bytes }
    }
}

/// The shadow rays of a round.
struct ShadowRound {
    count: usize,
    occluded: usize,
    seconds: f64,
}

impl ShadowRound {
    /// The fastest of some rounds, towards the first light.
    fn best(scene: &Scene, tiles: &[CameraTile], probe: &mut TileProbe<'_>, rounds: u32) -> Result<Self> {
        let light = scene.lights().first().copied().context("a scene has a light")?;
        let mut best = Self { count: 0, occluded: 0, seconds: f64::INFINITY };
        for _ in 0..rounds {
            let mut round = Self { count: 0, occluded: 0, seconds: 0.0 };
            for tile in tiles {
                let ShadowTiming { rays: count, occluded, seconds } =
                    probe.shadows(tile, &light, &thread_seconds);
                round.count += count;
                round.occluded += occluded;
                round.seconds += seconds;
            }
            if round.seconds < best.seconds {
                best = round;
            }
        }
        Ok(best)
    }
}

/// The processor time of a picture with one sample per pixel, on one thread.
fn picture_seconds(
    scene: &Scene,
    compiled: &CompiledScene,
    folder: Option<&Path>,
    args: &BenchArgs,
) -> Result<f64> {
    let picture =
        Picture { width: args.size.width, height: args.size.height, samples: 1, noise: 0.0, ..scene.picture };
    let settings = settings_with_surroundings(scene, folder)?.with_picture(picture).with_layers(false);
    let options = RenderOptions::default().with_threads(1);
    let before = process_seconds();
    render(compiled, &settings, &options)?;
    Ok(process_seconds() - before)
}

/// The wall time to compile again after the last primitive has shrunk by 1 %.
fn recompile_seconds(scene: &mut Scene, compiled: &CompiledScene, root: Option<&str>) -> Result<f64> {
    let Some(last) = scene.primitives().map(|(name, _)| name.to_owned()).last() else { return Ok(0.0) };
    let primitive = scene.primitive_mut(&last)?;
    primitive.shape = Superquadric::new(primitive.shape.radii() * 0.99, primitive.shape.exponents())?;
    Ok(timed(|| compiled.recompile(scene, root, scene.depth)).1)
}

/// Rays with random origins in the bounding box and random directions, as wide as camera rays.
fn random_rays(scene: &CompiledScene, view: &View, seed: u64) -> Vec<TraceRay> {
    let Some(bounds) = scene.bounds() else { return Vec::new() };
    let mut random = Random::new(seed ^ 0x5eed);
    let (center, half) = (bounds.center(), bounds.half_extent());
    (0..RANDOM_RAYS)
        .map(|_| {
            let mut in_cube = || DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
            let origin = center + in_cube() * half;
            let direction = loop {
                let v = in_cube();
                if (0.01..=1.0).contains(&v.length_squared()) {
                    break v.normalize();
                }
            };
            TraceRay::new(Ray::new(origin, direction)).with_footprint(view.footprint(1))
        })
        .collect()
}

/// A result and its wall time in seconds.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// The result and the processor time in seconds of the fastest of some rounds.
fn best<T>(rounds: u32, mut work: impl FnMut() -> T) -> (T, f64) {
    let mut round = || {
        let before = thread_seconds();
        let result = work();
        (result, thread_seconds() - before)
    };
    let mut fastest = round();
    for _ in 1..rounds {
        let next = round();
        if next.1 < fastest.1 {
            fastest = next;
        }
    }
    fastest
}
