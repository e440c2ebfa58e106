//! Parts of superquadric_parsing: columns `size`, `shape`, `rotation`, `location`, `tapering` and
//! `probability`, in .npz, JSON, or the rows of a .npy file. Its pickles are not read.

use superegg_geom::glam::{DQuat, DVec3};

use super::fit::{self, Fit};
use super::json;
use crate::read::arrays::npz::Npz;
use crate::read::arrays::numpy;
use crate::read::columns::extra_columns;
use crate::read::error::ReadError;
use crate::read::import::{Content, Import};
use crate::read::options::ReadOptions;
use crate::read::particles::Particles;

/// The arrays and keys that tell the format.
pub(crate) const KEYS: [&str; 4] = ["size", "shape", "rotation", "location"];
/// Parts of more than this probability are shown.
const LEAST_PROBABILITY: f64 = 0.5;
/// The numbers of a row: those of a part without and with its tapering.
pub(crate) const ROW_WIDTHS: [usize; 2] = [12, 14];

/// The columns of a file, flat.
#[derive(Default)]
struct Columns {
    size: Vec<f64>,
    shape: Vec<f64>,
    rotation: Vec<f64>,
    location: Vec<f64>,
    tapering: Vec<f64>,
    probability: Vec<f64>,
}

/// The collected parts.
#[derive(Default)]
struct Parts {
    particles: Particles,
    probability: Vec<f64>,
    listed: usize,
    tapered: usize,
    raised: usize,
}

/// Reads an archive of the columns.
///
/// # Errors
/// A column is missing, damaged, or of another length than the others.
pub(crate) fn read_npz(archive: &Npz<'_>, options: &ReadOptions) -> Result<Import, ReadError> {
    let needed = |name: &str| Ok::<_, ReadError>(archive.needed(name)?.numbers(name)?.values);
    let optional = |name: &str| match archive.has(name) {
        true => needed(name),
        false => Ok(Vec::new()),
    };
    let columns = Columns {
        size: needed("size")?,
        shape: needed("shape")?,
        rotation: needed("rotation")?,
        location: needed("location")?,
        tapering: optional("tapering")?,
        probability: optional("probability")?,
    };
    let mut parts = Parts::default();
    parts.add(&columns, "", options)?;
    parts.finish(options)
}

/// Reads JSON: a dictionary of columns, or one for each part, wherever it lies.
///
/// # Errors
/// The file is no JSON, has no such dictionary, or a value is wrong.
pub(crate) fn read_json(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let value = json::parse(bytes)?;
    let found = json::with_keys(&value, &KEYS);
    if found.is_empty() {
        let message = format!("the file has no dictionary with the keys {}", KEYS.join(" "));
        return Err(ReadError::File(message));
    }
    let mut parts = Parts::default();
    for found in &found {
        let numbers = |key: &str| json::numbers(found, key);
        let columns = Columns {
            size: numbers("size")?,
            shape: numbers("shape")?,
            rotation: numbers("rotation")?,
            location: numbers("location")?,
            tapering: numbers("tapering")?,
            probability: numbers("probability")?,
        };
        parts.add(&columns, &found.path, options)?;
    }
    parts.finish(options)
}

/// Reads rows of 12 or 14 numbers: size, shape, rotation, location, and tapering.
///
/// # Errors
/// The file is no .npy file, or its rows have another number of columns.
pub(crate) fn read_npy(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let array = numpy::read(bytes, "array")?.numbers("array")?;
    let Some(&width) = array.shape.last().filter(|width| ROW_WIDTHS.contains(width)) else {
        let message = format!(
            "expected rows of {} or {} numbers, found the shape {}",
            ROW_WIDTHS[0],
            ROW_WIDTHS[1],
            array.shape_text()
        );
        return Err(ReadError::part("array", message));
    };
    let mut columns = Columns::default();
    for row in array.values.chunks_exact(width) {
        columns.size.extend(&row[..3]);
        columns.shape.extend(&row[3..5]);
        columns.rotation.extend(&row[5..9]);
        columns.location.extend(&row[9..12]);
        columns.tapering.extend(&row[12..]);
    }
    let mut parts = Parts::default();
    parts.add(&columns, "", options)?;
    parts.finish(options)
}

