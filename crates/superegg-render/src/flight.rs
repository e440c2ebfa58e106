//! Rays that have nothing in common, thirty-two in flight at a time.
//!
//! Each ray goes its own way through the graph, by boxes eight at a time, until it comes to a shape whose own box it meets. There it waits until all
//! have come so far; then the lanes meet their shapes at once. As in [`crate::beam`] that makes candidates, the closest one is settled in
//! f64, and where the lanes cannot tell the ray goes the exact way.

use pulp::{Arch, Simd, WithSimd};
use superegg_geom::glam::DVec3;
use superegg_geom::lanes::flight::{BoxRay, FLIGHT, FlightAnswers, FlightLanes, meet_boxes};
use superegg_geom::lanes::settle::{SettleBatch, SettleRay, settle_powers};
use superegg_geom::{Ray, RayStart, Superquadric, scale_to_unit};

use crate::bvh::{PackedSlot, Slot, WIDTH};
use crate::compiled::{CompiledScene, Group};
use crate::footprint::{Footprint, chance};
use crate::path::InstancePath;
use crate::stand_in::StandIn;
use crate::traverse::{Departure, Hit};

/// A ray and what is asked of it.
#[derive(Clone, Debug)]
pub struct FlightRay {
    /// The ray.
    pub ray: Ray,
    /// What is known of its start.
    pub departure: Option<Departure>,
    /// Its width.
    pub footprint: Footprint,
}

impl From<Ray> for FlightRay {
    fn from(ray: Ray) -> Self {
        Self { ray, departure: None, footprint: Footprint::NONE }
    }
}

impl CompiledScene {
    /// The first crossing on each of many rays: the answers of [`CompiledScene::intersect_footprint`], found in flights.
    pub fn intersect_many(&self, rays: &[FlightRay]) -> Vec<Option<Hit>> {
        let Some(root) = self.root.as_deref().filter(|_| !rays.is_empty()) else {
            return vec![None; rays.len()];
        };
        let mut flight = Flight::new(self, rays, root, None);
        Arch::new().dispatch(Run(&mut flight));
        flight.settle();
        flight.found
    }

    /// Whether each of many rays is stopped with 0 <= t < `t_max`: the answers of [`CompiledScene::occluded_footprint`].
    pub fn occluded_many(&self, rays: &[FlightRay], t_max: f64) -> Vec<bool> {
        let Some(root) = self.root.as_deref().filter(|_| !rays.is_empty()) else {
            return vec![false; rays.len()];
        };
        let mut flight = Flight::new(self, rays, root, Some(t_max));
        Arch::new().dispatch(Run(&mut flight));
        flight.occluded
    }
}

/// The part of a flight that the lanes of the machine compile for.
struct Run<'a, 's>(&'a mut Flight<'s>);

impl WithSimd for Run<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(simd);
    }
}

struct Flight<'s> {
    scene: &'s CompiledScene,
    rays: &'s [FlightRay],
    root: &'s Group,
    /// The end of the rays where only occlusion is asked.
    any_before: Option<f64>,
    next: usize,
    found: Vec<Option<Hit>>,
    occluded: Vec<bool>,
    /// Crossings still to be settled: the rays, and what brings each t back to lengths of the ray's own direction.
    batch: SettleBatch,
    unsettled: Vec<(usize, f64)>,
}

/// A group that a ray is in.
#[derive(Clone, Copy)]
struct Frame<'s> {
    group: &'s Group,
    ray: Ray,
    tree: BoxRay,
    stretch: f64,
}

/// A place still to be visited.
#[derive(Clone, Copy)]
struct Pending {
    slot: PackedSlot,
    /// The t at which the ray enters its box; [`UP`] stands for the way back to the group above.
    near: f32,
}

const UP: f32 = -1.0;

