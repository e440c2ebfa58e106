//! Lists of rays through the graph of groups.
//!
//! A node asks all rays that come to it for its boxes, eight boxes at once; each box that any of them meets has its own list, and lists are followed depth first,
//! those of the nearest boxes first. The rays of a list go the same way along each axis, so that one order of boxes is good for all of them.
//! Where a list comes to a shape its rays wait: first for [`ShapeEntries`] to be full, then, those that meet the shape's own box, for
//! [`StreamLanes`].

use std::sync::{Mutex, PoisonError};

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::LanePowers;
use superegg_geom::kernels::stream::{
    BoxRay, END, ENTRY_LANES, EntryKind, ListedRay, NodeEntries, STREAM_LANES, ShapeEntries, ShapeEntry,
    StreamHits, StreamLanes, intersect_boxes,
};
use superegg_geom::{Ray, RayStart, ShapeHit, Superquadric, scale_to_unit};
use superegg_simd::Simd;

use crate::beam::lanes;
use crate::bvh::{Node, PackedSlot, Slot, WIDTH};
use crate::compiled::{CompiledScene, Group, Leaf};
use crate::flight::FlightRay;
use crate::footprint::{Footprint, chance};
use crate::path::InstancePath;
use crate::stand_in::StandIn;
use crate::traverse::{Departure, Hit};

/// What is told of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Told {
    /// It meets nothing.
    Nothing,
    /// Something stops it.
    Occluded,
    /// This is the first that it meets.
    Found(Best),
    /// The lanes cannot tell.
    Doubtful,
}

/// The closest crossing of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Best {
    pub(crate) t: f64,
    /// By how much it may be off.
    pub(crate) error: f32,
    /// The group, as a place among the trails, and the place in it.
    trail: u32,
    place: u32,
    pub(crate) found: Found,
}

/// How a crossing was found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    /// By f64: for [`Stream::exact`].
    Exactly(u32),
    /// By lanes.
    Nearly { leaving: bool },
}

/// A group that rays are in: the one above it and the place of the instance there.
#[derive(Clone, Copy, Debug)]
struct Trail {
    above: u32,
    place: u32,
}

/// The trail of the root.
const ROOT: u32 = u32::MAX;

/// What a ray is asked where it comes to a shape.
#[derive(Clone, Copy, Debug, Default)]
struct Patience {
    /// The last place of the path that it starts on.
    departs_from: u32,
    /// How many shapes it waits for.
    waiting: u32,
}

/// The last place of no path.
const NOWHERE: u32 = u32::MAX;
/// A ray that waits for so many shapes waits no longer.
const PATIENCE: u32 = 4;
/// From so many rays below the root on, few at a time go deeper.
const MANY_RAYS: usize = 1 << 16;
/// From so many trails on, those that lead to nothing are forgotten.
const MANY_TRAILS: usize = 1 << 18;
/// The end, in f32, of a ray that asks no more.
const DONE: f32 = -1.0;

/// A group that is open.
struct Frame<'s> {
    group: &'s Group,
    stretch: f64,
    trail: u32,
    /// From here on the rays are in its space.
    first_ray: u32,
}

/// What is still to be done.
#[derive(Clone, Copy, Debug)]
enum Task {
    /// A box of a node, for those of a list that meet it.
    Child { slot: PackedSlot, child: u8, octant: u8, list: List },
    /// The tree of the group that was entered last.
    Tree { octant: u8, list: List },
    /// A shape that rays wait for.
    Wait { place: u32, list: List },
    /// The shapes of a node that met nothing else: for eight rays of the list those that are left of them, a byte for each ray, and for all rays after these.
    WaitForLeaves { node: u32, list: List, eight: u32, pairs: u64 },
    /// The way back to the group above.
    Leave,
}

/// Some rays, with where they enter the boxes of the node that they were asked for.
#[derive(Clone, Copy, Debug)]
struct List {
    first: u32,
    count: u32,
    first_near: u32,
    /// Where the blocks of those that meet each box begin.
    first_met: u32,
}

impl List {
    /// Where what comes after its rays, their entries and its blocks begins.
    #[inline(always)]
    fn after(self) -> Self {
        let Self { first, count, first_near, first_met } = self;
        let first_met = first_met + count.div_ceil(BLOCK);
        Self { first: first + count, count: 0, first_near: first_near + count, first_met }
    }
}

/// Rays of a list whose bits are in one word.
const BLOCK: u32 = u64::BITS;

/// A ray and an instance of a shape that it may meet.
#[derive(Clone, Copy)]
struct Meeting<'s> {
    /// The ray.
    course: u32,
    /// The path to the instance.
    trail: u32,
    place: u32,
    leaf: &'s Leaf,
}

/// A ray at the box of a shape.
#[derive(Clone, Copy)]
struct Waiting<'s> {
    meeting: Meeting<'s>,
    start: RayStart,
    /// The t there.
    entry: f64,
    t_per_way: f64,
    /// For a ray that starts within the box: the t where it leaves it.
    leaves: Option<f64>,
}

/// Rays that wait in lanes.
struct Flying<'s> {
    lanes: StreamLanes,
    waiting: Vec<Waiting<'s>>,
}

/// How many rays are taken in together, so that the nearest caches hold them from the first look to the last.
const TAKEN_TOGETHER: usize = 1024;

