//! The open window with its surface and its GPU.

use std::fmt::Display;
use std::sync::Arc;

use wgpu::CurrentSurfaceTexture;
use winit::dpi::PhysicalSize;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::Window;

use super::egui_layer::EguiLayer;
use crate::draw::{Drawing, FilmTexture, Gpu, GpuError, by_family};
use crate::event::Event;
use crate::frame_stats::DrawStats;
use crate::text::first_line;

const FIRST_SIZE: (u32, u32) = (1280, 860);
/// A surface that fails more often in a row is left alone, so that it keeps no CPU busy.
const MOST_FAILURES: u32 = 20;
/// A driver that fails more often in a row is given up.
const MOST_REBUILDS: u32 = 5;

/// The open window.
pub(super) struct OpenWindow {
    pub(super) surface: WindowSurface,
    pub(super) gpu: Gpu,
    pub(super) drawing: Drawing,
    /// The last pass of the tracer.
    pub(super) film: Option<FilmTexture>,
    /// Statistics of the last frame.
    pub(super) stats: DrawStats,
    pub(super) egui: EguiLayer,
    /// Name of device and driver.
    pub(super) device_name: String,
    /// Status lines in the last frame.
    pub(super) status_lines: usize,
}

/// The window and the surface on it. The surface is dropped before the window.
pub(super) struct WindowSurface {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    instance: wgpu::Instance,
    device: wgpu::Device,
    pub(super) window: Arc<Window>,
    /// Failures in a row.
    failures: u32,
}

fn no_surface(error: &dyn Display) -> GpuError {
    GpuError::NoSurface(first_line(&error.to_string()))
}

impl OpenWindow {
    /// Opens a window.
    ///
    /// # Errors
    /// The system refuses a window, or there is no graphics driver for it.
    pub(super) fn open(
        event_loop: &ActiveEventLoop,
        proxy: &EventLoopProxy<Event>,
    ) -> Result<Self, GpuError> {
        let (width, height) = FIRST_SIZE;
        let attributes = Window::default_attributes()
            .with_title("Superegg")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(event_loop.create_window(attributes).map_err(|error| no_surface(&error))?);
        Self::on(&window, event_loop, proxy)
    }

    fn on(
        window: &Arc<Window>,
        event_loop: &ActiveEventLoop,
        proxy: &EventLoopProxy<Event>,
    ) -> Result<Self, GpuError> {
        let (surface, gpu) =
            by_family(|backends| WindowSurface::new(Arc::clone(window), event_loop, backends))?;
        report_faults(&gpu, proxy);
        let format = surface.config.format;
        Ok(Self {
            drawing: Drawing::new(&gpu, format),
            egui: EguiLayer::new(&gpu, format, window, event_loop),
            device_name: gpu.describe(),
            film: None,
            stats: DrawStats::default(),
            status_lines: 0,
            surface,
            gpu,
        })
    }

    /// Makes the surface and everything on the GPU again after a fault of the driver.
    ///
    /// # Errors
    /// That fails, or the driver has failed too often in a row.
    pub(super) fn rebuild(
        self,
        event_loop: &ActiveEventLoop,
        proxy: &EventLoopProxy<Event>,
        fault: &str,
    ) -> Result<Self, String> {
        let failures = self.surface.failures + 1;
        let window = Arc::clone(&self.surface.window);
        // A window has one surface at a time.
        drop(self);
        let mut rebuilt = Self::on(&window, event_loop, proxy).map_err(|error| error.to_string())?;
        if failures >= MOST_REBUILDS {
            return Err(fault.to_owned());
        }
        rebuilt.surface.failures = failures;
        Ok(rebuilt)
    }

    /// Restores the window if it is minimised, and gives it the keyboard.
    pub(super) fn focus(&self) {
        self.surface.window.set_minimized(false);
        self.surface.window.focus_window();
    }

    pub(super) fn request_redraw(&self) {
        self.surface.window.request_redraw();
    }
}

/// Sends errors of the GPU as events. Without a handler they end the process.
fn report_faults(gpu: &Gpu, proxy: &EventLoopProxy<Event>) {
    let fault_proxy = proxy.clone();
    gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        let _ = fault_proxy.send_event(Event::GpuFault(first_line(&error.to_string())));
    }));
    let lost_proxy = proxy.clone();
    gpu.device.set_device_lost_callback(move |reason, message| {
        if reason != wgpu::DeviceLostReason::Destroyed {
            let _ = lost_proxy.send_event(Event::GpuFault(first_line(&message)));
        }
    });
}

impl WindowSurface {
    fn new(
        window: Arc<Window>,
        event_loop: &ActiveEventLoop,
        backends: wgpu::Backends,
    ) -> Result<(Self, Gpu), GpuError> {
        let display = Box::new(event_loop.owned_display_handle());
        let descriptor = wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_with_display_handle(display)
        };
        let instance = wgpu::Instance::new(descriptor.with_env());
        let surface = instance.create_surface(Arc::clone(&window)).map_err(|error| no_surface(&error))?;
        let gpu = Gpu::new(&instance, Some(&surface))?;
        let size = window.inner_size();
        let capabilities = surface.get_capabilities(&gpu.adapter);
        // The shaders encode colours themselves.
        let format =
            capabilities.formats.iter().find(|format| !format.is_srgb()).or(capabilities.formats.first());
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_surface(&"the driver knows no format for it"))?;
        config.format = format.copied().unwrap_or(config.format);
        config.desired_maximum_frame_latency = 1;
        surface.configure(&gpu.device, &config);
        let device = gpu.device.clone();
        Ok((Self { surface, config, instance, device, window, failures: 0 }, gpu))
    }

    /// Width and height in pixels. Both are 0 while the window is minimised.
    pub(super) fn size(&self) -> (u32, u32) {
        (self.config.width, self.config.height)
    }

    pub(super) fn resize(&mut self, size: PhysicalSize<u32>) {
        let limit = self.device.limits().max_texture_dimension_2d;
        (self.config.width, self.config.height) = (size.width.min(limit), size.height.min(limit));
        self.reconfigure();
    }

    fn has_pixels(&self) -> bool {
        self.config.width > 0 && self.config.height > 0
    }

    fn reconfigure(&self) {
        // wgpu rejects a surface without pixels.
        if self.has_pixels() {
            self.surface.configure(&self.device, &self.config);
        }
    }

    /// The next image of the surface. After a failure it repairs the surface and requests another
    /// frame.
    pub(super) fn acquire(&mut self) -> Option<wgpu::SurfaceTexture> {
        if !self.has_pixels() {
            return None;
        }
        match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) => {
                self.failures = 0;
                return Some(texture);
            }
            CurrentSurfaceTexture::Suboptimal(texture) => {
                drop(texture);
                self.reconfigure();
            }
            CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return None,
            CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation => self.reconfigure(),
            CurrentSurfaceTexture::Lost => {
                if let Ok(surface) = self.instance.create_surface(Arc::clone(&self.window)) {
                    self.surface = surface;
                    self.reconfigure();
                }
            }
        }
        self.failures += 1;
        if self.failures < MOST_FAILURES {
            self.window.request_redraw();
        }
        None
    }
}
