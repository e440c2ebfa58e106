//! Vectors of EMS and Marching-Primitives: eleven numbers for each superquadric,
//!
//! ```text
//! e1 e2 a1 a2 a3 eulZ eulY eulX tx ty tz,   n = e1, e = e2, R = Rz Ry Rx in radians
//! ```
//!
//! as text, a row a line, or as a NumPy array of float64.

use std::fmt::Write;

use superegg_geom::glam::DMat3;
use superegg_scene::Scene;

use super::flatten::Instances;
use super::losses::{self, MaterialKept};
use super::particles::{Particle, particles};
use super::written::Written;

/// The numbers of a vector.
const COLUMNS: usize = 11;

/// The vectors as text.
pub fn to_ems_text(scene: &Scene, instances: &Instances) -> Written {
    let (rows, losses) = rows(scene, instances);
    let mut text = String::new();
    for row in rows {
        let _ = writeln!(text, "{}", row.map(|x| x.to_string()).join(" "));
    }
    Written { bytes: text.into_bytes(), companion: None, losses }
}

/// The vectors as a .npy file (format version 1.0): float64, one row each.
pub fn to_ems_npy(scene: &Scene, instances: &Instances) -> Written {
    const ALIGNMENT: usize = 64;
    let (rows, losses) = rows(scene, instances);
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {COLUMNS}), }}", rows.len());
    // The magic, the version and the length are ten bytes; a line end closes the header.
    let padding = (10 + header.len() + 1).next_multiple_of(ALIGNMENT) - (10 + header.len() + 1);
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    rows.iter().flatten().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
    Written { bytes, companion: None, losses }
}

fn rows(scene: &Scene, instances: &Instances) -> (Vec<[f64; COLUMNS]>, Vec<String>) {
    let (particles, sheared) = particles(instances);
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::None));
    losses.push("names of primitives are not in the file".to_owned());
    losses.extend(sheared);
    (particles.iter().map(row).collect(), losses)
}

fn row(particle: &Particle<'_>) -> [f64; COLUMNS] {
    let (exponents, rigid) = (particle.exponents(), &particle.rigid);
    let [a, b, c] = rigid.radii.to_array();
    let [z, y, x] = euler_zyx(&DMat3::from_quat(rigid.rotation));
    let [tx, ty, tz] = rigid.position.to_array();
    [exponents.n(), exponents.e(), a, b, c, z, y, x, tx, ty, tz]
}

/// The angles about z, y and x of `R = Rz Ry Rx`. Where y is a right angle x is 0.
fn euler_zyx(rotation: &DMat3) -> [f64; 3] {
    let (c0, c1, c2) = (rotation.x_axis, rotation.y_axis, rotation.z_axis);
    let across = c0.x.hypot(c0.y);
    let y = (-c0.z).atan2(across);
    if across > 1e-9 { [c0.y.atan2(c0.x), y, c1.z.atan2(c2.z)] } else { [(-c1.x).atan2(c1.y), y, 0.0] }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::{DQuat, DVec3, EulerRot};

    use super::*;

    #[test]
    fn the_angles_make_the_rotation() {
        for (axis, angle) in [
            (DVec3::new(1.0, 2.0, 3.0), 1.0),
            (DVec3::new(-1.0, 0.5, 0.2), 3.0),
            (DVec3::Y, std::f64::consts::FRAC_PI_2),
            (DVec3::Y, -std::f64::consts::FRAC_PI_2),
            (DVec3::X, 0.0),
        ] {
            let quat = DQuat::from_axis_angle(axis.normalize(), angle) * DQuat::from_rotation_x(0.3);
            let rotation = DMat3::from_quat(quat);
            let [z, y, x] = euler_zyx(&rotation);
            let again = DMat3::from_euler(EulerRot::ZYX, z, y, x);
            assert!((again - rotation).to_cols_array().iter().all(|x| x.abs() < 1e-8), "{axis} {angle}");
        }
    }
}
