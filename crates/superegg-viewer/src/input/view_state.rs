//! The state of the view: switches, eye, pointer. It contains no type of a window or a GPU.

use std::path::PathBuf;

use superegg_geom::glam::DVec2;
use superegg_geom::{Aabb, Ray};
use superegg_render::{Output, View};
use superegg_scene::{Camera, Shading, ViewSettings};

use super::eye::Eye;
use super::gizmo::Tool;
use super::keys::{Action, SCALE_STEP};
use super::view_side::ViewSide;
use super::viewport::Viewport;
use crate::commands;

/// The state of the view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewState {
    /// The switches.
    pub settings: ViewSettings,
    /// The eye.
    pub eye: Eye,
    /// The picture is ray traced instead of drawn.
    pub is_traced: bool,
    /// The quantity that the ray traced picture shows.
    pub output: Output,
    /// The side panel is shown.
    pub has_panel: bool,
    /// The keys are shown.
    pub has_help: bool,
    /// The handles of the selected child.
    pub tool: Option<Tool>,
    /// The ray of the last click. The intersection test casts it instead of the eye's own ray.
    pub cast: Option<Ray>,
    pointer: Pointer,
    /// The part of the window that shows the scene.
    pub viewport: Viewport,
}

/// The gesture of the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pointer {
    Idle,
    /// The left button went down here, and the pointer has not left the range of a click.
    Pressed(DVec2),
    Turning,
    /// The middle button is down, and the pointer was last here.
    Moving(DVec2),
}

/// Farthest distance between press and release of a click.
const CLICK_PX: f64 = 3.0;
/// Zoom factor of one notch of the wheel.
const WHEEL_STEP: f64 = 1.1;

/// The part of an action that [`ViewState`] cannot carry out itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Return the keyboard to the command line.
    KeyboardBack,
    /// Publish the changed settings.
    SettingsChanged,
    /// Rebuild everything from the scene.
    Refresh,
    /// Save a picture of the window.
    Screenshot,
    /// Run these lines of the language.
    Commands(Vec<String>),
    /// Show the frame this many frames later.
    StepFrame(isize),
    /// Begin an action with files.
    File(FileAction),
    /// See the scene from a side.
    LookFrom(ViewSide),
    /// Fit the selected child into the window.
    FrameSelected,
    /// Start or stop to show the frames one after another.
    TogglePlaying,
    /// Give the keyboard to the panel.
    FocusPanel,
    /// Remove the selected child.
    DeleteChild,
    /// Duplicate the selected child.
    DuplicateChild,
}

/// An action with files. It may ask for a file, or about unsaved changes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileAction {
    /// Begin a new scene.
    New,
    /// Open a file that the user chooses.
    Open,
    /// Open this file.
    OpenFile(PathBuf),
    /// Save the scene.
    Save,
    /// Save the scene in a file that the user chooses.
    SaveAs,
    /// Add the contents of a file to the scene.
    Import,
    /// Write the scene for another program.
    Export,
    /// Render the scene to a picture.
    Render,
    /// Close the window.
    Leave,
}

impl ViewState {
    /// The view through a camera.
    pub fn new(camera: &Camera, settings: ViewSettings) -> Self {
        Self {
            settings,
            eye: Eye::new(camera),
            is_traced: false,
            output: Output::Light,
            has_panel: true,
            has_help: false,
            tool: None,
            cast: None,
            pointer: Pointer::Idle,
            viewport: Viewport { corner: DVec2::ZERO, size: DVec2::ONE },
        }
    }

    /// Adopts the scene's camera if it has changed.
    pub fn set_camera(&mut self, camera: &Camera) {
        if self.eye.home() != camera {
            self.eye = Eye::new(camera);
        }
    }

