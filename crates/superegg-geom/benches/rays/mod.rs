//! The rays that benchmarks use, and the numbers they are made of.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;

/// Numbers that look random, the same in every run (SplitMix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn within(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * (2.0 * size) - size
    }
}

/// Rays of a camera that has the shape in view, turned so that no axis is special.
pub(crate) fn camera_rays(count: usize) -> Vec<Ray> {
    let side = (count as f64).sqrt() as usize;
    let eye = DVec3::new(2.3, -3.1, 1.7);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let place = |i: usize| 0.9 * ((i as f64 + 0.5) / side as f64 - 0.5);
    (0..side * side)
        .map(|i| Ray::new(eye, (forward + right * place(i % side) - up * place(i / side)).normalize()))
        .collect()
}

/// Rays from about the shape, towards its neighbourhood.
pub(crate) fn random_rays(count: usize) -> Vec<Ray> {
    let mut random = Random(1);
    (0..count)
        .map(|_| {
            let origin = random.within(4.0);
            Ray::new(origin, (random.within(1.2) - origin).normalize())
        })
        .collect()
}
