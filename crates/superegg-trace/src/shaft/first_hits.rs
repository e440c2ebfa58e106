//! The first hits of rays on the few shapes in their beam.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::refine::{RefineBatch, RefineRay, refine_powers};
use superegg_geom::kernels::stream::{
    EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamHits, StreamLanes,
};
use superegg_geom::{RayStart, ShapeHit};
use superegg_simd::{Arch, Simd, WithSimd, bits};

use super::occluders::Occluder;
use super::occlusion::ShaftRays;
use crate::ray::query::Hit;
use crate::scene::compiled::CompiledScene;

/// The first hit of a ray.
#[derive(Clone, Debug)]
pub enum FirstHit {
    /// The ray hits none of the shapes.
    None,
    /// The hit, in f64.
    Hit(Hit),
    /// The ray starts inside a shape, or f32 does not tell its hits apart.
    Unknown,
}

/// First hits, with memory for one beam after the other.
#[derive(Debug, Default)]
pub struct FirstHits {
    /// The hit of each ray, in their order.
    pub found: Vec<FirstHit>,
    nearest: Vec<Nearest>,
    batch: RefineBatch,
}

/// The nearest crossing of a ray so far, in f32.
#[derive(Clone, Copy, Debug)]
enum Nearest {
    None,
    Crossing { t: f64, error: f64, occluder: u32 },
    Unknown,
}

impl Nearest {
    /// Takes a crossing if it is closer. If their errors overlap, the ray is not resolved.
    fn take(&mut self, t: f64, error: f64, occluder: u32) {
        match *self {
            Self::Unknown => {}
            Self::Crossing { t: old, error: old_error, .. } if (t - old).abs() <= error + old_error => {
                *self = Self::Unknown;
            }
            Self::Crossing { t: old, .. } if old < t => {}
            Self::None | Self::Crossing { .. } => *self = Self::Crossing { t, error, occluder },
        }
    }
}

impl CompiledScene {
    /// Finds the first hit of each ray among these shapes, without an end of the rays.
    pub fn first_hits(&self, occluders: &[Occluder], rays: &ShaftRays, hits: &mut FirstHits) {
        let FirstHits { found, nearest, batch } = hits;
        nearest.clear();
        nearest.resize(rays.len(), Nearest::None);
        Arch::new().dispatch(FindNearest { occluders, rays, nearest });
        batch.clear();
        for (ray, nearest) in nearest.iter().enumerate() {
            if let Nearest::Crossing { t, occluder, .. } = *nearest {
                let Occluder { unit_from_world, primitive, .. } = &occluders[occluder as usize];
                let local = rays.ray(ray).through(unit_from_world);
                let powers = refine_powers(&self.primitives.unit_shape(*primitive));
                batch.push(&RefineRay { origin: local.origin, direction: local.direction, t, powers });
            }
        }
        batch.run();
        found.clear();
        let mut refined = 0..;
        found.extend(nearest.iter().map(|nearest| {
            let Nearest::Crossing { t: near, error, occluder } = *nearest else {
                return if matches!(nearest, Nearest::None) { FirstHit::None } else { FirstHit::Unknown };
            };
            let answer = refined.next().and_then(|index| batch.get(index));
            // If the refined t is outside the error bound, another shape may be closer.
            let Some((ShapeHit { t, leaving, point: unit_point }, gradient)) =
                answer.filter(|(hit, _)| (hit.t - near).abs() <= error)
            else {
                return FirstHit::Unknown;
            };
            let Occluder { primitive, path, .. } = &occluders[occluder as usize];
            let unit_gradient = (gradient != DVec3::ZERO).then_some(gradient);
            let (primitive, path) = (*primitive, path.clone());
            FirstHit::Hit(Hit { t, leaving, primitive, unit_point, unit_gradient, path, scene: self.id })
        }));
    }
}

/// Finds the nearest crossing of each ray in f32.
struct FindNearest<'a> {
    occluders: &'a [Occluder],
    rays: &'a ShaftRays,
    nearest: &'a mut [Nearest],
}

/// A ray that waits for the kernel.
#[derive(Clone, Copy)]
struct Queued {
    ray: usize,
    occluder: u32,
    t_entry: f64,
    t_per_s: f64,
}

impl WithSimd for FindNearest<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { occluders, rays, nearest } = self;
        let mut entries = ShapeEntries::default();
        let (mut lanes, mut answers) = (StreamLanes::default(), StreamHits::default());
        let mut queued = smallvec::SmallVec::<[Queued; STREAM_LANES]>::new();
        for (number, occluder) in (0..).zip(occluders) {
            rays.for_each_entry(occluder, f64::INFINITY, &mut entries, |ray, kind, entry| {
                let is_free = occluder.is_convex && occluder.start == RayStart::Free;
                if kind != EntryKind::Enters || !is_free {
                    nearest[ray] = Nearest::Unknown;
                    return;
                }
                let ShapeEntry { t_entry, t_per_s, .. } = entry;
                lanes.set(queued.len(), occluder.powers, &entry, false);
                queued.push(Queued { ray, occluder: number, t_entry, t_per_s });
                if queued.len() == STREAM_LANES {
                    run(&mut lanes, &mut queued, &mut answers, nearest);
                }
            });
        }
        run(&mut lanes, &mut queued, &mut answers, nearest);
    }
}

