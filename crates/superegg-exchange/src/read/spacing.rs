//! The radius of the spheres that stand for the points of a cloud.

use superegg_geom::glam::DVec3;

/// The most points whose nearest neighbour is searched.
const MOST_QUERIES: usize = 512;
/// The most points that a search visits on each side.
const MOST_VISITED: usize = 20_000;

/// The radius of spheres for points: half of the median distance from a point to its nearest
/// neighbour, coincident points aside. A cloud without two different points has radius 1. The
/// points are finite.
///
/// The points are sorted along the longest edge of their box; a search walks from the point in both
/// directions until the distance along that axis exceeds the nearest one.
pub(super) fn point_radius(points: &[DVec3]) -> f64 {
    let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &point| {
        (low.min(point), high.max(point))
    });
    let axis = (high - low).max_position();
    let mut sorted: Vec<u32> = (0..u32::try_from(points.len()).unwrap_or(u32::MAX)).collect();
    sorted.sort_unstable_by(|&a, &b| points[a as usize][axis].total_cmp(&points[b as usize][axis]));
    let sorted: Vec<DVec3> = sorted.into_iter().map(|index| points[index as usize]).collect();
    let step = sorted.len().div_ceil(MOST_QUERIES).max(1);
    let mut distances: Vec<f64> = (0..sorted.len())
        .step_by(step)
        .map(|query| nearest_distance(&sorted, query, axis))
        .filter(|distance| distance.is_finite())
        .collect();
    if distances.is_empty() {
        return 1.0;
    }
    let middle = distances.len() / 2;
    *distances.select_nth_unstable_by(middle, f64::total_cmp).1 / 2.0
}

/// The distance from a point to the nearest other one that does not coincide with it; infinite if
/// there is none.
fn nearest_distance(sorted: &[DVec3], query: usize, axis: usize) -> f64 {
    let point = sorted[query];
    let nearest = |nearest: f64, others: &mut dyn Iterator<Item = &DVec3>| {
        let mut nearest = nearest;
        for other in others.take(MOST_VISITED) {
            if (other[axis] - point[axis]).abs() > nearest {
                break;
            }
            let distance = other.distance(point);
            if distance > 0.0 {
                nearest = nearest.min(distance);
            }
        }
        nearest
    };
    let after = nearest(f64::INFINITY, &mut sorted[query + 1..].iter());
    nearest(after, &mut sorted[..query].iter().rev())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_has_half_its_spacing_along_any_axis() {
        for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let mut points = Vec::new();
            for index in 0..4000 {
                let cell = [index % 40, index / 40 % 10, index / 400].map(|cell| f64::from(cell) * 0.25);
                let mut point = DVec3::ZERO;
                axes.iter().zip(cell).for_each(|(&axis, cell)| point[axis] = cell);
                points.push(point);
            }
            assert_eq!(point_radius(&points), 0.125);
        }
    }

    #[test]
    fn coincident_single_and_no_points_have_a_radius() {
        assert_eq!(point_radius(&[]), 1.0);
        assert_eq!(point_radius(&[DVec3::ONE]), 1.0);
        assert_eq!(point_radius(&[DVec3::ONE; 3]), 1.0);
        assert_eq!(point_radius(&[DVec3::ONE, DVec3::ONE, DVec3::ZERO]), 3_f64.sqrt() / 2.0);
    }
}
