//! Groups of points: those that neighbours join, and halves.

use std::collections::HashMap;

use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::symmetric_eigen;

/// The groups of points (by index) that steps of at most `reach` along the axes join, the largest first.
pub(super) fn joined(points: &[DVec3], members: &[usize], reach: f64) -> Vec<Vec<usize>> {
    let cell = |index: usize| (points[index] / reach).floor().as_i64vec3().to_array();
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut order = Vec::new();
    for &index in members {
        let entry = cells.entry(cell(index)).or_default();
        if entry.is_empty() {
            order.push(cell(index));
        }
        entry.push(index);
    }
    let mut groups = Vec::new();
    for first in order {
        let Some(start) = cells.remove(&first) else { continue };
        let (mut group, mut open) = (start, vec![first]);
        while let Some([x, y, z]) = open.pop() {
            for dx in -1..=1 {
                for dy in -1..=1 {
                    for dz in -1..=1 {
                        let next = [x + dx, y + dy, z + dz];
                        if let Some(found) = cells.remove(&next) {
                            group.extend(found);
                            open.push(next);
                        }
                    }
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    groups
}

/// Steps to two means.
const STEPS: usize = 20;

/// Two halves of a group: two means, from the ends of its longest axis.
pub(super) fn halves(points: &[DVec3], members: &[usize]) -> [Vec<usize>; 2] {
    let mean = |members: &[usize]| {
        members.iter().map(|&index| points[index]).sum::<DVec3>() / members.len().max(1) as f64
    };
    let middle = mean(members);
    let mut scatter = DMat3::ZERO;
    for &index in members {
        let off = points[index] - middle;
        scatter += DMat3::from_cols(off * off.x, off * off.y, off * off.z);
    }
    let (values, vectors) = symmetric_eigen(scatter.to_cols_array_2d());
    let longest = (0..3).fold(0, |best, axis| if values[axis] > values[best] { axis } else { best });
    let along = DVec3::from_array(vectors[longest]);
    let mut halves: [Vec<usize>; 2] =
        members.iter().partition(|&&index| (points[index] - middle).dot(along) < 0.0).into();
    for _ in 0..STEPS {
        let [first, second] = [mean(&halves[0]), mean(&halves[1])];
        let is_first = |index: &&usize| {
            points[**index].distance_squared(first) < points[**index].distance_squared(second)
        };
        let next: [Vec<usize>; 2] = members.iter().partition(is_first).into();
        if next == halves {
            break;
        }
        halves = next;
    }
    halves
}
