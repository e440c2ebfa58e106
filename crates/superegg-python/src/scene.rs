//! A scene: built from lines and columns, rendered, and hit by rays.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use superegg::exchange::sqb;
use superegg::exchange::write::export::{ExportFormat, ExportOptions, export};
use superegg::exchange::write::grid::GridValue;
use superegg::exchange::write::meshes::Tolerance;
use superegg::exchange::write::ply::Precision;
use superegg::exchange::write::scene_mesh::SceneMesh;
use superegg::exchange::write::written::Written;
use superegg::geom::glam::{DAffine3, DMat3, DQuat, DVec3};
use superegg::geom::{Aabb, Exponents};
use superegg::lang::{
    Effect, Fault, FaultCode, Session, key_frames, picture_files, scene_at, write_scene, write_without_tables,
};
use superegg::render::{Framing, Output, RenderOptions, RenderSettings, TextureSet};
use superegg::scene::{Entity, EnvironmentPicture, InstanceTable, Material, TableBuilder, Texture};
use superegg::trace::{BatchOptions, CompiledScene, HitPaths};
use superegg::{Model, Part};
use superegg_cli::denoise;
use superegg_cli::load::{self as program, LoadedScene, frame_data};

use crate::columns::{Array, Column, Rays, array, flat, points, rows};
use crate::errors;
use crate::film::Film;
use crate::load::options;
use crate::shape::{Shape, append, hit_arrays, with_room};
use crate::work::{abandonable, by_length, detached, in_parallel, in_slices, interruptible, thread_count};

/// Above this many colours those of a table are rounded.
const MOST_COLORS: usize = 1 << 16;
/// The steps of a channel that is rounded, even to the eye.
const COLOR_STEPS: f64 = 63.0;

/// A scene. Python holds its methods' lock only for moments; rays and pictures use a compiled copy.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Scene(Mutex<State>);

#[derive(Clone)]
struct State {
    model: Model,
    compiled: Option<Arc<CompiledScene>>,
    /// The box of data whose camera nobody has set.
    data: Option<Aabb>,
    /// The folder of the scene's file, where the files that it names are searched.
    folder: Option<PathBuf>,
}

impl State {
    fn new(model: Model) -> Self {
        Self { model, compiled: None, data: None, folder: None }
    }

    /// The scene with the names that files have for a scene in this folder; `None` for where the scene is.
    fn scene_for(&self, folder: Option<&Path>) -> superegg::scene::Scene {
        let mut scene = self.model.scene().clone();
        if let Some(folder) = folder {
            program::rename_for_saving(&mut scene, self.folder.as_deref(), folder);
        }
        scene
    }

    fn compiled(&mut self) -> Arc<CompiledScene> {
        let Self { model, compiled, .. } = self;
        Arc::clone(compiled.get_or_insert_with(|| Arc::new(model.compile())))
    }

    fn replace(&mut self, model: Model) {
        if model.scene().camera != self.model.scene().camera {
            self.data = None;
        }
        self.model = model;
        self.compiled = None;
    }
}

/// The paths of hits.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Paths {
    compiled: Arc<CompiledScene>,
    paths: HitPaths,
}

#[pymethods]
impl Paths {
    /// The names of the instances of some rays; `None` for a miss.
    fn names(&self, rays: Vec<usize>) -> Vec<Option<String>> {
        let name = |ray: usize| Some(self.compiled.path_name(self.paths.get(ray)?));
        rays.into_iter().map(name).collect()
    }
}

/// Reads files as one scene: the scene, how the numbers were read, and warnings.
#[pyfunction]
pub(crate) fn load_files(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    keywords: &Bound<'_, PyDict>,
) -> PyResult<(Scene, Vec<String>, Vec<String>)> {
    let options = options(keywords)?;
    let name = paths.first().map(|path| path.display().to_string()).unwrap_or_default();
    let loaded = abandonable(py, move || program::load_files(&paths, &options))?;
    loaded_scene(loaded.map_err(|error| errors::of_file(&error, &name))?, Path::new(&name))
}

