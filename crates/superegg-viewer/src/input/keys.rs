//! Key bindings: one table for the window, the help on screen and the documents.

/// The action of a key or of a button of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Return the keyboard to the command line.
    KeyboardBack,
    /// Lights turn with the scene, or stay with the eye.
    ToggleLightsTurn,
    /// Shading per pixel (Phong) or per vertex (Gouraud).
    ToggleShading,
    /// Enlarge the scene by [`SCALE_STEP`].
    Larger,
    /// Shrink the scene by [`SCALE_STEP`].
    Smaller,
    /// Rebuild everything from the scene.
    Refresh,
    /// Edges instead of surfaces.
    ToggleWireframe,
    /// Normals at the vertices, in wireframe.
    ToggleNormals,
    /// The inside-outside test.
    ToggleIoTest,
    /// The points outside, in the inside-outside test.
    ToggleOutside,
    /// The intersection test.
    ToggleIntersectTest,
    /// Ray tracing instead of the preview.
    ToggleTrace,
    /// The coordinate axes and the positions of the lights.
    ToggleAxes,
    /// Fit the selected child into the window, or the whole scene if none is selected.
    FrameSelected,
    /// Fit the whole scene into the window.
    FrameAll,
    /// Handles that move the selected child.
    MoveTool,
    /// Handles that rotate the selected child.
    RotateTool,
    /// Handles that scale the selected child.
    ScaleTool,
    /// See the scene from the front.
    FrontView,
    /// See the scene from the right.
    RightView,
    /// See the scene from the top.
    TopView,
    /// Remove the selected child.
    Delete,
    /// Duplicate the selected child.
    Duplicate,
    /// Return to the scene's own camera.
    Home,
    /// Make the current view the scene's camera.
    WriteCamera,
    /// Save a picture of the window as a numbered file.
    Screenshot,
    /// The side panel.
    TogglePanel,
    /// Start or stop to show the frames one after another.
    TogglePlaying,
    /// Render the scene to a picture.
    Render,
    /// Give the keyboard to the panel.
    FocusPanel,
    /// The list of keys on screen.
    ToggleHelp,
    /// Undo the last command.
    Undo,
    /// Redo the command undone last.
    Redo,
    /// Begin a new scene.
    New,
    /// Open a scene.
    Open,
    /// Save the scene.
    Save,
    /// Save the scene in another file.
    SaveAs,
    /// Show the frame before.
    PreviousFrame,
    /// Show the next frame.
    NextFrame,
}

/// Factor of [`Action::Larger`] and [`Action::Smaller`].
pub const SCALE_STEP: f64 = 1.1;

/// A row of the table.
#[derive(Debug)]
pub struct Binding {
    /// The keys: a character as typed, or the name of a key, after `Ctrl+` or `Ctrl+Shift+` where
    /// those are held.
    pub keys: &'static [&'static str],
    /// Their action.
    pub action: Action,
    /// Help text.
    pub help: &'static str,
}

const fn row(keys: &'static [&'static str], action: Action, help: &'static str) -> Binding {
    Binding { keys, action, help }
}

