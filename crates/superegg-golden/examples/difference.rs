//! How two pictures differ: `cargo run --release -p superegg-golden --example difference A.png B.png [SIDE_BY_SIDE.png]`.
//!
//! The third picture shows the first, the second, and eight times the difference of each channel.
#![allow(clippy::print_stdout, reason = "a tool")]

use image::RgbImage;

/// By how much differences are made brighter to be seen.
const BRIGHTER: u8 = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let (a, b, side_by_side) = match &paths[..] {
        [a, b] => (a, b, None),
        [a, b, out] => (a, b, Some(out)),
        _ => return Err("two pictures are needed, and a third to write".into()),
    };
    let (a, b) = (image::open(a)?.to_rgb8(), image::open(b)?.to_rgb8());
    if a.dimensions() != b.dimensions() {
        return Err("the pictures have different sizes".into());
    }
    let off: Vec<u8> = a
        .pixels()
        .zip(b.pixels())
        .map(|(a, b)| a.0.iter().zip(b.0).map(|(&a, b)| a.abs_diff(b)).max().unwrap_or(0))
        .collect();
    let mean = off.iter().map(|&off| f64::from(off)).sum::<f64>() / off.len() as f64;
    let share = |limit: u8| 100.0 * off.iter().filter(|&&off| off > limit).count() as f64 / off.len() as f64;
    println!(
        "mean difference {mean:.3} of 255; more than 2: {:.3} %, more than 12: {:.3} %",
        share(2),
        share(12)
    );
    if let Some(out) = side_by_side {
        beside(&a, &b).save(out)?;
    }
    Ok(())
}

fn beside(a: &RgbImage, b: &RgbImage) -> RgbImage {
    let width = a.width();
    RgbImage::from_fn(3 * width, a.height(), |x, y| {
        let (first, second) = (a.get_pixel(x % width, y), b.get_pixel(x % width, y));
        match x / width {
            0 => *first,
            1 => *second,
            _ => image::Rgb([0, 1, 2].map(|i| first[i].abs_diff(second[i]).saturating_mul(BRIGHTER))),
        }
    })
}
