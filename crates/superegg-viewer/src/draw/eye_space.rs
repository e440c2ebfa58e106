//! Eye space.

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::unit_vector;
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
    /// All rays are parallel: the camera is orthographic.
    pub(super) is_parallel: bool,
    /// Cotangents of half the angles of view, or for parallel rays reciprocals of half the extents.
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
        let scale_y = match camera.ortho_height {
            Some(height) => 2.0 * unit / height,
            None => 1.0 / (0.5 * camera.fov_deg.to_radians()).tan(),
        };
        let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
        Self {
            eye_from_world,
            unit,
            is_parallel: camera.ortho_height.is_some(),
            scale_x: scale_y / aspect,
            scale_y,
            height_px: f64::from(height),
        }
    }

    /// Width and height of a pixel in normalized device coordinates.
    pub(super) fn ndc_per_pixel(&self) -> (f32, f32) {
        let height = self.height_px.max(1.0);
        let width = height * self.scale_y / self.scale_x;
        ((2.0 / width) as f32, (2.0 / height) as f32)
    }

    /// The size of a pixel at distance 1, or for parallel rays at any distance.
    pub(super) fn pixel(&self) -> f64 {
        2.0 / (self.scale_y * self.height_px.max(1.0))
    }

    /// A direction of the world as a unit vector.
    pub(super) fn direction(&self, world: DVec3) -> DVec3 {
        (self.eye_from_world.matrix3 * unit_vector(world).unwrap_or(DVec3::Y)).normalize_or_zero()
    }

    /// A point of the world, clamped to a range that f32 holds.
    pub(super) fn point(&self, world: DVec3) -> [f32; 3] {
        let point =
            self.eye_from_world.transform_point3(world).clamp(DVec3::splat(-1e30), DVec3::splat(1e30));
        point.as_vec3().to_array()
    }

    /// The distance of an instance from the eye.
    pub(super) fn distance(&self, instance: &PreviewInstance) -> f64 {
        let center = self.eye_from_world.transform_point3(instance.world_from_unit.translation);
        if self.is_parallel { -center.z } else { center.length() }
    }

    /// Radius of an instance on the screen in pixels. `None` if it is outside the view frustum.
    pub(super) fn size_px(&self, instance: &PreviewInstance) -> Option<f64> {
        let center = self.eye_from_world.transform_point3(instance.world_from_unit.translation);
        let radius = instance.radius / self.unit;
        let depth = -center.z;
        if self.is_parallel {
            let beyond = |across: f64, scale: f64| (across.abs() - radius) * scale > 1.0;
            let is_seen = center.is_finite()
                && depth + radius > 0.0
                && !beyond(center.x, self.scale_x)
                && !beyond(center.y, self.scale_y);
            return is_seen.then_some(radius / self.pixel());
        }
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
