//! Pictures in the sixel protocol of terminals: a palette of 256 colours, error diffusion, bands of six rows.

use std::fmt::Write;

type Rgb = [u8; 3];

/// The most colours of a palette that every sixel terminal takes.
const MOST_COLORS: usize = 256;

/// The text that draws a picture of this width, from its rows of red, green and blue.
pub(super) fn sixel(rgb: &[u8], width: usize) -> String {
    let pixels = rgb.as_chunks().0;
    let palette = palette(pixels);
    let indices = diffuse(pixels, width, &palette);
    encode(&indices, width, &palette)
}

/// A colour and how many pixels have it.
type Counted = (Rgb, u32);

/// A part of the colours of a picture.
struct Cell<'a> {
    colors: &'a mut [Counted],
    /// The channel in which the colours differ most.
    widest: usize,
    /// How much is gained by a cut: the number of pixels, times the square of the colours' width. 0 for a single colour.
    gain: u64,
}

impl<'a> Cell<'a> {
    fn new(colors: &'a mut [Counted]) -> Self {
        let width = |channel: usize| {
            let values = colors.iter().map(|(color, _)| color[channel]);
            values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
        };
        let widest = (0..3).max_by_key(|&channel| width(channel)).unwrap_or(0);
        let pixels: u64 = colors.iter().map(|&(_, count)| u64::from(count)).sum();
        let gain = pixels * u64::from(width(widest)).pow(2);
        Self { colors, widest, gain }
    }

    /// Two cells of about as many pixels each, cut across the widest channel. The cell has two colours or more.
    fn cut(self) -> (Self, Self) {
        let channel = self.widest;
        self.colors.sort_unstable_by_key(|(color, _)| color[channel]);
        let pixels: u64 = self.colors.iter().map(|&(_, count)| u64::from(count)).sum();
        let mut below = 0;
        let half = self.colors.iter().position(|&(_, count)| {
            below += u64::from(count);
            2 * below >= pixels
        });
        let at = (half.unwrap_or(0) + 1).min(self.colors.len() - 1);
        let (low, high) = self.colors.split_at_mut(at);
        (Self::new(low), Self::new(high))
    }

    /// The mean colour of the pixels, as near as sixel says it.
    fn mean(&self) -> Rgb {
        let mut sums = [0; 3];
        let mut pixels = 0;
        for &(color, count) in self.colors.iter() {
            pixels += u64::from(count);
            for (sum, value) in sums.iter_mut().zip(color) {
                *sum += u64::from(value) * u64::from(count);
            }
        }
        sums.map(|sum| from_percent(percent((sum as f64 / pixels.max(1) as f64).round() as u8)))
    }
}

/// Sixel says colours in whole per cents.
fn percent(value: u8) -> u8 {
    ((u32::from(value) * 100 + 127) / 255) as u8
}

fn from_percent(percent: u8) -> u8 {
    ((u32::from(percent) * 255 + 50) / 100) as u8
}

/// At most 256 colours that stand for all: those of a picture that has no more, otherwise by median cut (Heckbert 1982).
fn palette(pixels: &[Rgb]) -> Vec<Rgb> {
    let mut sorted = pixels.to_vec();
    sorted.sort_unstable();
    let mut colors: Vec<Counted> =
        sorted.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as u32)).collect();
    let mut cells = vec![Cell::new(&mut colors)];
    while cells.len() < MOST_COLORS {
        let Some(best) = (0..cells.len()).max_by_key(|&i| cells[i].gain).filter(|&i| cells[i].gain > 0)
        else {
            break;
        };
        let (low, high) = cells.swap_remove(best).cut();
        cells.extend([low, high]);
    }
    let mut palette: Vec<Rgb> = cells.iter().map(Cell::mean).collect();
    palette.sort_unstable();
    palette.dedup();
    palette
}

/// The palette's index of each pixel. The error of a pixel's colour goes to its neighbours (Floyd and Steinberg 1976).
fn diffuse(pixels: &[Rgb], width: usize, palette: &[Rgb]) -> Vec<u8> {
    // Errors of this row and the next, with a column to each side.
    let mut errors = [vec![[0f32; 3]; width + 2], vec![[0f32; 3]; width + 2]];
    let mut indices = Vec::with_capacity(pixels.len());
    for row in pixels.chunks(width.max(1)) {
        for (x, &pixel) in row.iter().enumerate() {
            let wanted: [f32; 3] =
                std::array::from_fn(|i| (f32::from(pixel[i]) + errors[0][x + 1][i]).clamp(0.0, 255.0));
            let index = nearest(palette, wanted);
            for i in 0..3 {
                let error = wanted[i] - f32::from(palette[index][i]);
                errors[0][x + 2][i] += error * 7.0 / 16.0;
                errors[1][x][i] += error * 3.0 / 16.0;
                errors[1][x + 1][i] += error * 5.0 / 16.0;
                errors[1][x + 2][i] += error / 16.0;
            }
            indices.push(index as u8);
        }
        errors.swap(0, 1);
        errors[1].fill([0.0; 3]);
    }
    indices
}

fn nearest(palette: &[Rgb], wanted: [f32; 3]) -> usize {
    let distance = |color: &Rgb| -> f32 { (0..3).map(|i| (f32::from(color[i]) - wanted[i]).powi(2)).sum() };
    let mut best = (0, f32::INFINITY);
    for (index, color) in palette.iter().enumerate() {
        let distance = distance(color);
        if distance < best.1 {
            best = (index, distance);
        }
    }
    best.0
}

