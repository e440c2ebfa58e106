//! The window: events in, pictures out.

use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use superegg_geom::glam::DVec2;
use superegg_geom::{Aabb, Ray};
use superegg_render::{Development, RenderSettings, Surroundings};
use superegg_scene::{Camera, Light, Scene};
use superegg_trace::CompiledScene;
use wgpu::CurrentSurfaceTexture;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::{Window, WindowId};

use crate::annotations;
use crate::cast::{CastHit, cast, lines_and_marks};
use crate::draw::{Drawing, FilmTexture, Line, Mark, Picture, Style, Target};
use crate::frame_stats::DrawStats;
use crate::gpu::{Gpu, GpuError, by_family};
use crate::io_grid::{GridSpec, IoGrid};
use crate::keys::{Action, action_of};
use crate::panel::{Done, Model, Panel};
use crate::preview::{Preview, PreviewBudget};
use crate::protocol::{FromViewer, Shown};
use crate::screenshot;
use crate::state::{Request, ViewState, Viewport};
use crate::tracer::{Pass, TraceJob, Tracer};
use crate::viewer::{Event, first_line};
use crate::worker::{Order, Ready, Worker};

const FIRST_SIZE: (u32, u32) = (1280, 860);
/// Two clicks within this time and distance are a double click.
const DOUBLE_CLICK: Duration = Duration::from_millis(400);
const DOUBLE_CLICK_PX: f64 = 6.0;
const NOTICE_TIME: Duration = Duration::from_secs(5);
/// Instances that the preview opens at most.
const MOST_INSTANCES: usize = 250_000;
/// The finest samples of a picture in the window; a file may ask for more.
const MOST_SAMPLES: u32 = 16;

/// The viewer as it runs.
pub(crate) struct App {
    proxy: EventLoopProxy<Event>,
    out: Sender<FromViewer>,
    first: Option<Shown>,
    window: Option<OpenWindow>,
    scene: Shown,
    /// Counts the snapshots.
    number: u64,
    /// A change that is being made in the panel, shown until it is done.
    draft: Option<Scene>,
    /// An object that stays shown while a primitive in it is selected: who clicked it wants to see it where it is.
    held_root: Option<String>,
    /// The name selected by the last double click.
    picked: Option<String>,
    view: ViewState,
    panel: Panel,
    worker: Option<Worker>,
    tracer: Option<Tracer>,
    ordered: Option<OrderKey>,
    preview: Arc<Preview>,
    selected_shape: Option<u32>,
    compiled: Option<(u64, Arc<CompiledScene>)>,
    grid: Option<Arc<IoGrid>>,
    traced: Traced,
    notice: Option<(String, Instant)>,
    modifiers: ModifiersState,
    pointer: DVec2,
    last_click: Option<(Instant, DVec2)>,
    quits: bool,
}

/// What an order depends on: a new one is sent when this differs.
#[derive(Clone, Debug, PartialEq)]
struct OrderKey {
    number: u64,
    height_px: u32,
    /// Where something is not opened because it is too small, or costs too much, the eye matters.
    camera: Option<Camera>,
    grid: Option<GridSpec>,
}

/// The ray traced picture.
#[derive(Default)]
struct Traced {
    number: u64,
    asked: Option<TraceKey>,
    pass: Option<Pass>,
}

#[derive(Clone, Debug, PartialEq)]
struct TraceKey {
    scene_number: u64,
    camera: Camera,
    lights: Vec<Light>,
    size: (u32, u32),
}

/// What there is while the window is open. The surface comes before the window it is on.
struct OpenWindow {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    instance: wgpu::Instance,
    gpu: Gpu,
    drawing: Drawing,
    film: Option<FilmTexture>,
    egui: egui::Context,
    egui_state: egui_winit::State,
    egui_renderer: egui_wgpu::Renderer,
    window: Arc<Window>,
    device_name: String,
    stats: DrawStats,
    /// Attempts to draw that failed since the last that did not.
    failures: u32,
    /// Lines at the bottom of the scene in the last frame.
    status_lines: usize,
}

