//! What the person at the window has switched, turned and pointed at. No type of a window or a GPU.

use superegg_geom::glam::DVec2;
use superegg_geom::{Aabb, Ray};
use superegg_render::View;
use superegg_scene::{Camera, Shading, ViewSettings};

use crate::eye::Eye;
use crate::keys::{Action, SCALE_STEP};

/// The whole state of the view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewState {
    /// The switches.
    pub settings: ViewSettings,
    /// Where it is looked from.
    pub eye: Eye,
    /// The picture is ray traced.
    pub is_traced: bool,
    /// The side panel is shown.
    pub has_panel: bool,
    /// The keys are shown.
    pub has_help: bool,
    /// The ray of a click; the intersection test takes it instead of the eye's own.
    pub cast: Option<Ray>,
    pointer: Pointer,
    /// The part of the window that shows the scene.
    pub viewport: Viewport,
}

/// A rectangle in pixels of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    /// Its top left corner.
    pub corner: DVec2,
    /// Its width and height, at least 1.
    pub size: DVec2,
}

impl Viewport {
    /// A place in radii of the arcball: the ball fills the shorter side.
    fn on_ball(&self, place: DVec2) -> DVec2 {
        let from_middle = place - self.corner - 0.5 * self.size;
        from_middle * DVec2::new(1.0, -1.0) / (0.5 * self.size.min_element())
    }

    /// Width over height.
    pub fn aspect(&self) -> f64 {
        self.size.x / self.size.y
    }
}

/// What the pointer is doing.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pointer {
    Idle,
    /// The left button went down here, and the pointer has not gone far: a click as yet.
    Pressed(DVec2),
    Turning,
    /// The middle button is down; the pointer was here last.
    Moving(DVec2),
}

/// A pointer that goes no farther than this between down and up has clicked.
const CLICK_PX: f64 = 3.0;
/// One notch of the wheel.
const WHEEL_STEP: f64 = 1.1;

/// What an action asks of those around the view.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// The keyboard goes back to the command line.
    KeyboardBack,
    /// The settings have changed.
    SettingsChanged,
    /// Make everything anew.
    Refresh,
    /// Write the picture to a file.
    Screenshot,
    /// Lines for the command line.
    Commands(Vec<String>),
}

impl ViewState {
    /// The view of a camera.
    pub fn new(camera: &Camera, settings: ViewSettings) -> Self {
        Self {
            settings,
            eye: Eye::new(camera),
            is_traced: false,
            has_panel: true,
            has_help: false,
            cast: None,
            pointer: Pointer::Idle,
            viewport: Viewport { corner: DVec2::ZERO, size: DVec2::ONE },
        }
    }

    /// Follows the scene's camera where that has changed.
    pub fn set_camera(&mut self, camera: &Camera) {
        if self.eye.home() != camera {
            self.eye = Eye::new(camera);
        }
    }

    /// Carries an action out. `bounds` is around everything shown.
    pub fn apply(&mut self, action: Action, bounds: &Aabb) -> Option<Request> {
        let settings = &mut self.settings;
        let switch = |flag: &mut bool| {
            *flag = !*flag;
            Some(Request::SettingsChanged)
        };
        match action {
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
            Action::ToggleIntersectTest => {
                self.cast = None;
                switch(&mut settings.intersect_test)
            }
            Action::Larger => self.only(|state| state.eye.magnify(SCALE_STEP)),
            Action::Smaller => self.only(|state| state.eye.magnify(1.0 / SCALE_STEP)),
            Action::FrameAll => self.only(|state| state.eye.frame(bounds, state.viewport.aspect())),
            Action::Home => self.only(|state| state.eye.go_home()),
            Action::ToggleTrace => self.only(|state| state.is_traced = !state.is_traced),
            Action::TogglePanel => self.only(|state| state.has_panel = !state.has_panel),
            Action::ToggleHelp => self.only(|state| state.has_help = !state.has_help),
            Action::Refresh => Some(Request::Refresh),
            Action::Screenshot => Some(Request::Screenshot),
            Action::WriteCamera => {
                Some(Request::Commands(camera_commands(&self.eye.camera(), self.eye.home())))
            }
            Action::Undo => Some(Request::Commands(vec!["undo".to_owned()])),
            Action::Redo => Some(Request::Commands(vec!["redo".to_owned()])),
        }
    }

