//! Rays that share an origin, a tile of them at a time: those of a camera, and shadow rays seen from the light.
//!
//! The rays go through the graph together, sixteen in a register. A node's box is asked for each packet of sixteen that met its parent, leaves by the
//! f32 lanes. What the lanes find is a candidate; the closest one is settled in f64 by Newton's method from where the lanes found it, which proves that
//! it is the shape's first crossing. Where the lanes cannot tell (two surfaces at the same place, a grazing ray, an origin within a shape's box)
//! the ray goes the exact way of [`crate::traverse`].

use std::sync::Arc;

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::kernels::packet::{
    ALL_LANES, ConeWidth, DirectionBoxes, DirectionRange, LaneCompactor, MAX_PACKETS, NodeBoxes, PACKET,
    PacketBatch, PacketColumn, PacketHits, PacketIntervals, PacketKernels, PacketShape, PacketSurfaces,
    PacketVectors, PacketVectors64, PerPacket, RANGE,
};
use superegg_geom::kernels::refine::{RefineBatch, RefineRay, refine_powers};
use superegg_geom::{Ray, RayStart, Superquadric, inverse_of, scale_to_unit, unit_vector};

use crate::bvh::Slot;
use crate::compiled::{CompiledScene, Group, Instance};
use crate::footprint::{Footprint, chance};
use crate::path::InstancePath;
use crate::pencil::Pencil;
use crate::stand_in::StandIn;
use crate::traverse::{Departure, Hit};

/// Rays of a packet.
pub const LANES: usize = PACKET;
/// Rays of a beam at most: as many packets as a mask has bits.
pub const MOST_RAYS: usize = MAX_PACKETS * PACKET;
/// The rounding of a direction and a map in f32, as a part of the way, with room.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;
/// The least tolerance of N in f32.
const LEAST_TOLERANCE: f64 = 1.5e-6;
/// With a larger one the lanes tell nothing.
const MOST_TOLERANCE: f64 = 0.03;
/// Scales beyond this many powers of two are f64's.
const MOST_EXPONENT: i32 = 90;
/// Where the lanes are off by less than this part of a pixel's width, what they tell is shaded as it is.
const NEAR: f64 = 1.0 / 64.0;
/// From further away points on rays are not exact enough to be settled together.
const MOST_DISTANCE: f64 = 4096.0;

/// A shape that was found on some ray of the tile.
#[derive(Clone, Debug)]
pub struct Candidate {
    pub unit_from_world: DAffine3,
    /// The path, as a node of the tile's paths.
    path: u32,
    pub kind: Kind,
    /// How its crossings are settled together; `None` where each goes by itself.
    lens: Option<Lens>,
    /// What the lanes know of it; `None` of what they only know a shape around.
    seen: Option<PacketShape>,
}

/// A convex shape as f64 sees it from the beam's origin.
#[derive(Clone, Copy, Debug)]
struct Lens {
    /// The beam's origin in unit space.
    origin: DVec3,
    powers: [f64; 2],
}

/// A place in a group's tree that packets have still to visit.
#[derive(Clone, Copy, Debug)]
struct Pending {
    slot: Slot,
    mask: u32,
    /// How near it is, along the middle of the beam.
    near: f32,
}

/// What a candidate is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A primitive, by its number.
    Primitive(u32),
    /// A group that stands in as a whole.
    StandIn,
}

/// The closest crossing on one ray.
#[derive(Clone, Copy, Debug)]
pub struct BeamHit {
    pub t: f64,
    pub candidate: u32,
    pub unit_point: DVec3,
    /// The gradient of N there.
    pub gradient: DVec3,
    pub leaving: bool,
}

/// A place in the graph as a linked list: the node above, and the place taken there.
#[derive(Clone, Copy, Debug)]
struct PathNode {
    above: u32,
    place: u32,
    /// A hash of the whole path.
    key: u32,
}

const NO_NODE: u32 = u32::MAX;
/// Stands for the candidate of a shadow ray that starts on none.
pub const NO_CANDIDATE: u32 = u32::MAX;

/// A group that is open.
#[derive(Debug)]
struct Frame {
    group: Arc<Group>,
    path: u32,
    group_from_world: DAffine3,
    /// The world's lengths are at most this many times the group's.
    stretch: f64,
    /// The beam's origin in the group's space.
    group_origin: DVec3,
    /// The same in the tree's space.
    tree_origin: DVec3,
    /// What brings a beam's t into the tree's.
    t_scale: f32,
    pad: [f32; 3],
    /// By this t (of the beam) every ray has passed the group.
    passed: f64,
    /// The longest direction in the tree's space, for the beam's t.
    longest: f64,
    /// A direction in the middle, in the tree's space.
    middle: DVec3,
    intervals: PacketIntervals,
    /// Where the reciprocals of the directions in the tree's space begin.
    first_inverse: usize,
}

/// The largest coordinates of a beam's directions, whatever their signs.
fn largest(directions: &DirectionRange) -> DVec3 {
    directions.least.abs().max(directions.most.abs())
}

/// No direction of a beam has a lesser part along `row`, whatever its sign.
fn least_along(directions: &DirectionRange, row: DVec3) -> f64 {
    let DirectionRange { least, most, .. } = *directions;
    (row.dot(0.5 * (least + most)).abs() - row.abs().dot(0.5 * (most - least))).max(0.0)
}

/// Where a shadow ray of a tile starts.
#[derive(Clone, Copy, Debug)]
pub struct ShadowStart {
    /// The candidate on whose surface, or [`NO_CANDIDATE`].
    pub own: u32,
    /// Where it goes from there.
    pub start: RayStart,
}

/// A shadow ray of a tile.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// From the surface to the light, t = 1 there.
    pub ray: Ray,
    /// Its width at the surface.
    pub width: f64,
}

/// Shadow rays of a tile in the order of their lanes. Neighbours on one surface have neighbouring rays, so they are to be beside each other.
#[derive(Clone, Copy)]
pub struct ShadowRays<'a> {
    /// The rays backwards, from the light: they end at t = 1.
    pub from_light: &'a Pencil,
    pub starts: &'a [ShadowStart],
    /// All of a ray, by its number: few are asked for.
    pub ray: &'a dyn Fn(usize) -> ShadowRay,
}

