//! The intersection test (course text, drawIntersectTest): a ray, where it first meets the scene, and the normal there.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayStart, Superquadric};
use superegg_scene::Scene;
use superegg_trace::CompiledScene;

use crate::draw::{Line, Mark};

/// What a ray met.
#[derive(Clone, Debug, PartialEq)]
pub struct CastHit {
    /// The place on the ray, in world units from its start.
    pub t: f64,
    /// The point.
    pub point: DVec3,
    /// The unit normal, outwards.
    pub normal: DVec3,
    /// The instance: names from the root down, joined by `/`.
    pub path: String,
    /// The primitive's own name.
    pub primitive: String,
    /// Newton steps to the hit. `None` for a shape that is not convex: its roots are isolated by bounds.
    pub newton_steps: Option<u32>,
}

/// Casts a ray into a scene.
pub fn cast(scene: &Scene, compiled: &CompiledScene, ray: &Ray) -> Option<CastHit> {
    let hit = compiled.intersect(ray, None)?;
    let surface = compiled.interaction(&hit);
    let (primitive, described) = scene.primitives().nth(hit.primitive as usize)?;
    let shape = Superquadric::unit(described.shape.exponents());
    let newton_steps = shape.newton_steps(&compiled.unit_ray(ray, &hit), RayStart::Free);
    Some(CastHit {
        t: hit.t * ray.direction.length(),
        point: surface.position,
        normal: surface.normal,
        path: compiled.path_name(&hit.path),
        primitive: primitive.to_owned(),
        newton_steps,
    })
}

const RAY: [f32; 4] = [1.0, 0.85, 0.2, 1.0];
const NORMAL: [f32; 4] = [0.2, 1.0, 0.5, 1.0];

/// The ray up to its hit, or so far where it hits nothing, and the normal of length 1 with a dot at its foot.
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
        marks.push(Mark { center: hit.point, radius: dot_radius, color: NORMAL });
    }
    (lines, marks)
}

#[cfg(test)]
mod tests {
    use superegg_lang::Session;

    use super::*;

    #[test]
    fn the_nearest_of_all_is_told_with_path_normal_and_steps() {
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