/// As [`load_files`], of the bytes of one file.
#[pyfunction]
pub(crate) fn load_bytes(
    py: Python<'_>,
    name: &str,
    bytes: &[u8],
    keywords: &Bound<'_, PyDict>,
) -> PyResult<(Scene, Vec<String>, Vec<String>)> {
    let options = options(keywords)?;
    let (owned, bytes) = (name.to_owned(), bytes.to_vec());
    let loaded = abandonable(py, move || program::load_bytes(Path::new(&owned), &bytes, &options))?;
    loaded_scene(loaded.map_err(|error| errors::of_file(&error, name))?, Path::new(name))
}

/// The scene that was read from the file at a path.
fn loaded_scene(loaded: LoadedScene, path: &Path) -> PyResult<(Scene, Vec<String>, Vec<String>)> {
    if let Some(error) = errors::of_diagnostics(&loaded.diagnostics) {
        return Err(error);
    }
    let LoadedScene { session, diagnostics, readings, mut warnings, bounds, .. } = loaded;
    warnings.extend(diagnostics.iter().map(ToString::to_string));
    let model = Model::from_scene(session.scene().clone(), session.selected()).map_err(errors::value)?;
    // Whole, because the working folder may change.
    let folder = std::path::absolute(path).ok().and_then(|path| Some(path.parent()?.to_owned()));
    let state = State { data: bounds, folder, ..State::new(model) };
    Ok((Scene(Mutex::new(state)), readings, warnings))
}

