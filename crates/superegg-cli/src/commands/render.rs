//! `superegg render`: a scene into a picture.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde::Serialize;
use superegg_lang::write_scene;
use superegg_render::{Film, Output, PartHeader, RayCounts, RenderOptions, RenderSettings, Shard};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

use crate::args::RenderArgs;
use crate::commands::input::still_at;
use crate::console;
use crate::files;
use crate::files::picture::PictureFormat;
use crate::files::scene::load;
use crate::inspect::picture_warnings::picture_warnings;
use crate::long::checkpoint::{checkpoint_path, has_layers};
use crate::long::resumable::ResumableRender;
use crate::long::shard::ShardArg;
use crate::outcome::Outcome;
use crate::progress::progress_bar;
use crate::system::interrupt::Interrupt;
use crate::system::memory::peak_rss_bytes;
use crate::system::processor::available_threads;
use crate::text::counted;

pub(crate) fn run(args: &RenderArgs) -> Result<Outcome> {
    let share = args.long.tiles.map(ShardArg::resolve).transpose().context("cannot determine the shard")?;
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene, share));
    for place in [Some(output.as_path()), args.stats.as_deref()] {
        files::check_output(place, &args.scene)?;
    }
    let format = format_of(&output, share)?;
    let mut clock = Clock::start();
    let loaded = load(&args.scene)?;
    let parse = clock.lap();
    loaded.print_diagnostics();

    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let still = args.frame.map(|frame| still_at(&loaded.session, frame)).transpose()?;
    let scene = still.as_ref().unwrap_or(loaded.session.scene());
    let depth = args.depth.unwrap_or(scene.depth);
    let compiled = CompiledScene::compile(scene, root.as_deref(), depth);
    let compile = clock.lap();
    // Shares may become any kind of picture, and what has layers goes on with them.
    let has_layers = args.long.resume && has_layers(&checkpoint_path(&output));
    let layers = share.is_some() || format == Some(PictureFormat::Exr) || has_layers;
    let settings = settings_of(args, scene).with_layers(layers);
    let picture = settings.picture;
    for concern in picture_warnings(&compiled, &settings) {
        console::warn(format_args!("superegg: warning: {concern}"));
    }
    if args.max_samples.is_some() && picture.noise == 0.0 {
        console::warn(
            "superegg: warning: --max-samples changes nothing without --noise, for each pixel takes --samples",
        );
    }
    if let Some(root) =
        root.as_deref().filter(|_| scene.floor.is_none() && compiled.instance_count().to_string() == "0")
    {
        console::warn(format_args!(
            "superegg: warning: '{root}' has no visible parts: the picture shows only the background"
        ));
    }

    let threads = args.threads.map_or_else(available_threads, usize::from);
    let header = || {
        let text = write_scene(scene, loaded.session.selected());
        let whole = share.unwrap_or(Shard::WHOLE);
        PartHeader::new(env!("CARGO_PKG_VERSION"), &text, root.as_deref(), depth, &settings, whole)
    };
    let tell = |told: &str| console::warn(format_args!("superegg: {told}"));
    let inform = |told: &str| {
        if !args.quiet {
            tell(told);
        }
    };
    let mut work = ResumableRender::new(&output, share, args.long.resume, &picture, header, &inform)?;
    let interrupt = Interrupt::listen()?;
    let bar = progress_bar(work.wanted_pixels(), args.quiet, "{rate}");
    let progress = |pixels| bar.set_position(pixels);
    let options =
        RenderOptions::default().with_threads(threads).with_cancel(interrupt.flag()).with_progress(&progress);
    let rendered = work.render(&compiled, &settings, &options, &|told| bar.suspend(|| tell(told)));
    bar.finish_and_clear();
    interrupt.work_ended();
    let (film, trace_stats) = rendered?;
    let render = clock.lap();
    let stopped = work.finish(&output, &film, || match format {
        Some(format) => files::write(&output, &format.encode(&film, &settings)?),
        None => Ok(()),
    })?;
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
            stand_in_rays: trace_stats.proxy_hits,
        },
        width: picture.width,
        height: picture.height,
        samples: picture.samples,
        samples_taken: (picture.noise > 0.0).then(|| SamplesTaken::of(&film)),
        threads,
        rays: trace_stats.rays.into(),
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
        console::print(format_args!(
            "{}: {}x{}, {}{}, {render:.1} s{}{}",
            output.display(),
            stats.width,
            stats.height,
            share.map_or_else(String::new, |share| format!("shard {share}, ")),
            counted(&stats.instances, "instance"),
            shown(&settings, &film, stats.samples_taken.as_ref()),
            limits(&stats)
        ))?;
    }
    let outcome = Outcome::of_input(loaded.has_errors());
    // The process ends, and its memory with it: to take a large scene apart first takes a while.
    std::mem::forget((loaded, compiled));
    Ok(outcome)
}

