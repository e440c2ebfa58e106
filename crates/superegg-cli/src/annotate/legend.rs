//! The meaning of the colours of data: a bar of a colour map with ticks, or a swatch for each type.

use superegg_exchange::coloring::{ColorKey, Coloring, Colormap, Palette, share_of, type_color};
use superegg_geom::glam::DVec3;
use superegg_render::Development;

use super::canvas::{Canvas, Ink, Rectangle};
use super::glyphs::text_width;
use super::round::{Label, ticks};

/// The height of the bar of a colour map as a part of the picture's.
const BAR_PART: f64 = 0.45;
/// A longer title is cut.
const LONGEST_TITLE: usize = 28;

/// The legend of a coloured column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Legend {
    title: String,
    scale: Scale,
}

#[derive(Clone, Debug, PartialEq)]
enum Scale {
    Map { map: Colormap, range: [f64; 2] },
    Types(Vec<f64>),
}

impl Legend {
    /// The legend of data; `None` if its colours stand for no numbers.
    pub(crate) fn of(coloring: &Coloring, key: &ColorKey) -> Option<Self> {
        let (title, scale) = match (coloring, key) {
            (Coloring::ByColumn(by), ColorKey::Range(range)) => {
                (by.column.as_str(), Scale::Map { map: by.map, range: *range })
            }
            (Coloring::ByType, ColorKey::Types(types)) => ("type", Scale::Types(types.clone())),
            _ => return None,
        };
        let is_long = title.chars().count() > LONGEST_TITLE;
        let cut: String = title.chars().take(LONGEST_TITLE - 2).collect();
        Some(Self { title: if is_long { cut + ".." } else { title.to_owned() }, scale })
    }

    /// Draws the legend at the right edge, at half the height.
    pub(super) fn draw(&self, canvas: &mut Canvas<'_>, development: &Development) {
        match &self.scale {
            Scale::Map { map, range } => self.draw_map(canvas, development, *map, *range),
            Scale::Types(types) => self.draw_types(canvas, development, types),
        }
    }

    fn draw_map(&self, canvas: &mut Canvas<'_>, development: &Development, map: Colormap, range: [f64; 2]) {
        let unit = canvas.unit;
        let ticks = ticks(range);
        let (bar_width, mark, gap) = (7.0 * unit, 2.0 * unit, 2.0 * unit);
        let [_, height] = canvas.size();
        let bar_height = (BAR_PART * height).round().max(1.0);
        let width = bar_width + mark + gap + widest(ticks.iter().map(|tick| tick.text.as_str())) * unit;
        let [left, top] = self.panel(canvas, [width, bar_height + 0.5 * canvas.text_height()]);
        let palette = Palette::of(map);
        for row in 0..bar_height as u32 {
            let up = 1.0 - (f64::from(row) + 0.5) / bar_height;
            // A range without width has one colour.
            let share = if range[0] < range[1] { up } else { 0.5 };
            let color = palette.color(share).unwrap_or_default();
            let strip = Rectangle { left, top: top + f64::from(row), width: bar_width, height: 1.0 };
            canvas.fill(strip, flat(development, color));
        }
        let line = (0.5 * unit).round().max(1.0);
        outline(canvas, Rectangle { left, top, width: bar_width, height: bar_height }, line);
        for Label { value, text } in &ticks {
            let y = top + bar_height * (1.0 - share_of(*value, range));
            let y = y.clamp(top + 0.5 * line, top + bar_height - 0.5 * line);
            let right = left + bar_width;
            canvas.fill(
                Rectangle { left: right, top: (y - 0.5 * line).round(), width: mark, height: line },
                canvas.ink,
            );
            let base = (y + 0.5 * canvas.text_height()).round();
            canvas.text(right + mark + gap, base, text);
        }
    }

    fn draw_types(&self, canvas: &mut Canvas<'_>, development: &Development, types: &[f64]) {
        let unit = canvas.unit;
        let (side, gap, pitch) = (canvas.text_height(), 3.0 * unit, canvas.text_height() + 4.0 * unit);
        // As many as the height has room for.
        let [_, height] = canvas.size();
        let most = ((0.8 * height / pitch) as usize).clamp(1, types.len().max(1));
        let shown = &types[..most.min(types.len())];
        let mut texts: Vec<String> = shown.iter().map(f64::to_string).collect();
        if shown.len() < types.len() {
            texts.push(format!("+{}", types.len() - shown.len()));
        }
        let width = side + gap + widest(texts.iter().map(String::as_str)) * unit;
        let [left, top] = self.panel(canvas, [width, texts.len() as f64 * pitch - 4.0 * unit]);
        let line = (0.5 * unit).round().max(1.0);
        for (row, text) in texts.iter().enumerate() {
            let top = top + row as f64 * pitch;
            if let Some(value) = shown.get(row) {
                let swatch = Rectangle { left, top, width: side, height: side };
                canvas.fill(swatch, flat(development, type_color(*value)));
                outline(canvas, swatch, line);
            }
            canvas.text(left + side + gap, top + side, text);
        }
    }

    /// Lays paper for a content of this size and writes the title above it. Returns the upper left
    /// corner of the content.
    fn panel(&self, canvas: &mut Canvas<'_>, [width, height]: [f64; 2]) -> [f64; 2] {
        let unit = canvas.unit;
        let (margin, pad) = (6.0 * unit, 4.0 * unit);
        let above = canvas.text_height() + 5.0 * unit;
        let width = width.max(text_width(&self.title) * unit).round() + 2.0 * pad;
        let height = (above + height).round() + 2.0 * pad;
        let [right, bottom] = canvas.size();
        let (left, top) = (right - margin - width, (0.5 * (bottom - height)).round());
        canvas.fill(Rectangle { left, top, width, height }, canvas.paper);
        canvas.text(left + pad, top + pad + canvas.text_height(), &self.title);
        [left + pad, top + pad + above]
    }
}

/// A colour of data as the picture has it, without light: encoded, but not exposed.
fn flat(development: &Development, color: DVec3) -> Ink {
    Ink::opaque(development.value(color.as_vec3().to_array()))
}

/// The width of the longest text, in units.
fn widest<'a>(texts: impl Iterator<Item = &'a str>) -> f64 {
    texts.map(text_width).fold(0.0, f64::max)
}

/// A frame within the edge of a rectangle.
fn outline(canvas: &mut Canvas<'_>, Rectangle { left, top, width, height }: Rectangle, line: f64) {
    let ink = canvas.ink;
    for edge in [
        Rectangle { left, top, width, height: line },
        Rectangle { left, top: top + height - line, width, height: line },
        Rectangle { left, top: top + line, width: line, height: height - 2.0 * line },
        Rectangle { left: left + width - line, top: top + line, width: line, height: height - 2.0 * line },
    ] {
        canvas.fill(edge, ink);
    }
}
