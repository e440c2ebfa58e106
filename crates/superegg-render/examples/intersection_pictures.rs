//! The pictures of docs/intersection.md: evaluations a pixel of the textbook method and of ours,
//! and where the textbook method is wrong.
//!
//! `cargo run --release -p superegg-render --example intersection_pictures -- docs/pictures/steps.png`

use image::{Rgb, RgbImage};
use superegg_geom::glam::DVec2;
use superegg_geom::{Exponents, Ray, RayStart, Superquadric, textbook};
use superegg_render::View;
use superegg_scene::Camera;

/// A panel's edge in pixels.
const SIDE: u32 = 240;
const ROWS: [(f64, f64); 5] = [(1.0, 1.0), (0.1, 0.1), (0.01, 0.01), (0.0001, 0.0001), (2.5, 2.5)];

fn main() -> image::ImageResult<()> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "steps.png".to_owned());
    let camera = Camera {
        position: [3.1, -4.2, 2.4].into(),
        up: [0.0, 0.0, 1.0].into(),
        fov_deg: 34.0,
        ..Camera::default()
    };
    let view = View::new(&camera, SIDE, SIDE);
    let mut picture = RgbImage::new(3 * SIDE, ROWS.len() as u32 * SIDE);
    for (row, (e, n)) in (0..).zip(ROWS) {
        let shape = Superquadric::unit(Exponents::new(e, n).expect("good exponents"));
        let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
        for (x, y) in pixels {
            let ray = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            let [steps, ours, verdict] = panels(&shape, &ray);
            for (column, color) in (0..).zip([steps, ours, verdict]) {
                picture.put_pixel(column * SIDE + x, row * SIDE + y, color);
            }
        }
    }
    picture.save(path)
}

/// One pixel of the three panels.
fn panels(shape: &Superquadric, ray: &Ray) -> [Rgb<u8>; 3] {
    let textbook = textbook::intersect(ray, shape.exponents());
    let truth = shape.intersect(ray, RayStart::Free);
    let verdict = match (textbook.t, truth) {
        (None, Some(_)) => Rgb([220, 50, 40]),
        (Some(_), None) => Rgb([60, 90, 240]),
        (Some(a), Some(b)) if (a - b.t).abs() > 1e-6 => Rgb([240, 200, 40]),
        (Some(_), Some(hit)) => Rgb([(120.0 + 100.0 * shape.normal(hit.point).z) as u8; 3]),
        (None, None) => Rgb([20; 3]),
    };
    let ours = shape.newton_steps(ray, RayStart::Free).map_or(Rgb([20; 3]), heat);
    [heat(textbook.steps), ours, verdict]
}

/// Black for none, over violet, red and yellow to white for 64 and more: a step of colour for each
/// doubling.
fn heat(steps: u32) -> Rgb<u8> {
    const STOPS: [[f64; 3]; 5] =
        [[10.0, 10.0, 20.0], [80.0, 20.0, 120.0], [210.0, 50.0, 60.0], [250.0, 180.0, 40.0], [255.0; 3]];
    let place = (f64::from(1 + steps).log2() / 6.0).min(1.0) * 4.0;
    let stop = (place as usize).min(3);
    let share = place - stop as f64;
    Rgb([0, 1, 2].map(|c| ((1.0 - share) * STOPS[stop][c] + share * STOPS[stop + 1][c]) as u8))
}
