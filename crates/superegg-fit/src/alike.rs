//! Shapes that are similar, or equal, with other parameters.

use superegg_geom::glam::{DMat3, DVec3};

use crate::parameters::{Bounds, Parameters};

/// The exponent of a section that is neither round nor square.
const BETWEEN: f64 = 0.6;
/// Sizes to try where one side is hidden.
const SIZES: [f64; 3] = [0.6, 0.8, 1.25];
/// The least distance of the middle of the points from the centre where a side counts as hidden, as
/// a part of the mean semi-axis.
const ONE_SIDED: f64 = 0.15;

/// Shapes that may be confused with this one, and that no short step leads to: other axes as the
/// third one with the exponents exchanged, sections turned by 45 degrees, and other sizes where the
/// points, whose middle is given, lie on one side.
pub(crate) fn alike(shape: &Parameters, middle: DVec3, bounds: Bounds) -> Vec<Parameters> {
    let exchanged = [0, 1].map(|axis| {
        let [e, n] = shape.exponents;
        Parameters { exponents: [n, e], ..with_third_axis(shape, axis) }
    });
    let mut shapes = exchanged.to_vec();
    shapes.extend([*shape, exchanged[0], exchanged[1]].map(|shape| with_turned_section(&shape, bounds)));
    let turned = shapes[2];
    shapes.push(Parameters { exponents: [bounds.clamp(BETWEEN), turned.exponents[1]], ..turned });
    if is_one_sided(shape, middle) {
        shapes.extend(SIZES.map(|size| scaled_from(shape, middle, size)));
    }
    shapes
}

/// The shape in another size, with its surface where it is on the side of a point.
fn scaled_from(shape: &Parameters, side: DVec3, size: f64) -> Parameters {
    let own = shape.axes.transpose() * (side - shape.center);
    // The reach of the ellipsoid is near enough.
    let reach = own / (own / shape.radii).length();
    let fixed = shape.center + shape.axes * reach;
    Parameters { center: fixed + size * (shape.center - fixed), radii: size * shape.radii, ..*shape }
}

/// Factors on one semi-axis, where the far side is hidden.
const STRETCHES: [f64; 2] = [0.87, 1.15];

/// Whether points whose middle is given lie on one side of the shape.
pub(crate) fn is_one_sided(shape: &Parameters, middle: DVec3) -> bool {
    (middle - shape.center).length() > ONE_SIDED * shape.size()
}

/// Shapes of other extents along one axis each, with the surface where it is on the side of a point.
pub(crate) fn stretched(shape: &Parameters, side: DVec3) -> Vec<Parameters> {
    let own = shape.axes.transpose() * (side - shape.center);
    let stretch = |axis: usize, factor: f64| {
        let mut other = *shape;
        other.radii[axis] *= factor;
        let shift = (shape.radii[axis] - other.radii[axis]) * 1.0_f64.copysign(own[axis]);
        other.center += shape.axes.col(axis) * shift;
        other
    };
    (0..3).flat_map(|axis| STRETCHES.map(|factor| stretch(axis, factor))).collect()
}

/// The same axes in another order: the axis `z` becomes the third one.
pub(crate) fn with_third_axis(shape: &Parameters, z: usize) -> Parameters {
    let order = [(z + 1) % 3, (z + 2) % 3, z];
    let [x, y, z] = order.map(|axis| shape.axes.col(axis));
    Parameters {
        axes: DMat3::from_cols(x, y, z),
        radii: DVec3::from_array(order.map(|axis| shape.radii[axis])),
        ..*shape
    }
}

/// The shape turned by 45 degrees about its third axis, with exponents and radii that keep its
/// section as nearly as a superellipse can.
fn with_turned_section(shape: &Parameters, bounds: Bounds) -> Parameters {
    let e = shape.exponents[0];
    // The section's reach along the diagonal, as a part of a semi-axis.
    let reach = 0.5_f64.powf(0.5 * e) * 2f64.sqrt();
    let radius = (shape.radii.x * shape.radii.y).sqrt() * reach;
    let turn = DMat3::from_rotation_z(std::f64::consts::FRAC_PI_4);
    Parameters {
        axes: shape.axes * turn,
        radii: DVec3::new(radius, radius, shape.radii.z),
        exponents: [bounds.clamp(2.0 - e), shape.exponents[1]],
        ..*shape
    }
}
