//! `superegg render`: renders a scene to a picture, or a shard of it to a partial file.

mod stats;

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use superegg_lang::fingerprint_text;
use superegg_render::{Film, Output, PartHeader, RenderOptions, RenderSettings, Shard, TraceStats};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

use crate::annotate::Annotations;
use crate::args::RenderArgs;
use crate::commands::input::still_at;
use crate::console;
use crate::denoise;
use crate::files;
use crate::files::fingerprint::PictureHashes;
use crate::files::maker::check_maker;
use crate::files::notes::notes;
use crate::files::picture::PictureFormat;
use crate::files::scene::{Loaded, load_with};
use crate::files::surroundings::settings_with_surroundings;
use crate::inspect::framing::{framed, framing_note};
use crate::inspect::picture_warnings::picture_warnings;
use crate::long::checkpoint::{checkpoint_path, has_layers};
use crate::long::resumable::ResumableRender;
use crate::long::shard::ShardArg;
use crate::outcome::Outcome;
use crate::progress::progress_bar;
use crate::system::interrupt::Interrupt;
use crate::system::processor::available_threads;
use crate::text::counted;
use stats::{Seconds, Stats};

pub(crate) fn run(args: &RenderArgs) -> Result<Outcome> {
    Job::from_args(args)?.run()
}

/// A render as the arguments define it, with checked outputs.
struct Job<'a> {
    args: &'a RenderArgs,
    shard: Option<Shard>,
    output: PathBuf,
    /// `None` for a shard, whose output is a partial file.
    format: Option<PictureFormat>,
    threads: usize,
}

/// The scene of a job, ready to render.
struct Prepared<'a> {
    scene: Cow<'a, Scene>,
    root: Option<String>,
    /// The recursion depth.
    depth: u32,
    compiled: CompiledScene,
    settings: RenderSettings,
}

/// The result of a job.
struct Finished {
    film: Film,
    trace: TraceStats,
    /// The message of a render that a signal stopped, and its exit code.
    stopped: Option<(String, u8)>,
    render_seconds: f64,
    write_seconds: f64,
}

