//! The traversal of the graph by a stream.

use std::cell::Cell;

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::kernels::stream::{BoxRay, ListedRay, NodeEntries, STREAM_LANES, intersect_boxes};
use superegg_geom::{Ray, RayStart, scale_to_unit};
use superegg_simd::{Arch, Simd, WithSimd};

use super::leaves::LeafQueues;
use super::lists::{List, ListMemory, positions_along};
use super::table::{DONE, LeafState, NO_LEAF, Outcome, Query, RayLeafPair, RayTable, TestedShape, TrailId};
use crate::ray::footprint::Footprint;
use crate::ray::lottery::{Lottery, PathHash};
use crate::ray::query::TraceRay;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::Group;
use crate::scene::node::{PackedSlot, Slot, WIDTH};
use crate::scene::path::InstancePath;
use crate::scene::proxy::{Proxy, stops_light};

/// From this many rays below the root on, only a part of a list enters the next group at a time.
const MANY_RAYS: usize = 1 << 16;
/// From this many trails on, unused ones are removed.
const MANY_TRAILS: usize = 1 << 18;
/// Rays are loaded in chunks of this many, which the nearest caches hold.
const CHUNK: usize = 1024;
/// Once the rays have entered this many groups each, on average, groups are hit as proxies at larger sizes.
const EXACT_GROUPS: u64 = 512;
/// The size from which groups are opened doubles after this many further groups a ray.
const GROUPS_PER_DOUBLING: u64 = 32;
/// Coordinates beyond this are left to f64.
const FARTHEST: f64 = 1e25;

/// An open group.
struct Frame<'s> {
    group: &'s Group,
    /// An upper bound on the factor from lengths of the group to the world's.
    stretch: f64,
    trail: TrailId,
    /// The first ray in the group's space.
    first_ray: u32,
}

/// A step that is still to be done.
#[derive(Clone, Copy, Debug)]
enum Task {
    /// Visit a child of a node, with the rays of a list that hit its box.
    Child { slot: PackedSlot, child: u8, octant: u8, list: List },
    /// Visit the tree of the group that was entered last.
    Tree { octant: u8, list: List },
    /// Queue rays at a leaf.
    Leaf { index: u32, list: List },
    /// Queue rays at the leaves of a node of which only leaves were hit. `pairs` has the remaining pairs of the eight rays
    /// number `eight`, one byte for each ray with a bit for each leaf; later rays have all of theirs.
    Leaves { node: u32, list: List, eight: u32, pairs: u64 },
    /// Return to the group above.
    Leave,
}

/// The memory of a stream. Using it again spares page faults, which once cost a tenth of a picture.
#[derive(Debug, Default)]
struct Scratch {
    table: RayTable,
    lists: ListMemory,
    tasks: Vec<Task>,
}

thread_local! {
    /// The memory of the last stream of this thread.
    static SCRATCH: Cell<Option<Box<Scratch>>> = const { Cell::new(None) };
}

/// Rays that traverse a scene together. The memory returns to its thread when the stream is dropped.
pub(super) struct Stream<'s> {
    query: Query<'s>,
    scratch: Box<Scratch>,
    frames: Vec<Frame<'s>>,
    /// The path to the group that was entered last.
    path: InstancePath,
    queues: LeafQueues<'s>,
    most_rays: usize,
    most_trails: usize,
    /// How often a ray has entered a group.
    entered: u64,
}

impl Drop for Stream<'_> {
    fn drop(&mut self) {
        SCRATCH.set(Some(std::mem::take(&mut self.scratch)));
    }
}

/// A bit for each axis along which a direction is negative.
#[inline(always)]
fn octant_of(direction: DVec3) -> usize {
    let bit = |coordinate: f64| usize::from(coordinate.is_sign_negative());
    bit(direction.x) | bit(direction.y) << 1 | bit(direction.z) << 2
}

