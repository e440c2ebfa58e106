//! The scene that the window shows.

use superegg_scene::Scene;

use crate::commands;
use crate::protocol::Shown;

/// The session's snapshot, a draft of it, and the entity that is shown.
#[derive(Debug)]
pub(super) struct Content {
    snapshot: Scene,
    selected: Option<String>,
    /// A change in progress in the panel, shown until it is over.
    draft: Option<Scene>,
    /// Number of the scene: it changes with the snapshot, the draft and the selection.
    number: u64,
    pick: Option<Pick>,
}

/// A primitive selected by a double click. The object that contains it stays in view.
#[derive(Debug)]
struct Pick {
    primitive: String,
    root: Option<String>,
}

impl Content {
    pub(super) fn new(shown: Shown) -> Self {
        Self { snapshot: shown.scene, selected: shown.selected, draft: None, number: 1, pick: None }
    }

    /// Takes over a snapshot. It ends the draft.
    pub(super) fn replace(&mut self, shown: Shown) {
        if shown.scene != self.snapshot || shown.selected != self.selected {
            self.number += 1;
        }
        if self.pick.as_ref().is_none_or(|pick| shown.selected.as_ref() != Some(&pick.primitive)) {
            self.pick = None;
        }
        self.snapshot = shown.scene;
        self.selected = shown.selected;
        self.draft = None;
    }

    /// The draft, or else the snapshot.
    pub(super) fn scene(&self) -> &Scene {
        self.draft.as_ref().unwrap_or(&self.snapshot)
    }

    pub(super) fn snapshot(&self) -> &Scene {
        &self.snapshot
    }

    pub(super) fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// Name of the entity that is shown: the root held since a pick, or else the selected entity.
    pub(super) fn root(&self) -> Option<&str> {
        let held = self.pick.as_ref().and_then(|pick| pick.root.as_deref());
        held.filter(|name| self.snapshot.get(name).is_some()).or(self.selected())
    }

    /// Makes everything that depends on the scene obsolete.
    pub(super) fn refresh(&mut self) {
        self.number += 1;
    }

    /// Shows a draft. Returns whether it differs from the current one.
    pub(super) fn set_draft(&mut self, scene: Scene) -> bool {
        let has_changed = self.draft.as_ref() != Some(&scene);
        if has_changed {
            self.draft = Some(scene);
            self.number += 1;
        }
        has_changed
    }

    /// Returns to the snapshot.
    pub(super) fn drop_draft(&mut self) {
        self.draft = None;
        self.number += 1;
    }

    /// Holds the root while this primitive is selected.
    pub(super) fn pick(&mut self, primitive: String) {
        let root = self.root().map(str::to_owned);
        self.pick = Some(Pick { primitive, root });
    }

    /// Ends a pick. Returns the line that selects the held root.
    pub(super) fn end_pick(&mut self) -> Option<String> {
        let root = self.pick.take()?.root?;
        Some(match self.snapshot.get(&root) {
            Some(entity) => commands::select(&root, entity),
            None => commands::select_primitive(&root),
        })
    }
}
