//! Values on a regular grid: the inside-outside function or the signed distance, as NRRD or as VTK
//! image data (.vti).

use std::fmt::Write;
use std::num::NonZero;
use std::thread;

use superegg_geom::glam::{DMat3, DQuat, DVec3};
use superegg_geom::{Aabb, SearchLimits, Superquadric};
use superegg_scene::Scene;

use super::flatten::Instances;
use super::losses::{self, MaterialKept};
use super::particles::particles;
use super::written::{WriteError, Written};

/// The quantity on a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridValue {
    /// The signed distance to the union, negative inside: the least one of all instances. Outside it
    /// is the distance to the union's surface; inside, where instances overlap, it is a bound: the
    /// union's surface is at least as far.
    Distance,
    /// The least value of the inside-outside function, each in its shape's own space.
    InsideOutside,
}

impl GridValue {
    fn name(self) -> &'static str {
        match self {
            Self::Distance => "distance",
            Self::InsideOutside => "inside_outside",
        }
    }
}

/// The most samples along the longest side of a grid.
pub const MOST_SAMPLES: usize = 512;
/// The most evaluations of one instance at one sample.
pub const MOST_EVALUATIONS: u64 = 4_000_000_000;
/// A grid is larger than the scene by this part of its longest side, on each side, and by at least
/// one sample.
const MARGIN: f64 = 0.05;
/// The relative error of distances: less than that of float32.
const DISTANCE_ERROR: f64 = 2e-8;
/// The cells that a search for a closest point looks at.
const DISTANCE_CELLS: usize = 20_000;

/// Samples in the order x, y, z: x runs fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    value: GridValue,
    counts: [usize; 3],
    origin: DVec3,
    spacing: f64,
    samples: Vec<f32>,
    losses: Vec<String>,
}

impl Grid {
    /// The grid around the instances with `longest` samples along its longest side and one spacing.
    ///
    /// # Errors
    /// More than [`MOST_EVALUATIONS`], no grid (`longest` not in 4 to [`MOST_SAMPLES`]), or, for
    /// distances, a sheared instance, which is no superquadric.
    pub fn new(
        scene: &Scene,
        instances: &Instances,
        value: GridValue,
        longest: usize,
    ) -> Result<Self, WriteError> {
        let (counts, origin, spacing) = layout(instances, longest)?;
        let evaluations = counts.iter().fold(instances.list.len() as u64, |n, &count| n * count as u64);
        if evaluations > MOST_EVALUATIONS {
            return Err(WriteError::Grid(format!(
                "{} instances at {} samples are more than {MOST_EVALUATIONS} evaluations; take fewer samples",
                instances.list.len(),
                counts.iter().product::<usize>()
            )));
        }
        let field = match value {
            GridValue::Distance => Field::Distance(bodies(instances)?),
            GridValue::InsideOutside => Field::InsideOutside(maps(instances)),
        };
        let mut grid = Self { value, counts, origin, spacing, samples: Vec::new(), losses: Vec::new() };
        grid.samples = grid.sampled(&field);
        grid.losses = losses::of_scene(scene);
        grid.losses.extend(losses::of_materials(instances, MaterialKept::None));
        if value == GridValue::Distance && instances.list.len() > 1 {
            grid.losses.push(
                "inside, where primitives overlap, the distance is that to the nearest primitive's surface: a bound for the union, exact outside"
                    .to_owned(),
            );
        }
        Ok(grid)
    }

    /// The samples of all slices, each thread a part of them.
    fn sampled(&self, field: &Field) -> Vec<f32> {
        let [nx, ny, nz] = self.counts;
        let mut samples = vec![0.0; nx * ny * nz];
        let threads = thread::available_parallelism().map_or(1, NonZero::get).min(nz);
        let sample = |(k, slice): (usize, &mut [f32])| {
            for (index, sample) in slice.iter_mut().enumerate() {
                let steps = DVec3::new((index % nx) as f64, (index / nx) as f64, k as f64);
                *sample = field.at(self.origin + self.spacing * steps) as f32;
            }
        };
        // Where the system has no threads, none is started.
        if threads == 1 {
            samples.chunks_mut(nx * ny).enumerate().for_each(sample);
            return samples;
        }
        // Slices are dealt out in turn, since those in the middle take longest.
        let mut hands: Vec<Vec<(usize, &mut [f32])>> = (0..threads).map(|_| Vec::new()).collect();
        for (k, slice) in samples.chunks_mut(nx * ny).enumerate() {
            hands[k % threads].push((k, slice));
        }
        thread::scope(|scope| {
            for hand in hands {
                scope.spawn(|| hand.into_iter().for_each(sample));
            }
        });
        samples
    }

