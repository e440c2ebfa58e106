//! A scene and the object of it that is shown.

use std::fs;
use std::path::Path;

use superegg_geom::Superquadric;
use superegg_geom::glam::DVec3;
use superegg_lang::{Diagnostic, Session, Severity, write_scene};
use superegg_render::{RenderOptions, RenderSettings, render};
use superegg_scene::{Camera, Entity, Light, Scene, numbered_name};
use superegg_trace::CompiledScene;

use crate::error::Error;
use crate::part::{Content, Part};
use crate::picture::Rendering;
use crate::scene_file;

/// The name of the object that [`Model::new`] shows.
const ROOT: &str = "model";

/// A scene, and the object or primitive of it that is shown: the one that is selected last in a file, or `model` for a scene built in
/// code. All parts, lights and settings are in [`Model::scene`], which the modelling language, the viewer and the exporters share.
///
/// Built in code:
///
/// ```
/// use superegg::prelude::*;
/// let mut model = Model::new();
/// model.add(Part::new(Superquadric::new(DVec3::new(1.0, 1.0, 1.3), Exponents::new(1.0, 0.9)?)?).color([0.9, 0.6, 0.2]))?;
/// model.add(Part::new(Superquadric::unit_sphere()).scale([0.5; 3]).translate([1.5, 0.0, 0.0]))?;
/// model.look_at([4.0, -5.0, 3.0], [0.0, 0.0, 0.0]);
/// let picture = model.render(80, 60)?;
/// assert_eq!((picture.film.width(), picture.film.height()), (80, 60));
/// # Ok::<(), Error>(())
/// ```
///
/// Read from the modelling language, where errors have a line and a column:
///
/// ```
/// use superegg::prelude::*;
/// let model = Model::from_text("egg.scn", "prm egg\ncoeff 1 1 1.3\nexp 1 .9\n")?;
/// assert_eq!(model.root(), Some("egg"));
/// let error = Model::from_text("egg.scn", "prm egg\ncoeff 1 1\n").unwrap_err();
/// assert!(error.to_string().starts_with("egg.scn:2:"), "{error}");
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    scene: Scene,
    root: Option<String>,
}

impl Default for Model {
    fn default() -> Self {
        Self::new()
    }
}

impl Model {
    /// A model without parts.
    pub fn new() -> Self {
        let mut scene = Scene::default();
        // A new scene has no name that could be in the way.
        let root = scene.ensure_object(ROOT).is_ok().then(|| ROOT.to_owned());
        Self { scene, root }
    }

    /// A model of one shape at the origin.
    pub fn of(shape: Superquadric) -> Self {
        let mut model = Self::new();
        let added = model.add(Part::new(shape));
        // No name is taken and no step is there to fail.
        debug_assert!(added.is_ok());
        model
    }

    /// A scene and the name of what is shown of it; `None` shows nothing.
    ///
    /// # Errors
    /// The scene has nothing of this name.
    pub fn from_scene(scene: Scene, root: Option<&str>) -> Result<Self, Error> {
        let mut model = Self { scene, root: None };
        if let Some(root) = root {
            model.show(root)?;
        }
        Ok(model)
    }

    /// Reads a scene in the modelling language. `name` stands for the file in messages.
    ///
    /// # Errors
    /// [`Error::Text`] with every error of the text. Lines that read other files (`include`, `load`) are errors:
    /// [`Model::load`] reads them.
    pub fn from_text(name: &str, text: &str) -> Result<Self, Error> {
        Self::of_session(scene_file::run_text(name, text))
    }

