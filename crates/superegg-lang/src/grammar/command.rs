//! Commands, as parsed.
//!
//! The variant of a command says what the command works on, so what must be selected
//! ([`Command::needs`]) follows from its type. The enums of commands are exhaustive on purpose: the
//! compiler reports each match that does not handle a new command.

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::{
    AmbientOcclusion, Camera, Daylight, EnvironmentPicture, Light, MaterialWeight, Patches, Texture,
    TextureChannel,
};

/// One command with its arguments, each within its range.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Prints something, or changes the selection, a setting, or the session as a whole.
    Session(SessionCommand),
    /// Changes the scene; needs no selection.
    Scene(SceneCommand),
    /// Changes the selected primitive.
    Primitive(PrimitiveCommand),
    /// Changes the selected object.
    Object(ObjectCommand),
    /// Needs files, a terminal, a renderer or a window: for whoever runs the session.
    Request(Request),
}

impl Command {
    /// The selection that the command needs.
    pub fn needs(&self) -> Needs {
        match self {
            Self::Session(_) | Self::Scene(_) | Self::Request(_) => Needs::Nothing,
            Self::Primitive(_) => Needs::Primitive,
            Self::Object(_) => Needs::Object,
        }
    }

    /// Whether the command can do no more than change the selection or a cursor, once the entity
    /// that it names exists.
    pub fn is_selection(&self) -> bool {
        match self {
            Self::Session(command) => match command {
                SessionCommand::Deselect
                | SessionCommand::SelectPrimitive(_)
                | SessionCommand::SelectObject(_) => true,
                SessionCommand::Help(_)
                | SessionCommand::Info(_)
                | SessionCommand::Set { .. }
                | SessionCommand::Get(_)
                | SessionCommand::Clear
                | SessionCommand::ClearScreen => false,
            },
            Self::Object(command) => match command {
                ObjectCommand::SetCursor(_) => true,
                ObjectCommand::TransformWhole(_)
                | ObjectCommand::AddObject { .. }
                | ObjectCommand::AddPrimitive { .. }
                | ObjectCommand::RemoveChild(_)
                | ObjectCommand::RenameChild { .. }
                | ObjectCommand::Hide(_)
                | ObjectCommand::Unhide(_)
                | ObjectCommand::TransformChild(_) => false,
            },
            Self::Scene(_) | Self::Primitive(_) | Self::Request(_) => false,
        }
    }
}

/// The selection that a command needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// A primitive.
    Primitive,
    /// An object.
    Object,
}

/// A command that prints something, or changes the selection, a setting, or the session as a whole.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionCommand {
    /// List the commands, or explain the named ones.
    Help(Vec<String>),
    /// List the scene, or show the details of the named entities.
    Info(Vec<String>),
    /// Change a setting.
    Set {
        /// The name of the setting.
        setting: String,
        /// The new value, as typed.
        value: String,
    },
    /// Show the named settings; all if none is named.
    Get(Vec<String>),
    /// Empty the scene.
    Clear,
    /// Empty the terminal.
    ClearScreen,
    /// Select nothing.
    Deselect,
    /// Select a primitive; create it if it is new.
    SelectPrimitive(String),
    /// Select an object; create it if it is new.
    SelectObject(String),
}

/// A command that changes the scene and needs no selection.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneCommand {
    /// Delete a primitive or object, and every child that refers to it.
    Delete(String),
    /// Give a primitive or object another name.
    Rename {
        /// The present name.
        name: String,
        /// The new name.
        new: String,
    },
    /// Copy a primitive or object.
    Copy {
        /// The name of the original.
        name: String,
        /// The name of the copy.
        new: String,
    },
    /// Add or replace a light.
    SetLight(String, Light),
    /// Remove a light.
    RemoveLight(String),
    /// Set the radius of a light.
    SetLightRadius {
        /// The name of the light.
        name: String,
        /// The radius, in world units.
        radius: f64,
    },
    /// Set the camera's position, target and field of view. Its other fields stay as they are.
    SetCamera(Camera),
    /// Set the camera's up direction.
    SetCameraUp(DVec3),
    /// Make the camera orthographic, with an image of this height in world units; 0 for a
    /// perspective camera.
    SetOrthographic(f64),
    /// Set the camera's lens; a radius of 0 for a pinhole.
    SetLens {
        /// The radius of the lens, in world units.
        radius: f64,
        /// The focus distance, in world units; the distance of the target if `None`.
        focus: Option<f64>,
    },
    /// Set the background colour.
    SetBackground(DVec3),
    /// Set the up direction of camera, sky and floor, and of those that are set later.
    SetUp(DVec3),
    /// Set the sky.
    SetSky {
        /// The radiance at the horizon.
        horizon: DVec3,
        /// The radiance at the zenith.
        zenith: DVec3,
        /// The direction of the zenith; the scene's if `None`.
        up: Option<DVec3>,
    },
    /// Remove the sky.
    RemoveSky,
    /// Set a picture of the surroundings.
    SetEnvironment(EnvironmentPicture),
    /// Set sun and sky.
    SetDaylight(Daylight),
    /// Remove both.
    RemoveEnvironment,
    /// Set the floor.
    SetFloor {
        /// The height along `up`, in world units.
        height: f64,
        /// The primitive whose material the floor has.
        surface: Option<String>,
        /// The normal of the floor; the scene's up direction if `None`.
        up: Option<DVec3>,
    },
    /// Set the normal of the floor.
    SetFloorUp(DVec3),
    /// Remove the floor.
    RemoveFloor,
    /// Turn ambient occlusion on or off.
    SetAmbientOcclusion(Option<AmbientOcclusion>),
    /// Set the recursion depth of objects.
    SetDepth(u32),
    /// Add a key: keep the numbers of a line at a frame. The parsed line is
    /// [`crate::Parsed::keyed`].
    SetKey {
        /// The frame.
        frame: f64,
        /// The words of the line after its command.
        words: Vec<String>,
    },
    /// Remove keys.
    RemoveKeys {
        /// The frame, or `all`.
        frame: String,
        /// Remove only the keys of this command on the selected entity; the keys of every command
        /// if `None`.
        command: Option<String>,
    },
}

