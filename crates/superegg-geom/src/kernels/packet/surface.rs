//! The surface normals at the hits of a packet.

use superegg_simd::{Lanes, Linear, Mask, Simd, Triple, WithSimd, register_bits};

use super::super::norm::{EvaluateNorm, SIDE_BY_SIDE, SQUARES, ValueAndGradient, WithNorm, with_norm};
use super::hits::{PacketHits, PacketSurfaces};
use super::rays::{PACKET, PacketVectors};
use super::shape::{PacketShape, PreparedShape, recip};

/// [`super::PacketKernels::surfaces`].
pub(super) struct SurfaceKernel<'a> {
    pub(super) shape: &'a PacketShape,
    pub(super) normal_map: &'a [[f32; 3]; 3],
    pub(super) directions: &'a PacketVectors,
    pub(super) hits: &'a PacketHits,
    pub(super) lanes: u32,
    pub(super) surfaces: &'a mut PacketSurfaces,
}

/// [`SurfaceKernel`] with the lanes.
struct Surface<'a, S: Simd>(S, SurfaceKernel<'a>);

impl WithSimd for SurfaceKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        with_norm(simd, self.shape.xy, self.shape.rz, Surface(simd, self));
    }
}

impl<S: Simd> WithNorm<S> for Surface<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self, one: impl EvaluateNorm<S>, _: impl EvaluateNorm<S, SIDE_BY_SIDE>) {
        let Self(simd, SurfaceKernel { shape, normal_map, directions, hits, lanes, surfaces }) = self;
        let prepared = PreparedShape::new(simd, shape);
        let to_normal = Linear::<S>::splat(simd, normal_map);
        for i in 0..PACKET / S::F32_LANES {
            let active = register_bits::<S>(lanes, i);
            if active == 0 {
                continue;
            }
            let d = prepared.map.image(Triple::load(simd, directions, i));
            let hit_t: Lanes<S> = hits.t.load(simd, i);
            let t = hit_t * prepared.inv_t_scale;
            let error: Lanes<S> = hits.error.load(simd, i);
            // The search does not evaluate N at its final step. Newton's step from there bounds the error, for there may be
            // an edge between.
            let ValueAndGradient { norm, gradient, scale } =
                one.value_and_gradient(prepared.origin.along(t, d));
            let step = (t.all(1.0) - norm) * scale * recip(gradient.dot(d));
            let most = error * prepared.inv_t_scale;
            let normal = to_normal.image(gradient);
            let square = normal.dot(normal);
            let is_near = step.abs().le(most) & gradient.dot(d).lt(t.all(0.0));
            let resolved = is_near & t.all(SQUARES[0]).lt(square) & square.lt(t.all(SQUARES[1]));
            let resolved = resolved & Mask::of_bits(simd, active);
            let inverse = square.rsqrt();
            surfaces.t.store_where(resolved, i, (t + step) * prepared.t_scale);
            surfaces.error.store_where(resolved, i, error);
            for (axis, part) in [normal.x, normal.y, normal.z].into_iter().enumerate() {
                surfaces.normal[axis].store_where(resolved, i, part * inverse);
            }
            surfaces.id.copy_where(resolved, i, &hits.id);
            surfaces.lanes |= resolved.bits_from(i);
        }
    }
}
