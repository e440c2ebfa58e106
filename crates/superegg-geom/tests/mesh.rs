//! Meshes: closed, outward, and within the tolerance of the exact surface.

use std::collections::HashMap;

use proptest::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Mesh, MeshError, SearchLimits, Superquadric};

fn shape(e: f64, n: f64, radii: [f64; 3]) -> Superquadric {
    Superquadric::new(radii.into(), Exponents::new(e, n).unwrap()).unwrap()
}

/// Each directed edge has its opposite exactly once, after equal positions are merged.
fn assert_closed(mesh: &Mesh) {
    let mut merged = HashMap::new();
    let id: Vec<usize> = mesh
        .positions
        .iter()
        .map(|p| {
            let next = merged.len();
            *merged.entry((p + 0.0).to_array().map(f64::to_bits)).or_insert(next)
        })
        .collect();
    assert_eq!(merged.len(), mesh.positions.len(), "two vertices in one place");
    let mut edges: HashMap<(usize, usize), u32> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| id[i as usize]);
        assert!(a != b && b != c && c != a);
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    assert!(edges.iter().all(|(&(a, b), &count)| count == 1 && edges.get(&(b, a)) == Some(&1)));
    // One sphere: V - E + F = 2.
    assert_eq!(mesh.positions.len() + mesh.triangles.len(), edges.len() / 2 + 2);
}

/// Barycentric weights: corners of edges, middles, and others.
const WEIGHTS: [[f64; 3]; 6] = [
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
    [0.1, 0.2, 0.7],
    [0.75, 0.2, 0.05],
];

/// The largest distance of points of up to `count` triangles from the surface.
fn distance_to_surface(shape: &Superquadric, mesh: &Mesh, count: usize) -> f64 {
    let limits = SearchLimits { relative_tolerance: 0.01, most_cells: 4000 };
    let step = (mesh.triangles.len() / count).max(1);
    let points = mesh.triangles.iter().step_by(step).flat_map(|triangle| {
        let corners = triangle.map(|i| mesh.positions[i as usize]);
        WEIGHTS.map(|[a, b, c]| a * corners[0] + b * corners[1] + c * corners[2])
    });
    let distance = |point| {
        let closest = shape.closest_point_within(point, &limits).unwrap();
        closest.distance.abs() - closest.error
    };
    points.map(distance).fold(0.0, f64::max)
}

/// The distance from a point to a triangle (C. Ericson, Real-Time Collision Detection, 5.1.5, by
/// clamped barycentric search over edges and the plane).
fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_segment = |from: DVec3, to: DVec3| {
        let along = to - from;
        let part = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (point - from - part * along).length()
    };
    let normal = (b - a).cross(c - a);
    let is_above = |from: DVec3, to: DVec3| normal.cross(to - from).dot(point - from) >= 0.0;
    if normal.length() > 0.0 && is_above(a, b) && is_above(b, c) && is_above(c, a) {
        return (point - a).dot(normal).abs() / normal.length();
    }
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}

fn distance_to_mesh(point: DVec3, mesh: &Mesh) -> f64 {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
    mesh.triangles.iter().map(|t| distance_to_triangle(point, corners(t))).fold(f64::INFINITY, f64::min)
}

fn check(shape: &Superquadric, tolerance: f64) -> Mesh {
    let mesh = shape.mesh(tolerance).unwrap();
    assert_closed(&mesh);
    for (&position, &normal) in mesh.positions.iter().zip(&mesh.normals) {
        let unit = position / shape.radii();
        assert!((shape.norm().value(unit) - 1.0).abs() < 1e-11, "{shape:?}: {position}");
        assert!((normal.length() - 1.0).abs() < 1e-12);
        assert!(normal.dot(position) > 0.0, "{shape:?}: {position} {normal}");
    }
    let far = distance_to_surface(shape, &mesh, 150);
    assert!(far <= tolerance, "{shape:?} {tolerance}: {far}");
    let (volume, exact) = (mesh.volume(), shape.volume());
    assert!(volume > 0.0);
    let area: f64 = shape.surface_area();
    assert!(
        (volume - exact).abs() <= 1.1 * tolerance * area + 1e-12 * exact,
        "{shape:?} {tolerance}: {volume} {exact}"
    );
    mesh
}