/// What the rays of a tile see first.
#[derive(Debug, Default)]
pub struct Sight {
    /// What is left to f64: the rays, and what each meets.
    pub hits: Vec<(u32, BeamHit)>,
    /// The other surfaces, which the lanes tell of, some of them as f64 has settled them, and the rays' directions.
    pub surfaces: Vec<PacketSurfaces>,
    pub directions: Vec<PacketVectors>,
    /// The candidates in them.
    pub told: Vec<Told>,
    /// What brings t back to that of the rays as they came.
    pub t_scale: f64,
    /// None of the directions is longer.
    reach: f64,
}

/// A candidate that lanes tell of.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    pub packet: usize,
    pub candidate: u32,
    /// A bit for each.
    pub lanes: u32,
}

/// A candidate that rays of a packet meet first.
#[derive(Clone, Copy, Debug)]
struct Met {
    told: Told,
    /// The lanes that are near enough to be told of.
    near: u32,
}

impl Sight {
    /// A crossing that the lanes tell of: the candidate, its t for the ray as it came, and by how much it may be off in the world.
    pub fn told(&self, ray: usize) -> (u32, f64, f64) {
        let (surfaces, lane) = (&self.surfaces[ray / PACKET], ray % PACKET);
        let t = f64::from(surfaces.t.0[lane]) * self.t_scale;
        (surfaces.id.0[lane], t, self.reach * f64::from(surfaces.error.0[lane]))
    }

    /// Has the lanes tell of a crossing that f64 found; `map` has the columns of the map from gradients to normals. `false` where they would be off by more
    /// than `width`, or cannot hold it.
    fn tell(&mut self, ray: u32, hit: &BeamHit, map: [[f32; 3]; 3], width: ConeWidth) -> bool {
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

/// The state of a tile.
pub struct Beam<'s> {
    scene: &'s CompiledScene,
    kernels: PacketKernels,
    pub candidates: Vec<Candidate>,
    paths: Vec<PathNode>,
    /// The rays' directions, scaled, and the boxes around those of each packet.
    directions: Vec<PacketVectors>,
    direction_boxes: DirectionBoxes,
    hits: Vec<PacketHits>,
    /// By packets the largest t of the beam that still counts for some ray; negative where none asks.
    ends: PerPacket,
    /// Lanes, by packet, whose ray has to go the exact way.
    exact: Vec<u32>,
    compactor: LaneCompactor,
    batch: RefineBatch,
    unsettled: Vec<Unsettled>,
    met: Vec<Met>,
    /// Of each packet of shadow rays the candidate from which all of them come outwards ([`NO_CANDIDATE`] where there is none such).
    packet_own: Vec<u32>,
    /// The nodes of open groups that are still to be visited.
    pending: Vec<Pending>,
    /// The reciprocals of directions in the spaces of open groups.
    inverses: Vec<PacketVectors>,
    /// How many of them are those of groups that are open.
    open_inverses: usize,
    /// The beam's origin, in the world.
    origin: DVec3,
    box_of_directions: DirectionRange,
    middle: DVec3,
    footprint: Footprint,
}

/// A crossing that is settled with others.
#[derive(Clone, Copy, Debug)]
struct Unsettled {
    ray: u32,
    candidate: u32,
    /// Where it was found, and by how much that may be off.
    t: f64,
    error: f64,
}

/// What a beam is asked.
enum Question<'a> {
    /// The closest crossing of each ray.
    Closest { rays: &'a Pencil },
    /// Whether there is one before the end.
    Any { shadow: ShadowRays<'a>, occluded: Vec<u32> },
}

impl Question<'_> {
    fn ray(&self, i: usize) -> Option<Ray> {
        match self {
            Self::Closest { rays } => (i < rays.count()).then(|| rays.ray(i)),
            Self::Any { shadow, .. } => (i < shadow.starts.len()).then(|| (shadow.ray)(i).ray),
        }
    }
}

impl<'s> Beam<'s> {
    pub fn new(scene: &'s CompiledScene) -> Self {
        Self {
            scene,
            kernels: PacketKernels::default(),
            candidates: Vec::new(),
            paths: Vec::new(),
            directions: Vec::new(),
            direction_boxes: DirectionBoxes::NONE,
            hits: Vec::new(),
            ends: PerPacket::splat(-1.0),
            exact: Vec::new(),
            compactor: LaneCompactor::default(),
            batch: RefineBatch::default(),
            unsettled: Vec::new(),
            met: Vec::new(),
            packet_own: Vec::new(),
            pending: Vec::new(),
            inverses: Vec::new(),
            open_inverses: 0,
            origin: DVec3::ZERO,
            box_of_directions: DirectionRange { scale: 1.0, least: DVec3::ZERO, most: DVec3::ZERO },
            middle: DVec3::ZERO,
            footprint: Footprint::NONE,
        }
    }

    /// Forgets the candidates of the tile before.
    pub fn start_tile(&mut self) {
        self.candidates.clear();
        self.paths.clear();
    }

    /// The path of a candidate.
    pub fn path(&self, candidate: u32) -> InstancePath {
        self.instance_path(self.candidates[candidate as usize].path)
    }

    fn instance_path(&self, mut node: u32) -> InstancePath {
        let mut places = Vec::new();
        while node != NO_NODE {
            places.push(self.paths[node as usize].place);
            node = self.paths[node as usize].above;
        }
        let mut path = InstancePath::default();
        places.into_iter().rev().for_each(|place| path.push(place));
        path
    }

    /// The closest crossing of each ray, settled in f64. There are at most [`MOST_RAYS`].
    pub fn closest(&mut self, rays: &Pencil, footprint: Footprint, sight: &mut Sight) {
        self.closest_but(rays, footprint, Footprint::NONE, sight, |_, _| None);
    }

