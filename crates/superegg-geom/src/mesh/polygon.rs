//! Polygons in superellipse arcs.

use crate::measure::arc::{Arc, ArcPoint};

/// A vertex of a polygon: a point of the arc at a parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// The parameter s, with t = sinh(s). The outermost ones stand for infinite t.
    s: f64,
    pub(super) point: ArcPoint,
}

/// An arc in a plane whose axes are scaled: the point is `(scale[0] X, scale[1] Y)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScaledArc {
    pub(super) arc: Arc,
    pub(super) scale: [f64; 2],
}

/// Where a polygon begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Start {
    /// At the end of the arc, (1, 0).
    End,
    /// Beyond it, so that a chord from the first vertex to its mirror image under Y -> -Y is within
    /// the budget there.
    Mirrored,
}

/// A chord is at least this part of the longest one that its budget allows.
const CHORD_SLACK: f64 = 0.03;
/// The evaluations of a search for a chord.
const CHORD_STEPS: usize = 80;

impl ScaledArc {
    /// The outermost parameter s: -end and end stand for the ends of the arc.
    fn end(&self) -> f64 {
        self.arc.far().asinh()
    }

    fn vertex(&self, s: f64) -> Vertex {
        let end = self.end();
        let t = if s <= -end {
            f64::NEG_INFINITY
        } else if s >= end {
            f64::INFINITY
        } else {
            s.sinh()
        };
        Vertex { s, point: self.arc.at(t) }
    }

    /// The Hausdorff distance between a piece of the arc and its chord.
    ///
    /// The piece turns by less than a right angle and is convex or concave, so its projection onto
    /// the chord's line lies within the chord, and the distance is that of the point whose tangent
    /// is parallel to the chord.
    pub(super) fn chord_error(&self, from: &Vertex, to: &Vertex) -> f64 {
        let (low, high) = (&from.point, &to.point);
        let (width, height) = (low.x - high.x, high.y - low.y);
        let Some(t) = self.arc.parallel_to(height / width) else { return 0.0 };
        let t = if t.is_nan() { 0.0 } else { t.clamp(from.s.sinh(), to.s.sinh()) };
        let farthest = self.arc.at(t);
        let chord = [self.scale[0] * width, self.scale[1] * height];
        let length = chord[0].hypot(chord[1]);
        if length == 0.0 {
            return 0.0;
        }
        let offset = [self.scale[0] * (low.x - farthest.x), self.scale[1] * (farthest.y - low.y)];
        ((offset[0] * chord[1] - offset[1] * chord[0]) / length).abs()
    }

    /// The end of about the longest chord from a vertex with an error of at most `budget`, no
    /// farther than `stop`. `None` if f64 does not resolve so short a chord.
    ///
    /// The error grows with the chord: the angle at its fixed end, between the chord and any point
    /// of the piece, grows.
    fn longest_chord(&self, from: &Vertex, stop: f64, budget: f64) -> Option<Vertex> {
        let excess = |to: &Vertex| (self.chord_error(from, to) / budget).sqrt() - 1.0;
        let last = self.vertex(stop);
        let (mut good, mut good_excess) = (*from, -1.0);
        let (mut bad, mut bad_excess) = (last.s, excess(&last));
        if bad_excess <= 0.0 {
            return Some(last);
        }
        for step in 0..CHORD_STEPS {
            let part: f64 = if step % 2 == 0 { -good_excess / (bad_excess - good_excess) } else { 0.5 };
            let middle = good.s + (bad - good.s) * part;
            if !(middle > good.s && middle < bad) {
                break;
            }
            let vertex = self.vertex(middle);
            let found = excess(&vertex);
            if found > 0.0 {
                (bad, bad_excess) = (middle, found);
            } else {
                (good, good_excess) = (vertex, found);
                if found > -CHORD_SLACK {
                    break;
                }
            }
        }
        (good.s > from.s).then_some(good)
    }

