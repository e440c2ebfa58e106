//! A ray to trace, and the hit that answers it.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayStart, Superquadric};

use super::footprint::Footprint;
use crate::scene::id::SceneId;
use crate::scene::path::InstancePath;

/// A ray with what a query needs to know about it.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceRay {
    /// Origin and direction. The direction may have any length: t counts lengths of it.
    pub ray: Ray,
    /// The surface that the ray starts on, if any.
    pub start: Option<SurfaceStart>,
    /// The width of the ray. Groups much smaller than the width are hit as a whole.
    pub footprint: Footprint,
}

impl TraceRay {
    /// A ray without width that starts on no surface.
    pub fn new(ray: Ray) -> Self {
        Self { ray, start: None, footprint: Footprint::NONE }
    }

    /// The same ray with a width.
    #[must_use]
    pub fn with_footprint(self, footprint: Footprint) -> Self {
        Self { footprint, ..self }
    }

    /// The same ray, starting on a surface.
    #[must_use]
    pub fn with_start(self, start: Option<SurfaceStart>) -> Self {
        Self { start, ..self }
    }
}

impl From<Ray> for TraceRay {
    fn from(ray: Ray) -> Self {
        Self::new(ray)
    }
}

/// The side of a surface to which a ray leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Away from the inside of the shape.
    Outward,
    /// Into the shape.
    Inward,
}

/// A ray's start on the surface of an instance.
///
/// It replaces an epsilon by geometry: a ray that leaves a convex shape outwards does not hit that shape again, and one
/// that goes in has exactly one exit.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceStart {
    /// The instance whose surface the ray starts on.
    pub path: InstancePath,
    /// The side to which the ray leaves.
    pub side: Side,
}

impl SurfaceStart {
    /// The start of a ray at the shape of `path`; `None` for a free start.
    #[inline]
    pub fn of(path: InstancePath, start: RayStart) -> Option<Self> {
        let side = match start {
            RayStart::Free => return None,
            RayStart::SurfaceOutward => Side::Outward,
            RayStart::SurfaceInward => Side::Inward,
        };
        Some(Self { path, side })
    }

    /// The start for the shape that the ray starts on.
    pub(crate) fn ray_start(&self) -> RayStart {
        match self.side {
            Side::Outward => RayStart::SurfaceOutward,
            Side::Inward => RayStart::SurfaceInward,
        }
    }

    /// The start for the shape at `path`: free for each shape but the ray's own.
    pub(crate) fn at(start: Option<&Self>, path: &InstancePath) -> RayStart {
        match start {
            Some(start) if start.path == *path => start.ray_start(),
            _ => RayStart::Free,
        }
    }
}

/// The closest hit of a ray, as small as the traversal needs it.
///
/// [`CompiledScene::interaction`] computes the rest: position, normal, material.
///
/// [`CompiledScene::interaction`]: crate::CompiledScene::interaction
#[derive(Clone, Debug)]
pub struct Hit {
    /// The hit is at `origin + t * direction`.
    pub t: f64,
    /// Whether the ray leaves the shape here.
    pub leaving: bool,
    /// The index of the primitive, for [`CompiledScene::primitive`](crate::CompiledScene::primitive). For a proxy: of
    /// the primitive that is seen most.
    pub primitive: u32,
    /// The point in the space of the unit shape, in which the semi-axes are 1.
    pub unit_point: DVec3,
    /// The gradient of N there, of any length, where the traversal has computed it.
    pub(crate) unit_gradient: Option<DVec3>,
    /// The instance of the primitive. For a ray with a footprint it may be a whole group
    /// ([`InstancePath::is_proxy`]).
    pub path: InstancePath,
    /// The scene that was hit.
    pub(crate) scene: SceneId,
}

impl Hit {
    /// The gradient of N at [`Hit::unit_point`], of any length. `shape` is the unit shape of the primitive.
    pub fn gradient(&self, shape: &Superquadric) -> DVec3 {
        self.unit_gradient.unwrap_or_else(|| shape.norm().value_and_gradient(self.unit_point).1)
    }
}

/// Hits are equal if they are the same point of the same instance. The scene itself is not compared, so the hits of a
/// scene and of its recompiled copy may be equal.
impl PartialEq for Hit {
    fn eq(&self, other: &Self) -> bool {
        let Self { t, leaving, primitive, unit_point, unit_gradient, path, scene: _ } = self;
        (*t, *leaving, *primitive, *unit_point, *unit_gradient)
            == (other.t, other.leaving, other.primitive, other.unit_point, other.unit_gradient)
            && *path == other.path
    }
}
