//! How a picture is cut into tiles.

use std::ops::Range;

/// The size of a tile in pixels: one sample of each pixel fills the packets of one query.
const TILE_PX: (u32, u32) = (32, 16);
/// The edge of a block of pixels whose rays form a packet.
const BLOCK_PX: usize = 4;

/// A part of the picture that is made as a whole, by one thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Its columns of pixels, from the left of the picture.
    pub x: Range<u32>,
    /// Its rows, from the top.
    pub y: Range<u32>,
}

impl Tile {
    /// Its pixels row by row, from the top left: the order in which [`crate::Film::pixels`] has those of [`crate::Film::tile`].
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let x = self.x.clone();
        self.y.clone().flat_map(move |y| x.clone().map(move |x| (x, y)))
    }

    /// How many pixels it has across and down.
    pub fn size(&self) -> (u32, u32) {
        (self.x.len() as u32, self.y.len() as u32)
    }

    /// How many pixels it has.
    pub fn pixel_count(&self) -> usize {
        self.x.len() * self.y.len()
    }

    /// Its pixels, by blocks of neighbours that go through the scene together.
    pub(crate) fn pixels_by_block(&self) -> Vec<(u32, u32)> {
        let blocks = |range: &Range<u32>| {
            let end = range.end;
            range.clone().step_by(BLOCK_PX).map(move |first| first..end.min(first + BLOCK_PX as u32))
        };
        let rows = blocks(&self.y).flat_map(|y| blocks(&self.x).map(move |x| (x, y.clone())));
        rows.flat_map(|(x, y)| y.flat_map(move |y| x.clone().map(move |x| (x, y)))).collect()
    }
}

/// The tiles of a picture of so many pixels, row by row from the top left. The place in this list is a tile's index. It depends on nothing but
/// the size of the picture; tiles at the right and at the bottom may be smaller.
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
