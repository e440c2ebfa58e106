//! Background renders: one after another, each of a snapshot of the scene.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use superegg_render::{RenderOptions, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

use crate::denoise;
use crate::files;
use crate::files::notes::notes;
use crate::files::picture::PictureFormat;
use crate::files::surroundings::settings_with_surroundings;
use crate::inspect::framing::{framed, framing_note};
use crate::inspect::picture_warnings::picture_warnings;
use crate::modeller::reporter::{Message, Reporter};
use crate::system::processor::available_threads;
use crate::text::counted;

/// A render to a file.
pub(crate) struct RenderJob {
    pub(crate) scene: Scene,
    /// The primitive or object to draw.
    pub(crate) root: String,
    /// The file name for messages.
    pub(crate) name: String,
    /// The absolute path, independent of the working folder.
    pub(crate) path: PathBuf,
    /// Width and height in pixels.
    pub(crate) size: (u32, u32),
    /// The number of threads; 0 for one for each core.
    pub(crate) threads: usize,
}

/// A job with its cancel flag.
type QueuedJob = (RenderJob, Arc<AtomicBool>);

/// The queue of jobs and its worker thread.
pub(crate) struct RenderQueue {
    reporter: Reporter,
    /// The input of the worker; the first job starts it.
    queue: Option<Sender<QueuedJob>>,
    shared: Arc<Shared>,
}

/// The state that the queue and its worker share.
#[derive(Default)]
struct Shared {
    /// The cancel flags of unfinished jobs, in order.
    cancels: Mutex<Vec<Arc<AtomicBool>>>,
    is_changed: Condvar,
    has_failed: AtomicBool,
}

