//! Picture files that scenes name, by name: of the surroundings, and on surfaces.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

use superegg_render::{EnvironmentPixels, RenderSettings, TexturePixels, TextureSet};
use superegg_scene::{Entity, EnvironmentLight, Scene, TextureChannel};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::answers::FileNamed;
use crate::file::{is_data, read};

/// Files by name, with the pictures that have been read from them. Copies share them, so that a scene that is typed anew does
/// not read them again.
#[wasm_bindgen]
#[derive(Clone, Default)]
pub struct Files(Rc<RefCell<BTreeMap<String, File>>>);

/// A file, and each picture once it is read: pixels, or the reason why there are none.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    color: Option<Result<Arc<TexturePixels>, String>>,
    value: Option<Result<Arc<TexturePixels>, String>>,
    surroundings: Option<Result<Arc<EnvironmentPixels>, String>>,
}

#[wasm_bindgen]
impl Files {
    /// No files.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file, in place of one of the same name.
    pub fn put(&self, name: &str, bytes: &[u8]) {
        let file = File { bytes: bytes.to_vec(), ..File::default() };
        self.0.borrow_mut().insert(name.to_owned(), file);
    }

    /// Forgets all files but those of these names.
    pub fn keep(&self, names: Vec<String>) {
        let names: BTreeSet<String> = names.into_iter().collect();
        self.0.borrow_mut().retain(|name, _| names.contains(name));
    }
}

/// The use of a file in a scene.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    Surroundings,
    Texture(TextureChannel),
}

/// The files that a scene names, each use once.
fn uses(scene: &Scene) -> Vec<(String, Use)> {
    let mut found = Vec::new();
    let mut add = |name: &str, of: Use| {
        if !found.iter().any(|(known, as_what)| known == name && *as_what == of) {
            found.push((name.to_owned(), of));
        }
    };
    if let Some(EnvironmentLight::Picture(picture)) = &scene.environment {
        add(&picture.file, Use::Surroundings);
    }
    for (_, entity) in scene.entities() {
        let Entity::Primitive(primitive) = entity else { continue };
        let textures = primitive.textures.iter().flat_map(|textures| textures.all());
        textures.for_each(|(channel, texture)| add(&texture.file, Use::Texture(channel)));
    }
    found
}

/// The name of a file without its folders: a file that is dropped has no more.
fn bare(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

impl Files {
    /// Reads the file of a name, or one of the same name in another folder; `None` if there is none.
    fn with<T>(&self, name: &str, read: impl FnOnce(&mut File) -> T) -> Option<T> {
        let mut files = self.0.borrow_mut();
        let key = match files.contains_key(name) {
            true => name.to_owned(),
            false => files.keys().find(|key| bare(key) == bare(name))?.clone(),
        };
        files.get_mut(&key).map(read)
    }

    fn texture(&self, name: &str, channel: TextureChannel) -> Option<Result<Arc<TexturePixels>, String>> {
        self.with(name, |file| {
            let is_color = channel == TextureChannel::Color;
            let known = if is_color { &mut file.color } else { &mut file.value };
            let read = || match TexturePixels::of_file(&file.bytes, is_color) {
                Ok(pixels) => Ok(Arc::new(pixels)),
                Err(error) => Err(format!("'{name}' is no texture: {error}")),
            };
            known.get_or_insert_with(read).clone()
        })
    }

    fn surroundings(&self, name: &str) -> Option<Result<Arc<EnvironmentPixels>, String>> {
        self.with(name, |file| {
            let read = || match EnvironmentPixels::of_file(&file.bytes) {
                Ok(pixels) => Ok(Arc::new(pixels)),
                Err(error) => Err(format!("'{name}' is no picture of surroundings: {error}")),
            };
            file.surroundings.get_or_insert_with(read).clone()
        })
    }

    /// The settings of a scene's picture, with the files that are here. Surfaces and surroundings without theirs are plain.
    pub(crate) fn settings(&self, scene: &Scene) -> RenderSettings {
        let textures =
            TextureSet::available(scene, |texture, channel| self.texture(&texture.file, channel)?.ok());
        let settings = RenderSettings::of(scene).with_textures(textures);
        let missing = settings.clone();
        settings
            .with_surroundings(scene, |picture| {
                self.surroundings(&picture.file).and_then(Result::ok).ok_or(())
            })
            .unwrap_or(missing)
    }

    /// The files that a scene names: whether each is here, and the fault of one that cannot be read.
    pub(crate) fn named_by(&self, scene: &Scene) -> Vec<FileNamed> {
        let mut named: Vec<FileNamed> = Vec::new();
        for (name, of) in uses(scene) {
            let read = match of {
                Use::Surroundings => self.surroundings(&name).map(Result::err),
                Use::Texture(channel) => self.texture(&name, channel).map(Result::err),
            };
            let is_given = read.is_some();
            let fault = read.flatten();
            match named.iter_mut().find(|known| known.name == name) {
                Some(known) => known.fault = known.fault.take().or(fault),
                None => named.push(FileNamed { name, is_given, fault }),
            }
        }
        named
    }
}

/// The names of the pictures that a file of a scene names, and nothing for a file of another kind. The scene is read but not
/// compiled.
#[wasm_bindgen(js_name = filesNamed)]
pub fn files_named(name: &str, bytes: &[u8]) -> Vec<String> {
    if is_data(bytes) {
        return Vec::new();
    }
    let Ok(read) = read(name, bytes) else { return Vec::new() };
    read.session.scene().picture_files().into_iter().map(str::to_owned).collect()
}
