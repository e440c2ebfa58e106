//! The shapes that the rays of a tile may hit, and their paths.

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::kernels::packet::PacketShape;
use superegg_geom::kernels::refine::refine_powers;
use superegg_geom::{Ray, RayStart, Superquadric, inverse_of, scale_to_unit};

use crate::ray::lottery::PathHash;
use crate::ray::query::Hit;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::Target;
use crate::scene::path::InstancePath;
use crate::scene::proxy::Proxy;

/// Beyond this distance in unit space the rounding of points on rays is too large to refine hits in batches.
const MOST_DISTANCE: f64 = 4096.0;

/// The columns of a linear map in f32, such as that from gradients to normals.
pub type Columns = [[f32; 3]; 3];

/// A shape that some ray of the tile may hit.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The map from the world to the unit shape.
    pub unit_from_world: DAffine3,
    /// The owner of the shape.
    pub target: Target,
    /// The path, as a node of [`Paths`].
    pub(super) path: PathId,
    /// The shape for refining hits in batches. `None` if each hit is refined by itself.
    pub(super) refined: Option<RefinedShape>,
    /// The shape as the f32 kernels see it. `None` if they see only a convex shape around it.
    pub(super) packet_shape: Option<PacketShape>,
}

impl Candidate {
    /// The map from the unit shape to the world.
    pub fn world_from_unit(&self) -> DAffine3 {
        inverse_of(&self.unit_from_world)
    }
}

/// A convex shape in f64, seen from the rays' origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct RefinedShape {
    /// The rays' origin in unit space.
    pub(super) origin: DVec3,
    pub(super) powers: [f64; 2],
}

/// The closest hit of one ray, in f64.
#[derive(Clone, Copy, Debug)]
pub struct CandidateHit {
    /// The hit is at `origin + t * direction`.
    pub t: f64,
    /// The index of the candidate.
    pub candidate: u32,
    /// The point in the space of the unit shape.
    pub unit_point: DVec3,
    /// The gradient of N there.
    pub gradient: DVec3,
    /// Whether the ray leaves the shape.
    pub leaving: bool,
}

/// A shape in the world that is about to be tested.
pub(super) struct TestShape {
    pub(super) unit_from_world: DAffine3,
    /// The rays' origin in unit space.
    pub(super) origin: DVec3,
    pub(super) shape: Superquadric,
    /// The part of the light that it stops: below 1 for a proxy.
    pub(super) opacity: f64,
    /// The last index of the path.
    pub(super) index: u32,
    pub(super) target: Target,
}

/// A node of [`Paths`]; `None` for the root.
pub(super) type PathId = Option<NodeId>;

/// The index of a node, plus 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NodeId(std::num::NonZeroU32);

/// A path as a linked list: the node above, and the index of the child there.
#[derive(Clone, Copy, Debug)]
struct PathNode {
    above: PathId,
    index: u32,
    /// A hash of the whole path.
    hash: PathHash,
}

/// Paths that share their beginnings.
#[derive(Debug, Default)]
pub(super) struct Paths(Vec<PathNode>);

impl Paths {
    fn node(&self, NodeId(id): NodeId) -> &PathNode {
        &self.0[id.get() as usize - 1]
    }

    /// Adds a path: the child `index` below a node.
    pub(super) fn push(&mut self, above: PathId, index: u32) -> PathId {
        let hash = self.hash(above, index);
        self.0.push(PathNode { above, index, hash });
        std::num::NonZeroU32::new(self.0.len() as u32).map(NodeId)
    }

    /// A hash of the path to the child `index` below a node.
    pub(super) fn hash(&self, above: PathId, index: u32) -> PathHash {
        above.map_or(PathHash::ROOT, |above| self.node(above).hash).child(index)
    }

    pub(super) fn instance_path(&self, id: PathId) -> InstancePath {
        let mut indices = smallvec::SmallVec::<[u32; 16]>::new();
        let mut at = id;
        while let Some(id) = at {
            let PathNode { above, index, .. } = *self.node(id);
            indices.push(index);
            at = above;
        }
        let mut path = InstancePath::default();
        indices.into_iter().rev().for_each(|index| path.push(index));
        path
    }
}

/// The candidates of a tile.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    pub(super) list: Vec<Candidate>,
    pub(super) paths: Paths,
}

