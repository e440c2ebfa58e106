//! A camera that shows a whole scene.

use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;
use superegg_scene::{Camera, Lens, Light, LightKind, Scene};
use superegg_trace::CompiledScene;

/// The part of the picture that a framed scene fills, of the height or of the width.
const FILLED: f64 = 0.9;
/// The part of the picture's height below which a scene counts as unseen.
const SMALLEST_SEEN: f64 = 0.02;
/// The distance of the camera to its target at which the light is where the default light is. The
/// default camera is three times as far from its target, because a scene is rarely as small in its
/// picture as there: a light so near to one that fills it would light a part.
const LIGHT_DISTANCE: f64 = 10.0 / 3.0;

/// A camera that shows all of a scene, and a light in the direction of the default light, as bright
/// at the target as that is.
///
/// ```
/// use superegg_geom::{Exponents, Superquadric};
/// use superegg_geom::glam::DVec3;
/// use superegg_render::Framing;
/// use superegg_scene::{Camera, Scene};
/// use superegg_trace::CompiledScene;
///
/// let mut scene = Scene::default();
/// scene.ensure_primitive("grain")?;
/// scene.primitive_mut("grain")?.shape = Superquadric::new(DVec3::splat(0.001), Exponents::ROUND)?;
/// let compiled = CompiledScene::compile(&scene, Some("grain"), 1);
/// let framing = Framing::of_unseen(&scene, &compiled, (640, 480)).expect("it is smaller than a pixel");
/// assert!(framing.camera.position.z < 0.003);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// The camera.
    pub camera: Camera,
    /// The light, for a scene without lights.
    pub light: Light,
}

impl Framing {
    /// Frames a scene for a picture of `size` pixels, seen from the direction of `camera`. `None` for
    /// an empty scene, or one whose size is no finite number.
    ///
    /// Each side of the view is moved until it touches the scene: the camera is as near as it can be.
    pub fn of(camera: &Camera, compiled: &CompiledScene, size: (u32, u32)) -> Option<Self> {
        Self::of_extent(camera, &|u| compiled.extent(u), size)
    }

    /// As [`Framing::of`], for everything in a box. `None` for an empty box too.
    ///
    /// ```
    /// use superegg_geom::Aabb;
    /// use superegg_geom::glam::DVec3;
    /// use superegg_render::Framing;
    /// use superegg_scene::Camera;
    ///
    /// let cube = Aabb::around(DVec3::X, DVec3::ONE);
    /// let framing = Framing::of_box(&Camera::default(), &cube, (640, 480)).expect("a cube is in sight");
    /// assert!((framing.camera.position - DVec3::new(1.0, 0.0, 2.92)).length() < 0.01);
    /// ```
    pub fn of_box(camera: &Camera, bounds: &Aabb, size: (u32, u32)) -> Option<Self> {
        let (center, half) = (bounds.center(), bounds.half_extent());
        let extent = |u: DVec3| (!bounds.is_empty()).then(|| u.dot(center) + u.abs().dot(half));
        Self::of_extent(camera, &extent, size)
    }

    /// Frames what has this extent along each direction; see [`CompiledScene::extent`].
    fn of_extent(camera: &Camera, extent: &dyn Fn(DVec3) -> Option<f64>, size: (u32, u32)) -> Option<Self> {
        let basis = Basis::of(camera);
        let aspect = f64::from(size.0) / f64::from(size.1);
        let middle = |axis: DVec3| Some(0.5 * (extent(axis)? - extent(-axis)?));
        let spread = |axis: DVec3| Some(extent(axis)? + extent(-axis)?);
        let depth = middle(basis.back)?;
        let mut framed = *camera;
        let (right, up, back) = if camera.ortho_height.is_some() {
            let height = spread(basis.up)?.max(spread(basis.right)? / aspect) / FILLED;
            framed.ortho_height = Some(height);
            let size = height.max(spread(basis.back)?);
            (middle(basis.right)?, middle(basis.up)?, depth + 2.0 * size)
        } else {
            let slope = FILLED * (0.5 * camera.fov_deg.to_radians()).tan();
            // For a side with normal cos * axis + sin * back the camera is at least at the extent.
            let fit = |axis: DVec3, slope: f64| {
                let cos = 1.0 / (1.0 + slope * slope).sqrt();
                let sin = slope * cos;
                let (a, b) = (extent(cos * axis + sin * basis.back)?, extent(sin * basis.back - cos * axis)?);
                Some(((a - b) / (2.0 * cos), (a + b) / (2.0 * sin)))
            };
            let (up, back_for_height) = fit(basis.up, slope)?;
            let (right, back_for_width) = fit(basis.right, slope * aspect)?;
            (right, up, back_for_height.max(back_for_width))
        };
        let at = |depth: f64| right * basis.right + up * basis.up + depth * basis.back;
        (framed.position, framed.target) = (at(back), at(depth));
        let distance = back - depth;
        let is_finite = framed.position.is_finite() && framed.target.is_finite();
        if !is_finite || distance <= 0.0 || framed.position == framed.target {
            return None;
        }
        framed.lens = camera.lens.map(|lens| Lens { focus: distance, ..lens });
        Some(Self { camera: framed, light: light_for(&framed, distance) })
    }

