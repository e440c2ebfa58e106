//! The closest point of the surface, by branch and bound.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DAffine3, DMat3, DVec3};

use super::arc::{Arc, ArcPoint};
use crate::math::transform::inverse_of;
use crate::norm::NormForm;
use crate::superquadric::Superquadric;

/// The point of a surface that is closest to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClosestPoint {
    /// The point of the surface, in the shape's own space.
    pub point: DVec3,
    /// The signed distance to it: negative inside, 0 on the surface, positive outside.
    pub distance: f64,
    /// The proven error: the whole surface is at least `distance.abs() - error` away.
    pub error: f64,
}

/// The end of a search for a closest point: it ends at the tolerance or at the number of cells,
/// whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchLimits {
    /// The error that is small enough, as a part of the distance.
    pub relative_tolerance: f64,
    /// The most cells of the surface that are looked at. One takes about a microsecond.
    pub most_cells: usize,
}

impl Default for SearchLimits {
    /// A relative error of 1e-9, 50,000 cells.
    fn default() -> Self {
        Self { relative_tolerance: 1e-9, most_cells: 50_000 }
    }
}

/// An error that rounding leaves, as a part of the largest number involved.
const ROUNDING: f64 = 32.0 * f64::EPSILON;
/// The steps of the search for the point of a hull that is closest.
const HULL_STEPS: usize = 6;
/// The steps of Newton's method on the surface.
const NEWTON_STEPS: usize = 40;

/// The least descent of a step, as a part of the squared distance: an eighth of a unit in its last place.
const LEAST_DESCENT: f64 = f64::EPSILON / 8.0;

