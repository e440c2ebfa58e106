//! The settings of a viewer. They belong to the user, not to the scene.

/// The shading of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// Per pixel, from the interpolated normal.
    Phong,
    /// Per vertex, interpolated.
    Gouraud,
}

/// The colours of the viewer's menus and panels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Theme {
    /// Those of the system, and dark ones where it has none.
    #[default]
    System,
    /// Dark text on light panels.
    Light,
    /// Light text on dark panels.
    Dark,
}

/// Settings of the viewer's drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewSettings {
    /// Whether the lights rotate with the arcball.
    pub lights_turn: bool,
    /// The shading of the mesh.
    pub shading: Shading,
    /// Whether edges are drawn instead of surfaces.
    pub wireframe: bool,
    /// Whether vertex normals are drawn, in wireframe.
    pub normals: bool,
    /// Whether the axes and the positions of the lights are drawn.
    pub axes: bool,
    /// Whether the inside-outside test is drawn: a grid of marked points.
    pub io_test: bool,
    /// Whether its grid suits the size of the scene; else the next four numbers make it.
    pub io_fit: bool,
    /// Whether its points outside are drawn too.
    pub io_outside: bool,
    /// The spacing of its grid in world units, above 0.
    pub io_step: f64,
    /// The half extent of its grid along each axis, in world units.
    pub io_half: f64,
    /// The maximal random offset of its points along each axis, which separates the rows visually.
    pub io_jitter: f64,
    /// The radius of the marks, above 0.
    pub io_radius: f64,
    /// Whether the intersection test is drawn: the camera's central ray, and the normal at its
    /// first hit.
    pub intersect_test: bool,
    /// Whether surfaces have the patches of their primitives, as in the course program, instead of
    /// as many as their size on the screen needs.
    pub course: bool,
    /// The colours of menus and panels.
    pub theme: Theme,
}

impl ViewSettings {
    /// The initial state of the course program: both tests are drawn.
    pub const COURSE: Self = Self {
        lights_turn: true,
        shading: Shading::Phong,
        wireframe: false,
        normals: false,
        axes: true,
        io_test: true,
        io_fit: false,
        io_outside: true,
        io_step: 0.5,
        io_half: 5.0,
        io_jitter: 0.05,
        io_radius: 0.1,
        intersect_test: true,
        course: true,
        theme: Theme::System,
    };
}

impl Default for ViewSettings {
    /// The scene with its axes, and no test.
    fn default() -> Self {
        Self { io_test: false, io_fit: true, intersect_test: false, course: false, ..Self::COURSE }
    }
}