/// A command that changes the selected primitive.
#[derive(Clone, Debug, PartialEq)]
pub enum PrimitiveCommand {
    /// Set the semi-axes.
    SetRadii(DVec3),
    /// Set the exponents.
    SetExponents {
        /// East-west, above 0.
        e: f64,
        /// North-south, above 0.
        n: f64,
    },
    /// Set the number of patches in the preview.
    SetPatches(Patches),
    /// Set the base colour.
    SetColor(DVec3),
    /// Set one weight of the material.
    SetWeight(MaterialWeight, f64),
    /// Set the index of refraction.
    SetIndex(f64),
    /// Sets the light that the surface gives off, in multiples of its colour.
    SetEmission(f64),
    /// Set the exponent of the highlight.
    SetShininess(f64),
    /// Turn Fresnel reflectance on or off.
    SetFresnel(bool),
    /// Set the absorption inside, for each channel, per world unit.
    SetAbsorption(DVec3),
    /// Set the second colour. How many numbers are allowed depends on the word.
    SetPattern {
        /// The word of the pattern, as [`superegg_scene::Pattern::word`].
        word: String,
        /// A colour, and optionally a size or a direction.
        numbers: Vec<f64>,
    },
    /// Set a picture on the surface, or remove it.
    SetTexture {
        /// The quantity that it sets.
        channel: TextureChannel,
        /// The picture; `None` for none.
        texture: Option<Texture>,
    },
}

/// A command that changes the selected object.
#[derive(Clone, Debug, PartialEq)]
pub enum ObjectCommand {
    /// Append a step to the transform of the whole object.
    TransformWhole(TransformStep),
    /// Add an object as a child.
    AddObject {
        /// The object to add.
        target: String,
        /// The alias of the child; the target's name if `None`.
        alias: Option<String>,
    },
    /// Add a primitive as a child.
    AddPrimitive {
        /// The primitive to add.
        target: String,
        /// The alias of the child; the target's name if `None`.
        alias: Option<String>,
    },
    /// Remove a child.
    RemoveChild(String),
    /// Give a child another alias.
    RenameChild {
        /// The alias.
        alias: String,
        /// The new alias.
        new: String,
    },
    /// Hide a child; the one at the cursor if `None`.
    Hide(Option<String>),
    /// Show a hidden child; all of them if `None`.
    Unhide(Option<String>),
    /// Move the cursor to a child. The next transforms move that child.
    SetCursor(String),
    /// Append a step to the transform of the child at the cursor.
    TransformChild(TransformStep),
}

/// A command for whoever runs the session: the language itself reads, writes and draws nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Leave.
    Stop,
    /// Stop rendering.
    StopRender,
    /// Clear the session and run a file.
    Source {
        /// The file; the quicksave if `None`.
        file: Option<String>,
        /// Keep the good lines of a file with errors.
        is_forced: bool,
    },
    /// Add the contents of a file to the scene.
    Include(String),
    /// Begin a new scene.
    New,
    /// Write the selected entity for another program.
    Export {
        /// The file.
        file: String,
        /// Overwrite an existing file.
        is_forced: bool,
    },
    /// Write the session to a file.
    Save {
        /// The file; the quicksave if `None`.
        file: Option<String>,
        /// Overwrite an existing file.
        is_forced: bool,
        /// Write the commands as typed instead of a clean scene.
        as_history: bool,
    },
    /// Restore, list or discard unsaved sessions.
    Recover(Recovery),
    /// Undo this many changes.
    Undo(u32),
    /// Redo this many changes.
    Redo(u32),
    /// Show the tree, the number of instances and the bounds of the named entities; of the selected
    /// one if none is named.
    Show(Vec<String>),
    /// Show the typed lines: all, or the last ones.
    History(Option<u32>),
    /// Empty the terminal.
    ClearScreen,
    /// Print the working folder.
    PrintFolder,
    /// Change the working folder; to the home folder if `None`.
    ChangeFolder(Option<String>),
    /// List a folder; the working folder if `None`.
    ListFolder(Option<String>),
    /// Set the camera so that the named entity is in sight; the selected one if `None`.
    Frame(Option<String>),
    /// Ray trace into a file.
    Render {
        /// The file; named after the scene if `None`.
        file: Option<String>,
        /// Width and height in pixels; the scene's if `None`.
        size: Option<(u32, u32)>,
        /// Whether a read-only file is replaced.
        is_forced: bool,
    },
    /// Ray trace into the terminal, at a frame if one is given.
    Preview(Option<f64>),
    /// Open the viewer.
    View,
    /// Give the keyboard to the viewer.
    Interact,
    /// Test a point with the inside-outside function; the grid of the settings if `None`.
    InsideOutside(Option<DVec3>),
    /// Intersect a ray, given as origin and direction; the camera's central ray if `None`.
    Intersect(Option<(DVec3, DVec3)>),
}

/// An action on unsaved sessions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recovery {
    /// Restore one, by its number in the list, 1 for the latest.
    Restore(u32),
    /// List all.
    List,
    /// Discard one, by its number in the list; all if `None`.
    Discard(Option<u32>),
}
