//! `superegg measure`: volume, area, centre, inertia and bounding box.

use anyhow::{Context, Result};
use serde_json::{Value, json};
use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::{Aabb, SurfaceArea};
use superegg_lang::format_number;
use superegg_trace::{CompiledScene, MassProperties, PlacedPrimitive, SceneMeasures, UnionProperties};

use crate::args::MeasureArgs;
use crate::commands::input::{MOST_INSTANCES, load_compiled, too_many_instances};
use crate::console;
use crate::outcome::Outcome;
use crate::text::{counted, visible_json};

pub(crate) fn run(args: &MeasureArgs) -> Result<Outcome> {
    let (loaded, compiled) = load_compiled(&args.scene, &args.root)?;
    let measures =
        SceneMeasures::of(&compiled, MOST_INSTANCES).with_context(|| too_many_instances(&compiled))?;
    let union = (args.samples > 0).then(|| measures.union(args.samples as usize, args.seed));
    let report = Report { scene: &compiled, measures: &measures, union, most_rows: args.rows as usize };
    if args.json {
        console::print_raw(visible_json(&serde_json::to_string_pretty(&report.json())?))?;
    } else {
        console::print(report.text())?;
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}

struct Report<'a> {
    scene: &'a CompiledScene,
    measures: &'a SceneMeasures<'a>,
    union: Option<UnionProperties>,
    most_rows: usize,
}

/// The measures of one instance.
struct Row {
    path: String,
    primitive: String,
    mass: MassProperties,
    area: SurfaceArea,
    bounds: Aabb,
}

impl Report<'_> {
    /// The measures of each instance; of none if there are more than the limit.
    fn rows(&self) -> Vec<Row> {
        let instances = self.measures.instances();
        let listed = if instances.len() > self.most_rows { &[] } else { instances };
        let row = |(placed, area): (&PlacedPrimitive, &SurfaceArea)| Row {
            path: self.scene.path_name(&placed.path),
            primitive: self.scene.primitive_name(placed.primitive).unwrap_or_default().to_owned(),
            mass: self.measures.mass_of(placed),
            area: *area,
            bounds: self.measures.bounds_of(placed),
        };
        listed.iter().zip(self.measures.areas()).map(row).collect()
    }

    /// A remark on what the report leaves out.
    fn note(&self) -> Option<String> {
        let count = self.measures.instances().len();
        (count > self.most_rows).then(|| {
            format!("{count} instances, more than {}: totals only (--rows N lists more)", self.most_rows)
        })
    }

    fn text(&self) -> String {
        let mut lines = Vec::new();
        for Row { path, mass, area, bounds, .. } in self.rows() {
            lines.push(format!(
                "{path}\n{}\n  area {} (relative error {:.0e})\n{}",
                text_of_mass(&mass),
                format_number(area.value),
                area.relative_error,
                text_of_box(&bounds)
            ));
        }
        let count = self.measures.instances().len();
        lines.extend(self.note());
        lines.push(format!(
            "sum of {}\n{}\n  area {}\n{}",
            counted(count, "instance"),
            text_of_mass(&self.measures.total_mass()),
            format_number(self.measures.total_area()),
            text_of_box(&self.measures.bounds())
        ));
        if let Some(union) = &self.union {
            lines.push(format!(
                "union, from {} (standard errors: volume {}, area {}, centre {})\n{}\n  area {}",
                counted(union.samples, "sample"),
                format_number(union.volume_error),
                format_number(union.area.error),
                triple(union.center_error),
                text_of_mass(&union.mass),
                format_number(union.area.value),
            ));
        }
        lines.join("\n")
    }

    fn json(&self) -> Value {
        let rows: Vec<Value> = self.rows().iter().map(json_of_row).collect();
        let total = self.measures.total_mass();
        let bounds = self.measures.bounds();
        let mut report = json!({
            "instance_count": self.measures.instances().len(),
            "instances": rows,
            "sum": {
                "volume": total.volume,
                "area": self.measures.total_area(),
                "center": total.center.to_array(),
                "inertia": json_of_tensor(&total.inertia),
                "principal_moments": total.principal_moments(),
                "box": json_of_box(&bounds),
            },
        });
        if let Some(note) = self.note() {
            report["note"] = note.into();
        }
        if let Some(union) = &self.union {
            report["union"] = json!({
                "volume": union.mass.volume,
                "volume_error": union.volume_error,
                "area": union.area.value,
                "area_error": union.area.error,
                "center": union.mass.center.to_array(),
                "center_error": union.center_error.to_array(),
                "inertia": json_of_tensor(&union.mass.inertia),
                "principal_moments": union.mass.principal_moments(),
                "box": json_of_box(&bounds),
                "samples": union.samples,
            });
        }
        report
    }
}

fn json_of_row(row: &Row) -> Value {
    json!({
        "path": row.path,
        "primitive": row.primitive,
        "volume": row.mass.volume,
        "area": row.area.value,
        "area_relative_error": row.area.relative_error,
        "center": row.mass.center.to_array(),
        "inertia": json_of_tensor(&row.mass.inertia),
        "principal_moments": row.mass.principal_moments(),
        "box": json_of_box(&row.bounds),
    })
}

/// The rows of a symmetric tensor.
fn json_of_tensor(tensor: &DMat3) -> Value {
    json!([tensor.x_axis.to_array(), tensor.y_axis.to_array(), tensor.z_axis.to_array()])
}

/// Two corners; null for an empty box.
fn json_of_box(bounds: &Aabb) -> Value {
    if bounds.is_empty() { Value::Null } else { json!([bounds.min.to_array(), bounds.max.to_array()]) }
}

fn triple(v: DVec3) -> String {
    v.to_array().map(format_number).join(" ")
}

fn text_of_mass(mass: &MassProperties) -> String {
    let [x, y, z] = [mass.inertia.x_axis, mass.inertia.y_axis, mass.inertia.z_axis];
    format!(
        "  volume {}\n  centre {}\n  inertia about the centre, density 1: xx yy zz {}, xy xz yz {}",
        format_number(mass.volume),
        triple(mass.center),
        triple(DVec3::new(x.x, y.y, z.z)),
        triple(DVec3::new(x.y, x.z, y.z)),
    )
}

fn text_of_box(bounds: &Aabb) -> String {
    if bounds.is_empty() {
        return "  box: empty".to_owned();
    }
    format!("  box {} to {}", triple(bounds.min), triple(bounds.max))
}
