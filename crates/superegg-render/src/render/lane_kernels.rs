//! Kernels that light opaque surfaces in f32 lanes: the local part of [`crate::shade`], with its
//! formulas.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::{PACKET, PacketColumn, PacketSurfaces, PacketVectors};
use superegg_scene::{Light, LightKind, Material, Pattern};
use superegg_simd::{Lanes, Mask};
use superegg_simd::{Simd, WithSimd};

use crate::camera::view::View;
use crate::shade::context::RenderContext;
use crate::shade::lane_math::{MOST_EXPONENT, blinn_power, dot, inverse_length};
use crate::shade::phong::{self, LobeWeights};

/// Pictures with larger numbers are shaded in f64.
const F32_LIMIT: f64 = 1e12;

/// A point light relative to a pinhole camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketLight {
    /// From the camera to the light.
    offset: [f32; 3],
    color: [f32; 3],
    falloff: f32,
}

impl PacketLight {
    /// The lights of a scene; `None` if any light or setting needs shading in f64.
    pub(crate) fn all(context: &RenderContext<'_>, view: &View) -> Option<Vec<Self>> {
        let environment = context.environment;
        if !view.is_pinhole() || context.has_transmission || environment.ambient_occlusion.is_some() {
            return None;
        }
        environment.lights.iter().map(|light| Self::of(light, view.position())).collect()
    }

    fn of(light: &Light, camera: DVec3) -> Option<Self> {
        let LightKind::Point { position } = light.kind else { return None };
        let offset = position - camera;
        let fits_f32 =
            offset.abs().max(light.color.abs()).max_element() < F32_LIMIT && light.falloff.abs() < F32_LIMIT;
        (fits_f32 && light.radius == 0.0).then(|| Self {
            offset: offset.as_vec3().to_array(),
            color: light.color.as_vec3().to_array(),
            falloff: light.falloff as f32,
        })
    }
}

/// An opaque material without a pattern, in f32. It may mirror the same part of the light at every angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainMaterial {
    /// The diffuse reflectance.
    diffuse: [f32; 3],
    /// The weight of the highlight.
    specular: f32,
    /// The exponent of the highlight.
    exponent: f32,
    /// The reflected ambient light, and what the surface gives off.
    ambient: [f32; 3],
    /// The part of the light that it mirrors.
    mirror: f32,
}

impl PlainMaterial {
    /// Converts a material. `None` if it mirrors in another way, transmits, has a pattern or exceeds the limits of f32.
    pub(crate) fn of(material: &Material, context: &RenderContext<'_>) -> Option<Self> {
        let weights = LobeWeights::of(material, 1.0);
        let diffuse = phong::diffuse(material, &weights, material.color);
        let ambient =
            phong::ambient(material, &weights, material.color) + phong::emitted(material, material.color);
        let exponent = material.highlight_exponent();
        let is_plain = weights.transmitted == 0.0
            && material.pattern == Pattern::None
            && (material.reflected.is_none_or(|share| share == 0.0) || is_plain_mirror(material, context));
        let fits_f32 = diffuse.abs().max_element() < F32_LIMIT
            && material.specular.abs() < F32_LIMIT
            && ambient.abs().max_element() < F32_LIMIT
            && (0.0..MOST_EXPONENT).contains(&exponent);
        (is_plain && fits_f32).then(|| Self {
            diffuse: diffuse.as_vec3().to_array(),
            specular: material.specular as f32,
            exponent: exponent as f32,
            ambient: ambient.as_vec3().to_array(),
            mirror: weights.mirror as f32,
        })
    }

    /// The part of the light that it mirrors.
    pub(crate) fn mirror(&self) -> f32 {
        self.mirror
    }
}

/// Whether a material that mirrors gives each ray of the camera one mirrored ray of a constant weight, which only shapes can
/// stop.
fn is_plain_mirror(material: &Material, context: &RenderContext<'_>) -> bool {
    let picture = context.picture;
    let is_blurred = picture.gloss_rays > 0 && material.gloss > 0.0;
    let is_traced = picture.bounces > 0 && LobeWeights::of(material, 1.0).mirror > picture.least_weight;
    !material.fresnel && !is_blurred && is_traced && context.ground.is_none()
}

/// The materials in the lanes of a packet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketMaterials {
    diffuse: PacketVectors,
    specular: PacketColumn<f32>,
    exponent: PacketColumn<f32>,
    ambient: PacketVectors,
}

impl PacketMaterials {
    /// Black in all lanes.
    pub(crate) const NONE: Self = Self {
        diffuse: [PacketColumn::splat(0.0); 3],
        specular: PacketColumn::splat(0.0),
        exponent: PacketColumn::splat(0.0),
        ambient: [PacketColumn::splat(0.0); 3],
    };

