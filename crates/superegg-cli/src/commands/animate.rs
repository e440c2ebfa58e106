//! `superegg animate`: renders the frames of an animation and encodes them as a film.

mod film_file;
mod frame_folder;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use indicatif::ProgressBar;
use superegg_lang::Session;
use superegg_render::{Framing, RenderOptions, RenderSettings, Shard, render};
use superegg_scene::{Picture, Scene, Track};
use superegg_trace::CompiledScene;

use crate::annotate::Annotations;
use crate::args::{AnimateArgs, FrameRange, PictureArgs};
use crate::commands::input::still_at;
use crate::console;
use crate::denoise::{self, denoised};
use crate::files;
use crate::files::fingerprint::{PictureHashes, hash};
use crate::files::notes::notes;
use crate::files::scene::load_with;
use crate::files::series::Series;
use crate::files::surroundings::ReadPictures;
use crate::inspect::framing::framed_root;
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
    let target = Target::from_args(args)?;
    args.annotations.check(&args.data)?;
    let options = args.data.options(None, args.annotations.framed(args.picture.size));
    let series = Series::of(&args.scene, &options)?;
    let loaded = load_with(&args.scene, &options)?;
    loaded.print_warnings(args.quiet);
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let root = series.as_ref().map_or(root, |series| Some(series.root.clone()));
    let legend = series.as_ref().map_or(&loaded.legend, |series| &series.legend);
    let annotations = args.annotations.with_legend(legend.clone())?;
    let scene = loaded.session.scene();
    let mut plan = Plan::from_args(args, scene, series.as_ref())?;
    let stills = Stills { session: &loaded.session, series: series.as_ref() };
    plan.frame_unseen(&stills, root.as_deref(), args.depth)?;
    // Find a frame that cannot be rendered before hours of work on the frames before it.
    for frame in plan.frames().filter(|_| series.is_none()) {
        plan.still(&stills, frame)?;
    }
    let mut folder = FrameFolder::open(&target.folder, args.overwrite.into(), plan.shard.is_some())?;
    plan.own_frames().try_for_each(|frame| folder.check_replaceable(frame))?;
    let interrupt = Interrupt::listen()?;

    let start = Instant::now();
    let renderer = FrameRenderer { args, plan: &plan, stills, root: root.as_deref(), annotations };
    let counts = renderer.render_frames(&mut folder, interrupt.flag())?;
    interrupt.work_ended();
    if interrupt.flag().load(Ordering::Relaxed) {
        console::warn(format_args!(
            "superegg: stopped: {} of {} are in '{}'; the same command goes on from there",
            counts.rendered + counts.kept,
            counted(plan.own_frames().count(), "frame"),
            target.folder.display()
        ));
        return Ok(Outcome::Stopped(interrupt.exit_code()));
    }
    if !args.quiet {
        report_frames(&target, &plan, &counts, start.elapsed().as_secs_f64())?;
    }
    if let Some((path, format)) = target.film.as_ref().filter(|_| plan.shard.is_none()) {
        format.encode(
            path,
            &folder,
            plan.frames(),
            args.fps,
            args.picture.apply(scene.picture).transparent,
        )?;
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

fn report_frames(target: &Target, plan: &Plan<'_>, counts: &FrameCounts, seconds: f64) -> Result<()> {
    let kept = if counts.kept > 0 { format!(", {} kept from before", counts.kept) } else { String::new() };
    console::print(format_args!(
        "{}: {}{} of {}x{}, {} rendered{kept}, {seconds:.1} s",
        target.folder.display(),
        plan.shard.map_or_else(String::new, |shard| format!("shard {shard}, ")),
        counted(plan.own_frames().count(), "frame"),
        plan.size.0,
        plan.size.1,
        counts.rendered,
    ))
}

/// The outputs: the folder of the frames, and the film if there is one.
struct Target {
    folder: PathBuf,
    film: Option<(PathBuf, FilmFormat)>,
}

impl Target {
    /// An output with the extension of a film is the film, with its frames in a folder beside it;
    /// any other output is the folder.
    fn from_args(args: &AnimateArgs) -> Result<Self> {
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
                files::check_output(Some(output), &args.scene, args.overwrite.into())?;
                let folder = output.with_file_name(frames_of(output));
                Ok(Self { folder, film: Some((output.clone(), format)) })
            }
            None if output.extension().is_some() && !output.is_dir() => bail!(
                "'{}' names no film that can be made; end it in {}, or name a folder without an extension",
                output.display(),
                FilmFormat::EXTENSIONS
            ),
            None => Ok(Self { folder: output.clone(), film: None }),
        }
    }
}

