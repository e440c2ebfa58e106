//! The camera rays of tiles, for benchmarks.

use superegg_geom::glam::DVec2;
use superegg_trace::measure::CameraTile;
use superegg_trace::packet::PacketRays;

use crate::camera::view::View;
use crate::film::tile::{Tile, tiles};

/// The camera rays of a picture, one per pixel, in the tiles and the order of [`crate::render()`].
/// The camera must be a pinhole camera.
pub fn camera_tiles(view: &View, width: u32, height: u32) -> Vec<CameraTile> {
    let rays = |tile: &Tile| {
        let mut rays = PacketRays::default();
        rays.start(view.position());
        for (x, y) in tile.pixels_by_block() {
            rays.push(view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).direction);
        }
        CameraTile::new(rays)
    };
    tiles(width, height).iter().map(rays).collect()
}
