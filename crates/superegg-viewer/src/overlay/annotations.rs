//! Coordinate axes and marks at the positions of the lights.

use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;
use superegg_scene::{Camera, Encoding, Light};

use crate::draw::{Line, Mark, encoded};

/// Least length of the axes, in world units. In a larger scene they reach beyond its bounding box.
const AXIS_LENGTH: f64 = 5.0;
/// Radius of a light's mark, in units of the distance from camera to target.
const LIGHT_SIZE: f64 = 0.012;

/// The x, y and z axes in red, green and blue, bright on the positive side.
pub(crate) fn axes(bounds: Option<&Aabb>) -> Vec<Line> {
    let reach = bounds.map_or(0.0, |bounds| bounds.min.abs().max(bounds.max.abs()).max_element());
    let length = if reach.is_finite() { AXIS_LENGTH.max(1.2 * reach) } else { AXIS_LENGTH };
    let axis = |direction: DVec3, sign: f64, brightness: f32| {
        let [r, g, b] = (direction.as_vec3() * brightness + 0.12 * brightness).to_array();
        Line {
            ends: [DVec3::ZERO, sign * length * direction],
            color: [r.min(1.0), g.min(1.0), b.min(1.0), 1.0],
        }
    };
    [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|direction| [axis(direction, 1.0, 1.0), axis(direction, -1.0, 0.4)])
        .collect()
}

/// A small sphere in the colour of each light at its position. A directional light has none.
pub(crate) fn light_marks(lights: &[Light], camera: &Camera, encoding: Encoding) -> Vec<Mark> {
    let radius = LIGHT_SIZE * (camera.target - camera.position).length();
    let mark = |light: &Light| {
        let color = encoded(light.color / light.color.max_element().max(1e-300), encoding);
        let [r, g, b] = color.map(|part| part.max(0.1) as f32);
        Some(Mark { center: light.position()?, radius, color: [r, g, b, 1.0], is_on_top: false })
    };
    lights.iter().filter_map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_axes_are_the_brighter() {
        let lines = axes(Some(&Aabb::around(DVec3::ZERO, DVec3::splat(100.0))));
        assert_eq!(lines.len(), 6);
        for pair in lines.chunks(2) {
            let sum = |line: &Line| line.color[..3].iter().sum::<f32>();
            assert!(sum(&pair[0]) > sum(&pair[1]) && pair[0].ends[1].max_element() == 120.0);
        }
        assert_eq!(axes(None)[0].ends[1], DVec3::X * 5.0);
    }
}
