//! Primitives: a superquadric with a material.

use std::sync::Arc;

use superegg_geom::Superquadric;
use superegg_geom::glam::DVec3;

use crate::texture::Textures;

/// The tessellation of a primitive in the preview.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patches {
    /// Patches around (longitude), > 0.
    pub u: u32,
    /// Patches from pole to pole (latitude), > 0.
    pub v: u32,
}

/// A parameter of a material that is one number in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialWeight {
    /// The weight of ambient light.
    Ambient,
    /// The weight of reflected light.
    Reflected,
    /// The weight of transmitted light.
    Refracted,
    /// Roughness of the highlight: smaller is sharper.
    Gloss,
    /// The weight of diffuse light.
    Diffuse,
    /// The weight of the specular highlight.
    Specular,
    /// The roughness of the facets of the surface.
    Roughness,
    /// The part of the surface that is metal.
    Metallic,
}

/// A procedural second colour, in the primitive's own space (for a floor: in its plane, from the
/// origin).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pattern {
    /// The base colour everywhere.
    #[default]
    None,
    /// A 3D checkerboard; the cube that begins at the origin has the base colour.
    Checker {
        /// The other linear colour.
        color: DVec3,
        /// The edge length of a cube, above 0.
        size: f64,
    },
    /// A gradient from the base colour to another along a direction, across the whole shape (on a
    /// floor: a triangle wave, one unit each way).
    Gradient {
        /// The linear colour at the far end.
        color: DVec3,
        /// The direction of the gradient; not zero, of any length.
        direction: DVec3,
    },
    /// Clouds of both colours.
    Noise {
        /// The other linear colour.
        color: DVec3,
        /// The size of the largest clouds, above 0.
        size: f64,
    },
    /// Veins across the x axis, as of marble.
    Marble {
        /// The linear colour of the veins.
        color: DVec3,
        /// The distance of the veins, above 0.
        size: f64,
    },
    /// Rings around the z axis, as of wood.
    Wood {
        /// The linear colour of late wood.
        color: DVec3,
        /// The width of a ring, above 0.
        size: f64,
    },
}

impl Pattern {
    /// The other linear colour; `None` for no pattern.
    pub fn color(&self) -> Option<DVec3> {
        match *self {
            Self::None => None,
            Self::Checker { color, .. }
            | Self::Gradient { color, .. }
            | Self::Noise { color, .. }
            | Self::Marble { color, .. }
            | Self::Wood { color, .. } => Some(color),
        }
    }

    /// The word of the pattern in the language.
    pub fn word(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Checker { .. } => "checker",
            Self::Gradient { .. } => "gradient",
            Self::Noise { .. } => "noise",
            Self::Marble { .. } => "marble",
            Self::Wood { .. } => "wood",
        }
    }

    /// The size of a pattern that has one.
    pub fn size(&self) -> Option<f64> {
        match *self {
            Self::None | Self::Gradient { .. } => None,
            Self::Checker { size, .. }
            | Self::Noise { size, .. }
            | Self::Marble { size, .. }
            | Self::Wood { size, .. } => Some(size),
        }
    }
}