    /// The samples in float32: x runs fastest, then y.
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// The number of samples along x, y and z.
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// The position of the first sample.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The distance between neighbouring samples.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// A NRRD file (version 4) with raw samples.
    pub fn to_nrrd(&self) -> Written {
        let ([nx, ny, nz], s, o) = (self.counts, self.spacing, self.origin);
        let header = format!(
            "NRRD0004\n# superegg\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: {nx} {ny} {nz}\nspace directions: ({s},0,0) (0,{s},0) (0,0,{s})\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: ({},{},{})\ncontent: {}\n\n",
            o.x,
            o.y,
            o.z,
            self.value.name()
        );
        self.written(header.into_bytes(), b"")
    }

    /// A VTK image data file with appended raw samples.
    pub fn to_vti(&self) -> Written {
        let ([nx, ny, nz], s, o) = (self.counts, self.spacing, self.origin);
        let extent = format!("0 {} 0 {} 0 {}", nx - 1, ny - 1, nz - 1);
        let name = self.value.name();
        let mut text = "<?xml version=\"1.0\"?>\n".to_owned();
        let _ = write!(
            text,
            "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<ImageData WholeExtent=\"{extent}\" Origin=\"{} {} {}\" Spacing=\"{s} {s} {s}\">\n<Piece Extent=\"{extent}\">\n<PointData Scalars=\"{name}\">\n<DataArray type=\"Float32\" Name=\"{name}\" format=\"appended\" offset=\"0\"/>\n</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_",
            o.x, o.y, o.z
        );
        let mut bytes = text.into_bytes();
        bytes.extend_from_slice(&(4 * self.samples.len() as u64).to_le_bytes());
        self.written(bytes, b"\n</AppendedData>\n</VTKFile>\n")
    }

    fn written(&self, mut bytes: Vec<u8>, end: &[u8]) -> Written {
        bytes.reserve_exact(4 * self.samples.len() + end.len());
        self.samples.iter().for_each(|sample| bytes.extend_from_slice(&sample.to_le_bytes()));
        bytes.extend_from_slice(end);
        Written { bytes, companion: None, losses: self.losses.clone() }
    }
}

/// The counts, the origin and the spacing of the grid around instances.
fn layout(instances: &Instances, longest: usize) -> Result<([usize; 3], DVec3, f64), WriteError> {
    if !(4..=MOST_SAMPLES).contains(&longest) {
        return Err(WriteError::Grid(format!(
            "a grid has 4 to {MOST_SAMPLES} samples along its longest side"
        )));
    }
    let bounds = instances.list.iter().fold(Aabb::EMPTY, |bounds, instance| {
        let half = instances.part(instance).shape.half_extent_under(&instance.map.matrix3);
        bounds.union(&Aabb::around(instance.map.translation, half))
    });
    let (center, half) = (bounds.center(), bounds.half_extent());
    let side = 2.0 * half.max_element();
    let intervals = (longest - 1) as f64;
    let spacing = (side * (1.0 + 2.0 * MARGIN) / intervals).max(side / (intervals - 2.0));
    if !(spacing.is_normal() && bounds.min.is_finite() && bounds.max.is_finite()) {
        return Err(WriteError::Grid("the scene is too large or too small for a grid".to_owned()));
    }
    let margin = 0.5 * (spacing * intervals - side);
    let counts = (2.0 * (half + margin) / spacing).ceil().to_array().map(|count| count as usize + 1);
    let counts = counts.map(|count| count.min(longest));
    let size = DVec3::from_array(counts.map(|count| (count - 1) as f64)) * spacing;
    Ok((counts, center - 0.5 * size, spacing))
}

/// A function of space.
enum Field {
    Distance(Vec<Body>),
    InsideOutside(Vec<(Superquadric, DVec3, DMat3)>),
}

/// A superquadric in the world.
struct Body {
    shape: Superquadric,
    to_shape: DQuat,
    position: DVec3,
    least_radius: f64,
}

fn bodies(instances: &Instances) -> Result<Vec<Body>, WriteError> {
    let (particles, sheared) = particles(instances);
    if let Some(loss) = sheared {
        return Err(WriteError::Grid(format!("{loss}: --value inside-outside has them")));
    }
    let body = |particle: &super::particles::Particle<'_>| {
        let shape = Superquadric::new(particle.rigid.radii, particle.exponents());
        let shape =
            shape.map_err(|error| WriteError::Grid(format!("{}: {error}", particle.instance.path)))?;
        Ok(Body {
            shape,
            to_shape: particle.rigid.rotation.inverse(),
            position: particle.rigid.position,
            least_radius: shape.radii().min_element(),
        })
    };
    particles.iter().map(body).collect()
}

