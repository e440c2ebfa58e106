//! `superegg render`: a scene into a picture.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use superegg_render::{CompiledScene, RayCounts, RenderBudget, RenderSettings, Rendered, render};
use superegg_scene::{Picture, Scene};

use crate::args::RenderArgs;
use crate::commands::{Outcome, available_threads, counted};
use crate::files;
use crate::load::load;
use crate::memory::peak_rss_bytes;
use crate::say;

pub(crate) fn run(args: &RenderArgs) -> Result<Outcome> {
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene));
    for place in [Some(output.as_path()), args.stats.as_deref()] {
        files::check_writable_place(place, &args.scene)?;
    }
    let mut clock = Clock::start();
    let loaded = load(&args.scene)?;
    let parse = clock.lap();
    loaded.print_diagnostics();

    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let scene = loaded.session.scene();
    let compiled = CompiledScene::compile(scene, root.as_deref(), args.depth.unwrap_or(scene.depth));
    let compile = clock.lap();
    if let Some(root) = root.filter(|_| compiled.instance_count().to_string() == "0") {
        say::complain(format_args!(
            "superegg: warning: '{root}' comes to nothing: the picture will show only the background"
        ));
    }

    let threads = args.threads.map_or_else(available_threads, usize::from);
    let picture = picture_of(args, scene.picture);
    let rendered = draw(scene, &compiled, picture, args.quiet, threads)?;
    let render = clock.lap();
    files::write(&output, &rendered.film.to_png(picture.encoding)?)?;
    let write = clock.lap();

    let stats = Stats {
        primitives: scene.primitives().count(),
        objects: scene.objects().count(),
        groups: compiled.group_count(),
        instances: compiled.instance_count().to_string(),
        compiled: Compiled {
            bytes: compiled.bytes(),
            box_area_spared: compiled.swelling().avoided,
            reaches_depth: compiled.reaches_depth(),
            stand_in_rays: rendered.stand_ins,
        },
        width: picture.width,
        height: picture.height,
        samples: picture.samples,
        threads,
        rays: rendered.rays.into(),
        seconds: Seconds { parse, compile, render, write },
        peak_rss_bytes: peak_rss_bytes(),
    };
    if let Some(path) = &args.stats {
        files::write(path, format!("{}\n", serde_json::to_string_pretty(&stats)?).as_bytes())?;
    }
    let is_piped =
        [Some(output.as_path()), args.stats.as_deref()].into_iter().flatten().any(files::is_standard_stream);
    if !args.quiet && !is_piped {
        say::out(format_args!(
            "{}: {}x{}, {}, {render:.1} s{}",
            output.display(),
            stats.width,
            stats.height,
            counted(&stats.instances, "instance"),
            limits(&stats)
        ))?;
    }
    Ok(Outcome::of(&loaded))
}

/// The picture as the scene has it, but for what the arguments say.
fn picture_of(args: &RenderArgs, scene: Picture) -> Picture {
    let (width, height) = args.size.map_or((scene.width, scene.height), |size| (size.width, size.height));
    Picture {
        width,
        height,
        samples: args.samples.unwrap_or(scene.samples),
        encoding: args.encoding.map_or(scene.encoding, Into::into),
        ..scene
    }
}

/// The limits that the picture came to, to be said once.
fn limits(stats: &Stats) -> String {
    let mut limits = String::new();
    if stats.compiled.reaches_depth {
        limits += "; objects deeper than the depth limit are left out";
    }
    if stats.compiled.stand_in_rays > 0 {
        limits += &format!(
            "; {} met the average of an object smaller than half a pixel",
            counted(stats.compiled.stand_in_rays, "ray")
        );
    }
    limits
}

/// The scene's name with .png, in the current folder.
fn default_output(scene: &Path) -> PathBuf {
    let stem = scene.file_stem().filter(|_| !files::is_standard_stream(scene));
    let mut name = stem.unwrap_or("scene".as_ref()).to_owned();
    name.push(".png");
    PathBuf::from(name)
}

fn draw(
    scene: &Scene,
    compiled: &CompiledScene,
    picture: Picture,
    quiet: bool,
    threads: usize,
) -> Result<Rendered> {
    let settings = RenderSettings { picture, ..RenderSettings::of(scene) };
    let bar = progress_bar(u64::from(picture.width) * u64::from(picture.height), quiet);
    let budget = RenderBudget {
        threads,
        cancel: &AtomicBool::new(false),
        progress: &|pixels| bar.set_position(pixels),
    };
    let rendered = render(compiled, &settings, &budget).context("cannot start the threads");
    bar.finish_and_clear();
    rendered
}

/// A bar on standard error; hidden where that is no terminal.
fn progress_bar(pixels: u64, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {elapsed} gone, {eta} to go");
    ProgressBar::with_draw_target(Some(pixels), target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Seconds between laps.
struct Clock(Instant);

impl Clock {
    fn start() -> Self {
        Self(Instant::now())
    }

    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now.duration_since(self.0).as_secs_f64();
        self.0 = now;
        lap
    }
}

/// What `--stats` writes.
#[derive(Debug, Serialize)]
struct Stats {
    /// Primitives that the scene has, in the picture or not.
    primitives: usize,
    /// Objects likewise.
    objects: usize,
    /// Nodes of the compiled graph.
    groups: usize,
    /// Instances of primitives in the picture: digits, however many.
    instances: String,
    compiled: Compiled,
    width: u32,
    height: u32,
    samples: u32,
    threads: usize,
    rays: Rays,
    seconds: Seconds,
    peak_rss_bytes: Option<u64>,
}

/// The compiled scene, and the limits that the picture came to.
#[derive(Debug, Serialize)]
struct Compiled {
    /// What it holds, in bytes.
    bytes: usize,
    /// The mean area of boxes made of eight corners, as a multiple of that of the boxes in use, over children that are objects.
    box_area_spared: f64,
    /// Whether objects were left out at the depth limit.
    reaches_depth: bool,
    /// Rays that saw the average of an object smaller than half a pixel.
    stand_in_rays: u64,
}

#[derive(Debug, Serialize)]
struct Rays {
    camera: u64,
    shadow: u64,
    ambient: u64,
    reflection: u64,
    refraction: u64,
}

impl From<RayCounts> for Rays {
    fn from(RayCounts { camera, shadow, ambient, reflection, refraction }: RayCounts) -> Self {
        Self { camera, shadow, ambient, reflection, refraction }
    }
}

#[derive(Debug, Serialize)]
struct Seconds {
    parse: f64,
    compile: f64,
    render: f64,
    write: f64,
}