    /// The same but for candidates of which `told_by_lanes` gives the columns of the map from gradients to normals. Lanes tell of those: where they are
    /// right to a small part of a pixel's width what they know is enough, and elsewhere what f64 has settled.
    pub fn closest_but(
        &mut self,
        rays: &Pencil,
        footprint: Footprint,
        pixel: Footprint,
        sight: &mut Sight,
        mut told_by_lanes: impl FnMut(&Self, u32) -> Option<[[f32; 3]; 3]>,
    ) {
        sight.hits.clear();
        sight.told.clear();
        sight.surfaces.clear();
        sight.surfaces.resize(rays.directions().len(), PacketSurfaces::NONE);
        let Some(scale) = self.find_candidates(rays, footprint) else {
            for ray in 0..rays.count() {
                self.push_exact_hit(rays, ray, footprint, sight);
            }
            return;
        };
        (sight.t_scale, sight.reach) = (scale, largest(&self.box_of_directions).length());
        let near = NEAR / sight.reach;
        let width =
            ConeWidth { width: (near * pixel.width) as f32, spread: (near * pixel.spread * scale) as f32 };
        let mut batch = std::mem::take(&mut self.batch);
        let mut unsettled = std::mem::take(&mut self.unsettled);
        batch.clear();
        unsettled.clear();
        let mut met = std::mem::take(&mut self.met);
        met.clear();
        for packet in 0..self.hits.len() {
            let exact = self.exact[packet] & rays.asked(packet);
            let found = self.kernels.candidates(&self.hits[packet], rays.asked(packet) & !exact, width);
            for lane in lanes(found.unresolved | exact) {
                self.push_exact_hit(rays, packet * PACKET + lane, footprint, sight);
            }
            let with_lanes = found.ids.iter().zip(&found.lanes).take(found.count);
            met.extend(with_lanes.map(|(&candidate, &lanes)| Met {
                told: Told { packet, candidate, lanes },
                near: lanes & found.near,
            }));
        }
        // What is on one surface comes together.
        met.sort_unstable_by_key(|met| (met.told.candidate, met.told.packet));
        for same in met.chunk_by(|a, b| a.told.candidate == b.told.candidate) {
            let candidate = same[0].told.candidate;
            let map = told_by_lanes(self, candidate);
            let Candidate { unit_from_world, lens, seen, .. } = self.candidates[candidate as usize];
            for &Met { told: Told { packet, lanes: all, .. }, near } in same {
                let surfaces = &mut sight.surfaces[packet];
                if let (Some(shape), Some(map)) = (&seen, &map) {
                    let (directions, hits) = (&self.directions[packet], &self.hits[packet]);
                    self.kernels.surfaces(shape, map, directions, hits, near, surfaces);
                }
                let left = all & !surfaces.lanes;
                if map.is_some() {
                    sight.told.push(Told { packet, candidate, lanes: all });
                }
                for lane in lanes(left) {
                    let (ray, hits) = (packet * PACKET + lane, &self.hits[packet]);
                    let Some(Lens { origin, powers }) = lens else {
                        match self.settle(&rays.ray(ray), candidate) {
                            Some(hit) => sight.hits.push((ray as u32, hit)),
                            None => self.push_exact_hit(rays, ray, footprint, sight),
                        }
                        continue;
                    };
                    let (t, error) =
                        (f64::from(hits.t.0[lane]) * scale, f64::from(hits.error.0[lane]) * scale);
                    let direction = unit_from_world.matrix3 * rays.direction(ray);
                    batch.push(&RefineRay { origin, direction, t, powers });
                    unsettled.push(Unsettled { ray: ray as u32, candidate, t, error });
                }
            }
        }
        batch.run();
        for (place, &Unsettled { ray, candidate, t, error }) in unsettled.iter().enumerate() {
            // Where it is farther off than was said another shape may be first.
            let settled = batch.get(place).filter(|(hit, _)| (hit.t - t).abs() <= error);
            match settled {
                Some((hit, gradient)) => {
                    let unit_point = hit.point;
                    let hit = BeamHit { t: hit.t, candidate, unit_point, gradient, leaving: false };
                    let map = told_by_lanes(self, candidate);
                    if !map.is_some_and(|map| sight.tell(ray, &hit, map, width)) {
                        sight.hits.push((ray, hit));
                    }
                }
                None => self.push_exact_hit(rays, ray as usize, footprint, sight),
            }
        }
        let Sight { told, surfaces, .. } = sight;
        told.retain_mut(|told| {
            told.lanes &= surfaces[told.packet].lanes;
            told.lanes != 0
        });
        (self.batch, self.unsettled, self.met) = (batch, unsettled, met);
        std::mem::swap(&mut self.directions, &mut sight.directions);
    }

    fn push_exact_hit(&mut self, rays: &Pencil, ray: usize, footprint: Footprint, sight: &mut Sight) {
        let hit = self.exact_hit(&rays.ray(ray), footprint);
        sight.hits.extend(hit.map(|hit| (ray as u32, hit)));
    }

    /// How many rays meet something, as far as the lanes can tell.
    pub fn find(&mut self, rays: &Pencil, footprint: Footprint) -> usize {
        if self.find_candidates(rays, footprint).is_none() {
            return 0;
        }
        self.hits.iter().flat_map(|hits| hits.id.0).filter(|&id| id != u32::MAX).count()
    }

    /// Fills `hits`, and returns what brings their t back; `None` for rays that f32 cannot hold.
    fn find_candidates(&mut self, rays: &Pencil, footprint: Footprint) -> Option<f64> {
        debug_assert!(rays.count() <= MOST_RAYS);
        let scale = self.take_directions(rays.directions(), f64::INFINITY)?;
        self.footprint = Footprint { spread: footprint.spread * scale, ..footprint };
        self.traverse(rays.origin, scale, &mut Question::Closest { rays });
        Some(scale)
    }

    /// Which rays do not reach the light, at most [`MOST_RAYS`]: by packets, a bit for each lane.
    pub fn occluded(&mut self, shadow: ShadowRays<'_>, footprint_of_light: Footprint) -> Vec<u32> {
        self.packet_own.clear();
        self.packet_own.extend(shadow.starts.chunks(PACKET).map(|starts| {
            let own = starts[0].own;
            let is_own = |one: &ShadowStart| one.own == own && one.start == RayStart::SurfaceOutward;
            if starts.iter().all(is_own) { own } else { NO_CANDIDATE }
        }));
        let occluded = vec![0; shadow.from_light.directions().len()];
        let Some(scale) = self.take_directions(shadow.from_light.directions(), 1.0) else {
            let all = vec![u32::MAX; occluded.len()];
            return self.occluded_exactly(shadow, &all, occluded);
        };
        self.footprint = footprint_of_light;
        let mut question = Question::Any { shadow, occluded };
        self.traverse(shadow.from_light.origin, scale, &mut question);
        let Question::Any { occluded, .. } = question else { return Vec::new() };
        self.occluded_exactly(shadow, &self.exact, occluded)
    }