/// The settings of a picture beside the scene's own.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PictureRequest {
    size: Option<(u32, u32)>,
    output: String,
    layers: bool,
    lines: Vec<String>,
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self(Mutex::new(State::new(Model::new())))
    }

    /// The picture files that the scene names: names, and the paths where they are searched.
    fn picture_files(&self, py: Python<'_>) -> Vec<(String, PathBuf)> {
        let state = self.state(py);
        let files = picture_files(state.model.scene()).into_keys();
        files.map(|name| (name.to_string(), program::path_of_file(&name, state.folder.as_deref()))).collect()
    }

    /// A copy, which shares everything.
    fn copy(&self, py: Python<'_>) -> Self {
        Self(Mutex::new(self.state(py).clone()))
    }

    /// The scene file; for one in a folder with the names that files have there.
    #[pyo3(signature = (folder=None))]
    fn text(&self, py: Python<'_>, folder: Option<PathBuf>) -> PyResult<String> {
        detached(py, || {
            let state = self.lock();
            write_scene(&state.scene_for(folder.as_deref()), state.model.root())
        })
    }

    /// The binary scene file, as [`Scene::text`].
    #[pyo3(signature = (folder=None))]
    fn to_bytes<'py>(&self, py: Python<'py>, folder: Option<PathBuf>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = detached(py, || {
            let state = self.lock();
            let scene = &state.scene_for(folder.as_deref());
            let tables: Vec<(&str, &InstanceTable)> = scene.tables().collect();
            let mut bytes = Vec::new();
            let text = write_without_tables(scene, state.model.root());
            sqb::write(&mut bytes, &text, &tables).map(|()| bytes)
        })?;
        Ok(PyBytes::new(py, &bytes.map_err(errors::value)?))
    }

    /// The box of data whose camera nobody has set, as its corners.
    fn data_bounds(&self, py: Python<'_>) -> Option<([f64; 3], [f64; 3])> {
        self.state(py).data.map(|bounds| (bounds.min.to_array(), bounds.max.to_array()))
    }

    fn set_data_bounds(&self, py: Python<'_>, bounds: Option<([f64; 3], [f64; 3])>) {
        self.state(py).data = bounds.map(|(min, max)| Aabb { min: min.into(), max: max.into() });
    }

    #[getter]
    fn root(&self, py: Python<'_>) -> Option<String> {
        self.state(py).model.root().map(str::to_owned)
    }

    fn show(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        let mut state = self.state(py);
        let mut model = state.model.clone();
        model.show(name).map_err(errors::key)?;
        state.replace(model);
        Ok(())
    }

    /// The names of what the scene has, and their kinds.
    fn names(&self, py: Python<'_>) -> Vec<(String, &'static str)> {
        let kind = |entity: &Entity| match entity {
            Entity::Primitive(_) => "primitive",
            Entity::Object(_) => "object",
            Entity::Table(_) => "table",
        };
        self.state(py).model.names().map(|(name, entity)| (name.to_owned(), kind(entity))).collect()
    }

    fn lights(&self, py: Python<'_>) -> Vec<String> {
        self.state(py).model.scene().named_lights().map(|(name, _)| name.to_owned()).collect()
    }

    fn has_camera(&self, py: Python<'_>) -> bool {
        Framing::is_set(self.state(py).model.scene())
    }

    /// Position, target, up, field of view, orthographic height, lens radius and focus distance.
    fn camera(&self, py: Python<'_>) -> CameraNumbers {
        let camera = self.state(py).model.scene().camera;
        (
            camera.position.to_array(),
            camera.target.to_array(),
            camera.up.to_array(),
            camera.fov_deg,
            camera.ortho_height,
            camera.lens.map(|lens| (lens.radius, lens.focus)),
        )
    }

    /// Places the camera as a picture of this size has it, if the scene sets none.
    fn frame(&self, py: Python<'_>, width: u32, height: u32) -> PyResult<()> {
        detached(py, || {
            let (compiled, mut model, data) = self.snapshot();
            let size = (model.scene().picture.width, model.scene().picture.height);
            let scene = model.scene_mut();
            (scene.picture.width, scene.picture.height) = (width, height);
            frame(scene, &compiled, data);
            (scene.picture.width, scene.picture.height) = size;
            let mut state = self.lock();
            state.data = None;
            // The shapes stay, and with them what is compiled.
            state.model = model;
        })
    }

    /// The frames that have keys, sorted.
    fn key_frames(&self, py: Python<'_>) -> Vec<f64> {
        key_frames(self.state(py).model.scene())
    }

    /// The scene at a frame of its keys.
    fn at(&self, py: Python<'_>, frame: f64) -> PyResult<Self> {
        let State { model, data, folder, .. } = self.state(py).clone();
        let session = Session::with_scene(model.scene().clone(), model.root());
        let still = scene_at(&session, frame).map_err(errors::value)?;
        let model = Model::from_scene(still, model.root()).map_err(errors::value)?;
        Ok(Self(Mutex::new(State { data, folder, ..State::new(model) })))
    }

    /// Carries out lines of the modelling language, all or none, and returns what they print.
    fn run(&self, py: Python<'_>, lines: Vec<String>) -> PyResult<Vec<String>> {
        by_length(py, lines.len(), |cancel| {
            let mut state = self.lock();
            let (model, printed) = after_unless(&state.model, state.model.root(), &lines, cancel)?;
            state.replace(model);
            Ok(printed)
        })?
    }

    /// Adds a shape under a name to the shown object, with the material of some lines.
    #[pyo3(signature = (shape, name, matrix, lines))]
    fn add(
        &self,
        py: Python<'_>,
        shape: &Shape,
        name: Option<String>,
        matrix: Option<[f64; 12]>,
        lines: Vec<String>,
    ) -> PyResult<String> {
        let mut state = self.state(py);
        let mut part = Part::new(shape.0);
        if let Some(name) = name {
            part = part.named(checked_name(name)?);
        }
        if let Some(matrix) = matrix {
            part = part.matrix(affine(&matrix));
        }
        let mut model = state.model.clone();
        let name = model.add(part).map_err(errors::value)?;
        if !lines.is_empty() {
            let material = material_of(&lines)?;
            let scene = model.scene_mut();
            scene.primitive_mut(&name).map_err(errors::value)?.material = material;
        }
        state.replace(model);
        Ok(name)
    }

    /// Adds a table of instances to the shown object. Rotations are quaternions x y z w.
    #[pyo3(signature = (name, columns, ids, lines))]
    fn add_table(
        &self,
        py: Python<'_>,
        name: String,
        columns: TableArrays<'_>,
        ids: Option<Vec<i64>>,
        lines: Vec<String>,
    ) -> PyResult<String> {
        let name = checked_name(name)?;
        let material = material_of(&lines)?;
        let columns = columns.rows()?;
        let table = detached(py, || columns.table(ids.as_deref(), &material))?.map_err(errors::value)?;
        let mut state = self.state(py);
        let mut model = state.model.clone();
        let root = model.root().unwrap_or("model").to_owned();
        let scene = model.scene_mut();
        let added = scene.ensure_object(&root).and_then(|()| scene.add_table(&name, table));
        added.and_then(|()| scene.add_child(&root, &name, &name)).map_err(errors::value)?;
        model.show(&root).map_err(errors::value)?;
        state.replace(model);
        Ok(name)
    }

    /// The tables of the scene, as columns.
    fn table<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
        let scene = self.state(py).model.scene().clone();
        let Some(Entity::Table(table)) = scene.get(name) else {
            return Err(errors::key(format!("the scene has no table '{name}'")));
        };
        let count = table.len();
        let of_rows = |of: &dyn Fn(usize) -> Vec<f64>| (0..count).flat_map(of).collect::<Vec<f64>>();
        let columns = PyDict::new(py);
        let set = |key, column| columns.set_item(key, array(py, column));
        set("positions", of_rows(&|row| table.position(row).to_array().into()))?;
        set("radii", of_rows(&|row| table.shape(row).radii.to_array().into()))?;
        let exponents = |row| {
            let exponents = table.shape(row).exponents;
            vec![exponents.e(), exponents.n()]
        };
        set("exponents", of_rows(&exponents))?;
        set("rotations", of_rows(&|row| table.rotation(row).to_array().into()))?;
        set("colors", of_rows(&|row| table.material(row).color.to_array().into()))?;
        let ids = table.ids().map_or_else(|| (1..=count as i64).collect(), |ids| ids.to_vec());
        columns.set_item("ids", array(py, ids))?;
        Ok(columns)
    }

    /// The number of instances, as text since it has no bound.
    fn instance_count(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.compiled(py)?.instance_count().to_string())
    }

    /// The corners of the box around the scene.
    fn bounds(&self, py: Python<'_>) -> PyResult<Option<([f64; 3], [f64; 3])>> {
        let bounds = self.compiled(py)?.bounds();
        Ok(bounds.map(|bounds| (bounds.min.to_array(), bounds.max.to_array())))
    }

    /// The memory of scene and compiled scene, in bytes.
    fn compiled_bytes(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.compiled(py)?.bytes())
    }

    fn primitive_name(&self, py: Python<'_>, index: u32) -> PyResult<Option<String>> {
        Ok(self.compiled(py)?.primitive_name(index).map(str::to_owned))
    }

    /// The closest hits: t, position, normal, (u, v), leaving, primitive, instance id, paths.
    #[pyo3(signature = (origins, directions, t_min, t_max, query))]
    fn intersect<'py>(
        &self,
        py: Python<'py>,
        origins: Column<'py>,
        directions: Column<'py>,
        t_min: Option<Column<'py>>,
        t_max: Option<Column<'py>>,
        query: (usize, bool),
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let (threads, uv) = query;
        let compiled = self.compiled(py)?;
        let rays = Rays { origins, directions, t_min, t_max };
        let batch = rays.batch()?;
        let options = BatchOptions::default().with_threads(threads).with_uv(uv);
        let trace = |cancel: &AtomicBool| {
            // Each part is moved at once, so that the next one reuses its memory.
            let (mut hits, mut primitives) = (with_room(batch.len()), Vec::with_capacity(batch.len()));
            let (mut ids, mut paths) =
                (Vec::with_capacity(batch.len()), HitPaths::with_capacity(batch.len()));
            in_slices(batch.len(), cancel, |slice| {
                let Some(rays) = batch.slice(slice) else { return };
                let (columns, of_hits, instances, of_paths) =
                    compiled.intersect_batch(&rays, options).into_columns();
                append(&mut hits, columns);
                primitives.extend(of_hits.into_iter().map(u32::cast_signed));
                ids.extend(instances);
                paths.append(of_paths);
            });
            (hits, primitives, ids, paths)
        };
        let (hits, primitives, ids, paths) = if batch.len() < 1000 {
            let options = options.with_threads(1);
            let one = detached(py, || compiled.intersect_batch(&batch, options).into_columns())?;
            let primitives = one.1.into_iter().map(u32::cast_signed).collect();
            (one.0, primitives, one.2, one.3)
        } else {
            interruptible(py, |_| Ok(()), trace)?
        };
        let (t, points, normals, uv, leaving) = hit_arrays(py, hits);
        let paths = Paths { compiled, paths };
        Ok(vec![
            t.into_any(),
            points.into_any(),
            normals.into_any(),
            uv.into_any(),
            leaving.into_any(),
            array(py, primitives).into_any(),
            array(py, ids).into_any(),
            Bound::new(py, paths)?.into_any(),
        ])
    }

    #[pyo3(signature = (origins, directions, t_min, t_max, threads))]
    fn occluded<'py>(
        &self,
        py: Python<'py>,
        origins: Column<'py>,
        directions: Column<'py>,
        t_min: Option<Column<'py>>,
        t_max: Option<Column<'py>>,
        threads: usize,
    ) -> PyResult<Array<'py, bool>> {
        let compiled = self.compiled(py)?;
        let rays = Rays { origins, directions, t_min, t_max };
        let batch = rays.batch()?;
        let options = BatchOptions::default().with_threads(threads);
        let trace = |cancel: &AtomicBool| {
            let mut all = Vec::with_capacity(batch.len());
            in_slices(batch.len(), cancel, |slice| {
                let rays = batch.slice(slice);
                rays.iter().for_each(|rays| all.extend(compiled.occluded_batch(rays, options)));
            });
            all
        };
        let occluded = interruptible(py, |_| Ok(()), trace)?;
        Ok(array(py, occluded))
    }

    /// The signed distances to the surface of the scene and their proven errors.
    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        at: Column<'py>,
        threads: usize,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let compiled = self.compiled(py)?;
        let at = points(&at)?;
        let limits = superegg::trace::PointLimits::default();
        let of_point = |&point: &[f64; 3]| match compiled.signed_distance(point.into(), &limits) {
            Some(found) => [found.distance, found.error],
            None => [f64::INFINITY, 0.0],
        };
        let found = interruptible(
            py,
            |_| Ok(()),
            |cancel| {
                in_parallel(at.len(), thread_count(threads), |range| {
                    let unless = |_: &&[f64; 3]| !cancel.load(Ordering::Relaxed);
                    at[range].iter().take_while(unless).map(of_point).collect()
                })
            },
        )?;
        let column = |i: usize| found.iter().map(|row| row[i]).collect();
        Ok((array(py, column(0)), array(py, column(1))))
    }

    /// The scene in the format of a file's name: the file, the materials beside an .obj, and what is lost.
    fn export<'py>(&self, py: Python<'py>, file: PathBuf, request: ExportRequest) -> PyResult<Exported<'py>> {
        let (compiled, model, data) = detached(py, || self.snapshot())?;
        let write = move || {
            let format = ExportFormat::of(&file).map_err(errors::value)?;
            let (mut scene, root) = (model.scene().clone(), shown(&model)?);
            frame(&mut scene, &compiled, data);
            let materials = file.with_extension("mtl");
            let materials = materials.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            let options = request.options(materials)?;
            export(&scene, root, format, &options).map_err(errors::value)
        };
        let written = abandonable(py, write)??;
        let Written { bytes, companion, losses } = written;
        let companion = companion.map(|bytes| PyBytes::new(py, &bytes));
        Ok((PyBytes::new(py, &bytes), companion, losses))
    }

    /// The triangles of all instances: vertices, normals, triangles, the instance of each triangle, and the
    /// paths and colours of instances.
    fn mesh<'py>(&self, py: Python<'py>, request: ExportRequest) -> PyResult<MeshArrays<'py>> {
        let model = self.state(py).model.clone();
        let make = move || {
            let (scene, root) = (model.scene(), shown(&model)?);
            let ExportOptions { depth, tolerance, .. } = request.options("")?;
            SceneMesh::of(scene, root, depth.unwrap_or(scene.depth), tolerance).map_err(errors::value)
        };
        let mesh = abandonable(py, make)??;
        Ok((
            array(py, flat(mesh.positions.into_iter())),
            array(py, flat(mesh.normals.into_iter())),
            array(py, mesh.triangles.into_flattened()),
            array(py, mesh.instance_of_triangle),
            mesh.paths,
            array(py, flat(mesh.colors.into_iter())),
        ))
    }

    /// Whether points are inside any primitive.
    fn inside<'py>(&self, py: Python<'py>, at: Column<'py>, threads: usize) -> PyResult<Array<'py, bool>> {
        let compiled = self.compiled(py)?;
        let at = points(&at)?;
        let inside = interruptible(
            py,
            |_| Ok(()),
            |cancel| {
                in_parallel(at.len(), thread_count(threads), |range| {
                    let of_point = |&point: &[f64; 3]| compiled.contains_point_unless(point.into(), cancel);
                    at[range].iter().map_while(of_point).collect()
                })
            },
        )?;
        Ok(array(py, inside))
    }

    /// Renders the scene. `progress` is called with the finished and all pixels.
    #[pyo3(signature = (request, threads, progress))]
    fn render(
        &self,
        py: Python<'_>,
        request: PictureRequest,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Film> {
        let (compiled, settings) = detached(py, || self.prepare(&request))??;
        settings.validate().map_err(errors::value)?;
        let finished = AtomicU64::new(0);
        let total = u64::from(settings.picture.width) * u64::from(settings.picture.height);
        let tick = |py: Python<'_>| match &progress {
            Some(progress) => progress.call1(py, (finished.load(Ordering::Relaxed), total)).map(drop),
            None => Ok(()),
        };
        let rendered = interruptible(py, tick, |cancel| {
            let count = |pixels: u64| finished.store(pixels, Ordering::Relaxed);
            let options =
                RenderOptions::default().with_threads(threads).with_cancel(cancel).with_progress(&count);
            superegg::render::render(&compiled, &settings, &options)
        })?
        .map_err(errors::value)?;
        if let Some(progress) = &progress {
            progress.call1(py, (total, total))?;
        }
        let film = detached(py, || denoise::denoised(&rendered.film, &settings).map(Cow::into_owned))?;
        let film = settings.output.into_colored(film.map_err(errors::value)?);
        Ok(Film { film, settings })
    }
}

