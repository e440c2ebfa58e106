//! Direct light on the surfaces that packets of camera rays see, shaded in f32 lanes.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::{ALL_LANES, PacketVectors};
use superegg_simd::Arch;
use superegg_trace::Footprint;
use superegg_trace::packet::{
    DirectionsFrom, LANES, LaneSurface, PacketRays, ShadowRay, SurfaceLanes, VisibleSurfaces, bits,
};

use crate::camera::view::View;
use crate::render::lane_kernels::{
    AddContribution, PacketContribution, PacketLight, PacketMaterials, SetMaterial, ShadePacket,
};
use crate::render::primary_hits::PrimaryHits;
use crate::render::shadow_queue::ShadowQueue;
use crate::shade::context::RenderContext;
use crate::stats::TraceStats;

/// Lights the f32 surfaces of a batch. The vectors have one element per packet.
pub(crate) struct LaneLighting {
    arch: Arch,
    /// The lights of the scene; `None` if the picture needs shading in f64.
    lights: Option<Vec<PacketLight>>,
    materials: Vec<PacketMaterials>,
    /// The light on each surface so far.
    radiance: Vec<PacketVectors>,
    /// The unoccluded light of the current light source.
    contributions: Vec<PacketContribution>,
    shadows: LaneShadows,
}

/// The queued shadow rays of lanes. They are the first rays of the [`ShadowQueue`].
#[derive(Default)]
struct LaneShadows {
    groups: Vec<ShadowGroup>,
    /// Lanes that do not fill a packet. They are queued after all full packets.
    partial: Vec<SurfaceLanes>,
    /// A mask of the unoccluded lanes of each packet.
    unoccluded: Vec<u32>,
}

/// Shadow rays from lanes of one packet with one candidate.
struct ShadowGroup {
    source: SurfaceLanes,
    /// The index of the first ray in the queue.
    first: usize,
}

impl ShadowGroup {
    /// A mask of the unoccluded lanes. `occluded` has a mask for each packet of shadow rays.
    fn unoccluded(&self, occluded: &[u32]) -> u32 {
        let (packet, lane) = (self.first / LANES, self.first % LANES);
        let next = occluded.get(packet + 1).copied().unwrap_or_default();
        let unoccluded = !((occluded[packet] | next << LANES) >> lane);
        if self.source.lanes == ALL_LANES {
            return unoccluded & ALL_LANES;
        }
        bits(self.source.lanes).enumerate().fold(0, |all, (ray, lane)| all | (unoccluded >> ray & 1) << lane)
    }

    /// The index of the sample of a shadow ray of this group.
    fn sample(&self, ray: usize) -> Option<usize> {
        let lane = bits(self.source.lanes).nth(ray.checked_sub(self.first)?)?;
        Some(self.source.packet * LANES + lane)
    }
}

/// The camera rays and their surfaces, from which shadow rays to one light start.
struct ShadowSource<'s> {
    arch: Arch,
    rays: &'s PacketRays,
    visible: &'s VisibleSurfaces,
    /// The position of the light.
    light: DVec3,
    /// From the light to the camera.
    light_to_camera: DVec3,
}

impl ShadowSource<'_> {
    /// Queues the shadow rays of some lanes. Returns the least t of their camera rays.
    fn queue(&self, source: SurfaceLanes, groups: &mut Vec<ShadowGroup>, queue: &mut ShadowQueue) -> f64 {
        let (t, t_scale) = (&self.visible.surfaces[source.packet].t, self.visible.t_scale);
        let rays = &self.rays.directions()[source.packet];
        let offset = self.light_to_camera;
        let directions = self.arch.dispatch(DirectionsFrom { rays, t, t_scale, offset });
        groups.push(ShadowGroup { source, first: queue.len() });
        queue.push_lanes(&directions, source.lanes, source.candidate);
        t_scale * f64::from(bits(source.lanes).fold(f32::INFINITY, |least, lane| least.min(t.0[lane])))
    }

    /// Dims the light that passes the floor. Returns the lanes that it still reaches.
    fn dim_by_floor(
        &self,
        context: &RenderContext<'_>,
        source: SurfaceLanes,
        contribution: &mut PacketContribution,
    ) -> u32 {
        let mut lanes = source.lanes;
        for lane in bits(source.lanes) {
            let sample = source.packet * LANES + lane;
            let LaneSurface { t, position_error: origin_error, .. } = self.visible.surface_at(sample);
            let direction = self.light_to_camera + t * self.rays.direction(sample);
            let ray = Ray { origin: self.light + direction, direction: -direction, origin_error };
            let past_floor = context.transmittance_past_floor(&ray, false, 1.0);
            contribution.color.iter_mut().for_each(|column| column.0[lane] *= past_floor as f32);
            lanes &= !(u32::from(past_floor == 0.0) << lane);
        }
        lanes
    }
}

impl LaneLighting {
    pub(crate) fn new(context: &RenderContext<'_>, view: &View) -> Self {
        Self {
            arch: Arch::new(),
            lights: PacketLight::all(context, view),
            materials: Vec::new(),
            radiance: Vec::new(),
            contributions: Vec::new(),
            shadows: LaneShadows::default(),
        }
    }

    /// Whether opaque surfaces of the picture may be shaded in lanes.
    pub(crate) fn is_enabled(&self) -> bool {
        self.lights.is_some()
    }

