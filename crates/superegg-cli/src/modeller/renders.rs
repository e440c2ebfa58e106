//! Pictures rendered behind the prompt: one after another, each of the scene as it was when it was asked for.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use superegg_render::{RenderOptions, RenderSettings, render};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

use crate::commands::{available_threads, counted};
use crate::files;
use crate::modeller::voice::{Said, Voice};
use crate::picture_file::PictureFormat;
use crate::pointless::concerns;

/// A picture to be made.
pub(crate) struct Job {
    pub(crate) scene: Scene,
    /// The primitive or object to draw.
    pub(crate) root: String,
    /// The file as it was named, and where it is wherever the working folder goes.
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    /// Width and height in pixels.
    pub(crate) size: (u32, u32),
    /// Threads to use; 0 for one a core.
    pub(crate) threads: usize,
}

/// The queue of pictures and the thread that makes them.
pub(crate) struct Renders {
    voice: Voice,
    queue: Option<Sender<(Job, Arc<AtomicBool>)>>,
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    /// What stops each job that is not done yet.
    cancels: Mutex<Vec<Arc<AtomicBool>>>,
    is_changed: Condvar,
    has_failed: AtomicBool,
}

impl Shared {
    fn cancels(&self) -> MutexGuard<'_, Vec<Arc<AtomicBool>>> {
        self.cancels.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Renders {
    pub(crate) fn new(voice: Voice) -> Self {
        Self { voice, queue: None, shared: Arc::default() }
    }

    /// Puts a job at the end of the queue. Returns how many are before it.
    pub(crate) fn push(&mut self, job: Job) -> usize {
        let cancel = Arc::new(AtomicBool::new(false));
        let mut cancels = self.shared.cancels();
        cancels.push(Arc::clone(&cancel));
        let before = cancels.len() - 1;
        drop(cancels);
        let queue = self.queue.get_or_insert_with(|| {
            let (queue, jobs) = channel::<(Job, Arc<AtomicBool>)>();
            let (voice, shared) = (Arc::clone(&self.voice), Arc::clone(&self.shared));
            std::thread::spawn(move || {
                for (job, cancel) in jobs {
                    let said = make(&job, &cancel, &voice);
                    // What is done cannot be stopped any more.
                    cancel.store(true, Ordering::Relaxed);
                    if matches!(said, Said::Failed(_)) {
                        shared.has_failed.store(true, Ordering::Relaxed);
                    }
                    // A reader that went away is noticed at the next line of the session.
                    let _ = voice(said);
                    shared.cancels().retain(|other| !Arc::ptr_eq(other, &cancel));
                    shared.is_changed.notify_all();
                }
            });
            queue
        });
        // The thread ends only when the queue is dropped.
        let _ = queue.send((job, cancel));
        before
    }

    /// Stops every picture. Returns how many there were.
    pub(crate) fn stop(&self) -> usize {
        self.shared.cancels().iter().filter(|cancel| !cancel.swap(true, Ordering::Relaxed)).count()
    }

    pub(crate) fn is_busy(&self) -> bool {
        !self.shared.cancels().is_empty()
    }

    /// Whether any picture could not be made.
    pub(crate) fn has_failed(&self) -> bool {
        self.shared.has_failed.load(Ordering::Relaxed)
    }

    /// Waits until every picture is made, or until `interrupt` turns true, which stops them.
    pub(crate) fn wait(&self, interrupt: &AtomicBool) {
        const LOOK_AGAIN: Duration = Duration::from_millis(50);
        let mut cancels = self.shared.cancels();
        while !cancels.is_empty() {
            if interrupt.load(Ordering::Relaxed) {
                cancels.iter().for_each(|cancel| cancel.store(true, Ordering::Relaxed));
            }
            let waited = self.shared.is_changed.wait_timeout(cancels, LOOK_AGAIN);
            cancels = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

fn make(job: &Job, cancel: &AtomicBool, voice: &Voice) -> Said {
    let stopped = || Said::Done(format!("{}: stopped, nothing is written", job.name));
    if cancel.load(Ordering::Relaxed) {
        return stopped();
    }
    let start = Instant::now();
    let compiled = CompiledScene::compile(&job.scene, Some(&job.root), job.scene.depth);
    let (width, height) = job.size;
    let settings = RenderSettings::of(&job.scene)
        .with_picture(Picture { width, height, ..job.scene.picture })
        .with_layers(PictureFormat::of(&job.path).is_ok_and(|format| format == PictureFormat::Exr));
    for concern in concerns(&compiled, &settings) {
        let _ = voice(Said::Done(format!("{}: warning: {concern}", job.name)));
    }
    let threads = if job.threads == 0 { available_threads() } else { job.threads };
    let meter = Meter::new(job, voice);
    let progress = |pixels| meter.show(pixels);
    let options = RenderOptions::default().with_threads(threads).with_cancel(cancel).with_progress(&progress);
    let rendered = match render(&compiled, &settings, &options) {
        Ok(rendered) => rendered,
        Err(error) => {
            return Said::Failed(format!("{}: {error}", job.name));
        }
    };
    if cancel.load(Ordering::Relaxed) {
        return stopped();
    }
    let written = PictureFormat::of(&job.path)
        .and_then(|format| format.encode(&rendered.film, &settings))
        .and_then(|file| files::write(&job.path, &file));
    let seconds = start.elapsed().as_secs_f64();
    match written {
        Ok(()) => Said::Done(format!(
            "{}: {width}x{height}, {}, {seconds:.1} s",
            job.name,
            counted(compiled.instance_count(), "instance")
        )),
        Err(error) => Said::Failed(format!("{}: {error:#}", job.name)),
    }
}

/// Says now and then how far a picture is.
struct Meter<'a> {
    job: &'a Job,
    voice: &'a Voice,
    last: Mutex<Instant>,
    start: Instant,
}

impl<'a> Meter<'a> {
    const PAUSE: Duration = Duration::from_millis(300);

    fn new(job: &'a Job, voice: &'a Voice) -> Self {
        let now = Instant::now();
        Self { job, voice, last: Mutex::new(now), start: now }
    }

    fn show(&self, pixels: u64) {
        // Another thread that is at it will do.
        let Ok(mut last) = self.last.try_lock() else { return };
        if last.elapsed() < Self::PAUSE {
            return;
        }
        *last = Instant::now();
        let total = f64::from(self.job.size.0) * f64::from(self.job.size.1);
        let share = pixels.max(1) as f64 / total;
        let gone = self.start.elapsed().as_secs_f64();
        let left = gone * (1.0 / share - 1.0);
        let line = format!("{}: {:.1} %, {} to go", self.job.name, 100.0 * share, told_seconds(left));
        let _ = (self.voice)(Said::Progress(line));
    }
}

/// "8 s", "3 min 20 s".
fn told_seconds(seconds: f64) -> String {
    let whole = seconds.ceil() as u64;
    if whole < 60 { format!("{whole} s") } else { format!("{} min {} s", whole / 60, whole % 60) }
}