#[test]
fn every_pair_of_exponents_is_closed_outward_and_near() {
    let exponents = [0.05, 0.3, 1.0, 2.0, 3.0, 8.0];
    for e in exponents {
        for n in exponents {
            for (radii, tolerance) in [([1.0; 3], 1e-2), ([1.0, 2.0, 0.5], 1e-3)] {
                check(&shape(e, n, radii), tolerance);
            }
        }
    }
}

#[test]
fn every_point_of_the_surface_has_the_mesh_near() {
    for (e, n) in [(1.0, 1.0), (0.1, 1.0), (1.0, 0.1), (0.2, 0.2), (2.0, 1.0), (3.0, 0.5), (4.0, 4.0)] {
        let shape = shape(e, n, [1.0, 0.7, 1.5]);
        let tolerance = 0.01;
        let mesh = shape.mesh(tolerance).unwrap();
        for sample in shape.sample_surface(400, 3) {
            let far = distance_to_mesh(sample.point, &mesh);
            assert!(far <= tolerance, "{e} {n}: {far} at {}", sample.point);
        }
    }
}

#[test]
fn plates_needles_and_scales() {
    for radii in [[1.0, 1.0, 1e-4], [1e-4, 1e-4, 1.0], [1.0, 1e-5, 1.0], [1e-6, 1.0, 1e-3]] {
        for (e, n) in [(1.0, 1.0), (0.2, 0.4), (3.0, 3.0)] {
            check(&shape(e, n, radii), 1e-3);
            check(&shape(e, n, radii), 1e-5);
        }
    }
    for scale in [1e-150, 1e150] {
        let mesh = shape(0.5, 1.5, [scale; 3]).mesh(1e-2 * scale).unwrap();
        let unit = shape(0.5, 1.5, [1.0; 3]).mesh(1e-2).unwrap();
        assert_eq!(mesh.triangles, unit.triangles);
        assert!(mesh.normals.iter().zip(&unit.normals).all(|(a, b)| (a - b).length() < 1e-14));
    }
}

#[test]
fn boxes_and_octahedra_have_their_corners() {
    for exponent in [f64::MIN_POSITIVE, 1e-300, 1e-17] {
        let nearly_box = shape(exponent, exponent, [1.0, 2.0, 3.0]);
        let mesh = nearly_box.mesh(1e-6).unwrap();
        assert_closed(&mesh);
        assert!((mesh.volume() / 48.0 - 1.0).abs() < 1e-12, "{}", mesh.volume());
        assert_eq!(mesh.triangles.len(), 32);
    }
    let octahedron = Superquadric::unit(Exponents::new(2.0, 2.0).unwrap()).mesh(1e-9).unwrap();
    assert_eq!((octahedron.positions.len(), octahedron.triangles.len()), (6, 8));
    let cylinder = shape(1.0, 1e-300, [1.0; 3]).mesh(1e-4).unwrap();
    assert_closed(&cylinder);
    assert!(cylinder.triangles.len() < 1500, "{}", cylinder.triangles.len());
}

#[test]
fn hostile_tolerances() {
    let sphere = Superquadric::unit_sphere();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0] {
        assert_eq!(sphere.mesh(tolerance), Err(MeshError::Tolerance));
    }
    for tolerance in [1.0, 10.0, 1e300, f64::MAX] {
        assert_eq!(sphere.mesh(tolerance).unwrap().triangles.len(), 8);
    }
    for tolerance in [f64::MIN_POSITIVE, 1e-300, 1e-17, 1e-12, 1e-9] {
        let Err(MeshError::TooFine { possible, .. }) = sphere.mesh(tolerance) else { panic!("{tolerance}") };
        assert!(possible > 1e-8 && possible < 1e-5, "{possible}");
    }
    let Err(MeshError::TooFine { possible, .. }) = sphere.mesh(1e-9) else { panic!() };
    let mesh = sphere.mesh(possible).unwrap();
    assert!(mesh.triangles.len() <= Mesh::MOST_TRIANGLES && mesh.triangles.len() > Mesh::MOST_TRIANGLES / 8);
}

