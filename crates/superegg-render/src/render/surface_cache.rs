//! The shading data of packet candidates, prepared at the first hit of each.

use std::cell::OnceCell;
use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DMat3};
use superegg_trace::packet::{Columns, PacketTracer, f32_columns};
use superegg_trace::{InstancePath, Target};

use crate::film::first::SurfaceIds;
use crate::render::lane_kernels::PlainMaterial;
use crate::render::surface_ids::SurfaceIdTable;
use crate::shade::context::RenderContext;
use crate::shade::point::MaterialRef;

/// The shading data of the candidates of one tile.
pub(crate) struct SurfaceCache<'a> {
    context: RenderContext<'a>,
    by_candidate: Vec<Option<PreparedSurface<'a>>>,
}

/// The shading data of one candidate.
#[derive(Clone)]
pub(crate) struct PreparedSurface<'a> {
    /// Computed at the first hit in f64; most candidates have none.
    world_from_unit: OnceCell<DAffine3>,
    /// Maps gradients of the unit shape to world normals.
    pub(crate) normal_map: DMat3,
    pub(crate) material: MaterialRef<'a>,
    /// The index of the primitive; `None` for a proxy.
    pub(crate) primitive: Option<u32>,
    pub(crate) path: Rc<InstancePath>,
    /// Computed at the first hit whose ids are wanted.
    ids: OnceCell<SurfaceIds>,
    /// The material and the normal map in f32, if the lane kernels can shade the surface.
    pub(crate) plain: Option<(PlainMaterial, Columns)>,
}

impl PreparedSurface<'_> {
    /// The map from the unit shape to the world.
    pub(crate) fn world_from_unit(&self, tracer: &PacketTracer<'_>, candidate: u32) -> &DAffine3 {
        self.world_from_unit.get_or_init(|| tracer.candidate(candidate).world_from_unit())
    }

    /// The ids of the surface.
    pub(crate) fn ids(&self, table: &mut SurfaceIdTable<'_>) -> SurfaceIds {
        *self.ids.get_or_init(|| table.of(&self.path))
    }
}

impl<'a> SurfaceCache<'a> {
    pub(crate) fn new(context: RenderContext<'a>) -> Self {
        Self { context, by_candidate: Vec::new() }
    }

    /// Removes all surfaces, before the candidates of another tile.
    pub(crate) fn clear(&mut self) {
        self.by_candidate.clear();
    }

    /// The surface of a candidate, if it was prepared.
    pub(crate) fn get(&self, candidate: u32) -> Option<&PreparedSurface<'a>> {
        self.by_candidate.get(candidate as usize).and_then(Option::as_ref)
    }

    /// The surface of a candidate, prepared at the first request.
    pub(crate) fn get_or_prepare(
        &mut self,
        tracer: &PacketTracer<'_>,
        candidate: u32,
    ) -> &PreparedSurface<'a> {
        let Self { context, .. } = *self;
        let (scene, textures) = (context.scene, &context.paths.textures);
        if self.by_candidate.len() <= candidate as usize {
            self.by_candidate.resize(tracer.candidate_count(), None);
        }
        self.by_candidate[candidate as usize].get_or_insert_with(|| {
            let path = Rc::new(tracer.path(candidate));
            let candidate = tracer.candidate(candidate);
            let (primitive, material) = match candidate.target {
                Target::Primitive(primitive) => {
                    let material = scene.material_of(&scene.primitive(primitive));
                    (Some(primitive), MaterialRef::Scene(material))
                }
                Target::Proxy => (None, MaterialRef::Mean(Rc::new(scene.proxy_material(&path)))),
            };
            let normal_map = candidate.unit_from_world.matrix3.transpose();
            PreparedSurface {
                world_from_unit: OnceCell::new(),
                normal_map,
                plain: PlainMaterial::of(&material, &context)
                    .filter(|plain| plain.mirror() == 0.0 || primitive.is_some())
                    .filter(|_| primitive.is_none_or(|primitive| textures.get(primitive).is_none()))
                    .and_then(|plain| Some((plain, f32_columns(&normal_map)?.0))),
                material,
                primitive,
                ids: OnceCell::new(),
                path,
            }
        })
    }
}
