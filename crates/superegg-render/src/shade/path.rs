//! Path tracing (Kajiya 1986): light that reaches a surface by way of other surfaces, and from the sky.
//!
//! At each point of a path the lights are sampled, as in the course's model, and a point of a shape that shines. The path
//! goes on in one direction until chance ends it. A first hit goes on in one direction for each of its lobes. Light of
//! shapes that shine is found in both ways, by samples of their area and by paths that meet them, each weighted by its
//! share of the probability (the balance heuristic of Veach 1997), and so is that of a picture of the surroundings.
//!
//! A matt surface reflects `local * diffuse * color` of the light that arrives, whatever its direction: the light of a lamp
//! of colour C that shines straight onto it counts as C, and so does that of a sky of colour C. `ambient` and ambient
//! occlusion have no part: what they stand for is traced. `specular` is the image of the lights alone. Lights have no
//! shape that a path could hit, and their light passes glass straight and tinted, as in the course's model.
//!
//! A surface with `roughness` or `metallic` is one of facets ([`Microfacets`]); of the other weights of its material it
//! keeps `diffuse`, `refracted` and `index`.

use std::f64::consts::FRAC_1_PI;

use superegg_geom::glam::DVec3;
use superegg_trace::{InstancePath, TraceRay};

use crate::camera::sobol::cosine_direction;
use crate::environment::map::EnvironmentSample;
use crate::shade::context::RenderContext;
use crate::shade::direct;
use crate::shade::emitters::EmitterSample;
use crate::shade::light_sample::toward;
use crate::shade::medium::Media;
use crate::shade::microfacet::surface::{Microfacets, Scattered};
use crate::shade::phong;
use crate::shade::point::{PathState, SurfaceOwner, SurfacePoint};
use crate::shade::state::ShadingState;

/// A way in which a surface without facets scatters light.
#[derive(Clone, Copy, Debug)]
enum Lobe {
    /// In all directions, by Lambert's law.
    Matt,
    /// By the mirror of `reflected`.
    Mirror,
    /// By the interface of a transparent shape.
    Reflected,
    /// Through that interface, in this direction.
    Refracted(DVec3),
}

/// Branches of a [`crate::camera::sobol::SampleKey`].
const LOBES: u32 = 1 << 21;
const CHOICE: u32 = LOBES + 8;
const ROULETTE: u32 = LOBES + 9;
const EMITTER: u32 = LOBES + 10;
const FACETS: u32 = LOBES + 11;
const SURROUNDINGS: u32 = LOBES + 12;

/// Only paths of less weight are likely to be ended by chance. A greater threshold saves rays, but their noise costs more.
const LEAST_WEIGHT: f64 = 0.25;
/// Heavier paths of fewer bounces always go on.
const LEAST_BOUNCES: u32 = 3;
/// The greatest probability that a longer path goes on. Between white walls no weight falls.
const MOST_LIKELY: f64 = 0.95;
/// Longer paths are so rare that no picture has one.
const MOST_BOUNCES: u32 = 512;

impl Lobe {
    /// The branch of the random numbers of a direction.
    fn branch(self) -> u32 {
        LOBES
            + match self {
                Self::Matt => 0,
                Self::Mirror => 1,
                Self::Reflected => 2,
                Self::Refracted(_) => 3,
            }
    }

    /// The lobes of a point, each with the part of the light that it scatters.
    fn of(point: &SurfacePoint<'_>) -> [(Self, DVec3); 4] {
        let SurfacePoint { weights, albedo, .. } = point;
        let (mut refracted, mut reflectance) = (DVec3::ZERO, 1.0);
        if weights.transmitted > 0.0 {
            let (ratio, _) = point.beyond();
            if let Some(found) = point.refract(ratio) {
                (refracted, reflectance) = found;
            }
        }
        [
            (Self::Matt, matt_share(point)),
            (Self::Mirror, DVec3::splat(weights.mirror)),
            (Self::Reflected, DVec3::splat(weights.transmitted * reflectance)),
            (Self::Refracted(refracted), weights.transmitted * (1.0 - reflectance) * albedo.map(f64::sqrt)),
        ]
    }

