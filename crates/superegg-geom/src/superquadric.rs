//! The superquadric itself.

use std::ops::Deref;

use glam::{DMat3, DVec3};

use crate::math::numeric::{scale_to_unit, unit_vector};
use crate::math::ray::{Ray, RayStart};
use crate::norm::{BOUND_SHAPES, NormForm, support_bounds};
use crate::shape::{Exponents, ShapeError, ShapeHit, is_positive};
use crate::solve::span::BoxSpan;
use crate::solve::{certified, convex};

/// A superquadric centred at the origin, its axes along x, y and z. In coordinates divided by
/// `radii` it is the unit shape, which lies in the box [-1, 1]^3 and touches all six faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Superquadric {
    radii: DVec3,
    exponents: Exponents,
    norm: NormForm,
}

/// A superquadric that is known to be convex (e <= 2 and n <= 2): the argument of solvers that are
/// right for convex shapes alone. Only [`Superquadric::as_convex`] makes one.
///
/// ```compile_fail,E0423
/// use superegg_geom::{Convex, Exponents, Superquadric};
/// let star = Superquadric::unit(Exponents::new(3.0, 3.0).unwrap());
/// let convex = Convex(star);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convex(Superquadric);

impl Deref for Convex {
    type Target = Superquadric;

    fn deref(&self) -> &Superquadric {
        &self.0
    }
}

impl Superquadric {
    /// A superquadric from its semi-axes and exponents.
    ///
    /// ```
    /// use superegg_geom::{Exponents, ShapeError, Superquadric, glam::DVec3};
    /// let egg = Superquadric::new(DVec3::new(1.0, 1.0, 1.3), Exponents::new(1.0, 0.8)?)?;
    /// assert_eq!(egg.point_at(0.0, 0.0), DVec3::X);
    /// assert!(egg.inside_outside(DVec3::new(0.0, 0.0, 1.4)) > 0.0);
    /// # Ok::<(), ShapeError>(())
    /// ```
    ///
    /// # Errors
    /// [`ShapeError::Radius`] if a semi-axis is not finite and above 0.
    pub fn new(radii: DVec3, exponents: Exponents) -> Result<Self, ShapeError> {
        if !radii.to_array().into_iter().all(is_positive) {
            return Err(ShapeError::Radius);
        }
        Ok(Self { radii, exponents, norm: NormForm::new(exponents) })
    }

    /// The sphere of radius 1: what a new primitive is.
    pub fn unit_sphere() -> Self {
        Self::unit(Exponents::ROUND)
    }