impl Parts {
    fn add(&mut self, columns: &Columns, path: &str, options: &ReadOptions) -> Result<(), ReadError> {
        let Columns { size, shape, rotation, location, tapering, probability } = columns;
        let count = size.len() / 3;
        for (name, values, width, is_optional) in [
            ("size", size, 3, false),
            ("shape", shape, 2, false),
            ("rotation", rotation, 4, false),
            ("location", location, 3, false),
            ("tapering", tapering, 2, true),
            ("probability", probability, 1, true),
        ] {
            if values.len() != width * count && !(is_optional && values.is_empty()) {
                let message =
                    format!("expected {width} numbers for each of {count} parts, found {}", values.len());
                let name = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
                return Err(ReadError::part(name, message));
            }
        }
        self.listed += count;
        for index in 0..count {
            let probability = probability.get(index).copied();
            // A probability that is no number shows nothing.
            if probability.is_some_and(|value| value.is_nan() || value <= LEAST_PROBABILITY) {
                continue;
            }
            let [w, x, y, z] = [0, 1, 2, 3].map(|at| rotation[4 * index + at]);
            let fit = Fit {
                position: DVec3::from_slice(&location[3 * index..]),
                radii: DVec3::from_slice(&size[3 * index..]),
                exponents: [shape[2 * index + 1], shape[2 * index]],
                // The file's turns the world into the body.
                rotation: DQuat::from_xyzw(-x, -y, -z, w),
            };
            let whole = fit::push(&mut self.particles, fit, options)
                .map_err(|message| ReadError::part(format!("{path}[{index}]"), message))?;
            self.raised += usize::from(!whole);
            let is_tapered = (0..2).any(|at| tapering.get(2 * index + at).is_some_and(|k| *k != 0.0));
            self.tapered += usize::from(is_tapered);
            self.probability.extend(probability);
        }
        Ok(())
    }

