//! egui in the window: input, textures and the panel's render pass.

use std::time::Duration;

use superegg_scene::Theme;
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use crate::draw::Gpu;

/// The state of egui.
pub(super) struct EguiLayer {
    context: egui::Context,
    state: egui_winit::State,
    renderer: egui_wgpu::Renderer,
}

/// The shapes of a frame, ready to be painted.
pub(super) struct UiPaint {
    jobs: Vec<egui::ClippedPrimitive>,
    /// Textures to free after the frame.
    free: Vec<egui::TextureId>,
    pub(super) pixels_per_point: f32,
    /// The next frame is due after this time.
    pub(super) repaint_after: Duration,
}

impl EguiLayer {
    pub(super) fn new(
        gpu: &Gpu,
        format: wgpu::TextureFormat,
        window: &Window,
        event_loop: &ActiveEventLoop,
    ) -> Self {
        let context = egui::Context::default();
        let state = egui_winit::State::new(
            context.clone(),
            egui::ViewportId::ROOT,
            event_loop,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        Self { renderer: egui_wgpu::Renderer::new(&gpu.device, format, options), context, state }
    }

    pub(super) fn on_window_event(
        &mut self,
        window: &Window,
        event: &WindowEvent,
    ) -> egui_winit::EventResponse {
        self.state.on_window_event(window, event)
    }

    /// The pointer is over a panel.
    pub(super) fn wants_pointer(&self) -> bool {
        self.context.egui_wants_pointer_input()
    }

    /// A text field has the keyboard.
    pub(super) fn wants_keyboard(&self) -> bool {
        self.context.egui_wants_keyboard_input()
    }

    /// Moves the keyboard to the next widget of the panel.
    pub(super) fn focus_next(&self) {
        self.context.memory_mut(|memory| memory.move_focus(egui::FocusDirection::Next));
    }

    /// Runs one frame of the user interface and uploads its textures.
    pub(super) fn run(
        &mut self,
        gpu: &Gpu,
        window: &Window,
        theme: Theme,
        ui: impl FnMut(&mut egui::Ui),
    ) -> UiPaint {
        self.context.options_mut(|options| {
            options.theme_preference = match theme {
                Theme::System => egui::ThemePreference::System,
                Theme::Light => egui::ThemePreference::Light,
                Theme::Dark => egui::ThemePreference::Dark,
            };
        });
        let input = self.state.take_egui_input(window);
        let output = self.context.run_ui(input, ui);
        self.state.handle_platform_output(window, output.platform_output);
        // Before anything can fail: a skipped upload would be missing in later frames.
        let mut textures = output.textures_delta;
        for (id, deltas) in &textures.set {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, *id, delta);
            }
        }
        let free = std::mem::take(&mut textures.free).into_iter().collect();
        textures.clear();
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        UiPaint {
            free,
            repaint_after: root.map_or(Duration::MAX, |root| root.repaint_delay),
            jobs: self.context.tessellate(output.shapes, output.pixels_per_point),
            pixels_per_point: output.pixels_per_point,
        }
    }

    /// Records the pass that draws the user interface over a view of this size in pixels. Returns
    /// commands to submit before it.
    pub(super) fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        paint: &UiPaint,
        view: &wgpu::TextureView,
        (width, height): (u32, u32),
    ) -> Vec<wgpu::CommandBuffer> {
        let descriptor = egui_wgpu::ScreenDescriptor {
            size_in_pixels: [width, height],
            pixels_per_point: paint.pixels_per_point,
        };
        let commands =
            self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &paint.jobs, &descriptor);
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panel"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), &paint.jobs, &descriptor);
        commands
    }

    /// Frees the textures that the frame was the last to use.
    pub(super) fn free_textures(&mut self, paint: &UiPaint) {
        for id in &paint.free {
            self.renderer.free_texture(id);
        }
    }
}