impl Superquadric {
    /// The closest point of the surface and the signed distance, to a relative error of 1e-9:
    /// [`Superquadric::closest_point_within`] with the default limits. `None` for a point that is
    /// not finite.
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric, glam::DVec3};
    /// let star = Superquadric::unit(Exponents::new(3.0, 3.0)?);
    /// let closest = star.closest_point(DVec3::new(0.0, 0.0, 1.5)).unwrap();
    /// assert_eq!((closest.point, closest.distance), (DVec3::Z, 0.5));
    /// # Ok::<(), superegg_geom::ShapeError>(())
    /// ```
    pub fn closest_point(&self, point: DVec3) -> Option<ClosestPoint> {
        self.closest_point_within(point, &SearchLimits::default())
    }

    /// The closest point of the surface and the signed distance, for every pair of exponents, with
    /// a proven error. `None` for a point that is not finite.
    ///
    /// For a point outside Newton's method finds a point of the surface, and a plane between the two
    /// proves that no other is closer: the shape lies behind its support plane. That is all where
    /// the closest point is one of the convex hull, as it is for a convex shape.
    ///
    /// Elsewhere, branch and bound. The closest point lies in the octant of the given one, and the surface
    /// there is a product of two superellipse arcs (see [`Superquadric::surface_area_with_error`]).
    /// A piece of an arc is convex or concave, so it lies in the triangle of its chord and its end
    /// tangents, and a cell of the surface lies in the convex hull of nine points; the gap shrinks
    /// with the square of the cell's size, at spikes, creases and edges too. The distance to the
    /// hull, from below by a separating plane, bounds the distance to the cell. The cell with the
    /// smallest bound is halved, until the bound is the distance to the best point found, which
    /// Newton's method has improved.
    ///
    /// The error is larger than the tolerance only where a whole patch of the surface is closest to
    /// within less than the bounds resolve, as near the centre of what is nearly a sphere. Around a
    /// shape of revolution (e = 1 and equal semi-axes) only its profile is searched; a sphere has a
    /// closed form. If several points are closest, such as those of a point in a plane of symmetry,
    /// one is returned.
    ///
    /// ```
    /// use superegg_geom::{SearchLimits, Superquadric, glam::DVec3};
    /// let limits = SearchLimits { relative_tolerance: 1e-12, ..SearchLimits::default() };
    /// let sphere = Superquadric::unit_sphere();
    /// let closest = sphere.closest_point_within(DVec3::new(0.3, 0.0, -0.4), &limits).unwrap();
    /// assert!((closest.distance + 0.5).abs() < 1e-12 && closest.error < 1e-12);
    /// ```
    pub fn closest_point_within(&self, point: DVec3, limits: &SearchLimits) -> Option<ClosestPoint> {
        if !point.is_finite() {
            return None;
        }
        // In units of the larger of shape and point, so that no square leaves the range of f64.
        let unit = self.radii().max_element().max(point.abs().max_element());
        let (radii, query) = (self.radii() / unit, point.abs() / unit);
        let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
        let octant = DVec3::new(sign(point.x), sign(point.y), sign(point.z));
        let search = Search::straight(self, radii, query);
        let is_inside = self.norm().value(point / self.radii()) < 1.0;
        let found = if is_inside { search.run(limits) } else { search.run_from_outside(limits) };
        let side = if is_inside { -1.0 } else { 1.0 };
        Some(ClosestPoint {
            point: octant * found.point * unit,
            distance: side * found.distance * unit,
            error: found.error * unit,
        })
    }

    /// The closest point of the shape's image under an affine map, and the signed distance there.
    /// Point, distance and error are in the space that the map leads to. `None` for a point or a map
    /// that is not finite, and for a map that is singular.
    ///
    /// Rotations, mirrors and scales along the shape's own axes leave a superquadric, for which
    /// [`Superquadric::closest_point_within`] answers. Under any other map (a shear) the search runs
    /// over all eight octants of the image: cells and hulls are images of those of the shape, so the
    /// error is proven too.
    ///
    /// ```
    /// use superegg_geom::glam::{DAffine3, DVec3};
    /// use superegg_geom::{SearchLimits, Superquadric};
    /// let map = DAffine3::from_scale(DVec3::new(1.0, 1.0, 3.0));
    /// let at = DVec3::new(0.0, 0.0, 5.0);
    /// let ball = Superquadric::unit_sphere();
    /// let closest = ball.closest_point_under(&map, at, &SearchLimits::default()).unwrap();
    /// assert!((closest.distance - 2.0).abs() < 1e-9);
    /// ```
    pub fn closest_point_under(
        &self,
        map: &DAffine3,
        point: DVec3,
        limits: &SearchLimits,
    ) -> Option<ClosestPoint> {
        let inverse = inverse_of(map);
        let offset = point - map.translation;
        if !offset.is_finite() || !map.is_finite() || !inverse.is_finite() {
            return None;
        }
        if let Some((rotation, lengths)) = rotation_and_lengths(&map.matrix3) {
            let shape = Self::new(self.radii() * lengths, self.exponents()).ok()?;
            let closest = shape.closest_point_within(rotation.transpose() * offset, limits)?;
            let point = rotation * closest.point + map.translation;
            let error = closest.error + 4.0 * SKEW * shape.radii().max_element();
            return Some(ClosestPoint { point, error, ..closest });
        }
        let frame = map.matrix3 * DMat3::from_diagonal(self.radii());
        let columns = frame.x_axis.abs().max(frame.y_axis.abs()).max(frame.z_axis.abs());
        let unit = columns.max_element().max(offset.abs().max_element());
        let found = Search::sheared(self, &(frame * (1.0 / unit)), offset / unit).run(limits);
        let local = inverse.transform_point3(point) / self.radii();
        let side = if self.norm().value(local) < 1.0 { -1.0 } else { 1.0 };
        Some(ClosestPoint {
            point: found.point * unit + map.translation,
            distance: side * found.distance * unit,
            error: found.error * unit,
        })
    }
}

/// The largest cosine between columns that count as perpendicular.
const SKEW: f64 = 1e-13;

/// A linear map whose columns are perpendicular, as a rotation (or rotation and mirror) and the
/// lengths of the columns: map = rotation * diagonal. `None` for any other map.
pub(super) fn rotation_and_lengths(map: &DMat3) -> Option<(DMat3, DVec3)> {
    let lengths = DVec3::new(map.x_axis.length(), map.y_axis.length(), map.z_axis.length());
    let [x, y, z] = [map.x_axis / lengths.x, map.y_axis / lengths.y, map.z_axis / lengths.z];
    let is_perpendicular = [x.dot(y), y.dot(z), z.dot(x)].iter().all(|cosine| cosine.abs() <= SKEW);
    (is_perpendicular && lengths.is_finite()).then(|| (DMat3::from_cols(x, y, z), lengths))
}

