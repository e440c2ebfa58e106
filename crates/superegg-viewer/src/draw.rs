//! Drawing on the GPU, into a window or into an image. It knows cameras, instances, lines and marks, and nothing of windows or switches'
//! keys.

mod lod;
mod meshes;
mod pipelines;

use std::time::Instant;

use image::RgbaImage;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_render::{Development, Film};
use superegg_scene::{Camera, Encoding, Light, LightKind, Shading};
use wgpu::util::DeviceExt;

use self::lod::LevelOfDetail;
use self::meshes::{MeshKey, Meshes};
use self::pipelines::Pipelines;
use crate::frame_stats::DrawStats;
use crate::gpu::{Gpu, GpuError};
use crate::preview::{Preview, PreviewInstance};

/// What WGSL source the module draws with.
pub const SHADERS: &str = include_str!("draw/shaders.wgsl");

/// The most lights that shine in the preview.
pub const MOST_LIGHTS: usize = 32;
/// The format of images without a window.
const IMAGE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// The near plane, in distances from the eye to what it looks at.
const NEAR: f64 = 1e-4;

/// A straight line in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its ends.
    pub ends: [DVec3; 2],
    /// Red, green, blue and opacity, as on the screen.
    pub color: [f32; 4],
}

/// A small sphere in the world that shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Its centre.
    pub center: DVec3,
    /// Its radius.
    pub radius: f64,
    /// Red, green, blue and opacity, as on the screen.
    pub color: [f32; 4],
}

/// How solids are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Surfaces.
    Solid(Shading),
    /// Patch edges, those in front bright, those behind dim; with normals or without.
    Wireframe {
        /// Lines along the normals at the vertices.
        has_normals: bool,
    },
}

/// A picture to be drawn.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The eye.
    pub camera: Camera,
    /// The lights, in the world of the camera.
    pub lights: &'a [Light],
    /// The linear colour behind everything.
    pub background: DVec3,
    /// How linear colours become bytes.
    pub encoding: Encoding,
    /// The solids.
    pub preview: &'a Preview,
    /// How they are drawn.
    pub style: Style,
    /// The shape whose edges are shown over the surfaces.
    pub selected: Option<u32>,
    /// Lines in the world.
    pub lines: &'a [Line],
    /// Marks in the world.
    pub marks: &'a [Mark],
    /// Taken instead of all that, over the whole viewport.
    pub film: Option<&'a FilmTexture>,
}

/// A traced picture on the GPU.
#[derive(Debug)]
pub struct FilmTexture {
    bind_group: wgpu::BindGroup,
}

/// Where a picture goes.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// The colours.
    pub view: &'a wgpu::TextureView,
    /// Width and height of all of it, in pixels.
    pub size: (u32, u32),
    /// Left, top, width and height of the part that the picture takes.
    pub viewport: (u32, u32, u32, u32),
}

#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct FrameUniform {
    projection: [f32; 4],
    counts: [u32; 4],
    lights: [[f32; 12]; MOST_LIGHTS],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct InstanceData {
    rows: [[f32; 4]; 3],
    color_ambient: [f32; 4],
    surface: [f32; 4],
    /// Columns of the map for normals.
    normals: [[f32; 3]; 3],
}

/// Which of its triangles an instance shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sides {
    /// Those that face the eye.
    Front,
    /// The same of a mirrored instance, whose triangles go round the other way.
    MirroredFront,
    /// All: the eye may be inside.
    Both,
}

impl Sides {
    const ALL: [Self; 3] = [Self::Front, Self::MirroredFront, Self::Both];

    fn of(space: &EyeSpace, instance: &PreviewInstance, data: &InstanceData) -> Self {
        let center = space.eye_from_world.transform_point3(instance.world_from_unit.translation);
        if center.length() <= 1.001 * instance.radius / space.unit + NEAR {
            Self::Both
        } else if data.surface[3] < 0.0 {
            Self::MirroredFront
        } else {
            Self::Front
        }
    }
}

