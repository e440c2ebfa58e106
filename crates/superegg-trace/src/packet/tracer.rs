//! Tracing the rays of a tile in packets.
//!
//! Rays with one origin traverse the graph together, sixteen to a SIMD register (Wald 2001, Boulos 2007). A node's box is
//! tested for each packet that has hit the parent's; shapes are intersected by f32 kernels, which find candidates. The
//! closest candidate of each ray is refined in f64 by Newton's method from the f32 hit, which proves that it is the shape's
//! first. Where f32 cannot decide (two surfaces at one t, a grazing ray, an origin within a shape's box) the scalar
//! traversal of [`crate::single`] traces the ray.

use superegg_geom::kernels::packet::{ALL_LANES, MAX_PACKETS, PACKET};

use super::batch::LEAST_STREAM;
use super::candidates::{Candidate, CandidateHit, Columns};
use super::query::{AnyHit, Closest, ShadowRay, ShadowRays, ShadowStart, Tests};
use super::rays::PacketRays;
use super::resolve::{Found, Resolver, Scope, SurfaceLanes, VisibleSurfaces};
use super::traverse::{PacketLimits, Stacks, Traversal, Work};
use crate::ray::footprint::Footprint;
use crate::ray::limits::Coarsened;
use crate::ray::query::{Hit, SurfaceStart, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::path::InstancePath;
use superegg_simd::bits;

/// The rays of a packet.
pub const LANES: usize = PACKET;
/// The most rays of one trace: as many packets as a mask has bits.
pub const MOST_RAYS: usize = MAX_PACKETS * PACKET;

/// Traces the rays of one tile after the other, in the same memory.
pub struct PacketTracer<'s> {
    scene: &'s CompiledScene,
    tests: Tests,
    stacks: Stacks,
    resolver: Resolver,
    limits: PacketLimits,
    /// How often the width of the rays of the last trace was doubled.
    doublings: u32,
    coarsened: Coarsened,
}

impl<'s> PacketTracer<'s> {
    /// For the rays of a scene.
    pub fn new(scene: &'s CompiledScene) -> Self {
        let (tests, stacks, resolver, limits, coarsened, doublings) = Default::default();
        Self { scene, tests, stacks, resolver, limits, doublings, coarsened }
    }

    /// The rays since the last call whose work was bounded.
    pub fn take_coarsened(&mut self) -> Coarsened {
        std::mem::take(&mut self.coarsened)
    }

    /// Removes the candidates of the last tile.
    pub fn start_tile(&mut self) {
        self.tests.candidates.clear();
    }

    /// The number of candidates so far.
    pub fn candidate_count(&self) -> usize {
        self.tests.candidates.list.len()
    }

    /// A candidate by its index.
    pub fn candidate(&self, index: u32) -> &Candidate {
        self.tests.candidates.get(index)
    }

    /// The path of a candidate.
    pub fn path(&self, index: u32) -> InstancePath {
        self.tests.candidates.path(index)
    }

    /// Adds a candidate for a hit of another query.
    pub fn adopt(&mut self, hit: &Hit) -> CandidateHit {
        self.tests.candidates.adopt(self.scene, hit)
    }

    /// The closest hit of each ray in f64. There are at most [`MOST_RAYS`].
    pub fn closest(&mut self, rays: &PacketRays, footprint: Footprint, visible: &mut VisibleSurfaces) {
        self.find(rays, footprint, Footprint::NONE);
        self.resolve(rays, &[], visible);
    }

    /// Finds the closest candidate of each ray, at most [`MOST_RAYS`] rays. `footprint` is the rays' width and `pixel` that
    /// of a whole pixel.
    ///
    /// [`PacketTracer::found`] has the candidates, from which the caller makes the maps for [`PacketTracer::resolve`].
    pub fn find(&mut self, rays: &PacketRays, footprint: Footprint, pixel: Footprint) {
        self.doublings = 0;
        let is_loaded = self.trace_closest(rays, footprint);
        self.resolver.start(footprint.doubled(self.doublings, self.scene.size()));
        let (resolver, mut scope) = self.parts(rays);
        if is_loaded {
            resolver.find(&mut scope, pixel);
        } else {
            resolver.find_without_packets(&mut scope);
        }
    }

