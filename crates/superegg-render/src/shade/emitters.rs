//! Shapes that shine, as lights that can be sampled.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::{ImageSampler, SurfacePoint as AreaSample, SurfaceSampler};
use superegg_trace::{CompiledScene, InstancePath};

use crate::camera::sobol::SampleKey;

/// Scenes of more instances are not searched for shapes that shine.
const MOST_INSTANCES: usize = 1 << 17;
/// If more instances shine, none is sampled: paths meet them by chance.
const MOST_EMITTERS: usize = 1 << 10;

/// The instances that shine.
#[derive(Default)]
pub(crate) struct Emitters {
    all: Vec<Emitter>,
    /// The sum of the probabilities of all emitters up to and with each one.
    cumulative: Vec<f64>,
    by_path: HashMap<InstancePath, usize, RandomState>,
}

struct Emitter {
    path: InstancePath,
    /// Points that are spread evenly over the area in the world.
    sampler: ImageSampler,
    /// The probability density of a sample, for each unit of area.
    density: f64,
}

/// A sample of an emitter.
pub(crate) struct EmitterSample<'e> {
    pub(crate) path: &'e InstancePath,
    pub(crate) point: DVec3,
    /// The outward unit normal.
    pub(crate) normal: DVec3,
    /// The probability density of the sample, for each unit of area.
    pub(crate) density: f64,
}

/// A sampler and the area that it samples, for images of one shape that differ by a rotation and a translation.
struct Class {
    primitive: u32,
    gram: DMat3,
    sampler: SurfaceSampler,
    area: f64,
}

impl Class {
    fn new(scene: &CompiledScene, primitive: u32, linear: &DMat3) -> Option<Self> {
        let shape = scene.primitive(primitive).unit_shape();
        let area = shape.surface_area_under(linear)?.value;
        let sampler = ImageSampler::class(&shape, linear)?;
        Some(Self { primitive, gram: linear.transpose() * *linear, sampler, area })
    }

    fn has(&self, primitive: u32, linear: &DMat3) -> bool {
        let gram = linear.transpose() * *linear;
        let size = gram.x_axis.x + gram.y_axis.y + gram.z_axis.z;
        primitive == self.primitive && self.gram.abs_diff_eq(gram, 1e-12 * size)
    }
}

impl Emitters {
    /// The emitters of a scene. Each is chosen in proportion to the light that it gives off.
    pub(crate) fn of(scene: &CompiledScene) -> Self {
        let shines = |primitive: u32| scene.material_of(scene.primitive(primitive)).emission > 0.0;
        if !scene.materials().iter().any(|material| material.emission > 0.0) {
            return Self::default();
        }
        let mut placed = scene.placed_primitives(MOST_INSTANCES).unwrap_or_default();
        placed.retain(|placed| shines(placed.primitive));
        if placed.len() > MOST_EMITTERS {
            return Self::default();
        }
        let mut classes: Vec<Class> = Vec::new();
        let mut emitters = Self::default();
        let mut total = 0.0;
        for placed in placed {
            let linear = placed.world_from_unit.matrix3;
            let known = classes.iter().position(|class| class.has(placed.primitive, &linear));
            let class = match known {
                Some(class) => class,
                None => {
                    // A shape whose area is out of range is met by chance.
                    let Some(class) = Class::new(scene, placed.primitive, &linear) else { continue };
                    classes.push(class);
                    classes.len() - 1
                }
            };
            let Class { sampler, area, .. } = &classes[class];
            let Some(sampler) = ImageSampler::of_class(sampler, &placed.world_from_unit, 0) else { continue };
            let material = scene.material_of(scene.primitive(placed.primitive));
            // A little for black shapes, whose pattern may shine.
            let power = area * material.emission * material.color.max_element().max(1e-3);
            if !(power > 0.0 && power.is_finite()) {
                continue;
            }
            total += power;
            emitters.cumulative.push(total);
            emitters.by_path.insert(placed.path.clone(), emitters.all.len());
            emitters.all.push(Emitter { path: placed.path, sampler, density: power / area });
        }
        emitters.cumulative.iter_mut().for_each(|sum| *sum /= total);
        emitters.all.iter_mut().for_each(|emitter| emitter.density /= total);
        emitters
    }

    /// A random point of an emitter; `None` if there are none.
    pub(crate) fn sample(&self, key: SampleKey) -> Option<EmitterSample<'_>> {
        let choice = key.point(0, 1).x;
        let chosen = self.cumulative.partition_point(|&sum| sum <= choice);
        let Emitter { path, sampler, density } = self.all.get(chosen.min(self.all.len().checked_sub(1)?))?;
        let AreaSample { point, normal, .. } = sampler.with_seed(key.bits()).sample();
        Some(EmitterSample { path, point, normal, density: *density })
    }

    /// The probability density of samples of an instance, for each unit of area; 0 if it is not sampled.
    pub(crate) fn density(&self, path: &InstancePath) -> f64 {
        self.by_path.get(path).map_or(0.0, |&index| self.all[index].density)
    }
}