impl Candidates {
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.paths.0.clear();
    }

    pub(super) fn get(&self, candidate: u32) -> &Candidate {
        &self.list[candidate as usize]
    }

    pub(super) fn path(&self, candidate: u32) -> InstancePath {
        self.paths.instance_path(self.get(candidate).path)
    }

    /// The index of the next candidate.
    pub(super) fn next(&self) -> u32 {
        self.list.len() as u32
    }

    /// Removes the candidates from this one on.
    pub(super) fn truncate(&mut self, first: u32) {
        self.list.truncate(first as usize);
    }

    /// Adds a candidate below a node. `origin` is the rays' origin in the world.
    pub(super) fn push(
        &mut self,
        above: PathId,
        tested: &TestShape,
        origin: DVec3,
        packet_shape: Option<PacketShape>,
    ) {
        let path = self.paths.push(above, tested.index);
        let TestShape { unit_from_world, shape, target, .. } = *tested;
        let origin = unit_from_world.transform_point3(origin);
        let distance = origin.abs().max_element();
        let is_in_batches = shape.is_convex() && distance > 1.0 && distance <= MOST_DISTANCE;
        let refined = is_in_batches.then(|| RefinedShape { origin, powers: refine_powers(&shape) });
        self.list.push(Candidate { unit_from_world, path, target, refined, packet_shape });
    }

    /// Whether a candidate is the child `index` below a node. `hash` is that of its path.
    pub(super) fn is_same_path(&self, candidate: u32, hash: PathHash, above: PathId, index: u32) -> bool {
        let Some(id) = self.get(candidate).path else { return false };
        let node = self.paths.node(id);
        if node.hash != hash || node.index != index {
            return false;
        }
        let (mut a, mut b) = (node.above, above);
        while a != b {
            let (Some(node_a), Some(node_b)) = (a, b) else { return false };
            let (node_a, node_b) = (self.paths.node(node_a), self.paths.node(node_b));
            if node_a.index != node_b.index {
                return false;
            }
            (a, b) = (node_a.above, node_b.above);
        }
        true
    }

    /// Adds a candidate for a hit of another query.
    pub(super) fn adopt(&mut self, scene: &CompiledScene, hit: &Hit) -> CandidateHit {
        let (unit_from_world, target) = scene.unit_from_world(&hit.path);
        let path = hit.path.indices().iter().fold(None, |above, &index| self.paths.push(above, index));
        let candidate = self.next();
        let shape = unit_shape(scene, target);
        self.list.push(Candidate { unit_from_world, path, target, refined: None, packet_shape: None });
        CandidateHit {
            t: hit.t,
            candidate,
            unit_point: hit.unit_point,
            gradient: shape.norm().value_and_gradient(hit.unit_point).1,
            leaving: hit.leaving,
        }
    }

    /// The first hit of a ray on a candidate, in f64.
    pub(super) fn intersect(&self, scene: &CompiledScene, ray: &Ray, candidate: u32) -> Option<CandidateHit> {
        let Candidate { unit_from_world, target, .. } = self.get(candidate);
        let hit = unit_shape(scene, *target).intersect(&ray.through(unit_from_world), RayStart::Free)?;
        let gradient = self.gradient(scene, candidate, hit.point);
        Some(CandidateHit { t: hit.t, candidate, unit_point: hit.point, gradient, leaving: hit.leaving })
    }

    /// The gradient of N at a point on a candidate.
    pub(super) fn gradient(&self, scene: &CompiledScene, candidate: u32, unit_point: DVec3) -> DVec3 {
        unit_shape(scene, self.get(candidate).target).norm().value_and_gradient(unit_point).1
    }
}

pub(super) fn unit_shape(scene: &CompiledScene, target: Target) -> Superquadric {
    match target {
        Target::Primitive(primitive) => scene.primitives.unit_shape(primitive),
        Target::Proxy => Proxy::unit_shape(),
    }
}

/// Scales beyond this power of two are left to f64.
const MOST_EXPONENT: i32 = 90;

/// A linear map in f32 and the power of two that it was scaled by; `None` beyond the range of f32.
pub fn f32_columns(linear: &DMat3) -> Option<(Columns, f64)> {
    let largest = linear.x_axis.abs().max(linear.y_axis.abs()).max(linear.z_axis.abs());
    let (_, scale) = scale_to_unit(largest)?;
    let exponent = (scale.to_bits() >> 52) as i32 - 1023;
    if exponent.abs() > MOST_EXPONENT {
        return None;
    }
    let column = |v: DVec3| (v * scale).as_vec3().to_array();
    Some(([column(linear.x_axis), column(linear.y_axis), column(linear.z_axis)], scale))
}
