//! Plain mirrors in f32 lanes, with what they show.
//!
//! Mirrored rays of neighbouring lanes lie in one beam. Where no shape reaches into the beam, the mirrors stay in f32 and
//! receive the sky. Where a few shapes do, each ray is tested against these: it receives the sky or has a first hit, which is
//! shaded as a point of the next bounce. All others go on in f64, as rays.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::{PACKET, PacketColumn, PacketSurfaces, PacketVectors};
use superegg_geom::{Aabb, Ray};
use superegg_simd::{Arch, Lanes, Mask, Simd, WithSimd};
use superegg_trace::packet::{LANES, PacketTracer, SurfaceLanes, VisibleSurfaces, bits};
use superegg_trace::shaft::{BeamHits, FirstHit, FirstHits, Occluder, RayBeam, ShaftRays};
use superegg_trace::{CompiledScene, Footprint, Hit, InstancePath};

use crate::render::surface_cache::SurfaceCache;
use crate::shade::context::RenderContext;
use crate::shade::lane_math::{dot, inverse_length};
use crate::stats::TraceStats;

/// The most packets whose rays form one beam.
const NEIGHBOURS: usize = 4;
/// More than the rounding error of a mirrored direction in f32.
const DIRECTION_ERROR: f64 = 1e-5;
/// More than the relative rounding error of a position in f32.
const POSITION_ERROR: f64 = 4.0 * f32::EPSILON as f64;

/// The mirrors of one batch.
pub(crate) struct LaneMirrors {
    arch: Arch,
    /// The mirrored unit directions, by packets. Those of packets without mirrors have no meaning.
    directions: Vec<PacketVectors>,
    /// The lanes whose mirrored rays hit nothing.
    open: Vec<SurfaceLanes>,
    /// The lanes of whose mirrored rays nothing is known.
    others: Vec<SurfaceLanes>,
    /// The hits of mirrored rays of which lanes know the first one.
    seen: Vec<MirroredHit>,
    found: Vec<Occluder>,
    rays: ShaftRays,
    first_hits: FirstHits,
}

/// The first hit of a mirrored ray.
#[derive(Clone, Debug)]
pub(crate) struct MirroredHit {
    /// The index of the camera ray.
    pub(crate) pixel: usize,
    pub(crate) ray: Ray,
    /// The width of the ray at its start, and its growth.
    pub(crate) footprint: Footprint,
    /// The part of the light that the surface mirrors.
    pub(crate) mirror: f64,
    pub(crate) hit: Hit,
}

impl LaneMirrors {
    pub(crate) fn new() -> Self {
        Self {
            arch: Arch::new(),
            directions: Vec::new(),
            open: Vec::new(),
            others: Vec::new(),
            seen: Vec::new(),
            found: Vec::new(),
            rays: ShaftRays::default(),
            first_hits: FirstHits::default(),
        }
    }

    /// Removes the mirrors of the batch before.
    pub(crate) fn clear(&mut self) {
        self.open.clear();
        self.others.clear();
        self.seen.clear();
    }

    /// The hits of mirrored rays whose surfaces stay in lanes.
    pub(crate) fn seen(&self) -> &[MirroredHit] {
        &self.seen
    }

    /// The number of lanes that go on in f64.
    pub(crate) fn moved_count(&self) -> usize {
        self.others.iter().map(|surface| surface.lanes.count_ones() as usize).sum()
    }

    /// Tests the mirrored rays of all surfaces. Returns the lanes that go on in f64. `camera` is the origin of the
    /// rays, and `footprint` their width.
    pub(crate) fn find(
        &mut self,
        scene: &CompiledScene,
        tracer: &PacketTracer<'_>,
        surfaces: &mut SurfaceCache<'_>,
        visible: &VisibleSurfaces,
        (camera, footprint): (DVec3, Footprint),
    ) -> &[SurfaceLanes] {
        self.directions.resize(visible.surfaces.len(), [PacketColumn::splat(0.0); 3]);
        for group in visible.resolved.chunk_by(|a, b| a.candidate == b.candidate) {
            let surface = surfaces.get_or_prepare(tracer, group[0].candidate);
            let mirror = surface.plain.as_ref().map_or(0.0, |(material, _)| material.mirror());
            if mirror == 0.0 {
                continue;
            }
            let mirror = f64::from(mirror);
            let source = MirrorSource { scene, visible, camera, footprint, own: &surface.path, mirror };
            for group in group.chunks(NEIGHBOURS) {
                self.test(&source, group);
            }
        }
        &self.others
    }

