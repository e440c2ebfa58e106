//! Rectangles and texts on a finished picture.

use superegg_render::EncodedPicture;

use super::glyphs::{CAPITAL, Glyph};

/// A rectangle in pixels from the top left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rectangle {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// An encoded colour that covers a part of what is below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ink {
    pub(super) color: [f32; 3],
    pub(super) opacity: f32,
}

impl Ink {
    pub(super) fn opaque(color: [f32; 3]) -> Self {
        Self { color, opacity: 1.0 }
    }
}

/// A picture to draw on. Nothing is drawn outside it.
pub(super) struct Canvas<'a> {
    pub(super) picture: &'a mut EncodedPicture,
    /// The size of texts and gaps: the width of the pen in pixels, a whole number.
    pub(super) unit: f64,
    /// The colour of texts and lines.
    pub(super) ink: Ink,
    /// The colour below them.
    pub(super) paper: Ink,
}

/// The height of a picture of 4 by 3 in units. Texts are a fortieth of it.
const UNITS: f64 = 320.0;
/// The part of a narrow picture's width that counts as its height.
const NARROW: f64 = 0.75;

impl<'a> Canvas<'a> {
    /// A canvas for a picture with a light or a dark background.
    pub(super) fn new(picture: &'a mut EncodedPicture, is_light: bool) -> Self {
        let [width, height] = [picture.width(), picture.height()].map(f64::from);
        let unit = (height.min(NARROW * width) / UNITS).round().max(1.0);
        let (ink, paper) = if is_light { ([0.1; 3], [1.0; 3]) } else { ([0.95; 3], [0.0; 3]) };
        let opacity = if is_light { 0.75 } else { 0.55 };
        Self { picture, unit, ink: Ink::opaque(ink), paper: Ink { color: paper, opacity } }
    }

    /// The size of the picture in pixels.
    pub(super) fn size(&self) -> [f64; 2] {
        [f64::from(self.picture.width()), f64::from(self.picture.height())]
    }

    /// The height of a line of text in pixels, from the base line to the top of capitals.
    pub(super) fn text_height(&self) -> f64 {
        (CAPITAL + 1.0) * self.unit
    }

    /// Fills a rectangle. Pixels at its edges are covered in part.
    pub(super) fn fill(&mut self, rectangle: Rectangle, ink: Ink) {
        let Rectangle { left, top, width, height } = rectangle;
        let (right, bottom) = (left + width, top + height);
        let [columns, rows] = [self.picture.width(), self.picture.height()];
        let covered = |pixel: u32, from: f64, to: f64| {
            let pixel = f64::from(pixel);
            (to.min(pixel + 1.0) - from.max(pixel)).clamp(0.0, 1.0) as f32
        };
        for y in pixels(top, bottom, rows) {
            let of_row = covered(y, top, bottom) * ink.opacity;
            for x in pixels(left, right, columns) {
                self.picture.blend(x, y, ink.color, of_row * covered(x, left, right));
            }
        }
    }

    /// Writes a text with its lower left corner at a point.
    pub(super) fn text(&mut self, left: f64, base: f64, text: &str) {
        let unit = self.unit;
        let mut at = left;
        for c in text.chars() {
            let glyph = Glyph::of(c);
            let place = |[x, y]: [f64; 2]| [at + (x + 0.5) * unit, base - (y + 0.5) * unit];
            let lines: Vec<[[f64; 2]; 2]> = glyph
                .strokes
                .iter()
                .flat_map(|stroke| stroke.windows(2).map(|ends| [place(ends[0]), place(ends[1])]))
                .collect();
            self.draw_lines(&lines);
            at += glyph.advance * unit;
            // Nothing more can be seen.
            if at > f64::from(self.picture.width()) {
                return;
            }
        }
    }

