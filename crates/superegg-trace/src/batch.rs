//! Batch queries: rays as columns in, hits as columns out.

use std::collections::HashMap;
use std::num::NonZeroUsize;

use foldhash::fast::RandomState;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{BatchHit, HitBatch, HitColumns, Ray, RayBatch, Superquadric, inverse_of, unit_vector};

use crate::ray::query::{Hit, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::group::Target;
use crate::scene::path::InstancePath;
use crate::scene::proxy::Proxy;

/// How to run a batch query.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct BatchOptions {
    /// The number of threads, default: 1. The answers do not depend on it, but for the last digits of t.
    pub threads: NonZeroUsize,
    /// Whether hits have (u, v), which take several powers each; otherwise they are NaN. Default: true.
    pub uv: bool,
}

impl Default for BatchOptions {
    fn default() -> Self {
        Self { threads: NonZeroUsize::MIN, uv: true }
    }
}

impl BatchOptions {
    /// The same options with this number of threads. 0 means one thread for each processor core.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        let all = || std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
        Self { threads: NonZeroUsize::new(threads).unwrap_or_else(all), ..self }
    }

    /// The same options with or without (u, v) of hits.
    #[must_use]
    pub fn with_uv(self, uv: bool) -> Self {
        Self { uv, ..self }
    }
}

/// The answers of [`CompiledScene::intersect_batch`] as columns: row i belongs to ray i.
///
/// | column | type | for a miss |
/// |---|---|---|
/// | [`hits`](Self::hits) | t, points, normals, uv, leaving | see [`HitBatch`] |
/// | [`primitives`](Self::primitives) | `u32` | [`SceneHitBatch::NO_PRIMITIVE`] |
/// | [`instance_ids`](Self::instance_ids) | `u32` | 0 |
/// | [`path`](Self::path) | [`InstancePath`] | `None` |
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneHitBatch {
    hits: HitBatch,
    primitives: Vec<u32>,
    instance_ids: Vec<u32>,
    paths: Vec<InstancePath>,
}

impl SceneHitBatch {
    /// The primitive of a miss.
    pub const NO_PRIMITIVE: u32 = u32::MAX;

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.primitives.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.primitives.is_empty()
    }

    /// The geometry of the hits. (u, v) are those of the primitive's shape.
    pub fn hits(&self) -> &HitBatch {
        &self.hits
    }

    /// The index of each primitive, for [`CompiledScene::primitive`] and [`CompiledScene::primitive_name`].
    pub fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    /// The id of each instance: that of the instance id output of a picture ([`CompiledScene::instance_id`]).
    pub fn instance_ids(&self) -> &[u32] {
        &self.instance_ids
    }

    /// The path of the instance that ray `i` hits, for [`CompiledScene::path_name`]. `None` for a miss and past the end.
    pub fn path(&self, i: usize) -> Option<&InstancePath> {
        self.paths.get(i).filter(|path| !path.indices().is_empty())
    }

    /// The columns, without a copy: geometry, primitives, instance ids and paths.
    pub fn into_columns(self) -> (HitColumns, Vec<u32>, Vec<u32>, Vec<InstancePath>) {
        let Self { hits, primitives, instance_ids, paths } = self;
        (hits.into_columns(), primitives, instance_ids, paths)
    }

    fn push(&mut self, surface: Option<(BatchHit, u32, u32)>, path: InstancePath) {
        let (hit, primitive, id) = match surface {
            Some((hit, primitive, id)) => (Some(hit), primitive, id),
            None => (None, Self::NO_PRIMITIVE, 0),
        };
        self.hits.push(hit);
        self.primitives.push(primitive);
        self.instance_ids.push(id);
        self.paths.push(path);
    }

    fn append(&mut self, other: &mut Self) {
        self.hits.append(&other.hits);
        self.primitives.append(&mut other.primitives);
        self.instance_ids.append(&mut other.instance_ids);
        self.paths.append(&mut other.paths);
    }
}

/// The number of rays to trace at a time, which bounds the memory.
const CHUNK: usize = 1 << 16;

