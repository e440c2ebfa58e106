//! The application of the event loop: events of the window, of the session and of the background
//! threads.

use std::path::Path;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use superegg_geom::Ray;
use superegg_geom::glam::DVec2;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::WindowId;

use super::background::Background;
use super::content::Content;
use super::frame::{Composed, intersection_test, paint, run_panel};
use super::notice::Notice;
use super::outbox::Outbox;
use super::pointer::PointerTracker;
use super::surface::OpenWindow;
use super::{keyboard, screenshot, status};
use crate::commands;
use crate::event::Event;
use crate::frame_stats::DrawStats;
use crate::input::gizmo::GizmoDrag;
use crate::input::keys::Action;
use crate::input::{FileAction, Request, ViewState};
use crate::live::tracer::Pass;
use crate::panel::{Files, Panel, PanelEvent, PanelModel};
use crate::protocol::{FromViewer, Shown};
use crate::queries::cast;

/// Pixels of smooth scrolling that count as one notch of the wheel.
const NOTCH_PX: f64 = 50.0;
/// The time of a frame that is played.
const FRAME_TIME: Duration = Duration::from_millis(41);
/// egui returns a longer delay if it needs no further frame.
const NEVER: Duration = Duration::from_secs(3600);

/// The viewer in the event loop.
pub(crate) struct App {
    proxy: EventLoopProxy<Event>,
    pub(super) outbox: Outbox,
    /// Open the window at the start.
    opens_at_once: bool,
    /// End the event loop.
    quits: bool,
    pub(super) window: Option<OpenWindow>,
    pub(super) content: Content,
    pub(super) background: Background,
    pub(super) view: ViewState,
    pub(super) panel: Panel,
    pub(super) files: Files,
    pub(super) notice: Notice,
    pub(super) modifiers: ModifiersState,
    pub(super) pointer: PointerTracker,
    /// The progress of a picture that is rendered to a file.
    rendering: Option<String>,
    /// The time of the last frame that was played; `None` if nothing is played.
    playing: Option<Instant>,
    /// A handle that is dragged.
    pub(super) gizmo: Option<GizmoDrag>,
}

impl App {
    pub(crate) fn new(proxy: EventLoopProxy<Event>, out: Sender<FromViewer>, first: Option<Shown>) -> Self {
        let opens_at_once = first.is_some();
        let shown = first.unwrap_or_default();
        Self {
            outbox: Outbox::new(out),
            opens_at_once,
            quits: false,
            window: None,
            background: Background::start(&proxy),
            proxy,
            view: ViewState::new(&shown.scene.camera, shown.settings),
            content: Content::new(shown),
            panel: Panel::default(),
            files: Files::default(),
            notice: Notice::default(),
            modifiers: ModifiersState::empty(),
            pointer: PointerTracker::default(),
            rendering: None,
            playing: None,
            gizmo: None,
        }
    }

    /// Shows a text in the window and at the prompt.
    pub(super) fn report(&mut self, text: String) {
        self.notice.show(text.clone());
        self.outbox.send(FromViewer::Message(text));
        self.redraw();
    }

