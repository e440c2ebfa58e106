//! Wavefront OBJ with its materials (MTL).

use std::fmt::Write;

use superegg_scene::Scene;

use super::baked::{Rounding, distinct, for_each, world_tolerance};
use super::flatten::Instances;
use super::looks::{Look, looks, srgb};
use super::losses::{self, MaterialKept};
use super::meshes::{Meshes, Tolerance};
use super::ply::Precision;
use super::written::{WriteError, Written};

/// The instances as an OBJ file, each an object of its path's name, and the MTL file beside it, to
/// which the OBJ file refers as `materials`. Colours are in the sRGB encoding, which most readers
/// expect.
///
/// # Errors
/// A tolerance that is not possible, or coordinates beyond float32.
pub fn to_obj(
    scene: &Scene,
    instances: &Instances,
    tolerance: Tolerance,
    precision: Precision,
    materials: &str,
) -> Result<Written, WriteError> {
    let meshes = Meshes::of(instances, tolerance)?;
    meshes.baked_triangles(tolerance)?;
    let (looks, look_of_part) = looks(instances);
    let names: Vec<String> =
        looks.iter().enumerate().map(|(index, look)| format!("{}_{index}", word(&look.name))).collect();
    let mut text = format!("# superegg\nmtllib {materials}\n");
    let (mut first, mut rounding) = (1u32, Rounding::default());
    for_each(&meshes, |index, mesh, baked| {
        let instance = &instances.list[index];
        let within = world_tolerance(instances, index, tolerance);
        let positions = rounding.round(&baked.positions, within, &instance.path)?;
        let _ = writeln!(text, "o {}", word(&instance.path));
        for (exact, rounded) in baked.positions.iter().zip(&positions) {
            let _ = match precision {
                Precision::Single => writeln!(text, "v {} {} {}", rounded.x, rounded.y, rounded.z),
                Precision::Double => writeln!(text, "v {} {} {}", exact.x, exact.y, exact.z),
            };
        }
        for normal in &baked.normals {
            let normal = normal.as_vec3();
            let _ = writeln!(text, "vn {} {} {}", normal.x, normal.y, normal.z);
        }
        let _ = writeln!(text, "usemtl {}", names[look_of_part[instance.part]]);
        let mut face = |triangle: [u32; 3]| {
            let [a, b, c] = triangle.map(|corner| first + corner);
            let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
        };
        match precision {
            Precision::Single => distinct(mesh, &positions).for_each(&mut face),
            Precision::Double => mesh.triangles.iter().copied().for_each(&mut face),
        }
        first += mesh.positions.len() as u32;
        Ok(())
    })?;
    let mut losses = losses::of_scene(scene);
    losses.extend(losses::of_materials(instances, MaterialKept::Reflection));
    losses.extend(rounding.loss().filter(|_| precision == Precision::Single));
    let companion = Some(mtl(&looks, &names).into_bytes());
    Ok(Written { bytes: text.into_bytes(), companion, losses })
}

/// A name without blanks, which would end it.
fn word(name: &str) -> String {
    name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
}

fn mtl(looks: &[Look], names: &[String]) -> String {
    let mut text = "# superegg\n".to_owned();
    for (look, name) in looks.iter().zip(names) {
        let [r, g, b] = srgb(look.color).map(|x| x as f32);
        let specular = look.specular as f32;
        // A mirror is illumination model 3, a plain highlight 2.
        let model = if look.mirror > 0.0 { 3 } else { 2 };
        let _ = writeln!(
            text,
            "newmtl {name}\nKd {r} {g} {b}\nKs {specular} {specular} {specular}\nNs {}\nd {}\nillum {model}",
            (look.exponent as f32).clamp(0.0, 1000.0),
            look.opacity as f32,
        );
    }
    text
}
