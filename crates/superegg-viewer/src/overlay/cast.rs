//! The intersection test (course text, drawIntersectTest): a ray, its first hit, and the normal
//! there.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayStart, Superquadric};
use superegg_scene::Scene;
use superegg_trace::{CompiledScene, RayLimits, TraceRay};

use crate::draw::{Line, Mark};

/// The first hit of a ray.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CastHit {
    /// Distance from the ray's origin, in world units.
    pub(crate) t: f64,
    /// The point, in world space.
    pub(crate) point: DVec3,
    /// The outward unit normal, in world space.
    pub(crate) normal: DVec3,
    /// Path of the instance: names from the root down, joined by `/`.
    pub(crate) path: String,
    /// Name of the primitive.
    pub(crate) primitive: String,
    /// Newton steps to the hit. `None` for a shape that is not convex: its roots are isolated by
    /// bounds.
    pub(crate) newton_steps: Option<u32>,
}

/// The most boxes that are tested for one ray.
const MOST_BOXES: u64 = 400_000;

/// Intersects a ray with a scene. `compiled` must be compiled from `scene`. Returns `None` if the
/// ray hits nothing, or needs more than [`MOST_BOXES`].
pub(crate) fn cast(scene: &Scene, compiled: &CompiledScene, ray: &Ray) -> Option<CastHit> {
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

const RAY: [f32; 4] = [1.0, 0.85, 0.2, 1.0];
const NORMAL: [f32; 4] = [0.2, 1.0, 0.5, 1.0];

/// Draws a ray up to its hit, or to the distance `far` without one. At the hit it draws the normal
/// with length 1 and a dot.
pub(crate) fn lines_and_marks(
    ray: &Ray,
    hit: Option<&CastHit>,
    far: f64,
    dot_radius: f64,
) -> (Vec<Line>, Vec<Mark>) {
    let end = hit.map_or_else(|| ray.origin + ray.direction.normalize() * far, |hit| hit.point);
    let mut lines = vec![Line { ends: [ray.origin, end], color: RAY }];
    let mut marks = Vec::new();
    if let Some(hit) = hit {
        lines.push(Line { ends: [hit.point, hit.point + hit.normal], color: NORMAL });
        marks.push(Mark { center: hit.point, radius: dot_radius, color: NORMAL, is_on_top: false });
    }
    (lines, marks)
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
        let (lines, marks) = lines_and_marks(&ray, Some(&hit), 1.0, 0.1);
        assert_eq!((lines.len(), marks.len()), (2, 1));
        assert!((lines[1].ends[1] - lines[1].ends[0]).length() - 1.0 < 1e-12);

        let from_below = Ray::new(DVec3::new(0.01, 0.02, -20.0), DVec3::Z);
        let hit = cast(session.scene(), &compiled, &from_below).unwrap();
        assert_eq!((hit.primitive.as_str(), hit.newton_steps), ("star", None));
        assert!(cast(session.scene(), &compiled, &Ray::new(DVec3::X * 50.0, DVec3::Y)).is_none());
    }
}
