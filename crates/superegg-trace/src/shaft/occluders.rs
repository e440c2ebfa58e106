//! The shapes in a shaft.

use smallvec::SmallVec;
use superegg_geom::RayStart;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::kernels::LanePowers;

use super::hull::{BLOCK, BLOCKS, Shaft, SideBlock, Sides};
use crate::ray::footprint::Footprint;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Leaf};
use crate::scene::node::{Node, Slot, TreeSpace, WIDTH};
use crate::scene::path::InstancePath;
use superegg_simd::{Arch, Simd, WithSimd};

/// The most nodes that a search visits.
const MOST_NODES: u32 = 192;
/// The most shapes that it finds. Rays through more are traced through the scene.
const MOST_OCCLUDERS: usize = 16;

/// Shapes and groups that a search meets.
type Met = SmallVec<[Slot; 48]>;

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
    /// The instance.
    pub(crate) path: InstancePath,
}

/// Where the rays of a shaft start.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShaftStart<'p> {
    /// The instance whose surface all rays leave outwards.
    pub own: Option<&'p InstancePath>,
    /// The largest width of a ray.
    pub width: f64,
}

impl Occluder {
    /// Whether the shape is convex.
    pub fn is_convex(&self) -> bool {
        self.is_convex
    }
}

impl CompiledScene {
    /// Finds the shapes that may occlude the rays of a shaft: no other shape does. Returns false, with no meaning of
    /// `found`, where the search would be long or some groups are small enough to be hit as proxies.
    pub fn find_occluders(&self, shaft: &Shaft, start: ShaftStart<'_>, found: &mut Vec<Occluder>) -> bool {
        found.clear();
        let Some(root) = self.root.as_deref() else { return true };
        let (path, met) = (InstancePath::default(), Met::new());
        let mut search =
            Search { arch: Arch::new(), scene: self, start, found, path, met, nodes_left: MOST_NODES };
        search.visit(root, &shaft.sides, &DAffine3::IDENTITY, 1.0).is_some()
    }
}

struct Search<'p, 'f> {
    arch: Arch,
    scene: &'p CompiledScene,
    start: ShaftStart<'p>,
    found: &'f mut Vec<Occluder>,
    path: InstancePath,
    /// The shapes and groups that are still to be visited, group by group.
    met: Met,
    nodes_left: u32,
}

impl Search<'_, '_> {
    /// Visits a group, with the shaft in its space. `stretch` bounds the factor from lengths of the group to the world's.
    /// `None` ends the search.
    fn visit(
        &mut self,
        group: &Group,
        sides: &Sides,
        group_from_world: &DAffine3,
        stretch: f64,
    ) -> Option<()> {
        let first = self.met.len();
        let (nodes_left, met) = (&mut self.nodes_left, &mut self.met);
        self.arch.dispatch(FindChildren { sides, group, nodes_left, met })?;
        for next in first..self.met.len() {
            match self.met[next] {
                Slot::Node(_) => {}
                Slot::Leaf(index) => self.visit_leaf(group, index, sides, group_from_world)?,
                Slot::Instance(index) => {
                    let instance = &group.instances[index as usize];
                    let stretch = stretch * instance.stretch;
                    let width = Footprint { width: self.start.width, spread: 0.0 };
                    if width.hides(instance.size() * stretch, 0.0) {
                        return None;
                    }
                    let map = instance.map();
                    let local = self.arch.dispatch(ToLocal { sides, map: map.forward() });
                    self.path.push(index);
                    self.visit(&instance.group, &local, &(*map.inverse() * *group_from_world), stretch)?;
                    self.path.pop();
                }
            }
        }
        self.met.truncate(first);
        Some(())
    }

