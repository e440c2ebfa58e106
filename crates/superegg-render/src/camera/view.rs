//! The map from film positions to camera rays.

use superegg_geom::Ray;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_geom::kernels::packet::{PACKET, PacketColumn, PacketVectors64};
use superegg_scene::{Camera, Lens};
use superegg_simd::{Simd, WithSimd};
use superegg_trace::Footprint;

use crate::camera::sample::FilmSample;
use crate::camera::sobol::{SampleKey, disc};

/// The branch of a [`SampleKey`] for the position on the lens.
const LENS: u32 = 0;

/// A camera with a picture size: the map from film coordinates to rays.
///
/// ```
/// use superegg_geom::glam::{DVec2, DVec3};
/// use superegg_render::View;
/// use superegg_scene::Camera;
///
/// let view = View::new(&Camera::default(), 200, 100);
/// assert_eq!(view.ray(DVec2::new(100.0, 50.0)).direction, DVec3::NEG_Z);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct View {
    position: DVec3,
    forward: DVec3,
    /// From the camera to the top left corner of the film.
    to_corner: DVec3,
    /// The steps of one pixel to the right and down.
    pixel_right: DVec3,
    pixel_down: DVec3,
    kind: Projection,
}

/// The origins of rays.
#[derive(Clone, Copy, Debug)]
enum Projection {
    /// All rays start at the camera.
    Pinhole,
    /// Rays start on a disc with two semi-axes. All rays of a film position meet at the distance
    /// `focus`.
    Lens { right: DVec3, up: DVec3, focus: f64 },
    /// Orthographic: each ray starts at its film position; all are parallel.
    Parallel,
}

impl View {
    /// The view of a camera on a picture of `width` by `height` pixels, which are square.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let (right, up, forward) = camera.frame();
        let (width, height) = (f64::from(width), f64::from(height));
        let picture_height =
            camera.ortho_height.unwrap_or_else(|| 2.0 * (0.5 * camera.fov_deg.to_radians()).tan());
        let pixel = picture_height / height;
        let to_film = if camera.ortho_height.is_some() { DVec3::ZERO } else { forward };
        let kind = match (camera.ortho_height, camera.lens) {
            (Some(_), _) => Projection::Parallel,
            (None, Some(Lens { radius, focus })) => {
                Projection::Lens { right: radius * right, up: radius * up, focus }
            }
            (None, None) => Projection::Pinhole,
        };
        Self {
            position: camera.position,
            forward,
            to_corner: to_film + 0.5 * pixel * (height * up - width * right),
            pixel_right: pixel * right,
            pixel_down: -pixel * up,
            kind,
        }
    }

    /// The footprint of one ray of `samples` per pixel.
    pub fn footprint(&self, samples: u32) -> Footprint {
        let pixel = self.pixel_right.length() / f64::from(samples.max(1)).sqrt();
        match self.kind {
            Projection::Parallel => Footprint { width: pixel, spread: 0.0 },
            _ => Footprint { width: 0.0, spread: pixel },
        }
    }

    /// The ray through a film position, in pixels from the top left corner. The centre of the first
    /// pixel is (0.5, 0.5). For a lens, the ray passes its centre. The component of the direction
    /// along the line of sight is 1, so t is the depth.
    pub fn ray(&self, film_px: DVec2) -> Ray {
        self.lens_ray(film_px, DVec2::ZERO)
    }

    /// The ray through a film position and a position on the lens, given in the unit disc.
    pub fn lens_ray(&self, film_px: DVec2, on_lens: DVec2) -> Ray {
        let to_film = self.to_corner + film_px.x * self.pixel_right + film_px.y * self.pixel_down;
        match self.kind {
            Projection::Pinhole => Ray::new(self.position, to_film),
            Projection::Parallel => Ray::new(self.position + to_film, self.forward),
            Projection::Lens { right, up, focus } => {
                let aside = on_lens.x * right + on_lens.y * up;
                Ray::new(self.position + aside, to_film - aside / focus)
            }
        }
    }

    /// The camera ray of a sample.
    pub(crate) fn sample_ray(&self, sample: &FilmSample) -> Ray {
        if !matches!(self.kind, Projection::Lens { .. }) {
            return self.ray(sample.film_px);
        }
        let key = SampleKey::new(sample.pixel, sample.index).branch(LENS);
        self.lens_ray(sample.film_px, disc(key.point(0, 1)))
    }

    /// The position of the camera.
    pub(crate) fn position(&self) -> DVec3 {
        self.position
    }

    /// Whether all rays have one origin.
    pub(crate) fn is_pinhole(&self) -> bool {
        matches!(self.kind, Projection::Pinhole)
    }

    /// Whether the camera is orthographic.
    pub(crate) fn is_parallel(&self) -> bool {
        matches!(self.kind, Projection::Parallel)
    }

    /// The depth of a point along the line of sight.
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        (point - self.position).dot(self.forward)
    }
}

