//! Checks of arguments that ranges of single numbers cannot express.

use superegg_geom::glam::DVec3;
use superegg_scene::{Camera, Light, LightKind, Pattern};

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::table::CHECKER_SIZE;
use crate::parse::parser::Parsed;

/// Rejects the direction 0 0 0.
pub(crate) fn check_direction(direction: DVec3, wanted: &str, parsed: &Parsed) -> Result<(), Fault> {
    if direction.abs().max_element() > 0.0 {
        return Ok(());
    }
    let fault = Fault::new(FaultCode::NoDirection, "the direction 0 0 0 has no length");
    Err(fault.help(format!("give {wanted}")).at(parsed.argument_columns()))
}

/// Rejects a camera whose position is its target, or too far from it.
pub(crate) fn check_camera(camera: &Camera, parsed: &Parsed) -> Result<(), Fault> {
    let to_target = camera.target - camera.position;
    if to_target.is_finite() && to_target.abs().max_element() > 0.0 {
        return Ok(());
    }
    let message = "the camera and its target must be two places, not too far apart";
    Err(Fault::new(FaultCode::NoDirection, message)
        .help("the first three numbers place the camera, the next three what it looks at")
        .at(parsed.argument_columns()))
}

/// Rejects a spot light without an axis and a directional light without a direction.
pub(crate) fn check_light(light: &Light, parsed: &Parsed) -> Result<(), Fault> {
    match light.kind {
        LightKind::Point { .. } => Ok(()),
        LightKind::Sun { direction } => {
            check_direction(direction, "the direction towards the sun, such as 1 3 2", parsed)
        }
        LightKind::Spot { position, target, .. } => {
            let axis = target - position;
            if axis.is_finite() && axis.abs().max_element() > 0.0 {
                return Ok(());
            }
            let fault = Fault::new(
                FaultCode::NoDirection,
                "a spot and its target must be two places, not too far apart",
            );
            Err(fault
                .help("the first three numbers place the light, the next three what it shines at")
                .at(parsed.argument_columns()))
        }
    }
}

/// The distance from a camera to its target; infinite if it overflows.
pub(crate) fn target_distance(camera: &Camera) -> f64 {
    let to_target = camera.target - camera.position;
    let largest = to_target.abs().max_element();
    largest * (to_target / largest).length()
}

/// The pattern of a word and its numbers. The table allows more counts of numbers than each word
/// takes.
pub(crate) fn pattern(word: &str, numbers: &[f64], parsed: &Parsed) -> Result<Pattern, Fault> {
    let color = || DVec3::from_slice(&numbers[..3]);
    match (word, numbers.len()) {
        ("none", 0) => Ok(Pattern::None),
        ("checker" | "noise" | "marble" | "wood", count @ (3 | 4)) => {
            let size = if count == 4 { numbers[3] } else { CHECKER_SIZE };
            if size <= 0.0 {
                let fault = Fault::new(FaultCode::OutOfRange, format!("size of a {word} must be above 0"));
                let help = format!("for example: setPattern {word} 0.1 0.1 0.1 0.25");
                return Err(fault.help(help).at(parsed.word_columns(5)));
            }
            let color = color();
            Ok(match word {
                "checker" => Pattern::Checker { color, size },
                "noise" => Pattern::Noise { color, size },
                "marble" => Pattern::Marble { color, size },
                _ => Pattern::Wood { color, size },
            })
        }
        ("gradient", 3) => Ok(Pattern::Gradient { color: color(), direction: DVec3::Z }),
        ("gradient", 6) => {
            let direction = DVec3::from_slice(&numbers[3..]);
            check_direction(direction, "the direction in which the colour changes, such as 0 0 1", parsed)?;
            Ok(Pattern::Gradient { color: color(), direction })
        }
        _ => {
            let (takes, example) = match word {
                "none" => ("no numbers", ""),
                "gradient" => ("a colour r g b, and perhaps a direction x y z", " 0.1 0.2 0.6 0 0 1"),
                _ => ("a colour r g b, and perhaps a size", " 0.1 0.1 0.1 0.25"),
            };
            let message = format!("'{word}' takes {takes}; here are {} numbers", numbers.len());
            Err(Fault::new(FaultCode::ArgumentCount, message)
                .help(format!("for example: setPattern {word}{example}"))
                .at(parsed.argument_columns()))
        }
    }
}
