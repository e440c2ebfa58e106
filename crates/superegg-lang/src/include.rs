//! The command `include`: the lines that add one scene to another.

use std::collections::HashSet;

use superegg_scene::{Camera, Entity, Scene, Track, TrackSubject};

use crate::diagnostic::{Fault, FaultCode};
use crate::parse::number::vector;
use crate::session::interpreter::Session;
use crate::session::settings;
use crate::text::shorten;
use crate::writer::{select, write_floor, write_new, write_settings};

impl Session {
    /// The lines that add the contents of another session's scene to this one. Each of them
    /// succeeds, and the selection afterwards is what it was.
    ///
    /// Primitives, objects, lights and keys are added. An entity that both scenes have under the same name is
    /// taken once if it is equal; cursors are not compared. Settings (camera, up direction,
    /// background, sky, floor, ambient occlusion, depth, image settings) are taken where this scene
    /// has the default.
    ///
    /// # Errors
    /// A name that means different things in the two scenes.
    pub fn lines_to_include(&self, added: &Session) -> Result<String, Fault> {
        let (own, added) = (self.scene(), added.scene());
        let different = different_names(own, added);
        if !different.is_empty() {
            return Err(conflict(&different));
        }
        let mut text = String::new();
        write_new_settings(&mut text, own, added);
        let keyed: HashSet<&TrackSubject> = own.tracks().map(Track::subject).collect();
        let is_new_track = |track: &Track| !keyed.contains(track.subject());
        text.push_str(&write_new(added, |name| own.get(name).is_none(), is_new_track));
        if let (None, Some(floor)) = (&own.floor, &added.floor) {
            let up = if takes_up(own) { added.up() } else { own.up() };
            write_floor(&mut text, floor, up);
        }
        if !text.is_empty() {
            text.push_str(&match self.selection().entity() {
                Some((name, entity)) => select(name, entity),
                None => "deselect".to_owned(),
            });
            text.push('\n');
        }
        Ok(text)
    }
}

/// The names of entities and lights that are in both scenes and differ there.
fn different_names<'a>(own: &Scene, added: &'a Scene) -> Vec<&'a str> {
    let entities = added.entities().filter(|(name, entity)| {
        own.get(name).is_some_and(|held| !is_same(held, entity) || !has_same_keys(own, added, name))
    });
    let lights =
        added.named_lights().filter(|(name, light)| own.light(name).is_ok_and(|held| held != *light));
    entities.map(|(name, _)| name).chain(lights.map(|(name, _)| name)).collect()
}

fn is_same(a: &Entity, b: &Entity) -> bool {
    match (a, b) {
        (Entity::Object(a), Entity::Object(b)) => {
            a.children().eq(b.children())
                && a.hidden_children().eq(b.hidden_children())
                && a.overall_steps().eq(b.overall_steps())
        }
        (a, b) => a == b,
    }
}

/// Whether the keys about an entity are the same.
fn has_same_keys(own: &Scene, added: &Scene, name: &str) -> bool {
    let about = |scene: &Scene| -> Vec<Track> {
        scene.tracks().filter(|track| track.subject().is_about(name)).cloned().collect()
    };
    about(own) == about(added)
}

fn conflict(names: &[&str]) -> Fault {
    const MOST_NAMED: usize = 5;
    let mut shown: Vec<String> =
        names.iter().take(MOST_NAMED).map(|name| format!("'{}'", shorten(name))).collect();
    if names.len() > MOST_NAMED {
        shown.push(format!("{} more", names.len() - MOST_NAMED));
    }
    let message = format!("the file and the scene each have their own {}", shown.join(", "));
    let first = shorten(names[0]);
    Fault::new(FaultCode::NameExists, message).help(format!(
        "equal ones are taken once; rename one of two different ones, for example: rename {first} {first}2"
    ))
}

/// Whether the scene has no up direction of its own that `up` would replace.
fn takes_up(own: &Scene) -> bool {
    let default = Scene::default();
    own.up() == default.up() && own.camera.up == default.camera.up && own.sky.is_none() && own.floor.is_none()
}

/// Writes the settings of `added` for which `own` has the default.
fn write_new_settings(text: &mut String, own: &Scene, added: &Scene) {
    let default = Scene::default();
    // Has the settings to write, and else defaults.
    let mut new = Scene::default();
    if takes_up(own) && added.up() != default.up() {
        text.push_str(&format!("up {}\n", vector(added.up())));
        new.set_up(added.up());
    } else {
        new.set_up(own.up());
    }
    if !own.sets_camera && own.camera == (Camera { up: own.up(), ..default.camera }) {
        (new.camera, new.sets_camera) = (added.camera, added.sets_camera);
    }
    if own.background == default.background {
        new.background = added.background;
    }
    if own.sky.is_none() {
        new.sky = added.sky;
    }
    if own.environment.is_none() {
        new.environment = added.environment.clone();
    }
    if own.ambient_occlusion.is_none() {
        new.ambient_occlusion = added.ambient_occlusion;
    }
    if own.depth == default.depth {
        new.depth = added.depth;
    }
    for (name, light) in added.named_lights().filter(|(name, _)| own.light(name).is_err()) {
        new.set_light(name, *light);
    }
    new.picture = settings::merged(&own.picture, &added.picture);
    write_settings(text, &new);
}
