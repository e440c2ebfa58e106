//! All instances of primitives as a list.

use std::ops::ControlFlow;

use superegg_geom::Transform;
use superegg_geom::glam::DAffine3;
use superegg_geom::inverse_of;

use crate::scene::compiled::CompiledScene;
use crate::scene::group::Group;
use crate::scene::path::InstancePath;

/// An instance of a primitive with its map.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PlacedPrimitive {
    /// The instance.
    pub path: InstancePath,
    /// The index of the primitive.
    pub primitive: u32,
    /// From the space of the unit shape to the world; the semi-axes are in it.
    pub world_from_unit: DAffine3,
}

impl CompiledScene {
    /// All instances of primitives, in the order of children; `None` if there are more than `most`.
    ///
    /// Copies of a child at the same position in the same object are one instance, as for rays.
    pub fn placed_primitives(&self, most: usize) -> Option<Vec<PlacedPrimitive>> {
        let mut list = List { most, path: InstancePath::default(), found: Vec::new() };
        if let Some(root) = self.root.as_deref()
            && list.visit(root, &Transform::IDENTITY).is_break()
        {
            return None;
        }
        let mut found = list.found;
        found.sort_by_cached_key(|placed| self.rank(&placed.path));
        Some(found)
    }
}

struct List {
    most: usize,
    path: InstancePath,
    found: Vec<PlacedPrimitive>,
}

impl List {
    /// Breaks at the limit.
    fn visit(&mut self, group: &Group, world_from_group: &Transform) -> ControlFlow<()> {
        if self.found.len() + group.leaves.len() + group.instances.len() > self.most {
            return ControlFlow::Break(());
        }
        for (index, leaf) in (0..).zip(&group.leaves) {
            let mut path = self.path.clone();
            path.push(index);
            let world_from_unit = *world_from_group.forward() * inverse_of(&leaf.unit_from_group);
            self.found.push(PlacedPrimitive { path, primitive: leaf.primitive, world_from_unit });
        }
        for (index, instance) in (0..).zip(&group.instances) {
            // A child beyond the range of f64 cannot be seen either.
            let Ok(world_from_child) = world_from_group.after(instance.map()) else { continue };
            self.path.push(index);
            let flow = self.visit(&instance.group, &world_from_child);
            self.path.pop();
            flow?;
        }
        ControlFlow::Continue(())
    }
}
