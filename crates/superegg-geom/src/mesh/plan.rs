//! Where the vertices of an octant lie, and the proof of the distance.

use super::polygon::{Polygon, ScaledArc, Start};
use crate::measure::arc::{Arc, ArcPoint};
use crate::superquadric::Superquadric;

/// A section polygon thinned to every 2^k-th vertex.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// The vertices, as indices into the whole polygon.
    pub(super) indices: Vec<u32>,
    /// The largest distance between one of its chords and the arc, at rho = 1.
    error: f64,
}

/// The vertices of an octant: rings of the section polygon at the heights of the profile polygon.
/// The first ring is the equator, or the upper ring of a band around it.
///
/// # Bound
/// A band lies between two rings, at rho_j and rho_(j+1) < rho_j. Let the coarser of their polygons
/// have the chord error d, in the plane of (a X, b Y), and the profile's chord the error h, in the
/// plane of (w rho, c zeta), with w the largest length of (a X, b Y). A point of a triangle of the
/// band is
///
/// ```text
/// (rho' (a X', b Y'), c zeta'),   (rho', zeta') on the profile's chord,
/// ```
///
/// with (X', Y') a mean of vertices within one chord of the coarser polygon, so between that chord
/// and its arc. Points (X, Y) and (rho, zeta) of the arcs are within d and h of these, and the point
/// of the surface that they make is at a distance of at most
///
/// ```text
/// rho' |(a (X - X'), b (Y - Y'))| + |(w (rho - rho'), c (zeta - zeta'))| <= rho_j d + h
/// ```
///
/// The other way round, the mesh at the height of (rho', zeta') is a curve from one end of the
/// coarser chord to the other, between chord and arc. A perpendicular from a point of the arc to the
/// chord crosses it, so every point of the surface has a point of the mesh as near. Both hold for
/// the band around the equator, whose profile chord is upright: rho' and the foot of the
/// perpendicular from (1, 0) are those of its rings.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) section: Polygon,
    pub(super) levels: Vec<Level>,
    pub(super) profile: Polygon,
    /// The level of each ring, from the first one in the north to the last one below the pole.
    pub(super) ring_levels: Vec<usize>,
}

/// The two arcs of a shape in units of its largest semi-axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arcs {
    section: ScaledArc,
    profile: ScaledArc,
}

/// How the mesh is made.
#[derive(Clone, Copy, Debug)]
struct Division {
    /// The part of the tolerance for the section; the profile has the rest.
    part: f64,
    /// Whether there is a ring at the equator.
    start: Start,
}

