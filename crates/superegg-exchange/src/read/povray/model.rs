//! The content of a POV-Ray scene, before it becomes a script.

use std::rc::Rc;

use superegg_geom::TransformStep;
use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};

/// The look of a surface. The defaults are POV-Ray's.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Surface {
    pub(crate) color: DVec3,
    /// The weight of light that passes: filter and transmit together.
    pub(crate) through: f64,
    pub(crate) ambient: f64,
    pub(crate) diffuse: f64,
    pub(crate) specular: f64,
    /// The exponent of the highlight.
    pub(crate) shininess: Option<f64>,
    /// The weights of mirrored light head on and at grazing angles.
    pub(crate) reflection: [f64; 2],
    /// Whether Fresnel's law leads from one weight to the other.
    pub(crate) fresnel: bool,
    pub(crate) index: Option<f64>,
    /// The absorption inside, per unit.
    pub(crate) absorb: DVec3,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            color: DVec3::ZERO,
            through: 0.0,
            ambient: 0.1,
            diffuse: 0.6,
            specular: 0.0,
            shininess: None,
            reflection: [0.0; 2],
            fresnel: false,
            index: None,
            absorb: DVec3::ZERO,
        }
    }
}

/// A shape, a union, or a use of a declared object.
#[derive(Debug)]
pub(crate) struct Node {
    pub(crate) kind: NodeKind,
    pub(crate) steps: Vec<TransformStep>,
    pub(crate) surface: Option<Rc<Surface>>,
    /// The name under which it is declared.
    pub(crate) name: Option<String>,
    /// The levels of objects below and with this one.
    pub(crate) levels: usize,
}

/// The kind of a node.
#[derive(Debug)]
pub(crate) enum NodeKind {
    /// A superellipsoid of half width 1 with the exponents (e, n).
    Shape([f64; 2]),
    Union(Vec<Rc<Node>>),
    Use(Rc<Node>),
}

/// A light source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightSource {
    pub(crate) position: DVec3,
    pub(crate) color: DVec3,
    pub(crate) target: DVec3,
    /// The half angles, in degrees, of full light and of none.
    pub(crate) cone: Option<[f64; 2]>,
    pub(crate) is_parallel: bool,
    /// The attenuation k in `1 / (1 + k d^2)`.
    pub(crate) attenuation: f64,
    pub(crate) radius: f64,
}

/// A camera: right and up span the picture at the end of the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PovCamera {
    pub(crate) location: DVec3,
    pub(crate) direction: DVec3,
    pub(crate) right: DVec3,
    pub(crate) up: DVec3,
    pub(crate) is_orthographic: bool,
    pub(crate) aperture: f64,
    pub(crate) focal_point: Option<DVec3>,
}

impl Default for PovCamera {
    fn default() -> Self {
        Self {
            location: DVec3::ZERO,
            direction: DVec3::Z,
            right: DVec3::X * (4.0 / 3.0),
            up: DVec3::Y,
            is_orthographic: false,
            aperture: 0.0,
            focal_point: None,
        }
    }
}

/// An infinite plane.
#[derive(Debug)]
pub(crate) struct Plane {
    pub(crate) normal: DVec3,
    pub(crate) height: f64,
    pub(crate) surface: Option<Rc<Surface>>,
}

/// A scene.
#[derive(Debug, Default)]
pub(crate) struct PovScene {
    pub(crate) objects: Vec<Rc<Node>>,
    pub(crate) lights: Vec<LightSource>,
    pub(crate) camera: Option<PovCamera>,
    pub(crate) plane: Option<Plane>,
    pub(crate) background: Option<DVec3>,
}

/// The map of steps, the first acting first.
pub(crate) fn map_of(steps: &[TransformStep]) -> DAffine3 {
    steps.iter().fold(DAffine3::IDENTITY, |map, step| {
        let next = match step {
            TransformStep::Translate(by) => DAffine3::from_translation(*by),
            TransformStep::Scale(factors) => DAffine3::from_scale(*factors),
            TransformStep::Rotate { axis, angle_deg } => {
                DAffine3::from_axis_angle(axis.normalize_or_zero(), angle_deg.to_radians())
            }
            TransformStep::Orient(rotation) => DAffine3::from_quat(rotation.normalize()),
            TransformStep::Affine(map) => **map,
        };
        next * map
    })
}

