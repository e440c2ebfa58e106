//! Lists of rays at nodes.

use superegg_geom::kernels::stream::ListedRay;

use crate::scene::node::WIDTH;

/// Rays at a node, with what is known about them at its boxes. All fields are positions in [`ListMemory`].
#[derive(Clone, Copy, Debug)]
pub(super) struct List {
    pub(super) first: u32,
    pub(super) count: u32,
    /// The first entry t.
    pub(super) first_near: u32,
    /// The first block of masks.
    pub(super) first_block: u32,
}

/// The number of rays in a block: a word has a bit for each.
pub(super) const BLOCK: u32 = u64::BITS;

impl List {
    pub(super) const EMPTY: Self = Self { first: 0, count: 0, first_near: 0, first_block: 0 };

    /// The empty list behind this one's rays, entries and blocks.
    #[inline(always)]
    pub(super) fn after(self) -> Self {
        let Self { first, count, first_near, first_block } = self;
        let first_block = first_block + count.div_ceil(BLOCK);
        Self { first: first + count, count: 0, first_near: first_near + count, first_block }
    }
}

/// The memory of lists, which lie one after the other as on a stack.
#[derive(Debug, Default)]
pub(super) struct ListMemory {
    pub(super) rays: Vec<ListedRay>,
    /// By ray the t where it enters each box of the node.
    pub(super) near: Vec<[f32; WIDTH]>,
    /// By block and box a bit for each ray that hits the box.
    blocks: Vec<[u64; WIDTH]>,
    /// By ray of the last list that was tested a bit for each box that it hits.
    pub(super) boxes_hit: Vec<u8>,
    /// The rays that enter a group, with their octants.
    pub(super) arrivals: Vec<(u8, ListedRay)>,
}

impl ListMemory {
    #[inline(always)]
    pub(super) fn reserve(&mut self, rays: usize, near: usize, blocks: usize) {
        if self.rays.len() < rays {
            self.rays.resize(2 * rays, ListedRay::default());
        }
        if self.near.len() < near {
            self.near.resize(2 * near, [0.0; WIDTH]);
        }
        if self.blocks.len() < blocks {
            self.blocks.resize(2 * blocks, [0; WIDTH]);
        }
    }

    /// Lists the arrivals behind `top`, one list for each octant. Returns the lists by octant.
    #[inline(always)]
    pub(super) fn list_arrivals(&mut self, top: List) -> [List; 8] {
        self.reserve(top.first as usize + self.arrivals.len(), 0, 0);
        let mut counts = [0; 8];
        for (octant, _) in &self.arrivals {
            counts[*octant as usize % 8] += 1;
        }
        let mut first = top.first;
        let lists = counts.map(|count| {
            let list = List { first, count, ..top };
            first += count;
            list
        });
        let mut ends = lists.map(|list| list.first);
        for (octant, listed) in &self.arrivals {
            let end = &mut ends[*octant as usize % 8];
            self.rays[*end as usize] = *listed;
            *end += 1;
        }
        self.arrivals.clear();
        lists
    }

    /// Lists the rays of a list that enter a box of the node before their ends.
    #[inline(always)]
    pub(super) fn list_child(&mut self, child: u8, list: List, ends: &[f32]) -> Option<List> {
        let (child, top) = (child as usize % WIDTH, list.after());
        let Self { rays, near, blocks, .. } = self;
        let (parents, free) = rays[list.first as usize..].split_at_mut(list.count as usize);
        let near = &near[list.first_near as usize..top.first_near as usize];
        if let ([ray], [near]) = (&*parents, near) {
            // The ray of a list of one hits each child that is visited, and stays where it is.
            let is_kept = near[child] <= ends[ray.end()];
            return is_kept.then_some(List { first: list.first, count: 1, ..top });
        }
        // Every ray that hits the box is written. One that has ended before is overwritten by the next.
        let mut kept = 0;
        for (block, hit) in blocks[list.first_block as usize..top.first_block as usize].iter().enumerate() {
            let mut hit = hit[child];
            while hit != 0 {
                let i = block * BLOCK as usize + hit.trailing_zeros() as usize;
                hit &= hit - 1;
                free[kept] = parents[i];
                kept += usize::from(near[i][child] <= ends[parents[i].end()]);
            }
        }
        (kept > 0).then_some(List { count: kept as u32, ..top })
    }

    /// Fills the blocks of a list from the masks of its rays.
    #[inline(always)]
    pub(super) fn fill_blocks(&mut self, list: List) {
        let whole_eights = (list.count as usize).next_multiple_of(WIDTH);
        let blocks = &mut self.blocks[list.first_block as usize..list.after().first_block as usize];
        for (block, hit) in blocks.iter_mut().zip(self.boxes_hit[..whole_eights].chunks(BLOCK as usize)) {
            *block = by_boxes(hit);
        }
    }
}

/// Masks of rays by box, from masks of boxes by ray. The rays are a multiple of eight, and at most [`BLOCK`].
#[inline(always)]
fn by_boxes(rays: &[u8]) -> [u64; WIDTH] {
    let mut boxes = [0; WIDTH];
    for (index, eight) in rays.as_chunks::<WIDTH>().0.iter().enumerate() {
        let transposed = transposed(u64::from_le_bytes(*eight)).to_le_bytes();
        for (to, bits) in boxes.iter_mut().zip(transposed) {
            *to |= u64::from(bits) << (8 * index);
        }
    }
    boxes
}

/// The transpose of an 8x8 bit matrix (Warren, Hacker's Delight, 7-3).
#[inline(always)]
fn transposed(mut bits: u64) -> u64 {
    for (shift, half) in
        [(7, 0x00aa_00aa_00aa_00aa), (14, 0x0000_cccc_0000_cccc), (28, 0x0000_0000_f0f0_f0f0)]
    {
        let exchanged = (bits ^ (bits >> shift)) & half;
        bits ^= exchanged ^ (exchanged << shift);
    }
    bits
}

/// The position of each box of a node along an octant's diagonal.
#[inline(always)]
pub(super) fn positions_along(bounds: &[[f32; WIDTH]; 6], octant: u8) -> [f32; WIDTH] {
    let mut along = [0.0; WIDTH];
    for axis in 0..3 {
        let turn = if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let both = bounds[axis].iter().zip(&bounds[axis + 3]);
        for (along, (least, largest)) in along.iter_mut().zip(both) {
            *along += turn * (least + largest);
        }
    }
    along
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_by_ray_are_the_same_by_box() {
        for count in [8usize, 24, 64] {
            let rays: Vec<u8> = (0..count).map(|ray| (ray * ray * 37 + ray) as u8).collect();
            let boxes = by_boxes(&rays);
            for (child, bits) in boxes.into_iter().enumerate() {
                let expected = (0..count).fold(0, |all, ray| all | u64::from(rays[ray] >> child & 1) << ray);
                assert_eq!(bits, expected);
            }
        }
    }
}
