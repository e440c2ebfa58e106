//! Frames scenes that set no camera and are not in sight.

use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_render::Framing;
use superegg_scene::{Camera, LightKind, Scene};
use superegg_trace::CompiledScene;

/// The scene with its camera, and its light if it has none, set so that all is in sight; `None` if
/// the scene sets a camera, or is in sight with the default one.
pub(crate) fn framed(scene: &Scene, compiled: &CompiledScene, size: (u32, u32)) -> Option<Scene> {
    let mut framed = scene.clone();
    Framing::frame_unseen(&mut framed, compiled, size).then_some(framed)
}

/// As [`framed`], for a scene that is not compiled yet; it is compiled only if it sets no camera.
pub(crate) fn framed_root(scene: &Scene, root: Option<&str>, depth: u32, size: (u32, u32)) -> Option<Scene> {
    let is_set = Framing::is_set(scene);
    (!is_set).then(|| framed(scene, &CompiledScene::compile(scene, root, depth), size))?
}

/// The line about a framed scene.
pub(crate) fn framing_note(scene: &Scene) -> String {
    format!(
        "the scene sets no camera and is not in sight of the default one, so it is framed: {}",
        camera_line(&scene.camera)
    )
}

/// The commands that frame a scene; the light only if the scene has none.
pub(crate) fn framing_lines(framing: &Framing, scene: &Scene) -> String {
    let mut lines = camera_line(&framing.camera) + "\n";
    if let Some(height) = framing.camera.ortho_height {
        lines.push_str(&format!("orthographic {}\n", format_number(height)));
    }
    if let Some(lens) = framing.camera.lens {
        lines.push_str(&format!("lens {} {}\n", format_number(lens.radius), format_number(lens.focus)));
    }
    if let LightKind::Point { position } = framing.light.kind
        && scene.named_lights().len() == 0
    {
        let (name, falloff) = (Framing::LIGHT_NAME, format_number(framing.light.falloff));
        lines.push_str(&format!("light {name} {} 1 1 1 {falloff}\n", vector(position)));
    }
    lines
}

fn camera_line(camera: &Camera) -> String {
    format!("camera {} {} {}", vector(camera.position), vector(camera.target), format_number(camera.fov_deg))
}

fn vector(v: DVec3) -> String {
    v.to_array().map(format_number).join(" ")
}
