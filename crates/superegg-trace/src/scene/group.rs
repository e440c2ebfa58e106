//! Groups: the nodes of the compiled scene graph.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use num_bigint::BigUint;
use superegg_geom::glam::DAffine3;
use superegg_geom::kernels::LanePowers;
use superegg_geom::{Aabb, Ray, Transform};
use superegg_scene::row_name;

use super::node::{Node, TreeSpace, WIDTH};
use super::primitive::Primitives;
use super::proxy::Proxy;

/// The last entry of an instance path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A primitive, by its index.
    Primitive(u32),
    /// The proxy of a group that was too small to be opened.
    Proxy,
}

/// A primitive as a child of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    /// From the group's space to that of the unit shape. It includes the semi-axes.
    pub(crate) unit_from_group: DAffine3,
    /// The index in [`CompiledScene::primitives`](crate::CompiledScene).
    pub(crate) primitive: u32,
    pub(crate) name: NameRef,
    /// A copy of the primitive's powers, which spares the lookup. `None` if the shape is not convex.
    pub(crate) lane_powers: Option<LanePowers>,
}

impl Leaf {
    /// An instance of the primitive of this index in `primitives`.
    pub(crate) fn new(
        unit_from_group: DAffine3,
        primitive: u32,
        name: NameRef,
        primitives: &Primitives,
    ) -> Self {
        let shape = primitives.unit_shape(primitive);
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
    /// An upper bound on the factor by which the map stretches a length.
    pub(crate) stretch: f64,
}

impl Instance {
    /// The diameter of the child's box, in the child's space.
    pub(crate) fn size(&self) -> f64 {
        self.group.size()
    }

    /// Parent from child.
    pub(crate) fn map(&self) -> &Transform {
        &self.parent_from_child
    }
}

/// The name of a leaf or an instance: an index in its group's [`Group::names`], or in [`Group::folded`] if it belongs to a
/// child that was folded into the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NameRef(u32);

impl NameRef {
    const FOLDED: u32 = 1 << 31;
    /// The root itself, which has no alias.
    pub(crate) const ROOT: Self = Self(u32::MAX);

    pub(crate) fn child(index: u32) -> Self {
        Self(index)
    }

    pub(crate) fn folded(index: u32) -> Self {
        Self(index | Self::FOLDED)
    }

    /// The index among the names of the group; `None` for the content of a folded child and the root.
    pub(crate) fn as_child(self) -> Option<u32> {
        (self.0 & Self::FOLDED == 0).then_some(self.0)
    }

    /// The index among the folded names of the group; `None` for a child and the root.
    fn as_folded(self) -> Option<usize> {
        (self != Self::ROOT && self.0 & Self::FOLDED != 0).then_some((self.0 & !Self::FOLDED) as usize)
    }
}

/// The aliases of a container's children, in their order.
#[derive(Clone, Debug)]
pub(crate) enum Names {
    /// The aliases of an object's children.
    Listed {
        /// All aliases, one after the other.
        text: String,
        /// The end of each.
        ends: Vec<u32>,
    },
    /// The rows of a table, by their ids if it has some.
    Rows(Option<Arc<[i64]>>),
}

impl Default for Names {
    fn default() -> Self {
        Self::listed([])
    }
}

impl Names {
    pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut list = NameList::default();
        names.into_iter().for_each(|name| list.push(name));
        list.finish()
    }

    pub(crate) fn get(&self, index: u32) -> Cow<'_, str> {
        match (self, self.alias(index)) {
            (_, Some(alias)) => Cow::Borrowed(alias),
            (Self::Listed { .. }, None) => Cow::Borrowed(""),
            (Self::Rows(ids), None) => Cow::Owned(row_name(ids.as_deref(), index as usize)),
        }
    }

    /// The alias of this index; `None` for the row of a table.
    pub(crate) fn alias(&self, index: u32) -> Option<&str> {
        let index = index as usize;
        match self {
            Self::Listed { text, ends } => {
                let start = if index == 0 { 0 } else { ends[index - 1] };
                Some(&text[start as usize..ends[index] as usize])
            }
            Self::Rows(_) => None,
        }
    }
}