    /// A direction of the lobe, with the density of the light that it scatters.
    fn direction(self, point: &SurfacePoint<'_>, is_blurred: bool) -> DVec3 {
        let key = point.state.key.branch(self.branch());
        match self {
            Self::Matt => cosine_direction(key.point(0, 1), point.shading_normal()),
            Self::Mirror if is_blurred && point.material.gloss > 0.0 => {
                let exponent = point.material.highlight_exponent();
                point.rough_mirror(exponent, key.point(0, 1))
            }
            Self::Mirror | Self::Reflected => phong::mirror(-point.to_eye, point.mirror_normal()),
            Self::Refracted(direction) => direction,
        }
    }
}

/// The light that a matt surface scatters, of all that arrives.
fn matt_share(point: &SurfacePoint<'_>) -> DVec3 {
    phong::diffuse(&point.material, &point.weights, point.albedo)
}

/// The scattering of light from any direction by a surface, without sharp mirrors and glass.
#[expect(clippy::large_enum_variant, reason = "it lives on the stack for one sample")]
enum Receiver<'a> {
    /// A matt surface, with the part of the light that it scatters.
    Matt(DVec3),
    Facets(Microfacets<'a>),
}

impl<'a> Receiver<'a> {
    /// The receiver at a point; `None` if it scatters nothing.
    fn at(context: &RenderContext<'a>, point: &SurfacePoint<'_>) -> Option<Self> {
        if let Some(facets) = context.microfacets(point) {
            return Some(Self::Facets(facets));
        }
        let share = matt_share(point);
        (share.max_element() > 0.0).then_some(Self::Matt(share))
    }

    /// The scattered part of the light from a unit direction, with the density of paths in that direction.
    fn scattered(&self, point: &SurfacePoint<'_>, direction: DVec3) -> Scattered {
        match self {
            Self::Matt(share) => {
                let density = FRAC_1_PI * point.shading_normal().dot(direction).max(0.0);
                Scattered { light: point.open_part(direction) * density * *share, density }
            }
            Self::Facets(facets) => facets.scattered(direction),
        }
    }
}

/// The rays of one bounce.
struct PathRays<'a> {
    context: RenderContext<'a>,
    rays: Vec<TraceRay>,
    states: Vec<PathState>,
    /// The probability density of the direction of each ray; `None` for rays of sharp mirrors and glass.
    densities: Vec<Option<f64>>,
}

/// A ray that continues a path.
struct NextRay {
    direction: DVec3,
    /// The part of the light that it brings, divided by its probability.
    share: DVec3,
    density: Option<f64>,
    /// The branch of its random numbers.
    branch: u32,
    media: Media,
}

/// Adds the light that first hits scatter, reflect or transmit of shapes that shine and of the sky. The light of the lights
/// is not included. Returns the points that the rays of the first hits meet.
pub(crate) fn trace_first_paths<'a>(
    context: RenderContext<'a>,
    first: &[SurfacePoint<'a>],
    shading: &mut ShadingState<'_, 'a>,
) -> Vec<SurfacePoint<'a>> {
    let mut paths = PathRays::new(context);
    paths.add_samples_of_emitters(first, shading);
    paths.add_samples_of_surroundings(first, shading);
    first.iter().for_each(|point| paths.push_all(point, shading));
    paths.trace(shading)
}

/// Adds the light that reaches first hits by way of other surfaces. `points` are those of [`trace_first_paths`].
pub(crate) fn add_indirect_light<'a>(
    context: RenderContext<'a>,
    mut points: Vec<SurfacePoint<'a>>,
    shading: &mut ShadingState<'_, 'a>,
) {
    for bounce in 1..MOST_BOUNCES {
        if points.is_empty() {
            return;
        }
        direct::add_light(context, &points, &context.lights(), false, shading);
        let mut next = PathRays::new(context);
        next.add_samples_of_emitters(&points, shading);
        next.add_samples_of_surroundings(&points, shading);
        points.iter().for_each(|point| next.push_one(point, bounce, shading));
        points = next.trace(shading);
    }
}

