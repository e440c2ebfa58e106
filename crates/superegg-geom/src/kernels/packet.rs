//! Packets: rays with a common origin, 16 to a packet and up to 32 packets at once, against boxes and convex shapes.
//!
//! Packet traversal with interval culling (Wald 2001, Boulos 2007): [`PacketKernels::intersect_boxes`] tests a node's boxes
//! against an interval of reciprocal directions of each packet first, and against each ray of the packet only where the
//! interval hits. [`PacketKernels::intersect`] searches the rays that hit a shape's box, after they are compacted
//! ([`LaneCompactor`]).
//!
//! Directions and maps are rounded to f32, so a shape is searched at the level N = 1 + tolerance. A hit is a
//! candidate with a bound on its error; no shape is missed.

#![allow(clippy::needless_range_loop, reason = "plain loops become lanes")]

mod boxes;
mod candidates;
mod compact;
mod directions;
mod hits;
mod intersect;
mod occlude;
mod rays;
mod shape;
mod surface;

use superegg_simd::Arch;

pub use boxes::{NodeBoxes, PacketIntervals};
pub use candidates::{ConeWidth, PacketCandidates, RANGE};
pub use compact::LaneCompactor;
pub use directions::{DirectionBoxes, DirectionRange};
pub use hits::{Occlusion, PacketHits, PacketSurfaces};
pub use intersect::PacketBatch;
pub use rays::{ALL_LANES, MAX_PACKETS, PACKET, PacketColumn, PacketVectors, PacketVectors64, PerPacket};
pub use shape::PacketShape;

use self::boxes::{BoxKernel, IntervalKernel};
use self::candidates::CandidateKernel;
use self::directions::{ResetKernel, ScaleKernel};
use self::intersect::IntersectKernel;
use self::occlude::OccludeKernel;
use self::surface::SurfaceKernel;

/// The kernels, for the lanes of this machine.
#[derive(Clone, Copy, Debug)]
pub struct PacketKernels(Arch);

impl Default for PacketKernels {
    fn default() -> Self {
        Self(Arch::new())
    }
}

impl PacketKernels {
    /// The packets that may hit each box before their ends, as masks: bit i of an answer stands for packet i. `ends` has the
    /// largest t of each packet, `mask` the packets to test.
    pub fn intersect_boxes(
        self,
        boxes: &NodeBoxes<'_>,
        intervals: &PacketIntervals,
        ends: &PerPacket,
        mask: u32,
    ) -> [u32; 8] {
        self.0.dispatch(BoxKernel { boxes, intervals, ends, mask })
    }

    /// Intersects the packets of `mask` with one shape, as candidate `id`, and updates the hits and ends of the batch.
    /// Returns the packets in which the candidate became the closest of some ray.
    pub fn intersect(self, shape: &PacketShape, batch: PacketBatch<'_>, mask: u32, id: u32) -> u32 {
        self.0.dispatch(IntersectKernel { shape, batch, mask, id })
    }

    /// Which rays of the packets in `mask` cross the shape before their ends, which are the t in `hits`.
    pub fn occluded(
        self,
        shape: &PacketShape,
        directions: &[PacketVectors],
        hits: &[PacketHits],
        compactor: &mut LaneCompactor,
        mask: u32,
    ) -> Occlusion {
        self.0.dispatch(OccludeKernel { shape, directions, hits, compactor, mask })
    }

    /// The candidates of a packet, by lanes; only for the lanes in `active`. The answer marks the lanes whose error is below
    /// `width` at their t.
    pub fn candidates(self, hits: &PacketHits, active: u32, width: ConeWidth) -> PacketCandidates {
        self.0.dispatch(CandidateKernel { hits, active, width })
    }

    /// Scales directions by a power of two and rounds them to f32. The range that is returned leaves NaN aside. `None` where
    /// all directions are zero, or some is infinite.
    pub fn scale_directions(
        self,
        directions: &[PacketVectors64],
        scaled: &mut Vec<PacketVectors>,
    ) -> Option<DirectionRange> {
        self.0.dispatch(ScaleKernel { directions, scaled })
    }

    /// The surface of one shape at the hits of a packet, for the lanes in `lanes`. `normal_map` has the columns of the linear
    /// map from gradients in the shape's space to normals, of any length, in the packet's. Adds the lanes that f32 resolves
    /// to `surfaces`.
    pub fn surfaces(
        self,
        shape: &PacketShape,
        normal_map: &[[f32; 3]; 3],
        directions: &PacketVectors,
        hits: &PacketHits,
        lanes: u32,
        surfaces: &mut PacketSurfaces,
    ) {
        self.0.dispatch(SurfaceKernel { shape, normal_map, directions, hits, lanes, surfaces });
    }