    /// Asks the exact way for the rays whose bits are set in `asked`, but for those that are stopped already.
    fn occluded_exactly(&self, shadow: ShadowRays<'_>, asked: &[u32], mut occluded: Vec<u32>) -> Vec<u32> {
        for (packet, (occluded, asked)) in occluded.iter_mut().zip(asked).enumerate() {
            for lane in lanes(asked & !*occluded & ALL_LANES) {
                let i = packet * PACKET + lane;
                let Some(&ShadowStart { own, start, .. }) = shadow.starts.get(i) else { continue };
                let ShadowRay { ray, width } = (shadow.ray)(i);
                let departure = if own == NO_CANDIDATE { None } else { Departure::of(self.path(own), start) };
                let width = Footprint { width, spread: 0.0 };
                if self.scene.occluded_footprint(&ray, departure.as_ref(), 1.0, width) {
                    *occluded |= 1 << lane;
                }
            }
        }
        occluded
    }

    /// Takes directions, all scaled by one power of two, and returns what brings a t for them back; `None` where f32 cannot hold them. Nothing beyond
    /// `end` counts.
    fn take_directions(&mut self, directions: &[PacketVectors64], end: f64) -> Option<f64> {
        self.box_of_directions = self.kernels.scale_directions(directions, &mut self.directions)?;
        let t_max = (end / self.box_of_directions.scale) as f32;
        let packets = directions.len();
        self.hits.resize(packets, PacketHits::up_to(t_max));
        self.direction_boxes =
            self.kernels.reset(&mut self.directions, &mut self.hits, &mut self.ends, t_max);
        self.exact.clear();
        self.exact.resize(packets, 0);
        let mut middle = DVec3::ZERO;
        for (packet, _) in self.directions.iter().zip(self.ends.0).filter(|(_, end)| *end > 0.0) {
            middle += DVec3::from_array(packet.each_ref().map(|column| f64::from(column.0[0])));
        }
        self.middle = middle.normalize_or_zero();
        Some(self.box_of_directions.scale)
    }

    fn traverse(&mut self, origin: DVec3, scale: f64, question: &mut Question<'_>) {
        let Some(root) = self.scene.root.clone() else { return };
        self.origin = origin;
        let mask = self.still_asking(u32::MAX);
        if origin.is_finite() && mask != 0 {
            self.visit_group(root, NO_NODE, DAffine3::IDENTITY, origin, 1.0, scale, mask, question);
        }
    }

    /// Opens a group for the packets of a mask; `None` where f32 cannot hold what it is.
    fn open(
        &mut self,
        group: Arc<Group>,
        path: u32,
        group_from_world: DAffine3,
        origin: DVec3,
        stretch: f64,
        mask: u32,
    ) -> Option<Frame> {
        let tree_from_world = group.space.tree_from_group() * group_from_world;
        let group_origin = group_from_world.transform_point3(origin);
        let tree_origin = tree_from_world.transform_point3(origin);
        let (columns, map_scale) = f32_columns(&tree_from_world.matrix3)?;
        if !tree_origin.is_finite() || tree_origin.abs().max_element() > 1e15 {
            return None;
        }
        let first_inverse = self.open_inverses;
        let end = first_inverse + self.directions.len();
        if self.inverses.len() < end {
            self.inverses.resize(end, [PacketColumn::splat(0.0); 3]);
        }
        let inverses = &mut self.inverses[first_inverse..];
        let boxes = &self.direction_boxes;
        let intervals = self.kernels.intervals(&columns, &self.directions, boxes, mask, inverses);
        self.open_inverses = end;
        let [shortest, longest] = intervals.squares;
        let distance = tree_origin.length() + 2.0;
        let passed = distance / f64::from(shortest.sqrt()) * map_scale;
        let largest = largest(&self.box_of_directions);
        let reach = |row: DVec3| row.abs().dot(largest);
        let rows = tree_from_world.matrix3.transpose();
        let passed = passed.min(1e300);
        let pad = [rows.x_axis, rows.y_axis, rows.z_axis].map(reach);
        let pad = std::array::from_fn(|axis| {
            (ROUNDING * (pad[axis] * passed + tree_origin[axis].abs() + 2.0)).min(1e18) as f32
        });
        Some(Frame {
            stretch,
            group_origin,
            tree_origin,
            t_scale: (1.0 / map_scale) as f32,
            pad,
            passed,
            longest: f64::from(longest.sqrt()) / map_scale,
            middle: tree_from_world.matrix3 * self.middle,
            intervals,
            first_inverse,
            path,
            group_from_world,
            group,
        })
    }

