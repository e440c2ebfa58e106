//! Buffer contents as the shaders read them.

use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::{Superquadric, unit_vector};
use superegg_scene::{Encoding, Floor, Light, LightKind, Material, Pattern, Sky, Tone};

use super::eye_space::{EyeSpace, NEAR};
use super::picture::Picture;
use crate::preview::{PreviewInstance, PreviewShape};

/// Most lights in the preview.
pub const MOST_LIGHTS: usize = 32;

/// The uniform of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct FrameUniform {
    /// Cotangents of half the angles of view in x and y, near plane, 1 for the sRGB curve.
    projection: [f32; 4],
    /// The number of lights, 1 for parallel rays, the tone mapping, 1 for a floor.
    counts: [u32; 4],
    /// Factor of the exposure, size of a pixel.
    develop: [f32; 4],
    horizon: [f32; 4],
    zenith: [f32; 4],
    sky_up: [f32; 4],
    floor: FloorUniform,
    lights: [[f32; 12]; MOST_LIGHTS],
}

/// The floor.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct FloorUniform {
    /// Unit normal, and distance from the eye along it.
    plane: [f32; 4],
    /// Maps to the two coordinates of the pattern.
    pattern_x: [f32; 4],
    pattern_y: [f32; 4],
    surface: SurfaceData,
    mirror: f32,
    lobes: [f32; 2],
    unused: f32,
}

/// The surface of an instance or of the floor.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct SurfaceData {
    color_ambient: [f32; 4],
    /// Diffuse, specular, highlight exponent, and for an instance the sign of its determinant.
    weights: [f32; 4],
    /// The colour of the pattern; 1 for a checker, 2 for a gradient.
    pattern: [f32; 4],
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
    /// The colour of the pattern; 1 for a checker, 2 for a gradient.
    pattern: [f32; 4],
    /// Factors from the unit shape to the coordinates of the pattern; weight of mirrored light.
    cells: [f32; 4],
    /// Weight of transmitted light; index of refraction, negative without Fresnel reflection.
    lobes: [f32; 2],
    /// The colour that light through one side has after absorption.
    tint: [f32; 3],
}

impl InstanceData {
    /// Whether light goes through the surface.
    pub(super) fn is_transparent(&self) -> bool {
        self.lobes[0] > 0.0
    }

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
    let development = &picture.development;
    let is_curved = if development.encoding == Encoding::Srgb { 1.0 } else { 0.0 };
    let tone = match development.tone {
        Tone::None => 0,
        Tone::Reinhard => 1,
        Tone::Filmic => 2,
        Tone::Aces => 3,
        Tone::Agx => 4,
    };
    let background = picture.background;
    let sky = picture.sky.unwrap_or(Sky { horizon: background, zenith: background, up: DVec3::Y });
    let floor =
        picture.floor.as_ref().map(|(floor, material)| floor_uniform(space, picture, floor, material));
    FrameUniform {
        projection: [space.scale_x as f32, space.scale_y as f32, NEAR as f32, is_curved],
        counts: [shining.len() as u32, space.is_parallel.into(), tone, floor.is_some().into()],
        develop: [
            development.exposure.exp2() as f32,
            space.pixel() as f32,
            space.ndc_per_pixel().0,
            space.ndc_per_pixel().1,
        ],
        horizon: with(sky.horizon, 0.0),
        zenith: with(sky.zenith, 0.0),
        sky_up: with(space.direction(sky.up), 0.0),
        floor: floor.unwrap_or_default(),
        lights,
    }
}

/// A vector with a fourth component, clamped to a range that f32 holds.
fn with(vector: DVec3, w: f64) -> [f32; 4] {
    let clamped = |x: f64| x.clamp(-1e30, 1e30) as f32;
    [clamped(vector.x), clamped(vector.y), clamped(vector.z), clamped(w)]
}

fn floor_uniform(
    space: &EyeSpace,
    picture: &Picture<'_>,
    floor: &Floor,
    material: &Material,
) -> FloorUniform {
    let [first, second, up] = floor.axes();
    let eye = picture.camera.position;
    let plane = with(space.direction(up), (floor.height - up.dot(eye)) / space.unit);
    // A coordinate of the pattern along a direction of this length; a period is 2.
    let map = |along: DVec3| {
        let offset = along.dot(eye);
        let linear = space.eye_from_world.matrix3 * along * space.unit * space.unit;
        with(linear, offset - 2.0 * (0.5 * offset).floor())
    };
    let (pattern_x, pattern_y) = match material.pattern {
        Pattern::None | Pattern::Noise { .. } | Pattern::Marble { .. } | Pattern::Wood { .. } => {
            ([0.0; 4], [0.0; 4])
        }
        Pattern::Checker { size, .. } => (map(first / size), map(second / size)),
        Pattern::Gradient { direction, .. } => {
            let along = unit_vector(direction).unwrap_or(DVec3::Z);
            (map(along.x * first + along.y * second), [0.0; 4])
        }
    };
    let (mirror, lobes) = lobes_data(material, picture.is_course);
    FloorUniform { plane, pattern_x, pattern_y, surface: surface_data(material), mirror, lobes, unused: 0.0 }
}

