//! The search for parts: splits of what one shape describes badly, then merges.

use superegg_geom::glam::DVec3;

use super::group::{halves, joined};
use super::model::{LEAST_MEMBERS, are_close, described, fitted, improved, is_surface};
use super::watch::Watch;
use crate::options::PartCount;
use crate::refine::Candidate;
use crate::search::Question;
use crate::surface::distance;

/// The most times that a group is split.
const MOST_DEPTH: usize = 5;
/// The share of points that a good shape explains.
const GOOD: f64 = 0.97;
/// The rounds in which points choose their part and shapes are refined.
const ROUNDS: usize = 4;
/// The distance between surfaces that are the same, as a part of the size.
const SAME: f64 = 0.01;
/// Neighbours of a point that is not alone are nearer than this many mean spacings.
const REACH: f64 = 4.0;

/// The search for the parts of a cloud.
pub(super) struct Explainer<'a> {
    points: &'a [DVec3],
    question: Question,
    /// The volume of the outliers.
    volume: f64,
    reach: f64,
    watch: Watch<'a>,
}

impl<'a> Explainer<'a> {
    pub(super) fn new(points: &'a [DVec3], question: Question, watch: Watch<'a>) -> Self {
        let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
            (low.min(*point), high.max(*point))
        });
        // The spacing of points on a sphere of radius 1.
        let spacing = (4.0 * std::f64::consts::PI / points.len() as f64).sqrt();
        Self {
            points,
            question,
            volume: (high - low).max(DVec3::splat(1e-3)).element_product(),
            reach: REACH * spacing,
            watch,
        }
    }

    fn fitted(&self, members: &[usize]) -> Option<Candidate> {
        self.watch.before_fit();
        fitted(self.points, members, &self.question)
    }

    /// The shapes with their points, those of the most points first.
    pub(super) fn parts(&self, count: PartCount) -> Vec<(Candidate, Vec<usize>)> {
        let all: Vec<usize> = (0..self.points.len()).collect();
        let mut shapes: Vec<Candidate> = Vec::new();
        for group in joined(self.points, &all, self.reach) {
            shapes.extend(self.explain(&group, 0));
        }
        shapes = self.settled(shapes, &all);
        shapes = self.merged(shapes, &all, count);
        if let PartCount::Exactly(wanted) = count {
            while shapes.len() < wanted {
                let more = self.with_one_more(&shapes, &all).map(|more| self.settled(more, &all));
                match more.filter(|more| more.len() > shapes.len()) {
                    Some(more) => shapes = more,
                    None => break,
                }
            }
        }
        let mut parts: Vec<(Candidate, Vec<usize>)> = shapes
            .iter()
            .copied()
            .zip(self.members(&shapes, &all))
            .filter(|(_, members)| members.len() >= LEAST_MEMBERS)
            .collect();
        parts.sort_by_key(|(_, members)| std::cmp::Reverse(members.len()));
        parts
    }

    fn length(&self, shapes: &[Candidate], members: &[usize]) -> f64 {
        described(self.points, members, shapes, self.volume).length
    }

    /// The points of each shape.
    fn members(&self, shapes: &[Candidate], all: &[usize]) -> Vec<Vec<usize>> {
        let mut members = vec![Vec::new(); shapes.len()];
        for (&index, part) in all.iter().zip(described(self.points, all, shapes, self.volume).part_of) {
            if let Some(part) = part {
                members[part].push(index);
            }
        }
        members
    }

    /// The shapes that describe a group shortest.
    fn explain(&self, group: &[usize], depth: usize) -> Vec<Candidate> {
        let Some(one) = self.fitted(group) else { return Vec::new() };
        let own = described(self.points, group, &[one], self.volume);
        let rest: Vec<usize> = group
            .iter()
            .zip(&own.part_of)
            .filter(|(_, part)| part.is_none())
            .map(|(&index, _)| index)
            .collect();
        let is_good = (rest.len() as f64) < (1.0 - GOOD) * group.len() as f64
            && one.mixture.sigma < 0.01 * one.shape.size();
        if is_good || depth == MOST_DEPTH || self.watch.has_stopped() {
            return vec![one];
        }
        let mut best = (vec![one], own.length);
        let mut peeled = vec![one];
        if rest.len() >= LEAST_MEMBERS && rest.len() < group.len() {
            for group in joined(self.points, &rest, self.reach) {
                peeled.extend(self.explain(&group, depth + 1));
            }
        }
        let halved =
            halves(self.points, group).iter().flat_map(|half| self.explain(half, depth + 1)).collect();
        for shapes in [peeled, halved] {
            let length = self.length(&shapes, group);
            if length < best.1 {
                best = (shapes, length);
            }
        }
        best.0
    }

    /// Lets points choose their shape and refines the shapes, in turns. One shape is left
    /// of those with the same surface: with different noises they would describe noise that is not normal better than one does.
    fn settled(&self, mut shapes: Vec<Candidate>, all: &[usize]) -> Vec<Candidate> {
        for _ in 0..ROUNDS {
            let members = self.members(&shapes, all);
            let refined = shapes.iter().zip(&members).filter(|(_, members)| members.len() >= LEAST_MEMBERS);
            shapes = refined
                .map(|(shape, members)| improved(self.points, members, shape, &self.question))
                .filter(is_surface)
                .fold(Vec::new(), with_new);
        }
        shapes
    }

    /// Merges pairs of shapes while that shortens the description. While there are too many, the pair or the
    /// shape goes without which the description is shortest.
    fn merged(&self, mut shapes: Vec<Candidate>, all: &[usize], count: PartCount) -> Vec<Candidate> {
        loop {
            self.watch.described(shapes.len());
            let now = self.length(&shapes, all);
            let are_too_many = matches!(count, PartCount::Exactly(wanted) if shapes.len() > wanted);
            let mut fewer = self.with_a_pair_joined(&shapes, all);
            if are_too_many {
                fewer.extend((0..shapes.len()).map(|index| without(&shapes, index)));
            }
            if self.watch.has_stopped() {
                return shapes;
            }
            let described = fewer.into_iter().map(|fewer| (self.length(&fewer, all), fewer));
            let Some((length, best)) = described.min_by(|a, b| a.0.total_cmp(&b.0)) else { return shapes };
            let is_wanted = match count {
                PartCount::Auto => length < now,
                PartCount::Exactly(_) => are_too_many,
            };
            if !is_wanted {
                return shapes;
            }
            shapes = self.settled(best, all);
        }
    }

    /// The shapes with two of them joined to one, for each pair that is close.
    fn with_a_pair_joined(&self, shapes: &[Candidate], all: &[usize]) -> Vec<Vec<Candidate>> {
        let members = self.members(shapes, all);
        let mut joined = Vec::new();
        for i in 0..shapes.len() {
            for j in i + 1..shapes.len() {
                if !are_close(&shapes[i].shape, &shapes[j].shape) {
                    continue;
                }
                let mut both = [members[i].as_slice(), members[j].as_slice()].concat();
                both.sort_unstable();
                let Some(one) = self.fitted(&both) else { continue };
                let mut fewer = without(shapes, j);
                fewer[i] = one;
                joined.push(fewer);
                if self.watch.has_stopped() {
                    return joined;
                }
            }
        }
        joined
    }

    /// The shapes with the one halved that gains most by it.
    fn with_one_more(&self, shapes: &[Candidate], all: &[usize]) -> Option<Vec<Candidate>> {
        let members = self.members(shapes, all);
        let mut best: Option<(Vec<Candidate>, f64)> = None;
        for (index, members) in members.iter().enumerate() {
            let two = halves(self.points, members).map(|half| self.fitted(&half));
            if self.watch.has_stopped() {
                return None;
            }
            let [Some(first), Some(second)] = two else { continue };
            let mut more = shapes.to_vec();
            more[index] = first;
            more.push(second);
            let length = self.length(&more, all);
            if best.as_ref().is_none_or(|(_, best)| length < *best) {
                best = Some((more, length));
            }
        }
        best.map(|(more, _)| more)
    }
}

/// The shapes with another one, if none of them has its surface.
fn with_new(mut shapes: Vec<Candidate>, another: Candidate) -> Vec<Candidate> {
    let is_copy = |shape: &Candidate| {
        let enough = SAME * shape.shape.size().min(another.shape.size());
        distance(&shape.shape, &another.shape) < enough && distance(&another.shape, &shape.shape) < enough
    };
    if !shapes.iter().any(is_copy) {
        shapes.push(another);
    }
    shapes
}

fn without(shapes: &[Candidate], index: usize) -> Vec<Candidate> {
    [&shapes[..index], &shapes[index + 1..]].concat()
}
