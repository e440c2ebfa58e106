//! The points of a surface: those of a cloud as they are, those of a mesh spread evenly by area.

use std::io::{Read, SeekFrom};

use superegg_geom::glam::DVec3;

use super::arrays::numpy;
use super::error::ReadError;
use super::format::Format;
use super::import::{Content, Input};
use super::meshes::{self, Triangle};
use super::options::ReadOptions;
use super::source::open;
use super::vtk::{self, Kind};
use super::{clouds, source, vtk_programs};

/// The points of a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfacePoints {
    /// The points, in the order of the file.
    pub points: Vec<DVec3>,
    /// How the file was read, one line: "a PLY file: 1288 points".
    pub reading: String,
}

/// How many points stand for a mesh, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshSampling {
    /// The number of points.
    pub count: usize,
    /// The seed.
    pub seed: u64,
}

/// Reads the points of a cloud (PLY, rows of x y z, tables with columns x, y and z, NumPy arrays of
/// rows that begin with x y z, the points of VTK files), or spreads points over the triangles of a mesh (STL, OBJ, PLY with
/// faces). Formats are recognized by their content. Values that are no finite numbers are errors.
///
/// # Errors
/// The stream cannot be read, its format is none of these, or its content is wrong.
///
/// ```
/// use std::io::Cursor;
/// use superegg_exchange::read::{MeshSampling, ReadOptions, read_surface_points};
///
/// let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let sampling = MeshSampling { count: 50, seed: 1 };
/// let found = read_surface_points(&mut Cursor::new(triangle), &ReadOptions::default(), sampling)?;
/// assert_eq!(found.points.len(), 50);
/// assert!(found.points.iter().all(|at| at.x + at.y <= 1.0 && at.z == 0.0));
/// # Ok::<(), superegg_exchange::read::ReadError>(())
/// ```
pub fn read_surface_points(
    input: &mut dyn Input,
    options: &ReadOptions,
    sampling: MeshSampling,
) -> Result<SurfacePoints, ReadError> {
    let mut bytes = Vec::new();
    input.seek(SeekFrom::Start(0))?;
    input.take(source::MOST_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > source::MOST_BYTES {
        return Err(ReadError::File(format!("the file is larger than {} bytes", source::MOST_BYTES)));
    }
    if options.from.is_none() {
        if meshes::is_stl(&bytes) {
            return of_mesh("an STL mesh", &meshes::read_stl(&bytes)?, &[], sampling);
        }
        if meshes::is_obj(&bytes) {
            let obj = meshes::read_obj(&bytes)?;
            return of_mesh("an OBJ mesh", &obj.triangles, &obj.vertices, sampling);
        }
        if clouds::is_ply(&bytes) {
            let triangles = clouds::read_ply_triangles(&bytes)?;
            if !triangles.is_empty() {
                return of_mesh("a PLY mesh", &triangles, &[], sampling);
            }
        }
        if let Some([_, width]) = numpy::shape_of(&bytes).as_deref()
            && *width >= 3
        {
            return of_array(&bytes);
        }
        if vtk::is_vtk(&bytes) && !vtk_programs::has_shapes(&bytes) {
            return of_vtk(&bytes);
        }
    }
    of_cloud(&bytes, options)
}

/// The points of a mesh; its vertices where it has no faces.
fn of_mesh(
    what: &str,
    triangles: &[Triangle],
    vertices: &[DVec3],
    sampling: MeshSampling,
) -> Result<SurfacePoints, ReadError> {
    if triangles.is_empty() && !vertices.is_empty() {
        return finite(vertices.to_vec(), format!("{what} without faces: {} vertices", vertices.len()));
    }
    let points = meshes::sample(triangles, sampling.count, sampling.seed);
    if points.is_empty() && sampling.count > 0 {
        return Err(ReadError::File("the mesh has no triangles with a finite area above 0".to_owned()));
    }
    let reading = format!("{what}: {} points of {} triangles, even by area", points.len(), triangles.len());
    finite(points, reading)
}

/// The first three numbers of each row of an array.
fn of_array(bytes: &[u8]) -> Result<SurfacePoints, ReadError> {
    let array = numpy::read(bytes, "array")?.numbers("array")?;
    let width = array.shape[1];
    let points: Vec<DVec3> = array.values.chunks_exact(width).map(DVec3::from_slice).collect();
    let more = if width > 3 { format!(", the first 3 of {width} columns") } else { String::new() };
    let reading = format!("{}: {} points{more}", Format::NpyPoints.description(), points.len());
    finite(points, reading)
}

/// The points of a VTK file, whatever cells join them.
fn of_vtk(bytes: &[u8]) -> Result<SurfacePoints, ReadError> {
    let data = vtk::read(bytes, &|_, _| false)?;
    let kind = data.kind.name();
    if !matches!(data.kind, Kind::PolyData | Kind::UnstructuredGrid | Kind::StructuredGrid) {
        let message = format!("the points of a VTK file of {kind} fill a box; expected points of a surface");
        return Err(ReadError::File(message));
    }
    let reading = format!("a VTK file of {kind}: {} points; faces are not used", data.points.len());
    finite(data.points, reading)
}

fn of_cloud(bytes: &[u8], options: &ReadOptions) -> Result<SurfacePoints, ReadError> {
    let mut source = open(std::io::Cursor::new(bytes), options)?;
    let format = source.format();
    if !matches!(format, Format::Ply | Format::Xyz | Format::NpyPoints | Format::Table) {
        let message = format!(
            "this is {}, not a cloud of points or a mesh; 'superegg sample' gives points of its surfaces",
            format.description()
        );
        return Err(ReadError::File(message));
    }
    let Content::Particles(particles) = source.read(0, options)?.content else {
        return Err(ReadError::File("the file has no points".to_owned()));
    };
    let reading = format!("{}: {} points", format.description(), particles.len());
    finite(particles.positions, reading)
}

/// The points, if all of them are finite.
fn finite(points: Vec<DVec3>, reading: String) -> Result<SurfacePoints, ReadError> {
    match points.iter().position(|point| !point.is_finite()) {
        None => Ok(SurfacePoints { points, reading }),
        Some(index) => {
            let message = format!("expected finite coordinates, found {}", points[index]);
            Err(ReadError::part(format!("point {index}"), message))
        }
    }
}