impl<'a> PathRays<'a> {
    fn new(context: RenderContext<'a>) -> Self {
        Self { context, rays: Vec::new(), states: Vec::new(), densities: Vec::new() }
    }

    /// Adds the light of one sample of the shapes that shine to each point.
    fn add_samples_of_emitters(&self, points: &[SurfacePoint<'a>], shading: &mut ShadingState<'_, 'a>) {
        /// How far the hit may be from the sample, as a part of the distance.
        const TOLERANCE: f64 = 1e-6;
        let (mut rays, mut wanted) = (Vec::new(), Vec::new());
        for point in points {
            let Some(receiver) = Receiver::at(&self.context, point) else { continue };
            let key = point.state.key.branch(EMITTER);
            let Some(sample) = self.context.paths.emitters.sample(key, point.position) else { return };
            let Some((direction, weight)) = weighted_sample(point, &receiver, &sample) else { continue };
            let PathState { pixel, weight: before, key, ref media, .. } = point.state;
            let is_beyond = direction.dot(point.facing_normal()) < 0.0;
            let state = PathState {
                pixel,
                weight: before * weight,
                key,
                media: if is_beyond { point.beyond().1 } else { media.clone() },
                is_from_floor: point.is_on_floor(),
            };
            rays.push(toward(point, direction));
            wanted.push((state, sample.path, sample.point));
        }
        shading.stats.rays.shadow += rays.len() as u64;
        let hits = self.context.scene.intersect_many_counted(&rays, &mut shading.stats.coarsened);
        for ((ray, (state, path, sample)), hit) in rays.iter().zip(wanted).zip(hits) {
            let reach = (sample - ray.ray.origin).length();
            let found = self.context.surface_point(ray, hit.as_ref(), state, shading);
            let is_sample = |found: &SurfacePoint<'_>| {
                is_of(found, path) && (found.position - sample).length() <= TOLERANCE * reach
            };
            if let Some(found) = found.filter(is_sample) {
                direct::add_emission(std::slice::from_ref(&found), shading);
            }
        }
    }

