//! The read-only data of shading: compiled scene, environment and picture settings.

use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Aabb, Ray};
use superegg_scene::{Light, Material, Picture};
use superegg_trace::{CompiledScene, Footprint, Hit, InstancePath, Target, TraceRay};

use crate::settings::{Environment, RenderSettings};
use crate::shade::bump::Bump;
use crate::shade::floor::FloorPlane;
use crate::shade::medium::Media;
use crate::shade::microfacet::surface::Microfacets;
use crate::shade::path_resources::PathResources;
use crate::shade::phong::LobeWeights;
use crate::shade::point::{MaterialRef, PathState, SurfaceOwner, SurfacePoint, SurfaceView};
use crate::shade::state::ShadingState;
use crate::shade::surfaces::{Located, Surface};
use crate::shade::textured::{Finish, finish_of_floor, finish_of_shape};

/// The scene with its environment and picture settings.
#[derive(Clone, Copy)]
pub(crate) struct RenderContext<'a> {
    pub(crate) scene: &'a CompiledScene,
    pub(crate) environment: &'a Environment,
    pub(crate) picture: &'a Picture,
    pub(crate) ground: Option<FloorPlane<'a>>,
    /// Whether any material transmits light. Shadows may then be coloured.
    pub(crate) has_transmission: bool,
    pub(crate) paths: &'a PathResources,
}

/// Whether light passes through a material.
pub(crate) fn transmits(material: &Material) -> bool {
    material.refracted.is_some_and(|share| share > 0.0)
}

impl<'a> RenderContext<'a> {
    pub(crate) fn new(
        scene: &'a CompiledScene,
        settings: &'a RenderSettings,
        paths: &'a PathResources,
    ) -> Self {
        let ground =
            settings.environment.floor.as_ref().map(|(floor, material)| FloorPlane::new(floor, material));
        Self {
            scene,
            environment: &settings.environment,
            picture: &settings.picture,
            ground,
            has_transmission: scene.materials().iter().any(transmits),
            paths,
        }
    }

    /// Whether a point has a surface of facets.
    pub(crate) fn has_facets(&self, point: &SurfacePoint<'_>) -> bool {
        self.paths.albedo.is_some() && point.material.facet_roughness().is_some()
    }

    /// The surface of facets at a point; `None` in the course's model, and for materials without any.
    pub(crate) fn microfacets(&self, point: &SurfacePoint<'_>) -> Option<Microfacets<'a>> {
        Microfacets::of(self.paths.albedo.as_ref()?, point)
    }

    /// The lights with their indices.
    pub(crate) fn lights(&self) -> impl Iterator<Item = (u32, &'a Light)> + Clone + use<'a> {
        (0..).zip(&self.environment.lights)
    }

    /// The sky or background in a direction of any length.
    pub(crate) fn sky(&self, direction: DVec3) -> DVec3 {
        if let Some(map) = &self.environment.map {
            return map.radiance(direction.normalize_or_zero());
        }
        match &self.environment.sky {
            Some(sky) => sky.color(direction.normalize_or_zero()),
            None => self.environment.background,
        }
    }

    /// The transmittance of the floor along a ray up to t = `end`.
    pub(crate) fn transmittance_past_floor(&self, ray: &Ray, is_from_floor: bool, end: f64) -> f64 {
        let ground = self.ground.filter(|_| !is_from_floor);
        match ground.and_then(|ground| Some((ground, ground.intersect(ray)?))) {
            Some((ground, t)) if t < end => ground.material.refracted.unwrap_or(0.0).min(1.0),
            _ => 1.0,
        }
    }

    /// The transparent shapes that contain a point.
    pub(crate) fn media_at(&self, point: DVec3) -> Media {
        // The largest number of shapes that are tested.
        const MOST_SHAPES: usize = 4096;
        if !self.has_transmission {
            return Media::default();
        }
        let around = self.scene.query_box(&Aabb { min: point, max: point }, MOST_SHAPES);
        let mut containing: Vec<(f64, InstancePath, &Material)> = around
            .into_iter()
            .filter_map(|path| {
                let (unit_from_world, target) = self.scene.unit_from_world(&path);
                let Target::Primitive(primitive) = target else { return None };
                let primitive = self.scene.primitive(primitive);
                let material = self.scene.material_of(&primitive);
                let local = unit_from_world.transform_point3(point);
                (primitive.unit_shape().inside_outside(local) < 0.0 && transmits(material))
                    .then(|| (unit_from_world.matrix3.determinant().abs(), path, material))
            })
            .collect();
        // The largest first: it contains the others.
        containing.sort_by(|a, b| a.0.total_cmp(&b.0));
        containing
            .into_iter()
            .fold(Media::default(), |media, (_, path, material)| media.entering(&Rc::new(path), material))
    }

    /// The surface point that a ray hits, the floor included. `hit` is its first hit in the scene.
    pub(crate) fn surface_point(
        &self,
        ray: &TraceRay,
        hit: Option<&Hit>,
        state: PathState,
        shading: &mut ShadingState<'_, 'a>,
    ) -> Option<SurfacePoint<'a>> {
        let TraceRay { ray, footprint, .. } = ray;
        let ground = self.ground.filter(|_| !state.is_from_floor);
        if let Some((ground, t)) = ground.and_then(|ground| Some((ground, ground.intersect(ray)?)))
            && hit.is_none_or(|hit| t < hit.t)
        {
            return Some(self.point_of_floor(&ground, ray, t, *footprint, state));
        }
        let hit = hit?;
        let surface = shading.surfaces.at(hit);
        shading.stats.proxy_hits += u64::from(surface.primitive.is_none());
        Some(self.point_of_hit(&surface, hit, ray, *footprint, state))
    }

    /// The finish at a point of a shape: [`finish_of_shape`]. `primitive` is its index; `None` for a proxy.
    pub(crate) fn finish(
        &self,
        material: &MaterialRef<'a>,
        primitive: Option<u32>,
        unit_point: DVec3,
        world_from_unit: &DAffine3,
        view: &SurfaceView,
    ) -> Finish<'a> {
        let primitive = primitive.map(|index| (self.scene.primitive(index), self.paths.textures.get(index)));
        finish_of_shape(material, primitive, unit_point, world_from_unit, view)
    }

