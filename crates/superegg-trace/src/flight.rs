//! Rays that have nothing in common, many at a time.
//!
//! They go through the graph as lists ([`crate::stream`]): each node asks those that come to it one after the other, and no ray waits for another one's
//! way. As in [`crate::beam`] that makes candidates, the closest one is settled in f64, and where the lanes cannot tell the ray goes the
//! exact way.

use superegg_geom::kernels::refine::{RefineBatch, RefineRay, refine_powers};
use superegg_geom::{Ray, ShapeHit, scale_to_unit};
use superegg_simd::{Arch, Simd, WithSimd};

use crate::compiled::{CompiledScene, Group, Leaf};
use crate::footprint::Footprint;
use crate::stream::{Found, Stream, Told};
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
            for (part, rays) in rays.chunks(SETTLED_TOGETHER).enumerate() {
                settling.take(self, &stream, part * SETTLED_TOGETHER, rays, &mut found);
            }
        }
        stream.end_here();
        found
    }

    /// How many of many rays meet something: what [`CompiledScene::intersect_many`] does before it settles where.
    pub(crate) fn find_many(&self, rays: &[FlightRay]) -> usize {
        let Some(root) = self.root.as_deref() else { return 0 };
        let (mut stream, mut count) = (Stream::new(self, root, None), 0);
        for rays in rays.chunks(rays_together(root)) {
            Arch::new().dispatch(Run { stream: &mut stream, rays });
            for (place, asked) in rays.iter().enumerate() {
                count += usize::from(match stream.told(place) {
                    Told::Nothing | Told::Occluded => false,
                    Told::Found(_) => true,
                    Told::Doubtful => self.intersect_asked(asked).is_some(),
                });
            }
        }
        stream.end_here();
        count
    }

    /// The exact way.
    fn intersect_asked(&self, asked: &FlightRay) -> Option<Hit> {
        self.intersect_footprint(&asked.ray, asked.departure.as_ref(), asked.footprint)
    }

    /// Whether each of many rays is stopped with 0 <= t < `t_max`: the answers of [`CompiledScene::occluded_footprint`].
    pub fn occluded_many(&self, rays: &[FlightRay], t_max: f64) -> Vec<bool> {
        let mut occluded = vec![false; rays.len()];
        let Some(root) = self.root.as_deref().filter(|_| !rays.is_empty()) else { return occluded };
        let (mut stream, together) = (Stream::new(self, root, Some(t_max)), rays_together(root));
        for (rays, occluded) in rays.chunks(together).zip(occluded.chunks_mut(together)) {
            Arch::new().dispatch(Run { stream: &mut stream, rays });
            for ((place, asked), occluded) in rays.iter().enumerate().zip(occluded) {
                *occluded = match stream.told(place) {
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
const SETTLED_TOGETHER: usize = 128;

/// Crossings that lanes have found, settled in f64.
#[derive(Default)]
struct Settling {
    batch: RefineBatch,
    /// Of each of the batch.
    primitives: Vec<u32>,
}

impl Settling {
    /// Makes hits of what is told of some rays of a stream, from one on, and adds them to others.
    fn take(
        &mut self,
        scene: &CompiledScene,
        stream: &Stream<'_>,
        first: usize,
        rays: &[FlightRay],
        found: &mut Vec<Option<Hit>>,
    ) {
        for (place, asked) in (first..).zip(rays) {
            if let (Told::Found(best), Some((direction, _))) =
                (stream.told(place), scale_to_unit(asked.ray.direction))
                && let Found::Nearly { leaving } = best.found
            {
                let ray = Ray { origin: asked.ray.origin, direction, origin_error: 0.0 };
                let (leaf, ray) = stream.before_leaf(best, &ray);
                self.push(scene, leaf, &ray, best.t, leaving);
            }
        }
        self.batch.run();
        let mut settled_before = 0;
        found.extend((first..).zip(rays).map(|(place, asked)| {
            let best = match stream.told(place) {
                Told::Nothing | Told::Occluded => return None,
                Told::Doubtful => return scene.intersect_asked(asked),
                Told::Found(best) => best,
            };
            // What brings t back to lengths of the ray's own direction.
            let (_, scale) = scale_to_unit(asked.ray.direction)?;
            let path = stream.path(best);
            match best.found {
                Found::Exactly(place) => Some(Hit { t: best.t * scale, path, ..stream.exact(place).clone() }),
                Found::Nearly { leaving } => {
                    let place = settled_before;
                    settled_before += 1;
                    let settled = self.batch.get(place);
                    let settled = settled.map(|(ShapeHit { t, point, .. }, gradient)| {
                        (if leaving { 2.0 * best.t - t } else { t }, point, gradient)
                    });
                    // Where it is farther off than was said another shape may be first.
                    match settled.filter(|(t, ..)| (t - best.t).abs() <= f64::from(best.error)) {
                        Some((t, unit_point, unit_gradient)) => {
                            let primitive = self.primitives[place];
                            Some(Hit { t: t * scale, leaving, primitive, unit_point, unit_gradient, path })
                        }
                        None => scene.intersect_asked(asked),
                    }
                }
            }
        }));
        self.batch.clear();
        self.primitives.clear();
    }

    /// Puts a crossing among those to be settled.
    #[inline(always)]
    fn push(&mut self, scene: &CompiledScene, leaf: &Leaf, ray: &Ray, t: f64, leaving: bool) {
        let Ray { origin, direction, .. } = *ray;
        let powers = refine_powers(&scene.primitives[leaf.primitive as usize].unit_shape());
        self.primitives.push(leaf.primitive);
        self.batch.push(&if leaving {
            // Backwards it is the first crossing.
            RefineRay { origin: origin + 2.0 * t * direction, direction: -direction, t, powers }
        } else {
            RefineRay { origin, direction, t, powers }
        });
    }
}
