//! The pixels of a texture, and its smaller copies.

use std::io::Cursor;

use image::{DynamicImage, ImageError, ImageReader, Limits};
use superegg_geom::glam::{DVec2, DVec3, Vec3};
use thiserror::Error;
use twox_hash::XxHash3_128;

/// Why a file is no texture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TextureError {
    /// The file is of another kind, or damaged.
    #[error("it cannot be read as a picture (PNG, JPEG or Radiance): {0}")]
    Unreadable(String),
    /// The picture has no pixels, or too many.
    #[error("it has {width} x {height} pixels; expected 1 to 67108864, and sides of 1 to 32768")]
    Size {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
    },
}

/// The pixels of a texture: linear values, with copies of half the size down to one pixel (Williams 1983).
pub struct TexturePixels {
    /// From the picture itself on.
    levels: Vec<Level>,
    fingerprint: u128,
}

struct Level {
    width: usize,
    height: usize,
    values: Vec<Vec3>,
}

impl std::fmt::Debug for TexturePixels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Level { width, height, .. } = &self.levels[0];
        write!(f, "TexturePixels({width} x {height}, {:032x})", self.fingerprint)
    }
}

impl PartialEq for TexturePixels {
    fn eq(&self, other: &Self) -> bool {
        self.fingerprint == other.fingerprint
    }
}

/// The most pixels of a texture.
const MOST_PIXELS: u64 = 1 << 26;
/// The longest side.
const LONGEST_SIDE: u32 = 1 << 15;
/// The most memory that a reader may take, in bytes.
const MOST_BYTES: u64 = 16 * MOST_PIXELS;

impl TexturePixels {
    /// Reads a picture, recognized by its first bytes: PNG, JPEG or Radiance. With `is_color` the values of 8 and 16 bits are
    /// colours in sRGB and become linear, else they are taken as they are, from 0 to 1. Transparency is left out.
    ///
    /// # Errors
    /// The file is of another kind, damaged, or too large.
    pub fn of_file(bytes: &[u8], is_color: bool) -> Result<Self, TextureError> {
        let unreadable = |error: ImageError| TextureError::Unreadable(error.to_string());
        let reader = || {
            let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
            reader.map_err(|error| TextureError::Unreadable(error.to_string()))
        };
        let (width, height) = reader()?.into_dimensions().map_err(unreadable)?;
        let is_side = |side| (1..=LONGEST_SIDE).contains(&side);
        if !is_side(width) || !is_side(height) || u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(TextureError::Size { width, height });
        }
        let mut reader = reader()?;
        let mut limits = Limits::default();
        limits.max_alloc = Some(MOST_BYTES);
        reader.limits(limits);
        let picture = reader.decode().map_err(unreadable)?;
        let is_linear = matches!(picture, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
        let picture = picture.into_rgb32f();
        let size = (picture.width() as usize, picture.height() as usize);
        let linear = |value: f32| match value {
            value if !value.is_finite() || value < 0.0 => 0.0,
            value if is_color && !is_linear => linear_of_srgb(value),
            value => value,
        };
        let values = picture.pixels().map(|pixel| Vec3::from_array(pixel.0.map(linear))).collect();
        Ok(Self::new(size, values))
    }

    /// The pixels of a picture row by row from the top. There are as many as the size has, at least one.
    pub(crate) fn new((width, height): (usize, usize), values: Vec<Vec3>) -> Self {
        debug_assert!(values.len() == width * height && !values.is_empty());
        let mut hasher = XxHash3_128::new();
        hasher.write(&(width as u64).to_le_bytes());
        for value in values.iter().flat_map(Vec3::to_array) {
            hasher.write(&value.to_le_bytes());
        }
        let mut levels = vec![Level { width, height, values }];
        while let Some(half) = levels.last().and_then(Level::half) {
            levels.push(half);
        }
        Self { levels, fingerprint: hasher.finish_128() }
    }

    /// A hash of the pixels.
    pub(crate) fn fingerprint(&self) -> u128 {
        self.fingerprint
    }

    /// The width divided by the height.
    pub(crate) fn aspect(&self) -> f64 {
        self.levels[0].width as f64 / self.levels[0].height as f64
    }

    /// The height in pixels.
    pub(crate) fn height(&self) -> f64 {
        self.levels[0].height as f64
    }

