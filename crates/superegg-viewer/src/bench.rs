//! Frame times without a window: the preview and the live ray traced view of a rotating scene.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use superegg_geom::glam::DVec2;
use superegg_render::RenderSettings;
use superegg_scene::Scene;
use superegg_trace::CompiledScene;

use crate::draw::{Drawing, Gpu, GpuError, Picture};
use crate::frame_stats::{DrawStats, FrameTimes, PreviewBench, TraceBench, ViewerBench};
use crate::input::Eye;
use crate::live::tracer::{ALL_THREADS, Pace, TraceJob, trace_pass};
use crate::preview::{PreviewBudget, SceneIndex};

/// A frame at 20 frames per second, less a fifth for everything else.
const LIVE_SECONDS: f64 = 0.04;

/// The eye at a frame of a sequence in which a tilted scene makes one turn.
fn eye_at(scene: &Scene, frame: usize, frames: usize) -> Eye {
    let mut eye = Eye::new(&scene.camera);
    let angle = TAU * frame as f64 / frames.max(1) as f64;
    eye.press(DVec2::ZERO);
    eye.drag(0.6 * DVec2::from_angle(angle));
    eye
}

fn times(mut milliseconds: Vec<f64>) -> FrameTimes {
    milliseconds.sort_by(f64::total_cmp);
    let frames = milliseconds.len();
    let at = |share: f64| milliseconds.get((share * frames as f64) as usize).copied().unwrap_or_default();
    FrameTimes { median_ms: at(0.5), slow_ms: at(0.95), frames }
}

fn ms_since(begin: Instant) -> f64 {
    1e3 * begin.elapsed().as_secs_f64()
}

/// Measures frames of the preview, then of the live ray traced view, at this size in pixels.
///
/// # Errors
/// There is no graphics driver.
pub fn bench(
    scene: &Scene,
    root: Option<&str>,
    size: (u32, u32),
    frames: usize,
) -> Result<ViewerBench, GpuError> {
    Ok(ViewerBench {
        preview: bench_preview(scene, root, size, frames)?,
        traced: bench_trace(scene, root, size, frames),
    })
}

/// Draws a sequence of frames of the preview.
fn bench_preview(
    scene: &Scene,
    root: Option<&str>,
    size: (u32, u32),
    frames: usize,
) -> Result<PreviewBench, GpuError> {
    let gpu = Gpu::headless()?;
    let mut drawing = Drawing::for_images(&gpu);
    let begin = Instant::now();
    let index = SceneIndex::new(scene);
    let budget = PreviewBudget { instances: PreviewBudget::WINDOW_INSTANCES, height_px: size.1 };
    let preview = index.open(root, &scene.camera, &budget);
    let open_ms = ms_since(begin);
    let lights = scene.lights();
    let mut milliseconds = Vec::new();
    let mut last = DrawStats::default();
    // The first frame makes the meshes and is not counted.
    for frame in 0..=frames {
        let picture = Picture {
            camera: eye_at(scene, frame, frames).camera(),
            ..Picture::of(scene, &preview, &lights)
        };
        let begin = Instant::now();
        last = drawing.draw_to_image(&picture, size)?.1;
        if frame > 0 {
            milliseconds.push(ms_since(begin));
        }
    }
    let instances = preview.instances.len();
    Ok(PreviewBench { device: gpu.describe(), open_ms, instances, stats: last, times: times(milliseconds) })
}

/// Traces a sequence of frames as a window does.
fn bench_trace(scene: &Scene, root: Option<&str>, size: (u32, u32), frames: usize) -> TraceBench {
    let begin = Instant::now();
    let compiled = Arc::new(CompiledScene::compile(scene, root, scene.depth));
    let compile_ms = ms_since(begin);
    let never = AtomicBool::new(false);
    let job = |frame: usize| TraceJob {
        compiled: Arc::clone(&compiled),
        settings: RenderSettings::of(scene)
            .with_picture(superegg_scene::Picture {
                width: size.0,
                height: size.1,
                noise: 0.0,
                ..scene.picture
            })
            .with_camera(eye_at(scene, frame, frames).camera()),
        number: 0,
    };
    let mut pace = Pace::default();
    let mut coarseness = 1;
    let mut live = Vec::new();
    for frame in 0..frames {
        let begin = Instant::now();
        let affordable = pace.coarseness(size, LIVE_SECONDS);
        if let Some(pass) = trace_pass(&job(frame), affordable, 1, ALL_THREADS, &never) {
            coarseness = pass.coarseness;
            pace.measure(f64::from(pass.film.width()) * f64::from(pass.film.height()), pass.seconds);
        }
        live.push(ms_since(begin));
    }
    let full = (0..frames.div_ceil(10)).map(|frame| {
        let begin = Instant::now();
        trace_pass(&job(10 * frame), 1, 1, ALL_THREADS, &never);
        ms_since(begin)
    });
    TraceBench {
        threads: rayon::current_num_threads(),
        compile_ms,
        full: times(full.collect()),
        live: times(live),
        coarseness,
    }
}