/// The number of divisions of the tolerance that are tried: many for meshes that are made fast.
const DIVISIONS: [u32; 2] = [8, 40];
/// Meshes of no more triangles than this are made fast.
const FEW_TRIANGLES: usize = 20_000;
/// Few rings have a smaller rho.
const USUAL_RHO: f64 = 1.0 / 64.0;
/// The part that is tried first.
const MIDDLE_PART: f64 = 0.49;
/// The part of the tolerance that rounding may take.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Arcs {
    pub(super) fn of(shape: &Superquadric) -> Self {
        let exponents = shape.exponents();
        let radii = shape.radii() / shape.radii().max_element();
        let widest = widest_section(exponents.e(), radii.x, radii.y);
        Self {
            section: ScaledArc { arc: Arc::new(exponents.e()), scale: [radii.x, radii.y] },
            profile: ScaledArc { arc: Arc::new(exponents.n()), scale: [widest, radii.z] },
        }
    }

    /// About the fewest triangles within a tolerance, in units of the largest semi-axis. `None` if
    /// there are more than `most`.
    pub(super) fn plan(&self, tolerance: f64, most: usize) -> Option<Plan> {
        let first = self.first_plan(tolerance, most)?;
        let tolerance = tolerance - ROUNDING;
        let mut least = first.triangles();
        let mut best = Division { part: MIDDLE_PART, start: Start::End };
        let divisions = DIVISIONS[usize::from(least <= FEW_TRIANGLES)];
        for part in (1..divisions).map(|k| f64::from(k) / f64::from(divisions)) {
            for start in [Start::End, Start::Mirrored] {
                let division = Division { part, start };
                if let Some(plan) = self.plan_with(tolerance, division, least, false)
                    && plan.triangles() < least
                {
                    (least, best) = (plan.triangles(), division);
                }
            }
        }
        // Equal chords leave more of the tolerance, so there are no more of them, but for rounding.
        let plan = |is_equalized| self.plan_with(tolerance, best, least, is_equalized);
        plan(true).or_else(|| plan(false))
    }

    /// The plan for one division of the tolerance: a quick answer to whether there is one.
    pub(super) fn first_plan(&self, tolerance: f64, most: usize) -> Option<Plan> {
        let tolerance = tolerance - ROUNDING;
        (tolerance > ROUNDING)
            .then(|| {
                let division = Division { part: MIDDLE_PART, start: Start::End };
                self.plan_with(tolerance, division, most, false)
            })
            .flatten()
    }

    fn plan_with(&self, tolerance: f64, division: Division, most: usize, is_equalized: bool) -> Option<Plan> {
        // Two rings of one octant have at least this many chords.
        let most_chords = most / 8 + 2;
        let share = division.part * tolerance;
        let section_budget = |_: &ArcPoint| share;
        let mut section = self.section.polygon(Start::End, most_chords, &section_budget)?;
        if is_equalized {
            section = self.section.equalized(section, &section_budget);
        }
        let levels = self.levels(&section);
        let error_at = |point: &ArcPoint| levels[level_at(&levels, point.x, share)].error;
        let profile_budget = |point: &ArcPoint| tolerance - point.x * error_at(point);
        // A quick end for what has too many triangles: rings nearer to the axis are few.
        let usual_chords = levels[level_at(&levels, USUAL_RHO, share)].indices.len() - 1;
        let most_bands = most / (8 * usual_chords) + 2;
        let mut profile = self.profile.polygon(division.start, most_bands, &profile_budget)?;
        if is_equalized {
            profile = self.profile.equalized(profile, &profile_budget);
        }
        let below_pole = &profile.vertices[..profile.chords()];
        // The level of a band is that of its upper ring. The first ring is in a band at the equator.
        let mut ring_levels = vec![level_at(&levels, 1.0, share)];
        ring_levels.extend(below_pole.iter().map(|ring| level_at(&levels, ring.point.x, share)));
        ring_levels.truncate(below_pole.len());
        let plan = Plan { section, levels, profile, ring_levels };
        (plan.triangles() <= most).then_some(plan)
    }

    /// The section polygon and its thinned versions.
    fn levels(&self, section: &Polygon) -> Vec<Level> {
        let mut indices: Vec<u32> = (0..=section.chords() as u32).collect();
        let mut levels = Vec::new();
        loop {
            let error = indices.windows(2).map(|pair| {
                let [from, to] = [pair[0], pair[1]].map(|i| &section.vertices[i as usize]);
                self.section.chord_error(from, to)
            });
            let error = error.fold(0.0, f64::max);
            let thinned = section.thinned(&indices);
            let is_last = thinned.len() == indices.len();
            levels.push(Level { indices, error });
            if is_last {
                return levels;
            }
            indices = thinned;
        }
    }
}

/// The coarsest level whose error at this rho is within the section's share.
fn level_at(levels: &[Level], rho: f64, share: f64) -> usize {
    levels.iter().rposition(|level| level.error * rho <= share).unwrap_or(0)
}

/// The largest length of (a X, b Y) over the section `X^p + Y^p = 1`, p = 2/e: by Hölder's
/// inequality `(a^q + b^q)^(1/q)`, q = 2 / (1 - e), for e < 1, else the larger semi-axis.
fn widest_section(e: f64, a: f64, b: f64) -> f64 {
    let (long, short) = (a.max(b), a.min(b));
    if e >= 1.0 {
        return long;
    }
    let q = 2.0 / (1.0 - e);
    // Rounding may not take away from a bound.
    long * (1.0 + (short / long).powf(q)).powf(1.0 / q) * (1.0 + 4.0 * f64::EPSILON)
}

impl Plan {
    /// The vertices of a ring in one octant, without the last one.
    fn ring_chords(&self, ring: usize) -> usize {
        self.levels[self.ring_levels[ring]].indices.len() - 1
    }

    /// Whether the first ring is the equator.
    pub(super) fn has_equator(&self) -> bool {
        self.profile.start == Start::End
    }

    /// The triangles of the whole mesh: each chord of a ring is a side of one triangle of each band
    /// at the ring.
    pub(super) fn triangles(&self) -> usize {
        let of_rings: usize = (0..self.ring_levels.len()).map(|ring| self.ring_chords(ring)).sum();
        // Two bands at each ring; an equator is a ring of both halves.
        2 * 4 * (2 * of_rings - if self.has_equator() { self.ring_chords(0) } else { 0 })
    }
}
