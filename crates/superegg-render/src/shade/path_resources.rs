//! What paths need to know of a scene before they start.

use superegg_scene::{LightModel, Material};
use superegg_trace::CompiledScene;

use crate::settings::RenderSettings;
use crate::shade::emitters::Emitters;
use crate::shade::microfacet::albedo::AlbedoTables;

/// What paths need to know of a scene; empty in other models of light.
#[derive(Default)]
pub(crate) struct PathResources {
    pub(crate) emitters: Emitters,
    /// `None` if no surface has facets.
    pub(crate) albedo: Option<AlbedoTables>,
}

impl PathResources {
    pub(crate) fn of(scene: &CompiledScene, settings: &RenderSettings) -> Self {
        if settings.picture.light_model == LightModel::Course {
            return Self::default();
        }
        let of_floor = settings.environment.floor.iter().map(|(_, material)| material);
        let has_facets = |material: &Material| material.facet_roughness().is_some();
        let any_has_facets = scene.materials().iter().chain(of_floor).any(has_facets);
        Self { emitters: Emitters::of(scene), albedo: any_has_facets.then(AlbedoTables::new) }
    }
}