/// What a stream keeps of its rays: for each of them, and for each list of them. It can be used again, which spares asking the system for it.
#[derive(Debug, Default)]
pub(crate) struct StreamMemory {
    told: Vec<Told>,
    /// Where each ray that was asked is among all else, and which of those that were asked each is there.
    courses: Vec<u32>,
    places: Vec<u32>,
    /// No crossing beyond these counts.
    ends: Vec<f32>,
    /// None where the root has no groups.
    footprints: Vec<Footprint>,
    patience: Vec<Patience>,
    /// The origins and directions of rays in the spaces of the groups that are open, and what their trees see of them.
    lines: Vec<[DVec3; 2]>,
    boxes: Vec<BoxRay>,
    trails: Vec<Trail>,
    tasks: Vec<Task>,
    /// Lists and entries, one after the other as they are needed, and by boxes a bit for each ray of a block that meets it.
    lists: Vec<ListedRay>,
    near: Vec<[f32; WIDTH]>,
    met: Vec<[u64; WIDTH]>,
    /// By rays of a list a bit for each box.
    boxes_met: Vec<u8>,
    /// Rays that come to a group, with their octants.
    arrivals: Vec<(u8, ListedRay)>,
    exact: Vec<Hit>,
}

impl StreamMemory {
    /// The rays of a flight wait no longer: a bit for each of which there is something to tell.
    #[inline(always)]
    fn end_waiting(&mut self, flying: &[Waiting<'_>], answers: &StreamHits) -> u32 {
        for waiting in flying {
            self.patience[waiting.meeting.course as usize].waiting -= 1;
        }
        answers.found | answers.unresolved
    }
}

/// Rays that go through a scene together.
pub(crate) struct Stream<'s> {
    scene: &'s CompiledScene,
    root: &'s Group,
    /// The end of the rays where only occlusion is asked.
    any_before: Option<f64>,
    asked: &'s [FlightRay],
    memory: StreamMemory,
    frames: Vec<Frame<'s>>,
    path: InstancePath,
    approaches: ShapeEntries,
    approaching: Vec<(Meeting<'s>, RayStart)>,
    /// From outside of their boxes, and from within.
    outside: Flying<'s>,
    within: Flying<'s>,
    answers: StreamHits,
    /// Set where a ray waits no longer.
    is_impatient: bool,
    most_rays: usize,
    most_trails: usize,
}

/// Scales beyond this are f64's.
const FARTHEST: f64 = 1e25;

/// A bit for each axis along which a direction goes backwards.
#[inline(always)]
fn octant_of(direction: DVec3) -> usize {
    let bit = |coordinate: f64| usize::from(coordinate.is_sign_negative());
    bit(direction.x) | bit(direction.y) << 1 | bit(direction.z) << 2
}

/// A ray as the boxes of a group's tree see it; `None` where f32 cannot hold it.
#[inline(always)]
fn tree_ray(group: &Group, ray: &Ray) -> Option<BoxRay> {
    let origin = (ray.origin - group.space.center) * group.space.scale;
    let direction = ray.direction * group.space.scale;
    let (size, pace) = (origin.abs().max_element(), direction.abs().max_element());
    (size < FARTHEST && pace < FARTHEST && pace > 1.0 / FARTHEST)
        .then(|| BoxRay::new(origin, direction, size))
}

/// Memory that streams have used, for others: as much as there ever were at a time.
#[derive(Debug, Default)]
pub(crate) struct Spare(Mutex<Vec<StreamMemory>>);

impl Spare {
    fn take(&self) -> StreamMemory {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    fn give(&self, memory: StreamMemory) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(memory);
    }
}

/// What is spare stays with the scene that it was made for.
impl Clone for Spare {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<'s> Stream<'s> {
    /// For rays that are asked for their first crossings, or whether anything stops them before a t.
    pub(crate) fn new(scene: &'s CompiledScene, root: &'s Group, any_before: Option<f64>) -> Self {
        let flying = || Flying { lanes: StreamLanes::default(), waiting: Vec::with_capacity(STREAM_LANES) };
        Self {
            scene,
            root,
            any_before,
            asked: &[],
            memory: scene.spare.take(),
            frames: Vec::new(),
            path: InstancePath::default(),
            approaches: ShapeEntries::default(),
            approaching: Vec::with_capacity(ENTRY_LANES),
            outside: flying(),
            within: flying(),
            answers: StreamHits::default(),
            is_impatient: false,
            most_rays: MANY_RAYS,
            most_trails: MANY_TRAILS,
        }
    }

    /// Gives its memory back to the scene, for the next one.
    pub(crate) fn end_here(self) {
        self.scene.spare.give(self.memory);
    }

    /// What is told of a ray of the last run, by its place among those that were asked.
    #[inline(always)]
    pub(crate) fn told(&self, place: usize) -> &Told {
        &self.memory.told[self.memory.courses[place] as usize]
    }

    /// The ray that was asked.
    fn asked(&self, course: usize) -> &'s FlightRay {
        &self.asked[self.memory.places[course] as usize]
    }

    /// The path to a crossing.
    #[inline(always)]
    pub(crate) fn path(&self, best: &Best) -> InstancePath {
        let mut path = self.path_to(best.trail);
        path.push(best.place);
        path
    }

    /// The leaf of a crossing that lanes have found, and a ray in the space of its shape.
    #[inline(always)]
    pub(crate) fn before_leaf(&self, best: &Best, ray: &Ray) -> (&'s Leaf, Ray) {
        let (group, ray) = self.root.follow(self.path_to(best.trail).places(), ray);
        let leaf = &group.leaves[best.place as usize];
        (leaf, ray.through(&leaf.unit_from_group))
    }

