//! The solvers against ground truth made with 40-digit arithmetic: our own rays (`tests/data/rays.csv`, made by
//! `tools/oracle/generate_rays.py`), and those that stand beside the project where its team works.

// A test that is skipped says so.
#![allow(clippy::print_stderr)]

use std::path::{Path, PathBuf};

use superegg_geom::glam::DVec3;
#[cfg(feature = "simd")]
use superegg_geom::kernels;
use superegg_geom::{Exponents, Ray, RayStart, ShapeHit, Superquadric, textbook};

struct TruthRow {
    shape: Superquadric,
    ray: Ray,
    start_inside: bool,
    hit: Option<(f64, DVec3)>,
    margin: f64,
}

fn read(path: &Path) -> Vec<TruthRow> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader
        .records()
        .map(|record| {
            let record = record.unwrap();
            let number = |i: usize| record[i].parse::<f64>().unwrap_or(f64::NAN);
            let vector = |i: usize| DVec3::new(number(i), number(i + 1), number(i + 2));
            TruthRow {
                shape: Superquadric::new(DVec3::ONE, Exponents::new(number(0), number(1)).unwrap()).unwrap(),
                ray: Ray::new(vector(2), vector(5)),
                start_inside: &record[8] == "1",
                hit: (&record[9] == "1").then(|| (number(10), vector(11))),
                margin: number(14),
            }
        })
        .collect()
}

/// The demands on an answer: no wrong hit or miss, t to 1e-6 (1 + t), normals to 1e-4 where the surface is smooth.
fn check(row: &TruthRow, answer: Option<ShapeHit>) -> Result<(), String> {
    let (expected, actual) = match (&row.hit, answer) {
        (None, None) => return Ok(()),
        (Some(expected), Some(actual)) => (expected, actual),
        _ if row.margin <= 1e-6 => return Ok(()),
        (None, Some(actual)) => return Err(format!("hit at t = {} where there is none", actual.t)),
        (Some((t, _)), None) => return Err(format!("missed the hit at t = {t}")),
    };
    let (t, normal) = *expected;
    if (actual.t - t).abs() > 1e-6 * (1.0 + t) && row.margin > 1e-6 {
        return Err(format!("t = {} for {t}", actual.t));
    }
    if actual.leaving != row.start_inside {
        return Err("wrong side".to_string());
    }
    let (e, n) = (row.shape.exponents().e(), row.shape.exponents().n());
    let is_smooth = (0.02..=2.0).contains(&e) && (0.02..=2.0).contains(&n);
    let away_from_planes = row.ray.point_at(t).abs().min_element() > 1e-3;
    let angle = row.shape.normal(actual.point).cross(normal).length();
    if is_smooth && away_from_planes && row.margin > 1e-6 && angle > 1e-4 {
        return Err(format!("normal off by {angle}"));
    }
    Ok(())
}

type Solver = fn(&Superquadric, &Ray) -> Option<ShapeHit>;

fn wrong_answers(rows: &[TruthRow], solver: Solver) -> Vec<String> {
    rows.iter()
        .filter_map(|row| {
            let wrong = check(row, solver(&row.shape, &row.ray)).err()?;
            Some(format!("{:?} {:?} margin {}: {wrong}", row.shape.exponents(), row.ray, row.margin))
        })
        .collect()
}

fn all_right(path: &Path) {
    let rows = read(path);
    assert!(rows.len() >= 1000, "{} rows in {}", rows.len(), path.display());
    for (name, solver) in [
        ("intersect", (|shape, ray| shape.intersect(ray, RayStart::Free)) as Solver),
        ("intersect_certified", |shape, ray| shape.intersect_certified(ray, RayStart::Free)),
    ] {
        let wrong = wrong_answers(&rows, solver);
        assert!(wrong.is_empty(), "{name}: {} of {} wrong:\n{}", wrong.len(), rows.len(), wrong.join("\n"));
    }
}

fn beside_the_project(path: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(path);
    if !path.exists() {
        eprintln!("skipped: {} is not on this machine", path.display());
        return None;
    }
    Some(path)
}

fn own_rays() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/rays.csv")
}

#[test]
fn every_ray_of_our_own_ground_truth() {
    all_right(&own_rays());
}

#[test]
fn every_ray_of_the_ground_truth_beside_the_project() {
    if let Some(path) = beside_the_project("oracle/rays.csv") {
        all_right(&path);
    }
}

