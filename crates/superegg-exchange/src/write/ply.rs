//! Binary PLY: one mesh in the world with normals and colours.

use superegg_scene::Scene;

use super::baked::{Rounding, distinct, for_each, world_tolerance};
use super::flatten::Instances;
use super::looks::srgb_bytes;
use super::losses::{self, MaterialKept};
use super::meshes::{Meshes, Tolerance};
use super::written::{WriteError, Written};

/// The type of coordinates. Programs on WebGL refuse doubles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// float32.
    #[default]
    Single,
    /// float64.
    Double,
}

/// The instances as one binary PLY file, little-endian: positions and normals, and the base colour
/// in the sRGB encoding.
///
/// # Errors
/// A tolerance that is not possible, or coordinates beyond float32.
pub fn to_ply(
    scene: &Scene,
    instances: &Instances,
    tolerance: Tolerance,
    precision: Precision,
) -> Result<Written, WriteError> {
    let meshes = Meshes::of(instances, tolerance)?;
    meshes.baked_triangles(tolerance)?;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let (mut vertex_count, mut face_count) = (0u32, 0u32);
    let mut rounding = Rounding::default();
    for_each(&meshes, |index, mesh, baked| {
        let instance = &instances.list[index];
        let color = srgb_bytes(instances.part(instance).material.color);
        let triangles: Vec<[u32; 3]> = match precision {
            Precision::Double => {
                for (position, normal) in baked.positions.iter().zip(&baked.normals) {
                    let numbers = position.to_array().into_iter().chain(normal.to_array());
                    numbers.for_each(|x| vertices.extend_from_slice(&x.to_le_bytes()));
                    vertices.extend_from_slice(&color);
                }
                mesh.triangles.clone()
            }
            Precision::Single => {
                let within = world_tolerance(instances, index, tolerance);
                let positions = rounding.round(&baked.positions, within, &instance.path)?;
                for (position, normal) in positions.iter().zip(&baked.normals) {
                    let numbers = position.to_array().into_iter().chain(normal.as_vec3().to_array());
                    numbers.for_each(|x| vertices.extend_from_slice(&x.to_le_bytes()));
                    vertices.extend_from_slice(&color);
                }
                distinct(mesh, &positions).collect()
            }
        };
        for triangle in &triangles {
            faces.push(3);
            let corners = triangle.map(|corner| vertex_count + corner);
            corners.iter().for_each(|corner| faces.extend_from_slice(&corner.to_le_bytes()));
        }
        vertex_count += mesh.positions.len() as u32;
        face_count += triangles.len() as u32;
        Ok(())
    })?;
    let mut bytes = header(precision, vertex_count, face_count).into_bytes();
    bytes.reserve_exact(vertices.len() + faces.len());
    bytes.append(&mut vertices);
    bytes.append(&mut faces);
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::Color));
    losses.push("names of primitives are not in the file".to_owned());
    losses.extend(rounding.loss());
    Ok(Written { bytes, companion: None, losses })
}

fn header(precision: Precision, vertices: u32, faces: u32) -> String {
    let number = match precision {
        Precision::Single => "float",
        Precision::Double => "double",
    };
    let properties: String = ["x", "y", "z", "nx", "ny", "nz"]
        .into_iter()
        .map(|name| format!("property {number} {name}\n"))
        .chain(["red", "green", "blue"].map(|name| format!("property uchar {name}\n")))
        .collect();
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment superegg\nelement vertex {vertices}\n{properties}element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}
