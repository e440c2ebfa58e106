//! The surfaces of instances, each prepared once for many hits.

use std::collections::HashMap;
use std::rc::Rc;

use foldhash::fast::RandomState;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Superquadric, error_through, inverse_of, unit_vector};
use superegg_trace::{CompiledScene, Hit, InstancePath, Target};

use crate::shade::point::MaterialRef;

/// The surface of an instance or a proxy.
pub(crate) struct Surface<'a> {
    pub(crate) world_from_unit: DAffine3,
    /// Maps gradients of the unit shape to world normals.
    pub(crate) normal_map: DMat3,
    pub(crate) shape: Superquadric,
    pub(crate) material: MaterialRef<'a>,
    /// The index of the primitive; `None` for a proxy.
    pub(crate) primitive: Option<u32>,
    pub(crate) path: Rc<InstancePath>,
}

/// The prepared surfaces of a thread.
pub(crate) struct Surfaces<'a> {
    scene: &'a CompiledScene,
    by_path: HashMap<InstancePath, Rc<Surface<'a>>, RandomState>,
    /// The surface of the last hit. Neighbouring rays often hit one instance.
    last: Option<Rc<Surface<'a>>>,
}

/// More surfaces than this are forgotten: fractals have any number.
const MOST_SURFACES: usize = 1 << 12;

impl<'a> Surfaces<'a> {
    pub(crate) fn new(scene: &'a CompiledScene) -> Self {
        Self { scene, by_path: HashMap::default(), last: None }
    }

    /// The surface at a hit.
    pub(crate) fn at(&mut self, hit: &Hit) -> Rc<Surface<'a>> {
        let Self { scene, by_path, last } = self;
        if let Some(last) = last.as_ref().filter(|last| *last.path == hit.path) {
            return last.clone();
        }
        let found = by_path.get(&hit.path).cloned();
        let surface = found.unwrap_or_else(|| {
            if by_path.len() >= MOST_SURFACES {
                by_path.clear();
            }
            let surface = Rc::new(Surface::of(scene, &hit.path));
            by_path.insert(hit.path.clone(), surface.clone());
            surface
        });
        *last = Some(surface.clone());
        surface
    }
}

/// A point of a surface in the world.
pub(crate) struct Located {
    pub(crate) position: DVec3,
    /// A bound on the rounding error of each coordinate.
    pub(crate) position_error: f64,
    /// The outward unit normal.
    pub(crate) normal: DVec3,
}

impl Located {
    /// A point of a unit shape in the world, with the gradient of N there. `normal_map` maps gradients to world normals.
    pub(crate) fn of(
        world_from_unit: &DAffine3,
        normal_map: &DMat3,
        unit_point: DVec3,
        gradient: DVec3,
    ) -> Self {
        let unit_error = 4.0 * f64::EPSILON * unit_point.abs().max_element();
        Self {
            position: world_from_unit.transform_point3(unit_point),
            // Doubled for the rounding error of the map itself.
            position_error: 2.0 * error_through(world_from_unit, unit_point, unit_error),
            normal: unit_vector(*normal_map * gradient).unwrap_or(DVec3::Z),
        }
    }
}

impl<'a> Surface<'a> {
    /// The point of a hit.
    pub(crate) fn locate(&self, hit: &Hit) -> Located {
        Located::of(&self.world_from_unit, &self.normal_map, hit.unit_point, hit.gradient(&self.shape))
    }

    fn of(scene: &'a CompiledScene, path: &InstancePath) -> Self {
        let (unit_from_world, target) = scene.unit_from_world(path);
        let (shape, material, primitive) = match target {
            Target::Primitive(index) => {
                let primitive = scene.primitive(index);
                let material = MaterialRef::Scene(scene.material_of(&primitive));
                (primitive.unit_shape(), material, Some(index))
            }
            Target::Proxy => {
                let material = MaterialRef::Mean(Rc::new(scene.proxy_material(path)));
                (Superquadric::unit_sphere(), material, None)
            }
        };
        Self {
            world_from_unit: inverse_of(&unit_from_world),
            normal_map: unit_from_world.matrix3.transpose(),
            shape,
            material,
            primitive,
            path: Rc::new(path.clone()),
        }
    }
}
