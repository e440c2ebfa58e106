//! What is in an object, drawn as a tree.

use superegg_lang::{Session, format_number};
use superegg_scene::{Entity, Scene};
use superegg_trace::CompiledScene;

use crate::commands::counted;

/// A drawing has at most so many lines below its first.
const MOST_LINES: usize = 200;
/// It opens objects at most so deep.
const DEEPEST: usize = 12;

/// Instances and bounds of a primitive or object, and the tree of what is in it.
pub(crate) fn show(session: &Session, name: &str) -> String {
    let scene = session.scene();
    let compiled = CompiledScene::compile(scene, Some(name), scene.depth);
    let mut text = format!("{name}: {}", counted(compiled.instance_count(), "instance"));
    match compiled.bounds() {
        None => text.push_str(", nothing to see"),
        Some(bounds) => {
            let corner = |v: superegg_geom::glam::DVec3| v.to_array().map(told).join(" ");
            text.push_str(&format!(", from {} to {}", corner(bounds.min), corner(bounds.max)));
        }
    }
    let mut tree = Tree { scene, lines: Vec::new(), left_out: 0 };
    tree.draw_children(name, "", &mut vec![name]);
    for line in &tree.lines {
        text.push('\n');
        text.push_str(line);
    }
    if tree.left_out > 0 {
        text.push_str(&format!("\n... and {} more, which are not drawn", tree.left_out));
    }
    text
}

/// Six digits, which are enough to look at.
fn told(x: f64) -> String {
    format_number(format!("{x:.5e}").parse().unwrap_or(x))
}

struct Tree<'a> {
    scene: &'a Scene,
    lines: Vec<String>,
    /// Children that found no room.
    left_out: usize,
}

impl<'a> Tree<'a> {
    /// Draws the children of an object, each with what is in it. `open` are the objects from the root down to this one.
    fn draw_children(&mut self, name: &str, indent: &str, open: &mut Vec<&'a str>) {
        let Ok(object) = self.scene.object(name) else { return };
        let last = object.children().len().saturating_sub(1);
        let cursor = object.cursor().map(|(alias, _)| alias);
        for (i, (alias, child)) in object.children().enumerate() {
            if self.lines.len() >= MOST_LINES {
                self.left_out += last + 1 - i;
                return;
            }
            let (branch, below) = if i == last { ("└─ ", "   ") } else { ("├─ ", "│  ") };
            let target = child.target();
            let of = if alias == target { String::new() } else { format!(" = {target}") };
            let mark = if cursor == Some(alias) && indent.is_empty() { "  <- cursor" } else { "" };
            let is_object = matches!(self.scene.get(target), Some(Entity::Object(_)));
            let again = match (is_object, open.iter().position(|name| *name == target)) {
                (true, Some(_)) => "  (itself again)",
                (true, None) if open.len() >= DEEPEST => "  ...",
                _ => "",
            };
            self.lines.push(format!("{indent}{branch}{alias}{of}{again}{mark}"));
            if is_object && again.is_empty() {
                open.push(target);
                self.draw_children(target, &format!("{indent}{below}"), open);
                open.pop();
            }
        }
    }
}
