//! The surface at a hit.

use std::borrow::Cow;
use std::fmt;

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Ray, error_through, inverse_of, unit_vector};
use superegg_scene::Material;

use crate::ray::query::{Hit, Side, SurfaceStart, TraceRay};
use crate::scene::compiled::{CompiledScene, PathEnd, group_from_world};
use crate::scene::group::Target;
use crate::scene::path::InstancePath;
use crate::scene::proxy::Proxy;

/// A point of a surface, in world space.
#[derive(Clone, Debug)]
pub struct SurfaceInteraction<'a> {
    /// The position, mapped up from the space of the unit shape. It is on the surface up to rounding, however far the ray
    /// has come.
    pub position: DVec3,
    /// A bound on the rounding error of the position's coordinates, in world units.
    pub position_error: f64,
    /// The unit normal, outwards from the shape.
    pub normal: DVec3,
    /// Whether the ray leaves the shape here.
    pub leaving: bool,
    /// The material; for a proxy the mean of its group.
    pub material: Cow<'a, Material>,
    /// The instance.
    pub path: InstancePath,
}

/// A hit was given to a scene that it does not belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForeignHit;

impl fmt::Display for ForeignHit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the hit belongs to another compiled scene")
    }
}

impl std::error::Error for ForeignHit {}

impl CompiledScene {
    /// The surface at a hit of this scene.
    ///
    /// # Panics
    ///
    /// If the hit belongs to another scene; see [`CompiledScene::try_interaction`].
    pub fn interaction(&self, hit: &Hit) -> SurfaceInteraction<'_> {
        assert!(hit.scene == self.id, "{ForeignHit}");
        self.interaction_of_own(hit)
    }

    /// The surface at a hit.
    ///
    /// # Errors
    ///
    /// [`ForeignHit`] if the hit belongs to another scene, such as the one that this scene was recompiled from.
    pub fn try_interaction(&self, hit: &Hit) -> Result<SurfaceInteraction<'_>, ForeignHit> {
        if hit.scene == self.id { Ok(self.interaction_of_own(hit)) } else { Err(ForeignHit) }
    }

    fn interaction_of_own(&self, hit: &Hit) -> SurfaceInteraction<'_> {
        let (passed, end) = self.groups_along(&hit.path);
        let (unit_from_group, shape, material, instance) = match end {
            PathEnd::Leaf(_, leaf) => {
                let primitive = self.primitives.get(leaf.primitive);
                let material = Cow::Borrowed(&self.materials[primitive.material as usize]);
                (leaf.unit_from_group, primitive.unit_shape(), material, None)
            }
            PathEnd::Nowhere => {
                (DAffine3::IDENTITY, Proxy::unit_shape(), Cow::Owned(Material::default()), None)
            }
            PathEnd::Proxy(_, instance) => {
                let proxy = instance.group.proxy(&self.primitives);
                let material = Cow::Owned(proxy.material(&self.primitives, &self.materials));
                (proxy.unit_from_group, Proxy::unit_shape(), material, Some(instance))
            }
        };
        let gradient = hit.gradient(&shape);
        let mut normal = unit_vector(gradient).unwrap_or(DVec3::Z);
        let mut position = hit.unit_point;
        let mut position_error = 4.0 * f64::EPSILON * position.abs().max_element();
        let mut climb = |forward: &DAffine3, inverse: &DAffine3| {
            position_error = error_through(forward, position, position_error);
            position = forward.transform_point3(position);
            normal = unit_vector(inverse.matrix3.transpose() * normal).unwrap_or(normal);
        };
        climb(&inverse_of(&unit_from_group), &unit_from_group);
        if let Some(instance) = instance {
            climb(instance.map().forward(), instance.map().inverse());
        }
        for (group, index) in passed.iter().rev() {
            let map = group.instances[*index as usize].map();
            climb(map.forward(), map.inverse());
        }
        let path = hit.path.clone();
        SurfaceInteraction { position, position_error, normal, leaving: hit.leaving, material, path }
    }

    /// A ray in the space of the unit shape that it hit. Points on the ray keep their t.
    ///
    /// # Panics
    ///
    /// If the hit belongs to another scene.
    pub fn unit_ray(&self, ray: &Ray, hit: &Hit) -> Ray {
        assert!(hit.scene == self.id, "{ForeignHit}");
        ray.through(&self.unit_from_world(&hit.path).0)
    }

    /// The map from the world to the unit shape at the end of a path, and what stands there. The map of an empty path is
    /// NaN.
    pub fn unit_from_world(&self, path: &InstancePath) -> (DAffine3, Target) {
        let (passed, end) = self.groups_along(path);
        let above = group_from_world(&passed);
        match end {
            PathEnd::Leaf(_, leaf) => (leaf.unit_from_group * above, Target::Primitive(leaf.primitive)),
            PathEnd::Proxy(_, instance) => {
                let proxy = instance.group.proxy(&self.primitives);
                (proxy.unit_from_group * *instance.map().inverse() * above, Target::Proxy)
            }
            PathEnd::Nowhere => (DAffine3::NAN, Target::Proxy),
        }
    }

    /// The mean material of the group that a path ends at; the default material for a path that ends at a primitive.
    pub fn proxy_material(&self, path: &InstancePath) -> Material {
        match self.groups_along(path).1 {
            PathEnd::Proxy(_, instance) => {
                instance.group.proxy(&self.primitives).material(&self.primitives, &self.materials)
            }
            PathEnd::Leaf(..) | PathEnd::Nowhere => Material::default(),
        }
    }
}

impl SurfaceInteraction<'_> {
    /// The normal on the side that the ray came from.
    pub fn facing_normal(&self) -> DVec3 {
        if self.leaving { -self.normal } else { self.normal }
    }

    /// A ray without width that starts here.
    pub fn spawn_ray(&self, direction: DVec3) -> TraceRay {
        let side = if self.normal.dot(direction) >= 0.0 { Side::Outward } else { Side::Inward };
        let ray = Ray { origin: self.position, direction, origin_error: self.position_error };
        TraceRay::new(ray).with_start(Some(SurfaceStart { path: self.path.clone(), side }))
    }
}
