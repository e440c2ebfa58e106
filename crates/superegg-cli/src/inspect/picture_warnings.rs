//! Warnings about pictures that will be empty, dark or seen from inside a shape.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_render::{Output, RenderSettings};
use superegg_scene::{Camera, Light, LightKind, LightModel};
use superegg_trace::CompiledScene;

/// The maximum time of the test whether the camera is inside a shape, which a deep fractal can make
/// very long.
const TEST_TIMEOUT: Duration = Duration::from_millis(500);

/// Warnings about a picture that is probably not what the user wants. An empty scene has none; the
/// caller reports it.
pub(crate) fn picture_warnings(compiled: &CompiledScene, settings: &RenderSettings) -> Vec<String> {
    let Some(bounds) = compiled.bounds() else { return Vec::new() };
    let environment = &settings.environment;
    let has_floor = environment.floor.is_some();
    let mut warnings = Vec::new();
    let by_paths = settings.picture.light_model == LightModel::Path;
    let is_lit_otherwise =
        if by_paths { shines_alone(compiled, settings) } else { environment.ambient_occlusion.is_some() };
    if settings.output == Output::Light
        && !is_lit_otherwise
        && !environment.lights.iter().any(|light| shines_on(light, &bounds, has_floor))
    {
        let cause = match environment.lights.len() {
            0 => "there is no light",
            1 => "the only light does not reach anything",
            _ => "no light reaches anything",
        };
        warnings.push(if by_paths {
            format!("{cause}, the sky is black and no shape shines: surfaces are black")
        } else {
            format!("{cause}: surfaces show only their ambient part")
        });
    }
    let picture = &settings.picture;
    let aspect = f64::from(picture.width) / f64::from(picture.height);
    match out_of_view(&settings.camera, &bounds, aspect).filter(|_| !has_floor) {
        Some(OutOfView::Behind) => {
            warnings.push(
                "nothing is in view: all of it is behind the camera; look at it with 'camera'".to_owned(),
            );
        }
        Some(OutOfView::Beside) => {
            warnings
                .push("nothing is in view: the camera looks past it; look at it with 'camera'".to_owned());
        }
        None => {
            if let Some(name) = shape_around(compiled, &settings.camera) {
                warnings.push(format!("the camera is inside '{name}', and sees it from within"));
            }
        }
    }
    warnings
}

/// Whether the sky or a shape shines.
fn shines_alone(compiled: &CompiledScene, settings: &RenderSettings) -> bool {
    let environment = &settings.environment;
    let of_floor = environment.floor.iter().map(|(_, material)| material);
    let sky = environment.sky.map_or(environment.background, |sky| sky.horizon.max(sky.zenith));
    environment.map.is_some()
        || sky.max_element() > 0.0
        || compiled.materials().iter().chain(of_floor).any(|material| material.emission > 0.0)
}

/// Whether a light reaches the box or the floor.
fn shines_on(light: &Light, bounds: &Aabb, has_floor: bool) -> bool {
    if light.color.max_element() <= 0.0 {
        return false;
    }
    let LightKind::Spot { position, target, cone_deg, .. } = light.kind else { return true };
    let (to_middle, radius) = (bounds.center() - position, bounds.half_extent().length());
    if has_floor || to_middle.length() <= radius {
        return true;
    }
    // The bounding sphere of the box, as seen from the light.
    let (Some(axis), Some(middle)) = (unit_vector(target - position), unit_vector(to_middle)) else {
        return true;
    };
    let off_axis_rad = axis.dot(middle).clamp(-1.0, 1.0).acos();
    off_axis_rad - (radius / to_middle.length()).asin() <= 0.5 * cone_deg.to_radians()
}

/// Where a box outside the view lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutOfView {
    Behind,
    Beside,
}

