//! The shapes in a shaft.

use smallvec::SmallVec;
use superegg_geom::RayStart;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::kernels::LanePowers;

use super::hull::{HalfSpace, HalfSpaces, Shaft};
use crate::ray::footprint::Footprint;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Leaf};
use crate::scene::node::{Node, Slot, WIDTH};
use crate::scene::path::InstancePath;

/// The most nodes that a search visits.
const MOST_NODES: u32 = 192;
/// The most shapes that it finds. Rays through more are traced through the scene.
const MOST_OCCLUDERS: usize = 16;

/// A shape that may occlude the rays of a shaft.
#[derive(Clone, Debug)]
pub struct Occluder {
    /// From the world to the space of the unit shape.
    pub(crate) unit_from_world: DAffine3,
    pub(crate) powers: LanePowers,
    pub(crate) is_convex: bool,
    /// The index of the primitive.
    pub primitive: u32,
    /// How the rays start on this shape.
    pub(crate) start: RayStart,
}

/// Where the rays of a shaft start.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShaftStart<'p> {
    /// The instance whose surface all rays leave outwards.
    pub own: Option<&'p InstancePath>,
    /// The largest width of a ray.
    pub width: f64,
}

impl CompiledScene {
    /// Finds the shapes that may occlude the rays of a shaft: no other shape does. Returns false, with no meaning of
    /// `found`, where the search would be long or some groups are small enough to be hit as proxies.
    pub fn find_occluders(&self, shaft: &Shaft, start: ShaftStart<'_>, found: &mut Vec<Occluder>) -> bool {
        found.clear();
        let Some(root) = self.root.as_deref() else { return true };
        let path = InstancePath::default();
        let mut search = Search { scene: self, start, found, path, nodes_left: MOST_NODES };
        search.visit(root, &shaft.sides, &DAffine3::IDENTITY, 1.0).is_some()
    }
}

struct Search<'p, 'f> {
    scene: &'p CompiledScene,
    start: ShaftStart<'p>,
    found: &'f mut Vec<Occluder>,
    path: InstancePath,
    nodes_left: u32,
}

impl Search<'_, '_> {
    /// Visits a group, with the shaft in its space. `stretch` bounds the factor from lengths of the group to the world's.
    /// `None` ends the search.
    fn visit(
        &mut self,
        group: &Group,
        sides: &[HalfSpace],
        group_from_world: &DAffine3,
        stretch: f64,
    ) -> Option<()> {
        let tree_sides = TreeSides::of(sides, group);
        let mut pending = SmallVec::<[u32; 32]>::from_slice(&[0]);
        while let Some(node) = pending.pop() {
            self.nodes_left = self.nodes_left.checked_sub(1)?;
            let node = &group.nodes[node as usize];
            for child in superegg_simd::bits(tree_sides.children_inside(node)) {
                match node.slots[child].unpack() {
                    Slot::Node(inner) => pending.push(inner),
                    Slot::Leaf(index) => self.visit_leaf(group, index, sides, group_from_world)?,
                    Slot::Instance(index) => {
                        let instance = &group.instances[index as usize];
                        let stretch = stretch * instance.stretch;
                        let width = Footprint { width: self.start.width, spread: 0.0 };
                        if width.hides(instance.size() * stretch, 0.0) {
                            return None;
                        }
                        let map = instance.map();
                        let local: HalfSpaces =
                            sides.iter().map(|side| side.to_local(map.forward())).collect();
                        self.path.push(index);
                        self.visit(&instance.group, &local, &(*map.inverse() * *group_from_world), stretch)?;
                        self.path.pop();
                    }
                }
            }
        }
        Some(())
    }

