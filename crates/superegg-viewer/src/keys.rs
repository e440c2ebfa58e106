//! What the keys do: one table for the window, the help on screen and the documents.

/// What a key, or a button of the panel, asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The keyboard goes back to the command line.
    KeyboardBack,
    /// Lights turn with the scene, or stay.
    ToggleLightsTurn,
    /// Shading at each pixel, or at each vertex.
    ToggleShading,
    /// The scene larger by [`SCALE_STEP`].
    Larger,
    /// The scene smaller by [`SCALE_STEP`].
    Smaller,
    /// Everything made anew from the scene.
    Refresh,
    /// Edges instead of surfaces, or back.
    ToggleWireframe,
    /// Normals at the vertices, in wireframe.
    ToggleNormals,
    /// The inside-outside test.
    ToggleIoTest,
    /// The intersection test.
    ToggleIntersectTest,
    /// Ray tracing in the window, or back.
    ToggleTrace,
    /// The three axes and the places of the lights.
    ToggleAxes,
    /// All of the scene into the window.
    FrameAll,
    /// The scene's own camera.
    Home,
    /// The present view becomes the scene's camera.
    WriteCamera,
    /// A picture of the window into a numbered file.
    Screenshot,
    /// The side panel.
    TogglePanel,
    /// The keys on screen.
    ToggleHelp,
    /// The last command undone.
    Undo,
    /// The command undone last, done again.
    Redo,
}

/// `Larger` and `Smaller` scale by this.
pub const SCALE_STEP: f64 = 1.1;

/// A row of the table.
#[derive(Debug)]
pub struct Binding {
    /// The keys: a character as typed, or the name of a key; `Ctrl+` before it for that key held.
    pub keys: &'static [&'static str],
    /// What they ask for.
    pub action: Action,
    /// What it does, in a few words.
    pub help: &'static str,
}

const fn row(keys: &'static [&'static str], action: Action, help: &'static str) -> Binding {
    Binding { keys, action, help }
}

/// All keys. Those of the course program come first.
pub const BINDINGS: &[Binding] = &[
    row(&["q", "Escape"], Action::KeyboardBack, "keyboard back to the command line"),
    row(&["b"], Action::ToggleLightsTurn, "lights turn with the scene, or stay"),
    row(&["m"], Action::ToggleShading, "shading per pixel (Phong) or per vertex (Gouraud)"),
    row(&["w"], Action::Larger, "scene larger"),
    row(&["s"], Action::Smaller, "scene smaller"),
    row(&["r"], Action::Refresh, "refresh the scene"),
    row(&["t"], Action::ToggleWireframe, "wireframe"),
    row(&["n"], Action::ToggleNormals, "normals, in wireframe"),
    row(&["o"], Action::ToggleIoTest, "inside-outside test"),
    row(&["i"], Action::ToggleIntersectTest, "intersection test"),
    row(&["p"], Action::ToggleTrace, "ray trace what is seen, or back"),
    row(&["a"], Action::ToggleAxes, "axes and places of the lights"),
    row(&["f"], Action::FrameAll, "frame all"),
    row(&["Home"], Action::Home, "the scene's camera"),
    row(&["c"], Action::WriteCamera, "write this view into the scene as its camera"),
    row(&["F12", "PrintScreen"], Action::Screenshot, "screenshot to a numbered PNG"),
    row(&["Tab"], Action::TogglePanel, "side panel"),
    row(&["h", "?"], Action::ToggleHelp, "these keys"),
    row(&["Ctrl+z"], Action::Undo, "undo the last command"),
    row(&["Ctrl+y", "Ctrl+Shift+z"], Action::Redo, "do it again"),
];

/// What the pointer does, for the help on screen.
pub const POINTER_HELP: &[(&str, &str)] = &[
    ("left drag", "turn the scene"),
    ("middle drag", "move it"),
    ("wheel", "nearer and farther"),
    ("click", "intersection test at that pixel"),
    ("double click", "select the primitive; beside everything: the whole again"),
];

/// What a key asks for. Letters count in either case, unless Ctrl is held.
pub fn action_of(key: &str) -> Option<Action> {
    let is_same = |bound: &str| bound == key || (key.chars().count() == 1 && bound == key.to_lowercase());
    BINDINGS.iter().find(|row| row.keys.iter().any(|bound| is_same(bound))).map(|row| row.action)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn a_key_asks_for_one_thing_and_a_thing_has_one_row() {
        let keys: Vec<&str> = BINDINGS.iter().flat_map(|row| row.keys).copied().collect();
        assert_eq!(keys.iter().collect::<HashSet<_>>().len(), keys.len());
        assert_eq!(BINDINGS.iter().map(|row| row.action).collect::<HashSet<_>>().len(), BINDINGS.len());
        assert!(BINDINGS.iter().all(|row| row.keys.iter().all(|key| action_of(key) == Some(row.action))));
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