impl OpenWindow {
    fn open(event_loop: &ActiveEventLoop, proxy: &EventLoopProxy<Event>) -> Result<Self, GpuError> {
        let no_surface = |error: &dyn std::fmt::Display| GpuError::NoSurface(first_line(&error.to_string()));
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
        by_family(|backends| Self::with_backends(Arc::clone(window), event_loop, proxy, backends))
    }

    fn with_backends(
        window: Arc<Window>,
        event_loop: &ActiveEventLoop,
        proxy: &EventLoopProxy<Event>,
        backends: wgpu::Backends,
    ) -> Result<Self, GpuError> {
        let no_surface = |error: &dyn std::fmt::Display| GpuError::NoSurface(first_line(&error.to_string()));
        let display = Box::new(event_loop.owned_display_handle());
        let descriptor = wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_with_display_handle(display)
        };
        let instance = wgpu::Instance::new(descriptor.with_env());
        let surface = instance.create_surface(Arc::clone(&window)).map_err(|error| no_surface(&error))?;
        let gpu = Gpu::new(&instance, Some(&surface))?;
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
        let size = window.inner_size();
        let capabilities = surface.get_capabilities(&gpu.adapter);
        let format =
            capabilities.formats.iter().find(|format| !format.is_srgb()).or(capabilities.formats.first());
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_surface(&"the driver knows no format for it"))?;
        config.format = format.copied().unwrap_or(config.format);
        config.desired_maximum_frame_latency = 1;
        surface.configure(&gpu.device, &config);
        let egui = egui::Context::default();
        egui.options_mut(|options| options.theme_preference = egui::ThemePreference::Dark);
        let egui_state = egui_winit::State::new(
            egui.clone(),
            egui::ViewportId::ROOT,
            event_loop,
            Some(window.scale_factor() as f32),
            None,
            Some(gpu.device.limits().max_texture_dimension_2d as usize),
        );
        Ok(Self {
            drawing: Drawing::new(&gpu, config.format),
            egui_renderer: egui_wgpu::Renderer::new(
                &gpu.device,
                config.format,
                egui_wgpu::RendererOptions { dithering: false, ..Default::default() },
            ),
            device_name: gpu.describe(),
            film: None,
            egui,
            egui_state,
            surface,
            config,
            instance,
            gpu,
            window,
            stats: DrawStats::default(),
            failures: 0,
            status_lines: 0,
        })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        let limit = self.gpu.device.limits().max_texture_dimension_2d;
        (self.config.width, self.config.height) = (size.width.min(limit), size.height.min(limit));
        self.reconfigure();
    }

    fn reconfigure(&self) {
        // A minimised window has no pixels, and a surface of none is refused.
        if self.config.width > 0 && self.config.height > 0 {
            self.surface.configure(&self.gpu.device, &self.config);
        }
    }

    /// The next image of the surface. What has changed is mended, for the next attempt.
    fn acquire(&mut self) -> Option<wgpu::SurfaceTexture> {
        if self.config.width == 0 || self.config.height == 0 {
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
        // Not for ever: a surface that stays lost is no reason to keep a processor busy.
        if self.failures < 20 {
            self.window.request_redraw();
        }
        None
    }
}

/// Everything of one frame that is drawn into the scene.
struct Composed {
    camera: Camera,
    lights: Vec<Light>,
    lines: Vec<Line>,
    marks: Vec<Mark>,
    hit: Option<CastHit>,
}

impl App {
    pub(crate) fn new(proxy: EventLoopProxy<Event>, out: Sender<FromViewer>, first: Option<Shown>) -> Self {
        let scene = first.clone().unwrap_or_default();
        let (worker_proxy, tracer_proxy) = (proxy.clone(), proxy.clone());
        let worker = Worker::start(move |ready| {
            let _ = worker_proxy.send_event(Event::Ready(ready));
        });
        let tracer = Tracer::start(move |pass| {
            let _ = tracer_proxy.send_event(Event::Traced(Box::new(pass)));
        });
        Self {
            proxy,
            out,
            first,
            window: None,
            number: 1,
            draft: None,
            held_root: None,
            picked: None,
            view: ViewState::new(&scene.scene.camera, scene.settings),
            scene,
            panel: Panel::default(),
            worker: worker.ok(),
            tracer: tracer.ok(),
            ordered: None,
            preview: Arc::default(),
            selected_shape: None,
            compiled: None,
            grid: None,
            traced: Traced::default(),
            notice: None,
            modifiers: ModifiersState::empty(),
            pointer: DVec2::ZERO,
            last_click: None,
            quits: false,
        }
    }