/// Instances of one mesh, next to each other in the buffer.
#[derive(Clone, Copy, Debug)]
struct Batch {
    mesh: usize,
    sides: Sides,
    first: u32,
    count: u32,
}

/// The drawing module. One serves one format of target.
#[derive(Debug)]
pub struct Drawing {
    device: wgpu::Device,
    queue: wgpu::Queue,
    format: wgpu::TextureFormat,
    /// Samples a pixel of the edges' smoothing.
    samples: u32,
    /// Triangles that a picture may cost.
    triangle_budget: usize,
    pipelines: Pipelines,
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    meshes: Meshes,
    instances: GrowingBuffer,
    lines: GrowingBuffer,
    marks: GrowingBuffer,
    /// Depth and multisampled colours, with their size.
    attachments: Option<Attachments>,
}

#[derive(Debug)]
struct Attachments {
    size: (u32, u32),
    depth: wgpu::TextureView,
    multisampled: Option<wgpu::TextureView>,
}

/// A vertex buffer that grows to what is written into it.
#[derive(Debug)]
struct GrowingBuffer {
    label: &'static str,
    buffer: Option<wgpu::Buffer>,
}

impl GrowingBuffer {
    fn new(label: &'static str) -> Self {
        Self { label, buffer: None }
    }

    fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        match &self.buffer {
            Some(buffer) if buffer.size() >= bytes.len() as u64 => queue.write_buffer(buffer, 0, bytes),
            _ => {
                let size = (bytes.len() as u64).next_power_of_two().max(4096);
                let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(self.label),
                    size,
                    usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                queue.write_buffer(&buffer, 0, bytes);
                self.buffer = Some(buffer);
            }
        }
    }
}

