//! The camera and the light of data of other programs.

use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;
use superegg_scene::{Camera, Light, LightKind, Scene};

use crate::camera::framing::Framing;

/// The direction from data to its camera: from the front, a little from the right and above.
const BACKWARDS: DVec3 = DVec3::new(0.55, -0.75, 0.42);
/// The vertical field of view of the camera, in degrees.
const FIELD_OF_VIEW: f64 = 40.0;
/// The name of the light of data.
const KEY_LIGHT: &str = "key";

/// Gives a scene a camera and a light that show a box in a picture of `size` pixels, z up, on white. An empty box
/// changes nothing.
///
/// ```
/// use superegg_geom::Aabb;
/// use superegg_geom::glam::DVec3;
/// use superegg_render::frame_data;
/// use superegg_scene::Scene;
///
/// let mut scene = Scene::default();
/// frame_data(&mut scene, &Aabb::around(DVec3::X, DVec3::ONE), (640, 480));
/// assert!(scene.sets_camera && scene.camera.position.y < 0.0);
/// assert_eq!(scene.named_lights().len(), 1);
/// ```
pub fn frame_data(scene: &mut Scene, bounds: &Aabb, size: (u32, u32)) {
    let direction = Camera {
        position: BACKWARDS,
        target: DVec3::ZERO,
        up: DVec3::Z,
        fov_deg: FIELD_OF_VIEW,
        ..Camera::default()
    };
    let Some(Framing { camera, .. }) = Framing::of_box(&direction, bounds, size) else { return };
    scene.set_up(DVec3::Z);
    (scene.camera, scene.sets_camera) = (camera, true);
    scene.background = DVec3::ONE;
    // Over the left shoulder, so that the three faces that are in sight get different light.
    let (right, up, forward) = camera.frame();
    let aside = 0.75 * up - 0.45 * forward - 0.35 * right;
    let position = bounds.center() + 6.0 * bounds.half_extent().length() * aside;
    let light = Light {
        kind: LightKind::Point { position },
        color: DVec3::splat(1.1),
        falloff: 0.0,
        ..Light::DEFAULT
    };
    scene.set_light(KEY_LIGHT, light);
}