    fn tell(&mut self, what: FromViewer) {
        // Who does not listen any more does not want a window either.
        self.quits |= self.out.send(what).is_err();
    }

    fn say(&mut self, text: &str) {
        self.notice = Some((text.to_owned(), Instant::now()));
        self.tell(FromViewer::Say(text.to_owned()));
        self.redraw();
    }

    fn redraw(&self) {
        if let Some(open) = &self.window {
            open.window.request_redraw();
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(open) = &self.window {
            open.window.set_minimized(false);
            open.window.focus_window();
            return;
        }
        match OpenWindow::open(event_loop, &self.proxy) {
            Ok(open) => {
                open.window.request_redraw();
                self.window = Some(open);
                self.traced = Traced::default();
            }
            Err(error) => {
                self.tell(FromViewer::Say(format!("the viewer cannot open its window: {error}")));
                self.tell(FromViewer::Closed);
            }
        }
    }

    fn close(&mut self) {
        if self.window.take().is_some() {
            self.view.is_traced = false;
            if let Some(tracer) = &self.tracer {
                tracer.rest();
            }
            self.tell(FromViewer::Closed);
        }
    }

    fn show(&mut self, shown: Shown) {
        let has_changed = shown.scene != self.scene.scene || shown.selected != self.scene.selected;
        if self.picked.is_none() || shown.selected != self.picked {
            self.held_root = None;
            self.picked = None;
        }
        self.view.settings = shown.settings;
        self.view.set_camera(&shown.scene.camera);
        self.scene = shown;
        self.draft = None;
        if has_changed {
            self.number += 1;
        }
        self.redraw();
    }

    /// What of the scene is shown.
    fn root(&self) -> Option<&str> {
        let held = self.held_root.as_deref().filter(|name| self.scene.scene.get(name).is_some());
        held.or(self.scene.selected.as_deref())
    }

    fn shown_scene(&self) -> &Scene {
        self.draft.as_ref().unwrap_or(&self.scene.scene)
    }

    fn bounds(&self) -> Aabb {
        self.preview.bounds.unwrap_or(Aabb::EMPTY)
    }

    fn act(&mut self, action: Action) {
        let bounds = self.bounds();
        match self.view.apply(action, &bounds) {
            None => (),
            Some(Request::KeyboardBack) => self.tell(FromViewer::KeyboardBack),
            Some(Request::SettingsChanged) => self.settings_changed(),
            Some(Request::Refresh) => {
                self.number += 1;
                if let Some(open) = &mut self.window {
                    open.drawing.forget_meshes();
                }
                self.notice = Some(("refreshed".to_owned(), Instant::now()));
            }
            Some(Request::Screenshot) => self.write_screenshot(),
            Some(Request::Commands(lines)) => {
                lines.into_iter().for_each(|line| self.tell(FromViewer::Command(line)));
            }
        }
        self.redraw();
    }

    fn settings_changed(&mut self) {
        self.scene.settings = self.view.settings;
        self.tell(FromViewer::Settings(self.view.settings));
    }

    fn write_screenshot(&mut self) {
        let development = Development { transparent: false, ..Development::of(&self.shown_scene().picture) };
        let traced = self.traced.pass.as_ref().filter(|_| self.view.is_traced);
        let bytes = match traced {
            Some(pass) => development.png(&pass.film).map_err(|error| error.to_string()),
            None => self.preview_png(),
        };
        let written = bytes.and_then(|bytes| {
            screenshot::write_numbered(Path::new("."), &bytes).map_err(|error| error.to_string())
        });
        match written {
            Ok(path) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                self.say(&format!("picture written: {name}"));
            }
            Err(error) => self.say(&format!("no picture could be written here: {error}")),
        }
    }

