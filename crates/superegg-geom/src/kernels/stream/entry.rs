//! Rays at the boxes of their shapes, in f64.

use glam::{DAffine3, DVec3};

/// Rays that are mapped to the boxes of their shapes together.
pub const ENTRY_LANES: usize = 8;
/// Relative error of the ends of rays.
pub const END: f64 = 4e-6;
/// Rays that start on a shape are searched from here on at the latest, in lengths of unit space.
const FIRST_STRETCH: f32 = 1.0 / 32.0;
/// And not before here.
const LEAST_STRETCH: f32 = 1.0 / 1024.0;
/// The box [-1, 1]^3 is enlarged by this factor, for rounding.
const BOX: f64 = 1.0 + 1e-6;
/// The squared radius of the sphere around the box, with a margin.
const SPHERE: f64 = 3.000_01;
/// A ray whose origin is farther away stays in f64.
const FAR: f64 = 1e4;
/// Reciprocals of directions are clamped to this size.
const MAX_INVERSE: f64 = 1e30;

type Row = [f64; ENTRY_LANES];

/// Rays in the spaces of the shapes whose boxes they may hit.
#[derive(Clone, Debug, Default)]
pub struct ShapeEntries {
    origin: [Row; 3],
    direction: [Row; 3],
    t_max: Row,
    answers: Answers,
}

#[derive(Clone, Debug, Default)]
struct Answers {
    kind: [EntryKind; ENTRY_LANES],
    start: [Row; 3],
    direction: [Row; 3],
    length: Row,
    t_entry: Row,
    t_per_s: Row,
}

/// How a ray enters the box of its shape. As wide as f64, so that kinds are lanes beside the numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u64)]
pub enum EntryKind {
    /// It misses the box, or hits it after its end.
    #[default]
    Misses,
    /// From outside.
    Enters,
    /// It starts inside.
    Inside,
    /// f32 cannot hold it.
    Unresolved,
}

/// The segment of a ray inside the box of its shape, in the space of the shape.
#[derive(Clone, Copy, Debug)]
pub struct ShapeEntry {
    /// The first point in the box.
    pub start: [f32; 3],
    /// A unit vector.
    pub direction: [f32; 3],
    /// The length of the segment: to the exit from the box, or to the end of the ray where it enters from outside.
    pub length: f32,
    /// The ray's t at the start.
    pub t_entry: f64,
    /// Converts a length in the space of the shape to t.
    pub t_per_s: f64,
}

impl ShapeEntry {
    /// The segment of a ray that starts on the surface, without a first stretch that ends before the next coordinate plane: within
    /// an octant it is verified from its ends. `None` if the segment is not more than twice as long.
    #[inline(always)]
    pub fn beyond_surface(self) -> Option<Self> {
        let mut length = FIRST_STRETCH;
        for axis in 0..3 {
            let half_way = -0.5 * self.start[axis] / self.direction[axis];
            if half_way > 0.0 && half_way < length {
                length = half_way;
            }
        }
        let length = length.max(LEAST_STRETCH);
        let is_longer = self.length > 2.0 * length;
        is_longer.then(|| Self {
            start: std::array::from_fn(|axis| self.start[axis] + length * self.direction[axis]),
            length: self.length - length,
            t_entry: self.t_entry + f64::from(length) * self.t_per_s,
            ..self
        })
    }
}