    /// The closest candidates that [`PacketTracer::find`] has found, sorted by candidate. Rays that f32 cannot decide are
    /// not among them: they are traced in f64.
    pub fn found(&self) -> &[Found] {
        self.resolver.found()
    }

    /// The hits that [`PacketTracer::find`] has found for these rays.
    ///
    /// `maps` has, by the index of the candidate, the columns of the map from gradients to normals. Hits of candidates with
    /// a map go to [`VisibleSurfaces::surfaces`] in f32: as they are if their error is below 1/64 pixel, else refined in
    /// f64. All others go to [`VisibleSurfaces::hits`] in f64.
    pub fn resolve(&mut self, rays: &PacketRays, maps: &[Option<Columns>], visible: &mut VisibleSurfaces) {
        let (resolver, mut scope) = self.parts(rays);
        resolver.resolve(&mut scope, maps, visible);
        std::mem::swap(&mut self.tests.batch.directions, &mut visible.directions);
    }

    /// Moves the surfaces of some lanes to [`VisibleSurfaces::hits`], in f64. `rays` are those of [`PacketTracer::resolve`].
    pub fn move_to_hits(&mut self, rays: &PacketRays, moved: &[SurfaceLanes], visible: &mut VisibleSurfaces) {
        let (resolver, mut scope) = self.parts(rays);
        resolver.move_to_hits(&mut scope, moved, visible);
    }