    fn preview_png(&mut self) -> Result<Vec<u8>, String> {
        let composed = self.compose();
        let scene = self.draft.clone().unwrap_or_else(|| self.scene.scene.clone());
        let size = self.view.size_px();
        let preview = Arc::clone(&self.preview);
        let style = self.style();
        let selected = self.highlight();
        let open = self.window.as_mut().ok_or("there is no window")?;
        let picture = composed.picture(&scene, &preview, style, selected, None);
        let (image, _) = open.drawing.draw_to_image(&picture, size).map_err(|error| error.to_string())?;
        screenshot::png(&image).map_err(|error| error.to_string())
    }

    fn style(&self) -> Style {
        let settings = &self.view.settings;
        if settings.wireframe {
            Style::Wireframe { has_normals: settings.normals }
        } else {
            Style::Solid(settings.shading)
        }
    }

    /// The selected primitive's edges are shown where it is one among others.
    fn highlight(&self) -> Option<u32> {
        let is_part = self.root() != self.scene.selected.as_deref();
        self.selected_shape.filter(|_| is_part)
    }

    fn test_ray(&self) -> Option<Ray> {
        self.view.settings.intersect_test.then(|| self.view.test_ray())
    }

    fn compose(&self) -> Composed {
        let scene = self.shown_scene();
        let camera = self.view.eye.camera();
        let settings = &self.view.settings;
        let lights = self.view.eye.lights(&scene.lights(), settings.lights_turn);
        let mut lines = Vec::new();
        let mut marks = Vec::new();
        let bounds = self.preview.bounds;
        if settings.axes {
            lines.extend(annotations::axes(bounds.as_ref()));
            marks.extend(annotations::light_marks(&lights, &camera, scene.picture.encoding));
        }
        if let Some(grid) = self.grid.as_ref().filter(|_| settings.io_test) {
            marks.extend(grid.marks(settings.io_radius));
        }
        let mut hit = None;
        if let (Some(ray), Some((_, compiled))) = (self.test_ray(), &self.compiled) {
            hit = cast(scene, compiled, &ray);
            let distance = (camera.target - camera.position).length();
            let (ray_lines, ray_marks) =
                lines_and_marks(&ray, hit.as_ref(), 100.0 * distance, 0.008 * distance);
            lines.extend(ray_lines);
            marks.extend(ray_marks);
        }
        Composed { camera, lights, lines, marks, hit }
    }

    /// Asks the worker and the tracer for what is not up to date.
    fn order(&mut self) {
        let (_, height_px) = self.view.size_px();
        let camera = self.view.eye.camera();
        let depends_on_eye = self.preview.small_branches + self.preview.unpaid_branches > 0;
        let grid = self.view.settings.io_test.then(|| GridSpec::new(&self.view.settings));
        let key = OrderKey {
            number: self.number,
            height_px: if depends_on_eye { height_px } else { 0 },
            camera: depends_on_eye.then_some(camera),
            grid,
        };
        if self.ordered.as_ref() != Some(&key)
            && let Some(worker) = &self.worker
        {
            worker.order(Order {
                scene: self.shown_scene().clone(),
                number: self.number,
                root: self.root().map(str::to_owned),
                camera,
                budget: PreviewBudget { instances: MOST_INSTANCES, height_px },
                grid,
                selected: self.scene.selected.clone(),
            });
            self.ordered = Some(key);
        }
        self.order_trace(camera);
    }

    fn order_trace(&mut self, camera: Camera) {
        let Some(tracer) = &self.tracer else { return };
        if !self.view.is_traced {
            if self.traced.asked.take().is_some() {
                tracer.rest();
                self.traced.pass = None;
            }
            return;
        }
        let Some((scene_number, compiled)) = &self.compiled else { return };
        let scene = self.shown_scene();
        let key = TraceKey {
            scene_number: *scene_number,
            camera,
            lights: self.view.eye.lights(&scene.lights(), self.view.settings.lights_turn),
            size: self.view.size_px(),
        };
        if self.traced.asked.as_ref() == Some(&key) {
            return;
        }
        let number = self.traced.number + 1;
        let settings = RenderSettings::of(scene);
        tracer.trace(TraceJob {
            compiled: Arc::clone(compiled),
            settings: RenderSettings {
                picture: superegg_scene::Picture {
                    width: key.size.0,
                    height: key.size.1,
                    samples: scene.picture.samples.clamp(1, MOST_SAMPLES),
                    // A window has a background, and is to be quick.
                    transparent: false,
                    noise: 0.0,
                    ..scene.picture
                },
                camera: key.camera,
                surroundings: Surroundings { lights: key.lights.clone(), ..settings.surroundings.clone() },
                ..settings
            },
            number,
        });
        self.traced.number = number;
        self.traced.asked = Some(key);
    }

