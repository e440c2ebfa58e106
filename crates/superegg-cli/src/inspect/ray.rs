//! Describes where a ray hits a scene.

use superegg_geom::Ray;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_lang::format_number;
use superegg_render::View;
use superegg_scene::Camera;
use superegg_trace::{CompiledScene, Hit, TraceRay};

/// The first hit of a ray: by the f64 reference path, or with `fast` by the f32 kernels.
pub(crate) fn first_hit(scene: &CompiledScene, ray: &Ray, fast: bool) -> Option<Hit> {
    if fast { scene.intersect_many(&[TraceRay::new(*ray)]).pop().flatten() } else { scene.intersect_ray(ray) }
}

/// Describes the hit of the central camera ray, whose direction has unit length.
pub(crate) fn describe_camera_ray(scene: &CompiledScene, camera: &Camera, fast: bool) -> String {
    let center = View::new(camera, 2, 2).ray(DVec2::ONE);
    let ray = Ray::new(center.origin, center.direction.normalize());
    let (origin, direction) = (numbers(ray.origin), numbers(ray.direction));
    let hit = first_hit(scene, &ray, fast);
    format!("the ray from the camera at {origin} along {direction}\n{}", describe_hit(scene, hit.as_ref()))
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
