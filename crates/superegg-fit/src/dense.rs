//! The points of a cloud that have many neighbours: those of a surface, not the outliers.

use superegg_geom::glam::DVec3;

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

/// The cells along each axis, and the bits that count them.
const CELL_BITS: u32 = 21;
const MOST_CELL: f64 = (1 << (CELL_BITS - 2)) as f64;

/// The numbers of points within `radius` of each point, itself included.
///
/// Points are sorted by cells as wide as the radius. The neighbours in the three cells of one column are a
/// range of that order, and the range moves on with the point: nine sweeps find all.
fn neighbor_counts(points: &[DVec3], radius: f64) -> Vec<u32> {
    let key_of = |cell: [i64; 3]| (cell[0] << (2 * CELL_BITS)) + (cell[1] << CELL_BITS) + cell[2];
    let cell_of = |point: DVec3| {
        // Points far away are no neighbours of any surface: they share the outermost cells.
        let cell =
            (point / radius).clamp(DVec3::splat(-MOST_CELL), DVec3::splat(MOST_CELL)) + MOST_CELL + 1.0;
        key_of(cell.to_array().map(|x| x as i64))
    };
    let mut sorted: Vec<(i64, usize)> =
        points.iter().enumerate().map(|(index, point)| (cell_of(*point), index)).collect();
    sorted.sort_unstable();
    let places: Vec<DVec3> = sorted.iter().map(|(_, index)| points[*index]).collect();
    let square = radius * radius;
    let mut counts = vec![0; points.len()];
    for (x, y) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))) {
        let mut first = 0;
        for (at, (key, index)) in sorted.iter().enumerate() {
            let column = key + key_of([x, y, 0]);
            while first < sorted.len() && sorted[first].0 < column - 1 {
                first += 1;
            }
            let range = sorted[first..].iter().take_while(|(other, _)| *other <= column + 1).count();
            let near = places[first..first + range]
                .iter()
                .filter(|other| other.distance_squared(places[at]) <= square);
            counts[*index] += near.count() as u32;
        }
    }
    counts
}
