//! What a ray is inside of: transparent shapes, one within another.

use std::rc::Rc;

use superegg_geom::glam::DVec3;
use superegg_scene::Material;
use superegg_trace::InstancePath;

/// The transparent shapes that a ray is in, the last entered first; empty is the open air, of index 1. A clone is cheap.
#[derive(Clone, Debug, Default)]
pub(crate) struct Media(Option<Rc<Layer>>);

#[derive(Debug)]
struct Layer {
    path: Rc<InstancePath>,
    index: f64,
    absorb: DVec3,
    outside: Media,
}

impl Media {
    /// The index of refraction here.
    pub(crate) fn index(&self) -> f64 {
        self.0.as_ref().map_or(1.0, |layer| layer.index)
    }

    /// Whether light fades here at all.
    pub(crate) fn absorbs(&self) -> bool {
        self.0.as_ref().is_some_and(|layer| layer.absorb != DVec3::ZERO)
    }

    /// The share of light that is left after some way, in world units: `exp(-absorb * way)` (Beer and Lambert).
    pub(crate) fn transmittance(&self, way: f64) -> DVec3 {
        // Not 0 times infinity.
        self.0.as_ref().map_or(DVec3::ONE, |layer| (-layer.absorb * way.min(f64::MAX)).exp())
    }

    /// The same on the way between two points.
    pub(crate) fn transmittance_between(&self, from: DVec3, to: DVec3) -> DVec3 {
        if self.absorbs() { self.transmittance((to - from).length()) } else { DVec3::ONE }
    }

    /// Inside of one more shape.
    pub(crate) fn within(&self, path: &Rc<InstancePath>, material: &Material) -> Self {
        let layer = Layer {
            path: Rc::clone(path),
            index: material.index,
            absorb: material.absorb,
            outside: self.clone(),
        };
        Self(Some(Rc::new(layer)))
    }

    /// Outside of a shape, wherever in the row it was entered; what was entered after it stays.
    pub(crate) fn without(&self, path: &InstancePath) -> Self {
        let Some(layer) = &self.0 else { return Self::default() };
        if *layer.path == *path {
            return layer.outside.clone();
        }
        if !self.holds(path) {
            return self.clone();
        }
        Self(Some(Rc::new(Layer {
            path: Rc::clone(&layer.path),
            index: layer.index,
            absorb: layer.absorb,
            outside: layer.outside.without(path),
        })))
    }

    fn holds(&self, path: &InstancePath) -> bool {
        let mut layer = &self.0;
        while let Some(held) = layer {
            if *held.path == *path {
                return true;
            }
            layer = &held.outside.0;
        }
        false
    }

    /// The index on the near side of a surface of a shape with this material, and what a ray is in behind it.
    pub(crate) fn across(&self, path: &Rc<InstancePath>, material: &Material, leaving: bool) -> (f64, Self) {
        if !leaving {
            return (self.index(), self.within(path, material));
        }
        // A shape that was not entered, because the ray began in it.
        let near = if self.holds(path) { self.index() } else { material.index };
        (near, self.without(path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(place: u32) -> Rc<InstancePath> {
        let mut path = InstancePath::default();
        path.push(place);
        Rc::new(path)
    }

    #[test]
    fn shapes_are_left_in_any_order() {
        let (glass, water) =
            (Material { index: 1.5, ..Material::default() }, Material { index: 1.33, ..Material::default() });
        let (a, b) = (path(1), path(2));
        let air = Media::default();
        let (near, in_glass) = air.across(&a, &glass, false);
        assert_eq!((near, in_glass.index()), (1.0, 1.5));
        let (near, in_both) = in_glass.across(&b, &water, false);
        assert_eq!((near, in_both.index()), (1.5, 1.33));
        // Out of the glass while still in the water: nothing bends.
        let (near, in_water) = in_both.across(&a, &glass, true);
        assert_eq!((near, in_water.index()), (1.33, 1.33));
        assert_eq!(in_water.across(&b, &water, true).1.index(), 1.0);
        // A way out of what was never entered.
        let (near, out) = air.across(&a, &glass, true);
        assert_eq!((near, out.index()), (1.5, 1.0));
    }

    #[test]
    fn light_fades_by_the_way() {
        let ink = Material { absorb: DVec3::new(0.0, 1.0, 2.0), ..Material::default() };
        let inside = Media::default().within(&path(0), &ink);
        let left = inside.transmittance(0.5);
        assert!((left - DVec3::new(1.0, (-0.5f64).exp(), (-1f64).exp())).length() < 1e-12);
        assert_eq!(Media::default().transmittance(1e300), DVec3::ONE);
    }
}
