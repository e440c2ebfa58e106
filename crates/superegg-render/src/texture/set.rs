//! The textures of a scene, read from their files.

use std::collections::{BTreeMap, HashMap};
use std::convert::Infallible;
use std::sync::Arc;

use superegg_scene::{Entity, Scene, Texture, TextureChannel};
use superegg_trace::CompiledScene;

use crate::texture::mapping::MappedTexture;
use crate::texture::pixels::TexturePixels;

/// The textures of the primitives of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureSet {
    by_name: BTreeMap<Box<str>, Arc<PrimitiveTextures>>,
}

/// The textures of a primitive.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct PrimitiveTextures {
    pub(crate) color: Option<MappedTexture>,
    pub(crate) roughness: Option<MappedTexture>,
    /// With the height of white above black, in units of the primitive's own space.
    pub(crate) bump: Option<(MappedTexture, f64)>,
}

/// The textures of the primitives of a compiled scene, by their indices.
#[derive(Debug, Default)]
pub(crate) struct TexturesByIndex {
    by_index: HashMap<u32, Arc<PrimitiveTextures>>,
    pub(crate) floor: Option<Arc<PrimitiveTextures>>,
}

impl TextureSet {
    /// The textures that a scene names. `read` gets the pixels of a file, once for each file and kind of values.
    ///
    /// # Errors
    /// Those of `read`.
    pub fn of<P: Into<Arc<TexturePixels>>, E>(
        scene: &Scene,
        mut read: impl FnMut(&Texture, TextureChannel) -> Result<P, E>,
    ) -> Result<Self, E> {
        let mut known: HashMap<(Arc<str>, bool), Arc<TexturePixels>> = HashMap::new();
        Self::collect(scene, |texture, channel| {
            let key = (Arc::clone(&texture.file), channel == TextureChannel::Color);
            if let Some(pixels) = known.get(&key) {
                return Ok(Some(Arc::clone(pixels)));
            }
            let pixels = read(texture, channel)?.into();
            known.insert(key, Arc::clone(&pixels));
            Ok(Some(pixels))
        })
    }

    /// The textures that a scene names and `find` has, where files may be missing: a surface without its texture is plain.
    pub fn available(
        scene: &Scene,
        mut find: impl FnMut(&Texture, TextureChannel) -> Option<Arc<TexturePixels>>,
    ) -> Self {
        match Self::collect(scene, |texture, channel| Ok::<_, Infallible>(find(texture, channel))) {
            Ok(found) => found,
            Err(never) => match never {},
        }
    }

    fn collect<E>(
        scene: &Scene,
        mut find: impl FnMut(&Texture, TextureChannel) -> Result<Option<Arc<TexturePixels>>, E>,
    ) -> Result<Self, E> {
        let mut by_name = BTreeMap::new();
        for (name, entity) in scene.entities() {
            let Entity::Primitive(primitive) = entity else { continue };
            let Some(textures) = &primitive.textures else { continue };
            let mut mapped = PrimitiveTextures::default();
            for (channel, texture) in textures.all() {
                let Some(pixels) = find(texture, channel)? else { continue };
                let height = texture.height.unwrap_or(Texture::HEIGHT);
                let texture = MappedTexture { pixels, mapping: texture.mapping, scale: texture.scale };
                match channel {
                    TextureChannel::Color => mapped.color = Some(texture),
                    TextureChannel::Roughness => mapped.roughness = Some(texture),
                    // A flat picture turns no normal.
                    TextureChannel::Bump if height == 0.0 || texture.pixels.is_flat() => {}
                    TextureChannel::Bump => mapped.bump = Some((texture, height)),
                }
            }
            if mapped != PrimitiveTextures::default() {
                by_name.insert(name.into(), Arc::new(mapped));
            }
        }
        Ok(Self { by_name })
    }

    /// Whether no primitive has a texture.
    pub fn is_empty(&self) -> bool {
        self.by_name.is_empty()
    }

    /// Whether any primitive has a texture of roughness.
    pub(crate) fn has_roughness(&self) -> bool {
        self.by_name.values().any(|textures| textures.roughness.is_some())
    }

    /// The textures by the indices of primitives, and those of the primitive whose material the floor has.
    pub(crate) fn by_index(&self, scene: &CompiledScene, floor: Option<&str>) -> TexturesByIndex {
        if self.is_empty() {
            return TexturesByIndex::default();
        }
        let indices = 0..scene.primitive_count() as u32;
        let textures =
            |index: u32| Some((index, Arc::clone(self.by_name.get(scene.primitive_name(index)?)?)));
        TexturesByIndex {
            by_index: indices.filter_map(textures).collect(),
            floor: floor.and_then(|name| self.by_name.get(name).cloned()),
        }
    }

    /// Bytes that are equal for equal sets.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (name, textures) in &self.by_name {
            bytes.extend(name.as_bytes());
            for texture in [&textures.color, &textures.roughness] {
                let fingerprint = texture.as_ref().map_or(0, |texture| texture.pixels.fingerprint());
                bytes.extend(fingerprint.to_le_bytes());
            }
            if let Some((texture, height)) = &textures.bump {
                bytes.extend(texture.pixels.fingerprint().to_le_bytes());
                bytes.extend(height.to_le_bytes());
            }
        }
        bytes
    }
}

impl TexturesByIndex {
    /// The textures of the primitive of this index.
    pub(crate) fn get(&self, index: u32) -> Option<&PrimitiveTextures> {
        if self.by_index.is_empty() { None } else { self.by_index.get(&index).map(Arc::as_ref) }
    }
}
