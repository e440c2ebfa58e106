//! The light that comes to points of surfaces straight from lights and from all around.

use std::rc::Rc;

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_scene::{AmbientOcclusion, Light};
use superegg_trace::{FlightRay, Footprint, Side};

use crate::integrator::{Setting, Taken};
use crate::medium::Media;
use crate::point::{Arrival, Seen, SurfacePoint};
use crate::sequence::{SampleKey, cosine_direction, disc};
use crate::shading;

/// A way from a point to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightWay {
    /// To the light: t = 1 is its place; a unit vector to a sun.
    pub(crate) direction: DVec3,
    /// The same as a unit vector.
    pub(crate) unit: DVec3,
    /// The light's colour as it comes to the point.
    pub(crate) color: DVec3,
}

impl LightWay {
    /// The way to the middle of a light; `None` where none of its light comes, whatever is between.
    pub(crate) fn to_middle(light: &Light, point: DVec3) -> Option<Self> {
        let color = light.color_at(point);
        let unit = light.direction_from(point).filter(|_| color.max_element() > 0.0)?;
        let direction = light.position().map_or(unit, |position| position - point);
        Some(Self { direction, unit, color })
    }

    /// The way to a place on the disc that a light of some radius shows to the point.
    fn to_disc(self, radius: f64, key: SampleKey, place: u32, count: u32) -> Self {
        let on_disc = radius * disc(key.point(place, count));
        let (across, down) = self.unit.any_orthonormal_pair();
        let direction = self.direction + on_disc.x * across + on_disc.y * down;
        Self { direction, unit: unit_vector(direction).unwrap_or(self.unit), ..self }
    }
}

/// Rays to lights, and what each adds where nothing is between.
#[derive(Default)]
pub(crate) struct ShadowRays {
    flights: Vec<FlightRay>,
    adds: Vec<Addition>,
}

/// What a shadow ray adds to a pixel, and what it is in.
struct Addition {
    pixel: usize,
    color: DVec3,
    media: Media,
}

impl ShadowRays {
    /// Takes a ray from a point.
    pub(crate) fn push(&mut self, point: &SurfacePoint<'_>, flight: FlightRay, color: DVec3) {
        self.flights.push(flight);
        let Arrival { pixel, media, .. } = &point.arrival;
        self.adds.push(Addition { pixel: *pixel, color, media: media.clone() });
    }

    /// Each ray with what it adds.
    fn into_pairs(self) -> impl Iterator<Item = (Addition, FlightRay)> {
        self.adds.into_iter().zip(self.flights)
    }
}

impl Addition {
    /// What is left of it at the end of a way, in world units.
    fn add_after(&self, way: f64, colors: &mut [DVec3]) {
        colors[self.pixel] += self.color * self.media.transmittance(way);
    }
}