/// The steps of an affine map: scales between two rotations, and a translation. `None` if the map
/// flattens space.
pub(crate) fn steps_of(map: &DAffine3) -> Option<Vec<TransformStep>> {
    let matrix = map.matrix3;
    if !map.is_finite() {
        return None;
    }
    // The singular values by rotations of the columns against each other (one-sided Jacobi).
    let mut columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let mut first = DMat3::IDENTITY;
    for _ in 0..60 {
        let mut worst: f64 = 0.0;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let dot = columns[p].dot(columns[q]);
            let (a, b) = (columns[p].length(), columns[q].length());
            if a == 0.0 || b == 0.0 {
                return None;
            }
            worst = worst.max((dot / a / b).abs());
            if dot.abs() <= f64::EPSILON * a * b {
                continue;
            }
            let zeta = (b * b - a * a) / (2.0 * dot);
            let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let cosine = (1.0 + t * t).sqrt().recip();
            let sine = cosine * t;
            let turned = |p: DVec3, q: DVec3| (cosine * p - sine * q, sine * p + cosine * q);
            (columns[p], columns[q]) = turned(columns[p], columns[q]);
            let mut axes = [first.x_axis, first.y_axis, first.z_axis];
            (axes[p], axes[q]) = turned(axes[p], axes[q]);
            first = DMat3::from_cols(axes[0], axes[1], axes[2]);
        }
        if worst <= 2.0 * f64::EPSILON {
            break;
        }
    }
    // matrix * first = columns, which are at right angles.
    let mut factors = DVec3::from_array(columns.map(DVec3::length));
    if !(factors.min_element() > 0.0 && factors.is_finite()) {
        return None;
    }
    let mut second = DMat3::from_cols(columns[0] / factors.x, columns[1] / factors.y, columns[2] / factors.z);
    if second.determinant() < 0.0 {
        factors.z = -factors.z;
        second.z_axis = -second.z_axis;
    }
    let mut steps = Vec::new();
    steps.extend(rotation_step(&first.transpose()));
    if factors != DVec3::ONE {
        steps.push(TransformStep::Scale(factors));
    }
    steps.extend(rotation_step(&second));
    if map.translation != DVec3::ZERO {
        steps.push(TransformStep::Translate(map.translation));
    }
    Some(steps)
}

fn rotation_step(rotation: &DMat3) -> Option<TransformStep> {
    if *rotation == DMat3::IDENTITY {
        return None;
    }
    let (axis, angle) = DQuat::from_mat3(rotation).normalize().to_axis_angle();
    (angle != 0.0).then(|| TransformStep::Rotate { axis, angle_deg: angle.to_degrees() })
}

/// A step seen in the mirror z -> -z.
pub(crate) fn mirrored(step: &TransformStep) -> TransformStep {
    match step {
        TransformStep::Translate(by) => TransformStep::Translate(mirror(*by)),
        TransformStep::Scale(factors) => TransformStep::Scale(*factors),
        TransformStep::Rotate { axis, angle_deg } => {
            TransformStep::Rotate { axis: -mirror(*axis), angle_deg: *angle_deg }
        }
        TransformStep::Orient(q) => TransformStep::Orient(DQuat::from_xyzw(-q.x, -q.y, q.z, q.w)),
        TransformStep::Affine(map) => {
            let flip = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
            TransformStep::Affine(Box::new(flip * **map * flip))
        }
    }
}

/// A point or direction in the mirror z -> -z.
pub(crate) fn mirror(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.y, -v.z)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn distance(a: &DAffine3, b: &DAffine3) -> f64 {
        let d = a.to_cols_array().into_iter().zip(b.to_cols_array()).map(|(a, b)| (a - b).abs());
        d.fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn an_affine_map_is_its_steps(numbers in prop::array::uniform12(-3.0..3.0_f64)) {
            let map = DAffine3::from_cols_array(&numbers);
            prop_assume!(map.matrix3.determinant().abs() > 1e-3);
            let steps = steps_of(&map).unwrap();
            prop_assert!(distance(&map_of(&steps), &map) < 1e-13);
            let through: Vec<TransformStep> = steps.iter().map(mirrored).collect();
            let flip = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
            prop_assert!(distance(&map_of(&through), &(flip * map * flip)) < 1e-13);
        }
    }

    #[test]
    fn simple_maps_have_simple_steps() {
        let scale = DAffine3::from_scale(DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(steps_of(&scale).unwrap(), [TransformStep::Scale(DVec3::new(2.0, 3.0, 4.0))]);
        assert_eq!(steps_of(&DAffine3::IDENTITY).unwrap(), []);
        let turned = DAffine3::from_rotation_z(0.5) * scale;
        assert_eq!(steps_of(&turned).unwrap().len(), 2);
        assert_eq!(steps_of(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))), None);
        assert_eq!(steps_of(&DAffine3::from_scale(DVec3::splat(f64::NAN))), None);
        let flat = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::X * 2.0, DVec3::Z));
        assert!(steps_of(&flat).is_none_or(|steps| distance(&map_of(&steps), &flat) < 1e-12));
    }
}
