//! Masks of lanes as integers, one bit for each lane.

use pulp::Simd;

/// The positions of the bits that are set, from the lowest.
#[inline(always)]
pub fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let bit = mask.trailing_zeros();
            mask &= mask - 1;
            bit as usize
        })
    })
}

/// The bits of a mask that belong to the lanes of register `i`, shifted to bit 0.
#[inline(always)]
pub fn register_bits<S: Simd>(mask: u32, i: usize) -> u32 {
    let shifted = mask >> (i * S::F32_LANES);
    if S::F32_LANES < 32 { shifted & ((1 << S::F32_LANES) - 1) } else { shifted }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_come_from_the_lowest() {
        assert_eq!(bits(0).count(), 0);
        assert_eq!(bits(0x8000_0011).collect::<Vec<_>>(), [0, 4, 31]);
        assert_eq!(bits(u32::MAX).count(), 32);
    }
}
