//! The traversal of the graph by packets.
//!
//! A node's boxes are tested for each packet that has hit the node's parent; a packet goes on while any of its rays hits.

use arrayvec::ArrayVec;
use superegg_geom::glam::DAffine3;
use superegg_geom::kernels::packet::{MAX_PACKETS, NodeBoxes, PACKET, PacketColumn};

use super::candidates::TestShape;
use super::frame::{BeyondKernels, Entry, Frame, InverseStack};
use super::query::{PacketQuery, Tests};
use crate::ray::footprint::Footprint;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::Leaf;
use crate::scene::node::Slot;
use superegg_simd::bits;

/// A child that packets have still to visit.
#[derive(Clone, Copy, Debug)]
struct Pending {
    slot: Slot,
    /// The packets.
    mask: u32,
    /// The distance of its nearest corner along the middle direction.
    near: f32,
}

/// The stacks of a traversal, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct Stacks {
    /// The children of open groups that are still to be visited.
    pending: Vec<Pending>,
    pub(super) inverses: InverseStack,
}

/// A query on its way through the graph.
pub(super) struct Traversal<'t, 's, Q> {
    pub(super) scene: &'s CompiledScene,
    pub(super) tests: &'t mut Tests,
    pub(super) stacks: &'t mut Stacks,
    pub(super) query: &'t mut Q,
    pub(super) footprint: Footprint,
    pub(super) limits: PacketLimits,
    pub(super) work: Work,
}

/// The bounds on the work for one trace.
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketLimits {
    /// After this many groups the traversal begins again in order. Two tests of folded leaves count as a group.
    pub(super) most_opened: u32,
    /// The most work in order for each width of the rays, in the units of `in_order`.
    pub(super) work: u32,
}

impl Default for PacketLimits {
    fn default() -> Self {
        Self { most_opened: 3 << 10, work: 8 << 10 }
    }
}

/// A packet tested in f64 takes as long as opening so many groups.
const GROUPS_IN_F64: u32 = 4;

/// Streams take the rays if so many packets were tested in f64 because their origin is too far from a shape, and most of the
/// tests were of this kind.
const MOST_TOO_FAR: u32 = 64;

/// The work of one trace.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Work {
    /// The number of groups opened so far.
    pub(super) opened: u32,
    /// The number of tests of leaves of folded groups so far.
    folded_leaves: u32,
    /// The number of packets whose rays were tested in f64, one by one, because f32 kernels cannot test a shape.
    pub(super) packets_in_f64: u32,
    /// The number of those whose origin is too far from the shape.
    too_far: u32,
    /// The number of tests, each of a shape for one packet.
    tested: u32,
    /// Whether groups were left out because of the work.
    is_cut: bool,
    /// How often the width of the rays was doubled to bound the work.
    pub(super) doublings: u32,
    /// The packets of which some group was hit as its proxy to bound the work.
    pub(super) coarsened: u32,
}