    fn finish(self, options: &ReadOptions) -> Result<Import, ReadError> {
        let Self { mut particles, probability, listed, tapered, raised } = self;
        let mut warnings = Vec::new();
        if tapered > 0 {
            warnings.push(format!("{tapered} parts are tapered, which is left out"));
        }
        warnings.extend(fit::raised_warning(raised));
        let is_whole = !probability.is_empty() && probability.len() == particles.len();
        let columns = is_whole.then(|| ("probability".to_owned(), probability));
        particles.extra = extra_columns(columns.into_iter().collect(), options)?;
        let reading = format!(
            "superquadric_parsing: {} of {listed} parts; semi-axes from size, n = shape[0], \
             e = shape[1], rotation w x y z from world to body",
            particles.len()
        );
        Ok(Import { warnings, ..Import::new(Content::Particles(particles), reading) })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rawzip::CompressionMethod;

    use super::*;
    use crate::read::arrays::npz::tests::npz;
    use crate::read::arrays::numpy::tests::{npy, npy_f64};

    fn particles(import: Import) -> Particles {
        match import.content {
            Content::Particles(particles) => particles,
            Content::Script(script) => panic!("{script}"),
        }
    }

    fn row() -> impl Strategy<Value = Vec<f64>> {
        let size = prop::array::uniform3(0.01..2.0_f64);
        let shape = prop::array::uniform2(0.1..2.0_f64);
        let rotation = prop::array::uniform4(-1.0..1.0_f64)
            .prop_filter("long", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01);
        let location = prop::array::uniform3(-9.0..9.0_f64);
        let tapering = prop::array::uniform2(-0.5..0.5_f64);
        (size, shape, rotation, location, tapering).prop_map(|(size, shape, rotation, location, tapering)| {
            [&size[..], &shape, &rotation, &location, &tapering].concat()
        })
    }

    fn check(found: &Particles, rows: &[Vec<f64>]) -> Result<(), TestCaseError> {
        prop_assert_eq!(found.len(), rows.len());
        for (index, row) in rows.iter().enumerate() {
            prop_assert_eq!(found.radii[index].to_array(), [row[0], row[1], row[2]]);
            prop_assert_eq!(found.exponents[index], [row[4], row[3]]);
            prop_assert_eq!(found.positions[index].to_array(), [row[9], row[10], row[11]]);
            let file = DQuat::from_xyzw(row[6], row[7], row[8], row[5]).normalize();
            // p = R (x - t): a point of the world, seen by the body.
            let x = DVec3::new(0.3, -2.0, 1.1);
            let body = found.rotations[index].inverse() * (x - found.positions[index]);
            prop_assert!((body - file * (x - found.positions[index])).length() < 1e-12);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn parts_are_read_from_every_file(rows in prop::collection::vec(row(), 1..8)) {
            let options = ReadOptions::default();
            let count = rows.len();
            let flat: Vec<f64> = rows.concat();
            check(&particles(read_npy(&npy_f64(&format!("({count}, 14)"), &flat), &options).unwrap()), &rows)?;
            let column = |from: usize, to: usize| rows.iter().flat_map(|row| row[from..to].to_vec()).collect::<Vec<f64>>();
            let bytes = npz(&[
                ("size", npy_f64(&format!("(1, {})", 3 * count), &column(0, 3))),
                ("shape", npy_f64(&format!("({count}, 2)"), &column(3, 5))),
                ("rotation", npy_f64(&format!("({count}, 4)"), &column(5, 9))),
                ("location", npy_f64(&format!("({count}, 3)"), &column(9, 12))),
                ("tapering", npy_f64(&format!("({count}, 2)"), &column(12, 14))),
            ], CompressionMethod::DEFLATE);
            let import = read_npz(&Npz::open(&bytes).unwrap(), &options).unwrap();
            let tapered = rows.iter().filter(|row| row[12] != 0.0 || row[13] != 0.0).count();
            prop_assert_eq!(import.warnings.len(), usize::from(tapered > 0));
            check(&particles(import), &rows)?;
            let dictionary = |row: &Vec<f64>| serde_json::json!({"size": row[..3], "shape": row[3..5], "rotation": row[5..9], "location": row[9..12]});
            let list = serde_json::to_vec(&rows.iter().map(dictionary).collect::<Vec<_>>()).unwrap();
            check(&particles(read_json(&list, &options).unwrap()), &rows)?;
            let columns = serde_json::json!({"parts": {"size": column(0, 3), "shape": column(3, 5), "rotation": column(5, 9), "location": column(9, 12)}});
            check(&particles(read_json(&serde_json::to_vec(&columns).unwrap(), &options).unwrap()), &rows)?;
        }
    }

    #[test]
    fn unlikely_parts_are_left_out_and_wrong_ones_named() {
        let part = |probability: &str, w: &str| {
            format!(
                r#"{{"size": [1, 2, 3], "shape": [0.2, 0.4], "rotation": [{w}, 0, 0, 0], "location": [0, 0, 0], "probability": {probability}}}"#
            )
        };
        let text = format!("[{}, {}]", part("0.9", "2"), part("0.1", "0"));
        let options = ReadOptions { all_extra: true, ..ReadOptions::default() };
        let import = read_json(text.as_bytes(), &options).unwrap();
        assert!(import.reading.contains("1 of 2 parts"));
        let found = particles(import);
        assert_eq!(found.extra, [("probability".to_owned(), vec![0.9])]);
        assert_eq!(found.rotations, [DQuat::IDENTITY]);
        let message = |text: &str| read_json(text.as_bytes(), &options).unwrap_err().to_string();
        assert_eq!(
            message(&format!("[{}]", part("0.9", "0"))),
            "'[0][0]': the quaternion 0 -0 -0 -0 has no direction"
        );
        assert!(message(&part("0.9", "1").replace("0.2, ", "")).contains("'shape': expected 2 numbers"));
        let pickle = npy("'|O'", false, "()", &[0; 64]);
        assert!(read_npy(&pickle, &options).unwrap_err().to_string().contains("pickled"));
        assert!(read_npy(&npy_f64("(2, 13)", &[0.0; 26]), &options).is_err());
    }
}
