//! The division of a picture into tiles.

use std::ops::Range;

/// The size of a tile in pixels: one sample of each pixel fills the packets of one query.
const TILE_PX: (u32, u32) = (32, 16);
/// The edge of a block of pixels whose rays form a packet.
const BLOCK_PX: usize = 4;

/// A rectangle of pixels that one thread renders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// The columns of pixels, from the left of the picture.
    pub x: Range<u32>,
    /// The rows of pixels, from the top of the picture.
    pub y: Range<u32>,
}

impl Tile {
    /// The pixels row by row from the top left, in the order of [`crate::Film::pixels`] of
    /// [`crate::Film::tile`].
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let x = self.x.clone();
        self.y.clone().flat_map(move |y| x.clone().map(move |x| (x, y)))
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.x.len() as u32, self.y.len() as u32)
    }

    /// The number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.x.len() * self.y.len()
    }

    /// The pixels ordered by blocks of neighbours, whose camera rays form packets.
    pub(crate) fn pixels_by_block(&self) -> Vec<(u32, u32)> {
        let blocks = |range: &Range<u32>| {
            let end = range.end;
            range.clone().step_by(BLOCK_PX).map(move |first| first..end.min(first + BLOCK_PX as u32))
        };
        let rows = blocks(&self.y).flat_map(|y| blocks(&self.x).map(move |x| (x, y.clone())));
        rows.flat_map(|(x, y)| y.flat_map(move |y| x.clone().map(move |x| (x, y)))).collect()
    }
}

/// The tiles of a picture of `width` by `height` pixels, row by row from the top left. The index of
/// a tile is its index in this list. Tiles at the right and at the bottom may be smaller.
pub fn tiles(width: u32, height: u32) -> Vec<Tile> {
    let ranges = |length: u32, edge: u32| {
        (0..length.div_ceil(edge)).map(move |i| i * edge..length.min((i + 1) * edge))
    };
    let (across, down) = TILE_PX;
    ranges(height, down).flat_map(|y| ranges(width, across).map(move |x| Tile { x, y: y.clone() })).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn tiles_cover_each_pixel_once() {
        for (width, height) in [(1, 1), (16, 16), (17, 15), (100, 33)] {
            let tiles = tiles(width, height);
            let by_row: Vec<(u32, u32)> = tiles.iter().flat_map(Tile::pixels).collect();
            let by_block: HashSet<(u32, u32)> = tiles.iter().flat_map(Tile::pixels_by_block).collect();
            assert_eq!(by_row.len() as u64, u64::from(width) * u64::from(height));
            assert_eq!(by_row.len(), tiles.iter().map(Tile::pixel_count).sum::<usize>());
            assert_eq!(by_block, by_row.into_iter().collect());
        }
        assert_eq!(tiles(33, 5)[1], Tile { x: 32..33, y: 0..5 });
    }
}
