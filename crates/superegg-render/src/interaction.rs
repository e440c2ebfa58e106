//! What is asked about a hit, computed when it is asked.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, Transform, unit_vector};
use superegg_scene::Material;

use crate::compiled::CompiledScene;
use crate::path::InstancePath;
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
    /// The surface.
    pub material: &'a Material,
    path: InstancePath,
}

impl CompiledScene {
    /// The surface at a hit.
    pub fn interaction(&self, hit: &Hit) -> SurfaceInteraction<'_> {
        let primitive = &self.primitives[hit.primitive as usize];
        let mut position = hit.local_point;
        let mut position_error = 4.0 * f64::EPSILON * position.abs().max_element();
        let mut normal = primitive.shape.normal(position);
        let levels: Vec<&Transform> = self.transforms(&hit.path).collect();
        for transform in levels.into_iter().rev() {
            position_error = transform.world_error(position, position_error);
            position = transform.forward().transform_point3(position);
            normal = unit_vector(transform.normal_to_world(normal)).unwrap_or(normal);
        }
        SurfaceInteraction {
            position,
            position_error,
            normal,
            leaving: hit.leaving,
            material: &primitive.material,
            path: hit.path.clone(),
        }
    }
}

impl CompiledScene {
    /// A ray in the own space of the primitive that it hit. Places on it keep their t.
    pub fn local_ray(&self, ray: &Ray, hit: &Hit) -> Ray {
        self.transforms(&hit.path).fold(*ray, |ray, parent_from_child| ray.to_local(parent_from_child))
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
