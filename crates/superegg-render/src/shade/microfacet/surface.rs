//! The scattering of light by a surface with `roughness` or `metallic`.
//!
//! The surface is a blend by `metallic` of a metal, whose colour is its reflectance head on, and of a dielectric of the
//! material's index; of the dielectric, `refracted` is rough glass (Walter et al. 2007) and the rest is matt under a
//! coat. Single scattering is that of GGX facets. The lost light comes back as diffuse light (Kulla and Conty 2017), and
//! what the coat does not reflect reaches the matt part, which scatters `diffuse * color` of it. So nothing is lost if
//! colours are white, and light may go either way along each path.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use superegg_geom::glam::{DVec2, DVec3};

use crate::camera::sobol::cosine_direction;
use crate::shade::bump::Bump;
use crate::shade::microfacet::albedo::{AlbedoTables, GlassAlbedo, LEAST_RATIO, MirrorAlbedo};
use crate::shade::microfacet::ggx::{Ggx, grazing};
use crate::shade::phong;
use crate::shade::point::SurfacePoint;

/// A surface at a point, seen from one side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Microfacets<'a> {
    /// The axes of the surface in the world: two in its plane, then the normal on the side of the eye.
    axes: [DVec3; 3],
    /// The direction to the eye in that frame.
    eye: DVec3,
    ggx: Ggx,
    mirror: MirrorAlbedo<'a>,
    metal: f64,
    /// The reflectance of the metal head on.
    metal_color: DVec3,
    coat: f64,
    /// The reflectance of the coat head on.
    coat_reflectance: f64,
    /// The albedo of the matt part.
    matt: DVec3,
    glass: Option<Glass<'a>>,
    /// The probability of each way of [`Microfacets::sample`], as in [`WAYS`].
    chances: [f64; 5],
    /// Bumps, with the unit normal of the shape on the side of the eye.
    bump: Option<(Bump, DVec3)>,
}

/// The glass of a surface.
#[derive(Clone, Copy, Debug)]
struct Glass<'a> {
    weight: f64,
    /// The index of refraction beyond the surface divided by that before it.
    ratio: f64,
    /// The colour of light that crosses the surface once.
    tint: DVec3,
    albedo: GlassAlbedo<'a>,
}

/// The light that a surface scatters from one direction to the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scattered {
    /// The part of the light from there, for each unit of solid angle; the cosine is in it.
    pub(crate) light: DVec3,
    /// The probability density of the direction in [`Microfacets::sample`].
    pub(crate) density: f64,
}

/// A way to choose a direction.
#[derive(Clone, Copy, Debug)]
enum Way {
    Mirror,
    Glass,
    /// By the cosine.
    Matt,
    /// Evenly: most of the light that one bounce loses is at grazing angles.
    GivenBack,
    /// The same beyond glass.
    GivenBackBeyond,
}

const WAYS: [Way; 5] = [Way::Mirror, Way::Glass, Way::Matt, Way::GivenBack, Way::GivenBackBeyond];

/// The density of even directions in a hemisphere.
const EVEN: f64 = 0.5 * FRAC_1_PI;

/// The smallest mean loss that is given back.
const LEAST_LOSS: f64 = 1e-9;

impl<'a> Microfacets<'a> {
    /// The surface at a point; `None` if its material has neither roughness nor metal.
    pub(crate) fn of(tables: &'a AlbedoTables, point: &SurfacePoint<'_>) -> Option<Self> {
        let roughness = point.material.facet_roughness()?;
        let material = &point.material;
        let normal = point.mirror_normal();
        let (across, down) = normal.any_orthonormal_pair();
        let eye = DVec3::new(across.dot(point.to_eye), down.dot(point.to_eye), normal.dot(point.to_eye));
        // A normal that has been rounded may look away from the eye.
        let eye = DVec3 { z: eye.z.max(1e-9), ..eye }.normalize();
        let metal = material.metallic;
        let through = (1.0 - metal) * material.refracted.unwrap_or(0.0).min(1.0);
        let glass = (through > 0.0).then(|| {
            let ratio = point.beyond().0.recip();
            let ratio = if ratio >= 1.0 { ratio.max(LEAST_RATIO) } else { ratio.min(LEAST_RATIO.recip()) };
            let albedo = tables.glass(roughness, ratio);
            Glass { weight: through, ratio, tint: point.albedo.max(DVec3::ZERO).map(f64::sqrt), albedo }
        });
        let index = material.index / point.state.media.index();
        let head_on = (index - 1.0) / (index + 1.0);
        let mut surface = Self {
            axes: [across, down, normal],
            eye,
            ggx: Ggx::new(roughness),
            mirror: tables.mirror(roughness),
            metal,
            metal_color: point.albedo,
            coat: (1.0 - metal - through).max(0.0),
            coat_reflectance: head_on * head_on,
            matt: material.diffuse * point.albedo,
            glass,
            chances: [0.0; 5],
            bump: point.bump.as_deref().map(|bump| (*bump, point.facing_normal())),
        };
        surface.chances = surface.chances();
        Some(surface)
    }

