//! The scene and the changes that keep it consistent.

use indexmap::IndexMap;
use superegg_geom::glam::DVec3;
use superegg_geom::{TransformError, TransformStep};
use thiserror::Error;

use crate::camera::Camera;
use crate::light::Light;
use crate::object::{Child, Object};
use crate::primitive::Primitive;

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
    /// No light has this name.
    #[error("no light is named '{0}'")]
    UnknownLight(String),
    /// The transform is not usable.
    #[error(transparent)]
    Transform(#[from] TransformError),
}

/// Everything that a user described. Cloning it gives a snapshot that later changes do not touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    entities: IndexMap<String, Entity>,
    lights: IndexMap<String, Light>,
    /// The camera.
    pub camera: Camera,
    /// The linear colour where nothing is.
    pub background: DVec3,
    /// How deep objects are opened; the selected one is level 1, and primitives of the last level are included. 0 to [`MAX_DEPTH`].
    pub depth: u32,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            entities: IndexMap::new(),
            lights: IndexMap::new(),
            camera: Camera::default(),
            background: DVec3::ZERO,
            depth: DEFAULT_DEPTH,
        }
    }
}

impl Scene {
    /// Primitives and objects with their names, in the order they were made.
    pub fn entities(&self) -> impl ExactSizeIterator<Item = (&str, &Entity)> {
        self.entities.iter().map(|(name, entity)| (name.as_str(), entity))
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
        self.lights.iter().map(|(name, light)| (name.as_str(), light))
    }

    /// The lights that shine: those named, or the default one while none is.
    pub fn lights(&self) -> Vec<Light> {
        if self.lights.is_empty() { vec![Light::DEFAULT] } else { self.lights.values().copied().collect() }
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
                self.entities.insert(name.to_owned(), Entity::Primitive(Primitive::default()));
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
                self.entities.insert(name.to_owned(), Entity::Object(Object::default()));
                Ok(())
            }
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
        self.object(name)?;
        match self.entities.get_mut(name) {
            Some(Entity::Object(object)) => Ok(object),
            _ => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// Adds `target` to `object` under an alias and moves the object's cursor to it. The target may be the object itself, or one that
    /// contains it.
    ///
    /// # Errors
    /// An unknown name, or an alias that a child of the object has already.
    pub fn add_child(&mut self, object: &str, alias: &str, target: &str) -> Result<(), SceneError> {
        if !self.entities.contains_key(target) {
            return Err(SceneError::Unknown(target.to_owned()));
        }
        let parent = self.object_mut(object)?;
        if parent.child(alias).is_some() {
            return Err(SceneError::AliasTaken { object: object.to_owned(), alias: alias.to_owned() });
        }
        parent.push_child(alias.to_owned(), Child::new(target.to_owned()));
        Ok(())
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
        self.lights.insert(name.to_owned(), light);
    }

    /// Takes a light away.
    ///
    /// # Errors
    /// No light has this name.
    pub fn remove_light(&mut self, name: &str) -> Result<(), SceneError> {
        match self.lights.shift_remove(name) {
            Some(_) => Ok(()),
            None => Err(SceneError::UnknownLight(name.to_owned())),
        }
    }
}