/// Position, target, up, field of view, orthographic height, lens radius with focus distance.
type CameraNumbers = ([f64; 3], [f64; 3], [f64; 3], f64, Option<f64>, Option<(f64, f64)>);

/// A file, the file beside it, and what is lost.
type Exported<'py> = (Bound<'py, PyBytes>, Option<Bound<'py, PyBytes>>, Vec<String>);

/// Vertices, normals, triangles, the instance of each triangle, the paths and colours of instances.
type MeshArrays<'py> =
    (Array<'py, f64>, Array<'py, f64>, Array<'py, u32>, Array<'py, u32>, Vec<String>, Array<'py, f64>);

impl Scene {
    /// The state, for a thread that holds the interpreter's lock. It waits without that lock: another thread may
    /// compile the scene meanwhile, which takes seconds.
    fn state(&self, py: Python<'_>) -> MutexGuard<'_, State> {
        loop {
            match self.0.try_lock() {
                Ok(state) => return state,
                Err(TryLockError::Poisoned(state)) => return state.into_inner(),
                Err(TryLockError::WouldBlock) => py.detach(|| drop(self.lock())),
            }
        }
    }

    /// The state, for a thread without the interpreter's lock.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn compiled(&self, py: Python<'_>) -> PyResult<Arc<CompiledScene>> {
        detached(py, || self.lock().compiled())
    }

    /// The compiled scene, the model, and the box of data whose camera nobody has set.
    fn snapshot(&self) -> (Arc<CompiledScene>, Model, Option<Aabb>) {
        let mut state = self.lock();
        (state.compiled(), state.model.clone(), state.data)
    }

    /// The compiled scene and the settings of a picture, as the program finds them.
    fn prepare(&self, request: &PictureRequest) -> PyResult<(Arc<CompiledScene>, RenderSettings)> {
        let output = output_of(&request.output)?;
        let (compiled, model, data) = self.snapshot();
        let (model, _) = after(&model, model.root(), &request.lines)?;
        let mut scene = model.scene().clone();
        if let Some((width, height)) = request.size {
            (scene.picture.width, scene.picture.height) = (width, height);
        }
        frame(&mut scene, &compiled, data);
        let settings = RenderSettings::of(&scene).with_output(output).with_layers(request.layers);
        let settings = denoise::prepared(settings).map_err(errors::value)?;
        let folder = self.lock().folder.clone();
        let folder = folder.as_deref();
        let pixels_of = |picture: &EnvironmentPicture| {
            program::surroundings_pixels(picture, folder).map_err(|error| errors::value(format!("{error:#}")))
        };
        let texture_of = |texture: &Texture, channel| {
            program::texture_pixels(texture, channel, folder)
                .map_err(|error| errors::value(format!("{error:#}")))
        };
        let settings = settings.with_surroundings(&scene, pixels_of)?;
        Ok((compiled, settings.with_textures(TextureSet::of(&scene, texture_of)?)))
    }
}

/// Sets the camera of data, and of a scene that sets none and is not in sight.
fn frame(scene: &mut superegg::scene::Scene, compiled: &CompiledScene, data: Option<Aabb>) {
    let size = (scene.picture.width.max(1), scene.picture.height.max(1));
    if let Some(bounds) = data {
        frame_data(scene, &bounds, size);
    } else {
        Framing::frame_unseen(scene, compiled, size);
    }
}

/// The name of what a model shows.
fn shown(model: &Model) -> PyResult<&str> {
    model.root().ok_or_else(|| errors::value("the scene is empty: add a shape first"))
}

/// The settings of an export, beside the file.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ExportRequest {
    depth: Option<u32>,
    tolerance: f64,
    absolute: bool,
    double: bool,
    grid: usize,
    value: String,
}

