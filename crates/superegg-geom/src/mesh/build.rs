//! Vertices and triangles from a plan.

use glam::DVec3;

use super::plan::Plan;
use super::surface::Mesh;
use crate::math::numeric::unit_vector;
use crate::measure::arc::ArcPoint;
use crate::superquadric::Superquadric;

/// The triangles of all eight octants.
pub(super) fn build(shape: &Superquadric, plan: &Plan) -> Mesh {
    let mut builder = Builder { shape, plan, mesh: Mesh::default() };
    let rings = plan.ring_levels.len();
    let south = builder.pole(-1.0);
    // From the last ring in the south to the last one in the north.
    let south_rings = (usize::from(plan.has_equator())..rings).rev().map(|ring| (ring, -1.0));
    let ring_numbers = south_rings.chain((0..rings).map(|ring| (ring, 1.0)));
    let all: Vec<Ring> = ring_numbers.map(|(ring, side)| builder.ring(ring, side)).collect();
    let north = builder.pole(1.0);
    builder.cap(&all[0], south, false);
    for pair in all.windows(2) {
        builder.band(&pair[0], &pair[1]);
    }
    builder.cap(&all[all.len() - 1], north, true);
    builder.mesh
}

/// A closed ring of vertices around the axis.
struct Ring {
    /// The position of each vertex around the axis, 0 to four times the chords of the section.
    azimuths: Vec<u32>,
    /// The index of the first vertex; the others follow.
    first: u32,
}

impl Ring {
    /// The index of a vertex of the ring, which may be one turn farther.
    fn vertex(&self, i: usize) -> u32 {
        self.first + (i % self.azimuths.len()) as u32
    }
}

struct Builder<'a> {
    shape: &'a Superquadric,
    plan: &'a Plan,
    mesh: Mesh,
}

impl Builder<'_> {
    fn push(&mut self, unit: DVec3, normal: DVec3) {
        self.mesh.positions.push(self.shape.radii() * unit);
        self.mesh.normals.push(unit_vector(normal / self.shape.radii()).unwrap_or(DVec3::Z));
    }

    fn pole(&mut self, side: f64) -> u32 {
        self.push(side * DVec3::Z, side * DVec3::Z);
        self.mesh.positions.len() as u32 - 1
    }

    /// Adds the vertices of a ring, north (side 1) or south (-1) of the equator.
    fn ring(&mut self, ring: usize, side: f64) -> Ring {
        let first = self.mesh.positions.len() as u32;
        let chords = self.plan.section.chords() as u32;
        let indices = &self.plan.levels[self.plan.ring_levels[ring]].indices;
        let height = &self.plan.profile.vertices[ring].point;
        let [across, along] = unit_normal(height, ring == 0 && self.plan.has_equator(), false);
        let mut azimuths = Vec::with_capacity(4 * (indices.len() - 1));
        for quadrant in 0..4 {
            let is_mirrored = quadrant % 2 == 1;
            // The quadrant's last vertex is the first one of the next quadrant.
            for step in 0..indices.len() - 1 {
                let index = indices[if is_mirrored { indices.len() - 1 - step } else { step }];
                let around = &self.plan.section.vertices[index as usize].point;
                let [x, y] = unit_normal(around, index == 0, index == chords);
                let signs = DVec3::new(
                    if matches!(quadrant, 1 | 2) { -1.0 } else { 1.0 },
                    if quadrant >= 2 { -1.0 } else { 1.0 },
                    side,
                );
                // 0 has no sign.
                let unit = DVec3::new(height.x * around.x, height.x * around.y, height.y) * signs + 0.0;
                self.push(unit, DVec3::new(across * x, across * y, along) * signs + 0.0);
                azimuths.push(quadrant * chords + if is_mirrored { chords - index } else { index });
            }
        }
        Ring { azimuths, first }
    }

    /// Joins a ring to a pole.
    fn cap(&mut self, ring: &Ring, pole: u32, is_north: bool) {
        for i in 0..ring.azimuths.len() {
            let (here, next) = (ring.vertex(i), ring.vertex(i + 1));
            self.mesh.triangles.push(if is_north { [here, next, pole] } else { [next, here, pole] });
        }
    }

    /// Joins two rings; `upper` is north of `lower`. The vertices of one of them are among those of
    /// the other.
    fn band(&mut self, lower: &Ring, upper: &Ring) {
        let is_upper_coarse = upper.azimuths.len() <= lower.azimuths.len();
        let (coarse, fine) = if is_upper_coarse { (upper, lower) } else { (lower, upper) };
        let turn = 4 * self.plan.section.chords() as u32;
        let mut from = 0;
        for i in 0..coarse.azimuths.len() {
            let next_azimuth = coarse.azimuths.get(i + 1).copied().unwrap_or(turn);
            let mut to = from;
            while fine.azimuths.get(to).copied().unwrap_or(turn) < next_azimuth {
                to += 1;
            }
            let is_mirrored = (4 * coarse.azimuths[i] / turn) % 2 == 1;
            let half = (to - from) / 2;
            let middle = if is_mirrored == is_upper_coarse { from + half } else { to - half };
            let (here, next) = (coarse.vertex(i), coarse.vertex(i + 1));
            let mut push = |[a, b, c]: [u32; 3]| {
                self.mesh.triangles.push(if is_upper_coarse { [a, b, c] } else { [b, a, c] });
            };
            // A fan from each end of the coarse chord, and the triangle on the chord between.
            (from..middle).for_each(|k| push([fine.vertex(k), fine.vertex(k + 1), here]));
            push([fine.vertex(middle), next, here]);
            (middle..to).for_each(|k| push([fine.vertex(k), fine.vertex(k + 1), next]));
            from = to;
        }
    }
}

/// The normal of an arc at a point, scaled so that its product with the point is 1: the factors of
/// the surface's normal `(n_rho n_X / a, n_rho n_Y / b, n_zeta / c)`. At its ends, where the tangent
/// may be a cusp, the arc's axis.
fn unit_normal(point: &ArcPoint, is_first: bool, is_last: bool) -> [f64; 2] {
    if is_first {
        return [1.0, 0.0];
    }
    if is_last {
        return [0.0, 1.0];
    }
    let steepness = point.steepness;
    if steepness <= 1.0 {
        let sum = point.x * steepness + point.y;
        [steepness / sum, 1.0 / sum]
    } else {
        let flatness = steepness.recip();
        let sum = point.x + point.y * flatness;
        [1.0 / sum, flatness / sum]
    }
}
