//! The scene and the changes that keep it consistent.

use superegg_geom::glam::DVec3;
use superegg_geom::{TransformError, TransformStep};
use thiserror::Error;

use crate::animation::{Track, TrackSubject, Tracks};
use crate::camera::Camera;
use crate::light::Light;
use crate::object::{Child, Object};
use crate::ordered_map::OrderedMap;
use crate::picture::Picture;
use crate::primitive::{Material, Primitive};
use crate::surroundings::{AmbientOcclusion, Floor, Sky};

/// How deep objects are opened unless the scene says otherwise.
pub const DEFAULT_DEPTH: u32 = 25;
/// The deepest that a scene may ask for.
pub const MAX_DEPTH: u32 = 64;

/// What a name stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Entity {
    /// A superquadric with a surface.
    Primitive(Primitive),
    /// A group.
    Object(Object),
}

impl Entity {
    /// The word for its kind, with its article.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Primitive(_) => "a primitive",
            Self::Object(_) => "an object",
        }
    }
}

/// Why a change was refused. The scene is as it was.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SceneError {
    /// Nothing has this name.
    #[error("nothing is named '{0}'")]
    Unknown(String),
    /// The name stands for a primitive where an object is needed.
    #[error("'{0}' is a primitive, not an object")]
    NotAnObject(String),
    /// The name stands for an object where a primitive is needed.
    #[error("'{0}' is an object, not a primitive")]
    NotAPrimitive(String),
    /// A child of the object has this alias already.
    #[error("'{object}' has a child '{alias}' already")]
    AliasTaken {
        /// The object.
        object: String,
        /// The alias.
        alias: String,
    },
    /// The object has no child of this alias.
    #[error("'{object}' has no child '{alias}'")]
    UnknownAlias {
        /// The object.
        object: String,
        /// The alias.
        alias: String,
    },
    /// The object has no children, so there is none at the cursor.
    #[error("'{0}' has no child yet that could be moved")]
    NoChild(String),
    /// A primitive or object has this name already.
    #[error("the name '{0}' is taken")]
    NameTaken(String),
    /// No light has this name.
    #[error("no light is named '{0}'")]
    UnknownLight(String),
    /// The other keys of this track have so many numbers.
    #[error("the other keys of {command} here have {count} numbers each")]
    KeyNumbers {
        /// The command.
        command: String,
        /// How many numbers they have.
        count: usize,
    },
    /// The transform is not usable.
    #[error(transparent)]
    Transform(#[from] TransformError),
}

/// Everything that a user described. Cloning it gives a snapshot that later changes do not touch, and takes no time that grows with it.
#[derive(Clone, Debug)]
pub struct Scene {
    entities: OrderedMap<Entity>,
    lights: OrderedMap<Light>,
    /// The camera.
    pub camera: Camera,
    /// The linear colour where nothing is, unless there is a sky.
    pub background: DVec3,
    /// What is seen where nothing is, instead of the background.
    pub sky: Option<Sky>,
    /// A plane without end.
    pub floor: Option<Floor>,
    /// Whether, and how, ambient light is kept from corners.
    pub ambient_occlusion: Option<AmbientOcclusion>,
    /// How deep objects are opened; the selected one is level 1, and primitives of the last level are included. 0 to [`MAX_DEPTH`].
    pub depth: u32,
    /// How the picture is taken.
    pub picture: Picture,
    tracks: Tracks,
}

impl PartialEq for Scene {
    /// The order in which primitives and objects were made is no part of what a scene is.
    fn eq(&self, other: &Self) -> bool {
        self.entities.has_same_entries(&other.entities)
            && self.lights == other.lights
            && self.camera == other.camera
            && self.background == other.background
            && self.sky == other.sky
            && self.floor == other.floor
            && self.ambient_occlusion == other.ambient_occlusion
            && self.depth == other.depth
            && self.picture == other.picture
            && self.tracks == other.tracks
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            entities: OrderedMap::default(),
            lights: OrderedMap::default(),
            camera: Camera::default(),
            background: DVec3::ZERO,
            sky: None,
            floor: None,
            ambient_occlusion: None,
            depth: DEFAULT_DEPTH,
            picture: Picture::default(),
            tracks: Tracks::default(),
        }
    }
}