    /// Resets the hits: nothing is found yet, and nothing beyond `t_max` counts. Invalid directions (zero, NaN, or too large
    /// for f32) are replaced by a valid one of their packet, and get the t -1, an empty interval. A packet without a valid
    /// direction gets the end -1. Returns the boxes around the directions of the others.
    pub fn reset(
        self,
        directions: &mut [PacketVectors],
        hits: &mut [PacketHits],
        ends: &mut PerPacket,
        t_max: f32,
    ) -> DirectionBoxes {
        self.0.dispatch(ResetKernel { directions, hits, ends, t_max })
    }

    /// The intervals of the packets in `mask` in the space of a tree, by the linear map into it. Writes the reciprocals of
    /// all directions in that space to `inverses`.
    pub fn intervals(
        self,
        columns: &[[f32; 3]; 3],
        directions: &[PacketVectors],
        direction_boxes: &DirectionBoxes,
        mask: u32,
        inverses: &mut [PacketVectors],
    ) -> PacketIntervals {
        self.0.dispatch(IntervalKernel { columns, directions, direction_boxes, mask, inverses })
    }
}

#[cfg(test)]
mod tests {
    use superegg_simd::{Column, Scalar, WithSimd};

    use super::boxes::ENDLESS;
    use super::*;
    use crate::superquadric::Superquadric;

