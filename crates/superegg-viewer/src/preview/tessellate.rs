//! Triangle meshes of superquadrics: patches of the course text's parameterisation (4.1.3).

use std::f64::consts::FRAC_PI_2;

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Superquadric};
use superegg_scene::Patches;

use super::superellipse::quarter;

/// A vertex of a unit shape.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    /// Position in the box [-1, 1]^3.
    pub(crate) position: [f32; 3],
    /// Unit normal, outwards.
    pub(crate) normal: [f32; 3],
}

/// A unit shape as triangles and patch edges. Triangles are counter-clockwise as seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mesh {
    /// The south pole, the rings from south to north, the north pole.
    pub(crate) vertices: Vec<Vertex>,
    /// Fans at the poles, two triangles for each patch between.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The patch edges, each once.
    pub(crate) edges: Vec<[u32; 2]>,
}

/// Most patches that are drawn in either direction.
pub(crate) const MOST_PATCHES: u32 = 512;

/// Patches clamped to `1..=MOST_PATCHES` in each direction.
pub(crate) fn drawn_patches(patches: Patches) -> Patches {
    Patches { u: patches.u.clamp(1, MOST_PATCHES), v: patches.v.clamp(1, MOST_PATCHES) }
}

/// Tessellates the unit shape: longitudes `-pi + 2 pi i / u`, latitudes `-pi/2 + pi j / v`. Each
/// pole is one vertex with a fan. Two patches around give a flat mesh, one patch from pole to pole
/// gives a line.
pub(crate) fn tessellate(exponents: Exponents, patches: Patches) -> Mesh {
    let Patches { u, v } = drawn_patches(patches);
    let around: Vec<(f64, f64)> = (0..u).map(|i| full_turn(i, u, exponents.e())).collect();
    let rings: Vec<(f64, f64)> = (1..v).map(|j| latitude(j, v, exponents.n())).collect();
    mesh_of(exponents, &around, &rings)
}

/// Tessellates the unit shape so that curves around it and from pole to pole are within a tolerance.
pub(crate) fn tessellate_within(exponents: Exponents, tolerance: f64) -> Mesh {
    let east = quarter(exponents.e(), tolerance);
    let turned = |turn: usize| {
        east[..east.len() - 1].iter().map(move |point| match turn {
            0 => (-point.y, -point.x),
            1 => (-point.x, point.y),
            2 => (point.y, point.x),
            _ => (point.x, -point.y),
        })
    };
    let around: Vec<(f64, f64)> = (0..4).flat_map(turned).collect();
    let north = quarter(exponents.n(), tolerance);
    // The poles are no rings.
    let upper = north[..north.len() - 1].iter().map(|point| (point.y, point.x));
    let lower = north[1..north.len() - 1].iter().rev().map(|point| (-point.y, point.x));
    let rings: Vec<(f64, f64)> = lower.chain(upper).collect();
    mesh_of(exponents, &around, &rings)
}

/// The number of segments of a quarter turn of a tessellation within a tolerance, for an exponent.
pub(crate) fn quarter_segments(exponent: f64, tolerance: f64) -> u32 {
    quarter(exponent, tolerance).len() as u32 - 1
}

/// The mesh of rings of points. `around` has sine and cosine of each longitude, as powers, from -pi
/// on; `rings` has height and radius of each latitude between the poles, from south to north.
fn mesh_of(exponents: Exponents, around: &[(f64, f64)], rings: &[(f64, f64)]) -> Mesh {
    let (u, v) = (around.len() as u32, rings.len() as u32 + 1);
    let shape = Superquadric::unit(exponents);
    let vertex = |point: DVec3| Vertex {
        position: point.as_vec3().to_array(),
        normal: shape.normal(point).as_vec3().to_array(),
    };
    let mut vertices = vec![vertex(DVec3::NEG_Z)];
    for (height, radius) in rings {
        vertices.extend(around.iter().map(|(s, c)| vertex(DVec3::new(radius * c, radius * s, *height))));
    }
    vertices.push(vertex(DVec3::Z));

    let north = vertices.len() as u32 - 1;
    let at = |j: u32, i: u32| match j {
        0 => 0,
        j if j == v => north,
        j => 1 + (j - 1) * u + i % u,
    };
    let mut triangles = Vec::with_capacity(2 * (u * v) as usize);
    let mut edges = Vec::with_capacity(2 * (u * v) as usize);
    for j in 0..v {
        for i in 0..u {
            let (here, east) = (at(j, i), at(j, i + 1));
            let (above, above_east) = (at(j + 1, i), at(j + 1, i + 1));
            if j > 0 {
                triangles.push([here, east, above_east]);
                edges.push([here, east]);
            }
            if j + 1 < v {
                triangles.push([here, above_east, above]);
            }
            edges.push([here, above]);
        }
    }
    Mesh { vertices, triangles, edges }
}

/// `sign(x) |x|^w`, and 0 for x = 0 and any power.
fn power(x: f64, w: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.abs().powf(w).copysign(x) }
}

/// Sine and cosine, each to the power w, of the angle `-pi + 2 pi i / n`. Whole quarter turns are
/// exact: the power 0.0001 would enlarge the rounding error of sin(pi) to 0.996.
fn full_turn(i: u32, n: u32, w: f64) -> (f64, f64) {
    let (quarter, rest) = (4 * u64::from(i) / u64::from(n), 4 * u64::from(i) % u64::from(n));
    let (sin, cos) = (rest as f64 / f64::from(n) * FRAC_PI_2).sin_cos();
    let (s, c) = (power(sin, w), power(cos, w));
    match quarter % 4 {
        0 => (-s, -c),
        1 => (-c, s),
        2 => (s, c),
        _ => (c, -s),
    }
}

