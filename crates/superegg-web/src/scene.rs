//! A scene that answers questions.

use std::cell::OnceCell;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use superegg_exchange::write::export::{ExportFormat, ExportOptions, export};
use superegg_exchange::write::meshes::Tolerance;
use superegg_exchange::write::scene_mesh::SceneMesh;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_geom::{HitColumns, Ray, RayBatch};
use superegg_lang::{Session, key_frames, scene_at, write_session};
use superegg_render::{Framing, RenderResources, RenderSettings, View};
use superegg_scene::{Entity, ViewSettings};
use superegg_trace::{BatchOptions, CompiledScene, HitPaths};
use superegg_viewer::{CastHit, GridChoice, IoGrid, cast};
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::answers::{FirstHit, Name, PictureRequest, Summary, error, json};
use crate::eye::{camera_of, numbers_of, position_of};
use crate::file::{Read, read, run_text};
use crate::findings::{Finding, findings};
use crate::picture::{Picture, settings_of};
use crate::pictures::Files;

/// Most frames of a scene with keys.
const MOST_FRAMES: f64 = 1e6;

/// A scene: it is read once, and compiled for rays when it is first asked.
#[wasm_bindgen]
pub struct Scene {
    session: Session,
    findings: Vec<Finding>,
    notes: Vec<String>,
    compiled: OnceCell<Arc<CompiledScene>>,
    resources: OnceCell<Arc<RenderResources>>,
    files: Files,
    /// The scene with its keys, while one frame of it is shown.
    keyed: Option<Session>,
}

impl Scene {
    fn of(session: Session, findings: Vec<Finding>, notes: Vec<String>) -> Self {
        Self {
            session,
            findings,
            notes,
            compiled: OnceCell::new(),
            resources: OnceCell::new(),
            files: Files::default(),
            keyed: None,
        }
    }

    fn compiled(&self) -> &Arc<CompiledScene> {
        let scene = self.session.scene();
        self.compiled
            .get_or_init(|| Arc::new(CompiledScene::compile(scene, self.session.selected(), scene.depth)))
    }

    fn root(&self) -> Result<&str, JsError> {
        self.session.selected().ok_or_else(|| error("nothing is selected, so the scene shows nothing"))
    }

    fn settings(&self) -> RenderSettings {
        self.files.settings(self.session.scene())
    }

    /// The scene with its keys.
    fn keyed(&self) -> &Session {
        self.keyed.as_ref().unwrap_or(&self.session)
    }

    /// The frames from 0 to the last key.
    fn frames(&self) -> usize {
        let last = key_frames(self.keyed().scene()).last().copied().unwrap_or(-1.0);
        (last.floor().clamp(-1.0, MOST_FRAMES) + 1.0) as usize
    }
}

#[wasm_bindgen]
impl Scene {
    /// The scene of a text. Lines with errors are left out; see [`Scene::findings`].
    #[wasm_bindgen(constructor)]
    pub fn new(text: &str) -> Self {
        let mut session = Session::default();
        let diagnostics = run_text(&mut session, text);
        Self::of(session, findings(diagnostics, text), Vec::new())
    }

