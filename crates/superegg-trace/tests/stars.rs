//! Rays between shapes that are not convex: lanes find what the search in f64 finds, from surfaces too.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayStart, SplitMix};
use superegg_lang::load_text;
use superegg_trace::{CompiledScene, Hit, SurfaceStart, TraceRay};

const STARS: &str = "prm sharp\nexp 3 2.5\ncoeff .9 .7 .8\nprm flat\nexp .4 4\ncoeff .6 .6 .9\n\
    prm needle\nexp 6 6\nprm ball\ncoeff .5 .5 .5\nobj all\n\
    ap sharp\nxs -1.2 0 0\nap flat\nxs 1.1 .2 0\nrs 1 2 3 40\nap needle\nxs 0 1.3 .1\nap ball\nxs 0 -1.1 0\n";

fn compiled(text: &str) -> CompiledScene {
    let (session, diagnostics) = load_text("stars.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    CompiledScene::compile(session.scene(), Some("all"), 4)
}

fn vector(random: &mut SplitMix) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
}

#[test]
fn streams_and_single_rays_agree() {
    let scene = compiled(STARS);
    let mut random = SplitMix::new(5);
    let mut rays: Vec<TraceRay> = Vec::new();
    for _ in 0..20_000 {
        let (from, to) = (3.0 * vector(&mut random), 1.5 * vector(&mut random));
        let ray = TraceRay::from(Ray::new(from, to - from));
        if let Some(hit) = scene.intersect(&ray) {
            let surface = scene.interaction(&hit);
            let direction = vector(&mut random);
            let side = if surface.normal.dot(direction) >= 0.0 {
                RayStart::SurfaceOutward
            } else {
                RayStart::SurfaceInward
            };
            let start = SurfaceStart::of(hit.path.clone(), side);
            let origin_error = surface.position_error;
            let spawned = Ray { origin: surface.position, direction, origin_error };
            rays.push(TraceRay::new(spawned).with_start(start));
        }
        rays.push(ray);
    }
    let hits = scene.intersect_many(&rays);
    let occluded = scene.occluded_many(&rays, 1.5);
    let (mut from_surfaces, mut leaving, mut differences) = (0, 0, 0);
    for ((ray, hit), is_occluded) in rays.iter().zip(&hits).zip(occluded) {
        let single = scene.intersect(ray);
        // A ray that grazes a shape may be taken either way.
        if single.as_ref().map(|hit| &hit.path) != hit.as_ref().map(|hit| &hit.path) {
            differences += 1;
            continue;
        }
        if let (Some(a), Some(b)) = (hit, &single) {
            assert!((a.t - b.t).abs() < 1e-8 * (1.0 + b.t), "{ray:?} {a:?} {b:?}");
            assert_eq!(a.leaving, b.leaving);
            from_surfaces += u32::from(ray.start.is_some());
            leaving += u32::from(b.leaving);
        }
        let before = |hit: &Hit| hit.t < 1.5;
        assert_eq!(is_occluded, single.as_ref().is_some_and(before), "{ray:?} {single:?}");
    }
    assert!(from_surfaces > 3_000 && leaving > 2_000, "{from_surfaces} {leaving}");
    assert_eq!(differences, 0);
}

/// Rays through a sharp rim, and a plate close behind it: their first hit is the other side of the rim, although the search for it
/// begins behind the plate.
#[test]
fn rays_through_a_thin_rim_leave_it_before_the_plate_behind() {
    let text = "prm star\nexp 1 8\nprm plate\nexp .1 .1\ncoeff .3 .3 .01\nobj all\nap star\nap plate\nxs .7 0 -.0105\n";
    let scene = compiled(text);
    let mut random = SplitMix::new(7);
    let mut rays: Vec<TraceRay> = Vec::new();
    for _ in 0..4_000 {
        let target = DVec3::new(0.7 + 0.15 * (2.0 * random.unit() - 1.0), 0.1 * random.unit(), 0.0);
        let direction = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, -2.0);
        let hit = scene.intersect_ray(&Ray::new(target - direction, direction));
        rays.extend(hit.map(|hit| scene.interaction(&hit).spawn_ray(direction)));
    }
    assert!(rays.len() > 3_000, "{}", rays.len());
    for (ray, many) in rays.iter().zip(scene.intersect_many(&rays)) {
        let single = scene.intersect(ray);
        let path = |hit: &Option<Hit>| hit.as_ref().map(|hit| (hit.path.clone(), hit.leaving));
        assert_eq!(path(&many), path(&single), "{ray:?} {many:?} {single:?}");
        assert!(single.is_some_and(|hit| hit.leaving));
    }
}