impl ExportRequest {
    fn options(&self, materials: &str) -> PyResult<ExportOptions> {
        let tolerance = if self.absolute { Tolerance::Absolute } else { Tolerance::Relative };
        let value = match &*self.value {
            "distance" => GridValue::Distance,
            "inside-outside" => GridValue::InsideOutside,
            other => {
                let text = format!("a grid has no value '{other}'; choose distance or inside-outside");
                return Err(errors::value(text));
            }
        };
        Ok(ExportOptions {
            depth: self.depth,
            tolerance: tolerance(self.tolerance),
            precision: if self.double { Precision::Double } else { Precision::Single },
            grid: self.grid,
            value,
            materials: materials.to_owned(),
        })
    }
}

/// A model after lines of the modelling language, and what they print. Files are not touched.
fn after(model: &Model, selected: Option<&str>, lines: &[String]) -> PyResult<(Model, Vec<String>)> {
    after_unless(model, selected, lines, &AtomicBool::new(false))
}

/// As [`after`], until `cancel` is true: then there is an error, which nobody sees.
fn after_unless(
    model: &Model,
    selected: Option<&str>,
    lines: &[String],
    cancel: &AtomicBool,
) -> PyResult<(Model, Vec<String>)> {
    if lines.is_empty() {
        return Ok((model.clone(), Vec::new()));
    }
    let mut session = Session::with_scene(model.scene().clone(), selected);
    let mut printed = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        if cancel.load(Ordering::Relaxed) {
            return Err(errors::defect("the lines were stopped"));
        }
        let at = |fault: &Fault| {
            let help = fault.help.as_deref().map_or_else(String::new, |help| format!("; {help}"));
            // A line that is no text is not shown.
            let shown = if fault.code == FaultCode::NotText { String::new() } else { format!("'{line}': ") };
            let text = format!("line {}: {shown}{}{help}", number + 1, fault.message);
            errors::format_error(&text, None, Some(number as u64 + 1), None)
        };
        match session.run_line(line).map_err(|fault| at(&fault))? {
            Effect::Done | Effect::Changed(_) => {}
            Effect::Print(text) => printed.push(text),
            Effect::Request(_) => {
                let text = format!(
                    "line {}: '{line}' is a command of the program; call a method instead",
                    number + 1
                );
                return Err(errors::value(text));
            }
        }
    }
    let model = Model::from_scene(session.scene().clone(), session.selected()).map_err(errors::value)?;
    Ok((model, printed))
}