    fn take_ready(&mut self, ready: Ready) {
        match ready {
            Ready::Preview(preview, selected) => {
                self.preview = preview;
                self.selected_shape = selected;
                self.mend_order_key();
            }
            Ready::Compiled(number, compiled) => self.compiled = Some((number, compiled)),
            Ready::Grid(grid) => self.grid = Some(grid),
        }
        self.redraw();
    }

    /// A preview may have made the eye matter; the order that it answers was for this eye.
    fn mend_order_key(&mut self) {
        let depends_on_eye = self.preview.small_branches + self.preview.unpaid_branches > 0;
        if let Some(key) = &mut self.ordered
            && depends_on_eye
            && key.camera.is_none()
        {
            key.camera = Some(self.view.eye.camera());
            key.height_px = self.view.size_px().1;
        }
    }

    fn take_pass(&mut self, pass: Pass) {
        if !self.view.is_traced || pass.number > self.traced.number {
            return;
        }
        let development = Development::of(&self.shown_scene().picture);
        if let Some(open) = &mut self.window {
            open.film = Some(open.drawing.upload_film(&pass.film, &development));
        }
        self.traced.pass = Some(pass);
        self.redraw();
    }

    fn click(&mut self, place: DVec2) {
        let now = Instant::now();
        let is_double = self.last_click.is_some_and(|(then, there)| {
            now - then <= DOUBLE_CLICK && (place - there).length() <= DOUBLE_CLICK_PX
        });
        self.last_click = (!is_double).then_some((now, place));
        let ray = self.view.ray_at(place);
        if is_double {
            self.pick(&ray);
        } else if self.view.settings.intersect_test {
            self.view.cast = Some(ray);
        }
        self.redraw();
    }

    /// Selects the primitive that a ray meets; what was shown stays shown. Beside everything the whole is selected again.
    fn pick(&mut self, ray: &Ray) {
        let Some((_, compiled)) = &self.compiled else { return };
        match cast(&self.scene.scene, compiled, ray) {
            Some(hit) => {
                self.held_root = self.root().map(str::to_owned);
                self.picked = Some(hit.primitive.clone());
                self.tell(FromViewer::Command(format!("primitive {}", hit.primitive)));
                self.say(&format!("selected {} at {}", hit.primitive, hit.path));
            }
            None => {
                let Some(root) = self.held_root.take() else { return };
                self.picked = None;
                let word = if self.scene.scene.object(&root).is_ok() { "object" } else { "primitive" };
                self.tell(FromViewer::Command(format!("{word} {root}")));
            }
        }
    }

    fn key(&mut self, event: &KeyEvent) {
        let name = match &event.logical_key {
            Key::Named(NamedKey::Escape) => "Escape",
            Key::Named(NamedKey::Tab) => "Tab",
            Key::Named(NamedKey::Home) => "Home",
            Key::Named(NamedKey::F12) => "F12",
            Key::Named(NamedKey::PrintScreen) => "PrintScreen",
            Key::Character(character) => character.as_str(),
            _ => return,
        };
        let held = self.modifiers;
        if held.alt_key() || held.super_key() {
            return;
        }
        let action = match (held.control_key(), held.shift_key()) {
            (true, false) => action_of(&format!("Ctrl+{name}")),
            (true, true) => action_of(&format!("Ctrl+Shift+{}", name.to_lowercase())),
            (false, _) => action_of(name),
        };
        // A key that is held goes on where that makes sense.
        if let Some(action) = action
            && (!event.repeat || matches!(action, Action::Larger | Action::Smaller))
        {
            self.act(action);
        }
    }

