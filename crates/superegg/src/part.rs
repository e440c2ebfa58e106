//! A part of a model: a shape or an object, its surface and its transform.

use superegg_geom::glam::{DAffine3, DQuat, DVec3};
use superegg_geom::{Superquadric, TransformStep};
use superegg_scene::Material;

/// The shape of a part.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Content {
    Shape(Box<(Superquadric, Material)>),
    Object(String),
}

/// A superquadric with its surface, or an instance of an object, and the steps that move it. [`crate::Model::add`] puts it into a
/// model.
///
/// Steps act in the order in which they are written: `.scale(..).rotate(..).translate(..)` scales first.
///
/// ```
/// use superegg::prelude::*;
/// let cushion = Superquadric::new(DVec3::new(1.0, 1.0, 0.4), Exponents::new(0.3, 1.0)?)?;
/// let part = Part::new(cushion).named("cushion").color([0.8, 0.2, 0.1]).rotate([0.0, 0.0, 1.0], 30.0).translate([0.0, 0.0, 0.4]);
/// let mut model = Model::new();
/// model.add(part)?;
/// assert_eq!(model.compile().instance_count().to_string(), "1");
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a part shows once it is added to a model"]
pub struct Part {
    pub(crate) content: Content,
    pub(crate) name: Option<String>,
    pub(crate) steps: Vec<TransformStep>,
}

impl Part {
    /// A superquadric at the origin with the surface of a new primitive.
    pub fn new(shape: Superquadric) -> Self {
        Self {
            content: Content::Shape(Box::new((shape, Material::default()))),
            name: None,
            steps: Vec::new(),
        }
    }

    /// An instance of the object or primitive of this name; the object may be the one that it is added to, which makes a fractal.
    pub fn instance_of(name: impl Into<String>) -> Self {
        Self { content: Content::Object(name.into()), name: None, steps: Vec::new() }
    }

    /// Sets the name: of the primitive for a shape, of the child for an instance. Default: the first free one of `shape1`, `shape2`, ...
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// Sets the surface of a shape. An instance keeps the surfaces of what it shows.
    pub fn material(mut self, material: Material) -> Self {
        if let Content::Shape(shape) = &mut self.content {
            shape.1 = material;
        }
        self
    }

    /// Sets the base colour of a shape: linear, each channel in [0, 1].
    pub fn color(self, color: impl Into<DVec3>) -> Self {
        let color = color.into();
        self.with_material(|material| material.color = color)
    }

    /// Sets the share of light that a shape reflects as a mirror, in [0, 1].
    pub fn reflected(self, share: f64) -> Self {
        self.with_material(|material| material.reflected = Some(share))
    }

    /// Sets the share of light that a shape transmits, in [0, 1], and its index of refraction.
    pub fn refracted(self, share: f64, index_of_refraction: f64) -> Self {
        self.with_material(|material| {
            material.refracted = Some(share);
            material.index = index_of_refraction;
        })
    }

    fn with_material(mut self, change: impl FnOnce(&mut Material)) -> Self {
        if let Content::Shape(shape) = &mut self.content {
            change(&mut shape.1);
        }
        self
    }

    /// Appends a step.
    pub fn step(mut self, step: TransformStep) -> Self {
        self.steps.push(step);
        self
    }

    /// Moves the part.
    pub fn translate(self, by: impl Into<DVec3>) -> Self {
        self.step(TransformStep::Translate(by.into()))
    }

    /// Turns the part right-handed about an axis through the origin, by an angle in degrees.
    pub fn rotate(self, axis: impl Into<DVec3>, angle_deg: f64) -> Self {
        self.step(TransformStep::Rotate { axis: axis.into(), angle_deg })
    }

    /// Rotates the part by a quaternion, which need not be of unit length; zero is an error.
    pub fn orient(self, quaternion: DQuat) -> Self {
        self.step(TransformStep::Orient(quaternion))
    }

    /// Transforms the part by an affine map, which must be invertible.
    pub fn matrix(self, map: DAffine3) -> Self {
        self.step(TransformStep::Affine(Box::new(map)))
    }

    /// Scales the part along x, y and z. Negative factors mirror it.
    pub fn scale(self, factors: impl Into<DVec3>) -> Self {
        self.step(TransformStep::Scale(factors.into()))
    }
}