    /// The superquadric of these exponents with semi-axes 1.
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric, glam::DVec3};
    /// assert_eq!(Superquadric::unit(Exponents::ROUND), Superquadric::unit_sphere());
    /// ```
    pub fn unit(exponents: Exponents) -> Self {
        Self { radii: DVec3::ONE, exponents, norm: NormForm::new(exponents) }
    }

    /// The semi-axes.
    pub fn radii(&self) -> DVec3 {
        self.radii
    }

    /// The exponents.
    pub fn exponents(&self) -> Exponents {
        self.exponents
    }

    /// The norm form of the unit shape.
    pub fn norm(&self) -> &NormForm {
        &self.norm
    }

    /// Whether the shape is convex: e <= 2 and n <= 2.
    pub fn is_convex(&self) -> bool {
        self.exponents.are_convex()
    }

    /// The shape as a [`Convex`] one; `None` where e or n is above 2.
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric};
    /// assert!(Superquadric::unit_sphere().as_convex().is_some());
    /// assert!(Superquadric::unit(Exponents::new(3.0, 1.0)?).as_convex().is_none());
    /// # Ok::<(), superegg_geom::ShapeError>(())
    /// ```
    pub fn as_convex(&self) -> Option<Convex> {
        self.is_convex().then_some(Convex(*self))
    }

    /// The inside-outside function at a point of the shape's space: < 0 inside, 0 on the surface, >
    /// 0 outside, +inf where it leaves the range of f64 (course text, 4.1.1).
    ///
    /// ```
    /// use superegg_geom::{Superquadric, glam::DVec3};
    /// let sphere = Superquadric::unit_sphere();
    /// assert_eq!(sphere.inside_outside(DVec3::ZERO), -1.0);
    /// assert_eq!(sphere.inside_outside(DVec3::new(2.0, 0.0, 0.0)), 3.0);
    /// ```
    pub fn inside_outside(&self, point: DVec3) -> f64 {
        self.norm.inside_outside(point / self.radii)
    }

    /// The unit outward normal at a point of the surface; at any other point, the direction of the
    /// gradient. Where the normal is not unique (edges, creases, poles) it is a fixed choice among
    /// the valid ones; at the centre it is +z.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let (_, gradient) = self.norm.value_and_gradient(point / self.radii);
        unit_vector(gradient / self.radii).unwrap_or(DVec3::Z)
    }

    /// The point with longitude u in (-pi, pi] and latitude v in [-pi/2, pi/2], in radians (course
    /// text, 4.1.3):
    ///
    /// ```text
    /// (c(v, n) c(u, e),  c(v, n) s(u, e),  s(v, n)) * radii,   c(t, w) = sign(cos t) |cos t|^w,  s likewise with sin
    /// ```
    pub fn point_at(&self, u_rad: f64, v_rad: f64) -> DVec3 {
        // 0 to any power is 0: for an exponent of 0 the limit of small ones.
        let power = |x: f64, w: f64| if x == 0.0 { 0.0 } else { x.abs().powf(w).copysign(x) };
        let (e, n) = (self.exponents.e(), self.exponents.n());
        let around = power(v_rad.cos(), n);
        DVec3::new(around * power(u_rad.cos(), e), around * power(u_rad.sin(), e), power(v_rad.sin(), n))
            * self.radii
    }

    /// The outward unit normal at longitude u and latitude v, in radians:
    ///
    /// ```text
    /// (c(v, 2 - n) c(u, 2 - e) / a,  c(v, 2 - n) s(u, 2 - e) / b,  s(v, 2 - n) / c), at unit length
    /// ```
    ///
    /// (Barr 1981) with c and s of [`Superquadric::point_at`]. It is more exact than the normal at
    /// that point, whose coordinates cannot resolve the edges of a box. On creases, where the normal
    /// is not unique, the component of a sine or cosine that is 0 is 0.
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric, glam::DVec3};
    /// let nearly_cube = Superquadric::unit(Exponents::new(1e-4, 1e-4)?);
    /// let quarter = std::f64::consts::FRAC_PI_4;
    /// let edge = nearly_cube.normal_at(quarter, 0.0);
    /// assert!((edge - DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0)).length() < 1e-12);
    /// # Ok::<(), superegg_geom::ShapeError>(())
    /// ```
    pub fn normal_at(&self, u_rad: f64, v_rad: f64) -> DVec3 {
        let power = |x: f64, w: f64| if x == 0.0 { 0.0 } else { x.abs().powf(w).copysign(x) };
        let (e, n) = (2.0 - self.exponents.e(), 2.0 - self.exponents.n());
        let around = power(v_rad.cos(), n);
        let section = DVec3::new(power(u_rad.cos(), e), power(u_rad.sin(), e), 0.0);
        let normal = (around * section + power(v_rad.sin(), n) * DVec3::Z) / self.radii;
        // Infinity times 0: the factor 0 is exact, the infinite one is not.
        let normal = normal.map(|x| if x.is_nan() { 0.0 } else { x });
        unit_vector(normal).unwrap_or(DVec3::Z)
    }

    /// The longitude u in (-pi, pi] and latitude v in [-pi/2, pi/2] of a point of the surface, in
    /// radians: the inverse of [`Superquadric::point_at`]. Any other point has those of the surface
    /// point on the ray from the centre through it; the centre has (0, 0), and a pole u = 0.
    ///
    /// ```text
    /// u = atan2(sign(y) |y|^(1/e), sign(x) |x|^(1/e)),   v = atan2(sign(z) |z|^(1/n), R(x, y)^(1/n))
    /// ```
    ///
    /// Angles near a multiple of pi/2 other than 0 have few digits left: for exponents below about
    /// 0.1 they do not determine the point to more than a few digits, below 0.003 most points of a
    /// face share the angles of its middle.
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric, glam::DVec3};
    /// let egg = Superquadric::new(DVec3::new(1.0, 2.0, 3.0), Exponents::new(0.8, 1.5)?)?;
    /// let (u, v) = egg.uv_at(egg.point_at(2.5, -0.3));
    /// assert!((u - 2.5).abs() < 1e-14 && (v + 0.3).abs() < 1e-14);
    /// # Ok::<(), superegg_geom::ShapeError>(())
    /// ```
    pub fn uv_at(&self, point: DVec3) -> (f64, f64) {
        let unit = point / self.radii;
        let around = self.norm.xy.value(unit.x.abs(), unit.y.abs());
        let u = power_angle(unit.x, unit.y, 1.0 / self.exponents.e());
        (u, power_angle(around, unit.z, 1.0 / self.exponents.n()))
    }

    /// Half the edges of the smallest axis-aligned box around the shape's image under a linear map.
    /// The box is centred on the image of the origin, and tight for every pair of exponents: its
    /// size is the support function.
    pub fn half_extent_under(&self, linear: &DMat3) -> DVec3 {
        let rows = linear.transpose();
        DVec3::new(
            self.norm.support(rows.x_axis * self.radii),
            self.norm.support(rows.y_axis * self.radii),
            self.norm.support(rows.z_axis * self.radii),
        )
    }

    /// As [`Superquadric::half_extent_under`], for four shapes of semi-axes 1 and their maps, but up to
    /// 1e-5 of it too large, in a tenth of the time: for boxes of many shapes.
    pub fn unit_half_extent_bounds(
        exponents: &[Exponents; BOUND_SHAPES],
        linear: [&DMat3; BOUND_SHAPES],
    ) -> [DVec3; BOUND_SHAPES] {
        support_bounds(exponents, linear.map(|map| [&map.x_axis, &map.y_axis, &map.z_axis]))
    }

    /// The first crossing of the ray with the surface at t >= 0, inwards or outwards. A ray that
    /// touches the surface without crossing it has no hit there.
    ///
    /// For e, n <= 2 Newton's method on the norm form starts at the unit box and cannot miss. For
    /// other exponents the search isolates roots with bounds (see ARCHITECTURE.md). The error of
    /// `t` is about 1e-12 (1 + t) unless the ray grazes the shape.
    ///
    /// A ray that is not finite, or whose direction is zero, hits nothing.
    ///
    /// ```
    /// use superegg_geom::{Ray, RayStart, Superquadric, glam::DVec3};
    /// let hit = Superquadric::unit_sphere()
    ///     .intersect(&Ray::new(DVec3::new(0.0, 0.0, 10.0), DVec3::NEG_Z), RayStart::Free)
    ///     .unwrap();
    /// assert_eq!((hit.t, hit.leaving), (9.0, false));
    /// ```
    pub fn intersect(&self, ray: &Ray, start: RayStart) -> Option<ShapeHit> {
        self.intersect_by(self.solver(), ray, start)
    }

    /// The number of Newton steps that [`Superquadric::intersect`] takes to its hit. `None` without
    /// a hit, and for a shape that is not convex: its solver isolates roots with bounds instead.
    ///
    /// ```
    /// use superegg_geom::{Ray, RayStart, Superquadric, glam::DVec3};
    /// let (sphere, from) = (Superquadric::unit_sphere(), DVec3::new(0.3, 0.2, 10.0));
    /// let steps = sphere.newton_steps(&Ray::new(from, DVec3::NEG_Z), RayStart::Free);
    /// assert!(steps.is_some_and(|steps| (1..100).contains(&steps)));
    /// assert_eq!(sphere.newton_steps(&Ray::new(from, DVec3::Z), RayStart::Free), None);
    /// ```
    pub fn newton_steps(&self, ray: &Ray, start: RayStart) -> Option<u32> {
        let local = self.unit_ray(ray, start).filter(|_| self.is_convex())?;
        let span = BoxSpan::of(local.origin, local.direction)?;
        convex::solve(&self.norm, &span, local.start).map(|(_, steps)| steps)
    }

    /// Whether the ray crosses the surface with 0 <= t < `t_max`: the query of a shadow ray. For a
    /// ray from outside the unit box a point inside the shape proves a crossing, so most answers
    /// cost one evaluation of N. The other answers are those of [`Superquadric::intersect`].
    pub fn occluded(&self, ray: &Ray, start: RayStart, t_max: f64) -> bool {
        let Some(local) = self.unit_ray(ray, start) else { return false };
        let Some(span) = BoxSpan::of(local.origin, local.direction) else { return false };
        let t_max = t_max / local.t_scale;
        let length = span.length.min(t_max - span.t_in);
        // A ray from outside the box that has a point inside the shape crosses the surface before
        // it. A start on the surface proves nothing: rounding may put the first stretch on either
        // side.
        if local.start == RayStart::Free && !span.starts_inside_box && length > 0.0 {
            let middle = span.point_in + (0.5 * length) * span.direction;
            if self.norm.value(middle) < 1.0 {
                return true;
            }
        }
        self.solver()(&self.norm, &span, local.start).is_some_and(|hit| hit.t < t_max)
    }

    fn solver(&self) -> Solver {
        if self.is_convex() { convex::intersect } else { certified::intersect }
    }

    /// [`Superquadric::intersect`] by the certified search alone, whatever the exponents: the slow
    /// reference that tests compare the convex solver with.
    #[cfg(any(test, feature = "baseline"))]
    pub fn intersect_certified(&self, ray: &Ray, start: RayStart) -> Option<ShapeHit> {
        self.intersect_by(certified::intersect, ray, start)
    }

    /// Solves in the space of the unit shape and maps the hit back.
    fn intersect_by(&self, solve: Solver, ray: &Ray, start: RayStart) -> Option<ShapeHit> {
        let local = self.unit_ray(ray, start)?;
        let hit = solve(&self.norm, &BoxSpan::of(local.origin, local.direction)?, local.start)?;
        Some(ShapeHit { t: hit.t * local.t_scale, point: hit.point * self.radii, ..hit })
    }

    /// The ray in the space of the unit shape; `None` where it is not finite, has no direction, or leaves the shape and its box.
    fn unit_ray(&self, ray: &Ray, start: RayStart) -> Option<UnitRay> {
        let origin = ray.origin / self.radii;
        // Twice, since a quotient may leave the range of f64 where the direction is long and the
        // radii small.
        let (direction, first_scale) = scale_to_unit(ray.direction)?;
        let (direction, second_scale) = scale_to_unit(direction / self.radii)?;
        if !origin.is_finite() {
            return None;
        }
        let start = if start == RayStart::Free && ray.origin_error > 0.0 {
            self.start_within_error(origin, direction, ray.origin_error / self.radii.min_element())
        } else {
            start
        };
        // Close to n = 0 a point that is rounded below a face looks like one inside, however close it is.
        let error = ray.origin_error / self.radii + DVec3::splat(4.0 * f64::EPSILON);
        let is_on_face = origin.abs().cmpge(DVec3::ONE - error);
        if start == RayStart::SurfaceOutward && (is_on_face & (origin * direction).cmpge(DVec3::ZERO)).any() {
            return None;
        }
        Some(UnitRay { origin, direction, start, t_scale: second_scale * first_scale })
    }

    /// The start of a ray whose origin is a computed point: on this surface if it lies within its
    /// error of the surface and the ray leads outwards.
    fn start_within_error(&self, origin: DVec3, direction: DVec3, error: f64) -> RayStart {
        let (norm, gradient) = self.norm.value_and_gradient(origin);
        let slope: f64 = gradient.abs().to_array().iter().sum();
        if (norm - 1.0).abs() <= error * slope && gradient.dot(direction) >= 0.0 {
            RayStart::SurfaceOutward
        } else {
            RayStart::Free
        }
    }
}

/// The angle of the vector (sign(x) |x|^w, sign(y) |y|^w), in (-pi, pi].
fn power_angle(x: f64, y: f64, w: f64) -> f64 {
    let larger = x.abs().max(y.abs());
    if larger == 0.0 {
        return 0.0;
    }
    let power = |c: f64| (c.abs() / larger).powf(w).copysign(c);
    // Adding 0 turns -0 into 0, and so -pi into pi.
    (power(y) + 0.0).atan2(power(x))
}

/// A solver in the space of the unit shape.
type Solver = fn(&NormForm, &BoxSpan, RayStart) -> Option<ShapeHit>;

/// A ray in the space of the unit shape.
struct UnitRay {
    origin: DVec3,
    /// Its largest component is in [1, 2).
    direction: DVec3,
    start: RayStart,
    /// Converts t here to lengths of the ray's own direction.
    t_scale: f64,
}