/// The frames of an animation and their settings.
struct Plan<'a> {
    range: FrameRange,
    /// The number of frames of one orbit of the camera.
    turntable: Option<u32>,
    /// Width and height in pixels, equal for all frames.
    size: (u32, u32),
    /// The settings of the frames that the arguments set.
    picture: &'a PictureArgs,
    /// The shard of the frames to render; `None` for all.
    shard: Option<Shard>,
    /// The camera and the light, if the scene sets no camera and is not in sight in the first
    /// frame.
    framed: Option<Scene>,
}

impl<'a> Plan<'a> {
    fn from_args(args: &'a AnimateArgs, scene: &Scene, series: Option<&Series>) -> Result<Self> {
        let of_series = series.map(|series| {
            let last = (series.len() - 1).min(FrameRange::MOST as usize) as u32;
            FrameRange { first: 0, last }
        });
        if let (Some(range), Some(all)) = (args.frames, of_series)
            && range.last > all.last
        {
            bail!("there is no frame {}; the data has frames 0 to {}", range.last, all.last);
        }
        let range = match (args.frames.or(of_series), args.turntable) {
            (Some(range), _) => range,
            (None, Some(count)) => FrameRange { first: 0, last: count - 1 },
            (None, None) => keyed_range(scene).ok_or_else(|| {
                anyhow!(
                    "the scene has no keys, so nothing moves: --turntable N orbits the camera in N frames; \
                     'key FRAME COMMAND' in the scene sets keys"
                )
            })?,
        };
        if args.turntable.is_none() && scene.tracks().len() == 0 && series.is_none() {
            console::warn("superegg: warning: the scene has no keys, so all frames are alike");
        }
        let picture = args.picture.apply(scene.picture);
        if let Some(warning) = args.picture.warning(&picture) {
            console::warn(format_args!("superegg: warning: {warning}"));
        }
        let size = (picture.width, picture.height);
        let shard = args.shard.map(ShardArg::resolve).transpose().context("cannot determine the shard")?;
        Ok(Self { range, turntable: args.turntable, size, picture: &args.picture, shard, framed: None })
    }

    /// Frames the first frame, and all others alike, if it is not in sight and the scene sets no
    /// camera.
    fn frame_unseen(&mut self, stills: &Stills<'_>, root: Option<&str>, depth: Option<u32>) -> Result<()> {
        if !Framing::is_set(stills.session.scene()) {
            let still = self.still(stills, self.range.first)?;
            self.framed = framed_root(&still, root, depth.unwrap_or(still.depth), self.size);
        }
        Ok(())
    }

    /// All frames of the animation.
    fn frames(&self) -> impl ExactSizeIterator<Item = u32> + use<> {
        // An inclusive range of u32 has no exact size.
        let first = self.range.first;
        (0..(self.range.last - first + 1) as usize).map(move |i| first + i as u32)
    }

    /// The frames of the shard.
    fn own_frames(&self) -> impl Iterator<Item = u32> + use<> {
        let shard = self.shard.unwrap_or(Shard::WHOLE);
        self.frames().enumerate().filter(move |(index, _)| shard.takes(*index)).map(|(_, frame)| frame)
    }

    /// The scene at a frame, with the camera on its orbit.
    fn still(&self, stills: &Stills<'_>, frame: u32) -> Result<Scene> {
        let mut still = stills.at(frame)?;
        if let Some(framed) = &self.framed {
            still.camera = framed.camera;
            for (name, light) in framed.named_lights() {
                if still.light(name).is_err() {
                    still.set_light(name, *light);
                }
            }
        }
        let (width, height) = self.size;
        still.picture = Picture { width, height, ..self.picture.apply(still.picture) };
        if let Some(count) = self.turntable {
            let turns = f64::from((frame - self.range.first) % count) / f64::from(count);
            still.camera = still.camera.orbited(360.0 * turns);
        }
        Ok(still)
    }
}

/// The scenes of frames: keyframes of a session, or the frames of data.
#[derive(Clone, Copy)]
struct Stills<'a> {
    session: &'a Session,
    series: Option<&'a Series>,
}

