//! Laws of surfaces of facets.

use std::rc::Rc;

use superegg_scene::Material;
use superegg_trace::{Footprint, InstancePath};

use super::*;
use crate::camera::sobol::{SampleKey, sobol};
use crate::shade::medium::Media;
use crate::shade::phong::LobeWeights;
use crate::shade::point::{MaterialRef, PathState, SurfaceOwner};

/// A point that is seen at a cosine, from outside of the shape or from within.
fn point(material: &Material, cos: f64, leaving: bool) -> SurfacePoint<'_> {
    let mut path = InstancePath::default();
    path.push(0);
    let path = Rc::new(path);
    let media = if leaving { Media::default().entering(&path, material) } else { Media::default() };
    let sin = (1.0 - cos * cos).sqrt();
    let normal = DVec3::new(0.48, -0.64, 0.6);
    let (across, down) = normal.any_orthonormal_pair();
    let facing = if leaving { -normal } else { normal };
    SurfacePoint {
        state: PathState {
            pixel: 0,
            weight: DVec3::ONE,
            key: SampleKey::new((0, 0), 0),
            media,
            is_from_floor: false,
        },
        owner: SurfaceOwner::Instance(path),
        position: DVec3::ZERO,
        position_error: 0.0,
        normal,
        leaving,
        to_eye: sin * (0.8 * across + 0.6 * down) + cos * facing,
        footprint: Footprint { width: 0.0, spread: 0.0 },
        material: MaterialRef::Scene(material),
        albedo: material.color,
        weights: LobeWeights::of(material, cos),
        bump: None,
    }
}

fn materials() -> Vec<Material> {
    let mut all = Vec::new();
    for roughness in [0.0, 0.1, 0.33, 0.7, 1.0] {
        for (metallic, refracted, index) in [
            (1.0, None, 1.5),
            (0.0, None, 1.5),
            (0.4, None, 2.4),
            (0.0, Some(1.0), 1.5),
            (0.0, Some(1.0), 1.33),
            (0.2, Some(0.6), 1.7),
        ] {
            all.push(Material {
                roughness: Some(roughness),
                metallic,
                refracted,
                index,
                diffuse: 1.0,
                ..Material::default()
            });
        }
    }
    all
}

/// Directions spread evenly over the sphere.
fn on_sphere(square: DVec2) -> DVec3 {
    let z = 1.0 - 2.0 * square.y;
    (DVec2::from_angle(TAU * square.x) * (1.0 - z * z).sqrt()).extend(z)
}

#[test]
fn white_surfaces_in_a_white_world_are_white() {
    let tables = AlbedoTables::new();
    for material in materials() {
        for (cos, leaving) in
            [(1.0, false), (0.7, false), (0.2, false), (0.03, false), (0.9, true), (0.5, true), (0.1, true)]
        {
            let point = point(&material, cos, leaving);
            let surface = Microfacets::of(&tables, &point).unwrap();
            let count = 1 << 15;
            // Each way by itself: the mean of a choice among them would be noisier than the tables.
            let (mut white, mut before) = (0.0, 0.0);
            for chance in surface.chances {
                let of_way = |i| surface.sample(before + chance * sobol(i, 3).x, sobol(i, 4));
                let found = (0..count).filter_map(of_way);
                let sum: f64 = found.map(|(_, scattered)| scattered.light.x / scattered.density).sum();
                white += chance * sum / f64::from(count);
                before += chance;
            }
            let bound = if material.refracted.is_some() { 2e-3 } else { 1e-3 };
            assert!((white - 1.0).abs() < bound, "{material:?} {cos} {leaving}: {white}");
        }
    }
}

#[test]
fn directions_are_drawn_with_their_density() {
    let tables = AlbedoTables::new();
    for material in materials().into_iter().filter(|material| material.roughness > Some(0.2)) {
        for (cos, leaving) in [(0.8, false), (0.25, false), (0.6, true)] {
            let point = point(&material, cos, leaving);
            let surface = Microfacets::of(&tables, &point).unwrap();
            let test = |d: DVec3| [1.0, d.x, d.y * d.z, f64::from(u8::from(d.dot(point.normal) > 0.0))];
            let (mut drawn, mut integral) = ([0.0; 4], [0.0; 4]);
            let count = 1 << 16;
            for i in 0..count {
                if let Some((direction, _)) = surface.sample(sobol(i, 3).x, sobol(i, 4)) {
                    drawn.iter_mut().zip(test(direction)).for_each(|(sum, x)| *sum += x);
                }
                let direction = on_sphere(sobol(i, 5));
                let density = 2.0 * TAU * surface.scattered(direction).density;
                integral.iter_mut().zip(test(direction)).for_each(|(sum, x)| *sum += density * x);
            }
            for (a, b) in drawn.into_iter().zip(integral) {
                assert!((a - b).abs() < 2e-2 * f64::from(count), "{material:?} {cos} {leaving}: {a} {b}");
            }
        }
    }
}

#[test]
fn light_may_go_either_way() {
    let tables = AlbedoTables::new();
    for mut material in materials() {
        material.color = DVec3::new(0.9, 0.4, 0.1);
        material.diffuse = 0.6;
        let there = point(&material, 0.7, false);
        let surface = Microfacets::of(&tables, &there).unwrap();
        for i in 0..64 {
            let direction = on_sphere(sobol(i, 7));
            let cos = direction.dot(there.normal);
            // From the other end: on the same side, or from within the glass.
            let mut back = point(&material, 0.5, cos < 0.0);
            back.to_eye = direction;
            let turned = Microfacets::of(&tables, &back).unwrap();
            let forward = surface.scattered(direction).light / cos.abs();
            let backward = turned.scattered(there.to_eye).light / 0.7;
            // Radiance is squeezed by the square of the index.
            let squeeze = if cos < 0.0 { material.index * material.index } else { 1.0 };
            let difference = (forward - squeeze * backward).abs().max_element();
            assert!(
                difference <= 1e-6 * (1e-3 + forward.max_element()),
                "{material:?} {cos}: {forward} {backward}"
            );
        }
    }
}
