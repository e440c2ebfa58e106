//! Rays of many packets that have one shape's box before them, lane beside lane: of the lanes that packets send there a fifth to a third
//! miss it, and N is what takes the time.

#![allow(
    clippy::needless_range_loop,
    reason = "only what is spelled out is inlined for the lanes of the machine"
)]

use pulp::Simd;

use super::beam::{MOST_PACKETS, PACKET};
use super::descent::Passage;
use super::kernel::Triple;
use super::vector::{Lanes, Mask};

/// A register's rays on their way through a shape's box.
#[derive(Clone, Copy)]
pub(super) struct Approach<S: Simd> {
    /// The t where each enters and leaves, in the shape's space.
    pub(super) near: Lanes<S>,
    pub(super) far: Lanes<S>,
    pub(super) direction: Triple<S>,
    pub(super) active: Mask<S>,
}

/// The rays, and what is found of them.
#[derive(Clone, Debug)]
pub struct Crowd {
    count: usize,
    /// Where each enters the box: the t, the way to where it leaves the box (-1 where there is no ray), and the direction, in the shape's space.
    near: CrowdOf,
    length: CrowdOf,
    direction: [CrowdOf; 3],
    /// What is found: two numbers each.
    found: [CrowdOf; 2],
    origins: Vec<Origin>,
}

/// A number for each ray of a beam, and for some that are none at the end.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct CrowdOf([f32; (MOST_PACKETS + 1) * PACKET]);

/// The register of a packet from which rays of a crowd came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub(super) packet: usize,
    pub(super) register: usize,
    /// Its lanes that came, a bit for each.
    pub(super) lanes: u32,
    /// Where they begin.
    first: usize,
}

impl Default for Crowd {
    fn default() -> Self {
        let zero = CrowdOf([0.0; (MOST_PACKETS + 1) * PACKET]);
        let (near, length, direction, found) = (zero, zero, [zero; 3], [zero; 2]);
        Self { count: 0, near, length, direction, found, origins: Vec::new() }
    }
}

impl Crowd {
    /// Forgets all rays.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.origins.clear();
    }

    /// Takes the rays of a register that come to the box.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, packet: usize, register: usize, approach: &Approach<S>) {
        let Approach { near, far, direction, active } = *approach;
        let first = self.count;
        near.pack(active, &mut self.near.0[first..]);
        active.select(far - near, near.all(-1.0)).pack(active, &mut self.length.0[first..]);
        let [x, y, z] = &mut self.direction;
        direction.x.pack(active, &mut x.0[first..]);
        direction.y.pack(active, &mut y.0[first..]);
        direction.z.pack(active, &mut z.0[first..]);
        self.origins.push(Origin { packet, register, lanes: active.bits(), first });
        self.count += active.packed();
    }

    /// Ends the taking of rays. Returns how many registers they fill.
    #[inline(always)]
    pub(super) fn close<S: Simd>(&mut self) -> usize {
        self.length.0[self.count..self.count + S::F32_LANES].fill(-1.0);
        self.count.div_ceil(S::F32_LANES)
    }

    /// The t where the rays of some registers enter the box, and their ways through it.
    #[inline(always)]
    pub(super) fn passage<S: Simd, const K: usize>(
        &self,
        origin: Triple<S>,
        register: usize,
    ) -> (Lanes<S, K>, Passage<S, K>) {
        let column = |column: &CrowdOf| {
            let column = S::as_simd_f32s(&column.0).0;
            let mut parts = [origin.x.with(column[register]); K];
            for k in 1..K {
                parts[k] = origin.x.with(column[register + k]);
            }
            Lanes::join(parts)
        };
        let (near, length) = (column(&self.near), column(&self.length));
        let [x, y, z] = &self.direction;
        let direction = Triple { x: column(x), y: column(y), z: column(z) };
        let start = Triple::join([origin; K]).along(near, direction);
        (near, Passage { start, direction, length, active: near.all(0.0).le(length) })
    }

    /// Takes what is found of the rays of some registers.
    #[inline(always)]
    pub(super) fn put<S: Simd, const K: usize>(&mut self, register: usize, found: [Lanes<S, K>; 2]) {
        let [first, second] = &mut self.found;
        for k in 0..K {
            S::as_mut_simd_f32s(&mut first.0).0[register + k] = found[0].part(k).register();
            S::as_mut_simd_f32s(&mut second.0).0[register + k] = found[1].part(k).register();
        }
    }

    /// The registers that the rays came from, by their place in the order in which they came.
    #[inline(always)]
    pub(super) fn origin(&self, place: usize) -> Option<Origin> {
        self.origins.get(place).copied()
    }

    /// What is found of the rays that came from a register, in the lanes from which they came; in others there is anything.
    #[inline(always)]
    pub(super) fn found<S: Simd>(&self, simd: S, origin: Origin) -> [Lanes<S>; 2] {
        let [first, second] = &self.found;
        [
            Lanes::unpack(simd, origin.lanes, &first.0[origin.first..]),
            Lanes::unpack(simd, origin.lanes, &second.0[origin.first..]),
        ]
    }
}