/// The material of a new primitive after some lines.
fn material_of(lines: &[String]) -> PyResult<Material> {
    let model = Model::new();
    let all: Vec<String> =
        std::iter::once("primitive material".to_owned()).chain(lines.iter().cloned()).collect();
    let (model, _) = after(&model, None, &all)?;
    Ok(model.scene().primitive("material").map_err(errors::value)?.material)
}

/// A name that the modelling language can write.
fn checked_name(name: String) -> PyResult<String> {
    let mut session = Session::default();
    let made = session.run_line(&format!("primitive {name}"));
    match made {
        Ok(_) if session.selected() == Some(&name) && !name.contains('\0') => Ok(name),
        _ => {
            Err(errors::value(format!("'{name}' cannot be a name: a name is one word without blanks and #")))
        }
    }
}

fn affine(m: &[f64; 12]) -> DAffine3 {
    let column = |i: usize| DVec3::new(m[i], m[4 + i], m[8 + i]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

fn output_of(name: &str) -> PyResult<Output> {
    Output::of_word(name).ok_or_else(|| {
        let known = Output::ALL.map(Output::word).join(", ");
        errors::value(format!("there is no output '{name}'; choose one of {known}"))
    })
}

/// The columns of a table, each of one row for all or of a row for each instance.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct TableArrays<'py> {
    positions: Column<'py>,
    radii: Column<'py>,
    exponents: Column<'py>,
    rotations: Column<'py>,
    colors: Option<Column<'py>>,
}

impl TableArrays<'_> {
    fn rows(&self) -> PyResult<TableRows<'_>> {
        Ok(TableRows {
            positions: points(&self.positions)?,
            radii: points(&self.radii)?,
            exponents: rows::<2>(&self.exponents)?,
            rotations: rows::<4>(&self.rotations)?,
            colors: self.colors.as_ref().map(points).transpose()?,
        })
    }
}

