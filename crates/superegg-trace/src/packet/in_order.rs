//! Packets through groups that overlap: nearest first, with bounded work.
//!
//! A traversal that opens one group after the other takes time without end where the parts of a deep fractal overlap: each
//! ray is in the boxes of exponentially many groups. Here all groups wait in one queue, so that none is opened that lies
//! behind the hits of all its rays. If that is too much work still, the rays of the trace are widened: groups are hit as
//! their proxies at larger sizes. The width is the smallest power of two whose traversal is within
//! [`PacketLimits::work`], as far as that is found with about twice as much work.
//!
//! [`PacketLimits::work`]: super::traverse::PacketLimits

use std::collections::BinaryHeap;

use superegg_geom::kernels::packet::{NodeBoxes, PacketHits, PerPacket};

use super::frame::{Entry, Frame};
use super::query::{PacketQuery, Tests};
use super::traverse::Traversal;
use crate::ranked::Ranked;
use crate::scene::group::Instance;
use crate::scene::node::Slot;
use superegg_simd::bits;

/// The widths that are tried first are doubled so often.
const FIRST_DOUBLINGS: u32 = 6;
/// If these are too narrow, they are doubled so often more.
const MORE_DOUBLINGS: u32 = 3;
/// Rays that are doubled so often are wider than the scene.
const MOST_DOUBLINGS: u32 = 24;

/// The work of testing a packet against a shape in f64.
const WORK_IN_F64: u32 = 16;

/// A group that waits to be opened or hit as its proxy.
struct Waiting {
    /// A lower bound on the packets' t at which any ray reaches the group.
    least_t: f32,
    /// The packets that hit its box.
    mask: u32,
}

/// The groups of one traversal.
#[derive(Default)]
struct Queue<'s> {
    /// Ranked by the index of the parent among the entries, and that of the child in its parent: of equal ones the child of
    /// the group that was opened last is next.
    waiting: BinaryHeap<Ranked<(u32, u32), Waiting>>,
    /// The opened groups.
    entries: Vec<Entry<'s>>,
    nodes: Vec<(u32, u32)>,
    /// The work so far, in units of about an eighth of a microsecond, without tests in f64.
    work: u32,
    /// [`Work::packets_in_f64`](super::traverse::Work) at the beginning.
    packets_in_f64: u32,
    /// The packets of which a group was hit as its proxy because the rays are widened.
    coarsened: u32,
}

/// The result of a trace.
struct Answers {
    hits: Vec<PacketHits>,
    ends: PerPacket,
    unresolved: Vec<u32>,
    occluded: Option<Vec<u32>>,
}

/// A traversal that was within the limits.
struct Finished {
    doublings: u32,
    work: u32,
    coarsened: u32,
}

