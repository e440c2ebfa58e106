//! Textures and buffers on the GPU.

use image::RgbaImage;

use super::gpu::{Gpu, GpuError};

/// Format of images without a window.
pub(super) const IMAGE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Depth is reversed: nearer is greater.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Depth and multisampled colours of a size.
#[derive(Debug)]
pub(super) struct Attachments {
    pub(super) size: (u32, u32),
    pub(super) depth: wgpu::TextureView,
    /// The colours before they are resolved, if there is more than one sample per pixel.
    pub(super) multisampled: Option<wgpu::TextureView>,
}

impl Attachments {
    pub(super) fn new(
        device: &wgpu::Device,
        size: (u32, u32),
        samples: u32,
        format: wgpu::TextureFormat,
    ) -> Self {
        let make = |label, format| {
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT;
            let texture = device.create_texture(&texture_descriptor(label, size, samples, format, usage));
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Self {
            size,
            depth: make("depth", DEPTH_FORMAT),
            multisampled: (samples > 1).then(|| make("multisampled", format)),
        }
    }
}

/// A vertex buffer that grows to the size of its contents.
#[derive(Debug)]
pub(super) struct GrowingBuffer {
    label: &'static str,
    pub(super) buffer: Option<wgpu::Buffer>,
}

impl GrowingBuffer {
    pub(super) fn new(label: &'static str) -> Self {
        Self { label, buffer: None }
    }

    pub(super) fn write(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) {
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

pub(super) fn texture_descriptor(
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

/// Submits the commands and reads the texture back as an image.
///
/// # Errors
/// The driver cannot map the buffer.
pub(super) fn read_back(
    gpu: &Gpu,
    mut encoder: wgpu::CommandEncoder,
    texture: &wgpu::Texture,
    (width, height): (u32, u32),
) -> Result<RgbaImage, GpuError> {
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    let slice = buffer.slice(..);
    slice.map_async(wgpu::MapMode::Read, |_| ());
    let failed = |error: &dyn std::fmt::Display| GpuError::ReadBack(error.to_string());
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
    let mapped = slice.get_mapped_range().map_err(|error| failed(&error))?;
    let mut bytes: Vec<u8> = mapped
        .chunks_exact(row as usize)
        .flat_map(|line| line[..4 * width as usize].iter().copied())
        .collect();
    if matches!(texture.format(), wgpu::TextureFormat::Bgra8Unorm) {
        bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
    }
    bytes.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
    RgbaImage::from_raw(width, height, bytes).ok_or_else(|| failed(&"its size does not fit"))
}
