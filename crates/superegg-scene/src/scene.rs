//! The scene, and the changes that keep it consistent.

use std::sync::Arc;

use superegg_geom::glam::DVec3;
use superegg_geom::{TransformError, TransformStep};
use thiserror::Error;

use crate::animation::{Track, TrackSubject};
use crate::camera::Camera;
use crate::environment::{AmbientOcclusion, EnvironmentLight, Floor, Sky};
use crate::light::Light;
use crate::object::{Child, Object};
use crate::ordered_map::OrderedMap;
use crate::picture::Picture;
use crate::primitive::{Material, Primitive};
use crate::table::InstanceTable;
use crate::texture::{Texture, TextureChannel};
use crate::tracks::Tracks;
use crate::uses::Uses;

/// The default recursion depth of objects.
pub const DEFAULT_DEPTH: u32 = 25;
/// The maximal recursion depth of objects.
pub const MAX_DEPTH: u32 = 64;

/// A primitive, an object or a table of instances: what a name refers to.
#[derive(Clone, Debug, PartialEq)]
pub enum Entity {
    /// A superquadric with a material.
    Primitive(Primitive),
    /// A group of children.
    Object(Object),
    /// Many instances as columns. A table can be a child of objects; it never changes.
    Table(InstanceTable),
}

impl Entity {
    /// Whether it is a primitive with pictures on its surface.
    pub fn has_textures(&self) -> bool {
        matches!(self, Self::Primitive(primitive) if primitive.textures.is_some())
    }

    /// The kind with its article: "a primitive", "an object" or "a table of instances".
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Primitive(_) => "a primitive",
            Self::Object(_) => "an object",
            Self::Table(_) => "a table of instances",
        }
    }
}

/// Why a change was rejected. The scene is unchanged.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SceneError {
    /// Nothing has this name.
    #[error("nothing is named '{0}'")]
    Unknown(String),
    /// The name belongs to a primitive; an object is needed.
    #[error("'{0}' is a primitive, not an object")]
    NotAnObject(String),
    /// The name belongs to an object; a primitive is needed.
    #[error("'{0}' is an object, not a primitive")]
    NotAPrimitive(String),
    /// The name belongs to a table, which cannot be changed.
    #[error("'{0}' is a table of instances, which cannot be changed")]
    IsTable(String),
    /// The object already has a child with this alias.
    #[error("'{object}' has a child '{alias}' already")]
    AliasExists {
        /// The object.
        object: String,
        /// The alias.
        alias: String,
    },
    /// The object has no child with this alias.
    #[error("'{object}' has no child '{alias}'")]
    UnknownAlias {
        /// The object.
        object: String,
        /// The alias.
        alias: String,
    },
    /// The object has no children, so no child is at the cursor.
    #[error("'{0}' has no child yet")]
    NoChild(String),
    /// A primitive or object already has this name.
    #[error("the name '{0}' is taken")]
    NameExists(String),
    /// No light has this name.
    #[error("no light is named '{0}'")]
    UnknownLight(String),
    /// The count of numbers differs from that of the track's other keys.
    #[error("the other keys of {command} here have {count} numbers each")]
    KeyNumbers {
        /// The command.
        command: String,
        /// The count of numbers in the other keys.
        count: usize,
    },
    /// The transform is not invertible.
    #[error(transparent)]
    Transform(#[from] TransformError),
}

