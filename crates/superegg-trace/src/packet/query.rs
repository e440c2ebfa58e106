//! The two queries of packets: the closest hit, and any hit.

use arrayvec::ArrayVec;
use superegg_geom::kernels::packet::{
    ALL_LANES, LaneCompactor, MAX_PACKETS, PACKET, PacketBatch, PacketKernels, PacketShape, PerPacket,
};
use superegg_geom::kernels::stream::END;
use superegg_geom::{Ray, RayStart};

use super::batch::TracedPackets;
use super::candidates::{Candidates, TestShape};
use super::frame::Frame;
use super::isolation::{Isolation, LocalRay};
use super::rays::PacketRays;
use crate::ray::footprint::Footprint;
use crate::ray::lottery::Lottery;
use crate::scene::group::{Instance, Target};
use crate::scene::proxy::stops_light;
use superegg_simd::bits;

/// The input and output of the tests of shapes.
#[derive(Default)]
pub(super) struct Tests {
    pub(super) kernels: PacketKernels,
    pub(super) batch: TracedPackets,
    pub(super) candidates: Candidates,
    pub(super) compactor: LaneCompactor,
    pub(super) isolation: Isolation,
}

/// A query of packets.
pub(super) trait PacketQuery {
    /// Whether boxes are visited front to back. Otherwise in the order of memory.
    const IS_ORDERED: bool;

    /// The numbers that a ray of the query draws; `None` for an unused lane.
    fn lottery(&self, index: usize) -> Option<Lottery>;

    /// Whether all rays are so wide that a child is hit as its proxy.
    fn hides(&self, frame: &Frame<'_>, instance: &Instance, footprint: Footprint) -> bool;

    /// Tests a shape for the packets of a mask. `packet_shape` is the shape as the f32 kernels see it.
    fn test(
        &mut self,
        tests: &mut Tests,
        frame: &Frame<'_>,
        tested: &TestShape,
        packet_shape: Option<&PacketShape>,
        mask: u32,
    );

    /// Forgets the answers that a second traversal would find again.
    fn restart(&self, tests: &mut Tests);

    /// The occluded lanes of each packet, for a query that collects them.
    fn occluded(&mut self) -> Option<&mut Vec<u32>>;

    /// The lanes of a packet that have their answer.
    fn resolved(&self, packet: usize) -> u32;
}

/// The closest hit of each ray.
pub(super) struct Closest<'a> {
    pub(super) rays: &'a PacketRays,
}

impl PacketQuery for Closest<'_> {
    const IS_ORDERED: bool = true;

    fn lottery(&self, index: usize) -> Option<Lottery> {
        (index < self.rays.count()).then(|| Lottery::of_scaled(self.rays.direction(index)))
    }

    fn hides(&self, frame: &Frame<'_>, instance: &Instance, footprint: Footprint) -> bool {
        footprint != Footprint::NONE
            && footprint.hides(instance.size() * (frame.stretch * instance.stretch), frame.least_t(instance))
    }

    fn test(
        &mut self,
        tests: &mut Tests,
        frame: &Frame<'_>,
        tested: &TestShape,
        packet_shape: Option<&PacketShape>,
        mask: u32,
    ) {
        match packet_shape {
            Some(shape) if tested.shape.is_convex() => {
                let Tests { kernels, batch, candidates, compactor, .. } = tests;
                let TracedPackets { directions, hits, ends, .. } = batch;
                let packets = PacketBatch { directions, hits, ends, compactor };
                if kernels.intersect(shape, packets, mask, candidates.next()) != 0 {
                    candidates.push(frame.path, tested, batch.origin, Some(*shape));
                }
            }
            around => self.test_in_f64(tests, frame, tested, around, mask),
        }
    }

    fn restart(&self, tests: &mut Tests) {
        tests.batch.forget_hits(tests.kernels, f64::INFINITY);
    }

    fn occluded(&mut self) -> Option<&mut Vec<u32>> {
        None
    }

    fn resolved(&self, _: usize) -> u32 {
        0
    }
}

impl Closest<'_> {
    /// Tests each ray that may hit the shape, which is not convex, and computes its hit in f64. `around` is a convex shape around
    /// it.
    fn test_in_f64(
        &self,
        tests: &mut Tests,
        frame: &Frame<'_>,
        tested: &TestShape,
        around: Option<&PacketShape>,
        mask: u32,
    ) {
        let Tests { kernels, batch, candidates, compactor, isolation } = tests;
        let id = candidates.next();
        let mut rays = Vec::new();
        for packet in bits(mask) {
            let mut near = batch.hits[packet];
            if let Some(shape) = around {
                let packets = PacketBatch {
                    directions: &batch.directions[packet..=packet],
                    hits: std::slice::from_mut(&mut near),
                    ends: &mut PerPacket::splat(0.0),
                    compactor,
                };
                kernels.intersect(shape, packets, 1, id);
            }
            for lane in bits(self.rays.lanes(packet)) {
                let may_hit = around.is_none() || near.id.0[lane] == id || near.unresolved >> lane & 1 == 1;
                let t_max = batch.hits[packet].t.0[lane];
                if may_hit && t_max > 0.0 {
                    let ray = self.rays.ray(packet * PACKET + lane).through(&tested.unit_from_world);
                    let t_max = f64::from(t_max) * batch.t_scale * (1.0 + END);
                    rays.push(LocalRay { index: [packet, lane], ray, t_max });
                }
            }
        }
        let mut is_closest = false;
        isolation.intersect(&tested.shape, &rays, |[packet, lane], t| {
            let t = (t / batch.t_scale) as f32;
            batch.hits[packet].insert(lane, t, 1e-6 * t, id, false);
            is_closest |= batch.hits[packet].id.0[lane] == id;
        });
        for packet in bits(mask) {
            batch.ends.0[packet] = batch.hits[packet].end();
        }
        if is_closest {
            candidates.push(frame.path, tested, batch.origin, None);
        }
    }
}