    /// The first vertex of a polygon. The chord to its mirror image has the error `scale[0] (1 - X)`.
    fn first(&self, start: Start, budget: &dyn Fn(&ArcPoint) -> f64) -> Option<Vertex> {
        let end = self.vertex(-self.end());
        if start == Start::End {
            return Some(end);
        }
        let within = budget(&end.point) / self.scale[0];
        let corner = self.vertex(0.0);
        if 1.0 - corner.point.x <= within {
            return Some(corner);
        }
        let t = self.arc.t_at_fall(within * (1.0 - CHORD_SLACK));
        (t > end.s.sinh()).then(|| self.vertex(t.asinh()))
    }

    /// A polygon to (0, 1), of about the fewest chords whose errors are at most
    /// `budget` at their first vertices. With `is_halved` one vertex is at t = 0.
    ///
    /// `None` if it has more than `most` chords.
    fn greedy(
        &self,
        start: Start,
        is_halved: bool,
        most: usize,
        budget: &dyn Fn(&ArcPoint) -> f64,
    ) -> Option<Vec<Vertex>> {
        let end = self.end();
        let mut vertices = vec![self.first(start, budget)?];
        let stops = if is_halved { vec![0.0, end] } else { vec![end] };
        for stop in stops {
            loop {
                let from = vertices[vertices.len() - 1];
                if from.s >= stop {
                    break;
                }
                if vertices.len() > most {
                    return None;
                }
                let budget = budget(&from.point);
                vertices.push(self.longest_chord(&from, stop, budget)?);
            }
        }
        Some(vertices)
    }

    /// The shorter of the two greedy polygons, with and without a vertex at t = 0: the corner of an
    /// arc that is nearly a box. If both are equal, the one with that vertex, which is symmetric.
    pub(super) fn polygon(
        &self,
        start: Start,
        most: usize,
        budget: &dyn Fn(&ArcPoint) -> f64,
    ) -> Option<Polygon> {
        let plain = self.greedy(start, false, most, budget)?;
        let halved = self.greedy(start, true, most, budget);
        let (vertices, is_halved) = match halved {
            Some(halved) if halved.len() <= plain.len() => (halved, true),
            Some(_) | None => (plain, false),
        };
        Some(Polygon { vertices, start, is_halved })
    }

    /// A polygon with as many chords, whose budgets are all reduced by about the largest common
    /// factor: the errors of the chords are nearly equal then.
    pub(super) fn equalized(&self, polygon: Polygon, budget: &dyn Fn(&ArcPoint) -> f64) -> Polygon {
        const STEPS: usize = 12;
        let most = polygon.vertices.len() - 1;
        let (start, is_halved) = (polygon.start, polygon.is_halved);
        let (mut too_small, mut enough, mut best) = (0.0, 1.0, polygon);
        for _ in 0..STEPS {
            let factor = 0.5 * (too_small + enough);
            match self.greedy(start, is_halved, most, &|point| factor * budget(point)) {
                Some(vertices) => {
                    best = Polygon { vertices, start, is_halved };
                    enough = factor;
                }
                None => too_small = factor,
            }
        }
        best
    }
}

/// A polygon in an arc, to (0, 1).
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    pub(super) vertices: Vec<Vertex>,
    pub(super) start: Start,
    /// Whether one vertex is at t = 0.
    is_halved: bool,
}

impl Polygon {
    /// The chords between all vertices.
    pub(super) fn chords(&self) -> usize {
        self.vertices.len() - 1
    }

    /// Every other one of the vertices with these indices; the ends and t = 0 stay.
    pub(super) fn thinned(&self, indices: &[u32]) -> Vec<u32> {
        let stays = |index: u32| {
            let vertex = &self.vertices[index as usize];
            index as usize == self.chords() || (self.is_halved && vertex.s == 0.0)
        };
        let mut thinned = Vec::with_capacity(indices.len() / 2 + 2);
        let mut is_next = true;
        for &index in indices {
            if is_next || stays(index) {
                thinned.push(index);
                is_next = false;
            } else {
                is_next = true;
            }
        }
        thinned
    }
}
