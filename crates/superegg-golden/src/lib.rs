//! Test support: a picture against its reference.
//!
//! A picture differs where a whole block of 3 x 3 pixels differs, so that an edge that moved by a rounding error does not count and a lost shape
//! does. A failed comparison writes `NAME.actual.png`, `NAME.reference.png` and `NAME.diff.png` to `target/golden`. With
//! `SUPEREGG_BLESS=1` in the environment an actual picture that differs becomes the reference.

use std::path::{Path, PathBuf};

use image::RgbaImage;

/// A channel, opacity among them, may be off by so much, of 255.
const TOLERANCE: u8 = 12;

/// Compares a PNG file with the reference of this name in `folder`.
///
/// # Errors
/// The difference, and the folder of the pictures to look at.
pub fn check(folder: &Path, name: &str, actual: &Path) -> Result<(), String> {
    let reference = folder.join(format!("{name}.png"));
    let compared = compare(name, actual, &reference);
    if compared.is_err() && std::env::var_os("SUPEREGG_BLESS").is_some() {
        return std::fs::copy(actual, &reference).map(|_| ()).map_err(|error| error.to_string());
    }
    compared
}

fn compare(name: &str, actual: &Path, reference: &Path) -> Result<(), String> {
    let read = |path: &Path| {
        image::open(path)
            .map(|picture| picture.to_rgba8())
            .map_err(|error| format!("{}: {error}", path.display()))
    };
    let (actual, reference) = (read(actual)?, read(reference)?);
    if actual.dimensions() != reference.dimensions() {
        return Err(format!(
            "{name}: {:?} is not the size {:?}",
            actual.dimensions(),
            reference.dimensions()
        ));
    }
    let different = different_blocks(&actual, &reference);
    if different == 0 {
        return Ok(());
    }
    let out = write_all(name, &actual, &reference).map_err(|error| error.to_string())?;
    Err(format!("{name}: {different} blocks of 3 x 3 pixels differ; look at {}", out.display()))
}

fn differs(a: &RgbaImage, b: &RgbaImage, x: u32, y: u32) -> bool {
    a.get_pixel(x, y).0.iter().zip(b.get_pixel(x, y).0).any(|(&a, b)| a.abs_diff(b) > TOLERANCE)
}

/// How many blocks of 3 x 3 pixels differ in all their pixels.
fn different_blocks(a: &RgbaImage, b: &RgbaImage) -> usize {
    let (width, height) = a.dimensions();
    let all_differ = |x: u32, y: u32| (0..3).all(|dy| (0..3).all(|dx| differs(a, b, x + dx, y + dy)));
    let corners =
        (0..height.saturating_sub(2)).flat_map(|y| (0..width.saturating_sub(2)).map(move |x| (x, y)));
    corners.filter(|&(x, y)| all_differ(x, y)).count()
}

fn write_all(name: &str, actual: &RgbaImage, reference: &RgbaImage) -> image::ImageResult<PathBuf> {
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/golden");
    std::fs::create_dir_all(&out)?;
    let diff = RgbaImage::from_fn(actual.width(), actual.height(), |x, y| {
        image::Rgba(if differs(actual, reference, x, y) { [255, 0, 0, 255] } else { [0, 0, 0, 255] })
    });
    for (kind, picture) in [("actual", actual), ("reference", reference), ("diff", &diff)] {
        picture.save(out.join(format!("{name}.{kind}.png")))?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_square(side: u32) -> RgbaImage {
        RgbaImage::from_fn(16, 16, |x, y| image::Rgba([if x < side && y < side { 255 } else { 0 }; 4]))
    }

    #[test]
    fn a_lost_shape_counts_and_a_moved_edge_does_not() {
        assert_eq!(different_blocks(&with_square(0), &with_square(3)), 1);
        assert_eq!(different_blocks(&with_square(8), &with_square(9)), 0);
    }
}