    /// The path to a group.
    #[inline(always)]
    fn path_to(&self, trail: u32) -> InstancePath {
        if trail == ROOT { InstancePath::default() } else { self.path_along(trail) }
    }

    fn path_along(&self, trail: u32) -> InstancePath {
        let mut path = InstancePath::default();
        let mut places = smallvec::SmallVec::<[u32; 8]>::new();
        let mut at = trail;
        while at != ROOT {
            let Trail { above, place } = self.memory.trails[at as usize];
            places.push(place);
            at = above;
        }
        places.iter().rev().for_each(|&place| path.push(place));
        path
    }

    /// A crossing that f64 has found, without its path.
    pub(crate) fn exact(&self, place: u32) -> &Hit {
        &self.memory.exact[place as usize]
    }

    /// Sends rays through the scene.
    #[inline(always)]
    pub(crate) fn run<S: Simd>(&mut self, simd: S, asked: &'s [FlightRay]) {
        self.start(asked);
        loop {
            let mut visit = None;
            match self.memory.tasks.pop() {
                None if self.is_anything_waiting() => self.is_impatient = true,
                None => return,
                Some(Task::Child { slot, child, octant, list }) => match slot.unpack() {
                    Slot::Node(node) => visit = self.list_child(child, list).map(|list| (node, octant, list)),
                    Slot::Leaf(place) => {
                        if let Some(list) = self.list_child(child, list) {
                            self.wait(place, list);
                        }
                    }
                    Slot::Instance(place) => self.enter(slot, place, child, list),
                },
                Some(Task::Wait { place, list }) => self.wait(place, list),
                Some(Task::WaitForLeaves { node, list, eight, pairs }) => {
                    self.wait_for_leaves(node, list, eight, pairs);
                }
                Some(Task::Tree { octant, list }) => visit = Some((0, octant, list)),
                Some(Task::Leave) => self.leave(),
            }
            if let Some((node, octant, list)) = visit {
                self.visit(simd, node, octant, list);
            }
            self.meet(simd);
        }
    }

    fn is_anything_waiting(&self) -> bool {
        !(self.approaching.is_empty() && self.outside.waiting.is_empty() && self.within.waiting.is_empty())
    }

    /// Meets what waits where there is enough of it, or all where rays have waited long enough.
    #[inline(always)]
    fn meet<S: Simd>(&mut self, simd: S) {
        if !(self.is_impatient || self.approaching.len() == ENTRY_LANES) {
            return;
        }
        self.come_to_boxes();
        if self.is_impatient || self.outside.is_full() {
            self.meet_outside(simd);
        }
        if self.is_impatient || self.within.is_full() {
            self.meet_within(simd);
        }
        self.is_impatient = false;
        if self.memory.trails.len() > self.most_trails {
            self.forget_trails();
        }
    }

    /// Forgets the trails that lead to no crossing and to no open group. Nothing may wait.
    #[inline(never)]
    fn forget_trails(&mut self) {
        if self.is_anything_waiting() {
            return;
        }
        let StreamMemory { told, trails, .. } = &mut self.memory;
        let mut ends: Vec<&mut u32> = self.frames.iter_mut().map(|frame| &mut frame.trail).collect();
        ends.extend(told.iter_mut().filter_map(|told| match told {
            Told::Found(best) => Some(&mut best.trail),
            _ => None,
        }));
        let mut is_kept = vec![false; trails.len()];
        for end in &ends {
            let mut at = **end;
            while at != ROOT && !std::mem::replace(&mut is_kept[at as usize], true) {
                at = trails[at as usize].above;
            }
        }
        // A trail comes after the one above it.
        let mut place_of = vec![ROOT; trails.len()];
        let renamed =
            |trail: u32, place_of: &[u32]| if trail == ROOT { ROOT } else { place_of[trail as usize] };
        let mut count = 0;
        for trail in 0..trails.len() {
            if is_kept[trail] {
                let Trail { above, place } = trails[trail];
                trails[count] = Trail { above: renamed(above, &place_of), place };
                place_of[trail] = count as u32;
                count += 1;
            }
        }
        trails.truncate(count);
        ends.into_iter().for_each(|end| *end = renamed(*end, &place_of));
        self.most_trails = self.most_trails.max(2 * count);
    }

