//! `superegg animate`: a scene into the frames of a film, and those into the film.

mod film_file;
mod frame_folder;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use superegg_lang::{Session, write_scene};
use superegg_render::{RenderOptions, RenderSettings, Shard, render};
use superegg_scene::{Picture, Scene, Track};
use superegg_trace::CompiledScene;

use crate::args::{AnimateArgs, FrameRange};
use crate::commands::input::still_at;
use crate::console;
use crate::files;
use crate::files::picture::PictureFormat;
use crate::files::scene::load;
use crate::inspect::picture_warnings::picture_warnings;
use crate::long::shard::ShardArg;
use crate::outcome::Outcome;
use crate::progress::progress_bar;
use crate::system::interrupt::Interrupt;
use crate::system::processor::available_threads;
use crate::text::counted;
use film_file::FilmFormat;
use frame_folder::FrameFolder;

pub(crate) fn run(args: &AnimateArgs) -> Result<Outcome> {
    let target = Target::of(args)?;
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let plan = Plan::of(args, loaded.session.scene())?;
    // Before hours of work are done for frames up to the one that cannot be.
    for frame in plan.frames() {
        plan.still(&loaded.session, frame)?;
    }
    let mut folder = FrameFolder::open(&target.folder)?;
    let interrupt = Interrupt::listen()?;

    let start = Instant::now();
    let made = make_frames(args, &plan, &loaded.session, root.as_deref(), &mut folder, interrupt.flag())?;
    interrupt.work_ended();
    if interrupt.flag().load(Ordering::Relaxed) {
        console::warn(format_args!(
            "superegg: stopped: {} of {} are in '{}'; the same command goes on from there",
            made.rendered + made.kept,
            counted(plan.own_frames().count(), "frame"),
            target.folder.display()
        ));
        return Ok(Outcome::Stopped(interrupt.exit_code()));
    }
    if !args.quiet {
        let kept = if made.kept > 0 { format!(", {} kept from before", made.kept) } else { String::new() };
        console::print(format_args!(
            "{}: {}{} of {}x{}, {} rendered{kept}, {:.1} s",
            target.folder.display(),
            plan.share.map_or_else(String::new, |share| format!("shard {share}, ")),
            counted(plan.own_frames().count(), "frame"),
            plan.size.0,
            plan.size.1,
            made.rendered,
            start.elapsed().as_secs_f64()
        ))?;
    }
    if let Some((path, format)) = target.film.as_ref().filter(|_| plan.share.is_none()) {
        format.make(path, &folder, plan.frames(), args.fps, loaded.session.scene().picture.transparent)?;
        if !args.quiet {
            let seconds = plan.frames().len() as f64 / args.fps;
            console::print(format_args!(
                "{}: {seconds:.1} s at {} frames a second",
                path.display(),
                args.fps
            ))?;
        }
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}

/// Where frames and film go.
struct Target {
    folder: PathBuf,
    film: Option<(PathBuf, FilmFormat)>,
}

impl Target {
    /// A name that ends as a film does is the film's, with its frames in a folder beside it; any other is the folder's.
    fn of(args: &AnimateArgs) -> Result<Self> {
        let frames_of = |path: &Path| {
            let stem = path.file_stem().filter(|_| !files::is_standard_stream(path));
            let mut name = stem.unwrap_or("scene".as_ref()).to_owned();
            name.push("_frames");
            name
        };
        let Some(output) = &args.output else {
            return Ok(Self { folder: PathBuf::from(frames_of(&args.scene)), film: None });
        };
        if files::is_standard_stream(output) {
            bail!("frames and films go into files, not to standard output; name a folder or a film with -o");
        }
        match FilmFormat::of(output) {
            Some(format) => {
                files::check_output(Some(output), &args.scene)?;
                Ok(Self {
                    folder: output.with_file_name(frames_of(output)),
                    film: Some((output.clone(), format)),
                })
            }
            None if output.extension().is_some() && !output.is_dir() => bail!(
                "'{}' names no film that can be made; end it in {}, or name a folder without an ending",
                output.display(),
                FilmFormat::ENDINGS
            ),
            None => Ok(Self { folder: output.clone(), film: None }),
        }
    }
}

/// What frames there are, and what is seen in each.
struct Plan {
    range: FrameRange,
    /// In so many frames the camera goes round once.
    turn: Option<u32>,
    /// Width and height in pixels, the same for the whole film.
    size: (u32, u32),
    /// Samples a pixel, instead of what the scene says.
    samples: Option<u32>,
    /// The share of the frames that is made here, where not all are.
    share: Option<Shard>,
}

impl Plan {
    fn of(args: &AnimateArgs, scene: &Scene) -> Result<Self> {
        let range = match (args.frames, args.turntable) {
            (Some(range), _) => range,
            (None, Some(count)) => FrameRange { first: 0, last: count - 1 },
            (None, None) => keyed_range(scene).ok_or_else(|| {
                anyhow!(
                    "the scene has no keys, so nothing moves: --turntable N lets the camera go round in N frames; \
                     'key FRAME COMMAND' in the scene sets keys"
                )
            })?,
        };
        if args.turntable.is_none() && scene.tracks().len() == 0 {
            console::warn("superegg: warning: the scene has no keys, so all frames are alike");
        }
        let Picture { width, height, .. } = scene.picture;
        let size = args.size.map_or((width, height), |size| (size.width, size.height));
        let share = args.tiles.map(ShardArg::resolve).transpose().context("cannot determine the shard")?;
        Ok(Self { range, turn: args.turntable, size, samples: args.samples, share })
    }

    fn frames(&self) -> impl ExactSizeIterator<Item = u32> + use<> {
        // A range that has its end would not know its length.
        let first = self.range.first;
        (0..(self.range.last - first + 1) as usize).map(move |i| first + i as u32)
    }

    /// Those that are made here.
    fn own_frames(&self) -> impl Iterator<Item = u32> + use<> {
        let share = self.share.unwrap_or(Shard::WHOLE);
        self.frames().enumerate().filter(move |(place, _)| share.takes(*place)).map(|(_, frame)| frame)
    }

    /// The scene at a frame, as the camera sees it on its way round.
    fn still(&self, session: &Session, frame: u32) -> Result<Scene> {
        let mut still = still_at(session, f64::from(frame))?;
        (still.picture.width, still.picture.height) = self.size;
        still.picture.samples = self.samples.unwrap_or(still.picture.samples);
        if let Some(count) = self.turn {
            let share = f64::from((frame - self.range.first) % count) / f64::from(count);
            still.camera = still.camera.orbited(360.0 * share);
        }
        Ok(still)
    }
}

/// From the first key to the last.
fn keyed_range(scene: &Scene) -> Option<FrameRange> {
    let frames = || scene.tracks().flat_map(Track::keys).map(|key| key.frame);
    let first = frames().reduce(f64::min)?.floor().clamp(0.0, f64::from(FrameRange::MOST));
    let last = frames().reduce(f64::max)?.ceil().clamp(first, f64::from(FrameRange::MOST));
    Some(FrameRange { first: first as u32, last: last as u32 })
}

/// How many frames were made, and how many were there.
#[derive(Default)]
struct FrameCounts {
    rendered: usize,
    kept: usize,
}

/// Makes the frames that are not there, until there are all or `cancel` turns true.
fn make_frames(
    args: &AnimateArgs,
    plan: &Plan,
    session: &Session,
    root: Option<&str>,
    folder: &mut FrameFolder,
    cancel: &AtomicBool,
) -> Result<FrameCounts> {
    let pixels = u64::from(plan.size.0) * u64::from(plan.size.1);
    let bar = progress_bar(pixels * plan.own_frames().count() as u64, args.quiet, "frame {msg}");
    let threads = args.threads.map_or_else(available_threads, usize::from);
    let mut made = FrameCounts::default();
    let mut before: Option<CompiledScene> = None;
    for (place, frame) in plan.own_frames().enumerate() {
        let start = pixels * place as u64;
        bar.set_position(start);
        bar.set_message(frame.to_string());
        let still = plan.still(session, frame)?;
        let depth = args.depth.unwrap_or(still.depth);
        let signature = signature(&still, root, depth);
        if folder.has(frame, signature) {
            made.kept += 1;
            continue;
        }
        let compiled = match &before {
            Some(before) => before.recompile(&still, root, depth),
            None => CompiledScene::compile(&still, root, depth),
        };
        let settings = RenderSettings::of(&still).with_layers(false);
        for concern in picture_warnings(&compiled, &settings).iter().filter(|_| before.is_none()) {
            bar.suspend(|| console::warn(format_args!("superegg: warning: frame {frame}: {concern}")));
        }
        let progress = |pixels| bar.set_position(start + pixels);
        let options =
            RenderOptions::default().with_threads(threads).with_cancel(cancel).with_progress(&progress);
        let rendered = render(&compiled, &settings, &options)?;
        if cancel.load(Ordering::Relaxed) {
            break;
        }
        folder.write(frame, signature, &PictureFormat::Png.encode(&rendered.film, &settings)?)?;
        made.rendered += 1;
        before = Some(compiled);
    }
    bar.finish_and_clear();
    Ok(made)
}

/// What tells frames apart: all that a picture depends on.
fn signature(still: &Scene, root: Option<&str>, depth: u32) -> u64 {
    let text = format!("{} {root:?} {depth}\n{}", env!("CARGO_PKG_VERSION"), write_scene(still, root));
    frame_folder::hash(text.as_bytes())
}
