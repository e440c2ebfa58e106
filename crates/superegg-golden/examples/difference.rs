//! How two pictures differ: `cargo run --release -p superegg-golden --example difference A.png B.png`.
#![allow(clippy::print_stdout, reason = "a tool")]

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [a, b] = &paths[..] else { return Err("two pictures are needed".into()) };
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
    Ok(())
}
