//! Points spread evenly over triangles.

use superegg_geom::SplitMix;
use superegg_geom::glam::DVec3;

/// The corners of a triangle.
pub(crate) type Triangle = [DVec3; 3];

/// `count` independent points, each triangle with a share in proportion to its area; none if no
/// triangle has an area.
pub(crate) fn sample(triangles: &[Triangle], count: usize, seed: u64) -> Vec<DVec3> {
    let mut sum = 0.0;
    let cumulative: Vec<f64> = triangles
        .iter()
        .map(|[a, b, c]| {
            sum += (*b - *a).cross(*c - *a).length();
            sum
        })
        .collect();
    if !(sum > 0.0 && sum.is_finite()) {
        return Vec::new();
    }
    let mut random = SplitMix::new(seed);
    let mut point = || {
        let target = random.unit() * sum;
        let index = cumulative.partition_point(|&below| below <= target).min(triangles.len() - 1);
        let [a, b, c] = triangles[index];
        // The square root makes the density even.
        let (root, part) = (random.unit().sqrt(), random.unit());
        a * (1.0 - root) + b * (root * (1.0 - part)) + c * (root * part)
    };
    (0..count).map(|_| point()).collect()
}