/// Takes the crossings of the queued rays.
fn run(
    lanes: &mut StreamLanes,
    queued: &mut smallvec::SmallVec<[Queued; STREAM_LANES]>,
    answers: &mut StreamHits,
    nearest: &mut [Nearest],
) {
    lanes.clear_from(queued.len());
    lanes.intersect(queued.len(), answers);
    for lane in bits(answers.found | answers.unresolved) {
        let Queued { ray, occluder, t_entry, t_per_s } = queued[lane];
        if answers.unresolved >> lane & 1 == 1 {
            nearest[ray] = Nearest::Unknown;
            continue;
        }
        let (s, error) = (f64::from(answers.s[lane]), f64::from(answers.error[lane]));
        nearest[ray].take(t_entry + s * t_per_s, error * t_per_s, occluder);
    }
    queued.clear();
}

#[cfg(test)]
mod tests {
    use superegg_geom::{Aabb, Ray, SplitMix};
    use superegg_lang::load_text;

    use super::super::hull::Shaft;
    use super::super::occluders::ShaftStart;
    use super::*;

    fn vector(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
    }

    #[test]
    fn first_hits_are_those_of_the_scene() {
        let mut random = SplitMix::new(27);
        let (mut hit, mut missed, mut unknown) = (0, 0, 0);
        for case in 0..300 {
            let mut text = String::new();
            for shape in 0..1 + case % 4 {
                let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
                // Some are not convex.
                let (e, n) = (number(0.05, 2.1), number(0.05, 2.0));
                let (x, y, z) = (number(-1.5, 1.5), number(-1.5, 1.5), number(-1.5, 1.5));
                let (flat, angle) = (number(0.01, 1.0), number(0.0, 360.0));
                text += &format!(
                    "prm p{shape}\nexp {e} {n}\ncoeff 1 {flat} .7\nobj all\nap p{shape}\nrs 1 2 3 {angle}\nxs {x} {y} {z}\n"
                );
            }
            let size = 10f64.powf(6.0 * random.unit() - 3.0);
            text += &format!("obj whole\nao all\nss {size} {size} -{size}\nxs 3 1 -2\n");
            let (session, diagnostics) = load_text("hits.scn", &text);
            assert!(diagnostics.is_empty(), "{diagnostics:?}");
            let scene = CompiledScene::compile(session.scene(), Some("whole"), 4);
            let around = Aabb::around(DVec3::ZERO, DVec3::splat(1e5));
            let (mut shapes, mut rays, mut hits) = (Vec::new(), ShaftRays::default(), FirstHits::default());
            let everywhere = Shaft::between(&around, &around);
            assert!(scene.find_occluders(&everywhere, ShaftStart::default(), &mut shapes));
            let middle = DVec3::new(3.0, 1.0, -2.0);
            let given: Vec<Ray> = (0..21)
                .map(|_| {
                    let origin = middle + size * (4.0 * vector(&mut random));
                    let target = middle + size * (1.5 * vector(&mut random));
                    Ray::new(origin, (target - origin) * 10f64.powf(4.0 * random.unit() - 2.0))
                })
                .collect();
            given.iter().for_each(|ray| rays.push(ray));
            scene.first_hits(&shapes, &rays, &mut hits);
            assert_eq!(hits.found.len(), given.len());
            for (ray, found) in given.iter().zip(&hits.found) {
                let expected = scene.intersect(&(*ray).into());
                match (found, expected) {
                    (FirstHit::Unknown, _) => unknown += 1,
                    (FirstHit::None, None) => missed += 1,
                    (FirstHit::Hit(found), Some(expected)) => {
                        assert_eq!((&found.path, found.leaving), (&expected.path, expected.leaving));
                        assert!(
                            (found.t - expected.t).abs() <= 1e-11 * expected.t,
                            "case {case}: {ray:?} {text}"
                        );
                        assert!(
                            (found.unit_point - expected.unit_point).length() < 1e-9,
                            "case {case}: {text}"
                        );
                        hit += 1;
                    }
                    (found, expected) => panic!("case {case}: {ray:?} {found:?} {expected:?}\n{text}"),
                }
            }
        }
        assert!(hit > 1_500 && missed > 1_500 && unknown < 500, "{hit} {missed} {unknown}");
    }
}
