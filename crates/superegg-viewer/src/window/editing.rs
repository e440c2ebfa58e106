//! Direct manipulation: the selected child, its handles, and views from a side.

use superegg_geom::Ray;
use winit::event::KeyEvent;
use winit::keyboard::{Key, NamedKey};

use super::app::App;
use crate::commands;
use crate::input::gizmo::Handles;
use crate::input::{Projection, ViewSide};
use crate::queries::cast;

impl App {
    fn projection(&self) -> Projection {
        Projection::new(&self.view.eye.camera(), &self.view.viewport)
    }

    /// The handles of the selected child.
    pub(super) fn handles(&self) -> Option<Handles> {
        let tool = self.view.tool.filter(|_| !self.view.is_traced)?;
        Handles::new(tool, &self.content.gizmo_frame()?, &self.projection())
    }

    /// The directions of the x, y and z axes on the screen: right, up, towards the eye.
    pub(super) fn compass(&self) -> [[f64; 3]; 3] {
        let (right, up, forward) = self.projection().axes();
        [0, 1, 2].map(|axis| [right[axis], up[axis], -forward[axis]])
    }

    /// Selects the root's child that a ray hits, or none.
    pub(super) fn select_child_at(&mut self, ray: &Ray) {
        let Some(compiled) = self.background.compiled() else { return };
        let hit = cast(self.content.snapshot(), compiled, ray);
        match hit.and_then(|hit| self.content.child_on_path(&hit.path)) {
            Some(alias) => self.select_child(&alias),
            None => self.content.deselect_child(),
        }
    }

    /// Selects a child of the root.
    pub(super) fn select_child(&mut self, alias: &str) {
        let lines = self.content.select_child(alias);
        self.outbox.lines(lines);
        self.redraw();
    }

    /// Gives a child of the selected object another alias. It stays selected.
    pub(super) fn rename_child(&mut self, alias: &str, new: &str) {
        if self.content.selected_child() == Some(alias) && self.content.selected() == self.content.root() {
            self.content.expect_child(new.to_owned());
        }
        self.outbox.command(commands::rename_child(alias, new));
    }

    pub(super) fn frame_selected(&mut self) {
        let bounds = self.content.child_bounds(self.background.preview());
        let bounds = bounds.unwrap_or_else(|| self.background.bounds());
        self.view.eye.frame(&bounds, self.view.viewport.aspect());
    }

    pub(super) fn look_from(&mut self, side: ViewSide) {
        let (direction, up) = side.directions(self.content.scene().up());
        self.view.eye.look_from(direction, up);
        self.redraw();
    }

    pub(super) fn delete_child(&mut self) {
        match self.content.lines_to_remove_child() {
            Some(lines) => self.outbox.change("remove a child", lines),
            None => self.report(NO_CHILD.to_owned()),
        }
    }

    pub(super) fn duplicate_child(&mut self) {
        match self.content.lines_to_duplicate_child() {
            Some((lines, alias)) => {
                self.outbox.change(&format!("duplicate as {alias}"), lines);
                self.content.expect_child(alias);
            }
            None => self.report(NO_CHILD.to_owned()),
        }
    }

    /// Grabs a handle at the pointer. Returns whether there is one.
    pub(super) fn press_gizmo(&mut self) -> bool {
        let (Some(handles), Some(frame)) = (self.handles(), self.content.gizmo_frame()) else { return false };
        self.gizmo = handles.press(self.pointer.position, &frame, &self.projection());
        self.gizmo.is_some()
    }

    /// Moves a grabbed handle to the pointer. Returns whether there is one.
    pub(super) fn drag_gizmo(&mut self) -> bool {
        let Some(mut drag) = self.gizmo else { return false };
        let step = drag.step(self.pointer.position, self.modifiers.control_key());
        self.gizmo = Some(drag);
        match step.and_then(|step| self.content.transformed_child(&step)) {
            Some((_, scene)) => drop(self.content.set_draft(scene)),
            None => self.content.drop_draft(),
        }
        true
    }

    /// Releases a grabbed handle: its step becomes a line. Returns whether there was one.
    pub(super) fn release_gizmo(&mut self) -> bool {
        let Some(mut drag) = self.gizmo.take() else { return false };
        let step = drag.step(self.pointer.position, self.modifiers.control_key());
        match step.and_then(|step| self.content.transformed_child(&step)) {
            Some((lines, _)) => self.outbox.lines(lines),
            None => self.content.drop_draft(),
        }
        true
    }

    /// Escape lets go of a handle and changes nothing.
    pub(super) fn cancel_gizmo(&mut self, event: &KeyEvent) -> bool {
        let is_cancelled = self.gizmo.is_some() && event.logical_key == Key::Named(NamedKey::Escape);
        if is_cancelled {
            self.gizmo = None;
            self.content.drop_draft();
            self.redraw();
        }
        is_cancelled
    }
}

const NO_CHILD: &str = "no child is selected; click one in the scene or in the panel";