    fn visit_leaf(
        &mut self,
        group: &Group,
        index: u32,
        sides: &[HalfSpace],
        group_from_world: &DAffine3,
    ) -> Option<()> {
        let leaf: &Leaf = &group.leaves[index as usize];
        self.path.push(index);
        let is_own = self.start.own.is_some_and(|own| *own == self.path);
        self.path.pop();
        // A ray that leaves a convex shape does not hit it again.
        if (is_own && leaf.lane_powers.is_some()) || is_outside(leaf, sides) {
            return Some(());
        }
        if self.found.len() == MOST_OCCLUDERS {
            return None;
        }
        let shape = || self.scene.primitives[leaf.primitive as usize].unit_shape();
        let powers = leaf.lane_powers.unwrap_or_else(|| LanePowers::of_any(&shape()));
        self.found.push(Occluder {
            unit_from_world: leaf.unit_from_group * *group_from_world,
            powers,
            is_convex: leaf.lane_powers.is_some(),
            primitive: leaf.primitive,
            start: if is_own { RayStart::SurfaceOutward } else { RayStart::Free },
        });
        Some(())
    }
}

/// Whether the box of a leaf's unit shape lies outside one of the sides. The box of the tree is checked before; this one is
/// turned with the shape.
fn is_outside(leaf: &Leaf, sides: &[HalfSpace]) -> bool {
    // A plain inverse is known to about 1e-16 times the square of the ratio of sizes.
    const MOST_STRETCHED: f64 = 1e3;
    let matrix = &leaf.unit_from_group.matrix3;
    let inverse = matrix.inverse();
    let size = |m: &DMat3| (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()).max_element();
    let stretched = size(matrix) * size(&inverse);
    if stretched.is_nan() || stretched >= MOST_STRETCHED {
        return false;
    }
    let center = inverse * leaf.unit_from_group.translation;
    let columns = inverse.transpose();
    sides.iter().any(|side| {
        // The largest value of the side's function on the box, and that at the centre of the shape.
        let reach = (columns * side.normal).abs().element_sum();
        let at_center = -side.normal.dot(center);
        let slack = 1e-8 * (reach + side.offset.abs() + side.normal.abs().dot(center.abs()));
        at_center - reach - slack > side.offset
    })
}

/// The sides of a shaft in the space of a group's tree, in f32. The largest component of each normal is 1.
struct TreeSides(SmallVec<[[f32; 4]; super::hull::MOST_SIDES]>);

/// Twice the relative rounding error of a sum of four products.
const ROUNDING: f32 = 1e-6;

impl TreeSides {
    fn of(sides: &[HalfSpace], group: &Group) -> Self {
        let space = &group.space;
        let mut converted = SmallVec::new();
        for side in sides {
            let scale = side.normal.abs().max_element().recip();
            let DVec3 { x, y, z } = scale * side.normal;
            let offset = side.offset - side.normal.dot(space.center);
            let rounding =
                16.0 * f64::EPSILON * (side.offset.abs() + side.normal.abs().dot(space.center.abs()));
            let offset = ((offset + rounding) * (scale * space.scale)) as f32;
            let side = [x as f32, y as f32, z as f32, offset + ROUNDING * offset.abs()];
            // Where a number leaves the range of f32 the side is left out.
            if side.iter().all(|x| x.is_finite()) {
                converted.push(side);
            }
        }
        Self(converted)
    }

    /// The children of a node whose boxes may meet the shaft, one bit each.
    #[inline(always)]
    fn children_inside(&self, node: &Node) -> u32 {
        let mut outside = [false; WIDTH];
        for [x, y, z, offset] in &self.0 {
            // The corner of each box that is deepest inside.
            let column =
                |axis: usize, component: f32| &node.bounds[if component > 0.0 { axis } else { axis + 3 }];
            let (xs, ys, zs) = (column(0, *x), column(1, *y), column(2, *z));
            for child in 0..WIDTH {
                let (x, y, z) = (x * xs[child], y * ys[child], z * zs[child]);
                let slack = ROUNDING * (x.abs() + y.abs() + z.abs());
                outside[child] |= x + y + z - slack > *offset;
            }
        }
        let mut inside = 0;
        for (child, outside) in outside.iter().enumerate().take(node.count as usize) {
            inside |= u32::from(!outside) << child;
        }
        inside
    }
}
