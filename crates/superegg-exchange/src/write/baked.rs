//! Meshes of instances with their coordinates in the world.

use superegg_geom::Mesh;
use superegg_geom::glam::{DVec3, Vec3};
use superegg_geom::unit_vector;

use super::flatten::Instances;
use super::meshes::{Meshes, Placement, Tolerance, normal_map};
use super::written::WriteError;

/// A mesh in the world.
pub(super) struct Baked {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
}

impl Baked {
    /// A mesh in its place.
    pub(super) fn of(mesh: &Mesh, placement: &Placement) -> Self {
        let map = placement.map();
        let normals = normal_map(&map.matrix3);
        Self {
            positions: mesh.positions.iter().map(|&point| map.transform_point3(point)).collect(),
            normals: mesh
                .normals
                .iter()
                .map(|&normal| unit_vector(normals * normal).unwrap_or(DVec3::Z))
                .collect(),
        }
    }
}

/// Rounds coordinates to float32, and measures by how much.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounding {
    /// The largest distance by which a vertex moves, as a part of the tolerance there.
    worst: f64,
    /// That distance.
    distance: f64,
}

impl Rounding {
    /// The positions of an instance in float32.
    ///
    /// # Errors
    /// A coordinate beyond the range of float32.
    pub(super) fn round(
        &mut self,
        positions: &[DVec3],
        tolerance: f64,
        path: &str,
    ) -> Result<Vec<Vec3>, WriteError> {
        let rounded: Vec<Vec3> = positions.iter().map(|position| position.as_vec3()).collect();
        for (exact, rounded) in positions.iter().zip(&rounded) {
            if !rounded.is_finite() {
                return Err(WriteError::Range { path: path.to_owned() });
            }
            let distance = (rounded.as_dvec3() - exact).length();
            if distance / tolerance > self.worst {
                (self.worst, self.distance) = (distance / tolerance, distance);
            }
        }
        Ok(rounded)
    }

    /// The loss, if rounding moves a vertex by more than a tenth of the tolerance.
    pub(super) fn loss(&self) -> Option<String> {
        (self.worst > 0.1).then(|| {
            format!(
                "float32 coordinates move vertices by up to {:.1e}, {:.1} times the tolerance there: the shapes are small beside their distance from the origin",
                self.distance, self.worst
            )
        })
    }
}

/// The tolerance of an instance in world units.
pub(super) fn world_tolerance(instances: &Instances, index: usize, tolerance: Tolerance) -> f64 {
    match tolerance {
        Tolerance::Absolute(distance) => distance,
        Tolerance::Relative(part) => {
            let instance = &instances.list[index];
            let radii = instances.part(instance).shape.radii();
            let linear = &instance.map.matrix3;
            let axes = [linear.x_axis * radii.x, linear.y_axis * radii.y, linear.z_axis * radii.z];
            part * axes.map(DVec3::length).into_iter().fold(0.0, f64::max)
        }
    }
}

/// The triangles that float32 has not collapsed: no two corners are in one place. Without the
/// others the mesh is still closed.
pub(super) fn distinct<'a>(mesh: &'a Mesh, positions: &'a [Vec3]) -> impl Iterator<Item = [u32; 3]> + 'a {
    mesh.triangles.iter().copied().filter(move |triangle| {
        let [a, b, c] = triangle.map(|index| positions[index as usize]);
        a != b && b != c && c != a
    })
}

/// Bakes each instance in turn.
pub(super) fn for_each(
    meshes: &Meshes,
    mut visit: impl FnMut(usize, &Mesh, Baked) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    for (index, instance) in meshes.instances.iter().enumerate() {
        let mesh = &meshes.meshes[instance.mesh];
        visit(index, mesh, Baked::of(mesh, &instance.placement))?;
    }
    Ok(())
}
