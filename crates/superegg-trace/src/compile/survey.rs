//! The survey of a group's content before it is assembled.

use std::hash::BuildHasher;

use rayon::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, BOUND_SHAPES};
use superegg_scene::InstanceTable;

use super::described::Described;
use super::parts::{LARGE, LeafImage, Parts, unit_from_group};
use super::patch::Patchable;
use super::signature::{Mixer, bits_of};
use crate::scene::group::Names;

/// Facts about the content of a group before it is assembled.
pub(super) struct Survey {
    /// A hash of everything that the content comes from. Different content has the same signature with a probability of
    /// 2^-64.
    pub(super) signature: u64,
    /// The box around all plain leaves.
    pub(super) leaf_box: Aabb,
    /// Nearly the smallest box of each plain leaf, empty for one without a map; `None` if they are not computed yet.
    pub(super) boxes: Option<Vec<Aabb>>,
    /// Child and primitive of the leaves that differ from those before.
    pub(super) changed: Vec<(u32, u32)>,
}

impl Survey {
    pub(super) const NOTHING: Self =
        Self { signature: 0, leaf_box: Aabb::EMPTY, boxes: None, changed: Vec::new() };
}

/// The results of a survey besides signature and box.
#[derive(Clone, Copy)]
pub(super) struct SurveyWork<'a> {
    /// Whether the boxes of leaves are computed: a group without one before needs them.
    pub(super) keeps_boxes: bool,
    /// The group to find changed leaves in.
    pub(super) before: Option<&'a Patchable<'a>>,
}

/// The part of a survey that is joined from those of leaves.
struct Joined {
    signature: u64,
    leaf_box: Aabb,
    changed: Vec<(u32, u32)>,
}

impl Joined {
    const NOTHING: Self = Self { signature: 0, leaf_box: Aabb::EMPTY, changed: Vec::new() };

    fn join(mut self, other: Self) -> Self {
        self.signature = self.signature.wrapping_add(other.signature);
        self.leaf_box = self.leaf_box.union(&other.leaf_box);
        self.changed.extend(other.changed);
        self
    }
}

/// Computes the signature and the box of an object's content, and which leaves differ from those before. No child is folded
/// yet.
pub(super) fn survey_object(
    parts: &Parts<'_>,
    names: &Names,
    described: &Described,
    work: SurveyWork<'_>,
) -> Survey {
    // Each leaf is transformed once for all that is found about it.
    let add = |all: &mut Joined, &(child, primitive): &(u32, u32)| {
        let (radii, exponents) = described.shape(primitive);
        let map = parts.transform(child);
        let mut hash = Mixer::new(u64::from(child) << 32 | u64::from(primitive));
        hash.shape(radii, exponents);
        if let Some(map) = &map {
            hash.words(bits_of(map));
        }
        all.signature = all.signature.wrapping_add(hash.finish());
        if let Some(before) = work.before {
            let unit_from_group = map.as_ref().map(|map| unit_from_group(map, radii));
            if before.has_changed((child, primitive), unit_from_group, exponents) {
                all.changed.push((child, primitive));
            }
        }
        let image = LeafImage::new(&map?, (radii, exponents));
        all.leaf_box = all.leaf_box.union(&image.loose_box());
        Some(image)
    };
    // The boxes of several leaves are computed side by side.
    let add_some = |mut all: Joined, (leaves, boxes): (&[(u32, u32)], &mut [Aabb])| {
        let mut images = [const { None }; BOUND_SHAPES];
        for (image, leaf) in images.iter_mut().zip(leaves) {
            *image = add(&mut all, leaf);
        }
        for (held, tight) in boxes.iter_mut().zip(LeafImage::tight_boxes(&images)) {
            *held = tight.unwrap_or(Aabb::EMPTY);
        }
        all
    };
    let mut boxes = work.keeps_boxes.then(|| vec![Aabb::EMPTY; parts.leaves.len()]);
    let joined = match &mut boxes {
        Some(boxes) => parts
            .leaves
            .par_chunks(BOUND_SHAPES)
            .zip(boxes.par_chunks_mut(BOUND_SHAPES))
            .with_min_len(LARGE / BOUND_SHAPES)
            .fold(|| Joined::NOTHING, add_some)
            .reduce(|| Joined::NOTHING, Joined::join),
        None => {
            let add_one = |mut all: Joined, leaf: &(u32, u32)| {
                add(&mut all, leaf);
                all
            };
            let leaves = parts.leaves.par_iter().with_min_len(LARGE);
            leaves.fold(|| Joined::NOTHING, add_one).reduce(|| Joined::NOTHING, Joined::join)
        }
    };
    let mut hash = Mixer::new(joined.signature);
    for item in &parts.groups {
        hash.words([item.name.as_child().map_or(u64::MAX, u64::from), item.group.signature]);
        hash.words(bits_of(&item.parent_from_child));
    }
    if let Names::Listed { text, .. } = names {
        hash.text(text);
    }
    hash.words([parts.primitive_count]);
    Survey { signature: hash.finish(), leaf_box: joined.leaf_box, boxes, changed: joined.changed }
}

/// The signature of a table, from its columns as they are, and a box around it.
pub(super) fn survey_table(parts: &Parts<'_>, table: &InstanceTable) -> Survey {
    let mut hasher = foldhash::fast::FixedState::default().build_hasher();
    table.hash_columns(&mut hasher);
    let first = parts.leaves.first().map_or(0, |(_, primitive)| *primitive);
    let mut hash = Mixer::new(std::hash::Hasher::finish(&hasher));
    hash.words([u64::from(first), parts.primitive_count]);
    let row_box =
        |row: usize| Aabb::around(table.position(row), DVec3::splat(table.shape(row).radii.length()));
    let leaf_box = (0..table.len())
        .into_par_iter()
        .with_min_len(LARGE)
        .map(row_box)
        .reduce(|| Aabb::EMPTY, |a, b| a.union(&b));
    Survey { signature: hash.finish(), leaf_box, boxes: None, changed: Vec::new() }
}
