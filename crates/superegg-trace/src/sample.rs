//! Points spread evenly over the surfaces of a scene, by area.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use rayon::prelude::*;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{ImageSampler, SplitMix, SurfaceArea, SurfaceSampler};

use crate::instances::PlacedPrimitive;
use crate::point::PointLimits;
use crate::scene::compiled::CompiledScene;
use crate::scene::path::InstancePath;

/// A point of a surface of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ScenePoint {
    /// The point, in world space.
    pub point: DVec3,
    /// The outward unit normal.
    pub normal: DVec3,
    /// The index of its instance among [`SceneSurfaces::instances`].
    pub instance: usize,
}

/// The surfaces of all instances of a scene, with their areas.
pub struct SceneSurfaces<'a> {
    scene: &'a CompiledScene,
    instances: Vec<PlacedPrimitive>,
    areas: Vec<SurfaceArea>,
    /// The class of each instance: those of one class are similar.
    class_of: Vec<usize>,
    /// An instance of each class.
    examples: Vec<usize>,
}

/// Similar images of a shape: its exponents, and the Gram matrix of the map, in units of its longest column and
/// to 44 binary digits.
#[derive(PartialEq, Eq, Hash)]
struct ClassKey {
    exponents: [u64; 2],
    gram: [i64; 6],
}

impl ClassKey {
    fn of(scene: &CompiledScene, placed: &PlacedPrimitive) -> Self {
        let exponents = scene.primitive(placed.primitive).exponents;
        let linear = placed.world_from_unit.matrix3;
        let scaled = linear * (1.0 / longest_column(&linear));
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = scaled;
        let products = [x.dot(x), y.dot(y), z.dot(z), x.dot(y), y.dot(z), z.dot(x)];
        let rounded = |product: f64| (product * 2f64.powi(44)).round() as i64;
        Self { exponents: [exponents.e().to_bits(), exponents.n().to_bits()], gram: products.map(rounded) }
    }
}

fn longest_column(linear: &DMat3) -> f64 {
    linear.x_axis.length().max(linear.y_axis.length()).max(linear.z_axis.length())
}

impl<'a> SceneSurfaces<'a> {
    /// The surfaces of a scene's instances; `None` if there are more than `most`.
    ///
    /// An area takes about a millisecond, and is computed once for instances that are similar.
    pub fn of(scene: &'a CompiledScene, most: usize) -> Option<Self> {
        scene.placed_primitives(most).map(|instances| Self::of_instances(scene, instances))
    }

    /// The surfaces of some instances of a scene.
    pub fn of_instances(scene: &'a CompiledScene, instances: Vec<PlacedPrimitive>) -> Self {
        let mut classes: HashMap<ClassKey, usize, RandomState> = HashMap::default();
        let mut examples = Vec::new();
        let mut class_of = Vec::with_capacity(instances.len());
        for (i, placed) in instances.iter().enumerate() {
            let class = *classes.entry(ClassKey::of(scene, placed)).or_insert_with(|| {
                examples.push(i);
                examples.len() - 1
            });
            class_of.push(class);
        }
        let unit_area = |&example: &usize| {
            let placed = &instances[example];
            let linear = placed.world_from_unit.matrix3;
            let scaled = linear * (1.0 / longest_column(&linear));
            scene.primitive(placed.primitive).unit_shape().surface_area_under(&scaled)
        };
        let unit_areas: Vec<Option<SurfaceArea>> = examples.par_iter().map(unit_area).collect();
        let area_of = |(placed, &class): (&PlacedPrimitive, &usize)| {
            let scale = longest_column(&placed.world_from_unit.matrix3);
            unit_areas[class].map(|area| area.scaled(scale))
        };
        // An image whose area is out of range has none.
        let areas = instances.iter().zip(&class_of).map(|pair| area_of(pair).unwrap_or_default()).collect();
        Self { scene, instances, areas, class_of, examples }
    }

    /// The instances, in the order of children.
    pub fn instances(&self) -> &[PlacedPrimitive] {
        &self.instances
    }

    /// The area of each instance, with its error.
    pub fn areas(&self) -> &[SurfaceArea] {
        &self.areas
    }