    /// Notices and limits, at the bottom of the scene.
    fn status(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let Some(open) = &self.window else { return lines };
        let mut first = match self.root() {
            Some(name) => name.to_owned(),
            None => "nothing is selected, so nothing is shown; 'object NAME' selects".to_owned(),
        };
        match self.traced.pass.as_ref().filter(|_| self.view.is_traced) {
            Some(pass) => {
                let (width, height) = (pass.film.width(), pass.film.height());
                first += &format!(
                    "  |  ray traced at {width} x {height}, {} a pixel, {:.0} ms{}",
                    pass.samples,
                    1e3 * pass.seconds,
                    if pass.is_last { "" } else { " …" }
                );
            }
            None if self.view.is_traced => first += "  |  ray tracing …",
            None => {
                let stats = &open.stats;
                let kind = if self.view.settings.wireframe { "edges" } else { "triangles" };
                let count = self.preview.instances.len();
                let plural = if count == 1 { "" } else { "s" };
                first += &format!("  |  {count} instance{plural}, {} {kind}", stats.triangles);
            }
        }
        first += "  |  h: keys";
        lines.push(first);
        if self.preview.unpaid_branches > 0 {
            lines.push(format!(
                "the drawing budget of {MOST_INSTANCES} instances is spent: {} branches are closed; ray tracing (p) has them all",
                self.preview.unpaid_branches
            ));
        }
        if !self.view.is_traced {
            if open.stats.coarser > 0 {
                lines.push(format!(
                    "the drawing budget is spent: {} instances have fewer patches than their own",
                    open.stats.coarser
                ));
            }
            if open.stats.lights_left_out > 0 {
                lines.push(format!("{} lights are left out of the preview", open.stats.lights_left_out));
            }
            if self.view.settings.io_test && self.grid.as_ref().is_some_and(|grid| grid.is_cut) {
                lines.push(
                    "the grid has more points than are shown: a larger step shows all of its extent"
                        .to_owned(),
                );
            }
        }
        lines
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        if self.notice.as_ref().is_some_and(|(_, since)| since.elapsed() > NOTICE_TIME) {
            self.notice = None;
        }
        let composed = self.compose();
        let status = self.status();
        let Some(mut open) = self.window.take() else { return };
        let (repaint_after, paint, done) = self.run_egui(&mut open, &composed, &status);
        // A text that has grown is placed by its size in the frame before.
        let has_grown = status.len() != open.status_lines;
        open.status_lines = status.len();
        self.window = Some(open);
        let is_due = has_grown || !done.is_empty();
        done.into_iter().for_each(|done| self.take_done(done));
        self.order();
        self.paint(&paint);
        self.schedule(event_loop, repaint_after, is_due);
    }

    fn run_egui(
        &mut self,
        open: &mut OpenWindow,
        composed: &Composed,
        status: &[String],
    ) -> (Duration, EguiPaint, Vec<Done>) {
        let input = open.egui_state.take_egui_input(&open.window);
        let scene = self.shown_scene().clone();
        let (selected, root) = (self.scene.selected.clone(), self.root().map(str::to_owned));
        let model = Model {
            scene: &scene,
            selected: selected.as_deref(),
            root: root.as_deref(),
            hit: composed.hit.as_ref(),
            status,
            notice: self.notice.as_ref().map(|(text, _)| text.as_str()),
            device: &open.device_name,
        };
        let mut done = Vec::new();
        let mut left = egui::Rect::NOTHING;
        let (panel, view) = (&mut self.panel, &mut self.view);
        let output = open.egui.run_ui(input, |ui| {
            done.extend(panel.show(ui, view, &model));
            left = ui.available_rect_before_wrap();
        });
        open.egui_state.handle_platform_output(&open.window, output.platform_output);
        let scale = f64::from(output.pixels_per_point);
        let pixels = |at: egui::Pos2| DVec2::new(f64::from(at.x), f64::from(at.y)) * scale;
        let (corner, end) = (pixels(left.min).round(), pixels(left.max).round());
        self.view.viewport =
            Viewport { corner: corner.max(DVec2::ZERO), size: (end - corner).max(DVec2::ONE) };
        // Before anything can fail: textures that are not taken over would be missing later.
        let mut textures = output.textures_delta;
        for (id, deltas) in &textures.set {
            for delta in deltas {
                open.egui_renderer.update_texture(&open.gpu.device, &open.gpu.queue, *id, delta);
            }
        }
        let free = std::mem::take(&mut textures.free).into_iter().collect();
        textures.clear();
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        let delay = root.map_or(Duration::MAX, |root| root.repaint_delay);
        let jobs = open.egui.tessellate(output.shapes, output.pixels_per_point);
        (delay, EguiPaint { jobs, free, pixels_per_point: output.pixels_per_point }, done)
    }