impl CompiledScene {
    /// The closest hit of each ray within its range of t.
    ///
    /// It is the fastest way to trace many rays that have nothing in common. A ray that is not finite, or whose direction
    /// is zero, hits nothing.
    ///
    /// ```
    /// use superegg_geom::RayBatch;
    /// use superegg_scene::Scene;
    /// use superegg_trace::{BatchOptions, CompiledScene};
    ///
    /// let mut scene = Scene::default();
    /// scene.ensure_primitive("ball")?;
    /// let compiled = CompiledScene::compile(&scene, Some("ball"), 1);
    /// let (origins, directions) = ([[0.0, 0.0, 5.0], [3.0, 0.0, 5.0]], [[0.0, 0.0, -1.0]; 2]);
    /// let rays = RayBatch::new(&origins, &directions)?;
    /// let hits = compiled.intersect_batch(&rays, BatchOptions::default());
    /// assert_eq!(hits.hits().t(), [4.0, f64::INFINITY]);
    /// assert_eq!(compiled.primitive_name(hits.primitives()[0]), Some("ball"));
    /// assert_eq!(hits.path(0).map(|path| compiled.path_name(path)).as_deref(), Some("ball"));
    /// assert_eq!(hits.path(1), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect_batch(&self, rays: &RayBatch<'_>, options: BatchOptions) -> SceneHitBatch {
        let mut all = SceneHitBatch::default();
        for mut part in in_parallel(rays, options, |part| self.intersect_part(&part, options.uv)) {
            if all.is_empty() {
                all = part;
            } else {
                all.append(&mut part);
            }
        }
        all
    }

    /// Whether each ray hits any surface within its range of t. Other rays are as for
    /// [`CompiledScene::intersect_batch`].
    pub fn occluded_batch(&self, rays: &RayBatch<'_>, options: BatchOptions) -> Vec<bool> {
        in_parallel(rays, options, |part| self.occluded_part(&part)).concat()
    }

    fn intersect_part(&self, rays: &RayBatch<'_>, uv: bool) -> SceneHitBatch {
        let mut surfaces = Surfaces { scene: self, uv, by_path: HashMap::default() };
        let mut batch = SceneHitBatch::default();
        batch.primitives.reserve_exact(rays.len());
        batch.instance_ids.reserve_exact(rays.len());
        batch.paths.reserve_exact(rays.len());
        for first in (0..rays.len()).step_by(CHUNK) {
            let ranged: Vec<Ranged> =
                (first..rays.len().min(first + CHUNK)).map(|i| ranged(rays, i)).collect();
            let traced: Vec<TraceRay> = ranged.iter().map(|ranged| ranged.ray.into()).collect();
            for (hit, ranged) in self.intersect_many(&traced).into_iter().zip(&ranged) {
                let hit = hit.map(|hit| Hit { t: ranged.t_min + hit.t, ..hit });
                match hit.filter(|hit| hit.t < ranged.t_max) {
                    Some(hit) => batch.push(Some(surfaces.at(&hit)), hit.path),
                    None => batch.push(None, InstancePath::default()),
                }
            }
        }
        batch
    }

    fn occluded_part(&self, rays: &RayBatch<'_>) -> Vec<bool> {
        let mut occluded = vec![false; rays.len()];
        for first in (0..rays.len()).step_by(CHUNK) {
            // Rays that end are scaled to end at t = 1, so that one call traces all of them.
            let (mut ending, mut endless) = (Queued::default(), Queued::default());
            for i in first..rays.len().min(first + CHUNK) {
                let Ranged { ray, t_min, t_max } = ranged(rays, i);
                let length = t_max - t_min;
                let direction = ray.direction * length;
                if length == f64::INFINITY || (length > 0.0 && !direction.is_finite()) {
                    endless.push(i, ray);
                } else if length > 0.0 {
                    ending.push(i, Ray { direction, ..ray });
                }
            }
            for (queued, end) in [(ending, 1.0), (endless, f64::INFINITY)] {
                for (i, is_occluded) in queued.indices.iter().zip(self.occluded_many(&queued.rays, end)) {
                    occluded[*i] = is_occluded;
                }
            }
        }
        occluded
    }
}

