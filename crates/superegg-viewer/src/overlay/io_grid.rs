//! The inside-outside test (course text, drawIOTest): a jittered grid of points, each tested
//! against the scene.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_scene::ViewSettings;
use superegg_trace::CompiledScene;

use crate::draw::Mark;

/// Most points along each axis. Points farther from the origin are left out.
const MOST_ALONG_AXIS: u32 = 41;

/// Parameters of a grid: spacing, extent, jitter. The radius of the marks is not one: it needs no
/// new test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GridSpec {
    /// Spacing in world units.
    step: f64,
    /// Half the extent along each axis, in world units.
    half: f64,
    /// Largest displacement along each axis, in world units.
    jitter: f64,
}

/// A tested grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct IoGrid {
    /// The jittered points, and whether each is inside a shape.
    pub(crate) points: Vec<(DVec3, bool)>,
    /// The extent holds more points than the limit.
    pub(crate) is_cut: bool,
}

const INSIDE: [f32; 4] = [1.0, 0.16, 0.13, 1.0];
/// Most points are outside. They are nearly transparent so that they hide nothing.
const OUTSIDE: [f32; 4] = [0.25, 0.45, 1.0, 0.1];

impl GridSpec {
    /// The grid of the settings.
    pub(crate) fn new(settings: &ViewSettings) -> Self {
        Self { step: settings.io_step, half: settings.io_half, jitter: settings.io_jitter }
    }

    /// Steps from the centre to each side after the limit, and whether the limit cut any.
    fn reach(&self) -> (i32, bool) {
        // Rounding must not lose the last step: 0.3 / 0.1 is less than 3.
        let reach = (self.half / self.step * (1.0 + 4.0 * f64::EPSILON)).floor();
        let most = f64::from(MOST_ALONG_AXIS / 2);
        // NaN gives no steps.
        (reach.min(most).max(0.0) as i32, reach > most)
    }

    /// The points `step (i, j, k)` within the extent, displaced along each axis by at most the
    /// jitter. Equal parameters give equal points.
    fn points(&self) -> Vec<DVec3> {
        let (reach, _) = self.reach();
        let range = move || -reach..=reach;
        let step = if self.step.is_finite() { self.step } else { 0.0 };
        let jitter = if self.jitter.is_finite() { self.jitter } else { 0.0 };
        let cells = range().flat_map(|i| range().flat_map(move |j| range().map(move |k| [i, j, k])));
        cells
            .map(|cell| {
                let point = step * DVec3::from_array(cell.map(f64::from));
                point + jitter * DVec3::from_array([0, 1, 2].map(|axis| noise(cell, axis)))
            })
            .collect()
    }
}

/// A pseudorandom number in [-1, 1) for an axis of a cell: the finaliser of SplitMix64.
fn noise(cell: [i32; 3], axis: u64) -> f64 {
    let key = cell.iter().fold(axis, |key, &i| (key << 20) ^ u64::from(i as u32 & 0xF_FFFF));
    let mut x = key.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^= x >> 31;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl IoGrid {
    /// Tests every point of a grid on all cores. Returns `None` if `cancel` became true first.
    pub(crate) fn test(scene: &CompiledScene, spec: &GridSpec, cancel: &AtomicBool) -> Option<Self> {
        let points: Vec<(DVec3, bool)> = spec
            .points()
            .into_par_iter()
            .map(|point| (point, scene.contains_point_unless(point, cancel) == Some(true)))
            .collect();
        (!cancel.load(Ordering::Relaxed)).then_some(Self { points, is_cut: spec.reach().1 })
    }

    /// The points as marks of this radius: red inside, blue outside.
    pub(crate) fn marks(&self, radius: f64) -> impl Iterator<Item = Mark> {
        self.points.iter().map(move |&(center, is_inside)| Mark {
            center,
            radius,
            color: if is_inside { INSIDE } else { OUTSIDE },
        })
    }
}

#[cfg(test)]
mod tests {
    use superegg_lang::Session;

    use super::*;

    fn compiled(lines: &[&str]) -> CompiledScene {
        let mut session = Session::default();
        lines.iter().for_each(|line| assert!(session.run_line(line).is_ok(), "{line}"));
        CompiledScene::compile(session.scene(), session.selected(), session.scene().depth)
    }

    #[test]
    fn the_default_grid_is_that_of_the_course_text() {
        let spec = GridSpec::new(&ViewSettings::default());
        let points = spec.points();
        assert_eq!(points.len(), 21 * 21 * 21);
        assert!(points.iter().all(|p| {
            let nearest = (*p / 0.5).round() * 0.5;
            (*p - nearest).abs().max_element() <= 0.05 && nearest.abs().max_element() <= 5.0
        }));
        assert_ne!(points[0], points[0].round());
        assert_eq!(points, spec.points());
    }

    #[test]
    fn answers_are_those_of_the_shape_with_its_transforms() {
        let scene = compiled(&["prm ball", "obj o", "ap ball", "ss 2 1 1", "xs 1 0 0"]);
        let spec = GridSpec { step: 0.5, half: 3.0, jitter: 0.1 };
        let grid = IoGrid::test(&scene, &spec, &AtomicBool::new(false)).unwrap();
        let is_inside = |p: DVec3| ((p.x - 1.0) / 2.0).powi(2) + p.y * p.y + p.z * p.z < 1.0;
        assert!(grid.points.iter().any(|(_, inside)| *inside));
        assert!(grid.points.iter().all(|(p, inside)| *inside == is_inside(*p)));
        assert!(!grid.is_cut);
    }

    #[test]
    fn a_grid_too_large_is_cut_and_parameters_that_are_not_finite_are_harmless() {
        let spec = GridSpec { step: 1e-9, half: 5.0, jitter: 0.0 };
        assert_eq!((spec.reach(), spec.points().len()), ((20, true), 41 * 41 * 41));
        for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            let spec = GridSpec { step: bad, half: bad, jitter: bad };
            assert!(spec.points().iter().all(|point| point.is_finite()), "{bad}");
        }
    }

    #[test]
    fn a_cancelled_test_answers_nothing() {
        let scene = compiled(&["prm ball"]);
        let spec = GridSpec::new(&ViewSettings::default());
        assert!(IoGrid::test(&scene, &spec, &AtomicBool::new(true)).is_none());
    }
}