/// An answer in the octant and unit of the search.
#[derive(Clone, Copy, Debug)]
struct Found {
    point: DVec3,
    distance: f64,
    error: f64,
}

/// A piece of an arc: between two parameters, with the points there and the apex of the triangle.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// The parameters s, with t = sinh(s); the outermost ones stand for infinite t.
    from: f64,
    to: f64,
    low: ArcPoint,
    high: ArcPoint,
}

impl Piece {
    /// The corners of a triangle that holds the piece.
    fn corners(&self) -> [[f64; 2]; 3] {
        let (low, high) = (&self.low, &self.high);
        let (width, height) = (low.x - high.x, high.y - low.y);
        let (from, to) = (low.steepness, high.steepness);
        // The tangents meet at X = low.x - across.
        let across = if from == to {
            // Straight to the last digit.
            width
        } else if from == f64::INFINITY {
            0.0
        } else if to == f64::INFINITY {
            width
        } else {
            ((height - to * width) / (from - to)).clamp(0.0, width)
        };
        // From the tangent that is less steep.
        let up = if from < to { low.y + from * across } else { high.y - to * (width - across) };
        let up = if up.is_nan() { high.y } else { up.clamp(low.y, high.y) };
        [[low.x, low.y], [high.x, high.y], [low.x - across, up]]
    }

    /// The size of the piece.
    fn extent(&self) -> (f64, f64) {
        (self.low.x - self.high.x, self.high.y - self.low.y)
    }
}

/// A cell of the surface: a piece of the arc around, times one of the profile.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// A lower bound on the distance.
    bound: f64,
    /// The index of its octant among [`Search::frames`].
    octant: usize,
    around: Piece,
    profile: Piece,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    /// The heap's greatest cell is that of the smallest bound.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound)
    }
}

/// The search over one octant of the surface, or over all.
struct Search {
    /// The norm of the unit shape.
    norm: NormForm,
    /// The images of the unit vectors, one frame for each octant: a point of the unit shape's first
    /// octant times the frame is a point of the surface.
    frames: Vec<DMat3>,
    /// The lengths of the frames' columns.
    radii: DVec3,
    query: DVec3,
    around: Arc,
    profile: Arc,
    /// The outermost parameters s.
    ends: [f64; 2],
    /// The direction (X, Y) of the query from the axis of a shape of revolution.
    azimuth: Option<[f64; 2]>,
    is_sphere: bool,
}

impl Search {
    /// In the first octant of a shape along the axes, where the query is too.
    fn straight(shape: &Superquadric, radii: DVec3, query: DVec3) -> Self {
        let exponents = shape.exponents();
        let is_round = exponents.e() == 1.0 && radii.x == radii.y;
        let azimuth = is_round.then(|| {
            let length = query.x.hypot(query.y);
            if length > 0.0 { [query.x / length, query.y / length] } else { [1.0, 0.0] }
        });
        let is_sphere = is_round && exponents.n() == 1.0 && radii.x == radii.z;
        let frames = vec![DMat3::from_diagonal(radii)];
        Self { azimuth, is_sphere, ..Self::new(shape, frames, query) }
    }

    /// In all octants of the image under `frame`.
    fn sheared(shape: &Superquadric, frame: &DMat3, query: DVec3) -> Self {
        let sign = |octant: usize, axis: usize| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let signs = |octant| DVec3::new(sign(octant, 0), sign(octant, 1), sign(octant, 2));
        let frames = (0..8).map(|octant| *frame * DMat3::from_diagonal(signs(octant)));
        Self::new(shape, frames.collect(), query)
    }

