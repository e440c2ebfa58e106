//! Picture files that scenes name, by name: of the surroundings, and on surfaces.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

use superegg_lang::{PictureUse, picture_files};
use superegg_render::{EnvironmentPixels, RenderSettings, TexturePixels, TextureSet};
use superegg_scene::{Scene, TextureChannel};
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
        let named = picture_files(scene).into_iter().map(|(name, uses)| {
            let read = |used_as: PictureUse| match used_as {
                PictureUse::Environment => self.surroundings(&name).map(Result::err),
                PictureUse::Texture(channel) => self.texture(&name, channel).map(Result::err),
            };
            let read: Vec<Option<String>> = uses.into_iter().filter_map(read).collect();
            let is_given = !read.is_empty();
            FileNamed { name: name.to_string(), is_given, fault: read.into_iter().flatten().next() }
        });
        named.collect()
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
    picture_files(read.session.scene()).into_keys().map(|name| name.to_string()).collect()
}
