//! The data that a render computes from a scene before it starts.

use superegg_scene::{LightModel, Material};
use superegg_trace::CompiledScene;

use crate::settings::RenderSettings;
use crate::shade::emitters::Emitters;
use crate::shade::microfacet::albedo::AlbedoTables;
use crate::texture::set::TexturesByIndex;

/// The data that a render computes from a scene before it starts: the emitters and tables of paths, and the textures of any picture.
#[derive(Default)]
pub(crate) struct PathResources {
    /// Empty in other models of light.
    pub(crate) emitters: Emitters,
    /// `None` if no surface has facets, and in other models of light.
    pub(crate) albedo: Option<AlbedoTables>,
    pub(crate) textures: TexturesByIndex,
}

impl PathResources {
    pub(crate) fn of(scene: &CompiledScene, settings: &RenderSettings) -> Self {
        let floor = settings.environment.floor.as_ref();
        let surface = floor.and_then(|(floor, _)| floor.surface.as_deref());
        let textures = settings.textures.by_index(scene, surface);
        if settings.picture.light_model == LightModel::Course {
            return Self { textures, ..Self::default() };
        }
        let of_floor = floor.iter().map(|(_, material)| material);
        let has_facets = |material: &Material| material.facet_roughness().is_some();
        let any_has_facets =
            settings.textures.has_roughness() || scene.materials().iter().chain(of_floor).any(has_facets);
        Self { emitters: Emitters::of(scene), albedo: any_has_facets.then(AlbedoTables::new), textures }
    }
}