/// Rays of a batch with their indices in it.
#[derive(Default)]
struct Queued {
    indices: Vec<usize>,
    rays: Vec<TraceRay>,
}

impl Queued {
    fn push(&mut self, index: usize, ray: Ray) {
        self.indices.push(index);
        self.rays.push(ray.into());
    }
}

/// A ray that starts at the beginning of its range.
struct Ranged {
    ray: Ray,
    /// The t of the given ray at this ray's origin.
    t_min: f64,
    /// The end of the range, as a t of the given ray; NaN for a ray that hits nothing.
    t_max: f64,
}

fn ranged(rays: &RayBatch<'_>, i: usize) -> Ranged {
    let given = rays.ray(i).filter(|ray| ray.origin.is_finite() && ray.direction.is_finite());
    let range = rays.range(i).filter(|(t_min, _)| !t_min.is_nan());
    let (Some(given), Some((t_min, t_max))) = (given, range) else {
        return Ranged { ray: Ray::new(DVec3::ZERO, DVec3::ZERO), t_min: 0.0, t_max: f64::NAN };
    };
    if t_min > 0.0 {
        let ray = Ray::new(given.point_at(t_min), given.direction);
        let t_max = if ray.origin.is_finite() { t_max } else { f64::NAN };
        return Ranged { ray, t_min, t_max };
    }
    Ranged { ray: given, t_min: 0.0, t_max }
}

/// Splits rays into one part for each thread, and returns the answers in their order.
fn in_parallel<T: Send>(
    rays: &RayBatch<'_>,
    options: BatchOptions,
    query: impl Fn(RayBatch<'_>) -> T + Sync,
) -> Vec<T> {
    let part = rays.len().div_ceil(options.threads.get()).max(1);
    let parts: Vec<RayBatch<'_>> = (0..rays.len())
        .step_by(part)
        .filter_map(|first| rays.slice(first..rays.len().min(first + part)))
        .collect();
    if let [only] = parts[..] {
        return vec![query(only)];
    }
    let query = &query;
    std::thread::scope(|scope| {
        let threads: Vec<_> = parts.into_iter().map(|part| scope.spawn(move || query(part))).collect();
        let join = |thread: std::thread::ScopedJoinHandle<'_, T>| match thread.join() {
            Ok(answer) => answer,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        threads.into_iter().map(join).collect()
    })
}

/// The surfaces of instances, each prepared once.
struct Surfaces<'a> {
    scene: &'a CompiledScene,
    uv: bool,
    by_path: HashMap<InstancePath, Surface, RandomState>,
}

struct Surface {
    world_from_unit: DAffine3,
    /// From gradients in unit space to normals.
    normal_map: DMat3,
    shape: Superquadric,
    id: u32,
}

impl Surfaces<'_> {
    /// The geometry at a hit, the primitive, and the instance id.
    fn at(&mut self, hit: &Hit) -> (BatchHit, u32, u32) {
        let scene = self.scene;
        let Surface { world_from_unit, normal_map, shape, id } = match self.by_path.get(&hit.path) {
            Some(surface) => surface,
            None => self.by_path.entry(hit.path.clone()).or_insert_with(|| Surface::of(scene, &hit.path)),
        };
        let gradient = hit.gradient(shape);
        let normal = unit_vector(*normal_map * gradient).unwrap_or(DVec3::Z);
        let point = world_from_unit.transform_point3(hit.unit_point);
        let (u, v) = if self.uv { shape.uv_at(hit.unit_point) } else { (f64::NAN, f64::NAN) };
        (BatchHit::new(hit.t, point, normal, [u, v], hit.leaving), hit.primitive, *id)
    }
}

impl Surface {
    fn of(scene: &CompiledScene, path: &InstancePath) -> Self {
        let (unit_from_world, target) = scene.unit_from_world(path);
        let shape = match target {
            Target::Primitive(primitive) => scene.primitive(primitive).unit_shape(),
            Target::Proxy => Proxy::unit_shape(),
        };
        Self {
            world_from_unit: inverse_of(&unit_from_world),
            normal_map: unit_from_world.matrix3.transpose(),
            shape,
            id: scene.instance_id(path),
        }
    }
}
