//! Batch queries: rays as columns in, hits as columns out.

use std::collections::HashMap;
use std::num::NonZeroUsize;

use foldhash::fast::RandomState;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{BatchHit, HitBatch, HitColumns, Ray, RayBatch, Superquadric, inverse_of, unit_vector};

use crate::ray::limits::Coarsened;
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
    paths: HitPaths,
}

/// The path of the instance in each row. Rows share the paths.
#[derive(Clone, Debug, Default)]
pub struct HitPaths {
    /// The index of the path, or [`HitPaths::NONE`].
    of_row: Vec<u32>,
    paths: Vec<InstancePath>,
}

impl HitPaths {
    /// The path of a miss.
    const NONE: u32 = u32::MAX;

    /// No paths, with room for `count` rows.
    pub fn with_capacity(count: usize) -> Self {
        Self { of_row: Vec::with_capacity(count), paths: Vec::new() }
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.of_row.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.of_row.is_empty()
    }

    /// The path in a row; `None` for a miss and past the end.
    pub fn get(&self, row: usize) -> Option<&InstancePath> {
        self.paths.get(*self.of_row.get(row)? as usize)
    }

    /// Adds the rows of `other`.
    pub fn append(&mut self, mut other: Self) {
        let before = self.paths.len() as u32;
        self.paths.append(&mut other.paths);
        self.of_row.extend(other.of_row.iter().map(|&path| match path {
            Self::NONE => Self::NONE,
            path => before + path,
        }));
    }
}

/// Paths are equal if all rows are.
impl PartialEq for HitPaths {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len() && (0..self.len()).all(|row| self.get(row) == other.get(row))
    }
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
        self.paths.get(i)
    }

    /// The columns, without a copy: geometry, primitives, instance ids and paths.
    pub fn into_columns(self) -> (HitColumns, Vec<u32>, Vec<u32>, HitPaths) {
        let Self { hits, primitives, instance_ids, paths } = self;
        (hits.into_columns(), primitives, instance_ids, paths)
    }

    /// Adds a row: the hit, its primitive, its instance id and the index of its path.
    fn push(&mut self, surface: Option<(BatchHit, u32, u32, u32)>) {
        let (hit, primitive, id, path) = match surface {
            Some((hit, primitive, id, path)) => (Some(hit), primitive, id, path),
            None => (None, Self::NO_PRIMITIVE, 0, HitPaths::NONE),
        };
        self.hits.push(hit);
        self.primitives.push(primitive);
        self.instance_ids.push(id);
        self.paths.of_row.push(path);
    }

    fn append(&mut self, mut other: Self) {
        self.hits.append(&other.hits);
        self.primitives.append(&mut other.primitives);
        self.instance_ids.append(&mut other.instance_ids);
        self.paths.append(other.paths);
    }
}

/// Surfaces are found by their leaves if there are no more of these for each ray.
const LEAVES_PER_RAY: usize = 4;
/// Marks a leaf whose surface is not prepared.
const NOT_PREPARED: u32 = u32::MAX;

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
        for part in in_parallel(rays, options, |part| self.intersect_part(&part, options.uv)) {
            if all.is_empty() {
                all = part;
            } else {
                all.append(part);
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
        let count = rays.len();
        let leaves = self.root.as_ref().map_or(0, |root| root.leaves.len());
        // A table of many leaves takes longer than a few rays.
        let table = if leaves <= LEAVES_PER_RAY * count { leaves } else { 0 };
        let mut surfaces = Surfaces {
            scene: self,
            uv,
            prepared: Vec::new(),
            paths: Vec::new(),
            of_leaf: vec![NOT_PREPARED; table],
            by_path: HashMap::default(),
        };
        let mut batch = SceneHitBatch {
            hits: HitBatch::with_capacity(count),
            primitives: Vec::with_capacity(count),
            instance_ids: Vec::with_capacity(count),
            paths: HitPaths::with_capacity(count),
        };
        // The lists of one chunk after the other: new ones would be new pages each time.
        let (mut ranges, mut traced, mut hits) = (Vec::new(), Vec::<TraceRay>::new(), Vec::new());
        let together = self.rays_together();
        for first in (0..count).step_by(together) {
            ranges.clear();
            traced.clear();
            for i in first..count.min(first + together) {
                let Ranged { ray, t_min, t_max } = ranged(rays, i);
                ranges.push((t_min, t_max));
                traced.push(ray.into());
            }
            self.append_hits(&traced, &[], &mut Coarsened::default(), &mut hits);
            for (hit, &(t_min, t_max)) in hits.drain(..).zip(&ranges) {
                match hit {
                    Some(hit) if t_min + hit.t < t_max => {
                        let hit = Hit { t: t_min + hit.t, ..hit };
                        batch.push(Some(surfaces.at(&hit)));
                    }
                    _ => batch.push(None),
                }
            }
        }
        batch.paths.paths = surfaces.paths;
        batch
    }

    fn occluded_part(&self, rays: &RayBatch<'_>) -> Vec<bool> {
        let mut occluded = vec![false; rays.len()];
        let together = self.rays_together();
        for first in (0..rays.len()).step_by(together) {
            // Rays that end are scaled to end at t = 1, so that one call traces all of them.
            let (mut ending, mut endless) = (Queued::default(), Queued::default());
            for i in first..rays.len().min(first + together) {
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
    prepared: Vec<Surface>,
    /// Their paths.
    paths: Vec<InstancePath>,
    /// The index of the surface of each leaf of the root, or [`NOT_PREPARED`]; empty for a few rays. Most scenes of data are one
    /// flat group.
    of_leaf: Vec<u32>,
    /// The indices of all others.
    by_path: HashMap<InstancePath, u32, RandomState>,
}

struct Surface {
    world_from_unit: DAffine3,
    /// From gradients in unit space to normals.
    normal_map: DMat3,
    shape: Superquadric,
    id: u32,
}

impl Surfaces<'_> {
    /// The geometry at a hit, the primitive, the instance id, and the index of the path.
    fn at(&mut self, hit: &Hit) -> (BatchHit, u32, u32, u32) {
        let index = self.index_of(&hit.path);
        let Surface { world_from_unit, normal_map, shape, id } = &self.prepared[index as usize];
        let gradient = hit.gradient(shape);
        let normal = unit_vector(*normal_map * gradient).unwrap_or(DVec3::Z);
        let point = world_from_unit.transform_point3(hit.unit_point);
        let (u, v) = if self.uv { shape.uv_at(hit.unit_point) } else { (f64::NAN, f64::NAN) };
        (BatchHit::new(hit.t, point, normal, [u, v], hit.leaving), hit.primitive, *id, index)
    }

    /// The index of the surface at a path, prepared at the first call.
    fn index_of(&mut self, path: &InstancePath) -> u32 {
        let Self { scene, prepared, paths, of_leaf, by_path, .. } = self;
        let mut prepare = || {
            prepared.push(Surface::of(scene, path));
            paths.push(path.clone());
            prepared.len() as u32 - 1
        };
        match path.indices() {
            [leaf] if (*leaf as usize) < of_leaf.len() => {
                let index = &mut of_leaf[*leaf as usize];
                if *index == NOT_PREPARED {
                    *index = prepare();
                }
                *index
            }
            _ => match by_path.get(path) {
                Some(index) => *index,
                None => *by_path.entry(path.clone()).or_insert_with(prepare),
            },
        }
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
