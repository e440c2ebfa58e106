//! Draws a picture in the terminal, which also works over ssh.

use std::io::IsTerminal;

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use superegg_lang::PreviewStyle;
use superegg_render::{Development, Film};

use crate::modeller::sixel::sixel;
use crate::system::terminal::has_cursor;

/// A method of drawing pictures in a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Canvas {
    /// Two pixels per character, in true colour.
    Blocks,
    /// Two rows of pixels per character, by brightness, without escape sequences.
    Plain,
    /// The kitty picture protocol.
    Kitty,
    /// Sixel graphics.
    Sixel,
}

impl Canvas {
    /// The canvas of a style; `Auto` chooses by the environment variables of the terminal.
    pub(crate) fn choose(style: PreviewStyle) -> Self {
        let is = |name: &str, values: &[&str]| {
            std::env::var(name).is_ok_and(|value| values.iter().any(|known| value.contains(known)))
        };
        match style {
            PreviewStyle::Blocks => Self::Blocks,
            PreviewStyle::Kitty => Self::Kitty,
            PreviewStyle::Sixel => Self::Sixel,
            PreviewStyle::Plain => Self::Plain,
            PreviewStyle::Auto if !std::io::stdout().is_terminal() || !has_cursor() => Self::Plain,
            // Multiplexers do not forward pictures.
            PreviewStyle::Auto if is("TERM", &["screen", "tmux"]) => Self::Blocks,
            PreviewStyle::Auto
                if is("TERM", &["kitty", "ghostty"]) || is("TERM_PROGRAM", &["WezTerm", "ghostty"]) =>
            {
                Self::Kitty
            }
            PreviewStyle::Auto if is("TERM", &["foot", "mlterm", "sixel", "contour"]) => Self::Sixel,
            PreviewStyle::Auto => Self::Blocks,
        }
    }

    /// The size in pixels of a picture of this aspect on a terminal of `columns` by `rows`.
    pub(crate) fn size_px(self, (width, height): (u32, u32), columns: u32, rows: u32) -> (u32, u32) {
        // A character is twice as high as wide; 8 by 16 pixels for pixel graphics.
        let (across, down) = match self {
            Self::Blocks | Self::Plain => (columns, 2 * rows),
            Self::Kitty | Self::Sixel => (8 * columns.min(100), 16 * rows.min(40)),
        };
        let scale = f64::min(f64::from(across) / f64::from(width), f64::from(down) / f64::from(height));
        let side =
            |length: u32, most: u32| ((f64::from(length) * scale).round() as u32).clamp(1, most.max(1));
        (side(width, across), side(height, down))
    }

    /// The text that draws the film, without a final line break. `development` must be for screens:
    /// 8 bits, sRGB.
    pub(crate) fn draw(self, film: &Film, development: &Development) -> anyhow::Result<String> {
        Ok(match self {
            Self::Blocks => blocks(film, &development.rgb8(film)),
            Self::Plain => plain(film, &development.rgb8(film)),
            Self::Kitty => kitty(&development.png(film)?),
            Self::Sixel => sixel(&development.rgb8(film), film.width() as usize),
        })
    }
}

/// The colour of a pixel of the RGB `bytes`; `None` below the last row.
fn pixel(film: &Film, bytes: &[u8], x: u32, y: u32) -> Option<[u8; 3]> {
    let i = 3 * (y as usize * film.width() as usize + x as usize);
    (y < film.height()).then(|| [bytes[i], bytes[i + 1], bytes[i + 2]])
}

/// Draws with upper half blocks: the foreground is the upper pixel, the background the lower one.
fn blocks(film: &Film, bytes: &[u8]) -> String {
    let mut text = String::new();
    for y in (0..film.height()).step_by(2) {
        let mut last = None;
        for x in 0..film.width() {
            let colors = (pixel(film, bytes, x, y), pixel(film, bytes, x, y + 1));
            if last != Some(colors) {
                let code = |layer: u8, color: Option<[u8; 3]>| match color {
                    Some([r, g, b]) => format!("\x1b[{layer};2;{r};{g};{b}m"),
                    None => format!("\x1b[{}m", layer + 1),
                };
                text.push_str(&code(38, colors.0));
                text.push_str(&code(48, colors.1));
                last = Some(colors);
            }
            text.push('▀');
        }
        text.push_str("\x1b[0m");
        if y + 2 < film.height() {
            text.push('\n');
        }
    }
    text
}

