//! What a picture shows instead of light.

use std::borrow::Cow;

use superegg_geom::glam::DVec3;
use superegg_scene::{AmbientOcclusion, Filter, Picture};
use superegg_trace::CompiledScene;

use crate::film::{Film, Pixel};
use crate::render::{RenderSettings, Surroundings};

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shows {
    /// Light.
    #[default]
    Light,
    /// The normals of what is seen first: 0.5 + 0.5 n of each part.
    Normal,
    /// How near what is seen first is: white the nearest, black the farthest in the picture.
    Depth,
    /// A colour for each instance, the same in each picture of the scene.
    Id,
    /// The work of a camera ray: boxes and shapes that the exact traversal asks, from black for none over blue and red to white for the most in
    /// the picture.
    Steps,
    /// The share of rays to all sides that get away from a point, by the scene's ambient occlusion, or 16 rays as far as a quarter of the scene's
    /// size.
    Occlusion,
}

impl Shows {
    /// Rays for each point where the scene has no ambient occlusion.
    const OCCLUSION_RAYS: u32 = 16;
    /// Their length, as a part of the diagonal of the scene's box.
    const OCCLUSION_REACH: f64 = 0.25;

    /// The settings with all taken away that makes no difference to what is shown. Numbers are not filtered across pixels.
    pub(crate) fn stripped(self, settings: &RenderSettings) -> RenderSettings {
        if self == Self::Light {
            return settings.clone();
        }
        let picture = settings.picture;
        let noise = if self == Self::Occlusion { picture.noise } else { 0.0 };
        let filter = if self == Self::Occlusion { picture.filter } else { Filter::Box };
        RenderSettings {
            // Numbers of steps are asked for everywhere, where nothing is too.
            picture: Picture {
                noise,
                filter,
                bounces: 0,
                transparent: picture.transparent && self != Self::Steps,
                ..picture
            },
            surroundings: Surroundings {
                lights: Vec::new(),
                background: DVec3::ZERO,
                sky: None,
                floor: settings.surroundings.floor.clone(),
                ambient_occlusion: None,
            },
            ..settings.clone()
        }
    }

    /// The rays of [`Shows::Occlusion`].
    pub(crate) fn occlusion(settings: &RenderSettings, scene: &CompiledScene) -> AmbientOcclusion {
        settings.surroundings.ambient_occlusion.unwrap_or_else(|| {
            let size = scene.bounds().map_or(0.0, |bounds| 2.0 * bounds.half_extent().length());
            let distance = if size > 0.0 && size.is_finite() { Self::OCCLUSION_REACH * size } else { 1.0 };
            AmbientOcclusion { samples: Self::OCCLUSION_RAYS, distance }
        })
    }

    /// Whether values are made visible by their range in the whole picture.
    fn is_by_range(self) -> bool {
        matches!(self, Self::Depth | Self::Steps)
    }

    /// The film with the colours that are looked at. Until all of a film is made, the range of depth or of steps is not known: their film has
    /// plain depth, and plain numbers as its colour.
    pub fn colored(self, film: &Film) -> Cow<'_, Film> {
        if !self.is_by_range() {
            return Cow::Borrowed(film);
        }
        let value = |pixel: Pixel| if self == Self::Depth { pixel.depth } else { pixel.color[0] };
        let values = || film.pixels().map(value).filter(|value| value.is_finite());
        let (least, most) = values().fold((f32::INFINITY, 0f32), |(l, m), v| (l.min(v), m.max(v)));
        let mut colored = film.clone();
        for (x, y) in (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y))) {
            let pixel = film.pixel(x, y);
            let color = if self == Self::Depth {
                // By the reciprocal: a floor that goes to the horizon would leave nothing for what is near.
                let inverse = |depth: f32| depth.max(f32::MIN_POSITIVE).recip();
                let nearness = if most > least {
                    (inverse(pixel.depth) - inverse(most)) / (inverse(least) - inverse(most))
                } else {
                    1.0
                };
                // Nothing is at infinity.
                if pixel.depth.is_finite() { [pixel.alpha * nearness; 3] } else { [0.0; 3] }
            } else {
                heat(if most > 0.0 { value(pixel) / most } else { 0.0 })
            };
            colored.set(x, y, Pixel { color, ..pixel });
        }
        Cow::Owned(colored)
    }
}

/// Black for 0 over blue, red and yellow to white for 1; brighter is always more.
fn heat(value: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [0.15, 0.1, 0.6], [0.8, 0.15, 0.3], [1.0, 0.7, 0.1], [1.0, 1.0, 1.0]];
    let place = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let stop = (place as usize).min(STOPS.len() - 2);
    let share = place - stop as f32;
    std::array::from_fn(|i| STOPS[stop][i] + share * (STOPS[stop + 1][i] - STOPS[stop][i]))
}

/// A bright colour for a number that differs from instance to instance, black for 0.
pub(crate) fn color_of_id(id: u32) -> DVec3 {
    if id == 0 {
        return DVec3::ZERO;
    }
    let mut hash = id.wrapping_mul(0x9e37_79b1);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca6b);
    hash ^= hash >> 13;
    // Of the three parts one is full, one low, and one anything: saturated, and never dark.
    let turn = f64::from(hash & 0xffff) / 65536.0 * 6.0;
    let pale = 0.45 * f64::from(hash >> 16 & 0xff) / 255.0;
    let part = |middle: f64| {
        let away = (turn - middle).abs();
        (2.0 - away.min(6.0 - away)).clamp(0.0, 1.0)
    };
    let hue = DVec3::new(part(0.0), part(2.0), part(4.0));
    let bright = 1.0 - 0.35 * f64::from(hash >> 24 & 0xff) / 255.0;
    bright * (DVec3::splat(pale) + (1.0 - pale) * hue)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_have_colours_that_can_be_told_apart() {
        assert_eq!(color_of_id(0), DVec3::ZERO);
        let colors: Vec<DVec3> = (1..200).map(color_of_id).collect();
        assert!(colors.iter().all(|color| color.max_element() >= 0.6 && color.max_element() <= 1.0));
        let pairs = colors.windows(2).filter(|pair| (pair[0] - pair[1]).length() > 0.1);
        assert!(pairs.count() > 180);
    }

    #[test]
    fn heat_rises_with_what_it_shows() {
        let luminance = |[r, g, b]: [f32; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let values: Vec<f32> = (0..=100).map(|i| luminance(heat(i as f32 / 100.0))).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!((heat(0.0), heat(1.0), heat(f32::NAN)[0].is_nan()), ([0.0; 3], [1.0; 3], true));
    }

    #[test]
    fn depth_goes_from_white_to_black_over_the_picture() {
        let mut film = Film::new(4, 1);
        for (x, depth) in [2.0, 6.0, 4.0, f32::INFINITY].into_iter().enumerate() {
            film.set(x as u32, 0, Pixel { depth, alpha: 1.0, ..Pixel::EMPTY });
        }
        let colored = Shows::Depth.colored(&film);
        let values = [0, 1, 2, 3].map(|x| colored.pixel(x, 0).color[0]);
        assert_eq!(values.map(|value| (1e3 * value).round()), [1000.0, 0.0, 250.0, 0.0]);
        let one = Film::new(1, 1);
        assert_eq!(Shows::Depth.colored(&one).pixel(0, 0).color, [0.0; 3]);
    }
}
