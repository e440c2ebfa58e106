//! The traversal of the graph by packets.
//!
//! A node's boxes are tested for each packet that has hit the node's parent; a packet goes on while any of its rays hits.

use superegg_geom::glam::DAffine3;
use superegg_geom::kernels::packet::{NodeBoxes, PACKET, PacketHits};

use super::candidates::TestShape;
use super::frame::{Entry, Frame, InverseStack};
use super::query::{PacketQuery, Tests};
use crate::ray::footprint::Footprint;
use crate::ray::lottery::Lottery;
use crate::scene::compiled::CompiledScene;
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
    inverses: InverseStack,
}

/// A query on its way through the graph.
pub(super) struct Traversal<'t, 's, Q> {
    pub(super) scene: &'s CompiledScene,
    pub(super) tests: &'t mut Tests,
    pub(super) stacks: &'t mut Stacks,
    pub(super) query: &'t mut Q,
    pub(super) footprint: Footprint,
}

impl<'s, Q: PacketQuery> Traversal<'_, 's, Q> {
    /// Traces the rays of the batch through the scene.
    pub(super) fn run(&mut self) {
        let Some(group) = self.scene.root.as_deref() else { return };
        let mask = self.tests.batch.active(u32::MAX);
        if self.tests.batch.origin.is_finite() && mask != 0 {
            let root = Entry { group, path: None, group_from_world: DAffine3::IDENTITY, stretch: 1.0 };
            self.visit_group(root, mask);
        }
    }

    fn visit_group(&mut self, entry: Entry<'s>, mask: u32) {
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
                    let primitive = frame.group.leaves[index as usize].primitive;
                    let shape = self.scene.primitives[primitive as usize].unit_shape();
                    self.test(&frame, &frame.leaf(index, shape), mask);
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

    /// Tests the boxes of a node.
    fn visit_node(&mut self, frame: &Frame<'s>, node: u32, mask: u32) {
        let node = &frame.group.nodes[node as usize];
        let Stacks { pending, inverses } = &mut *self.stacks;
        let Tests { kernels, batch, .. } = &*self.tests;
        // The kernel of a shape tests the shape's own box anyway, so for leaves the packet's interval is enough. A shadow
        // ray ends before it reaches most leaves.
        let roughly = if Q::IS_ORDERED { node.leaves() } else { 0 };
        let boxes = NodeBoxes {
            intervals_only: roughly,
            bounds: &node.bounds,
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
                (node.bounds[axis][child] * d).min(node.bounds[axis + 3][child] * d)
            };
            let near = if Q::IS_ORDERED { corner(0) + corner(1) + corner(2) } else { 0.0 };
            pending.push(Pending { slot, mask: hit[child], near });
        }
        if Q::IS_ORDERED {
            pending[first..].sort_unstable_by(|a, b| b.near.total_cmp(&a.near));
        }
    }

    /// Tests the proxy of a child for the rays that hit it by the lottery. The other rays are made inactive meanwhile.
    fn visit_proxy(&mut self, frame: &Frame<'s>, index: u32, mask: u32) {
        let instance = &frame.group.instances[index as usize];
        let proxy = instance.group.proxy(&self.scene.primitives);
        let tested = frame.proxy(index, instance, proxy);
        let Tests { batch, candidates, .. } = &mut *self.tests;
        let path = candidates.paths.push(frame.path, tested.index);
        let path = candidates.paths.instance_path(path);
        let before: Vec<(usize, PacketHits)> =
            bits(mask).map(|packet| (packet, batch.hits[packet])).collect();
        for (packet, hits) in &before {
            for lane in 0..PACKET {
                let draws = || {
                    let ray = self.query.ray(packet * PACKET + lane)?;
                    Some(Lottery::of_scaled(ray.direction).hits(path.indices(), proxy.opacity))
                };
                if hits.t.0[lane] <= 0.0 || draws() != Some(true) {
                    batch.hits[*packet].t.0[lane] = -1.0;
                }
            }
        }
        self.test(frame, &tested, mask);
        let batch = &mut self.tests.batch;
        for (packet, hits) in before {
            let resolved = self.query.resolved(packet);
            for lane in 0..PACKET {
                if batch.hits[packet].t.0[lane] < 0.0 && resolved >> lane & 1 == 0 {
                    batch.hits[packet].t.0[lane] = hits.t.0[lane];
                }
            }
            batch.ends.0[packet] = batch.hits[packet].end();
        }
    }

    fn test(&mut self, frame: &Frame<'s>, tested: &TestShape, mask: u32) {
        if tested.unit_from_world.is_finite() {
            let packet_shape = frame.packet_shape(&self.tests.batch, tested);
            self.query.test(self.tests, frame, tested, packet_shape.as_ref(), mask);
        }
    }
}
