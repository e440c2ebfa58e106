//! Describes where a ray hits a scene.

use superegg_geom::Ray;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_lang::format_number;
use superegg_render::View;
use superegg_scene::Camera;
use superegg_trace::{Coarsened, CompiledScene, Footprint, Hit, LimitReached, RayLimits, TraceRay};

/// How the hit of a ray is found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RayMethod {
    /// By the f64 reference path.
    Exact(RayLimits),
    /// By the f32 kernels.
    Fast,
}

/// A width that hides nothing. It bounds the work of the f32 kernels.
const NARROW: Footprint = Footprint { width: f64::MIN_POSITIVE, spread: 0.0 };

/// The first hit of a ray.
///
/// # Errors
/// The ray needs more work than the limits allow.
pub(crate) fn first_hit(
    scene: &CompiledScene,
    ray: &Ray,
    method: RayMethod,
) -> Result<Option<Hit>, LimitReached> {
    let traced = TraceRay::new(*ray);
    match method {
        RayMethod::Exact(limits) => scene.intersect_within(&traced, &limits),
        RayMethod::Fast => {
            let mut coarsened = Coarsened::default();
            let hits = scene.intersect_many_counted(&[traced.with_footprint(NARROW)], &mut coarsened);
            if coarsened.rays > 0 {
                // The reference path needs less work for its answer.
                return first_hit(scene, ray, RayMethod::Exact(RayLimits::default()));
            }
            Ok(hits.into_iter().next().flatten())
        }
    }
}

/// Describes the hit of the central camera ray, whose direction has unit length.
///
/// # Errors
/// As for [`first_hit`].
pub(crate) fn describe_camera_ray(
    scene: &CompiledScene,
    camera: &Camera,
    method: RayMethod,
) -> Result<String, LimitReached> {
    let center = View::new(camera, 2, 2).ray(DVec2::ONE);
    let ray = Ray::new(center.origin, center.direction.normalize());
    let (origin, direction) = (numbers(ray.origin), numbers(ray.direction));
    let hit = first_hit(scene, &ray, method)?;
    let described = describe_hit(scene, hit.as_ref());
    Ok(format!("the ray from the camera at {origin} along {direction}\n{described}"))
}

/// Describes a hit: the instance, `t`, the position and the normal.
pub(crate) fn describe_hit(scene: &CompiledScene, hit: Option<&Hit>) -> String {
    let Some(hit) = hit else { return "meets nothing".to_owned() };
    let surface = scene.interaction(hit);
    let verb = if hit.leaving { "leaves" } else { "meets" };
    format!(
        "{verb} {}\nat t = {}\nat the point {}\nwhere the normal is {}",
        scene.path_name(&hit.path),
        format_number(hit.t),
        numbers(surface.position),
        numbers(surface.normal)
    )
}

fn numbers(v: DVec3) -> String {
    v.to_array().map(format_number).join(" ")
}
