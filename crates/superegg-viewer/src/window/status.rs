//! The lines at the bottom of the scene: its name, renderer, and the parts that the budgets leave
//! out.

use superegg_render::Output;
use superegg_scene::{EnvironmentLight, LightModel, Pattern, Scene};

use super::background::Background;
use super::content::Content;
use crate::frame_stats::DrawStats;
use crate::input::ViewState;
use crate::live::tracer::Pass;
use crate::preview::{Preview, PreviewBudget};

const KEYS: &str = "h: keys  |  o: inside-outside test  |  i: intersection test";
/// In the course program both tests are on at first.
const COURSE_KEYS: &str = "h: keys";

/// The status lines. `stats` are those of the last frame.
pub(super) fn lines(
    content: &Content,
    background: &Background,
    view: &ViewState,
    stats: &DrawStats,
) -> Vec<String> {
    let nothing = if content.scene().entities().len() == 0 {
        "the scene is empty: the menu Add makes shapes, and File opens a scene"
    } else {
        "nothing is selected, so nothing is shown; 'object NAME' selects"
    };
    let root = content.root().unwrap_or(nothing);
    let renderer = match background.trace.pass() {
        Some(pass) if view.is_traced => traced(pass, view.output),
        None if view.is_traced => "ray tracing …".to_owned(),
        _ => drawn(background.preview().instances.len(), stats, view.settings.wireframe),
    };
    let frame = content
        .frames()
        .map(|frames| format!("  |  frame {} of 0 to {}", frames.current, frames.count.saturating_sub(1)));
    let keys = if view.settings.course { COURSE_KEYS } else { KEYS };
    let mut lines = vec![format!("{root}{}  |  {renderer}  |  {keys}", frame.unwrap_or_default())];
    let unpaid = background.preview().unpaid_branches;
    if unpaid > 0 {
        let most = PreviewBudget::WINDOW_INSTANCES;
        lines.push(format!(
            "the preview is limited to {most} instances: {unpaid} branches are not expanded; ray tracing (p) shows all"
        ));
    }
    lines.extend(only_rendered(content.scene()));
    if view.is_traced {
        return lines;
    }
    if !view.settings.course
        && !view.settings.wireframe
        && let Some(line) = only_ray_traced(content.scene(), background.preview())
    {
        lines.push(line);
    }
    if stats.coarser > 0 {
        lines.push(format!("the triangle budget is spent: {} instances have fewer patches", stats.coarser));
    }
    if stats.lights_left_out > 0 {
        lines.push(format!("{} lights are missing in the preview", stats.lights_left_out));
    }
    if view.settings.io_test && background.grid().is_some_and(|grid| grid.is_cut) {
        lines.push("the grid has too many points; a larger step shows its whole extent".to_owned());
    }
    lines
}

/// Most instances whose materials are searched at each frame.
const MOST_SEARCHED: usize = 20_000;

/// The line that names what only ray tracing shows of a scene.
fn only_ray_traced(scene: &Scene, preview: &Preview) -> Option<String> {
    let mut names = Vec::new();
    let seen = || preview.instances.iter().take(MOST_SEARCHED);
    let materials = || seen().map(|instance| &preview.shapes[instance.shape as usize].material);
    if preview.instances.len() > 1 || scene.floor.is_some() {
        names.push("shadows");
        if materials().any(|material| material.reflected.is_some_and(|weight| weight > 0.0)) {
            names.push("mirrored objects");
        }
    }
    let mut clear = materials().filter(|material| material.refracted.is_some_and(|weight| weight > 0.0));
    if clear.any(|material| material.index != 1.0) {
        names.push("refraction");
    }
    let is_noise =
        |pattern| matches!(pattern, Pattern::Noise { .. } | Pattern::Marble { .. } | Pattern::Wood { .. });
    if materials().any(|material| is_noise(material.pattern)) {
        names.push("noise patterns");
    }
    if matches!(scene.environment, Some(EnvironmentLight::Daylight(_))) {
        names.push("daylight");
    }
    if scene.camera.lens.is_some() {
        names.push("depth of field");
    }
    if scene.picture.light_model == LightModel::Path {
        names.push("light by paths");
    } else if scene.ambient_occlusion.is_some() {
        names.push("ambient occlusion");
    }
    (!names.is_empty()).then(|| format!("only ray traced (p): {}", names.join(", ")))
}

/// The line that names what only rendered pictures show of a scene: the window reads no files of pictures.
fn only_rendered(scene: &Scene) -> Option<String> {
    let mut names = Vec::new();
    if scene.entities().take(MOST_SEARCHED).any(|(_, entity)| entity.has_textures()) {
        names.push("textures");
    }
    if matches!(scene.environment, Some(EnvironmentLight::Picture(_))) {
        names.push("the environment");
    }
    (!names.is_empty()).then(|| format!("only in rendered pictures (Ctrl+R): {}", names.join(", ")))
}

fn traced(pass: &Pass, output: Output) -> String {
    let (width, height) = (pass.film.width(), pass.film.height());
    let (samples, ms) = (pass.samples, 1e3 * pass.seconds);
    let more = if pass.is_last { "" } else { " …" };
    let plural = if samples == 1 { "" } else { "s" };
    let of = if output == Output::Light { String::new() } else { format!(" ({})", output.word()) };
    format!("ray traced{of} at {width} x {height}, {samples} sample{plural} per pixel, {ms:.0} ms{more}")
}

fn drawn(instances: usize, stats: &DrawStats, is_wireframe: bool) -> String {
    let kind = if is_wireframe { "edges" } else { "triangles" };
    let plural = if instances == 1 { "" } else { "s" };
    format!("{instances} instance{plural}, {} {kind}", stats.triangles)
}
