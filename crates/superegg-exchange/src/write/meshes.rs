//! The meshes of a scene: one for each distinct shape, and where its instances are.

use std::collections::HashMap;

use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};
use superegg_geom::{Mesh, Superquadric};

use super::flatten::{Instance, Instances};
use super::rigid::Rigid;
use super::written::WriteError;

/// The greatest distance between a mesh and its exact surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// As a part of each instance's size: its largest semi-axis in the world.
    Relative(f64),
    /// In world units.
    Absolute(f64),
}

impl Tolerance {
    /// The number.
    pub fn value(self) -> f64 {
        match self {
            Self::Relative(value) | Self::Absolute(value) => value,
        }
    }

    /// The tolerance for a shape of this size, as a part of the size.
    fn relative_to(self, size: f64) -> f64 {
        match self {
            Self::Relative(part) => part,
            // Sizes share a mesh up to a factor of 2.
            Self::Absolute(distance) if (distance / size).is_normal() => {
                (distance / size).log2().floor().exp2()
            }
            Self::Absolute(distance) => distance / size,
        }
    }
}

/// The most triangles of a file.
pub const MOST_TRIANGLES: u64 = 20_000_000;

/// Where a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Placement {
    /// Scaled by one factor, turned and moved.
    Similar {
        /// The factor.
        scale: f64,
        /// The rotation.
        rotation: DQuat,
        /// The position.
        position: DVec3,
    },
    /// Under a map that shears it.
    Sheared(DAffine3),
}

impl Placement {
    pub(super) fn map(&self) -> DAffine3 {
        match *self {
            Self::Similar { scale, rotation, position } => {
                DAffine3 { matrix3: DMat3::from_quat(rotation) * scale, translation: position }
            }
            Self::Sheared(map) => map,
        }
    }
}

/// An instance of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshInstance {
    /// The index of its mesh in [`Meshes::meshes`].
    pub(super) mesh: usize,
    pub(super) placement: Placement,
}

/// The meshes of instances.
#[derive(Clone, Debug, Default)]
pub(super) struct Meshes {
    /// The distinct meshes, of shapes whose largest semi-axis is 1 where they are not sheared.
    pub(super) meshes: Vec<Mesh>,
    /// One for each instance, in their order.
    pub(super) instances: Vec<MeshInstance>,
}

/// The numbers that a mesh depends on.
type Key = [u64; 6];

impl Meshes {
    /// The meshes of these instances.
    pub(super) fn of(instances: &Instances, tolerance: Tolerance) -> Result<Self, WriteError> {
        let mut meshes = Self::default();
        let mut known: HashMap<Key, usize> = HashMap::new();
        let mut triangles: u64 = 0;
        for instance in &instances.list {
            let part = instances.part(instance);
            let (shape, part_of_size, placement) = unit_shape(&part.shape, instance, tolerance);
            let exponents = shape.exponents();
            let [a, b, c] = shape.radii().to_array();
            let key = [a, b, c, exponents.e(), exponents.n(), part_of_size].map(f64::to_bits);
            let mesh = match known.get(&key) {
                Some(&mesh) => mesh,
                None => {
                    let mesh = shape.mesh(part_of_size);
                    let mesh = mesh.map_err(|error| WriteError::Mesh { name: part.name.clone(), error })?;
                    triangles += mesh.triangles.len() as u64;
                    check_count(triangles, tolerance)?;
                    meshes.meshes.push(mesh);
                    known.insert(key, meshes.meshes.len() - 1);
                    meshes.meshes.len() - 1
                }
            };
            meshes.instances.push(MeshInstance { mesh, placement });
        }
        Ok(meshes)
    }

    /// The triangles of all instances.
    ///
    /// # Errors
    /// More than [`MOST_TRIANGLES`].
    pub(super) fn baked_triangles(&self, tolerance: Tolerance) -> Result<u64, WriteError> {
        let of_mesh = |instance: &MeshInstance| self.meshes[instance.mesh].triangles.len() as u64;
        let count = self.instances.iter().map(of_mesh).sum();
        check_count(count, tolerance)?;
        Ok(count)
    }
}

fn check_count(count: u64, tolerance: Tolerance) -> Result<(), WriteError> {
    if count <= MOST_TRIANGLES {
        return Ok(());
    }
    // The count grows with the inverse of the tolerance.
    let possible = tolerance.value() * (count as f64 / MOST_TRIANGLES as f64) * 1.2;
    Err(WriteError::TooManyTriangles { count, most: MOST_TRIANGLES, tolerance: tolerance.value(), possible })
}

/// The shape to mesh for an instance, the tolerance in its units, and where its mesh goes.
fn unit_shape(
    shape: &Superquadric,
    instance: &Instance,
    tolerance: Tolerance,
) -> (Superquadric, f64, Placement) {
    let similar = Rigid::of(shape, &instance.map).and_then(|rigid| {
        let size = rigid.radii.max_element();
        // Rounding would give each instance its own mesh.
        let ratio = |x: f64| if x > 1e-6 { (x * 1e12).round() / 1e12 } else { x };
        let unit = Superquadric::new((rigid.radii / size).map(ratio), shape.exponents()).ok()?;
        let placement =
            Placement::Similar { scale: size, rotation: rigid.rotation, position: rigid.position };
        Some((unit, tolerance.relative_to(size), placement))
    });
    similar.unwrap_or_else(|| {
        let linear = &instance.map.matrix3;
        let radii = shape.radii();
        let axes = [linear.x_axis * radii.x, linear.y_axis * radii.y, linear.z_axis * radii.z];
        let size = axes.map(DVec3::length).into_iter().fold(0.0, f64::max);
        // A length in the shape's space grows by no more than the norm of the map.
        let norm =
            DVec3::new(linear.x_axis.length(), linear.y_axis.length(), linear.z_axis.length()).length();
        (*shape, tolerance.relative_to(size) * size / norm, Placement::Sheared(instance.map))
    })
}

/// The map of normals under a map of points: the transposed inverse, up to a positive factor.
pub(super) fn normal_map(linear: &DMat3) -> DMat3 {
    let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
    let scale = x.abs().max(y.abs()).max(z.abs()).max_element();
    let [x, y, z] = [x / scale, y / scale, z / scale];
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y))
}
