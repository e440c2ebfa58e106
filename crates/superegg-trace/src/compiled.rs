//! The compiled scene: what rays hit.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use num_bigint::BigUint;
use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::kernels::LanePowers;
use superegg_geom::{Aabb, Exponents, Ray, Superquadric, Transform};
use superegg_scene::Material;

use crate::beam::Kind;
use crate::bvh::{Node, TreeSpace};
use crate::path::InstancePath;
use crate::stand_in::StandIn;
use crate::stream::Spare;

/// A primitive as a child of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    /// From the group's space to that of the unit shape: the radii are in it.
    pub(crate) unit_from_group: DAffine3,
    /// By its place in [`CompiledScene::primitives`].
    pub(crate) primitive: u32,
    pub(crate) name: NameRef,
    /// The primitive's, which need not be looked up then.
    pub(crate) lane_powers: Option<LanePowers>,
}

impl Leaf {
    /// An instance of a primitive, the one at a place among `primitives`.
    pub(crate) fn new(
        unit_from_group: DAffine3,
        primitive: u32,
        name: NameRef,
        primitives: &[CompiledPrimitive],
    ) -> Self {
        let shape = primitives[primitive as usize].unit_shape();
        let lane_powers = shape.as_convex().map(|shape| LanePowers::of(&shape));
        Self { unit_from_group, primitive, name, lane_powers }
    }
}

/// A group as a child of a group.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub(crate) parent_from_child: Transform,
    pub(crate) group: Arc<Group>,
    pub(crate) name: NameRef,
    /// At most by so much does the map stretch a length.
    pub(crate) stretch: f64,
}

/// The way a child is called: a place in its group's [`Group::names`], or in [`Group::chains`] where levels of one child were folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NameRef(u32);

impl NameRef {
    const CHAIN: u32 = 1 << 31;
    /// The root itself, which has no alias.
    pub(crate) const ROOT: Self = Self(u32::MAX);

    pub(crate) fn child(place: u32) -> Self {
        Self(place)
    }

    pub(crate) fn chain(place: u32) -> Self {
        Self(place | Self::CHAIN)
    }

    /// The place among the names of the group, where it is one.
    pub(crate) fn as_child(self) -> Option<u32> {
        (self.0 & Self::CHAIN == 0).then_some(self.0)
    }
}

/// The aliases of an object's children, in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    text: String,
    ends: Vec<u32>,
}

impl Names {
    pub(crate) fn with_capacity(count: usize) -> Self {
        Self { text: String::with_capacity(8 * count), ends: Vec::with_capacity(count) }
    }

    /// Gives back room that is not used.
    pub(crate) fn shrink(&mut self) {
        self.text.shrink_to_fit();
    }

    pub(crate) fn push(&mut self, name: &str) {
        self.text.push_str(name);
        self.ends.push(self.text.len() as u32);
    }

    /// All of them, one after the other.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn get(&self, place: u32) -> &str {
        let place = place as usize;
        let start = if place == 0 { 0 } else { self.ends[place - 1] };
        &self.text[start as usize..self.ends[place] as usize]
    }
}

/// Aliases of levels that were folded into one, from the top down.
pub(crate) type Chain = Vec<(Arc<Names>, u32)>;

/// An object opened to some remaining depth. Children that come to nothing are left out.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) instances: Vec<Instance>,
    /// The tree over both, in a space of its own.
    pub(crate) nodes: Vec<Node>,
    pub(crate) space: TreeSpace,
    /// Around everything, in the group's space.
    pub(crate) bounds: Aabb,
    pub(crate) names: Arc<Names>,
    pub(crate) chains: Vec<Chain>,
    /// How many primitives it stands for.
    pub(crate) count: BigUint,
    /// What all of its content comes from, to tell whether it has changed.
    pub(crate) signature: u64,
    /// The surface of all boxes of the tree, as a multiple of what it was when the tree was built: 1 unless leaves were patched since.
    pub(crate) growth: f64,
    /// What is seen instead of it where it is too small to be opened.
    pub(crate) stand_in: OnceLock<StandIn>,
}

impl Group {
    /// The aliases that a child adds to a path.
    fn push_name(&self, name: NameRef, path: &mut String) {
        let mut push = |names: &Names, place: u32| {
            path.push('/');
            path.push_str(names.get(place));
        };
        if name == NameRef::ROOT {
            return;
        }
        if name.0 & NameRef::CHAIN == 0 {
            return push(&self.names, name.0);
        }
        self.chains[(name.0 & !NameRef::CHAIN) as usize]
            .iter()
            .for_each(|(names, place)| push(names, *place));
    }

