//! The switches of a viewer: what it draws of a scene, and how. They belong to the person who looks, not to the scene.

/// Where the light on a mesh is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// At each pixel, from the interpolated normal.
    Phong,
    /// At each vertex, interpolated between them.
    Gouraud,
}

/// What the viewer draws, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSettings {
    /// The lights turn with the arcball.
    pub lights_turn: bool,
    /// Where the light on a mesh is computed.
    pub shading: Shading,
    /// Edges instead of surfaces.
    pub wireframe: bool,
    /// Normals at the vertices, in wireframe.
    pub normals: bool,
    /// The three axes and the places of the lights.
    pub axes: bool,
    /// The inside-outside test, a grid of marked points.
    pub io_test: bool,
    /// The spacing of its grid, above 0.
    pub io_step: f64,
    /// How far its grid goes from the origin along each axis.
    pub io_half: f64,
    /// How far each point may be moved along each axis, to tell the rows apart.
    pub io_jitter: f64,
    /// The radius of the marks, above 0.
    pub io_radius: f64,
    /// The intersection test: the ray along which the camera looks, and the normal where it first hits.
    pub intersect_test: bool,
}

impl Default for ViewSettings {
    /// As the course program starts; grid and marks as its text proposes.
    fn default() -> Self {
        Self {
            lights_turn: true,
            shading: Shading::Phong,
            wireframe: false,
            normals: false,
            axes: true,
            io_test: true,
            io_step: 0.5,
            io_half: 5.0,
            io_jitter: 0.05,
            io_radius: 0.1,
            intersect_test: true,
        }
    }
}
