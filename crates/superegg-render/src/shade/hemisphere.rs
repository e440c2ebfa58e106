//! Cosine-weighted directions from many points at once, in f32 lanes: those of [`cosine_direction`].
//!
//! [`cosine_direction`]: crate::camera::sobol::cosine_direction

use superegg_geom::glam::DVec3;
use superegg_simd::{Arch, Column, Lanes, Simd, WithSimd};

use crate::camera::sobol::SampleKey;
use crate::shade::light_kernel::{BLOCK, across_and_down, concentric_disc, square_of};

type Numbers = Column<f32, BLOCK>;

/// The directions of one call of the kernel: their blocks stay in the nearest cache.
pub(crate) const MOST_DIRECTIONS: usize = 16 * BLOCK;

/// Directions that are drawn together.
#[derive(Clone, Copy, Debug)]
struct DirectionBlock {
    /// The seeds and indices of the random points.
    seed: [u32; BLOCK],
    index: [u32; BLOCK],
    /// The unit normals.
    normal: [Numbers; 3],
    /// The result: unit directions.
    direction: [Numbers; 3],
}

/// Draws directions, at most [`MOST_DIRECTIONS`] at once.
pub(crate) struct Hemispheres {
    arch: Arch,
    blocks: Box<[DirectionBlock; MOST_DIRECTIONS / BLOCK]>,
    count: usize,
}

impl Hemispheres {
    pub(crate) fn new() -> Self {
        let up = [0.0, 0.0, 1.0].map(|coordinate| Column([coordinate; BLOCK]));
        let empty = DirectionBlock { seed: [0; BLOCK], index: [0; BLOCK], normal: up, direction: up };
        Self { arch: Arch::new(), blocks: Box::new([empty; MOST_DIRECTIONS / BLOCK]), count: 0 }
    }

    /// Adds the direction around a unit normal of random point `sample` of `count`.
    #[inline]
    pub(crate) fn push(&mut self, key: SampleKey, (sample, count): (u32, u32), normal: DVec3) {
        let (block, lane) = (&mut self.blocks[self.count / BLOCK], self.count % BLOCK);
        (block.index[lane], block.seed[lane]) = key.index_and_seed(sample, count);
        for (column, coordinate) in block.normal.iter_mut().zip(normal.to_array()) {
            column.0[lane] = coordinate as f32;
        }
        self.count += 1;
    }

    /// Draws the directions that were added, and removes them.
    pub(crate) fn draw(&mut self) -> impl Iterator<Item = DVec3> {
        let count = std::mem::take(&mut self.count);
        self.arch.dispatch(Draw(&mut self.blocks[..count.div_ceil(BLOCK)]));
        let blocks = &*self.blocks;
        (0..count).map(|i| {
            let direction = &blocks[i / BLOCK].direction;
            DVec3::from_array([0, 1, 2].map(|axis| f64::from(direction[axis].0[i % BLOCK])))
        })
    }
}

struct Draw<'a>(&'a mut [DirectionBlock]);

impl WithSimd for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for block in self.0 {
            let (x, y) = square_of(&block.index, &block.seed);
            for i in 0..BLOCK / S::F32_LANES {
                let disc = concentric_disc(simd, Lanes::load(simd, &x, i), Lanes::load(simd, &y, i));
                let normal = block.normal.each_ref().map(|column| -> Lanes<S> { column.load(simd, i) });
                let (across, down) = across_and_down(simd, normal);
                for axis in 0..3 {
                    let flat = disc.x.mul_add(across[axis], disc.y * down[axis]);
                    block.direction[axis].store(i, disc.height.mul_add(normal[axis], flat));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;

    use super::*;
    use crate::camera::sobol::cosine_direction;

    #[test]
    fn directions_are_those_of_f64() {
        let mut random = SplitMix::new(4);
        let mut hemispheres = Hemispheres::new();
        for case in 0..200u32 {
            let normals: Vec<DVec3> = (0..1 + 7 * case as usize % MOST_DIRECTIONS)
                .map(|_| DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0)).normalize())
                .chain(DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]))
                .take(MOST_DIRECTIONS)
                .collect();
            let key = SampleKey::new((case, 3 * case), case).branch(2);
            let count = normals.len() as u32;
            for (sample, normal) in (0..).zip(&normals) {
                hemispheres.push(key, (sample, count), *normal);
            }
            let directions: Vec<DVec3> = hemispheres.draw().collect();
            assert_eq!(directions.len(), normals.len());
            for (sample, (direction, normal)) in (0..).zip(directions.iter().zip(&normals)) {
                let expected = cosine_direction(key.point(sample, count), *normal);
                // At a right angle to the normal the height above the disc is the root of a small number.
                let error = (*direction - expected).length() * expected.dot(*normal).max(1e-3);
                assert!(error < 1e-6, "{case} {sample}: {direction} {expected}");
                assert!((direction.length() - 1.0).abs() < 1e-6);
            }
        }
    }
}
