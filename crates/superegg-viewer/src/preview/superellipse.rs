//! A superellipse as a polygon within a tolerance: the curves around a superquadric and from its
//! equator to a pole.

use std::f64::consts::FRAC_PI_4;

use superegg_geom::glam::DVec2;

/// Most segments of an eighth of the curve.
const MOST_SEGMENTS: usize = 64;
/// Smallest exponent: below it the curve is a square.
const LEAST_EXPONENT: f64 = 1e-4;
/// Least cosine between a normal and its interpolation from the ends of a segment.
const LEAST_COS: f64 = 0.995;
/// Shorter segments than this many tolerances may have normals that differ more.
const SHORT: f64 = 5.0;

/// The curve |x|^(2/w) + |y|^(2/w) = 1.
struct Superellipse {
    /// 2 / w.
    power: f64,
}

impl Superellipse {
    /// The point at a polar angle in [0, pi/4].
    fn point(&self, angle: f64) -> DVec2 {
        let direction = DVec2::from_angle(angle);
        // x is the larger coordinate: nothing overflows.
        let ratio = direction.y / direction.x;
        let x = (1.0 + ratio.powf(self.power)).powf(-1.0 / self.power);
        DVec2::new(x, x * ratio)
    }

    /// The unit normal at a point with 0 <= y <= x.
    fn normal(&self, point: DVec2) -> DVec2 {
        let DVec2 { x, y } = point;
        let normal = if self.power >= 1.0 {
            DVec2::new(1.0, (y / x).powf(self.power - 1.0))
        } else {
            DVec2::new((y / x).powf(1.0 - self.power), 1.0)
        };
        normal.normalize()
    }

    /// Whether the curve between two polar angles departs from its chord by more than `tolerance`,
    /// or its normals from those of a chord that is not short.
    fn departs(&self, from: f64, to: f64, tolerance: f64) -> bool {
        let (a, b) = (self.point(from), self.point(to));
        let chord = b - a;
        let length = chord.length();
        if length <= tolerance {
            return false;
        }
        let mean = (self.normal(a) + self.normal(b)).normalize_or_zero();
        [0.25, 0.5, 0.75].into_iter().any(|part| {
            let point = self.point(from + part * (to - from));
            let is_far = chord.perp_dot(point - a).abs() > tolerance * length;
            is_far || (part == 0.5 && length > SHORT * tolerance && self.normal(point).dot(mean) < LEAST_COS)
        })
    }
}

/// The points of the first quarter, from (1, 0) to (0, 1), of the curve with the exponent w. They
/// are within `tolerance` of it.
pub(super) fn quarter(w: f64, tolerance: f64) -> Vec<DVec2> {
    let curve = Superellipse { power: 2.0 / w.max(LEAST_EXPONENT) };
    let mut angles = vec![0.0, FRAC_PI_4];
    let mut i = 0;
    // The segments are split from the left one on; near a spike that is where most are needed.
    while i + 1 < angles.len() {
        let (from, to) = (angles[i], angles[i + 1]);
        let middle = 0.5 * (from + to);
        let can_split = angles.len() <= MOST_SEGMENTS && middle > from && middle < to;
        if can_split && curve.departs(from, to, tolerance) {
            angles.insert(i + 1, middle);
        } else {
            i += 1;
        }
    }
    let mut points: Vec<DVec2> = angles.iter().map(|angle| curve.point(*angle)).collect();
    if points.len() == 2 && !curve_bends(&curve, tolerance) {
        // A chord over the whole quarter suffices.
        return vec![DVec2::X, DVec2::Y];
    }
    let mirrored: Vec<DVec2> = points.iter().rev().skip(1).map(|point| point.yx()).collect();
    points.extend(mirrored);
    points
}

/// Whether the quarter departs from its own chord.
fn curve_bends(curve: &Superellipse, tolerance: f64) -> bool {
    let corner = curve.point(FRAC_PI_4);
    (corner.x + corner.y - 1.0).abs() * std::f64::consts::FRAC_1_SQRT_2 > tolerance
}

trait Swapped {
    fn yx(self) -> Self;
}

impl Swapped for DVec2 {
    fn yx(self) -> Self {
        Self::new(self.y, self.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distance of the curve from the polygon at many points.
    fn error(w: f64, points: &[DVec2]) -> f64 {
        let curve = Superellipse { power: 2.0 / w };
        let distance = |point: DVec2| {
            points
                .windows(2)
                .map(|two| {
                    let along = two[1] - two[0];
                    let t = ((point - two[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                    (point - two[0] - t * along).length()
                })
                .fold(f64::INFINITY, f64::min)
        };
        (0..=1000).map(|i| distance(curve.point(f64::from(i) / 1000.0 * FRAC_PI_4))).fold(0.0, f64::max)
    }

    #[test]
    fn the_polygon_is_within_the_tolerance_for_any_exponent() {
        for w in [0.0001, 0.05, 0.1, 0.3, 0.5, 0.9, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0] {
            for tolerance in [0.3, 0.1, 0.01, 0.001] {
                let points = quarter(w, tolerance);
                assert!(points[0] == DVec2::X && (points[points.len() - 1] - DVec2::Y).length() < 1e-12);
                let error = error(w, &points);
                assert!(error <= 1.5 * tolerance, "{w} {tolerance}: {error} with {} points", points.len());
            }
        }
        assert_eq!(quarter(1.0, 0.3).len(), 2);
        assert!((20..40).contains(&quarter(1.0, 0.0005).len()), "{}", quarter(1.0, 0.0005).len());
        assert!(quarter(16.0, 1e-9).len() <= 2 * MOST_SEGMENTS + 1);
    }

    #[test]
    fn the_faces_of_a_cube_are_flat_to_their_rims() {
        let points = quarter(0.0001, 0.01);
        let curve = Superellipse { power: 2.0 / 0.0001 };
        let flat = points.iter().filter(|p| p.y <= p.x && curve.normal(**p).y < 1e-6).map(|p| p.y);
        assert!(flat.fold(0.0, f64::max) > 0.9);
    }
}
