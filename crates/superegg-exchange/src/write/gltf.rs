//! glTF 2.0 in one binary file (.glb).
//!
//! Each distinct mesh is stored once, and instances are nodes that share it. Meshes of sheared
//! instances are baked, because a node has only translation, rotation and scale. No node mirrors:
//! some readers show mirrored nodes inside out.

use std::collections::HashMap;

use serde_json::{Value, json};
use superegg_geom::Mesh;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_scene::Scene;

use super::baked::Baked;
use super::flatten::Instances;
use super::looks::{Look, looks};
use super::losses::{self, MaterialKept};
use super::meshes::{MeshInstance, Meshes, Placement, Tolerance};
use super::written::{WriteError, Written};

/// The largest file: its length is a 32-bit number.
const MOST_BYTES: usize = u32::MAX as usize;

/// The instances as a .glb file. A root node turns the scene's up direction, that of its camera, to
/// glTF's +y, and its name says so.
///
/// # Errors
/// A tolerance that is not possible, or coordinates beyond float32.
pub fn to_glb(scene: &Scene, instances: &Instances, tolerance: Tolerance) -> Result<Written, WriteError> {
    let meshes = Meshes::of(instances, tolerance)?;
    let (looks, look_of_part) = looks(instances);
    let mut builder = Builder { materials: looks.iter().map(material).collect(), ..Builder::default() };
    let mut geometry_of_mesh = HashMap::new();
    for (index, instance) in instances.list.iter().enumerate() {
        let MeshInstance { mesh, placement } = &meshes.instances[index];
        let geometry = match placement {
            Placement::Similar { .. } => match geometry_of_mesh.get(mesh) {
                Some(&geometry) => geometry,
                None => {
                    let stored = &meshes.meshes[*mesh];
                    let geometry = builder.geometry(stored, &stored.positions, &stored.normals);
                    let geometry =
                        geometry.ok_or_else(|| WriteError::Range { path: instance.path.clone() })?;
                    geometry_of_mesh.insert(*mesh, geometry);
                    geometry
                }
            },
            Placement::Sheared(_) => {
                let stored = &meshes.meshes[*mesh];
                let Baked { positions, normals } = Baked::of(stored, placement);
                let geometry = builder.geometry(stored, &positions, &normals);
                geometry.ok_or_else(|| WriteError::Range { path: instance.path.clone() })?
            }
        };
        let mesh = builder.mesh(geometry, look_of_part[instance.part]);
        let node = node(&instance.path, mesh, placement);
        builder.nodes.push(node.ok_or_else(|| WriteError::Range { path: instance.path.clone() })?);
    }
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::Reflection));
    let sheared =
        meshes.instances.iter().filter(|instance| matches!(instance.placement, Placement::Sheared(_)));
    let sheared = sheared.count();
    if sheared > 0 {
        losses.push(format!("meshes of sheared instances are stored one by one ({sheared})"));
    }
    let bytes = builder.finish(scene.camera.up).ok_or(WriteError::TooManyTriangles {
        count: meshes.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum(),
        most: MOST_BYTES as u64 / 60,
        tolerance: tolerance.value(),
        possible: 2.0 * tolerance.value(),
    })?;
    Ok(Written { bytes, companion: None, losses })
}

/// The accessors of a mesh: positions, normals, indices.
type Geometry = [usize; 3];

#[derive(Default)]
struct Builder {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    mesh_of: HashMap<(Geometry, usize), usize>,
    nodes: Vec<Value>,
}

/// The component types of glTF.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
/// The targets of buffer views.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