/// A scene: named primitives and objects, lights, camera, environment, image settings, keyframes.
///
/// Cloning takes constant time and gives a snapshot that later changes do not affect.
///
/// ```
/// use superegg_geom::TransformStep;
/// use superegg_geom::glam::DVec3;
/// use superegg_scene::{Scene, SceneError};
///
/// let mut scene = Scene::default();
/// scene.ensure_primitive("ball")?;
/// scene.primitive_mut("ball")?.material.color = DVec3::new(0.8, 0.2, 0.1);
/// scene.ensure_object("snowman")?;
/// scene.add_child("snowman", "body", "ball")?;
/// scene.add_child("snowman", "head", "ball")?;
/// scene.transform_child("snowman", TransformStep::Translate(DVec3::new(0.0, 0.0, 1.5)))?;
///
/// let snowman = scene.object("snowman")?;
/// let head = snowman.parent_from_child(snowman.child("head").unwrap())?;
/// assert_eq!(head.forward().translation.z, 1.5);
/// assert!(matches!(scene.add_child("snowman", "hat", "cone"), Err(SceneError::Unknown(_))));
/// # Ok::<(), SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    entities: OrderedMap<Arc<Entity>>,
    /// The number of the entity that was changed last. The next change is likely to be there.
    recent: usize,
    lights: OrderedMap<Light>,
    /// The camera.
    pub camera: Camera,
    /// Whether the scene has set its camera, even to the default one.
    pub sets_camera: bool,
    /// The up direction of sky and floor unless they have their own; not zero.
    up: DVec3,
    /// The linear colour of rays that hit nothing, if there is no sky.
    pub background: DVec3,
    /// The sky, which replaces the background.
    pub sky: Option<Sky>,
    /// Light from far away in all directions, which replaces sky and background.
    pub environment: Option<EnvironmentLight>,
    /// The floor, an infinite plane.
    pub floor: Option<Floor>,
    /// Ambient occlusion; `None` if off.
    pub ambient_occlusion: Option<AmbientOcclusion>,
    /// The recursion depth of objects, 0 to [`MAX_DEPTH`]. The root object is level 1; primitives
    /// of the last level are included.
    pub depth: u32,
    /// The image settings.
    pub picture: Picture,
    tracks: Tracks,
    /// Kept only after many deletions and renamings.
    uses: Option<Uses>,
    /// The number of searches through all children.
    searches: u32,
}

/// The number of deletions and renamings that search all children. A scene has millions of children,
/// and few have ever a name deleted; for more deletions than these an index is made and kept.
const MOST_SEARCHES: u32 = 64;

impl PartialEq for Scene {
    /// Ignores the order in which primitives and objects were created.
    fn eq(&self, other: &Self) -> bool {
        self.entities.has_same_entries(&other.entities)
            && self.lights == other.lights
            && self.camera == other.camera
            && self.sets_camera == other.sets_camera
            && self.up == other.up
            && self.background == other.background
            && self.sky == other.sky
            && self.environment == other.environment
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
            recent: 0,
            lights: OrderedMap::default(),
            camera: Camera::default(),
            sets_camera: false,
            up: DVec3::Y,
            background: DVec3::ZERO,
            sky: None,
            environment: None,
            floor: None,
            ambient_occlusion: None,
            depth: DEFAULT_DEPTH,
            picture: Picture::default(),
            tracks: Tracks::default(),
            uses: None,
            searches: 0,
        }
    }
}

impl Scene {
    /// Primitives and objects with their names, in the order of creation.
    pub fn entities(&self) -> impl ExactSizeIterator<Item = (&str, &Entity)> {
        self.entities.iter().map(|(name, entity)| (name, &**entity))
    }

    /// The entities with their names and numbers, in the order of creation. A number belongs to one
    /// scene: it stays the same until an entity is deleted.
    pub fn numbered_entities(&self) -> impl Iterator<Item = (usize, &str, &Entity)> {
        self.entities.numbered().map(|(number, name, entity)| (number, name, &**entity))
    }

    /// The number of the entity of this name, as in [`Scene::numbered_entities`]. It is found at once
    /// if it is `guess`.
    pub fn entity_number(&self, name: &str, guess: usize) -> Option<usize> {
        if self.entities.name_at(guess) == Some(name) { Some(guess) } else { self.entities.number_of(name) }
    }

    /// The objects with their names.
    pub fn objects(&self) -> impl Iterator<Item = (&str, &Object)> {
        self.entities().filter_map(|(name, entity)| match entity {
            Entity::Object(object) => Some((name, object)),
            Entity::Primitive(_) | Entity::Table(_) => None,
        })
    }

    /// The primitives with their names.
    pub fn primitives(&self) -> impl Iterator<Item = (&str, &Primitive)> {
        self.entities().filter_map(|(name, entity)| match entity {
            Entity::Primitive(primitive) => Some((name, primitive)),
            Entity::Object(_) | Entity::Table(_) => None,
        })
    }

    /// The tables of instances with their names.
    pub fn tables(&self) -> impl Iterator<Item = (&str, &InstanceTable)> {
        self.entities().filter_map(|(name, entity)| match entity {
            Entity::Table(table) => Some((name, table)),
            Entity::Primitive(_) | Entity::Object(_) => None,
        })
    }