/// A line with a fourth coordinate that does not count: with it the compiler fills a register.
#[derive(Clone, Copy)]
struct WideLine {
    origin: [f64; 4],
    direction: [f64; 4],
}

#[inline(always)]
fn wide(v: DVec3) -> [f64; 4] {
    [v.x, v.y, v.z, 0.0]
}

#[inline(always)]
fn narrow([x, y, z, _]: [f64; 4]) -> DVec3 {
    DVec3::new(x, y, z)
}

impl WideLine {
    #[inline(always)]
    fn of([origin, direction]: [DVec3; 2]) -> Self {
        Self { origin: wide(origin), direction: wide(direction) }
    }

    #[inline(always)]
    fn narrow(self) -> [DVec3; 2] {
        [narrow(self.origin), narrow(self.direction)]
    }
}

/// The columns of a map, the last one the translation.
struct WideMap([[f64; 4]; 4]);

impl WideMap {
    #[inline(always)]
    fn of(map: &DAffine3) -> Self {
        let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
        Self([x_axis, y_axis, z_axis, map.translation].map(wide))
    }

    /// The image of a line: the numbers of [`Ray::through`].
    #[inline(always)]
    fn image(&self, [o, d]: [DVec3; 2]) -> WideLine {
        let [x, y, z, at] = &self.0;
        let (mut origin, mut direction) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            origin[i] = x[i] * o.x + y[i] * o.y + z[i] * o.z + at[i];
            direction[i] = x[i] * d.x + y[i] * d.y + z[i] * d.z;
        }
        WideLine { origin, direction }
    }
}

/// A ray in the space of a group's tree; `None` if f32 cannot hold it.
#[inline(always)]
fn tree_ray(group: &Group, line: WideLine) -> Option<BoxRay> {
    let (center, scale) = (wide(group.space.center), group.space.scale);
    let (mut origin, mut direction) = (line.origin, line.direction);
    for i in 0..4 {
        origin[i] = (origin[i] - center[i]) * scale;
        direction[i] *= scale;
    }
    let largest = |v: [f64; 4]| narrow(v).abs().max_element();
    let (size, speed) = (largest(origin), largest(direction));
    (size < FARTHEST && speed < FARTHEST && speed > 1.0 / FARTHEST)
        .then(|| BoxRay::new(origin, direction, size))
}

/// A run of a stream, compiled for the instruction sets of the machine.
struct Run<'a, 's> {
    stream: &'a mut Stream<'s>,
    rays: &'s [TraceRay],
    left_out: &'a [bool],
}

impl WithSimd for Run<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.stream.run_with(simd, self.rays, self.left_out);
    }
}

impl<'s> Stream<'s> {
    /// For the closest hits, or for occlusion before a t.
    pub(super) fn new(scene: &'s CompiledScene, root: &'s Group, any_before: Option<f64>) -> Self {
        Self {
            query: Query { scene, root, any_before, rays: &[] },
            scratch: SCRATCH.take().unwrap_or_default(),
            frames: Vec::new(),
            path: InstancePath::default(),
            queues: LeafQueues::new(),
            most_rays: MANY_RAYS,
            most_trails: MANY_TRAILS,
            entered: 0,
        }
    }

    /// The number of rays of the last run that hit a group as its proxy to bound the work.
    pub(super) fn coarsened_count(&self) -> u64 {
        self.scratch.table.coarsened.iter().filter(|&&is_coarsened| is_coarsened).count() as u64
    }

    /// How often the width of rays is doubled by now.
    fn doublings(&self) -> u32 {
        let rays = self.query.rays.len() as u64;
        let beyond = self.entered.checked_sub(rays * EXACT_GROUPS);
        beyond.map_or(0, |beyond| (beyond / (rays * GROUPS_PER_DOUBLING)) as u32 + 1)
    }

    /// The rays of the last run.
    pub(super) fn table(&self) -> &RayTable {
        &self.scratch.table
    }

