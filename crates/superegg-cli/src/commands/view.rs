//! `superegg view`: a window onto a scene, without a prompt.

mod inbox;

use std::path::Path;
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use anyhow::{Context, Result, ensure};
use superegg_lang::{Severity, visible};
use superegg_scene::Scene;
use superegg_viewer::{FrameTimes, Frames, FromViewer, Viewer, ViewerBench};

use crate::args::ViewArgs;
use crate::console;
use crate::files;
use crate::files::data::DataOptions;
use crate::files::names::{folder_of, rename_for};
use crate::files::scene::load_with;
use crate::files::series::Series;
use crate::inspect::framing::{framed_root, framing_note};
use crate::modeller::{Input, Modeller, ShownFrame, console_reporter};
use crate::outcome::Outcome;
use crate::text::counted;
use inbox::Inbox;

pub(crate) fn run(args: &ViewArgs) -> Result<Outcome> {
    let options = args.data.options(None, None);
    let scene_file = args.scene.as_deref();
    let mut loaded = scene_file.map(|file| load_with(file, &options)).transpose()?.unwrap_or_default();
    loaded.print_diagnostics();
    if let Some(file) = scene_file {
        // The session's files are seen from the working folder.
        rename_for(&mut loaded.session, folder_of(file), Path::new(""));
    }
    let series = scene_file.filter(|_| !args.bench).and_then(|file| series_of(file, &options));
    if let Some(series) = &series {
        loaded.session = series.seen(&loaded.session);
    }
    let root = match scene_file {
        Some(_) => loaded.root_or_warn(args.root.object.as_deref())?,
        None => None,
    };
    let scene = loaded.session.scene();
    let size = (args.size.width, args.size.height);
    if let Some(framed) = framed_root(scene, root.as_deref(), scene.depth, size) {
        console::warn(format_args!("superegg: {}", framing_note(&framed)));
        loaded.session = loaded.session.with_view_of(&framed);
    }
    let outcome = Outcome::of_input(loaded.has_errors());
    let of_whole = scene_file
        .filter(|file| loaded.is_whole_scene() && series.is_none() && !files::is_standard_stream(file));
    let fault = loaded.diagnostics.iter().find(|found| found.severity == Severity::Error);
    let fault = fault.map(|found| visible(found.to_string().lines().next().unwrap_or_default()));
    if args.bench {
        bench(args, loaded.session.scene(), root.as_deref())?;
        return Ok(outcome);
    }
    let viewer = Viewer::new().context("the viewer cannot start")?;
    let handle = viewer.handle();
    let source = Input::Lines { name: "window".to_owned(), is_file: false };
    let modeller = Modeller::new(source, true, console_reporter(), Arc::default());
    let mut modeller = modeller.with_scene(loaded.session, root.as_deref());
    modeller.begin_document(scene_file, of_whole.is_some());
    modeller.use_kept_settings(args.course);
    if let Some(series) = &series {
        let first = scene_file.and_then(|file| series.index_of(file, loaded.frame)).unwrap_or_default();
        modeller.show_frame(load_frame(series, first)?);
    }
    modeller.attach_viewer(handle.clone());
    // Whoever has opened a file from a desktop sees no terminal.
    fault.into_iter().for_each(|fault| handle.notice(fault));
    let first = modeller.snapshot();
    let (events, from_viewer) = mpsc::channel();
    let session = std::thread::Builder::new()
        .name("session".to_owned())
        .spawn(move || {
            for event in Inbox::new(from_viewer) {
                if let (FromViewer::Frame(frame), Some(series)) = (&event, &series) {
                    match load_frame(series, *frame) {
                        Ok(frame) => modeller.show_frame(frame),
                        Err(error) => modeller.report_viewer_error(format!("{error:#}")),
                    }
                }
                // There is no prompt to return to.
                let closed_by_user = match &event {
                    FromViewer::KeyboardBack => Some(true),
                    FromViewer::Closed { by_user } => Some(*by_user),
                    _ => None,
                };
                modeller.handle_viewer_event(event);
                if let Some(by_user) = closed_by_user {
                    if let Err(error) = modeller.leave_window(by_user) {
                        console::warn(format_args!("superegg: {error:#}"));
                    }
                    handle.quit();
                    return;
                }
            }
        })
        .context("cannot start the session's thread")?;
    let exit_code = i32::from(outcome != Outcome::Fine);
    let session = Arc::new(Mutex::new(Some(session)));
    // The session ends when the window is closed.
    let wait = |session: &Mutex<Option<JoinHandle<()>>>| {
        let session = session.lock().unwrap_or_else(PoisonError::into_inner).take();
        session.map(JoinHandle::join)
    };
    let session_after_loss = Arc::clone(&session);
    viewer.run(Some(first), events, move || {
        wait(&session_after_loss);
        std::process::exit(exit_code);
    });
    wait(&session);
    Ok(outcome)
}

/// The series that a file belongs to. Without one that can be read the file is shown alone.
fn series_of(path: &Path, options: &DataOptions) -> Option<Series> {
    Series::of(path, options).unwrap_or_else(|error| {
        console::warn(format_args!("superegg: warning: the other frames are not shown: {error:#}"));
        None
    })
}

/// Loads a frame of a series.
fn load_frame(series: &Series, current: usize) -> Result<ShownFrame> {
    let count = series.len();
    ensure!(current < count, "there is no frame {current}; the data has frames 0 to {}", count - 1);
    Ok(ShownFrame { frames: Frames { count, current }, scene: series.scene(current)? })
}

/// Prints the frame times of the preview and of the ray-traced view.
fn bench(args: &ViewArgs, scene: &Scene, root: Option<&str>) -> Result<()> {
    let size = (args.size.width, args.size.height);
    let frames = usize::from(args.frames);
    console::print(format_args!("{}x{}, {}", size.0, size.1, counted(frames, "frame")))?;
    let ViewerBench { preview, traced } =
        superegg_viewer::bench(scene, root, size, frames).context("the preview cannot be drawn")?;
    console::print(format_args!(
        "preview on {}: {} ms to open {}, {}; {} and {} in the picture, {} coarser than their own patches",
        preview.device,
        preview.open_ms.round(),
        counted(preview.instances, "instance"),
        frame_text(&preview.times),
        counted(preview.stats.instances, "instance"),
        counted(preview.stats.triangles, "triangle"),
        preview.stats.coarser,
    ))?;
    console::print(format_args!(
        "ray traced on {}: {} ms to compile; at every pixel {}",
        counted(traced.threads, "thread"),
        traced.compile_ms.round(),
        frame_text(&traced.full),
    ))?;
    console::print(format_args!(
        "ray traced while turned: {}, one ray for {} x {} pixels at the end",
        frame_text(&traced.live),
        traced.coarseness,
        traced.coarseness,
    ))
}

/// The median and the 95th percentile of frame times.
fn frame_text(times: &FrameTimes) -> String {
    format!(
        "{:.1} ms a frame ({:.1} frames a second; one of twenty takes {:.1} ms or more)",
        times.median_ms,
        1e3 / times.median_ms.max(1e-3),
        times.slow_ms
    )
}
