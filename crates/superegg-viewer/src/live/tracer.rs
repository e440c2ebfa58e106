//! Live ray tracing: passes over the latest view, coarse at first and then finer.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use superegg_render::{Development, Film, RenderOptions, RenderSettings, render};
use superegg_scene::Picture;
use superegg_trace::CompiledScene;

use super::latest::LatestWorker;

/// A view to be traced.
#[derive(Clone, Debug)]
pub(crate) struct TraceJob {
    /// The scene to trace.
    pub(crate) compiled: Arc<CompiledScene>,
    /// The settings of the last pass: full size and all samples.
    pub(crate) settings: RenderSettings,
    /// Number of the job, copied to its passes.
    pub(crate) number: u64,
}

/// A finished pass.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    /// The picture, `coarseness` times smaller than the job's in each direction, rounded up.
    pub(crate) film: Film,
    /// How the film becomes a picture.
    pub(crate) development: Development,
    /// Number of the job.
    pub(crate) number: u64,
    /// Side of the square of window pixels that one film pixel covers.
    pub(crate) coarseness: u32,
    /// Samples per pixel.
    pub(crate) samples: u32,
    /// This is the last pass of the job.
    pub(crate) is_last: bool,
    /// Duration of the pass in seconds.
    pub(crate) seconds: f64,
}

/// Time limit of the first pass.
const FIRST_PASS_SECONDS: f64 = 0.04;
/// Samples per second that are assumed before any measurement.
const FIRST_GUESS: f64 = 200_000.0;
const COARSEST: u32 = 32;
/// The renderer uses all threads.
pub(crate) const ALL_THREADS: usize = 0;

/// Measured tracing speed on the current scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    samples_per_second: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Self { samples_per_second: FIRST_GUESS }
    }
}

impl Pace {
    /// The coarseness at which one sample per film pixel of a picture of this size takes at most
    /// this time.
    pub(crate) fn coarseness(&self, (width, height): (u32, u32), seconds: f64) -> u32 {
        let pixels = f64::from(width) * f64::from(height);
        let affordable = (self.samples_per_second * seconds).max(1.0);
        ((pixels / affordable).sqrt().ceil() as u32).clamp(1, COARSEST)
    }

    /// Adds a measurement: the number of samples of a pass and its duration.
    pub(crate) fn measure(&mut self, samples: f64, seconds: f64) {
        let speed = samples / seconds.max(1e-6);
        // The mean with the old speed: one slow pass must not make the picture coarse.
        self.samples_per_second = 0.5 * (self.samples_per_second + speed);
    }
}

