//! Superquadrics as columns.

use superegg_geom::Aabb;
use superegg_geom::glam::{DQuat, DVec3};

/// The box of a simulation: a corner, three edges, and which of them are periodic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationBox {
    /// The corner from which the edges start.
    pub origin: DVec3,
    /// The three edges.
    pub edges: [DVec3; 3],
    /// Whether the box repeats along each edge.
    pub periodic: [bool; 3],
}

/// Superquadrics as columns of equal length, in our conventions: e shapes the xy section, n the
/// profile along z, sizes are semi-axes, and `world = rotation * p + position`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// The time step or time of the frame, as in the file.
    pub step: Option<f64>,
    /// The id of each particle; empty if the file has none.
    pub ids: Vec<i64>,
    /// The centres.
    pub positions: Vec<DVec3>,
    /// The semi-axes.
    pub radii: Vec<DVec3>,
    /// The exponents (e, n).
    pub exponents: Vec<[f64; 2]>,
    /// The rotations from body to world: quaternions of unit length to the digits of the file.
    pub rotations: Vec<DQuat>,
    /// The linear colours; empty if the file has none.
    pub colors: Vec<[f32; 3]>,
    /// Further numeric columns under their names in the file.
    pub extra: Vec<(String, Vec<f64>)>,
    /// The box of the simulation.
    pub bounds: Option<SimulationBox>,
}

impl Particles {
    /// The number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// A box around all particles, however they are turned.
    pub fn reach(&self) -> Aabb {
        let of_particle =
            |(position, radii): (&DVec3, &DVec3)| Aabb::around(*position, DVec3::splat(radii.max_element()));
        let boxes = self.positions.iter().zip(&self.radii).map(of_particle);
        boxes.fold(Aabb::EMPTY, |all, next| all.union(&next))
    }

    /// Appends one particle without id, colour and further columns.
    pub fn push(&mut self, position: DVec3, radii: DVec3, exponents: [f64; 2], rotation: DQuat) {
        self.positions.push(position);
        self.radii.push(radii);
        self.exponents.push(exponents);
        self.rotations.push(rotation);
    }
}
