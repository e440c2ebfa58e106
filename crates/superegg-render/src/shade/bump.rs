//! Bumps: a shading normal that is not the normal of the surface (Blinn 1978).
//!
//! Rays hit the shape itself, shadows and silhouettes are its own; only the light at a point is that of a surface with
//! another normal. Three rules keep that in order:
//!
//! - Matt light and highlights take the turned normal as it is. Light from below the surface itself counts for nothing, and
//!   that from its horizon fades in by the shadowing of facets of the same tilt (Estevez, Lecocq and Stein 2019), so that bumps
//!   show no hard edge where the shape turns away from the light.
//! - Mirrors, glass and facets need a normal that the eye sees, and whose mirrored ray leaves the surface. Where the turned
//!   normal is none, it is turned less ([`Bump::mirror`]).
//! - Both only take light away: a white surface in a white world is never brighter than that.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

/// The normals of light at a point with bumps, on the side of the ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bump {
    /// The unit normal of the surface with its bumps. It may face away from the eye.
    pub(crate) normal: DVec3,
    /// The unit normal of mirrors: `normal`, or one between it and that of the shape.
    pub(crate) mirror: DVec3,
    /// The squared roughness of the facets that stand for the bumps at the horizon.
    alpha_squared: f64,
}

impl Bump {
    /// The bump that turns the unit normal `facing` of the shape to `normal`; both are on the side of `to_eye`'s ray.
    pub(crate) fn new(facing: DVec3, normal: DVec3, to_eye: DVec3) -> Self {
        let cos = facing.dot(normal);
        let tan_squared = if cos > 0.0 { (cos * cos).recip() - 1.0 } else { f64::INFINITY };
        Self {
            normal,
            mirror: mirror_normal(facing, normal, to_eye),
            alpha_squared: (0.125 * tan_squared).clamp(0.0, 1.0),
        }
    }

    /// The part of the light from a unit direction at this cosine to the normal of the shape that reaches the surface: 0 from
    /// below.
    pub(crate) fn open_part(&self, cos: f64) -> f64 {
        if cos <= 0.0 {
            return 0.0;
        }
        let tan_squared = ((cos * cos).recip() - 1.0).max(0.0);
        2.0 / (1.0 + (1.0 + self.alpha_squared * tan_squared).sqrt())
    }
}

/// The normal between `facing` and `normal`, as far towards the latter as the ray from the eye is still mirrored away from the
/// surface. The eye then sees it, too.
fn mirror_normal(facing: DVec3, normal: DVec3, to_eye: DVec3) -> DVec3 {
    /// The least cosine of a mirrored ray to `facing`, unless the eye itself is lower.
    const LEAST: f64 = 0.01;
    let cos = facing.dot(normal).clamp(-1.0, 1.0);
    let height = facing.dot(to_eye);
    let Some(aside) = unit_vector(normal - cos * facing) else { return facing };
    if height <= 0.0 {
        return facing;
    }
    // In the plane of both normals the ray to the eye has the length `reach` and the angle `toward` to `facing`. Mirrored at a
    // normal of angle a it has the angle 2 a - toward.
    let sideways = aside.dot(to_eye);
    let (reach, toward) = (height.hypot(sideways), sideways.atan2(height));
    let most = 0.5 * (toward + (height.min(LEAST) / reach).min(1.0).acos());
    let angle = cos.acos().min(most.max(0.0));
    let (sin, cos) = angle.sin_cos();
    (cos * facing + sin * aside).normalize()
}

/// The unit normal of a surface that rises along its normal by a height of this gradient. The normal, of any length, and the
/// gradient are those of the primitive's own space, whose axes are `axes` in the world. `None` if nothing is turned.
pub(crate) fn bumped_normal(normal: DVec3, gradient: DVec3, axes: [DVec3; 3]) -> Option<DVec3> {
    let normal = unit_vector(normal)?;
    let along = gradient - gradient.dot(normal) * normal;
    if along == DVec3::ZERO || !along.is_finite() {
        return None;
    }
    let turned = normal - along;
    // Normals are mapped by the cofactors of the axes, in proportion.
    let largest = axes.iter().map(|axis| axis.abs().max_element()).fold(0.0, f64::max);
    let [x, y, z] = axes.map(|axis| axis / largest);
    let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
    let in_world = turned.x * cofactors[0] + turned.y * cofactors[1] + turned.z * cofactors[2];
    let handed = x.dot(cofactors[0]).signum();
    unit_vector(handed * in_world).filter(|normal| normal.is_finite())
}