    /// The mean around a point over a footprint, both in pictures: (0, 0) is the lower left corner, and the picture repeats
    /// within `rows`.
    pub(crate) fn mean(&self, at: DVec2, footprint: DVec2, rows: Rows) -> DVec3 {
        let Level { width, height, .. } = &self.levels[0];
        // A long footprint is the mean of several short ones along its longer side.
        let in_pixels = footprint.abs() * DVec2::new(*width as f64, *height as f64);
        let (long, short) = (in_pixels.max_element(), in_pixels.min_element());
        if !long.is_finite() {
            return self.level(self.levels.len() - 1, at, rows);
        }
        let probes = (long / short.max(1.0)).ceil().clamp(1.0, MOST_PROBES);
        let along = if in_pixels.x >= in_pixels.y { DVec2::X } else { DVec2::Y };
        let width = (long / probes).max(short);
        let step = along * footprint.abs().dot(along) / probes;
        let first = at - 0.5 * (probes - 1.0) * step;
        let sum: DVec3 =
            (0..probes as u32).map(|i| self.blurred(first + f64::from(i) * step, width, rows)).sum();
        sum / probes
    }

    /// The slope of the red channel in both directions at a point, per picture: the mean over a footprint of at least one
    /// pixel, so that it has no jumps. 0 where the footprint is as wide as the picture.
    pub(crate) fn slope(&self, at: DVec2, footprint: DVec2, rows: Rows) -> DVec2 {
        let Level { width, height, .. } = &self.levels[0];
        let wide = footprint.abs().max(DVec2::new(*width as f64, *height as f64).recip());
        let along = |axis: DVec2| {
            let width = wide.dot(axis);
            // Also with one pixel, and where the width is no number.
            let is_narrow = width < 1.0;
            if !is_narrow {
                return 0.0;
            }
            let [below, above] =
                [-0.5, 0.5].map(|side| self.mean(at + side * width * axis, footprint, rows).x);
            let rise = above - below;
            // Equal values are interpolated with a rounding error.
            if rise.abs() <= 8.0 * f64::EPSILON * above.abs().max(below.abs()) { 0.0 } else { rise / width }
        };
        DVec2::new(along(DVec2::X), along(DVec2::Y))
    }

    /// Whether the red channel has one value everywhere.
    pub(crate) fn is_flat(&self) -> bool {
        let values = &self.levels[0].values;
        values.iter().all(|value| value.x == values[0].x)
    }

    /// The value at a point, blurred over a width in pixels.
    fn blurred(&self, at: DVec2, width_px: f64, rows: Rows) -> DVec3 {
        let level = width_px.max(1.0).log2().min((self.levels.len() - 1) as f64);
        let (lower, part) = (level.floor() as usize, level.fract());
        let value = self.level(lower, at, rows);
        if part == 0.0 { value } else { value.lerp(self.level(lower + 1, at, rows), part) }
    }

    /// The value of a level at a point, linear between the centres of pixels.
    fn level(&self, level: usize, at: DVec2, rows: Rows) -> DVec3 {
        let Level { width, height, values } = &self.levels[level];
        let at = match rows {
            Rows::Repeat => at,
            Rows::UpTo(end) => {
                // From the centre of the first row to that of the last.
                let half = (0.5 / *height as f64).min(0.5 * end);
                DVec2::new(at.x, at.y.max(half).min(end - half))
            }
        };
        let inside = at - at.floor();
        if !inside.is_finite() {
            return DVec3::ZERO;
        }
        let x = inside.x * *width as f64 - 0.5;
        // Rows go from the top.
        let y = (1.0 - inside.y) * *height as f64 - 0.5;
        let index = |position: f64, count: usize| (position as i64).rem_euclid(count as i64) as usize;
        let (left, right) = (index(x.floor(), *width), index(x.floor() + 1.0, *width));
        let (above, below) = (index(y.floor(), *height), index(y.floor() + 1.0, *height));
        let value = |x: usize, y: usize| values[y * width + x].as_dvec3();
        let (part, down) = (x - x.floor(), y - y.floor());
        let upper = value(left, above).lerp(value(right, above), part);
        upper.lerp(value(left, below).lerp(value(right, below), part), down)
    }
}

/// How far a picture repeats from row to row.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rows {
    /// Without an end.
    Repeat,
    /// From 0 up to this number of pictures. The rows at the ends continue beyond them.
    UpTo(f64),
}

/// The most probes of a long footprint. A longer one is blurred across, too.
const MOST_PROBES: f64 = 8.0;

