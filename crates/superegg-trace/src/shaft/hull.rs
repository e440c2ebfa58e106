//! The planes around a shaft.

use superegg_geom::Aabb;
use superegg_geom::glam::{DAffine3, DVec3};

/// The most half spaces of a shaft: six along the axes, and one for each corner of the three projections.
pub(crate) const MOST_SIDES: usize = 18;

/// The half spaces of a block.
pub(crate) const BLOCK: usize = 4;
/// The blocks of a shaft.
pub(crate) const BLOCKS: usize = MOST_SIDES.div_ceil(BLOCK);

/// Half spaces as columns: the points with `normal . x <= offset`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SideBlock {
    pub(crate) normal: [[f64; BLOCK]; 3],
    pub(crate) offset: [f64; BLOCK],
}

impl SideBlock {
    /// All points.
    const ALL: Self = Self { normal: [[0.0; BLOCK]; 3], offset: [f64::INFINITY; BLOCK] };
}

/// The intersection of half spaces.
#[derive(Clone, Debug)]
pub(crate) struct Sides {
    blocks: [SideBlock; BLOCKS],
    count: usize,
}

impl Sides {
    /// All points.
    const ALL: Self = Self { blocks: [SideBlock::ALL; BLOCKS], count: 0 };

    fn push(&mut self, normal: DVec3, offset: f64) {
        let (block, lane) = (&mut self.blocks[self.count / BLOCK], self.count % BLOCK);
        for axis in 0..3 {
            block.normal[axis][lane] = normal[axis];
        }
        block.offset[lane] = offset;
        self.count += 1;
    }

    /// The half spaces in blocks. The last block may have some of all points.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> &[SideBlock] {
        &self.blocks[..self.count.div_ceil(BLOCK)]
    }

    /// The same half spaces in the local coordinates of a map.
    #[inline(always)]
    pub(crate) fn to_local(&self, world_from_local: &DAffine3) -> Self {
        let DAffine3 { matrix3, translation } = world_from_local;
        let mut local = Self { count: self.count, ..Self::ALL };
        for (from, to) in self.blocks().iter().zip(&mut local.blocks) {
            let [x, y, z] = &from.normal;
            for lane in 0..BLOCK {
                let along = |v: DVec3| v.x * x[lane] + v.y * y[lane] + v.z * z[lane];
                to.normal[0][lane] = along(matrix3.x_axis);
                to.normal[1][lane] = along(matrix3.y_axis);
                to.normal[2][lane] = along(matrix3.z_axis);
                to.offset[lane] = from.offset[lane] - along(*translation);
            }
        }
        local
    }
}

/// A convex region that holds all rays from one box to another, or from a box along directions in another.
#[derive(Clone, Debug)]
pub struct Shaft {
    pub(crate) sides: Sides,
}

impl Shaft {
    /// The convex hull of two boxes, or a little more.
    pub fn between(from: &Aabb, to: &Aabb) -> Self {
        let mut sides = Sides::ALL;
        for axis in 0..3 {
            let (most, least) = (from.max[axis].max(to.max[axis]), from.min[axis].min(to.min[axis]));
            let normal = DVec3::AXES[axis];
            sides.push(normal, most);
            sides.push(-normal, -least);
        }
        push_slanted(&mut sides, from, |signs| corner(to, signs) - corner(from, signs));
        Self { sides }
    }

    /// The rays from the points of a box along the directions in another box.
    pub fn along(from: &Aabb, directions: &Aabb) -> Self {
        let mut sides = Sides::ALL;
        for axis in 0..3 {
            let normal = DVec3::AXES[axis];
            if directions.max[axis] <= 0.0 {
                sides.push(normal, from.max[axis]);
            }
            if directions.min[axis] >= 0.0 {
                sides.push(-normal, -from.min[axis]);
            }
        }
        push_slanted(&mut sides, from, |signs| corner(directions, signs));
        Self { sides }
    }
}

/// The corner of a box that is farthest in a direction of these signs.
fn corner(bounds: &Aabb, signs: DVec3) -> DVec3 {
    DVec3::select(signs.cmpgt(DVec3::ZERO), bounds.max, bounds.min)
}

/// Adds the sides that are parallel to one axis: the common tangents of the projections of both boxes. `edge` is the edge of
/// the hull at the corner of given signs.
///
/// A tangent whose normal has the signs of a corner touches both boxes there. It is one of the hull exactly if the edge from
/// one corner to the other descends along one axis of the projection and rises along the other.
fn push_slanted(sides: &mut Sides, from: &Aabb, edge: impl Fn(DVec3) -> DVec3) {
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        for (sign_i, sign_j) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut signs = DVec3::ONE;
            (signs[i], signs[j]) = (sign_i, sign_j);
            let edge = edge(signs);
            if edge[i] * sign_i * (edge[j] * sign_j) < 0.0 {
                let mut normal = DVec3::ZERO;
                (normal[i], normal[j]) = (edge[j].abs() * sign_i, edge[i].abs() * sign_j);
                sides.push(normal, normal.dot(corner(from, signs)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;

    use super::*;

    /// Whether a point lies in a shaft, up to rounding.
    fn holds(shaft: &Shaft, point: DVec3) -> bool {
        shaft.sides.blocks().iter().all(|block| {
            (0..BLOCK).all(|lane| {
                let normal = DVec3::from_array(block.normal.map(|column| column[lane]));
                let offset = block.offset[lane];
                let slack = 1e-12 * (offset.abs() + normal.abs().dot(point.abs()));
                normal.dot(point) <= offset + slack
            })
        })
    }

    fn vector(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| random.unit()))
    }

    fn random_box(random: &mut SplitMix, size: f64) -> Aabb {
        let corner = 8.0 * vector(random) - 4.0;
        Aabb { min: corner, max: corner + size * vector(random) }
    }

    fn point_in(random: &mut SplitMix, bounds: &Aabb) -> DVec3 {
        bounds.min + (bounds.max - bounds.min) * vector(random)
    }

    #[test]
    fn shafts_hold_all_their_rays_and_little_else() {
        let mut random = SplitMix::new(5);
        let (mut inside, mut total) = (0, 0);
        for case in 0..400 {
            let size = if case % 4 == 0 { 0.0 } else { 1.0 };
            let (from, to) = (random_box(&mut random, size), random_box(&mut random, 1.0));
            let directions = random_box(&mut random, 0.5);
            let (between, along) = (Shaft::between(&from, &to), Shaft::along(&from, &directions));
            for _ in 0..50 {
                let (a, b) = (point_in(&mut random, &from), point_in(&mut random, &to));
                assert!(holds(&between, a.lerp(b, random.unit())));
                let t = 10.0 * random.unit();
                assert!(holds(&along, a + t * point_in(&mut random, &directions)));
            }
            // Most points around two small boxes are not in their hull.
            let around = Aabb { min: DVec3::splat(-5.0), max: DVec3::splat(5.0) };
            for _ in 0..50 {
                total += 1;
                inside += u32::from(holds(&between, point_in(&mut random, &around)));
            }
        }
        assert!(inside * 20 < total, "{inside} of {total}");
    }
}
