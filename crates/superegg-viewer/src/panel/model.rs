//! Input and output of the panel.

use superegg_scene::Scene;

use super::files::FileEvent;
use crate::input::gizmo::Handles;
use crate::input::keys::Action;
use crate::input::{FileAction, ViewSide};
use crate::protocol::{Document, Frames};
use crate::queries::CastHit;

/// Everything that the panel shows.
pub(crate) struct PanelModel<'a> {
    pub(crate) scene: &'a Scene,
    /// Name of the selected entity.
    pub(crate) selected: Option<&'a str>,
    /// Name of the entity that the window shows.
    pub(crate) root: Option<&'a str>,
    /// The frames, if there are any.
    pub(crate) frames: Option<Frames>,
    /// The hit of the intersection test.
    pub(crate) hit: Option<&'a CastHit>,
    /// Lines at the bottom of the scene.
    pub(crate) status: &'a [String],
    /// A line at the top of the scene.
    pub(crate) notice: Option<&'a str>,
    /// Name of device and driver.
    pub(crate) device: &'a str,
    /// The file of the session.
    pub(crate) document: &'a Document,
    /// The progress of a picture that is rendered.
    pub(crate) rendering: Option<&'a str>,
    /// The frames are shown one after another.
    pub(crate) is_playing: bool,
    /// Alias of the root's child that is selected in the window.
    pub(crate) child: Option<&'a str>,
    /// The handles of that child.
    pub(crate) handles: Option<Handles>,
    /// The directions of the axes on the screen: right, up, towards the eye.
    pub(crate) compass: [[f64; 3]; 3],
}

/// A change made in the panel.
#[derive(Debug)]
pub(crate) enum PanelEvent {
    /// A line of the modelling language.
    Command(String),
    /// The scene with a change that is still in progress.
    Draft(Box<Scene>),
    /// The action of a button or a switch.
    Action(Action),
    /// A setting of the view was changed in place.
    SettingsChanged,
    /// The frame of this index.
    Frame(usize),
    /// An action with files.
    File(FileAction),
    /// The result of an action with files.
    FileEvent(FileEvent),
    /// The lines of one action.
    Lines(Vec<String>),
    /// Lines that are one change, with its name in the history.
    Change(String, Vec<String>),
    /// Select this child of the root.
    SelectChild(String),
    /// Give this child of the selected object another alias.
    RenameChild(String, String),
    /// See the scene from a side.
    LookFrom(ViewSide),
    /// Do not offer the session that ended without a save again.
    RecoverLater,
}