/// A larger set, made on demand: `SUPEREGG_ORACLE=rays.csv cargo test --release -p superegg-geom --test oracle`.
#[test]
fn every_ray_of_a_named_ground_truth() {
    match std::env::var_os("SUPEREGG_ORACLE") {
        Some(path) => all_right(Path::new(&path)),
        None => eprintln!("skipped: SUPEREGG_ORACLE names no file"),
    }
}

/// The batch kernel against the reference: hit or miss right but within 1e-5 of tangency, the point within 1e-5 across the
/// surface.
#[cfg(feature = "simd")]
#[test]
fn the_batch_kernel_finds_the_true_crossings() {
    for path in [Some(own_rays()), beside_the_project("oracle/rays.csv")].into_iter().flatten() {
        for row in read(&path).iter().filter(|row| row.margin > 1e-5) {
            let context = || format!("{:?} {:?} margin {}", row.shape.exponents(), row.ray, row.margin);
            let mut hits = vec![row.shape.intersect(&row.ray, RayStart::Free)];
            if let Some(convex) = row.shape.as_convex() {
                kernels::batch::intersect(&convex, &[row.ray], &mut hits);
            }
            match (row.hit, hits[0]) {
                (None, None) => {}
                (Some((t, normal)), Some(actual)) => {
                    let across = (actual.t - t).abs() * normal.dot(row.ray.direction).abs();
                    assert!(across < 1e-5 * (1.0 + 1e-9 * t), "{}: {} for {t}", context(), actual.t);
                    assert_eq!(actual.leaving, row.start_inside, "{}", context());
                }
                (truth, actual) => panic!("{}: {actual:?} for {truth:?}", context()),
            }
        }
    }
}

/// The checks above can fail: the textbook method does not pass them.
#[test]
fn the_textbook_method_fails_where_its_module_says() {
    let rows = read(&own_rays());
    let answer: Solver = |shape, ray| {
        let t = textbook::intersect(ray, shape.exponents()).t?;
        let leaving = shape.inside_outside(ray.origin) < 0.0;
        Some(ShapeHit { t, point: ray.point_at(t), leaving })
    };
    let share_wrong = |choose: fn(f64) -> bool| {
        let chosen: Vec<_> = rows
            .iter()
            .filter(|r| r.hit.is_some() && choose(r.shape.exponents().e().min(r.shape.exponents().n())))
            .collect();
        let wrong = chosen.iter().filter(|row| check(row, answer(&row.shape, &row.ray)).is_err()).count();
        wrong as f64 / chosen.len() as f64
    };
    assert!(share_wrong(|least| least < 0.001) > 0.5);
    assert!(share_wrong(|least| least > 0.9) < 0.5);
}

/// Lanes isolate crossings whatever the exponents, and f64 verifies them.
#[cfg(feature = "simd")]
#[test]
fn every_verified_crossing_of_our_own_ground_truth() {
    use kernels::LanePowers;
    use kernels::stream::{EntryKind, ShapeEntries, StreamHits, StreamLanes};
    use kernels::verify::{KnownCrossing, VerifyBatch};
    let (mut entries, mut lanes, mut found) =
        (ShapeEntries::default(), StreamLanes::default(), StreamHits::default());
    let (mut batch, mut verified) = (VerifyBatch::default(), [0, 0]);
    for row in read(&own_rays()) {
        let TruthRow { shape, ray, .. } = &row;
        entries.set_unit(0, ray.origin, ray.direction, f64::INFINITY);
        entries.run();
        if row.start_inside || entries.kind(0) != EntryKind::Enters {
            continue;
        }
        let entry = entries.get(0);
        lanes.set(0, LanePowers::of_any(shape), &entry, false);
        lanes.isolate(1, &mut found);
        if found.unresolved & 1 == 1 {
            continue;
        }
        let (s, error) = (found.s[0], found.error[0]);
        let hit = if s == f32::INFINITY {
            None
        } else {
            let t_at = |s: f32| entry.t_entry + f64::from(s) * entry.t_per_s;
            let known = KnownCrossing { clear_from: 0.0, between: Some([t_at(s - error), t_at(s)]) };
            batch.clear();
            batch.push(shape, ray, RayStart::Free, &known);
            batch.run();
            let Some(hit) = batch.get(0) else { continue };
            hit.map(|(hit, _)| hit)
        };
        verified[usize::from(hit.is_some())] += 1;
        check(&row, hit).unwrap_or_else(|wrong| panic!("{shape:?} {ray:?}: {wrong}"));
    }
    assert!(verified[0] > 100 && verified[1] > 300, "{verified:?}");
}
