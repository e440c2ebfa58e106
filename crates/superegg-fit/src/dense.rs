//! The points of a cloud that have many neighbours: those of a surface, not the outliers.

use std::collections::HashMap;

use superegg_geom::glam::{DVec3, IVec3};

/// The most points that are looked at.
const MOST: usize = 4000;
/// The neighbours that a point of a sphere has.
const NEIGHBORS: f64 = 12.0;
/// The part of the points that is denser than the reference.
const REFERENCE: f64 = 0.2;
/// The least neighbours of a dense point, as a part of those of the reference.
const LEAST: f64 = 0.25;

/// The dense points among the first ones of a cloud.
pub(crate) struct DensePoints {
    pub(crate) points: Vec<DVec3>,
    /// The share of dense points.
    pub(crate) share: f64,
}

/// The points among the first ones that have not much fewer neighbours than the fifth of densest
/// points. Points on a surface lie closer together than outliers in a volume.
///
/// Neighbours are nearer than the radius within which a point of a sphere has 12 of them, where
/// points are at a distance of 1 from their middle.
pub(crate) fn dense_points(points: &[DVec3]) -> DensePoints {
    let points = &points[..points.len().min(MOST)];
    let radius = (4.0 * NEIGHBORS / points.len() as f64).sqrt();
    let counts = neighbor_counts(points, radius);
    let mut sorted = counts.clone();
    let rank = ((1.0 - REFERENCE) * (sorted.len() - 1) as f64) as usize;
    let (_, &mut reference, _) = sorted.select_nth_unstable(rank);
    let least = (LEAST * f64::from(reference)).ceil() as u32;
    let dense = points.iter().zip(counts).filter(|(_, count)| *count >= least).map(|(point, _)| *point);
    let dense: Vec<DVec3> = dense.collect();
    let share = dense.len() as f64 / points.len() as f64;
    DensePoints { points: dense, share }
}

/// The numbers of points within `radius` of each point, itself included.
fn neighbor_counts(points: &[DVec3], radius: f64) -> Vec<u32> {
    // Points far away are no neighbours of any surface: they share the outermost cells.
    let cell_of =
        |point: DVec3| (point / radius).clamp(DVec3::splat(-1e6), DVec3::splat(1e6)).floor().as_ivec3();
    let cells: Vec<IVec3> = points.iter().map(|point| cell_of(*point)).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |cell: IVec3| cell.to_array();
    order.sort_unstable_by_key(|&index| (key(cells[index]), index));
    let mut starts: HashMap<[i32; 3], (usize, usize)> = HashMap::with_capacity(points.len());
    for (position, &index) in order.iter().enumerate() {
        let entry = starts.entry(key(cells[index])).or_insert((position, position));
        entry.1 = position + 1;
    }
    let sorted: Vec<DVec3> = order.iter().map(|&index| points[index]).collect();
    let square = radius * radius;
    let count = |index: usize| {
        let mut found = 0;
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let cell = key(cells[index] + IVec3::new(x, y, z));
                    let Some(&(from, to)) = starts.get(&cell) else { continue };
                    let near = |other: &&DVec3| other.distance_squared(points[index]) <= square;
                    found += sorted[from..to].iter().filter(near).count() as u32;
                }
            }
        }
        found
    };
    (0..points.len()).map(count).collect()
}
