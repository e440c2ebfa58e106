//! Lines of the modelling language.

use std::collections::{HashMap, HashSet};

use superegg_geom::TransformStep;
use superegg_geom::glam::{DAffine3, DVec3};

/// The recursion depth of a scene that sets none.
const DEFAULT_DEPTH: usize = 25;

/// The text of a scene, and the names in it.
#[derive(Debug, Default)]
pub(crate) struct Script {
    text: String,
    names: Names,
}

/// Names that differ.
#[derive(Debug, Default)]
pub(crate) struct Names {
    used: HashSet<String>,
    /// The number that the next of several equal names gets.
    next: HashMap<String, u64>,
}

impl Names {
    /// A name as much like `wanted` as the language and the other names allow.
    pub(crate) fn add(&mut self, wanted: &str) -> String {
        let plain = plain_name(wanted);
        let mut name = plain.clone();
        while !self.used.insert(name.clone()) {
            let number = self.next.entry(plain.clone()).or_insert(1);
            *number += 1;
            name = format!("{plain}_{number}");
        }
        name
    }
}

impl Script {
    /// Appends a command with its arguments.
    pub(crate) fn line(&mut self, words: &[&str]) {
        self.text.push_str(&words.join(" "));
        self.text.push('\n');
    }

    /// Appends a command with a name and numbers; an empty name is left out.
    pub(crate) fn numbers(&mut self, command: &str, name: &str, numbers: &[f64]) {
        self.text.push_str(command);
        for word in [name].into_iter().filter(|name| !name.is_empty()) {
            self.text.push(' ');
            self.text.push_str(word);
        }
        for number in numbers {
            self.text.push(' ');
            self.text.push_str(&number_text(*number));
        }
        self.text.push('\n');
    }

    /// Appends an empty line.
    pub(crate) fn gap(&mut self) {
        self.text.push('\n');
    }

    /// Appends transforms; `suffix` is "All" for those of the whole object.
    pub(crate) fn steps(&mut self, steps: &[TransformStep], suffix: &str) {
        for step in steps {
            let (command, numbers) = match step {
                TransformStep::Translate(by) => ("translate", by.to_array().to_vec()),
                TransformStep::Scale(factors) => ("scale", factors.to_array().to_vec()),
                TransformStep::Rotate { axis, angle_deg } => {
                    ("rotate", vec![axis.x, axis.y, axis.z, *angle_deg])
                }
                TransformStep::Orient(q) => ("orient", vec![q.w, q.x, q.y, q.z]),
                TransformStep::Affine(map) => ("matrix", rows_of(map)),
            };
            self.numbers(&format!("{command}{suffix}"), "", &numbers);
        }
    }

    /// Sets the recursion depth if the objects are nested deeper than the default.
    pub(crate) fn depth(&mut self, levels: usize) {
        if levels > DEFAULT_DEPTH {
            self.line(&["setDepth", &levels.to_string()]);
        }
    }

    /// A name for a new entity or light, as much like `wanted` as the language and the other names
    /// allow.
    pub(crate) fn new_name(&mut self, wanted: &str) -> String {
        self.names.add(wanted)
    }

    /// The text.
    pub(crate) fn into_text(self) -> String {
        self.text
    }
}

/// The twelve numbers of a map, row by row.
fn rows_of(map: &DAffine3) -> Vec<f64> {
    let rows = map.matrix3.transpose();
    let by = map.translation.to_array();
    let rows = [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().zip(by);
    rows.flat_map(|(row, by)| [row.x, row.y, row.z, by]).collect()
}

/// A word that is a name: without blanks, comment signs, quotes and what cannot be seen.
fn plain_name(wanted: &str) -> String {
    let is_hidden = |c: char| matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}');
    let is_wrong = |c: char| c.is_whitespace() || c.is_control() || matches!(c, '#' | '"') || is_hidden(c);
    let name: String = wanted.trim().chars().take(200).map(|c| if is_wrong(c) { '_' } else { c }).collect();
    if name.is_empty() { "unnamed".to_owned() } else { name }
}

/// The shortest text that reads back to the same f64.
fn number_text(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) { format!("{x}") } else { format!("{x:e}") }
}

/// A colour as a unit colour and a weight: `color * weight`, with the greatest channel of the
/// colour 1. Black is white of weight 0.
pub(crate) fn color_and_weight(color: DVec3) -> (DVec3, f64) {
    let weight = color.max_element();
    if weight > 0.0 { (color / weight, weight) } else { (DVec3::ONE, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_words_and_differ() {
        let mut script = Script::default();
        let names = ["a b", "a#b", "a\tb", "", " ", "é", "\u{202e}x"].map(|name| script.new_name(name));
        assert_eq!(names, ["a_b", "a_b_2", "a_b_3", "unnamed", "unnamed_2", "é", "_x"]);
    }

    #[test]
    fn lines_are_commands() {
        let mut script = Script::default();
        script.numbers("light", "lamp", &[1.0, 1e-9, -0.5]);
        let turn = TransformStep::Rotate { axis: DVec3::Y, angle_deg: 30.0 };
        script.steps(&[turn, TransformStep::Scale(DVec3::splat(2.0))], "All");
        script.depth(25);
        script.depth(26);
        let expected = "light lamp 1 1e-9 -0.5\nrotateAll 0 1 0 30\nscaleAll 2 2 2\nsetDepth 26\n";
        assert_eq!(script.into_text(), expected);
        assert_eq!(color_and_weight(DVec3::new(0.0, 0.4, 0.8)), (DVec3::new(0.0, 0.5, 1.0), 0.8));
    }
}