    /// Carries out an action. `bounds` is the bounding box of everything shown. Returns the part
    /// that is left to the caller.
    pub fn apply(&mut self, action: Action, bounds: &Aabb) -> Option<Request> {
        let settings = &mut self.settings;
        let switch = |flag: &mut bool| {
            *flag = !*flag;
            Some(Request::SettingsChanged)
        };
        match action {
            // The list of keys covers the scene, and is what should go first.
            Action::KeyboardBack if self.has_help => self.change(|state| state.has_help = false),
            Action::KeyboardBack => Some(Request::KeyboardBack),
            Action::ToggleLightsTurn => switch(&mut settings.lights_turn),
            Action::ToggleShading => {
                settings.shading = match settings.shading {
                    Shading::Phong => Shading::Gouraud,
                    Shading::Gouraud => Shading::Phong,
                };
                Some(Request::SettingsChanged)
            }
            Action::ToggleWireframe => switch(&mut settings.wireframe),
            Action::ToggleNormals => switch(&mut settings.normals),
            Action::ToggleAxes => switch(&mut settings.axes),
            Action::ToggleIoTest => switch(&mut settings.io_test),
            Action::ToggleOutside => switch(&mut settings.io_outside),
            Action::ToggleIntersectTest => {
                self.cast = None;
                switch(&mut settings.intersect_test)
            }
            Action::Larger => self.change(|state| state.eye.magnify(SCALE_STEP)),
            Action::Smaller => self.change(|state| state.eye.magnify(1.0 / SCALE_STEP)),
            Action::MoveTool => self.change(|state| state.switch_tool(Tool::Move)),
            Action::RotateTool => self.change(|state| state.switch_tool(Tool::Rotate)),
            Action::ScaleTool => self.change(|state| state.switch_tool(Tool::Scale)),
            Action::FrontView => Some(Request::LookFrom(ViewSide::Front)),
            Action::RightView => Some(Request::LookFrom(ViewSide::Right)),
            Action::TopView => Some(Request::LookFrom(ViewSide::Top)),
            Action::FrameSelected => Some(Request::FrameSelected),
            Action::Delete => Some(Request::DeleteChild),
            Action::Duplicate => Some(Request::DuplicateChild),
            Action::FrameAll => self.change(|state| state.eye.frame(bounds, state.viewport.aspect())),
            Action::Home => self.change(|state| state.eye.go_home()),
            Action::ToggleTrace => self.change(|state| state.is_traced = !state.is_traced),
            Action::TogglePanel => self.change(|state| state.has_panel = !state.has_panel),
            Action::TogglePlaying => Some(Request::TogglePlaying),
            Action::Render => Some(Request::File(FileAction::Render)),
            Action::FocusPanel => Some(Request::FocusPanel),
            Action::ToggleHelp => self.change(|state| state.has_help = !state.has_help),
            Action::Refresh => Some(Request::Refresh),
            Action::Screenshot => Some(Request::Screenshot),
            Action::WriteCamera => {
                let (camera, home) = (self.eye.camera(), self.eye.home());
                Some(Request::Commands(commands::view_as_camera(&camera, home)))
            }
            Action::Undo => Some(Request::Commands(vec![commands::undo()])),
            Action::Redo => Some(Request::Commands(vec![commands::redo()])),
            Action::New => Some(Request::File(FileAction::New)),
            Action::Open => Some(Request::File(FileAction::Open)),
            Action::Save => Some(Request::File(FileAction::Save)),
            Action::SaveAs => Some(Request::File(FileAction::SaveAs)),
            Action::PreviousFrame => Some(Request::StepFrame(-1)),
            Action::NextFrame => Some(Request::StepFrame(1)),
        }
    }

    fn switch_tool(&mut self, tool: Tool) {
        self.tool = (self.tool != Some(tool)).then_some(tool);
    }

    fn change(&mut self, change: impl FnOnce(&mut Self)) -> Option<Request> {
        change(self);
        None
    }

    /// The left button goes down at a point in pixels of the window.
    pub fn press_left(&mut self, point: DVec2) {
        self.pointer = Pointer::Pressed(point);
    }

    /// The middle button goes down at a point in pixels of the window.
    pub fn press_middle(&mut self, point: DVec2) {
        self.eye.release();
        self.pointer = Pointer::Moving(point);
    }

    /// The pointer moves to a point in pixels of the window. Returns whether the view has changed.
    pub fn move_pointer(&mut self, point: DVec2) -> bool {
        match self.pointer {
            Pointer::Idle => return false,
            Pointer::Pressed(from) if (point - from).length() <= CLICK_PX => return false,
            Pointer::Pressed(from) => {
                self.eye.press(self.viewport.on_ball(from));
                self.eye.drag(self.viewport.on_ball(point));
                self.pointer = Pointer::Turning;
            }
            Pointer::Turning => self.eye.drag(self.viewport.on_ball(point)),
            Pointer::Moving(last) => {
                self.eye.move_by(point - last, self.viewport.size.y);
                self.pointer = Pointer::Moving(point);
            }
        }
        true
    }