    fn take_done(&mut self, done: Done) {
        match done {
            Done::Command(line) => self.tell(FromViewer::Command(line)),
            Done::Draft(scene) => {
                if self.draft.as_ref() != Some(&*scene) {
                    self.view.set_camera(&scene.camera);
                    self.draft = Some(*scene);
                    self.number += 1;
                }
            }
            Done::Action(action) => self.act(action),
            Done::SettingsChanged => self.settings_changed(),
        }
    }

    fn paint(&mut self, paint: &EguiPaint) {
        let composed = self.compose();
        let preview = Arc::clone(&self.preview);
        let (style, highlight) = (self.style(), self.highlight());
        let scene = self.shown_scene().clone();
        let viewport = self.view.viewport;
        let is_traced = self.view.is_traced;
        let Some(open) = &mut self.window else { return };
        if let Some(texture) = open.acquire() {
            let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let size = (open.config.width, open.config.height);
            let mut encoder =
                open.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let target = Target { view: &view, size, viewport: within(&viewport, size) };
            let film = open.film.as_ref().filter(|_| is_traced);
            let picture = composed.picture(&scene, &preview, style, highlight, film);
            open.stats = open.drawing.draw(&mut encoder, &picture, &target);
            let descriptor = egui_wgpu::ScreenDescriptor {
                size_in_pixels: [size.0, size.1],
                pixels_per_point: paint.pixels_per_point,
            };
            let (device, queue) = (&open.gpu.device, &open.gpu.queue);
            let mut commands =
                open.egui_renderer.update_buffers(device, queue, &mut encoder, &paint.jobs, &descriptor);
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("panel"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            open.egui_renderer.render(&mut pass.forget_lifetime(), &paint.jobs, &descriptor);
            commands.push(encoder.finish());
            queue.submit(commands);
            open.window.pre_present_notify();
            queue.present(texture);
        }
        for id in &paint.free {
            open.egui_renderer.free_texture(id);
        }
    }

    /// When the next frame is due, if nothing happens before.
    fn schedule(&self, event_loop: &ActiveEventLoop, after: Duration, at_once: bool) {
        if at_once || after.is_zero() {
            self.redraw();
        }
        let notice_ends =
            self.notice.as_ref().map(|(_, since)| *since + NOTICE_TIME + Duration::from_millis(20));
        let egui_wants = Instant::now().checked_add(after).filter(|_| after < Duration::from_secs(3600));
        match [notice_ends, egui_wants].into_iter().flatten().min() {
            Some(at) => event_loop.set_control_flow(ControlFlow::WaitUntil(at)),
            None => event_loop.set_control_flow(ControlFlow::Wait),
        }
    }

    /// Makes the GPU's side of the window anew.
    fn rebuild(&mut self, event_loop: &ActiveEventLoop, fault: &str) {
        let Some(open) = self.window.take() else { return };
        let failures = open.failures + 1;
        let window = Arc::clone(&open.window);
        drop(open);
        let rebuilt = OpenWindow::on(&window, event_loop, &self.proxy);
        match rebuilt {
            Ok(open) if failures < 5 => {
                self.window = Some(OpenWindow { failures, ..open });
                self.traced = Traced::default();
                self.say(&format!("the graphics driver had a fault and was started anew: {fault}"));
            }
            Ok(_) => self.give_up(fault),
            Err(error) => self.give_up(&error.to_string()),
        }
    }

    fn give_up(&mut self, fault: &str) {
        self.tell(FromViewer::Say(format!("the viewer's window is closed, for it cannot be drawn: {fault}")));
        self.tell(FromViewer::Closed);
    }
}

impl Composed {
    fn picture<'a>(
        &'a self,
        scene: &Scene,
        preview: &'a Preview,
        style: Style,
        selected: Option<u32>,
        film: Option<&'a FilmTexture>,
    ) -> Picture<'a> {
        Picture {
            camera: self.camera,
            lights: &self.lights,
            background: scene.background,
            encoding: scene.picture.encoding,
            preview,
            style,
            selected,
            lines: &self.lines,
            marks: &self.marks,
            film,
        }
    }
}

