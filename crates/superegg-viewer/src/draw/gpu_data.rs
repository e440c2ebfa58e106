//! Buffer contents as the shaders read them.

use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::unit_vector;
use superegg_scene::{Encoding, Light, LightKind, Material};

use super::eye_space::{EyeSpace, NEAR};
use super::picture::Picture;
use crate::preview::PreviewInstance;

/// Most lights in the preview.
pub const MOST_LIGHTS: usize = 32;

/// The uniform of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct FrameUniform {
    /// Cotangents of half the angles of view in x and y, near plane, 1 for the sRGB curve.
    projection: [f32; 4],
    /// The number of lights.
    counts: [u32; 4],
    lights: [[f32; 12]; MOST_LIGHTS],
}

/// The vertex data of an instance.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct InstanceData {
    /// Rows of the map from the unit shape to eye space.
    rows: [[f32; 4]; 3],
    color_ambient: [f32; 4],
    /// Diffuse, specular, highlight exponent, and the sign of the map's determinant.
    surface: [f32; 4],
    /// Columns of the map of normals.
    normals: [[f32; 3]; 3],
}

impl InstanceData {
    /// Whether the map mirrors the shape.
    pub(super) fn is_mirrored(&self) -> bool {
        self.surface[3] < 0.0
    }
}

pub(super) fn frame_uniform(space: &EyeSpace, picture: &Picture<'_>) -> FrameUniform {
    let mut lights = [[0.0; 12]; MOST_LIGHTS];
    let shining = picture.lights.iter().take(MOST_LIGHTS);
    for (to, light) in lights.iter_mut().zip(shining.clone()) {
        *to = light_numbers(space, light);
    }
    let is_curved = if picture.encoding == Encoding::Srgb { 1.0 } else { 0.0 };
    FrameUniform {
        projection: [space.scale_x as f32, space.scale_y as f32, NEAR as f32, is_curved],
        counts: [shining.len() as u32, 0, 0, 0],
        lights,
    }
}

/// A light for the shader: position and attenuation, colour and softness of the rim, axis and half
/// angle of the cone. A directional light has its direction as position and a softness below 0. A
/// point light has the angle 0.
fn light_numbers(space: &EyeSpace, light: &Light) -> [f32; 12] {
    let falloff = (light.falloff * space.unit * space.unit).min(1e30) as f32;
    let [r, g, b] = light.color.min(DVec3::splat(1e30)).as_vec3().to_array();
    let turned = |direction: DVec3| {
        let unit = unit_vector(direction).unwrap_or(DVec3::NEG_Z);
        (space.eye_from_world.matrix3 * unit).normalize_or_zero().as_vec3().to_array()
    };
    match light.kind {
        LightKind::Point { position } => {
            let [x, y, z] = space.point(position);
            [x, y, z, falloff, r, g, b, 0.0, 0.0, 0.0, 0.0, 0.0]
        }
        LightKind::Spot { position, target, cone_deg, soft } => {
            let [x, y, z] = space.point(position);
            let [ax, ay, az] = turned(target - position);
            let half_rad = 0.5 * cone_deg.to_radians() as f32;
            [x, y, z, falloff, r, g, b, soft as f32, ax, ay, az, half_rad]
        }
        LightKind::Sun { direction } => {
            let [x, y, z] = turned(direction);
            [x, y, z, 0.0, r, g, b, -1.0, 0.0, 0.0, 0.0, 0.0]
        }
    }
}

pub(super) fn instance_data(
    space: &EyeSpace,
    instance: &PreviewInstance,
    material: &Material,
) -> InstanceData {
    let map = space.eye_from_world * instance.world_from_unit;
    let m = map.matrix3;
    let row = |x: f64, y: f64, z: f64, t: f64| [x as f32, y as f32, z as f32, t as f32];
    let rows = [
        row(m.x_axis.x, m.y_axis.x, m.z_axis.x, map.translation.x),
        row(m.x_axis.y, m.y_axis.y, m.z_axis.y, map.translation.y),
        row(m.x_axis.z, m.y_axis.z, m.z_axis.z, map.translation.z),
    ];
    let [r, g, b] = material.color.as_vec3().to_array();
    // Scaled columns, so that no product overflows.
    let size = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element().max(1e-300);
    let column = |v: DVec3| v / v.abs().max_element().max(1e-300);
    let (x, y, z) = (column(m.x_axis), column(m.y_axis), column(m.z_axis));
    let sign = if DMat3::from_cols(x, y, z).determinant() < 0.0 { -1.0 } else { 1.0 };
    // The cofactor matrix is the inverse transpose times the determinant.
    let m = m * (1.0 / size);
    let cofactors = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
    let largest = cofactors.iter().fold(1e-300, |all: f64, c| all.max(c.abs().max_element()));
    InstanceData {
        rows,
        color_ambient: [r, g, b, material.ambient as f32],
        surface: [
            material.diffuse as f32,
            material.specular as f32,
            material.highlight_exponent().min(1e6) as f32,
            sign as f32,
        ],
        normals: cofactors.map(|c| (c * (sign / largest)).as_vec3().to_array()),
    }
}
