//! A surface point with the data that shading needs.

use std::borrow::Cow;
use std::ops::Deref;
use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DVec2, DVec3};
use superegg_geom::{Ray, RayStart};
use superegg_scene::{Material, Pattern};
use superegg_trace::{CompiledPrimitive, Footprint, InstancePath, SurfaceStart, TraceRay};

use crate::camera::sobol::SampleKey;
use crate::shade::bump::Bump;
use crate::shade::floor::FloorPlane;
use crate::shade::medium::Media;
use crate::shade::pattern;
use crate::shade::phong::{self, LobeWeights};

/// A material of the scene, or the mean material of a proxy.
#[derive(Clone, Debug)]
pub(crate) enum MaterialRef<'a> {
    Scene(&'a Material),
    Mean(Rc<Material>),
}

impl<'a> From<Cow<'a, Material>> for MaterialRef<'a> {
    fn from(material: Cow<'a, Material>) -> Self {
        match material {
            Cow::Borrowed(material) => Self::Scene(material),
            Cow::Owned(material) => Self::Mean(Rc::new(material)),
        }
    }
}

impl Deref for MaterialRef<'_> {
    type Target = Material;

    fn deref(&self) -> &Material {
        match self {
            Self::Scene(material) => material,
            Self::Mean(material) => material,
        }
    }
}

/// The owner of a surface point.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceOwner {
    /// An instance of a primitive, or a proxy.
    Instance(Rc<InstancePath>),
    /// The floor.
    Floor,
}

/// The state of a path where a ray starts.
#[derive(Clone, Debug)]
pub(crate) struct PathState {
    /// The index of the colour that the path adds to.
    pub(crate) pixel: usize,
    /// The throughput: the factor of light along the path.
    pub(crate) weight: DVec3,
    pub(crate) key: SampleKey,
    /// The media that the ray passes before the surface.
    pub(crate) media: Media,
    /// Whether the ray starts on the floor, which it cannot hit again.
    pub(crate) is_from_floor: bool,
}

/// A surface point to shade.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePoint<'a> {
    pub(crate) state: PathState,
    pub(crate) owner: SurfaceOwner,
    pub(crate) position: DVec3,
    /// A bound on the rounding error of each coordinate, in world units.
    pub(crate) position_error: f64,
    /// The outward unit normal.
    pub(crate) normal: DVec3,
    /// Whether the ray leaves the shape.
    pub(crate) leaving: bool,
    /// The unit direction back along the ray.
    pub(crate) to_eye: DVec3,
    /// The width of the ray here, and its growth per world unit.
    pub(crate) footprint: Footprint,
    pub(crate) material: MaterialRef<'a>,
    /// The colour of the surface here, with its pattern.
    pub(crate) albedo: DVec3,
    pub(crate) weights: LobeWeights,
    /// The normals of light, if they are not that of the shape.
    pub(crate) bump: Option<Box<Bump>>,
}

impl PathState {
    /// The state after the path from one point to another, dimmed by the current media.
    pub(crate) fn after(mut self, from: DVec3, to: DVec3) -> Self {
        self.weight *= self.media.transmittance_between(from, to);
        self
    }
}

