//! Textures: pictures on surfaces.

use std::sync::Arc;

/// The quantity of a material that a texture sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureChannel {
    /// The colour, times the colour and the pattern of the material.
    Color,
    /// The roughness of the facets, for [`LightModel::Path`](crate::LightModel) alone.
    Roughness,
    /// The height of bumps, which turn the normal that light takes.
    Bump,
}

/// How a picture lies on a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureMapping {
    /// Once around and from pole to pole: (u, v) are longitude and latitude in the space of the unit shape.
    #[default]
    Around,
    /// On six sides, in the primitive's own space: each point has the side that its normal faces most.
    Box,
}

/// A picture in a file, on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The name of the file, as it was given.
    pub file: Arc<str>,
    /// How it lies on the shape.
    pub mapping: TextureMapping,
    /// The size of the picture, above 0: as a part of the way around and from pole to pole, or in units of the primitive's
    /// own space. It repeats beyond its sides.
    pub scale: f64,
    /// The height of white above black for [`TextureChannel::Bump`], in units of the primitive's own space; below 0 for dents.
    /// `None` for [`Texture::HEIGHT`]. Other channels have none.
    pub height: Option<f64>,
}

impl Texture {
    /// The height of bumps that name none.
    pub const HEIGHT: f64 = 0.05;
}

/// The textures of a primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// For [`TextureChannel::Color`].
    pub color: Option<Texture>,
    /// For [`TextureChannel::Roughness`].
    pub roughness: Option<Texture>,
    /// For [`TextureChannel::Bump`].
    pub bump: Option<Texture>,
}

impl TextureChannel {
    /// Every channel.
    pub const ALL: [Self; 3] = [Self::Color, Self::Roughness, Self::Bump];

    /// The word of the channel in the language.
    pub fn word(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Roughness => "roughness",
            Self::Bump => "bump",
        }
    }
}

impl TextureMapping {
    /// The word of the mapping in the language.
    pub fn word(self) -> &'static str {
        match self {
            Self::Around => "around",
            Self::Box => "box",
        }
    }
}

impl Textures {
    /// The texture of a channel.
    pub fn get(&self, channel: TextureChannel) -> Option<&Texture> {
        match channel {
            TextureChannel::Color => self.color.as_ref(),
            TextureChannel::Roughness => self.roughness.as_ref(),
            TextureChannel::Bump => self.bump.as_ref(),
        }
    }

    /// Replaces the texture of a channel.
    pub fn set(&mut self, channel: TextureChannel, texture: Option<Texture>) {
        match channel {
            TextureChannel::Color => self.color = texture,
            TextureChannel::Roughness => self.roughness = texture,
            TextureChannel::Bump => self.bump = texture,
        }
    }

    /// All textures with their channels.
    pub fn all(&self) -> impl Iterator<Item = (TextureChannel, &Texture)> {
        TextureChannel::ALL.into_iter().filter_map(|channel| Some((channel, self.get(channel)?)))
    }
}
