//! The graphics device: hardware, or a software driver where there is none.

use thiserror::Error;
use wgpu::{Adapter, Backends, Device, Instance, InstanceDescriptor, Queue, Surface};

/// Why nothing can be drawn. The text is one line without a full stop.
#[derive(Debug, Error)]
pub enum GpuError {
    /// There is no driver.
    #[error(
        "no graphics driver was found, not even a software one ({0}); on Debian mesa-vulkan-drivers, or libegl1 with libgl1-mesa-dri, has one"
    )]
    NoAdapter(String),
    /// The driver refuses a device.
    #[error("the graphics driver gives no device: {0}")]
    NoDevice(String),
    /// The window has no usable surface.
    #[error("the window cannot be drawn into: {0}")]
    NoSurface(String),
    /// A picture cannot be read back.
    #[error("the picture cannot be read back: {0}")]
    ReadBack(String),
}

/// Tries the modern drivers first, then OpenGL: its start costs time, and some of its libraries
/// print to the terminal. Returns the first error if both fail.
pub(crate) fn by_family<T>(attempt: impl Fn(Backends) -> Result<T, GpuError>) -> Result<T, GpuError> {
    attempt(Backends::PRIMARY).or_else(|first| attempt(Backends::GL).map_err(|_| first))
}

/// A device with its queue. Clones share it.
#[derive(Clone, Debug)]
pub struct Gpu {
    pub(crate) adapter: Adapter,
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    /// The driver draws on the CPU.
    pub is_software: bool,
}

impl Gpu {
    /// Opens a device without a window.
    ///
    /// # Errors
    /// There is no driver, or it refuses a device.
    pub fn headless() -> Result<Self, GpuError> {
        by_family(|backends| {
            let descriptor = InstanceDescriptor::new_without_display_handle();
            Self::new(&Instance::new(InstanceDescriptor { backends, ..descriptor }.with_env()), None)
        })
    }

    pub(crate) fn new(instance: &Instance, surface: Option<&Surface<'_>>) -> Result<Self, GpuError> {
        let options = wgpu::RequestAdapterOptions { compatible_surface: surface, ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|error| GpuError::NoAdapter(error.to_string()))?;
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..wgpu::DeviceDescriptor::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::NoDevice(error.to_string()))?;
        let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        Ok(Self { adapter, device, queue, is_software })
    }

    /// Names of the device and of the driver family.
    pub fn describe(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({:?})", info.name, info.backend)
    }
}
