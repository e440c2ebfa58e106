//! The JSON file of `--stats`. Its keys are a contract: scripts read them.

use serde::Serialize;
use superegg_render::{Film, RayCounts, TraceStats};
use superegg_scene::{Picture, Scene};
use superegg_trace::CompiledScene;

use crate::system::memory::peak_rss_bytes;

/// The statistics of a render.
#[derive(Debug, Serialize)]
pub(super) struct Stats {
    /// The number of primitives of the scene, in the picture or not.
    primitives: usize,
    /// The number of objects of the scene, in the picture or not.
    objects: usize,
    /// The number of nodes of the compiled scene graph.
    groups: usize,
    /// The number of primitive instances in the picture, as digits because it can exceed 64 bits.
    pub(super) instances: String,
    pub(super) compiled: CompiledStats,
    pub(super) width: u32,
    pub(super) height: u32,
    /// The requested samples per pixel.
    samples: u32,
    /// Present with a noise threshold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) samples_taken: Option<SamplesTaken>,
    threads: usize,
    rays: Rays,
    pub(super) seconds: Seconds,
    peak_rss_bytes: Option<u64>,
}

impl Stats {
    pub(super) fn new(scene: &Scene, compiled: &CompiledScene, picture: &Picture, threads: usize) -> Self {
        Self {
            primitives: scene.primitives().count(),
            objects: scene.objects().count(),
            groups: compiled.group_count(),
            instances: compiled.instance_count().to_string(),
            compiled: CompiledStats {
                bytes: compiled.bytes(),
                box_area_spared: compiled.box_inflation().mean_ratio,
                reaches_depth: compiled.reaches_depth(),
                stand_in_rays: 0,
                coarsened_rays: 0,
            },
            width: picture.width,
            height: picture.height,
            samples: picture.samples,
            samples_taken: None,
            threads,
            rays: RayCounts::default().into(),
            seconds: Seconds::default(),
            peak_rss_bytes: None,
        }
    }

    /// Adds the results of the render.
    pub(super) fn with_render(mut self, film: &Film, trace: &TraceStats, has_noise_threshold: bool) -> Self {
        self.compiled.stand_in_rays = trace.proxy_hits;
        self.compiled.coarsened_rays = trace.coarsened.rays;
        self.samples_taken = has_noise_threshold.then(|| SamplesTaken::of(film));
        self.rays = trace.rays.into();
        self.peak_rss_bytes = peak_rss_bytes();
        self
    }
}

/// The samples per pixel of the finished pixels.
#[derive(Debug, Serialize)]
pub(super) struct SamplesTaken {
    pub(super) mean: f64,
    /// The maximum.
    pub(super) most: u32,
}

impl SamplesTaken {
    fn of(film: &Film) -> Self {
        let samples = || film.pixels().map(|pixel| pixel.samples).filter(|samples| *samples > 0);
        let total: u64 = samples().map(u64::from).sum();
        Self { mean: total as f64 / samples().count().max(1) as f64, most: samples().max().unwrap_or(0) }
    }
}

/// The compiled scene, and the limits that the render reached.
#[derive(Debug, Serialize)]
pub(super) struct CompiledStats {
    /// The memory of the compiled scene in bytes.
    bytes: usize,
    /// The mean area of boxes around eight transformed corners, as a multiple of the area of the
    /// boxes in use, over children that are objects.
    box_area_spared: f64,
    /// Whether the recursion depth cut off objects.
    pub(super) reaches_depth: bool,
    /// The number of rays that hit the proxy of an object: one smaller than half a pixel, or a
    /// larger one among too many that overlap.
    pub(super) stand_in_rays: u64,
    /// The number of rays for which parts wider than half a pixel were hit as proxies, because too
    /// many overlap.
    pub(super) coarsened_rays: u64,
}

/// The number of rays of each kind.
#[derive(Debug, Serialize)]
struct Rays {
    camera: u64,
    shadow: u64,
    /// Ambient occlusion rays; absent if there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    ambient: Option<u64>,
    reflection: u64,
    refraction: u64,
}

impl From<RayCounts> for Rays {
    fn from(RayCounts { camera, shadow, ambient, reflection, refraction, .. }: RayCounts) -> Self {
        Self { camera, shadow, ambient: Some(ambient).filter(|count| *count > 0), reflection, refraction }
    }
}

/// The wall time of each stage in seconds.
#[derive(Debug, Default, Serialize)]
pub(super) struct Seconds {
    pub(super) parse: f64,
    pub(super) compile: f64,
    pub(super) render: f64,
    pub(super) write: f64,
}
