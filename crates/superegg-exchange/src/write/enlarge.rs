//! The factor by which a scene is written larger for a program that has lengths of its own.

use superegg_geom::glam::DVec3;
use superegg_scene::Scene;

use super::flatten::{Instance, Instances, flatten};

/// POV-Ray 3.7 forgets what is nearer to a shadow ray's start than a thousandth of a unit, and hits nearer than some
/// hundred-thousandths (`findings/povray_small_scenes.sh`). Shapes of this size are not affected.
const LARGE_ENOUGH: f64 = 0.01;
/// The size that small shapes are given.
const AIM: f64 = 0.1;
/// A scene is not made larger than this; POV-Ray forgets what is 1e7 away.
const FARTHEST: f64 = 1e5;

/// The power of ten by which the lengths of a scene are multiplied in a POV-Ray file: 1 unless half of the instances below
/// `root` have a largest semi-axis below 0.01 units.
///
/// ```
/// use superegg_exchange::write::enlarge::enlargement;
/// use superegg_lang::load_text;
///
/// let (grains, _) = load_text("grains.scn", "primitive grain\ncoeff 1e-4 1e-4 2e-4\nobject all\naddPrimitive grain");
/// assert_eq!(enlargement(grains.scene(), "all", 1), 1000.0);
/// ```
pub fn enlargement(scene: &Scene, root: &str, depth: u32) -> f64 {
    // A scene that cannot be listed is refused by its writer.
    let Ok(instances) = flatten(scene, root, depth) else { return 1.0 };
    let mut sizes: Vec<f64> = instances.list.iter().map(|instance| size_of(&instances, instance)).collect();
    let middle = sizes.len() / 2;
    let (_, &mut median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    if !(median > 0.0 && median < LARGE_ENOUGH) {
        return 1.0;
    }
    let reach_of =
        |instance: &Instance| instance.map.translation.abs().max_element() + size_of(&instances, instance);
    let camera = scene.camera.position.abs().max_element();
    let reach = instances.list.iter().map(reach_of).fold(camera, f64::max);
    let most = (FARTHEST / reach).log10().floor();
    10f64.powf((AIM / median).log10().round().min(most).max(0.0))
}

/// The largest semi-axis of an instance.
fn size_of(instances: &Instances, instance: &Instance) -> f64 {
    let radii = instances.part(instance).shape.radii();
    let axes = instance.map.matrix3;
    let lengths = DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
    (lengths * radii).max_element()
}

#[cfg(test)]
mod tests {
    use superegg_lang::load_text;

    use super::*;

    fn factor(text: &str) -> f64 {
        let (session, diagnostics) = load_text("grains.scn", text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        enlargement(session.scene(), "all", 3)
    }

    #[test]
    fn small_shapes_are_enlarged_as_far_as_the_scene_allows() {
        let grains = |radius: &str, rest: &str| {
            format!(
                "primitive grain\ncoeff {radius} {radius} {radius}\ncamera 0 0 0.01 0 0 0 40\nobject all\n\
                 addPrimitive grain a\naddPrimitive grain b\n{rest}"
            )
        };
        assert_eq!(factor(&grains("1", "")), 1.0);
        assert_eq!(factor(&grains("0.01", "")), 1.0);
        assert_eq!(factor(&grains("1e-4", "")), 1e3);
        assert_eq!(factor(&grains("1e-9", "")), 1e7);
        // A large shape among small ones does not hide them, and bounds the factor.
        let wall = "primitive wall\ncoeff 5 5 5\nobject all\naddPrimitive wall";
        assert_eq!(factor(&grains("1e-4", wall)), 1e3);
        assert_eq!(factor(&grains("1e-9", wall)), 1e4);
        assert_eq!(factor(&grains("1e-4", "setCursor b\ntranslate 1e9 0 0")), 1.0);
    }
}