    /// A button goes up, or the pointer leaves the window. Returns the point of a click, if it was
    /// one.
    pub fn release(&mut self) -> Option<DVec2> {
        self.eye.release();
        match std::mem::replace(&mut self.pointer, Pointer::Idle) {
            Pointer::Pressed(point) => Some(point),
            Pointer::Idle | Pointer::Turning | Pointer::Moving(_) => None,
        }
    }

    /// Whether a drag is in progress.
    pub fn is_dragged(&self) -> bool {
        matches!(self.pointer, Pointer::Turning | Pointer::Moving(_))
    }

    /// The wheel turns by notches; up is positive and enlarges.
    pub fn turn_wheel(&mut self, notches: f64) {
        self.eye.magnify(WHEEL_STEP.powf(notches.clamp(-50.0, 50.0)));
    }

    /// The camera ray through a point in pixels of the window.
    pub fn ray_at(&self, point: DVec2) -> Ray {
        let (width, height) = self.size_px();
        View::new(&self.eye.camera(), width, height).ray(point - self.viewport.corner)
    }

    /// The ray of the intersection test: that of the last click, or the eye's own in its viewing
    /// direction.
    pub fn test_ray(&self) -> Ray {
        let camera = self.eye.camera();
        let (_, _, forward) = camera.frame();
        self.cast.unwrap_or(Ray::new(camera.position, forward))
    }

    /// Width and height of the viewport in whole pixels.
    pub fn size_px(&self) -> (u32, u32) {
        (self.viewport.size.x.max(1.0) as u32, self.viewport.size.y.max(1.0) as u32)
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;
    use crate::input::keys::BINDINGS;

    fn state() -> ViewState {
        let mut state = ViewState::new(&Camera::default(), ViewSettings::default());
        state.viewport = Viewport { corner: DVec2::ZERO, size: DVec2::new(400.0, 300.0) };
        state
    }

    fn bounds() -> Aabb {
        Aabb::around(DVec3::new(1.0, 2.0, 3.0), DVec3::ONE)
    }

    #[test]
    fn every_switch_twice_is_as_before() {
        for row in BINDINGS {
            let mut after = state();
            let request = after.apply(row.action, &bounds());
            let is_switch = !matches!(row.action, Action::FrameAll | Action::Larger | Action::Smaller);
            assert!(after != state() || request.is_some() || row.action == Action::Home, "{:?}", row.action);
            after.apply(row.action, &bounds());
            assert_eq!(after == state(), is_switch, "{:?}", row.action);
        }
    }

    #[test]
    fn the_list_of_keys_closes_before_the_window() {
        let mut view = state();
        view.apply(Action::ToggleHelp, &bounds());
        assert_eq!(view.apply(Action::KeyboardBack, &bounds()), None);
        assert!(!view.has_help);
        assert_eq!(view.apply(Action::KeyboardBack, &bounds()), Some(Request::KeyboardBack));
    }

    #[test]
    fn a_click_is_no_drag_and_a_drag_no_click() {
        let mut view = state();
        let point = DVec2::new(200.0, 100.0);
        view.press_left(point);
        assert!(!view.move_pointer(point + DVec2::X) && view.release() == Some(point));
        assert_eq!(view.eye, state().eye);
        view.press_left(point);
        assert!(view.move_pointer(point + 40.0 * DVec2::X) && view.is_dragged());
        assert!(view.move_pointer(point) && view.release().is_none());
        assert!((view.eye.camera().position - DVec3::Z * 10.0).length() < 1e-12);
    }

    #[test]
    fn the_ray_of_the_middle_pixel_is_the_eyes_own() {
        let mut view = state();
        view.press_left(DVec2::new(100.0, 100.0));
        view.move_pointer(DVec2::new(220.0, 190.0));
        view.release();
        let (middle, own) = (view.ray_at(DVec2::new(200.0, 150.0)), view.test_ray());
        assert!((middle.direction.normalize() - own.direction).length() < 1e-12);
        assert_eq!(middle.origin, own.origin);
    }

    #[test]
    fn the_camera_is_written_as_it_is_seen() {
        let mut view = state();
        view.turn_wheel(3.0);
        let Some(Request::Commands(lines)) = view.apply(Action::WriteCamera, &bounds()) else { panic!() };
        assert_eq!(lines, ["camera 0 0 7.513148 0 0 0 60"]);
        view.press_left(DVec2::ZERO);
        view.move_pointer(DVec2::new(100.0, 150.0));
        let Some(Request::Commands(lines)) = view.apply(Action::WriteCamera, &bounds()) else { panic!() };
        assert!(lines.len() == 2 && lines[0].starts_with("cameraUp "), "{lines:?}");
    }
}