    /// The probability of each way: that part of the light which it scatters.
    fn chances(&self) -> [f64; 5] {
        let (mirror, cos) = (&self.mirror, self.eye.z);
        let (full, dark) = (mirror.once(1.0, cos), mirror.once(0.0, cos));
        let mirrored = self.metal * (self.metal_color.max_element() * (full - dark) + dark)
            + self.coat * mirror.once(self.coat_reflectance, cos);
        let matt = self.coat * (1.0 - mirror.whole(self.coat_reflectance, cos)) * self.matt;
        let mut parts =
            [mirrored, 0.0, matt.max_element(), self.given_back().max_element() * mirror.lost(cos), 0.0];
        if let Some(Glass { weight, albedo, .. }) = &self.glass {
            let lost = weight * albedo.lost(false, cos);
            parts[1] = weight * albedo.kept(cos);
            parts[3] += lost * (1.0 - albedo.beyond);
            parts[4] = lost * albedo.beyond;
        }
        let total: f64 = parts.iter().sum();
        parts.map(|part| if total > 0.0 { part / total } else { 0.0 })
    }

    /// The part of the light lost by metal and coat that is given back.
    fn given_back(&self) -> DVec3 {
        self.metal * self.metal_color.map(|channel| self.mirror.given_back(channel))
            + self.coat * self.mirror.given_back(self.coat_reflectance)
    }

    /// The light that arrives from a unit direction in the world and is scattered to the eye.
    pub(crate) fn scattered(&self, direction: DVec3) -> Scattered {
        let scattered = self.scattered_locally(self.in_frame(direction));
        Scattered { light: self.past_bumps(direction) * scattered.light, ..scattered }
    }

    /// The part of the light from a unit direction in the world that bumps let pass: none where it is on one side of the facets
    /// and on the other of the shape.
    fn past_bumps(&self, direction: DVec3) -> f64 {
        let Some((bump, facing)) = &self.bump else { return 1.0 };
        let cos = facing.dot(direction);
        match self.axes[2].dot(direction) > 0.0 {
            true => bump.open_part(cos),
            false if cos < 0.0 => 1.0,
            false => 0.0,
        }
    }

    /// The part of the light of a lamp without a size that is scattered to the eye, with the cosine. Lamps have no image in
    /// a surface that is nearly smooth, and none beyond glass.
    pub(crate) fn lit_by_lamp(&self, direction: DVec3) -> DVec3 {
        let to_lamp = self.in_frame(direction);
        if to_lamp.z <= 0.0 {
            return DVec3::ZERO;
        }
        let light = if self.ggx.has_highlights() {
            self.scattered_locally(to_lamp).light
        } else {
            self.diffuse(to_lamp.z)
        };
        PI * self.past_bumps(direction) * light
    }

    /// A direction in the world, by a random number in [0, 1) and a random point of the unit square, and what the surface
    /// scatters from there. `None` if the light that comes to the eye this way is counted by another.
    pub(crate) fn sample(&self, choice: f64, square: DVec2) -> Option<(DVec3, Scattered)> {
        let mut rest = choice;
        let last = self.chances.iter().rposition(|chance| *chance > 0.0)?;
        let chosen = self.chances.iter().enumerate().find(|(way, chance)| {
            let is_chosen = rest < **chance || *way == last;
            if !is_chosen {
                rest -= **chance;
            }
            is_chosen
        });
        let (way, chance) = chosen.map(|(way, chance)| (WAYS[way], *chance))?;
        let direction = match way {
            Way::Mirror => self.mirrored(self.ggx.visible_facet(self.eye, square))?,
            Way::Glass => {
                let facet = self.ggx.visible_facet(self.eye, square);
                let refracted = phong::refract(-self.eye, facet, self.glass?.ratio.recip());
                let is_through = |reflectance: &f64| rest >= chance * reflectance;
                match refracted.filter(|(_, reflectance)| is_through(reflectance)) {
                    Some((direction, _)) if direction.z < 0.0 => direction,
                    Some(_) => return None,
                    None => self.mirrored(facet)?,
                }
            }
            Way::Matt => cosine_direction(square, DVec3::Z),
            Way::GivenBack => even_direction(square),
            Way::GivenBackBeyond => -even_direction(square),
        };
        let scattered = self.scattered_locally(direction);
        let is_valid = scattered.density > 0.0 && scattered.density.is_finite();
        let [across, down, normal] = self.axes;
        let in_world = direction.x * across + direction.y * down + direction.z * normal;
        is_valid.then(|| {
            let direction = in_world.normalize();
            (direction, Scattered { light: self.past_bumps(direction) * scattered.light, ..scattered })
        })
    }