    /// Tests the rays of some packets: together, and one by one where they may hit a few shapes.
    fn test(&mut self, source: &MirrorSource<'_>, group: &[SurfaceLanes]) {
        let beam = self.beam(source, group);
        match source.scene.beam_hits(&beam, &mut self.found) {
            BeamHits::None => self.open.extend_from_slice(group),
            BeamHits::Found => self.test_rays(source, group),
            BeamHits::Unknown => self.others.extend_from_slice(group),
        }
    }

    /// Tests each ray of some packets against the shapes that were found.
    fn test_rays(&mut self, source: &MirrorSource<'_>, group: &[SurfaceLanes]) {
        self.rays.clear();
        for &SurfaceLanes { packet, lanes, .. } in group {
            bits(lanes).for_each(|lane| self.rays.push(&source.ray(packet, lane, &self.directions[packet])));
        }
        source.scene.first_hits(&self.found, &self.rays, &mut self.first_hits);
        let mut hits = self.first_hits.found.drain(..).enumerate();
        for &surface in group {
            let (mut open, mut unknown) = (0, 0);
            for (lane, (index, hit)) in bits(surface.lanes).zip(&mut hits) {
                match hit {
                    FirstHit::None => open |= 1 << lane,
                    FirstHit::Unknown => unknown |= 1 << lane,
                    FirstHit::Hit(hit) => {
                        self.seen.push(source.mirrored_hit(surface.packet, lane, self.rays.ray(index), hit));
                    }
                }
            }
            for (lanes, list) in [(open, &mut self.open), (unknown, &mut self.others)] {
                if lanes != 0 {
                    list.push(SurfaceLanes { lanes, ..surface });
                }
            }
        }
    }

    /// The beam of the mirrored rays of some packets.
    fn beam<'s>(&mut self, source: &MirrorSource<'s>, group: &[SurfaceLanes]) -> RayBeam<'s> {
        let MirrorSource { visible, camera, footprint, own, .. } = *source;
        let mut range = MirrorRange::EMPTY;
        for &SurfaceLanes { packet, lanes, .. } in group {
            self.arch.dispatch(MirrorPacket {
                rays: &visible.directions[packet],
                surfaces: &visible.surfaces[packet],
                lanes,
                mirrored: &mut self.directions[packet],
                range: &mut range,
            });
        }
        let offsets = range.offsets.to_aabb();
        let rounding = POSITION_ERROR * offsets.min.abs().max(offsets.max.abs()).max_element();
        let error = DVec3::splat(visible.position_error(range.error) + rounding);
        let directions = range.directions.to_aabb();
        RayBeam {
            origins: Aabb { min: camera + offsets.min - error, max: camera + offsets.max + error },
            directions: Aabb { min: directions.min - DIRECTION_ERROR, max: directions.max + DIRECTION_ERROR },
            own: Some(own),
            // The direction of a camera ray is at least 1 long.
            footprint: Footprint { width: footprint.at(visible.t_scale * f64::from(range.t)), ..footprint },
        }
    }

    /// Adds the mirrored sky to the light of surfaces.
    pub(crate) fn add_sky(
        &self,
        context: &RenderContext<'_>,
        surfaces: &SurfaceCache<'_>,
        radiance: &mut [PacketVectors],
        stats: &mut TraceStats,
    ) {
        for &SurfaceLanes { packet, candidate, lanes } in &self.open {
            let plain = surfaces.get(candidate).and_then(|surface| surface.plain.as_ref());
            let Some((material, _)) = plain else { continue };
            stats.rays.reflection += u64::from(lanes.count_ones());
            let (mirror, directions) = (f64::from(material.mirror()), &self.directions[packet]);
            for lane in bits(lanes) {
                let sky = mirror * context.sky(vector_in(directions, lane));
                for axis in 0..3 {
                    radiance[packet][axis].0[lane] += sky[axis] as f32;
                }
            }
        }
    }
}

/// Mirrored rays of one surface.
#[derive(Clone, Copy)]
struct MirrorSource<'s> {
    scene: &'s CompiledScene,
    visible: &'s VisibleSurfaces,
    camera: DVec3,
    /// The width of the camera's rays.
    footprint: Footprint,
    own: &'s InstancePath,
    /// The part of the light that it mirrors.
    mirror: f64,
}

