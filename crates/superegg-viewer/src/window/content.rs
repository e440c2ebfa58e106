//! The scene that the window shows.

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Transform, TransformStep};
use superegg_scene::{Entity, Object, Scene};

use crate::commands::{self, free_name};
use crate::input::gizmo::GizmoFrame;
use crate::preview::Preview;
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
    /// The child of the root that is selected in this window.
    child: Option<String>,
    /// The child to select once it is there.
    expected_child: Option<String>,
}

/// A primitive selected by a double click. The object that contains it stays in view.
#[derive(Debug)]
struct Pick {
    primitive: String,
    root: Option<String>,
    /// The session has selected the primitive. Before that, snapshots of earlier lines arrive.
    is_seen: bool,
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
            child: None,
            expected_child: None,
        }
    }

    /// Takes over a snapshot. It ends the draft.
    pub(super) fn replace(&mut self, shown: Shown) {
        if shown.scene != self.snapshot || shown.selected != self.selected {
            self.number += 1;
        }
        let root = self.root().map(str::to_owned);
        if let Some(pick) = &mut self.pick {
            let is_selected = shown.selected.as_ref() == Some(&pick.primitive);
            let is_over = pick.is_seen && !is_selected;
            pick.is_seen |= is_selected;
            if is_over {
                self.pick = None;
            }
        }
        self.snapshot = shown.scene;
        self.selected = shown.selected;
        self.draft = None;
        self.frames = shown.frames;
        self.document = shown.document;
        if self.root() != root.as_deref() || self.selected_child().is_none() {
            self.child = None;
        }
        let is_there =
            |alias: &String| self.root_object().is_some_and(|(_, object)| object.child(alias).is_some());
        if self.expected_child.as_ref().is_some_and(is_there) {
            self.child = self.expected_child.take();
        }
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

    /// Whether the session has not shown the wanted frame yet.
    pub(super) fn waits_for_frame(&self) -> bool {
        self.wanted_frame.is_some()
    }

    /// Wants the next frame, after the last the first one. Returns it if the session has to show it.
    pub(super) fn next_frame(&mut self) -> Option<usize> {
        let Frames { count, current } = self.frames()?;
        self.want_frame((current + 1) % count.max(1))
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

    /// Name and object of the root, if it is an object.
    fn root_object(&self) -> Option<(&str, &Object)> {
        let root = self.root()?;
        match self.scene().get(root)? {
            Entity::Object(object) => Some((root, object)),
            Entity::Primitive(_) | Entity::Table(_) => None,
        }
    }

    /// Alias of the root's child that is selected in this window.
    pub(super) fn selected_child(&self) -> Option<&str> {
        let (_, object) = self.root_object()?;
        self.child.as_deref().filter(|alias| object.child(alias).is_some())
    }

    /// The index of the selected child.
    pub(super) fn child_index(&self) -> Option<u32> {
        let alias = self.selected_child()?;
        let index = self.root_object()?.1.visible_children().position(|(other, _)| other == alias)?;
        Some(index as u32)
    }

    /// Selects a child of the root in this window. Returns the lines that move the session there.
    pub(super) fn select_child(&mut self, alias: &str) -> Vec<String> {
        let Some((root, object)) = self.root_object() else { return Vec::new() };
        if object.child(alias).is_none() {
            return Vec::new();
        }
        let mut lines = self.lines_to_root(root);
        if object.cursor().is_none_or(|(cursor, _)| cursor != alias) {
            lines.push(commands::set_cursor(alias));
        }
        self.child = Some(alias.to_owned());
        lines
    }

    /// Selects a child that the session is about to add.
    pub(super) fn expect_child(&mut self, alias: String) {
        self.expected_child = Some(alias);
    }

    pub(super) fn deselect_child(&mut self) {
        self.child = None;
    }

    /// The lines that select the root, if it is not.
    fn lines_to_root(&self, root: &str) -> Vec<String> {
        if self.selected() == Some(root) { Vec::new() } else { vec![commands::select_object(root)] }
    }

    /// The alias of the root's child that a path leads to.
    pub(super) fn child_on_path(&self, path: &str) -> Option<String> {
        let (root, object) = self.root_object()?;
        let rest = path.strip_prefix(root)?.strip_prefix('/')?;
        let is_on_path =
            |alias: &&str| rest.strip_prefix(*alias).is_some_and(|r| r.is_empty() || r.starts_with('/'));
        let aliases = object.children().map(|(alias, _)| alias).filter(is_on_path);
        aliases.max_by_key(|alias| alias.len()).map(str::to_owned)
    }

    /// The frame of the handles of the selected child.
    pub(super) fn gizmo_frame(&self) -> Option<GizmoFrame> {
        let (_, object) = self.root_object()?;
        let child = object.child(self.selected_child()?)?;
        let own = Transform::from_steps(child.steps()).ok()?;
        let overall = Transform::from_steps(object.overall_steps()).ok()?;
        Some(GizmoFrame { pivot: own.forward().translation, world_from_object: *overall.forward() })
    }

    /// The bounding sphere's box of the selected child in a preview.
    pub(super) fn child_bounds(&self, preview: &Preview) -> Option<Aabb> {
        let index = self.child_index()?;
        let boxes = preview.instances.iter().filter(|instance| instance.child == index).map(|instance| {
            Aabb::around(instance.world_from_unit.translation, DVec3::splat(instance.radius / 3f64.sqrt()))
        });
        let all = boxes.fold(Aabb::EMPTY, |all, next| all.union(&next));
        (!all.is_empty()).then_some(all)
    }

    /// A step of the selected child: the line, and the scene with it.
    pub(super) fn transformed_child(&self, step: &TransformStep) -> Option<(Vec<String>, Scene)> {
        let (root, object) = self.root_object()?;
        let alias = self.selected_child()?;
        let mut lines = self.lines_to_root(root);
        if object.cursor().is_none_or(|(cursor, _)| cursor != alias) {
            lines.push(commands::set_cursor(alias));
        }
        lines.push(commands::transform_step(step, false));
        let mut scene = self.snapshot.clone();
        scene.move_cursor(root, alias).ok()?;
        scene.transform_child(root, step.clone()).ok()?;
        Some((lines, scene))
    }

    /// The lines that remove the selected child.
    pub(super) fn lines_to_remove_child(&self) -> Option<Vec<String>> {
        let (root, _) = self.root_object()?;
        let mut lines = self.lines_to_root(root);
        lines.push(commands::remove_child(self.selected_child()?));
        Some(lines)
    }

    /// The lines that add a copy of the selected child beside it, and the alias of the copy.
    pub(super) fn lines_to_duplicate_child(&self) -> Option<(Vec<String>, String)> {
        let (root, object) = self.root_object()?;
        let child = object.child(self.selected_child()?)?;
        let alias = free_name(self.selected_child()?, |name| object.child(name).is_some());
        let mut lines = self.lines_to_root(root);
        lines.push(commands::add_child(child.target(), self.scene().get(child.target())?, &alias));
        lines.extend(child.steps().map(|step| commands::transform_step(step, false)));
        Some((lines, alias))
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
        self.pick = Some(Pick { primitive, root, is_seen: false });
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
    fn a_picked_primitive_keeps_the_root_in_view_whatever_snapshots_are_on_their_way() {
        let mut session = superegg_lang::Session::default();
        for line in ["prm ball", "obj o", "ap ball", "ap ball two"] {
            assert!(session.run_line(line).is_ok());
        }
        let selecting = |selected: &str| {
            let (scene, selected) = (session.scene().clone(), Some(selected.to_owned()));
            Shown { scene, selected, ..Shown::default() }
        };
        let mut content = Content::new(selecting("o"));
        assert_eq!(content.select_child("ball"), ["setCursor ball"]);
        content.pick("ball".to_owned());
        // The snapshot of the cursor, then that of the primitive.
        for selected in ["o", "ball", "ball"] {
            content.replace(selecting(selected));
            assert_eq!(content.root(), Some("o"));
        }
        assert_eq!(content.select_child("two"), ["object o"]);
        content.replace(selecting("o"));
        assert_eq!(
            (content.root(), content.selected_child(), content.child_index()),
            (Some("o"), Some("two"), Some(1))
        );
        content.replace(selecting("ball"));
        assert_eq!((content.root(), content.selected_child()), (Some("ball"), None));
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
