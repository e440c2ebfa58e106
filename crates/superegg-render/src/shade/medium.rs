//! The nested transparent shapes that contain a ray.

use std::rc::Rc;

use superegg_geom::glam::DVec3;
use superegg_scene::Material;
use superegg_trace::InstancePath;

/// The transparent shapes that contain a ray, the last entered first. Empty means air, with index
/// of refraction 1. A clone is cheap.
#[derive(Clone, Debug, Default)]
pub(crate) struct Media(Option<Rc<Layer>>);

/// One shape and the media outside it.
#[derive(Debug)]
struct Layer {
    path: Rc<InstancePath>,
    index: f64,
    absorb: DVec3,
    outside: Media,
}

impl Media {
    /// The current index of refraction.
    pub(crate) fn index(&self) -> f64 {
        self.0.as_ref().map_or(1.0, |layer| layer.index)
    }

    /// Whether no shape contains the ray.
    pub(crate) fn is_air(&self) -> bool {
        self.0.is_none()
    }

    /// Whether the current medium absorbs light.
    pub(crate) fn absorbs(&self) -> bool {
        self.0.as_ref().is_some_and(|layer| layer.absorb != DVec3::ZERO)
    }

    /// The transmittance over a distance in world units, by the Beer-Lambert law:
    /// `exp(-absorb * distance)`.
    pub(crate) fn transmittance(&self, distance: f64) -> DVec3 {
        // Avoids 0 times infinity.
        self.0.as_ref().map_or(DVec3::ONE, |layer| (-layer.absorb * distance.min(f64::MAX)).exp())
    }

    /// The transmittance between two points.
    pub(crate) fn transmittance_between(&self, from: DVec3, to: DVec3) -> DVec3 {
        if self.absorbs() { self.transmittance((to - from).length()) } else { DVec3::ONE }
    }

    /// The media after a ray enters a shape.
    pub(crate) fn entering(&self, path: &Rc<InstancePath>, material: &Material) -> Self {
        let layer = Layer {
            path: Rc::clone(path),
            index: material.index,
            absorb: material.absorb,
            outside: self.clone(),
        };
        Self(Some(Rc::new(layer)))
    }

    /// The media after a ray leaves a shape. Shapes that it entered later remain.
    pub(crate) fn leaving(&self, path: &InstancePath) -> Self {
        let Some(layer) = &self.0 else { return Self::default() };
        if *layer.path == *path {
            return layer.outside.clone();
        }
        if !self.contains(path) {
            return self.clone();
        }
        Self(Some(Rc::new(Layer {
            path: Rc::clone(&layer.path),
            index: layer.index,
            absorb: layer.absorb,
            outside: layer.outside.leaving(path),
        })))
    }

    fn contains(&self, path: &InstancePath) -> bool {
        let mut layer = &self.0;
        while let Some(held) = layer {
            if *held.path == *path {
                return true;
            }
            layer = &held.outside.0;
        }
        false
    }

    /// The index of refraction before a surface of a shape with this material, and the media behind
    /// it.
    pub(crate) fn across(&self, path: &Rc<InstancePath>, material: &Material, leaving: bool) -> (f64, Self) {
        if !leaving {
            return (self.index(), self.entering(path, material));
        }
        // A ray that started inside the shape never entered it.
        let near = if self.contains(path) { self.index() } else { material.index };
        (near, self.leaving(path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(child: u32) -> Rc<InstancePath> {
        let mut path = InstancePath::default();
        path.push(child);
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
        // Leaving the glass inside the water does not refract.
        let (near, in_water) = in_both.across(&a, &glass, true);
        assert_eq!((near, in_water.index()), (1.33, 1.33));
        assert_eq!(in_water.across(&b, &water, true).1.index(), 1.0);
        // Leaving a shape that was never entered.
        let (near, out) = air.across(&a, &glass, true);
        assert_eq!((near, out.index()), (1.5, 1.0));
    }

    #[test]
    fn absorption_grows_with_distance() {
        let ink = Material { absorb: DVec3::new(0.0, 1.0, 2.0), ..Material::default() };
        let inside = Media::default().entering(&path(0), &ink);
        let transmittance = inside.transmittance(0.5);
        assert!((transmittance - DVec3::new(1.0, (-0.5f64).exp(), (-1f64).exp())).length() < 1e-12);
        assert_eq!(Media::default().transmittance(1e300), DVec3::ONE);
    }
}
