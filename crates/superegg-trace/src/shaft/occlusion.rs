//! Shadow rays against the few shapes in their shaft.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::stream::{
    END, ENTRY_LANES, EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamHits, StreamLanes,
};
use superegg_geom::{Ray, RayStart};
use superegg_simd::{Arch, Simd, WithSimd, bits};

use super::occluders::Occluder;
use crate::scene::compiled::CompiledScene;

/// Rays as columns, in groups of [`ENTRY_LANES`].
#[derive(Clone, Debug, Default)]
pub struct ShaftRays {
    groups: Vec<Eight>,
    errors: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Eight {
    origin: [[f64; ENTRY_LANES]; 3],
    direction: [[f64; ENTRY_LANES]; 3],
    /// The rays that are not known to be occluded, one bit each.
    open: u32,
}

impl ShaftRays {
    /// Removes all rays.
    pub fn clear(&mut self) {
        self.groups.clear();
        self.errors.clear();
    }

    /// The number of rays.
    pub fn len(&self) -> usize {
        self.errors.len()
    }

    /// Whether there are no rays.
    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// Adds a ray.
    #[inline]
    pub fn push(&mut self, ray: &Ray) {
        let lane = self.errors.len() % ENTRY_LANES;
        if lane == 0 {
            self.groups.push(Eight::default());
        }
        if let Some(group) = self.groups.last_mut() {
            for axis in 0..3 {
                group.origin[axis][lane] = ray.origin[axis];
                group.direction[axis][lane] = ray.direction[axis];
            }
            group.open |= 1 << lane;
        }
        self.errors.push(ray.origin_error);
    }

    /// Whether no shape has occluded the ray of this index.
    pub fn is_open(&self, index: usize) -> bool {
        self.groups[index / ENTRY_LANES].open >> (index % ENTRY_LANES) & 1 == 1
    }

    /// The number of rays that no shape has occluded.
    pub fn open_count(&self) -> usize {
        self.groups.iter().map(|group| group.open.count_ones() as usize).sum()
    }

    /// The ray of this index.
    pub fn ray(&self, index: usize) -> Ray {
        let (group, lane) = (&self.groups[index / ENTRY_LANES], index % ENTRY_LANES);
        let vector = |rows: &[[f64; ENTRY_LANES]; 3]| DVec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
        Ray {
            origin: vector(&group.origin),
            direction: vector(&group.direction),
            origin_error: self.errors[index],
        }
    }

    fn close(&mut self, index: usize) {
        self.groups[index / ENTRY_LANES].open &= !(1 << (index % ENTRY_LANES));
    }
}

impl CompiledScene {
    /// Closes the open rays that hit one of the shapes with 0 <= t < `t_max`. The answers are those of
    /// [`CompiledScene::occluded`] in a scene of these shapes.
    pub fn occlude_rays(&self, occluders: &[Occluder], t_max: f64, rays: &mut ShaftRays) {
        if !occluders.is_empty() && !rays.is_empty() {
            Arch::new().dispatch(Occlude { scene: self, occluders, t_max, rays });
        }
    }
}

struct Occlude<'a> {
    scene: &'a CompiledScene,
    occluders: &'a [Occluder],
    t_max: f64,
    rays: &'a mut ShaftRays,
}

/// A ray that waits for the solver.
#[derive(Clone, Copy, Debug)]
struct Queued {
    ray: u32,
    occluder: u32,
    /// The t where the ray enters the box of the shape.
    t_entry: f64,
    /// Converts a length in unit space to t.
    t_per_s: f64,
    /// For a ray that starts in the box: the t where it leaves the box.
    exit: Option<f64>,
}

impl WithSimd for Occlude<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { scene, occluders, t_max, rays } = self;
        let mut queue = Queue { lanes: StreamLanes::default(), rays: smallvec::SmallVec::new() };
        let mut entries = ShapeEntries::default();
        for (number, occluder) in occluders.iter().enumerate() {
            for group in 0..rays.groups.len() {
                let Eight { origin, direction, open } = rays.groups[group];
                if open == 0 {
                    continue;
                }
                entries.set_all(&occluder.unit_from_world, &origin, &direction, t_max);
                entries.run();
                for lane in bits(open) {
                    let kind = entries.kind(lane);
                    if kind == EntryKind::Misses {
                        continue;
                    }
                    let ray = group * ENTRY_LANES + lane;
                    match occluder.powers {
                        Some(powers) if kind != EntryKind::Unresolved && occluder.start == RayStart::Free => {
                            let entry = entries.get(lane);
                            let ShapeEntry { t_entry, t_per_s, length, .. } = entry;
                            let exit =
                                (kind == EntryKind::Inside).then_some(t_entry + f64::from(length) * t_per_s);
                            queue.lanes.set(queue.rays.len(), powers, &entry, false);
                            let (ray, occluder) = (ray as u32, number as u32);
                            queue.rays.push(Queued { ray, occluder, t_entry, t_per_s, exit });
                        }
                        Some(_) | None => test_in_f64(scene, occluder, t_max, rays, ray),
                    }
                }
                if queue.rays.len() > STREAM_LANES - ENTRY_LANES {
                    queue.solve(simd, scene, occluders, t_max, rays);
                }
            }
        }
        queue.solve(simd, scene, occluders, t_max, rays);
    }
}

struct Queue {
    lanes: StreamLanes,
    rays: smallvec::SmallVec<[Queued; STREAM_LANES]>,
}

impl Queue {
    #[inline(always)]
    fn solve<S: Simd>(
        &mut self,
        simd: S,
        scene: &CompiledScene,
        occluders: &[Occluder],
        t_max: f64,
        rays: &mut ShaftRays,
    ) {
        let Self { lanes, rays: queued } = self;
        let mut answers = StreamHits::default();
        lanes.clear_from(queued.len());
        lanes.occluded(simd, queued.len(), &mut answers);
        for lane in bits(answers.found | answers.unresolved) {
            let Queued { ray, occluder, t_entry, t_per_s, exit } = queued[lane];
            let (ray, length) = (ray as usize, answers.s[lane]);
            // The kernel finds a point inside the shape. A ray from outside hits the shape before; one that starts inside
            // hits it where it leaves.
            let t = exit.unwrap_or(t_entry + f64::from(length) * t_per_s);
            if length < f32::INFINITY && t < t_max * (1.0 - END) && t > 0.0 {
                rays.close(ray);
            } else {
                test_in_f64(scene, &occluders[occluder as usize], t_max, rays, ray);
            }
        }
        queued.clear();
    }
}

#[inline(never)]
fn test_in_f64(scene: &CompiledScene, occluder: &Occluder, t_max: f64, rays: &mut ShaftRays, index: usize) {
    if !rays.is_open(index) {
        return;
    }
    let shape = scene.primitives[occluder.primitive as usize].unit_shape();
    let local = rays.ray(index).through(&occluder.unit_from_world);
    if shape.occluded(&local, occluder.start, t_max) {
        rays.close(index);
    }
}