    fn visit_leaf(
        &mut self,
        group: &Group,
        index: u32,
        sides: &Sides,
        group_from_world: &DAffine3,
    ) -> Option<()> {
        let leaf: &Leaf = &group.leaves[index as usize];
        self.path.push(index);
        let path = self.path.clone();
        self.path.pop();
        let is_own = self.start.own.is_some_and(|own| *own == path);
        // A ray that leaves a convex shape does not hit it again.
        if (is_own && leaf.lane_powers.is_some()) || self.arch.dispatch(IsOutside { leaf, sides }) {
            return Some(());
        }
        if self.found.len() == MOST_OCCLUDERS {
            return None;
        }
        let shape = || self.scene.primitives.unit_shape(leaf.primitive);
        let powers = leaf.lane_powers.unwrap_or_else(|| LanePowers::of_any(&shape()));
        self.found.push(Occluder {
            unit_from_world: leaf.unit_from_group * *group_from_world,
            powers,
            is_convex: leaf.lane_powers.is_some(),
            primitive: leaf.primitive,
            start: if is_own { RayStart::SurfaceOutward } else { RayStart::Free },
            path,
        });
        Some(())
    }
}

/// [`Sides::to_local`].
struct ToLocal<'a> {
    sides: &'a Sides,
    map: &'a DAffine3,
}

impl WithSimd for ToLocal<'_> {
    type Output = Sides;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sides {
        self.sides.to_local(self.map)
    }
}

/// Whether the box of a leaf's unit shape lies outside one of the sides. The box of the tree is checked before; this one is
/// turned with the shape.
struct IsOutside<'a> {
    leaf: &'a Leaf,
    sides: &'a Sides,
}

impl WithSimd for IsOutside<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        // A plain inverse is known to about 1e-16 times the square of the ratio of sizes.
        const MOST_STRETCHED: f64 = 1e3;
        let unit_from_group = &self.leaf.unit_from_group;
        let matrix = &unit_from_group.matrix3;
        let inverse = matrix.inverse();
        let size = |m: &DMat3| (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()).max_element();
        let stretched = size(matrix) * size(&inverse);
        if stretched.is_nan() || stretched >= MOST_STRETCHED {
            return false;
        }
        let center = inverse * unit_from_group.translation;
        let mut outside = [false; BLOCK];
        for SideBlock { normal: [x, y, z], offset } in self.sides.blocks() {
            for lane in 0..BLOCK {
                let along = |v: DVec3| x[lane] * v.x + y[lane] * v.y + z[lane] * v.z;
                // The largest value of the side's function on the box, and that at the centre of the shape.
                let reach =
                    along(inverse.x_axis).abs() + along(inverse.y_axis).abs() + along(inverse.z_axis).abs();
                let at_center = -along(center);
                let size = x[lane].abs() * center.x.abs()
                    + y[lane].abs() * center.y.abs()
                    + z[lane].abs() * center.z.abs();
                let slack = 1e-8 * (reach + offset[lane].abs() + size);
                outside[lane] |= at_center - reach - slack > offset[lane];
            }
        }
        outside.contains(&true)
    }
}

/// Finds the children of a group whose boxes meet the shaft, in the space of the group. `None` where too many nodes are visited.
struct FindChildren<'a> {
    sides: &'a Sides,
    group: &'a Group,
    nodes_left: &'a mut u32,
    /// The leaves and instances that are found.
    met: &'a mut Met,
}

impl WithSimd for FindChildren<'_> {
    type Output = Option<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<()> {
        let Self { sides, group, nodes_left, met } = self;
        let tree_sides = TreeSides::of(sides, group);
        let mut pending = SmallVec::<[u32; 32]>::from_slice(&[0]);
        while let Some(node) = pending.pop() {
            *nodes_left = nodes_left.checked_sub(1)?;
            let node = &group.nodes[node as usize];
            for child in superegg_simd::bits(tree_sides.children_inside(node)) {
                match node.slot(child) {
                    Slot::Node(inner) => pending.push(inner),
                    slot => met.push(slot),
                }
            }
        }
        Some(())
    }
}

