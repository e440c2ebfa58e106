//! The rays of a list against the eight boxes of a node.

use superegg_simd::{Lanes, Simd};

/// Reciprocals of directions are clamped to this size.
const MAX_INVERSE: f32 = 1e30;

/// A ray in the form that boxes are tested with: half a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub struct BoxRay {
    /// The origin, shifted by half of the pad along each axis in the direction of the ray, then the pad: boxes are enlarged by
    /// it in all, for rounding. Entry faces are tested with this origin, exit faces after the pad is subtracted.
    entry_origin_and_pad: [f32; 4],
    /// The reciprocals of the direction's coordinates, all finite.
    inverse: [f32; 4],
}

impl BoxRay {
    /// A ray from its origin and direction, in a space where boxes have coordinates of the order of 1. `size` is the largest
    /// |coordinate| of the origin.
    ///
    /// The fourth coordinates do not count: with them the compiler fills a register.
    #[inline(always)]
    pub fn new(origin: [f64; 4], direction: [f64; 4], size: f64) -> Self {
        let half_pad = 6e-7 * (size + 2.0);
        let (mut entry_origin_and_pad, mut inverse) = ([0.0; 4], [0.0; 4]);
        for axis in 0..4 {
            inverse[axis] = (1.0 / direction[axis] as f32).clamp(-MAX_INVERSE, MAX_INVERSE);
            entry_origin_and_pad[axis] = (origin[axis] + half_pad.copysign(direction[axis])) as f32;
        }
        entry_origin_and_pad[3] = (2.0 * half_pad) as f32;
        Self { entry_origin_and_pad, inverse }
    }
}

/// A ray of a list: its index among the rays, and that of its end among the ends.
#[derive(Clone, Copy, Debug, Default)]
pub struct ListedRay {
    ray: u32,
    end: u32,
}

impl ListedRay {
    /// From both indices.
    #[inline(always)]
    pub fn new(ray: u32, end: u32) -> Self {
        Self { ray, end }
    }

    /// The index among the rays.
    #[inline(always)]
    pub fn ray(self) -> usize {
        self.ray as usize
    }

    /// The index among the ends.
    #[inline(always)]
    pub fn end(self) -> usize {
        self.end as usize
    }
}

/// Where the answers of [`intersect_boxes`] are written.
#[derive(Debug)]
pub struct NodeEntries<'a> {
    /// For each ray the t where it enters each box; infinite where it does not hit the box before its end.
    pub near: &'a mut [[f32; 8]],
    /// For each ray the boxes that it hits, one bit each.
    pub hit: &'a mut [u8],
}

/// Tests the rays of a list, all of one octant, against eight boxes (the least x, y and z of each, then the largest).
/// Returns the boxes that any ray hits, one bit each.
#[inline(always)]
pub fn intersect_boxes<S: Simd>(
    simd: S,
    bounds: &[[f32; 8]; 6],
    octant: u8,
    rays: &[BoxRay],
    list: &[ListedRay],
    ends: &[f32],
    entries: NodeEntries<'_>,
) -> u8 {
    #[cfg(target_arch = "x86_64")]
    if let Some(half) = superegg_simd::half_width(simd) {
        // Eight boxes fill half of a register.
        return intersect_boxes_by(half, bounds, octant, rays, list, ends, entries);
    }
    intersect_boxes_by(simd, bounds, octant, rays, list, ends, entries)
}

#[inline(always)]
fn intersect_boxes_by<S: Simd>(
    simd: S,
    bounds: &[[f32; 8]; 6],
    octant: u8,
    rays: &[BoxRay],
    list: &[ListedRay],
    ends: &[f32],
    entries: NodeEntries<'_>,
) -> u8 {
    let NodeEntries { near, hit } = entries;
    let mut hit_by_any = 0;
    for i in 0..8 / S::F32_LANES {
        let face = |row: usize| Lanes::<S>::load(simd, &bounds[row], i);
        let is_back = [octant & 1, octant >> 1 & 1, octant >> 2 & 1];
        let mut entry = [face(0); 3];
        let mut exit = [face(0); 3];
        let mut sign = [face(0); 3];
        for axis in 0..3 {
            entry[axis] = face(axis + 3 * usize::from(is_back[axis]));
            exit[axis] = face(axis + 3 * usize::from(1 - is_back[axis]));
            sign[axis] = Lanes::splat(simd, if is_back[axis] == 1 { -1.0 } else { 1.0 });
        }
        let miss = Lanes::<S>::splat(simd, f32::INFINITY);
        for ((listed, near), hit) in list.iter().zip(near.iter_mut()).zip(hit.iter_mut()) {
            let ray = &rays[listed.ray()];
            let mut t_enter = Lanes::<S>::splat(simd, 0.0);
            let mut t_exit = Lanes::<S>::splat(simd, ends[listed.end()]);
            let [x, y, z, pad] = ray.entry_origin_and_pad;
            let (entry_origin, pad) = ([x, y, z], Lanes::splat(simd, pad));
            for axis in 0..3 {
                let inverse = Lanes::splat(simd, ray.inverse[axis]);
                let origin = Lanes::splat(simd, entry_origin[axis]);
                t_enter = t_enter.max((entry[axis] - origin) * inverse);
                t_exit = t_exit.min(sign[axis].mul_add(pad, exit[axis] - origin) * inverse);
            }
            let hits = t_enter.le(t_exit);
            hits.select(t_enter, miss).store(near, i);
            let bits = (hits.bits() << (i * S::F32_LANES)) as u8;
            *hit = if i == 0 { bits } else { *hit | bits };
            hit_by_any |= bits;
        }
    }
    hit_by_any
}