/// Sine and cosine, each to the power w, of the angle `-pi/2 + pi j / n`.
fn latitude(j: u32, n: u32, w: f64) -> (f64, f64) {
    let part = (2.0 * f64::from(j) - f64::from(n)) / f64::from(n);
    let (sin, cos) = (part * FRAC_PI_2).sin_cos();
    (power(sin, w), power(cos, w))
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use proptest::prelude::*;
    use superegg_geom::glam::Vec3;

    use super::*;

    fn exponent() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0001), Just(1.0), Just(2.0), Just(4.0), 0.05..4.0f64]
    }

    proptest! {
        /// Every vertex is on the surface, with a unit normal.
        #[test]
        fn vertices_are_on_the_surface(e in exponent(), n in exponent(), u in 1..40u32, v in 1..40u32) {
            let exponents = Exponents::new(e, n).unwrap();
            let shape = Superquadric::new(DVec3::ONE, exponents).unwrap();
            let mesh = tessellate(exponents, Patches { u, v });
            prop_assert_eq!(mesh.vertices.len() as u32, (v - 1) * u + 2);
            for vertex in &mesh.vertices {
                let position = Vec3::from(vertex.position).as_dvec3();
                let norm = shape.norm().value(position);
                prop_assert!((norm - 1.0).abs() < 1e-3, "{position} {norm}");
                prop_assert!((Vec3::from(vertex.normal).length() - 1.0).abs() < 1e-5);
            }
        }

        /// Vertices of a tessellation within a tolerance are on the surface, which is closed and
        /// whose triangles face outwards.
        #[test]
        fn tessellations_within_a_tolerance_close(e in 0.2..1.9f64, n in 0.2..1.9f64, level in 0..8i32) {
            let exponents = Exponents::new(e, n).unwrap();
            let shape = Superquadric::new(DVec3::ONE, exponents).unwrap();
            let tolerance = 0.5f64.powi(level);
            let mesh = tessellate_within(exponents, tolerance);
            let (u, v) = (4 * quarter_segments(e, tolerance), 2 * quarter_segments(n, tolerance));
            prop_assert_eq!(mesh.triangles.len() as u32, 2 * u * (v - 1));
            let position = |i: u32| Vec3::from(mesh.vertices[i as usize].position);
            for vertex in &mesh.vertices {
                prop_assert!((shape.norm().value(Vec3::from(vertex.position).as_dvec3()) - 1.0).abs() < 1e-3);
            }
            let mut directed: HashMap<(u32, u32), i32> = HashMap::new();
            for [a, b, c] in mesh.triangles.iter().copied() {
                let facing = (position(b) - position(a)).cross(position(c) - position(a));
                prop_assert!(facing.dot(position(a) + position(b) + position(c)) > 0.0);
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *directed.entry((from, to)).or_default() += 1;
                }
            }
            prop_assert!(directed.iter().all(|((a, b), count)| *count == 1 && directed.contains_key(&(*b, *a))));
        }

        /// A closed surface: each directed edge of a triangle has its opposite once.
        #[test]
        fn triangles_close(u in 3..20u32, v in 2..20u32) {
            let mesh = tessellate(Exponents::ROUND, Patches { u, v });
            let mut directed: HashMap<(u32, u32), i32> = HashMap::new();
            for [a, b, c] in &mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *directed.entry((*from, *to)).or_default() += 1;
                }
            }
            prop_assert!(directed.iter().all(|((a, b), count)| *count == 1 && directed.get(&(*b, *a)) == Some(&1)));
            prop_assert_eq!(mesh.triangles.len() as u32, 2 * u * (v - 1));
            prop_assert_eq!(mesh.edges.len() as u32, u * (2 * v - 1));
        }

        /// Triangles are counter-clockwise as seen from outside.
        #[test]
        fn triangles_face_outwards(e in 0.5..1.5f64, n in 0.5..1.5f64, u in 5..20u32, v in 4..20u32) {
            let mesh = tessellate(Exponents::new(e, n).unwrap(), Patches { u, v });
            let position = |i: u32| Vec3::from(mesh.vertices[i as usize].position);
            for [a, b, c] in mesh.triangles.iter().copied() {
                let facing = (position(b) - position(a)).cross(position(c) - position(a));
                let middle = position(a) + position(b) + position(c);
                prop_assert!(facing.dot(middle) > 0.0);
            }
        }
    }

    #[test]
    fn a_cube_reaches_its_corners_and_the_middles_of_its_faces() {
        let mesh = tessellate(Exponents::new(0.0001, 0.0001).unwrap(), Patches { u: 8, v: 4 });
        let has = |wanted: [f32; 3]| {
            mesh.vertices.iter().any(|v| (Vec3::from(v.position) - Vec3::from(wanted)).length() < 1e-3)
        };
        assert!(
            has([1.0, 1.0, 1.0]) && has([-1.0, 1.0, -1.0]) && has([1.0, 0.0, 0.0]) && has([0.0, -1.0, 0.0])
        );
        assert!(has([0.0, 0.0, 1.0]) && has([0.0, 0.0, -1.0]));
    }

    #[test]
    fn any_number_of_patches_is_drawn() {
        for patches in [Patches { u: 1, v: 1 }, Patches { u: 2, v: 1 }, Patches { u: u32::MAX, v: 2 }] {
            let mesh = tessellate(Exponents::new(4.0, 0.0001).unwrap(), patches);
            let count = mesh.vertices.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
            assert!(mesh.vertices.iter().all(|v| Vec3::from(v.position).is_finite()));
        }
    }
}
