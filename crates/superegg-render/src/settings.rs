//! The settings of a render: picture, camera, environment and output.

use std::sync::Arc;

use superegg_geom::glam::DVec3;
use superegg_scene::{
    AmbientOcclusion, Camera, EnvironmentLight, EnvironmentPicture, Filter, Floor, Light, LightModel,
    Material, Picture, Scene, Sky, Tone,
};
use thiserror::Error;

use crate::environment::map::{EnvironmentMap, EnvironmentPixels};
use crate::film::buffer::Film;
use crate::film::develop::Development;
use crate::texture::set::TextureSet;

/// The quantity that a picture has: light, or one of the other outputs (AOVs).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Output {
    /// Light.
    #[default]
    Light,
    /// The normal of the first surface: 0.5 + 0.5 n for each component.
    Normal,
    /// The nearness of the first surface: white is the nearest, black the farthest in the picture.
    Depth,
    /// The colour of the first surface, without light.
    Albedo,
    /// One colour for each instance, the same in every picture of the scene.
    Id,
    /// The cost of a camera ray: the boxes and shapes that the scalar traversal tests. Black is 0,
    /// then blue, red and yellow; white is the largest number in the picture.
    Steps,
    /// The fraction of rays from the surface to all sides that hit nothing, by the ambient
    /// occlusion of the scene, or by 16 rays as long as a quarter of the scene.
    Occlusion,
}

impl Output {
    /// All outputs.
    pub const ALL: [Self; 7] =
        [Self::Light, Self::Normal, Self::Depth, Self::Albedo, Self::Id, Self::Steps, Self::Occlusion];

    /// The word for the output, such as `normal`.
    ///
    /// ```
    /// use superegg_render::Output;
    /// assert_eq!(Output::of_word("normal"), Some(Output::Normal));
    /// assert!(Output::ALL.iter().all(|output| Output::of_word(output.word()) == Some(*output)));
    /// ```
    pub fn word(self) -> &'static str {
        match self {
            Self::Light => "light",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Albedo => "albedo",
            Self::Id => "id",
            Self::Steps => "steps",
            Self::Occlusion => "occlusion",
        }
    }

    /// The output of a word.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|output| output.word() == word)
    }
}

/// The settings that determine a picture. Equal settings give bit-identical pictures for any
/// [`crate::RenderOptions`].
///
/// ```
/// use superegg_render::{Output, RenderSettings};
/// use superegg_scene::{Picture, Scene};
///
/// let picture = Picture { width: 64, height: 48, samples: 1, ..Picture::default() };
/// let settings = RenderSettings::of(&Scene::default()).with_picture(picture).with_output(Output::Normal);
/// assert!(settings.validate().is_ok());
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderSettings {
    /// Size and quality.
    pub picture: Picture,
    /// The camera.
    pub camera: Camera,
    /// Lights, sky and floor.
    pub environment: Environment,
    /// The quantity that the picture has.
    pub output: Output,
    /// Whether the film keeps depth, normals, albedo and instance ids beside light. They cost some
    /// time and two and a half times the memory.
    pub layers: bool,
    /// The pictures on surfaces, set by whoever reads the files ([`TextureSet::of`]).
    pub textures: TextureSet,
}

/// The environment of the objects of a scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Environment {
    /// The lights.
    pub lights: Vec<Light>,
    /// The linear colour of rays that hit nothing, unless there is a sky.
    pub background: DVec3,
    /// The colour of rays that hit nothing, by their direction.
    pub sky: Option<Sky>,
    /// An infinite plane and its material.
    pub floor: Option<(Floor, Material)>,
    /// Ambient occlusion; `None` for none.
    pub ambient_occlusion: Option<AmbientOcclusion>,
    /// Light from far away in all directions, which replaces sky and background. [`Environment::of`] has that of
    /// daylight; a picture in a file is set by whoever reads the file.
    pub map: Option<EnvironmentMap>,
}

impl Environment {
    /// The environment that a scene describes. The default light of a scene that names none does not shine on paths that
    /// have light from far away.
    pub fn of(scene: &Scene) -> Self {
        let by_paths = scene.picture.light_model == LightModel::Path;
        let is_lit_by_surroundings =
            by_paths && scene.environment.is_some() && scene.named_lights().len() == 0;
        Self {
            lights: if is_lit_by_surroundings { Vec::new() } else { scene.lights() },
            background: scene.background,
            sky: scene.sky,
            floor: scene.floor.clone().map(|floor| (floor, scene.floor_material())),
            ambient_occlusion: scene.ambient_occlusion,
            map: match &scene.environment {
                Some(EnvironmentLight::Daylight(daylight)) => {
                    Some(EnvironmentMap::of_daylight(daylight, scene.up()))
                }
                Some(EnvironmentLight::Picture(_)) | None => None,
            },
        }
    }

    /// Replaces the light from far away.
    #[must_use]
    pub fn with_map(self, map: EnvironmentMap) -> Self {
        Self { map: Some(map), ..self }
    }

