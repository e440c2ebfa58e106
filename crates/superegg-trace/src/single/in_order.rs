//! One ray through groups that overlap: nearest first, with bounded work.
//!
//! The depth-first traversal opens a group with all that is in it before the next one. Where the parts of a deep fractal
//! overlap that takes time without end, although the ray is stopped early. Here all parts wait in one queue in the order of
//! the ray.

use std::collections::BinaryHeap;

use superegg_geom::Ray;

use super::traversal::{Bound, BoxTest, Traversal};
use crate::ranked::Ranked;
use crate::scene::group::Group;
use crate::scene::node::Slot;

/// An opened group.
struct Opened<'s> {
    group: &'s Group,
    /// The ray in the group's space.
    ray: Ray,
    /// An upper bound on the factor from lengths of the group to the world's.
    stretch: f64,
    /// The opened group above, and the index of this one there; `None` for the root.
    above: Option<(u32, u32)>,
}

/// A child that waits. The nearest is next, and of equally near ones that which arrived last: the origin is in their boxes.
struct Waiting {
    /// A lower bound on the t at which the ray reaches the child.
    near: f64,
    /// The index among the opened groups.
    opened: u32,
    slot: Slot,
}

/// The children that wait.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Ranked<u64, Waiting>>,
    /// The number of arrivals.
    arrived: u64,
}

impl Queue {
    fn push(&mut self, waiting: Waiting) {
        self.arrived += 1;
        self.heap.push(Ranked { priority: -waiting.near, rank: self.arrived, item: waiting });
    }

    fn pop(&mut self) -> Option<Waiting> {
        self.heap.pop().map(|ranked| ranked.item)
    }
}