/// The material of a surface. Colours are linear values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The base colour, each channel in [0, 1].
    pub color: DVec3,
    /// The weight of ambient light, [0, 1].
    pub ambient: f64,
    /// The weight of reflected light, [0, 1]. `None` if the scene does not set it: then nothing is
    /// reflected, although the course program shows [`Material::UNSET_REFLECTED`].
    pub reflected: Option<f64>,
    /// The weight of transmitted light, [0, 1]; `None` likewise, shown as
    /// [`Material::UNSET_REFRACTED`].
    pub refracted: Option<f64>,
    /// The roughness of the highlight, [0, 1]; smaller is sharper.
    pub gloss: f64,
    /// The weight of diffuse light, [0, 1].
    pub diffuse: f64,
    /// The weight of the specular highlight, [0, 1].
    pub specular: f64,
    /// The index of refraction, 1 to 4.
    pub index: f64,
    /// The exponent of the highlight; derived from `gloss` if `None`.
    pub shininess: Option<f64>,
    /// Whether the reflected weight is scaled by the Fresnel reflectance of `index`: little at
    /// normal incidence, all at grazing angles.
    pub fresnel: bool,
    /// The absorption coefficient inside, for each channel, >= 0, per world unit: after a distance
    /// d the transmittance is `exp(-absorb * d)`.
    pub absorb: DVec3,
    /// The light that the surface gives off, in multiples of its colour, >= 0. It is seen as it is; with
    /// [`LightModel::Path`](crate::LightModel) it lights other surfaces, too.
    pub emission: f64,
    /// The roughness of the facets of the surface, [0, 1]; `None` for a surface without facets. For
    /// [`LightModel::Path`](crate::LightModel) alone.
    pub roughness: Option<f64>,
    /// The part of the surface that is metal, [0, 1], whose reflectance is the colour. For
    /// [`LightModel::Path`](crate::LightModel) alone.
    pub metallic: f64,
    /// The procedural second colour.
    pub pattern: Pattern,
}

impl Material {
    /// The reflected weight that the course program shows if none is set. It is not used.
    pub const UNSET_REFLECTED: f64 = 0.3;
    /// The same for the transmitted weight.
    pub const UNSET_REFRACTED: f64 = 0.5;
    /// The lower bound of gloss in the exponent, which grows as its inverse square.
    const LEAST_GLOSS: f64 = 0.01;

    /// Sets one parameter; the value is in [0, 1].
    pub fn set_weight(&mut self, weight: MaterialWeight, value: f64) {
        match weight {
            MaterialWeight::Ambient => self.ambient = value,
            MaterialWeight::Reflected => self.reflected = Some(value),
            MaterialWeight::Refracted => self.refracted = Some(value),
            MaterialWeight::Gloss => self.gloss = value,
            MaterialWeight::Diffuse => self.diffuse = value,
            MaterialWeight::Specular => self.specular = value,
            MaterialWeight::Roughness => self.roughness = Some(value),
            MaterialWeight::Metallic => self.metallic = value,
        }
    }

    /// The roughness of the facets that [`LightModel::Path`](crate::LightModel) shades: a metal of no stated roughness is
    /// smooth. `None` for a surface without facets.
    pub fn facet_roughness(&self) -> Option<f64> {
        self.roughness.or_else(|| (self.metallic > 0.0).then_some(0.0))
    }

    /// The exponent of the highlight: `shininess` if set, else `2 / gloss^2 - 2` with gloss at
    /// least 0.01.
    ///
    /// At the default gloss of 0.3 it is 20, as measured on the reference image of the course; at 1
    /// the highlight covers the hemisphere.
    pub fn highlight_exponent(&self) -> f64 {
        let gloss = self.gloss.max(Self::LEAST_GLOSS);
        self.shininess.unwrap_or(2.0 / (gloss * gloss) - 2.0)
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            color: DVec3::ONE,
            ambient: 0.1,
            reflected: None,
            refracted: None,
            gloss: 0.3,
            diffuse: 0.8,
            specular: 0.1,
            index: 1.5,
            shininess: None,
            fresnel: false,
            absorb: DVec3::ZERO,
            emission: 0.0,
            roughness: None,
            metallic: 0.0,
            pattern: Pattern::None,
        }
    }
}

/// A superquadric with its material.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// The shape, centred at the origin of the primitive's own space.
    pub shape: Superquadric,
    /// The tessellation in the preview.
    pub patches: Patches,
    /// The material.
    pub material: Material,
    /// Pictures on the surface; `None` for none.
    pub textures: Option<Arc<Textures>>,
}

impl Default for Primitive {
    fn default() -> Self {
        Self {
            shape: Superquadric::unit_sphere(),
            patches: Patches { u: 15, v: 15 },
            material: Material::default(),
            textures: None,
        }
    }
}