    /// Frames a scene that sets no camera, if the default camera sees nothing of it: it is outside
    /// the view, behind the camera, around it, or too small. Else `None`: the scene stays as it is.
    pub fn of_unseen(scene: &Scene, compiled: &CompiledScene, size: (u32, u32)) -> Option<Self> {
        let camera = &scene.camera;
        let aspect = f64::from(size.0) / f64::from(size.1);
        // From above the up direction has no meaning. Only `up` asks for another side.
        let is_above = camera.looks_along_up() && scene.up() == camera.up;
        if Self::is_set(scene) || !(is_above || is_unseen(camera, compiled, aspect)?) {
            return None;
        }
        Self::of(&facing(camera), compiled, size)
    }

    /// Whether a scene sets its camera, once or with keys, so that it is never framed.
    pub fn is_set(scene: &Scene) -> bool {
        let default = Camera::default();
        let camera = &scene.camera;
        scene.sets_camera
            || (camera.position, camera.target) != (default.position, default.target)
            || scene.tracks().any(|track| &*track.subject().command == "camera")
    }

    /// Sets the camera of a scene, and its light if it has none.
    pub fn apply(&self, scene: &mut Scene) {
        scene.camera = self.camera;
        scene.sets_camera = true;
        if scene.named_lights().len() == 0 {
            scene.set_light(Self::LIGHT_NAME, self.light);
        }
    }

    /// Frames a scene as [`Framing::of_unseen`] finds it, for pictures and exports alike. Returns whether the scene has changed.
    pub fn frame_unseen(scene: &mut Scene, compiled: &CompiledScene, size: (u32, u32)) -> bool {
        let framing = Self::of_unseen(scene, compiled, size);
        framing.iter().for_each(|framing| framing.apply(scene));
        framing.is_some()
    }

    /// The name of the light that [`Framing::apply`] adds.
    pub const LIGHT_NAME: &'static str = "light";
}

/// The orthonormal frame of a camera.
struct Basis {
    right: DVec3,
    up: DVec3,
    /// Towards the camera.
    back: DVec3,
}

impl Basis {
    fn of(camera: &Camera) -> Self {
        let (right, up, forward) = camera.frame();
        Self { right, up, back: -forward }
    }
}

/// The default light, turned and scaled with the camera.
fn light_for(camera: &Camera, distance: f64) -> Light {
    let LightKind::Point { position } = Light::DEFAULT.kind else { return Light::DEFAULT };
    let basis = Basis::of(camera);
    let scale = distance / LIGHT_DISTANCE;
    let offset = position.x * basis.right + position.y * basis.up + position.z * basis.back;
    // In two steps: the square of a small scale may underflow.
    let falloff = Light::DEFAULT.falloff / scale / scale;
    Light {
        kind: LightKind::Point { position: camera.target + scale * offset },
        falloff: if falloff.is_finite() { falloff } else { 0.0 },
        ..Light::DEFAULT
    }
}

/// A camera, turned if it looks along its up direction: then it looks along y, or if y is up along
/// -z.
pub fn facing(camera: &Camera) -> Camera {
    if !camera.looks_along_up() {
        return *camera;
    }
    let turned = |back: DVec3| Camera { position: camera.target + back, ..*camera };
    let from_front = turned(DVec3::NEG_Y);
    if from_front.looks_along_up() { turned(DVec3::Z) } else { from_front }
}

