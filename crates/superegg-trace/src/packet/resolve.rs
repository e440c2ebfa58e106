//! The hits of packets, to the precision that each needs.

use superegg_geom::glam::DMat3;
use superegg_geom::kernels::packet::{
    ConeWidth, PACKET, PacketKernels, PacketSurfaces, PacketVectors, RANGE,
};
use superegg_geom::kernels::refine::{RefineBatch, RefineRay};
use superegg_geom::kernels::verify::{KnownCrossing, VerifyBatch};
use superegg_geom::{RayStart, ShapeHit, unit_vector};

use super::batch::{LEAST_STREAM, TracedPackets};
use super::candidates::{Candidate, CandidateHit, Candidates, Columns, RefinedShape, unit_shape};
use super::rays::PacketRays;
use crate::ray::footprint::Footprint;
use crate::ray::limits::Coarsened;
use crate::ray::query::TraceRay;
use crate::scene::compiled::CompiledScene;
use superegg_simd::bits;

/// An f32 hit whose error is below this part of a pixel's width needs no refinement.
const NEAR: f64 = 1.0 / 64.0;

/// Lanes of a packet with the same closest candidate.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// The packet.
    pub packet: usize,
    /// The candidate.
    pub candidate: u32,
    /// The lanes.
    pub lanes: u32,
    /// Those of them whose f32 hit is precise to a small part of a pixel.
    near: u32,
}

/// Lanes of a packet with a surface of one candidate in [`VisibleSurfaces::surfaces`].
#[derive(Clone, Copy, Debug)]
pub struct SurfaceLanes {
    /// The packet.
    pub packet: usize,
    /// The candidate.
    pub candidate: u32,
    /// The lanes.
    pub lanes: u32,
}

/// The first surfaces on the rays of a tile.
#[derive(Debug, Default)]
pub struct VisibleSurfaces {
    /// The hits in f64, each with the index of its ray.
    pub hits: Vec<(u32, CandidateHit)>,
    /// The other surfaces, in f32, by packets.
    pub surfaces: Vec<PacketSurfaces>,
    /// The directions of the rays, by packets, scaled by a power of two.
    pub directions: Vec<PacketVectors>,
    /// The candidates in `surfaces`.
    pub resolved: Vec<SurfaceLanes>,
    /// Converts a t of `surfaces` to the rays' own.
    pub t_scale: f64,
    /// An upper bound on the length of `directions`.
    reach: f64,
}

/// A surface in one lane of [`VisibleSurfaces::surfaces`].
#[derive(Clone, Copy, Debug)]
pub struct LaneSurface {
    /// The candidate.
    pub candidate: u32,
    /// The t of the ray as it was given.
    pub t: f64,
    /// A bound on the error of the position, in world units.
    pub position_error: f64,
}

impl VisibleSurfaces {
    /// The f32 surface on a ray, which has one.
    pub fn surface_at(&self, ray: usize) -> LaneSurface {
        let (surfaces, lane) = (&self.surfaces[ray / PACKET], ray % PACKET);
        LaneSurface {
            candidate: surfaces.id.0[lane],
            t: f64::from(surfaces.t.0[lane]) * self.t_scale,
            position_error: self.position_error(surfaces.error.0[lane]),
        }
    }

    fn start(&mut self, packets: usize) {
        self.hits.clear();
        self.resolved.clear();
        self.surfaces.clear();
        self.surfaces.resize(packets, PacketSurfaces::NONE);
    }

    /// Removes the lanes without a surface from `resolved`.
    fn drop_empty(&mut self) {
        let Self { resolved, surfaces, .. } = self;
        resolved.retain_mut(|resolved| {
            resolved.lanes &= surfaces[resolved.packet].lanes;
            resolved.lanes != 0
        });
    }

    /// A bound on the error of positions whose error of t is `error`, in world units.
    pub fn position_error(&self, error: f32) -> f64 {
        self.reach * f64::from(error)
    }

