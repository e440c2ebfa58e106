//! Shadow rays against the few shapes in their shaft.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::LanePowers;
use superegg_geom::kernels::stream::{
    END, ENTRY_LANES, EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamHits, StreamLanes,
};
use superegg_geom::kernels::verify::{KnownCrossing, VerifyBatch};
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

    /// The rays that no shape has occluded so far.
    pub fn open(&self) -> OpenRays {
        OpenRays(self.groups.iter().map(|group| group.open as u8).collect())
    }

    /// The direction of the ray of this index.
    pub fn direction(&self, index: usize) -> DVec3 {
        let (group, lane) = (&self.groups[index / ENTRY_LANES], index % ENTRY_LANES);
        DVec3::from_array(group.direction.each_ref().map(|column| column[lane]))
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

    /// Visits the open rays that meet the box of a shape before t = `t_max`, with the way they do. `entries` is memory.
    #[inline(always)]
    pub(super) fn for_each_entry(
        &self,
        occluder: &Occluder,
        t_max: f64,
        entries: &mut ShapeEntries,
        mut visit: impl FnMut(usize, EntryKind, ShapeEntry),
    ) {
        for (group, Eight { origin, direction, open }) in self.groups.iter().enumerate() {
            if *open == 0 {
                continue;
            }
            entries.set_all(&occluder.unit_from_world, origin, direction, t_max);
            entries.run();
            for lane in bits(*open) {
                let kind = entries.kind(lane);
                if kind != EntryKind::Misses {
                    visit(group * ENTRY_LANES + lane, kind, entries.get(lane));
                }
            }
        }
    }

    fn close(&mut self, index: usize) {
        self.groups[index / ENTRY_LANES].open &= !(1 << (index % ENTRY_LANES));
    }
}

/// The rays of [`ShaftRays`] that no shape had occluded at a time.
#[derive(Clone, Debug)]
pub struct OpenRays(Vec<u8>);

impl OpenRays {
    /// Whether the ray of this index was open.
    pub fn is_open(&self, index: usize) -> bool {
        self.0[index / ENTRY_LANES] >> (index % ENTRY_LANES) & 1 == 1
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
    fn with_simd<S: Simd>(self, _: S) {
        let Self { scene, occluders, t_max, rays } = self;
        let mut convex = Queue::new(true);
        let mut others = Queue::new(false);
        let mut entries = ShapeEntries::default();
        for (number, occluder) in occluders.iter().enumerate() {
            for group in 0..rays.groups.len() {
                let Eight { origin, direction, open } = &rays.groups[group];
                let open = *open;
                if open == 0 {
                    continue;
                }
                entries.set_all(&occluder.unit_from_world, origin, direction, t_max);
                entries.run();
                for lane in bits(open) {
                    let kind = entries.kind(lane);
                    if kind == EntryKind::Misses {
                        continue;
                    }
                    let ray = group * ENTRY_LANES + lane;
                    let entry = entries.get(lane);
                    let is_inside = kind == EntryKind::Inside;
                    let entry = match occluder.start {
                        RayStart::Free => Some(entry),
                        RayStart::SurfaceOutward if !occluder.is_convex && is_inside => {
                            entry.beyond_surface()
                        }
                        RayStart::SurfaceOutward | RayStart::SurfaceInward => None,
                    };
                    let Some(entry) = entry.filter(|_| kind != EntryKind::Unresolved) else {
                        test_in_f64(scene, occluder, t_max, rays, ray);
                        continue;
                    };
                    let ShapeEntry { t_entry, t_per_s, length, .. } = entry;
                    // A free ray may start inside.
                    let may_exit = is_inside && occluder.start == RayStart::Free;
                    let exit = may_exit.then_some(t_entry + f64::from(length) * t_per_s);
                    let (ray, number) = (ray as u32, number as u32);
                    let queued = Queued { ray, occluder: number, t_entry, t_per_s, exit };
                    let queue = if occluder.is_convex { &mut convex } else { &mut others };
                    queue.push(occluder.powers, &entry, queued);
                }
                for queue in [&mut convex, &mut others] {
                    if queue.is_full() {
                        queue.run(scene, occluders, t_max, rays);
                    }
                }
            }
        }
        convex.run(scene, occluders, t_max, rays);
        others.run(scene, occluders, t_max, rays);
    }
}

/// Rays that wait for a kernel.
struct Queue {
    /// Whether the shapes are convex.
    is_convex: bool,
    lanes: StreamLanes,
    rays: smallvec::SmallVec<[Queued; STREAM_LANES]>,
    answers: StreamHits,
    /// Misses of rays that start on the shape, to be verified, by their lanes.
    verify: VerifyBatch,
    verified_lanes: smallvec::SmallVec<[usize; STREAM_LANES]>,
}

impl Queue {
    fn new(is_convex: bool) -> Self {
        let (lanes, answers) = (StreamLanes::default(), StreamHits::default());
        let (rays, verified_lanes) = (smallvec::SmallVec::new(), smallvec::SmallVec::new());
        Self { is_convex, lanes, rays, answers, verify: VerifyBatch::default(), verified_lanes }
    }