    fn new(shape: &Superquadric, frames: Vec<DMat3>, query: DVec3) -> Self {
        let exponents = shape.exponents();
        let (around, profile) = (Arc::new(exponents.e()), Arc::new(exponents.n()));
        let ends = [around, profile].map(|arc| arc.far().asinh());
        let DMat3 { x_axis, y_axis, z_axis } = frames[0];
        let radii = DVec3::new(x_axis.length(), y_axis.length(), z_axis.length());
        let norm = *shape.norm();
        Self { norm, frames, radii, query, around, profile, ends, azimuth: None, is_sphere: false }
    }

    /// [`Search::run`] for a query outside of a shape along the axes.
    fn run_from_outside(&self, limits: &SearchLimits) -> Found {
        if self.is_sphere {
            return self.run(limits);
        }
        let frame = &self.frames[0];
        let starts = [self.towards_center(), self.towards_support()];
        let [first, second] = starts.map(|[t, tau]| {
            let around = self.around_at(t);
            self.candidate(frame, &around, &self.profile.at(tau))
        });
        let (found, parameters) =
            if second.distance < first.distance { (second, starts[1]) } else { (first, starts[0]) };
        let best = self.improved(frame, found, parameters);
        let gap = best.distance - self.distance_to_planes(&best);
        if gap <= (limits.relative_tolerance * best.distance).max(ROUNDING) {
            Found { error: gap.max(0.0) + 2.0 * ROUNDING, ..best }
        } else {
            self.run_below(limits, best)
        }
    }

    /// The parameters t and tau of the surface point between the query and the centre.
    fn towards_center(&self) -> [f64; 2] {
        let at = self.query / self.radii;
        let rho = self.norm.xy.value(at.x, at.y);
        [self.around.at_ratio(at.y / at.x), self.profile.at_ratio(at.z / rho)]
    }

    /// The parameters t and tau of the surface point that is farthest in the direction of the query.
    fn towards_support(&self) -> [f64; 2] {
        let along = self.query * self.radii;
        let rho = self.norm.xy.dual().value(along.x, along.y);
        let parallel = |arc: Arc, steepness: f64| arc.parallel_to(steepness).map_or(0.0, |t| arc.within(t));
        [parallel(self.around, along.x / along.y), parallel(self.profile, rho / along.z)]
    }

    /// A lower bound on the distance to the shape from the query outside: that to a support plane,
    /// whose normal is the way from the found point to the query, or that of the surface there.
    fn distance_to_planes(&self, found: &Found) -> f64 {
        let gradient = || self.norm.value_and_gradient(found.point / self.radii).1 / self.radii;
        let way = (self.query - found.point).normalize_or_zero();
        let bound = |normal: DVec3| normal.dot(self.query) - self.norm.support(self.radii * normal);
        let by_way = bound(way);
        if found.distance - by_way <= ROUNDING {
            by_way
        } else {
            by_way.max(bound(gradient().normalize_or_zero()))
        }
    }

    /// The point of the arc around at t, or that in the direction of the query.
    fn around_at(&self, t: f64) -> ArcPoint {
        match self.azimuth {
            Some([x, y]) => ArcPoint { x, y, ..ArcPoint::default() },
            None => self.around.at(t),
        }
    }

    fn run(&self, limits: &SearchLimits) -> Found {
        if self.is_sphere {
            let length = self.query.length();
            let direction = if length > 0.0 { self.query / length } else { DVec3::Z };
            let distance = (length - self.radii.x).abs();
            return Found { point: direction * self.radii.x, distance, error: ROUNDING };
        }
        let whole = self.whole();
        self.run_below(limits, self.candidate(&self.frames[0], &whole.around.low, &whole.profile.low))
    }