    #[expect(clippy::too_many_arguments, reason = "the state of a recursion")]
    fn visit_group(
        &mut self,
        group: Arc<Group>,
        path: u32,
        group_from_world: DAffine3,
        origin: DVec3,
        stretch: f64,
        scale: f64,
        mask: u32,
        question: &mut Question<'_>,
    ) {
        let Some(frame) = self.open(group, path, group_from_world, origin, stretch, mask) else {
            self.leave_to_f64(mask);
            return;
        };
        let tree_origin = frame.tree_origin.as_vec3().to_array();
        let middle = frame.middle.as_vec3().to_array();
        let bottom = self.pending.len();
        self.pending.push(Pending { slot: Slot::Node(0), mask, near: 0.0 });
        while self.pending.len() > bottom {
            let Some(Pending { slot, mask, .. }) = self.pending.pop() else { return };
            let mask = self.still_asking(mask);
            if mask == 0 {
                continue;
            }
            match slot {
                Slot::Node(node) => {
                    let node = &frame.group.nodes[node as usize];
                    let is_ordered = matches!(question, Question::Closest { .. });
                    // The lanes ask a shape's own box at once; a shadow ray is stopped before it comes to most.
                    let is_rough = |slot: &Slot| is_ordered && matches!(slot, Slot::Leaf(_));
                    let roughly = node.slots().enumerate().filter(|(_, slot)| is_rough(slot));
                    let roughly = roughly.fold(0, |roughly, (place, _)| roughly | 1 << place);
                    let boxes = NodeBoxes {
                        intervals_only: roughly,
                        bounds: &node.bounds,
                        count: node.count as usize,
                        origin: tree_origin,
                        pad: frame.pad,
                        t_scale: frame.t_scale,
                        inverses: &self.inverses[frame.first_inverse..],
                    };
                    let met = self.kernels.intersect_boxes(&boxes, &frame.intervals, &self.ends, mask);
                    let first = self.pending.len();
                    for (place, slot) in node.slots().enumerate().filter(|(place, _)| met[*place] != 0) {
                        // The nearest corner along the middle of the beam.
                        let corner = |axis: usize| {
                            let d = middle[axis];
                            (node.bounds[axis][place] * d).min(node.bounds[axis + 3][place] * d)
                        };
                        let near = if is_ordered { corner(0) + corner(1) + corner(2) } else { 0.0 };
                        self.pending.push(Pending { slot, mask: met[place], near });
                    }
                    if is_ordered {
                        self.pending[first..].sort_unstable_by(|a, b| b.near.total_cmp(&a.near));
                    }
                }
                Slot::Leaf(leaf) => self.visit_leaf(&frame, leaf, scale, mask, question),
                Slot::Instance(place) => {
                    let instance = &frame.group.instances[place as usize];
                    let stretch = frame.stretch * instance.stretch;
                    if self.is_hidden(&frame, instance, stretch, question) {
                        self.visit_stand_in(&frame, place, scale, mask, question);
                        continue;
                    }
                    let path = self.push_path(frame.path, place);
                    let child_from_world = *instance.map().inverse() * frame.group_from_world;
                    self.visit_group(
                        instance.group.clone(),
                        path,
                        child_from_world,
                        origin,
                        stretch,
                        scale,
                        mask,
                        question,
                    );
                }
            }
        }
        self.open_inverses = frame.first_inverse;
    }

    /// The packets in which some ray still asks.
    fn still_asking(&self, mask: u32) -> u32 {
        packets(mask).filter(|&packet| self.ends.0[packet] > 0.0).fold(0, |mask, packet| mask | 1 << packet)
    }

    /// Leaves all rays of a mask to the exact way.
    fn leave_to_f64(&mut self, mask: u32) {
        for packet in packets(mask) {
            self.exact[packet] = ALL_LANES;
        }
    }

    fn is_hidden(&self, frame: &Frame, instance: &Instance, stretch: f64, question: &Question<'_>) -> bool {
        let size = instance.size() * stretch;
        match question {
            Question::Closest { .. } if self.footprint == Footprint::NONE => false,
            Question::Closest { .. } => {
                // The distance to the ball around the child, in the group's space, at the pace of the fastest ray: no ray is there earlier.
                let center = instance.map().forward().transform_point3(instance.group.bounds.center());
                let radius = 0.5 * instance.size() * instance.stretch;
                let distance = (center - frame.group_origin).length() - radius;
                let pace = frame.longest / frame.group.space.scale;
                self.footprint.hides(size, (distance / pace).max(0.0))
            }
            // Every ray is wider, all along.
            Question::Any { .. } => self.footprint.hides(size, 0.0),
        }
    }

    fn push_path(&mut self, above: u32, place: u32) -> u32 {
        let above_key = if above == NO_NODE { 0x9e37_79b9 } else { self.paths[above as usize].key };
        self.paths.push(PathNode { above, place, key: path_key(above_key, place) });
        self.paths.len() as u32 - 1
    }

    /// Whether a candidate's path is the one of a place below a node, which has this hash; never of [`NO_CANDIDATE`].
    fn is_same_path(&self, candidate: u32, key: u32, above: u32, place: u32) -> bool {
        let Some(candidate) = self.candidates.get(candidate as usize) else { return false };
        let mut a = candidate.path;
        if self.paths[a as usize].key != key || self.paths[a as usize].place != place {
            return false;
        }
        a = self.paths[a as usize].above;
        let mut b = above;
        while a != b {
            if a == NO_NODE || b == NO_NODE || self.paths[a as usize].place != self.paths[b as usize].place {
                return false;
            }
            (a, b) = (self.paths[a as usize].above, self.paths[b as usize].above);
        }
        true
    }

    fn visit_leaf(&mut self, frame: &Frame, place: u32, scale: f64, mask: u32, question: &mut Question<'_>) {
        let leaf = &frame.group.leaves[place as usize];
        let primitive = &self.scene.primitives[leaf.primitive as usize];
        let target = LeafTarget {
            unit_from_world: leaf.unit_from_group * frame.group_from_world,
            origin: leaf.unit_from_group.transform_point3(frame.group_origin),
            shape: primitive.unit_shape(),
            place,
            kind: Kind::Primitive(leaf.primitive),
        };
        self.visit_target(frame, &target, scale, mask, question);
    }

    fn visit_stand_in(
        &mut self,
        frame: &Frame,
        place: u32,
        scale: f64,
        mask: u32,
        question: &mut Question<'_>,
    ) {
        let instance = &frame.group.instances[place as usize];
        let stand_in = instance.group.stand_in(&self.scene.primitives);
        let unit_from_group = stand_in.unit_from_group * *instance.map().inverse();
        let target = LeafTarget {
            unit_from_world: unit_from_group * frame.group_from_world,
            origin: unit_from_group.transform_point3(frame.group_origin),
            shape: StandIn::unit_shape(),
            place: place | InstancePath::INSTANCE,
            kind: Kind::StandIn,
        };
        let path = self.push_path(frame.path, target.place);
        let path = self.instance_path(path);
        // Only rays that draw the lot meet it; the others are put out of the way meanwhile.
        let before: Vec<(usize, PacketHits)> =
            packets(mask).map(|packet| (packet, self.hits[packet])).collect();
        for (packet, hits) in &before {
            for lane in 0..PACKET {
                let draws = |ray: &Ray| chance(ray_bits(ray), path.places()) < stand_in.opacity;
                let asks = hits.t.0[lane] > 0.0;
                if !(asks && question.ray(packet * PACKET + lane).as_ref().is_some_and(draws)) {
                    self.hits[*packet].t.0[lane] = -1.0;
                }
            }
        }
        self.visit_target(frame, &target, scale, mask, question);
        for (packet, hits) in before {
            let occluded = match question {
                Question::Any { occluded, .. } => occluded[packet],
                Question::Closest { .. } => 0,
            };
            for lane in 0..PACKET {
                if self.hits[packet].t.0[lane] < 0.0 && occluded >> lane & 1 == 0 {
                    self.hits[packet].t.0[lane] = hits.t.0[lane];
                }
            }
            self.ends.0[packet] = self.hits[packet].end();
        }
    }