    /// Sets the materials of a batch and starts with its ambient light and the sky in its mirrors.
    pub(crate) fn start(
        &mut self,
        context: &RenderContext<'_>,
        hits: &mut PrimaryHits<'_>,
        stats: &mut TraceStats,
    ) {
        let PrimaryHits { tracer, visible, surfaces, mirrors, .. } = hits;
        self.materials.clear();
        self.materials.resize(visible.surfaces.len(), PacketMaterials::NONE);
        for &SurfaceLanes { packet, candidate, lanes } in &visible.resolved {
            let surface = surfaces.get_or_prepare(tracer, candidate);
            let lanes = lanes & visible.surfaces[packet].lanes;
            stats.proxy_hits += u64::from(surface.primitive.is_none()) * u64::from(lanes.count_ones());
            if let Some((material, _)) = &surface.plain {
                let packet = &mut self.materials[packet];
                self.arch.dispatch(SetMaterial { packet, lanes, material });
            }
        }
        self.radiance.clear();
        self.radiance.extend(self.materials.iter().map(PacketMaterials::ambient));
        mirrors.add_sky(context, surfaces, &mut self.radiance, stats);
    }

    /// Shades all packets by one light and queues a shadow ray for each lane that faces it.
    /// Returns the least width of a ray.
    pub(crate) fn queue_shadows(
        &mut self,
        context: &RenderContext<'_>,
        hits: &PrimaryHits<'_>,
        (light_index, light): (usize, DVec3),
        footprint: Footprint,
        queue: &mut ShadowQueue,
    ) -> f64 {
        self.shadows.groups.clear();
        if !self.shade(light_index, &hits.visible) {
            return f64::INFINITY;
        }
        let PrimaryHits { rays, visible, .. } = hits;
        let light_to_camera = rays.origin - light;
        let surfaces = ShadowSource { arch: self.arch, rays, visible, light, light_to_camera };
        let LaneShadows { groups, partial, .. } = &mut self.shadows;
        partial.clear();
        let mut least_t = f64::INFINITY;
        for &resolved in &visible.resolved {
            let mut lit = resolved;
            let contribution = &mut self.contributions[lit.packet];
            lit.lanes &= contribution.lanes;
            if context.ground.is_some() {
                lit.lanes = surfaces.dim_by_floor(context, lit, contribution);
            }
            match lit.lanes {
                0 => {}
                ALL_LANES => least_t = least_t.min(surfaces.queue(lit, groups, queue)),
                _ => partial.push(lit),
            }
        }
        for &lit in &*partial {
            least_t = least_t.min(surfaces.queue(lit, groups, queue));
        }
        // The width of a ray does not decrease with t.
        if least_t < f64::INFINITY { footprint.at(least_t) } else { f64::INFINITY }
    }

    /// Computes the unoccluded light of one source. Returns false if lanes do not shade it.
    fn shade(&mut self, light_index: usize, visible: &VisibleSurfaces) -> bool {
        let Some(light) = self.lights.as_ref().and_then(|lights| lights.get(light_index)) else {
            return false;
        };
        self.contributions.resize(self.materials.len(), PacketContribution::NONE);
        for (packet, (surfaces, materials)) in visible.surfaces.iter().zip(&self.materials).enumerate() {
            let contribution = &mut self.contributions[packet];
            contribution.lanes = 0;
            if surfaces.lanes != 0 {
                let directions = &visible.directions[packet];
                self.arch.dispatch(ShadePacket { light, directions, surfaces, materials, contribution });
            }
        }
        true
    }

    /// A queued shadow ray of lanes, by its index in the queue.
    pub(crate) fn shadow_ray(
        &self,
        index: usize,
        visible: &VisibleSurfaces,
        footprint: Footprint,
        from_light: &PacketRays,
    ) -> ShadowRay {
        let groups = &self.shadows.groups;
        let group = groups.partition_point(|group| group.first <= index).checked_sub(1);
        let sample = group.and_then(|group| groups[group].sample(index)).unwrap_or_default();
        let LaneSurface { t, position_error: origin_error, .. } = visible.surface_at(sample);
        let direction = -from_light.direction(index);
        let ray = Ray { origin: from_light.origin - direction, direction, origin_error };
        ShadowRay { ray, width: footprint.at(t) }
    }

    /// Adds the contribution of the light to all lanes whose shadow ray is unoccluded.
    pub(crate) fn add_unoccluded(&mut self, packets: usize, occluded: &[u32]) {
        let LaneShadows { groups, unoccluded, .. } = &mut self.shadows;
        unoccluded.clear();
        unoccluded.resize(packets, 0);
        for group in &*groups {
            unoccluded[group.source.packet] |= group.unoccluded(occluded);
        }
        for ((radiance, contribution), &lanes) in
            self.radiance.iter_mut().zip(&self.contributions).zip(&*unoccluded)
        {
            if lanes != 0 {
                self.arch.dispatch(AddContribution { radiance, contribution, lanes });
            }
        }
    }

    /// Writes the light on all lanes to the colours of their samples.
    pub(crate) fn write_colors(&self, visible: &VisibleSurfaces, colors: &mut [DVec3]) {
        for (packet, (surfaces, radiance)) in visible.surfaces.iter().zip(&self.radiance).enumerate() {
            for lane in bits(surfaces.lanes) {
                let [r, g, b] = radiance.each_ref().map(|column| f64::from(column.0[lane]));
                colors[packet * LANES + lane] = DVec3::new(r, g, b);
            }
        }
    }
}
