//! `superegg bench`: rays a second, compiling and memory, on scenes that anyone can make.

mod generated_scene;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_lang::load_text;
use superegg_render::measure::camera_tiles;
use superegg_render::{RenderOptions, RenderSettings, View, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::measure::{CameraTile, TileProbe, find_many};
use superegg_trace::{CompiledScene, FlightRay};

use crate::args::BenchArgs;
use crate::console;
use crate::files;
use crate::files::scene::load;
use crate::outcome::Outcome;
use crate::system::memory::{peak_rss_bytes, reset_peak};
use crate::system::processor::{process_seconds, thread_seconds};

/// The scene of the name `robot`.
const ROBOT: &str = include_str!("../../../../scenes/crane_arm.scn");
/// Random rays in a round.
const RANDOM_RAYS: usize = 1 << 17;

pub(crate) fn run(args: &BenchArgs) -> Result<Outcome> {
    if let Some(folder) = &args.save {
        for name in &args.scenes {
            let text = scene_text(name, args.seed)?;
            let file = folder.join(format!("{}.scn", name.replace([':', ','], "_")));
            files::write(&file, text.as_bytes())?;
            console::print(file.display())?;
        }
        return Ok(Outcome::Fine);
    }
    let is_piped = args.json.as_deref().is_some_and(files::is_standard_stream);
    let mut rows = Vec::new();
    for name in &args.scenes {
        let row = measure(name, rows.is_empty(), args)?;
        if !is_piped {
            if rows.is_empty() {
                console::print(HEAD)?;
            }
            console::print(row.line())?;
        }
        rows.push(row);
    }
    if !is_piped {
        console::print(LEGEND)?;
    }
    if let Some(path) = &args.json {
        files::write(path, format!("{}\n", serde_json::to_string_pretty(&rows)?).as_bytes())?;
    }
    Ok(Outcome::Fine)
}

/// A scene with the name of its root.
struct Subject {
    scene: Scene,
    root: Option<String>,
}

fn subject(name: &str, seed: u64) -> Result<Subject> {
    if name == "robot" {
        let (session, _) = load_text("robot", ROBOT);
        return Ok(Subject { root: session.selected().map(str::to_owned), scene: session.scene().clone() });
    }
    if let Some(made) = generated_scene::GeneratedScene::parse(name)? {
        return Ok(Subject { scene: made.scene(seed)?, root: Some(generated_scene::ROOT.to_owned()) });
    }
    if !Path::new(name).exists() {
        bail!("'{name}' is neither a file nor one of robot, cloud:N, glyphs:N, fractal:B,D");
    }
    let loaded = load(Path::new(name))?;
    loaded.print_diagnostics();
    let session = loaded.session;
    Ok(Subject { root: session.selected().map(str::to_owned), scene: session.scene().clone() })
}

fn scene_text(name: &str, seed: u64) -> Result<String> {
    if name == "robot" {
        return Ok(ROBOT.to_owned());
    }
    generated_scene::GeneratedScene::parse(name)?
        .map(|made| made.text(seed))
        .ok_or_else(|| anyhow!("'{name}' is none of robot, cloud:N, glyphs:N, fractal:B,D"))
}

/// What was measured of one scene. Rays are in millions a second on one core.
#[derive(Debug, Serialize)]
struct Row {
    scene: String,
    /// Instances of primitives in the picture: digits, however many.
    instances: String,
    /// Primitives and children that the scene has.
    described: usize,
    camera_mrays: f64,
    /// The same settled in f64.
    camera_settled_mrays: f64,
    camera_hits: f64,
    shadow_mrays: f64,
    shadow_stopped: f64,
    random_mrays: f64,
    /// The same settled in f64.
    random_settled_mrays: f64,
    random_hits: f64,
    random_occlusion_mrays: f64,
    /// Processor seconds of a whole picture, one sample a pixel, shadows and all.
    picture_seconds: f64,
    compile_seconds: f64,
    /// The processor seconds of all cores for it, which what else runs on the machine does not change.
    compile_processor_seconds: f64,
    /// Seconds to compile again after one primitive has changed.
    recompile_seconds: f64,
    /// The most memory resident while it was compiled, beyond what was before, a described primitive.
    peak_bytes_per_primitive: Option<f64>,
    /// What the compiled scene holds, a described primitive.
    bytes_per_primitive: f64,
    compiled_bytes: usize,
    /// The boxes of groups against those made of eight corners.
    box_area_spared: f64,
}

const HEAD: &str = "\
| scene | instances | camera | settled | shadow | random | random settled | random shadow | picture s | compile s | processor s | again s | peak bytes | bytes |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|";
const LEGEND: &str = "\
camera, shadow, random: million rays a second on one core, the best of the rounds; settled: the same rays with the crossing in f64
picture s: processor seconds of a whole picture with shadows, one sample a pixel; compile s: on all cores; processor s: of all cores together; again s: after one primitive has changed; bytes: a primitive of the description, at the peak of compiling (of the\nfirst scene of a run) and after it";

impl Row {
    fn line(&self) -> String {
        let mut line = String::new();
        let instances = match self.instances.len() {
            0..=9 => self.instances.clone(),
            digits => format!("{}e{}", &self.instances[..1], digits - 1),
        };
        let _ = write!(line, "| {} | {instances} |", self.scene);
        let mrays = [
            self.camera_mrays,
            self.camera_settled_mrays,
            self.shadow_mrays,
            self.random_mrays,
            self.random_settled_mrays,
            self.random_occlusion_mrays,
        ];
        for rate in mrays {
            let _ = write!(line, " {rate:.2} |");
        }
        let seconds = [
            self.picture_seconds,
            self.compile_seconds,
            self.compile_processor_seconds,
            self.recompile_seconds,
        ];
        for seconds in seconds {
            let _ = write!(line, " {seconds:.3} |");
        }
        match self.peak_bytes_per_primitive {
            Some(bytes) => {
                let _ = write!(line, " {bytes:.0} |");
            }
            None => line.push_str(" - |"),
        }
        let _ = write!(line, " {:.0} |", self.bytes_per_primitive);
        line
    }
}

fn measure(name: &str, is_first: bool, args: &BenchArgs) -> Result<Row> {
    let Subject { mut scene, root } = subject(name, args.seed)?;
    let root = root.as_deref();
    let described = scene.primitives().count().max(scene.objects().map(|(_, o)| o.children().len()).sum());
    let before = reset_peak();
    let processor_before = process_seconds();
    let (compiled, compile_seconds) = timed(|| CompiledScene::compile(&scene, root, scene.depth));
    let compile_processor_seconds = process_seconds() - processor_before;
    // Memory that earlier scenes have left is taken again, and would not count.
    let peak =
        before.zip(peak_rss_bytes()).filter(|_| is_first).map(|(before, peak)| peak.saturating_sub(before));

    let view = View::new(&scene.camera, args.size.width, args.size.height);
    let tiles = camera_tiles(&view, args.size.width, args.size.height);
    let rays: usize = tiles.iter().map(CameraTile::count).sum();
    let mut probe = TileProbe::new(&compiled, view.footprint(1));
    let (hits, camera) = best(args.rounds, || tiles.iter().map(|tile| probe.find(tile)).sum::<usize>());
    let (_, settled) = best(args.rounds, || tiles.iter().map(|tile| probe.settle(tile)).sum::<usize>());
    let light = scene.lights().first().copied().context("a scene has a light")?;
    let mut shadow = (0, 0, f64::INFINITY);
    for _ in 0..args.rounds {
        let mut round = (0, 0, 0.0);
        for tile in &tiles {
            let (count, stopped, time) = probe.shadows(tile, &light, &thread_seconds);
            round = (round.0 + count, round.1 + stopped, round.2 + time);
        }
        if round.2 < shadow.2 {
            shadow = round;
        }
    }
    let random = random_rays(&compiled, &view, args.seed);
    let (found, random_seconds) = best(args.rounds, || find_many(&compiled, &random));
    let (_, random_settled_seconds) =
        best(args.rounds, || compiled.intersect_many(&random).iter().flatten().count());
    let (_, occlusion_seconds) = best(args.rounds, || {
        compiled.occluded_many(&random, f64::MAX).iter().filter(|&&stops| stops).count()
    });

    let picture_seconds = picture(&scene, &compiled, args)?;
    let recompile_seconds = match scene.primitives().map(|(name, _)| name.to_owned()).last() {
        None => 0.0,
        Some(last) => {
            let radii = scene.primitive_mut(&last)?.shape.radii() * 0.99;
            let exponents = scene.primitive_mut(&last)?.shape.exponents();
            scene.primitive_mut(&last)?.shape = superegg_geom::Superquadric::new(radii, exponents)?;
            timed(|| compiled.recompile(&scene, root, scene.depth)).1
        }
    };
    let millions = |count: usize, seconds: f64| count as f64 / seconds / 1e6;
    let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
    let each = |bytes: f64| bytes / described.max(1) as f64;
    Ok(Row {
        scene: name.to_owned(),
        instances: compiled.instance_count().to_string(),
        described,
        camera_mrays: millions(rays, camera),
        camera_settled_mrays: millions(rays, settled),
        camera_hits: share(hits, rays),
        shadow_mrays: millions(shadow.0, shadow.2),
        shadow_stopped: share(shadow.1, shadow.0),
        random_mrays: millions(random.len(), random_seconds),
        random_settled_mrays: millions(random.len(), random_settled_seconds),
        random_hits: share(found, random.len()),
        random_occlusion_mrays: millions(random.len(), occlusion_seconds),
        picture_seconds,
        compile_seconds,
        compile_processor_seconds,
        recompile_seconds,
        peak_bytes_per_primitive: peak.map(|bytes| each(bytes as f64)),
        bytes_per_primitive: each(compiled.bytes() as f64),
        compiled_bytes: compiled.bytes(),
        box_area_spared: compiled.swelling().avoided,
    })
}

/// The processor seconds of a picture.
fn picture(scene: &Scene, compiled: &CompiledScene, args: &BenchArgs) -> Result<f64> {
    let picture =
        Picture { width: args.size.width, height: args.size.height, samples: 1, noise: 0.0, ..scene.picture };
    let settings = RenderSettings::of(scene).with_picture(picture).with_layers(false);
    let options = RenderOptions::default().with_threads(1);
    let before = process_seconds();
    render(compiled, &settings, &options)?;
    Ok(process_seconds() - before)
}

/// Rays from anywhere in the scene's box to anywhere, as wide as those of the camera.
fn random_rays(scene: &CompiledScene, view: &View, seed: u64) -> Vec<FlightRay> {
    let Some(bounds) = scene.bounds() else { return Vec::new() };
    let mut random = generated_scene::Random::new(seed ^ 0x5eed);
    let (center, half) = (bounds.center(), bounds.half_extent());
    (0..RANDOM_RAYS)
        .map(|_| {
            let mut within = || DVec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
            let origin = center + within() * half;
            let direction = loop {
                let v = within();
                if (0.01..=1.0).contains(&v.length_squared()) {
                    break v.normalize();
                }
            };
            FlightRay { footprint: view.footprint(1), ..Ray::new(origin, direction).into() }
        })
        .collect()
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let clock = Instant::now();
    let answer = work();
    (answer, clock.elapsed().as_secs_f64())
}

/// The answer, and the processor seconds of the fastest of some rounds.
fn best<T>(rounds: u32, mut work: impl FnMut() -> T) -> (T, f64) {
    let mut timed = || {
        let before = thread_seconds();
        let answer = work();
        (answer, thread_seconds() - before)
    };
    let mut fastest = timed();
    for _ in 1..rounds {
        let round = timed();
        if round.1 < fastest.1 {
            fastest = round;
        }
    }
    fastest
}