impl Shared {
    fn cancels(&self) -> MutexGuard<'_, Vec<Arc<AtomicBool>>> {
        self.cancels.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl RenderQueue {
    pub(crate) fn new(reporter: Reporter) -> Self {
        Self { reporter, queue: None, shared: Arc::default() }
    }

    /// Appends a job. Returns the number of unfinished jobs before it.
    pub(crate) fn push(&mut self, job: RenderJob) -> usize {
        let cancel = Arc::new(AtomicBool::new(false));
        let mut cancels = self.shared.cancels();
        cancels.push(Arc::clone(&cancel));
        let ahead = cancels.len() - 1;
        drop(cancels);
        let queue = self.queue.get_or_insert_with(|| {
            let (queue, jobs) = channel::<QueuedJob>();
            let (reporter, shared) = (Arc::clone(&self.reporter), Arc::clone(&self.shared));
            std::thread::spawn(move || {
                for (job, cancel) in jobs {
                    let result = run_job(&job, &cancel, &reporter);
                    // A finished job can no longer be cancelled.
                    cancel.store(true, Ordering::Relaxed);
                    if matches!(result, Message::Failed(_)) {
                        shared.has_failed.store(true, Ordering::Relaxed);
                    }
                    // The next line of the session detects a closed output.
                    let _ = reporter(result);
                    shared.cancels().retain(|other| !Arc::ptr_eq(other, &cancel));
                    shared.is_changed.notify_all();
                }
            });
            queue
        });
        // The worker ends only when the queue is dropped.
        let _ = queue.send((job, cancel));
        ahead
    }

    /// Cancels every job. Returns the number of jobs that this stops.
    pub(crate) fn stop(&self) -> usize {
        self.shared.cancels().iter().filter(|cancel| !cancel.swap(true, Ordering::Relaxed)).count()
    }

    pub(crate) fn is_busy(&self) -> bool {
        !self.shared.cancels().is_empty()
    }

    /// Whether any job has failed.
    pub(crate) fn has_failed(&self) -> bool {
        self.shared.has_failed.load(Ordering::Relaxed)
    }

    /// Waits for all jobs; cancels them when `interrupt` becomes true.
    pub(crate) fn wait(&self, interrupt: &AtomicBool) {
        const POLL: Duration = Duration::from_millis(50);
        let mut cancels = self.shared.cancels();
        while !cancels.is_empty() {
            if interrupt.load(Ordering::Relaxed) {
                cancels.iter().for_each(|cancel| cancel.store(true, Ordering::Relaxed));
            }
            let waited = self.shared.is_changed.wait_timeout(cancels, POLL);
            cancels = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

/// Renders and writes a picture. Returns the final message.
fn run_job(job: &RenderJob, cancel: &AtomicBool, reporter: &Reporter) -> Message {
    let stopped = || Message::Done(format!("{}: stopped, nothing is written", job.name));
    if cancel.load(Ordering::Relaxed) {
        return stopped();
    }
    let start = Instant::now();
    let compiled = CompiledScene::compile(&job.scene, Some(&job.root), job.scene.depth);
    let (width, height) = job.size;
    let framed = framed(&job.scene, &compiled, job.size);
    if let Some(scene) = &framed {
        let _ = reporter(Message::Done(format!("{}: {}", job.name, framing_note(scene))));
    }
    let settings = match settings_with_surroundings(framed.as_ref().unwrap_or(&job.scene), None) {
        Ok(settings) => settings,
        Err(error) => return Message::Failed(format!("{}: {error:#}", job.name)),
    };
    let settings = settings
        .with_picture(Picture { width, height, ..job.scene.picture })
        .with_layers(PictureFormat::of(&job.path).is_ok_and(|format| format == PictureFormat::Exr));
    let settings = match denoise::prepared(settings) {
        Ok(settings) => settings,
        Err(error) => return Message::Failed(format!("{}: {error}", job.name)),
    };
    for warning in picture_warnings(&compiled, &settings) {
        let _ = reporter(Message::Done(format!("{}: warning: {warning}", job.name)));
    }
    let threads = if job.threads == 0 { available_threads() } else { job.threads };
    let meter = Meter::new(job, reporter);
    let progress = |pixels| meter.update(pixels);
    let options = RenderOptions::default().with_threads(threads).with_cancel(cancel).with_progress(&progress);
    let rendered = match render(&compiled, &settings, &options) {
        Ok(rendered) => rendered,
        Err(error) => {
            return Message::Failed(format!("{}: {error}", job.name));
        }
    };
    let is_stopped = cancel.load(Ordering::Relaxed);
    let done = rendered.film.sample_counts().filter(|count| *count > 0).count();
    if is_stopped && done == 0 {
        return stopped();
    }
    let written = PictureFormat::of(&job.path)
        .and_then(|format| {
            let notes = notes(&settings, denoise::applies(&rendered.film, &settings), None);
            format.encode(&rendered.film, &settings, &notes)
        })
        .and_then(|file| files::write(&job.path, &file));
    let seconds = start.elapsed().as_secs_f64();
    match written {
        Ok(()) if is_stopped => {
            let part = 100.0 * done as f64 / (f64::from(width) * f64::from(height));
            let blank = if settings.picture.transparent { "transparent" } else { "black" };
            Message::Done(format!("{}: stopped at {part:.0} %, the rest is {blank}", job.name))
        }
        Ok(()) => Message::Done(format!(
            "{}: {width}x{height}, {}, {seconds:.1} s",
            job.name,
            counted(compiled.instance_count(), "instance")
        )),
        Err(error) => Message::Failed(format!("{}: {error:#}", job.name)),
    }
}

/// Reports the progress of a job at intervals.
struct Meter<'a> {
    job: &'a RenderJob,
    reporter: &'a Reporter,
    last: Mutex<Instant>,
    start: Instant,
}

impl<'a> Meter<'a> {
    const INTERVAL: Duration = Duration::from_millis(300);

    fn new(job: &'a RenderJob, reporter: &'a Reporter) -> Self {
        let now = Instant::now();
        Self { job, reporter, last: Mutex::new(now), start: now }
    }

    /// Takes the number of finished pixels; callable from every render thread.
    fn update(&self, pixels: u64) {
        // Another thread is reporting.
        let Ok(mut last) = self.last.try_lock() else { return };
        if last.elapsed() < Self::INTERVAL {
            return;
        }
        *last = Instant::now();
        let total = f64::from(self.job.size.0) * f64::from(self.job.size.1);
        let fraction = pixels.max(1) as f64 / total;
        let left = self.start.elapsed().as_secs_f64() * (1.0 / fraction - 1.0);
        let line = format!("{}: {:.1} %, {} left", self.job.name, 100.0 * fraction, duration(left));
        let _ = (self.reporter)(Message::Progress(line));
    }
}

/// A duration in whole seconds: "8 s", "3 min 20 s".
fn duration(seconds: f64) -> String {
    let whole = seconds.ceil() as u64;
    if whole < 60 { format!("{whole} s") } else { format!("{} min {} s", whole / 60, whole % 60) }
}
