//! The drawing module.

use std::time::Instant;

use image::RgbaImage;
use superegg_render::{Development, Film};
use superegg_scene::Shading;
use wgpu::util::DeviceExt;

use super::attachments::{Attachments, GrowingBuffer, IMAGE_FORMAT, read_back, texture_descriptor};
use super::eye_space::EyeSpace;
use super::gpu::{Gpu, GpuError};
use super::gpu_data::{FrameUniform, MOST_LIGHTS, frame_uniform};
use super::instances::{Batch, Sides, SortedInstances};
use super::meshes::Meshes;
use super::picture::{FilmTexture, Mark, Picture, Style, Target};
use super::pipelines::Pipelines;
use crate::frame_stats::DrawStats;

/// Draws pictures into targets of one format.
#[derive(Debug)]
pub struct Drawing {
    gpu: Gpu,
    format: wgpu::TextureFormat,
    /// Samples per pixel of the anti-aliasing.
    samples: u32,
    /// Most triangles of a picture.
    triangle_budget: usize,
    pipelines: Pipelines,
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    meshes: Meshes,
    instances: GrowingBuffer,
    lines: GrowingBuffer,
    marks: GrowingBuffer,
    attachments: Option<Attachments>,
}

/// Vertex counts of the lines and marks of a picture.
#[derive(Clone, Copy, Debug, Default)]
struct OverlayCounts {
    line_ends: u32,
    marks: MarkCounts,
}

/// Ends of the ranges of marks in their buffer.
#[derive(Clone, Copy, Debug, Default)]
struct MarkCounts {
    opaque: u32,
    /// The end of the transparent ones: all so far are hidden by surfaces before them.
    hidden: u32,
    all: u32,
}