/// A shape that a ray waits to meet.
struct Waiting {
    shape: Superquadric,
    primitive: u32,
    place: u32,
    local: Ray,
    /// The t where the ray enters the box, and what brings a way in unit space to a t.
    entry: f64,
    t_per_way: f64,
    /// The ray starts there, and perhaps in the shape.
    is_inside_box: bool,
}

/// The closest crossing so far.
struct Best {
    error: f64,
    path: InstancePath,
    primitive: u32,
    /// For one that is not settled yet: the shape and the ray in its space.
    open: Option<(Superquadric, Ray)>,
    unit_point: DVec3,
    leaving: bool,
}

/// One ray on its way.
struct Traveller<'s> {
    index: usize,
    /// What brings t back to lengths of the ray's own direction.
    scale: f64,
    footprint: Footprint,
    departure: Option<&'s Departure>,
    frame: Frame<'s>,
    above: Vec<Frame<'s>>,
    pending: Vec<Pending>,
    path: InstancePath,
    t_max: f64,
    best: Option<Best>,
    waiting: Option<Waiting>,
    /// Set where the lanes cannot tell.
    is_doubtful: bool,
    is_occluded: bool,
}

/// Scales beyond this are f64's.
const FARTHEST: f64 = 1e25;

/// A ray as the boxes of a group's tree see it; `None` where f32 cannot hold it.
#[inline(always)]
fn tree_ray(group: &Group, ray: &Ray) -> Option<BoxRay> {
    let origin = (ray.origin - group.space.center) * group.space.scale;
    let direction = ray.direction * group.space.scale;
    let (size, pace) = (origin.abs().max_element(), direction.abs().max_element());
    if !(size < FARTHEST && pace < FARTHEST && pace > 1.0 / FARTHEST) {
        return None;
    }
    let pad = 5e-7 * (size + 2.0);
    let mut tree = BoxRay { first_origin: [0.0; 3], last_origin: [0.0; 3], inverse: [0.0; 3] };
    for axis in 0..3 {
        let inverse = (1.0 / direction[axis]).clamp(-1e30, 1e30) as f32;
        // The face that is met first is moved towards the ray, the other one away.
        let pad = if inverse >= 0.0 { pad } else { -pad };
        tree.first_origin[axis] = (origin[axis] + pad) as f32;
        tree.last_origin[axis] = (origin[axis] - pad) as f32;
        tree.inverse[axis] = inverse;
    }
    Some(tree)
}