    fn parts<'a>(&'a mut self, rays: &'a PacketRays) -> (&'a mut Resolver, Scope<'a>) {
        let Tests { kernels, batch, candidates, .. } = &mut self.tests;
        let (coarsened, is_widened) = (&mut self.coarsened, self.doublings > 0);
        let (scene, kernels) = (self.scene, *kernels);
        let scope = Scope { scene, kernels, batch, candidates, rays, is_widened, coarsened };
        (&mut self.resolver, scope)
    }

    /// The number of rays that hit something, as far as f32 can tell.
    pub fn count_hits(&mut self, rays: &PacketRays, footprint: Footprint) -> usize {
        if !self.trace_closest(rays, footprint) {
            return 0;
        }
        self.tests.batch.hits.iter().flat_map(|hits| hits.id.0).filter(|&id| id != u32::MAX).count()
    }

    /// Traces rays for their closest candidates. `false` if f32 cannot hold them.
    fn trace_closest(&mut self, rays: &PacketRays, footprint: Footprint) -> bool {
        debug_assert!(rays.count() <= MOST_RAYS);
        let Tests { kernels, batch, .. } = &mut self.tests;
        if batch.load(*kernels, rays.origin, rays.directions(), f64::INFINITY).is_none() {
            return false;
        }
        let footprint = Footprint { spread: footprint.spread * batch.t_scale, ..footprint };
        let Self { scene, tests, stacks, limits, .. } = self;
        let (limits, work) = (*limits, Work::default());
        let query = &mut Closest { rays };
        let mut traversal = Traversal { scene, tests, stacks, query, footprint, limits, work };
        traversal.run();
        self.doublings = traversal.work.doublings;
        let rays_of = |packet: usize| u64::from(rays.lanes(packet).count_ones());
        self.coarsened.rays += bits(traversal.work.coarsened).map(rays_of).sum::<u64>();
        true
    }

    /// The occluded rays of at most [`MOST_RAYS`]: a mask of lanes for each packet. `footprint` is the rays' least width,
    /// from the light on.
    pub fn occluded(&mut self, shadow: ShadowRays<'_>, footprint: Footprint) -> Vec<u32> {
        let mut query = AnyHit::new(shadow);
        self.doublings = 0;
        let Self { scene, tests, stacks, limits, .. } = self;
        let (limits, work) = (*limits, Work::default());
        let from_light = shadow.from_light;
        if tests.batch.load(tests.kernels, from_light.origin, from_light.directions(), 1.0).is_none() {
            let all = vec![u32::MAX; query.occluded.len()];
            return self.occluded_without_packets(shadow, &all, query.occluded);
        }
        let mut traversal = Traversal { scene, tests, stacks, query: &mut query, footprint, limits, work };
        traversal.run();
        self.doublings = traversal.work.doublings;
        let rays_of = |packet: usize| shadow.starts.len().saturating_sub(packet * PACKET).min(PACKET) as u64;
        self.coarsened.rays += bits(traversal.work.coarsened).map(rays_of).sum::<u64>();
        let unresolved = std::mem::take(&mut self.tests.batch.unresolved);
        let occluded = self.occluded_without_packets(shadow, &unresolved, query.occluded);
        self.tests.batch.unresolved = unresolved;
        occluded
    }

    /// Traces the `unresolved` rays that are not yet occluded without packets.
    fn occluded_without_packets(
        &mut self,
        shadow: ShadowRays<'_>,
        unresolved: &[u32],
        mut occluded: Vec<u32>,
    ) -> Vec<u32> {
        let (mut rays, mut indices) = (Vec::new(), Vec::new());
        for (packet, (occluded, unresolved)) in occluded.iter().zip(unresolved).enumerate() {
            for lane in bits(unresolved & !*occluded & ALL_LANES) {
                let index = packet * PACKET + lane;
                let Some(&ShadowStart { own, start, .. }) = shadow.starts.get(index) else { continue };
                let ShadowRay { ray, width } = (shadow.ray)(index);
                let start = own.and_then(|own| SurfaceStart::of(self.path(own), start));
                let footprint = Footprint { width, spread: 0.0 };
                let footprint = footprint.doubled(self.doublings, self.scene.size());
                rays.push(TraceRay { ray, start, footprint });
                indices.push(index);
            }
        }
        let is_widened = self.doublings > 0;
        let answers = if rays.len() >= LEAST_STREAM && !is_widened {
            self.scene.occluded_many_counted(&rays, 1.0, &mut self.coarsened)
        } else {
            let mut is_occluded =
                |ray| self.scene.occluded_counted(ray, 1.0, is_widened, &mut self.coarsened);
            rays.iter().map(&mut is_occluded).collect()
        };
        for (index, _) in indices.into_iter().zip(answers).filter(|(_, is_occluded)| *is_occluded) {
            occluded[index / PACKET] |= 1 << (index % PACKET);
        }
        occluded
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::{DVec2, DVec3};
    use superegg_geom::kernels::packet::PacketSurfaces;
    use superegg_geom::{Ray, RayStart};
    use superegg_lang::load_text;
    use superegg_scene::Camera;

    use super::super::candidates::f32_columns;
    use super::super::resolve::SurfaceLanes;
    use super::*;
    use crate::test_camera::TestCamera;

    /// Shapes of all kinds, nested, turned, mirrored, in each other, beside each other, and twice at the same position.
    const SCENE: &str = "prm ball\nprm box\nexp .1 .1\ncoeff .8 .5 .6\nprm drop\nexp .7 1.6\ncoeff .3 .9 .5\n\
        prm star\nexp 3 2.5\nprm gem\nexp 2 2\nprm flat\nexp 1 .01\ncoeff 40 40 .1\n\
        obj inner\nap box\nrs 1 2 3 40\nap ball\nss .4 .4 .4\nxs .7 .2 .5\nap drop\nss .8 -.8 .8\nxs -1 .3 0\nap star\nxs 0 -1.2 .6\n\
        obj middle\nao inner a\nss .6 .9 .5\nrs 0 1 1 70\nao inner b\nrs 1 0 0 20\nss .5 .5 .5\nxs 1.5 0 0\nap gem\nxs 0 1.6 0\n\
        obj all\nao middle m\nao middle n\nrs 0 0 1 130\nxs .5 -2.5 .4\nap flat\nxs 0 0 -1.5\nap ball\nxs 2 2 0\nap ball again\nxs 2 2 0\n\
        ap box cut\nxs 1.6 2 .3\nap ball standing\nss .5 .5 .5\nxs -2 2 -.9\n";

    fn scene() -> CompiledScene {
        let (session, diagnostics) = load_text("packets.scn", SCENE);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        CompiledScene::compile(session.scene(), Some("all"), 10)
    }

    fn views() -> Vec<TestCamera> {
        // From afar, from among the shapes, from within one, and straight down.
        [(9.0, -7.0, 5.0), (0.3, -0.9, 0.9), (2.0, 2.0, 0.2), (0.0, 0.0, 30.0), (900.0, 300.0, 200.0)]
            .map(|(x, y, z)| {
                let fov_deg = if x > 100.0 { 0.6 } else { 50.0 };
                let camera = Camera {
                    position: DVec3::new(x, y, z),
                    target: DVec3::ZERO,
                    up: DVec3::Z,
                    fov_deg,
                    ..Camera::default()
                };
                TestCamera::new(&camera, 96, 96)
            })
            .to_vec()
    }

    fn tile(view: &TestCamera, tile: u32) -> Vec<Ray> {
        let (x, y) = (16 * (tile % 6), 16 * (tile / 6));
        let pixel = |i: u32| DVec2::new(f64::from(x + i % 16) + 0.5, f64::from(y + i / 16) + 0.5);
        (0..256).map(|i| view.ray(pixel(i))).collect()
    }

    /// The closest crossings of rays from one origin.
    fn closest(tracer: &mut PacketTracer<'_>, rays: &[Ray]) -> Vec<Option<CandidateHit>> {
        let (mut packets, mut visible) = (PacketRays::default(), VisibleSurfaces::default());
        packets.start(rays[0].origin);
        rays.iter().for_each(|ray| packets.push(ray.direction));
        tracer.start_tile();
        tracer.closest(&packets, Footprint::NONE, &mut visible);
        let mut hits = vec![None; rays.len()];
        visible.hits.into_iter().for_each(|(ray, hit)| hits[ray as usize] = Some(hit));
        hits
    }

    #[test]
    fn packets_hit_what_single_rays_hit_and_are_occluded_alike() {
        let scene = scene();
        let mut tracer = PacketTracer::new(&scene);
        let (mut hits_found, mut stopped, mut exact) = (0, 0, 0);
        for view in views() {
            for rays in (0..36).map(|i| tile(&view, i)) {
                let hits = closest(&mut tracer, &rays);
                exact += tracer.tests.batch.unresolved.iter().map(|lanes| lanes.count_ones()).sum::<u32>();
                let light = DVec3::new(3.0, -5.0, 8.0);
                let (mut shadow_rays, mut starts) = (Vec::new(), Vec::new());
                let mut from_light = PacketRays::default();
                from_light.start(light);
                for (ray, hit) in rays.iter().zip(&hits) {
                    let expected = scene.intersect_ray(ray);
                    assert_eq!(hit.is_some(), expected.is_some(), "{ray:?} {hit:?} {expected:?}");
                    let (Some(hit), Some(expected)) = (hit, expected) else { continue };
                    hits_found += 1;
                    assert!((hit.t - expected.t).abs() < 1e-9 * (1.0 + expected.t), "{hit:?} {expected:?}");
                    assert_eq!(hit.leaving, expected.leaving);
                    assert_eq!(tracer.path(hit.candidate), expected.path, "{ray:?}");
                    assert!((hit.unit_point - expected.unit_point).length() < 1e-7);
                    let surface = scene.interaction(&expected);
                    let direction = light - surface.position;
                    if surface.facing_normal().dot(direction) > 0.0 {
                        let TraceRay { ray, start, .. } = surface.spawn_ray(direction);
                        let start = start.map_or(RayStart::Free, |start| start.ray_start());
                        starts.push(ShadowStart { own: Some(hit.candidate), start });
                        from_light.push(-direction);
                        shadow_rays.push(ShadowRay { ray, width: 0.0 });
                    }
                }
                let shadow =
                    ShadowRays { from_light: &from_light, starts: &starts, ray: &|i| shadow_rays[i] };
                let occluded = tracer.occluded(shadow, Footprint::NONE);
                for (i, (ShadowRay { ray, .. }, one)) in shadow_rays.iter().zip(&starts).enumerate() {
                    let occluded = occluded[i / PACKET] >> (i % PACKET) & 1 == 1;
                    let start = SurfaceStart::of(tracer.path(one.own.unwrap()), one.start);
                    let expected = scene.occluded(&TraceRay::new(*ray).with_start(start), 1.0);
                    stopped += usize::from(expected);
                    assert_eq!(occluded, expected, "{ray:?}");
                }
            }
        }
        assert!(hits_found > 20_000 && stopped > 1_000 && exact < 46_080, "{hits_found} {stopped} {exact}");
    }

    #[test]
    fn rays_from_very_far_are_neither_widened_nor_lost() {
        // The blocks have too many shapes to be folded. Plates of neighbours would lie in each other.
        let mut text = SCENE.replace("ap flat\nxs 0 0 -1.5\n", "") + "obj block\n";
        for i in 0..36 {
            text += &format!("ao all a{i}\nxs {} {} 0\n", 8 * (i % 6) - 20, 8 * (i / 6) - 20);
        }
        text += "obj grid\nao block a\nxs 24 0 0\nao block b\nxs -24 0 5\n";
        let (session, diagnostics) = load_text("grid.scn", &text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = CompiledScene::compile(session.scene(), Some("grid"), 10);
        let mut tracer = PacketTracer::new(&scene);
        let (mut hits_found, mut stopped) = (0, 0);
        for (case, far) in (0u32..).zip([1e3, 1e5, 1e6, 1e7].into_iter().cycle().take(48)) {
            let position = far * DVec3::new(f64::from(case).sin(), f64::from(case).cos(), 0.7);
            let fov_deg = (70.0 / far).to_degrees();
            let camera = Camera { position, target: DVec3::ZERO, up: DVec3::Z, fov_deg, ..Camera::default() };
            let view = TestCamera::new(&camera, 16, 16);
            let footprint = Footprint { width: 1e-3, spread: 0.0 };
            let rays = tile(&view, 0);
            let (mut packets, mut visible) = (PacketRays::default(), VisibleSurfaces::default());
            packets.start(position);
            rays.iter().for_each(|ray| packets.push(ray.direction));
            tracer.start_tile();
            tracer.closest(&packets, footprint, &mut visible);
            let (mut shadow_rays, mut starts) = (Vec::new(), Vec::new());
            let (light, mut from_light) = (position - 0.4 * far * DVec3::X, PacketRays::default());
            from_light.start(light);
            let mut hits = vec![None; rays.len()];
            visible.hits.into_iter().for_each(|(ray, hit)| hits[ray as usize] = Some(hit));
            for (ray, hit) in rays.iter().zip(hits) {
                let expected = scene.intersect_ray(ray);
                let path = hit.as_ref().map(|hit| tracer.path(hit.candidate));
                assert_eq!(path, expected.as_ref().map(|hit| hit.path.clone()), "{far} {ray:?}");
                let (Some(hit), Some(expected)) = (hit, expected) else { continue };
                hits_found += 1;
                let surface = scene.interaction(&expected);
                let direction = light - surface.position;
                let TraceRay { ray, start, .. } = surface.spawn_ray(direction);
                let start = start.map_or(RayStart::Free, |start| start.ray_start());
                starts.push(ShadowStart { own: Some(hit.candidate), start });
                from_light.push(-direction);
                shadow_rays.push(ShadowRay { ray, width: 1e-3 });
            }
            let shadow = ShadowRays { from_light: &from_light, starts: &starts, ray: &|i| shadow_rays[i] };
            let occluded = tracer.occluded(shadow, footprint);
            for (i, (ShadowRay { ray, .. }, one)) in shadow_rays.iter().zip(&starts).enumerate() {
                let start = SurfaceStart::of(tracer.path(one.own.unwrap()), one.start);
                let expected = scene.occluded(&TraceRay::new(*ray).with_start(start), 1.0);
                assert_eq!(occluded[i / PACKET] >> (i % PACKET) & 1 == 1, expected, "{far} {ray:?}");
                stopped += usize::from(expected);
            }
            assert_eq!(tracer.take_coarsened().rays, 0, "{far}");
        }
        assert!(hits_found > 1_000 && stopped > 60, "{hits_found} {stopped}");
    }

    /// A tree of overlapping branches, with leaves at all levels.
    fn tree(depth: u32) -> CompiledScene {
        let text = "prm trunk\ncoeff .12 .12 .5\nexp 1 .3\nprm star\nexp 3 2.5\ncoeff .3 .2 .3\nobj tree\n\
            ap trunk\nxs 0 0 .5\nap star\nxs .2 .1 .9\nao tree a\nss .7 .7 .7\nrs 0 1 0 35\nxs 0 0 1\n\
            ao tree b\nss .7 -.7 .7\nrs 0 1 0 35\nrs 0 0 1 120\nxs 0 0 1\n\
            ao tree c\nss .7 .6 .7\nrs 0 1 0 35\nrs 0 0 1 240\nxs 0 0 1\n";
        let (session, diagnostics) = load_text("tree.scn", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        CompiledScene::compile(session.scene(), Some("tree"), depth)
    }

    fn tree_view() -> TestCamera {
        let camera = Camera {
            position: DVec3::new(1.3, -3.5, 2.9),
            target: DVec3::new(0.0, 0.0, 1.6),
            up: DVec3::Z,
            fov_deg: 45.0,
            ..Camera::default()
        };
        TestCamera::new(&camera, 96, 96)
    }

    #[test]
    fn packets_in_order_hit_what_single_rays_hit() {
        let scene = tree(6);
        let mut tracer = PacketTracer::new(&scene);
        // Never depth-first, and never too much work.
        tracer.limits = PacketLimits { most_opened: 0, work: u32::MAX };
        let mut hits_found = 0;
        for rays in (0..36).map(|i| tile(&tree_view(), i)) {
            let hits = closest(&mut tracer, &rays);
            for (ray, hit) in rays.iter().zip(&hits) {
                let expected = scene.intersect_ray(ray);
                assert_eq!(hit.is_some(), expected.is_some(), "{ray:?}");
                let (Some(hit), Some(expected)) = (hit, expected) else { continue };
                hits_found += 1;
                assert!((hit.t - expected.t).abs() < 1e-9 * (1.0 + expected.t));
                assert_eq!(tracer.path(hit.candidate), expected.path);
            }
        }
        assert_eq!(tracer.take_coarsened().rays, 0);
        assert!(hits_found > 2_000, "{hits_found}");
    }

    #[test]
    fn the_work_for_overlapping_branches_is_bounded_and_what_it_costs_is_counted() {
        // 10^14 instances, of which exponentially many are in front of each ray.
        let (scene, view) = (tree(30), tree_view());
        let footprint = view.footprint(1);
        let mut tracer = PacketTracer::new(&scene);
        tracer.limits = PacketLimits { most_opened: 200, work: 3_000 };
        let (mut packets, mut visible) = (PacketRays::default(), VisibleSurfaces::default());
        let mut covered = 0;
        for rays in (0..36).map(|i| tile(&view, i)) {
            packets.start(rays[0].origin);
            rays.iter().for_each(|ray| packets.push(ray.direction));
            tracer.start_tile();
            tracer.closest(&packets, footprint, &mut visible);
            covered += visible.hits.len();
            // A few dozen groups or leaves for each unit of a few traversals.
            assert!(tracer.candidate_count() < 40_000, "{}", tracer.candidate_count());
        }
        let coarsened = tracer.take_coarsened().rays;
        assert!(coarsened > 1_000 && coarsened < 96 * 96, "{coarsened}");
        assert!(covered > 3_000, "{covered}");
    }

    #[test]
    fn rays_that_f32_cannot_hold_are_answered_all_the_same() {
        let scene = scene();
        let mut tracer = PacketTracer::new(&scene);
        let hostile = [0.0, -0.0, 1e-300, 1e300, f64::MAX, f64::INFINITY, f64::NAN, -1.0];
        for x in hostile {
            for origin in hostile {
                let rays: Vec<Ray> = hostile
                    .iter()
                    .map(|&y| Ray::new(DVec3::new(origin, 3.0, 5.0), DVec3::new(x, y, -1.0)))
                    .collect();
                let hits = closest(&mut tracer, &rays);
                for (ray, hit) in rays.iter().zip(&hits).filter(|(ray, _)| ray.direction.is_finite()) {
                    assert_eq!(hit.is_some(), scene.intersect_ray(ray).is_some(), "{ray:?}");
                }
            }
        }
    }

    /// Finds the surfaces on the 256 rays of a tile of 16 x 16 pixels from this corner on, with maps for f32. Returns the rays.
    fn see_tile(
        tracer: &mut PacketTracer<'_>,
        view: &TestCamera,
        [x, y]: [u32; 2],
        visible: &mut VisibleSurfaces,
    ) -> Vec<Ray> {
        let film = |i: u32| DVec2::new(f64::from(x + i % 16) + 0.5, f64::from(y + i / 16) + 0.5);
        let seen: Vec<Ray> = (0..256).map(|i| view.ray(film(i))).collect();
        let mut rays = PacketRays::default();
        rays.start(seen[0].origin);
        seen.iter().for_each(|ray| rays.push(ray.direction));
        tracer.start_tile();
        tracer.find(&rays, view.footprint(64), view.footprint(1));
        let map = |candidate: u32| {
            let to_unit = tracer.candidate(candidate).unit_from_world.matrix3;
            f32_columns(&to_unit.transpose()).map(|(columns, _)| columns)
        };
        let maps: Vec<_> = (0..tracer.candidate_count() as u32).map(map).collect();
        tracer.resolve(&rays, &maps, visible);
        seen
    }

    #[test]
    fn flat_shapes_seen_from_afar_are_resolved_in_f32() {
        // A ground as course scenes have it: 1000 wide, a fiftieth high.
        let text = "prm ground\nexp 1 .0001\ncoeff 500 500 .01\nobj all\nap ground\nxs 0 0 -.01\n";
        let (session, diagnostics) = load_text("ground.scn", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = CompiledScene::compile(session.scene(), Some("all"), 10);
        let camera = Camera {
            position: DVec3::new(8.0, -15.0, 6.0),
            target: DVec3::new(1.0, 0.0, 1.0),
            up: DVec3::Z,
            fov_deg: 29.0,
            ..Camera::default()
        };
        let view = TestCamera::new(&camera, 1280, 960);
        let (mut tracer, mut visible) = (PacketTracer::new(&scene), VisibleSurfaces::default());
        let (mut in_f32, mut hits_found) = (0, 0);
        for i in (0..4800).step_by(37) {
            let (x, y) = (16 * (i % 80), 16 * (i / 80));
            see_tile(&mut tracer, &view, [x, y], &mut visible);
            // A refined hit has a smaller error than any that the f32 kernels find.
            let is_found_in_f32 = |packet: usize, lane: usize| {
                let PacketSurfaces { t, error, .. } = &visible.surfaces[packet];
                error.0[lane] > 2.0 * f32::EPSILON * t.0[lane]
            };
            for &SurfaceLanes { packet, lanes: all, .. } in &visible.resolved {
                hits_found += all.count_ones();
                in_f32 += bits(all).filter(|&lane| is_found_in_f32(packet, lane)).count() as u32;
            }
            hits_found += visible.hits.len() as u32;
        }
        assert!(hits_found > 20_000 && in_f32 > hits_found / 10 * 9, "{in_f32} of {hits_found}");
    }

    #[test]
    fn rims_of_thin_shapes_are_where_f64_has_them() {
        for (thin, e) in [(1e-2, 1.0), (1e-3, 1.0), (1e-4, 1.0), (1e-3, 0.5)] {
            let text = format!("prm disc\nexp {e} 1\nobj all\nap disc\nss 1 1 {thin}\nrs 1 0 0 30\n");
            let (session, diagnostics) = load_text("disc.scn", &text);
            assert!(diagnostics.is_empty(), "{diagnostics:?}");
            let scene = CompiledScene::compile(session.scene(), Some("all"), 10);
            let camera = Camera {
                position: DVec3::new(0.0, 0.0, 3.0),
                target: DVec3::ZERO,
                fov_deg: 40.0,
                ..Camera::default()
            };
            let view = TestCamera::new(&camera, 240, 240);
            let (mut tracer, mut visible) = (PacketTracer::new(&scene), VisibleSurfaces::default());
            let (mut wrong, mut hits) = (0, 0);
            for tile in 0..225 {
                let (x, y) = (16 * (tile % 15), 16 * (tile / 15));
                let rays = see_tile(&mut tracer, &view, [x, y], &mut visible);
                let mut is_hit = [false; 256];
                visible.hits.iter().for_each(|(ray, _)| is_hit[*ray as usize] = true);
                for &SurfaceLanes { packet, lanes, .. } in &visible.resolved {
                    bits(lanes).for_each(|lane| is_hit[packet * LANES + lane] = true);
                }
                for (i, is_hit) in is_hit.into_iter().enumerate() {
                    let expected = scene.intersect_ray(&rays[i]).is_some();
                    hits += u32::from(expected);
                    wrong += u32::from(is_hit != expected);
                }
            }
            assert!(hits > 5_000 && wrong == 0, "{thin} {e}: {wrong} of {hits}");
        }
    }
}
