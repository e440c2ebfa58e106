//! A table of superquadrics (.csv) with named columns:
//!
//! ```text
//! id,x,y,z,qw,qx,qy,qz,a,b,c,e,n,red,green,blue,name
//! ```
//!
//! Position, rotation (body to world), semi-axes, exponents, the linear base colour, and the path.

use std::fmt::Write;

use superegg_scene::Scene;

use super::flatten::Instances;
use super::losses::{self, MaterialKept};
use super::particles::particles;
use super::written::Written;

const HEADER: &str = "id,x,y,z,qw,qx,qy,qz,a,b,c,e,n,red,green,blue,name\n";

/// The instances as a CSV table.
pub fn to_csv(scene: &Scene, instances: &Instances) -> Written {
    let (particles, sheared) = particles(instances);
    let mut text = HEADER.to_owned();
    for particle in &particles {
        let (rigid, exponents) = (&particle.rigid, particle.exponents());
        let numbers = rigid.position.to_array().into_iter().chain(rigid.quaternion());
        let numbers = numbers.chain(rigid.radii.to_array()).chain([exponents.e(), exponents.n()]);
        let _ = write!(text, "{}", particle.id);
        for x in numbers.chain(particle.color().to_array()) {
            let _ = write!(text, ",{x}");
        }
        let _ = writeln!(text, ",{}", field(&particle.instance.path));
    }
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::Color));
    losses.extend(sheared);
    Written { bytes: text.into_bytes(), companion: None, losses }
}

/// A text field, quoted where it must be (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