    /// The reflected ambient light; black in lanes without a material.
    pub(crate) fn ambient(&self) -> PacketVectors {
        self.ambient
    }
}

/// Sets the material of some lanes of a packet.
pub(crate) struct SetMaterial<'a> {
    pub(crate) packet: &'a mut PacketMaterials,
    /// A mask of the lanes.
    pub(crate) lanes: u32,
    pub(crate) material: &'a PlainMaterial,
}

impl WithSimd for SetMaterial<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { packet, lanes, material } = self;
        for i in 0..PACKET / S::F32_LANES {
            let lanes = Mask::<S>::of_bits(simd, lanes >> (i * S::F32_LANES));
            let set = |column: &mut PacketColumn<f32>, value: f32| {
                column.store_where(lanes, i, Lanes::splat(simd, value));
            };
            for axis in 0..3 {
                set(&mut packet.diffuse[axis], material.diffuse[axis]);
                set(&mut packet.ambient[axis], material.ambient[axis]);
            }
            set(&mut packet.specular, material.specular);
            set(&mut packet.exponent, material.exponent);
        }
    }
}

/// The unoccluded light of one source on the surfaces of a packet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketContribution {
    /// A mask of the lanes that face the light. `color` of other lanes has no meaning.
    pub(crate) lanes: u32,
    pub(crate) color: PacketVectors,
}

impl PacketContribution {
    /// No light in any lane.
    pub(crate) const NONE: Self = Self { lanes: 0, color: [PacketColumn::splat(0.0); 3] };
}

/// Computes the unoccluded light of one source on the surfaces of a packet, by the formula of
/// [`phong::direct`].
pub(crate) struct ShadePacket<'a> {
    pub(crate) light: &'a PacketLight,
    /// The directions of the camera rays.
    pub(crate) directions: &'a PacketVectors,
    pub(crate) surfaces: &'a PacketSurfaces,
    pub(crate) materials: &'a PacketMaterials,
    /// The result. Its mask of lanes must be 0 before.
    pub(crate) contribution: &'a mut PacketContribution,
}

impl WithSimd for ShadePacket<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { light, directions, surfaces, materials, contribution } = self;
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (zero, one) = (splat(0.0), splat(1.0));
        for i in 0..PACKET / S::F32_LANES {
            let lane = |column: &PacketColumn<f32>| -> Lanes<S> { column.load(simd, i) };
            let triple = |[x, y, z]: &PacketVectors| [lane(x), lane(y), lane(z)];
            let (t, ray, normal) = (lane(&surfaces.t), triple(directions), triple(&surfaces.normal));
            let mut offset = ray;
            for axis in 0..3 {
                offset[axis] = splat(light.offset[axis]) - t * ray[axis];
            }
            let scale = inverse_length(offset);
            let to_light = [offset[0] * scale, offset[1] * scale, offset[2] * scale];
            let cos = dot(normal, to_light);
            let faces_light = zero.lt(cos);
            contribution.lanes |= (faces_light.bits() << (i * S::F32_LANES)) & surfaces.lanes;
            if !faces_light.any() {
                continue;
            }
            let to_eye = inverse_length(ray);
            let mut half = to_light;
            for axis in 0..3 {
                half[axis] = half[axis] - ray[axis] * to_eye;
            }
            let highlight = lane(&materials.specular) * blinn_power(normal, half, lane(&materials.exponent));
            let falloff = one / splat(light.falloff).mul_add(dot(offset, offset), one);
            for (axis, diffuse) in materials.diffuse.iter().enumerate() {
                let color = splat(light.color[axis]) * falloff * lane(diffuse).mul_add(cos, highlight);
                contribution.color[axis].store(i, color);
            }
        }
    }
}

/// Adds a contribution to the light in some lanes of a packet.
pub(crate) struct AddContribution<'a> {
    pub(crate) radiance: &'a mut PacketVectors,
    pub(crate) contribution: &'a PacketContribution,
    /// A mask of the lanes.
    pub(crate) lanes: u32,
}

impl WithSimd for AddContribution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { radiance, contribution, lanes } = self;
        for i in 0..PACKET / S::F32_LANES {
            let lanes = Mask::<S>::of_bits(simd, lanes >> (i * S::F32_LANES));
            for (sum, color) in radiance.iter_mut().zip(&contribution.color) {
                sum.store_where(lanes, i, sum.load(simd, i) + color.load(simd, i));
            }
        }
    }
}