    /// Adds what a child is called to a chain.
    pub(crate) fn extend_chain(&self, name: NameRef, chain: &mut Chain) {
        if name.0 & NameRef::CHAIN == 0 {
            chain.push((self.names.clone(), name.0));
        } else if name != NameRef::ROOT {
            chain.extend_from_slice(&self.chains[(name.0 & !NameRef::CHAIN) as usize]);
        }
    }

    /// The group that instances lead to, one after the other from here, and a ray in its space.
    pub(crate) fn follow(&self, places: &[u32], ray: &Ray) -> (&Self, Ray) {
        places.iter().fold((self, *ray), |(group, ray), &place| {
            let instance = &group.instances[place as usize];
            (&*instance.group, ray.to_local(instance.map()))
        })
    }

    /// The place among the object's children, which settles ties.
    fn rank(&self, name: NameRef) -> u32 {
        match name {
            NameRef::ROOT => 0,
            NameRef(place) if place & NameRef::CHAIN == 0 => place,
            NameRef(chain) => {
                self.chains[(chain & !NameRef::CHAIN) as usize].first().map_or(0, |(_, place)| *place)
            }
        }
    }

    /// Memory that it holds beyond its children's, in bytes.
    fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.leaves.capacity() * size_of::<Leaf>()
            + self.instances.capacity() * size_of::<Instance>()
            + self.nodes.capacity() * size_of::<Node>()
    }
}

/// A primitive, ready to be hit and shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompiledPrimitive {
    /// The semi-axes.
    pub radii: DVec3,
    /// The exponents.
    pub exponents: Exponents,
    /// The index of its material in [`CompiledScene::materials`].
    pub material: u32,
}

impl CompiledPrimitive {
    /// The shape with semi-axes 1: hits are computed in its space.
    pub fn unit_shape(&self) -> Superquadric {
        Superquadric::unit(self.exponents)
    }
}

/// How large boxes of children that are groups are, against boxes that were made of the eight corners of the child's own box: the part that
/// boxes would have swollen by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Swelling {
    /// Children that are groups.
    pub instances: u64,
    /// The mean over them of the surface area of the box of eight corners, as a multiple of that of the box in use.
    pub avoided: f64,
}

/// A scene as a graph of groups, shared wherever the same object is opened to the same depth.
#[derive(Clone, Debug)]
pub struct CompiledScene {
    pub(crate) primitives: Vec<CompiledPrimitive>,
    pub(crate) materials: Vec<Material>,
    pub(crate) root: Option<Arc<Group>>,
    pub(crate) root_name: String,
    /// The groups by object and remaining depth.
    pub(crate) opened: HashMap<(Box<str>, u32), Arc<Group>>,
    pub(crate) instance_count: BigUint,
    pub(crate) swelling: Swelling,
    pub(crate) reused_groups: usize,
    pub(crate) patched_groups: usize,
    pub(crate) reaches_depth: bool,
    /// Memory for streams of rays.
    pub(crate) spare: Spare,
}

impl CompiledScene {
    /// The primitive that a hit names by its index. Panics for an index of another scene.
    pub fn primitive(&self, index: u32) -> &CompiledPrimitive {
        &self.primitives[index as usize]
    }

    /// The materials of all primitives, each once.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The material of a primitive.
    pub fn material_of(&self, primitive: &CompiledPrimitive) -> &Material {
        &self.materials[primitive.material as usize]
    }

    /// How many groups the graph has.
    pub fn group_count(&self) -> usize {
        self.opened.len()
    }

    /// How many of them were taken over from the scene that this one was made from by [`CompiledScene::recompile`].
    pub fn reused_group_count(&self) -> usize {
        self.reused_groups
    }

    /// How many groups have the tree of the scene before, with some leaves changed.
    pub fn patched_group_count(&self) -> usize {
        self.patched_groups
    }

    /// How many instances of primitives the picture stands for: exact, however many.
    pub fn instance_count(&self) -> &BigUint {
        &self.instance_count
    }

    /// Whether some object was left out because it would be opened deeper than was asked for.
    pub fn reaches_depth(&self) -> bool {
        self.reaches_depth
    }

    /// What the refined boxes of groups spare.
    pub fn swelling(&self) -> Swelling {
        self.swelling
    }