/// The settings that the scene has, but for what the arguments say.
fn settings_of(args: &RenderArgs, scene: &Scene) -> RenderSettings {
    let of_scene = args.develop.change(scene.picture);
    let (width, height) =
        args.size.map_or((of_scene.width, of_scene.height), |size| (size.width, size.height));
    let picture = Picture {
        width,
        height,
        samples: args.samples.unwrap_or(of_scene.samples),
        noise: args.noise.unwrap_or(of_scene.noise),
        most_samples: args.max_samples.unwrap_or(of_scene.most_samples),
        filter: args.filter.map_or(of_scene.filter, Into::into),
        transparent: args.transparent || of_scene.transparent,
        bounces: args.bounces.unwrap_or(of_scene.bounces),
        ..of_scene
    };
    let output = args.view.map_or(Output::Light, Into::into);
    RenderSettings::of(scene).with_picture(picture).with_output(output)
}

/// What is told of samples and of the scale of what is shown, where there is more to tell than what was asked for.
fn shown(settings: &RenderSettings, film: &Film, taken: Option<&SamplesTaken>) -> String {
    let mut text = String::new();
    if let Some(taken) = taken {
        text += &format!("; {:.1} samples a pixel, {} at most", taken.mean, taken.most);
    }
    if settings.output == Output::Steps {
        let most = film.pixels().map(|pixel| pixel.color[0]).fold(0.0, f32::max);
        text += &format!("; white is {most:.1} boxes and shapes a ray");
    }
    text
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
fn default_output(scene: &Path, share: Option<Shard>) -> PathBuf {
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

/// The format of the picture; `None` for a share, which is none.
fn format_of(output: &Path, share: Option<Shard>) -> Result<Option<PictureFormat>> {
    let is_part = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("part"));
    let name = output.display();
    match share {
        Some(_) if is_part => Ok(None),
        Some(_) => bail!(
            "a shard is no picture, so -o takes NAME.part, not '{name}'; 'superegg merge' makes the picture"
        ),
        None if is_part => {
            bail!("'{name}' would be a partial file; --tiles K/N renders one, or name a picture")
        }
        None => PictureFormat::of(output).map(Some),
    }
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
    /// Samples a pixel that were asked for.
    samples: u32,
    /// Where pixels stop by themselves.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples_taken: Option<SamplesTaken>,
    threads: usize,
    rays: Rays,
    seconds: Seconds,
    peak_rss_bytes: Option<u64>,
}

/// Samples that pixels took.
#[derive(Debug, Serialize)]
struct SamplesTaken {
    mean: f64,
    most: u32,
}

impl SamplesTaken {
    fn of(film: &Film) -> Self {
        // Of the pixels that have been made.
        let taken = || film.pixels().map(|pixel| pixel.samples).filter(|samples| *samples > 0);
        let total: u64 = taken().map(u64::from).sum();
        Self { mean: total as f64 / taken().count().max(1) as f64, most: taken().max().unwrap_or(0) }
    }
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
    /// Where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    ambient: Option<u64>,
    reflection: u64,
    refraction: u64,
}

impl From<RayCounts> for Rays {
    fn from(RayCounts { camera, shadow, ambient, reflection, refraction }: RayCounts) -> Self {
        Self { camera, shadow, ambient: Some(ambient).filter(|count| *count > 0), reflection, refraction }
    }
}

#[derive(Debug, Serialize)]
struct Seconds {
    parse: f64,
    compile: f64,
    render: f64,
    write: f64,
}