impl<'s, Q: PacketQuery> Traversal<'_, 's, Q> {
    /// Traces the rays of the batch through the scene.
    pub(super) fn run(&mut self) {
        let Some(group) = self.scene.root.as_deref() else { return };
        let mask = self.tests.batch.active(u32::MAX);
        if self.tests.batch.origin.is_finite() && mask != 0 {
            let root = Entry { group, path: None, group_from_world: DAffine3::IDENTITY, stretch: 1.0 };
            self.visit_group(root, mask);
            if self.is_too_far() {
                self.query.restart(self.tests);
                let mask = self.tests.batch.active(u32::MAX);
                self.tests.batch.leave_to_f64(mask);
            } else if self.work.is_cut {
                let mask = self.tests.batch.active(u32::MAX);
                self.run_in_order(root, mask);
            }
            self.stacks.inverses.open = 0;
        }
    }

    /// Whether streams take the rays.
    fn is_too_far(&self) -> bool {
        let Work { too_far, tested, .. } = self.work;
        too_far > MOST_TOO_FAR && 2 * too_far > tested
    }

    /// Whether the traversal begins again in order.
    fn gives_up(&self) -> bool {
        let Work { opened, folded_leaves, packets_in_f64, .. } = self.work;
        opened + folded_leaves / 2 + GROUPS_IN_F64 * packets_in_f64 > self.limits.most_opened
    }

    fn visit_group(&mut self, entry: Entry<'s>, mask: u32) {
        self.work.opened += 1;
        if self.gives_up() {
            self.work.is_cut = true;
            self.stacks.pending.clear();
            return;
        }
        let Tests { kernels, batch, .. } = &mut *self.tests;
        let Some(frame) = Frame::open(*kernels, batch, &mut self.stacks.inverses, entry, mask) else {
            batch.leave_to_f64(mask);
            return;
        };
        let bottom = self.stacks.pending.len();
        self.stacks.pending.push(Pending { slot: Slot::Node(0), mask, near: 0.0 });
        while self.stacks.pending.len() > bottom {
            let Some(Pending { slot, mask, .. }) = self.stacks.pending.pop() else { return };
            let mask = self.tests.batch.active(mask);
            if mask == 0 {
                continue;
            }
            match slot {
                Slot::Node(node) => self.visit_node(&frame, node, mask),
                Slot::Leaf(index) => {
                    self.visit_leaf(&frame, index, mask);
                    if self.is_too_far() {
                        self.stacks.pending.clear();
                    }
                }
                Slot::Instance(index) => {
                    let instance = &frame.group.instances[index as usize];
                    if self.query.hides(&frame, instance, self.footprint) {
                        self.visit_proxy(&frame, index, mask);
                        continue;
                    }
                    let entry = Entry {
                        group: &instance.group,
                        path: self.tests.candidates.paths.push(frame.path, index),
                        group_from_world: *instance.map().inverse() * frame.group_from_world,
                        stretch: frame.stretch * instance.stretch,
                    };
                    self.visit_group(entry, mask);
                }
            }
        }
        self.stacks.inverses.open = frame.first_inverse;
    }

    pub(super) fn visit_leaf(&mut self, frame: &Frame<'s>, index: u32, mask: u32) {
        let Leaf { primitive, name, .. } = frame.group.leaves[index as usize];
        self.work.folded_leaves += u32::from(frame.group.was_in_group(name));
        let shape = self.scene.primitives.unit_shape(primitive);
        self.test(frame, &frame.leaf(index, shape), mask);
    }

    /// Tests the boxes of a node.
    fn visit_node(&mut self, frame: &Frame<'s>, node: u32, mask: u32) {
        let node = &frame.group.nodes[node as usize];
        let Stacks { pending, inverses } = &mut *self.stacks;
        let Tests { kernels, batch, .. } = &*self.tests;
        // The kernel of a shape tests the shape's own box anyway, so for leaves the packet's interval is enough. A shadow
        // ray ends before it reaches most leaves.
        let roughly = if Q::IS_ORDERED { node.leaves } else { 0 };
        let bounds = node.bounds();
        let boxes = NodeBoxes {
            intervals_only: roughly,
            bounds: &bounds,
            count: node.count as usize,
            origin: frame.tree_origin.as_vec3().to_array(),
            pad: frame.pad,
            t_scale: frame.t_scale,
            inverses: &inverses.inverses[frame.first_inverse..],
        };
        let hit = kernels.intersect_boxes(&boxes, &frame.intervals, &batch.ends, mask);
        let middle = frame.middle.as_vec3().to_array();
        let first = pending.len();
        for (child, slot) in node.slots().enumerate().filter(|(child, _)| hit[*child] != 0) {
            let corner = |axis: usize| {
                let d = middle[axis];
                (bounds[axis][child] * d).min(bounds[axis + 3][child] * d)
            };
            let near = if Q::IS_ORDERED { corner(0) + corner(1) + corner(2) } else { 0.0 };
            pending.push(Pending { slot, mask: hit[child], near });
        }
        if Q::IS_ORDERED {
            pending[first..].sort_unstable_by(|a, b| b.near.total_cmp(&a.near));
        }
    }

    /// Tests the proxy of a child for the rays that hit it by the lottery. The other rays are made inactive meanwhile.
    pub(super) fn visit_proxy(&mut self, frame: &Frame<'s>, index: u32, mask: u32) {
        let instance = &frame.group.instances[index as usize];
        let proxy = instance.group.proxy(&self.scene.primitives);
        let tested = frame.proxy(index, instance, proxy);
        // Proxies stop only rays from outside.
        if Q::IS_ORDERED && tested.origin.length_squared() <= 1.0 {
            return;
        }
        let Tests { batch, candidates, .. } = &mut *self.tests;
        if batch.lotteries.is_empty() {
            let rays = batch.hits.len() * PACKET;
            batch.lotteries.extend((0..rays).map(|ray| self.query.lottery(ray)));
        }
        let path = candidates.paths.hash(frame.path, tested.index);
        let mut drawn = 0;
        let mut before: ArrayVec<(usize, PacketColumn<f32>), MAX_PACKETS> = ArrayVec::new();
        for packet in bits(mask) {
            let t = batch.hits[packet].t;
            let lotteries = &batch.lotteries[packet * PACKET..][..PACKET];
            let column = &mut batch.hits[packet].t;
            for (lane, lottery) in lotteries.iter().enumerate() {
                let hits = lottery.is_some_and(|lottery| lottery.hits(path, proxy.opacity));
                if hits && t.0[lane] > 0.0 {
                    drawn |= 1 << packet;
                } else {
                    column.0[lane] = -1.0;
                }
            }
            before.push((packet, t));
        }
        self.test(frame, &tested, drawn);
        let batch = &mut self.tests.batch;
        for (packet, t) in before {
            let resolved = self.query.resolved(packet);
            let hits = &mut batch.hits[packet];
            for lane in 0..PACKET {
                if hits.t.0[lane] < 0.0 && resolved >> lane & 1 == 0 {
                    hits.t.0[lane] = t.0[lane];
                }
            }
            batch.ends.0[packet] = hits.end();
        }
    }

    fn test(&mut self, frame: &Frame<'s>, tested: &TestShape, mask: u32) {
        if tested.unit_from_world.is_finite() {
            let packet_shape = frame.packet_shape(&self.tests.batch, tested);
            self.work.tested += mask.count_ones();
            if let Err(why) = packet_shape {
                self.work.packets_in_f64 += mask.count_ones();
                let is_too_far = why == BeyondKernels::TooFar;
                self.work.too_far += if is_too_far { mask.count_ones() } else { 0 };
            }
            self.query.test(self.tests, frame, tested, packet_shape.as_ref().ok(), mask);
        }
    }
}
