//! Answers questions about the scene: trees of objects, inside-outside tests and ray hits.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_lang::{Fault, FaultCode, format_number};
use superegg_render::{Framing, facing};
use superegg_trace::{CompiledScene, InstancePath, PointLimits, RayLimits};

use crate::inspect::framing::framing_lines;
use crate::inspect::grid::Grid;
use crate::inspect::ray::{RayMethod, describe_camera_ray, describe_hit, first_hit};
use crate::inspect::tree::describe_tree;
use crate::modeller::faults::{at_argument, interrupted_test, too_deep};
use crate::modeller::journal::Record;
use crate::modeller::state::Modeller;
use crate::text::counted;

impl Modeller {
    /// Sets the camera so that all of an entity, by default the selected one, is in sight; and a
    /// light, if the scene has none. It is one change.
    pub(super) fn frame(&mut self, name: Option<&str>, line: &str) -> Result<(), Fault> {
        let root = match name {
            Some(name) => name,
            None => self.selected_root()?,
        };
        let scene = self.session().scene();
        if scene.get(root).is_none() {
            // The fault of an unknown name.
            self.session().describe(&[root.to_owned()]).map_err(|fault| at_argument(fault, line, 1))?;
        }
        let compiled = CompiledScene::compile(scene, Some(root), scene.depth);
        let size = (scene.picture.width, scene.picture.height);
        let framing = Framing::of(&facing(&scene.camera), &compiled, size).ok_or_else(|| {
            Fault::new(FaultCode::NoChild, format!("'{root}' has nothing to see"))
                .help("frame a primitive, or an object with children")
        })?;
        let lines = framing_lines(&framing, scene);
        self.timeline.run_lines(line.trim(), &lines)?;
        self.record(Record::Lines { label: line.trim(), lines: &lines });
        if self.is_interactive() {
            self.print(lines.trim_end());
        }
        Ok(())
    }

    fn compile_selected(&self) -> Result<CompiledScene, Fault> {
        let scene = self.session().scene();
        Ok(CompiledScene::compile(scene, Some(self.selected_root()?), scene.depth))
    }

    /// Prints the details and the tree of each name, by default of the selection.
    pub(super) fn show(&mut self, names: &[String], line: &str) -> Result<(), Fault> {
        let selected;
        let names = if names.is_empty() {
            selected = [self.selected_root()?.to_owned()];
            &selected[..]
        } else {
            names
        };
        let mut texts = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let session = self.session();
            let details = session
                .describe(std::slice::from_ref(name))
                .map_err(|fault| at_argument(fault, line, i + 1))?;
            let entities: Vec<&str> = match (session.scene().get(name), name.to_ascii_lowercase().as_str()) {
                (Some(_), _) => vec![name],
                (None, "all") => session.scene().entities().map(|(name, _)| name).collect(),
                (None, _) => session.selected().into_iter().collect(),
            };
            texts.push(details);
            texts.extend(entities.iter().map(|name| describe_tree(session, name)));
        }
        self.print(&texts.join("\n"));
        Ok(())
    }

    /// Prints the inside-outside value at a point, or the counts for the grid of the settings.
    pub(super) fn inside_outside(&mut self, point: Option<DVec3>) -> Result<(), Fault> {
        let compiled = self.compile_selected()?;
        let Some(point) = point else { return self.count_grid(&compiled) };
        let answer = compiled.query_point_unless(point, &self.interrupt).ok_or_else(interrupted_test)?;
        let verdict = match answer.least {
            _ if answer.inside => "inside",
            Some((0.0, _)) => "on the surface",
            Some(_) | None => "outside",
        };
        let describe = |value: f64, path: &InstancePath| {
            format!("{verdict}: the function is {} for {}", format_number(value), compiled.path_name(path))
        };
        let text = match answer.least {
            Some((value, path)) => describe(value, &path),
            // No box holds the point.
            None => match compiled.nearest_primitive(point, &PointLimits::default()) {
                Some(nearest) => describe(nearest.value, &nearest.path) + ", the nearest primitive",
                None => format!("{verdict}: there is no primitive"),
            },
        };
        self.print(&text);
        Ok(())
    }

    fn count_grid(&mut self, compiled: &CompiledScene) -> Result<(), Fault> {
        let view = self.session().settings.view;
        let grid = Grid::new(view.io_step, view.io_half).map_err(|error| {
            Fault::new(FaultCode::OutOfRange, error.to_string()).help("for example: set ioStep 0.5")
        })?;
        let (mut inside, mut count) = (0u64, 0u64);
        for point in grid.points() {
            let is_inside =
                compiled.contains_point_unless(point, &self.interrupt).ok_or_else(interrupted_test)?;
            inside += u64::from(is_inside);
            count += 1;
        }
        self.print(&format!(
            "{} from {half} to {} in steps of {}: {inside} inside, {} outside",
            counted(count, "point"),
            format_number(view.io_half),
            format_number(view.io_step),
            count - inside,
            half = format_number(-view.io_half),
        ));
        Ok(())
    }

    /// Prints the first hit of a ray (origin, direction), by default of the central camera ray.
    pub(super) fn intersect(&mut self, ray: Option<(DVec3, DVec3)>) -> Result<(), Fault> {
        let compiled = self.compile_selected()?;
        let method = RayMethod::Exact(RayLimits::default());
        let text = match ray {
            None => {
                describe_camera_ray(&compiled, &self.session().scene().camera, method).map_err(too_deep)?
            }
            Some((_, direction)) if direction == DVec3::ZERO => {
                let fault = Fault::new(FaultCode::NoDirection, "the direction 0 0 0 has no length");
                return Err(fault.help("the last three numbers are the direction, such as 0 0 -1"));
            }
            Some((origin, direction)) => {
                let hit = first_hit(&compiled, &Ray::new(origin, direction), method).map_err(too_deep)?;
                format!("the ray {}", describe_hit(&compiled, hit.as_ref()))
            }
        };
        self.print(&text);
        Ok(())
    }
}