    /// Reads a file by its content: a scene, a binary scene, or data of another program. `name` is that of the file.
    ///
    /// # Errors
    /// The file's fault.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, JsError> {
        let Read { session, diagnostics, notes } = read(name, bytes).map_err(error)?;
        let text = std::str::from_utf8(bytes).unwrap_or_default();
        Ok(Self::of(session, findings(diagnostics, text), notes))
    }

    /// The errors and warnings of the text, as JSON.
    pub fn findings(&self) -> String {
        json(&self.findings)
    }

    /// How a file was read, and what was left out.
    pub fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// The scene as text, which reads back as the same scene.
    pub fn text(&self) -> String {
        write_session(self.keyed())
    }

    /// The contents of the scene, as JSON.
    pub fn summary(&self) -> String {
        let picture = self.session.scene().picture;
        json(&Summary {
            root: self.session.selected().map(str::to_owned),
            instances: self.compiled().instance_count().to_string(),
            width: picture.width,
            height: picture.height,
            samples: picture.samples,
            frames: self.frames(),
            files: self.files.named_by(self.session.scene()),
        })
    }

    /// The primitives, objects and tables, as JSON.
    pub fn names(&self) -> String {
        let kind = |entity: &Entity| match entity {
            Entity::Primitive(_) => "primitive",
            Entity::Object(_) => "object",
            Entity::Table(_) => "table",
        };
        let entities = self.session.scene().entities();
        let names: Vec<Name> =
            entities.map(|(name, entity)| Name { name: name.to_owned(), kind: kind(entity) }).collect();
        json(&names)
    }

    /// Gives the scene the pictures that it names. A missing one leaves surfaces or surroundings plain.
    #[wasm_bindgen(js_name = setFiles)]
    pub fn set_files(&mut self, files: &Files) {
        self.files = files.clone();
        self.resources = OnceCell::new();
    }

    /// Shows the scene at a frame of its keys from now on.
    ///
    /// # Errors
    /// A keyed command cannot be carried out with its numbers at that frame.
    #[wasm_bindgen(js_name = setFrame)]
    pub fn set_frame(&mut self, frame: f64) -> Result<(), JsError> {
        if !frame.is_finite() {
            return Err(error(format!("a frame is a finite number, found {frame}")));
        }
        let keyed = self.keyed().clone();
        let still = scene_at(&keyed, frame)
            .map_err(|fault| error(format!("{}; {}", fault.message, fault.help.unwrap_or_default())))?;
        self.session = Session::with_scene(still, keyed.selected());
        self.keyed = Some(keyed);
        self.compiled = OnceCell::new();
        self.resources = OnceCell::new();
        Ok(())
    }

    /// The camera, for a picture of this size: that of the scene, or one that sees it where the scene sets none and the
    /// default camera sees nothing.
    pub fn camera(&mut self, width: u32, height: u32) -> Vec<f64> {
        let compiled = Arc::clone(self.compiled());
        let mut scene = self.session.scene().clone();
        if width > 0 && height > 0 && Framing::frame_unseen(&mut scene, &compiled, (width, height)) {
            self.session = Session::with_scene(scene, self.session.selected());
        }
        numbers_of(&self.session.scene().camera)
    }

    /// The direction that is up.
    pub fn up(&self) -> Vec<f64> {
        self.session.scene().up().to_array().to_vec()
    }

    /// Lower and upper corner of the box around the scene; `None` for an empty one.
    pub fn bounds(&self) -> Option<Vec<f64>> {
        let bounds = self.compiled().bounds()?;
        Some([bounds.min.to_array(), bounds.max.to_array()].concat())
    }

    /// The positions of the lights, three numbers each.
    pub fn lights(&self) -> Vec<f64> {
        self.session.scene().lights().iter().filter_map(position_of).flatten().collect()
    }

    /// Begins a picture. The request is JSON; see the type `PictureRequest` of the package.
    ///
    /// # Errors
    /// A request that no picture can have.
    pub fn picture(&self, request: &str) -> Result<Picture, JsError> {
        let request: PictureRequest = serde_json::from_str(request).map_err(error)?;
        let own = self.settings();
        let resources = self.resources.get_or_init(|| Arc::new(RenderResources::of(self.compiled(), &own)));
        let resources = Arc::clone(resources);
        let settings = settings_of(own, &request)?;
        Picture::new(Arc::clone(self.compiled()), resources, settings, request.shard.as_deref())
    }

    /// The closest hits of rays: origins and directions of three numbers each.
    ///
    /// # Errors
    /// The columns do not fit each other.
    pub fn intersect(&self, origins: &[f64], directions: &[f64]) -> Result<Hits, JsError> {
        let (origins, rest) = origins.as_chunks();
        let (directions, more) = directions.as_chunks();
        if !rest.is_empty() || !more.is_empty() {
            return Err(error("a ray has three numbers for its origin and three for its direction"));
        }
        let rays = RayBatch::new(origins, directions).map_err(error)?;
        let compiled = Arc::clone(self.compiled());
        let (hits, primitives, ids, paths) =
            compiled.intersect_batch(&rays, BatchOptions::default().with_uv(false)).into_columns();
        let HitColumns { t, points, normals, .. } = hits;
        Ok(Hits { compiled, t, points: points.concat(), normals: normals.concat(), primitives, ids, paths })
    }

    /// The first hit of the ray through a point of a picture with this camera, as JSON: t, point, normal, path, steps;
    /// `None` if it hits nothing. The point is in pixels from the top left corner.
    pub fn pick(&self, camera: &[f64], width: u32, height: u32, x: f64, y: f64) -> Option<String> {
        let camera = camera_of(camera.try_into().ok()?);
        let ray = View::new(&camera, width.max(1), height.max(1)).ray(DVec2::new(x, y));
        self.cast(&ray)
    }

    /// The first hit of a ray, as [`Scene::pick`].
    #[wasm_bindgen(js_name = firstHit)]
    pub fn first_hit(&self, origin: &[f64], direction: &[f64]) -> Option<String> {
        let vector = |numbers: &[f64]| <[f64; 3]>::try_from(numbers).ok().map(DVec3::from_array);
        self.cast(&Ray::new(vector(origin)?, vector(direction)?))
    }

    fn cast(&self, ray: &Ray) -> Option<String> {
        let CastHit { t, point, normal, path, primitive, newton_steps } =
            cast(self.session.scene(), self.compiled(), ray)?;
        let (point, normal) = (point.to_array(), normal.to_array());
        Some(json(&FirstHit { t, point, normal, path, primitive, steps: newton_steps }))
    }

    /// Whether each point, of three numbers, is inside a shape: 1 or 0.
    pub fn inside(&self, points: &[f64]) -> Vec<u8> {
        let compiled = self.compiled();
        let never = AtomicBool::new(false);
        let points = points.as_chunks::<3>().0.iter();
        let is_inside = |point: &[f64; 3]| {
            compiled.contains_point_unless(DVec3::from_array(*point), &never) == Some(true)
        };
        points.map(|point| u8::from(is_inside(point))).collect()
    }

    /// The grid of the inside-outside test that suits the scene as this camera sees it.
    #[wasm_bindgen(js_name = testGrid)]
    pub fn test_grid(&self, camera: &[f64]) -> Option<Grid> {
        let camera = camera_of(camera.try_into().ok()?);
        let compiled = self.compiled();
        let choice = GridChoice::new(&ViewSettings::default());
        let spec = choice.spec(compiled.bounds().as_ref(), &camera)?;
        IoGrid::test(compiled, &spec, &AtomicBool::new(false)).map(Grid)
    }

    /// The triangles of all instances, at most `tolerance` away from the exact surfaces, as a part of each instance's
    /// size.
    ///
    /// # Errors
    /// An empty scene, or too many triangles.
    pub fn mesh(&self, tolerance: f64) -> Result<Mesh, JsError> {
        let scene = self.session.scene();
        SceneMesh::of(scene, self.root()?, scene.depth, Tolerance::Relative(tolerance))
            .map(Mesh)
            .map_err(error)
    }

    /// The file of an export; the ending of `file`, such as `.stl`, decides the format.
    ///
    /// # Errors
    /// No such format, or one that cannot hold the scene.
    pub fn export(&self, file: &str, tolerance: f64) -> Result<Export, JsError> {
        let format = ExportFormat::of(file).map_err(error)?;
        let options = ExportOptions { tolerance: Tolerance::Relative(tolerance), ..ExportOptions::default() };
        let written = export(self.session.scene(), self.root()?, format, &options).map_err(error)?;
        Ok(Export { bytes: written.bytes, companion: written.companion, losses: written.losses })
    }
}