impl<'a> Job<'a> {
    fn from_args(args: &'a RenderArgs) -> Result<Self> {
        let shard =
            args.long.shard.map(ShardArg::resolve).transpose().context("cannot determine the shard")?;
        let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene, shard));
        for path in [Some(output.as_path()), args.stats.as_deref()] {
            files::check_output(path, &args.scene, args.overwrite.into())?;
        }
        let format = format_of(&output, shard)?;
        let replaced = check_maker(&output, args.output.is_none(), args.overwrite.into())
            .map_err(|error| anyhow!("{error}; name another picture with -o, or --force replaces it"))?;
        replaced.iter().for_each(|note| console::warn(format_args!("superegg: {note}")));
        check_annotations(args, format)?;
        let threads = args.threads.map_or_else(available_threads, usize::from);
        Ok(Self { args, shard, output, format, threads })
    }

    fn run(&self) -> Result<Outcome> {
        let mut clock = Clock::start();
        let loaded = load_with(
            &self.args.scene,
            &self.args.data.options(self.data_frame(), self.args.annotations.framed(self.args.picture.size)),
        )?;
        let parse = clock.lap();
        loaded.print_warnings(self.args.quiet);
        let prepared = self.prepare(&loaded)?;
        let annotations = self.args.annotations.with_legend(loaded.legend.clone())?;
        annotations.check(&prepared.settings)?;
        let compile = clock.lap();
        self.warn(&prepared);
        let finished = self.render(&loaded, &prepared, &annotations)?;

        let picture = &prepared.settings.picture;
        let mut stats = Stats::new(&prepared.scene, &prepared.compiled, picture, self.threads).with_render(
            &finished.film,
            &finished.trace,
            picture.noise > 0.0,
        );
        let (render, write) = (finished.render_seconds, finished.write_seconds);
        stats.seconds = Seconds { parse, compile, render, write };
        if let Some(path) = &self.args.stats {
            files::write(path, format!("{}\n", serde_json::to_string_pretty(&stats)?).as_bytes())?;
        }
        if let Some((message, exit_code)) = finished.stopped {
            console::warn(format_args!("superegg: stopped: {message}"));
            return Ok(Outcome::Stopped(exit_code));
        }
        let report = Report { job: self, settings: &prepared.settings, stats: &stats, film: &finished.film };
        report.print()?;
        let outcome = Outcome::of_input(loaded.has_errors());
        // The process ends here. Freeing a large scene first takes a while.
        std::mem::forget((prepared.compiled, prepared.scene));
        std::mem::forget(loaded);
        Ok(outcome)
    }

    /// The frame of a data file.
    fn data_frame(&self) -> Option<usize> {
        self.args.frame.filter(|frame| *frame >= 0.0 && frame.fract() == 0.0).map(|frame| frame as usize)
    }

    fn prepare<'l>(&self, loaded: &'l Loaded) -> Result<Prepared<'l>> {
        let args = self.args;
        let root = loaded.root_or_warn(args.root.object.as_deref())?;
        let scene = match args.frame {
            Some(frame) => Cow::Owned(still_at(&loaded.session, frame)?),
            None => Cow::Borrowed(loaded.session.scene()),
        };
        let depth = args.depth.unwrap_or(scene.depth);
        let compiled = CompiledScene::compile(&scene, root.as_deref(), depth);
        let Picture { width, height, .. } = args.picture.apply(scene.picture);
        let scene = match framed(&scene, &compiled, (width, height)) {
            Some(framed) => {
                console::warn(format_args!("superegg: {}", framing_note(&framed)));
                Cow::Owned(framed)
            }
            None => scene,
        };
        // A shard can become any kind of picture. A resumed render keeps the layers of its partial
        // file.
        let resumes_layers = args.long.resume && has_layers(&checkpoint_path(&self.output));
        let layers = self.shard.is_some() || self.format == Some(PictureFormat::Exr) || resumes_layers;
        let settings = settings_of(args, &scene)?.with_layers(layers);
        // A shard has the samples.
        let settings = if self.shard.is_some() { settings } else { denoise::prepared(settings)? };
        Ok(Prepared { scene, root, depth, compiled, settings })
    }

    /// Warns of a picture that is probably not what the user wants.
    fn warn(&self, prepared: &Prepared<'_>) {
        for warning in picture_warnings(&prepared.compiled, &prepared.settings) {
            console::warn(format_args!("superegg: warning: {warning}"));
        }
        if let Some(warning) = self.args.picture.warning(&prepared.settings.picture) {
            console::warn(format_args!("superegg: warning: {warning}"));
        }
        let is_empty =
            prepared.scene.floor.is_none() && prepared.compiled.instance_count().to_string() == "0";
        if let Some(root) = prepared.root.as_deref().filter(|_| is_empty) {
            console::warn(format_args!(
                "superegg: warning: '{root}' has no visible parts: the picture shows only the background"
            ));
        }
    }

    /// Renders and writes the output.
    fn render(
        &self,
        loaded: &Loaded,
        prepared: &Prepared<'_>,
        annotations: &Annotations,
    ) -> Result<Finished> {
        let mut clock = Clock::start();
        let Prepared { scene, root, depth, compiled, settings } = prepared;
        let header = || {
            let folder = self.args.scene.parent();
            let text = PictureHashes::new(folder).text_of_picture(scene, loaded.session.selected());
            let shard = self.shard.unwrap_or(Shard::WHOLE);
            PartHeader::new(env!("CARGO_PKG_VERSION"), &text, root.as_deref(), *depth, settings, shard)
        };
        let warn = |text: &str| console::warn(format_args!("superegg: {text}"));
        let inform = |text: &str| {
            if !self.args.quiet {
                warn(text);
            }
        };
        let resume = self.args.long.resume;
        let mut work =
            ResumableRender::new(&self.output, self.shard, resume, &settings.picture, header, &inform)?;
        let interrupt = Interrupt::listen()?;
        let bar = progress_bar(work.wanted_pixels(), self.args.quiet, "{rate}");
        let progress = |pixels| bar.set_position(pixels);
        let options = RenderOptions::default()
            .with_threads(self.threads)
            .with_cancel(interrupt.flag())
            .with_progress(&progress);
        let rendered = work.render(compiled, settings, &options, &|text| bar.suspend(|| warn(text)));
        bar.finish_and_clear();
        interrupt.work_ended();
        let (film, trace) = rendered?;
        let render_seconds = clock.lap();
        let message = work.finish(&self.output, &film, || match self.format {
            Some(format) => {
                let text = || fingerprint_text(scene, loaded.session.selected());
                let is_denoised = denoise::applies(&film, settings);
                let notes = notes(settings, is_denoised, self.args.scene_text.then(text));
                files::write(&self.output, &format.encode_annotated(&film, settings, annotations, &notes)?)
            }
            None => Ok(()),
        })?;
        let stopped = message.map(|message| (message, interrupt.exit_code()));
        Ok(Finished { film, trace, stopped, render_seconds, write_seconds: clock.lap() })
    }
}

/// Checks that the arguments want no annotation that the picture cannot have.
fn check_annotations(args: &RenderArgs, format: Option<PictureFormat>) -> Result<()> {
    args.annotations.check(&args.data)?;
    if !args.annotations.is_any() {
        return Ok(());
    }
    match format {
        Some(PictureFormat::Png) => {}
        Some(PictureFormat::Exr) => bail!(
            "--legend and --scale-bar are drawn into PNG pictures, and an .exr keeps light alone; leave them out, or name a .png"
        ),
        None => bail!(
            "--legend and --scale-bar are drawn into finished pictures, and a shard is a part of one; leave them out"
        ),
    }
    if args.annotations.legend && args.aov.is_some() {
        bail!("--legend shows the colours of data, and --aov replaces them; leave one of them out");
    }
    Ok(())
}

