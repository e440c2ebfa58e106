//! A scene's surfaces as triangles, and as spheres, with its camera rays: what `bench/embree.py`
//! gives to Embree. Prints how many triangles.
//!
//! `cargo run --release -p superegg-render --example triangles -- SCENE OUT`
//!
//! OUT, little-endian: four u64 (vertices, triangles, spheres, camera rays), the scene's box as six
//! f32 (least corner, greatest corner), the eye as three, then the vertices (three f32 each),
//! triangles (three u32), spheres (centre and radius, four f32), and directions of camera rays
//! (three f32; 4 x 4 neighbours of the film one after the other). World units.

// The script reads it.
#![allow(clippy::print_stdout)]

use std::f64::consts::{FRAC_PI_2, PI};
use std::fs::File;
use std::io::{BufWriter, Write};

use superegg_geom::Superquadric;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_lang::load_text;
use superegg_render::View;
use superegg_trace::CompiledScene;
use superegg_trace::reference::{FlatInstance, flatten};

/// That of the pictures of `superegg bench`.
const SIZE_PX: (u32, u32) = (1280, 960);
/// How far triangles may be from the surface: the twentieth of a pixel.
const TOLERANCE_PX: f64 = 0.05;
/// The coarsest and the finest grid around a shape; edges and poles of shapes with exponents of 2
/// are on grids of fours.
const PATCHES: (u32, u32) = (8, 512);
/// The most instances.
const MOST: usize = 2_000_000;
/// The edge of a block of rays, in pixels.
const BLOCK_PX: u32 = 4;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, out] = arguments.as_slice() else {
        return Err("usage: triangles SCENE OUT".into());
    };
    let (width, height) = SIZE_PX;
    let (session, _) = load_text(scene, &std::fs::read_to_string(scene)?);
    let scene = session.scene();
    let root = session.selected().ok_or("the scene selects nothing")?;
    let compiled = CompiledScene::compile(scene, Some(root), scene.depth);
    let bounds = compiled.bounds().ok_or("the scene is empty")?;
    let instances = flatten(scene, root, scene.depth, MOST).ok_or("too many instances")?;
    if scene.camera.ortho_height.is_some() || scene.camera.lens.is_some() {
        return Err("the camera's rays must begin at one place".into());
    }
    let view = View::new(&scene.camera, width, height);

    let mut mesh = Mesh::default();
    for flat in &instances {
        let distance = flat.world_from_local.forward().translation.distance(scene.camera.position);
        mesh.add(flat, TOLERANCE_PX * view.footprint(1).at(distance));
    }
    let spheres: Vec<[f32; 4]> = instances.iter().map(sphere).collect();
    let rays: Vec<[f32; 3]> = block_pixels(width, height)
        .map(|(x, y)| view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).direction)
        .map(|direction| direction.as_vec3().to_array())
        .collect();

    let mut file = BufWriter::new(File::create(out)?);
    for count in [mesh.vertices.len(), mesh.triangles.len(), spheres.len(), rays.len()] {
        file.write_all(&(count as u64).to_le_bytes())?;
    }
    let (middle, half) = (bounds.center(), bounds.half_extent());
    let places = [middle - half, middle + half, scene.camera.position];
    write_rows(&mut file, &places.map(|place| place.as_vec3().to_array()), f32::to_le_bytes)?;
    write_rows(&mut file, &mesh.vertices, f32::to_le_bytes)?;
    write_rows(&mut file, &mesh.triangles, u32::to_le_bytes)?;
    write_rows(&mut file, &spheres, f32::to_le_bytes)?;
    write_rows(&mut file, &rays, f32::to_le_bytes)?;
    file.flush()?;
    println!("{}", mesh.triangles.len());
    Ok(())
}

fn write_rows<T: Copy, const N: usize>(
    file: &mut impl Write,
    rows: &[[T; N]],
    bytes_of: impl Fn(T) -> [u8; 4],
) -> std::io::Result<()> {
    rows.iter().flatten().try_for_each(|&number| file.write_all(&bytes_of(number)))
}

/// The pixels of a picture, by blocks; the last of a row or column may lie beyond its edge.
fn block_pixels(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let blocks =
        (0..height.div_ceil(BLOCK_PX)).flat_map(move |y| (0..width.div_ceil(BLOCK_PX)).map(move |x| (x, y)));
    blocks.flat_map(|(x, y)| {
        (0..BLOCK_PX * BLOCK_PX).map(move |i| (BLOCK_PX * x + i % BLOCK_PX, BLOCK_PX * y + i / BLOCK_PX))
    })
}

/// A ball of the volume of the shape's ellipsoid, at its place.
fn sphere(flat: &FlatInstance) -> [f32; 4] {
    let forward = flat.world_from_local.forward();
    let volume = forward.matrix3.determinant().abs() * flat.shape.radii().element_product();
    let [x, y, z] = forward.translation.as_vec3().to_array();
    [x, y, z, volume.cbrt() as f32]
}

#[derive(Default)]
struct Mesh {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A shape by the coarsest grid of the parameterisation that is nowhere farther from it than
    /// `tolerance`.
    fn add(&mut self, flat: &FlatInstance, tolerance: f64) {
        let mut around = PATCHES.0;
        while around < PATCHES.1 && deviation(flat, around) > tolerance {
            around = (around + around / 8).next_multiple_of(4);
        }
        let (u, v) = (around, around / 2);
        let first = self.vertices.len() as u32;
        for j in 0..=v {
            for i in 0..u {
                let point = flat.world_from_local.forward().transform_point3(at(&flat.shape, i, j, u));
                self.vertices.push(point.as_vec3().to_array());
            }
        }
        let index = |i: u32, j: u32| first + j * u + i % u;
        for j in 0..v {
            for i in 0..u {
                let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                if j > 0 {
                    self.triangles.push([a, b, c]);
                }
                if j + 1 < v {
                    self.triangles.push([a, c, d]);
                }
            }
        }
    }
}

/// The surface's point at a node of a grid of `u` by `u / 2` patches.
fn at(shape: &Superquadric, i: u32, j: u32, u: u32) -> DVec3 {
    let v = u / 2;
    shape.point_at(
        2.0 * PI * f64::from(i % u) / f64::from(u) - PI,
        PI * f64::from(j) / f64::from(v) - FRAC_PI_2,
    )
}

/// How far the middles of edges and diagonals of a grid's first eighth are from the surface, to
/// first order, in world units.
fn deviation(flat: &FlatInstance, u: u32) -> f64 {
    let shape = &flat.shape;
    let distance = |point: DVec3| {
        let (value, gradient) = shape.norm().value_and_gradient(point / shape.radii());
        (value - 1.0).abs() / flat.world_from_local.normal_to_world(gradient / shape.radii()).length()
    };
    let mut farthest = 0.0f64;
    for j in 0..u / 4 {
        for i in 0..u / 4 {
            let here = at(shape, i, j, u);
            for other in [at(shape, i + 1, j, u), at(shape, i, j + 1, u), at(shape, i + 1, j + 1, u)] {
                farthest = farthest.max(distance(0.5 * (here + other)));
            }
        }
    }
    farthest
}