    fn point_of_hit(
        &self,
        surface: &Surface<'a>,
        hit: &Hit,
        ray: &Ray,
        footprint: Footprint,
        state: PathState,
    ) -> SurfacePoint<'a> {
        let direction = ray.direction.normalize();
        let footprint = at_surface(footprint, ray, hit.t);
        let Located { position, position_error, normal } = surface.locate(hit);
        let view = SurfaceView { normal, direction, width: footprint.width };
        let Finish { albedo, material, bumped } = self.finish(
            &surface.material,
            surface.primitive,
            hit.unit_point,
            &surface.world_from_unit,
            &view,
        );
        let bump = bump_at(normal, hit.leaving, bumped, -direction);
        SurfacePoint {
            state: state.after(ray.origin, position),
            owner: SurfaceOwner::Instance(Rc::clone(&surface.path)),
            position,
            position_error,
            normal,
            leaving: hit.leaving,
            to_eye: -direction,
            footprint,
            albedo,
            weights: LobeWeights::of(&material, cos_of_weights(direction, normal, bump.as_deref())),
            material,
            bump,
        }
    }

    /// The point of the floor on a ray.
    pub(crate) fn point_of_floor(
        &self,
        ground: &FloorPlane<'a>,
        ray: &Ray,
        t: f64,
        footprint: Footprint,
        state: PathState,
    ) -> SurfacePoint<'a> {
        let direction = ray.direction.normalize();
        let footprint = at_surface(footprint, ray, t);
        let (position, position_error) = ground.project(ray.point_at(t));
        let view = SurfaceView { normal: ground.up(), direction, width: footprint.width };
        let Finish { albedo, material, bumped } =
            finish_of_floor(ground, self.paths.textures.floor.as_deref(), position, &view);
        let leaving = ray.direction.dot(ground.up()) > 0.0;
        let bump = bump_at(ground.up(), leaving, bumped, -direction);
        SurfacePoint {
            state: state.after(ray.origin, position),
            owner: SurfaceOwner::Floor,
            position,
            position_error,
            normal: ground.up(),
            leaving,
            to_eye: -direction,
            footprint,
            material,
            albedo,
            weights: LobeWeights::of(
                ground.material,
                cos_of_weights(direction, ground.up(), bump.as_deref()),
            ),
            bump,
        }
    }
}

/// The bump of a point by the outward normals of its shape and with bumps.
pub(crate) fn bump_at(
    normal: DVec3,
    leaving: bool,
    bumped: Option<DVec3>,
    to_eye: DVec3,
) -> Option<Box<Bump>> {
    let side = if leaving { -1.0 } else { 1.0 };
    bumped.map(|bumped| Box::new(Bump::new(side * normal, side * bumped, to_eye)))
}

/// The cosine of the angle between a ray and the normal of mirrors.
pub(crate) fn cos_of_weights(direction: DVec3, normal: DVec3, bump: Option<&Bump>) -> f64 {
    direction.dot(bump.map_or(normal, |bump| bump.mirror)).abs()
}

/// The width of a ray at a hit, and its growth per world unit from there.
pub(crate) fn at_surface(footprint: Footprint, ray: &Ray, t: f64) -> Footprint {
    Footprint { width: footprint.at(t), spread: footprint.spread / ray.direction.length() }
}
