//! The inside-outside test (course text, drawIOTest): a jittered grid of points, each tested
//! against the scene.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;
use superegg_scene::{Camera, ViewSettings};
use superegg_trace::CompiledScene;

/// Most points along each axis. Points farther from the centre are left out.
const MOST_ALONG_AXIS: u32 = 41;
/// Steps from the centre of a fitting grid to its end along the longest side.
const FIT_STEPS: f64 = 7.0;
/// Half extent of a fitting grid, in half extents of the scene.
const FIT_MARGIN: f64 = 1.15;
/// Jitter of a fitting grid, in steps.
const FIT_JITTER: f64 = 0.1;

/// The choice of a grid. It does not depend on the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridChoice {
    /// The grid of these parameters.
    Fixed(GridSpec),
    /// The grid that suits the bounding box of the scene.
    Fit,
}

impl GridChoice {
    /// The choice of the settings.
    pub fn new(settings: &ViewSettings) -> Self {
        if settings.io_fit { Self::Fit } else { Self::Fixed(GridSpec::new(settings)) }
    }

    /// The grid for a scene with this bounding box and camera. `None` if there is no box to fit.
    pub fn spec(&self, bounds: Option<&Aabb>, camera: &Camera) -> Option<GridSpec> {
        match self {
            Self::Fixed(spec) => Some(*spec),
            Self::Fit => GridSpec::fitting(&in_view(bounds?, camera)),
        }
    }
}

/// The part of a box around the target of a camera that is in view, or the whole box if none is. Large
/// walls would make the grid too coarse for everything else.
fn in_view(bounds: &Aabb, camera: &Camera) -> Aabb {
    let distance = (camera.position - camera.target).length();
    let half_height = match camera.ortho_height {
        Some(height) => 0.5 * height,
        None => distance * (0.5 * camera.fov_deg.to_radians()).tan(),
    };
    let (min, max) = (camera.target - half_height, camera.target + half_height);
    let seen = Aabb { min: bounds.min.max(min), max: bounds.max.min(max) };
    let is_seen = (seen.max - seen.min).min_element() > 0.0;
    if is_seen { seen } else { *bounds }
}

/// Parameters of a grid: spacing, extent, jitter. The radius of the marks is not one: it needs no
/// new test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridSpec {
    /// The middle, in world space.
    center: DVec3,
    /// Spacing in world units.
    step: f64,
    /// Half the extent along each axis, in world units.
    half: DVec3,
    /// Largest displacement along each axis, in world units.
    jitter: f64,
}

/// A tested grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IoGrid {
    /// The jittered points, and whether each is inside a shape.
    pub points: Vec<(DVec3, bool)>,
    /// The extent holds more points than the limit.
    pub is_cut: bool,
    /// Spacing in world units.
    pub step: f64,
}

impl GridSpec {
    /// The grid of the settings, around the origin.
    fn new(settings: &ViewSettings) -> Self {
        Self {
            center: DVec3::ZERO,
            step: settings.io_step,
            half: DVec3::splat(settings.io_half),
            jitter: settings.io_jitter,
        }
    }

    /// A grid a little larger than a box. `None` for a box without a size.
    fn fitting(bounds: &Aabb) -> Option<Self> {
        let half = FIT_MARGIN * bounds.half_extent();
        let step = half.max_element() / FIT_STEPS;
        let is_usable = !bounds.is_empty() && half.is_finite() && bounds.center().is_finite() && step > 0.0;
        is_usable.then(|| Self { center: bounds.center(), step, half, jitter: FIT_JITTER * step })
    }

    /// Steps from the centre to each side along the axes after the limit, and whether the limit cut
    /// any.
    fn reach(&self) -> ([i32; 3], bool) {
        let most = f64::from(MOST_ALONG_AXIS / 2);
        // Rounding must not lose the last step: 0.3 / 0.1 is less than 3.
        let reach = (self.half / self.step * (1.0 + 4.0 * f64::EPSILON)).floor();
        // NaN gives no steps.
        (reach.to_array().map(|reach| reach.min(most).max(0.0) as i32), reach.max_element() > most)
    }

