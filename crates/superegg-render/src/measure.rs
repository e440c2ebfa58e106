//! The camera rays of a picture's tiles, for benchmarks.

use superegg_geom::glam::DVec2;
use superegg_trace::measure::CameraTile;
use superegg_trace::packet::PacketRays;

use crate::camera::view::View;
use crate::film::tile::{Tile, tiles};

/// The camera rays of a picture, one a pixel, by tiles as [`crate::render`] makes them, for a camera whose rays share an origin.
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