/// Whether a camera sees nothing of a scene. `None` for an empty scene.
fn is_unseen(camera: &Camera, compiled: &CompiledScene, aspect: f64) -> Option<bool> {
    let bounds = compiled.bounds()?;
    let basis = Basis::of(camera);
    let extent = |u: DVec3| compiled.extent(u);
    let at = camera.position;
    // The nearest and farthest depth along the line of sight.
    let (near, far) = (at.dot(basis.back) - extent(basis.back)?, at.dot(basis.back) + extent(-basis.back)?);
    let is_around = at.cmpge(bounds.min).all() && at.cmple(bounds.max).all();
    if far <= 0.0 || is_around {
        return Some(true);
    }
    let (fixed, slope) = match camera.ortho_height {
        Some(height) => (0.5 * height, 0.0),
        None => (0.0, (0.5 * camera.fov_deg.to_radians()).tan()),
    };
    let sides = [(basis.right, aspect), (-basis.right, aspect), (basis.up, 1.0), (-basis.up, 1.0)];
    for (side, scale) in sides {
        // All points p have (p - at) . outward > scale * fixed.
        let outward = side + scale * slope * basis.back;
        if -extent(-outward)? - at.dot(outward) > scale * fixed {
            return Some(true);
        }
    }
    let spread = |axis: DVec3| Some(extent(axis)? + extent(-axis)?);
    let height = 2.0 * (fixed + slope * near.max(0.0).midpoint(far));
    Some(spread(basis.up)?.max(spread(basis.right)?) < SMALLEST_SEEN * height)
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec2;
    use superegg_geom::{Exponents, Superquadric, TransformStep};

    use super::*;
    use crate::camera::view::View;

    fn ball(radius: f64, at: DVec3) -> Scene {
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        scene.primitive_mut("ball").unwrap().shape =
            Superquadric::new(DVec3::splat(radius), Exponents::ROUND).unwrap();
        scene.ensure_object("all").unwrap();
        scene.add_child("all", "ball", "ball").unwrap();
        scene.transform_child("all", TransformStep::Translate(at)).unwrap();
        scene
    }

    fn compiled(scene: &Scene) -> CompiledScene {
        CompiledScene::compile(scene, Some("all"), scene.depth)
    }

    #[test]
    fn a_ball_of_any_size_anywhere_touches_the_edge_of_its_frame() {
        let size = (200, 100);
        for (radius, at) in [
            (0.001, DVec3::ZERO),
            (1e6, DVec3::ZERO),
            (3.0, DVec3::new(1e4, -50.0, 7.0)),
            (1e-9, DVec3::splat(1e-3)),
        ] {
            let mut scene = ball(radius, at);
            let compiled = compiled(&scene);
            let framing = Framing::of_unseen(&scene, &compiled, size).expect("unseen before");
            framing.apply(&mut scene);
            let view = View::new(&scene.camera, size.0, size.1);
            let sees = |x: f64, y: f64| compiled.intersect_ray(&view.ray(DVec2::new(x, y))).is_some();
            // Nine tenths of the height: from 5 to 95.
            assert!(sees(100.0, 50.0) && sees(100.0, 5.5) && sees(100.0, 94.5), "{radius}");
            assert!(!sees(100.0, 4.5) && !sees(100.0, 95.5), "{radius}");
            assert!(Framing::of_unseen(&scene, &compiled, size).is_none(), "a set camera stays");
        }
    }

    #[test]
    fn the_light_keeps_its_place_in_the_picture() {
        let frame = |radius: f64| {
            let scene = ball(radius, DVec3::ZERO);
            Framing::of(&Camera::default(), &compiled(&scene), (100, 100)).unwrap()
        };
        let (small, large) = (frame(1e-3), frame(1e3));
        let position = |light: Light| match light.kind {
            LightKind::Point { position } => position,
            LightKind::Spot { .. } | LightKind::Sun { .. } => panic!("{light:?}"),
        };
        assert!((position(small.light) * 1e6 - position(large.light)).length() < 1e-6);
        assert!((small.light.falloff / large.light.falloff / 1e12 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_scene_that_is_in_sight_stays() {
        for (radius, at) in [(1.0, DVec3::ZERO), (0.3, DVec3::new(4.0, 3.0, 0.0)), (9.0, DVec3::ZERO)] {
            let scene = ball(radius, at);
            assert_eq!(Framing::of_unseen(&scene, &compiled(&scene), (640, 480)), None, "{radius}");
        }
        let mut far = ball(1.0, DVec3::X * 1e3);
        assert!(Framing::of_unseen(&far, &compiled(&far), (640, 480)).is_some());
        far.sets_camera = true;
        assert_eq!(Framing::of_unseen(&far, &compiled(&far), (640, 480)), None);
        let empty = Scene::default();
        let nothing = CompiledScene::compile(&empty, None, 1);
        assert_eq!(Framing::of_unseen(&empty, &nothing, (640, 480)), None);
    }

    #[test]
    fn z_up_and_parallel_rays_are_framed_too() {
        let mut scene = ball(1e3, DVec3::new(5.0, 6.0, 7.0));
        scene.set_up(DVec3::Z);
        let compiled = compiled(&scene);
        let framing = Framing::of_unseen(&scene, &compiled, (100, 100)).unwrap();
        let (right, up, forward) = framing.camera.frame();
        assert_eq!((right, up, forward), (DVec3::X, DVec3::Z, DVec3::Y));
        let parallel = Camera { ortho_height: Some(1.0), ..Camera::default() };
        let framing = Framing::of(&parallel, &compiled, (100, 100)).unwrap();
        assert!((framing.camera.ortho_height.unwrap() - 2e3 / FILLED).abs() < 1e-6);
    }
}