    fn visit_target(
        &mut self,
        frame: &Frame,
        target: &LeafTarget,
        scale: f64,
        mask: u32,
        question: &mut Question<'_>,
    ) {
        if !target.unit_from_world.is_finite() {
            return;
        }
        let shape = self.beam_shape(frame, target);
        match question {
            Question::Closest { rays } => match shape {
                Some(shape) if target.shape.is_convex() => self.meet(frame, target, &shape, mask),
                shape => self.meet_exactly(frame, target, shape.as_ref(), rays, scale, mask),
            },
            Question::Any { shadow, occluded, .. } => {
                self.occlude(frame, target, shape.as_ref(), *shadow, occluded, mask);
            }
        }
    }

    /// A shape as the lanes see it; of one that is not convex a convex one around it. `None` where the origin is within the shape's box, or f32 cannot
    /// tell.
    fn beam_shape(&self, frame: &Frame, target: &LeafTarget) -> Option<PacketShape> {
        let linear = &target.unit_from_world.matrix3;
        let rows = linear.transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let origin_size = target.origin.abs().max_element();
        // By this t every ray has passed the group, and the box of the shape between each two of its faces.
        let passed = (0..3).fold(frame.passed, |passed, axis| {
            passed.min((target.origin[axis].abs() + 1.1) / least_along(&self.box_of_directions, rows[axis]))
        });
        let largest = largest(&self.box_of_directions);
        let along = rows.into_iter().map(|row| row.abs().dot(largest)).fold(0.0, f64::max) * passed;
        let tolerance = LEAST_TOLERANCE + ROUNDING * (along.min(1e30) + origin_size);
        if !(tolerance < MOST_TOLERANCE && origin_size > 1.01 + 4.0 * tolerance) {
            return None;
        }
        let (columns, map_scale) = f32_columns(linear)?;
        let around = Superquadric::unit(target.shape.exponents().convexified()).as_convex()?;
        let origin = target.origin.as_vec3().to_array();
        Some(PacketShape::new(&around, columns, origin, tolerance as f32, map_scale as f32))
    }

    fn push_candidate(&mut self, frame: &Frame, target: &LeafTarget, seen: Option<PacketShape>) {
        let path = self.push_path(frame.path, target.place);
        let LeafTarget { unit_from_world, shape, kind, .. } = *target;
        let origin = unit_from_world.transform_point3(self.origin);
        let distance = origin.abs().max_element();
        let is_settled_with_others = shape.is_convex() && distance > 1.0 && distance <= MOST_DISTANCE;
        let lens = is_settled_with_others.then(|| Lens { origin, powers: refine_powers(&shape) });
        self.candidates.push(Candidate { unit_from_world, path, kind, lens, seen });
    }

    fn meet(&mut self, frame: &Frame, target: &LeafTarget, shape: &PacketShape, mask: u32) {
        let id = self.candidates.len() as u32;
        let batch = PacketBatch {
            directions: &self.directions,
            hits: &mut self.hits,
            ends: &mut self.ends,
            compactor: &mut self.compactor,
        };
        if self.kernels.intersect(shape, batch, mask, id) != 0 {
            self.push_candidate(frame, target, Some(*shape));
        }
    }

    /// Each ray that may meet the shape by f64.
    fn meet_exactly(
        &mut self,
        frame: &Frame,
        target: &LeafTarget,
        around: Option<&PacketShape>,
        rays: &Pencil,
        scale: f64,
        mask: u32,
    ) {
        let id = self.candidates.len() as u32;
        let mut is_best = false;
        for packet in packets(mask) {
            let mut near = self.hits[packet];
            if let Some(shape) = around {
                let batch = PacketBatch {
                    directions: &self.directions[packet..=packet],
                    hits: std::slice::from_mut(&mut near),
                    ends: &mut PerPacket::splat(0.0),
                    compactor: &mut self.compactor,
                };
                self.kernels.intersect(shape, batch, 1, id);
            }
            for lane in 0..PACKET {
                if rays.asked(packet) >> lane & 1 == 0 {
                    continue;
                }
                let may_meet = around.is_none() || near.id.0[lane] == id || near.unresolved >> lane & 1 == 1;
                if !may_meet || self.hits[packet].t.0[lane] <= 0.0 {
                    continue;
                }
                let local = rays.ray(packet * PACKET + lane).through(&target.unit_from_world);
                if let Some(hit) = target.shape.intersect(&local, RayStart::Free) {
                    let t = (hit.t / scale) as f32;
                    self.hits[packet].insert(lane, t, 1e-6 * t, id, false);
                    is_best |= self.hits[packet].id.0[lane] == id;
                }
            }
            self.ends.0[packet] = self.hits[packet].end();
        }
        if is_best {
            self.push_candidate(frame, target, None);
        }
    }