/// The text: raster attributes, the palette, and for each band of six rows the pixels of one colour after the other.
fn encode(indices: &[u8], width: usize, palette: &[Rgb]) -> String {
    let width = width.max(1);
    // Writing to a string cannot fail.
    let mut text = format!("\x1bP0;1q\"1;1;{width};{}", indices.len() / width);
    for (index, color) in palette.iter().enumerate() {
        let [r, g, b] = color.map(percent);
        let _ = write!(text, "#{index};2;{r};{g};{b}");
    }
    for band in indices.chunks(6 * width) {
        let mut sixels = vec![Vec::new(); palette.len()];
        for (at, &index) in band.iter().enumerate() {
            let sixels: &mut Vec<u8> = &mut sixels[usize::from(index)];
            sixels.resize(width, 0);
            sixels[at % width] |= 1 << (at / width);
        }
        let present = sixels.iter().enumerate().filter(|(_, sixels)| !sixels.is_empty());
        for (nth, (index, sixels)) in present.enumerate() {
            // Back to the left edge.
            let _ = write!(text, "{}#{index}", if nth > 0 { "$" } else { "" });
            for same in sixels.chunk_by(|a, b| a == b) {
                let sixel = char::from(b'?' + same[0]);
                match same.len() {
                    1..=3 => text.extend(std::iter::repeat_n(sixel, same.len())),
                    length => {
                        let _ = write!(text, "!{length}{sixel}");
                    }
                }
            }
        }
        text.push('-');
    }
    text.push_str("\x1b\\");
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The terminal's reading of the text: width, and the colour of each pixel that is set.
    fn decoded(text: &str) -> (usize, Vec<Option<Rgb>>) {
        let body = text.strip_prefix("\x1bP0;1q\"1;1;").unwrap().strip_suffix("\x1b\\").unwrap();
        let digits = |from: &str| from.chars().take_while(char::is_ascii_digit).collect::<String>();
        let width = digits(body);
        let height = digits(&body[width.len() + 1..]);
        let mut rest = &body[width.len() + 1 + height.len()..];
        let (width, height): (usize, usize) = (width.parse().unwrap(), height.parse().unwrap());
        let mut pixels = vec![None; width * height];
        let mut palette = vec![[0; 3]; MOST_COLORS];
        let (mut x, mut y, mut color, mut repeat) = (0, 0, 0, 1);
        while let Some(first) = rest.chars().next() {
            rest = &rest[1..];
            let number = digits(rest);
            match first {
                '#' => {
                    color = number.parse().unwrap();
                    rest = &rest[number.len()..];
                    if let Some(values) = rest.strip_prefix(";2;") {
                        for (channel, value) in values.splitn(3, ';').enumerate() {
                            let value = digits(value);
                            palette[color][channel] = from_percent(value.parse().unwrap());
                        }
                        let end = rest.find(['#', '-', '$']).unwrap_or(rest.len());
                        rest = &rest[end..];
                    }
                }
                '!' => {
                    repeat = number.parse().unwrap();
                    rest = &rest[number.len()..];
                }
                '$' => x = 0,
                '-' => (x, y) = (0, y + 6),
                sixel => {
                    let bits = sixel as u8 - b'?';
                    for x in x..x + repeat {
                        for row in (0..6).filter(|row| bits >> row & 1 == 1) {
                            let pixel = &mut pixels[(y + row) * width + x];
                            assert_eq!(*pixel, None, "each pixel has one colour");
                            *pixel = Some(palette[color]);
                        }
                    }
                    (x, repeat) = (x + repeat, 1);
                }
            }
        }
        (width, pixels)
    }

    fn shown(pixels: &[Rgb], width: usize) -> Vec<Rgb> {
        let (shown_width, shown) = decoded(&sixel(pixels.as_flattened(), width));
        assert_eq!(shown_width, width);
        shown.into_iter().map(|pixel| pixel.expect("every pixel is set")).collect()
    }

    #[test]
    fn few_colors_are_shown_as_they_are() {
        // Per cents of 255, which sixel says exactly; seven rows, so a band is not full.
        let colors = [[0, 0, 0], [255, 255, 255], [51, 102, 204], [255, 0, 51]];
        for width in [1, 4, 13] {
            let pixels: Vec<Rgb> = (0..7 * width).map(|i| colors[(i * i / 3) % 4]).collect();
            assert_eq!(shown(&pixels, width), pixels);
        }
    }

    #[test]
    fn a_gradient_keeps_its_colors_over_a_few_pixels() {
        let (width, height) = (96, 96);
        let pixels: Vec<Rgb> =
            (0..width * height).map(|i| [(i % width * 2) as u8, (i / width * 2) as u8, 90]).collect();
        let shown = shown(&pixels, width);
        let mean = |pixels: &[Rgb], left: usize, top: usize, channel: usize| {
            let at = |i: usize| pixels[(top + i / 8) * width + left + i % 8][channel];
            (0..64).map(|i| f64::from(at(i))).sum::<f64>() / 64.0
        };
        for (left, top) in (0..width / 8).flat_map(|x| (0..height / 8).map(move |y| (8 * x, 8 * y))) {
            for channel in 0..3 {
                let off = mean(&shown, left, top, channel) - mean(&pixels, left, top, channel);
                assert!(off.abs() < 3.0, "{left} {top}, channel {channel}: {off}");
            }
        }
    }
}