/// The start of a shadow ray.
#[derive(Clone, Copy, Debug)]
pub struct ShadowStart {
    /// The candidate on whose surface the ray starts, if any.
    pub own: Option<u32>,
    /// The side to which it leaves.
    pub start: RayStart,
}

/// A shadow ray.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// From the surface to the light, which is at t = 1.
    pub ray: Ray,
    /// The width at the surface.
    pub width: f64,
}

/// Shadow rays to one light, by their lanes. Rays from neighbouring points of one surface should be neighbours.
#[derive(Clone, Copy)]
pub struct ShadowRays<'a> {
    /// The rays reversed: from the light to the surface, which is at t = 1.
    pub from_light: &'a PacketRays,
    /// The start of each ray.
    pub starts: &'a [ShadowStart],
    /// A ray by its index. Only few are requested.
    pub ray: &'a dyn Fn(usize) -> ShadowRay,
}

/// Whether each shadow ray is occluded.
pub(super) struct AnyHit<'a> {
    shadow: ShadowRays<'a>,
    /// The occluded lanes of each packet.
    pub(super) occluded: Vec<u32>,
    /// The candidate that all rays of a packet leave outwards, if there is one.
    packet_own: ArrayVec<Option<u32>, MAX_PACKETS>,
}

impl<'a> AnyHit<'a> {
    pub(super) fn new(shadow: ShadowRays<'a>) -> Self {
        let packet_own = shadow.starts.chunks(PACKET).map(|starts| {
            let own = starts[0].own;
            let is_own = |one: &ShadowStart| one.own == own && one.start == RayStart::SurfaceOutward;
            own.filter(|_| starts.iter().all(is_own))
        });
        Self {
            shadow,
            occluded: vec![0; shadow.from_light.directions().len()],
            packet_own: packet_own.collect(),
        }
    }
}

impl PacketQuery for AnyHit<'_> {
    const IS_ORDERED: bool = false;

    fn lottery(&self, index: usize) -> Option<Lottery> {
        (index < self.shadow.starts.len()).then(|| Lottery::of((self.shadow.ray)(index).ray.direction))
    }

    fn hides(&self, frame: &Frame<'_>, instance: &Instance, footprint: Footprint) -> bool {
        // The footprint is the least width of the rays, all along.
        footprint.hides(instance.size() * (frame.stretch * instance.stretch), 0.0)
    }

    fn test(
        &mut self,
        tests: &mut Tests,
        frame: &Frame<'_>,
        tested: &TestShape,
        packet_shape: Option<&PacketShape>,
        mask: u32,
    ) {
        let Tests { kernels, batch, candidates, compactor, .. } = tests;
        let hash = candidates.paths.hash(frame.path, tested.index);
        let is_own = |own: Option<u32>| {
            own.is_some_and(|own| candidates.is_same_path(own, hash, frame.path, tested.index))
        };
        // A ray that leaves a convex shape does not hit it again, and a proxy does not occlude itself.
        let is_free_outwards = tested.shape.is_convex() || tested.target == Target::Proxy;
        let mask = if is_free_outwards {
            bits(mask)
                .filter(|&packet| !is_own(self.packet_own[packet]))
                .fold(0, |mask, packet| mask | 1 << packet)
        } else {
            mask
        };
        let answer = packet_shape
            .map(|shape| kernels.occluded(shape, &batch.directions, &batch.hits, compactor, mask));
        for packet in bits(answer.as_ref().map_or(mask, |answer| answer.packets)) {
            let (hit, unresolved) = match &answer {
                // The kernels see only a convex shape around one that is not convex.
                Some(answer) if !tested.shape.is_convex() => {
                    (0, answer.hit[packet] | answer.unresolved[packet])
                }
                Some(answer) => (answer.hit[packet], answer.unresolved[packet]),
                None => (0, ALL_LANES),
            };
            let before = self.occluded[packet];
            for lane in bits(hit | unresolved) {
                let index = packet * PACKET + lane;
                let Some(&ShadowStart { own, start, .. }) = self.shadow.starts.get(index) else { continue };
                if batch.hits[packet].t.0[lane] <= 0.0 {
                    continue;
                }
                let is_own = is_own(own);
                let is_leaving = start == RayStart::SurfaceOutward && is_free_outwards;
                let is_occluded = if is_own && (is_leaving || tested.target == Target::Proxy) {
                    false
                } else if tested.target == Target::Proxy {
                    let local = (self.shadow.ray)(index).ray.through(&tested.unit_from_world);
                    let draw = self.lottery(index).map_or(1.0, |lottery| lottery.draw(hash));
                    stops_light(tested.opacity, &local, 1.0, draw)
                } else if is_own || unresolved >> lane & 1 == 1 {
                    let start = if is_own { start } else { RayStart::Free };
                    let local = (self.shadow.ray)(index).ray.through(&tested.unit_from_world);
                    tested.shape.occluded(&local, start, 1.0)
                } else {
                    true
                };
                if is_occluded {
                    self.occluded[packet] |= 1 << lane;
                    batch.hits[packet].t.0[lane] = -1.0;
                }
            }
            if self.occluded[packet] != before {
                batch.ends.0[packet] = batch.hits[packet].end();
            }
        }
    }

    fn restart(&self, _: &mut Tests) {}

    fn occluded(&mut self) -> Option<&mut Vec<u32>> {
        Some(&mut self.occluded)
    }

    fn resolved(&self, packet: usize) -> u32 {
        self.occluded[packet]
    }
}