    /// Draws lines as one shape with the pen.
    fn draw_lines(&mut self, lines: &[[[f64; 2]; 2]]) {
        let radius = 0.5 * pen(self.unit);
        let points = || lines.iter().flatten();
        let range = |axis: usize| {
            let values = || points().map(move |point| point[axis]);
            let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
            (least - radius - 1.0, most + radius + 1.0)
        };
        let ((left, right), (top, bottom)) = (range(0), range(1));
        for y in pixels(top, bottom, self.picture.height()) {
            for x in pixels(left, right, self.picture.width()) {
                let middle = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let nearest = lines.iter().map(|line| distance(middle, *line)).fold(f64::INFINITY, f64::min);
                let part = (radius + 0.5 - nearest).clamp(0.0, 1.0) as f32;
                self.picture.blend(x, y, self.ink.color, part * self.ink.opacity);
            }
        }
    }
}

/// The width of the pen in pixels: thinner than its unit where that has room.
fn pen(unit: f64) -> f64 {
    if unit < 3.0 { unit } else { 0.85 * unit }
}

/// The pixels of a row or column that an interval touches.
fn pixels(from: f64, to: f64, count: u32) -> std::ops::Range<u32> {
    // Conversions of floats stop at the ends of u32.
    from.floor() as u32..(to.ceil() as u32).min(count)
}

/// The distance of a point to a line between two ends.
fn distance([x, y]: [f64; 2], [[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 { (((x - ax) * dx + (y - ay) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - ax - t * dx).hypot(y - ay - t * dy)
}

#[cfg(test)]
mod tests {
    use superegg_render::{Development, Film};
    use superegg_scene::Picture;

    use super::*;

    fn black(width: u32, height: u32) -> EncodedPicture {
        Development::of(&Picture::default()).encode(&Film::new(width, height))
    }

    fn sum(picture: &EncodedPicture) -> f64 {
        let pixels = (0..picture.height()).flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
        pixels.map(|(x, y)| f64::from(picture.value(x, y)[0])).sum()
    }

    #[test]
    fn a_filled_rectangle_has_its_area_whatever_its_place() {
        for (left, top, width, height) in [(3.0, 2.0, 5.0, 4.0), (3.25, 2.5, 5.5, 1.25), (4.1, 4.2, 0.5, 0.3)]
        {
            let mut picture = black(20, 10);
            let white = Ink::opaque([1.0; 3]);
            Canvas::new(&mut picture, false).fill(Rectangle { left, top, width, height }, white);
            assert!((sum(&picture) - width * height).abs() < 0.1, "{left} {top}: {}", sum(&picture));
        }
    }

    #[test]
    fn what_is_outside_is_not_drawn() {
        let far = [f64::NEG_INFINITY, -1e300, -7.5, 0.0, 0.5, 3.0, 1e300, f64::INFINITY, f64::NAN];
        for (width, height) in [(1, 1), (1, 9), (9, 1), (30, 20)] {
            for x in far {
                for y in far {
                    let mut picture = black(width, height);
                    let mut canvas = Canvas::new(&mut picture, false);
                    canvas.text(x, y, "Wg,|_é0");
                    let ink = canvas.ink;
                    canvas.fill(Rectangle { left: x, top: y, width: 5.0, height: x }, ink);
                }
            }
            let mut picture = black(width, height);
            let before = picture.clone();
            Canvas::new(&mut picture, false).text(-100.0, 5.0, "abc");
            Canvas::new(&mut picture, false).text(100.0, 5.0, "abc");
            Canvas::new(&mut picture, false).text(0.0, -10.0, "abc");
            Canvas::new(&mut picture, false).text(0.0, 100.0, "abc");
            assert_eq!(picture, before);
        }
    }

    #[test]
    fn texts_of_one_pixel_a_unit_are_sharp() {
        let mut picture = black(12, 9);
        let mut canvas = Canvas::new(&mut picture, false);
        canvas.ink = Ink::opaque([1.0; 3]);
        canvas.text(1.0, 8.0, "HI");
        let rows: Vec<String> = (1..8)
            .map(|y| (1..10).map(|x| if picture.value(x, y)[0] > 0.5 { '#' } else { '.' }).collect())
            .collect();
        let expected =
            ["#...#.###", "#...#..#.", "#...#..#.", "#####..#.", "#...#..#.", "#...#..#.", "#...#.###"];
        assert_eq!(rows, expected);
        for y in 0..9 {
            for x in 0..12 {
                assert!([0.0, 1.0].contains(&picture.value(x, y)[0]), "{x} {y}");
            }
        }
    }
}
