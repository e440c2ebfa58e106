//! Commands, as parsed.

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::{AmbientOcclusion, Camera, Light, MaterialShare, Patches, Sky};

/// One command with its arguments, each within its range.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Show the list of commands, or the text of those named.
    Help(Vec<String>),
    /// Show what there is, or the details of what is named.
    Info(Vec<String>),
    /// Ask something of whoever runs the session.
    Ask(Request),
    /// Change a setting.
    Set {
        /// Its name.
        setting: String,
        /// The new value, as typed.
        value: String,
    },
    /// Show settings; all where none is named.
    Get(Vec<String>),
    /// Empty the scene.
    Clear,
    /// Delete a primitive or object, and the children that stand for it.
    Delete(String),
    /// Give a primitive or object another name.
    Rename {
        /// Its name.
        name: String,
        /// The new one.
        new: String,
    },
    /// Copy a primitive or object.
    Copy {
        /// Its name.
        name: String,
        /// The name of the copy.
        new: String,
    },
    /// Select nothing.
    Deselect,
    /// Select a primitive, making it if new.
    Primitive(String),
    /// Set the semi-axes.
    SetRadii(DVec3),
    /// Set the exponents.
    SetExponents {
        /// East-west.
        e: f64,
        /// North-south.
        n: f64,
    },
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
    /// Set whether the mirrored share follows Fresnel's reflectance.
    SetFresnel(bool),
    /// Set what the inside takes away of light let through.
    SetAbsorption(DVec3),
    /// Set the second colour, in the words that say what it is like: which numbers fit depends on the word.
    SetPattern {
        /// `none`, `checker` or `gradient`.
        word: String,
        /// A colour, and perhaps a size or a direction.
        numbers: Vec<f64>,
    },
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
    /// Take a child out of the selected object.
    RemoveChild(String),
    /// Choose the child that the next transforms move.
    SetCursor(String),
    /// Append to the transform of the child at the cursor.
    TransformChild(TransformStep),
    /// Add or replace a light.
    SetLight(String, Light),
    /// Take a light away.
    RemoveLight(String),
    /// Set the radius of a light.
    SetLightRadius {
        /// Its name.
        name: String,
        /// The radius, in world units.
        radius: f64,
    },
    /// Set the camera's place, target and field of view; the rest of it stays.
    SetCamera(Camera),
    /// Set the camera's up direction.
    SetCameraUp(DVec3),
    /// Make the camera orthographic, with a picture of this height in world units; 0 for a perspective.
    SetOrthographic(f64),
    /// Give the camera a lens; a radius of 0 for a pinhole.
    SetLens {
        /// Its radius, in world units.
        radius: f64,
        /// The distance in focus, that of the target where it is not said.
        focus: Option<f64>,
    },
    /// Set the background colour.
    SetBackground(DVec3),
    /// Set the sky, or take it away.
    SetSky(Option<Sky>),
    /// Lay a floor.
    SetFloor {
        /// Its height along `up`, in world units.
        height: f64,
        /// The primitive whose surface it has.
        surface: Option<String>,
        /// The direction at right angles to it.
        up: DVec3,
    },
    /// Set the floor's up direction.
    SetFloorUp(DVec3),
    /// Take the floor away.
    RemoveFloor,
    /// Keep ambient light from corners, or no longer.
    SetAmbientOcclusion(Option<AmbientOcclusion>),
    /// Keep the numbers of a line at a frame. The line itself is [`crate::Parsed::keyed`].
    SetKey {
        /// The frame.
        frame: f64,
        /// The line's words after its command.
        words: Vec<String>,
    },
    /// Take keys away.
    RemoveKeys {
        /// The frame, or `all`.
        frame: String,
        /// The command whose keys are meant, for what is selected; those of all commands where it is not said.
        command: Option<String>,
    },
    /// Set how deep objects are opened.
    SetDepth(u32),
}

/// What a command asks of whoever runs the session: the language itself reads, writes and draws nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Leave.
    Stop,
    /// Stop rendering.
    StopRender,
    /// Clear the session and run this file, or the quicksave.
    Source {
        /// The file.
        file: Option<String>,
        /// Take what is good in a file with errors.
        is_forced: bool,
    },
    /// Write the session to this file, or to the quicksave.
    Save {
        /// The file.
        file: Option<String>,
        /// Overwrite whatever is there.
        is_forced: bool,
        /// The commands as typed, instead of a clean scene.
        as_history: bool,
    },
    /// Bring back a session that was not saved.
    Recover(Recovery),
    /// Take back so many changes.
    Undo(u32),
    /// Make so many changes again.
    Redo(u32),
    /// Show the tree, the instances and the bounds of each of these, or of what is selected.
    Show(Vec<String>),
    /// Show the lines typed, or the last so many.
    History(Option<u32>),
    /// Empty the terminal.
    ClearScreen,
    /// Tell the working folder.
    TellFolder,
    /// Change the working folder, or go home.
    ChangeFolder(Option<String>),
    /// List a folder, or the working folder.
    ListFolder(Option<String>),
    /// Ray trace into a file.
    Render {
        /// The file.
        file: Option<String>,
        /// Width and height in pixels.
        size: Option<(u32, u32)>,
    },
    /// Ray trace into the terminal, at a frame where one is given.
    Preview(Option<f64>),
    /// Open the viewer.
    View,
    /// Hand the keyboard to the viewer.
    Interact,
    /// Test a point, or the grid, with the inside-outside function.
    InsideOutside(Option<DVec3>),
    /// Meet a ray, given as origin and direction, or the camera's own.
    Intersect(Option<(DVec3, DVec3)>),
}

/// What to do about sessions that were not saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    /// Bring one back, by its number in the list, from 1 for the last.
    Restore(u32),
    /// Tell of all.
    List,
    /// Forget one, by its number in the list, or all.
    Discard(Option<u32>),
}