    /// Reads a scene file (`.scn`), and the files that it includes or loads. Their names are searched in the working folder, then
    /// beside the file that has the line; so are those of pictures on surfaces and of the environment, which [`Model::render`]
    /// reads. Files of other programs are read by `superegg::exchange::read`.
    ///
    /// # Errors
    /// The file cannot be read, or [`Error::Text`] with every error of all files.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::of_session(scene_file::run_file(path.as_ref())?)
    }

    fn of_session((session, diagnostics): (Session, Vec<Diagnostic>)) -> Result<Self, Error> {
        let errors: Vec<_> =
            diagnostics.into_iter().filter(|found| found.severity == Severity::Error).collect();
        if !errors.is_empty() {
            return Err(Error::Text(errors));
        }
        Ok(Self { scene: session.scene().clone(), root: session.selected().map(str::to_owned) })
    }

    /// The scene as text: [`Model::from_text`] reads it back without loss.
    ///
    /// ```
    /// use superegg::prelude::*;
    /// let model = Model::of(Superquadric::unit_sphere());
    /// assert_eq!(Model::from_text("sphere.scn", &model.to_text())?, model);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn to_text(&self) -> String {
        write_scene(&self.scene, self.root.as_deref())
    }

    /// Writes a scene file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        fs::write(path, self.to_text()).map_err(|error| Error::File {
            action: "write",
            path: path.to_owned(),
            error,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene, to change it: sky, floor, picture settings, materials. If a change removes the root, nothing is shown.
    pub fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// The name of the object or primitive that is shown.
    pub fn root(&self) -> Option<&str> {
        self.root.as_deref()
    }

    /// Shows another object or primitive.
    ///
    /// # Errors
    /// The scene has nothing of this name.
    pub fn show(&mut self, name: &str) -> Result<(), Error> {
        if self.scene.get(name).is_none() {
            return Err(superegg_scene::SceneError::Unknown(name.to_owned()).into());
        }
        self.root = Some(name.to_owned());
        Ok(())
    }

    /// Adds a part to the object that is shown, and returns the part's name.
    ///
    /// # Errors
    /// See [`Model::add_to`]; also if the model shows a primitive.
    pub fn add(&mut self, part: Part) -> Result<String, Error> {
        let root = self.root.clone().unwrap_or_else(|| ROOT.to_owned());
        let name = self.add_to(&root, part)?;
        self.root = Some(root);
        Ok(name)
    }

    /// Adds a part to the object of this name, which is made if there is none, and returns the part's name.
    ///
    /// ```
    /// use superegg::prelude::*;
    /// let mut model = Model::new();
    /// model.add_to("pair", Part::new(Superquadric::unit_sphere()).named("ball"))?;
    /// model.add_to("pair", Part::instance_of("ball").named("other").translate([3.0, 0.0, 0.0]))?;
    /// model.add(Part::instance_of("pair"))?;
    /// model.add(Part::instance_of("pair").translate([0.0, 3.0, 0.0]))?;
    /// assert_eq!(model.compile().instance_count().to_string(), "4");
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// A name that is taken, an unknown name, a name that is not one word ([`Error::Name`]), or steps that cannot be undone, such as a scale of 0. The model is then as it was.
    pub fn add_to(&mut self, object: &str, part: Part) -> Result<String, Error> {
        // A clone shares its content, and is the way back if a later step fails.
        let mut scene = self.scene.clone();
        for name in part.name.as_deref().into_iter().chain([object]) {
            check_name(name)?;
        }
        scene.ensure_object(object)?;
        let (alias, target) = match part.content {
            Content::Shape(content) => {
                let (shape, material) = *content;
                let name =
                    part.name.unwrap_or_else(|| numbered_name("shape", 1, |name| scene.get(name).is_some()));
                if scene.get(&name).is_some() {
                    return Err(superegg_scene::SceneError::NameExists(name).into());
                }
                scene.ensure_primitive(&name)?;
                let primitive = scene.primitive_mut(&name)?;
                primitive.shape = shape;
                primitive.material = material;
                (name.clone(), name)
            }
            Content::Object(target) => {
                let parent = scene.object(object)?;
                let is_taken = |alias: &str| parent.child(alias).is_some();
                (part.name.unwrap_or_else(|| numbered_name(&target, 1, is_taken)), target)
            }
        };
        scene.add_child(object, &alias, &target)?;
        for step in part.steps {
            scene.transform_child(object, step)?;
        }
        self.scene = scene;
        Ok(alias)
    }

    /// Sets a light under a name. Without any light the scene has [`Light::DEFAULT`].
    pub fn light(&mut self, name: &str, light: Light) {
        self.scene.set_light(name, light);
    }

    /// Places the camera. `up` stays as it is: z by default.
    pub fn look_at(&mut self, position: impl Into<DVec3>, target: impl Into<DVec3>) {
        let (position, target) = (position.into(), target.into());
        self.scene.camera = Camera { position, target, ..self.scene.camera };
        self.scene.sets_camera = true;
    }

    /// The names of the primitives and objects.
    pub fn names(&self) -> impl Iterator<Item = (&str, &Entity)> {
        self.scene.entities()
    }

    /// Compiles the scene for ray queries: groups, boxes and trees. It takes about a microsecond a primitive.
    pub fn compile(&self) -> CompiledScene {
        CompiledScene::compile(&self.scene, self.root(), self.scene.depth)
    }

    /// The settings of the scene's own picture, without the files of textures and of the environment.
    pub fn settings(&self) -> RenderSettings {
        RenderSettings::of(&self.scene)
    }

    /// The settings of the scene's own picture, with the files of textures and of the environment, which are read.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Texture`] or [`Error::Environment`]: a file cannot be read.
    pub fn settings_with_pictures(&self) -> Result<RenderSettings, Error> {
        scene_file::settings_with_pictures(&self.scene)
    }

    /// Renders the scene at a size in pixels on all cores, with the samples and other settings of the scene.
    ///
    /// # Errors
    /// [`Error::Render`]: a size of 0 or too large, a camera that is not finite. Those of [`Model::settings_with_pictures`].
    pub fn render(&self, width: u32, height: u32) -> Result<Rendering, Error> {
        let mut settings = self.settings_with_pictures()?;
        settings.picture.width = width;
        settings.picture.height = height;
        self.render_with(&settings, &RenderOptions::default())
    }

    /// Renders the scene with other settings, for a given number of threads, with progress and a flag that cancels.
    ///
    /// # Errors
    /// [`Error::Render`].
    pub fn render_with(
        &self,
        settings: &RenderSettings,
        options: &RenderOptions<'_>,
    ) -> Result<Rendering, Error> {
        let rendered = render(&self.compile(), settings, options)?;
        let film = settings.output.into_colored(rendered.film);
        Ok(Rendering { film, development: settings.development(), stats: rendered.stats })
    }
}

/// Checks that the modelling language can write a name.
fn check_name(name: &str) -> Result<(), Error> {
    let mut session = Session::default();
    let is_made = session.run_line(&format!("primitive {name}")).is_ok();
    if is_made && session.selected() == Some(name) { Ok(()) } else { Err(Error::Name(name.to_owned())) }
}