/// The hits of rays, as columns: t is infinite for a miss.
#[wasm_bindgen]
pub struct Hits {
    compiled: Arc<CompiledScene>,
    t: Vec<f64>,
    points: Vec<f64>,
    normals: Vec<f64>,
    primitives: Vec<u32>,
    ids: Vec<u32>,
    paths: HitPaths,
}

#[wasm_bindgen]
impl Hits {
    /// t of each hit, in lengths of the direction.
    #[wasm_bindgen(getter)]
    pub fn t(&self) -> Vec<f64> {
        self.t.clone()
    }

    /// The points, three numbers each.
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> Vec<f64> {
        self.points.clone()
    }

    /// The outward unit normals, three numbers each.
    #[wasm_bindgen(getter)]
    pub fn normals(&self) -> Vec<f64> {
        self.normals.clone()
    }

    /// The index of each primitive; 4294967295 for a miss.
    #[wasm_bindgen(getter)]
    pub fn primitives(&self) -> Vec<u32> {
        self.primitives.clone()
    }

    /// The id of each instance; 0 for a miss.
    #[wasm_bindgen(getter)]
    pub fn ids(&self) -> Vec<u32> {
        self.ids.clone()
    }

    /// The path of the instance of one hit: names from the root down, joined by `/`.
    pub fn path(&self, index: usize) -> Option<String> {
        Some(self.compiled.path_name(self.paths.get(index)?))
    }
}