impl<'s, Q: PacketQuery> Traversal<'_, 's, Q> {
    /// Traces the packets of a mask through a group, in order and with bounded work.
    pub(super) fn run_in_order(&mut self, root: Entry<'s>, mask: u32) {
        self.query.restart(self.tests);
        let start = self.answers();
        let most_work = f64::from(self.limits.work);
        let mut doublings = FIRST_DOUBLINGS;
        let mut finished = loop {
            match self.pass(root, mask, doublings) {
                Some(finished) => break finished,
                None if doublings >= MOST_DOUBLINGS => {
                    // Only where the root itself has more children than the work allows.
                    self.work.coarsened = mask;
                    return;
                }
                None => doublings += MORE_DOUBLINGS,
            }
            self.restore(&start);
        };
        let mut growth = 2.0;
        while finished.doublings > 0 && growth * f64::from(finished.work) < most_work {
            let coarser = self.answers();
            self.restore(&start);
            let Some(finer) = self.pass(root, mask, finished.doublings - 1) else {
                self.restore(&coarser);
                break;
            };
            growth = (f64::from(finer.work) / f64::from(finished.work)).max(1.5);
            finished = finer;
        }
        self.work.coarsened |= finished.coarsened;
        self.work.doublings = finished.doublings;
    }

    fn answers(&mut self) -> Answers {
        let batch = &self.tests.batch;
        Answers {
            hits: batch.hits.clone(),
            ends: batch.ends,
            unresolved: batch.unresolved.clone(),
            occluded: self.query.occluded().cloned(),
        }
    }

    fn restore(&mut self, answers: &Answers) {
        let batch = &mut self.tests.batch;
        batch.hits.clone_from(&answers.hits);
        batch.ends = answers.ends;
        batch.unresolved.clone_from(&answers.unresolved);
        if let (Some(now), Some(before)) = (self.query.occluded(), &answers.occluded) {
            now.clone_from(before);
        }
    }

    /// A traversal with rays that are widened by doublings. `None` if it needs too much work.
    fn pass(&mut self, root: Entry<'s>, mask: u32, doublings: u32) -> Option<Finished> {
        let packets_in_f64 = self.work.packets_in_f64;
        let mut queue = Queue { packets_in_f64, ..Queue::default() };
        let first_candidate = self.tests.candidates.next();
        let scene_size = self.scene.size();
        let footprint = self.footprint.doubled(doublings, scene_size);
        self.open_in_order(&mut queue, root, mask);
        while let Some(Ranked { rank: (parent, index), item: next, .. }) = queue.waiting.pop() {
            let mask = self.reaching(&next);
            if mask == 0 {
                continue;
            }
            if self.work_of(&queue) > self.limits.work {
                self.tests.candidates.truncate(first_candidate);
                return None;
            }
            let parent = queue.entries[parent as usize];
            let instance = &parent.group.instances[index as usize];
            let size = instance.size() * (parent.stretch * instance.stretch);
            let least_t = f64::from(next.least_t);
            queue.work += 2 + mask.count_ones();
            if footprint.hides(size, least_t) {
                if !self.footprint.hides(size, least_t) {
                    queue.coarsened |= mask;
                }
                if let Some(frame) = self.frame_in_order(parent, mask) {
                    self.visit_proxy(&frame, index, mask);
                }
                continue;
            }
            let entry = self.child_entry(&parent, instance, index);
            self.open_in_order(&mut queue, entry, mask);
        }
        Some(Finished { doublings, work: self.work_of(&queue), coarsened: queue.coarsened })
    }

    fn work_of(&self, queue: &Queue<'s>) -> u32 {
        queue.work + WORK_IN_F64 * (self.work.packets_in_f64 - queue.packets_in_f64)
    }

    fn child_entry(&mut self, parent: &Entry<'s>, instance: &'s Instance, index: u32) -> Entry<'s> {
        Entry {
            group: &instance.group,
            path: self.tests.candidates.paths.push(parent.path, index),
            group_from_world: *instance.map().inverse() * parent.group_from_world,
            stretch: parent.stretch * instance.stretch,
        }
    }

    /// The active packets that may still hit a group.
    fn reaching(&self, waiting: &Waiting) -> u32 {
        let ends = &self.tests.batch.ends.0;
        let reaches = |packet: &usize| ends[*packet] > 0.0 && ends[*packet] >= waiting.least_t;
        bits(waiting.mask).filter(reaches).fold(0, |mask, packet| mask | 1 << packet)
    }

    fn frame_in_order(&mut self, entry: Entry<'s>, mask: u32) -> Option<Frame<'s>> {
        let Tests { kernels, batch, .. } = &mut *self.tests;
        self.stacks.inverses.open = 0;
        let frame = Frame::open(*kernels, batch, &mut self.stacks.inverses, entry, mask);
        if frame.is_none() {
            batch.leave_to_f64(mask);
        }
        frame
    }

    /// Tests the leaves of a group and queues its groups.
    fn open_in_order(&mut self, queue: &mut Queue<'s>, entry: Entry<'s>, mask: u32) {
        let Some(frame) = self.frame_in_order(entry, mask) else { return };
        let parent = queue.entries.len() as u32;
        queue.entries.push(entry);
        queue.nodes.push((0, mask));
        while let Some((node, mask)) = queue.nodes.pop() {
            let node = &frame.group.nodes[node as usize];
            let bounds = node.bounds();
            let boxes = NodeBoxes {
                intervals_only: if Q::IS_ORDERED { node.leaves } else { 0 },
                bounds: &bounds,
                count: node.count as usize,
                origin: frame.tree_origin.as_vec3().to_array(),
                pad: frame.pad,
                t_scale: frame.t_scale,
                inverses: &self.stacks.inverses.inverses,
            };
            queue.work += 1;
            let Tests { kernels, batch, .. } = &*self.tests;
            let hit = kernels.intersect_boxes(&boxes, &frame.intervals, &batch.ends, mask);
            for (child, slot) in node.slots().enumerate().filter(|(child, _)| hit[*child] != 0) {
                let mask = hit[child];
                match slot {
                    Slot::Node(node) => queue.nodes.push((node, mask)),
                    Slot::Leaf(_) => {}
                    Slot::Instance(index) => {
                        let [least_t, far] = frame.intervals.range(&boxes, child, mask);
                        // Shadow rays end at their surfaces. Most are stopped near them.
                        let priority = if Q::IS_ORDERED { -least_t } else { far.min(self.farthest(mask)) };
                        let (rank, item) = ((parent, index), Waiting { least_t, mask });
                        queue.work += 1;
                        queue.waiting.push(Ranked { priority: f64::from(priority), rank, item });
                    }
                }
            }
            for (child, slot) in node.slots().enumerate().filter(|(child, _)| hit[*child] != 0) {
                if let Slot::Leaf(index) = slot {
                    queue.work += 1 + hit[child].count_ones();
                    self.visit_leaf(&frame, index, hit[child]);
                }
            }
        }
    }

    /// The largest t that counts for any packet of a mask.
    fn farthest(&self, mask: u32) -> f32 {
        bits(mask).map(|packet| self.tests.batch.ends.0[packet]).fold(0.0, f32::max)
    }
}
