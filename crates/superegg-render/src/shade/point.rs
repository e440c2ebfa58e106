//! A point of a surface that is to be shaded, with all that shading asks of it.

use std::borrow::Cow;
use std::ops::Deref;
use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Ray, RayStart};
use superegg_scene::Material;
use superegg_trace::{CompiledPrimitive, Footprint, InstancePath, SurfaceStart, TraceRay};

use crate::camera::sobol::SampleKey;
use crate::shade::floor::FloorPlane;
use crate::shade::medium::Media;
use crate::shade::pattern;
use crate::shade::phong::LobeWeights;

/// A surface of the scene, or the average of several that was made for a stand-in.
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

/// What a point is on.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceOwner {
    /// An instance of a primitive, or a stand-in.
    Instance(Rc<InstancePath>),
    /// The floor.
    Floor,
}

/// What a ray brings along that meets a surface.
#[derive(Clone, Debug)]
pub(crate) struct PathState {
    /// The place of the colour that it adds to.
    pub(crate) pixel: usize,
    /// The share of its light in that colour.
    pub(crate) weight: DVec3,
    pub(crate) key: SampleKey,
    /// What it was in before the surface.
    pub(crate) media: Media,
    /// Whether it began on the floor, which it does not meet again.
    pub(crate) is_from_floor: bool,
}

/// A point that is to be shaded.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePoint<'a> {
    pub(crate) state: PathState,
    pub(crate) owner: SurfaceOwner,
    pub(crate) position: DVec3,
    pub(crate) position_error: f64,
    /// The unit normal, outwards.
    pub(crate) normal: DVec3,
    pub(crate) leaving: bool,
    /// The unit direction back along the ray.
    pub(crate) to_eye: DVec3,
    /// The ray's width here, and what it grows by for each unit of way.
    pub(crate) footprint: Footprint,
    pub(crate) material: MaterialRef<'a>,
    /// The colour of the surface here, pattern and all.
    pub(crate) albedo: DVec3,
    pub(crate) weights: LobeWeights,
}

impl PathState {
    /// After the way between two points through what it is in.
    pub(crate) fn after(mut self, from: DVec3, to: DVec3) -> Self {
        self.weight *= self.media.transmittance_between(from, to);
        self
    }
}

impl SurfacePoint<'_> {
    /// The normal on the side of the ray.
    pub(crate) fn facing_normal(&self) -> DVec3 {
        if self.leaving { -self.normal } else { self.normal }
    }

    /// Whether it is on the average of a group that was not opened.
    pub(crate) fn is_proxy(&self) -> bool {
        matches!(&self.owner, SurfaceOwner::Instance(path) if path.is_proxy())
    }

    /// A ray from here, with what is known of its start.
    pub(crate) fn spawn(&self, direction: DVec3, footprint: Footprint) -> TraceRay {
        let ray = Ray { origin: self.position, direction, origin_error: self.position_error };
        let start = match &self.owner {
            SurfaceOwner::Instance(path) => SurfaceStart::of((**path).clone(), self.start(direction)),
            SurfaceOwner::Floor => None,
        };
        TraceRay { ray, start, footprint }
    }

    /// Whether it is on the floor, which rays from here do not meet again.
    pub(crate) fn is_on_floor(&self) -> bool {
        matches!(self.owner, SurfaceOwner::Floor)
    }

    /// The index of refraction before the surface divided by the one behind it, and what a ray is in behind it. Of the floor: nothing changes.
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

    /// What is known of the start of a ray from here for the shape itself.
    pub(crate) fn start(&self, direction: DVec3) -> RayStart {
        if self.normal.dot(direction) >= 0.0 { RayStart::SurfaceOutward } else { RayStart::SurfaceInward }
    }
}

/// How a point of a surface is seen.
pub(crate) struct SurfaceView {
    /// The unit normal, on either side.
    pub(crate) normal: DVec3,
    /// The unit direction of the ray.
    pub(crate) direction: DVec3,
    /// The ray's width.
    pub(crate) width: f64,
}

/// The colour at a point of a shape: `unit_point` is in the space of the unit shape.
pub(crate) fn albedo_of_shape(
    material: &Material,
    primitive: &CompiledPrimitive,
    unit_point: DVec3,
    world_from_unit: &DAffine3,
    seen: &SurfaceView,
) -> DVec3 {
    let radii = primitive.radii;
    let linear = world_from_unit.matrix3;
    // The world's image of a step along each axis of the primitive's own space.
    let axes = [linear.x_axis / radii.x, linear.y_axis / radii.y, linear.z_axis / radii.z];
    // A little inwards: a flat face may lie just between two cells.
    let inwards = 1.0 - 1e-9;
    let reach = |along: DVec3| primitive.unit_shape().norm().support(along * radii);
    let place = unit_point * radii * inwards;
    let share = pattern::share(&material.pattern, place, extents(axes, seen), Some(&reach));
    pattern::mix(material.color, &material.pattern, share)
}

/// The colour at a point of the floor.
pub(crate) fn albedo_of_floor(ground: &FloorPlane<'_>, position: DVec3, seen: &SurfaceView) -> DVec3 {
    let pattern = &ground.material.pattern;
    let share = pattern::share(pattern, ground.place(position), extents(ground.axes(), seen), None);
    pattern::mix(ground.material.color, pattern, share)
}

/// How far the part of a surface that a ray sees goes along each axis, in that axis' own units.
fn extents(axes: [DVec3; 3], seen: &SurfaceView) -> DVec3 {
    let &SurfaceView { normal, direction, width } = seen;
    let cos = direction.dot(normal).abs().max(1e-6);
    let along = (direction - direction.dot(normal) * normal).normalize_or_zero();
    DVec3::from_array(axes.map(|axis| {
        let in_plane = axis - axis.dot(normal) * normal;
        let (lengthwise, all) = (in_plane.dot(along), in_plane.length_squared());
        let crosswise = (all - lengthwise * lengthwise).max(0.0);
        width * (crosswise + lengthwise * lengthwise / (cos * cos)).sqrt() / axis.length_squared()
    }))
}