    /// Numbers that are the same on every run, in [0, 1).
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        }
    }

    #[test]
    fn kernels_agree_with_one_lane_and_with_many() {
        let mut next = numbers();
        for round in 0..50 {
            let mut hits = PacketHits::up_to(f32::INFINITY);
            for lane in 0..PACKET {
                if next() < 0.8 {
                    hits.t.0[lane] = 10.0 * next();
                    hits.error.0[lane] = 0.01 * next();
                    hits.id.0[lane] = (4.0 * next()) as u32;
                    hits.unresolved |= u32::from(next() < 0.2) << lane;
                }
            }
            let width = ConeWidth { width: 0.001, spread: 0.0008 };
            let active = if round % 2 == 0 { 0xffff } else { 0x3a7c };
            let one = CandidateKernel { hits: &hits, active, width }.with_simd(Scalar);
            let many = PacketKernels::default().candidates(&hits, active, width);
            let columns = |all: &PacketCandidates| {
                (all.unresolved, all.near, all.ids[..all.count].to_vec(), all.lanes[..all.count].to_vec())
            };
            assert_eq!(columns(&one), columns(&many));
            assert_eq!(one.lanes.iter().fold(one.unresolved, |all, lanes| all | lanes) & !active, 0);

            let strange = [0.0, -0.0, f64::NAN, 1e-300, 5e-324, -1.0];
            let mut vector = || {
                let mut column = || {
                    Column(std::array::from_fn(|_| {
                        let x = next();
                        if x < 0.2 { strange[(30.0 * x) as usize] } else { f64::from(next()) - 0.4 }
                    }))
                };
                [column(), column(), column()]
            };
            let directions = [vector(), vector(), vector()];
            let (mut of_one, mut of_many) = (Vec::new(), Vec::new());
            let one = ScaleKernel { directions: &directions, scaled: &mut of_one }.with_simd(Scalar);
            let many = PacketKernels::default().scale_directions(&directions, &mut of_many);
            assert_eq!(format!("{one:?} {of_one:?}"), format!("{many:?} {of_many:?}"));
            let (mut hits, mut ends) = ([hits; 3], PerPacket::splat(7.0));
            let (mut more_hits, mut more_ends) = (hits, ends);
            let one = ResetKernel { directions: &mut of_one, hits: &mut hits, ends: &mut ends, t_max: 3.0 }
                .with_simd(Scalar);
            let many = PacketKernels::default().reset(&mut of_many, &mut more_hits, &mut more_ends, 3.0);
            let seen = |directions: &[PacketVectors], hits: &[PacketHits; 3], ends, boxes| {
                format!("{directions:?} {hits:?} {ends:?} {boxes:?}")
            };
            assert_eq!(seen(&of_one, &hits, ends, one), seen(&of_many, &more_hits, more_ends, many));
            let has_ray = hits.iter().flat_map(|hits| hits.t.0).filter(|t| *t > 0.0).count();
            assert!(has_ray > 10 && of_one.iter().flatten().flat_map(|column| column.0).all(f32::is_finite));
        }
    }

    #[test]
    fn whole_batches_agree_with_one_lane_and_with_many() {
        let mut next = numbers();
        let (mut hits_found, mut stopped) = (0, 0);
        for e in [0.0001, 0.3, 1.0, 2.0] {
            let exponents = crate::Exponents::new(e, 0.7).unwrap();
            let one: [[f32; 3]; 3] =
                std::array::from_fn(|i| std::array::from_fn(|j| f32::from(u8::from(i == j))));
            let shape = PacketShape::new(
                &Superquadric::unit(exponents).as_convex().unwrap(),
                one,
                [0.3, -0.2, 9.0],
                2e-6,
                1.0,
            );
            let directions: Vec<PacketVectors> = (0..MAX_PACKETS)
                .map(|_| {
                    let mut side = || Column(std::array::from_fn(|_| 0.3 * next() - 0.15));
                    [side(), side(), PacketColumn::splat(-1.0)]
                })
                .collect();
            let (mut of_one, mut of_many) = (vec![PacketHits::up_to(30.0); MAX_PACKETS], Vec::new());
            of_many.clone_from(&of_one);
            let (mut ends, mut more_ends) = (PerPacket::splat(30.0), PerPacket::splat(30.0));
            let (shape, directions, mask, id) = (&shape, directions.as_slice(), u32::MAX, 5);
            let mut compactor = LaneCompactor::default();
            let stops = [
                OccludeKernel { shape, directions, hits: &of_one, compactor: &mut compactor, mask }
                    .with_simd(Scalar),
                PacketKernels::default().occluded(shape, directions, &of_one, &mut compactor, mask),
            ];
            let batch = PacketBatch {
                directions,
                hits: of_one.as_mut_slice(),
                ends: &mut ends,
                compactor: &mut compactor,
            };
            let closer = IntersectKernel { shape, batch, mask, id }.with_simd(Scalar);
            let batch = PacketBatch {
                directions,
                hits: &mut of_many,
                ends: &mut more_ends,
                compactor: &mut compactor,
            };
            let more_closer = PacketKernels::default().intersect(shape, batch, mask, id);
            assert_eq!(closer, more_closer);
            for (packet, (one, many)) in of_one.iter().zip(&of_many).enumerate() {
                assert!((ends.0[packet] - more_ends.0[packet]).abs() < 1e-3);
                assert_eq!(ends.0[packet], one.end());
                for lane in 0..PACKET {
                    assert_eq!(one.id.0[lane], many.id.0[lane]);
                    let off = (one.t.0[lane] - many.t.0[lane]).abs();
                    assert!(off <= one.error.0[lane] + many.error.0[lane]);
                    hits_found += u32::from(one.id.0[lane] == id);
                    let seen = stops.each_ref().map(|stop| {
                        let is = |lanes: &[u32; MAX_PACKETS]| {
                            stop.packets >> packet & 1 == 1 && lanes[packet] >> lane & 1 == 1
                        };
                        (is(&stop.hit), is(&stop.unresolved))
                    });
                    let [(hit, doubt), (more_hit, more_doubt)] = seen;
                    assert!(hit == more_hit || doubt || more_doubt);
                    assert!(one.id.0[lane] != id || hit || doubt);
                    stopped += u32::from(hit);
                }
            }
        }
        assert!(hits_found > 800 && stopped > 800 && hits_found < 2_000, "{hits_found} {stopped}");
    }

    #[test]
    fn intervals_contain_the_reciprocals_of_their_rays_and_are_little_wider() {
        let mut next = numbers();
        let (mut seen, mut missed) = (0, 0);
        for round in 0..200 {
            // Packets from narrow ones to such as look to all sides, along an axis now and then.
            let width = [1e-6, 1e-3, 0.1, 3.0][round % 4];
            let mut packet = || {
                let middle = [next() - 0.5, next() - 0.5, if next() < 0.3 { 0.0 } else { next() }];
                middle.map(|x| Column(std::array::from_fn(|_| x + width * (next() - 0.5))))
            };
            let mut directions = [packet(), packet(), packet()];
            let columns: [[f32; 3]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| 30.0 * next() - 15.0));
            let mut hits = [PacketHits::up_to(1.0); 3];
            let mut ends = PerPacket::splat(0.0);
            let boxes = PacketKernels::default().reset(&mut directions, &mut hits, &mut ends, 1.0);
            let mut inverses = [[PacketColumn::splat(0.0); 3]; 3];
            let intervals =
                PacketKernels::default().intervals(&columns, &directions, &boxes, 0b111, &mut inverses);
            for (packet, inverses) in inverses.iter().enumerate() {
                for (axis, inverses) in inverses.iter().enumerate() {
                    let (least, largest) =
                        (intervals.least[axis].0[packet], intervals.largest[axis].0[packet]);
                    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
                    for inverse in inverses.0 {
                        assert!(least <= inverse && inverse <= largest, "{least} {inverse} {largest}");
                        (low, high) = (low.min(inverse), high.max(inverse));
                    }
                    let is_narrow = largest.abs().max(least.abs()) < ENDLESS && width < 0.01;
                    seen += u32::from(is_narrow);
                    missed +=
                        u32::from(is_narrow && largest - least > 4.0 * (high - low) + 1e-4 * high.abs());
                }
            }
        }
        assert!(seen > 600 && missed < seen / 50, "{missed} of {seen}");
    }
}
