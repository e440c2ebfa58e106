//! Points in rows of lanes: what the kernels read.

use superegg_geom::glam::DVec3;

/// The points of a row.
pub(crate) const WIDTH: usize = 8;

/// A number for each point of a row.
pub(crate) type Row = [f64; WIDTH];

/// Points as columns of coordinates, and how much each one counts.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// x, y and z. The last row is filled up with copies of its first point.
    pub(crate) rows: Vec<[Row; 3]>,
    /// The weight of each point, 0 to 1; 0 for copies.
    pub(crate) presence: Vec<Row>,
    /// The sum of the weights.
    pub(crate) total: f64,
}

impl Points {
    /// Points that count fully.
    pub(crate) fn new(points: &[DVec3]) -> Self {
        Self::with_presence(points, |_| 1.0)
    }

    /// Points of which each counts as `presence` of its index, 0 to 1.
    pub(crate) fn with_presence(points: &[DVec3], presence: impl Fn(usize) -> f64) -> Self {
        let mut rows = Vec::with_capacity(points.len().div_ceil(WIDTH));
        let mut weights = Vec::with_capacity(rows.capacity());
        let mut total = 0.0;
        for (index, chunk) in points.chunks(WIDTH).enumerate() {
            let point = |lane: usize| chunk.get(lane).unwrap_or(&chunk[0]);
            rows.push([0, 1, 2].map(|axis| std::array::from_fn(|lane| point(lane)[axis])));
            let weight: Row = std::array::from_fn(|lane| match lane < chunk.len() {
                true => presence(WIDTH * index + lane),
                false => 0.0,
            });
            total += weight.iter().sum::<f64>();
            weights.push(weight);
        }
        Self { rows, presence: weights, total }
    }
}
