//! The colours of outputs that are no light.

use std::borrow::Cow;

use superegg_geom::glam::DVec3;
use superegg_scene::AmbientOcclusion;
use superegg_trace::CompiledScene;

use crate::film::buffer::Film;
use crate::film::pixel::Pixel;
use crate::settings::{Output, RenderSettings};

impl Output {
    /// The default number of rays at each point of [`Output::Occlusion`].
    const OCCLUSION_RAYS: u32 = 16;
    /// The default length of these rays, as a fraction of the diagonal of the scene's bounding box.
    const OCCLUSION_REACH: f64 = 0.25;

    /// The rays of [`Output::Occlusion`].
    pub(crate) fn occlusion(settings: &RenderSettings, scene: &CompiledScene) -> AmbientOcclusion {
        settings.environment.ambient_occlusion.unwrap_or_else(|| {
            let size = scene.bounds().map_or(0.0, |bounds| 2.0 * bounds.half_extent().length());
            let distance = if size > 0.0 && size.is_finite() { Self::OCCLUSION_REACH * size } else { 1.0 };
            AmbientOcclusion { samples: Self::OCCLUSION_RAYS, distance }
        })
    }

    /// The film with the colours of the output. Those of depth and steps depend on the range of
    /// values in the whole picture, so a film that is not complete has no final colours yet: its
    /// pixels keep plain depth, and the number of steps as their colour.
    pub fn colored(self, film: &Film) -> Cow<'_, Film> {
        self.coloring([film]).apply(film)
    }

    /// As [`Output::colored`], in place of the film.
    pub fn into_colored(self, film: Film) -> Film {
        match self.coloring([&film]) {
            OutputColoring::Same => film,
            coloring => coloring.apply(&film).into_owned(),
        }
    }

    /// The colours of a picture that these films are parts of.
    pub fn coloring<'f>(self, films: impl IntoIterator<Item = &'f Film>) -> OutputColoring {
        let films = films.into_iter();
        match self {
            Self::Light | Self::Normal | Self::Albedo | Self::Id | Self::Occlusion => OutputColoring::Same,
            Self::Depth => {
                let (least, most) = range(films.flat_map(Film::depths));
                OutputColoring::Depth { least, most }
            }
            Self::Steps => {
                let (_, most) = range(films.flat_map(Film::colors).map(|color| color[0]));
                OutputColoring::Steps { most }
            }
        }
    }
}

/// How the values of an output become colours in one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutputColoring {
    /// They are colours.
    Same,
    /// Grey by nearness.
    Depth {
        /// The least depth of the picture.
        least: f32,
        /// The largest finite depth of the picture.
        most: f32,
    },
    /// By a scale of heat.
    Steps {
        /// The largest number of steps of the picture.
        most: f32,
    },
}

impl OutputColoring {
    /// The film with the colours; it may be a part of the picture.
    pub fn apply(self, film: &Film) -> Cow<'_, Film> {
        match self {
            Self::Same => Cow::Borrowed(film),
            Self::Depth { least, most } => Cow::Owned(colored_by_depth(film, least, most)),
            Self::Steps { most } => Cow::Owned(colored_by_steps(film, most)),
        }
    }
}

/// The least and the largest finite value.
fn range(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let finite = values.filter(|value| value.is_finite());
    finite.fold((f32::INFINITY, 0f32), |(least, most), value| (least.min(value), most.max(value)))
}

/// Grey by nearness, times alpha.
fn colored_by_depth(film: &Film, least: f32, most: f32) -> Film {
    // Reciprocals: a floor that reaches the horizon would leave no contrast for near surfaces.
    let inverse = |depth: f32| depth.max(f32::MIN_POSITIVE).recip();
    recolored(film, |pixel| {
        let nearness = if most > least {
            (inverse(pixel.depth) - inverse(most)) / (inverse(least) - inverse(most))
        } else {
            1.0
        };
        // The depth of the background is infinite.
        if pixel.depth.is_finite() { [pixel.alpha * nearness; 3] } else { [0.0; 3] }
    })
}

/// The [`heat`] of the number of steps.
fn colored_by_steps(film: &Film, most: f32) -> Film {
    recolored(film, |pixel| heat(if most > 0.0 { pixel.color[0] / most } else { 0.0 }))
}

/// The film with other colours.
fn recolored(film: &Film, color: impl Fn(&Pixel) -> [f32; 3]) -> Film {
    let mut colored = film.clone();
    let positions = (0..film.height()).flat_map(|y| (0..film.width()).map(move |x| (x, y)));
    for ((x, y), pixel) in positions.zip(film.pixels()) {
        colored.set(x, y, Pixel { color: color(&pixel), ..pixel });
    }
    colored
}

/// Black for 0, then blue, red and yellow to white for 1. Luminance increases with the value.
fn heat(value: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [0.15, 0.1, 0.6], [0.8, 0.15, 0.3], [1.0, 0.7, 0.1], [1.0, 1.0, 1.0]];
    let position = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let stop = (position as usize).min(STOPS.len() - 2);
    let fraction = position - stop as f32;
    std::array::from_fn(|i| STOPS[stop][i] + fraction * (STOPS[stop + 1][i] - STOPS[stop][i]))
}

/// The colour of an instance id: bright and saturated; black for 0.
pub(crate) fn color_of_id(id: u32) -> DVec3 {
    if id == 0 {
        return DVec3::ZERO;
    }
    let mut hash = id.wrapping_mul(0x9e37_79b1);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x85eb_ca6b);
    hash ^= hash >> 13;
    // One channel is full, one is low and one is arbitrary: the colour is saturated and never dark.
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
        let colored = Output::Depth.colored(&film);
        let values = [0, 1, 2, 3].map(|x| colored.pixel(x, 0).unwrap().color[0]);
        assert_eq!(values.map(|value| (1e3 * value).round()), [1000.0, 0.0, 250.0, 0.0]);
        let one = Film::new(1, 1);
        assert_eq!(Output::Depth.colored(&one).pixel(0, 0).unwrap().color, [0.0; 3]);
    }
}
