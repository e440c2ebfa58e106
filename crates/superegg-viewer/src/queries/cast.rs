//! The intersection test (course text, drawIntersectTest): the first hit of a ray, and the normal
//! there.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayStart, Superquadric};
use superegg_scene::Scene;
use superegg_trace::{CompiledScene, RayLimits, TraceRay};

/// The first hit of a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct CastHit {
    /// Distance from the ray's origin, in world units.
    pub t: f64,
    /// The point, in world space.
    pub point: DVec3,
    /// The outward unit normal, in world space.
    pub normal: DVec3,
    /// Path of the instance: names from the root down, joined by `/`.
    pub path: String,
    /// Name of the primitive.
    pub primitive: String,
    /// Newton steps to the hit. `None` for a shape that is not convex: its roots are isolated by
    /// bounds.
    pub newton_steps: Option<u32>,
}

/// The most boxes that are tested for one ray.
const MOST_BOXES: u64 = 400_000;

/// Intersects a ray with a scene. `compiled` must be compiled from `scene`. Returns `None` if the
/// ray hits nothing, or needs the test of more than 400,000 boxes.
pub fn cast(scene: &Scene, compiled: &CompiledScene, ray: &Ray) -> Option<CastHit> {
    // The window waits for the answer.
    let limits = RayLimits::default().with_boxes(MOST_BOXES);
    let hit = compiled.intersect_within(&TraceRay::new(*ray), &limits).ok().flatten()?;
    let surface = compiled.interaction(&hit);
    let (name, primitive) = scene.primitives().nth(hit.primitive as usize)?;
    let shape = Superquadric::unit(primitive.shape.exponents());
    let newton_steps = shape.newton_steps(&compiled.unit_ray(ray, &hit), RayStart::Free);
    Some(CastHit {
        t: hit.t * ray.direction.length(),
        point: surface.position,
        normal: surface.normal,
        path: compiled.path_name(&hit.path),
        primitive: name.to_owned(),
        newton_steps,
    })
}

#[cfg(test)]
mod tests {
    use superegg_lang::Session;

    use super::*;

    #[test]
    fn the_first_hit_has_path_normal_and_steps() {
        let mut session = Session::default();
        for line in [
            "prm ball",
            "prm star",
            "exp 3 3",
            "obj o",
            "ap star",
            "xs 0 0 -9",
            "ap ball b",
            "ss 1 1 2",
            "xs 0 0 3",
        ] {
            assert!(session.run_line(line).is_ok(), "{line}");
        }
        let compiled = CompiledScene::compile(session.scene(), session.selected(), 25);
        let ray = Ray::new(DVec3::Z * 10.0, DVec3::NEG_Z * 2.0);
        let hit = cast(session.scene(), &compiled, &ray).unwrap();
        assert_eq!((hit.path.as_str(), hit.primitive.as_str()), ("o/b", "ball"));
        assert!(
            (hit.t - 5.0).abs() < 1e-9
                && (hit.point.z - 5.0).abs() < 1e-9
                && (hit.normal - DVec3::Z).length() < 1e-9
        );
        assert!(hit.newton_steps.is_some_and(|steps| steps < 48));

        let from_below = Ray::new(DVec3::new(0.01, 0.02, -20.0), DVec3::Z);
        let hit = cast(session.scene(), &compiled, &from_below).unwrap();
        assert_eq!((hit.primitive.as_str(), hit.newton_steps), ("star", None));
        assert!(cast(session.scene(), &compiled, &Ray::new(DVec3::X * 50.0, DVec3::Y)).is_none());
    }
}