    /// Takes rays in, those of one octant side by side: a list then has whole lines of the cache.
    #[inline(always)]
    fn start(&mut self, asked: &'s [FlightRay]) {
        self.asked = asked;
        let count = asked.len();
        let memory = &mut self.memory;
        memory.trails.clear();
        memory.exact.clear();
        self.path.clear();
        self.frames.clear();
        self.frames.push(Frame { group: self.root, stretch: 1.0, trail: ROOT, first_ray: 0 });
        // What is there from rays before is written over.
        memory.courses.resize(count, 0);
        memory.places.resize(count, 0);
        memory.told.resize(count, Told::Nothing);
        memory.ends.resize(count, DONE);
        memory.patience.resize(count, Patience::default());
        memory.lines.resize(count, [DVec3::ZERO; 2]);
        memory.boxes.resize(count, BoxRay::default());
        let has_groups = !self.root.instances.is_empty();
        memory.footprints.resize(if has_groups { count } else { 0 }, Footprint::NONE);

        let end = self.any_before.map_or(f32::MAX, |t_max| (t_max as f32).next_up().min(f32::MAX));
        for (number, taken) in asked.chunks(TAKEN_TOGETHER).enumerate() {
            let before = number * TAKEN_TOGETHER;
            let mut counts = [0; 8];
            for asked in taken {
                counts[octant_of(asked.ray.direction)] += 1;
            }
            let mut next: [usize; 8] =
                std::array::from_fn(|octant| before + counts[..octant].iter().sum::<usize>());
            for (place, asked) in (before..).zip(taken) {
                let next = &mut next[octant_of(asked.ray.direction)];
                (memory.courses[place], memory.places[*next]) = (*next as u32, place as u32);
                *next += 1;
            }
            for course in before..before + taken.len() {
                let asked = &asked[memory.places[course] as usize];
                let departs_from = match &asked.departure {
                    Some(departure) => departure.path.places().last().copied().unwrap_or(NOWHERE),
                    None => NOWHERE,
                };
                let (mut ray, mut footprint) = (asked.ray, asked.footprint);
                let (mut told, mut its_end, mut tree) = (Told::Nothing, DONE, BoxRay::default());
                if let Some((direction, scale)) = scale_to_unit(ray.direction) {
                    // Occlusion counts t in the ray's own lengths.
                    if self.any_before.is_none() {
                        ray.direction = direction;
                        footprint.spread *= scale;
                    }
                    match tree_ray(self.root, &ray) {
                        Some(seen) => (tree, its_end) = (seen, end),
                        None => told = Told::Doubtful,
                    }
                }
                memory.told[course] = told;
                memory.ends[course] = its_end;
                memory.boxes[course] = tree;
                memory.patience[course] = Patience { departs_from, waiting: 0 };
                // The place of a ray in the root's space is that of all else.
                memory.lines[course] = [ray.origin, ray.direction];
                let octant = octant_of(ray.direction) as u8;
                memory.arrivals.push((octant, ListedRay::new(course as u32, course as u32)));
                if has_groups {
                    memory.footprints[course] = footprint;
                }
            }
        }
        self.list_arrivals(List { first: 0, count: 0, first_near: 0, first_met: 0 });
    }

    /// Makes lists of the rays that come to a group, and tasks of these.
    #[inline(always)]
    fn list_arrivals(&mut self, top: List) {
        self.reserve(top.first as usize + self.memory.arrivals.len(), 0, 0);
        let mut counts = [0; 8];
        for (octant, _) in &self.memory.arrivals {
            counts[*octant as usize % 8] += 1;
        }
        let mut first = top.first;
        let mut ends = [0; 8];
        for octant in 0..8 {
            let count = counts[octant];
            ends[octant] = first;
            if count > 0 {
                let list = List { first, count, ..top };
                self.memory.tasks.push(Task::Tree { octant: octant as u8, list });
            }
            first += count;
        }
        for (octant, listed) in &self.memory.arrivals {
            let end = &mut ends[*octant as usize % 8];
            self.memory.lists[*end as usize] = *listed;
            *end += 1;
        }
        self.memory.arrivals.clear();
    }

    #[inline(always)]
    fn reserve(&mut self, lists: usize, near: usize, met: usize) {
        if self.memory.lists.len() < lists {
            self.memory.lists.resize(2 * lists, ListedRay::default());
        }
        if self.memory.near.len() < near {
            self.memory.near.resize(2 * near, [0.0; WIDTH]);
        }
        if self.memory.met.len() < met {
            self.memory.met.resize(2 * met, [0; WIDTH]);
        }
    }

    /// The group that rays are in.
    #[inline(always)]
    fn frame(&self) -> (&'s Group, f64, u32) {
        self.frames.last().map_or((self.root, 1.0, ROOT), |frame| (frame.group, frame.stretch, frame.trail))
    }

    /// The rays of a list that come to a box of a node before their ends.
    #[inline(always)]
    fn list_child(&mut self, child: u8, list: List) -> Option<List> {
        let (child, top) = (child as usize % WIDTH, list.after());
        let StreamMemory { lists, near, met, ends, .. } = &mut self.memory;
        let (parents, free) = lists[list.first as usize..].split_at_mut(list.count as usize);
        let near = &near[list.first_near as usize..top.first_near as usize];
        // All that meet it are written, and those that are not kept are written over.
        let mut kept = 0;
        for (block, met) in met[list.first_met as usize..top.first_met as usize].iter().enumerate() {
            let mut rays = met[child];
            while rays != 0 {
                let i = block * BLOCK as usize + rays.trailing_zeros() as usize;
                rays &= rays - 1;
                free[kept] = parents[i];
                kept += usize::from(near[i][child] <= ends[parents[i].end()]);
            }
        }
        (kept > 0).then_some(List { count: kept as u32, ..top })
    }