/// Aliases that become [`Names::Listed`].
#[derive(Default)]
pub(crate) struct NameList {
    text: String,
    ends: Vec<u32>,
}

impl NameList {
    pub(crate) fn with_capacity(count: usize) -> Self {
        Self { text: String::new(), ends: Vec::with_capacity(count) }
    }

    pub(crate) fn push(&mut self, name: &str) {
        self.text.push_str(name);
        self.ends.push(self.text.len() as u32);
    }

    pub(crate) fn finish(self) -> Names {
        let Self { mut text, mut ends } = self;
        text.shrink_to_fit();
        ends.shrink_to_fit();
        Names::Listed { text, ends }
    }
}

/// The name of a leaf or an instance of a child that was folded into a group. It shares the names of the child, which may be
/// folded ones too, so a name takes the same memory at every depth.
#[derive(Clone, Debug)]
pub(crate) struct FoldedName {
    /// The index of the child.
    pub(crate) child: u32,
    pub(crate) group: Arc<Group>,
    /// The name in the group of the child.
    pub(crate) name: NameRef,
}

/// An object opened to a remaining depth. Empty children are left out.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) instances: Vec<Instance>,
    /// The tree over leaves and instances, in the space of the next field.
    pub(crate) nodes: Vec<Node>,
    pub(crate) space: TreeSpace,
    /// The box around everything, in the group's space.
    pub(crate) bounds: Aabb,
    pub(crate) names: Arc<Names>,
    pub(crate) folded: Vec<FoldedName>,
    /// The work of a ray in this group, as [`Group::work_with`] counts it. Limits on work use it.
    pub(crate) work: u32,
    /// Whether the object has only one child that counts. Instance ids leave out such levels.
    pub(crate) has_one_child: bool,
    /// The number of instances of primitives, including those left out as duplicates.
    pub(crate) count: BigUint,
    /// A hash of everything that the group is compiled from. Equal signatures mean equal content.
    pub(crate) signature: u64,
    /// The surface area of all boxes of the tree, as a multiple of that when the tree was built. It differs from 1 once
    /// leaves have been patched.
    pub(crate) growth: f64,
    /// The level-of-detail proxy, made when it is first needed.
    pub(crate) proxy: OnceLock<Proxy>,
}

impl Group {
    /// Visits the levels of a name from this group down: each with the index of its child, `None` for the root itself.
    pub(crate) fn for_each_level(&self, name: NameRef, mut visit: impl FnMut(&Self, Option<u32>)) {
        let (mut group, mut name) = (self, name);
        while let Some(folded) = name.as_folded() {
            let folded = &group.folded[folded];
            visit(group, Some(folded.child));
            (group, name) = (&folded.group, folded.name);
        }
        visit(group, name.as_child());
    }

    /// The number of leaves and instances.
    pub(crate) fn item_count(&self) -> usize {
        self.leaves.len() + self.instances.len()
    }

    /// Whether a name belongs to a folded child of several items.
    pub(crate) fn was_in_group(&self, name: NameRef) -> bool {
        name.as_folded().is_some_and(|folded| self.folded[folded].group.item_count() > 1)
    }

    /// The work of a ray in a group with these folded names, as a number of groups without them. Rays pass by most of a
    /// wide tree.
    pub(crate) fn work_with(folded: &[FoldedName]) -> u32 {
        let count = folded.iter().filter(|name| name.group.item_count() > 1).count();
        1 + (count.min(WIDTH * WIDTH) / WIDTH) as u32
    }

    /// The diameter of the box.
    pub(crate) fn size(&self) -> f64 {
        2.0 * self.bounds.half_extent().length()
    }

    /// Follows instances down from this group. Returns the last group and the ray in its space.
    pub(crate) fn follow(&self, indices: &[u32], ray: &Ray) -> (&Self, Ray) {
        indices.iter().fold((self, *ray), |(group, ray), &index| {
            let instance = &group.instances[index as usize];
            (&*instance.group, ray.to_local(instance.map()))
        })
    }

    /// The memory of the group without its children's, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.leaves.capacity() * size_of::<Leaf>()
            + self.instances.capacity() * size_of::<Instance>()
            + self.nodes.capacity() * size_of::<Node>()
            + self.folded.capacity() * size_of::<FoldedName>()
    }
}