    /// Adds a table of instances under a new name.
    ///
    /// # Errors
    /// The name exists.
    pub fn add_table(&mut self, name: &str, table: InstanceTable) -> Result<(), SceneError> {
        if self.entities.contains(name) {
            return Err(SceneError::NameExists(name.to_owned()));
        }
        self.insert(name, Entity::Table(table));
        Ok(())
    }

    /// Replaces each table by that of the same name in another scene, if there is one. The tables
    /// are shared, not copied.
    ///
    /// ```
    /// use superegg_geom::glam::{DQuat, DVec3};
    /// use superegg_geom::Exponents;
    /// use superegg_scene::{Material, Scene, TableBuilder};
    ///
    /// let scene = |count: u32| {
    ///     let mut builder = TableBuilder::default();
    ///     let material = builder.material(Material::default());
    ///     let grain = builder.shape(DVec3::ONE, Exponents::ROUND, material)?;
    ///     (0..count).for_each(|_| builder.push(grain, DVec3::ZERO, DQuat::IDENTITY, None));
    ///     let mut scene = Scene::default();
    ///     scene.add_table("grains", builder.finish())?;
    ///     Ok::<_, Box<dyn std::error::Error>>(scene)
    /// };
    /// let mut shown = scene(1)?;
    /// shown.share_tables(&scene(3)?);
    /// assert_eq!(shown.tables().map(|(_, table)| table.len()).sum::<usize>(), 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn share_tables(&mut self, other: &Self) {
        for (name, _) in other.tables() {
            if matches!(self.get(name), Some(Entity::Table(_))) {
                self.entities.share(name, &other.entities);
            }
        }
    }

    /// The primitive or object of this name.
    pub fn get(&self, name: &str) -> Option<&Entity> {
        let number = self.entity_number(name, self.recent)?;
        self.entities.get_at(number).map(|entity| &**entity)
    }

    fn get_mut(&mut self, name: &str) -> Option<&mut Entity> {
        self.recent = self.entity_number(name, self.recent)?;
        self.entities.get_mut_at(self.recent).map(Arc::make_mut)
    }

    /// Adds an entity, or replaces the one of this name.
    fn insert(&mut self, name: &str, entity: Entity) {
        self.entities.insert(name, Arc::new(entity));
    }

    /// The lights with their names; empty if only the default light shines.
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

    /// The lights of the image: the named ones, or [`Light::DEFAULT`] if there is none.
    pub fn lights(&self) -> Vec<Light> {
        let named: Vec<Light> = self.lights.iter().map(|(_, light)| *light).collect();
        if named.is_empty() { vec![Light::DEFAULT] } else { named }
    }

    /// The material of the floor: that of its primitive, or the default material.
    pub fn floor_material(&self) -> Material {
        let name = self.floor.as_ref().and_then(|floor| floor.surface.as_deref());
        match name.and_then(|name| self.get(name)) {
            Some(Entity::Primitive(primitive)) => primitive.material,
            _ => Material::default(),
        }
    }

    /// Creates a primitive of this name if there is none.
    ///
    /// # Errors
    /// The name belongs to an object.
    pub fn ensure_primitive(&mut self, name: &str) -> Result<(), SceneError> {
        match self.get(name) {
            Some(Entity::Object(_)) => Err(SceneError::NotAPrimitive(name.to_owned())),
            Some(Entity::Table(_)) => Err(SceneError::IsTable(name.to_owned())),
            Some(Entity::Primitive(_)) => Ok(()),
            None => {
                self.insert(name, Entity::Primitive(Primitive::default()));
                Ok(())
            }
        }
    }

    /// Creates an empty object of this name if there is no object or table.
    ///
    /// # Errors
    /// The name belongs to a primitive.
    pub fn ensure_object(&mut self, name: &str) -> Result<(), SceneError> {
        match self.get(name) {
            Some(Entity::Primitive(_)) => Err(SceneError::NotAnObject(name.to_owned())),
            Some(Entity::Object(_) | Entity::Table(_)) => Ok(()),
            None => {
                self.insert(name, Entity::Object(Object::default()));
                Ok(())
            }
        }
    }

    /// The primitive of this name.
    ///
    /// # Errors
    /// The name is unknown, or belongs to an object.
    pub fn primitive(&self, name: &str) -> Result<&Primitive, SceneError> {
        match self.get(name) {
            Some(Entity::Primitive(primitive)) => Ok(primitive),
            Some(Entity::Object(_)) => Err(SceneError::NotAPrimitive(name.to_owned())),
            Some(Entity::Table(_)) => Err(SceneError::IsTable(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// Mutable access to the primitive of this name.
    ///
    /// # Errors
    /// The name is unknown, or belongs to an object.
    pub fn primitive_mut(&mut self, name: &str) -> Result<&mut Primitive, SceneError> {
        match self.get_mut(name) {
            Some(Entity::Primitive(primitive)) => Ok(primitive),
            Some(Entity::Object(_)) => Err(SceneError::NotAPrimitive(name.to_owned())),
            Some(Entity::Table(_)) => Err(SceneError::IsTable(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// The object of this name.
    ///
    /// # Errors
    /// The name is unknown, or belongs to a primitive.
    pub fn object(&self, name: &str) -> Result<&Object, SceneError> {
        match self.get(name) {
            Some(Entity::Object(object)) => Ok(object),
            Some(Entity::Primitive(_)) => Err(SceneError::NotAnObject(name.to_owned())),
            Some(Entity::Table(_)) => Err(SceneError::IsTable(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    fn object_mut(&mut self, name: &str) -> Result<&mut Object, SceneError> {
        match self.get_mut(name) {
            Some(Entity::Object(object)) => Ok(object),
            Some(Entity::Primitive(_)) => Err(SceneError::NotAnObject(name.to_owned())),
            Some(Entity::Table(_)) => Err(SceneError::IsTable(name.to_owned())),
            None => Err(SceneError::Unknown(name.to_owned())),
        }
    }

    /// Adds `target` to `object` under an alias and moves the object's cursor to the new child. The
    /// target may be the object itself, or an object that contains it.
    ///
    /// # Errors
    /// An unknown name, or an existing alias.
    pub fn add_child(&mut self, object: &str, alias: &str, target: &str) -> Result<(), SceneError> {
        if !self.entities.contains(target) {
            return Err(SceneError::Unknown(target.to_owned()));
        }
        if self.object_mut(object)?.push_child(alias, Child::new(target)) {
            if let Some(uses) = &mut self.uses {
                uses.add(target, object, alias);
            }
            Ok(())
        } else {
            Err(SceneError::AliasExists { object: object.to_owned(), alias: alias.to_owned() })
        }
    }

    /// Removes a child and its keys from an object. A cursor on it moves to the last child.
    ///
    /// # Errors
    /// An unknown object or alias.
    pub fn remove_child(&mut self, object: &str, alias: &str) -> Result<(), SceneError> {
        let target = self.object(object)?.child(alias).map(|child| child.target().to_owned());
        if let Some(target) = target {
            self.object_mut(object)?.remove_child(alias);
            if let Some(uses) = &mut self.uses {
                uses.remove(&target, object, alias);
            }
            self.tracks.remove_child(object, alias);
            Ok(())
        } else {
            Err(SceneError::UnknownAlias { object: object.to_owned(), alias: alias.to_owned() })
        }
    }

    /// Gives a child another alias. Its keys follow.
    ///
    /// # Errors
    /// An unknown object or alias, or an existing new alias.
    pub fn rename_child(&mut self, object: &str, alias: &str, new: &str) -> Result<(), SceneError> {
        let held = self.object(object)?;
        let Some(child) = held.child(alias) else {
            return Err(SceneError::UnknownAlias { object: object.to_owned(), alias: alias.to_owned() });
        };
        if held.child(new).is_some() {
            return Err(SceneError::AliasExists { object: object.to_owned(), alias: new.to_owned() });
        }
        let target = child.target().to_owned();
        self.object_mut(object)?.rename_child(alias, new);
        if let Some(uses) = &mut self.uses {
            uses.remove(&target, object, alias);
            uses.add(&target, object, new);
        }
        self.tracks.rename_child(object, alias, new);
        Ok(())
    }

    /// Hides a child of an object, or shows it again. A hidden child keeps its transform and its
    /// keys.
    ///
    /// # Errors
    /// An unknown object or alias.
    pub fn set_hidden(&mut self, object: &str, alias: &str, is_hidden: bool) -> Result<(), SceneError> {
        if self.object(object)?.child(alias).is_none() {
            return Err(SceneError::UnknownAlias { object: object.to_owned(), alias: alias.to_owned() });
        }
        self.object_mut(object)?.set_hidden(alias, is_hidden);
        Ok(())
    }

    /// Shows all children of an object.
    ///
    /// # Errors
    /// An unknown object.
    pub fn show_all(&mut self, object: &str) -> Result<(), SceneError> {
        self.object_mut(object)?.show_all();
        Ok(())
    }

    /// The object and alias of each child that refers to this name.
    pub fn uses(&self, name: &str) -> Vec<(String, String)> {
        let Some(uses) = &self.uses else {
            let uses_in = |(object, content): (&str, &Object)| -> Vec<(String, String)> {
                content.aliases_of(name).map(|alias| (object.to_owned(), alias.to_owned())).collect()
            };
            return self.objects().flat_map(uses_in).collect();
        };
        let mut found: Vec<(String, String)> =
            uses.of_target(name).map(|(object, alias)| (object.to_owned(), alias.to_owned())).collect();
        found.sort_by_cached_key(|(object, alias)| {
            let child = self.object(object).ok().and_then(|object| object.child_number(alias));
            (self.entities.number_of(object), child)
        });
        found
    }

    /// As [`Scene::uses`], for a change that may come many times.
    fn indexed_uses(&mut self, name: &str) -> Vec<(String, String)> {
        self.searches = self.searches.saturating_add(1);
        if self.uses.is_none() && self.searches > MOST_SEARCHES {
            self.uses = Some(Uses::of(self.objects()));
        }
        self.uses(name)
    }

    /// Deletes a primitive or object, its keys, and every child that refers to it. Returns the
    /// object and alias of those children.
    ///
    /// # Errors
    /// An unknown name.
    pub fn delete(&mut self, name: &str) -> Result<Vec<(String, String)>, SceneError> {
        if !self.entities.contains(name) {
            return Err(SceneError::Unknown(name.to_owned()));
        }
        let found = self.indexed_uses(name);
        for (object, alias) in &found {
            self.remove_child(object, alias)?;
        }
        if let (Some(uses), Some(entity)) = (&mut self.uses, self.entities.get(name))
            && let Entity::Object(object) = &**entity
        {
            uses.remove_object(name, object);
        }
        self.entities.remove(name);
        self.tracks.remove_entity(name);
        if let Some(floor) = &mut self.floor {
            floor.surface.take_if(|surface| **surface == *name);
        }
        Ok(found)
    }

    /// Renames a primitive or object. Children that refer to it, the floor and keys follow; aliases
    /// stay.
    ///
    /// # Errors
    /// An unknown name, or a new name that exists.
    pub fn rename(&mut self, name: &str, new: &str) -> Result<(), SceneError> {
        self.check_pair(name, new)?;
        for (object, alias) in self.indexed_uses(name) {
            self.object_mut(&object)?.retarget_child(&alias, new);
            if let Some(uses) = &mut self.uses {
                uses.remove(name, &object, &alias);
                uses.add(new, &object, &alias);
            }
        }
        if let (Some(uses), Some(entity)) = (&mut self.uses, self.entities.get(name))
            && let Entity::Object(object) = &**entity
        {
            uses.remove_object(name, object);
            uses.add_object(new, object);
        }
        self.entities.rename(name, new);
        self.tracks.rename(name, new);
        if let Some(surface) = self.floor.as_mut().and_then(|floor| floor.surface.as_mut())
            && **surface == *name
        {
            *surface = new.into();
        }
        Ok(())
    }

    /// Adds a copy under a new name, without keys. The copy of an object that contains itself
    /// contains itself.
    ///
    /// # Errors
    /// An unknown name, or a new name that exists.
    pub fn copy(&mut self, name: &str, new: &str) -> Result<(), SceneError> {
        let entity = self.check_pair(name, new)?.clone();
        self.insert(new, entity);
        if let Some(Entity::Object(object)) = self.get_mut(new) {
            object.retarget(name, new);
        }
        if let (Some(uses), Some(entity)) = (&mut self.uses, self.entities.get(new))
            && let Entity::Object(object) = &**entity
        {
            uses.add_object(new, object);
        }
        Ok(())
    }

    /// The entity called `name`, if `new` is free.
    fn check_pair(&self, name: &str, new: &str) -> Result<&Entity, SceneError> {
        let entity = self.get(name).ok_or_else(|| SceneError::Unknown(name.to_owned()))?;
        if self.entities.contains(new) { Err(SceneError::NameExists(new.to_owned())) } else { Ok(entity) }
    }

    /// Moves the object's cursor to a child.
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
    /// Unknown object, no child, or a step that makes the transform not invertible.
    pub fn transform_child(&mut self, object: &str, step: TransformStep) -> Result<(), SceneError> {
        if self.object_mut(object)?.push_child_step(step)? {
            Ok(())
        } else {
            Err(SceneError::NoChild(object.to_owned()))
        }
    }

    /// Appends a step to the transform of the whole object.
    ///
    /// # Errors
    /// Unknown object, or a step that makes the transform not invertible.
    pub fn transform_whole(&mut self, object: &str, step: TransformStep) -> Result<(), SceneError> {
        Ok(self.object_mut(object)?.push_overall_step(step)?)
    }

    /// The direction that is up: the default of camera, sky and floor.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// Sets the up direction of camera, sky and floor, and the default of a later sky or floor.
    /// `up` must not be zero.
    pub fn set_up(&mut self, up: DVec3) {
        self.up = up;
        self.camera.up = up;
        if let Some(sky) = &mut self.sky {
            sky.up = up;
        }
        if let Some(floor) = &mut self.floor {
            floor.up = up;
        }
    }

    /// Adds or replaces a light.
    pub fn set_light(&mut self, name: &str, light: Light) {
        self.lights.insert(name, light);
    }

    /// Removes a light and its keys.
    ///
    /// # Errors
    /// No light has this name.
    pub fn remove_light(&mut self, name: &str) -> Result<(), SceneError> {
        if !self.lights.remove(name) {
            return Err(SceneError::UnknownLight(name.to_owned()));
        }
        self.tracks.remove_light(name);
        Ok(())
    }

    /// Gives other names to files: of textures, and of the picture of the surroundings. `new_name` returns `None` for a name that
    /// stays. Returns whether any name is another now.
    pub fn rename_files(&mut self, new_name: &mut dyn FnMut(&str) -> Option<String>) -> bool {
        let mut is_changed = false;
        let textured = self.entities().filter(|(_, entity)| entity.has_textures());
        let names: Vec<Arc<str>> = textured.map(|(name, _)| name.into()).collect();
        for name in names {
            let Ok(primitive) = self.primitive(&name) else { continue };
            let Some(mut textures) = primitive.textures.as_deref().cloned() else { continue };
            let mut is_renamed = false;
            for channel in TextureChannel::ALL {
                let Some(texture) = textures.get(channel) else { continue };
                if let Some(file) = new_name(&texture.file) {
                    textures.set(channel, Some(Texture { file: file.into(), ..texture.clone() }));
                    is_renamed = true;
                }
            }
            if is_renamed && let Ok(primitive) = self.primitive_mut(&name) {
                primitive.textures = Some(Arc::new(textures));
                is_changed = true;
            }
        }
        if let Some(EnvironmentLight::Picture(picture)) = &mut self.environment
            && let Some(file) = new_name(&picture.file)
        {
            picture.file = file.into();
            is_changed = true;
        }
        is_changed
    }

    /// The keyframe tracks, in the order of creation. The scene only stores them; the language,
    /// which knows their commands, evaluates them.
    pub fn tracks(&self) -> impl ExactSizeIterator<Item = &Track> {
        self.tracks.iter()
    }

    /// Adds a key, or replaces the one at its frame. The names in the subject must exist, and the
    /// count of numbers must be [`TrackSubject::number_count`].
    ///
    /// # Errors
    /// The other keys of the track have another count of numbers.
    pub fn set_key(&mut self, subject: TrackSubject, frame: f64, numbers: &[f64]) -> Result<(), SceneError> {
        let command = subject.command.to_string();
        self.tracks.set(subject, frame, numbers).map_err(|count| SceneError::KeyNumbers { command, count })
    }

    /// Removes the keys at a frame, or at all frames, of the matching tracks. Returns their count.
    pub fn remove_keys(&mut self, frame: Option<f64>, matches: impl Fn(&TrackSubject) -> bool) -> usize {
        self.tracks.remove(frame, matches)
    }
}
