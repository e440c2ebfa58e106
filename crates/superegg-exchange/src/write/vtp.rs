//! VTK PolyData (.vtp) of particles, as LIGGGHTS's `dump custom/vtk` writes it and OVITO reads it:
//! uncompressed ASCII, with the arrays shapex, shapey, shapez (semi-axes), blockiness1 = 2/n,
//! blockiness2 = 2/e and TENSOR (the rotation, row by row).

use std::fmt::Write;

use superegg_geom::glam::DMat3;
use superegg_scene::Scene;

use super::flatten::Instances;
use super::losses::{self, MaterialKept};
use super::particles::{Particle, particles};
use super::written::Written;

/// The instances as points with the arrays of superquadric particles. ParaView shows them with its
/// glyph filter, OVITO as they are.
pub fn to_vtp(scene: &Scene, instances: &Instances) -> Written {
    let (particles, sheared) = particles(instances);
    let count = particles.len();
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n<PolyData>\n<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n"
    );
    let mut array = |name: &str, numbers: &dyn Fn(&Particle<'_>) -> Vec<f64>| {
        data_array(&mut text, "Float64", name, &particles, |particle| {
            numbers(particle).into_iter().map(|x| x.to_string()).collect()
        });
    };
    array("shapex", &|particle| vec![particle.rigid.radii.x]);
    array("shapey", &|particle| vec![particle.rigid.radii.y]);
    array("shapez", &|particle| vec![particle.rigid.radii.z]);
    array("blockiness1", &|particle| vec![particle.blockiness()[0]]);
    array("blockiness2", &|particle| vec![particle.blockiness()[1]]);
    array("TENSOR", &|particle| {
        let rows = DMat3::from_quat(particle.rigid.rotation).transpose();
        rows.to_cols_array().to_vec()
    });
    array("radius", &|particle| vec![particle.rigid.radii.max_element()]);
    array("Color", &|particle| particle.color().to_array().to_vec());
    data_array(&mut text, "Int64", "id", &particles, |particle| vec![particle.id.to_string()]);
    data_array(&mut text, "Int64", "type", &particles, |particle| {
        vec![(particle.instance.part + 1).to_string()]
    });
    text.push_str("</PointData>\n<Points>\n");
    data_array(&mut text, "Float64", "Points", &particles, |particle| {
        particle.rigid.position.to_array().map(|x| x.to_string()).to_vec()
    });
    text.push_str("</Points>\n<Verts>\n");
    let numbers = |first: usize| (0..count).map(|i| (i + first).to_string()).collect::<Vec<_>>().join(" ");
    for (name, first) in [("connectivity", 0), ("offsets", 1)] {
        let _ = writeln!(
            text,
            "<DataArray type=\"Int64\" Name=\"{name}\" format=\"ascii\">\n{}\n</DataArray>",
            numbers(first)
        );
    }
    text.push_str("</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n");
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::Color));
    losses.push("names of primitives are not in the file".to_owned());
    losses.extend(sheared);
    Written { bytes: text.into_bytes(), companion: None, losses }
}

/// An array with one line for each particle.
fn data_array(
    text: &mut String,
    kind: &str,
    name: &str,
    particles: &[Particle<'_>],
    row: impl Fn(&Particle<'_>) -> Vec<String>,
) {
    let components = match particles.first().map(|particle| row(particle).len()) {
        Some(components) if components > 1 => format!(" NumberOfComponents=\"{components}\""),
        _ => String::new(),
    };
    let _ = writeln!(text, "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"ascii\">");
    for particle in particles {
        text.push_str(&row(particle).join(" "));
        text.push('\n');
    }
    text.push_str("</DataArray>\n");
}
