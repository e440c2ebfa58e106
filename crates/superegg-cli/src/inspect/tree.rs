//! Draws the children of an object as a tree.

use superegg_geom::glam::DVec3;
use superegg_lang::{Session, format_number};
use superegg_scene::{Entity, Scene};
use superegg_trace::CompiledScene;

use crate::text::counted;

/// The maximum number of lines below the first.
const MOST_LINES: usize = 200;
/// The maximum depth of drawn objects.
const MOST_DEPTH: usize = 12;

/// The instance count, the bounding box and the tree of a primitive or object.
pub(crate) fn describe_tree(session: &Session, name: &str) -> String {
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, Some(name), scene.depth);
    let mut text = format!("{name}: {}", counted(compiled.instance_count(), "instance"));
    match compiled.bounds() {
        None => text.push_str(", nothing to see"),
        Some(bounds) => {
            let corner = |v: DVec3| v.to_array().map(six_digits).join(" ");
            text.push_str(&format!(", from {} to {}", corner(bounds.min), corner(bounds.max)));
        }
    }
    let mut tree = Tree { scene, lines: Vec::new(), omitted: 0 };
    tree.draw_children(name, "", &mut vec![name]);
    for line in &tree.lines {
        text.push('\n');
        text.push_str(line);
    }
    if tree.omitted > 0 {
        text.push_str(&format!("\n... and {} more, which are not drawn", tree.omitted));
    }
    text
}

/// Formats a number with six significant digits.
fn six_digits(x: f64) -> String {
    format_number(format!("{x:.5e}").parse().unwrap_or(x))
}

struct Tree<'a> {
    scene: &'a Scene,
    lines: Vec<String>,
    /// The number of children beyond [`MOST_LINES`].
    omitted: usize,
}

impl<'a> Tree<'a> {
    /// Draws the children of an object recursively. `open` holds the objects from the root to this
    /// one.
    fn draw_children(&mut self, name: &str, indent: &str, open: &mut Vec<&'a str>) {
        let Ok(object) = self.scene.object(name) else { return };
        let last = object.children().len().saturating_sub(1);
        let cursor = object.cursor().map(|(alias, _)| alias);
        for (i, (alias, child)) in object.children().enumerate() {
            if self.lines.len() >= MOST_LINES {
                self.omitted += last + 1 - i;
                return;
            }
            let (branch, below) = if i == last { ("└─ ", "   ") } else { ("├─ ", "│  ") };
            let target = child.target();
            let of = if alias == target { String::new() } else { format!(" = {target}") };
            let mark = if cursor == Some(alias) && indent.is_empty() { "  <- cursor" } else { "" };
            let is_object = matches!(self.scene.get(target), Some(Entity::Object(_)));
            let cut = match (is_object, open.contains(&target)) {
                _ if object.is_hidden(alias) => "  (hidden)",
                (true, true) => "  (itself again)",
                (true, false) if open.len() >= MOST_DEPTH => "  ...",
                (true | false, _) => "",
            };
            self.lines.push(format!("{indent}{branch}{alias}{of}{cut}{mark}"));
            if is_object && cut.is_empty() {
                open.push(target);
                self.draw_children(target, &format!("{indent}{below}"), open);
                open.pop();
            }
        }
    }
}