    pub(super) fn query(&self) -> &Query<'s> {
        &self.query
    }

    /// Traces rays. Rays that `left_out` marks get no hit; it may be shorter. Not inlined: the code is
    /// large, and is compiled once for each instruction set.
    #[inline(never)]
    pub(super) fn run(&mut self, rays: &'s [TraceRay], left_out: &[bool]) {
        Arch::new().dispatch(Run { stream: self, rays, left_out });
    }

    #[inline(always)]
    fn run_with<S: Simd>(&mut self, simd: S, rays: &'s [TraceRay], left_out: &[bool]) {
        self.load(rays, left_out);
        loop {
            let mut visit = None;
            match self.scratch.tasks.pop() {
                None if !self.queues.is_empty() => self.queues.must_flush = true,
                None => return,
                Some(Task::Child { slot, child, octant, list }) => match slot.unpack() {
                    Slot::Node(node) => visit = self.list_child(child, list).map(|list| (node, octant, list)),
                    Slot::Leaf(index) => {
                        if let Some(list) = self.list_child(child, list) {
                            self.queue_at_leaf(index, list);
                        }
                    }
                    Slot::Instance(index) => self.enter(slot, index, child, list),
                },
                Some(Task::Leaf { index, list }) => self.queue_at_leaf(index, list),
                Some(Task::Leaves { node, list, eight, pairs }) => {
                    self.queue_at_leaves(node, list, eight, pairs);
                }
                Some(Task::Tree { octant, list }) => visit = Some((0, octant, list)),
                Some(Task::Leave) => self.leave(),
            }
            if let Some((node, octant, list)) = visit {
                self.visit(simd, node, octant, list);
            }
            let Self { queues, query, scratch, .. } = self;
            if queues.run(query, &mut scratch.table) && scratch.table.trails.len() > self.most_trails {
                self.compact_trails();
            }
        }
    }

    /// Removes unused trails unless rays wait at leaves.
    #[inline(never)]
    fn compact_trails(&mut self) {
        if self.queues.is_empty() {
            let open = self.frames.iter_mut().map(|frame| &mut frame.trail);
            let count = self.scratch.table.compact_trails(open);
            self.most_trails = self.most_trails.max(2 * count);
        }
    }

    /// Loads rays, those of one octant side by side: lists then read whole cache lines.
    #[inline(always)]
    fn load(&mut self, rays: &'s [TraceRay], left_out: &[bool]) {
        self.query.rays = rays;
        let Query { root, any_before, .. } = self.query;
        let count = rays.len();
        let Scratch { table, lists, .. } = &mut *self.scratch;
        table.trails.clear();
        table.exact.clear();
        table.coarsened.clear();
        self.entered = 0;
        self.path.clear();
        self.frames.clear();
        self.frames.push(Frame { group: root, stretch: 1.0, trail: None, first_ray: 0 });
        // Values of earlier rays are overwritten.
        table.id_of.resize(count, 0);
        table.index_of.resize(count, 0);
        table.outcomes.resize(count, Outcome::Miss);
        table.ends.resize(count, DONE);
        table.leaf_states.resize(count, LeafState::default());
        table.lines.resize(count, [DVec3::ZERO; 2]);
        table.boxes.resize(count, BoxRay::default());
        let has_groups = !root.instances.is_empty();
        table.footprints.resize(if has_groups { count } else { 0 }, Footprint::NONE);

        let end = any_before.map_or(f32::MAX, |t_max| (t_max as f32).next_up().min(f32::MAX));
        for (number, chunk) in rays.chunks(CHUNK).enumerate() {
            let before = number * CHUNK;
            let mut counts = [0; 8];
            for traced in chunk {
                counts[octant_of(traced.ray.direction)] += 1;
            }
            let mut next: [usize; 8] =
                std::array::from_fn(|octant| before + counts[..octant].iter().sum::<usize>());
            for (index, traced) in (before..).zip(chunk) {
                let next = &mut next[octant_of(traced.ray.direction)];
                (table.id_of[index], table.index_of[*next]) = (*next as u32, index as u32);
                *next += 1;
            }
            for id in before..before + chunk.len() {
                let index = table.index_of[id] as usize;
                if left_out.get(index) == Some(&true) {
                    (table.outcomes[id], table.ends[id]) = (Outcome::Miss, DONE);
                    continue;
                }
                let traced = &rays[index];
                let starts_on = match &traced.start {
                    Some(start) => start.path.indices().last().copied().unwrap_or(NO_LEAF),
                    None => NO_LEAF,
                };
                let (mut ray, mut footprint) = (traced.ray, traced.footprint);
                let (mut outcome, mut its_end, mut tree) = (Outcome::Miss, DONE, BoxRay::default());
                if let Some((direction, scale)) = scale_to_unit(ray.direction) {
                    // The t of occlusion counts lengths of the given direction.
                    if any_before.is_none() {
                        ray.direction = direction;
                        footprint.spread *= scale;
                    }
                    match tree_ray(root, WideLine::of([ray.origin, ray.direction])) {
                        Some(seen) => (tree, its_end) = (seen, end),
                        None => outcome = Outcome::Unresolved,
                    }
                }
                table.outcomes[id] = outcome;
                table.ends[id] = its_end;
                table.boxes[id] = tree;
                table.leaf_states[id] = LeafState { starts_on, waits: 0 };
                table.lines[id] = [ray.origin, ray.direction];
                let octant = octant_of(ray.direction) as u8;
                lists.arrivals.push((octant, ListedRay::new(id as u32, id as u32)));
                if has_groups {
                    table.footprints[id] = footprint;
                }
            }
        }
        self.list_arrivals(List::EMPTY);
    }

    /// Makes lists of the rays that enter a group, and tasks of the lists.
    #[inline(always)]
    fn list_arrivals(&mut self, top: List) {
        let Scratch { lists, tasks, .. } = &mut *self.scratch;
        for (octant, list) in lists.list_arrivals(top).into_iter().enumerate() {
            if list.count > 0 {
                tasks.push(Task::Tree { octant: octant as u8, list });
            }
        }
    }

    #[inline(always)]
    fn list_child(&mut self, child: u8, list: List) -> Option<List> {
        let Scratch { table, lists, .. } = &mut *self.scratch;
        lists.list_child(child, list, &table.ends)
    }

    /// The group that was entered last: the group, its stretch and its trail.
    #[inline(always)]
    fn frame(&self) -> (&'s Group, f64, TrailId) {
        self.frames
            .last()
            .map_or((self.query.root, 1.0, None), |frame| (frame.group, frame.stretch, frame.trail))
    }

    /// Tests the boxes of a node for the rays of a list.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, index: u32, octant: u8, list: List) {
        let (List { first, count, first_near, .. }, top) = (list, list.after());
        let node = &self.frame().0.nodes[index as usize];
        let Scratch { table, lists, tasks } = &mut *self.scratch;
        lists.reserve((top.first + count + 1) as usize, top.first_near as usize, top.first_block as usize);
        let ListMemory { rays, near, boxes_hit, .. } = lists;
        let near = &mut near[first_near as usize..top.first_near as usize];
        let listed = &rays[first as usize..top.first as usize];
        let whole_eights = listed.len().next_multiple_of(WIDTH);
        if boxes_hit.len() < whole_eights {
            boxes_hit.resize(2 * whole_eights, 0);
        }
        let boxes_hit = &mut boxes_hit[..whole_eights];
        if let Some(last) = boxes_hit.last_chunk_mut::<WIDTH>() {
            *last = [0; WIDTH];
        }
        let entries = NodeEntries { near, hit: boxes_hit };
        let bounds = node.bounds();
        let hit = intersect_boxes(simd, &bounds, octant, &table.boxes, listed, &table.ends, entries);
        let mut hit = hit & ((1u32 << node.count) - 1) as u8;
        if hit & !node.leaves == 0 {
            if hit != 0 {
                self.queue_at_leaves(index, list, 0, self.pairs(index, 0));
            }
            return;
        }
        let order =
            if count == 1 { lists.near[first_near as usize] } else { positions_along(&bounds, octant) };
        if count > 1 {
            lists.fill_blocks(list);
        }
        // The task pushed last is done first, so the farthest box comes first.
        let mut sorted = [0u8; WIDTH];
        let mut sorted_count = 0;
        while hit != 0 {
            let child = hit.trailing_zeros() as usize % WIDTH;
            hit &= hit - 1;
            let mut at = sorted_count;
            while at > 0 && order[sorted[at - 1] as usize % WIDTH] < order[child] {
                sorted[at] = sorted[at - 1];
                at -= 1;
            }
            sorted[at] = child as u8;
            sorted_count += 1;
        }
        for &child in &sorted[..sorted_count] {
            let slot = PackedSlot::new(node.slot(child as usize % WIDTH));
            tasks.push(Task::Child { slot, child, octant, list });
        }
    }

    /// Queues the rays of a list at a leaf until the queue is full.
    #[inline(always)]
    fn queue_at_leaf(&mut self, index: u32, list: List) {
        for i in 0..list.count {
            let is_full = self.queue(index, self.scratch.lists.rays[(list.first + i) as usize]);
            if is_full {
                let (first, count) = (list.first + i + 1, list.count - i - 1);
                if count > 0 {
                    self.scratch.tasks.push(Task::Leaf { index, list: List { first, count, ..list } });
                }
                return;
            }
        }
    }

    /// Queues the rays of the last tested list at the leaves of the node that they hit, until the queue is full.
    ///
    /// Lists of single leaves would be short: most have one ray. One loop over the pairs of eight rays at a time has an end
    /// that is seldom mispredicted.
    #[inline(always)]
    fn queue_at_leaves(&mut self, node: u32, list: List, mut eight: u32, mut pairs: u64) {
        let its_node = &self.frame().0.nodes[node as usize];
        loop {
            while pairs != 0 {
                let pair = pairs.trailing_zeros();
                pairs &= pairs - 1;
                let (ray, child) = (WIDTH as u32 * eight + pair / WIDTH as u32, pair as usize % WIDTH);
                let listed = self.scratch.lists.rays[(list.first + ray) as usize];
                let near = self.scratch.lists.near[(list.first_near + ray) as usize][child];
                if near <= self.scratch.table.ends[listed.end()] && self.queue(its_node.leaf(child), listed) {
                    self.scratch.tasks.push(Task::Leaves { node, list, eight, pairs });
                    return;
                }
            }
            eight += 1;
            if eight * WIDTH as u32 >= list.count {
                return;
            }
            pairs = self.pairs(node, eight);
        }
    }

    /// The pairs of eight rays of the last tested list with the leaves of the node that they hit: a byte for each ray.
    #[inline(always)]
    fn pairs(&self, node: u32, eight: u32) -> u64 {
        let hit = u64::from_le_bytes(self.scratch.lists.boxes_hit.as_chunks::<WIDTH>().0[eight as usize]);
        hit & u64::from_le_bytes([self.frame().0.nodes[node as usize].leaves; WIDTH])
    }

    /// Queues a ray at a leaf. Returns whether the queue is full.
    #[inline(always)]
    fn queue(&mut self, index: u32, listed: ListedRay) -> bool {
        let (group, _, trail) = self.frame();
        let id = listed.end();
        let table = &mut self.scratch.table;
        let start = if table.leaf_states[id].starts_on == index {
            table.start_at(&self.query, id, &mut self.path, index)
        } else {
            RayStart::Free
        };
        let leaf = &group.leaves[index as usize];
        let pair = RayLeafPair { id: id as u32, trail, index, leaf };
        self.queues.push(table, pair, start, listed.ray())
    }

    /// Continues the rays of a list that hit the box of a group in the group's space. Rays much wider than the group hit
    /// its proxy.
    #[inline(always)]
    fn enter(&mut self, slot: PackedSlot, index: u32, child: u8, mut list: List) {
        let top = list.after();
        let (group, stretch, trail) = self.frame();
        let doublings = self.doublings();
        let Scratch { table, lists, tasks } = &mut *self.scratch;
        // Many rays in many levels would need much memory, so only a part of them may enter now.
        let inner_rays = table.lines.len() - self.query.rays.len();
        let room = self.most_rays.saturating_sub(inner_rays) / 2;
        let count = list.count.min(room.max(STREAM_LANES) as u32);
        if count < list.count {
            let rest = list.count - count;
            let rest = List {
                first: list.first + count,
                count: rest,
                first_near: list.first_near + count,
                // The blocks are not read again; what lies behind them stays where it is.
                first_block: top.first_block - rest.div_ceil(super::lists::BLOCK),
            };
            tasks.push(Task::Child { slot, child, octant: 0, list: rest });
            list.count = count;
        }
        let instance = &group.instances[index as usize];
        let stretch = stretch * instance.stretch;
        let size = instance.size() * stretch;
        let inner: &'s Group = &instance.group;
        let map = WideMap::of(instance.map().inverse());
        let first_ray = table.lines.len() as u32;
        for i in 0..list.count {
            let listed = lists.rays[(list.first + i) as usize];
            let id = listed.end();
            let near = lists.near[(list.first_near + i) as usize][child as usize % WIDTH];
            if near > table.ends[id] {
                continue;
            }
            let line = table.lines[listed.ray()];
            let footprint = table.footprints[id];
            let mut is_hidden = footprint.hides(size, f64::from(near));
            // A ray without width has an exact answer.
            if doublings > 0 && !is_hidden && footprint != Footprint::NONE {
                let widened = footprint.doubled(doublings, self.query.scene.size());
                is_hidden = widened.hides(size, f64::from(near));
                if is_hidden {
                    table.coarsened.resize(self.query.rays.len(), false);
                    table.coarsened[id] = true;
                }
            }
            if is_hidden {
                test_proxy(&self.query, table, &mut self.path, (group, trail, index), id, line);
                continue;
            }
            let local = map.image(line);
            let Some(tree) = tree_ray(inner, local) else {
                table.end(id, Outcome::Unresolved);
                continue;
            };
            let listed = ListedRay::new(table.lines.len() as u32, id as u32);
            let local = local.narrow();
            lists.arrivals.push((octant_of(local[1]) as u8, listed));
            table.lines.push(local);
            table.boxes.push(tree);
        }
        if lists.arrivals.is_empty() {
            return;
        }
        self.entered += lists.arrivals.len() as u64 * u64::from(inner.work);
        self.queues.must_flush |= table.trails.len() >= self.most_trails;
        let trail = table.push_trail(trail, index);
        tasks.push(Task::Leave);
        self.frames.push(Frame { group: inner, stretch, trail, first_ray });
        self.path.push(index);
        self.list_arrivals(top);
    }

    fn leave(&mut self) {
        if let Some(frame) = self.frames.pop() {
            self.scratch.table.lines.truncate(frame.first_ray as usize);
            self.scratch.table.boxes.truncate(frame.first_ray as usize);
            self.path.pop();
        }
    }
}