impl Scene {
    /// Primitives and objects with their names, in the order they were made.
    pub fn entities(&self) -> impl ExactSizeIterator<Item = (&str, &Entity)> {
        self.entities.iter()
    }

    /// The objects with their names.
    pub fn objects(&self) -> impl Iterator<Item = (&str, &Object)> {
        self.entities().filter_map(|(name, entity)| match entity {
            Entity::Object(object) => Some((name, object)),
            Entity::Primitive(_) => None,
        })
    }

    /// The primitives with their names.
    pub fn primitives(&self) -> impl Iterator<Item = (&str, &Primitive)> {
        self.entities().filter_map(|(name, entity)| match entity {
            Entity::Primitive(primitive) => Some((name, primitive)),
            Entity::Object(_) => None,
        })
    }

    /// What a name stands for.
    pub fn get(&self, name: &str) -> Option<&Entity> {
        self.entities.get(name)
    }

    /// The lights that the scene names.
    pub fn named_lights(&self) -> impl ExactSizeIterator<Item = (&str, &Light)> {
        self.lights.iter()
    }

    /// The light of this name.
    ///
    /// # Errors
    /// No light has this name.
    pub fn light(&self, name: &str) -> Result<&Light, SceneError> {
        self.lights.get(name).ok_or_else(|| SceneError::UnknownLight(name.to_owned()))
    }

    /// The lights that shine: those named, or the default one while none is.
    pub fn lights(&self) -> Vec<Light> {
        let named: Vec<Light> = self.lights.iter().map(|(_, light)| *light).collect();
        if named.is_empty() { vec![Light::DEFAULT] } else { named }
    }

    /// The surface of the floor: that of the primitive it names, or of a new one.
    pub fn floor_material(&self) -> Material {
        let name = self.floor.as_ref().and_then(|floor| floor.surface.as_deref());
        match name.and_then(|name| self.get(name)) {
            Some(Entity::Primitive(primitive)) => primitive.material,
            _ => Material::default(),
        }
    }

    /// Makes a primitive of this name where there is none.
    ///
    /// # Errors
    /// The name stands for an object.
    pub fn ensure_primitive(&mut self, name: &str) -> Result<(), SceneError> {
        match self.entities.get(name) {
            Some(Entity::Object(_)) => Err(SceneError::NotAPrimitive(name.to_owned())),
            Some(Entity::Primitive(_)) => Ok(()),
            None => {
                self.entities.insert(name, Entity::Primitive(Primitive::default()));
                Ok(())
            }
        }
    }

    /// Makes an empty object of this name where there is none.
    ///
    /// # Errors
    /// The name stands for a primitive.
    pub fn ensure_object(&mut self, name: &str) -> Result<(), SceneError> {
        match self.entities.get(name) {
            Some(Entity::Primitive(_)) => Err(SceneError::NotAnObject(name.to_owned())),
            Some(Entity::Object(_)) => Ok(()),
            None => {
                self.entities.insert(name, Entity::Object(Object::default()));
                Ok(())
            }
        }
    }

