//! Points spread over a shape's surface: its area, and how far it is from another one.

use superegg_geom::glam::DVec3;

use crate::parameters::Parameters;
use crate::rows::Points;
use crate::tangent::Linearization;

/// The cells along each side of a grid on the surface.
const CELLS: usize = 4;

/// The points of a grid.
type Grid = [[DVec3; CELLS + 1]; CELLS + 1];

/// The surface area of a polyhedron inscribed in the shape: exact for boxes and octahedra, 1 % below that
/// of a sphere. Shapes that are nearly the same have nearly the same one, whatever their parameters.
pub(crate) fn inscribed_area(shape: &Parameters) -> f64 {
    let mut area = 0.0;
    for grid in octant(shape) {
        for i in 0..CELLS {
            for j in 0..CELLS {
                let [low, right, up, high] = [grid[i][j], grid[i + 1][j], grid[i][j + 1], grid[i + 1][j + 1]];
                area += (right - low).cross(up - low).length() + (right - high).cross(up - high).length();
            }
        }
    }
    4.0 * area
}

/// The root mean square of the distances of points of one surface from another one.
pub(crate) fn distance(from: &Parameters, to: &Parameters) -> f64 {
    let mut points = Vec::new();
    for own in octant(from).as_flattened().as_flattened() {
        for mirror in 0..8 {
            let sign = |axis: u32| if mirror >> axis & 1 == 0 { 1.0 } else { -1.0 };
            points.push(from.center + from.axes * (*own * DVec3::new(sign(0), sign(1), sign(2))));
        }
    }
    let mut linear = Linearization::default();
    linear.set(&Points::new(&points).rows, to);
    let distances = &linear.distances.as_flattened()[..points.len()];
    (distances.iter().map(|distance| distance * distance).sum::<f64>() / points.len() as f64).sqrt()
}

/// Points of the surface where no coordinate along its axes is negative, from its centre. The octant is cut
/// like the corner of a cube: a grid on each of three faces.
fn octant(shape: &Parameters) -> [Grid; 3] {
    let [p, q] = shape.exponents.map(|exponent| 2.0 / exponent);
    let join = |a: f64, b: f64, power: f64| {
        let (small, large) = (a.min(b), a.max(b));
        if small == 0.0 { large } else { large * (1.0 + (small / large).powf(power)).powf(1.0 / power) }
    };
    let along = |index: usize| index as f64 / CELLS as f64;
    std::array::from_fn(|axis| {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let mut direction = DVec3::ONE;
                direction[(axis + 1) % 3] = along(i);
                direction[(axis + 2) % 3] = along(j);
                let norm = join(join(direction.x, direction.y, p), direction.z, q);
                direction / norm * shape.radii
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use superegg_geom::glam::DMat3;
    use superegg_geom::{Exponents, Superquadric};

    fn shape(radii: [f64; 3], exponents: [f64; 2]) -> Parameters {
        Parameters { center: DVec3::ZERO, axes: DMat3::IDENTITY, radii: radii.into(), exponents }
    }

    #[test]
    fn areas_are_nearly_exact() {
        for exponents in [[0.05, 0.05], [1.0, 1.0], [2.0, 2.0], [1.0, 0.1], [0.2, 1.8], [1.5, 0.7]] {
            let radii = [1.0, 2.5, 1.6];
            let [e, n] = exponents;
            let exact =
                Superquadric::new(radii.into(), Exponents::new(e, n).unwrap()).unwrap().surface_area();
            let ratio = inscribed_area(&shape(radii, exponents)) / exact;
            assert!((0.97..1.0001).contains(&ratio), "{exponents:?} {ratio}");
        }
    }

    #[test]
    fn a_square_is_a_diamond_that_is_turned() {
        let square = shape([1.0, 1.0, 2.0], [1e-3, 0.5]);
        let turned = Parameters {
            axes: DMat3::from_rotation_z(std::f64::consts::FRAC_PI_4),
            ..shape([2f64.sqrt(), 2f64.sqrt(), 2.0], [2.0, 0.5])
        };
        assert!((inscribed_area(&square) / inscribed_area(&turned) - 1.0).abs() < 0.02);
        assert!(distance(&square, &turned) < 0.005);
        let larger = shape([1.1, 1.1, 2.1], [1e-3, 0.5]);
        assert!((distance(&square, &larger) - 0.1).abs() < 0.03);
    }
}
