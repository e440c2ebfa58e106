//! Signatures of content, and materials without duplicates.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Transform};
use superegg_scene::{Material, Pattern};

/// Materials without duplicates.
#[derive(Default)]
pub(super) struct Materials {
    pub(super) all: Vec<Material>,
    index_of: HashMap<[u64; 25], u32, RandomState>,
    /// Some materials that were found before, by a hash of their colours.
    recent: [Option<([u64; 25], u32)>; RECENT],
}

/// A power of two.
const RECENT: usize = 32;

impl Materials {
    /// The index of a material, which is added if it is new.
    pub(super) fn index_of(&mut self, material: &Material) -> u32 {
        let bits = material_bits(material);
        let color = bits[0] ^ bits[1].rotate_left(21) ^ bits[2].rotate_left(42);
        let recent = &mut self.recent[(color.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 59) as usize % RECENT];
        if let Some((held, index)) = recent
            && *held == bits
        {
            return *index;
        }
        let index = *self.index_of.entry(bits).or_insert_with(|| {
            self.all.push(*material);
            self.all.len() as u32 - 1
        });
        *recent = Some((bits, index));
        index
    }
}

/// The bits of a material, which are equal for equal materials only.
fn material_bits(material: &Material) -> [u64; 25] {
    let Material {
        color,
        ambient,
        reflected,
        refracted,
        gloss,
        diffuse,
        specular,
        index,
        shininess,
        fresnel,
        absorb,
        emission,
        roughness,
        metallic,
        pattern,
    } = material;
    // The numbers are not negative, so -1 can mark an unset one.
    let optional = |number: &Option<f64>| number.unwrap_or(-1.0);
    let (kind, second, detail) = match *pattern {
        Pattern::None => (0.0, DVec3::ZERO, DVec3::ZERO),
        Pattern::Checker { color, size } => (1.0, color, DVec3::splat(size)),
        Pattern::Gradient { color, direction } => (2.0, color, direction),
        Pattern::Noise { color, size } => (3.0, color, DVec3::splat(size)),
        Pattern::Marble { color, size } => (4.0, color, DVec3::splat(size)),
        Pattern::Wood { color, size } => (5.0, color, DVec3::splat(size)),
    };
    let numbers = [
        color.x,
        color.y,
        color.z,
        *ambient,
        optional(reflected),
        optional(refracted),
        *gloss,
        *diffuse,
        *specular,
        *index,
        optional(shininess),
        f64::from(u8::from(*fresnel)),
        absorb.x,
        absorb.y,
        absorb.z,
        kind,
        second.x,
        second.y,
        second.z,
        detail.x,
        detail.y,
        detail.z,
        *emission,
        optional(roughness),
        *metallic,
    ];
    let mut bits = [0; 25];
    bits.iter_mut().zip(numbers).for_each(|(bits, number)| *bits = number.to_bits());
    bits
}

/// A hash of words by folded multiplication.
pub(super) struct Mixer(u64);

impl Mixer {
    pub(super) fn new(first: u64) -> Self {
        let mut mixer = Self(0x9e37_79b9_7f4a_7c15);
        mixer.words([first]);
        mixer
    }

    #[inline]
    pub(super) fn words<const N: usize>(&mut self, words: [u64; N]) {
        // Each product waits for the one before, so it takes two words.
        for pair in words.chunks(2) {
            let (first, second) = (pair[0], pair.get(1).map_or(0, |word| word.rotate_left(32)));
            let product = u128::from(self.0 ^ first ^ 0xa076_1d64_78bd_642f)
                * u128::from(second ^ 0xe703_7ed1_a0b4_28db);
            let folded = product as u64 ^ (product >> 64) as u64;
            self.0 = folded.wrapping_add(self.0.rotate_left(23)).wrapping_add(first);
        }
    }

    /// The hash.
    pub(super) fn finish(&self) -> u64 {
        self.0
    }

    pub(super) fn shape(&mut self, radii: DVec3, exponents: Exponents) {
        self.words([radii.x, radii.y, radii.z, exponents.e(), exponents.n()].map(f64::to_bits));
    }

    pub(super) fn text(&mut self, text: &str) {
        self.words([text.len() as u64]);
        for chunk in text.as_bytes().chunks(16) {
            let mut words = [0; 16];
            words[..chunk.len()].copy_from_slice(chunk);
            let [first, second] = [0, 8].map(|at| u64::from_le_bytes(std::array::from_fn(|i| words[at + i])));
            self.words([first, second]);
        }
    }
}

/// The bits of a transform, which are equal for equal transforms only.
pub(super) fn bits_of(transform: &Transform) -> [u64; 12] {
    transform.forward().to_cols_array().map(f64::to_bits)
}