struct EguiPaint {
    jobs: Vec<egui::ClippedPrimitive>,
    free: Vec<egui::TextureId>,
    pixels_per_point: f32,
}

/// The viewport as whole pixels within a target.
fn within(viewport: &Viewport, (width, height): (u32, u32)) -> (u32, u32, u32, u32) {
    let left = (viewport.corner.x as u32).min(width - 1);
    let top = (viewport.corner.y as u32).min(height - 1);
    let (w, h) = (viewport.size.x.max(1.0) as u32, viewport.size.y.max(1.0) as u32);
    (left, top, w.min(width - left), h.min(height - top))
}

impl ApplicationHandler<Event> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.first.take().is_some() {
            self.open(event_loop);
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        match event {
            Event::Open(shown) => {
                self.show(*shown);
                self.open(event_loop);
            }
            Event::Show(shown) => self.show(*shown),
            Event::Notice(text) => {
                self.draft = None;
                self.number += 1;
                self.notice = Some((text, Instant::now()));
                self.redraw();
            }
            Event::Interact => {
                if let Some(open) = &self.window {
                    open.window.set_minimized(false);
                    open.window.focus_window();
                }
            }
            Event::Close => self.close(),
            Event::Quit => {
                self.close();
                self.quits = true;
            }
            Event::Ready(ready) => self.take_ready(ready),
            Event::Traced(pass) => self.take_pass(*pass),
            Event::GpuFault(fault) => self.rebuild(event_loop, &fault),
        }
        if self.quits {
            event_loop.exit();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        let Some(open) = self.window.as_mut().filter(|open| open.window.id() == id) else { return };
        // To egui every redraw is one more reason to redraw.
        let mut is_eguis = false;
        let is_tab = matches!(&event, WindowEvent::KeyboardInput { event, .. } if event.logical_key == Key::Named(NamedKey::Tab));
        if !matches!(event, WindowEvent::RedrawRequested) && !is_tab {
            let response = open.egui_state.on_window_event(&open.window, &event);
            is_eguis = response.consumed;
            if response.repaint {
                open.window.request_redraw();
            }
        }
        let is_over_panel = open.egui.egui_wants_pointer_input();
        let is_typing = open.egui.egui_wants_keyboard_input();
        match event {
            WindowEvent::RedrawRequested => self.draw(event_loop),
            WindowEvent::CloseRequested => self.close(),
            WindowEvent::Resized(size) => {
                open.resize(size);
                open.window.request_redraw();
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed && !is_typing =>
            {
                self.key(&event);
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.pointer = DVec2::new(position.x, position.y);
                if self.view.move_pointer(self.pointer) {
                    self.redraw();
                }
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. }
                if !is_over_panel && !is_eguis =>
            {
                match button {
                    MouseButton::Left => self.view.press_left(self.pointer),
                    MouseButton::Middle => self.view.press_middle(self.pointer),
                    _ => (),
                }
            }
            WindowEvent::MouseInput { state: ElementState::Released, .. } => {
                if let Some(place) = self.view.release() {
                    self.click(place);
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !is_over_panel && !is_eguis => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / 50.0,
                };
                self.view.turn_wheel(notches);
                self.redraw();
            }
            WindowEvent::Focused(false) => {
                let _ = self.view.release();
            }
            _ => (),
        }
        if self.quits {
            event_loop.exit();
        }
    }

    fn new_events(&mut self, _event_loop: &ActiveEventLoop, cause: winit::event::StartCause) {
        if matches!(cause, winit::event::StartCause::ResumeTimeReached { .. }) {
            self.redraw();
        }
    }
}
