//! Groups of points on the same side of one surface.

use std::collections::HashMap;
use std::ops::Range;
use std::rc::Rc;

use foldhash::fast::RandomState;

use crate::shade::point::{SurfaceOwner, SurfacePoint};

/// The most points of a group. Neighbours in the order of points are neighbours in the picture.
const MOST_POINTS: usize = 32;

/// Points by the surfaces that they lie on, in groups of neighbours.
#[derive(Debug, Default)]
pub(crate) struct PointGroups {
    /// The indices of the points, one group after the other.
    order: Vec<usize>,
    groups: Vec<Range<usize>>,
    /// The points that belong to no group.
    single: Vec<usize>,
}

impl PointGroups {
    /// Groups the points for which `is_groupable` holds. The order of groups is that of their surfaces' first points.
    pub(crate) fn of(points: &[SurfacePoint<'_>], is_groupable: impl Fn(&SurfacePoint<'_>) -> bool) -> Self {
        let mut surfaces: HashMap<(*const (), bool), usize, RandomState> = HashMap::default();
        let (mut by_surface, mut single) = (Vec::<Vec<usize>>::new(), Vec::new());
        let mut last = None;
        for (index, point) in points.iter().enumerate() {
            if !is_groupable(point) {
                single.push(index);
                continue;
            }
            // One path has one pointer in all points, but for surfaces that were forgotten in between.
            let owner = match &point.owner {
                SurfaceOwner::Instance(path) => Rc::as_ptr(path).cast(),
                SurfaceOwner::Floor => std::ptr::null(),
            };
            let key = (owner, point.leaving);
            let surface = match last {
                Some((last_key, surface)) if last_key == key => surface,
                _ => *surfaces.entry(key).or_insert_with(|| {
                    by_surface.push(Vec::new());
                    by_surface.len() - 1
                }),
            };
            last = Some((key, surface));
            by_surface[surface].push(index);
        }
        let (mut order, mut groups) = (Vec::with_capacity(points.len()), Vec::new());
        for group in by_surface.iter().flat_map(|indices| indices.chunks(MOST_POINTS)) {
            groups.push(order.len()..order.len() + group.len());
            order.extend_from_slice(group);
        }
        Self { order, groups, single }
    }

    /// The number of groups.
    pub(crate) fn len(&self) -> usize {
        self.groups.len()
    }

    /// The indices of the points of a group: at least one.
    pub(crate) fn get(&self, group: usize) -> &[usize] {
        &self.order[self.groups[group].clone()]
    }

    /// The points that belong to no group.
    pub(crate) fn single(&self) -> &[usize] {
        &self.single
    }
}
