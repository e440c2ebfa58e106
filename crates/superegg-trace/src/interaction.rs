//! What is asked about a hit, computed when it is asked.

use std::borrow::Cow;

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Ray, error_through, inverse_of, unit_vector};
use superegg_scene::Material;

use crate::compiled::{CompiledScene, PathEnd};
use crate::path::InstancePath;
use crate::stand_in::StandIn;
use crate::traverse::{Departure, Hit, Side};

/// A point of a surface in world space.
#[derive(Clone, Debug)]
pub struct SurfaceInteraction<'a> {
    /// The point, mapped up from the primitive's own space: on the surface to rounding, from however far the ray came.
    pub position: DVec3,
    /// A bound on the rounding error of its coordinates.
    pub position_error: f64,
    /// The unit normal, outwards from the shape.
    pub normal: DVec3,
    /// Whether the ray leaves the shape here.
    pub leaving: bool,
    /// The surface; for a group that stands in as a whole its average.
    pub material: Cow<'a, Material>,
    /// The path of the instance.
    pub path: InstancePath,
}

impl CompiledScene {
    /// The surface at a hit of this scene.
    pub fn interaction(&self, hit: &Hit) -> SurfaceInteraction<'_> {
        let (passed, end) = self.groups_along(&hit.path);
        let (unit_from_group, shape, material, instance) = match end {
            PathEnd::Leaf(_, leaf) => {
                let primitive = &self.primitives[leaf.primitive as usize];
                let material = Cow::Borrowed(&self.materials[primitive.material as usize]);
                (leaf.unit_from_group, primitive.unit_shape(), material, None)
            }
            PathEnd::Nowhere => {
                (DAffine3::IDENTITY, StandIn::unit_shape(), Cow::Owned(Material::default()), None)
            }
            PathEnd::StandIn(_, instance) => {
                let stand_in = instance.group.stand_in(&self.primitives);
                let material = Cow::Owned(stand_in.material(&self.primitives, &self.materials));
                (stand_in.unit_from_group, StandIn::unit_shape(), material, Some(instance))
            }
        };
        let known = Some(hit.unit_gradient).filter(|gradient| *gradient != DVec3::ZERO);
        let gradient = known.unwrap_or_else(|| shape.norm().value_and_gradient(hit.unit_point).1);
        let mut normal = unit_vector(gradient).unwrap_or(DVec3::Z);
        let mut position = hit.unit_point;
        let mut position_error = 4.0 * f64::EPSILON * position.abs().max_element();
        let mut climb = |forward: &DAffine3, inverse: &DAffine3| {
            position_error = error_through(forward, position, position_error);
            position = forward.transform_point3(position);
            normal = unit_vector(inverse.matrix3.transpose() * normal).unwrap_or(normal);
        };
        climb(&inverse_of(&unit_from_group), &unit_from_group);
        let instances = passed.iter().map(|(group, place)| &group.instances[*place as usize]).chain(instance);
        for instance in instances.collect::<Vec<_>>().into_iter().rev() {
            let map = instance.map();
            climb(map.forward(), map.inverse());
        }
        SurfaceInteraction {
            position,
            position_error,
            normal,
            leaving: hit.leaving,
            material,
            path: hit.path.clone(),
        }
    }
}

impl CompiledScene {
    /// A ray in the space of the unit shape that it hit, whose semi-axes are 1. Places on it keep their t.
    pub fn unit_ray(&self, ray: &Ray, hit: &Hit) -> Ray {
        ray.through(&self.unit_from_world(&hit.path).0)
    }
}

impl SurfaceInteraction<'_> {
    /// The normal on the side that the ray came from.
    pub fn facing_normal(&self) -> DVec3 {
        if self.leaving { -self.normal } else { self.normal }
    }

    /// A ray that starts here, with what is known of its start.
    pub fn spawn_ray(&self, direction: DVec3) -> (Ray, Departure) {
        let side = if self.normal.dot(direction) >= 0.0 { Side::Outward } else { Side::Inward };
        let ray = Ray { origin: self.position, direction, origin_error: self.position_error };
        (ray, Departure { path: self.path.clone(), side })
    }
}