impl<'s> Flight<'s> {
    fn new(
        scene: &'s CompiledScene,
        rays: &'s [FlightRay],
        root: &'s Group,
        any_before: Option<f64>,
    ) -> Self {
        let (found, occluded) = match any_before {
            None => (vec![None; rays.len()], Vec::new()),
            Some(_) => (Vec::new(), vec![false; rays.len()]),
        };
        let (batch, unsettled) = (SettleBatch::default(), Vec::new());
        Self { scene, rays, root, any_before, next: 0, found, occluded, batch, unsettled }
    }

    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let mut lanes = FlightLanes::default();
        let mut answers = FlightAnswers::default();
        let mut travellers: Vec<Traveller<'s>> = (0..FLIGHT).map(|_| Traveller::nobody(self.root)).collect();
        // No closures here: those are not compiled for the machine's lanes.
        let mut flying = Vec::with_capacity(FLIGHT);
        for (lane, traveller) in travellers.iter_mut().enumerate() {
            if self.start_next(traveller) {
                flying.push(lane);
            }
        }
        loop {
            let mut count = 0;
            for place in 0..flying.len() {
                let lane = flying[place];
                if self.go_on(simd, &mut travellers[lane], &mut lanes, lane) {
                    flying[count] = lane;
                    count += 1;
                } else {
                    lanes.unset(lane);
                }
            }
            flying.truncate(count);
            if flying.is_empty() {
                return;
            }
            if let Some(t_max) = self.any_before {
                lanes.occlude(simd, &mut answers);
                for &lane in &flying {
                    travellers[lane].take_occlusion(lane, &answers, t_max);
                }
            } else {
                lanes.meet(simd, &mut answers);
                for &lane in &flying {
                    if travellers[lane].take_crossing(lane, &answers) {
                        self.meet_from_inside(&mut travellers[lane]);
                    }
                }
            }
        }
    }

    /// Goes on with a ray, and with the next ones in its place, until one waits for a shape; false where there are no more.
    #[inline(always)]
    fn go_on<S: Simd>(
        &mut self,
        simd: S,
        traveller: &mut Traveller<'s>,
        lanes: &mut FlightLanes,
        lane: usize,
    ) -> bool {
        while !self.advance(simd, traveller, lanes, lane) {
            self.finish(traveller);
            if !self.start_next(traveller) {
                return false;
            }
        }
        true
    }

    /// Sends the next ray off in the place of one that is done; false where there is none. Rays that f32 cannot hold are answered at once.
    #[inline(always)]
    fn start_next(&mut self, traveller: &mut Traveller<'s>) -> bool {
        loop {
            let index = self.next;
            let Some(asked) = self.rays.get(index) else { return false };
            self.next += 1;
            let Some((direction, scale)) = scale_to_unit(asked.ray.direction) else { continue };
            // Occlusion counts t in the ray's own lengths.
            let (direction, scale) =
                if self.any_before.is_some() { (asked.ray.direction, 1.0) } else { (direction, scale) };
            let ray = Ray { direction, ..asked.ray };
            let Some(tree) = tree_ray(self.root, &ray) else {
                self.answer_exactly(index);
                continue;
            };
            traveller.index = index;
            traveller.scale = scale;
            traveller.frame = Frame { group: self.root, ray, tree, stretch: 1.0 };
            traveller.footprint = Footprint { spread: asked.footprint.spread * scale, ..asked.footprint };
            traveller.departure = asked.departure.as_ref();
            traveller.above.clear();
            traveller.pending.clear();
            traveller.pending.push(Pending { slot: PackedSlot::new(Slot::Node(0)), near: 0.0 });
            traveller.path.clear();
            traveller.t_max = self.any_before.unwrap_or(f64::INFINITY);
            traveller.best = None;
            traveller.waiting = None;
            traveller.is_doubtful = false;
            traveller.is_occluded = false;
            return true;
        }
    }

    fn answer_exactly(&mut self, index: usize) {
        let FlightRay { ray, departure, footprint } = &self.rays[index];
        match self.any_before {
            None => self.found[index] = self.scene.intersect_footprint(ray, departure.as_ref(), *footprint),
            Some(t_max) => {
                let stops = self.scene.occluded_footprint(ray, departure.as_ref(), t_max, *footprint);
                self.occluded[index] = stops;
            }
        }
    }

    #[inline(always)]
    fn finish(&mut self, done: &mut Traveller<'s>) {
        if done.is_doubtful {
            return self.answer_exactly(done.index);
        }
        if self.any_before.is_some() {
            self.occluded[done.index] = done.is_occluded;
            return;
        }
        let Some(best) = done.best.take() else { return };
        if let Some((shape, local)) = best.open {
            let Ray { origin, direction, .. } = local;
            self.batch.push(&SettleRay { origin, direction, t: done.t_max, powers: settle_powers(&shape) });
            self.unsettled.push((done.index, done.scale));
        }
        let Best { path, primitive, unit_point, leaving, .. } = best;
        self.found[done.index] =
            Some(Hit { t: done.t_max * done.scale, leaving, primitive, unit_point, path });
    }

    /// Settles in f64 what the lanes have found.
    fn settle(&mut self) {
        self.batch.run();
        for (place, (index, scale)) in std::mem::take(&mut self.unsettled).into_iter().enumerate() {
            match (self.batch.get(place), &mut self.found[index]) {
                (Some((hit, _)), Some(found)) => {
                    found.t = hit.t * scale;
                    found.unit_point = hit.point;
                }
                _ => self.answer_exactly(index),
            }
        }
    }

    /// Goes on until the ray waits for a shape (true) or has come to its end.
    #[inline(always)]
    fn advance<S: Simd>(
        &self,
        simd: S,
        ray: &mut Traveller<'s>,
        lanes: &mut FlightLanes,
        lane: usize,
    ) -> bool {
        while let Some(Pending { slot, near }) = ray.pending.pop() {
            if near == UP {
                if let Some(frame) = ray.above.pop() {
                    ray.frame = frame;
                    ray.path.pop();
                }
                continue;
            }
            if f64::from(near) > ray.t_max {
                continue;
            }
            if ray.is_doubtful || ray.is_occluded {
                return false;
            }
            match slot.unpack() {
                Slot::Node(node) => {
                    let node = &ray.frame.group.nodes[node as usize];
                    let t_max = (ray.t_max as f32).next_up();
                    let mut near = [0.0; WIDTH];
                    let met = meet_boxes(simd, &node.bounds, &ray.frame.tree, t_max, &mut near);
                    let mut met = met & ((1 << node.count) - 1);
                    // The nearest on top.
                    let mut found = [Pending { slot: PackedSlot::default(), near: 0.0 }; WIDTH];
                    let mut count = 0;
                    while met != 0 {
                        let place = met.trailing_zeros() as usize % WIDTH;
                        met &= met - 1;
                        let new = Pending { slot: node.slots[place], near: near[place] };
                        let mut at = count;
                        while at > 0 && found[at - 1].near < new.near {
                            found[at] = found[at - 1];
                            at -= 1;
                        }
                        found[at] = new;
                        count += 1;
                    }
                    ray.pending.extend_from_slice(&found[..count]);
                }
                Slot::Leaf(place) => {
                    if self.prepare(ray, place, lanes, lane) {
                        return true;
                    }
                }
                Slot::Instance(place) => self.enter(ray, place, f64::from(near)),
            }
        }
        false
    }

    fn enter(&self, ray: &mut Traveller<'s>, place: u32, near: f64) {
        let instance = &ray.frame.group.instances[place as usize];
        let stretch = ray.frame.stretch * instance.stretch;
        if ray.footprint.hides(instance.size() * stretch, near) {
            return self.meet_stand_in(ray, place);
        }
        let local = ray.frame.ray.to_local(instance.map());
        let group: &'s Group = &instance.group;
        match tree_ray(group, &local) {
            None => ray.is_doubtful = true,
            Some(tree) => {
                ray.above.push(ray.frame);
                ray.path.push(place);
                ray.frame = Frame { group, ray: local, tree, stretch };
                ray.pending.push(Pending { slot: PackedSlot::default(), near: UP });
                ray.pending.push(Pending { slot: PackedSlot::new(Slot::Node(0)), near: near as f32 });
            }
        }
    }

    fn meet_stand_in(&self, ray: &mut Traveller<'s>, place: u32) {
        let instance = &ray.frame.group.instances[place as usize];
        let stand_in = instance.group.stand_in(&self.scene.primitives);
        ray.path.push(place | InstancePath::INSTANCE);
        let is_own = Departure::start_at(ray.departure, &ray.path) != RayStart::Free;
        ray.path.pop();
        if is_own {
            return;
        }
        let place = place | InstancePath::INSTANCE;
        ray.path.push(place);
        // The ray as it came, of whose bits the exact way draws the same lot.
        let origin_frame = ray.above.first().unwrap_or(&ray.frame);
        let bits = origin_frame.ray.direction.to_array().map(f64::to_bits);
        let draws = chance(bits, ray.path.places()) < stand_in.opacity;
        ray.path.pop();
        if draws {
            let local = ray.frame.ray.to_local(instance.map()).through(&stand_in.unit_from_group);
            let shape = StandIn::unit_shape();
            if shape.intersect(&local, RayStart::Free).is_some_and(|hit| !hit.leaving) {
                let primitive = stand_in.main_primitive();
                self.meet_exactly(ray, place, &shape, primitive, &local, RayStart::Free);
            }
        }
    }

    /// Brings the ray into a leaf's space. True where it is to meet the shape in the lanes; where that is not for the lanes it is done here.
    #[inline(always)]
    fn prepare(&self, ray: &mut Traveller<'s>, place: u32, lanes: &mut FlightLanes, lane: usize) -> bool {
        let leaf = &ray.frame.group.leaves[place as usize];
        let map = &leaf.unit_from_group;
        let (o, d) =
            (map.transform_point3(ray.frame.ray.origin), map.transform_vector3(ray.frame.ray.direction));
        let length_squared = d.dot(d);
        let nearest = -o.dot(d) / length_squared;
        let c = o + nearest * d;
        // The ball around the box. A number that is none goes the exact way.
        if c.dot(c) > 3.000_01 {
            return false;
        }
        let inverse = d.recip();
        let (to_middle, half) = (-c * inverse, inverse.abs() * BOX);
        let enter = (to_middle - half).max_element();
        let leave = (to_middle + half).min_element();
        let primitive = &self.scene.primitives[leaf.primitive as usize];
        let is_inside_box = o.abs().max_element() <= 1.0 + 1e-6;
        // Directions along an axis make infinities, which order themselves but for one in a face.
        if enter > leave || (nearest + leave < 0.0 && !is_inside_box) || nearest + enter > ray.t_max {
            return false;
        }
        let shape = primitive.unit_shape();
        let is_own = ray.departure.is_some_and(|departure| {
            departure.path.places().last() == Some(&place) && {
                ray.path.push(place);
                let is_own = departure.path == ray.path;
                ray.path.pop();
                is_own
            }
        });
        let start = match ray.departure {
            Some(departure) if is_own => departure.start(),
            _ => RayStart::Free,
        };
        if is_own && start == RayStart::SurfaceOutward && shape.is_convex() {
            return false;
        }
        let is_finite = enter.is_finite() && leave.is_finite() && nearest.is_finite();
        let is_far = o.abs().max_element() > 1e4;
        let only_asks = self.any_before.is_some();
        if is_own || (is_inside_box && only_asks) || is_far || !is_finite || !shape.is_convex() {
            let local = ray.frame.ray.through(map);
            self.meet_exactly(ray, place, &shape, leaf.primitive, &local, start);
            return false;
        }
        let size = length_squared.sqrt();
        let end = leave.min(ray.t_max * (1.0 + END) - nearest);
        let enter = if is_inside_box { -nearest } else { enter };
        let start_point = if is_inside_box { o } else { c + enter * d };
        let start_point = start_point.as_vec3().to_array();
        lanes.set(lane, &shape, start_point, (d / size).as_vec3().to_array(), ((end - enter) * size) as f32);
        ray.waiting = Some(Waiting {
            shape,
            primitive: leaf.primitive,
            place,
            local: Ray { origin: o, direction: d, origin_error: 0.0 },
            entry: nearest + enter,
            t_per_way: 1.0 / size,
            is_inside_box,
        });
        true
    }

    /// Meets the shape that a ray waits for by f64.
    fn meet_from_inside(&self, ray: &mut Traveller<'s>) {
        if let Some(Waiting { shape, primitive, place, .. }) = ray.waiting.take() {
            let local = ray.frame.ray.through(&ray.frame.group.leaves[place as usize].unit_from_group);
            self.meet_exactly(ray, place, &shape, primitive, &local, RayStart::Free);
        }
    }

    /// Meets a shape by f64.
    fn meet_exactly(
        &self,
        ray: &mut Traveller<'s>,
        place: u32,
        shape: &Superquadric,
        primitive: u32,
        local: &Ray,
        start: RayStart,
    ) {
        if self.any_before.is_some() {
            ray.is_occluded |= shape.occluded(local, start, ray.t_max);
            return;
        }
        if let Some(hit) = shape.intersect(local, start) {
            let best = Best {
                error: 1e-12 * hit.t,
                path: InstancePath::default(),
                primitive,
                open: None,
                unit_point: hit.point,
                leaving: hit.leaving,
            };
            ray.take(hit.t, place, &best);
        }
    }
}