    fn occlude(
        &mut self,
        frame: &Frame,
        target: &LeafTarget,
        shape: Option<&PacketShape>,
        shadow: ShadowRays<'_>,
        occluded: &mut [u32],
        mask: u32,
    ) {
        let above_key = if frame.path == NO_NODE { 0x9e37_79b9 } else { self.paths[frame.path as usize].key };
        let key = path_key(above_key, target.place);
        // What leaves a convex shape does not meet it again, and a stand-in does not hide itself.
        let is_left = target.shape.is_convex() || target.kind == Kind::StandIn;
        let mask = if is_left {
            packets(mask)
                .filter(|&packet| !self.is_same_path(self.packet_own[packet], key, frame.path, target.place))
                .fold(0, |mask, packet| mask | 1 << packet)
        } else {
            mask
        };
        let Self { kernels, directions, hits, compactor, .. } = self;
        let answer = shape.map(|shape| kernels.occluded(shape, directions, hits, compactor, mask));
        for packet in packets(answer.map_or(mask, |answer| answer.packets)) {
            let (hit, ask) = match &answer {
                // Of one that is not convex the lanes know only the convex shape around it.
                Some(answer) if !target.shape.is_convex() => {
                    (0, answer.hit[packet] | answer.unresolved[packet])
                }
                Some(answer) => (answer.hit[packet], answer.unresolved[packet]),
                None => (0, ALL_LANES),
            };
            let before = occluded[packet];
            for lane in lanes(hit | ask) {
                let i = packet * PACKET + lane;
                let Some(&ShadowStart { own, start, .. }) = shadow.starts.get(i) else { continue };
                if self.hits[packet].t.0[lane] <= 0.0 {
                    continue;
                }
                let is_own = self.is_same_path(own, key, frame.path, target.place);
                let leaves = start == RayStart::SurfaceOutward && is_left;
                let stops = if is_own && (leaves || target.kind == Kind::StandIn) {
                    false
                } else if is_own || ask >> lane & 1 == 1 {
                    let start = if is_own { start } else { RayStart::Free };
                    let local = (shadow.ray)(i).ray.through(&target.unit_from_world);
                    target.shape.occluded(&local, start, 1.0)
                } else {
                    true
                };
                if stops {
                    occluded[packet] |= 1 << lane;
                    self.hits[packet].t.0[lane] = -1.0;
                }
            }
            if occluded[packet] != before {
                self.ends.0[packet] = self.hits[packet].end();
            }
        }
    }

    fn shape_of(&self, candidate: u32) -> Superquadric {
        match self.candidates[candidate as usize].kind {
            Kind::Primitive(primitive) => self.scene.primitives[primitive as usize].unit_shape(),
            Kind::StandIn => StandIn::unit_shape(),
        }
    }

    /// The first crossing of a candidate, by f64 alone.
    fn settle(&self, ray: &Ray, candidate: u32) -> Option<BeamHit> {
        let shape = self.shape_of(candidate);
        let local = ray.through(&self.candidates[candidate as usize].unit_from_world);
        let hit = shape.intersect(&local, RayStart::Free)?;
        let (_, gradient) = shape.norm().value_and_gradient(hit.point);
        Some(BeamHit { t: hit.t, candidate, unit_point: hit.point, gradient, leaving: hit.leaving })
    }

    /// The closest crossing the exact way.
    fn exact_hit(&mut self, ray: &Ray, footprint: Footprint) -> Option<BeamHit> {
        let hit = self.scene.intersect_footprint(ray, None, footprint)?;
        Some(self.adopt(&hit))
    }

