//! The description of a picture, and its statistics.

use superegg_geom::glam::DVec3;
use superegg_render::Development;
use superegg_scene::{Camera, Floor, Light, Material, Scene, Shading, Sky};

use crate::preview::Preview;

/// A straight line in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its ends, in world space.
    pub ends: [DVec3; 2],
    /// Encoded red, green, blue, and opacity.
    pub color: [f32; 4],
}

/// A small emissive sphere in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Its centre, in world space.
    pub center: DVec3,
    /// Its radius, in world units.
    pub radius: f64,
    /// Encoded red, green, blue, and opacity.
    pub color: [f32; 4],
    /// It shows through the surfaces before it.
    pub is_on_top: bool,
}

/// The style of the solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Surfaces, shaded per pixel or per vertex.
    Solid(Shading),
    /// Patch edges: bright in front, dim behind.
    Wireframe {
        /// Draw the normals at the vertices.
        has_normals: bool,
    },
}

/// Instances that are highlighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selected {
    /// Those of the shape with this index.
    Shape(u32),
    /// The instances of the root's child with this index.
    Child(u32),
}

/// A picture to be drawn.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The camera.
    pub camera: Camera,
    /// The lights, in world space. Only the first [`super::MOST_LIGHTS`] shine.
    pub lights: &'a [Light],
    /// The background, a linear colour.
    pub background: DVec3,
    /// The sky, which replaces the background.
    pub sky: Option<Sky>,
    /// The floor with its material.
    pub floor: Option<(&'a Floor, Material)>,
    /// Exposure, tone mapping and encoding of linear colours for the screen.
    pub development: Development,
    /// As the course program: with the patches of the primitives, and without mirrors and glass.
    pub is_course: bool,
    /// The solids.
    pub preview: &'a Preview,
    /// Their style.
    pub style: Style,
    /// The instances that are highlighted: by an outline, or in wireframe and as in the course
    /// program by their edges.
    pub selected: Option<Selected>,
    /// Additional lines.
    pub lines: &'a [Line],
    /// Additional marks.
    pub marks: &'a [Mark],
    /// A traced picture that replaces all of these over the whole viewport.
    pub film: Option<&'a FilmTexture>,
}

impl<'a> Picture<'a> {
    /// The picture of a scene through its camera, shaded per pixel.
    pub fn of(scene: &'a Scene, preview: &'a Preview, lights: &'a [Light]) -> Self {
        Self {
            camera: scene.camera,
            lights,
            background: scene.background,
            sky: scene.sky,
            floor: scene.floor.as_ref().map(|floor| (floor, scene.floor_material())),
            development: Development::of(&scene.picture),
            is_course: false,
            preview,
            style: Style::Solid(Shading::Phong),
            selected: None,
            lines: &[],
            marks: &[],
            film: None,
        }
    }
}

/// A traced picture on the GPU.
#[derive(Debug)]
pub struct FilmTexture {
    pub(super) bind_group: wgpu::BindGroup,
}

/// The target of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target<'a> {
    /// The colour attachment.
    pub(crate) view: &'a wgpu::TextureView,
    /// Its width and height in pixels.
    pub(crate) size: (u32, u32),
    /// Left, top, width and height of the part for the picture, in pixels.
    pub(crate) viewport: (u32, u32, u32, u32),
}