impl Drawing {
    /// A module that draws into targets of a format; colours are written as they are on the screen, so it should not be an sRGB one.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let device = gpu.device.clone();
        // On the processor each sample costs as much as a pixel.
        let samples = if gpu.is_software { 1 } else { 4 };
        let pipelines = Pipelines::new(&device, format, samples);
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
            meshes: Meshes::new(&device),
            queue: gpu.queue.clone(),
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
            device,
        }
    }

    /// A module that draws into images.
    pub fn for_images(gpu: &Gpu) -> Self {
        Self::new(gpu, IMAGE_FORMAT)
    }

    /// Forgets all meshes; the next picture makes them anew.
    pub fn forget_meshes(&mut self) {
        self.meshes = Meshes::new(&self.device);
    }

    /// How many meshes are on the GPU.
    pub fn mesh_count(&self) -> usize {
        self.meshes.len()
    }

    /// A traced picture for [`Picture::film`]. Enlarged it is smoothed.
    pub fn upload_film(&self, film: &Film, development: &Development) -> FilmTexture {
        let bytes = development.rgb8(film);
        let rgba: Vec<u8> = bytes.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
        let texture = self.device.create_texture_with_data(
            &self.queue,
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
        FilmTexture { bind_group: self.pipelines.film_group(&self.device, &view) }
    }

    /// Records the drawing of a picture.
    pub fn draw(
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
        self.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame_uniform(&space, picture)));
        let is_traced = picture.film.is_some();
        let (batches, selected) =
            if is_traced { Default::default() } else { self.prepare_instances(picture, &space, &mut stats) };
        let line_count = if is_traced { 0 } else { self.prepare_lines(picture, &space) };
        let (opaque_marks, marks) = if is_traced { (0, 0) } else { self.prepare_marks(picture, &space) };
        self.ensure_attachments(target.size);

        let Some(attachments) = &self.attachments else { return stats };
        let background = encoded(picture.background, picture.encoding);
        let color = match &attachments.multisampled {
            Some(view) => (view, Some(target.view)),
            None => (target.view, None),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: color.0,
                depth_slice: None,
                resolve_target: color.1,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color {
                        r: background[0],
                        g: background[1],
                        b: background[2],
                        a: 1.0,
                    }),
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
        pass.set_bind_group(0, &self.frame_group, &[]);
        if let Some(film) = picture.film {
            pass.set_pipeline(&self.pipelines.film);
            pass.set_bind_group(1, &film.bind_group, &[]);
            pass.draw(0..3, 0..1);
            stats.seconds = begin.elapsed().as_secs_f64();
            return stats;
        }
        match picture.style {
            Style::Solid(shading) => {
                let pipeline = match shading {
                    Shading::Phong => &self.pipelines.phong,
                    Shading::Gouraud => &self.pipelines.gouraud,
                };
                self.draw_triangles(&mut pass, pipeline, &batches);
                if let Some(selected) = selected {
                    self.draw_edges(&mut pass, &self.pipelines.selected_edge, &[selected]);
                }
                self.draw_lines(&mut pass, line_count);
                self.draw_marks(&mut pass, opaque_marks, marks);
            }
            Style::Wireframe { has_normals } => {
                // Marks are seen through the wires, and hide those behind them.
                self.draw_marks(&mut pass, opaque_marks, marks);
                self.draw_edges(&mut pass, &self.pipelines.dim_edge, &batches);
                self.draw_triangles(&mut pass, &self.pipelines.depth, &batches);
                self.draw_edges(&mut pass, &self.pipelines.edge, &batches);
                if let Some(selected) = selected {
                    self.draw_edges(&mut pass, &self.pipelines.selected_edge, &[selected]);
                }
                if has_normals {
                    self.draw_normals(&mut pass, &batches);
                }
                self.draw_lines(&mut pass, line_count);
            }
        }
        stats.draws = batches.len();
        stats.seconds = begin.elapsed().as_secs_f64();
        stats
    }

    /// Draws a picture into an image of its own.
    ///
    /// # Errors
    /// It cannot be read back.
    pub fn draw_to_image(
        &mut self,
        picture: &Picture<'_>,
        (width, height): (u32, u32),
    ) -> Result<(RgbaImage, DrawStats), GpuError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let texture =
            self.device.create_texture(&texture_descriptor("image", (width, height), 1, self.format, usage));
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = Target { view: &view, size: (width, height), viewport: (0, 0, width, height) };
        let stats = self.draw(&mut encoder, picture, &target);
        let image = self.read_back(encoder, &texture, (width, height))?;
        Ok((image, stats))
    }

    fn read_back(
        &self,
        mut encoder: wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        (width, height): (u32, u32),
    ) -> Result<RgbaImage, GpuError> {
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        self.queue.submit([encoder.finish()]);
        let slice = buffer.slice(..);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        let failed = |error: &dyn std::fmt::Display| GpuError::ReadBack(error.to_string());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        let mapped = slice.get_mapped_range().map_err(|error| failed(&error))?;
        let mut bytes: Vec<u8> = mapped
            .chunks_exact(row as usize)
            .flat_map(|line| line[..4 * width as usize].iter().copied())
            .collect();
        if matches!(self.format, wgpu::TextureFormat::Bgra8Unorm) {
            bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
        }
        bytes.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
        RgbaImage::from_raw(width, height, bytes).ok_or_else(|| failed(&"its size does not fit"))
    }

    /// Chooses what is seen and how finely, brings it to the eye, and sorts it by mesh. Returns the batches, and that of the selected shape.
    fn prepare_instances(
        &mut self,
        picture: &Picture<'_>,
        space: &EyeSpace,
        stats: &mut DrawStats,
    ) -> (Vec<Batch>, Option<Batch>) {
        let preview = picture.preview;
        let is_wireframe = matches!(picture.style, Style::Wireframe { .. });
        let seen: Vec<(&PreviewInstance, f64)> =
            preview.instances.iter().filter_map(|i| Some((i, space.size_px(i)?))).collect();
        let detail = LevelOfDetail::within(
            self.triangle_budget,
            is_wireframe,
            seen.iter().map(|(i, size_px)| (preview.shapes[i.shape as usize].patches, *size_px)),
        );
        stats.coarser = detail.coarser;

        let mut mesh_of: std::collections::HashMap<(u32, u8), usize> = std::collections::HashMap::new();
        let mut counts: Vec<u32> = Vec::new();
        let placed: Vec<(usize, InstanceData, u32)> = seen
            .iter()
            .map(|(instance, size_px)| {
                let shape = &preview.shapes[instance.shape as usize];
                let level = detail.level(shape.patches, *size_px);
                let mesh = *mesh_of
                    .entry((instance.shape, level))
                    .or_insert_with(|| self.meshes.ensure(&self.device, MeshKey::new(shape, level)));
                let data = instance_data(space, instance, &shape.material);
                let place = 3 * mesh + Sides::of(space, instance, &data) as usize;
                if counts.len() <= place {
                    counts.resize(place + 1, 0);
                }
                counts[place] += 1;
                (place, data, instance.shape)
            })
            .collect();

        let mut batches = Vec::new();
        let mut next: Vec<u32> = Vec::with_capacity(counts.len());
        let mut first = 0;
        for (place, &count) in counts.iter().enumerate() {
            next.push(first);
            if count > 0 {
                let (mesh, sides) = (place / 3, Sides::ALL[place % 3]);
                batches.push(Batch { mesh, sides, first, count });
                let size = self.meshes.get(mesh);
                let cost = if is_wireframe { size.edge_count } else { size.triangle_count };
                stats.triangles += cost as usize * count as usize;
            }
            first += count;
        }
        let mut sorted = vec![InstanceData::default(); placed.len()];
        let mut selected: Vec<InstanceData> = Vec::new();
        let mut selected_mesh = 0;
        for (place, data, shape) in &placed {
            sorted[next[*place] as usize] = *data;
            next[*place] += 1;
            if picture.selected == Some(*shape) {
                // One mesh for all of them: the finest.
                selected_mesh =
                    self.meshes.ensure(&self.device, MeshKey::new(&preview.shapes[*shape as usize], 0));
                selected.push(*data);
            }
        }
        stats.instances = placed.len();
        let selected_batch = (!selected.is_empty()).then_some(Batch {
            mesh: selected_mesh,
            sides: Sides::Both,
            first: sorted.len() as u32,
            count: selected.len() as u32,
        });
        sorted.extend(selected);
        self.instances.write(&self.device, &self.queue, bytemuck::cast_slice(&sorted));
        (batches, selected_batch)
    }

    fn prepare_lines(&mut self, picture: &Picture<'_>, space: &EyeSpace) -> u32 {
        let ends: Vec<[f32; 7]> = picture
            .lines
            .iter()
            .flat_map(|line| line.ends.map(|end| (end, line.color)))
            .map(|(end, [r, g, b, a])| {
                let [x, y, z] = space.point(end);
                [x, y, z, r, g, b, a]
            })
            .collect();
        self.lines.write(&self.device, &self.queue, bytemuck::cast_slice(&ends));
        ends.len() as u32
    }

    /// Opaque marks come first. Returns their number, and that of all.
    fn prepare_marks(&mut self, picture: &Picture<'_>, space: &EyeSpace) -> (u32, u32) {
        let is_opaque = |mark: &&Mark| mark.color[3] >= 1.0;
        let data = |mark: &Mark| -> [[f32; 4]; 2] {
            let [x, y, z] = space.point(mark.center);
            [[x, y, z, (mark.radius / space.unit) as f32], mark.color]
        };
        let mut all: Vec<_> = picture.marks.iter().filter(is_opaque).map(data).collect();
        let opaque = all.len() as u32;
        all.extend(picture.marks.iter().filter(|mark| !is_opaque(mark)).map(data));
        self.marks.write(&self.device, &self.queue, bytemuck::cast_slice(&all));
        (opaque, all.len() as u32)
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

    fn draw_lines(&self, pass: &mut wgpu::RenderPass<'_>, count: u32) {
        if let (Some(lines), 1..) = (&self.lines.buffer, count) {
            pass.set_pipeline(&self.pipelines.line);
            pass.set_vertex_buffer(0, lines.slice(..));
            pass.draw(0..count, 0..1);
        }
    }

    fn draw_marks(&self, pass: &mut wgpu::RenderPass<'_>, opaque: u32, all: u32) {
        let Some(marks) = &self.marks.buffer else { return };
        let ball = &self.meshes.ball;
        for (pipeline, range) in
            [(&self.pipelines.opaque_mark, 0..opaque), (&self.pipelines.clear_mark, opaque..all)]
        {
            if !range.is_empty() {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, ball.vertices.slice(..));
                pass.set_vertex_buffer(1, marks.slice(..));
                pass.set_index_buffer(ball.triangles.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..3 * ball.triangle_count, 0, range);
            }
        }
    }

    fn ensure_attachments(&mut self, size: (u32, u32)) {
        if self.attachments.as_ref().is_some_and(|attachments| attachments.size == size) {
            return;
        }
        let make = |label, format| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
            let texture =
                self.device.create_texture(&texture_descriptor(label, size, self.samples, format, usage));
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        self.attachments = Some(Attachments {
            size,
            depth: make("depth", DEPTH_FORMAT),
            multisampled: (self.samples > 1).then(|| make("multisampled", self.format)),
        });
    }
}

