//! Interval arithmetic against the solvers: a check, ray by ray, that no crossing was skipped. Each interval of t before the answer (or of
//! the whole ray, for a miss) is shown to lie on one side of the surface, with every operation rounded outwards.

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Ray, RayStart, Superquadric};

/// All numbers from `.0` to `.1`.
#[derive(Clone, Copy, Debug)]
struct Interval(f64, f64);

impl Interval {
    /// Outwards by more than the error of any library function used here.
    fn rounded(low: f64, high: f64) -> Self {
        let slack = |x: f64| 4.0 * f64::EPSILON * x.abs() + f64::MIN_POSITIVE;
        Self(low - slack(low), high + slack(high))
    }

    /// |o + t d|.
    fn magnitude(t: Self, o: f64, d: f64) -> Self {
        let (a, b) = (o + t.0 * d, o + t.1 * d);
        let error = 4.0 * f64::EPSILON * (o.abs() + t.1.abs() * d.abs());
        let (low, high) = (a.min(b) - error, a.max(b) + error);
        if low > 0.0 {
            Self(low, high)
        } else if high < 0.0 {
            Self(-high, -low)
        } else {
            Self(0.0, high.max(-low))
        }
    }

    /// Numbers >= 0 to a power > 0.
    fn power(self, p: f64) -> Self {
        let raised = Self::rounded(self.0.max(0.0).powf(p), self.1.powf(p));
        // The rounding of large powers is that of the logarithm, times the power.
        let slack = 4.0 * f64::EPSILON * (1.0 + p * self.1.ln().abs().min(745.0 / p));
        Self((raised.0 * (1.0 - slack)).max(0.0), raised.1 * (1.0 + slack))
    }

    fn plus(self, other: Self) -> Self {
        Self::rounded(self.0 + other.0, self.1 + other.1)
    }
}

/// Which side of the surface all points of an interval of t are on: whether inside, or `None` where they may be on both.
fn side(exponents: Exponents, ray: &Ray, t: Interval) -> Option<bool> {
    let (p, q) = (2.0 / exponents.e(), 2.0 / exponents.n());
    let [x, y, z] = [0, 1, 2].map(|i| Interval::magnitude(t, ray.origin[i], ray.direction[i]));
    if x.0.max(y.0).max(z.0) > 1.0 {
        return Some(false);
    }
    // (|x|^p + |y|^p)^(q/p) + |z|^q, which is N^q.
    let sum = x.power(p).plus(y.power(p)).power(q / p).plus(z.power(q));
    if sum.0 > 1.0 {
        Some(false)
    } else if sum.1 < 1.0 {
        Some(true)
    } else {
        None
    }
}

/// Whether all t of the interval are shown to be on the given side, but for parts too narrow to matter.
fn is_on_side(exponents: Exponents, ray: &Ray, whole: Interval, inside: bool) -> Result<(), Interval> {
    let mut pending = vec![whole];
    let mut budget = 200_000;
    while let Some(t) = pending.pop() {
        budget -= 1;
        let middle = 0.5 * (t.0 + t.1);
        match side(exponents, ray, t) {
            Some(found) if found == inside => {}
            Some(_) => return Err(t),
            // Nothing so narrow is shown; a crossing that is skipped there and back is below the rounding of t.
            None if t.1 - t.0 < 1e-11 || budget < 0 => {}
            None => pending.extend([Interval(middle, t.1), Interval(t.0, middle)]),
        }
    }
    Ok(())
}

/// Every exponent pair with every kind of ray, the hostile ones too: along axes, in planes, through the centre, along edges, grazing.
fn cases() -> impl Iterator<Item = (Exponents, Ray)> {
    let exponents = [0.01, 0.1, 0.5, 1.0, 2.0, 2.5, 4.0, 6.0, 8.0];
    let mut state = 7u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    };
    let mut rays = Vec::new();
    for i in 0..40 {
        let mut vector = |size: f64| DVec3::new(random(), random(), random()) * size;
        let (origin, target) = (vector(3.0), vector(1.0));
        let target = match i % 5 {
            0 => target,
            1 => DVec3::new(0.0, target.y, target.z),
            2 => target * DVec3::new(1e-3, 1e-6, 1.0),
            3 => DVec3::ZERO,
            _ => DVec3::new(1.0, target.y * 0.01, 0.0),
        };
        let origin = if i % 7 == 6 { DVec3::new(origin.x, 0.0, origin.z) } else { origin };
        rays.push(Ray::new(origin, target - origin));
    }
    for axis in DVec3::AXES {
        rays.push(Ray::new(-3.0 * axis, axis));
        rays.push(Ray::new(-3.0 * axis + 1e-3, axis));
        rays.push(Ray::new(0.4 * axis, axis));
    }
    exponents.into_iter().flat_map(move |e| {
        let rays = rays.clone();
        exponents
            .into_iter()
            .flat_map(move |n| rays.clone().into_iter().map(move |ray| (Exponents::new(e, n).unwrap(), ray)))
    })
}

#[test]
fn no_crossing_is_skipped() {
    for (exponents, ray) in cases() {
        let shape = Superquadric::new(DVec3::ONE, exponents).unwrap();
        let inside = shape.norm().value(ray.origin) < 1.0;
        for hit in [shape.intersect(&ray, RayStart::Free), shape.intersect_certified(&ray, RayStart::Free)] {
            let end = hit.map_or(10.0, |hit| hit.t - 1e-9);
            if end > 0.0 {
                let shown = is_on_side(exponents, &ray, Interval(0.0, end), inside);
                assert!(shown.is_ok(), "{exponents:?} {ray:?} {hit:?}: the other side at {shown:?}");
            }
        }
    }
}

/// The check can fail: it finds the crossing that a wrong miss would skip.
#[test]
fn the_check_sees_a_crossing() {
    let ray = Ray::new(DVec3::new(0.1, 0.2, 5.0), DVec3::NEG_Z);
    let exponents = Exponents::new(3.0, 2.5).unwrap();
    assert!(is_on_side(exponents, &ray, Interval(0.0, 10.0), false).is_err());
}