    /// The points `centre + step (i, j, k)` within the extent, displaced along each axis by at most
    /// the jitter. Equal parameters give equal points.
    fn points(&self) -> Vec<DVec3> {
        let ([x, y, z], _) = self.reach();
        let range = |reach: i32| -reach..=reach;
        let step = if self.step.is_finite() { self.step } else { 0.0 };
        let jitter = if self.jitter.is_finite() { self.jitter } else { 0.0 };
        let cells = range(x).flat_map(move |i| range(y).flat_map(move |j| range(z).map(move |k| [i, j, k])));
        cells
            .map(|cell| {
                let point = self.center + step * DVec3::from_array(cell.map(f64::from));
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
    pub fn test(scene: &CompiledScene, spec: &GridSpec, cancel: &AtomicBool) -> Option<Self> {
        let points: Vec<(DVec3, bool)> = spec
            .points()
            .into_par_iter()
            .map(|point| (point, scene.contains_point_unless(point, cancel) == Some(true)))
            .collect();
        let is_complete = !cancel.load(Ordering::Relaxed);
        is_complete.then(|| Self { points, is_cut: spec.reach().1, step: spec.step })
    }
}

#[cfg(test)]
mod tests {
    use superegg_lang::Session;

    use super::*;

    fn fixed(step: f64, half: f64, jitter: f64) -> GridSpec {
        GridSpec { center: DVec3::ZERO, step, half: DVec3::splat(half), jitter }
    }

    fn compiled(lines: &[&str]) -> CompiledScene {
        let mut session = Session::default();
        lines.iter().for_each(|line| assert!(session.run_line(line).is_ok(), "{line}"));
        CompiledScene::compile(session.scene(), session.selected(), session.scene().depth)
    }

    #[test]
    fn the_grid_of_the_course_is_that_of_its_text() {
        let choice = GridChoice::new(&ViewSettings::COURSE);
        let spec = choice.spec(None, &Camera::default()).unwrap();
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
        let spec = fixed(0.5, 3.0, 0.1);
        let grid = IoGrid::test(&scene, &spec, &AtomicBool::new(false)).unwrap();
        let is_inside = |p: DVec3| ((p.x - 1.0) / 2.0).powi(2) + p.y * p.y + p.z * p.z < 1.0;
        assert!(grid.points.iter().any(|(_, inside)| *inside));
        assert!(grid.points.iter().all(|(p, inside)| *inside == is_inside(*p)));
        assert!(!grid.is_cut);
    }

    #[test]
    fn a_grid_too_large_is_cut_and_parameters_that_are_not_finite_are_harmless() {
        let spec = fixed(1e-9, 5.0, 0.0);
        assert_eq!((spec.reach(), spec.points().len()), (([20; 3], true), 41 * 41 * 41));
        for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
            let spec = fixed(bad, bad, bad);
            assert!(spec.points().iter().all(|point| point.is_finite()), "{bad}");
        }
    }

    #[test]
    fn a_cancelled_test_answers_nothing() {
        let scene = compiled(&["prm ball"]);
        assert!(IoGrid::test(&scene, &fixed(0.5, 5.0, 0.0), &AtomicBool::new(true)).is_none());
    }

    #[test]
    fn a_fitting_grid_has_as_many_points_at_any_scale() {
        let settings = ViewSettings { io_test: true, ..ViewSettings::default() };
        let choice = GridChoice::new(&settings);
        let far = |scale: f64| Camera { position: 100.0 * scale * DVec3::Z, ..Camera::default() };
        let spec = |scale: f64| {
            let bounds =
                Aabb::around(scale * DVec3::new(3.0, 0.0, -1.0), scale * DVec3::new(2.0, 1.0, 0.001));
            choice.spec(Some(&bounds), &far(scale)).unwrap()
        };
        for scale in [1e-9, 1.0, 1e12] {
            let points = spec(scale).points();
            assert_eq!(points.len(), 15 * 7);
            assert!(
                points.iter().all(|p| (*p / scale - DVec3::new(3.0, 0.0, -1.0)).abs().max_element() < 2.4)
            );
        }
        let none = [None, Some(&Aabb::EMPTY), Some(&Aabb::around(DVec3::ONE, DVec3::ZERO))];
        assert!(none.into_iter().all(|bounds| choice.spec(bounds, &far(1.0)).is_none()));

        // A long wall does not make it coarse: it is where the camera looks.
        let wall = Aabb::around(DVec3::ZERO, DVec3::new(1000.0, 1.0, 1.0));
        let spec_of_wall = choice.spec(Some(&wall), &Camera::default()).unwrap();
        assert!(spec_of_wall.half.x < 10.0, "{spec_of_wall:?}");
    }
}