/// The rows of [`TableArrays`].
struct TableRows<'a> {
    positions: &'a [[f64; 3]],
    radii: &'a [[f64; 3]],
    exponents: &'a [[f64; 2]],
    rotations: &'a [[f64; 4]],
    colors: Option<&'a [[f64; 3]]>,
}

impl TableRows<'_> {
    fn table(&self, ids: Option<&[i64]>, material: &Material) -> Result<InstanceTable, String> {
        let mut builder = TableBuilder::default();
        builder.reserve(self.positions.len());
        let palette = Palette::of(self.colors);
        let mut materials: HashMap<[u64; 3], u32> = HashMap::new();
        for (row, &position) in self.positions.iter().enumerate() {
            let color = palette.color(row).unwrap_or(material.color);
            let new = || builder.material(Material { color, ..*material });
            let material = *materials.entry(color.to_array().map(f64::to_bits)).or_insert_with(new);
            let wrong = |error: superegg::geom::ShapeError| format!("row {row}: {error}");
            let [e, n] = at(self.exponents, row);
            let exponents = Exponents::new(e, n).map_err(wrong)?;
            let shape = builder.shape(at(self.radii, row).into(), exponents, material).map_err(wrong)?;
            let rotation = DQuat::from_array(at(self.rotations, row)).normalize();
            builder.push(shape, position.into(), rotation, ids.map(|ids| ids[row]));
        }
        Ok(builder.finish())
    }
}

/// The row of a column; the only one of a column of one row.
fn at<const K: usize>(rows: &[[f64; K]], row: usize) -> [f64; K] {
    rows[if rows.len() == 1 { 0 } else { row }]
}

/// The colours of rows, rounded if there are many.
struct Palette<'a> {
    colors: Option<&'a [[f64; 3]]>,
    is_rounded: bool,
}

impl<'a> Palette<'a> {
    fn of(colors: Option<&'a [[f64; 3]]>) -> Self {
        let mut distinct = std::collections::HashSet::new();
        let is_rounded = colors.is_some_and(|colors| {
            colors.iter().any(|color| {
                distinct.insert(color.map(f64::to_bits));
                distinct.len() > MOST_COLORS
            })
        });
        Self { colors, is_rounded }
    }

    fn color(&self, row: usize) -> Option<DVec3> {
        let color = DVec3::from_array(at(self.colors?, row));
        // A power near that of sRGB makes the steps even to the eye.
        let rounded = |x: f64| ((x.powf(1.0 / 2.2) * COLOR_STEPS).round() / COLOR_STEPS).powf(2.2);
        Some(if self.is_rounded { color.map(rounded) } else { color })
    }
}
