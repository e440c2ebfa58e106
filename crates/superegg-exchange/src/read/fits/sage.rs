//! Dictionaries of sage-superquadric 1.0: one, a list, or within another JSON file.

use superegg_geom::glam::{DQuat, DVec3};

use super::fit::{self, Fit};
use super::json::{self, Found};
use crate::read::columns::extra_columns;
use crate::read::error::ReadError;
use crate::read::import::{Content, Import};
use crate::read::options::ReadOptions;
use crate::read::particles::Particles;

/// The keys of a dictionary.
const KEYS: &[&str] = &["a1", "a2", "a3", "eps1", "eps2", "cx", "cy", "cz", "roll", "pitch", "yaw"];
/// The key that tells the format.
pub(crate) const KEY: &str = "eps1";
/// The name of a fit beside other dictionaries, such as the truth that it is compared to.
const FIT: &str = ".fit";

/// Reads all dictionaries of a file; of a file with one named `fit` only that.
///
/// # Errors
/// The file is no JSON, has no such dictionary, or a value is wrong.
pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let value = json::parse(bytes)?;
    let mut found = json::with_keys(&value, KEYS);
    let mut warnings = Vec::new();
    if found.iter().any(|found| found.path == FIT) {
        let others: Vec<&str> =
            found.iter().map(|found| found.path.as_str()).filter(|path| *path != FIT).collect();
        if !others.is_empty() {
            warnings.push(format!("only 'fit' is read, and not: {}", others.join(", ")));
        }
        found.retain(|found| found.path == FIT);
    }
    let mut particles = Particles::default();
    let mut raised = 0;
    for found in &found {
        let whole = fit::push(&mut particles, fit_of(found)?, options);
        let name = if found.path.is_empty() { "dictionary" } else { &found.path };
        raised += usize::from(!whole.map_err(|message| ReadError::part(name, message))?);
    }
    if particles.is_empty() {
        let message = format!("the file has no dictionary with the keys {}", KEYS.join(" "));
        return Err(ReadError::File(message));
    }
    warnings.extend(fit::raised_warning(raised));
    particles.extra = extra_columns(Vec::new(), options)?;
    let reading = "semi-axes a1 a2 a3, n = eps1, e = eps2, \
                   rotation Rx(roll) Ry(pitch) Rz(yaw) from radians";
    Ok(Import { warnings, ..Import::new(Content::Particles(particles), reading) })
}

fn fit_of(found: &Found<'_>) -> Result<Fit, ReadError> {
    let number = |key: &str| json::number(found, key);
    let vector = |[x, y, z]: [&str; 3]| Ok::<_, ReadError>(DVec3::new(number(x)?, number(y)?, number(z)?));
    let angles = vector(["roll", "pitch", "yaw"])?;
    Ok(Fit {
        position: vector(["cx", "cy", "cz"])?,
        radii: vector(["a1", "a2", "a3"])?,
        exponents: [number("eps2")?, number("eps1")?],
        rotation: DQuat::from_rotation_x(angles.x)
            * DQuat::from_rotation_y(angles.y)
            * DQuat::from_rotation_z(angles.z),
    })
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DMat3;

    use super::*;

    const ONE: &str = r#"{"a1": 1, "a2": 2, "a3": 3, "eps1": 0.5, "eps2": 1.5,
        "cx": 4, "cy": 5, "cz": 6, "roll": 0.3, "pitch": 0.5, "yaw": 0.9}"#;

    fn particles(text: &str) -> Particles {
        match read(text.as_bytes(), &ReadOptions::default()).unwrap().content {
            Content::Particles(particles) => particles,
            Content::Script(script) => panic!("{script}"),
        }
    }

    #[test]
    fn one_a_list_and_wrapped_ones_are_read() {
        let one = particles(ONE);
        assert_eq!(one.positions, [DVec3::new(4.0, 5.0, 6.0)]);
        assert_eq!(one.radii, [DVec3::new(1.0, 2.0, 3.0)]);
        assert_eq!(one.exponents, [[1.5, 0.5]]);
        let expected =
            DMat3::from_rotation_x(0.3) * DMat3::from_rotation_y(0.5) * DMat3::from_rotation_z(0.9);
        let found = DMat3::from_quat(one.rotations[0]);
        assert!((found - expected).to_cols_array().iter().all(|d| d.abs() < 1e-15));
        assert_eq!(particles(&format!("[{ONE}, {ONE}]")).len(), 2);
        assert_eq!(particles(&format!("{{\"nodes\": {{\"a\": {{\"params\": {ONE}}}}}}}")), one);
        let text = format!("{{\"true\": {ONE}, \"fit\": {ONE}, \"points\": [[1, 2, 3]]}}");
        let import = read(text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(import.warnings, ["only 'fit' is read, and not: .true"]);
    }

    #[test]
    fn wrong_values_are_named() {
        let message = |text: &str| read(text.as_bytes(), &ReadOptions::default()).unwrap_err().to_string();
        assert!(message("[]").contains("no dictionary with the keys a1"));
        assert_eq!(message(&ONE.replace("0.9", "\"a\"")), "'.yaw': expected a number");
        let list = format!("[{ONE}, {}]", ONE.replace("\"a1\": 1", "\"a1\": -1"));
        assert_eq!(message(&list), "'[1]': a semi-axis of -1 is not above 0; --min-axis X raises small ones");
    }

    /// The file has exact points of the true superquadric.
    #[allow(clippy::print_stderr, reason = "a test that is skipped says so")]
    #[test]
    fn a_real_fit_is_where_its_points_are() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/exchange/fits/sage_fit.json");
        let Ok(text) = std::fs::read_to_string(path) else {
            eprintln!("skipped: {path} is missing");
            return;
        };
        let fit = particles(&text);
        assert_eq!(fit.len(), 1);
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let [e, n] = fit.exponents[0];
        let points = value["points"].as_array().unwrap();
        assert_eq!(points.len(), 500);
        for point in points {
            let point: Vec<f64> = point.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
            let local = fit.rotations[0].inverse() * (DVec3::from_slice(&point) - fit.positions[0]);
            let [x, y, z] = (local / fit.radii[0]).abs().to_array();
            let section = x.powf(2.0 / e) + y.powf(2.0 / e);
            let value = section.powf(e / n) + z.powf(2.0 / n);
            assert!((value - 1.0).abs() < 1e-5, "{value} at {point:?}");
        }
    }
}