    /// Adds the light of one sample of a picture of the surroundings to each point.
    fn add_samples_of_surroundings(&self, points: &[SurfacePoint<'a>], shading: &mut ShadingState<'_, 'a>) {
        let Some(map) = &self.context.environment.map else { return };
        let (mut rays, mut lights) = (Vec::new(), Vec::new());
        for point in points {
            let Some(receiver) = Receiver::at(&self.context, point) else { continue };
            let square = point.state.key.branch(SURROUNDINGS).point(0, 1);
            let Some(EnvironmentSample { direction, radiance, density }) = map.sample(square) else { return };
            let scattered = receiver.scattered(point, direction);
            let light = scattered.light * radiance / (density + scattered.density);
            let ray = toward(point, direction);
            let past = self.context.transmittance_past_floor(&ray.ray, point.is_on_floor(), f64::INFINITY);
            // Paths find the light that shines through a floor or through a medium that absorbs.
            if light.max_element() > 0.0 && past == 1.0 && !point.state.media.absorbs() {
                rays.push(ray);
                lights.push((point.state.pixel, point.state.weight * light));
            }
        }
        shading.stats.rays.shadow += rays.len() as u64;
        let coarsened = &mut shading.stats.coarsened;
        let occluded = self.context.scene.occluded_many_counted(&rays, f64::INFINITY, coarsened);
        for ((pixel, light), occluded) in lights.into_iter().zip(occluded) {
            if !occluded {
                shading.colors[pixel] += light;
            }
        }
    }

    /// The light that a ray brings which meets nothing.
    fn light_of_surroundings(&self, ray: &TraceRay, density: Option<f64>) -> DVec3 {
        let sky = self.context.sky(ray.ray.direction);
        match (&self.context.environment.map, density) {
            (Some(map), Some(density)) => {
                let of_sample = map.density(ray.ray.direction.normalize_or_zero());
                sky * (density / (density + of_sample))
            }
            _ => sky,
        }
    }

    /// The weight of the emission of a point that a ray meets, beside samples of the emitters.
    fn weight_of_meeting(&self, point: &SurfacePoint<'_>, ray: &TraceRay, density: Option<f64>) -> f64 {
        let (Some(density), SurfaceOwner::Instance(path), false) = (density, &point.owner, point.leaving)
        else {
            return 1.0;
        };
        let cos = point.to_eye.dot(point.normal).max(0.0);
        let distance_squared = (point.position - ray.ray.origin).length_squared();
        // The density of samples by solid angle, times the cosine.
        let of_sample = self.context.paths.emitters.density(path) * distance_squared;
        if of_sample == 0.0 { 1.0 } else { density * cos / (density * cos + of_sample) }
    }

    /// Adds a ray for each lobe of a first hit.
    fn push_all(&mut self, point: &SurfacePoint<'_>, shading: &mut ShadingState<'_, 'a>) {
        if let Some(facets) = self.context.microfacets(point) {
            if let Some(ray) = ray_of_facets(point, &facets) {
                self.push(point, ray, shading);
            }
            return;
        }
        for (lobe, share) in Lobe::of(point) {
            if share.max_element() > 0.0 {
                let ray = self.ray_of_lobe(point, lobe, share);
                ray.into_iter().for_each(|ray| self.push(point, ray, shading));
            }
        }
    }

    /// Adds a ray for one lobe, which is chosen by chance, unless chance ends the path.
    fn push_one(&mut self, point: &SurfacePoint<'_>, bounce: u32, shading: &mut ShadingState<'_, 'a>) {
        let ray = match self.context.microfacets(point) {
            Some(facets) => ray_of_facets(point, &facets),
            None => self.ray_of_one_lobe(point),
        };
        let Some(ray) = ray else { return };
        let key = point.state.key;
        let weight = (point.state.weight * ray.share).max_element();
        let most = if bounce < LEAST_BOUNCES { 1.0 } else { MOST_LIKELY };
        let survival = (weight / LEAST_WEIGHT).min(most);
        if key.branch(ROULETTE).point(0, 1).x < survival {
            self.push(point, NextRay { share: ray.share / survival, ..ray }, shading);
        }
    }

    /// A ray of one lobe, which is chosen by chance.
    fn ray_of_one_lobe(&self, point: &SurfacePoint<'_>) -> Option<NextRay> {
        let lobes = Lobe::of(point);
        let total: f64 = lobes.iter().map(|(_, share)| share.max_element()).sum();
        let mut chosen = point.state.key.branch(CHOICE).point(0, 1).x * total;
        for (lobe, share) in lobes {
            let likelihood = share.max_element();
            if chosen < likelihood && likelihood > 0.0 {
                return self.ray_of_lobe(point, lobe, share * (total / likelihood));
            }
            chosen -= likelihood;
        }
        None
    }

    /// A ray of a lobe that scatters this share of the light; `None` if bumps keep it from leaving.
    fn ray_of_lobe(&self, point: &SurfacePoint<'_>, lobe: Lobe, mut share: DVec3) -> Option<NextRay> {
        let direction = lobe.direction(point, self.context.picture.gloss_rays > 0);
        let (media, density) = match lobe {
            Lobe::Refracted(_) => (point.beyond().1, None),
            Lobe::Mirror | Lobe::Reflected => (point.state.media.clone(), None),
            Lobe::Matt => {
                let density = FRAC_1_PI * point.shading_normal().dot(direction).max(0.0);
                let open = point.open_part(direction);
                if open == 0.0 {
                    return None;
                }
                share *= open;
                (point.state.media.clone(), Some(density))
            }
        };
        Some(NextRay { direction, share, density, branch: lobe.branch(), media })
    }

    fn push(&mut self, point: &SurfacePoint<'_>, ray: NextRay, shading: &mut ShadingState<'_, 'a>) {
        let NextRay { direction, share, density, branch, media } = ray;
        let rays = &mut shading.stats.rays;
        let is_beyond = direction.dot(point.facing_normal()) < 0.0;
        *(match density {
            _ if is_beyond => &mut rays.refraction,
            None => &mut rays.reflection,
            Some(_) => &mut rays.ambient,
        }) += 1;
        let PathState { pixel, weight, key, .. } = point.state;
        self.rays.push(point.spawn(direction, point.footprint));
        self.densities.push(density);
        self.states.push(PathState {
            pixel,
            weight: weight * share,
            key: key.branch(branch),
            media,
            is_from_floor: point.is_on_floor(),
        });
    }

    /// Traces the rays, and adds the emission of what they meet and the sky of rays that meet nothing. Returns the points
    /// that they hit.
    fn trace(mut self, shading: &mut ShadingState<'_, 'a>) -> Vec<SurfacePoint<'a>> {
        let (rays, states) = (std::mem::take(&mut self.rays), std::mem::take(&mut self.states));
        let hits = self.context.scene.intersect_many_counted(&rays, &mut shading.stats.coarsened);
        let mut points = Vec::with_capacity(hits.len());
        for (((ray, state), hit), &density) in rays.iter().zip(states).zip(hits).zip(&self.densities) {
            let (pixel, weight) = (state.pixel, state.weight);
            let Some(point) = self.context.surface_point(ray, hit.as_ref(), state, shading) else {
                shading.colors[pixel] += weight * self.light_of_surroundings(ray, density);
                continue;
            };
            if point.material.emission > 0.0 {
                let emitted = phong::emitted(&point.material, point.albedo);
                shading.colors[pixel] +=
                    point.state.weight * emitted * self.weight_of_meeting(&point, ray, density);
            }
            points.push(point);
        }
        points
    }
}