/// The sides of a shaft that cut the box of a group, in the space of its tree, in f32.
struct TreeSides {
    sides: [TreeSide; BLOCKS * BLOCK],
    count: usize,
}

/// The points with `normal . x <= offset`. The largest component of the normal is 1.
#[derive(Clone, Copy, Default)]
struct TreeSide {
    normal: [f32; 3],
    /// For each axis the column of a node that has the bounds which are deepest inside.
    columns: [u8; 3],
    /// With the rounding error of the product on boxes of the tree.
    offset: f32,
}

/// Twice the relative rounding error of a sum of four products.
const ROUNDING: f32 = 1e-6;

impl TreeSides {
    #[inline(always)]
    fn of(sides: &Sides, group: &Group) -> Self {
        let TreeSpace { center, scale: space_scale } = group.space;
        // The farthest coordinates of boxes.
        let reach = (group.bounds.max - center).abs().max((group.bounds.min - center).abs()) * space_scale;
        let reach = reach.to_array().map(|x| x as f32);
        let mut converted = Self { sides: [TreeSide::default(); BLOCKS * BLOCK], count: 0 };
        for SideBlock { normal: [x, y, z], offset } in sides.blocks() {
            let mut columns = [[0.0f32; BLOCK]; 4];
            let mut cuts = [false; BLOCK];
            for lane in 0..BLOCK {
                let (x, y, z, offset) = (x[lane], y[lane], z[lane], offset[lane]);
                let scale = 1.0 / x.abs().max(y.abs()).max(z.abs());
                let at_center = x * center.x + y * center.y + z * center.z;
                let size = x.abs() * center.x.abs() + y.abs() * center.y.abs() + z.abs() * center.z.abs();
                let rounding = 16.0 * f64::EPSILON * (offset.abs() + size);
                columns[0][lane] = (scale * x) as f32;
                columns[1][lane] = (scale * y) as f32;
                columns[2][lane] = (scale * z) as f32;
                columns[3][lane] = ((offset - at_center + rounding) * (scale * space_scale)) as f32;
            }
            let [x, y, z, offset] = &mut columns;
            for lane in 0..BLOCK {
                let largest = x[lane].abs() * reach[0] + y[lane].abs() * reach[1] + z[lane].abs() * reach[2];
                offset[lane] += ROUNDING * (offset[lane].abs() + largest);
                // A side that holds the whole box cuts nothing, and one beyond the range of f32 is left out.
                cuts[lane] = largest * (1.0 + ROUNDING) > offset[lane] && offset[lane].abs() < f32::INFINITY;
            }
            // Which sides cut is not predictable, so each is written, and the next replaces it if it does not.
            for lane in 0..BLOCK {
                let [x, y, z, offset] = columns.map(|column| column[lane]);
                let column = |axis: u8, along: f32| if along > 0.0 { axis } else { axis + 3 };
                converted.sides[converted.count] = TreeSide {
                    normal: [x, y, z],
                    columns: [column(0, x), column(1, y), column(2, z)],
                    offset,
                };
                converted.count += usize::from(cuts[lane]);
            }
        }
        converted
    }

    /// The children of a node whose boxes may meet the shaft, one bit each.
    #[inline(always)]
    fn children_inside(&self, node: &Node) -> u32 {
        let bounds = node.bounds();
        let mut beyond = [0.0f32; WIDTH];
        for &TreeSide { normal: [x, y, z], columns, offset } in &self.sides[..self.count] {
            // The corner of each box that is deepest inside.
            let [xs, ys, zs] = columns.map(|column| &bounds[usize::from(column)]);
            for child in 0..WIDTH {
                let depth = x * xs[child] + y * ys[child] + z * zs[child] - offset;
                beyond[child] = if depth > beyond[child] { depth } else { beyond[child] };
            }
        }
        let mut inside = 0;
        for (child, &beyond) in beyond.iter().enumerate().take(node.count as usize) {
            inside |= u32::from(beyond == 0.0) << child;
        }
        inside
    }
}