    /// Branch and bound, from a point that was found.
    fn run_below(&self, limits: &SearchLimits, mut best: Found) -> Found {
        let mut heap = BinaryHeap::new();
        let whole = self.whole();
        for octant in 0..self.frames.len() {
            self.push(&mut heap, Cell { octant, ..whole }, &mut best);
        }
        let mut lowest = 0.0;
        for _ in 0..limits.most_cells {
            let Some(cell) = heap.pop() else {
                // Every cell is excluded.
                lowest = best.distance;
                break;
            };
            lowest = cell.bound;
            let tolerance = (limits.relative_tolerance * best.distance).max(ROUNDING);
            if lowest >= best.distance - tolerance {
                break;
            }
            let Some([first, second]) = self.halves(&cell) else { break };
            self.push(&mut heap, first, &mut best);
            self.push(&mut heap, second, &mut best);
        }
        Found { error: (best.distance - lowest).max(0.0) + ROUNDING, ..best }
    }

    /// The first octant as one cell.
    fn whole(&self) -> Cell {
        let piece = |arc: Arc, end: f64| Piece {
            from: -end,
            to: end,
            low: arc.at(f64::NEG_INFINITY),
            high: arc.at(f64::INFINITY),
        };
        let mut around = piece(self.around, self.ends[0]);
        if self.azimuth.is_some() {
            let point = self.around_at(0.0);
            around = Piece { low: point, high: point, ..around };
        }
        Cell { bound: 0.0, octant: 0, around, profile: piece(self.profile, self.ends[1]) }
    }

    /// The halves of a cell along its longer side; `None` if it is as small as it can be.
    fn halves(&self, cell: &Cell) -> Option<[Cell; 2]> {
        let (x, y) = cell.around.extent();
        let around_size = cell.profile.low.x * (self.radii.x * x).max(self.radii.y * y);
        let (rho, zeta) = cell.profile.extent();
        let width = (self.radii.x * cell.around.low.x).max(self.radii.y * cell.around.high.y);
        let profile_size = (width * rho).max(self.radii.z * zeta);
        let halve = |arc: Arc, piece: &Piece| {
            let middle = 0.5 * (piece.from + piece.to);
            (middle > piece.from && middle < piece.to).then(|| {
                let point = arc.at(middle.sinh());
                [Piece { to: middle, high: point, ..*piece }, Piece { from: middle, low: point, ..*piece }]
            })
        };
        let by_around = || {
            let halves = halve(self.around, &cell.around).filter(|_| self.azimuth.is_none());
            halves.map(|halves| halves.map(|around| Cell { around, ..*cell }))
        };
        let by_profile = || {
            let halves = halve(self.profile, &cell.profile);
            halves.map(|halves| halves.map(|profile| Cell { profile, ..*cell }))
        };
        if around_size > profile_size {
            by_around().or_else(by_profile)
        } else {
            by_profile().or_else(by_around)
        }
    }

    /// Adds a cell unless its bound excludes it; its points may be better than the best one.
    fn push(&self, heap: &mut BinaryHeap<Cell>, mut cell: Cell, best: &mut Found) {
        let frame = &self.frames[cell.octant];
        let mut nearest: Option<(Found, [f64; 2])> = None;
        for (around, s) in [(&cell.around.low, cell.around.from), (&cell.around.high, cell.around.to)] {
            for (profile, sigma) in
                [(&cell.profile.low, cell.profile.from), (&cell.profile.high, cell.profile.to)]
            {
                let found = self.candidate(frame, around, profile);
                if nearest.is_none_or(|(nearest, _)| found.distance < nearest.distance) {
                    nearest = Some((found, [s, sigma]));
                }
            }
        }
        if let Some((found, parameters)) = nearest
            && found.distance < best.distance
        {
            *best = self.improved(frame, found, parameters.map(f64::sinh));
        }
        let bound = self.distance_to_hull(&self.hull(&cell), best.distance);
        if bound < best.distance {
            cell.bound = bound.max(cell.bound);
            heap.push(cell);
        }
    }

    fn point(frame: &DMat3, around: &ArcPoint, profile: &ArcPoint) -> DVec3 {
        *frame * DVec3::new(profile.x * around.x, profile.x * around.y, profile.y)
    }

    fn candidate(&self, frame: &DMat3, around: &ArcPoint, profile: &ArcPoint) -> Found {
        let point = Self::point(frame, around, profile);
        Found { point, distance: (point - self.query).length(), error: 0.0 }
    }

