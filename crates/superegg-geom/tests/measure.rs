//! Volume, moments, area, closest points and samples against high-precision values (`tests/data`,
//! made by `tools/oracle/generate_measures.py`), closed forms, and laws.

use std::f64::consts::PI;
use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_geom::glam::DVec3;
use superegg_geom::{
    ClosestPoint, Exponents, SearchLimits, Superquadric, SurfaceSampler, Transform, TransformStep,
};

fn shape(e: f64, n: f64, radii: [f64; 3]) -> Superquadric {
    Superquadric::new(radii.into(), Exponents::new(e, n).unwrap()).unwrap()
}

/// The relative error.
fn off(value: f64, truth: f64) -> f64 {
    (value / truth - 1.0).abs()
}

fn rows(name: &str) -> Vec<Vec<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.records().map(|row| row.unwrap().iter().map(|word| word.parse().unwrap()).collect()).collect()
}

#[test]
fn volume_moments_and_area_have_the_digits_of_the_oracle() {
    let rows = rows("measures.csv");
    assert!(rows.len() >= 12);
    for row in rows {
        let shape = shape(row[0], row[1], [row[2], row[3], row[4]]);
        assert!(off(shape.volume(), row[5]) < 2e-14, "{row:?}: {}", shape.volume());
        for (moment, truth) in shape.second_moments().to_array().into_iter().zip(&row[6..9]) {
            assert!(off(moment, *truth) < 4e-14, "{row:?}: {moment}");
        }
        let area = shape.surface_area_with_error();
        assert!(area.relative_error < 1e-12, "{row:?}: {area:?}");
        assert!(off(area.value, row[9]) < area.relative_error, "{row:?}: {area:?}");
    }
}

#[test]
fn closed_forms() {
    let sphere = shape(1.0, 1.0, [2.0; 3]);
    assert!(off(sphere.volume(), 32.0 * PI / 3.0) < 1e-14);
    assert!(off(sphere.surface_area(), 16.0 * PI) < 1e-12);
    assert!(off(sphere.inertia().x / sphere.volume(), 0.4 * 4.0) < 1e-14);
    // Every semi-axis counts once in the volume, and the area is that of a box, a cylinder, an octahedron.
    for exponent in [f64::MIN_POSITIVE, 1e-300, 1e-17, 1e-14] {
        let nearly_box = shape(exponent, exponent, [1.0, 2.0, 3.0]);
        assert!(off(nearly_box.volume(), 48.0) < 1e-12, "{exponent}");
        assert!(off(nearly_box.surface_area(), 88.0) < 2e-12, "{exponent}");
        assert!(off(nearly_box.inertia().z / nearly_box.volume(), (4.0 + 16.0) / 12.0) < 1e-12);
        let cylinder = shape(1.0, exponent, [2.0, 2.0, 3.0]);
        assert!(off(cylinder.volume(), PI * 4.0 * 6.0) < 1e-12);
        assert!(off(cylinder.surface_area(), 2.0 * PI * 4.0 + 2.0 * PI * 2.0 * 6.0) < 2e-12);
    }
    let octahedron = shape(2.0, 2.0, [1.0; 3]);
    assert!(off(octahedron.volume(), 4.0 / 3.0) < 1e-14);
    assert!(off(octahedron.surface_area(), 4.0 * 3f64.sqrt()) < 1e-12);
    // A bicone, and a disc of no thickness.
    assert!(off(shape(1.0, 2.0, [1.0, 1.0, 2.0]).surface_area(), 2.0 * PI * 5f64.sqrt()) < 1e-12);
    assert!(off(shape(1.0, 1.0, [1.0, 1.0, 1e-12]).surface_area(), 2.0 * PI) < 1e-12);
    for huge in [1e3, 1e5, 1e300] {
        assert!(shape(huge, huge, [1.0; 3]).volume() >= 0.0, "{huge}");
    }
}

#[test]
fn closest_points_have_the_digits_of_the_oracle() {
    let rows = rows("closest.csv");
    assert!(rows.len() >= 40);
    for row in rows {
        let shape = shape(row[0], row[1], [row[2], row[3], row[4]]);
        let query = DVec3::from_slice(&row[5..8]);
        let closest = shape.closest_point(query).unwrap();
        let size = shape.radii().max_element().max(query.abs().max_element());
        let (distance, truth) = (closest.distance.abs(), row[8]);
        assert!((distance - truth).abs() < 1e-9 * truth + 1e-14 * size, "{row:?}: {closest:?}");
        assert!(distance - closest.error <= truth * (1.0 + 1e-15), "{row:?}: {closest:?}");
        assert!(closest.error < 1e-9 * truth + 1e-14 * size, "{row:?}: {closest:?}");
        assert!(
            (closest.point - DVec3::from_slice(&row[9..12])).length() < 1e-5 * size,
            "{row:?}: {closest:?}"
        );
    }
}

