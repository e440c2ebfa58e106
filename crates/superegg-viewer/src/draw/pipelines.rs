//! The pipelines: shaders, vertex layouts and depth state.

use super::attachments::DEPTH_FORMAT;
use super::gpu_data::InstanceData;
use crate::preview::Vertex;

/// The WGSL source of all shaders.
pub const SHADERS: &str = include_str!("shaders.wgsl");

#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) frame_layout: wgpu::BindGroupLayout,
    film_layout: wgpu::BindGroupLayout,
    film_sampler: wgpu::Sampler,
    pub(super) phong: [wgpu::RenderPipeline; 3],
    pub(super) gouraud: [wgpu::RenderPipeline; 3],
    /// Transparent surfaces: counter-clockwise triangles, clockwise ones. Each has a
    /// pass that dims the things behind it, and one for its own light.
    pub(super) clear_phong: [[wgpu::RenderPipeline; 2]; 2],
    pub(super) clear_gouraud: [[wgpu::RenderPipeline; 2]; 2],
    /// Floor and sky.
    pub(super) environment: wgpu::RenderPipeline,
    pub(super) depth: [wgpu::RenderPipeline; 3],
    pub(super) edge: wgpu::RenderPipeline,
    pub(super) dim_edge: wgpu::RenderPipeline,
    pub(super) selected_edge: wgpu::RenderPipeline,
    pub(super) outline: [wgpu::RenderPipeline; 3],
    pub(super) normal: wgpu::RenderPipeline,
    pub(super) line: wgpu::RenderPipeline,
    pub(super) opaque_mark: wgpu::RenderPipeline,
    pub(super) clear_mark: wgpu::RenderPipeline,
    pub(super) top_mark: wgpu::RenderPipeline,
    pub(super) film: wgpu::RenderPipeline,
}

/// Depth state of a pipeline. Depth is reversed: nearer is greater.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Depth {
    /// Tested and written with a bias backwards, so that edges on the surface win.
    Behind,
    /// Tested and written.
    Solid,
    /// Tested with the same bias, not written: the product with what is behind.
    Filter,
    /// Tested with the same bias, not written: the sum with what is behind.
    Glow,
    /// Tested, not written.
    Tested,
    /// Neither tested nor written.
    Ignored,
}

const MESH: &[Option<wgpu::VertexBufferLayout<'static>>] = &[
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<InstanceData>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4, 4 => Float32x4, 5 => Float32x4, 6 => Float32x4, 7 => Float32x3, 8 => Float32x3, 9 => Float32x3, 10 => Float32x4, 11 => Float32x4, 12 => Float32x2, 13 => Float32x3],
    }),
];
const MARKS: &[Option<wgpu::VertexBufferLayout<'static>>] = &[
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: 32,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4],
    }),
];
const LINES: &[Option<wgpu::VertexBufferLayout<'static>>] = &[Some(wgpu::VertexBufferLayout {
    array_stride: 28,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x4],
})];