/// Tests the proxy of a child for a ray in the group's space. `path` leads to the group, and is restored.
#[inline(never)]
fn test_proxy(
    query: &Query<'_>,
    table: &mut RayTable,
    path: &mut InstancePath,
    (group, trail, index): (&Group, TrailId, u32),
    id: usize,
    [origin, direction]: [DVec3; 2],
) {
    let instance = &group.instances[index as usize];
    let proxy = instance.group.proxy(&query.scene.primitives);
    let child = index | InstancePath::INSTANCE;
    if table.start_at(query, id, path, child) != RayStart::Free {
        return;
    }
    path.push(child);
    let draw = Lottery::of(table.lines[id][1]).draw(PathHash::of(path.indices()));
    path.pop();
    if draw >= proxy.opacity {
        return;
    }
    let ray = Ray::new(origin, direction);
    let local = ray.to_local(instance.map()).through(&proxy.unit_from_group);
    if let Some(t_max) = query.any_before {
        if stops_light(proxy.opacity, &local, t_max, draw) {
            table.end(id, Outcome::Occluded);
        }
        return;
    }
    let shape = Proxy::unit_shape();
    if shape.intersect(&local, RayStart::Free).is_some_and(|hit| !hit.leaving) {
        let tested = TestedShape { trail, child, shape, primitive: proxy.main_primitive() };
        table.test_shape_in_f64(query, id, &tested, &local, RayStart::Free);
    }
}