impl ShapeEntries {
    /// Sets the ray of a lane: the map to the space of its unit shape, its origin and direction, and the t where it ends.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, map: &DAffine3, [origin, direction]: [DVec3; 2], t_max: f64) {
        self.set_unit(lane, map.transform_point3(origin), map.transform_vector3(direction), t_max);
    }

    /// As [`ShapeEntries::set`], for a ray in the space of the unit shape.
    #[inline(always)]
    pub fn set_unit(&mut self, lane: usize, origin: DVec3, direction: DVec3, t_max: f64) {
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
        }
        self.t_max[lane] = t_max;
    }

    /// Sets the rays of all lanes, which go to one shape.
    #[inline(always)]
    pub fn set_all(
        &mut self,
        map: &DAffine3,
        origin: &[[f64; ENTRY_LANES]; 3],
        direction: &[[f64; ENTRY_LANES]; 3],
        t_max: f64,
    ) {
        let (columns, at) = (map.matrix3.to_cols_array_2d(), map.translation.to_array());
        for axis in 0..3 {
            let [x, y, z] = columns.map(|column| column[axis]);
            // A loop for each row: with both in one the compiler does not fill registers.
            for (i, to) in self.origin[axis].iter_mut().enumerate() {
                *to = x * origin[0][i] + y * origin[1][i] + z * origin[2][i] + at[axis];
            }
            for (i, to) in self.direction[axis].iter_mut().enumerate() {
                *to = x * direction[0][i] + y * direction[1][i] + z * direction[2][i];
            }
        }
        self.t_max = [t_max; ENTRY_LANES];
    }

    /// Computes the entries of all lanes. Plain loops, which the compiler vectorises.
    #[inline(always)]
    pub fn run(&mut self) {
        let Self { origin, direction, t_max, answers } = self;
        for i in 0..ENTRY_LANES {
            let (ox, oy, oz) = (origin[0][i], origin[1][i], origin[2][i]);
            let (dx, dy, dz) = (direction[0][i], direction[1][i], direction[2][i]);
            let size = (dx * dx + dy * dy + dz * dz).sqrt();
            let t_per_s = 1.0 / size;
            let (dx, dy, dz) = (dx * t_per_s, dy * t_per_s, dz * t_per_s);
            // From the point nearest to the centre, slabs are exact for far origins too.
            let nearest = -(ox * dx + oy * dy + oz * dz);
            let (cx, cy, cz) = (ox + nearest * dx, oy + nearest * dy, oz + nearest * dz);
            let (enter_x, exit_x) = slab(cx, dx);
            let (enter_y, exit_y) = slab(cy, dy);
            let (enter_z, exit_z) = slab(cz, dz);
            let enter = larger(larger(enter_x, enter_y), enter_z);
            let exit = smaller(smaller(exit_x, exit_y), exit_z);
            let farthest = larger(larger(ox.abs(), oy.abs()), oz.abs());
            let is_inside = farthest <= BOX;
            let end = t_max[i] * size;
            let misses = cx * cx + cy * cy + cz * cz > SPHERE
                || enter > exit
                || (nearest + exit < 0.0 && !is_inside)
                || nearest + enter > end;
            let is_finite = enter.abs() < f64::INFINITY
                && exit.abs() < f64::INFINITY
                && nearest.abs() < f64::INFINITY
                && size > 0.0;
            let is_resolved = is_finite && farthest <= FAR;
            let first = if is_inside { -nearest } else { enter };
            let last = if is_inside { exit } else { smaller(exit, end * (1.0 + END) - nearest) };
            answers.start[0][i] = cx + first * dx;
            answers.start[1][i] = cy + first * dy;
            answers.start[2][i] = cz + first * dz;
            (answers.direction[0][i], answers.direction[1][i], answers.direction[2][i]) = (dx, dy, dz);
            answers.length[i] = last - first;
            answers.t_entry[i] = (nearest + first) * t_per_s;
            answers.t_per_s[i] = t_per_s;
            let kind = if is_inside { EntryKind::Inside } else { EntryKind::Enters };
            let kind = if is_resolved { kind } else { EntryKind::Unresolved };
            answers.kind[i] = if misses { EntryKind::Misses } else { kind };
        }
    }

    /// How the ray of a lane enters its box.
    #[inline(always)]
    pub fn kind(&self, lane: usize) -> EntryKind {
        self.answers.kind[lane]
    }

    /// The segment of a ray that enters its box or starts inside.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> ShapeEntry {
        let Answers { start, direction, length, t_entry, t_per_s, .. } = &self.answers;
        let (mut start_f32, mut direction_f32) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            start_f32[axis] = start[axis][lane] as f32;
            direction_f32[axis] = direction[axis][lane] as f32;
        }
        ShapeEntry {
            start: start_f32,
            direction: direction_f32,
            length: length[lane] as f32,
            t_entry: t_entry[lane],
            t_per_s: t_per_s[lane],
        }
    }
}

/// Where a line enters and leaves the slab between two opposite faces of the box.
#[inline(always)]
fn slab(at: f64, direction: f64) -> (f64, f64) {
    let inverse = 1.0 / direction;
    // A line parallel to the faces enters and leaves very far away.
    let size = smaller(inverse.abs(), MAX_INVERSE);
    let middle = -at * size.copysign(direction);
    (middle - size * BOX, middle + size * BOX)
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_stretch_ends_before_a_coordinate_plane() {
        let entry = |x: f32| ShapeEntry {
            start: [x, 0.5, -0.5],
            direction: [-0.6, 0.8, 0.0],
            length: 0.5,
            t_entry: 2.0,
            t_per_s: 4.0,
        };
        for (x, stretch) in
            [(0.5, FIRST_STRETCH), (0.012, 0.01), (1e-6, LEAST_STRETCH), (-0.01, FIRST_STRETCH)]
        {
            let entry = entry(x);
            let beyond = entry.beyond_surface().unwrap();
            assert!((entry.length - beyond.length - stretch).abs() < 1e-6, "{x} {beyond:?}");
            assert!((beyond.start[0] - (x - 0.6 * stretch)).abs() < 1e-6);
            assert!((beyond.t_entry - (2.0 + 4.0 * f64::from(stretch))).abs() < 1e-6);
        }
        assert!(ShapeEntry { length: 0.06, ..entry(0.5) }.beyond_surface().is_none());
    }
}