impl Drawing {
    /// Creates a module for targets of a format. It writes encoded colours, so the format should
    /// not be an sRGB one.
    pub(crate) fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let device = &gpu.device;
        // On the CPU each sample costs as much as a pixel.
        let samples = if gpu.is_software { 1 } else { 4 };
        let pipelines = Pipelines::new(device, format, samples);
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let frame_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &pipelines.frame_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
        });
        Self {
            meshes: Meshes::new(device),
            gpu: gpu.clone(),
            format,
            samples,
            triangle_budget: if gpu.is_software { 1_500_000 } else { 20_000_000 },
            pipelines,
            frame,
            frame_group,
            instances: GrowingBuffer::new("instances"),
            lines: GrowingBuffer::new("lines"),
            marks: GrowingBuffer::new("marks"),
            attachments: None,
        }
    }

    /// Creates a module that draws into images.
    pub fn for_images(gpu: &Gpu) -> Self {
        Self::new(gpu, IMAGE_FORMAT)
    }

    /// Drops all meshes. The next picture makes them again.
    pub(crate) fn forget_meshes(&mut self) {
        self.meshes = Meshes::new(&self.gpu.device);
    }

    /// The number of meshes on the GPU.
    pub fn mesh_count(&self) -> usize {
        self.meshes.len()
    }

    /// Uploads a traced picture for [`Picture::film`]. Enlargement interpolates linearly.
    pub(crate) fn upload_film(&self, film: &Film, development: &Development) -> FilmTexture {
        let bytes = development.rgb8(film);
        let rgba: Vec<u8> = bytes.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
        let texture = self.gpu.device.create_texture_with_data(
            &self.gpu.queue,
            &texture_descriptor(
                "film",
                (film.width(), film.height()),
                1,
                IMAGE_FORMAT,
                wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            ),
            wgpu::util::TextureDataOrder::LayerMajor,
            &rgba,
        );
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        FilmTexture { bind_group: self.pipelines.film_group(&self.gpu.device, &view) }
    }

    /// Records the drawing of a picture.
    pub(crate) fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Picture<'_>,
        target: &Target<'_>,
    ) -> DrawStats {
        let begin = Instant::now();
        let (_, _, width, height) = target.viewport;
        let space = EyeSpace::new(&picture.camera, width, height);
        let mut stats = DrawStats {
            lights_left_out: picture.lights.len().saturating_sub(MOST_LIGHTS),
            ..DrawStats::default()
        };
        let uniform = frame_uniform(&space, picture);
        self.gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&uniform));
        let mut sorted = SortedInstances::default();
        let mut counts = OverlayCounts::default();
        if picture.film.is_none() {
            sorted =
                SortedInstances::new(picture, &space, self.triangle_budget, &mut self.meshes, &mut stats);
            let bytes = bytemuck::cast_slice(&sorted.data);
            self.instances.write(&self.gpu.device, &self.gpu.queue, bytes);
            counts.line_ends = self.write_lines(picture, &space);
            counts.marks = self.write_marks(picture, &space);
        }
        self.record(encoder, picture, target, &sorted, counts);
        stats.draws = sorted.batches.len() + sorted.transparent.len();
        stats.seconds = begin.elapsed().as_secs_f64();
        stats
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Picture<'_>,
        target: &Target<'_>,
        sorted: &SortedInstances,
        counts: OverlayCounts,
    ) {
        let attachments =
            self.attachments.take().filter(|attachments| attachments.size == target.size).unwrap_or_else(
                || Attachments::new(&self.gpu.device, target.size, self.samples, self.format),
            );
        let mut pass = cleared_pass(encoder, &attachments, picture, target);
        pass.set_bind_group(0, &self.frame_group, &[]);
        match (picture.film, picture.style) {
            (Some(film), _) => {
                pass.set_pipeline(&self.pipelines.film);
                pass.set_bind_group(1, &film.bind_group, &[]);
                pass.draw(0..3, 0..1);
            }
            (None, Style::Solid(shading)) => {
                let pipelines = match shading {
                    Shading::Phong => &self.pipelines.phong,
                    Shading::Gouraud => &self.pipelines.gouraud,
                };
                self.draw_triangles(&mut pass, pipelines, &sorted.batches);
                if picture.sky.is_some() || picture.floor.is_some() {
                    pass.set_pipeline(&self.pipelines.environment);
                    pass.draw(0..3, 0..1);
                }
                let pipelines = match shading {
                    Shading::Phong => &self.pipelines.clear_phong,
                    Shading::Gouraud => &self.pipelines.clear_gouraud,
                };
                self.draw_transparent(&mut pass, pipelines, &sorted.transparent);
                if picture.is_course {
                    self.draw_edges(&mut pass, &self.pipelines.selected_edge, &sorted.selected);
                } else {
                    self.draw_triangles(&mut pass, &self.pipelines.outline, &sorted.selected);
                }
                self.draw_lines(&mut pass, counts);
                self.draw_marks(&mut pass, counts);
            }
            (None, Style::Wireframe { has_normals }) => {
                // Marks first: the wires are drawn over them, but marks hide wires behind them.
                self.draw_marks(&mut pass, counts);
                let all = [sorted.batches.as_slice(), &sorted.transparent];
                all.iter().for_each(|batches| self.draw_edges(&mut pass, &self.pipelines.dim_edge, batches));
                all.iter().for_each(|batches| self.draw_triangles(&mut pass, &self.pipelines.depth, batches));
                all.iter().for_each(|batches| self.draw_edges(&mut pass, &self.pipelines.edge, batches));
                self.draw_edges(&mut pass, &self.pipelines.selected_edge, &sorted.selected);
                if has_normals {
                    all.iter().for_each(|batches| self.draw_normals(&mut pass, batches));
                }
                self.draw_lines(&mut pass, counts);
            }
        }
        drop(pass);
        self.attachments = Some(attachments);
    }

    /// Draws a picture into a new image.
    ///
    /// # Errors
    /// The image cannot be read back.
    pub fn draw_to_image(
        &mut self,
        picture: &Picture<'_>,
        (width, height): (u32, u32),
    ) -> Result<(RgbaImage, DrawStats), GpuError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture = self.gpu.device.create_texture(&texture_descriptor(
            "image",
            (width, height),
            1,
            self.format,
            usage,
        ));
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = Target { view: &view, size: (width, height), viewport: (0, 0, width, height) };
        let stats = self.draw(&mut encoder, picture, &target);
        let image = read_back(&self.gpu, encoder, &texture, (width, height))?;
        Ok((image, stats))
    }

    fn write_lines(&mut self, picture: &Picture<'_>, space: &EyeSpace) -> u32 {
        let ends: Vec<[f32; 7]> = picture
            .lines
            .iter()
            .flat_map(|line| line.ends.map(|end| (end, line.color)))
            .map(|(end, [r, g, b, a])| {
                let [x, y, z] = space.point(end);
                [x, y, z, r, g, b, a]
            })
            .collect();
        self.lines.write(&self.gpu.device, &self.gpu.queue, bytemuck::cast_slice(&ends));
        ends.len() as u32
    }

    /// Writes the marks: opaque ones, transparent ones, then those on top from far to near.
    fn write_marks(&mut self, picture: &Picture<'_>, space: &EyeSpace) -> MarkCounts {
        let data = |mark: &Mark| -> [[f32; 4]; 2] {
            let [x, y, z] = space.point(mark.center);
            [[x, y, z, (mark.radius / space.unit) as f32], mark.color]
        };
        let of = |is_on_top: bool, is_opaque: bool| {
            let matches = move |mark: &&Mark| {
                mark.is_on_top == is_on_top && (is_on_top || (mark.color[3] >= 1.0) == is_opaque)
            };
            picture.marks.iter().filter(matches).map(data)
        };
        let mut all: Vec<[[f32; 4]; 2]> = of(false, true).collect();
        let opaque = all.len() as u32;
        all.extend(of(false, false));
        let hidden = all.len();
        all.extend(of(true, true));
        all[hidden..].sort_by(|[a, _], [b, _]| a[2].total_cmp(&b[2]));
        self.marks.write(&self.gpu.device, &self.gpu.queue, bytemuck::cast_slice(&all));
        MarkCounts { opaque, hidden: hidden as u32, all: all.len() as u32 }
    }

    fn draw_triangles(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &[wgpu::RenderPipeline; 3],
        batches: &[Batch],
    ) {
        let Some(instances) = &self.instances.buffer else { return };
        pass.set_vertex_buffer(1, instances.slice(..));
        let mut sides = None;
        for batch in batches {
            if sides != Some(batch.sides) {
                pass.set_pipeline(&pipelines[batch.sides as usize]);
                sides = Some(batch.sides);
            }
            let mesh = self.meshes.get(batch.mesh);
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            pass.set_index_buffer(mesh.triangles.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..3 * mesh.triangle_count, 0, batch.first..batch.first + batch.count);
        }
    }

    /// Draws transparent instances from far to near, each with its far side first.
    fn draw_transparent(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &[[wgpu::RenderPipeline; 2]; 2],
        batches: &[Batch],
    ) {
        let Some(instances) = &self.instances.buffer else { return };
        pass.set_vertex_buffer(1, instances.slice(..));
        for batch in batches {
            let mesh = self.meshes.get(batch.mesh);
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            pass.set_index_buffer(mesh.triangles.slice(..), wgpu::IndexFormat::Uint32);
            // The first pipeline hides the sides whose triangles are clockwise on the screen.
            let [front, back] = pipelines;
            let order = if batch.sides == Sides::MirroredFront { [front, back] } else { [back, front] };
            for pipeline in order.into_iter().flatten() {
                pass.set_pipeline(pipeline);
                pass.draw_indexed(0..3 * mesh.triangle_count, 0, batch.first..batch.first + batch.count);
            }
        }
    }

    fn draw_edges(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        batches: &[Batch],
    ) {
        let Some(instances) = &self.instances.buffer else { return };
        pass.set_vertex_buffer(1, instances.slice(..));
        pass.set_pipeline(pipeline);
        for batch in batches {
            let mesh = self.meshes.get(batch.mesh);
            pass.set_vertex_buffer(0, mesh.vertices.slice(..));
            pass.set_index_buffer(mesh.edges.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..2 * mesh.edge_count, 0, batch.first..batch.first + batch.count);
        }
    }

    fn draw_normals(&self, pass: &mut wgpu::RenderPass<'_>, batches: &[Batch]) {
        let Some(instances) = &self.instances.buffer else { return };
        pass.set_pipeline(&self.pipelines.normal);
        pass.set_vertex_buffer(1, instances.slice(..));
        for batch in batches {
            let mesh = self.meshes.get(batch.mesh);
            pass.set_vertex_buffer(0, mesh.doubled_vertices.slice(..));
            pass.draw(0..2 * mesh.vertex_count, batch.first..batch.first + batch.count);
        }
    }

    fn draw_lines(&self, pass: &mut wgpu::RenderPass<'_>, counts: OverlayCounts) {
        if let (Some(lines), 1..) = (&self.lines.buffer, counts.line_ends) {
            pass.set_pipeline(&self.pipelines.line);
            pass.set_vertex_buffer(0, lines.slice(..));
            pass.draw(0..counts.line_ends, 0..1);
        }
    }

    fn draw_marks(&self, pass: &mut wgpu::RenderPass<'_>, counts: OverlayCounts) {
        let Some(marks) = &self.marks.buffer else { return };
        let ball = &self.meshes.ball;
        let MarkCounts { opaque, hidden, all } = counts.marks;
        for (pipeline, range) in [
            (&self.pipelines.opaque_mark, 0..opaque),
            (&self.pipelines.clear_mark, opaque..hidden),
            (&self.pipelines.top_mark, hidden..all),
        ] {
            if !range.is_empty() {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, ball.vertices.slice(..));
                pass.set_vertex_buffer(1, marks.slice(..));
                pass.set_index_buffer(ball.triangles.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..3 * ball.triangle_count, 0, range);
            }
        }
    }
}

/// Begins a pass that fills the target with the background and draws into the viewport.
fn cleared_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    attachments: &Attachments,
    picture: &Picture<'_>,
    target: &Target<'_>,
) -> wgpu::RenderPass<'e> {
    let [r, g, b] = picture.development.value(picture.background.as_vec3().to_array()).map(f64::from);
    let (view, resolve_target) = match &attachments.multisampled {
        Some(view) => (view, Some(target.view)),
        None => (target.view, None),
    };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("scene"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &attachments.depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    let (left, top, width, height) = target.viewport;
    pass.set_viewport(left as f32, top as f32, width as f32, height as f32, 0.0, 1.0);
    pass.set_scissor_rect(left, top, width, height);
    pass
}
