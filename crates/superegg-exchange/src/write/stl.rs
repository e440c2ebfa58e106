//! Binary STL: triangles in the world, in float32, without colours.

use superegg_scene::Scene;

use super::baked::{Rounding, distinct, for_each, world_tolerance};
use super::flatten::Instances;
use super::losses::{self, MaterialKept};
use super::meshes::{Meshes, Tolerance};
use super::written::{WriteError, Written};

/// The bytes before the count.
const HEADER: &[u8] = b"superegg: triangles counter-clockwise from outside, coordinates of the scene";

/// The instances as one binary STL file.
///
/// # Errors
/// A tolerance that is not possible, or coordinates beyond float32.
pub fn to_stl(scene: &Scene, instances: &Instances, tolerance: Tolerance) -> Result<Written, WriteError> {
    let meshes = Meshes::of(instances, tolerance)?;
    let count = meshes.baked_triangles(tolerance)?;
    let mut bytes = Vec::with_capacity(84 + 50 * count as usize);
    bytes.extend_from_slice(HEADER);
    bytes.resize(84, 0);
    let (mut written, mut rounding) = (0u32, Rounding::default());
    for_each(&meshes, |index, mesh, baked| {
        let path = &instances.list[index].path;
        let within = world_tolerance(instances, index, tolerance);
        let positions = rounding.round(&baked.positions, within, path)?;
        for triangle in distinct(mesh, &positions) {
            let corners = triangle.map(|corner| positions[corner as usize]);
            let [a, b, c] = corners.map(superegg_geom::glam::Vec3::as_dvec3);
            let normal = superegg_geom::unit_vector((b - a).cross(c - a)).unwrap_or_default().as_vec3();
            for vector in [normal, corners[0], corners[1], corners[2]] {
                vector.to_array().iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
            }
            bytes.extend_from_slice(&[0, 0]);
            written += 1;
        }
        Ok(())
    })?;
    bytes[80..84].copy_from_slice(&written.to_le_bytes());
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::None));
    losses.push("names of primitives are not in the file".to_owned());
    losses.extend(rounding.loss());
    Ok(Written { bytes, companion: None, losses })
}
