//! A read-only view of a session: the scene and the selection.

use superegg_scene::{Entity, Object, Scene};

/// A scene and the name that is selected in it.
#[derive(Clone, Copy, Debug)]
pub struct Selection<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The name of the selected primitive or object.
    pub selected: Option<&'a str>,
}

impl<'a> Selection<'a> {
    /// The selected primitive or object with its name; `None` if nothing is selected.
    pub fn entity(self) -> Option<(&'a str, &'a Entity)> {
        self.selected.and_then(|name| Some((name, self.scene.get(name)?)))
    }

    /// The selected object; `None` if a primitive or nothing is selected.
    pub fn object(self) -> Option<&'a Object> {
        self.selected.and_then(|name| self.scene.object(name).ok())
    }

    /// The alias of the child at the cursor of the selected object.
    pub fn cursor(self) -> Option<&'a str> {
        self.object()?.cursor().map(|(alias, _)| alias)
    }
}