/// All bindings, those of the course program first.
pub const BINDINGS: &[Binding] = &[
    row(&["q", "Escape"], Action::KeyboardBack, "return the keyboard to the command line"),
    row(&["b"], Action::ToggleLightsTurn, "lights turn with the scene, or stay"),
    row(&["m"], Action::ToggleShading, "shading per pixel (Phong) or per vertex (Gouraud)"),
    row(&["w"], Action::Larger, "scene larger"),
    row(&["s"], Action::Smaller, "scene smaller"),
    row(&["r"], Action::Refresh, "refresh the scene"),
    row(&["t"], Action::ToggleWireframe, "wireframe"),
    row(&["n"], Action::ToggleNormals, "normals, in wireframe"),
    row(&["o"], Action::ToggleIoTest, "inside-outside test"),
    row(&["i"], Action::ToggleIntersectTest, "intersection test"),
    row(&["p"], Action::ToggleTrace, "ray trace the view"),
    row(&["a"], Action::ToggleAxes, "axes and positions of the lights"),
    row(&["u"], Action::ToggleOutside, "points outside, in the inside-outside test"),
    row(&["f"], Action::FrameSelected, "frame what is selected"),
    row(&["Shift+f"], Action::FrameAll, "frame all"),
    row(&["1"], Action::MoveTool, "handles to move what is selected"),
    row(&["2"], Action::RotateTool, "handles to rotate it; with Ctrl in steps of 15 degrees"),
    row(&["3"], Action::ScaleTool, "handles to scale it"),
    row(&["7"], Action::FrontView, "view from the front"),
    row(&["8"], Action::RightView, "view from the right"),
    row(&["9"], Action::TopView, "view from the top"),
    row(&["Delete"], Action::Delete, "remove the selected child"),
    row(&["Ctrl+d"], Action::Duplicate, "duplicate the selected child"),
    row(&["Home"], Action::Home, "the scene's camera"),
    row(&["c"], Action::WriteCamera, "write this view into the scene as its camera"),
    row(&["F12", "PrintScreen"], Action::Screenshot, "screenshot to a numbered PNG"),
    row(&["Tab"], Action::TogglePanel, "side panel"),
    row(&["F6"], Action::FocusPanel, "keyboard to the panel: Tab goes on, Escape returns"),
    row(&["h", "?"], Action::ToggleHelp, "these keys"),
    row(&["Ctrl+z"], Action::Undo, "undo the last command"),
    row(&["Ctrl+y", "Ctrl+Shift+z"], Action::Redo, "redo"),
    row(&["Ctrl+n"], Action::New, "new scene"),
    row(&["Ctrl+o"], Action::Open, "open a scene; a file dropped on the window opens too"),
    row(&["Ctrl+s"], Action::Save, "save"),
    row(&["Ctrl+Shift+s"], Action::SaveAs, "save as"),
    row(&[","], Action::PreviousFrame, "the frame before, of a series"),
    row(&["."], Action::NextFrame, "the next frame"),
    row(&["Space"], Action::TogglePlaying, "play the frames, or stop"),
    row(&["Ctrl+r"], Action::Render, "render to a picture"),
];

/// Actions of the pointer, for the help on screen.
pub const POINTER_HELP: &[(&str, &str)] = &[
    ("left drag", "turn the scene"),
    ("right, middle or Shift+left drag", "move the scene"),
    ("wheel", "zoom"),
    ("click", "select the child; with the intersection test on: test at that pixel"),
    ("double click", "select the primitive; on the background: the whole object again"),
];

/// The action of a letter with Shift held: its own, or else that of the letter.
pub fn action_of_shifted(key: &str) -> Option<Action> {
    action_of(&format!("Shift+{}", key.to_lowercase())).or_else(|| action_of(key))
}

/// The action of a key. Letters count in either case unless Ctrl is held.
pub fn action_of(key: &str) -> Option<Action> {
    let is_same = |bound: &str| bound == key || (key.chars().count() == 1 && bound == key.to_lowercase());
    BINDINGS.iter().find(|row| row.keys.iter().any(|bound| is_same(bound))).map(|row| row.action)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn a_key_has_one_action_and_an_action_has_one_row() {
        let keys: Vec<&str> = BINDINGS.iter().flat_map(|row| row.keys).copied().collect();
        assert_eq!(keys.iter().collect::<HashSet<_>>().len(), keys.len());
        assert_eq!(BINDINGS.iter().map(|row| row.action).collect::<HashSet<_>>().len(), BINDINGS.len());
        assert!(BINDINGS.iter().all(|row| row.keys.iter().all(|key| action_of(key) == Some(row.action))));
    }

    /// The book is beside the crate in the repository, and not in its package.
    #[test]
    fn the_page_of_the_window_has_every_key() {
        let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/window.md");
        let Ok(page) = std::fs::read_to_string(page) else { return };
        let section = page.split("## Keys").nth(1).unwrap().split("\n## ").next().unwrap();
        let cells = section.lines().filter_map(|line| line.strip_prefix("| `")?.split(" |").next());
        let mut listed: Vec<&str> = cells.flat_map(|cell| cell.split('`').step_by(2)).collect();
        let mut bound: Vec<&str> = BINDINGS.iter().flat_map(|row| row.keys).copied().collect();
        listed.retain(|key| !key.is_empty());
        listed.sort_unstable();
        bound.sort_unstable();
        assert_eq!(listed, bound);
    }

    #[test]
    fn keys_of_the_course_program() {
        for key in ["q", "Escape", "b", "m", "w", "s", "r", "t", "n", "o", "i", "p"] {
            assert!(action_of(key).is_some(), "{key}");
        }
        assert_eq!(
            (action_of("T"), action_of("x"), action_of("")),
            (Some(Action::ToggleWireframe), None, None)
        );
    }
}