    /// Asks the rays of a list for the boxes of a node.
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, index: u32, octant: u8, list: List) {
        let (List { first, count, first_near, first_met }, top) = (list, list.after());
        self.reserve((top.first + count + 1) as usize, top.first_near as usize, top.first_met as usize);
        let node = &self.frame().0.nodes[index as usize];
        let StreamMemory { lists, near, met: blocks, boxes_met, boxes, ends, .. } = &mut self.memory;
        let near = &mut near[first_near as usize..top.first_near as usize];
        let listed = &lists[first as usize..top.first as usize];
        let whole_eights = listed.len().next_multiple_of(WIDTH);
        if boxes_met.len() < whole_eights {
            boxes_met.resize(2 * whole_eights, 0);
        }
        let boxes_met = &mut boxes_met[..whole_eights];
        if let Some(last) = boxes_met.last_chunk_mut::<WIDTH>() {
            *last = [0; WIDTH];
        }
        let entries = NodeEntries { near, hit: boxes_met };
        let met = intersect_boxes(simd, &node.bounds, octant, boxes, listed, ends, entries);
        let mut met = met & ((1u32 << node.count) - 1) as u8;
        if met & !node.leaves() == 0 {
            if met != 0 {
                self.wait_for_leaves(index, list, 0, self.pairs(index, 0));
            }
            return;
        }
        let blocks = &mut blocks[first_met as usize..top.first_met as usize];
        for (block, met) in blocks.iter_mut().zip(boxes_met.chunks(BLOCK as usize)) {
            *block = by_boxes(met);
        }
        let order = if count == 1 { near[0] } else { places_along(node, octant) };
        // What is done last comes first.
        let mut found = [0u8; WIDTH];
        let mut found_count = 0;
        while met != 0 {
            let place = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            let mut at = found_count;
            while at > 0 && order[found[at - 1] as usize % WIDTH] < order[place] {
                found[at] = found[at - 1];
                at -= 1;
            }
            found[at] = place as u8;
            found_count += 1;
        }
        for &child in &found[..found_count] {
            self.memory.tasks.push(Task::Child {
                slot: node.slots[child as usize % WIDTH],
                child,
                octant,
                list,
            });
        }
    }

    /// The rays of a list wait for the shape of a leaf, as many as there is room for.
    #[inline(always)]
    fn wait(&mut self, place: u32, list: List) {
        for i in 0..list.count {
            let is_full = self.approach(place, self.memory.lists[(list.first + i) as usize]);
            if is_full {
                let (first, count) = (list.first + i + 1, list.count - i - 1);
                if count > 0 {
                    self.memory.tasks.push(Task::Wait { place, list: List { first, count, ..list } });
                }
                return;
            }
        }
    }