fn is_on_surface(shape: &Superquadric, point: DVec3) -> bool {
    (shape.norm().value(point / shape.radii()) - 1.0).abs() < 1e-9
}

/// No sample of the surface is closer than the proven bound.
fn holds_no_sample(shape: &Superquadric, query: DVec3, closest: &ClosestPoint, samples: &[DVec3]) {
    let radius = closest.distance.abs() - closest.error;
    let size = shape.radii().max_element().max(query.abs().max_element());
    for &sample in samples {
        let distance = (sample - query).length();
        assert!(distance >= radius - 1e-14 * size, "{shape:?} {query} {closest:?}: {sample} is closer");
    }
}

/// Points of the whole surface: by area, and by parameter, which reaches into spikes and edges.
fn dense_samples(shape: &Superquadric) -> Vec<DVec3> {
    let by_area = SurfaceSampler::new(shape, 5).take(4000).map(|sample| sample.point);
    let by_angle = (0..=120).flat_map(|i| {
        (0..=60)
            .map(move |j| shape.point_at(PI / 60.0 * f64::from(i) - PI, PI / 60.0 * f64::from(j) - PI / 2.0))
    });
    by_area.chain(by_angle).collect()
}

const HOSTILE: [f64; 7] = [1e-4, 0.1, 1.0, 1.7, 2.0, 2.5, 8.0];

#[test]
fn hostile_exponents_and_aspects_have_small_proven_errors() {
    let mut queries = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.0, 0.0, 1.5)];
    queries.extend([DVec3::new(0.3, -0.2, 0.1), DVec3::new(-1.2, 0.7, -0.9), DVec3::new(1e5, 1.0, 0.0)]);
    for e in HOSTILE {
        for n in HOSTILE {
            for radii in [[1.0; 3], [1.0, 2.0, 3.0], [1.0, 1e-6, 1.0], [1e3, 1.0, 1e-3]] {
                let shape = shape(e, n, radii);
                let samples = dense_samples(&shape);
                for &query in &queries {
                    let query = query * shape.radii();
                    let closest = shape.closest_point(query).unwrap();
                    let size = shape.radii().max_element().max(query.abs().max_element());
                    // From the centre a whole circle of the surface may be closest.
                    let relative = if query == DVec3::ZERO { 1e-6 } else { 1e-8 };
                    let bound = relative * closest.distance.abs() + 1e-13 * size;
                    assert!(closest.error <= bound, "{e} {n} {radii:?} {query}: {closest:?}");
                    assert!(is_on_surface(&shape, closest.point), "{e} {n} {radii:?} {query}: {closest:?}");
                    holds_no_sample(&shape, query, &closest, &samples);
                }
            }
        }
    }
}

#[test]
fn an_error_that_is_not_small_is_reported() {
    // From the centre of what is nearly a sphere the whole surface is nearly closest.
    let shape = shape(1.0 + 1e-7, 1.0 - 1e-7, [1.0; 3]);
    let limits = SearchLimits { most_cells: 2000, ..SearchLimits::default() };
    let closest = shape.closest_point_within(DVec3::ZERO, &limits).unwrap();
    assert!(closest.error > 1e-9 && closest.error < 1e-2, "{closest:?}");
    holds_no_sample(&shape, DVec3::ZERO, &closest, &dense_samples(&shape));
    let none = SearchLimits { most_cells: 0, ..limits };
    let closest = shape.closest_point_within(DVec3::ZERO, &none).unwrap();
    assert!(closest.distance.abs() - closest.error <= 1e-14);
}

#[test]
fn a_query_that_is_not_finite_has_no_closest_point() {
    for x in [f64::NAN, f64::INFINITY] {
        assert_eq!(shape(0.5, 3.0, [1.0; 3]).closest_point(DVec3::new(0.0, x, 0.0)), None);
    }
}

fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![prop::sample::select(HOSTILE.to_vec()), 0.05..4.0f64]
}