impl Stills<'_> {
    fn at(&self, frame: u32) -> Result<Scene> {
        match self.series {
            Some(series) => series.scene(frame as usize),
            None => still_at(self.session, f64::from(frame)),
        }
    }
}

/// The range from the first keyframe to the last; `None` without keyframes.
fn keyed_range(scene: &Scene) -> Option<FrameRange> {
    let frames = || scene.tracks().flat_map(Track::keys).map(|key| key.frame);
    let first = frames().reduce(f64::min)?.floor().clamp(0.0, f64::from(FrameRange::MOST));
    let last = frames().reduce(f64::max)?.ceil().clamp(first, f64::from(FrameRange::MOST));
    Some(FrameRange { first: first as u32, last: last as u32 })
}

/// The number of rendered frames, and of frames that existed already.
#[derive(Default)]
struct FrameCounts {
    rendered: usize,
    kept: usize,
}

/// Renders the frames of a plan.
struct FrameRenderer<'a> {
    args: &'a AnimateArgs,
    plan: &'a Plan<'a>,
    stills: Stills<'a>,
    root: Option<&'a str>,
    annotations: Annotations,
}

impl FrameRenderer<'_> {
    /// Renders the frames that the folder does not have, until `cancel` becomes true.
    fn render_frames(&self, folder: &mut FrameFolder, cancel: &AtomicBool) -> Result<FrameCounts> {
        let pixels = u64::from(self.plan.size.0) * u64::from(self.plan.size.1);
        let total = pixels * self.plan.own_frames().count() as u64;
        let bar = progress_bar(total, self.args.quiet, "frame {msg}");
        let threads = self.args.threads.map_or_else(available_threads, usize::from);
        let mut counts = FrameCounts::default();
        let mut previous: Option<CompiledScene> = None;
        let folder_of_scene = self.args.scene.parent();
        let (mut hashes, mut pictures) =
            (PictureHashes::new(folder_of_scene), ReadPictures::new(folder_of_scene));
        for (index, frame) in self.plan.own_frames().enumerate() {
            let start = pixels * index as u64;
            bar.set_position(start);
            bar.set_message(frame.to_string());
            let still = self.plan.still(&self.stills, frame)?;
            let depth = self.args.depth.unwrap_or(still.depth);
            let signature = signature(&still, self.root, depth, &mut hashes, &self.annotations);
            if folder.has(frame, signature) {
                counts.kept += 1;
                continue;
            }
            let compiled = match &previous {
                Some(previous) => previous.recompile(&still, self.root, depth),
                None => CompiledScene::compile(&still, self.root, depth),
            };
            let settings = pictures.settings(&still)?.with_layers(false);
            let settings = denoise::prepared(settings)?;
            self.annotations.check(&settings)?;
            if previous.is_none() {
                warn_of_frame(frame, &compiled, &settings, &bar);
            }
            let progress = |pixels| bar.set_position(start + pixels);
            let options =
                RenderOptions::default().with_threads(threads).with_cancel(cancel).with_progress(&progress);
            let rendered = render(&compiled, &settings, &options)?;
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            folder.check_replaceable(frame)?;
            let notes = notes(&settings, denoise::applies(&rendered.film, &settings), None);
            let film = denoised(&rendered.film, &settings)?;
            folder.write(frame, signature, &self.annotations.png(&film, &settings, &notes)?)?;
            counts.rendered += 1;
            previous = Some(compiled);
        }
        bar.finish_and_clear();
        Ok(counts)
    }
}

/// Warns of a frame that is probably not what the user wants.
fn warn_of_frame(frame: u32, compiled: &CompiledScene, settings: &RenderSettings, bar: &ProgressBar) {
    for warning in picture_warnings(compiled, settings) {
        bar.suspend(|| console::warn(format_args!("superegg: warning: frame {frame}: {warning}")));
    }
}

/// A hash of everything that determines the picture of a frame.
fn signature(
    still: &Scene,
    root: Option<&str>,
    depth: u32,
    hashes: &mut PictureHashes<'_>,
    annotations: &Annotations,
) -> u64 {
    let of_scene = hashes.text_of_picture(still, root);
    let text = format!("{} {root:?} {depth} {annotations:?}\n{of_scene}", env!("CARGO_PKG_VERSION"));
    hash(text.as_bytes())
}
