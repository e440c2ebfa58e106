//! Mattes: how much of each pixel is covered by every instance and every object, as Cryptomatte stores it.
//!
//! Cryptomatte (Friedman and Jones 2015; specification 1.2.0) names things by a hash of their names.

use std::collections::BTreeMap;

/// A thing in a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// The id of its name: [`matte_id`].
    pub id: u32,
    /// The part of the pixel that it covers, in (0, 1].
    pub share: f32,
}

/// The things that the ids of a matte stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatteLevel {
    /// Instances of primitives.
    Instance,
    /// The children of the root, or below objects of a single child, of the first object that has several.
    Object,
}

impl MatteLevel {
    /// Both levels.
    pub const ALL: [Self; 2] = [Self::Instance, Self::Object];

    /// The name of the level in files.
    pub fn type_name(self) -> &'static str {
        match self {
            Self::Instance => "CryptoInstance",
            Self::Object => "CryptoObject",
        }
    }
}

/// The most things that a pixel keeps for each level: those that cover most.
pub const MATTE_RANKS: usize = 6;
/// Longer names are not kept, in bytes; their ids are.
pub(crate) const LONGEST_NAME: usize = 1024;
/// A film keeps at most so many names: those of the smallest ids, in whatever order its tiles are finished.
const MOST_NAMES: usize = 1 << 16;

/// The mattes of a film.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mattes {
    pixels: Vec<Entries>,
    /// The entries of all pixels. Those of a pixel lie side by side: its instances, then its objects.
    entries: Vec<Coverage>,
    names: BTreeMap<u32, String>,
}

/// Where the entries of a pixel begin, and how many each level has.
#[derive(Clone, Copy, Debug, Default)]
struct Entries {
    start: u32,
    counts: [u8; 2],
}

impl Mattes {
    /// The mattes of pixels that nothing covers.
    pub(crate) fn new(pixels: usize) -> Self {
        Self { pixels: vec![Entries::default(); pixels], ..Self::default() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// The things that cover a pixel, the largest share first; empty without mattes.
    pub(crate) fn get(&self, pixel: usize, level: MatteLevel) -> &[Coverage] {
        let Entries { start, counts: [instances, objects] } =
            self.pixels.get(pixel).copied().unwrap_or_default();
        let (start, middle) = (start as usize, start as usize + usize::from(instances));
        match level {
            MatteLevel::Instance => &self.entries[start..middle],
            MatteLevel::Object => &self.entries[middle..middle + usize::from(objects)],
        }
    }

    /// Replaces what covers a pixel. More than [`MATTE_RANKS`] things of a level are left out from the end.
    pub(crate) fn set(&mut self, pixel: usize, [instances, objects]: [&[Coverage]; 2]) {
        let cut = |things: &[Coverage]| things.len().min(MATTE_RANKS);
        let counts = [cut(instances), cut(objects)];
        let Some(to) = self.pixels.get_mut(pixel) else { return };
        *to = Entries { start: self.entries.len() as u32, counts: counts.map(|count| count as u8) };
        self.entries.extend_from_slice(&instances[..counts[0]]);
        self.entries.extend_from_slice(&objects[..counts[1]]);
    }

    /// Copies a pixel of other mattes.
    pub(crate) fn copy(&mut self, to: usize, other: &Self, from: usize) {
        self.set(to, MatteLevel::ALL.map(|level| other.get(from, level)));
    }

    /// The names of ids, as far as they are known.
    pub(crate) fn names(&self) -> &BTreeMap<u32, String> {
        &self.names
    }

    /// Adds names of ids.
    pub(crate) fn add_names<'n>(&mut self, names: impl IntoIterator<Item = (u32, &'n str)>) {
        for (id, name) in names.into_iter().filter(|(_, name)| name.len() <= LONGEST_NAME) {
            // Names of one id are as good as one another, but the order of tiles must not matter.
            if self.names.get(&id).is_none_or(|known| name < known.as_str()) {
                self.names.insert(id, name.to_owned());
            }
            if self.names.len() > MOST_NAMES {
                self.names.pop_last();
            }
        }
    }
}

/// Equal if all pixels have the same things; names do not matter.
impl PartialEq for Mattes {
    fn eq(&self, other: &Self) -> bool {
        let pixels = 0..self.pixels.len();
        self.pixels.len() == other.pixels.len()
            && MatteLevel::ALL
                .into_iter()
                .all(|level| pixels.clone().all(|pixel| self.get(pixel, level) == other.get(pixel, level)))
    }
}

/// The Cryptomatte id of a name: MurmurHash3 (x86, 32 bits, seed 0) of its UTF-8 bytes. A bit is toggled where as the bits
/// of a 32-bit float it would be subnormal, infinite or no number. Files have it as that float.
pub fn matte_id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    if matches!(hash >> 23 & 0xff, 0 | 0xff) { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3_x86_32 of Appleby (2011) with seed 0.
fn murmur3(bytes: &[u8]) -> u32 {
    let mixed = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = 0u32;
    for word in words {
        hash = (hash ^ mixed(u32::from_le_bytes(*word))).rotate_left(13);
        hash = hash.wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    hash ^= mixed(rest.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte)));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_those_of_the_specification() {
        // The examples of the specification 1.2.0.
        assert_eq!(
            (murmur3("torus".as_bytes()), murmur3("равнина".as_bytes())),
            (4_053_562_365, 2_518_896_926)
        );
        assert_eq!((matte_id("bunny"), matte_id("default")), (0x1385_1a76, 0x42c9_679f));
        assert_eq!(matte_id("bunny_porcelain_mat"), 0xb24b_26d4);
        for i in 0..100_000 {
            let id = f32::from_bits(matte_id(&format!("name{i}")));
            assert!(id.is_normal(), "{id}");
        }
    }

    #[test]
    fn pixels_keep_what_covers_most_of_them() {
        let thing = |id| Coverage { id, share: 1.0 / (1 + id) as f32 };
        let many: Vec<Coverage> = (1..20).map(thing).collect();
        let mut mattes = Mattes::new(3);
        mattes.set(1, [&many, &many[..2]]);
        mattes.set(0, [&many[..1], &[]]);
        assert_eq!(mattes.get(1, MatteLevel::Instance), &many[..MATTE_RANKS]);
        assert_eq!(mattes.get(1, MatteLevel::Object), &many[..2]);
        assert_eq!(
            (mattes.get(0, MatteLevel::Instance), mattes.get(0, MatteLevel::Object)),
            (&many[..1], &[][..])
        );
        assert!(
            mattes.get(2, MatteLevel::Instance).is_empty() && mattes.get(9, MatteLevel::Object).is_empty()
        );
        let mut other = Mattes::new(3);
        other.copy(0, &mattes, 0);
        assert_ne!(other, mattes);
        other.copy(1, &mattes, 1);
        assert_eq!(other, mattes);
        other.add_names([(7, "seven"), (8, &*"n".repeat(LONGEST_NAME + 1))]);
        assert_eq!(other.names().get(&7).map(String::as_str), Some("seven"));
        other.add_names([(7, "six"), (7, "two")]);
        assert_eq!(
            other.names().iter().map(|(id, name)| (*id, name.as_str())).collect::<Vec<_>>(),
            [(7, "seven")]
        );
        other.add_names((0..=MOST_NAMES as u32).rev().map(|id| (id, "a")));
        assert!(other.names().keys().copied().eq(0..MOST_NAMES as u32));
    }
}