/// Boxes are taken so much larger, for rounding.
const BOX: f64 = 1.0 + 1e-6;
/// So near to its start a ray may be in the shape.
const START: f32 = 1e-4;
/// Ends of rays are known to this part of their t.
const END: f64 = 4e-6;

impl<'s> Traveller<'s> {
    /// One that is not on its way.
    fn nobody(root: &'s Group) -> Self {
        let tree = BoxRay { first_origin: [0.0; 3], last_origin: [0.0; 3], inverse: [0.0; 3] };
        let ray = Ray::new(DVec3::ZERO, DVec3::X);
        Self {
            index: 0,
            scale: 1.0,
            footprint: Footprint::NONE,
            departure: None,
            frame: Frame { group: root, ray, tree, stretch: 1.0 },
            above: Vec::new(),
            pending: Vec::with_capacity(64),
            path: InstancePath::default(),
            t_max: 0.0,
            best: None,
            waiting: None,
            is_doubtful: false,
            is_occluded: false,
        }
    }

    /// Takes a crossing if it is closer than the best; doubts where the two are as close as can be told.
    #[inline(always)]
    fn take(&mut self, t: f64, place: u32, best: &Best) {
        let old_error = self.best.as_ref().map_or(0.0, |best| best.error);
        if self.best.is_some() && (t - self.t_max).abs() <= best.error + old_error {
            self.is_doubtful = true;
        }
        if t < self.t_max {
            self.t_max = t;
            self.path.push(place);
            self.best = Some(Best { path: self.path.clone(), ..*best });
            self.path.pop();
        }
    }

