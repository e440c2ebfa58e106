//! Queries of one ray, in f64.
//!
//! This is the reference. Streams ([`crate::stream`]) and packets ([`crate::packet`]) are faster, give the same answers and
//! fall back to this path where f32 cannot decide.

mod in_order;
mod traversal;

use superegg_geom::Ray;

use self::traversal::Traversal;
use crate::ray::limits::{Coarsened, LimitReached, RayLimits};
use crate::ray::query::{Hit, TraceRay};
use crate::scene::compiled::CompiledScene;

impl CompiledScene {
    /// The closest hit of a ray with t >= 0.
    ///
    /// At equal t, the hit that comes first in the order of children counts. A ray with a footprint hits
    /// groups much smaller than its width as a whole. `None` also for a direction that is zero or not finite.
    ///
    /// The work for a ray with a footprint is bounded: where a deep fractal has too many overlapping parts, far and small
    /// ones are hit as a whole. A ray without width may take time without end there; [`CompiledScene::intersect_within`]
    /// bounds it.
    pub fn intersect(&self, ray: &TraceRay) -> Option<Hit> {
        self.intersect_counted(ray, false, &mut Coarsened::default())
    }

    /// [`CompiledScene::intersect`] for a ray without width that starts on no surface.
    pub fn intersect_ray(&self, ray: &Ray) -> Option<Hit> {
        self.intersect(&TraceRay::new(*ray))
    }

    /// The exact closest hit of a ray, within limits on the work.
    ///
    /// # Errors
    ///
    /// [`LimitReached`] if the answer needs more work.
    ///
    /// ```
    /// use superegg_geom::Ray;
    /// use superegg_geom::glam::DVec3;
    /// use superegg_scene::Scene;
    /// use superegg_trace::{CompiledScene, RayLimits, TraceRay};
    ///
    /// let mut scene = Scene::default();
    /// scene.ensure_primitive("ball")?;
    /// let compiled = CompiledScene::compile(&scene, Some("ball"), 1);
    /// let ray = TraceRay::new(Ray::new(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z));
    /// let hit = compiled.intersect_within(&ray, &RayLimits::default())?;
    /// assert_eq!(hit.map(|hit| hit.t), Some(4.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn intersect_within(&self, ray: &TraceRay, limits: &RayLimits) -> Result<Option<Hit>, LimitReached> {
        let Some((mut traversal, ray, scale)) = Traversal::closest(self, ray) else { return Ok(None) };
        traversal.bound_exactly(limits);
        traversal.run(&ray);
        if traversal.is_over() {
            return Err(LimitReached { boxes: limits.boxes });
        }
        Ok(traversal.best.map(|hit| Hit { t: hit.t * scale, ..hit }))
    }

    /// [`CompiledScene::intersect`] that counts the ray if its work was bounded. `is_widened` tells that it was widened for
    /// that before, so that it comes to its bound sooner.
    pub(crate) fn intersect_counted(
        &self,
        ray: &TraceRay,
        is_widened: bool,
        coarsened: &mut Coarsened,
    ) -> Option<Hit> {
        let (mut traversal, ray, scale) = Traversal::closest(self, ray)?;
        traversal.is_widened = is_widened;
        traversal.run(&ray);
        coarsened.rays += u64::from(traversal.is_coarsened);
        traversal.best.map(|hit| Hit { t: hit.t * scale, ..hit })
    }

    /// Whether a ray hits any surface with 0 <= t < `t_max`. The work is bounded as for [`CompiledScene::intersect`].
    pub fn occluded(&self, ray: &TraceRay, t_max: f64) -> bool {
        self.occluded_counted(ray, t_max, false, &mut Coarsened::default())
    }

    /// [`CompiledScene::occluded`], as [`CompiledScene::intersect_counted`].
    pub(crate) fn occluded_counted(
        &self,
        ray: &TraceRay,
        t_max: f64,
        is_widened: bool,
        coarsened: &mut Coarsened,
    ) -> bool {
        let mut traversal = Traversal::any_hit(self, ray, t_max);
        traversal.is_widened = is_widened;
        traversal.run(&ray.ray);
        coarsened.rays += u64::from(traversal.is_coarsened);
        traversal.is_occluded
    }

    /// The number of boxes and shapes that [`CompiledScene::intersect`] tests.
    pub fn visited(&self, ray: &TraceRay) -> u64 {
        let Some((mut traversal, ray, _)) = Traversal::closest(self, ray) else { return 0 };
        traversal.run(&ray);
        traversal.visited
    }
}
