//! Making the level-of-detail proxy of a group.
//!
//! A group much smaller than a pixel is hit as an ellipsoid that fills its bounding box. The ellipsoid's material is the
//! mean of what is seen of the group along the three axes, and its opacity is the part of the light that the group stops.
//! Rays hit the proxy with that probability ([`crate::ray::lottery`]). The normals are those of the ellipsoid: evenly
//! spread, as for a small thing about which nothing else is known.

use std::ops::ControlFlow;

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, Ray, RayReciprocal, RayStart, Superquadric};

use crate::scene::group::Group;
use crate::scene::node::Slot;
use crate::scene::primitive::Primitives;
use crate::scene::proxy::Proxy;
use crate::walk::Visitor;

/// The probing rays along each axis are a grid of this many by this many.
const GRID: u32 = 6;
/// The most primitives in the mean.
const MOST_PRIMITIVES: usize = 16;
/// The part of a box's face that its ellipsoid covers.
const ELLIPSE_IN_BOX: f64 = std::f64::consts::FRAC_PI_4;

impl Group {
    /// The proxy of this group, made at the first call.
    pub(crate) fn proxy(&self, primitives: &Primitives) -> &Proxy {
        self.proxy.get_or_init(|| proxy_of(self, primitives))
    }
}

fn proxy_of(group: &Group, primitives: &Primitives) -> Proxy {
    let half = group.bounds.half_extent().max(DVec3::splat(f64::MIN_POSITIVE));
    let center = group.bounds.center();
    let mut weights: Vec<(u32, f64)> = Vec::new();
    let mut stopped = 0.0;
    for axis in 0..3 {
        for cell in 0..GRID * GRID {
            let across = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID) * 2.0 - 1.0;
            let mut origin = DVec3::splat(-2.0);
            origin[(axis + 1) % 3] = across(cell % GRID);
            origin[(axis + 2) % 3] = across(cell / GRID);
            let ray = Ray::new(center + origin * half, DVec3::AXES[axis] * half[axis]);
            stopped += stopped_light(group, primitives, &ray, &mut weights);
        }
    }
    let rays = f64::from(3 * GRID * GRID);
    weights.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    weights.truncate(MOST_PRIMITIVES);
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    weights.iter_mut().for_each(|(_, weight)| *weight /= total.max(f64::MIN_POSITIVE));
    Proxy {
        unit_from_group: DAffine3::from_mat3_translation(DMat3::from_diagonal(half.recip()), -center / half),
        opacity: (stopped / rays / ELLIPSE_IN_BOX).min(1.0),
        weights,
    }
}

/// Traces a ray through the children of a group; children that are groups are hit as their proxies. Adds to the weight of
/// each primitive the light that it stops, and returns the sum, 0 to 1.
fn stopped_light(group: &Group, primitives: &Primitives, ray: &Ray, weights: &mut Vec<(u32, f64)>) -> f64 {
    let reciprocal = RayReciprocal::from(&ray.through(&group.space.tree_from_group()));
    let mut probe = Probe { group, primitives, ray, reciprocal, hits: Vec::new() };
    // The probe never breaks.
    let _ = group.walk(&mut probe);
    let mut hits = probe.hits;
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut passing = 1.0;
    for (_, slot) in hits {
        let mut add = |primitive: u32, weight: f64| match weights.iter_mut().find(|(of, _)| *of == primitive)
        {
            Some((_, sum)) => *sum += weight,
            None => weights.push((primitive, weight)),
        };
        match slot {
            Slot::Node(_) => {}
            Slot::Leaf(leaf) => {
                add(group.leaves[leaf as usize].primitive, passing);
                return 1.0;
            }
            Slot::Instance(instance) => {
                let inner = group.instances[instance as usize].group.proxy(primitives);
                for &(primitive, weight) in &inner.weights {
                    add(primitive, passing * inner.opacity * weight);
                }
                passing *= 1.0 - inner.opacity;
            }
        }
    }
    1.0 - passing
}

/// All hits of a ray with the children of a group.
struct Probe<'a> {
    group: &'a Group,
    primitives: &'a Primitives,
    ray: &'a Ray,
    reciprocal: RayReciprocal,
    hits: Vec<(f64, Slot)>,
}

impl Probe<'_> {
    fn hit(&mut self, slot: Slot, unit_from_group: &DAffine3, shape: Superquadric) -> ControlFlow<()> {
        let hit = shape.intersect(&self.ray.through(unit_from_group), RayStart::Free);
        self.hits.extend(hit.map(|hit| (hit.t, slot)));
        ControlFlow::Continue(())
    }
}

impl Visitor for Probe<'_> {
    const IS_ORDERED: bool = false;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        bounds.clip(&self.reciprocal, f64::INFINITY)
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        let leaf = &self.group.leaves[index as usize];
        let shape = self.primitives.unit_shape(leaf.primitive);
        self.hit(Slot::Leaf(index), &leaf.unit_from_group, shape)
    }

    fn instance(&mut self, index: u32, _: f64) -> ControlFlow<()> {
        let instance = &self.group.instances[index as usize];
        let proxy = instance.group.proxy(self.primitives);
        let unit_from_group = proxy.unit_from_group * *instance.map().inverse();
        self.hit(Slot::Instance(index), &unit_from_group, Proxy::unit_shape())
    }
}
