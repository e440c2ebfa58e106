//! Light on opaque surfaces that a packet of camera rays sees, in lanes of f32: the plain part of [`crate::shading`], whose formulas it shares.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::{PACKET, PacketColumn, PacketSurfaces, PacketVectors};
use superegg_scene::{Light, LightKind, Material, Pattern};
use superegg_simd::{Lanes, Mask};
use superegg_simd::{Simd, WithSimd};

use crate::camera::view::View;
use crate::shade::context::RenderContext;
use crate::shade::phong::{self, LobeWeights};

/// Numbers beyond this are f64's.
const MOST: f64 = 1e12;
/// Sharper highlights need the digits of f64.
const MOST_EXPONENT: f64 = 2000.0;

/// A light that shines from one point to all sides, as a camera at one place sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketLight {
    /// From the camera to the light.
    place: [f32; 3],
    color: [f32; 3],
    falloff: f32,
}

impl PacketLight {
    /// The lights of a picture all of whose opaque surfaces may be lit in lanes; `None` where something asks for more.
    pub(crate) fn all(context: &RenderContext<'_>, view: &View) -> Option<Vec<Self>> {
        let environment = context.environment;
        if !view.is_pinhole() || context.lets_light_through || environment.ambient_occlusion.is_some() {
            return None;
        }
        environment.lights.iter().map(|light| Self::of(light, view.position())).collect()
    }

    fn of(light: &Light, camera: DVec3) -> Option<Self> {
        let LightKind::Point { position } = light.kind else { return None };
        let place = position - camera;
        let is_held = place.abs().max(light.color.abs()).max_element() < MOST && light.falloff.abs() < MOST;
        (is_held && light.radius == 0.0).then(|| Self {
            place: place.as_vec3().to_array(),
            color: light.color.as_vec3().to_array(),
            falloff: light.falloff as f32,
        })
    }
}

/// An opaque surface of one colour, as lanes see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainMaterial {
    /// What of a light's colour it scatters, and its highlight.
    diffuse: [f32; 3],
    specular: f32,
    exponent: f32,
    /// Its part of the ambient light.
    ambient: [f32; 3],
}

impl PlainMaterial {
    /// That of a material which neither mirrors nor lets light through and has no pattern.
    pub(crate) fn of(material: &Material) -> Option<Self> {
        let weights = LobeWeights::of(material, 1.0);
        let diffuse = weights.local * material.diffuse * material.color;
        let ambient = phong::ambient(material, &weights, material.color);
        let exponent = material.highlight_exponent();
        let is_plain = material.reflected.is_none_or(|share| share == 0.0)
            && weights.is_local()
            && material.pattern == Pattern::None;
        let is_held = diffuse.abs().max_element() < MOST
            && material.specular.abs() < MOST
            && ambient.abs().max_element() < MOST
            && (0.0..MOST_EXPONENT).contains(&exponent);
        (is_plain && is_held).then(|| Self {
            diffuse: diffuse.as_vec3().to_array(),
            specular: material.specular as f32,
            exponent: exponent as f32,
            ambient: ambient.as_vec3().to_array(),
        })
    }
}

/// The finishes of a packet's surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketMaterials {
    diffuse: PacketVectors,
    specular: PacketColumn<f32>,
    exponent: PacketColumn<f32>,
    ambient: PacketVectors,
}

impl PacketMaterials {
    /// Of nothing yet.
    pub(crate) const NONE: Self = Self {
        diffuse: [PacketColumn::splat(0.0); 3],
        specular: PacketColumn::splat(0.0),
        exponent: PacketColumn::splat(0.0),
        ambient: [PacketColumn::splat(0.0); 3],
    };

    /// What ambient light brings to the surfaces; nothing to lanes that were not set.
    pub(crate) fn ambient(&self) -> PacketVectors {
        self.ambient
    }
}

/// Gives a finish to lanes of a packet.
pub(crate) struct SetMaterial<'a> {
    pub(crate) packet: &'a mut PacketMaterials,
    /// A bit for each.
    pub(crate) lanes: u32,
    pub(crate) finish: &'a PlainMaterial,
}