fn any_shape() -> impl Strategy<Value = Superquadric> {
    (exponent(), exponent(), prop::array::uniform3(0.1..10.0f64)).prop_map(|(e, n, radii)| shape(e, n, radii))
}

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        rng_seed: RngSeed::Fixed(18),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// The signed distance grows by no more than the step, and its sign is that of `io`.
    #[test]
    fn the_distance_is_1_lipschitz(shape in any_shape(), from in vector(12.0), step in vector(3.0)) {
        let to = from + step;
        let (a, b) = (shape.closest_point(from).unwrap(), shape.closest_point(to).unwrap());
        prop_assert!((a.distance - b.distance).abs() <= step.length() + a.error + b.error, "{a:?} {b:?}");
        prop_assert_eq!(a.distance < 0.0, shape.inside_outside(from) < 0.0);
        prop_assert!((a.distance.abs() - (a.point - from).length()).abs() < 1e-13 * 20.0);
        prop_assert!(is_on_surface(&shape, a.point));
    }

    /// A sign flips the point along, and a power of two scales it, to the bit.
    #[test]
    fn closest_points_are_symmetric_and_scale(
        shape in any_shape(), query in vector(12.0), flip in prop::array::uniform3(any::<bool>()), power in -200..200i32,
    ) {
        let sign = DVec3::from_array(flip.map(|f| if f { -1.0 } else { 1.0 }));
        let size = 2f64.powi(power);
        let scaled = Superquadric::new(shape.radii() * size, shape.exponents()).unwrap();
        let (a, b) = (shape.closest_point(query).unwrap(), scaled.closest_point(query * sign * size).unwrap());
        prop_assert_eq!((a.point * sign * size, a.distance * size, a.error * size), (b.point, b.distance, b.error));
    }

    /// Size and the order of x and y count as they should; the surface is no smaller than the sphere's of equal volume.
    #[test]
    fn measures_scale_and_swap(shape in any_shape(), power in -60..60i32) {
        let size = 2f64.powi(power);
        let scaled = Superquadric::new(shape.radii() * size, shape.exponents()).unwrap();
        prop_assert!(off(scaled.volume(), shape.volume() * size.powi(3)) < 1e-15);
        prop_assert!(off(scaled.surface_area(), shape.surface_area() * size.powi(2)) < 1e-15);
        prop_assert!(off(scaled.inertia().y, shape.inertia().y * size.powi(5)) < 1e-15);
        let swapped = Superquadric::new(DVec3::new(shape.radii().y, shape.radii().x, shape.radii().z), shape.exponents()).unwrap();
        prop_assert!(off(swapped.surface_area(), shape.surface_area()) < 1e-12);
        let (moments, others) = (shape.second_moments(), swapped.second_moments());
        prop_assert!(off(moments.x, others.y) < 1e-14 && off(moments.z, others.z) < 1e-14);
        let sphere = (36.0 * PI * shape.volume().powi(2)).cbrt();
        prop_assert!(shape.surface_area() > sphere * (1.0 - 1e-12));
    }

    /// The normal at (u, v) is at right angles to the surface's tangents, and that of the point.
    #[test]
    fn the_normal_at_u_v(e in 0.3..6.0f64, n in 0.3..6.0f64, u in 0.2..1.3f64, v in 0.2..1.3f64, quadrant in 0..4, flip in any::<bool>()) {
        let shape = shape(e, n, [1.0, 2.0, 0.3]);
        let (u, v) = (u + PI / 2.0 * f64::from(quadrant) - PI, if flip { -v } else { v });
        prop_assume!((u / (PI / 2.0)).fract().abs() > 0.1 && (u / (PI / 2.0)).fract().abs() < 0.9);
        let normal = shape.normal_at(u, v);
        prop_assert!((normal - shape.normal(shape.point_at(u, v))).length() < 1e-9, "{normal}");
        let step = 1e-6;
        for (du, dv) in [(step, 0.0), (0.0, step)] {
            let tangent = shape.point_at(u + du, v + dv) - shape.point_at(u - du, v - dv);
            prop_assert!(tangent.normalize().dot(normal).abs() < 1e-6);
        }
    }

    /// Longitude and latitude lead back, and a factor changes neither.
    #[test]
    fn uv_is_the_inverse_of_the_point(e in 0.3..8.0f64, n in 0.3..8.0f64, u in -3.1..3.1f64, v in -1.5..1.5f64, factor in 0.1..9.0f64) {
        let shape = shape(e, n, [1.0, 2.0, 0.3]);
        let (u_back, v_back) = shape.uv_at(shape.point_at(u, v) * factor);
        prop_assert!((u - u_back).abs() < 1e-13 && (v - v_back).abs() < 1e-13, "{u_back} {v_back}");
    }
}

#[test]
fn the_box_under_a_map_holds_the_samples_and_is_touched() {
    let steps = [
        TransformStep::Scale(DVec3::new(1.0, -2.0, 0.5)),
        TransformStep::Rotate { axis: DVec3::new(1.0, 2.0, 3.0), angle_deg: 77.0 },
        TransformStep::Translate(DVec3::new(10.0, 20.0, -5.0)),
    ];
    let transform = Transform::from_steps(&steps).unwrap();
    for e in HOSTILE {
        for n in HOSTILE {
            let shape = shape(e, n, [1.0, 2.0, 3.0]);
            let bounds = shape.bounds_under(&transform);
            let images: Vec<DVec3> =
                dense_samples(&shape).iter().map(|&p| transform.forward().transform_point3(p)).collect();
            assert!(images.iter().all(|&p| bounds.rounded_outward().contains(p)), "{e} {n}");
            // Each face is touched: by the image of the point with its normal, nearly by a sample.
            let reached = images.iter().fold(DVec3::NEG_INFINITY, |reached, p| reached.max(*p));
            assert!(((bounds.max - reached) / bounds.half_extent()).max_element() < 0.05, "{e} {n}");
        }
    }
}

