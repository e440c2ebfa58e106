//! Eye space.

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_scene::Camera;

use crate::preview::PreviewInstance;

/// Distance of the near plane, in units of eye space.
pub(super) const NEAR: f64 = 1e-4;

/// Eye space: x right, y up, the eye at the origin looking along -z. Its unit is the distance from
/// eye to target, so that f32 suffices for a scene of any scale.
pub(super) struct EyeSpace {
    pub(super) eye_from_world: DAffine3,
    /// The unit in world units.
    pub(super) unit: f64,
    /// Cotangents of half the angles of view.
    pub(super) scale_x: f64,
    pub(super) scale_y: f64,
    height_px: f64,
}

impl EyeSpace {
    pub(super) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let (right, up, forward) = camera.frame();
        let unit = (camera.target - camera.position).length().clamp(1e-150, 1e150);
        let turn = DMat3::from_cols(right, up, -forward).transpose() * (1.0 / unit);
        let eye_from_world = DAffine3 { matrix3: turn, translation: -(turn * camera.position) };
        let scale_y = 1.0 / (0.5 * camera.fov_deg.to_radians()).tan();
        let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
        Self { eye_from_world, unit, scale_x: scale_y / aspect, scale_y, height_px: f64::from(height) }
    }

    /// A point of the world, clamped to a range that f32 holds.
    pub(super) fn point(&self, world: DVec3) -> [f32; 3] {
        let point =
            self.eye_from_world.transform_point3(world).clamp(DVec3::splat(-1e30), DVec3::splat(1e30));
        point.as_vec3().to_array()
    }

    /// Radius of an instance on the screen in pixels. `None` if it is outside the view frustum.
    pub(super) fn size_px(&self, instance: &PreviewInstance) -> Option<f64> {
        let center = self.eye_from_world.transform_point3(instance.world_from_unit.translation);
        let radius = instance.radius / self.unit;
        let depth = -center.z;
        // The side planes of the frustum. The near plane is tested below.
        let beyond =
            |across: f64, scale: f64| across.abs() * scale - depth > radius * (1.0 + scale * scale).sqrt();
        if !(center.is_finite() && center.abs().max_element() < 1e30)
            || depth + radius < NEAR
            || beyond(center.x, self.scale_x)
            || beyond(center.y, self.scale_y)
        {
            return None;
        }
        let distance = (center.length() - radius).max(1e-3 * radius);
        Some(0.5 * self.height_px * self.scale_y * radius / distance)
    }
}