    /// Replaces the lights.
    #[must_use]
    pub fn with_lights(self, lights: Vec<Light>) -> Self {
        Self { lights, ..self }
    }
}

/// A setting that no picture can have.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{name} is {found}; expected {expected}")]
#[non_exhaustive]
pub struct SettingsError {
    /// The setting, such as "the picture's width".
    pub name: &'static str,
    /// Its value.
    pub found: String,
    /// The values that it can have.
    pub expected: &'static str,
}

/// An error unless the value is in range.
fn check(
    is_valid: bool,
    name: &'static str,
    found: impl std::fmt::Display,
    expected: &'static str,
) -> Result<(), SettingsError> {
    if is_valid { Ok(()) } else { Err(SettingsError { name, found: found.to_string(), expected }) }
}

impl RenderSettings {
    /// The picture that a scene describes: light, with layers.
    pub fn of(scene: &Scene) -> Self {
        Self {
            picture: scene.picture,
            camera: scene.camera,
            environment: Environment::of(scene),
            output: Output::Light,
            layers: true,
            textures: TextureSet::default(),
        }
    }

    /// Replaces the pictures on surfaces.
    #[must_use]
    pub fn with_textures(self, textures: TextureSet) -> Self {
        Self { textures, ..self }
    }

    /// Replaces size and quality.
    #[must_use]
    pub fn with_picture(self, picture: Picture) -> Self {
        Self { picture, ..self }
    }

    /// Replaces the camera.
    #[must_use]
    pub fn with_camera(self, camera: Camera) -> Self {
        Self { camera, ..self }
    }

    /// Replaces lights, sky and floor.
    #[must_use]
    pub fn with_environment(self, environment: Environment) -> Self {
        Self { environment, ..self }
    }

