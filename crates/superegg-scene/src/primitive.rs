//! Primitives: a superquadric and what its surface is like.

use superegg_geom::Superquadric;
use superegg_geom::glam::DVec3;

/// How finely the preview cuts a primitive into patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patches {
    /// Patches around (longitude), > 0.
    pub u: u32,
    /// Patches from pole to pole (latitude), > 0.
    pub v: u32,
}

/// A share of a surface's light that a scene sets as one number in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialShare {
    /// Ambient light.
    Ambient,
    /// Mirrored light.
    Reflected,
    /// Transmitted light.
    Refracted,
    /// Roughness of the highlight: smaller is sharper.
    Gloss,
    /// Diffuse light.
    Diffuse,
    /// The highlight.
    Specular,
}

/// A second colour on a surface, in coordinates of the primitive's own space (for a floor: along it, from the origin).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pattern {
    /// One colour throughout.
    #[default]
    None,
    /// Cubes of two colours by turns; the one that begins at the origin has the base colour.
    Checker {
        /// The other linear colour.
        color: DVec3,
        /// The edge of a cube, above 0.
        size: f64,
    },
    /// From the base colour over into another along a direction, across the whole shape (a floor: to and fro, one unit each way).
    Gradient {
        /// The linear colour at the far end.
        color: DVec3,
        /// The direction in the primitive's own space; not zero, of any length.
        direction: DVec3,
    },
}

/// What a surface is like. Colours are linear values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Base colour, each part in [0, 1].
    pub color: DVec3,
    /// Share of ambient light, [0, 1].
    pub ambient: f64,
    /// Share of mirrored light, [0, 1]; `None` where the scene does not set it: then nothing is mirrored, though the old
    /// program shows [`Material::UNSET_REFLECTED`].
    pub reflected: Option<f64>,
    /// Share of transmitted light, [0, 1]; `None` likewise, shown as [`Material::UNSET_REFRACTED`].
    pub refracted: Option<f64>,
    /// Roughness of the highlight, [0, 1]; smaller is sharper.
    pub gloss: f64,
    /// Diffuse share, [0, 1].
    pub diffuse: f64,
    /// Highlight share, [0, 1].
    pub specular: f64,
    /// Index of refraction, 1 to 4.
    pub index: f64,
    /// An explicit exponent of the highlight, instead of what `gloss` gives.
    pub shininess: Option<f64>,
    /// Whether the mirrored share counts only as far as Fresnel's reflectance of the index goes: little head-on, all at grazing angles.
    pub fresnel: bool,
    /// What the inside takes away of light let through, each part >= 0, per world unit: `exp(-absorb * way)` is left.
    pub absorb: DVec3,
    /// A second colour.
    pub pattern: Pattern,
}

impl Material {
    /// What the old program had for a mirrored share that nobody set, and did not use.
    pub const UNSET_REFLECTED: f64 = 0.3;
    /// The same for the transmitted share.
    pub const UNSET_REFRACTED: f64 = 0.5;
    /// Below this a gloss counts as this: the exponent grows as its inverse square.
    const LEAST_GLOSS: f64 = 0.01;

    /// Sets one share; the value is in [0, 1].
    pub fn set_share(&mut self, share: MaterialShare, value: f64) {
        match share {
            MaterialShare::Ambient => self.ambient = value,
            MaterialShare::Reflected => self.reflected = Some(value),
            MaterialShare::Refracted => self.refracted = Some(value),
            MaterialShare::Gloss => self.gloss = value,
            MaterialShare::Diffuse => self.diffuse = value,
            MaterialShare::Specular => self.specular = value,
        }
    }

    /// The exponent of the highlight: `shininess` where set, else `2 / gloss^2 - 2` with gloss at least 0.01. That gives 20 at the default
    /// gloss of 0.3, as measured on the course's official picture, and a highlight spread over the hemisphere at 1.
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
            pattern: Pattern::None,
        }
    }
}

/// A superquadric with its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// The shape, centred at the origin of its own space.
    pub shape: Superquadric,
    /// Its cutting in the preview.
    pub patches: Patches,
    /// Its surface.
    pub material: Material,
}

impl Default for Primitive {
    fn default() -> Self {
        Self {
            shape: Superquadric::unit_sphere(),
            patches: Patches { u: 15, v: 15 },
            material: Material::default(),
        }
    }
}
