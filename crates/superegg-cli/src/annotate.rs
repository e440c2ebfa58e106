//! Annotations of finished pictures: the legend of coloured data, and a scale bar.

mod canvas;
mod glyphs;
mod legend;
mod round;
mod scale_bar;

use anyhow::{Context, Result};
use superegg_render::{Development, EncodedPicture, Film, Output, PictureNote, RenderSettings};
use superegg_scene::Tone;

use canvas::Canvas;
pub(crate) use legend::Legend;
use scale_bar::ScaleBar;

/// The annotations of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Annotations {
    pub(crate) legend: Option<Legend>,
    pub(crate) scale_bar: bool,
}

impl Annotations {
    /// Checks that a picture of these settings can have the annotations.
    ///
    /// # Errors
    /// There is no scale at the camera's target.
    pub(crate) fn check(&self, settings: &RenderSettings) -> Result<()> {
        self.scale_bar(settings).map(|_| ())
    }

    /// The scale bar, if there is one.
    fn scale_bar(&self, settings: &RenderSettings) -> Result<Option<ScaleBar>> {
        if !self.scale_bar {
            return Ok(None);
        }
        let size = [settings.picture.width, settings.picture.height].map(f64::from);
        let found = ScaleBar::of(&settings.camera, size);
        found.map(Some).context("--scale-bar has no length, because the camera stands at its target")
    }

    /// A film as a PNG file, with the annotations.
    ///
    /// # Errors
    /// The encoder fails, or there is no scale at the camera's target.
    pub(crate) fn png(
        &self,
        film: &Film,
        settings: &RenderSettings,
        notes: &[PictureNote],
    ) -> Result<Vec<u8>> {
        let mut picture = settings.development().encode(&settings.output.colored(film));
        self.draw(&mut picture, settings)?;
        Ok(picture.png(notes)?)
    }

    fn draw(&self, picture: &mut EncodedPicture, settings: &RenderSettings) -> Result<()> {
        let mut canvas = Canvas::new(picture, has_light_background(settings));
        if let Some(legend) = &self.legend {
            let development = Development { exposure: 0.0, tone: Tone::None, ..settings.development() };
            legend.draw(&mut canvas, &development);
        }
        if let Some(bar) = self.scale_bar(settings)? {
            bar.draw(&mut canvas);
        }
        Ok(())
    }
}

/// Whether dark texts are easier to read on the background of a picture.
fn has_light_background(settings: &RenderSettings) -> bool {
    if settings.output != Output::Light {
        return false;
    }
    if settings.picture.transparent {
        return true;
    }
    let environment = &settings.environment;
    let color = environment.sky.map_or(environment.background, |sky| sky.horizon);
    let [r, g, b] = settings.development().value(color.as_vec3().to_array());
    0.299 * r + 0.587 * g + 0.114 * b > 0.5
}