fn texture_descriptor(
    label: &'static str,
    (width, height): (u32, u32),
    samples: u32,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

/// The space of the eye, one unit from the eye to its target: then f32 serves for any scene.
struct EyeSpace {
    eye_from_world: DAffine3,
    unit: f64,
    /// Cotangents of half the angles of view.
    scale_x: f64,
    scale_y: f64,
    height_px: f64,
}

impl EyeSpace {
    fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let (right, up, forward) = camera.frame();
        let unit = (camera.target - camera.position).length().clamp(1e-150, 1e150);
        let turn = DMat3::from_cols(right, up, -forward).transpose() * (1.0 / unit);
        let eye_from_world = DAffine3 { matrix3: turn, translation: -(turn * camera.position) };
        let scale_y = 1.0 / (0.5 * camera.fov_deg.to_radians()).tan();
        let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
        Self { eye_from_world, unit, scale_x: scale_y / aspect, scale_y, height_px: f64::from(height) }
    }

    fn point(&self, world: DVec3) -> [f32; 3] {
        // Far beyond what is seen, and within f32.
        let place =
            self.eye_from_world.transform_point3(world).clamp(DVec3::splat(-1e30), DVec3::splat(1e30));
        place.as_vec3().to_array()
    }

    /// The radius on the screen of what is at least partly in the picture, in pixels.
    fn size_px(&self, instance: &PreviewInstance) -> Option<f64> {
        let center = self.eye_from_world.transform_point3(instance.world_from_unit.translation);
        let radius = instance.radius / self.unit;
        let depth = -center.z;
        // The planes through the eye and the picture's sides, and the near plane.
        let beyond =
            |across: f64, scale: f64| across.abs() * scale - depth > radius * (1.0 + scale * scale).sqrt();
        if !(center.is_finite() && center.abs().max_element() < 1e30)
            || depth + radius < NEAR
            || beyond(center.x, self.scale_x)
            || beyond(center.y, self.scale_y)
        {
            return None;
        }
        let distance = (center.length() - radius).max(1e-3 * radius);
        Some(0.5 * self.height_px * self.scale_y * radius / distance)
    }
}