/// The surface of a material; the fourth weight is left 0.
fn surface_data(material: &Material) -> SurfaceData {
    let pattern = match material.pattern {
        // Only ray tracing shows noise.
        Pattern::None | Pattern::Noise { .. } | Pattern::Marble { .. } | Pattern::Wood { .. } => [0.0; 4],
        Pattern::Checker { color, .. } => with(color, 1.0),
        Pattern::Gradient { color, .. } => with(color, 2.0),
    };
    let (diffuse, specular) = (material.diffuse as f32, material.specular as f32);
    SurfaceData {
        color_ambient: with(material.color, material.ambient + material.emission),
        weights: [diffuse, specular, material.highlight_exponent().min(1e6) as f32, 0.0],
        pattern,
    }
}

/// The weight of mirrored light, then that of transmitted light with the index of refraction, negative
/// without Fresnel reflection. The course program draws neither.
fn lobes_data(material: &Material, is_course: bool) -> (f32, [f32; 2]) {
    if is_course {
        return (0.0, [0.0; 2]);
    }
    let index = if material.fresnel { material.index as f32 } else { -material.index as f32 };
    let (mirror, transmitted) = (material.reflected.unwrap_or(0.0), material.refracted.unwrap_or(0.0));
    (mirror as f32, [transmitted as f32, index])
}

/// The colour that light through one side of an instance has: absorbed over half of its mean chord.
fn tint(instance: &PreviewInstance, material: &Material) -> [f32; 3] {
    let m = instance.world_from_unit.matrix3;
    let radius = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length).into_iter().fold(f64::MAX, f64::min);
    // The mean chord of a ball is 4/3 of its radius, and a ray goes through two sides.
    material.absorb.to_array().map(|absorb| (-absorb * radius / 1.5).exp() as f32)
}

/// Factors from the unit shape to the coordinates of its pattern: cubes of a checker, or from -1 to
/// 1 across the shape along a gradient.
fn pattern_cells(shape: &PreviewShape) -> DVec3 {
    match shape.material.pattern {
        Pattern::None | Pattern::Noise { .. } | Pattern::Marble { .. } | Pattern::Wood { .. } => DVec3::ZERO,
        Pattern::Checker { size, .. } => shape.radii / size,
        Pattern::Gradient { direction, .. } => {
            let along = shape.radii * unit_vector(direction).unwrap_or(DVec3::Z);
            along / Superquadric::unit(shape.exponents).norm().support(along).max(1e-300)
        }
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
    shape: &PreviewShape,
    is_course: bool,
) -> InstanceData {
    let map = space.eye_from_world * instance.world_from_unit;
    let m = map.matrix3;
    let row = |x: f64, y: f64, z: f64, t: f64| [x as f32, y as f32, z as f32, t as f32];
    let rows = [
        row(m.x_axis.x, m.y_axis.x, m.z_axis.x, map.translation.x),
        row(m.x_axis.y, m.y_axis.y, m.z_axis.y, map.translation.y),
        row(m.x_axis.z, m.y_axis.z, m.z_axis.z, map.translation.z),
    ];
    // Scaled columns, so that no product overflows.
    let size = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element().max(1e-300);
    let column = |v: DVec3| v / v.abs().max_element().max(1e-300);
    let (x, y, z) = (column(m.x_axis), column(m.y_axis), column(m.z_axis));
    let sign = if DMat3::from_cols(x, y, z).determinant() < 0.0 { -1.0 } else { 1.0 };
    // The cofactor matrix is the inverse transpose times the determinant.
    let m = m * (1.0 / size);
    let cofactors = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
    let largest = cofactors.iter().fold(1e-300, |all: f64, c| all.max(c.abs().max_element()));
    let SurfaceData { color_ambient, mut weights, pattern } = surface_data(&shape.material);
    weights[3] = sign as f32;
    let (mirror, lobes) = lobes_data(&shape.material, is_course);
    InstanceData {
        rows,
        color_ambient,
        surface: weights,
        normals: cofactors.map(|c| (c * (sign / largest)).as_vec3().to_array()),
        pattern,
        cells: with(pattern_cells(shape), f64::from(mirror)),
        lobes,
        tint: tint(instance, &shape.material),
    }
}
