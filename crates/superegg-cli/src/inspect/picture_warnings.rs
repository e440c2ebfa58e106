//! What makes a picture empty, dark or odd, told before it is made.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;

use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_render::{Output, RenderSettings};
use superegg_scene::{Camera, Light, LightKind};
use superegg_trace::CompiledScene;

/// Asking whether the camera is inside of something may take so long; a deep fractal around it could take for ever.
const LONGEST_ASKED: Duration = Duration::from_millis(500);

/// Sentences about a picture that is likely not what was meant. Nothing of an empty scene, which is told apart.
pub(crate) fn picture_warnings(compiled: &CompiledScene, settings: &RenderSettings) -> Vec<String> {
    let Some(bounds) = compiled.bounds() else { return Vec::new() };
    let environment = &settings.environment;
    let has_floor = environment.floor.is_some();
    let mut found = Vec::new();
    if settings.output == Output::Light
        && environment.ambient_occlusion.is_none()
        && !environment.lights.iter().any(|light| shines_on(light, &bounds, has_floor))
    {
        let which = match environment.lights.len() {
            0 => "there is no light",
            1 => "the only light does not reach anything",
            _ => "no light reaches anything",
        };
        found.push(format!("{which}: surfaces show only their ambient part"));
    }
    let picture = &settings.picture;
    let aspect = f64::from(picture.width) / f64::from(picture.height);
    match out_of_view(&settings.camera, &bounds, aspect).filter(|_| !has_floor) {
        Some(Missed::Behind) => {
            found.push(
                "nothing is in view: all of it is behind the camera; look at it with 'camera'".to_owned(),
            );
        }
        Some(Missed::Beside) => {
            found.push("nothing is in view: the camera looks past it; look at it with 'camera'".to_owned());
        }
        None => {
            if let Some(name) = shape_around(compiled, &settings.camera) {
                found.push(format!("the camera is inside '{name}', and sees it from within"));
            }
        }
    }
    found
}

/// Whether any of a light comes to a box, or where there is a floor, at all.
fn shines_on(light: &Light, bounds: &Aabb, has_floor: bool) -> bool {
    if light.color.max_element() <= 0.0 {
        return false;
    }
    let LightKind::Spot { position, target, cone_deg, .. } = light.kind else { return true };
    let (to_middle, radius) = (bounds.center() - position, bounds.half_extent().length());
    if has_floor || to_middle.length() <= radius {
        return true;
    }
    // The ball around the box, as seen from the light.
    let (Some(axis), Some(middle)) = (unit_vector(target - position), unit_vector(to_middle)) else {
        return true;
    };
    let off_axis_rad = axis.dot(middle).clamp(-1.0, 1.0).acos();
    off_axis_rad - (radius / to_middle.length()).asin() <= 0.5 * cone_deg.to_radians()
}

/// Where a box is that no ray of the camera comes near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Missed {
    Behind,
    Beside,
}

/// Whether a box lies wholly behind one of the planes that bound what the camera sees.
fn out_of_view(camera: &Camera, bounds: &Aabb, aspect: f64) -> Option<Missed> {
    let (right, up, forward) = camera.frame();
    let half = bounds.half_extent();
    let corners: [DVec3; 8] = std::array::from_fn(|i| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        bounds.center() + DVec3::new(sign(0), sign(1), sign(2)) * half - camera.position
    });
    if corners.iter().all(|corner| corner.dot(forward) < 0.0) {
        return Some(Missed::Behind);
    }
    // Rays through a lens leave these planes.
    if camera.lens.is_some() {
        return None;
    }
    // How far the picture goes to a side: so much, and so much more for each unit of depth.
    let (fixed, slope) = match camera.ortho_height {
        Some(height) => (0.5 * height, 0.0),
        None => (0.0, (0.5 * camera.fov_deg.to_radians()).tan()),
    };
    let is_past = |side: DVec3, share: f64| {
        let reach = |corner: &DVec3| share * (fixed + slope * corner.dot(forward));
        corners.iter().all(|corner| corner.dot(side) > reach(corner))
    };
    let sides = [(right, aspect), (-right, aspect), (up, 1.0), (-up, 1.0)];
    sides.into_iter().any(|(side, share)| is_past(side, share)).then_some(Missed::Beside)
}

/// The name of a shape that the camera is inside of, unless light goes through it, or it takes too long to tell.
fn shape_around(compiled: &CompiledScene, camera: &Camera) -> Option<String> {
    let cancel = AtomicBool::new(false);
    let answer = std::thread::scope(|scope| {
        let (done, is_done) = channel::<()>();
        let cancel = &cancel;
        scope.spawn(move || {
            if is_done.recv_timeout(LONGEST_ASKED).is_err() {
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

    fn told(text: &str) -> Vec<String> {
        let (session, diagnostics) = load_text("odd.scn", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let scene = session.scene();
        let compiled = CompiledScene::compile(scene, session.selected(), scene.depth);
        picture_warnings(&compiled, &RenderSettings::of(scene))
    }

    fn one(text: &str, part: &str) {
        let told = told(text);
        assert!(told.len() == 1 && told[0].contains(part), "{text}: {told:?}");
    }

    #[test]
    fn what_is_pointless_is_told() {
        assert_eq!(told("prm s\n"), [""; 0]);
        one("prm s\nlight l 0 0 9 0 0 0\n", "does not reach");
        one("prm s\nlight l 0 0 9 0 0 0\nlight m 0 9 9 0 0 0\n", "no light reaches");
        one("prm s\ncamera 0 0 10 0 0 20\n", "behind the camera");
        one("prm s\ncamera 0 0 10 10 0 10\n", "looks past");
        one("prm s\ncamera 0 0 .5 0 0 0\n", "inside 's'");
    }

    #[test]
    fn what_has_a_point_is_not() {
        for fine in [
            "prm s\nlight l 0 0 9 0 0 0\nlight m 0 9 9 0 .1 0\n",
            "prm s\ncamera 0 0 .5 0 0 0\nrefracted .8\n",
            // A corner of the picture is enough, and the floor goes everywhere.
            "prm s\ncamera 0 0 10 5.5 4 0 60\n",
            "prm s\ncamera 0 0 10 0 0 20\nfloor -1\n",
            "obj o\n",
        ] {
            assert_eq!(told(fine), [""; 0], "{fine}");
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
