//! Shadow rays of a group straight through convex shapes that transmit light, with their chords in f32.
//!
//! The light is that of [`super::shadow_batch::add_transmitted`], which traces through the scene and takes all other rays.

use superegg_geom::glam::DVec3;
use superegg_scene::{Material, Pattern};
use superegg_trace::shaft::{Chord, Chords, Occluder, ShaftRays};

use crate::shade::context::RenderContext;
use crate::shade::shadow_batch::passed_surface;

/// The light of a shadow ray that arrives, as far as chords tell it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Passage {
    /// The part of the light that passes all shapes.
    Passed(DVec3),
    /// It is to be traced through the scene.
    Unknown,
}

/// A passage so far, and the interval of t from the first entry to the last exit.
type Passing = (Passage, [f64; 2]);

/// The passages of the rays of one group after the other.
#[derive(Default)]
pub(crate) struct ClearShadows {
    passages: Vec<Passing>,
    chords: Chords,
}

impl ClearShadows {
    /// Finds what passes the shapes, for rays up to t = `end` that start in air outside of all of them. `false` where light
    /// through one of the shapes is not that simple.
    pub(crate) fn find(
        &mut self,
        context: &RenderContext<'_>,
        shapes: &[Occluder],
        end: f64,
        rays: &ShaftRays,
    ) -> bool {
        let materials: Option<Vec<_>> = shapes.iter().map(|shape| plain_material(context, shape)).collect();
        let surfaces = 2 * shapes.len();
        let Some(materials) = materials.filter(|_| surfaces <= context.picture.bounces as usize) else {
            return false;
        };
        self.passages.clear();
        self.passages.resize(rays.len(), (Passage::Passed(DVec3::ONE), [f64::INFINITY, f64::NEG_INFINITY]));
        let Self { passages, chords } = self;
        for (shape, material) in shapes.iter().zip(materials) {
            shape.find_chords(end, rays, chords);
            for &ray in &chords.unresolved {
                passages[ray].0 = Passage::Unknown;
            }
            for chord in &chords.found {
                let length = rays.direction(chord.ray).length();
                pass(&mut passages[chord.ray], material, chord, length);
            }
        }
        true
    }

    /// The passage of a ray.
    pub(crate) fn of(&self, ray: usize) -> Passage {
        self.passages[ray].0
    }
}

/// Dims a passage by a chord. `length` is that of the ray's direction.
fn pass((passage, passed): &mut Passing, material: &Material, chord: &Chord, length: f64) {
    let Passage::Passed(part) = passage else { return };
    let [entry, exit] = chord.t;
    // Shapes within or across one another change each other's refraction.
    if entry <= passed[1] && exit >= passed[0] {
        *passage = Passage::Unknown;
        return;
    }
    *passed = [passed[0].min(entry), passed[1].max(exit)];
    let way = (exit - entry) * length;
    *part *= (-material.absorb * way).exp();
    for cos in chord.cos {
        *part *= passed_surface(material, material.color, cos, material.index);
    }
}

/// The material of a convex shape of one colour.
fn plain_material<'a>(context: &RenderContext<'a>, shape: &Occluder) -> Option<&'a Material> {
    let material = context.scene.material_of(&context.scene.primitive(shape.primitive));
    let is_plain = shape.is_convex()
        && material.pattern == Pattern::None
        && context.paths.textures.get(shape.primitive).is_none();
    is_plain.then_some(material)
}
