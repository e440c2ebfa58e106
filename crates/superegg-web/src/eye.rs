//! The eye of the viewer for a page, and the table of keys.

use serde::Serialize;
use superegg_geom::Aabb;
use superegg_geom::glam::{DAffine3, DVec2, DVec3};
use superegg_scene::{Camera, Light};
use superegg_viewer::keys::BINDINGS;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::answers::json;

/// A camera of eleven numbers: position, target, up, field of view in degrees, and height of an orthographic picture
/// or 0.
pub(crate) fn camera_of(numbers: &[f64; 11]) -> Camera {
    let vector = |at: usize| DVec3::new(numbers[at], numbers[at + 1], numbers[at + 2]);
    Camera {
        position: vector(0),
        target: vector(3),
        up: vector(6),
        fov_deg: numbers[9],
        ortho_height: (numbers[10] > 0.0).then_some(numbers[10]),
        ..Camera::default()
    }
}

pub(crate) fn numbers_of(camera: &Camera) -> Vec<f64> {
    let Camera { position, target, up, fov_deg, ortho_height, .. } = camera;
    let vectors = [position, target, up].into_iter().flat_map(DVec3::to_array);
    vectors.chain([*fov_deg, ortho_height.unwrap_or(0.0)]).collect()
}

pub(crate) fn map_of(numbers: &[f64; 12]) -> DAffine3 {
    DAffine3::from_cols_array(numbers)
}

/// The camera of a scene after drags, wheel and keys. Points are in radii of the arcball, with x to the right and y up.
#[wasm_bindgen]
pub struct Eye {
    eye: superegg_viewer::Eye,
    is_home: bool,
}

#[wasm_bindgen]
impl Eye {
    /// The eye at a scene's own camera.
    #[wasm_bindgen(constructor)]
    pub fn new(camera: &[f64]) -> Self {
        let numbers: Option<&[f64; 11]> = camera.try_into().ok();
        let camera = numbers.map_or_else(Camera::default, camera_of);
        Self { eye: superegg_viewer::Eye::new(&camera), is_home: true }
    }

    /// The camera's numbers.
    pub fn camera(&self) -> Vec<f64> {
        numbers_of(&self.eye.camera())
    }

    /// The map of lights that stay with the eye, in columns; `None` at the scene's own camera.
    #[wasm_bindgen(js_name = lightMap)]
    pub fn light_map(&self) -> Option<Vec<f64>> {
        (!self.is_home).then(|| self.eye.light_map().to_cols_array().to_vec())
    }

    /// Returns to the scene's own camera.
    pub fn home(&mut self) {
        self.eye.go_home();
        self.is_home = true;
    }

    /// Starts to turn the scene.
    pub fn press(&mut self, x: f64, y: f64) {
        self.eye.press(DVec2::new(x, y));
    }

    /// Turns the scene to a point.
    pub fn drag(&mut self, x: f64, y: f64) {
        self.eye.drag(DVec2::new(x, y));
        self.is_home = false;
    }

    /// Ends the turn.
    pub fn release(&mut self) {
        self.eye.release();
    }

    /// Enlarges the scene by a factor above 0.
    pub fn magnify(&mut self, factor: f64) {
        self.eye.magnify(factor);
        self.is_home = false;
    }

    /// Moves the scene by pixels right and down, in a picture of this height.
    #[wasm_bindgen(js_name = moveBy)]
    pub fn move_by(&mut self, right: f64, down: f64, height: f64) {
        self.eye.move_by(DVec2::new(right, down), height);
        self.is_home = false;
    }

    /// Fits a box into a picture of this aspect ratio. The box is its lower and its upper corner.
    pub fn frame(&mut self, corners: &[f64], aspect: f64) {
        let &[a, b, c, d, e, f] = corners else { return };
        self.eye.frame(&Aabb { min: DVec3::new(a, b, c), max: DVec3::new(d, e, f) }, aspect);
        self.is_home = false;
    }

    /// Looks from the front (`front`), the right (`right`) or the top (`top`), in a scene with this direction up.
    #[wasm_bindgen(js_name = lookFrom)]
    pub fn look_from(&mut self, side: &str, up: &[f64]) {
        use superegg_viewer::ViewSide;
        let side = match side {
            "right" => ViewSide::Right,
            "top" => ViewSide::Top,
            _ => ViewSide::Front,
        };
        let up = <[f64; 3]>::try_from(up).map_or(DVec3::Y, DVec3::from_array);
        let (direction, up) = side.directions(up);
        self.eye.look_from(direction, up);
        self.is_home = false;
    }
}

/// A row of the table of keys.
#[derive(Serialize)]
struct Key {
    keys: &'static [&'static str],
    action: String,
    help: &'static str,
}

/// The keys of the viewer, as JSON: keys, action, help.
#[wasm_bindgen]
pub fn keys() -> String {
    let rows = BINDINGS.iter();
    let keys: Vec<Key> =
        rows.map(|row| Key { keys: row.keys, action: format!("{:?}", row.action), help: row.help }).collect();
    json(&keys)
}

/// The position of a scene's light, for drawing; `None` for a light without one.
pub(crate) fn position_of(light: &Light) -> Option<[f64; 3]> {
    light.position().map(|position| position.to_array())
}