/// A ray from a surface of facets.
fn ray_of_facets(point: &SurfacePoint<'_>, facets: &Microfacets<'_>) -> Option<NextRay> {
    let key = point.state.key;
    let choice = key.branch(CHOICE).point(0, 1).x;
    let (direction, Scattered { light, density }) = facets.sample(choice, key.branch(FACETS).point(0, 1))?;
    if point.bump.is_some() && light == DVec3::ZERO {
        return None;
    }
    let is_beyond = direction.dot(point.facing_normal()) < 0.0;
    Some(NextRay {
        direction,
        share: light / density,
        density: Some(density),
        branch: FACETS,
        media: if is_beyond { point.beyond().1 } else { point.state.media.clone() },
    })
}

/// The unit direction from a point to a sample of an emitter, and the factor of its light; `None` if one faces away from
/// the other.
fn weighted_sample(
    point: &SurfacePoint<'_>,
    receiver: &Receiver<'_>,
    sample: &EmitterSample<'_>,
) -> Option<(DVec3, DVec3)> {
    let to_sample = sample.point - point.position;
    let distance_squared = to_sample.length_squared();
    let direction = to_sample.try_normalize()?;
    let cos_there = -sample.normal.dot(direction);
    if cos_there <= 0.0 {
        return None;
    }
    let Scattered { light, density } = receiver.scattered(point, direction);
    if light.max_element() <= 0.0 {
        return None;
    }
    // Both densities by solid angle, times the cosine at the emitter.
    let (of_sample, of_direction) = (sample.density * distance_squared, density * cos_there);
    Some((direction, light * cos_there / (of_sample + of_direction)))
}

/// Whether a point is on the outside of an instance.
fn is_of(point: &SurfacePoint<'_>, path: &InstancePath) -> bool {
    !point.leaving && matches!(&point.owner, SurfaceOwner::Instance(owner) if **owner == *path)
}
