//! Ray tracing in the window: a thread that traces the latest view, coarse at once and then finer.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use superegg_render::{Film, RenderBudget, RenderSettings, render};
use superegg_scene::Picture;
use superegg_trace::CompiledScene;

/// A view to be traced.
#[derive(Clone, Debug)]
pub struct TraceJob {
    /// What rays hit.
    pub compiled: Arc<CompiledScene>,
    /// The picture in full: size and samples are those of the last pass.
    pub settings: RenderSettings,
    /// What the answer is marked with.
    pub number: u64,
}

/// A pass that is done.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The picture so far, of any size with about the sides' ratio of the job.
    pub film: Film,
    /// The job's number.
    pub number: u64,
    /// One pixel of the film stands for so many of the window, along a side.
    pub coarseness: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// Whether no pass follows.
    pub is_last: bool,
    /// How long this pass took.
    pub seconds: f64,
}

/// A first pass should take no longer than this.
const FIRST_PASS_SECONDS: f64 = 0.04;
/// Before anything was measured: this many samples a second.
const FIRST_GUESS: f64 = 200_000.0;
const COARSEST: u32 = 32;

/// The speed of this machine on this scene, as measured pass by pass.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    samples_per_second: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { samples_per_second: FIRST_GUESS }
    }
}

impl Pace {
    /// How coarse a pass must be to be done within a time, for a picture of this size.
    pub fn coarseness(&self, (width, height): (u32, u32), seconds: f64) -> u32 {
        let pixels = f64::from(width) * f64::from(height);
        let affordable = (self.samples_per_second * seconds).max(1.0);
        ((pixels / affordable).sqrt().ceil() as u32).clamp(1, COARSEST)
    }

    /// Takes a finished pass into account.
    pub fn measure(&mut self, samples: f64, seconds: f64) {
        let speed = samples / seconds.max(1e-6);
        // Half the old, half the new: one slow pass is no reason for a coarse picture.
        self.samples_per_second = 0.5 * (self.samples_per_second + speed);
    }
}

