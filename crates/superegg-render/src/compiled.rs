//! The compiled scene: what rays hit.

use num_bigint::BigUint;
use superegg_geom::{Aabb, Superquadric, Transform};
use superegg_scene::Material;

use crate::bvh::Bvh;
use crate::path::InstancePath;

/// What an instance stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Target {
    /// A primitive, by its place in [`CompiledScene::primitives`].
    Primitive(u32),
    /// A group, by its place in [`CompiledScene::groups`].
    Group(u32),
}

/// One child of a group.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    pub(crate) parent_from_child: Transform,
    /// Around the child, in the group's space.
    pub(crate) bounds: Aabb,
    pub(crate) target: Target,
    /// The child's place among the children of the object, for its alias.
    pub(crate) child: u32,
}

/// An object opened to some remaining depth. Children that come to nothing are left out.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// The object, by its place in [`CompiledScene::aliases`].
    pub(crate) object: u32,
    pub(crate) instances: Vec<Instance>,
    pub(crate) bvh: Bvh,
}

/// A primitive, ready to be hit and shaded.
#[derive(Clone, Debug)]
pub(crate) struct CompiledPrimitive {
    pub(crate) shape: Superquadric,
    pub(crate) material: Material,
}

/// A scene as a graph of groups, shared wherever the same object is opened to the same depth.
#[derive(Clone, Debug)]
pub struct CompiledScene {
    pub(crate) primitives: Vec<CompiledPrimitive>,
    pub(crate) groups: Vec<Group>,
    pub(crate) root: Option<Target>,
    pub(crate) root_name: String,
    /// The aliases of each object's children.
    pub(crate) aliases: Vec<Vec<Box<str>>>,
    pub(crate) instance_count: BigUint,
}

impl CompiledScene {
    /// How many groups the graph has.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// How many instances of primitives the picture stands for: exact, however many.
    pub fn instance_count(&self) -> &BigUint {
        &self.instance_count
    }

    /// A box around everything, along the axes; `None` where there is nothing.
    pub fn bounds(&self) -> Option<Aabb> {
        let bounds = match self.root? {
            Target::Primitive(at) => {
                let radii = self.primitives[at as usize].shape.radii();
                Aabb::around(superegg_geom::glam::DVec3::ZERO, radii)
            }
            Target::Group(at) => self.groups[at as usize].bvh.bounds(),
        };
        (!bounds.is_empty()).then_some(bounds)
    }

    /// The name of an instance: the root's name and the aliases down to the primitive, joined by `/`.
    pub fn path_name(&self, path: &InstancePath) -> String {
        let mut name = self.root_name.clone();
        let mut target = self.root;
        for &index in path.indices() {
            let Some(Target::Group(group)) = target else { break };
            let group = &self.groups[group as usize];
            let instance = &group.instances[index as usize];
            name.push('/');
            name.push_str(&self.aliases[group.object as usize][instance.child as usize]);
            target = Some(instance.target);
        }
        name
    }

    /// The transforms along a path, from the root down.
    pub(crate) fn transforms<'a>(&'a self, path: &'a InstancePath) -> impl Iterator<Item = &'a Transform> {
        let mut target = self.root;
        path.indices().iter().map_while(move |&index| {
            let Some(Target::Group(group)) = target else { return None };
            let instance = &self.groups[group as usize].instances[index as usize];
            target = Some(instance.target);
            Some(&instance.parent_from_child)
        })
    }
}
