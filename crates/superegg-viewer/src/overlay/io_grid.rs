//! The marks of the inside-outside test.

use superegg_scene::ViewSettings;

use crate::draw::Mark;
use crate::queries::IoGrid;

/// Radius of the marks of a fitting grid, in steps.
const FIT_RADIUS: f64 = 0.09;

const INSIDE: [f32; 4] = [1.0, 0.16, 0.13, 1.0];
/// Most points are outside. They are nearly transparent so that they hide nothing.
const OUTSIDE: [f32; 4] = [0.25, 0.45, 1.0, 0.1];
/// The same in a fitting grid, which has fewer points.
const FIT_OUTSIDE: [f32; 4] = [0.3, 0.5, 1.0, 0.2];

/// The points as marks: red inside, blue outside. The points of a fitting grid that are inside show
/// through surfaces unless `is_wireframe`.
pub(crate) fn marks(
    grid: &IoGrid,
    settings: &ViewSettings,
    is_wireframe: bool,
) -> impl Iterator<Item = Mark> {
    let is_fit = settings.io_fit;
    let radius = if is_fit { FIT_RADIUS * grid.step } else { settings.io_radius };
    let outside = if is_fit { FIT_OUTSIDE } else { OUTSIDE };
    let shows_outside = settings.io_outside;
    let shown = grid.points.iter().filter(move |(_, is_inside)| *is_inside || shows_outside);
    shown.map(move |&(center, is_inside)| Mark {
        center,
        radius,
        color: if is_inside { INSIDE } else { outside },
        is_on_top: is_inside && is_fit && !is_wireframe,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use superegg_geom::Aabb;
    use superegg_geom::glam::DVec3;
    use superegg_lang::Session;
    use superegg_scene::Camera;
    use superegg_trace::CompiledScene;

    use super::*;
    use crate::queries::GridChoice;

    #[test]
    fn the_outside_of_a_grid_can_be_left_out() {
        let settings = ViewSettings { io_test: true, ..ViewSettings::default() };
        let mut session = Session::default();
        ["prm ball", "coeff 40 40 40"]
            .iter()
            .for_each(|line| assert!(session.run_line(line).is_ok(), "{line}"));
        let scene = CompiledScene::compile(session.scene(), session.selected(), session.scene().depth);
        let bounds = Aabb::around(DVec3::ZERO, DVec3::splat(40.0));
        let camera = Camera { position: 4000.0 * DVec3::Z, ..Camera::default() };
        let spec = GridChoice::new(&settings).spec(Some(&bounds), &camera).unwrap();
        let grid = IoGrid::test(&scene, &spec, &AtomicBool::new(false)).unwrap();
        let inside = grid.points.iter().filter(|(_, is_inside)| *is_inside).count();
        let count = |settings: &ViewSettings| marks(&grid, settings, false).count();
        assert_eq!(count(&settings), grid.points.len());
        assert_eq!(count(&ViewSettings { io_outside: false, ..settings }), inside);
        assert!(
            inside > 500 && marks(&grid, &settings, false).filter(|mark| mark.is_on_top).count() == inside
        );
    }
}