impl Level {
    /// The level of half the size, each pixel of which is a mean; `None` for one pixel.
    fn half(&self) -> Option<Self> {
        let Self { width, height, values } = self;
        if (*width, *height) == (1, 1) {
            return None;
        }
        let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
        // An odd row or column belongs to the last pixel.
        let range = |index: usize, half: usize, whole: usize| {
            let end = if index + 1 == half { whole } else { 2 * (index + 1) };
            2 * index..end
        };
        let mean = |x: usize, y: usize| {
            let (columns, rows) = (range(x, half_width, *width), range(y, half_height, *height));
            let count = (columns.len() * rows.len()) as f32;
            let sum: Vec3 = rows.map(|y| values[y * width..][columns.clone()].iter().sum::<Vec3>()).sum();
            sum / count
        };
        let means =
            (0..half_height).flat_map(|y| (0..half_width).map(move |x| (x, y))).map(|(x, y)| mean(x, y));
        Some(Self { width: half_width, height: half_height, values: means.collect() })
    }
}

/// A linear value from one of sRGB, both from 0 to 1.
fn linear_of_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(width: usize, height: usize) -> TexturePixels {
        let value = |i: usize| Vec3::splat(((i % width + i / width) % 2) as f32);
        TexturePixels::new((width, height), (0..width * height).map(value).collect())
    }

    #[test]
    fn centres_of_pixels_have_their_values_and_the_picture_repeats() {
        let values = (0..6).map(|i| Vec3::new(i as f32, 0.0, 1.0)).collect();
        let pixels = TexturePixels::new((3, 2), values);
        for turn in [-2.0, 0.0, 5.0] {
            for (i, y) in [(0, 0.75), (3, 0.25)] {
                for x in 0..3 {
                    let at = DVec2::new((f64::from(x) + 0.5) / 3.0 + turn, y - turn);
                    let value = pixels.mean(at, DVec2::ZERO, Rows::Repeat);
                    assert!((value - DVec3::new(f64::from(i + x), 0.0, 1.0)).length() < 1e-6, "{at} {value}");
                }
            }
        }
        // Across the seam.
        assert!((pixels.mean(DVec2::new(0.0, 0.75), DVec2::ZERO, Rows::Repeat).x - 1.0).abs() < 1e-9);
        for bad in [f64::NAN, f64::INFINITY, 1e300, f64::MAX] {
            assert!(pixels.mean(DVec2::splat(bad), DVec2::ONE, Rows::Repeat).is_finite());
            assert!(pixels.mean(DVec2::ONE, DVec2::splat(bad), Rows::Repeat).is_finite());
        }
    }

    #[test]
    fn wide_footprints_see_the_mean() {
        for (width, height) in [(64, 64), (61, 7), (1, 9), (128, 2)] {
            let pixels = checker(width, height);
            let (sum, count) = (0..width * height).fold((0.0, 0.0), |(sum, count), i| {
                (sum + ((i % width + i / width) % 2) as f64, count + 1.0)
            });
            let wide = pixels.mean(DVec2::new(0.3, 0.8), DVec2::splat(4.0), Rows::Repeat).x;
            assert!((wide - sum / count).abs() < 0.08, "{width} x {height}: {wide}");
        }
        // A long footprint blurs along itself alone: columns of stripes stay.
        let value = |i: usize| Vec3::splat((i % 32 / 16) as f32);
        let stripes = TexturePixels::new((32, 32), (0..1024).map(value).collect());
        let (dark, bright) = (DVec2::new(0.25, 0.5), DVec2::new(0.75, 0.5));
        let tall = DVec2::new(0.0, 0.5);
        assert!(
            stripes.mean(dark, tall, Rows::Repeat).x < 0.05
                && stripes.mean(bright, tall, Rows::Repeat).x > 0.95
        );
        assert!((stripes.mean(dark, DVec2::new(1.0, 0.0), Rows::Repeat).x - 0.5).abs() < 0.1);
    }

    #[test]
    fn files_are_read_and_bad_ones_are_errors() {
        let picture = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([255 * x as u8, 188, 0]));
        let mut png = Vec::new();
        picture.write_to(&mut Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
        let right = |is_color| {
            TexturePixels::of_file(&png, is_color).unwrap().mean(
                DVec2::new(0.75, 0.5),
                DVec2::ZERO,
                Rows::Repeat,
            )
        };
        assert!((right(true) - DVec3::new(1.0, 0.502_886, 0.0)).length() < 1e-5, "{}", right(true));
        assert!((right(false) - DVec3::new(1.0, 188.0 / 255.0, 0.0)).length() < 1e-6);
        for length in 0..png.len() {
            // Some readers forgive a missing end.
            let _ = TexturePixels::of_file(&png[..length], true);
        }
        for bad in [&b""[..], b"prm ball", &png[..20], b"\xff\xd8\xff\xe0\0\x10JFIF"] {
            assert!(TexturePixels::of_file(bad, true).is_err());
        }
        // A header that claims 65536 x 65536 pixels.
        let mut large = png.clone();
        large[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
        assert!(TexturePixels::of_file(&large, true).is_err());
    }
}