/// The settings of the scene, overridden by the arguments.
fn settings_of(args: &RenderArgs, scene: &Scene) -> Result<RenderSettings> {
    let picture = args.picture.apply(scene.picture);
    let picture = Picture {
        cryptomatte: args.cryptomatte || picture.cryptomatte,
        far_depth: args.far_depth.unwrap_or(picture.far_depth),
        ..picture
    };
    let output = args.aov.map_or(Output::Light, Into::into);
    let mut scene = scene.clone();
    scene.picture = picture;
    Ok(settings_with_surroundings(&scene, args.scene.parent())?.with_output(output))
}

/// The line about a finished render.
struct Report<'a> {
    job: &'a Job<'a>,
    settings: &'a RenderSettings,
    stats: &'a Stats,
    film: &'a Film,
}

impl Report<'_> {
    /// Prints the line, unless `--quiet` is given or standard output has the picture or the
    /// statistics.
    fn print(&self) -> Result<()> {
        let Job { args, output, shard, .. } = self.job;
        let mut outputs = [Some(output.as_path()), args.stats.as_deref()].into_iter().flatten();
        if args.quiet || outputs.any(files::is_standard_stream) {
            return Ok(());
        }
        let stats = self.stats;
        console::print(format_args!(
            "{}: {}x{}, {}{}, {:.1} s{}{}",
            output.display(),
            stats.width,
            stats.height,
            shard.map_or_else(String::new, |shard| format!("shard {shard}, ")),
            counted(&stats.instances, "instance"),
            stats.seconds.render,
            self.details(),
            self.limits()
        ))
    }

    /// The samples per pixel with a noise threshold, and the scale of the cost picture.
    fn details(&self) -> String {
        let mut text = String::new();
        if let Some(samples) = &self.stats.samples_taken {
            text += &format!("; {:.1} samples a pixel, {} at most", samples.mean, samples.most);
        }
        if self.settings.output == Output::Steps {
            let most = self.film.pixels().map(|pixel| pixel.color[0]).fold(0.0, f32::max);
            text += &format!("; white is {most:.1} boxes and shapes a ray");
        }
        text
    }

    /// The limits that the render reached.
    fn limits(&self) -> String {
        let compiled = &self.stats.compiled;
        let mut limits = String::new();
        if compiled.reaches_depth {
            limits += "; objects deeper than the depth limit are left out";
        }
        if compiled.stand_in_rays > 0 {
            limits += &format!(
                "; {} hit the proxy of an object smaller than half a pixel{}",
                counted(compiled.stand_in_rays, "ray"),
                if compiled.coarsened_rays > 0 { ", or of a larger one among too many" } else { "" }
            );
        }
        if compiled.coarsened_rays > 0 {
            limits += &format!(
                "; {} crossed too many overlapping objects, of which small ones are shown as averages: \
                 a smaller setDepth shows fewer objects exactly",
                counted(compiled.coarsened_rays, "ray")
            );
        }
        limits
    }
}

/// The default output in the current folder: the scene's name with `.png`, or with the shard and
/// `.part`.
fn default_output(scene: &Path, shard: Option<Shard>) -> PathBuf {
    let stem = scene.file_stem().filter(|_| !files::is_standard_stream(scene));
    let mut name = stem.unwrap_or("scene".as_ref()).to_owned();
    name.push(match shard {
        // Leading zeros keep the names in order.
        Some(shard) => {
            let digits = shard.count().to_string().len();
            format!("-{:0digits$}-of-{}.part", shard.number(), shard.count())
        }
        None => ".png".to_owned(),
    });
    PathBuf::from(name)
}

/// The format of the picture; `None` for a shard, whose output is a partial file.
fn format_of(output: &Path, shard: Option<Shard>) -> Result<Option<PictureFormat>> {
    let is_part = output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("part"));
    let name = output.display();
    match shard {
        Some(_) if is_part => Ok(None),
        Some(_) => bail!(
            "the output of a shard is a partial file, so -o takes NAME.part, not '{name}'; 'superegg merge' makes the picture"
        ),
        None if is_part => {
            bail!("'{name}' would be a partial file; --shard K/N renders one, or name a picture")
        }
        None => PictureFormat::of(output).map(Some),
    }
}

/// Measures the wall time of successive stages.
struct Clock(Instant);

impl Clock {
    fn start() -> Self {
        Self(Instant::now())
    }

    /// The seconds since the start or the last lap.
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let lap = now.duration_since(self.0).as_secs_f64();
        self.0 = now;
        lap
    }
}