fn frame_uniform(space: &EyeSpace, picture: &Picture<'_>) -> FrameUniform {
    let mut lights = [[0.0; 12]; MOST_LIGHTS];
    let shining = picture.lights.iter().take(MOST_LIGHTS);
    for (place, light) in lights.iter_mut().zip(shining.clone()) {
        *place = light_numbers(space, light);
    }
    let is_curved = if picture.encoding == Encoding::Srgb { 1.0 } else { 0.0 };
    FrameUniform {
        projection: [space.scale_x as f32, space.scale_y as f32, NEAR as f32, is_curved],
        counts: [shining.len() as u32, 0, 0, 0],
        lights,
    }
}

/// A light as the shader takes it: place and falloff, colour and softness of the rim, axis and half angle of the cone. A sun has its direction
/// for a place and a softness below 0; a light that shines to all sides has no angle.
fn light_numbers(space: &EyeSpace, light: &Light) -> [f32; 12] {
    let falloff = (light.falloff * space.unit * space.unit).min(1e30) as f32;
    let [r, g, b] = light.color.min(DVec3::splat(1e30)).as_vec3().to_array();
    let turned = |direction: DVec3| {
        let unit = superegg_geom::unit_vector(direction).unwrap_or(DVec3::NEG_Z);
        (space.eye_from_world.matrix3 * unit).normalize_or_zero().as_vec3().to_array()
    };
    match light.kind {
        LightKind::Point { position } => {
            let [x, y, z] = space.point(position);
            [x, y, z, falloff, r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0]
        }
        LightKind::Spot { position, target, cone_deg, soft } => {
            let [x, y, z] = space.point(position);
            let [ax, ay, az] = turned(target - position);
            let half_rad = 0.5 * cone_deg.to_radians() as f32;
            [x, y, z, falloff, r, g, b, soft as f32, ax, ay, az, half_rad]
        }
        LightKind::Sun { direction } => {
            let [x, y, z] = turned(direction);
            [x, y, z, 0.0, r, g, b, -1.0, 0.0, 0.0, 0.0, 0.0]
        }
    }
}