#[cfg(test)]
mod tests {
    use superegg_lang::load_text;

    use super::*;

    /// A fractal of overlapping shapes.
    const FRACTAL: &str = "prm ball\nexp 1 .4\ncoeff .2 .3 .1\nprm star\nexp 3 2.5\ncoeff .3 .2 .3\n\
        obj all\nap ball\nap star\nxs .3 .2 .1\nao all a\nrs 1 2 3 40\nss .8 .8 .8\nxs .3 0 0\n\
        ao all b\nrs 2 1 0 70\nss .8 .7 -.8\nxs -.3 .2 0\nao all c\nss .6 .6 .6\nxs 0 -.9 .4\n";

    #[test]
    fn limits_on_memory_change_no_answer() {
        let (session, diagnostics) = load_text("stream.scn", FRACTAL);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = CompiledScene::compile(session.scene(), Some("all"), 7);
        let root = scene.root.as_deref().unwrap();
        let rays: Vec<TraceRay> = (0..3_000)
            .map(|i| {
                let a = f64::from(i);
                let origin = DVec3::new((1.3 * a).sin(), (0.7 * a).cos(), (2.9 * a).sin()) * 1.2;
                // One octant makes long lists.
                let direction = DVec3::new((2.1 * a).cos(), (1.1 * a).sin(), (0.37 * a).cos()).abs();
                Ray::new(origin, direction).into()
            })
            .collect();
        for any_before in [None, Some(1.0)] {
            let mut stream = Stream::new(&scene, root, any_before);
            (stream.most_rays, stream.most_trails) = (100, 8);
            stream.run(&rays, &[]);
            assert!(stream.table().lines.capacity() <= 2 * rays.len(), "{}", stream.table().lines.capacity());
            // The trails of hits stay.
            let most_trails = if any_before.is_some() { 50 } else { 3_500 };
            assert!(stream.table().trails.len() < most_trails, "{}", stream.table().trails.len());
            let (mut found, mut unresolved) = (0, 0);
            for (index, traced) in rays.iter().enumerate() {
                let outcome = stream.table().outcome(index);
                let expected = scene.intersect(traced);
                match (*outcome, any_before) {
                    (Outcome::Hit(nearest), None) => {
                        found += 1;
                        let expected = expected.unwrap();
                        assert_eq!(stream.table().path(&nearest), expected.path);
                        let (_, scale) = scale_to_unit(traced.ray.direction).unwrap();
                        assert!((nearest.t * scale - expected.t).abs() < 1e-4 * (1.0 + expected.t));
                    }
                    (Outcome::Miss, None) => assert!(expected.is_none()),
                    (Outcome::Unresolved, _) => unresolved += 1,
                    (outcome, _) => {
                        let stopped = scene.occluded(traced, 1.0);
                        assert_eq!(matches!(outcome, Outcome::Occluded), stopped, "{traced:?}");
                    }
                }
            }
            assert!(any_before.is_some() || found > 200, "{found}");
            assert!(unresolved < 100, "{unresolved}");
        }
    }
}