/// The directions of [`View::ray`] for at most one packet of samples of a pinhole camera. Lanes
/// beyond the last sample have no meaning.
pub(crate) struct PacketDirections<'a> {
    pub(crate) view: &'a View,
    pub(crate) samples: &'a [FilmSample],
}

impl WithSimd for PacketDirections<'_> {
    type Output = PacketVectors64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> PacketVectors64 {
        let Self { view: View { to_corner, pixel_right, pixel_down, .. }, samples } = self;
        let (mut x, mut y) = ([0.0; PACKET], [0.0; PACKET]);
        for ((x, y), sample) in x.iter_mut().zip(&mut y).zip(samples) {
            (*x, *y) = sample.film_px.into();
        }
        // Plain loops, which the compiler vectorises.
        let mut directions = [PacketColumn::splat(0.0); 3];
        for (axis, column) in directions.iter_mut().enumerate() {
            let (corner, right, down) = (to_corner[axis], pixel_right[axis], pixel_down[axis]);
            for lane in 0..PACKET {
                column.0[lane] = corner + x[lane] * right + y[lane] * down;
            }
        }
        directions
    }
}

#[cfg(test)]
mod tests {
    use superegg_simd::Arch;

    use super::*;
    use superegg_trace::packet::direction;

    #[test]
    fn corners_and_centre_of_the_default_camera() {
        let view = View::new(&Camera::default(), 200, 100);
        let half_height = 30f64.to_radians().tan();
        let close = |film: (f64, f64), expected: DVec3| {
            let ray = view.ray(film.into());
            assert!((ray.direction - expected).length() < 1e-12, "{film:?}: {:?}", ray.direction);
        };
        close((100.0, 50.0), DVec3::NEG_Z);
        close((0.0, 0.0), DVec3::new(-2.0 * half_height, half_height, -1.0));
        close((200.0, 100.0), DVec3::new(2.0 * half_height, -half_height, -1.0));
    }

    #[test]
    fn directions_of_packets_are_those_of_rays() {
        let camera = Camera { position: DVec3::new(3.0, -7.0, 2.0), up: DVec3::Z, ..Camera::default() };
        let view = View::new(&camera, 200, 100);
        for count in [PACKET, 5] {
            let sample = |i: usize| FilmSample {
                pixel: (0, 0),
                index: 0,
                film_px: DVec2::new(17.3 * i as f64, 99.0 - 3.7 * i as f64),
            };
            let samples: Vec<FilmSample> = (0..count).map(sample).collect();
            let directions = Arch::new().dispatch(PacketDirections { view: &view, samples: &samples });
            for (lane, sample) in samples.iter().enumerate() {
                assert_eq!(direction(&directions, lane), view.ray(sample.film_px).direction);
            }
        }
    }

    #[test]
    fn the_rays_of_a_lens_meet_in_the_plane_of_focus_and_those_of_an_orthographic_camera_nowhere() {
        let lens = Camera { lens: Some(Lens { radius: 0.5, focus: 4.0 }), ..Camera::default() };
        let view = View::new(&lens, 200, 100);
        let film = DVec2::new(31.0, 77.0);
        let middle = view.ray(film);
        assert_eq!(middle.origin, lens.position);
        for on_lens in [DVec2::X, DVec2::NEG_Y, DVec2::new(0.3, -0.6)] {
            let ray = view.lens_ray(film, on_lens);
            assert!(((ray.origin - lens.position).length() - 0.5 * on_lens.length()).abs() < 1e-12);
            assert!((ray.point_at(4.0) - middle.point_at(4.0)).length() < 1e-12);
        }
        let flat = Camera { ortho_height: Some(10.0), ..Camera::default() };
        let view = View::new(&flat, 200, 100);
        let (first, last) = (view.ray(DVec2::ZERO), view.ray(DVec2::new(200.0, 100.0)));
        assert_eq!([first.direction, last.direction], [DVec3::NEG_Z; 2]);
        assert_eq!([first.origin, last.origin], [DVec3::new(-10.0, 5.0, 10.0), DVec3::new(10.0, -5.0, 10.0)]);
    }
}
