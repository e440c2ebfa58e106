//! Level of detail: an instance is drawn with its own patches, or with as few as its size on the
//! screen can show.

use superegg_scene::Patches;

use crate::preview::drawn_patches;

/// The level of detail of one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LevelOfDetail {
    /// Factor on the size limits of the levels, at least 1. It keeps the picture within the budget.
    stretch: f64,
    is_wireframe: bool,
    /// Instances that are coarser than without a budget.
    pub(super) coarser: usize,
}

/// Levels below the own patches: largest radius in pixels, and patches. A sphere of at most this
/// radius is correct to a quarter of a pixel.
const LEVELS: [(f64, Patches); 3] =
    [(9.0, Patches { u: 16, v: 8 }), (3.5, Patches { u: 8, v: 4 }), (0.9, Patches { u: 4, v: 2 })];
/// Beyond this factor nothing gets cheaper.
const MOST_STRETCH: f64 = 1e4;

impl LevelOfDetail {
    /// The finest level of detail within a budget of triangles, for instances with these patches
    /// and radii in pixels.
    pub(super) fn within(
        budget: usize,
        is_wireframe: bool,
        instances: impl Iterator<Item = (Patches, f64)> + Clone,
    ) -> Self {
        let mut detail = Self { stretch: 1.0, is_wireframe, coarser: 0 };
        let finest = detail;
        loop {
            let cost: u64 = instances
                .clone()
                .map(|(own, size_px)| triangle_count(patches_at(own, detail.level(own, size_px))))
                .sum();
            if cost <= budget as u64 || detail.stretch >= MOST_STRETCH {
                break;
            }
            detail.stretch *= 2.0;
        }
        if detail.stretch > 1.0 {
            detail.coarser = instances
                .filter(|(own, size)| detail.level(*own, *size) != finest.level(*own, *size))
                .count();
        }
        detail
    }

    /// The level of an instance: 0 for its own patches, else 1 + its index in `LEVELS`.
    pub(super) fn level(&self, own: Patches, size_px: f64) -> u8 {
        let own_cost = triangle_count(own);
        let serves = |(limit, patches): &(f64, Patches)| {
            // In wireframe the patches themselves are visible.
            let limit = if self.is_wireframe { limit.min(2.0) } else { *limit };
            size_px <= limit * self.stretch && triangle_count(*patches) < own_cost
        };
        LEVELS.iter().rposition(serves).map_or(0, |index| index as u8 + 1)
    }
}

/// The patches of a level.
pub(super) fn patches_at(own: Patches, level: u8) -> Patches {
    if level == 0 { drawn_patches(own) } else { LEVELS[usize::from(level) - 1].1 }
}

fn triangle_count(patches: Patches) -> u64 {
    2 * u64::from(patches.u) * u64::from(patches.v.max(1) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: Patches = Patches { u: 15, v: 15 };

    #[test]
    fn a_large_instance_has_its_own_patches_and_a_small_one_fewer() {
        let detail = LevelOfDetail::within(usize::MAX, false, [(OWN, 100.0)].into_iter());
        let levels: Vec<u8> = [100.0, 8.0, 3.0, 0.5].map(|size| detail.level(OWN, size)).into();
        assert_eq!(levels, [0, 1, 2, 3]);
        assert_eq!(detail.level(Patches { u: 3, v: 2 }, 0.1), 0);
    }

    #[test]
    fn the_budget_is_kept_where_possible_and_reported() {
        let instances = || std::iter::repeat_n((OWN, 100.0), 1000);
        let detail = LevelOfDetail::within(20_000, false, instances());
        assert_eq!(detail.coarser, 1000);
        assert!(triangle_count(patches_at(OWN, detail.level(OWN, 100.0))) <= 20);
        assert_eq!(LevelOfDetail::within(1_000_000, false, instances()).coarser, 0);
        assert_eq!(LevelOfDetail::within(0, true, instances()).coarser, 1000);
    }
}