    /// True where the ray still waits: it starts in the shape, or too near to tell.
    #[inline(always)]
    fn take_crossing(&mut self, lane: usize, answers: &FlightAnswers) -> bool {
        let Some(waiting) = self.waiting.take() else { return false };
        let way = answers.way.0[lane];
        if way == f32::INFINITY {
            return false;
        }
        if waiting.is_inside_box && way <= START {
            self.waiting = Some(waiting);
            return true;
        }
        let t = waiting.entry + f64::from(way) * waiting.t_per_way;
        let error = f64::from(answers.error.0[lane]) * waiting.t_per_way;
        if answers.doubt.0[lane] > 0.0 {
            // A grazing ray, which may be behind the best.
            self.is_doubtful |= t - error < self.t_max;
            return false;
        }
        let best = Best {
            error,
            path: InstancePath::default(),
            primitive: waiting.primitive,
            open: Some((waiting.shape, waiting.local)),
            unit_point: DVec3::ZERO,
            leaving: false,
        };
        self.take(t, waiting.place, &best);
        false
    }

    #[inline(always)]
    fn take_occlusion(&mut self, lane: usize, answers: &FlightAnswers, t_max: f64) {
        let Some(waiting) = self.waiting.take() else { return };
        let way = answers.way.0[lane];
        let t = waiting.entry + f64::from(way) * waiting.t_per_way;
        let is_certain = way < f32::INFINITY && t < t_max * (1.0 - END) && t > 0.0;
        if is_certain {
            self.is_occluded = true;
        } else if way < f32::INFINITY || answers.doubt.0[lane] > 0.0 {
            let local = Ray { origin_error: self.local_error(waiting.place), ..waiting.local };
            self.is_occluded |= waiting.shape.occluded(&local, RayStart::Free, t_max);
        }
    }

    /// The error of the ray's origin in the space of a leaf.
    fn local_error(&self, place: u32) -> f64 {
        let leaf = &self.frame.group.leaves[place as usize];
        self.frame.ray.through(&leaf.unit_from_group).origin_error
    }
}