    /// Stores an f64 hit among the f32 surfaces. `map` is the map from gradients to normals. `false` if the rounding error
    /// exceeds `width`, or f32 cannot hold t.
    fn store(&mut self, ray: u32, hit: &CandidateHit, map: Columns, width: ConeWidth) -> bool {
        let (surfaces, lane) = (&mut self.surfaces[ray as usize / PACKET], ray as usize % PACKET);
        let t = (hit.t / self.t_scale) as f32;
        let error = f32::EPSILON * t;
        let map = DMat3::from_cols_array_2d(&map.map(|column| column.map(f64::from)));
        let Some(normal) = unit_vector(map * hit.gradient) else { return false };
        if !(RANGE[0]..RANGE[1]).contains(&t) || error > width.spread.mul_add(t, width.width) {
            return false;
        }
        surfaces.lanes |= 1 << lane;
        surfaces.t.0[lane] = t;
        surfaces.error.0[lane] = error;
        surfaces.id.0[lane] = hit.candidate;
        for axis in 0..3 {
            surfaces.normal[axis].0[lane] = normal[axis] as f32;
        }
        true
    }
}

/// A hit that is to be refined with others.
#[derive(Clone, Copy, Debug)]
struct Approximate {
    ray: u32,
    candidate: u32,
    t: f64,
    /// A bound on the error of t.
    error: f64,
}

/// The closest candidates of a tile's rays, and the memory to refine their hits.
pub(super) struct Resolver {
    found: Vec<Found>,
    /// The hits of rays that were traced in f64.
    exact: Vec<(u32, CandidateHit)>,
    footprint: Footprint,
    /// The error that an f32 hit may have.
    width: ConeWidth,
    refinement: RefineBatch,
    approximate: Vec<Approximate>,
    /// Hits on shapes that are not convex.
    verification: VerifyBatch,
    isolated: Vec<Approximate>,
}

/// The input of a resolver, and the candidates that it adds to.
pub(super) struct Scope<'a> {
    pub(super) scene: &'a CompiledScene,
    pub(super) kernels: PacketKernels,
    pub(super) batch: &'a TracedPackets,
    pub(super) candidates: &'a mut Candidates,
    pub(super) rays: &'a PacketRays,
    /// Whether the rays are widened to bound the work.
    pub(super) is_widened: bool,
    pub(super) coarsened: &'a mut Coarsened,
}

impl Default for Resolver {
    fn default() -> Self {
        Self {
            found: Vec::new(),
            exact: Vec::new(),
            footprint: Footprint::NONE,
            width: ConeWidth { width: 0.0, spread: 0.0 },
            refinement: RefineBatch::default(),
            approximate: Vec::new(),
            verification: VerifyBatch::default(),
            isolated: Vec::new(),
        }
    }
}

impl Resolver {
    pub(super) fn found(&self) -> &[Found] {
        &self.found
    }

    /// Forgets the last tile. Rays have this footprint.
    pub(super) fn start(&mut self, footprint: Footprint) {
        self.found.clear();
        self.exact.clear();
        self.footprint = footprint;
    }

    /// Traces all rays without packets.
    pub(super) fn find_without_packets(&mut self, scope: &mut Scope<'_>) {
        let rays: Vec<usize> = (0..scope.rays.count()).collect();
        scope.hits_without_packets(&rays, self.footprint, &mut self.exact);
    }

    /// Collects the closest candidates. Hits whose error is small against the footprint `pixel` stay in f32.
    pub(super) fn find(&mut self, scope: &mut Scope<'_>, pixel: Footprint) {
        let scale = scope.batch.t_scale;
        let near = NEAR / scope.batch.largest().length();
        self.width =
            ConeWidth { width: (near * pixel.width) as f32, spread: (near * pixel.spread * scale) as f32 };
        let mut others = Vec::new();
        for packet in 0..scope.batch.hits.len() {
            let lanes = scope.rays.lanes(packet);
            let unresolved = scope.batch.unresolved[packet] & lanes;
            let hits = &scope.batch.hits[packet];
            let closest = scope.kernels.candidates(hits, lanes & !unresolved, self.width);
            others.extend(bits(closest.unresolved | unresolved).map(|lane| packet * PACKET + lane));
            let with_lanes = closest.ids.iter().zip(&closest.lanes).take(closest.count);
            self.found.extend(with_lanes.map(|(&candidate, &lanes)| Found {
                packet,
                candidate,
                lanes,
                near: lanes & closest.near,
            }));
        }
        scope.hits_without_packets(&others, self.footprint, &mut self.exact);
        // The rays of one surface are then shaded together.
        self.found.sort_unstable_by_key(|found| (found.candidate, found.packet));
    }