/// Draws with characters of increasing brightness.
fn plain(film: &Film, bytes: &[u8]) -> String {
    const DARK_TO_BRIGHT: &[u8] = b" .:-=+*#%@";
    let mut lines = Vec::new();
    for y in (0..film.height()).step_by(2) {
        let mut line = String::new();
        for x in 0..film.width() {
            let both = [pixel(film, bytes, x, y), pixel(film, bytes, x, y + 1)];
            let seen: Vec<f64> = both.into_iter().flatten().map(brightness).collect();
            let mean = seen.iter().sum::<f64>() / seen.len().max(1) as f64;
            let level = (mean * (DARK_TO_BRIGHT.len() - 1) as f64).round() as usize;
            line.push(char::from(DARK_TO_BRIGHT[level.min(DARK_TO_BRIGHT.len() - 1)]));
        }
        lines.push(line.trim_end().to_owned());
    }
    lines.join("\n")
}

/// Luminance from 0 to 1, with the weights of Rec. 709.
fn brightness([r, g, b]: [u8; 3]) -> f64 {
    (0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)) / 255.0
}

/// A PNG in the kitty graphics protocol, in the required chunks of 4096 characters.
fn kitty(png: &[u8]) -> String {
    let data = BASE64.encode(png);
    let chunks: Vec<&str> =
        (0..data.len()).step_by(4096).map(|i| &data[i..data.len().min(i + 4096)]).collect();
    let mut text = String::new();
    for (i, chunk) in chunks.iter().enumerate() {
        let head = if i == 0 { "f=100,a=T,q=2," } else { "" };
        let more = u8::from(i + 1 < chunks.len());
        text.push_str(&format!("\x1b_G{head}m={more};{chunk}\x1b\\"));
    }
    text
}

#[cfg(test)]
mod tests {
    use superegg_scene::Picture;

    use super::*;

    #[test]
    fn a_picture_keeps_its_shape_and_fits() {
        for canvas in [Canvas::Blocks, Canvas::Plain, Canvas::Kitty, Canvas::Sixel] {
            for (size, columns, rows) in
                [((1280, 960), 80, 22), ((100, 1000), 80, 22), ((32_768, 1), 1, 1), ((1, 9), 300, 2)]
            {
                let (width, height) = canvas.size_px(size, columns, rows);
                assert!(width >= 1 && height >= 1 && width <= 8 * columns && height <= 16 * rows);
                let text =
                    canvas.draw(&Film::new(width, height), &Development::of(&Picture::default())).unwrap();
                assert!(canvas == Canvas::Plain || !text.ends_with('\n'));
            }
        }
        assert_eq!(Canvas::Blocks.size_px((1280, 960), 80, 22), (59, 44));
    }

    #[test]
    fn blocks_and_plain_have_a_line_for_two_rows() {
        let (film, bytes) = (Film::new(5, 3), [0; 3 * 5 * 3]);
        assert_eq!(blocks(&film, &bytes).lines().count(), 2);
        assert_eq!(blocks(&film, &bytes).matches('▀').count(), 10);
        assert_eq!(plain(&film, &bytes), "\n");
        assert!(
            blocks(&film, &bytes).contains("\x1b[49m"),
            "below the last row is the background of the terminal"
        );
    }

    #[test]
    fn kitty_chunks_mark_the_last() {
        let text = kitty(&[7; 10_000]);
        assert_eq!((text.matches("m=1;").count(), text.matches("m=0;").count()), (3, 1));
        assert!(text.starts_with("\x1b_Gf=100,a=T,q=2,m=1;") && text.ends_with("\x1b\\"));
    }
}
