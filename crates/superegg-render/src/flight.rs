//! Rays that have nothing in common, many at a time.
//!
//! They go through the graph as lists ([`crate::stream`]): each node asks those that come to it one after the other, and no ray waits for another one's
//! way. As in [`crate::beam`] that makes candidates, the closest one is settled in f64, and where the lanes cannot tell the ray goes the
//! exact way.

use pulp::{Arch, Simd, WithSimd};
use superegg_geom::lanes::settle::{SettleBatch, SettleRay, settle_powers};
use superegg_geom::{Ray, ShapeHit, scale_to_unit};

use crate::compiled::{CompiledScene, Group};
use crate::footprint::Footprint;
use crate::path::InstancePath;
use crate::stream::{Best, Found, Stream, Told};
use crate::traverse::{Departure, Hit};

/// A ray and what is asked of it.
#[derive(Clone, Debug)]
pub struct FlightRay {
    /// The ray.
    pub ray: Ray,
    /// What is known of its start.
    pub departure: Option<Departure>,
    /// Its width.
    pub footprint: Footprint,
}

impl From<Ray> for FlightRay {
    fn from(ray: Ray) -> Self {
        Self { ray, departure: None, footprint: Footprint::NONE }
    }
}

/// How many rays go together: as many as a core's cache has room for what is kept of them; where the scene itself is larger than that, more, since long
/// lists are then worth more than the cache.
fn rays_together(root: &Group) -> usize {
    (16 * root.nodes.len()).clamp(1 << 14, 1 << 17)
}

impl CompiledScene {
    /// The first crossing on each of many rays: the answers of [`CompiledScene::intersect_footprint`], found together.
    pub fn intersect_many(&self, rays: &[FlightRay]) -> Vec<Option<Hit>> {
        let Some(root) = self.root.as_deref() else { return vec![None; rays.len()] };
        let mut found = Vec::with_capacity(rays.len());
        let mut stream = Stream::new(self, root, None);
        let (mut settling, together) = (Settling::default(), rays_together(root));
        for rays in rays.chunks(together) {
            Arch::new().dispatch(Run { stream: &mut stream, rays });
            // Some at a time, so that each stays in the nearest cache from the first to the last that is done with it.
            let parts = rays.chunks(SETTLED_TOGETHER).zip(stream.told().chunks(SETTLED_TOGETHER));
            for (rays, told) in parts {
                settling.take(self, root, &stream, told, rays, &mut found);
            }
        }
        stream.end_here();
        found
    }

    /// Whether each of many rays is stopped with 0 <= t < `t_max`: the answers of [`CompiledScene::occluded_footprint`].
    pub fn occluded_many(&self, rays: &[FlightRay], t_max: f64) -> Vec<bool> {
        let mut occluded = vec![false; rays.len()];
        let Some(root) = self.root.as_deref().filter(|_| !rays.is_empty()) else { return occluded };
        let (mut stream, together) = (Stream::new(self, root, Some(t_max)), rays_together(root));
        for (rays, occluded) in rays.chunks(together).zip(occluded.chunks_mut(together)) {
            Arch::new().dispatch(Run { stream: &mut stream, rays });
            for ((asked, told), occluded) in rays.iter().zip(stream.told()).zip(occluded) {
                *occluded = match *told {
                    Told::Nothing => false,
                    Told::Doubtful => {
                        self.occluded_footprint(&asked.ray, asked.departure.as_ref(), t_max, asked.footprint)
                    }
                    Told::Occluded | Told::Found(_) => true,
                };
            }
        }
        stream.end_here();
        occluded
    }
}

/// The part that the lanes of the machine compile for.
pub(crate) struct Run<'a, 's> {
    pub(crate) stream: &'a mut Stream<'s>,
    pub(crate) rays: &'s [FlightRay],
}

impl WithSimd for Run<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.stream.run(simd, self.rays);
    }
}

/// How many rays have their crossings settled together.
const SETTLED_TOGETHER: usize = 64;

/// Crossings that lanes have found, still to be settled in f64.
#[derive(Default)]
struct Settling {
    batch: SettleBatch,
    open: Vec<Open>,
}

/// The ray of a crossing.
struct Open {
    index: usize,
    /// What brings t back to lengths of the ray's own direction.
    scale: f64,
    /// What the lanes say.
    best: Best,
    /// A ray that leaves is settled backwards from twice as far.
    leaving: bool,
    primitive: u32,
    path: InstancePath,
}

impl Settling {
    /// Makes hits of what is told of rays, and adds them to others.
    fn take(
        &mut self,
        scene: &CompiledScene,
        root: &Group,
        stream: &Stream<'_>,
        told: &[Told],
        rays: &[FlightRay],
        found: &mut Vec<Option<Hit>>,
    ) {
        let before = found.len();
        let exactly = |asked: &FlightRay| {
            scene.intersect_footprint(&asked.ray, asked.departure.as_ref(), asked.footprint)
        };
        for (index, (asked, told)) in rays.iter().zip(told).enumerate() {
            found.push(match told {
                Told::Nothing | Told::Occluded => None,
                Told::Doubtful => exactly(asked),
                Told::Found(best) => {
                    let Some((direction, scale)) = scale_to_unit(asked.ray.direction) else {
                        found.push(None);
                        continue;
                    };
                    let path = stream.path(best);
                    match best.found {
                        Found::Exactly(place) => {
                            let hit = stream.exact(place);
                            Some(Hit { t: best.t * scale, path, ..hit.clone() })
                        }
                        Found::Nearly { leaving } => {
                            let ray = Ray { direction, ..asked.ray };
                            let primitive = self.open(scene, root, &ray, &path, best.t, leaving);
                            self.open.push(Open { index, scale, best: *best, leaving, primitive, path });
                            None
                        }
                    }
                }
            });
        }
        self.batch.run();
        for (place, open) in self.open.drain(..).enumerate() {
            let Open { index, scale, best, leaving, primitive, path } = open;
            let settled = self
                .batch
                .get(place)
                .map(|(ShapeHit { t, point, .. }, _)| (if leaving { 2.0 * best.t - t } else { t }, point));
            // Where it is farther off than was said another shape may be first.
            let settled = settled.filter(|(t, _)| (t - best.t).abs() <= f64::from(best.error));
            found[before + index] = match settled {
                Some((t, unit_point)) => Some(Hit { t: t * scale, leaving, primitive, unit_point, path }),
                None => exactly(&rays[index]),
            };
        }
        self.batch.clear();
    }

    /// Puts a crossing among those to be settled, and tells of which primitive it is.
    fn open(
        &mut self,
        scene: &CompiledScene,
        root: &Group,
        ray: &Ray,
        path: &InstancePath,
        t: f64,
        leaving: bool,
    ) -> u32 {
        let Some((&last, above)) = path.places().split_last() else { return 0 };
        let (group, ray) = root.follow(above, &Ray { origin_error: 0.0, ..*ray });
        let leaf = &group.leaves[last as usize];
        let Ray { origin, direction, .. } = ray.through(&leaf.unit_from_group);
        let powers = settle_powers(&scene.primitives[leaf.primitive as usize].unit_shape());
        self.batch.push(&if leaving {
            // Backwards it is the first crossing.
            SettleRay { origin: origin + 2.0 * t * direction, direction: -direction, t, powers }
        } else {
            SettleRay { origin, direction, t, powers }
        });
        leaf.primitive
    }
}
