//! The chords of shadow rays through one convex shape.

use superegg_geom::kernels::stream::{
    END, EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamChords, StreamLanes,
};
use superegg_simd::{Arch, Simd, WithSimd};

use super::occluders::Occluder;
use super::occlusion::ShaftRays;
use crate::packet::f32_columns;

/// A ray through a convex shape, in f32.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// The index of the ray.
    pub ray: usize,
    /// The t of entry and exit.
    pub t: [f64; 2],
    /// The cosines of the angles between ray and normal at both, in [0, 1].
    pub cos: [f64; 2],
}

/// The rays that hit one shape or may do so.
#[derive(Debug, Default)]
pub struct Chords {
    /// The rays that go through it before their ends.
    pub found: Vec<Chord>,
    /// The rays of which f32 does not tell it.
    pub unresolved: Vec<usize>,
}

impl Occluder {
    /// Finds the chords of the open rays through this shape, if it is convex. All other open rays miss it up to t = `t_max`.
    pub fn find_chords(&self, t_max: f64, rays: &ShaftRays, chords: &mut Chords) {
        chords.found.clear();
        chords.unresolved.clear();
        Arch::new().dispatch(FindChords { occluder: self, t_max, rays, chords });
    }
}

struct FindChords<'a> {
    occluder: &'a Occluder,
    t_max: f64,
    rays: &'a ShaftRays,
    chords: &'a mut Chords,
}

/// A ray that waits for the kernel.
#[derive(Clone, Copy)]
struct Queued {
    ray: usize,
    t_entry: f64,
    t_per_s: f64,
}

impl WithSimd for FindChords<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { occluder, t_max, rays, chords } = self;
        let Some(columns) = f32_columns(&occluder.unit_from_world.matrix3).filter(|_| occluder.is_convex)
        else {
            let open = (0..rays.len()).filter(|&ray| rays.is_open(ray));
            chords.unresolved.extend(open);
            return;
        };
        let mut entries = ShapeEntries::default();
        let (mut lanes, mut found) = (StreamLanes::default(), StreamChords::default());
        let mut queued = smallvec::SmallVec::<[Queued; STREAM_LANES]>::new();
        rays.for_each_entry(occluder, t_max, &mut entries, |ray, kind, entry| {
            let ShapeEntry { t_entry, t_per_s, length, .. } = entry;
            let ends_beyond = t_entry + f64::from(length) * t_per_s < t_max * (1.0 - END);
            if kind != EntryKind::Enters || !ends_beyond {
                chords.unresolved.push(ray);
                return;
            }
            lanes.set(queued.len(), occluder.powers, &entry, false);
            queued.push(Queued { ray, t_entry, t_per_s });
            if queued.len() == STREAM_LANES {
                run(rays, columns, &mut lanes, &mut queued, &mut found, chords);
            }
        });
        run(rays, columns, &mut lanes, &mut queued, &mut found, chords);
    }
}

