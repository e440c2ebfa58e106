//! Meshes on the GPU, each stored once.

use std::collections::HashMap;

use superegg_geom::Exponents;
use superegg_scene::Patches;
use wgpu::util::DeviceExt;

use super::lod::patches_at;
use crate::preview::{PreviewShape, Vertex, tessellate};

/// Key of a mesh. Shapes with equal exponents and patches share one mesh; the semi-axes belong to
/// the instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MeshKey {
    e_bits: u64,
    n_bits: u64,
    u: u32,
    v: u32,
}

impl MeshKey {
    /// The key of a shape at a level of detail. Above level 0 exponents are rounded, by less than a
    /// quarter of a pixel, so that any number of small shapes needs few meshes.
    pub(super) fn new(shape: &PreviewShape, level: u8) -> Self {
        let Patches { u, v } = patches_at(shape.patches, level);
        let (e, n) = (shape.exponents.e(), shape.exponents.n());
        let (e, n) = if level == 0 { (e, n) } else { (rounded(e), rounded(n)) };
        Self { e_bits: e.to_bits(), n_bits: n.to_bits(), u, v }
    }
}

/// The nearest power of 1.1.
fn rounded(exponent: f64) -> f64 {
    1.1f64.powf(exponent.clamp(0.05, 16.0).log(1.1).round())
}

/// A mesh on the GPU.
#[derive(Debug)]
pub(super) struct GpuMesh {
    pub(super) vertices: wgpu::Buffer,
    pub(super) vertex_count: u32,
    /// Each vertex twice, for the two ends of a normal.
    pub(super) doubled_vertices: wgpu::Buffer,
    pub(super) triangles: wgpu::Buffer,
    pub(super) triangle_count: u32,
    pub(super) edges: wgpu::Buffer,
    pub(super) edge_count: u32,
}

/// All meshes on the GPU.
#[derive(Debug)]
pub(super) struct Meshes {
    device: wgpu::Device,
    numbers: HashMap<MeshKey, usize>,
    meshes: Vec<GpuMesh>,
    /// The sphere for marks.
    pub(super) ball: GpuMesh,
}

const BALL: Patches = Patches { u: 8, v: 5 };

impl Meshes {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let ball = upload(device, Exponents::ROUND, BALL);
        Self { device: device.clone(), numbers: HashMap::new(), meshes: Vec::new(), ball }
    }

    /// The number of a mesh. A new mesh is tessellated and uploaded.
    pub(super) fn ensure(&mut self, key: MeshKey) -> usize {
        *self.numbers.entry(key).or_insert_with(|| {
            let (e, n) = (f64::from_bits(key.e_bits), f64::from_bits(key.n_bits));
            // The bits of valid exponents, so the default is never used.
            let exponents = Exponents::new(e, n).unwrap_or_default();
            self.meshes.push(upload(&self.device, exponents, Patches { u: key.u, v: key.v }));
            self.meshes.len() - 1
        })
    }

    pub(super) fn get(&self, number: usize) -> &GpuMesh {
        &self.meshes[number]
    }

    pub(super) fn len(&self) -> usize {
        self.meshes.len()
    }
}

fn upload(device: &wgpu::Device, exponents: Exponents, patches: Patches) -> GpuMesh {
    let mesh = tessellate(exponents, patches);
    let buffer = |label, bytes: &[u8], usage| {
        // wgpu rejects an empty buffer.
        let contents = if bytes.is_empty() { &[0; 16] } else { bytes };
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    };
    let doubled: Vec<Vertex> = mesh.vertices.iter().flat_map(|vertex| [*vertex; 2]).collect();
    GpuMesh {
        vertices: buffer("vertices", bytemuck::cast_slice(&mesh.vertices), wgpu::BufferUsages::VERTEX),
        vertex_count: mesh.vertices.len() as u32,
        doubled_vertices: buffer("normals", bytemuck::cast_slice(&doubled), wgpu::BufferUsages::VERTEX),
        triangles: buffer("triangles", bytemuck::cast_slice(&mesh.triangles), wgpu::BufferUsages::INDEX),
        triangle_count: mesh.triangles.len() as u32,
        edges: buffer("edges", bytemuck::cast_slice(&mesh.edges), wgpu::BufferUsages::INDEX),
        edge_count: mesh.edges.len() as u32,
    }
}
