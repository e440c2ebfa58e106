//! Level of detail: an instance is drawn within a part of a pixel of its silhouette. In wireframe,
//! and as in the course program, it is drawn with its own patches, or with as few as its size on the
//! screen can show.

use std::cell::RefCell;
use std::collections::HashMap;

use superegg_geom::Exponents;
use superegg_scene::Patches;

use crate::preview::{PreviewShape, drawn_patches, quarter_segments};

/// The mesh of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum MeshDetail {
    /// This many patches.
    Patches { u: u32, v: u32 },
    /// Within 2^-level of the unit shape.
    Within { level: u8 },
}

/// The rule for meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DetailRule {
    /// Silhouettes are right to a part of a pixel.
    Silhouette,
    /// The patches of the primitives.
    Patches,
    /// The patches of the primitives, which are visible.
    Wireframe,
}

/// Triangle counts by exponent and level.
#[derive(Debug, Default)]
pub(super) struct SegmentCounts {
    counts: RefCell<HashMap<(u64, u8), u32>>,
}

impl SegmentCounts {
    fn quarter(&self, exponent: f64, level: u8) -> u32 {
        let count = || quarter_segments(exponent, tolerance(level));
        *self.counts.borrow_mut().entry((exponent.to_bits(), level)).or_insert_with(count)
    }
}

/// The level of detail of one picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct LevelOfDetail<'a> {
    segments: &'a SegmentCounts,
    rule: DetailRule,
    /// Factor on the size limits of the levels, at least 1. It keeps the picture within the budget.
    stretch: f64,
    /// Instances that are coarser than without a budget.
    pub(super) coarser: usize,
}

/// Levels below the own patches: largest radius in pixels, and patches. A sphere of at most this
/// radius is correct to a quarter of a pixel.
const LEVELS: [(f64, Patches); 3] =
    [(9.0, Patches { u: 16, v: 8 }), (3.5, Patches { u: 8, v: 4 }), (0.9, Patches { u: 4, v: 2 })];
/// Beyond this factor nothing gets cheaper.
const MOST_STRETCH: f64 = 1e4;
/// The tolerance of a curve around a shape and of one from pole to pole, in pixels. The radius on
/// the screen is that of a sphere around the box of the shape, so that both add to less than half a
/// pixel.
const TOLERANCE_PX: f64 = 0.4;
const FINEST: u8 = 14;
/// Exponents of smaller instances are rounded, by less than a quarter of a pixel, so that any number
/// of small shapes needs few meshes. This is the radius in pixels.
const SMALL_PX: f64 = 9.0;

/// The tolerance of a level on the unit shape.
pub(super) fn tolerance(level: u8) -> f64 {
    0.5f64.powi(level.into())
}

impl<'a> LevelOfDetail<'a> {
    /// The finest level of detail within a budget of triangles, for instances of these shapes and
    /// radii in pixels.
    pub(super) fn within<'s>(
        budget: usize,
        rule: DetailRule,
        segments: &'a SegmentCounts,
        instances: impl Iterator<Item = (&'s PreviewShape, f64)> + Clone,
    ) -> Self {
        let mut detail = Self { segments, rule, stretch: 1.0, coarser: 0 };
        let finest = detail;
        loop {
            let cost: u64 =
                instances.clone().map(|(shape, size_px)| detail.triangle_count(shape, size_px)).sum();
            if cost <= budget as u64 || detail.stretch >= MOST_STRETCH {
                break;
            }
            detail.stretch *= 2.0;
        }
        if detail.stretch > 1.0 {
            let is_coarser = |(shape, size_px): &(&PreviewShape, f64)| {
                detail.mesh(shape, *size_px).0 != finest.mesh(shape, *size_px).0
            };
            detail.coarser = instances.filter(is_coarser).count();
        }
        detail
    }

    /// The mesh of an instance, and the exponents that it has.
    pub(super) fn mesh(&self, shape: &PreviewShape, size_px: f64) -> (MeshDetail, Exponents) {
        match self.rule {
            DetailRule::Silhouette => {
                let size_px = size_px / self.stretch;
                let level = (size_px / TOLERANCE_PX).log2().ceil().clamp(0.0, FINEST.into()) as u8;
                let is_small = size_px <= SMALL_PX;
                let exponents = if is_small { rounded(shape.exponents) } else { shape.exponents };
                (MeshDetail::Within { level }, exponents)
            }
            DetailRule::Patches | DetailRule::Wireframe => {
                let level = self.level(shape.patches, size_px);
                let exponents = if level == 0 { shape.exponents } else { rounded(shape.exponents) };
                let Patches { u, v } = patches_at(shape.patches, level);
                (MeshDetail::Patches { u, v }, exponents)
            }
        }
    }

