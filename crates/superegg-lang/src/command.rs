//! Commands, as parsed.

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, TransformStep};
use superegg_scene::{Camera, Light, MaterialShare, Patches};

/// One command with its arguments, each within its range.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Show the list of commands, or the text of those named.
    Help(Vec<String>),
    /// Leave.
    Stop,
    /// Show what there is, or the details of what is named.
    Info(Vec<String>),
    /// Hand the keyboard to the viewer.
    Interact,
    /// Clear, then run a file.
    Source(Option<String>),
    /// Write the scene as commands.
    Save(Option<String>),
    /// Select nothing.
    Deselect,
    /// Select a primitive, making it if new.
    Primitive(String),
    /// Set the semi-axes.
    SetRadii(DVec3),
    /// Set the exponents.
    SetExponents(Exponents),
    /// Set the patches of the preview.
    SetPatches(Patches),
    /// Set the base colour.
    SetColor(DVec3),
    /// Set one share of the material.
    SetShare(MaterialShare, f64),
    /// Set the index of refraction.
    SetIndex(f64),
    /// Set the exponent of the highlight.
    SetShininess(f64),
    /// Select an object, making it if new.
    Object(String),
    /// Append to the transform of the whole object.
    TransformWhole(TransformStep),
    /// Add an object as a child.
    AddObject {
        /// The object to add.
        target: String,
        /// Its alias, if not its name.
        alias: Option<String>,
    },
    /// Add a primitive as a child.
    AddPrimitive {
        /// The primitive to add.
        target: String,
        /// Its alias, if not its name.
        alias: Option<String>,
    },
    /// Choose the child that the next transforms move.
    SetCursor(String),
    /// Append to the transform of the child at the cursor.
    TransformChild(TransformStep),
    /// Add or replace a light.
    SetLight(String, Light),
    /// Take a light away.
    RemoveLight(String),
    /// Set the camera's place, target and field of view; its up direction stays.
    SetCamera(Camera),
    /// Set the camera's up direction.
    SetCameraUp(DVec3),
    /// Set the background colour.
    SetBackground(DVec3),
    /// Set how deep objects are opened.
    SetDepth(u32),
}