impl SurfacePoint<'_> {
    /// The unit normal on the side of the ray.
    pub(crate) fn facing_normal(&self) -> DVec3 {
        if self.leaving { -self.normal } else { self.normal }
    }

    /// The unit normal of matt light and highlights, on the side of the ray.
    pub(crate) fn shading_normal(&self) -> DVec3 {
        self.bump.as_ref().map_or_else(|| self.facing_normal(), |bump| bump.normal)
    }

    /// The unit normal of mirrors, glass and facets, on the side of the ray.
    pub(crate) fn mirror_normal(&self) -> DVec3 {
        self.bump.as_ref().map_or_else(|| self.facing_normal(), |bump| bump.mirror)
    }

    /// The part of the light from a unit direction that its bumps let reach the point: 1 without any, 0 from below.
    pub(crate) fn open_part(&self, direction: DVec3) -> f64 {
        self.bump.as_ref().map_or(1.0, |bump| bump.open_part(self.facing_normal().dot(direction)))
    }

    /// The refracted direction of the ray and the reflectance, as [`phong::refract`]. With bumps `None` also where the direction
    /// would not go through the surface: all is reflected.
    pub(crate) fn refract(&self, ratio: f64) -> Option<(DVec3, f64)> {
        let found = phong::refract(-self.to_eye, self.mirror_normal(), ratio);
        found.filter(|(direction, _)| self.bump.is_none() || self.facing_normal().dot(*direction) < 0.0)
    }

    /// The direction of the ray after a rough mirror, as [`phong::rough_mirror`]. With bumps, one into the surface is replaced
    /// by that of the sharp mirror.
    pub(crate) fn rough_mirror(&self, exponent: f64, square: DVec2) -> DVec3 {
        let normal = self.mirror_normal();
        let rough = phong::rough_mirror(-self.to_eye, normal, exponent, square);
        let is_above = self.bump.is_none() || self.facing_normal().dot(rough) > 0.0;
        if is_above { rough } else { phong::mirror(-self.to_eye, normal) }
    }

    /// Whether the point is on a proxy.
    pub(crate) fn is_proxy(&self) -> bool {
        matches!(&self.owner, SurfaceOwner::Instance(path) if path.is_proxy())
    }

    /// A ray from here, with its start on the surface.
    pub(crate) fn spawn(&self, direction: DVec3, footprint: Footprint) -> TraceRay {
        let ray = Ray { origin: self.position, direction, origin_error: self.position_error };
        let start = match &self.owner {
            SurfaceOwner::Instance(path) => SurfaceStart::of((**path).clone(), self.start(direction)),
            SurfaceOwner::Floor => None,
        };
        TraceRay { ray, start, footprint }
    }

    /// Whether the point is on the floor, which rays from here cannot hit again.
    pub(crate) fn is_on_floor(&self) -> bool {
        matches!(self.owner, SurfaceOwner::Floor)
    }

    /// The ratio of the indices of refraction before and behind the surface, and the media behind
    /// it. The floor changes neither.
    pub(crate) fn beyond(&self) -> (f64, Media) {
        let media = &self.state.media;
        match &self.owner {
            SurfaceOwner::Instance(path) => {
                let (before, beyond) = media.across(path, &self.material, self.leaving);
                (before / beyond.index(), beyond)
            }
            SurfaceOwner::Floor => (1.0, media.clone()),
        }
    }

    /// The side of the surface to which a ray in a direction leaves.
    pub(crate) fn start(&self, direction: DVec3) -> RayStart {
        if self.normal.dot(direction) >= 0.0 { RayStart::SurfaceOutward } else { RayStart::SurfaceInward }
    }
}

/// The view of a surface point along a ray.
pub(crate) struct SurfaceView {
    /// The unit normal, on either side.
    pub(crate) normal: DVec3,
    /// The unit direction of the ray.
    pub(crate) direction: DVec3,
    /// The width of the ray.
    pub(crate) width: f64,
}

/// The colour at a point of a shape, given in the space of the unit shape.
pub(crate) fn albedo_of_shape(
    material: &Material,
    primitive: &CompiledPrimitive,
    unit_point: DVec3,
    world_from_unit: &DAffine3,
    view: &SurfaceView,
) -> DVec3 {
    let is_mapped = material.pattern != Pattern::None;
    let Some(radii) = primitive.radii.filter(|_| is_mapped) else { return material.color };
    let linear = world_from_unit.matrix3;
    // The world vectors of unit steps along the axes of the primitive.
    let axes = [linear.x_axis / radii.x, linear.y_axis / radii.y, linear.z_axis / radii.z];
    // Moves the point inwards: a flat face may lie exactly between two cells.
    let inwards = 1.0 - 1e-9;
    let reach = |along: DVec3| primitive.unit_shape().norm().support(along * radii);
    let local = unit_point * radii * inwards;
    let weight = pattern::weight(&material.pattern, local, extents(axes, view), Some(&reach));
    pattern::mix(material.color, &material.pattern, weight)
}

/// The colour at a point of the floor.
pub(crate) fn albedo_of_floor(ground: &FloorPlane<'_>, position: DVec3, view: &SurfaceView) -> DVec3 {
    let pattern = &ground.material.pattern;
    if *pattern == Pattern::None {
        return ground.material.color;
    }
    let weight = pattern::weight(pattern, ground.local(position), extents(ground.axes(), view), None);
    pattern::mix(ground.material.color, pattern, weight)
}

/// The extent of the footprint of a ray on the surface along each axis, in units of that axis.
pub(crate) fn extents(axes: [DVec3; 3], view: &SurfaceView) -> DVec3 {
    let &SurfaceView { normal, direction, width } = view;
    let cos = direction.dot(normal).abs().max(1e-6);
    let along = (direction - direction.dot(normal) * normal).normalize_or_zero();
    DVec3::from_array(axes.map(|axis| {
        let in_plane = axis - axis.dot(normal) * normal;
        let (lengthwise, all) = (in_plane.dot(along), in_plane.length_squared());
        let crosswise = (all - lengthwise * lengthwise).max(0.0);
        width * (crosswise + lengthwise * lengthwise / (cos * cos)).sqrt() / axis.length_squared()
    }))
}