/// Traces one pass of a job: one film pixel for `coarseness` squared of the window. `None` where it was cancelled or no thread could be started.
pub fn trace_pass(
    job: &TraceJob,
    coarseness: u32,
    samples: u32,
    threads: usize,
    cancel: &AtomicBool,
) -> Option<Pass> {
    let begin = Instant::now();
    let side = |length: u32| length.div_ceil(coarseness).max(1);
    let settings = RenderSettings {
        picture: Picture {
            width: side(job.settings.picture.width),
            height: side(job.settings.picture.height),
            samples,
            ..job.settings.picture
        },
        layers: false,
        ..job.settings.clone()
    };
    let budget = RenderBudget { threads, cancel, progress: &|_| () };
    let rendered = render(&job.compiled, &settings, &budget).ok()?;
    (!cancel.load(Ordering::Relaxed)).then(|| Pass {
        film: rendered.film,
        number: job.number,
        coarseness,
        samples,
        is_last: coarseness == 1 && samples >= job.settings.picture.samples,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// One thread for each core.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The thread. Dropping it stops the work.
#[derive(Debug)]
pub(crate) struct Tracer {
    desk: Arc<Desk>,
}

#[derive(Debug, Default)]
struct Desk {
    next: Mutex<Next>,
    has_news: Condvar,
    /// The finer passes of the present job are no longer wanted.
    cancel: AtomicBool,
}

#[derive(Debug, Default)]
struct Next {
    job: Option<TraceJob>,
    is_over: bool,
}

impl Desk {
    fn lock(&self) -> MutexGuard<'_, Next> {
        self.next.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Tracer {
    /// Starts the thread; `done` is called on it with every pass.
    ///
    /// # Errors
    /// The system gives no thread.
    pub(crate) fn start(done: impl Fn(Pass) + Send + 'static) -> std::io::Result<Self> {
        let desk = Arc::new(Desk::default());
        let theirs = Arc::clone(&desk);
        std::thread::Builder::new().name("tracer".to_owned()).spawn(move || work(&theirs, &done))?;
        Ok(Self { desk })
    }

    /// Traces this from now on. What was traced before ends, but for a first pass: a view that moves all the time is still seen.
    pub(crate) fn trace(&self, job: TraceJob) {
        self.desk.lock().job = Some(job);
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.has_news.notify_one();
    }

    /// Ends the work until the next job.
    pub(crate) fn rest(&self) {
        self.desk.lock().job = None;
        self.desk.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for Tracer {
    fn drop(&mut self) {
        self.desk.lock().is_over = true;
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.has_news.notify_one();
    }
}

fn work(desk: &Desk, done: &impl Fn(Pass)) {
    let threads = available_threads();
    let never = AtomicBool::new(false);
    let mut pace = Pace::default();
    loop {
        let job = {
            let mut next = desk.lock();
            loop {
                if next.is_over {
                    return;
                }
                if let Some(job) = next.job.take() {
                    // Under the lock: a later job sets it again.
                    desk.cancel.store(false, Ordering::Relaxed);
                    break job;
                }
                next = desk.has_news.wait(next).unwrap_or_else(PoisonError::into_inner);
            }
        };
        let size = (job.settings.picture.width, job.settings.picture.height);
        let mut coarseness = pace.coarseness(size, FIRST_PASS_SECONDS);
        let mut samples = 1;
        let mut is_first = true;
        loop {
            let cancel = if is_first { &never } else { &desk.cancel };
            let Some(pass) = trace_pass(&job, coarseness, samples, threads, cancel) else { break };
            let traced = f64::from(pass.film.width()) * f64::from(pass.film.height()) * f64::from(samples);
            pace.measure(traced, pass.seconds);
            let is_last = pass.is_last;
            done(pass);
            if is_last || desk.cancel.load(Ordering::Relaxed) {
                break;
            }
            is_first = false;
            if coarseness > 1 {
                coarseness = coarseness.div_ceil(2);
            } else {
                samples = job.settings.picture.samples;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use superegg_scene::Scene;

    use super::*;

    fn job(number: u64, size: (u32, u32), samples: u32) -> TraceJob {
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        TraceJob {
            compiled: Arc::new(CompiledScene::compile(&scene, Some("ball"), 1)),
            settings: RenderSettings {
                picture: Picture { width: size.0, height: size.1, samples, ..Picture::default() },
                ..RenderSettings::of(&Scene::default())
            },
            number,
        }
    }

    #[test]
    fn passes_get_finer_until_the_whole_picture() {
        let (send, passes) = mpsc::channel();
        let tracer = Tracer::start(move |pass| drop(send.send(pass))).unwrap();
        tracer.trace(job(7, (301, 200), 3));
        let mut all: Vec<Pass> = Vec::new();
        while all.last().is_none_or(|pass| !pass.is_last) {
            all.push(passes.recv().unwrap());
        }
        let grain: Vec<(u32, u32)> = all.iter().map(|pass| (pass.coarseness, pass.samples)).collect();
        assert!(grain.windows(2).all(|two| two[1].0 < two[0].0 || two[1].1 > two[0].1), "{grain:?}");
        let last = all.last().unwrap();
        assert_eq!((last.film.width(), last.film.height(), last.samples, last.number), (301, 200, 3, 7));
        let whole = trace_pass(&job(0, (301, 200), 3), 1, 3, 1, &AtomicBool::new(false)).unwrap();
        assert_eq!(whole.film, last.film);
    }

    #[test]
    fn the_latest_job_wins_and_each_is_answered_at_least_once_if_it_is_begun() {
        let (send, passes) = mpsc::channel();
        let tracer = Tracer::start(move |pass| drop(send.send(pass))).unwrap();
        (0..50).for_each(|number| tracer.trace(job(number, (400, 400), 4)));
        loop {
            let pass: Pass = passes.recv().unwrap();
            if pass.is_last {
                assert_eq!(pass.number, 49);
                break;
            }
        }
        drop(tracer);
        assert!(passes.iter().count() == 0);
    }

    #[test]
    fn the_pace_follows_what_is_measured() {
        let mut pace = Pace::default();
        (0..20).for_each(|_| pace.measure(1e6, 1.0));
        assert_eq!(pace.coarseness((1000, 1000), 1.01), 1);
        assert_eq!(pace.coarseness((1000, 1000), 0.0401), 5);
        assert_eq!(pace.coarseness((32768, 32768), 0.0), COARSEST);
        pace.measure(0.0, 0.0);
        assert!(pace.coarseness((0, 0), 1.0) == 1);
    }
}