    /// The corners of a hull that holds the cell.
    fn hull(&self, cell: &Cell) -> [DVec3; 9] {
        let (around, profile) = (cell.around.corners(), cell.profile.corners());
        let frame = self.frames[cell.octant];
        let corner = |[x, y]: [f64; 2], [rho, zeta]: [f64; 2]| frame * DVec3::new(rho * x, rho * y, zeta);
        let mut hull = [DVec3::ZERO; 9];
        for (i, &a) in around.iter().enumerate() {
            for (j, &p) in profile.iter().enumerate() {
                hull[3 * i + j] = corner(a, p);
            }
        }
        hull
    }

    /// A lower bound on the distance to a hull: that to a separating plane. The planes are those of
    /// the Frank-Wolfe method for the closest point of the hull; it stops at a bound of `enough`.
    fn distance_to_hull(&self, hull: &[DVec3; 9], enough: f64) -> f64 {
        let relative = hull.map(|corner| corner - self.query);
        let mut best = 0f64;
        let mut at = relative.iter().sum::<DVec3>() / 9.0;
        for _ in 0..HULL_STEPS {
            let length = at.length();
            if length == 0.0 {
                return best;
            }
            let normal = at / length;
            let (mut least, mut support) = (f64::INFINITY, at);
            for &corner in &relative {
                let along = corner.dot(normal);
                if along < least {
                    (least, support) = (along, corner);
                }
            }
            best = best.max(least);
            let step = support - at;
            // Without a step `at` is the closest point, and the fraction is no number.
            if best >= enough || length - least <= 1e-16 || step.length_squared() == 0.0 {
                return best;
            }
            let fraction = (-at.dot(step) / step.length_squared()).clamp(0.0, 1.0);
            at += fraction * step;
        }
        best
    }

    /// Newton's method for the closest point in the parameters t and tau, from a found point. A
    /// step is taken only if it leads closer.
    fn improved(&self, frame: &DMat3, found: Found, [mut t, mut tau]: [f64; 2]) -> Found {
        let mut best = found;
        let mut damping = 0.0;
        let (mut around, mut profile) = (self.around_at(t), self.profile.at(tau));
        for _ in 0..NEWTON_STEPS {
            let Some([dt, dtau]) = self.newton_step(frame, &around, &profile, damping) else { break };
            let (next_around, next_profile) = (self.around_at(t + dt), self.profile.at(tau + dtau));
            let next = self.candidate(frame, &next_around, &next_profile);
            if next.distance < best.distance {
                (best, t, tau) = (next, t + dt, tau + dtau);
                (around, profile) = (next_around, next_profile);
                damping *= 0.1;
            } else if damping > 1e6 {
                break;
            } else {
                damping = (10.0 * damping).max(1e-3);
            }
        }
        best
    }