    fn only(&mut self, change: impl FnOnce(&mut Self)) -> Option<Request> {
        change(self);
        None
    }

    /// The left button goes down at a place in pixels of the window.
    pub fn press_left(&mut self, place: DVec2) {
        self.pointer = Pointer::Pressed(place);
    }

    /// The middle button goes down.
    pub fn press_middle(&mut self, place: DVec2) {
        self.eye.release();
        self.pointer = Pointer::Moving(place);
    }

    /// The pointer is at another place. Returns whether the view has changed.
    pub fn move_pointer(&mut self, place: DVec2) -> bool {
        match self.pointer {
            Pointer::Idle => return false,
            Pointer::Pressed(from) if (place - from).length() <= CLICK_PX => return false,
            Pointer::Pressed(from) => {
                self.eye.press(self.viewport.on_ball(from));
                self.eye.drag(self.viewport.on_ball(place));
                self.pointer = Pointer::Turning;
            }
            Pointer::Turning => self.eye.drag(self.viewport.on_ball(place)),
            Pointer::Moving(last) => {
                self.eye.move_by(place - last, self.viewport.size.y);
                self.pointer = Pointer::Moving(place);
            }
        }
        true
    }

    /// A button goes up, or the pointer leaves. Returns the place of a click, if it was one.
    pub fn release(&mut self) -> Option<DVec2> {
        self.eye.release();
        match std::mem::replace(&mut self.pointer, Pointer::Idle) {
            Pointer::Pressed(place) => Some(place),
            _ => None,
        }
    }

    /// Whether a drag changes the view.
    pub fn is_dragged(&self) -> bool {
        matches!(self.pointer, Pointer::Turning | Pointer::Moving(_))
    }

    /// The wheel turns by notches, up positive.
    pub fn turn_wheel(&mut self, notches: f64) {
        self.eye.magnify(WHEEL_STEP.powf(notches.clamp(-50.0, 50.0)));
    }

    /// The ray of a place in pixels of the window.
    pub fn ray_at(&self, place: DVec2) -> Ray {
        let (width, height) = self.size_px();
        View::new(&self.eye.camera(), width, height).ray(place - self.viewport.corner)
    }

    /// The ray of the intersection test: that of the last click, or the eye's own along its look direction.
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

/// The lines that make a camera the scene's.
fn camera_commands(camera: &Camera, before: &Camera) -> Vec<String> {
    // Rounded where nobody could see it: to a millionth of the distance.
    let distance = (camera.position - camera.target).length();
    let decimals = (6.0 - distance.log10().floor()).clamp(0.0, 17.0) as usize;
    let place = |v: superegg_geom::glam::DVec3| v.to_array().map(|x| number_text(x, decimals)).join(" ");
    let mut lines = vec![format!(
        "camera {} {} {}",
        place(camera.position),
        place(camera.target),
        number_text(camera.fov_deg, 6)
    )];
    if (camera.up - before.up).length() > 1e-9 {
        lines.insert(0, format!("cameraUp {}", camera.up.to_array().map(|x| number_text(x, 7)).join(" ")));
    }
    lines
}

/// A number with so many decimals at most, and no zeros at its end.
pub(crate) fn number_text(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;
    use crate::keys::BINDINGS;

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
    fn a_click_is_no_drag_and_a_drag_no_click() {
        let mut view = state();
        let place = DVec2::new(200.0, 100.0);
        view.press_left(place);
        assert!(!view.move_pointer(place + DVec2::X) && view.release() == Some(place));
        assert_eq!(view.eye, state().eye);
        view.press_left(place);
        assert!(view.move_pointer(place + 40.0 * DVec2::X) && view.is_dragged());
        assert!(view.move_pointer(place) && view.release().is_none());
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

    #[test]
    fn numbers_are_written_short() {
        for (x, text) in
            [(1.0, "1"), (-0.0, "0"), (0.1, "0.1"), (-1e-9, "0"), (1e9, "1000000000"), (100.0, "100")]
        {
            assert_eq!(number_text(x, 6), text);
        }
        assert_eq!(number_text(1200.0, 0), "1200");
    }
}