impl WithSimd for SetMaterial<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { packet, lanes, finish } = self;
        for i in 0..PACKET / S::F32_LANES {
            let lanes = Mask::<S>::of_bits(simd, lanes >> (i * S::F32_LANES));
            let set = |column: &mut PacketColumn<f32>, value: f32| {
                column.store_where(lanes, i, Lanes::splat(simd, value));
            };
            for axis in 0..3 {
                set(&mut packet.diffuse[axis], finish.diffuse[axis]);
                set(&mut packet.ambient[axis], finish.ambient[axis]);
            }
            set(&mut packet.specular, finish.specular);
            set(&mut packet.exponent, finish.exponent);
        }
    }
}

/// What a light brings to the surfaces of a packet if nothing is between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PacketContribution {
    /// The lanes that it shines on, a bit for each.
    pub(crate) lanes: u32,
    pub(crate) color: PacketVectors,
}

impl PacketContribution {
    /// Of no light yet.
    pub(crate) const NONE: Self = Self { lanes: 0, color: [PacketColumn::splat(0.0); 3] };
}

/// One light on the surfaces that a packet sees, as [`shading::direct`] has it.
pub(crate) struct ShadePacket<'a> {
    pub(crate) light: &'a PacketLight,
    /// The beam's directions.
    pub(crate) directions: &'a PacketVectors,
    pub(crate) surfaces: &'a PacketSurfaces,
    pub(crate) finish: &'a PacketMaterials,
    /// Where what it brings goes, of no lanes yet.
    pub(crate) shine: &'a mut PacketContribution,
}

impl WithSimd for ShadePacket<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { light, directions, surfaces, finish, shine } = self;
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (zero, one) = (splat(0.0), splat(1.0));
        for i in 0..PACKET / S::F32_LANES {
            let lane = |column: &PacketColumn<f32>| -> Lanes<S> { column.load(simd, i) };
            let triple = |[x, y, z]: &PacketVectors| [lane(x), lane(y), lane(z)];
            let (t, ray, normal) = (lane(&surfaces.t), triple(directions), triple(&surfaces.normal));
            let mut way = ray;
            for axis in 0..3 {
                way[axis] = splat(light.place[axis]) - t * ray[axis];
            }
            let scale = inverse_length(way);
            let to_light = [way[0] * scale, way[1] * scale, way[2] * scale];
            let cos = dot(normal, to_light);
            let lit = zero.lt(cos);
            shine.lanes |= (lit.bits() << (i * S::F32_LANES)) & surfaces.lanes;
            if !lit.any() {
                continue;
            }
            let to_eye = inverse_length(ray);
            let mut half = to_light;
            for axis in 0..3 {
                half[axis] = half[axis] - ray[axis] * to_eye;
            }
            let cos_half = (dot(normal, half) * inverse_length(half)).max(zero);
            let exponent = lane(&finish.exponent);
            // 0 to the power of 0 is 1; a logarithm of 0 is large enough for other powers to be nothing.
            let log_cos = cos_half.max(splat(f32::MIN_POSITIVE)).log2_quick();
            // Not a subnormal number, which would take many times as long.
            let power = (exponent * log_cos).max(splat(-60.0));
            let highlight = lane(&finish.specular) * power.exp2();
            let falloff = one / splat(light.falloff).mul_add(dot(way, way), one);
            for (axis, diffuse) in finish.diffuse.iter().enumerate() {
                let color = splat(light.color[axis]) * falloff * lane(diffuse).mul_add(cos, highlight);
                shine.color[axis].store(i, color);
            }
        }
    }
}

/// Adds what a light brings to lanes of a packet.
pub(crate) struct AddContribution<'a> {
    pub(crate) light: &'a mut PacketVectors,
    pub(crate) shine: &'a PacketContribution,
    /// A bit for each.
    pub(crate) lanes: u32,
}

impl WithSimd for AddContribution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { light, shine, lanes } = self;
        for i in 0..PACKET / S::F32_LANES {
            let lanes = Mask::<S>::of_bits(simd, lanes >> (i * S::F32_LANES));
            for (light, shine) in light.iter_mut().zip(&shine.color) {
                light.store_where(lanes, i, light.load(simd, i) + shine.load(simd, i));
            }
        }
    }
}

#[inline(always)]
fn dot<S: Simd>(a: [Lanes<S>; 3], b: [Lanes<S>; 3]) -> Lanes<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// 1 over the length, large where there is none.
#[inline(always)]
fn inverse_length<S: Simd>(v: [Lanes<S>; 3]) -> Lanes<S> {
    let square = dot(v, v);
    square.max(square.all(f32::MIN_POSITIVE)).rsqrt()
}