    /// A step of Newton's method for half the squared distance, whose Hessian is made positive by
    /// `damping` of its diagonal. `None` where there is none, or none that changes the distance by
    /// more than it is rounded.
    fn newton_step(
        &self,
        frame: &DMat3,
        around: &ArcPoint,
        profile: &ArcPoint,
        damping: f64,
    ) -> Option<[f64; 2]> {
        let off = Self::point(frame, around, profile) - self.query;
        let (x_bend, y_bend) = self.around.log_slopes(around);
        let (rho_bend, zeta_bend) = self.profile.log_slopes(profile);
        let section = DVec3::new(around.x, around.y, 0.0);
        let section_t = DVec3::new(-around.x_fall, around.y_rise, 0.0);
        let section_tt = DVec3::new(-around.x_fall * x_bend, around.y_rise * y_bend, 0.0);
        let by_t = *frame * (section_t * profile.x);
        let by_tt = *frame * (section_tt * profile.x);
        let by_ttau = *frame * (section_t * -profile.x_fall);
        let by_tau = *frame * (section * -profile.x_fall + DVec3::Z * profile.y_rise);
        let by_tautau =
            *frame * (section * (-profile.x_fall * rho_bend) + DVec3::Z * (profile.y_rise * zeta_bend));
        let gradient = [off.dot(by_t), off.dot(by_tau)];
        let (tt, ss) = (by_t.length_squared(), by_tau.length_squared());
        let mixed = by_t.dot(by_tau) + off.dot(by_ttau);
        // Levenberg: the diagonal of the first derivatives keeps the matrix positive.
        let a = tt + off.dot(by_tt) + damping * (tt + off.dot(by_tt).abs());
        let d = ss + off.dot(by_tautau) + damping * (ss + off.dot(by_tautau).abs());
        let determinant = a * d - mixed * mixed;
        let step = if determinant > 0.0 && a > 0.0 {
            [
                (mixed * gradient[1] - d * gradient[0]) / determinant,
                (mixed * gradient[0] - a * gradient[1]) / determinant,
            ]
        } else {
            // Downhill in each parameter on its own.
            [gradient[0] / -a.abs().max(tt), gradient[1] / -d.abs().max(ss)]
                .map(|x| if x.is_finite() { x } else { 0.0 })
        };
        let step = if self.azimuth.is_some() { [0.0, gradient[1] / -d.abs()] } else { step };
        // The gain of half the squared distance is half of this.
        let descent = -(gradient[0] * step[0] + gradient[1] * step[1]);
        let is_step = step[0].is_finite() && step[1].is_finite() && step != [0.0; 2];
        (is_step && descent > LEAST_DESCENT * off.length_squared()).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix;
    use crate::shape::Exponents;

    /// Newton's method with its proof against branch and bound, at points outside.
    #[test]
    fn points_outside_have_the_answers_of_branch_and_bound() {
        let mut random = SplitMix::new(8);
        let exponents = [0.0, 1e-6, 0.05, 0.3, 1.0, 1.4, 1.99, 2.0, 2.3, 4.0];
        let (mut proven, mut of_convex) = (0, 0);
        for case in 0..3_000 {
            let mut pick = || exponents[(random.unit() * exponents.len() as f64) as usize];
            let (e, n) = (pick(), pick());
            let mut size = || 10f64.powf(-2.0 * random.unit());
            let radii = [size(), size(), size()];
            let radii = DVec3::from_array(if case % 5 == 0 { [radii[0], radii[0], radii[2]] } else { radii });
            let shape = Superquadric::new(radii, Exponents::new(e, n).unwrap()).unwrap();
            // Far, near, very near, and on planes of symmetry.
            let direction =
                DVec3::from_array(std::array::from_fn(
                    |axis| {
                        if case % 7 == axis { 0.0 } else { random.unit() }
                    },
                ));
            let on_surface = direction * radii / shape.norm().value(direction);
            let gap = [10.0, 0.5, 1e-2, 1e-6, 1e-10][case % 5 * 3 % 5];
            let away = DVec3::from_array(std::array::from_fn(|_| random.unit() * gap));
            let point = on_surface * (1.0 + 1e-3 * gap) + away;
            let unit = radii.max_element().max(point.max_element());
            if !on_surface.is_finite() || shape.norm().value(point / radii) < 1.0 {
                continue;
            }
            let search = Search::straight(&shape, radii / unit, point / unit);
            let limits = SearchLimits { most_cells: 5_000, ..SearchLimits::default() };
            let (fast, slow) = (search.run_from_outside(&limits), search.run(&limits));
            let is_proven = fast.error <= limits.relative_tolerance * fast.distance + 3.0 * ROUNDING;
            (proven, of_convex) = (
                proven + usize::from(is_proven && e < 2.0 && n < 2.0),
                of_convex + usize::from(e < 2.0 && n < 2.0),
            );
            let context = format!("{shape:?} {point} {fast:?} {slow:?}");
            assert!(fast.distance - fast.error <= slow.distance, "{context}");
            assert!(slow.distance - slow.error <= fast.distance, "{context}");
            let held = shape.norm().value(fast.point * unit / radii);
            assert!((held - 1.0).abs() < 1e-9 || e.max(n) > 2.0, "{held} {context}");
        }
        assert!(of_convex > 1_000 && proven * 100 >= of_convex * 99, "{proven} of {of_convex}");
    }
}