/// The points of the inside-outside test.
#[wasm_bindgen]
pub struct Grid(IoGrid);

#[wasm_bindgen]
impl Grid {
    /// The points, three numbers each.
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> Vec<f64> {
        self.0.points.iter().flat_map(|(point, _)| point.to_array()).collect()
    }

    /// 1 for each point inside, 0 for each outside.
    #[wasm_bindgen(getter)]
    pub fn inside(&self) -> Vec<u8> {
        self.0.points.iter().map(|(_, is_inside)| u8::from(*is_inside)).collect()
    }

    /// The spacing in world units.
    #[wasm_bindgen(getter)]
    pub fn step(&self) -> f64 {
        self.0.step
    }
}

/// Triangles of a scene.
#[wasm_bindgen]
pub struct Mesh(SceneMesh);

#[wasm_bindgen]
impl Mesh {
    /// The vertices, three numbers each.
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Vec<f32> {
        self.0.positions.iter().flat_map(|point| point.as_vec3().to_array()).collect()
    }

    /// The unit normal of the exact surface at each vertex.
    #[wasm_bindgen(getter)]
    pub fn normals(&self) -> Vec<f32> {
        self.0.normals.iter().flat_map(|normal| normal.as_vec3().to_array()).collect()
    }

    /// The linear colour of each vertex.
    #[wasm_bindgen(getter)]
    pub fn colors(&self) -> Vec<f32> {
        let mut colors = vec![0.0; 3 * self.0.positions.len()];
        for (triangle, instance) in self.0.triangles.iter().zip(&self.0.instance_of_triangle) {
            let color = self.0.colors[*instance as usize].as_vec3().to_array();
            for corner in triangle {
                colors[3 * *corner as usize..][..3].copy_from_slice(&color);
            }
        }
        colors
    }

    /// The vertices of each triangle, counter-clockwise from outside.
    #[wasm_bindgen(getter)]
    pub fn indices(&self) -> Vec<u32> {
        self.0.triangles.concat()
    }

    /// The index of each triangle's instance in `paths`.
    #[wasm_bindgen(getter, js_name = instanceOfTriangle)]
    pub fn instance_of_triangle(&self) -> Vec<u32> {
        self.0.instance_of_triangle.clone()
    }

    /// The path of each instance.
    #[wasm_bindgen(getter)]
    pub fn paths(&self) -> Vec<String> {
        self.0.paths.clone()
    }
}

/// A file that was written.
#[wasm_bindgen]
pub struct Export {
    bytes: Vec<u8>,
    companion: Option<Vec<u8>>,
    losses: Vec<String>,
}

#[wasm_bindgen]
impl Export {
    /// The file.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> Vec<u8> {
        self.bytes.clone()
    }

    /// The file beside it, such as the materials of an .obj.
    #[wasm_bindgen(getter)]
    pub fn companion(&self) -> Option<Vec<u8>> {
        self.companion.clone()
    }

    /// The losses of the format, one sentence each.
    #[wasm_bindgen(getter)]
    pub fn losses(&self) -> Vec<String> {
        self.losses.clone()
    }
}
