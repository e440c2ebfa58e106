//! The scene that the window shows.

use superegg_scene::Scene;

use crate::commands;
use crate::protocol::{Document, Frames, Shown};

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
    frames: Option<Frames>,
    /// The frame that the user wants and the session has not shown yet.
    wanted_frame: Option<usize>,
    document: Document,
}

/// A primitive selected by a double click. The object that contains it stays in view.
#[derive(Debug)]
struct Pick {
    primitive: String,
    root: Option<String>,
}

impl Content {
    pub(super) fn new(shown: Shown) -> Self {
        let Shown { scene, selected, frames, document, settings: _ } = shown;
        Self {
            snapshot: scene,
            selected,
            draft: None,
            number: 1,
            pick: None,
            frames,
            wanted_frame: None,
            document,
        }
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
        self.frames = shown.frames;
        self.document = shown.document;
        self.wanted_frame = self.wanted_frame.filter(|wanted| {
            self.frames.is_some_and(|frames| frames.current != *wanted && *wanted < frames.count)
        });
    }

    pub(super) fn document(&self) -> &Document {
        &self.document
    }

    /// The frames, with the one that the user wants as the current one.
    pub(super) fn frames(&self) -> Option<Frames> {
        let frames = self.frames?;
        Some(Frames { current: self.wanted_frame.unwrap_or(frames.current), ..frames })
    }

    /// Wants the frame so many frames later, or the last one there is. Returns it if the session has
    /// to show it.
    pub(super) fn step_frame(&mut self, by: isize) -> Option<usize> {
        let Frames { count, current } = self.frames()?;
        self.want_frame(current.saturating_add_signed(by).min(count.saturating_sub(1)))
    }

    /// Wants a frame. Returns it if the session has to show it.
    pub(super) fn want_frame(&mut self, frame: usize) -> Option<usize> {
        let frames = self.frames()?;
        if frame == frames.current || frame >= frames.count {
            return None;
        }
        self.wanted_frame = Some(frame);
        Some(frame)
    }

    /// Wants no other frame than that of the snapshot.
    pub(super) fn drop_wanted_frame(&mut self) {
        self.wanted_frame = None;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(count: usize, current: usize) -> Shown {
        Shown { frames: Some(Frames { count, current }), ..Shown::default() }
    }

    #[test]
    fn the_wanted_frame_stays_until_the_session_shows_it() {
        let mut content = Content::new(shown(5, 0));
        let current = |content: &Content| content.frames().unwrap().current;
        assert_eq!((content.step_frame(1), content.step_frame(1)), (Some(1), Some(2)));
        // An older frame arrives, then the wanted one.
        content.replace(shown(5, 1));
        assert_eq!(current(&content), 2);
        content.replace(shown(5, 2));
        assert_eq!(current(&content), 2);
        assert_eq!(content.want_frame(2), None, "it is there");
        // It cannot be loaded.
        assert_eq!(content.want_frame(4), Some(4));
        content.drop_wanted_frame();
        assert_eq!(current(&content), 2);
    }

    #[test]
    fn steps_end_at_the_first_and_the_last_frame() {
        let mut content = Content::new(shown(3, 2));
        assert_eq!((content.step_frame(1), content.step_frame(isize::MAX)), (None, None));
        assert_eq!((content.step_frame(isize::MIN), content.step_frame(-1)), (Some(0), None));
        assert_eq!((content.want_frame(3), content.want_frame(usize::MAX)), (None, None));
        // The series gets shorter.
        content.replace(shown(1, 0));
        assert_eq!(content.frames(), Some(Frames { count: 1, current: 0 }));
        let mut still = Content::new(Shown::default());
        assert_eq!((still.step_frame(1), still.want_frame(0)), (None, None));
    }
}