    /// The rays of the list that was asked for a node's boxes last wait for the shapes of the leaves that they meet, as many as there is room for. Lists
    /// of single leaves would be short: most have one ray. Eight rays at a time, so that there is one loop, whose end is seldom guessed wrong.
    #[inline(always)]
    fn wait_for_leaves(&mut self, node: u32, list: List, mut eight: u32, mut pairs: u64) {
        let slots = &self.frame().0.nodes[node as usize].slots;
        loop {
            while pairs != 0 {
                let pair = pairs.trailing_zeros();
                pairs &= pairs - 1;
                let (ray, child) = (WIDTH as u32 * eight + pair / WIDTH as u32, pair as usize % WIDTH);
                let listed = self.memory.lists[(list.first + ray) as usize];
                let near = self.memory.near[(list.first_near + ray) as usize][child];
                let Slot::Leaf(place) = slots[child].unpack() else { continue };
                if near <= self.memory.ends[listed.end()] && self.approach(place, listed) {
                    self.memory.tasks.push(Task::WaitForLeaves { node, list, eight, pairs });
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

    /// The leaves of a node that eight rays of the list that was asked last meet: a byte for each ray.
    #[inline(always)]
    fn pairs(&self, node: u32, eight: u32) -> u64 {
        let met = u64::from_le_bytes(self.memory.boxes_met.as_chunks::<WIDTH>().0[eight as usize]);
        met & u64::from_le_bytes([self.frame().0.nodes[node as usize].leaves(); WIDTH])
    }

    /// A ray waits for a shape. Returns whether there is no room for another one.
    #[inline(always)]
    fn approach(&mut self, place: u32, listed: ListedRay) -> bool {
        let (group, _, trail) = self.frame();
        let leaf = &group.leaves[place as usize];
        let course = listed.end();
        let start = if self.memory.patience[course].departs_from == place {
            self.start_at(course, place)
        } else {
            RayStart::Free
        };
        if start == RayStart::SurfaceOutward && leaf.lane_powers.is_some() {
            return false;
        }
        let lane = self.approaching.len();
        let t_max = f64::from(self.memory.ends[course]);
        self.approaches.set(lane, &leaf.unit_from_group, self.memory.lines[listed.ray()], t_max);
        self.approaching.push((Meeting { course: course as u32, trail, place, leaf }, start));
        let waiting = &mut self.memory.patience[course].waiting;
        *waiting += 1;
        self.is_impatient |= *waiting > PATIENCE;
        self.is_impatient || lane + 1 == ENTRY_LANES
    }

    /// What is known of a ray's start for the shape, or the group, at a place of the group that it is in.
    fn start_at(&mut self, course: usize, place: u32) -> RayStart {
        self.path.push(place);
        let start = Departure::start_at(self.asked(course).departure.as_ref(), &self.path);
        self.path.pop();
        start
    }

    /// Brings rays that wait to the boxes of their shapes.
    #[inline(always)]
    fn come_to_boxes(&mut self) {
        self.approaches.run();
        // No branch is taken for those that miss, which nobody could guess.
        let mut arrived = 0u32;
        for (lane, (meeting, _)) in self.approaching.iter().enumerate() {
            let course = meeting.course as usize;
            let arrives =
                (self.approaches.kind(lane) != EntryKind::Misses) & (self.memory.ends[course] != DONE);
            self.memory.patience[course].waiting -= u32::from(!arrives);
            arrived |= u32::from(arrives) << lane;
        }
        for lane in lanes(arrived) {
            let (meeting, start) = self.approaching[lane];
            let verdict = self.approaches.kind(lane);
            let course = meeting.course as usize;
            let is_within = verdict == EntryKind::Inside;
            // Its one crossing is the way out.
            let is_inward = start == RayStart::SurfaceInward && is_within && self.any_before.is_none();
            let is_known = start == RayStart::Free || is_inward;
            let powers = match meeting.leaf.lane_powers {
                Some(powers) if verdict != EntryKind::Unresolved && is_known => powers,
                Some(_) | None => {
                    self.memory.patience[course].waiting -= 1;
                    self.meet_exactly(&meeting, start);
                    continue;
                }
            };
            let approach = self.approaches.get(lane);
            let ShapeEntry { t_entry: entry, t_per_s: t_per_way, length, .. } = approach;
            let leaves = is_within.then_some(entry + f64::from(length) * t_per_way);
            let waiting = Waiting { meeting, start, entry, t_per_way, leaves };
            // For occlusion it is the same whether a ray starts in the box.
            if is_within && self.any_before.is_none() {
                self.within.push(powers, &approach, is_inward, waiting);
            } else {
                self.outside.push(powers, &approach, false, waiting);
            }
        }
        self.approaching.clear();
    }

    #[inline(always)]
    fn meet_outside<S: Simd>(&mut self, simd: S) {
        let count = self.outside.waiting.len();
        self.outside.lanes.clear_from(count);
        if self.any_before.is_some() {
            self.outside.lanes.occluded(simd, count, &mut self.answers);
        } else {
            self.outside.lanes.intersect(simd, count, &mut self.answers);
        }
        for lane in lanes(self.memory.end_waiting(&self.outside.waiting, &self.answers)) {
            let waiting = self.outside.waiting[lane];
            match self.any_before {
                Some(t_max) => self.take_occlusion(lane, &waiting, t_max),
                None => self.take_crossing(lane, &waiting, false),
            }
        }
        self.outside.waiting.clear();
    }

    #[inline(always)]
    fn meet_within<S: Simd>(&mut self, simd: S) {
        let count = self.within.waiting.len();
        if count == 0 {
            return;
        }
        self.within.lanes.clear_from(count);
        self.within.lanes.intersect_from_inside(simd, count, &mut self.answers);
        for lane in lanes(self.memory.end_waiting(&self.within.waiting, &self.answers)) {
            let waiting = self.within.waiting[lane];
            self.take_crossing(lane, &waiting, self.answers.leaving >> lane & 1 == 1);
        }
        self.within.waiting.clear();
    }

    #[inline(always)]
    fn take_crossing(&mut self, lane: usize, waiting: &Waiting<'s>, leaving: bool) {
        let way = self.answers.s[lane];
        let is_doubtful = self.answers.unresolved >> lane & 1 == 1;
        let course = waiting.meeting.course as usize;
        let t = waiting.entry + f64::from(way) * waiting.t_per_way;
        let error = f64::from(self.answers.error[lane]) * waiting.t_per_way;
        let error = (error as f32).next_up();
        if is_doubtful {
            // A grazing ray, which may be behind the best, or one that starts on the surface.
            if waiting.leaves.is_some() || t - f64::from(error) < self.t_max(course) {
                self.meet_exactly(&waiting.meeting, waiting.start);
            }
            return;
        }
        if way < f32::INFINITY {
            let Meeting { trail, place, .. } = waiting.meeting;
            self.take(course, Best { t, error, trail, place, found: Found::Nearly { leaving } });
        }
    }

    #[inline(always)]
    fn take_occlusion(&mut self, lane: usize, waiting: &Waiting<'s>, t_max: f64) {
        let course = waiting.meeting.course as usize;
        if self.memory.ends[course] == DONE {
            return;
        }
        let way = self.answers.s[lane];
        // What is inside somewhere is met before that, but for a ray that starts inside: that one is when it leaves.
        let t = waiting.leaves.unwrap_or(waiting.entry + f64::from(way) * waiting.t_per_way);
        if way < f32::INFINITY && t < t_max * (1.0 - END) && t > 0.0 {
            self.end(course, Told::Occluded);
        } else if way < f32::INFINITY || self.answers.unresolved >> lane & 1 == 1 {
            self.meet_exactly(&waiting.meeting, waiting.start);
        }
    }

    /// A ray asks no more.
    #[inline(always)]
    fn end(&mut self, course: usize, told: Told) {
        self.memory.told[course] = told;
        self.memory.ends[course] = DONE;
    }

    /// No crossing beyond this counts.
    #[inline(always)]
    fn t_max(&self, course: usize) -> f64 {
        match self.memory.told[course] {
            Told::Found(best) => best.t,
            _ => self.any_before.unwrap_or(f64::INFINITY),
        }
    }

    /// Takes a crossing if it is closer than the best; doubts where the two are as close as can be told.
    #[inline(always)]
    fn take(&mut self, course: usize, best: Best) {
        match self.memory.told[course] {
            Told::Doubtful => return,
            Told::Found(old) if f64::from(best.error + old.error) >= (best.t - old.t).abs() => {
                return self.end(course, Told::Doubtful);
            }
            _ => {}
        }
        if best.t < self.t_max(course) {
            self.memory.told[course] = Told::Found(best);
            self.memory.ends[course] = (best.t as f32).next_up().min(f32::MAX);
        }
    }

    /// Meets a shape by f64.
    #[inline(never)]
    fn meet_exactly(&mut self, meeting: &Meeting<'s>, start: RayStart) {
        let Meeting { course, trail, place, leaf } = *meeting;
        let course = course as usize;
        let [origin, direction] = self.memory.lines[course];
        let ray = Ray { origin, direction, ..self.asked(course).ray };
        let (_, ray) = self.root.follow(self.path_to(trail).places(), &ray);
        let shape = self.scene.primitives[leaf.primitive as usize].unit_shape();
        let local = ray.through(&leaf.unit_from_group);
        self.meet_shape_exactly(course, (trail, place), &shape, leaf.primitive, &local, start);
    }

    fn meet_shape_exactly(
        &mut self,
        course: usize,
        (trail, place): (u32, u32),
        shape: &Superquadric,
        primitive: u32,
        local: &Ray,
        start: RayStart,
    ) {
        if let Some(t_max) = self.any_before {
            if shape.occluded(local, start, t_max) {
                self.end(course, Told::Occluded);
            }
            return;
        }
        let Some(ShapeHit { t, leaving, point: unit_point }) = shape.intersect(local, start) else { return };
        // One for each ray is kept.
        let kept = match self.memory.told[course] {
            Told::Found(Best { found: Found::Exactly(kept), .. }) => kept as usize,
            _ => self.memory.exact.len(),
        };
        if t < self.t_max(course) {
            let (unit_gradient, path) = (DVec3::ZERO, InstancePath::default());
            let hit = Hit { t, leaving, primitive, unit_point, unit_gradient, path };
            match self.memory.exact.get_mut(kept) {
                Some(exact) => *exact = hit,
                None => self.memory.exact.push(hit),
            }
        }
        let found = Found::Exactly(kept as u32);
        self.take(course, Best { t, error: (1e-12 * t) as f32, trail, place, found });
    }

    /// The rays of a list that come to the box of a group go on in its space; those that are much wider meet what stands in for it.
    #[inline(always)]
    fn enter(&mut self, slot: PackedSlot, place: u32, child: u8, mut list: List) {
        let top = list.after();
        // Where many rays are in many levels the memory for them has an end: some go first.
        let inner_rays = self.memory.lines.len() - self.asked.len();
        let room = self.most_rays.saturating_sub(inner_rays) / 2;
        let count = list.count.min(room.max(STREAM_LANES) as u32);
        if count < list.count {
            let others = list.count - count;
            let others = List {
                first: list.first + count,
                count: others,
                first_near: list.first_near + count,
                // Not asked for; what comes after stays where it is.
                first_met: top.first_met - others.div_ceil(BLOCK),
            };
            self.memory.tasks.push(Task::Child { slot, child, octant: 0, list: others });
            list.count = count;
        }
        let (group, stretch, trail) = self.frame();
        let instance = &group.instances[place as usize];
        let stretch = stretch * instance.stretch;
        let size = instance.size() * stretch;
        let inner: &'s Group = &instance.group;
        let first_ray = self.memory.lines.len() as u32;
        for i in 0..list.count {
            let listed = self.memory.lists[(list.first + i) as usize];
            let course = listed.end();
            let near = self.memory.near[(list.first_near + i) as usize][child as usize % WIDTH];
            if near > self.memory.ends[course] {
                continue;
            }
            let [origin, direction] = self.memory.lines[listed.ray()];
            let ray = Ray::new(origin, direction);
            if self.memory.footprints[course].hides(size, f64::from(near)) {
                self.meet_stand_in(course, place, &ray);
                continue;
            }
            let local = ray.to_local(instance.map());
            let Some(tree) = tree_ray(inner, &local) else {
                self.end(course, Told::Doubtful);
                continue;
            };
            let listed = ListedRay::new(self.memory.lines.len() as u32, course as u32);
            self.memory.arrivals.push((octant_of(local.direction) as u8, listed));
            self.memory.lines.push([local.origin, local.direction]);
            self.memory.boxes.push(tree);
        }
        if self.memory.arrivals.is_empty() {
            return;
        }
        self.is_impatient |= self.memory.trails.len() >= self.most_trails;
        self.frames.push(Frame { group: inner, stretch, trail: self.memory.trails.len() as u32, first_ray });
        self.memory.trails.push(Trail { above: trail, place });
        self.path.push(place);
        self.memory.tasks.push(Task::Leave);
        self.list_arrivals(top);
    }

    fn leave(&mut self) {
        if let Some(frame) = self.frames.pop() {
            self.memory.lines.truncate(frame.first_ray as usize);
            self.memory.boxes.truncate(frame.first_ray as usize);
            self.path.pop();
        }
    }

    fn meet_stand_in(&mut self, course: usize, place: u32, ray: &Ray) {
        let (group, _, trail) = self.frame();
        let instance = &group.instances[place as usize];
        let stand_in = instance.group.stand_in(&self.scene.primitives);
        let place = place | InstancePath::INSTANCE;
        if self.start_at(course, place) != RayStart::Free {
            return;
        }
        // The ray as it came, of whose bits the exact way draws the same lot.
        let bits = self.memory.lines[course][1].to_array().map(f64::to_bits);
        self.path.push(place);
        let draws = chance(bits, self.path.places()) < stand_in.opacity;
        self.path.pop();
        if draws {
            let local = ray.to_local(instance.map()).through(&stand_in.unit_from_group);
            let shape = StandIn::unit_shape();
            if shape.intersect(&local, RayStart::Free).is_some_and(|hit| !hit.leaving) {
                let primitive = stand_in.main_primitive();
                self.meet_shape_exactly(course, (trail, place), &shape, primitive, &local, RayStart::Free);
            }
        }
    }
}

impl<'s> Flying<'s> {
    #[inline(always)]
    fn push(&mut self, powers: LanePowers, approach: &ShapeEntry, is_inward: bool, waiting: Waiting<'s>) {
        self.lanes.set(self.waiting.len(), powers, approach, is_inward);
        self.waiting.push(waiting);
    }

    /// Whether there may be no room for those that approach next.
    #[inline(always)]
    fn is_full(&self) -> bool {
        self.waiting.len() > STREAM_LANES - ENTRY_LANES
    }
}

/// By boxes a bit for each ray, from a bit for each box by rays: eights of them, and [`BLOCK`] at most.
#[inline(always)]
fn by_boxes(rays: &[u8]) -> [u64; WIDTH] {
    let mut boxes = [0; WIDTH];
    for (place, eight) in rays.as_chunks::<WIDTH>().0.iter().enumerate() {
        let transposed = transposed(u64::from_le_bytes(*eight)).to_le_bytes();
        for (to, bits) in boxes.iter_mut().zip(transposed) {
            *to |= u64::from(bits) << (8 * place);
        }
    }
    boxes
}

/// Eight rows of eight bits, the lowest first, with rows and columns exchanged: halves, quarters and single bits change places (Warren, Hacker's
/// Delight, 7-3).
#[inline(always)]
fn transposed(mut bits: u64) -> u64 {
    for (way, half) in [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)]
    {
        let exchanged = (bits ^ (bits >> way)) & half;
        bits ^= exchanged ^ (exchanged << way);
    }
    bits
}

/// How far along an octant the middles of a node's boxes are.
#[inline(always)]
fn places_along(node: &Node, octant: u8) -> [f32; WIDTH] {
    let mut along = [0.0; WIDTH];
    for axis in 0..3 {
        let turn = if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let bounds = node.bounds[axis].iter().zip(&node.bounds[axis + 3]);
        for (along, (least, largest)) in along.iter_mut().zip(bounds) {
            *along += turn * (least + largest);
        }
    }
    along
}

#[cfg(test)]
mod tests {
    use superegg_lang::load_text;
    use superegg_simd::Arch;

    use super::*;
    use crate::flight;

    /// A fractal of shapes in each other.
    const FRACTAL: &str = "prm ball\nexp 1 .4\ncoeff .2 .3 .1\nprm star\nexp 3 2.5\ncoeff .3 .2 .3\n\
        obj all\nap ball\nap star\nxs .3 .2 .1\nao all a\nrs 1 2 3 40\nss .8 .8 .8\nxs .3 0 0\n\
        ao all b\nrs 2 1 0 70\nss .8 .7 -.8\nxs -.3 .2 0\nao all c\nss .6 .6 .6\nxs 0 -.9 .4\n";

    #[test]
    fn bits_by_rays_are_the_same_by_boxes() {
        for count in [8usize, 24, 64] {
            let rays: Vec<u8> = (0..count).map(|ray| (ray * ray * 37 + ray) as u8).collect();
            let boxes = by_boxes(&rays);
            for (place, bits) in boxes.into_iter().enumerate() {
                let expected = (0..count).fold(0, |all, ray| all | u64::from(rays[ray] >> place & 1) << ray);
                assert_eq!(bits, expected);
            }
        }
    }

    #[test]
    fn bounds_on_memory_change_no_answer() {
        let (session, diagnostics) = load_text("stream.scn", FRACTAL);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = CompiledScene::compile(session.scene(), Some("all"), 7);
        let root = scene.root.as_deref().unwrap();
        let rays: Vec<FlightRay> = (0..3_000)
            .map(|i| {
                let a = f64::from(i);
                let origin = DVec3::new((1.3 * a).sin(), (0.7 * a).cos(), (2.9 * a).sin()) * 1.2;
                // Of one octant, so that lists are long.
                let direction = DVec3::new((2.1 * a).cos(), (1.1 * a).sin(), (0.37 * a).cos()).abs();
                Ray::new(origin, direction).into()
            })
            .collect();
        for any_before in [None, Some(1.0)] {
            let mut stream = Stream::new(&scene, root, any_before);
            (stream.most_rays, stream.most_trails) = (100, 8);
            Arch::new().dispatch(flight::Run { stream: &mut stream, rays: &rays });
            assert!(stream.memory.lines.capacity() <= 2 * rays.len(), "{}", stream.memory.lines.capacity());
            // Those of found crossings stay.
            let most_trails = if any_before.is_some() { 50 } else { 2_500 };
            assert!(stream.memory.trails.len() < most_trails, "{}", stream.memory.trails.len());
            let (mut found, mut doubtful) = (0, 0);
            for (place, asked) in rays.iter().enumerate() {
                let told = stream.told(place);
                let expected = scene.intersect(&asked.ray, None);
                match (*told, any_before) {
                    (Told::Found(best), None) => {
                        found += 1;
                        let expected = expected.unwrap();
                        assert_eq!(stream.path(&best), expected.path);
                        let (_, scale) = scale_to_unit(asked.ray.direction).unwrap();
                        assert!((best.t * scale - expected.t).abs() < 1e-4 * (1.0 + expected.t));
                    }
                    (Told::Nothing, None) => assert!(expected.is_none()),
                    (Told::Doubtful, _) => doubtful += 1,
                    (told, _) => {
                        let stopped = scene.occluded(&asked.ray, None, 1.0);
                        assert_eq!(matches!(told, Told::Occluded), stopped, "{asked:?}");
                    }
                }
            }
            assert!(any_before.is_some() || found > 200, "{found}");
            assert!(doubtful < 100, "{doubtful}");
        }
    }
}
