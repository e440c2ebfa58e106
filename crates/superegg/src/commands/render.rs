//! `superegg render`: a scene into a picture.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use superegg_lang::write_session;
use superegg_render::{CompiledScene, PartHeader, RayCounts, RenderBudget, RenderSettings, Share};
use superegg_scene::Picture;

use crate::args::RenderArgs;
use crate::commands::{Outcome, available_threads, counted};
use crate::files;
use crate::interrupt::Interrupt;
use crate::load::load;
use crate::long_render::LongRender;
use crate::memory::peak_rss_bytes;
use crate::say;
use crate::share::ShareArg;

pub(crate) fn run(args: &RenderArgs) -> Result<Outcome> {
    let share =
        args.long.tiles.map(ShareArg::share).transpose().context("cannot tell the share for --tiles")?;
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene, share));
    check_ending(&output, share)?;
    for place in [Some(output.as_path()), args.stats.as_deref()] {
        files::check_writable_place(place, &args.scene)?;
    }
    let mut clock = Clock::start();
    let loaded = load(&args.scene)?;
    let parse = clock.lap();
    loaded.print_diagnostics();

    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let scene = loaded.session.scene();
    let depth = args.depth.unwrap_or(scene.depth);
    let compiled = CompiledScene::compile(scene, root.as_deref(), depth);
    let compile = clock.lap();
    if let Some(root) = root.as_deref().filter(|_| compiled.instance_count().to_string() == "0") {
        say::complain(format_args!(
            "superegg: warning: '{root}' comes to nothing: the picture will show only the background"
        ));
    }

    let threads = args.threads.map_or_else(available_threads, usize::from);
    let picture = picture_of(args, scene.picture);
    let settings = RenderSettings { picture, ..RenderSettings::of(scene) };
    let header = || {
        let text = write_session(&loaded.session);
        let whole = share.unwrap_or(Share::WHOLE);
        PartHeader::new(env!("CARGO_PKG_VERSION"), &text, root.as_deref(), depth, &settings, whole)
    };
    let tell = |told: &str| say::complain(format_args!("superegg: {told}"));
    let inform = |told: &str| {
        if !args.quiet {
            tell(told);
        }
    };
    let mut work = LongRender::new(&output, share, args.long.resume, &picture, header, &inform)?;
    let interrupt = Interrupt::listen()?;
    let bar = progress_bar(work.wanted_pixels(), args.quiet);
    let budget =
        RenderBudget { threads, cancel: interrupt.flag(), progress: &|pixels| bar.set_position(pixels) };
    let rendered = work.render(&compiled, &settings, &budget, &|told| bar.suspend(|| tell(told)));
    bar.finish_and_clear();
    let rendered = rendered?;
    let render = clock.lap();
    let stopped =
        work.conclude(&output, || files::write(&output, &rendered.film.to_png(picture.encoding)?))?;
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
    if let Some(stopped) = stopped {
        tell(&format!("stopped: {stopped}"));
        return Ok(Outcome::Stopped(interrupt.exit_code()));
    }
    if !args.quiet && !is_piped {
        say::out(format_args!(
            "{}: {}x{}, {}{}, {render:.1} s{}",
            output.display(),
            stats.width,
            stats.height,
            share.map_or_else(String::new, |share| format!("share {share}, ")),
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

/// The scene's name with .png, or with the share and .part, in the current folder.
fn default_output(scene: &Path, share: Option<Share>) -> PathBuf {
    let stem = scene.file_stem().filter(|_| !files::is_standard_stream(scene));
    let mut name = stem.unwrap_or("scene".as_ref()).to_owned();
    name.push(match share {
        // As many digits for each, so that names are in order.
        Some(share) => {
            let digits = share.count().to_string().len();
            format!("-{:0digits$}-of-{}.part", share.number(), share.count())
        }
        None => ".png".to_owned(),
    });
    PathBuf::from(name)
}

/// Refuses to write a share where a picture would be expected, and the other way round.
fn check_ending(output: &Path, share: Option<Share>) -> Result<()> {
    let is_part = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("part"));
    let name = output.display();
    match share {
        Some(_) if !is_part => {
            bail!(
                "a share is no picture, so -o takes NAME.part, not '{name}'; 'superegg merge' makes the picture"
            )
        }
        None if is_part => {
            bail!("'{name}' would be a partial file; --tiles K/N renders one, or name a picture")
        }
        _ => Ok(()),
    }
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