/// Adds to the colours what lights bring to points, and what comes from all around.
pub(crate) fn add_light<'l>(
    setting: Setting<'_>,
    points: &[SurfacePoint<'_>],
    lights: &(impl Iterator<Item = (u32, &'l Light)> + Clone),
    is_first: bool,
    colors: &mut [DVec3],
    taken: &mut Taken,
) {
    let (mut ending, mut endless) = (ShadowRays::default(), ShadowRays::default());
    for point in points {
        for (number, light) in lights.clone() {
            let rays = if light.position().is_some() { &mut ending } else { &mut endless };
            ask_light(setting, point, number, light, is_first, rays);
        }
    }
    add_seen(setting, ending, 1.0, colors, taken);
    add_seen(setting, endless, f64::INFINITY, colors, taken);
    add_ambient(setting, points, is_first, colors, taken);
}

/// The rays from a point to a light: one, or some where it has a radius.
fn ask_light(
    setting: Setting<'_>,
    point: &SurfacePoint<'_>,
    number: u32,
    light: &Light,
    is_first: bool,
    asked: &mut ShadowRays,
) {
    let Some(middle) = LightWay::to_middle(light, point.position) else { return };
    let end = if light.position().is_some() { 1.0 } else { f64::INFINITY };
    let count = if light.radius > 0.0 && is_first { setting.picture.light_rays.max(1) } else { 1 };
    let key = point.arrival.key.branch(LIGHTS + number);
    for place in 0..count {
        let way = if light.radius > 0.0 { middle.to_disc(light.radius, key, place, count) } else { middle };
        let Some(color) = lit(point, &way) else { continue };
        let flight = toward(point, way.direction);
        let past_ground = setting.share_past_ground(&flight.ray, point.is_on_floor(), end);
        if past_ground > 0.0 {
            asked.push(point, flight, past_ground * point.arrival.weight * color / f64::from(count));
        }
    }
}

/// Choices of a [`SampleKey`]; a light's number is added to the first.
const LIGHTS: u32 = 1 << 16;
const AMBIENT: u32 = 1;

/// What a light adds to a point that nothing hides from it; `None` where it shines on the other side.
pub(crate) fn lit(point: &SurfacePoint<'_>, way: &LightWay) -> Option<DVec3> {
    let normal = point.facing_normal();
    (normal.dot(way.unit) > 0.0).then(|| {
        shading::direct(
            &point.material,
            &point.shares,
            point.albedo,
            way.color,
            normal,
            point.to_eye,
            way.unit,
        )
    })
}

/// Traces shadow rays up to t = `end`, and adds what comes through.
fn add_seen(setting: Setting<'_>, asked: ShadowRays, end: f64, colors: &mut [DVec3], taken: &mut Taken) {
    taken.rays.shadow += asked.flights.len() as u64;
    let stopped = setting.scene.occluded_many(&asked.flights, end);
    let mut dimmed = ShadowRays::default();
    for ((addition, flight), stopped) in asked.into_pairs().zip(stopped) {
        if !stopped {
            addition.add_after(flight.ray.direction.length(), colors);
        } else if setting.lets_light_through {
            dimmed.flights.push(flight);
            dimmed.adds.push(addition);
        }
    }
    add_dimmed(setting, dimmed, end, colors, taken);
}

/// Follows rays that something stops straight on through what lets light through: each surface takes its share and colours the rest, each inside
/// takes what it absorbs. Each also mirrors its part away, which makes the rim of a glass ball's shadow dark; but light is not bent on this way, so there is
/// no bright focus in it.
pub(crate) fn add_dimmed(
    setting: Setting<'_>,
    mut rays: ShadowRays,
    end: f64,
    colors: &mut [DVec3],
    taken: &mut Taken,
) {
    for _ in 0..=setting.picture.bounces {
        if rays.flights.is_empty() {
            return;
        }
        let hits = setting.scene.intersect_many(&rays.flights);
        taken.rays.shadow += hits.len() as u64;
        let mut next = ShadowRays::default();
        for ((addition, flight), hit) in rays.into_pairs().zip(hits) {
            let Some(hit) = hit.filter(|hit| hit.t < end) else {
                addition.add_after(flight.ray.direction.length(), colors);
                continue;
            };
            let surface = setting.scene.interaction(&hit);
            let direction = flight.ray.direction;
            let way = (surface.position - flight.ray.origin).length();
            let seen = Seen {
                normal: surface.normal,
                direction: unit_vector(direction).unwrap_or(surface.normal),
                width: flight.footprint.width,
            };
            let albedo = setting.albedo(&surface.material, &hit, &seen);
            let cos = seen.direction.dot(surface.normal).abs();
            let shares = shading::Shares::of(&surface.material, cos);
            let path = Rc::new(hit.path);
            let (before, beyond) = addition.media.across(&path, &surface.material, surface.leaving);
            let ratio = beyond.index() / before;
            let clear = 1.0 - shading::reflectance(cos, ratio.max(ratio.recip()));
            let color = addition.color
                * addition.media.transmittance(way)
                * shares.through
                * clear
                * albedo.map(f64::sqrt);
            if color.max_element() > setting.picture.least_weight {
                // t = 1 stays the place of the light.
                let rest =
                    if end.is_finite() { flight.ray.point_at(1.0) - surface.position } else { direction };
                let (ray, mut departure) = surface.spawn_ray(rest);
                departure.side = if surface.leaving { Side::Outward } else { Side::Inward };
                next.flights.push(FlightRay { ray, departure: Some(departure), ..flight });
                next.adds.push(Addition { pixel: addition.pixel, color, media: beyond });
            }
        }
        rays = next;
    }
}

/// Adds the ambient part: of white light from all sides, or with ambient occlusion of what comes from the sky within its distance.
fn add_ambient(
    setting: Setting<'_>,
    points: &[SurfacePoint<'_>],
    is_first: bool,
    colors: &mut [DVec3],
    taken: &mut Taken,
) {
    let parts = points
        .iter()
        .map(|point| point.arrival.weight * shading::ambient(&point.material, &point.shares, point.albedo));
    let Some(occlusion) = setting.surroundings.ambient_occlusion else {
        for (point, part) in points.iter().zip(parts) {
            colors[point.arrival.pixel] += part;
        }
        return;
    };
    // What is seen in mirrors and through glass gets fewer.
    let count = if is_first { occlusion.samples.max(1) } else { occlusion.samples.div_ceil(4).max(1) };
    let parts: Vec<DVec3> = parts.collect();
    let lit = |i: usize| parts[i].max_element() > 0.0;
    for (i, direction) in open_ways(setting, points, lit, count, occlusion.distance, taken) {
        let sky = setting.surroundings.sky.map_or(DVec3::ONE, |sky| sky.color(direction));
        colors[points[i].arrival.pixel] += parts[i] * sky / f64::from(count);
    }
}

/// Of rays from each point to all sides of its surface the share that gets as far as it should.
pub(crate) fn open_shares(
    setting: Setting<'_>,
    occlusion: AmbientOcclusion,
    points: &[SurfacePoint<'_>],
    taken: &mut Taken,
) -> Vec<f64> {
    let count = occlusion.samples.max(1);
    let mut shares = vec![0.0; points.len()];
    for (i, _) in open_ways(setting, points, |_| true, count, occlusion.distance, taken) {
        shares[i] += 1.0 / f64::from(count);
    }
    shares
}

/// The unit directions to all sides of the points that are asked for in which nothing is within the distance, with the numbers of the points.
fn open_ways(
    setting: Setting<'_>,
    points: &[SurfacePoint<'_>],
    is_asked: impl Fn(usize) -> bool,
    count: u32,
    distance: f64,
    taken: &mut Taken,
) -> impl Iterator<Item = (usize, DVec3)> {
    let (mut rays, mut ways) = (Vec::new(), Vec::new());
    for (i, point) in points.iter().enumerate().filter(|(i, _)| is_asked(*i)) {
        let key = point.arrival.key.branch(AMBIENT);
        for place in 0..count {
            let direction = cosine_direction(key.point(place, count), point.facing_normal());
            let ray = toward(point, distance * direction);
            if setting.share_past_ground(&ray.ray, point.is_on_floor(), 1.0) > 0.0 {
                rays.push(ray);
                ways.push((i, direction));
            }
        }
    }
    taken.rays.ambient += rays.len() as u64;
    let stopped = setting.scene.occluded_many(&rays, 1.0);
    ways.into_iter().zip(stopped).filter(|(_, stopped)| !stopped).map(|(way, _)| way)
}

/// A ray from a point to a light.
pub(crate) fn toward(point: &SurfacePoint<'_>, direction: DVec3) -> FlightRay {
    point.spawn(direction, Footprint { spread: 0.0, ..point.footprint })
}
