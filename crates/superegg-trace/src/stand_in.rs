//! What is seen instead of a group that is too small to be opened.
//!
//! A group whose box is smaller than a stated part of a pixel stands in by an ellipsoid in its box with the group's average look: the mean material of
//! what is seen of it along the axes, and the mean share of light that it stops. Rays meet it with that probability, decided by a hash, so that the
//! same picture comes out always. Its normals are those of the ellipsoid: spread as evenly as those of a small thing of which nothing else is known.

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, Exponents, Ray, RayReciprocal, RayStart, Superquadric};
use superegg_scene::Material;

use crate::bvh::Slot;
use crate::compiled::{CompiledPrimitive, CompiledScene, Group, PathEnd};
use crate::path::InstancePath;

/// The average of a group.
#[derive(Clone, Debug)]
pub(crate) struct StandIn {
    /// From the group's space to that in which the ellipsoid is the unit sphere.
    pub(crate) unit_from_group: DAffine3,
    /// The share of rays through the ellipsoid that it stops.
    pub(crate) opacity: f64,
    /// What is seen: primitives with their shares, which are 1 together.
    shares: Vec<(u32, f64)>,
}

/// Rays along each axis, in each of two directions across.
const GRID: u32 = 6;
/// At most so many primitives make the average.
const MOST_SHARES: usize = 16;
/// The part of a box's face that its ellipsoid covers.
const ELLIPSE_IN_BOX: f64 = std::f64::consts::FRAC_PI_4;

impl Group {
    /// What is seen instead of this group from afar. Made when it is first asked for.
    pub(crate) fn stand_in(&self, primitives: &[CompiledPrimitive]) -> &StandIn {
        self.stand_in.get_or_init(|| StandIn::of(self, primitives))
    }
}

impl CompiledScene {
    /// The average look of the group that a path ends in.
    pub fn stand_in_material(&self, path: &InstancePath) -> Material {
        match self.groups_along(path).1 {
            PathEnd::StandIn(_, instance) => {
                instance.group.stand_in(&self.primitives).material(&self.primitives, &self.materials)
            }
            _ => Material::default(),
        }
    }
}

impl StandIn {
    fn of(group: &Group, primitives: &[CompiledPrimitive]) -> Self {
        let half = group.bounds.half_extent().max(DVec3::splat(f64::MIN_POSITIVE));
        let center = group.bounds.center();
        let mut shares: Vec<(u32, f64)> = Vec::new();
        let mut stopped = 0.0;
        for axis in 0..3 {
            for cell in 0..GRID * GRID {
                let along = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID) * 2.0 - 1.0;
                let mut place = DVec3::splat(-2.0);
                place[(axis + 1) % 3] = along(cell % GRID);
                place[(axis + 2) % 3] = along(cell / GRID);
                let ray = Ray::new(center + place * half, DVec3::AXES[axis] * half[axis]);
                stopped += look(group, primitives, &ray, &mut shares);
            }
        }
        let rays = f64::from(3 * GRID * GRID);
        shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        shares.truncate(MOST_SHARES);
        let total: f64 = shares.iter().map(|(_, share)| share).sum();
        shares.iter_mut().for_each(|(_, share)| *share /= total.max(f64::MIN_POSITIVE));
        Self {
            unit_from_group: DAffine3::from_mat3_translation(
                DMat3::from_diagonal(half.recip()),
                -center / half,
            ),
            opacity: (stopped / rays / ELLIPSE_IN_BOX).min(1.0),
            shares,
        }
    }

    /// The unit sphere, whose image is the ellipsoid.
    pub(crate) fn unit_shape() -> Superquadric {
        Superquadric::unit(Exponents::ROUND)
    }

    /// The primitive of which most is seen.
    pub(crate) fn main_primitive(&self) -> u32 {
        self.shares.first().map_or(0, |share| share.0)
    }

    /// The mean of what is seen; nothing of it mirrors or lets light through.
    pub(crate) fn material(&self, primitives: &[CompiledPrimitive], materials: &[Material]) -> Material {
        let nothing = Material {
            color: DVec3::ZERO,
            ambient: 0.0,
            gloss: 0.0,
            diffuse: 0.0,
            specular: 0.0,
            ..Material::default()
        };
        self.shares.iter().fold(nothing, |mut mean, &(primitive, share)| {
            let seen = &materials[primitives[primitive as usize].material as usize];
            mean.color += share * seen.color;
            mean.ambient += share * seen.ambient;
            mean.gloss += share * seen.gloss;
            mean.diffuse += share * seen.diffuse;
            mean.specular += share * seen.specular;
            mean
        })
    }
}

/// Follows a ray through the children of a group, groups among them by their own stand-ins. Adds what is seen to the shares, and returns the part
/// of the light that was stopped.
fn look(group: &Group, primitives: &[CompiledPrimitive], ray: &Ray, shares: &mut Vec<(u32, f64)>) -> f64 {
    let mut met: Vec<(f64, Slot)> = Vec::new();
    let reciprocal = RayReciprocal::from(&ray.through(&group.space.tree_from_group()));
    let mut pending = vec![0];
    while let Some(node) = pending.pop() {
        let node = &group.nodes[node as usize];
        for (place, slot) in node.slots().enumerate() {
            let child: Aabb = node.child_box(place);
            if child.clip(&reciprocal, f64::INFINITY).is_none() {
                continue;
            }
            let hit = |map: &DAffine3, shape: Superquadric| {
                shape.intersect(&ray.through(map), RayStart::Free).map(|hit| (hit.t, slot))
            };
            match slot {
                Slot::Node(child) => pending.push(child),
                Slot::Leaf(leaf) => {
                    let leaf = &group.leaves[leaf as usize];
                    met.extend(hit(&leaf.unit_from_group, primitives[leaf.primitive as usize].unit_shape()));
                }
                Slot::Instance(instance) => {
                    let instance = &group.instances[instance as usize];
                    let inner = instance.group.stand_in(primitives);
                    let map = inner.unit_from_group * *instance.parent_from_child.inverse();
                    met.extend(hit(&map, StandIn::unit_shape()));
                }
            }
        }
    }
    met.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut let_through = 1.0;
    for (_, slot) in met {
        let mut see = |primitive: u32, weight: f64| match shares.iter_mut().find(|share| share.0 == primitive)
        {
            Some(share) => share.1 += weight,
            None => shares.push((primitive, weight)),
        };
        match slot {
            Slot::Node(_) => {}
            Slot::Leaf(leaf) => {
                see(group.leaves[leaf as usize].primitive, let_through);
                return 1.0;
            }
            Slot::Instance(instance) => {
                let inner = group.instances[instance as usize].group.stand_in(primitives);
                inner
                    .shares
                    .iter()
                    .for_each(|&(primitive, share)| see(primitive, let_through * inner.opacity * share));
                let_through *= 1.0 - inner.opacity;
            }
        }
    }
    1.0 - let_through
}