    #[inline(always)]
    fn push(&mut self, powers: LanePowers, entry: &ShapeEntry, ray: Queued) {
        self.lanes.set(self.rays.len(), powers, entry, false);
        self.rays.push(ray);
    }

    /// Whether the next eight rays might not fit.
    #[inline(always)]
    fn is_full(&self) -> bool {
        self.rays.len() > STREAM_LANES - ENTRY_LANES
    }

    /// Closes the rays that the kernel finds occluded, and tests those that it leaves open in f64.
    #[inline(always)]
    fn run(&mut self, scene: &CompiledScene, occluders: &[Occluder], t_max: f64, rays: &mut ShaftRays) {
        let Self { is_convex, lanes, rays: queued, answers, verify, verified_lanes } = self;
        let count = queued.len();
        lanes.clear_from(count);
        if *is_convex {
            lanes.occluded(count, answers);
        } else {
            lanes.enters(count, answers);
        }
        // The first stretch of rays that start on the shape is not known.
        let is_on_shape = |queued: &Queued| occluders[queued.occluder as usize].start != RayStart::Free;
        let on_shape = queued.iter().rev().fold(0, |mask, ray| mask << 1 | u32::from(is_on_shape(ray)));
        for lane in bits(answers.found | answers.unresolved | on_shape) {
            let Queued { ray, occluder, t_entry, t_per_s, exit } = queued[lane];
            let (ray, length) = (ray as usize, answers.s[lane]);
            // The kernel finds a point inside the shape. A ray from outside hits the shape before; one that starts inside
            // hits it where it leaves.
            let t = exit.unwrap_or(t_entry + f64::from(length) * t_per_s);
            if length < f32::INFINITY && t < t_max * (1.0 - END) && t > 0.0 {
                rays.close(ray);
            } else if length < f32::INFINITY || answers.unresolved >> lane & 1 == 1 {
                test_in_f64(scene, &occluders[occluder as usize], t_max, rays, ray);
            } else if rays.is_open(ray) {
                let Occluder { primitive, start, unit_from_world, .. } = &occluders[occluder as usize];
                let shape = scene.primitives.unit_shape(*primitive);
                let known = KnownCrossing { clear_from: t_entry, between: None };
                verify.push(&shape, &rays.ray(ray).through(unit_from_world), *start, &known);
                verified_lanes.push(lane);
            }
        }
        verify.run();
        for (number, &lane) in verified_lanes.iter().enumerate() {
            if verify.get(number).is_none() {
                let Queued { ray, occluder, .. } = queued[lane];
                test_in_f64(scene, &occluders[occluder as usize], t_max, rays, ray as usize);
            }
        }
        verify.clear();
        verified_lanes.clear();
        queued.clear();
    }
}

#[inline(never)]
fn test_in_f64(scene: &CompiledScene, occluder: &Occluder, t_max: f64, rays: &mut ShaftRays, index: usize) {
    if !rays.is_open(index) {
        return;
    }
    let shape = scene.primitives.unit_shape(occluder.primitive);
    let local = rays.ray(index).through(&occluder.unit_from_world);
    if shape.occluded(&local, occluder.start, t_max) {
        rays.close(index);
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::{Aabb, SplitMix};
    use superegg_lang::load_text;

    use super::super::hull::Shaft;
    use super::super::occluders::ShaftStart;
    use super::*;
    use crate::ray::query::{SurfaceStart, TraceRay};

    /// A fractal of overlapping shapes, some of them not convex, with sheared and mirrored children.
    const FRACTAL: &str = "prm ball\nexp 1 .4\ncoeff .2 .3 .1\nprm star\nexp 3 2.5\ncoeff .3 .2 .3\n\
        obj all\nap ball\nap star\nxs .3 .2 .1\nao all a\nrs 1 2 3 40\nss .8 .8 .8\nxs .6 0 0\n\
        ao all b\nrs 2 1 0 70\nss .8 .7 -.8\nxs -.6 .2 0\nao all c\nss .6 .6 .6\nxs 0 -1.2 .4\n";

    fn vector(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
    }

    #[test]
    fn rays_in_a_shaft_are_occluded_as_in_the_scene() {
        let (session, diagnostics) = load_text("shaft.scn", FRACTAL);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = CompiledScene::compile(session.scene(), Some("all"), 4);
        let mut random = SplitMix::new(11);
        let (mut empty, mut few, mut many, mut occluded, mut on_surfaces) = (0, 0, 0, 0, 0);
        let (mut found, mut rays) = (Vec::new(), ShaftRays::default());
        for case in 0..1_500 {
            // From points of a surface, or from free ones.
            let free = 2.5 * vector(&mut random);
            let hit = scene.intersect(&Ray::new(free, -free + 0.5 * vector(&mut random)).into());
            let surface = hit.filter(|hit| case % 2 == 0 && !hit.leaving).map(|hit| scene.interaction(&hit));
            let (origin, error) =
                surface.as_ref().map_or((free, 0.0), |surface| (surface.position, surface.position_error));
            let spread = if surface.is_some() { 0.0 } else { 0.2 };
            let target = 3.0 * vector(&mut random);
            let is_sun = case % 3 == 0;
            let (mut given, radius) = (Vec::new(), 0.3 * random.unit());
            for _ in 0..13 {
                let origin = origin + spread * vector(&mut random);
                let to = target + radius * vector(&mut random);
                let direction = if is_sun { to } else { to - origin };
                if surface.as_ref().is_none_or(|surface| surface.normal.dot(direction) > 0.0) {
                    given.push(Ray { origin, direction, origin_error: error });
                }
            }
            let around = |center: DVec3, half: f64| Aabb::around(center, DVec3::splat(half));
            let origins = around(origin, spread + error);
            let shaft = if is_sun {
                Shaft::along(&origins, &around(target, radius))
            } else {
                Shaft::between(&origins, &around(target, radius))
            };
            let own = surface.as_ref().map(|surface| &surface.path);
            on_surfaces += u32::from(own.is_some());
            if !scene.find_occluders(&shaft, ShaftStart { own, width: 0.0 }, &mut found) {
                many += 1;
                continue;
            }
            *if found.is_empty() { &mut empty } else { &mut few } += 1;
            rays.clear();
            given.iter().for_each(|ray| rays.push(ray));
            let end = if is_sun { f64::INFINITY } else { 1.0 };
            scene.occlude_rays(&found, end, &mut rays);
            for (index, ray) in given.iter().enumerate() {
                let start = own.and_then(|own| SurfaceStart::of(own.clone(), RayStart::SurfaceOutward));
                let expected = scene.occluded(&TraceRay::new(*ray).with_start(start), end);
                assert_eq!(rays.is_open(index), !expected, "case {case}: {ray:?}");
                occluded += u32::from(expected);
            }
        }
        assert!(
            empty > 100 && few > 300 && many > 10 && occluded > 500 && on_surfaces > 100,
            "{empty} {few} {many} {occluded} {on_surfaces}"
        );
    }

    #[test]
    fn groups_that_a_wide_ray_does_not_open_end_the_search() {
        let (session, _) = load_text("shaft.scn", FRACTAL);
        let scene = CompiledScene::compile(session.scene(), Some("all"), 12);
        let shaft = Shaft::between(
            &Aabb::around(DVec3::new(0.0, 0.0, 3.0), DVec3::splat(0.01)),
            &Aabb::around(DVec3::new(0.0, 0.0, -3.0), DVec3::splat(0.01)),
        );
        let mut found = Vec::new();
        assert!(!scene.find_occluders(&shaft, ShaftStart { own: None, width: 1e3 }, &mut found));
        let beside = Shaft::between(
            &Aabb::around(DVec3::new(40.0, 0.0, 3.0), DVec3::splat(0.01)),
            &Aabb::around(DVec3::new(40.0, 0.0, -3.0), DVec3::splat(0.01)),
        );
        assert!(scene.find_occluders(&beside, ShaftStart { own: None, width: 1e3 }, &mut found));
        assert!(found.is_empty());
    }
}