/// Tests whether a box lies completely outside one plane of the view frustum.
fn out_of_view(camera: &Camera, bounds: &Aabb, aspect: f64) -> Option<OutOfView> {
    let (right, up, forward) = camera.frame();
    let half = bounds.half_extent();
    let corners: [DVec3; 8] = std::array::from_fn(|i| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        bounds.center() + DVec3::new(sign(0), sign(1), sign(2)) * half - camera.position
    });
    if corners.iter().all(|corner| corner.dot(forward) < 0.0) {
        return Some(OutOfView::Behind);
    }
    // Depth of field widens the frustum.
    if camera.lens.is_some() {
        return None;
    }
    // The half height of the frustum: `fixed + slope * depth`.
    let (fixed, slope) = match camera.ortho_height {
        Some(height) => (0.5 * height, 0.0),
        None => (0.0, (0.5 * camera.fov_deg.to_radians()).tan()),
    };
    let is_outside = |side: DVec3, scale: f64| {
        let reach = |corner: &DVec3| scale * (fixed + slope * corner.dot(forward));
        corners.iter().all(|corner| corner.dot(side) > reach(corner))
    };
    let sides = [(right, aspect), (-right, aspect), (up, 1.0), (-up, 1.0)];
    sides.into_iter().any(|(side, scale)| is_outside(side, scale)).then_some(OutOfView::Beside)
}

/// The opaque shape that contains the camera; `None` also if the test takes too long.
fn shape_around(compiled: &CompiledScene, camera: &Camera) -> Option<String> {
    let cancel = AtomicBool::new(false);
    let answer = std::thread::scope(|scope| {
        let (done, is_done) = channel::<()>();
        let cancel = &cancel;
        scope.spawn(move || {
            if is_done.recv_timeout(TEST_TIMEOUT).is_err() {
                cancel.store(true, Ordering::Relaxed);
            }
        });
        let answer = compiled.query_point_unless(camera.position, cancel);
        let _ = done.send(());
        answer
    })?;
    let (value, path) = answer.least?;
    (value < 0.0 && !compiled.lets_light_through(&path)).then(|| compiled.path_name(&path))
}

#[cfg(test)]
mod tests {
    use superegg_lang::load_text;

    use super::*;

    fn warnings(text: &str) -> Vec<String> {
        let (session, diagnostics) = load_text("odd.scn", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = session.scene();
        let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
        picture_warnings(&compiled, &RenderSettings::of(scene))
    }

    fn one(text: &str, part: &str) {
        let warnings = warnings(text);
        assert!(warnings.len() == 1 && warnings[0].contains(part), "{text}: {warnings:?}");
    }

    #[test]
    fn a_pointless_picture_has_a_warning() {
        assert_eq!(warnings("prm s\n"), [""; 0]);
        one("prm s\nlight l 0 0 9 0 0 0\n", "does not reach");
        one("prm s\nlight l 0 0 9 0 0 0\nlight m 0 9 9 0 0 0\n", "no light reaches");
        one("set light path\nbackground 0 0 0\nprm s\nlight l 0 0 9 0 0 0\n", "no shape shines");
        one("prm s\ncamera 0 0 10 0 0 20\n", "behind the camera");
        one("prm s\ncamera 0 0 10 10 0 10\n", "looks past");
        one("prm s\ncamera 0 0 .5 0 0 0\n", "inside 's'");
    }

    #[test]
    fn a_useful_picture_has_none() {
        for fine in [
            "prm s\nlight l 0 0 9 0 0 0\nlight m 0 9 9 0 .1 0\n",
            "set light path\nbackground 1 1 1\nprm s\nlight l 0 0 9 0 0 0\n",
            "set light path\nbackground 0 0 0\nprm s\nlight l 0 0 9 0 0 0\nemission 1\n",
            "prm s\ncamera 0 0 .5 0 0 0\nrefracted .8\n",
            // A corner of the picture is enough, and the floor goes everywhere.
            "prm s\ncamera 0 0 10 5.5 4 0 60\n",
            "prm s\ncamera 0 0 10 0 0 20\nfloor -1\n",
            "obj o\n",
        ] {
            assert_eq!(warnings(fine), [""; 0], "{fine}");
        }
    }

    #[test]
    fn a_spot_that_misses_everything_does_not_shine() {
        let bounds = Aabb { min: DVec3::splat(-1.0), max: DVec3::ONE };
        let spot = |target: DVec3, cone_deg: f64| Light {
            kind: LightKind::Spot { position: DVec3::Z * 10.0, target, cone_deg, soft: 0.0 },
            ..Light::DEFAULT
        };
        assert!(shines_on(&spot(DVec3::ZERO, 1.0), &bounds, false));
        assert!(shines_on(&spot(DVec3::X * 3.0, 20.0), &bounds, false));
        assert!(!shines_on(&spot(DVec3::Z * 20.0, 90.0), &bounds, false));
        assert!(!shines_on(&spot(DVec3::X * 20.0, 20.0), &bounds, false));
        assert!(shines_on(&spot(DVec3::X * 20.0, 20.0), &bounds, true));
    }
}
