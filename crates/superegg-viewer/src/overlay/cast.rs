//! The drawing of the intersection test: a ray, its first hit, and the normal there.

use superegg_geom::Ray;

use crate::draw::{Line, Mark};
use crate::queries::CastHit;

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
    use superegg_geom::glam::DVec3;

    use super::*;

    #[test]
    fn a_hit_has_a_ray_a_normal_and_a_dot() {
        let hit = CastHit {
            t: 5.0,
            point: 5.0 * DVec3::Z,
            normal: DVec3::Z,
            path: "o/b".to_owned(),
            primitive: "ball".to_owned(),
            newton_steps: Some(3),
        };
        let ray = Ray::new(DVec3::Z * 10.0, DVec3::NEG_Z * 2.0);
        let (lines, marks) = lines_and_marks(&ray, Some(&hit), 1.0, 0.1);
        assert_eq!((lines.len(), marks.len()), (2, 1));
        assert!(((lines[1].ends[1] - lines[1].ends[0]).length() - 1.0).abs() < 1e-12);
        let (lines, marks) = lines_and_marks(&ray, None, 3.0, 0.1);
        assert_eq!((lines[0].ends[1], marks.len()), (7.0 * DVec3::Z, 0));
    }
}
