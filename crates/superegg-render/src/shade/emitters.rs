//! Shapes that shine, as lights that can be sampled.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use superegg_geom::glam::DVec3;
use superegg_geom::{ImageSampler, SurfacePoint as AreaSample};
use superegg_trace::{CompiledScene, InstancePath, SceneSurfaces};

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
    centre: DVec3,
    /// The probability density of a sample, for each unit of area that faces the point for which it is drawn.
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

impl Emitters {
    /// The emitters of a scene. Each is chosen in proportion to the light that it gives off.
    pub(crate) fn of(scene: &CompiledScene) -> Self {
        let shines = |primitive: u32| scene.material_of(&scene.primitive(primitive)).emission > 0.0;
        if !scene.materials().iter().any(|material| material.emission > 0.0) {
            return Self::default();
        }
        let mut placed = scene.placed_primitives(MOST_INSTANCES).unwrap_or_default();
        placed.retain(|placed| shines(placed.primitive));
        if placed.len() > MOST_EMITTERS {
            return Self::default();
        }
        let surfaces = SceneSurfaces::of_instances(scene, placed);
        let (mut emitters, mut total) = (Self::default(), 0.0);
        let areas = surfaces.areas().iter().map(|area| area.value);
        for ((placed, area), sampler) in surfaces.instances().iter().zip(areas).zip(surfaces.samplers()) {
            // A shape whose area is out of range is met by chance.
            let Some(sampler) = sampler else { continue };
            let material = scene.material_of(&scene.primitive(placed.primitive));
            // A little for black shapes, whose pattern may shine.
            let power = area * material.emission * material.color.max_element().max(1e-3);
            if !(power > 0.0 && power.is_finite()) {
                continue;
            }
            total += power;
            emitters.cumulative.push(total);
            emitters.by_path.insert(placed.path.clone(), emitters.all.len());
            let centre = placed.world_from_unit.translation;
            // Each sample stands for its mirror image through the centre, too.
            let density = 2.0 * power / area;
            emitters.all.push(Emitter { path: placed.path.clone(), sampler, centre, density });
        }
        emitters.cumulative.iter_mut().for_each(|sum| *sum /= total);
        emitters.all.iter_mut().for_each(|emitter| emitter.density /= total);
        emitters
    }

    /// A random point of an emitter that faces a point, if one of a pair of opposite points does: every shape is symmetric
    /// about its centre. `None` if there are no emitters.
    pub(crate) fn sample(&self, key: SampleKey, from: DVec3) -> Option<EmitterSample<'_>> {
        let choice = key.point(0, 1).x;
        let chosen = self.cumulative.partition_point(|&sum| sum <= choice);
        let emitter = self.all.get(chosen.min(self.all.len().checked_sub(1)?))?;
        let Emitter { path, sampler, centre, density } = emitter;
        let AreaSample { mut point, mut normal, .. } = sampler.with_seed(key.bits()).sample();
        if normal.dot(from - point) < 0.0 {
            (point, normal) = (2.0 * *centre - point, -normal);
        }
        Some(EmitterSample { path, point, normal, density: *density })
    }

    /// The probability density of samples of an instance, for each unit of area; 0 if it is not sampled.
    pub(crate) fn density(&self, path: &InstancePath) -> f64 {
        self.by_path.get(path).map_or(0.0, |&index| self.all[index].density)
    }
}