    /// The memory of primitives, groups and trees, in bytes.
    pub fn bytes(&self) -> usize {
        self.primitives.capacity() * size_of::<CompiledPrimitive>()
            + self.materials.capacity() * size_of::<Material>()
            + self.opened.values().map(|group| group.bytes()).sum::<usize>()
    }

    /// The box around everything, in world units; `None` for an empty scene.
    pub fn bounds(&self) -> Option<Aabb> {
        self.root.as_ref().map(|root| root.bounds)
    }

    /// The name of an instance: the root's name and the aliases down to the primitive, joined by `/`.
    pub fn path_name(&self, path: &InstancePath) -> String {
        let mut name = self.root_name.clone();
        self.walk(path, |group, child| group.push_name(child, &mut name));
        name
    }

    /// Whether the surface at the end of a path lets light through.
    pub fn lets_light_through(&self, path: &InstancePath) -> bool {
        let PathEnd::Leaf(_, leaf) = self.groups_along(path).1 else { return false };
        let material = self.primitives[leaf.primitive as usize].material;
        self.materials[material as usize].refracted.is_some_and(|share| share > 0.0)
    }

    /// The places of a path's children among the children of their objects: of two paths the one with the smaller list comes first.
    pub(crate) fn rank(&self, path: &InstancePath) -> Vec<u32> {
        let mut ranks = Vec::with_capacity(path.places().len());
        self.walk(path, |group, child| ranks.push(group.rank(child)));
        ranks
    }

    /// What tells instances apart in a picture: a hash of the places of a path's children among the children of their objects, above
    /// [`InstancePath::FLOOR_ID`]. It does not depend on the order of leaves in their tree.
    pub fn instance_id(&self, path: &InstancePath) -> u32 {
        let mut hash = 0x811c_9dc5;
        let mut mix = |place: u32| hash = u32::wrapping_mul(hash ^ place, 0x0100_0193).rotate_left(15);
        self.walk(path, |group, child| mix(group.rank(child)));
        if path.is_stand_in() {
            mix(InstancePath::INSTANCE);
        }
        (hash ^ (hash >> 16)).max(InstancePath::FLOOR_ID + 1)
    }

    fn walk(&self, path: &InstancePath, mut visit: impl FnMut(&Group, NameRef)) {
        let (passed, end) = self.groups_along(path);
        for (group, place) in &passed {
            visit(group, group.instances[*place as usize].name);
        }
        match end {
            PathEnd::Leaf(group, leaf) => visit(group, leaf.name),
            PathEnd::StandIn(group, instance) => visit(group, instance.name),
            PathEnd::Nowhere => {}
        }
    }

    /// The groups that a path goes through with the place of the instance that it takes in each, and where it ends.
    pub(crate) fn groups_along<'a>(&'a self, path: &InstancePath) -> (Vec<(&'a Group, u32)>, PathEnd<'a>) {
        let (Some(mut group), Some((&last, above))) = (self.root.as_deref(), path.places().split_last())
        else {
            return (Vec::new(), PathEnd::Nowhere);
        };
        let mut passed = Vec::with_capacity(above.len());
        for &place in above {
            passed.push((group, place));
            group = &group.instances[place as usize].group;
        }
        let end = if last & InstancePath::INSTANCE == 0 {
            PathEnd::Leaf(group, &group.leaves[last as usize])
        } else {
            PathEnd::StandIn(group, &group.instances[(last & !InstancePath::INSTANCE) as usize])
        };
        (passed, end)
    }

    /// The map from the world to the unit shape at the end of a path, and what stands there.
    pub fn unit_from_world(&self, path: &InstancePath) -> (DAffine3, Kind) {
        let (passed, end) = self.groups_along(path);
        let above = passed.iter().fold(DAffine3::IDENTITY, |map, (group, place)| {
            *group.instances[*place as usize].map().inverse() * map
        });
        match end {
            PathEnd::Leaf(_, leaf) => (leaf.unit_from_group * above, Kind::Primitive(leaf.primitive)),
            PathEnd::StandIn(_, instance) => {
                let stand_in = instance.group.stand_in(&self.primitives);
                (stand_in.unit_from_group * *instance.map().inverse() * above, Kind::StandIn)
            }
            PathEnd::Nowhere => (DAffine3::NAN, Kind::StandIn),
        }
    }
}

/// Where a path ends.
pub(crate) enum PathEnd<'a> {
    /// At a primitive of a group.
    Leaf(&'a Group, &'a Leaf),
    /// At a child of a group that is seen as a whole.
    StandIn(&'a Group, &'a Instance),
    /// It is empty.
    Nowhere,
}
