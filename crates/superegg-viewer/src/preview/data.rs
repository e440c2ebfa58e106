//! The preview's data.

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Aabb, Exponents};
use superegg_scene::{Material, Patches};

/// A primitive in the preview: the unit shape. Each instance's map contains the semi-axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewShape {
    /// Its exponents.
    pub exponents: Exponents,
    /// Its semi-axes, for patterns.
    pub radii: DVec3,
    /// Its patches around and from pole to pole.
    pub patches: Patches,
    /// Its material.
    pub material: Material,
}

/// One instance of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewInstance {
    /// Index of its shape in [`Preview::shapes`].
    pub shape: u32,
    /// World from the unit shape's space.
    pub world_from_unit: DAffine3,
    /// Index of the root's child that it belongs to; 0 for a root that is a primitive.
    pub child: u32,
    /// Radius of a bounding sphere about the instance's origin, in world units.
    pub radius: f64,
}

/// A scene ready to be drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preview {
    /// The primitives of the scene in its order, then the shapes of proxies.
    pub shapes: Vec<PreviewShape>,
    /// The instances.
    pub instances: Vec<PreviewInstance>,
    /// Bounding box of the whole scene, the branches that are not expanded included. `None` for an
    /// empty scene.
    pub bounds: Option<Aabb>,
    /// Branches smaller than a pixel. One proxy stands for each.
    pub small_branches: usize,
    /// Branches beyond the budget.
    pub unpaid_branches: usize,
}

impl Preview {
    /// Whether the result depends on the camera, because some branches are not expanded.
    pub(crate) fn depends_on_camera(&self) -> bool {
        self.small_branches + self.unpaid_branches > 0
    }
}

/// Limits of the expansion of objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewBudget {
    /// Most instances, approximately.
    pub instances: usize,
    /// Height of the picture in pixels. It sets the size of a pixel.
    pub height_px: u32,
}

impl PreviewBudget {
    /// Most instances of the window's preview.
    pub(crate) const WINDOW_INSTANCES: usize = 250_000;
}
