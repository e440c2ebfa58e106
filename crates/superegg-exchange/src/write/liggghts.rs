//! LIGGGHTS: an input script, and a data file.
//!
//! Sizes are semi-axes, blockiness is 2/n and 2/e. The program refuses a blockiness below 2, so
//! exponents above 1.

use std::fmt::Write;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Transform};
use superegg_scene::Scene;

use super::flatten::Instances;
use super::losses::{self, MaterialKept};
use super::particles::{Particle, listed, particles};
use super::written::Written;

/// The density that files assume, in kg/m^3: a scene has none.
const DENSITY: f64 = 1000.0;
/// The smallest blockiness.
const LEAST_BLOCKINESS: f64 = 2.0;
/// The simulation box is larger than the particles by this part, on each side.
const MARGIN: f64 = 0.05;

/// An input script that creates the instances as particles of one type, with assumed material
/// properties, and runs no step.
pub fn to_input_script(scene: &Scene, instances: &Instances) -> Written {
    let (accepted, mut losses) = accepted(scene, instances);
    let bounds = simulation_box(&accepted);
    let largest = accepted.iter().map(|particle| particle.rigid.radii.max_element()).fold(0.0, f64::max);
    let [least, most] = [bounds.min, bounds.max].map(|corner| corner.to_array());
    let mut text = format!(
        "# Written by superegg. Density, stiffness and friction are assumed: set your own.\n\
         units si\natom_style superquadric\natom_modify map array\nboundary f f f\nnewton off\n\
         communicate single vel yes\n\
         region box block {} {} {} {} {} {} units box\ncreate_box 1 box\n\
         neighbor {} bin\nneigh_modify delay 0\n\
         fix m1 all property/global youngsModulus peratomtype 1e7\n\
         fix m2 all property/global poissonsRatio peratomtype 0.3\n\
         fix m3 all property/global coefficientRestitution peratomtypepair 1 0.5\n\
         fix m4 all property/global coefficientFriction peratomtypepair 1 0.5\n\
         pair_style gran model hertz tangential history surface superquadric\npair_coeff * *\n\
         timestep 1e-5\n",
        least[0],
        most[0],
        least[1],
        most[1],
        least[2],
        most[2],
        0.1 * largest
    );
    for particle in &accepted {
        let [x, y, z] = particle.rigid.position.to_array();
        let _ = writeln!(text, "create_atoms 1 single {x} {y} {z}");
    }
    for (index, particle) in accepted.iter().enumerate() {
        let ([a, b, c], [n1, n2]) = (particle.rigid.radii.to_array(), particle.blockiness());
        // The program takes the axis as it is: it must have length 1.
        let (axis, angle) = particle.rigid.rotation.to_axis_angle();
        let _ = writeln!(
            text,
            "set atom {} shape {a} {b} {c} blockiness {n1} {n2} density {DENSITY} quat {} {} {} {}",
            index + 1,
            axis.x,
            axis.y,
            axis.z,
            angle.to_degrees()
        );
    }
    text.push_str("fix integr all nve/superquadric integration_scheme 1\nrun 0\n");
    losses.push(format!(
        "density ({DENSITY} kg/m^3) and material properties are assumed; particles are numbered from 1"
    ));
    Written { bytes: text.into_bytes(), companion: None, losses }
}

/// A data file for `read_data`: id, type, density, semi-axes, blockiness, position. It has no
/// rotations.
pub fn to_data_file(scene: &Scene, instances: &Instances) -> Written {
    let (accepted, mut losses) = accepted(scene, instances);
    let bounds = simulation_box(&accepted);
    let mut text = format!("superegg\n\n{} atoms\n1 atom types\n\n", accepted.len());
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let _ = writeln!(text, "{} {} {name}lo {name}hi", bounds.min[axis], bounds.max[axis]);
    }
    text.push_str("\nAtoms\n\n");
    for particle in &accepted {
        let ([a, b, c], [n1, n2]) = (particle.rigid.radii.to_array(), particle.blockiness());
        let [x, y, z] = particle.rigid.position.to_array();
        let _ = writeln!(text, "{} 1 {DENSITY} {a} {b} {c} {n1} {n2} {x} {y} {z}", particle.id);
    }
    let turned: Vec<&str> = accepted
        .iter()
        .filter(|particle| particle.rigid.rotation.w.abs() < 1.0 - 1e-15)
        .map(|particle| particle.instance.path.as_str())
        .collect();
    losses.extend(listed(
        &turned,
        "a data file has no rotations; an input script (.liggghts) has. Turned instances",
    ));
    losses.push(format!("density ({DENSITY} kg/m^3) is assumed"));
    Written { bytes: text.into_bytes(), companion: None, losses }
}

/// The particles that the program accepts, and what is lost.
fn accepted<'a>(scene: &Scene, instances: &'a Instances) -> (Vec<Particle<'a>>, Vec<String>) {
    let (all, sheared) = particles(instances);
    let (accepted, refused): (Vec<_>, Vec<_>) = all
        .into_iter()
        .partition(|particle| particle.blockiness().iter().all(|&blockiness| blockiness >= LEAST_BLOCKINESS));
    let refused: Vec<&str> = refused.iter().map(|particle| particle.instance.path.as_str()).collect();
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::None));
    losses.push("names of primitives are not in the file".to_owned());
    losses.extend(sheared);
    losses
        .extend(listed(&refused, "LIGGGHTS refuses exponents above 1 (blockiness below 2). Not in the file"));
    (accepted, losses)
}

/// A box around the particles, with a margin.
fn simulation_box(particles: &[Particle<'_>]) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    for particle in particles {
        let Ok(shape) = superegg_geom::Superquadric::new(particle.rigid.radii, particle.exponents()) else {
            continue;
        };
        let map = Transform::rigid(particle.rigid.rotation, particle.rigid.position);
        bounds = bounds.union(&shape.bounds_under(&map));
    }
    if bounds.is_empty() {
        return Aabb::around(DVec3::ZERO, DVec3::ONE);
    }
    let margin = DVec3::splat(MARGIN * bounds.half_extent().max_element());
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}