    /// Replaces the light from far away by the picture of the surroundings that a scene names; other settings, and those of
    /// a scene that names none, stay. `read` gets the pixels of the file.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn with_surroundings<P: Into<Arc<EnvironmentPixels>>, E>(
        self,
        scene: &Scene,
        read: impl FnOnce(&EnvironmentPicture) -> Result<P, E>,
    ) -> Result<Self, E> {
        let Some(EnvironmentLight::Picture(picture)) = &scene.environment else { return Ok(self) };
        let map = EnvironmentMap::new(read(picture)?.into(), scene.up(), picture.rotation_deg, picture.scale);
        Ok(Self { environment: self.environment.with_map(map), ..self })
    }

    /// Replaces the quantity that the picture has.
    #[must_use]
    pub fn with_output(self, output: Output) -> Self {
        Self { output, ..self }
    }

    /// Sets whether the film keeps depth, normals, albedo and instance ids.
    #[must_use]
    pub fn with_layers(self, layers: bool) -> Self {
        Self { layers, ..self }
    }

    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let Picture { width, height, samples, noise, exposure, bits, least_weight, .. } = self.picture;
        const SIDE: &str = "1 to 32768 pixels";
        let is_side = |side| (1..=Picture::LONGEST_SIDE).contains(&side);
        check(is_side(width), "the picture's width", width, SIDE)?;
        check(is_side(height), "the picture's height", height, SIDE)?;
        let pixels = u64::from(width) * u64::from(height);
        check(Picture::is_size(width, height), "the picture's size", pixels, "at most 134217728 pixels")?;
        let is_samples = (1..=Picture::MOST_SAMPLES).contains(&samples);
        check(is_samples, "the number of samples", samples, "1 to 65536")?;
        check(noise >= 0.0 && noise.is_finite(), "the noise threshold", noise, "a finite number >= 0")?;
        check(exposure.is_finite(), "the exposure", exposure, "a finite number of stops")?;
        check(matches!(bits, 8 | 16), "the bits of a channel", bits, "8 or 16")?;
        check(least_weight >= 0.0, "the least weight of a ray", least_weight, "a number >= 0")?;
        self.validate_camera()?;
        self.validate_environment()
    }

    fn validate_camera(&self) -> Result<(), SettingsError> {
        const POINT: &str = "three finite numbers";
        const LENGTH: &str = "a finite number > 0";
        let is_length = |length: f64| length > 0.0 && length.is_finite();
        let Camera { position, target, up, fov_deg, ortho_height, lens } = self.camera;
        check(position.is_finite(), "the camera's position", position, POINT)?;
        check(target.is_finite(), "the camera's target", target, POINT)?;
        check(up.is_finite(), "the camera's up direction", up, POINT)?;
        let is_fov = fov_deg > 0.0 && fov_deg < 180.0;
        check(is_fov, "the camera's field of view", fov_deg, "more than 0 and less than 180 degrees")?;
        if let Some(height) = ortho_height {
            check(is_length(height), "the camera's orthographic height", height, LENGTH)?;
        }
        if let Some(lens) = lens {
            let is_radius = lens.radius >= 0.0 && lens.radius.is_finite();
            check(is_radius, "the lens radius", lens.radius, "a finite number >= 0")?;
            check(is_length(lens.focus), "the focus distance", lens.focus, LENGTH)?;
        }
        Ok(())
    }

    fn validate_environment(&self) -> Result<(), SettingsError> {
        let Environment { lights, background, ambient_occlusion, .. } = &self.environment;
        for Light { color, falloff, radius, .. } in lights {
            check(color.is_finite(), "a light's colour", color, "three finite numbers")?;
            let is_falloff = *falloff >= 0.0 && falloff.is_finite();
            check(is_falloff, "a light's attenuation", falloff, "a finite number >= 0")?;
            let is_radius = *radius >= 0.0 && radius.is_finite();
            check(is_radius, "a light's radius", radius, "a finite number >= 0")?;
        }
        check(background.is_finite(), "the background", background, "three finite numbers")?;
        if let Some(AmbientOcclusion { distance, .. }) = ambient_occlusion {
            check(*distance > 0.0, "the distance of ambient occlusion", distance, "a number > 0")?;
        }
        Ok(())
    }

    /// How the film becomes a picture file, after [`Output::colored`].
    pub fn development(&self) -> Development {
        match self.output {
            Output::Light => Development::of(&self.picture),
            Output::Albedo => {
                Development { exposure: 0.0, tone: Tone::None, ..Development::of(&self.picture) }
            }
            _ => Development::undeveloped(&self.picture),
        }
    }

    /// Whether the film keeps depth, normals, albedo and ids; a picture of depth needs them.
    pub fn keeps_layers(&self) -> bool {
        self.layers || self.output == Output::Depth
    }

    /// Whether the film keeps the parts of light apart ([`Film::passes`]): light by paths with layers has them.
    pub fn keeps_passes(&self) -> bool {
        self.layers && self.output == Output::Light && self.picture.light_model == LightModel::Path
    }

    /// Whether the film keeps mattes ([`Film::matte`]): pictures with layers have them if their settings ask for them.
    pub fn keeps_mattes(&self) -> bool {
        self.layers && self.picture.cryptomatte
    }

    /// An empty film for the picture.
    pub fn film(&self) -> Film {
        let Picture { width, height, .. } = self.picture;
        if !self.keeps_layers() {
            return Film::without_layers(width, height);
        }
        Film::new(width, height).keeping(self.keeps_passes(), self.keeps_mattes())
    }

    /// The settings without what makes no difference to the output. Outputs that are no light are
    /// not filtered across pixels.
    pub(crate) fn for_output(&self) -> Self {
        let (output, picture) = (self.output, self.picture);
        if output == Output::Light {
            return self.clone();
        }
        let is_occlusion = output == Output::Occlusion;
        let picture = Picture {
            noise: if is_occlusion { picture.noise } else { 0.0 },
            filter: if is_occlusion { picture.filter } else { Filter::Box },
            bounces: 0,
            // Rays that hit nothing have a cost too.
            transparent: picture.transparent && output != Output::Steps,
            ..picture
        };
        let environment = Environment {
            lights: Vec::new(),
            background: DVec3::ZERO,
            sky: None,
            floor: self.environment.floor.clone(),
            ambient_occlusion: None,
            map: None,
        };
        Self { picture, environment, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use superegg_scene::Lens;

    use super::*;

    #[test]
    fn invalid_settings_are_errors_that_name_the_value() {
        let valid = RenderSettings::of(&Scene::default());
        assert_eq!(valid.validate(), Ok(()));
        type Case = (fn(&mut RenderSettings), &'static str);
        let cases: [Case; 13] = [
            (|s| s.picture.width = 0, "the picture's width is 0; expected 1 to 32768 pixels"),
            (|s| s.picture.height = 40_000, "the picture's height is 40000"),
            (|s| (s.picture.width, s.picture.height) = (32_768, 32_768), "the picture's size is 1073741824"),
            (|s| s.picture.samples = 0, "the number of samples is 0"),
            (|s| s.picture.noise = f64::NAN, "the noise threshold is NaN"),
            (|s| s.picture.exposure = f64::INFINITY, "the exposure is inf"),
            (|s| s.picture.bits = 9, "the bits of a channel is 9; expected 8 or 16"),
            (|s| s.picture.least_weight = -1.0, "the least weight of a ray is -1"),
            (|s| s.camera.fov_deg = f64::NAN, "the camera's field of view is NaN"),
            (|s| s.camera.position.x = f64::NAN, "the camera's position is [NaN, 0, 10]"),
            (|s| s.camera.ortho_height = Some(0.0), "the camera's orthographic height is 0"),
            (|s| s.camera.lens = Some(Lens { radius: 1.0, focus: 0.0 }), "the focus distance is 0"),
            (|s| s.environment.lights[0].radius = -1.0, "a light's radius is -1"),
        ];
        for (change, message) in cases {
            let mut settings = valid.clone();
            change(&mut settings);
            let error = settings.validate().unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