    /// Resolves the hits. Candidates with a map from gradients to normals in `maps`, which is indexed by candidate, go to
    /// the f32 surfaces if they can; all others become hits in f64.
    pub(super) fn resolve(
        &mut self,
        scope: &mut Scope<'_>,
        maps: &[Option<Columns>],
        visible: &mut VisibleSurfaces,
    ) {
        visible.start(scope.rays.directions().len());
        visible.hits.append(&mut self.exact);
        (visible.t_scale, visible.reach) = (scope.batch.t_scale, scope.batch.largest().length());
        self.clear_queues();
        for index in 0..self.found.len() {
            let found = self.found[index];
            self.resolve_lanes(scope, &found, map_of(maps, found.candidate), visible);
        }
        self.refine(scope, maps, visible);
        visible.drop_empty();
    }

    fn resolve_lanes(
        &mut self,
        scope: &mut Scope<'_>,
        found: &Found,
        map: Option<Columns>,
        visible: &mut VisibleSurfaces,
    ) {
        let Found { packet, candidate, lanes, near } = *found;
        let hits = &scope.batch.hits[packet];
        let surfaces = &mut visible.surfaces[packet];
        if let (Some(shape), Some(map)) = (&scope.candidates.get(candidate).packet_shape, &map) {
            scope.kernels.surfaces(shape, map, &scope.batch.directions[packet], hits, near, surfaces);
        }
        let remaining = lanes & !surfaces.lanes;
        if map.is_some() {
            visible.resolved.push(SurfaceLanes { packet, candidate, lanes });
        }
        for lane in bits(remaining) {
            let (hits, scale) = (&scope.batch.hits[packet], scope.batch.t_scale);
            let (t, error) = (f64::from(hits.t.0[lane]) * scale, f64::from(hits.error.0[lane]) * scale);
            self.queue(scope, packet * PACKET + lane, candidate, [t, error], visible);
        }
    }

    /// Removes the hits that wait for f64.
    fn clear_queues(&mut self) {
        self.refinement.clear();
        self.approximate.clear();
        self.verification.clear();
        self.isolated.clear();
    }

    /// Moves the surfaces of some lanes to the hits in f64.
    pub(super) fn move_to_hits(
        &mut self,
        scope: &mut Scope<'_>,
        moved: &[SurfaceLanes],
        visible: &mut VisibleSurfaces,
    ) {
        self.clear_queues();
        for &SurfaceLanes { packet, candidate, lanes } in moved {
            for lane in bits(lanes & visible.surfaces[packet].lanes) {
                let (surfaces, scale) = (&visible.surfaces[packet], visible.t_scale);
                let (t, error) =
                    (f64::from(surfaces.t.0[lane]) * scale, f64::from(surfaces.error.0[lane]) * scale);
                self.queue(scope, packet * PACKET + lane, candidate, [t, error], visible);
            }
            visible.surfaces[packet].lanes &= !lanes;
        }
        self.refine(scope, &[], visible);
        visible.drop_empty();
    }

    /// Queues an approximate hit, or finds it at once where hits of its candidate are neither refined nor verified together.
    fn queue(
        &mut self,
        scope: &mut Scope<'_>,
        ray: usize,
        candidate: u32,
        [t, error]: [f64; 2],
        visible: &mut VisibleSurfaces,
    ) {
        let Candidate { unit_from_world, refined, target, .. } = scope.candidates.get(candidate);
        let approximate = Approximate { ray: ray as u32, candidate, t, error };
        let Some(RefinedShape { origin, powers }) = *refined else {
            let shape = unit_shape(scope.scene, *target);
            if shape.is_convex() {
                visible.hits.extend(scope.hit_on(&approximate, self.footprint));
            } else {
                // The search in f64 found this crossing, and t was rounded to f32.
                let between = Some([t - 2.0 * error, t + 2.0 * error]);
                let local = scope.rays.ray(ray).through(unit_from_world);
                let known = KnownCrossing { clear_from: 0.0, between };
                self.verification.push(&shape, &local, RayStart::Free, &known);
                self.isolated.push(approximate);
            }
            return;
        };
        let direction = unit_from_world.matrix3 * scope.rays.direction(ray);
        self.refinement.push(&RefineRay { origin, direction, t, powers });
        self.approximate.push(approximate);
    }