fn instance_data(
    space: &EyeSpace,
    instance: &PreviewInstance,
    material: &superegg_scene::Material,
) -> InstanceData {
    let map = space.eye_from_world * instance.world_from_unit;
    let m = map.matrix3;
    let row = |x: f64, y: f64, z: f64, t: f64| [x as f32, y as f32, z as f32, t as f32];
    let rows = [
        row(m.x_axis.x, m.y_axis.x, m.z_axis.x, map.translation.x),
        row(m.x_axis.y, m.y_axis.y, m.z_axis.y, map.translation.y),
        row(m.x_axis.z, m.y_axis.z, m.z_axis.z, map.translation.z),
    ];
    let [r, g, b] = material.color.as_vec3().to_array();
    // Of unit columns, so that no product leaves the range of numbers.
    let size = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element().max(1e-300);
    let column = |v: DVec3| v / v.abs().max_element().max(1e-300);
    let (x, y, z) = (column(m.x_axis), column(m.y_axis), column(m.z_axis));
    let sign = if DMat3::from_cols(x, y, z).determinant() < 0.0 { -1.0 } else { 1.0 };
    // The cofactors are the inverse transpose but for the determinant.
    let m = m * (1.0 / size);
    let cofactors = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
    let largest = cofactors.iter().fold(1e-300, |all: f64, c| all.max(c.abs().max_element()));
    InstanceData {
        rows,
        color_ambient: [r, g, b, material.ambient as f32],
        surface: [
            material.diffuse as f32,
            material.specular as f32,
            material.highlight_exponent().min(1e6) as f32,
            sign as f32,
        ],
        normals: cofactors.map(|c| (c * (sign / largest)).as_vec3().to_array()),
    }
}

/// A linear colour as it is on the screen.
pub(crate) fn encoded(color: DVec3, encoding: Encoding) -> [f64; 3] {
    let curve = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        match encoding {
            Encoding::Linear => x,
            Encoding::Srgb if x <= 0.003_130_8 => 12.92 * x,
            Encoding::Srgb => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        }
    };
    color.to_array().map(curve)
}