    fn triangle_count(&self, shape: &PreviewShape, size_px: f64) -> u64 {
        match self.mesh(shape, size_px) {
            (MeshDetail::Patches { u, v }, _) => triangle_count(Patches { u, v }),
            (MeshDetail::Within { level }, exponents) => {
                let quarter = |exponent| self.segments.quarter(exponent, level);
                triangle_count(Patches { u: 4 * quarter(exponents.e()), v: 2 * quarter(exponents.n()) })
            }
        }
    }

    /// The level of an instance: 0 for its own patches, else 1 + its index in `LEVELS`.
    fn level(&self, own: Patches, size_px: f64) -> u8 {
        let own_cost = triangle_count(own);
        let serves = |(limit, patches): &(f64, Patches)| {
            // In wireframe the patches themselves are visible.
            let limit = if self.rule == DetailRule::Wireframe { limit.min(2.0) } else { *limit };
            size_px <= limit * self.stretch && triangle_count(*patches) < own_cost
        };
        LEVELS.iter().rposition(serves).map_or(0, |index| index as u8 + 1)
    }
}

/// The patches of a level.
fn patches_at(own: Patches, level: u8) -> Patches {
    if level == 0 { drawn_patches(own) } else { LEVELS[usize::from(level) - 1].1 }
}

fn triangle_count(patches: Patches) -> u64 {
    2 * u64::from(patches.u) * u64::from(patches.v.max(1) - 1)
}

/// The nearest powers of 1.1.
fn rounded(exponents: Exponents) -> Exponents {
    let nearest = |exponent: f64| 1.1f64.powf(exponent.clamp(0.05, 16.0).log(1.1).round());
    // The powers are valid, so the default is never used.
    Exponents::new(nearest(exponents.e()), nearest(exponents.n())).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;
    use superegg_scene::Material;

    use super::*;

    const OWN: Patches = Patches { u: 15, v: 15 };

    fn shape(patches: Patches) -> PreviewShape {
        let (exponents, radii) = (Exponents::ROUND, DVec3::ONE);
        PreviewShape { exponents, radii, patches, material: Material::default() }
    }

    #[test]
    fn a_large_instance_has_its_own_patches_and_a_small_one_fewer() {
        let (segments, own) = (SegmentCounts::default(), shape(OWN));
        let once = [(&own, 100.0)].into_iter();
        let detail = LevelOfDetail::within(usize::MAX, DetailRule::Patches, &segments, once);
        let levels: Vec<u8> = [100.0, 8.0, 3.0, 0.5].map(|size| detail.level(OWN, size)).into();
        assert_eq!(levels, [0, 1, 2, 3]);
        assert_eq!(detail.level(Patches { u: 3, v: 2 }, 0.1), 0);
    }

    #[test]
    fn the_budget_is_kept_where_possible_and_reported() {
        let (segments, own) = (SegmentCounts::default(), shape(OWN));
        let within = |budget, rule| {
            let instances = std::iter::repeat_n((&own, 100.0), 1000);
            LevelOfDetail::within(budget, rule, &segments, instances)
        };
        for rule in [DetailRule::Patches, DetailRule::Silhouette] {
            let detail = within(20_000, rule);
            assert_eq!(detail.coarser, 1000);
            assert!(detail.triangle_count(&own, 100.0) <= 20);
            assert_eq!(within(10_000_000, rule).coarser, 0);
        }
        assert_eq!(within(0, DetailRule::Wireframe).coarser, 1000);
    }

    #[test]
    fn a_silhouette_is_right_to_half_a_pixel_at_any_size() {
        let (segments, own) = (SegmentCounts::default(), shape(OWN));
        let detail = LevelOfDetail::within(usize::MAX, DetailRule::Silhouette, &segments, std::iter::empty());
        for size_px in [0.1, 1.0, 10.0, 100.0, 1000.0, 4000.0] {
            let (MeshDetail::Within { level }, _) = detail.mesh(&own, size_px) else { panic!() };
            // The sphere around the box of a ball is larger than the ball.
            assert!(2.0 * tolerance(level) * size_px / 3f64.sqrt() < 0.5, "{size_px}");
        }
    }
}