/// A superellipse arc, written independently of the library: X and Y at t = 2 ln tan(angle).
fn arc(w: f64, t: f64) -> [f64; 2] {
    [t, -t].map(|t| (-0.5 * w * (t.max(0.0) + (-t.abs()).exp().ln_1p())).exp())
}

/// Counts of samples against the areas of a fine mesh, in 64 cells and 8 octants.
#[test]
fn samples_are_spread_by_area() {
    const BLOCKS: usize = 8;
    const FINE: usize = 40;
    for (e, n, radii) in [
        (1.0, 1.0, [1.0; 3]),
        (1e-4, 1e-4, [1.0, 2.0, 3.0]),
        (8.0, 8.0, [1.0; 3]),
        (0.1, 8.0, [1.0, 1.0, 2.0]),
        (2.5, 0.7, [3.0, 1.0, 0.2]),
        (0.5, 0.5, [1.0, 1e-3, 1.0]),
    ] {
        let shape = shape(e, n, radii);
        let end = |w: f64| (40.0 / (0.5 * w).min(1.0)).asinh();
        let nodes = BLOCKS * FINE;
        let parameter = |i: usize, w: f64| (end(w) * (2.0 * i as f64 / nodes as f64 - 1.0)).sinh();
        let point = |i: usize, j: usize| {
            let ([x, y], [rho, zeta]) = (arc(e, parameter(i, e)), arc(n, parameter(j, n)));
            shape.radii() * DVec3::new(rho * x, rho * y, zeta)
        };
        let mut areas = [0.0; BLOCKS * BLOCKS];
        for i in 0..nodes {
            for j in 0..nodes {
                let [p, q, r, s] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                let area = 0.5 * ((q - p).cross(r - p).length() + (r - p).cross(s - p).length());
                areas[i / FINE * BLOCKS + j / FINE] += area;
            }
        }
        let total: f64 = areas.iter().sum();
        assert!(off(8.0 * total, shape.surface_area()) < 2e-3, "{e} {n}: {total}");

        let count = 40_000;
        let mut counts = [0u32; BLOCKS * BLOCKS];
        let mut octants = [0u32; 8];
        for sample in SurfaceSampler::new(&shape, 2026).take(count) {
            assert!(is_on_surface(&shape, sample.point) && (sample.normal.length() - 1.0).abs() < 1e-9);
            let unit = (sample.point / shape.radii()).abs();
            let rho = {
                let p = 2.0 / e;
                let (large, small) = (unit.x.max(unit.y), unit.x.min(unit.y));
                large * ((small / large).powf(p).ln_1p() / p).exp()
            };
            let block = |t: f64, w: f64| {
                ((t.asinh() / end(w) + 1.0) * 0.5 * BLOCKS as f64).clamp(0.0, BLOCKS as f64 - 1.0) as usize
            };
            let i = block(2.0 / e * (unit.y / unit.x).ln(), e);
            let j = block(2.0 / n * (unit.z / rho).ln(), n);
            counts[i * BLOCKS + j] += 1;
            let bit = |x: f64, bit: usize| usize::from(x < 0.0) << bit;
            octants[bit(sample.point.x, 0) | bit(sample.point.y, 1) | bit(sample.point.z, 2)] += 1;
        }
        let (mut chi_square, mut cells) = (0.0, 0);
        let (mut rest, mut rest_expected) = (0.0, 0.0);
        for (&found, &area) in counts.iter().zip(&areas) {
            let expected = area / total * count as f64;
            if expected < 25.0 {
                (rest, rest_expected) = (rest + f64::from(found), rest_expected + expected);
            } else {
                chi_square += (f64::from(found) - expected).powi(2) / expected;
                cells += 1;
            }
        }
        assert!(cells >= 6, "{e} {n}: {cells}");
        let limit = f64::from(cells) + 4.5 * (2.0 * f64::from(cells)).sqrt();
        assert!(chi_square < limit, "{e} {n} {radii:?}: {chi_square} in {cells} cells");
        assert!(
            (rest - rest_expected).abs() < 6.0 + 5.0 * rest_expected.sqrt(),
            "{e} {n}: {rest} {rest_expected}"
        );
        let eighth = count as f64 / 8.0;
        let octant_chi_square: f64 = octants.iter().map(|&c| (f64::from(c) - eighth).powi(2) / eighth).sum();
        assert!(octant_chi_square < 30.0, "{e} {n}: {octants:?}");
    }
}