/// Finds the chords of the queued rays. `columns` is the linear map from the world, scaled.
fn run(
    rays: &ShaftRays,
    (columns, scale): ([[f32; 3]; 3], f64),
    lanes: &mut StreamLanes,
    queued: &mut smallvec::SmallVec<[Queued; STREAM_LANES]>,
    found: &mut StreamChords,
    chords: &mut Chords,
) {
    if queued.is_empty() {
        return;
    }
    lanes.clear_from(queued.len());
    lanes.chords(queued.len(), &columns, found);
    for (lane, &Queued { ray, t_entry, t_per_s }) in queued.iter().enumerate() {
        if found.missed >> lane & 1 == 1 {
            continue;
        }
        if found.found >> lane & 1 == 0 {
            chords.unresolved.push(ray);
            continue;
        }
        let per_slope = scale / (t_per_s * rays.direction(ray).length());
        chords.found.push(Chord {
            ray,
            t: [0, 1].map(|end| t_entry + f64::from(found.s[end][lane]) * t_per_s),
            cos: [0, 1].map(|end| (f64::from(found.slopes[end][lane]) * per_slope).min(1.0)),
        });
    }
    queued.clear();
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;
    use superegg_geom::{Aabb, Ray, RayStart, SplitMix};
    use superegg_lang::load_text;

    use super::super::hull::Shaft;
    use super::super::occluders::ShaftStart;
    use super::*;
    use crate::ray::query::{SurfaceStart, TraceRay};
    use crate::scene::compiled::CompiledScene;

    fn vector(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
    }

    #[test]
    fn chords_are_those_of_two_rays_in_f64() {
        let mut random = SplitMix::new(21);
        let (mut through, mut missed, mut unresolved) = (0, 0, 0);
        for case in 0..400 {
            let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
            let (e, n) = (number(0.05, 2.0), number(0.05, 2.0));
            let (size, flat, angle) = (number(1e-2, 50.0), number(0.1, 1.0), number(0.0, 360.0));
            let text = format!(
                "prm glass\nexp {e} {n}\ncoeff 1 {flat} .7\nobj all\nap glass\nss {size} {size} -{size}\nrs 1 2 3 {angle}\nxs 3 1 -2\n"
            );
            let (session, diagnostics) = load_text("chords.scn", &text);
            assert!(diagnostics.is_empty(), "{diagnostics:?}");
            let scene = CompiledScene::compile(session.scene(), Some("all"), 4);
            let around = Aabb::around(DVec3::ZERO, DVec3::splat(1e4));
            let (mut shapes, mut rays, mut chords) = (Vec::new(), ShaftRays::default(), Chords::default());
            assert!(scene.find_occluders(
                &Shaft::between(&around, &around),
                ShaftStart::default(),
                &mut shapes
            ));
            let middle = DVec3::new(3.0, 1.0, -2.0);
            let given: Vec<Ray> = (0..21)
                .map(|_| {
                    let origin = middle + size * (3.0 * vector(&mut random).normalize_or(DVec3::X));
                    let target = middle + size * vector(&mut random);
                    // Ends before, in and behind the shape.
                    Ray::new(origin, (target - origin) * (3.0 * random.unit()))
                })
                .collect();
            given.iter().for_each(|ray| rays.push(ray));
            shapes[0].find_chords(1.0, &rays, &mut chords);
            unresolved += chords.unresolved.len();
            for (index, ray) in
                given.iter().enumerate().filter(|(index, _)| !chords.unresolved.contains(index))
            {
                let entry = scene.intersect(&TraceRay::new(*ray)).filter(|hit| hit.t < 1.0);
                let Some(chord) = chords.found.iter().find(|chord| chord.ray == index) else {
                    assert!(entry.is_none(), "case {case}: {ray:?} {entry:?}");
                    missed += 1;
                    continue;
                };
                let entry = entry.unwrap_or_else(|| panic!("case {case}: {ray:?} {chord:?}"));
                let surface = scene.interaction(&entry);
                let inward = SurfaceStart::of(entry.path.clone(), RayStart::SurfaceInward);
                let onward = Ray { origin: surface.position, origin_error: surface.position_error, ..*ray };
                let exit = scene.intersect(&TraceRay::new(onward).with_start(inward)).unwrap();
                let behind = scene.interaction(&exit);
                let expected = [(entry.t, surface.normal), (entry.t + exit.t, behind.normal)];
                for (end, (t, normal)) in expected.into_iter().enumerate() {
                    let cos = ray.direction.normalize().dot(normal).abs();
                    let what = format!("case {case}: {text} {ray:?} {chord:?} {t} {cos}");
                    // How far the end lies from the surface.
                    let off = (chord.t[end] - t).abs() * ray.direction.length() * cos;
                    assert!(off < 2e-5 * size, "{what}");
                    // Edges of small exponents turn within a small part of the shape.
                    assert!((chord.cos[end] - cos).abs() < 0.02, "{what}");
                    assert!((chord.cos[end] - cos).abs() < 5e-3 || e.min(n) < 0.3, "{what}");
                }
                through += 1;
            }
        }
        assert!(through > 1_500 && missed > 1_500 && unresolved < 2_500, "{through} {missed} {unresolved}");
    }
}