    /// The sum of all areas.
    pub fn total_area(&self) -> f64 {
        self.areas.iter().map(|area| area.value).sum()
    }

    /// `count` points spread evenly over all surfaces by area, in the order of instances. The same scene, count and seed
    /// give the same points. Empty for a scene without area.
    ///
    /// The number of points of an instance is its part of the area, rounded up or down at random (systematic sampling);
    /// within an instance the points are independent.
    pub fn sample(&self, count: usize, seed: u64) -> Vec<ScenePoint> {
        let areas: Vec<f64> = self.areas.iter().map(|area| area.value).collect();
        let mut random = SplitMix::new(seed);
        let shares = systematic_shares(&areas, count, &mut random);
        let seeds: Vec<u64> = shares.iter().map(|_| random.bits()).collect();
        let mut is_used = vec![false; self.examples.len()];
        shares.iter().for_each(|&(instance, _)| is_used[self.class_of[instance]] = true);
        let samplers = self.class_samplers(&is_used);
        let points_of = |(&(instance, count), &seed): (&(usize, usize), &u64)| -> Vec<ScenePoint> {
            let map: &DAffine3 = &self.instances[instance].world_from_unit;
            let class = samplers[self.class_of[instance]].as_ref();
            let sampler = class.and_then(|class| ImageSampler::of_class(class, map, seed));
            let points = sampler.into_iter().flatten().take(count);
            points.map(|sample| ScenePoint { point: sample.point, normal: sample.normal, instance }).collect()
        };
        shares.par_iter().zip(&seeds).flat_map_iter(points_of).collect()
    }

    /// An endless sequence of points of each instance, spread evenly over its area; `None` for an image that is out of
    /// range.
    pub fn samplers(&self) -> Vec<Option<ImageSampler>> {
        let classes = self.class_samplers(&vec![true; self.examples.len()]);
        let sampler = |(placed, &class): (&PlacedPrimitive, &usize)| {
            ImageSampler::of_class(classes[class].as_ref()?, &placed.world_from_unit, 0)
        };
        self.instances.iter().zip(&self.class_of).map(sampler).collect()
    }

    /// The part that the instances of each used class share.
    fn class_samplers(&self, is_used: &[bool]) -> Vec<Option<SurfaceSampler>> {
        let sampler = |(&example, &is_used): (&usize, &bool)| {
            let placed = &self.instances[example];
            let shape = self.scene.primitive(placed.primitive).unit_shape();
            is_used.then(|| ImageSampler::class(&shape, &placed.world_from_unit.matrix3)).flatten()
        };
        self.examples.par_iter().zip(is_used).map(sampler).collect()
    }

    /// Whether a point of a surface is inside another primitive.
    ///
    /// A point is on the surface of another one, and not inside it, if its inside-outside value is above -1e-9.
    pub fn is_covered(&self, point: &ScenePoint, limits: &PointLimits) -> bool {
        let own: &InstancePath = &self.instances[point.instance].path;
        let (holders, _) = self.scene.primitives_holding(point.point, MOST_HOLDERS, limits);
        holders.iter().any(|holder| holder.value < -1e-9 && holder.path != *own)
    }
}

/// The most holders of a point that are looked at.
const MOST_HOLDERS: usize = 1000;

/// Divides `count` points among parts in proportion to their weights: (part, number) for each part that gets any.
pub(crate) fn systematic_shares(weights: &[f64], count: usize, random: &mut SplitMix) -> Vec<(usize, usize)> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let offset = random.unit();
    let (mut sum, mut given) = (0.0, 0);
    let mut shares = Vec::new();
    for (part, &weight) in weights.iter().enumerate() {
        sum += weight;
        // The number of the points offset + 0, 1, ... below the sum, in units of total / count.
        let below = (sum / total * count as f64 - offset).ceil().clamp(given as f64, count as f64) as usize;
        if below > given {
            shares.push((part, below - given));
            given = below;
        }
    }
    if let Some((_, last)) = shares.last_mut() {
        // Rounding of the sum.
        *last += count - given;
    }
    shares
}