/// Colours blended by these factors. Alpha stays.
const fn blended(src: wgpu::BlendFactor, dst: wgpu::BlendFactor) -> wgpu::BlendState {
    let operation = wgpu::BlendOperation::Add;
    wgpu::BlendState {
        color: wgpu::BlendComponent { src_factor: src, dst_factor: dst, operation },
        alpha: wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::Zero,
            dst_factor: wgpu::BlendFactor::One,
            operation,
        },
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat, samples: u32) -> Self {
        let shaders = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("shaders"),
            source: wgpu::ShaderSource::Wgsl(SHADERS.into()),
        });
        let entry =
            |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let frame_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, uniform)],
        });
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let film_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("film"),
            entries: &[
                entry(0, wgpu::ShaderStages::FRAGMENT, texture),
                entry(
                    1,
                    wgpu::ShaderStages::FRAGMENT,
                    wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                ),
            ],
        });
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let scene_layout = layout(&[Some(&frame_layout)]);
        let picture_layout = layout(&[Some(&frame_layout), Some(&film_layout)]);

        use wgpu::PrimitiveTopology::{LineList, TriangleList};
        let make = |layout, vertex, fragment, buffers, topology, depth| {
            let shaders = (&shaders, vertex, fragment);
            pipeline(device, shaders, layout, buffers, (topology, None), depth, (format, samples))
        };
        let scene = |vertex, fragment, buffers, topology, depth| {
            make(&scene_layout, vertex, fragment, buffers, topology, depth)
        };
        // Without the depth test the back of a mark would be drawn over its front.
        let top_mark = pipeline(
            device,
            (&shaders, "mark_vertex", "mark_fragment"),
            &scene_layout,
            MARKS,
            (TriangleList, Some(wgpu::Face::Back)),
            Depth::Ignored,
            (format, samples),
        );
        // In the order of `Sides::ALL`.
        let solid = |vertex, fragment| {
            [Some(wgpu::Face::Back), Some(wgpu::Face::Front), None].map(|hidden| {
                let shaders = (&shaders, vertex, fragment);
                pipeline(
                    device,
                    shaders,
                    &scene_layout,
                    MESH,
                    (TriangleList, hidden),
                    Depth::Behind,
                    (format, samples),
                )
            })
        };
        // The sides that `Sides::ALL` hides.
        let outline =
            [Some(wgpu::Face::Front), Some(wgpu::Face::Back), Some(wgpu::Face::Front)].map(|hidden| {
                let shaders = (&shaders, "outline_vertex", "colored_fragment");
                let target = (format, samples);
                pipeline(device, shaders, &scene_layout, MESH, (TriangleList, hidden), Depth::Behind, target)
            });
        let clear = |vertex, behind, fragment| {
            [Some(wgpu::Face::Back), Some(wgpu::Face::Front)].map(|hidden| {
                [(behind, Depth::Filter), (fragment, Depth::Glow)].map(|(fragment, depth)| {
                    let (shaders, target) = ((&shaders, vertex, fragment), (format, samples));
                    pipeline(device, shaders, &scene_layout, MESH, (TriangleList, hidden), depth, target)
                })
            })
        };
        Self {
            clear_phong: clear("phong_vertex", "phong_behind_fragment", "phong_fragment"),
            clear_gouraud: clear("gouraud_vertex", "gouraud_behind_fragment", "gouraud_fragment"),
            environment: scene("film_vertex", "environment_fragment", &[], TriangleList, Depth::Solid),
            outline,
            phong: solid("phong_vertex", "phong_fragment"),
            gouraud: solid("gouraud_vertex", "gouraud_fragment"),
            depth: solid("depth_vertex", "depth_fragment"),
            edge: scene("edge_vertex", "colored_fragment", MESH, LineList, Depth::Tested),
            dim_edge: scene("dim_edge_vertex", "colored_fragment", MESH, LineList, Depth::Tested),
            selected_edge: scene("selected_edge_vertex", "colored_fragment", MESH, LineList, Depth::Tested),
            normal: scene("normal_vertex", "colored_fragment", MESH, LineList, Depth::Tested),
            line: scene("line_vertex", "colored_fragment", LINES, LineList, Depth::Tested),
            opaque_mark: scene("mark_vertex", "mark_fragment", MARKS, TriangleList, Depth::Solid),
            clear_mark: scene("mark_vertex", "mark_fragment", MARKS, TriangleList, Depth::Tested),
            top_mark,
            film: make(&picture_layout, "film_vertex", "film_fragment", &[], TriangleList, Depth::Ignored),
            film_sampler: device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("film"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            }),
            frame_layout,
            film_layout,
        }
    }

    pub(super) fn film_group(&self, device: &wgpu::Device, view: &wgpu::TextureView) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("film"),
            layout: &self.film_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(view) },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&self.film_sampler),
                },
            ],
        })
    }
}

fn pipeline(
    device: &wgpu::Device,
    (shaders, vertex, fragment): (&wgpu::ShaderModule, &'static str, &'static str),
    layout: &wgpu::PipelineLayout,
    buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
    (topology, cull_mode): (wgpu::PrimitiveTopology, Option<wgpu::Face>),
    depth: Depth,
    (format, samples): (wgpu::TextureFormat, u32),
) -> wgpu::RenderPipeline {
    // The depth pass writes no colour. Opaque surfaces need no blending.
    let (write_mask, blend) = match (fragment, topology) {
        ("depth_fragment", _) => (wgpu::ColorWrites::empty(), None),
        (_, wgpu::PrimitiveTopology::LineList) | ("mark_fragment", _) => {
            (wgpu::ColorWrites::ALL, Some(wgpu::BlendState::ALPHA_BLENDING))
        }
        _ if depth == Depth::Filter => {
            (wgpu::ColorWrites::ALL, Some(blended(wgpu::BlendFactor::Zero, wgpu::BlendFactor::Src)))
        }
        _ if depth == Depth::Glow => {
            (wgpu::ColorWrites::ALL, Some(blended(wgpu::BlendFactor::One, wgpu::BlendFactor::One)))
        }
        _ => (wgpu::ColorWrites::ALL, None),
    };
    let targets = [Some(wgpu::ColorTargetState { format, blend, write_mask })];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(vertex),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shaders,
            entry_point: Some(vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState { topology, cull_mode, ..wgpu::PrimitiveState::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(matches!(depth, Depth::Behind | Depth::Solid)),
            depth_compare: Some(if depth == Depth::Ignored {
                wgpu::CompareFunction::Always
            } else {
                wgpu::CompareFunction::GreaterEqual
            }),
            stencil: wgpu::StencilState::default(),
            bias: if matches!(depth, Depth::Behind | Depth::Filter | Depth::Glow) {
                wgpu::DepthBiasState { constant: -2, slope_scale: -1.0, clamp: 0.0 }
            } else {
                wgpu::DepthBiasState::default()
            },
        }),
        multisample: wgpu::MultisampleState { count: samples, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: shaders,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
