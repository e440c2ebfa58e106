//! Meshes on the GPU, each stored once.

use std::collections::HashMap;

use superegg_geom::Exponents;
use superegg_scene::Patches;
use wgpu::util::DeviceExt;

use super::lod::{MeshDetail, SegmentCounts, tolerance};
use crate::preview::{Mesh, PreviewShape, Vertex, drawn_patches, tessellate, tessellate_within};

/// Key of a mesh. Shapes with equal exponents and detail share one mesh; the semi-axes belong to the
/// instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct MeshKey {
    e_bits: u64,
    n_bits: u64,
    detail: MeshDetail,
}

impl MeshKey {
    pub(super) fn new((detail, exponents): (MeshDetail, Exponents)) -> Self {
        Self { e_bits: exponents.e().to_bits(), n_bits: exponents.n().to_bits(), detail }
    }

    /// The key of the mesh with a shape's own patches.
    pub(super) fn of_patches(shape: &PreviewShape) -> Self {
        let Patches { u, v } = drawn_patches(shape.patches);
        Self::new((MeshDetail::Patches { u, v }, shape.exponents))
    }
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
    pub(super) segments: SegmentCounts,
    /// The sphere for marks.
    pub(super) ball: GpuMesh,
}

const BALL: Patches = Patches { u: 8, v: 5 };

impl Meshes {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let ball = upload(device, &tessellate(Exponents::ROUND, BALL));
        Self {
            device: device.clone(),
            numbers: HashMap::new(),
            meshes: Vec::new(),
            segments: SegmentCounts::default(),
            ball,
        }
    }

    /// The number of a mesh. A new mesh is tessellated and uploaded.
    pub(super) fn ensure(&mut self, key: MeshKey) -> usize {
        *self.numbers.entry(key).or_insert_with(|| {
            let (e, n) = (f64::from_bits(key.e_bits), f64::from_bits(key.n_bits));
            // The bits of valid exponents, so the default is never used.
            let exponents = Exponents::new(e, n).unwrap_or_default();
            let mesh = match key.detail {
                MeshDetail::Patches { u, v } => tessellate(exponents, Patches { u, v }),
                MeshDetail::Within { level } => tessellate_within(exponents, tolerance(level)),
            };
            self.meshes.push(upload(&self.device, &mesh));
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

fn upload(device: &wgpu::Device, mesh: &Mesh) -> GpuMesh {
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
