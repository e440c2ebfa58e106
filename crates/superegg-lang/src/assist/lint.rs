//! Warnings about valid files that are probably wrong.

use std::collections::HashSet;

use superegg_scene::Entity;

use crate::diagnostic::{Diagnostic, FaultCode, FaultList, Severity};
use crate::session::interpreter::Session;
use crate::session::keys::key_frames;
use crate::session::still::scene_at;

/// The maximal number of frames to check.
const MOST_FRAMES: usize = 1000;

/// Warnings about a loaded file as a whole.
pub fn lint(session: &Session, file: &str) -> Vec<Diagnostic> {
    let scene = session.scene();
    let (mut warnings, mut list) = (Vec::new(), FaultList::new(file));
    let mut warn = |code, message: String, help: &str| {
        list.add(&mut warnings, Severity::Warning, || Diagnostic::of_file(file, code, message, help));
    };

    let in_objects =
        scene.objects().flat_map(|(_, object)| object.children()).map(|(_, child)| child.target());
    let of_floor = scene.floor.as_ref().and_then(|floor| floor.surface.as_deref());
    let used: HashSet<&str> = in_objects.chain(of_floor).collect();
    for (name, entity) in scene.entities() {
        let is_selected = session.selected() == Some(name);
        match entity {
            Entity::Object(object) if object.children().len() == 0 => {
                warn(
                    FaultCode::EmptyObject,
                    format!("the object '{name}' has no children"),
                    "the name may be misspelt",
                );
            }
            Entity::Object(_) | Entity::Table(_) if !used.contains(name) && !is_selected => {
                warn(
                    FaultCode::Unused,
                    format!("the object '{name}' is in no other and not selected"),
                    "it will not be in the picture",
                );
            }
            Entity::Primitive(_) if !used.contains(name) && !is_selected => {
                warn(
                    FaultCode::Unused,
                    format!("the primitive '{name}' is in no object"),
                    "it will not be in the picture",
                );
            }
            Entity::Object(_) | Entity::Table(_) | Entity::Primitive(_) => {}
        }
    }
    for (name, primitive) in scene.primitives() {
        let material = &primitive.material;
        if material.reflected.unwrap_or(0.0) + material.refracted.unwrap_or(0.0) > 1.0 {
            warn(
                FaultCode::Weights,
                format!("reflected and refracted of '{name}' are more than 1 together"),
                "they will be scaled to a sum of 1",
            );
        }
    }
    // Between keys an interpolated number may be an invalid 0; at a key the transform may not be
    // invertible.
    let frames = key_frames(scene);
    let between = frames.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]);
    if let Some(fault) = between
        .chain(frames.iter().copied())
        .take(MOST_FRAMES)
        .find_map(|frame| scene_at(session, frame).err())
    {
        warn(
            FaultCode::Keys,
            fault.message,
            "'animate' needs every frame; keys nearer to that one lead around it",
        );
    }
    let camera = &scene.camera;
    if camera.looks_along_up() {
        warn(
            FaultCode::CameraUp,
            "the camera looks along its up direction".to_owned(),
            "'cameraUp x y z' sets another; until then an axis replaces it",
        );
    }
    if session.selected().is_none() {
        warn(
            FaultCode::NothingSelected,
            "nothing is selected at the end".to_owned(),
            "end with 'object NAME', or render with --object NAME",
        );
    }
    list.finish(&mut warnings);
    warnings
}