impl Traversal<'_> {
    /// Traces the ray in the order of t.
    pub(super) fn run_in_order(&mut self, root: &Group, ray: &Ray) {
        let scene_size = self.scene.size();
        let mut opened = vec![Opened { group: root, ray: *ray, stretch: 1.0, above: None }];
        let mut waiting = Queue::default();
        let begin = self.visited;
        waiting.push(Waiting { near: 0.0, opened: 0, slot: Slot::Node(0) });
        while let Some(next) = waiting.pop() {
            if next.near > self.t_max || self.is_over() || self.is_occluded {
                return;
            }
            let Opened { group, ray, stretch, .. } = opened[next.opened as usize];
            match next.slot {
                Slot::Node(node) => {
                    let boxes = BoxTest::new(group, &ray);
                    for (bounds, slot) in group.nodes[node as usize].children() {
                        self.visited += 1;
                        let Some(near) = boxes.clip(&bounds, self.t_max) else { continue };
                        waiting.push(Waiting { near, opened: next.opened, slot });
                    }
                }
                Slot::Leaf(index) => {
                    self.set_path(&opened, next.opened);
                    self.visit_leaf(group, index, &ray);
                }
                Slot::Instance(index) => {
                    let instance = &group.instances[index as usize];
                    let stretch = stretch * instance.stretch;
                    let size = instance.size() * stretch;
                    let footprint = self.footprint.doubled(self.doublings(begin), scene_size);
                    if footprint.hides(size, next.near) {
                        self.is_coarsened |= !self.footprint.hides(size, next.near);
                        self.set_path(&opened, next.opened);
                        self.visit_proxy(instance, index, &ray);
                        continue;
                    }
                    let above = Some((next.opened, index));
                    let ray = ray.to_local(instance.map());
                    let child = opened.len() as u32;
                    opened.push(Opened { group: &instance.group, ray, stretch, above });
                    waiting.push(Waiting { opened: child, slot: Slot::Node(0), ..next });
                }
            }
        }
    }

    /// How often the width of the ray is doubled by now: after twice as many boxes as the depth-first traversal may test,
    /// and again for each quarter of those.
    fn doublings(&self, begin: u64) -> u32 {
        let is_exact = match self.bound {
            Bound::None | Bound::Boxes(_) => true,
            Bound::Proxies => false,
        };
        match (self.visited - begin).checked_sub(2 * self.most_boxes()) {
            Some(beyond) if !is_exact => (4 * beyond / self.most_boxes()) as u32 + 1,
            _ => 0,
        }
    }

    fn set_path(&mut self, opened: &[Opened<'_>], last: u32) {
        let mut indices = Vec::new();
        let mut at = &opened[last as usize];
        while let Some((above, index)) = at.above {
            indices.push(index);
            at = &opened[above as usize];
        }
        self.path.clear();
        indices.into_iter().rev().for_each(|index| self.path.push(index));
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;
    use superegg_lang::load_text;

    use super::*;
    use crate::ray::footprint::Footprint;
    use crate::ray::limits::RayLimits;
    use crate::ray::query::TraceRay;
    use crate::scene::compiled::CompiledScene;

    /// A cluster of overlapping copies of itself.
    fn cluster(depth: u32) -> CompiledScene {
        let text = "prm ball\nexp 1 .4\ncoeff .2 .3 .1\nprm star\nexp 3 2.5\ncoeff .3 .2 .3\n\
            obj all\nap ball\nap star\nxs .3 .2 .1\nao all a\nrs 1 2 3 40\nss .8 .8 .8\nxs .3 0 0\n\
            ao all b\nrs 2 1 0 70\nss .8 .7 -.8\nxs -.3 .2 0\nao all c\nss .6 .6 .6\nxs 0 -.9 .4\n";
        let (session, diagnostics) = load_text("cluster.scn", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        CompiledScene::compile(session.scene(), Some("all"), depth)
    }

    fn rays() -> impl Iterator<Item = TraceRay> {
        (0..2_000).map(|i| {
            let a = f64::from(i);
            let origin = DVec3::new((1.3 * a).sin(), (0.7 * a).cos(), (2.9 * a).sin()) * 1.5;
            let direction = DVec3::new((2.1 * a).cos(), (1.1 * a).sin(), (0.37 * a).cos());
            TraceRay::new(Ray::new(origin, direction))
        })
    }

    #[test]
    fn rays_in_order_hit_what_rays_hit_depth_first() {
        let scene = cluster(6);
        let limits = RayLimits::default();
        let mut hits = 0;
        for ray in rays() {
            let expected = scene.intersect(&ray);
            let (mut in_order, scaled, scale) = Traversal::closest(&scene, &ray).unwrap();
            in_order.run_in_order(scene.root.as_deref().unwrap(), &scaled);
            assert_eq!(
                in_order.best.map(|hit| (hit.t * scale, hit.path)),
                expected.clone().map(|hit| (hit.t, hit.path))
            );
            assert_eq!(scene.intersect_within(&ray, &limits), Ok(expected.clone()));
            hits += usize::from(expected.is_some());
            let mut any_hit = Traversal::any_hit(&scene, &ray, 0.8);
            any_hit.run_in_order(scene.root.as_deref().unwrap(), &ray.ray);
            assert_eq!(any_hit.is_occluded, scene.occluded(&ray, 0.8));
        }
        assert!(hits > 100, "{hits}");
    }

    #[test]
    fn the_work_for_one_ray_is_bounded() {
        let scene = cluster(40);
        let narrow = Footprint { width: 1e-4, spread: 0.0 };
        let limits = RayLimits::default().with_boxes(20_000);
        let mut errors = 0;
        for ray in rays().take(60) {
            match scene.intersect_within(&ray, &limits) {
                Err(error) => {
                    errors += 1;
                    assert!(error.to_string().contains("20000 boxes"), "{error}");
                }
                // An answer within the limits is the exact one.
                Ok(hit) => assert!(hit.is_none_or(|hit| !hit.path.is_proxy())),
            }
            let with_width = ray.with_footprint(narrow);
            assert!(scene.visited(&with_width) < 60_000, "{}", scene.visited(&with_width));
            scene.occluded(&with_width, 1.0);
        }
        assert!(errors > 0, "{errors}");
    }
}