    pub(super) fn redraw(&self) {
        if let Some(open) = &self.window {
            open.request_redraw();
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(open) = &self.window {
            open.focus();
            return;
        }
        match OpenWindow::open(event_loop, &self.proxy) {
            Ok(open) => {
                open.request_redraw();
                self.window = Some(open);
                self.update_title();
                self.background.trace.forget();
            }
            Err(error) => {
                let text = format!("the viewer cannot open its window: {error}");
                self.outbox.send(FromViewer::Message(text));
                self.outbox.send(FromViewer::Closed { by_user: false });
            }
        }
    }

    /// Closes the window.
    pub(super) fn close(&mut self, by_user: bool) {
        if self.window.take().is_some() {
            self.view.is_traced = false;
            self.background.trace.stop();
            self.outbox.send(FromViewer::Closed { by_user });
        }
    }

    fn show(&mut self, shown: Shown) {
        self.view.settings = shown.settings;
        self.view.set_camera(&shown.scene.camera);
        self.content.replace(shown);
        self.after_snapshot();
        self.redraw();
    }

    /// Makes the window again after a fault of the graphics driver.
    fn rebuild(&mut self, event_loop: &ActiveEventLoop, fault: &str) {
        let Some(open) = self.window.take() else { return };
        match open.rebuild(event_loop, &self.proxy, fault) {
            Ok(open) => {
                self.window = Some(open);
                self.background.trace.forget();
                self.report(format!("the graphics driver failed and was restarted: {fault}"));
            }
            Err(error) => {
                let text = format!("the viewer's window is closed because it cannot be drawn: {error}");
                self.outbox.send(FromViewer::Message(text));
                self.outbox.send(FromViewer::Closed { by_user: false });
            }
        }
    }

    fn act(&mut self, action: Action) {
        let bounds = self.background.bounds();
        match self.view.apply(action, &bounds) {
            None => (),
            Some(Request::KeyboardBack) => self.keyboard_back(),
            Some(Request::File(action)) => self.begin_file_action(action),
            Some(Request::TogglePlaying) => self.toggle_playing(),
            Some(Request::FocusPanel) => {
                self.view.has_panel = true;
                if let Some(open) = &self.window {
                    open.egui.focus_next();
                }
            }
            Some(Request::LookFrom(side)) => self.look_from(side),
            Some(Request::FrameSelected) => self.frame_selected(),
            Some(Request::DeleteChild) => self.delete_child(),
            Some(Request::DuplicateChild) => self.duplicate_child(),
            Some(Request::SettingsChanged) => self.send_settings(),
            Some(Request::Refresh) => {
                self.content.refresh();
                if let Some(open) = &mut self.window {
                    open.drawing.forget_meshes();
                }
                self.notice.show("refreshed".to_owned());
            }
            Some(Request::Screenshot) => self.write_screenshot(),
            Some(Request::Commands(lines)) => self.outbox.lines(lines),
            Some(Request::StepFrame(by)) => {
                if let Some(frame) = self.content.step_frame(by) {
                    self.outbox.send(FromViewer::Frame(frame));
                }
            }
        }
        self.redraw();
    }

    fn send_settings(&mut self) {
        self.outbox.send(FromViewer::Settings(self.view.settings));
    }

    fn write_screenshot(&mut self) {
        let written = self.screenshot().and_then(|bytes| {
            screenshot::write_numbered(Path::new("."), &bytes).map_err(|error| error.to_string())
        });
        self.report(match written {
            Ok(path) => {
                format!("picture written: {}", path.file_name().unwrap_or_default().to_string_lossy())
            }
            Err(error) => format!("no picture could be written here: {error}"),
        });
    }

    /// The traced picture or the preview as a PNG file.
    fn screenshot(&mut self) -> Result<Vec<u8>, String> {
        if let Some(pass) = self.background.trace.pass().filter(|_| self.view.is_traced) {
            return pass.development.png(&pass.film).map_err(|error| error.to_string());
        }
        let composed = Composed::new(&self.content, &self.background, &self.view);
        let open = self.window.as_mut().ok_or("there is no window")?;
        let drawn = open.drawing.draw_to_image(&composed.picture(None), self.view.size_px());
        let (image, _) = drawn.map_err(|error| error.to_string())?;
        screenshot::png(&image).map_err(|error| error.to_string())
    }

    fn receive_pass(&mut self, pass: Pass) {
        if !self.view.is_traced {
            return;
        }
        if let Some(pass) = self.background.trace.receive(pass)
            && let Some(open) = &mut self.window
        {
            open.film = Some(open.drawing.upload_film(&pass.film, &pass.development));
        }
        self.redraw();
    }

    fn click(&mut self, point: DVec2) {
        let is_double = self.pointer.click(Instant::now(), point);
        let ray = self.view.ray_at(point);
        if is_double {
            self.pick(&ray);
        } else if self.view.settings.intersect_test {
            self.view.cast = Some(ray);
        } else {
            self.select_child_at(&ray);
        }
        self.redraw();
    }

    /// Selects the primitive that a ray hits and holds the root in view. Without a hit it selects
    /// the root again.
    fn pick(&mut self, ray: &Ray) {
        let Some(compiled) = self.background.compiled() else { return };
        match cast(self.content.snapshot(), compiled, ray) {
            Some(hit) => {
                self.outbox.command(commands::select_primitive(&hit.primitive));
                self.report(format!("selected {} at {}", hit.primitive, hit.path));
                self.content.pick(hit.primitive);
            }
            None => {
                if let Some(line) = self.content.end_pick() {
                    self.outbox.command(line);
                }
            }
        }
    }

    /// Starts or stops to show the frames one after another.
    fn toggle_playing(&mut self) {
        let can_play = self.content.frames().is_some_and(|frames| frames.count > 1);
        self.playing = if self.playing.is_none() && can_play { Some(Instant::now()) } else { None };
        if !can_play {
            self.notice.show("the scene has no frames; 'key' at the prompt makes some".to_owned());
        }
    }

    /// Wants the next frame if it is due, after the last the first one.
    fn play(&mut self) {
        let is_due = self.playing.is_some_and(|last| last.elapsed() >= FRAME_TIME);
        if !is_due || self.content.waits_for_frame() {
            return;
        }
        self.playing = Some(Instant::now());
        if let Some(frame) = self.content.next_frame() {
            self.outbox.send(FromViewer::Frame(frame));
        }
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        self.notice.expire();
        self.play();
        let (handles, compass) = (self.handles(), self.compass());
        let Some(open) = &mut self.window else { return };
        let status = status::lines(&self.content, &self.background, &self.view, &open.stats);
        let test = intersection_test(&self.content, &self.background, &self.view);
        let device_name = open.device_name.clone();
        let model = PanelModel {
            scene: self.content.scene(),
            selected: self.content.selected(),
            root: self.content.root(),
            frames: self.content.frames(),
            hit: test.as_ref().and_then(|(_, hit)| hit.as_ref()),
            status: &status,
            notice: self.notice.text(),
            device: &device_name,
            document: self.content.document(),
            rendering: self.rendering.as_deref(),
            is_playing: self.playing.is_some(),
            child: self.content.selected_child(),
            handles,
            compass,
        };
        let (ui, events) = run_panel(open, &mut self.panel, &mut self.files, &mut self.view, &model);
        // egui positions a text by its size in the previous frame.
        let has_grown = status.len() != open.status_lines;
        open.status_lines = status.len();
        let mut is_due = has_grown || !events.is_empty();
        events.into_iter().for_each(|event| self.on_panel_event(event));
        self.background.update(&self.content, &self.view);
        if let Some(open) = &mut self.window {
            let composed = Composed::new(&self.content, &self.background, &self.view);
            let before = open.stats;
            paint(open, &composed, &self.view, &ui);
            // The status shows the numbers of the frame before.
            is_due |= DrawStats { seconds: before.seconds, ..open.stats } != before;
        }
        self.schedule(event_loop, ui.repaint_after, is_due);
    }

    fn on_panel_event(&mut self, event: PanelEvent) {
        match event {
            PanelEvent::Command(line) => self.outbox.command(line),
            PanelEvent::Draft(scene) => {
                let camera = scene.camera;
                if self.content.set_draft(*scene) {
                    self.view.set_camera(&camera);
                }
            }
            PanelEvent::Action(action) => self.act(action),
            PanelEvent::SettingsChanged => self.send_settings(),
            PanelEvent::File(action) => self.begin_file_action(action),
            PanelEvent::FileEvent(event) => self.on_file_event(event),
            PanelEvent::Lines(lines) => self.outbox.lines(lines),
            PanelEvent::Change(label, lines) => self.outbox.change(&label, lines),
            PanelEvent::SelectChild(alias) => self.select_child(&alias),
            PanelEvent::RenameChild(alias, new) => self.rename_child(&alias, &new),
            PanelEvent::LookFrom(side) => self.look_from(side),
            PanelEvent::RecoverLater => self.panel.recovers_later = true,
            PanelEvent::Frame(frame) => {
                if let Some(frame) = self.content.want_frame(frame) {
                    self.outbox.send(FromViewer::Frame(frame));
                }
            }
        }
    }

    /// Sets the time of the next frame without events.
    fn schedule(&self, event_loop: &ActiveEventLoop, repaint_after: Duration, is_due: bool) {
        if is_due || repaint_after.is_zero() {
            self.redraw();
        }
        let repaint_at = Instant::now().checked_add(repaint_after).filter(|_| repaint_after < NEVER);
        let frame_at = self.playing.map(|last| last + FRAME_TIME);
        match [self.notice.ends_at(), repaint_at, frame_at].into_iter().flatten().min() {
            Some(at) => event_loop.set_control_flow(ControlFlow::WaitUntil(at)),
            None => event_loop.set_control_flow(ControlFlow::Wait),
        }
    }

    fn exit_if_done(&self, event_loop: &ActiveEventLoop) {
        if self.quits || self.outbox.is_closed() {
            event_loop.exit();
        }
    }
}

/// Whether egui should see an event. A redraw would make it request another one. Tab is a key of
/// the viewer, except where the panel or a dialog has the keyboard.
fn is_for_egui(event: &WindowEvent, has_focus: bool) -> bool {
    match event {
        WindowEvent::RedrawRequested => false,
        WindowEvent::KeyboardInput { event, .. } => {
            has_focus || event.logical_key != Key::Named(NamedKey::Tab)
        }
        _ => true,
    }
}

impl ApplicationHandler<Event> for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if std::mem::take(&mut self.opens_at_once) {
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
            Event::Inform(text) => {
                self.notice.show(text);
                self.redraw();
            }
            Event::Rendering(progress) => {
                self.rendering = progress;
                self.redraw();
            }
            Event::Notice(text) => {
                self.files.on_failure();
                self.content.drop_draft();
                self.content.drop_wanted_frame();
                self.notice.show(text);
                self.redraw();
            }
            Event::Interact => {
                if let Some(open) = &self.window {
                    open.focus();
                }
            }
            Event::Close => self.close(false),
            Event::Quit => {
                self.close(false);
                self.quits = true;
            }
            Event::Ready(result) => {
                self.background.receive(result, &self.view);
                self.redraw();
            }
            Event::Traced(pass) => self.receive_pass(*pass),
            Event::GpuFault(fault) => self.rebuild(event_loop, &fault),
        }
        self.exit_if_done(event_loop);
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        let Some(open) = self.window.as_mut().filter(|open| open.surface.window.id() == id) else { return };
        let mut is_consumed = false;
        let has_focus = self.files.is_open() || open.egui.wants_keyboard();
        if is_for_egui(&event, has_focus) {
            let response = open.egui.on_window_event(&open.surface.window, &event);
            is_consumed = response.consumed;
            if response.repaint {
                open.request_redraw();
            }
        }
        // egui knows the panel under the pointer since the last frame, which may be a second ago.
        let is_over_scene = self.view.viewport.contains(self.pointer.position);
        let is_for_scene = !is_consumed && is_over_scene && !open.egui.wants_pointer();
        match event {
            WindowEvent::RedrawRequested => self.draw(event_loop),
            WindowEvent::CloseRequested => self.begin_file_action(FileAction::Leave),
            WindowEvent::DroppedFile(path) => self.begin_file_action(FileAction::OpenFile(path)),
            WindowEvent::Resized(size) => {
                open.surface.resize(size);
                open.request_redraw();
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed
                    && !open.egui.wants_keyboard()
                    && !self.files.is_open() =>
            {
                if self.cancel_gizmo(&event) {
                    return;
                }
                if let Some(action) = keyboard::action(&event, self.modifiers) {
                    self.act(action);
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.pointer.position = DVec2::new(position.x, position.y);
                if self.drag_gizmo() || self.view.move_pointer(self.pointer.position) {
                    self.redraw();
                }
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } if is_for_scene => {
                match button {
                    MouseButton::Left if self.press_gizmo() => (),
                    MouseButton::Left if !self.modifiers.shift_key() => {
                        self.view.press_left(self.pointer.position);
                    }
                    MouseButton::Left | MouseButton::Middle | MouseButton::Right => {
                        self.view.press_middle(self.pointer.position);
                    }
                    _ => (),
                }
            }
            WindowEvent::MouseInput { state: ElementState::Released, .. } => {
                if self.release_gizmo() {
                    self.redraw();
                } else if let Some(point) = self.view.release() {
                    self.click(point);
                }
            }
            WindowEvent::MouseWheel { delta, .. } if is_for_scene => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y / NOTCH_PX,
                };
                self.view.turn_wheel(notches);
                self.redraw();
            }
            WindowEvent::Focused(false) => {
                let _ = self.view.release();
            }
            _ => (),
        }
        self.exit_if_done(event_loop);
    }

    fn new_events(&mut self, _event_loop: &ActiveEventLoop, cause: StartCause) {
        if matches!(cause, StartCause::ResumeTimeReached { .. }) {
            self.redraw();
        }
    }
}
