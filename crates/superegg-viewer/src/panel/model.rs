//! Input and output of the panel.

use superegg_scene::Scene;

use super::files::FileEvent;
use crate::input::FileAction;
use crate::input::keys::Action;
use crate::overlay::cast::CastHit;
use crate::protocol::{Document, Frames};

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
    /// Do not offer the session that ended without a save again.
    RecoverLater,
}