impl MirrorSource<'_> {
    /// The direction of a camera ray.
    fn direction(&self, packet: usize, lane: usize) -> DVec3 {
        vector_in(&self.visible.directions[packet], lane)
    }

    /// The mirrored ray of a lane. `mirrored` has the directions of its packet.
    fn ray(&self, packet: usize, lane: usize, mirrored: &PacketVectors) -> Ray {
        let surfaces = &self.visible.surfaces[packet];
        let offset = f64::from(surfaces.t.0[lane]) * self.direction(packet, lane);
        let rounding = POSITION_ERROR * offset.abs().max_element();
        Ray {
            origin: self.camera + offset,
            direction: vector_in(mirrored, lane),
            origin_error: self.visible.position_error(surfaces.error.0[lane]) + rounding,
        }
    }

    /// The hit of the mirrored ray of a lane.
    fn mirrored_hit(&self, packet: usize, lane: usize, ray: Ray, hit: Hit) -> MirroredHit {
        let pixel = packet * LANES + lane;
        let spread = self.footprint.spread * self.visible.t_scale / self.direction(packet, lane).length();
        let width = self.footprint.at(self.visible.surface_at(pixel).t);
        MirroredHit { pixel, ray, footprint: Footprint { width, spread }, mirror: self.mirror, hit }
    }
}

/// The vector of a lane.
fn vector_in(columns: &PacketVectors, lane: usize) -> DVec3 {
    DVec3::from_array(columns.each_ref().map(|column| f64::from(column.0[lane])))
}

/// A box in f32.
#[derive(Clone, Copy)]
struct Range {
    min: [f32; 3],
    max: [f32; 3],
}

impl Range {
    const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// Takes in some lanes of vectors.
    #[inline(always)]
    fn extend<S: Simd>(&mut self, lanes: Mask<S>, vectors: [Lanes<S>; 3]) {
        for (axis, column) in vectors.into_iter().enumerate() {
            let least = lanes.select(column, column.all(f32::INFINITY)).least();
            let largest = lanes.select(column, column.all(f32::NEG_INFINITY)).largest();
            self.min[axis] = self.min[axis].min(least);
            self.max[axis] = self.max[axis].max(largest);
        }
    }

    fn to_aabb(self) -> Aabb {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        Aabb { min: vector(self.min), max: vector(self.max) }
    }
}

/// The range of mirrored rays.
struct MirrorRange {
    /// Their origins, from the camera.
    offsets: Range,
    /// Their unit directions.
    directions: Range,
    /// The largest t of the camera's rays, and the largest error of one.
    t: f32,
    error: f32,
}

impl MirrorRange {
    const EMPTY: Self = Self { offsets: Range::EMPTY, directions: Range::EMPTY, t: 0.0, error: 0.0 };
}

/// Computes the mirrored unit directions of a packet, and the range of its rays.
struct MirrorPacket<'a> {
    /// The directions of the camera's rays.
    rays: &'a PacketVectors,
    surfaces: &'a PacketSurfaces,
    /// A mask of the lanes that count.
    lanes: u32,
    mirrored: &'a mut PacketVectors,
    range: &'a mut MirrorRange,
}

impl WithSimd for MirrorPacket<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rays, surfaces, lanes, mirrored, range } = self;
        for i in 0..PACKET / S::F32_LANES {
            let lanes = Mask::<S>::of_bits(simd, lanes >> (i * S::F32_LANES));
            let lane = |column: &PacketColumn<f32>| -> Lanes<S> { column.load(simd, i) };
            let triple = |[x, y, z]: &PacketVectors| [lane(x), lane(y), lane(z)];
            let (t, error) = (lane(&surfaces.t), lane(&surfaces.error));
            let (ray, normal) = (triple(rays), triple(&surfaces.normal));
            let scale = inverse_length(ray);
            let twice = dot(ray, normal) * scale * scale.all(-2.0);
            let (mut offset, mut direction) = (ray, ray);
            for axis in 0..3 {
                offset[axis] = t * ray[axis];
                direction[axis] = twice.mul_add(normal[axis], ray[axis] * scale);
                mirrored[axis].store_where(lanes, i, direction[axis]);
            }
            range.offsets.extend(lanes, offset);
            range.directions.extend(lanes, direction);
            range.t = range.t.max(lanes.select(t, t.all(0.0)).largest());
            range.error = range.error.max(lanes.select(error, error.all(0.0)).largest());
        }
    }
}