    /// The direction whose light a facet mirrors to the eye; `None` if another facet is in its way.
    fn mirrored(&self, facet: DVec3) -> Option<DVec3> {
        Some(phong::mirror(-self.eye, facet)).filter(|direction| direction.z > 0.0)
    }

    fn in_frame(&self, direction: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(direction)))
    }

    fn scattered_locally(&self, light: DVec3) -> Scattered {
        if light.z > 0.0 { self.reflected(light) } else { self.transmitted(light) }
    }

    /// The diffuse part of the light that comes from this side at a cosine, with the cosine.
    fn diffuse(&self, cos: f64) -> DVec3 {
        let Self { mirror, eye, coat, coat_reflectance, .. } = self;
        let mut sum = DVec3::ZERO;
        if mirror.mean_lost() > LEAST_LOSS {
            let lost = mirror.lost(eye.z) * mirror.lost(cos) / mirror.mean_lost();
            sum += lost * self.given_back();
        }
        let below = 1.0 - mirror.mean_whole(*coat_reflectance);
        if *coat > 0.0 && below > LEAST_LOSS {
            let [to_eye, to_light] = [eye.z, cos].map(|cos| 1.0 - mirror.whole(*coat_reflectance, cos));
            sum += *coat * self.matt * (to_eye * to_light / below);
        }
        if let Some(Glass { weight, albedo, .. }) = &self.glass
            && albedo.mean_lost(false) > LEAST_LOSS
        {
            let lost = albedo.lost(false, eye.z) * albedo.lost(false, cos) / albedo.mean_lost(false);
            sum += weight * (1.0 - albedo.beyond) * lost;
        }
        FRAC_1_PI * cos * sum
    }

    fn reflected(&self, light: DVec3) -> Scattered {
        let Self { eye, ggx, metal, metal_color, coat, coat_reflectance, chances, .. } = self;
        let Some(facet) = (*eye + light).try_normalize() else {
            return Scattered { light: DVec3::ZERO, density: 0.0 };
        };
        let cos = eye.dot(facet).clamp(0.0, 1.0);
        let rate = ggx.density(facet) / (4.0 * eye.z);
        let grazing = grazing(cos);
        let toward_one = |head_on: f64| head_on + (1.0 - head_on) * grazing;
        let mut reflectance = *metal * metal_color.map(toward_one) + *coat * toward_one(*coat_reflectance);
        let mut chance = chances[0];
        if let Some(Glass { weight, ratio, .. }) = &self.glass {
            let of_facet =
                phong::refract(-*eye, facet, ratio.recip()).map_or(1.0, |(_, reflectance)| reflectance);
            reflectance += weight * of_facet;
            chance += chances[1] * of_facet;
        }
        Scattered {
            light: reflectance * (rate * ggx.visible_to_both(*eye, light)) + self.diffuse(light.z),
            density: chance * rate * ggx.visible(*eye) + chances[2] * FRAC_1_PI * light.z + chances[3] * EVEN,
        }
    }

    fn transmitted(&self, light: DVec3) -> Scattered {
        let nothing = Scattered { light: DVec3::ZERO, density: 0.0 };
        let (Some(Glass { weight, ratio, tint, albedo }), true) = (self.glass, light.z < 0.0) else {
            return nothing;
        };
        let Self { eye, ggx, chances, .. } = self;
        let cos = -light.z;
        let mut scattered = Scattered { density: chances[4] * EVEN, ..nothing };
        if albedo.mean_lost(true) > LEAST_LOSS {
            let lost = albedo.lost(false, eye.z) * albedo.lost(true, cos) / albedo.mean_lost(true);
            scattered.light = tint * (weight * albedo.beyond * lost * FRAC_1_PI * cos);
        }
        // The facet points to the thinner side.
        let toward = (*eye + ratio * light) * if ratio >= 1.0 { -1.0 } else { 1.0 };
        let Some(facet) = toward.try_normalize().filter(|facet| facet.z > 0.0) else { return scattered };
        let (to_eye, to_light) = (eye.dot(facet), light.dot(facet));
        if to_eye <= 0.0 || to_light >= 0.0 {
            return scattered;
        }
        let Some((_, reflectance)) = phong::refract(-*eye, facet, ratio.recip()) else { return scattered };
        let spread = ratio * ratio * -to_light / (to_eye + ratio * to_light).powi(2);
        let rate = (1.0 - reflectance) * ggx.density_of_visible(*eye, facet) * spread;
        scattered.light += tint * (weight * rate * ggx.visible(light));
        scattered.density += chances[1] * rate;
        scattered
    }
}

/// A direction with z > 0 by a point of the unit square, with the density [`EVEN`].
fn even_direction(square: DVec2) -> DVec3 {
    let z = square.x;
    (DVec2::from_angle(TAU * square.y) * (1.0 - z * z).max(0.0).sqrt()).extend(z)
}

#[cfg(test)]
mod tests;