    /// Makes a candidate of a hit that was found otherwise.
    pub fn adopt(&mut self, hit: &Hit) -> BeamHit {
        let (unit_from_world, kind) = self.scene.unit_from_world(&hit.path);
        let shape = match kind {
            Kind::Primitive(primitive) => self.scene.primitives[primitive as usize].unit_shape(),
            Kind::StandIn => StandIn::unit_shape(),
        };
        let path = hit.path.places().iter().fold(NO_NODE, |above, &place| self.push_path(above, place));
        self.candidates.push(Candidate { unit_from_world, path, kind, lens: None, seen: None });
        BeamHit {
            t: hit.t,
            candidate: self.candidates.len() as u32 - 1,
            unit_point: hit.unit_point,
            gradient: shape.norm().value_and_gradient(hit.unit_point).1,
            leaving: hit.leaving,
        }
    }
}

impl Candidate {
    /// The map back.
    pub fn world_from_unit(&self) -> DAffine3 {
        inverse_of(&self.unit_from_world)
    }
}

/// A shape in the world.
struct LeafTarget {
    unit_from_world: DAffine3,
    /// The beam's origin in unit space.
    origin: DVec3,
    shape: Superquadric,
    place: u32,
    kind: Kind,
}

/// A linear map in f32, scaled by the power of two that is returned with it; `None` beyond the range of f32.
pub fn f32_columns(linear: &DMat3) -> Option<([[f32; 3]; 3], f64)> {
    let largest = linear.x_axis.abs().max(linear.y_axis.abs()).max(linear.z_axis.abs());
    let (_, scale) = scale_to_unit(largest)?;
    let exponent = (scale.to_bits() >> 52) as i32 - 1023;
    if exponent.abs() > MOST_EXPONENT {
        return None;
    }
    let column = |v: DVec3| (v * scale).as_vec3().to_array();
    Some(([column(linear.x_axis), column(linear.y_axis), column(linear.z_axis)], scale))
}

fn path_key(above: u32, place: u32) -> u32 {
    let mixed = (above ^ place.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
    mixed ^ (mixed >> 15)
}

/// The bits by which a ray draws lots.
pub fn ray_bits(ray: &Ray) -> [u64; 3] {
    let (direction, _) = scale_to_unit(ray.direction).unwrap_or((DVec3::ZERO, 1.0));
    direction.to_array().map(f64::to_bits)
}

fn packets(mask: u32) -> impl Iterator<Item = usize> {
    lanes(mask)
}

/// The bits that are set.
pub fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let bit = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            bit
        })
    })
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec2;
    use superegg_lang::load_text;
    use superegg_scene::Camera;

    use super::*;
    use crate::test_camera::TestCamera;

    /// Shapes of all kinds, nested, turned, mirrored, in each other, beside each other, and twice in the same place.
    const SCENE: &str = "prm ball\nprm box\nexp .1 .1\ncoeff .8 .5 .6\nprm drop\nexp .7 1.6\ncoeff .3 .9 .5\n\
        prm star\nexp 3 2.5\nprm gem\nexp 2 2\nprm flat\nexp 1 .01\ncoeff 40 40 .1\n\
        obj inner\nap box\nrs 1 2 3 40\nap ball\nss .4 .4 .4\nxs .7 .2 .5\nap drop\nss .8 -.8 .8\nxs -1 .3 0\nap star\nxs 0 -1.2 .6\n\
        obj middle\nao inner a\nss .6 .9 .5\nrs 0 1 1 70\nao inner b\nrs 1 0 0 20\nss .5 .5 .5\nxs 1.5 0 0\nap gem\nxs 0 1.6 0\n\
        obj all\nao middle m\nao middle n\nrs 0 0 1 130\nxs .5 -2.5 .4\nap flat\nxs 0 0 -1.5\nap ball\nxs 2 2 0\nap ball again\nxs 2 2 0\n\
        ap box cut\nxs 1.6 2 .3\nap ball standing\nss .5 .5 .5\nxs -2 2 -.9\n";

    fn scene() -> CompiledScene {
        let (session, diagnostics) = load_text("beam.scn", SCENE);
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

    /// The closest crossings of rays from one place.
    fn closest(beam: &mut Beam<'_>, rays: &[Ray]) -> Vec<Option<BeamHit>> {
        let (mut pencil, mut sight) = (Pencil::default(), Sight::default());
        pencil.start(rays[0].origin);
        rays.iter().for_each(|ray| pencil.push(ray.direction));
        beam.start_tile();
        beam.closest(&pencil, Footprint::NONE, &mut sight);
        let mut hits = vec![None; rays.len()];
        sight.hits.into_iter().for_each(|(ray, hit)| hits[ray as usize] = Some(hit));
        hits
    }

    #[test]
    fn beams_meet_what_single_rays_meet_and_stop_where_they_stop() {
        let scene = scene();
        let mut beam = Beam::new(&scene);
        let (mut met, mut stopped, mut exact) = (0, 0, 0);
        for view in views() {
            for rays in (0..36).map(|i| tile(&view, i)) {
                let hits = closest(&mut beam, &rays);
                exact += beam.exact.iter().map(|lanes| lanes.count_ones()).sum::<u32>();
                let light = DVec3::new(3.0, -5.0, 8.0);
                let (mut shadow_rays, mut starts) = (Vec::new(), Vec::new());
                let mut from_light = Pencil::default();
                from_light.start(light);
                for (ray, hit) in rays.iter().zip(&hits) {
                    let expected = scene.intersect(ray, None);
                    assert_eq!(hit.is_some(), expected.is_some(), "{ray:?} {hit:?} {expected:?}");
                    let (Some(hit), Some(expected)) = (hit, expected) else { continue };
                    met += 1;
                    assert!((hit.t - expected.t).abs() < 1e-9 * (1.0 + expected.t), "{hit:?} {expected:?}");
                    assert_eq!(hit.leaving, expected.leaving);
                    assert_eq!(beam.path(hit.candidate), expected.path, "{ray:?}");
                    assert!((hit.unit_point - expected.unit_point).length() < 1e-7);
                    let surface = scene.interaction(&expected);
                    let direction = light - surface.position;
                    if surface.facing_normal().dot(direction) > 0.0 {
                        let (ray, departure) = surface.spawn_ray(direction);
                        starts.push(ShadowStart { own: hit.candidate, start: departure.start() });
                        from_light.push(-direction);
                        shadow_rays.push(ShadowRay { ray, width: 0.0 });
                    }
                }
                let asked = ShadowRays { from_light: &from_light, starts: &starts, ray: &|i| shadow_rays[i] };
                let occluded = beam.occluded(asked, Footprint::NONE);
                for (i, (ShadowRay { ray, .. }, one)) in shadow_rays.iter().zip(&starts).enumerate() {
                    let occluded = occluded[i / PACKET] >> (i % PACKET) & 1 == 1;
                    let departure = Departure::of(beam.path(one.own), one.start);
                    let expected = scene.occluded(ray, departure.as_ref(), 1.0);
                    stopped += usize::from(expected);
                    assert_eq!(occluded, expected, "{ray:?}");
                }
            }
        }
        assert!(met > 20_000 && stopped > 1_000 && exact < 46_080, "{met} {stopped} {exact}");
    }

    #[test]
    fn rays_that_f32_cannot_hold_are_answered_all_the_same() {
        let scene = scene();
        let mut beam = Beam::new(&scene);
        let hostile = [0.0, -0.0, 1e-300, 1e300, f64::MAX, f64::INFINITY, f64::NAN, -1.0];
        for x in hostile {
            for origin in hostile {
                let rays: Vec<Ray> = hostile
                    .iter()
                    .map(|&y| Ray::new(DVec3::new(origin, 3.0, 5.0), DVec3::new(x, y, -1.0)))
                    .collect();
                let hits = closest(&mut beam, &rays);
                for (ray, hit) in rays.iter().zip(&hits).filter(|(ray, _)| ray.direction.is_finite()) {
                    assert_eq!(hit.is_some(), scene.intersect(ray, None).is_some(), "{ray:?}");
                }
            }
        }
    }

    #[test]
    fn flat_shapes_seen_from_afar_are_told_by_the_lanes() {
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
        let (mut beam, mut sight) = (Beam::new(&scene), Sight::default());
        let (mut told, mut met, mut pencil) = (0, 0, Pencil::default());
        for i in (0..4800).step_by(37) {
            let (x, y) = (16 * (i % 80), 16 * (i / 80));
            let film = |i: u32| DVec2::new(f64::from(x + i % 16) + 0.5, f64::from(y + i / 16) + 0.5);
            pencil.start(camera.position);
            (0..256).for_each(|i| pencil.push(view.ray(film(i)).direction));
            beam.start_tile();
            let map = |beam: &Beam<'_>, candidate: u32| {
                let to_unit = beam.candidates[candidate as usize].unit_from_world.matrix3;
                f32_columns(&to_unit.transpose()).map(|(columns, _)| columns)
            };
            beam.closest_but(&pencil, view.footprint(64), view.footprint(1), &mut sight, map);
            // What f64 has settled is known better than lanes find anything.
            let is_found_by_lanes = |packet: usize, lane: usize| {
                let PacketSurfaces { t, error, .. } = &sight.surfaces[packet];
                error.0[lane] > 2.0 * f32::EPSILON * t.0[lane]
            };
            for &Told { packet, lanes: all, .. } in &sight.told {
                met += all.count_ones();
                told += lanes(all).filter(|&lane| is_found_by_lanes(packet, lane)).count() as u32;
            }
            met += sight.hits.len() as u32;
        }
        assert!(met > 20_000 && told > met / 10 * 9, "{told} of {met}");
    }
}