    /// The primitive of this name.
    ///
    /// # Errors
    /// The name is unknown or an object's.
    pub fn primitive(&self, name: &str) -> Result<&Primitive, SceneError> {
        match self.entities.get(name) {
            Some(Entity::Primitive(primitive)) => Ok(primitive),
            Some(Entity::Object(_)) => Err(SceneError::NotAPrimitive(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// The primitive of this name, to change it.
    ///
    /// # Errors
    /// The name is unknown or an object's.
    pub fn primitive_mut(&mut self, name: &str) -> Result<&mut Primitive, SceneError> {
        match self.entities.get_mut(name) {
            Some(Entity::Primitive(primitive)) => Ok(primitive),
            Some(Entity::Object(_)) => Err(SceneError::NotAPrimitive(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// The object of this name.
    ///
    /// # Errors
    /// The name is unknown or a primitive's.
    pub fn object(&self, name: &str) -> Result<&Object, SceneError> {
        match self.entities.get(name) {
            Some(Entity::Object(object)) => Ok(object),
            Some(Entity::Primitive(_)) => Err(SceneError::NotAnObject(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    fn object_mut(&mut self, name: &str) -> Result<&mut Object, SceneError> {
        match self.entities.get_mut(name) {
            Some(Entity::Object(object)) => Ok(object),
            Some(Entity::Primitive(_)) => Err(SceneError::NotAnObject(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// Adds `target` to `object` under an alias and moves the object's cursor to it. The target may be the object itself, or one that
    /// contains it.
    ///
    /// # Errors
    /// An unknown name, or an alias that a child of the object has already.
    pub fn add_child(&mut self, object: &str, alias: &str, target: &str) -> Result<(), SceneError> {
        if !self.entities.contains(target) {
            return Err(SceneError::Unknown(target.to_owned()));
        }
        let parent = self.object_mut(object)?;
        if parent.child(alias).is_some() {
            return Err(SceneError::AliasTaken { object: object.to_owned(), alias: alias.to_owned() });
        }
        parent.push_child(alias, Child::new(target));
        Ok(())
    }

    /// Takes the child of this alias out of the object, and its keys away. A cursor that stood on it goes to the last child.
    ///
    /// # Errors
    /// An unknown object or alias.
    pub fn remove_child(&mut self, object: &str, alias: &str) -> Result<(), SceneError> {
        if self.object_mut(object)?.remove_child(alias) {
            self.tracks.remove(None, |subject| {
                subject.selected.as_deref() == Some(object) && subject.cursor.as_deref() == Some(alias)
            });
            Ok(())
        } else {
            Err(SceneError::UnknownAlias { object: object.to_owned(), alias: alias.to_owned() })
        }
    }

    /// Object and alias of each child that stands for this name.
    pub fn uses(&self, name: &str) -> Vec<(String, String)> {
        let uses_in = |(object, content): (&str, &Object)| -> Vec<(String, String)> {
            content.aliases_of(name).map(|alias| (object.to_owned(), alias.to_owned())).collect()
        };
        self.objects().flat_map(uses_in).collect()
    }

    /// Takes a primitive or object away, its keys, and every child that stands for it. Returns object and alias of those children.
    ///
    /// # Errors
    /// An unknown name.
    pub fn delete(&mut self, name: &str) -> Result<Vec<(String, String)>, SceneError> {
        if !self.entities.contains(name) {
            return Err(SceneError::Unknown(name.to_owned()));
        }
        let uses = self.uses(name);
        for (object, alias) in &uses {
            self.remove_child(object, alias)?;
        }
        self.entities.remove(name);
        self.tracks.remove(None, |subject| subject.is_about(name));
        if let Some(floor) = &mut self.floor {
            floor.surface.take_if(|surface| **surface == *name);
        }
        Ok(uses)
    }

    /// Gives a primitive or object another name. The children that stand for it follow, and its keys; their aliases stay.
    ///
    /// # Errors
    /// An unknown name, or a new one that is taken.
    pub fn rename(&mut self, name: &str, new: &str) -> Result<(), SceneError> {
        self.check_pair(name, new)?;
        self.entities.rename(name, new);
        self.tracks.rename(name, new);
        let objects: Vec<String> = self.objects().map(|(object, _)| object.to_owned()).collect();
        for object in objects {
            if self.object(&object)?.aliases_of(name).next().is_some() {
                self.object_mut(&object)?.retarget(name, new);
            }
        }
        if let Some(surface) = self.floor.as_mut().and_then(|floor| floor.surface.as_mut())
            && **surface == *name
        {
            *surface = new.into();
        }
        Ok(())
    }

    /// Adds a copy under a new name, at the end, without keys. Where an object holds itself, its copy holds itself too.
    ///
    /// # Errors
    /// An unknown name, or a new one that is taken.
    pub fn copy(&mut self, name: &str, new: &str) -> Result<(), SceneError> {
        let entity = self.check_pair(name, new)?.clone();
        self.entities.insert(new, entity);
        if let Some(Entity::Object(object)) = self.entities.get_mut(new) {
            object.retarget(name, new);
        }
        Ok(())
    }

    /// What has the first name, where nothing has the second.
    fn check_pair(&self, name: &str, new: &str) -> Result<&Entity, SceneError> {
        let entity = self.get(name).ok_or_else(|| SceneError::Unknown(name.to_owned()))?;
        if self.entities.contains(new) { Err(SceneError::NameTaken(new.to_owned())) } else { Ok(entity) }
    }

    /// Moves the object's cursor to the child of this alias.
    ///
    /// # Errors
    /// An unknown object or alias.
    pub fn move_cursor(&mut self, object: &str, alias: &str) -> Result<(), SceneError> {
        if self.object_mut(object)?.move_cursor(alias) {
            Ok(())
        } else {
            Err(SceneError::UnknownAlias { object: object.to_owned(), alias: alias.to_owned() })
        }
    }

    /// Appends a step to the transform of the child at the object's cursor.
    ///
    /// # Errors
    /// No such object, no child, or a step after which the transform could not be undone.
    pub fn transform_child(&mut self, object: &str, step: TransformStep) -> Result<(), SceneError> {
        if self.object_mut(object)?.push_child_step(step)? {
            Ok(())
        } else {
            Err(SceneError::NoChild(object.to_owned()))
        }
    }

    /// Appends a step to the object's transform of the whole.
    ///
    /// # Errors
    /// No such object, or a step after which the transform could not be undone.
    pub fn transform_whole(&mut self, object: &str, step: TransformStep) -> Result<(), SceneError> {
        Ok(self.object_mut(object)?.push_overall_step(step)?)
    }

    /// Adds or replaces a light.
    pub fn set_light(&mut self, name: &str, light: Light) {
        self.lights.insert(name, light);
    }

    /// Takes a light away, and its keys.
    ///
    /// # Errors
    /// No light has this name.
    pub fn remove_light(&mut self, name: &str) -> Result<(), SceneError> {
        if !self.lights.remove(name) {
            return Err(SceneError::UnknownLight(name.to_owned()));
        }
        self.tracks.remove(None, |subject| subject.names_light(name));
        Ok(())
    }

    /// The tracks of keys, in the order in which they began. They change nothing here: what a scene is at a frame the
    /// language knows, whose commands they are of.
    pub fn tracks(&self) -> impl ExactSizeIterator<Item = &Track> {
        self.tracks.iter()
    }

    /// Adds a key, or replaces the one at its frame. What the subject names is there; the numbers are as many as it has places for.
    ///
    /// # Errors
    /// The other keys of the same subject have another count of numbers.
    pub fn set_key(&mut self, subject: TrackSubject, frame: f64, numbers: &[f64]) -> Result<(), SceneError> {
        let command = subject.command.to_string();
        self.tracks.set(subject, frame, numbers).map_err(|count| SceneError::KeyNumbers { command, count })
    }

    /// Takes away the keys at a frame, or all of them, of the tracks that are meant. Returns how many there were.
    pub fn remove_keys(&mut self, frame: Option<f64>, is_meant: impl Fn(&TrackSubject) -> bool) -> usize {
        self.tracks.remove(frame, is_meant)
    }
}