/// The triangles of the textbook's grid of u, v angles whose mesh has the same bound: fans at the
/// poles, the same angles everywhere.
fn textbook_triangles(shape: &Superquadric, tolerance: f64) -> usize {
    let arc_error = |count: usize, point: &dyn Fn(f64) -> [f64; 2], i: usize, span: f64, start: f64| {
        let at = |k: f64| point(start + span * k / count as f64);
        let ([ax, ay], [bx, by]) = (at(i as f64), at(i as f64 + 1.0));
        let (dx, dy) = (bx - ax, by - ay);
        let length = dx.hypot(dy).max(1e-300);
        (1..16)
            .map(|k| {
                let [x, y] = at(i as f64 + f64::from(k) / 16.0);
                ((x - ax) * dy - (y - ay) * dx).abs() / length
            })
            .fold(0.0, f64::max)
    };
    let radii = shape.radii();
    let section = |u: f64| {
        let p = shape.point_at(u, 0.0);
        [p.x, p.y]
    };
    let widest =
        (0..1000).map(|k| section(f64::from(k) / 1000.0 * std::f64::consts::TAU)).map(|[x, y]| x.hypot(y));
    let widest = widest.fold(0.0, f64::max) / radii.x;
    let profile = |v: f64| {
        let p = shape.point_at(0.0, v);
        [p.x * widest, p.z]
    };
    let (turn, half) = (std::f64::consts::TAU, std::f64::consts::PI);
    let section_error = |u: usize| (0..u).map(|i| arc_error(u, &section, i, turn, 0.0)).fold(0.0, f64::max);
    let mut best = usize::MAX;
    let most = if tolerance < 5e-3 { 160 } else { 60 };
    let section_errors: Vec<(usize, f64)> = (3..most).map(|u| (u, section_error(u))).collect();
    for v in 2..most {
        let bands: Vec<(f64, f64)> = (0..v)
            .map(|j| {
                let rho =
                    |j: usize| shape.point_at(0.0, -0.5 * half + half * j as f64 / v as f64).x / radii.x;
                (rho(j).max(rho(j + 1)), arc_error(v, &profile, j, half, -0.5 * half))
            })
            .collect();
        let fits = |error: f64| bands.iter().all(|(rho, profile)| rho * error + profile <= tolerance);
        if let Some((u, _)) = section_errors.iter().find(|(_, error)| fits(*error)) {
            best = best.min(2 * u * (v - 1));
        }
    }
    best
}

#[test]
#[expect(clippy::print_stdout, reason = "bench/README.md has these numbers")]
fn there_are_about_no_more_triangles_than_in_the_grid_of_angles() {
    for (e, n) in [(1.0, 1.0), (0.3, 0.3), (1.0, 0.2), (0.2, 1.0), (1.5, 0.7), (2.0, 1.0), (3.0, 3.0)] {
        for tolerance in [1e-2, 1e-3] {
            let shape = shape(e, n, [1.0; 3]);
            let ours = shape.mesh(tolerance).unwrap().triangles.len();
            let grid = textbook_triangles(&shape, tolerance);
            println!("{e} {n} {tolerance}: {ours} {grid} {:.2}", ours as f64 / grid as f64);
            // The grid may have any number of angles, a mirrored octant only multiples of four.
            assert!(ours as f64 <= 1.04 * grid as f64, "{e} {n} {tolerance}: {ours} against {grid}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: proptest::test_runner::RngSeed::Fixed(5), ..ProptestConfig::default() })]
    #[test]
    fn any_shape(
        e in prop_oneof![0.05..8.0f64, 1e-6..0.1f64],
        n in prop_oneof![0.05..8.0f64, 1e-6..0.1f64],
        radii in [0.01..10.0f64, 0.01..10.0f64, 0.01..10.0f64],
        part in prop_oneof![Just(1e-4), Just(1e-3), Just(1e-2), Just(0.3)],
    ) {
        let shape = shape(e, n, radii);
        check(&shape, part * shape.radii().max_element());
    }
}