/// Traces one pass of a job. Returns `None` if it was cancelled or the threads could not be
/// started.
pub(crate) fn trace_pass(
    job: &TraceJob,
    coarseness: u32,
    samples: u32,
    threads: usize,
    cancel: &AtomicBool,
) -> Option<Pass> {
    let begin = Instant::now();
    let side = |length: u32| length.div_ceil(coarseness).max(1);
    let picture = Picture {
        width: side(job.settings.picture.width),
        height: side(job.settings.picture.height),
        samples,
        ..job.settings.picture
    };
    let is_last = coarseness == 1 && samples >= job.settings.picture.samples;
    let mut settings = job.settings.clone().with_picture(picture).with_layers(false);
    if !is_last {
        trace_few_rays(&mut settings);
    }
    let options = RenderOptions::default().with_threads(threads).with_cancel(cancel);
    let rendered = render(&job.compiled, &settings, &options).ok()?;
    (!cancel.load(Ordering::Relaxed)).then(|| Pass {
        film: settings.output.into_colored(rendered.film),
        development: settings.development(),
        number: job.number,
        coarseness,
        samples,
        is_last,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// One ray for each area light, for ambient occlusion and for blurred reflection: passes that a finer one replaces may be noisy.
fn trace_few_rays(settings: &mut RenderSettings) {
    let Picture { light_rays, gloss_rays, .. } = &mut settings.picture;
    (*light_rays, *gloss_rays) = (1, (*gloss_rays).min(1));
    if let Some(occlusion) = &mut settings.environment.ambient_occlusion {
        occlusion.samples = 1;
    }
}

/// The tracing thread. Dropping it cancels the work.
#[derive(Debug)]
pub(crate) struct Tracer {
    worker: LatestWorker<TraceJob>,
}

impl Tracer {
    /// Starts the thread, which calls `done` with every pass.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub(crate) fn start(done: impl Fn(Pass) + Send + 'static) -> std::io::Result<Self> {
        let mut pace = Pace::default();
        let serve = move |job: TraceJob, cancel: &AtomicBool| trace(&job, &mut pace, cancel, &done);
        Ok(Self { worker: LatestWorker::start("tracer", serve)? })
    }

    /// Traces a job in place of the current one. The first pass of a job cannot be cancelled, so
    /// that a view in constant motion is still visible.
    pub(crate) fn trace(&self, job: TraceJob) {
        self.worker.request(job);
    }

    /// Cancels the work until the next job.
    pub(crate) fn rest(&self) {
        self.worker.clear();
    }
}

/// Traces the passes of a job: first as coarse as the time limit demands, then at half the
/// coarseness each, at last with all samples and all rays of the scene.
fn trace(job: &TraceJob, pace: &mut Pace, cancel: &AtomicBool, done: &impl Fn(Pass)) {
    let never = AtomicBool::new(false);
    let size = (job.settings.picture.width, job.settings.picture.height);
    let mut coarseness = pace.coarseness(size, FIRST_PASS_SECONDS);
    let mut samples = 1;
    let mut is_first = true;
    loop {
        let cancel_pass = if is_first { &never } else { cancel };
        let Some(pass) = trace_pass(job, coarseness, samples, ALL_THREADS, cancel_pass) else { return };
        let traced = f64::from(pass.film.width()) * f64::from(pass.film.height()) * f64::from(samples);
        pace.measure(traced, pass.seconds);
        let is_last = pass.is_last;
        done(pass);
        if is_last || cancel.load(Ordering::Relaxed) {
            return;
        }
        is_first = false;
        if coarseness > 1 {
            coarseness = coarseness.div_ceil(2);
        } else {
            samples = job.settings.picture.samples;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use superegg_scene::{AmbientOcclusion, Scene};

    use super::*;

    fn job(number: u64, size: (u32, u32), samples: u32) -> TraceJob {
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        TraceJob {
            compiled: Arc::new(CompiledScene::compile(&scene, Some("ball"), 1)),
            settings: RenderSettings::of(&Scene::default()).with_picture(Picture {
                width: size.0,
                height: size.1,
                samples,
                ..Picture::default()
            }),
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
    fn the_last_pass_alone_has_the_rays_of_the_scene() {
        let mut own = job(0, (40, 30), 1);
        own.settings.picture.light_rays = 9;
        own.settings.environment.lights.iter_mut().for_each(|light| light.radius = 0.3);
        own.settings.environment.ambient_occlusion = Some(AmbientOcclusion { samples: 9, distance: 2.0 });
        let mut few = own.clone();
        few.settings.picture.light_rays = 1;
        few.settings.environment.ambient_occlusion = Some(AmbientOcclusion { samples: 1, distance: 2.0 });
        let film = |job: &TraceJob, coarseness: u32, most_samples: u32| {
            let mut job = job.clone();
            job.settings.picture.samples = most_samples;
            trace_pass(&job, coarseness, 1, 1, &AtomicBool::new(false)).unwrap().film
        };
        // With one sample the pass at full size is the last.
        assert_ne!(film(&own, 1, 1), film(&few, 1, 1));
        assert_eq!(film(&own, 2, 1), film(&few, 2, 1));
        assert_eq!(film(&own, 1, 4), film(&few, 1, 4));
        assert_eq!(film(&own, 1, 4), film(&few, 1, 1));
    }

    #[test]
    fn the_latest_job_wins_and_every_job_that_begins_has_a_pass() {
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
    fn the_pace_follows_the_measurements() {
        let mut pace = Pace::default();
        (0..20).for_each(|_| pace.measure(1e6, 1.0));
        assert_eq!(pace.coarseness((1000, 1000), 1.01), 1);
        assert_eq!(pace.coarseness((1000, 1000), 0.0401), 5);
        assert_eq!(pace.coarseness((32768, 32768), 0.0), COARSEST);
        pace.measure(0.0, 0.0);
        assert!(pace.coarseness((0, 0), 1.0) == 1);
    }
}