fn maps(instances: &Instances) -> Vec<(Superquadric, DVec3, DMat3)> {
    let map = |instance: &super::flatten::Instance| {
        let shape = instances.part(instance).shape;
        (shape, instance.map.translation, instance.map.matrix3.inverse())
    };
    instances.list.iter().map(map).collect()
}

impl Field {
    fn at(&self, point: DVec3) -> f64 {
        match self {
            Self::InsideOutside(shapes) => {
                let value = |(shape, center, inverse): &(Superquadric, DVec3, DMat3)| {
                    shape.inside_outside(*inverse * (point - center))
                };
                shapes.iter().map(value).fold(f64::INFINITY, f64::min)
            }
            Self::Distance(bodies) => least_distance(bodies, point),
        }
    }
}

/// The least signed distance.
fn least_distance(bodies: &[Body], point: DVec3) -> f64 {
    let limits = SearchLimits { relative_tolerance: DISTANCE_ERROR, most_cells: DISTANCE_CELLS };
    let mut bounds: Vec<(f64, usize)> =
        bodies.iter().enumerate().map(|(index, body)| (body.bound(point), index)).collect();
    bounds.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut least = f64::INFINITY;
    for (bound, index) in bounds {
        if bound >= least {
            break;
        }
        let body = &bodies[index];
        if let Some(closest) = body.shape.closest_point_within(body.local(point), &limits) {
            least = least.min(closest.distance);
        }
    }
    least
}

impl Body {
    fn local(&self, point: DVec3) -> DVec3 {
        self.to_shape * (point - self.position)
    }

    /// A lower bound of the signed distance: that to the shape's box, and inside the box the least
    /// semi-axis, beyond which no point of the shape lies from its surface.
    fn bound(&self, point: DVec3) -> f64 {
        let outside = (self.local(point).abs() - self.shape.radii()).max(DVec3::ZERO).length();
        if outside > 0.0 { outside } else { -self.least_radius }
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::TransformStep;

    use super::super::flatten::flatten;
    use super::*;

    fn scene() -> Scene {
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        scene.ensure_object("pair").unwrap();
        scene.add_child("pair", "a", "ball").unwrap();
        scene.add_child("pair", "b", "ball").unwrap();
        scene.transform_child("pair", TransformStep::Scale(DVec3::splat(0.5))).unwrap();
        scene.transform_child("pair", TransformStep::Translate(DVec3::new(3.0, 0.0, 0.0))).unwrap();
        scene
    }

    #[test]
    fn distances_are_those_of_spheres() {
        let scene = scene();
        let instances = flatten(&scene, "pair", 2).unwrap();
        let grid = Grid::new(&scene, &instances, GridValue::Distance, 24).unwrap();
        let [nx, ny, nz] = grid.counts();
        assert_eq!((nx, grid.samples().len()), (24, nx * ny * nz));
        assert!(ny < nx && ny == nz);
        for (index, &sample) in grid.samples().iter().enumerate() {
            let steps = [index % nx, index / nx % ny, index / nx / ny].map(|i| i as f64);
            let point = grid.origin() + grid.spacing() * DVec3::from_array(steps);
            let exact = (point.length() - 1.0).min((point - DVec3::new(3.0, 0.0, 0.0)).length() - 0.5);
            assert!((f64::from(sample) - exact).abs() < 1e-6, "{point}: {sample} {exact}");
            // The scene lies within, with a margin.
            let is_border = [index % nx, index / nx % ny, index / nx / ny]
                .iter()
                .zip([nx, ny, nz])
                .any(|(&i, n)| i == 0 || i == n - 1);
            assert!(!is_border || sample > 0.0);
        }
        let nrrd = grid.to_nrrd();
        assert!(nrrd.bytes.starts_with(b"NRRD0004\n"));
        let end = nrrd.bytes.windows(2).position(|pair| pair == b"\n\n").unwrap() + 2;
        assert_eq!(nrrd.bytes.len() - end, 4 * nx * ny * nz);
        assert!(nrrd.losses.iter().any(|loss| loss.contains("bound")));
    }

    #[test]
    fn inside_outside_values_and_limits() {
        let scene = scene();
        let instances = flatten(&scene, "pair", 2).unwrap();
        let grid = Grid::new(&scene, &instances, GridValue::InsideOutside, 16).unwrap();
        assert!(grid.samples().iter().any(|&x| x < 0.0) && grid.samples()[0] > 0.0);
        let vti = grid.to_vti().bytes;
        assert!(vti.ends_with(b"</VTKFile>\n"));
        for bad in [0, 1, 3, MOST_SAMPLES + 1, usize::MAX] {
            assert!(matches!(
                Grid::new(&scene, &instances, GridValue::Distance, bad),
                Err(WriteError::Grid(_))
            ));
        }
    }
}