    /// Verifies and refines the approximate hits in f64.
    fn refine(&mut self, scope: &mut Scope<'_>, maps: &[Option<Columns>], visible: &mut VisibleSurfaces) {
        self.verification.run();
        for (index, approximate) in self.isolated.iter().enumerate() {
            let Approximate { ray, candidate, .. } = *approximate;
            let verified = self.verification.get(index).flatten().map(|(hit, gradient)| {
                let gradient =
                    gradient.unwrap_or_else(|| scope.candidates.gradient(scope.scene, candidate, hit.point));
                let ShapeHit { t, leaving, point: unit_point } = hit;
                (ray, CandidateHit { t, candidate, unit_point, gradient, leaving })
            });
            visible.hits.extend(verified.or_else(|| scope.hit_on(approximate, self.footprint)));
        }
        self.refinement.run();
        for (index, &Approximate { ray, candidate, t, error }) in self.approximate.iter().enumerate() {
            // If the refined t is outside the error bound, another shape may be closer.
            let refined = self.refinement.get(index).filter(|(hit, _)| (hit.t - t).abs() <= error);
            let Some((hit, gradient)) = refined else {
                visible.hits.extend(scope.hit_in_f64(ray as usize, self.footprint));
                continue;
            };
            let unit_point = hit.point;
            let hit = CandidateHit { t: hit.t, candidate, unit_point, gradient, leaving: false };
            let map = map_of(maps, candidate);
            if !map.is_some_and(|map| visible.store(ray, &hit, map, self.width)) {
                visible.hits.push((ray, hit));
            }
        }
    }
}

fn map_of(maps: &[Option<Columns>], candidate: u32) -> Option<Columns> {
    maps.get(candidate as usize).copied().flatten()
}

impl Scope<'_> {
    /// The hit of a ray on a candidate, in f64; if it is none after all, its closest hit.
    fn hit_on(&mut self, approximate: &Approximate, footprint: Footprint) -> Option<(u32, CandidateHit)> {
        let Approximate { ray, candidate, .. } = *approximate;
        let in_world = self.rays.ray(ray as usize);
        let hit = self.candidates.intersect(self.scene, &in_world, candidate).map(|hit| (ray, hit));
        hit.or_else(|| self.hit_in_f64(ray as usize, footprint))
    }

    /// Adds the closest hits of rays without packets.
    fn hits_without_packets(
        &mut self,
        rays: &[usize],
        footprint: Footprint,
        hits: &mut Vec<(u32, CandidateHit)>,
    ) {
        if rays.len() < LEAST_STREAM || self.is_widened {
            hits.extend(rays.iter().filter_map(|&ray| self.hit_in_f64(ray, footprint)));
            return;
        }
        let traced: Vec<TraceRay> =
            rays.iter().map(|&ray| TraceRay::new(self.rays.ray(ray)).with_footprint(footprint)).collect();
        let found = self.scene.intersect_many_counted(&traced, self.coarsened);
        for (&ray, hit) in rays.iter().zip(found) {
            hits.extend(hit.map(|hit| (ray as u32, self.candidates.adopt(self.scene, &hit))));
        }
    }

    /// The closest hit of a ray by the scalar traversal.
    fn hit_in_f64(&mut self, ray: usize, footprint: Footprint) -> Option<(u32, CandidateHit)> {
        let traced = TraceRay::new(self.rays.ray(ray)).with_footprint(footprint);
        let hit = self.scene.intersect_counted(&traced, self.is_widened, self.coarsened)?;
        Some((ray as u32, self.candidates.adopt(self.scene, &hit)))
    }
}