impl Builder {
    /// Stores a mesh. `None` if a coordinate is beyond float32.
    fn geometry(&mut self, mesh: &Mesh, positions: &[DVec3], normals: &[DVec3]) -> Option<Geometry> {
        let rounded: Vec<[f32; 3]> = positions.iter().map(|position| position.as_vec3().to_array()).collect();
        if !rounded.iter().flatten().all(|x| x.is_finite()) {
            return None;
        }
        let extreme = |pick: fn(f32, f32) -> f32, start: f32| {
            rounded
                .iter()
                .fold([start; 3], |so_far, point| [0, 1, 2].map(|axis| pick(so_far[axis], point[axis])))
        };
        let (least, most) = (extreme(f32::min, f32::INFINITY), extreme(f32::max, f32::NEG_INFINITY));
        let count = rounded.len();
        let bytes = rounded.iter().flatten().flat_map(|x| x.to_le_bytes());
        let view = self.view(bytes, ARRAY_BUFFER);
        let position = self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": "VEC3", "min": least, "max": most,
        }));
        let bytes = normals.iter().flat_map(|normal| normal.as_vec3().to_array()).flat_map(f32::to_le_bytes);
        let view = self.view(bytes, ARRAY_BUFFER);
        let normal = self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": "VEC3",
        }));
        let corners = mesh.triangles.iter().flatten();
        // The largest index of a type is reserved.
        let (kind, view) = if count < usize::from(u16::MAX) {
            (UNSIGNED_SHORT, self.view(corners.flat_map(|&i| (i as u16).to_le_bytes()), ELEMENT_ARRAY_BUFFER))
        } else {
            (UNSIGNED_INT, self.view(corners.flat_map(|&i| i.to_le_bytes()), ELEMENT_ARRAY_BUFFER))
        };
        let index = self.accessor(json!({
            "bufferView": view, "componentType": kind, "count": 3 * mesh.triangles.len(), "type": "SCALAR",
        }));
        Some([position, normal, index])
    }

    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: u32) -> usize {
        let start = self.binary.len();
        self.binary.extend(bytes);
        let length = self.binary.len() - start;
        // Accessors are aligned to four bytes.
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(json!({
            "buffer": 0, "byteOffset": start, "byteLength": length, "target": target,
        }));
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The mesh of a geometry with a material.
    fn mesh(&mut self, geometry: Geometry, material: usize) -> usize {
        *self.mesh_of.entry((geometry, material)).or_insert_with(|| {
            let [position, normal, index] = geometry;
            self.meshes.push(json!({ "primitives": [{
                "attributes": { "POSITION": position, "NORMAL": normal },
                "indices": index, "material": material,
            }] }));
            self.meshes.len() - 1
        })
    }

    /// The file. `None` if it is too long.
    fn finish(mut self, up: DVec3) -> Option<Vec<u8>> {
        let children: Vec<usize> = (0..self.nodes.len()).collect();
        let (name, turn) = y_from_up(up);
        let rotation = turn.as_quat().to_array();
        self.nodes.push(json!({ "name": name, "rotation": rotation, "children": children }));
        let root = self.nodes.len() - 1;
        let document = json!({
            "asset": { "version": "2.0", "generator": "superegg" },
            "scene": 0,
            "scenes": [{ "nodes": [root] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.binary.len() }],
        });
        let mut text = serde_json::to_vec(&document).ok()?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.binary.len();
        if length > MOST_BYTES {
            return None;
        }
        let mut bytes = Vec::with_capacity(length);
        bytes.extend_from_slice(b"glTF");
        let number = |bytes: &mut Vec<u8>, x: usize| bytes.extend_from_slice(&(x as u32).to_le_bytes());
        number(&mut bytes, 2);
        number(&mut bytes, length);
        number(&mut bytes, text.len());
        bytes.extend_from_slice(b"JSON");
        bytes.append(&mut text);
        number(&mut bytes, self.binary.len());
        bytes.extend_from_slice(b"BIN\0");
        bytes.append(&mut self.binary);
        Some(bytes)
    }
}

/// The rotation of the axis nearest to `up` to +y, and a name for it.
fn y_from_up(up: DVec3) -> (&'static str, DQuat) {
    let axis = up.abs().max_position();
    let is_positive = up[axis] >= 0.0;
    let quarter = std::f64::consts::FRAC_PI_2;
    match (axis, is_positive) {
        (0, true) => ("x-up to y-up", DQuat::from_rotation_z(quarter)),
        (0, false) => ("-x-up to y-up", DQuat::from_rotation_z(-quarter)),
        (1, true) => ("y-up", DQuat::IDENTITY),
        (1, false) => ("-y-up to y-up", DQuat::from_rotation_x(2.0 * quarter)),
        (_, true) => ("z-up to y-up", DQuat::from_rotation_x(-quarter)),
        (_, false) => ("-z-up to y-up", DQuat::from_rotation_x(quarter)),
    }
}

/// The node of an instance. `None` if a number is beyond float32.
fn node(name: &str, mesh: usize, placement: &Placement) -> Option<Value> {
    match *placement {
        Placement::Sheared(_) => Some(json!({ "name": name, "mesh": mesh })),
        Placement::Similar { scale, rotation, position } => {
            let (factor, translation) = (scale as f32, position.as_vec3());
            if !(factor.is_normal() && translation.is_finite()) {
                return None;
            }
            let rotation = rotation.as_quat().normalize().to_array();
            Some(json!({
                "name": name, "mesh": mesh, "translation": translation.to_array(), "rotation": rotation,
                "scale": [factor, factor, factor],
            }))
        }
    }
}

/// The metallic-roughness material.
fn material(look: &Look) -> Value {
    let [r, g, b] = look.color.as_vec3().to_array();
    let mut material = json!({
        "name": look.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, look.opacity as f32],
            "metallicFactor": look.metallic() as f32,
            "roughnessFactor": look.roughness() as f32,
        },
    });
    if look.opacity < 1.0 {
        material["alphaMode"] = json!("BLEND");
    }
    material
}
