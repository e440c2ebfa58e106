//! SuperDec's archives (.npz): arrays over entries and their parts.

use superegg_geom::glam::DVec3;

use super::fit::{self, Fit};
use crate::read::arrays::npz::Npz;
use crate::read::arrays::number_array::NumberArray;
use crate::read::arrays::numpy::NumpyArray;
use crate::read::columns::extra_columns;
use crate::read::error::ReadError;
use crate::read::import::{Content, Import};
use crate::read::options::ReadOptions;
use crate::read::particles::Particles;

/// The array that no other format has.
pub(crate) const KEY: &str = "exponents";
/// Parts that exist with more than this are shown.
const LEAST_EXISTENCE: f64 = 0.5;
/// The most names of entries in a message.
const MOST_NAMES: usize = 5;

/// Reads an archive. Entries lie in one space; the column `entry` numbers them, `exist` is the
/// network's certainty.
///
/// # Errors
/// An array is missing, damaged, or has another number of parts than `scale`.
pub(crate) fn read(archive: &Npz<'_>, options: &ReadOptions) -> Result<Import, ReadError> {
    let scale = archive.needed("scale")?.numbers("scale")?;
    let (entries, parts) = match scale.shape[..] {
        [entries, parts, 3] => (entries, parts),
        [parts, 3] => (1, parts),
        _ => {
            let message = format!("expected the shape (entries, parts, 3), found {}", scale.shape_text());
            return Err(ReadError::part("scale", message));
        }
    };
    let count = entries * parts;
    let array = |name: &str, width: usize| {
        let array = archive.needed(name)?.numbers(name)?;
        sized(array, name, count, width)
    };
    let rotation = array("rotation", 9)?;
    let translation = array("translation", 3)?;
    let exponents = array("exponents", 2)?;
    let mut warnings = Vec::new();
    let exist = if archive.has("exist") {
        array("exist", 1)?
    } else {
        warnings.push("the archive has no 'exist': all parts are shown".to_owned());
        vec![1.0; count]
    };
    let mut particles = Particles::default();
    let (mut entry_column, mut exist_column) = (Vec::new(), Vec::new());
    let mut raised = 0;
    // Parts that do not exist may hold anything.
    for index in (0..count).filter(|&index| exist[index] > LEAST_EXISTENCE) {
        let vector = |values: &[f64]| DVec3::from_slice(&values[3 * index..]);
        let error = |message| {
            let position = format!("[{}, {}]", index / parts, index % parts);
            ReadError::part(position, message)
        };
        let mut rows = [0.0; 9];
        rows.copy_from_slice(&rotation[9 * index..9 * index + 9]);
        let fit = Fit {
            position: vector(&translation),
            radii: vector(&scale.values),
            exponents: [exponents[2 * index + 1], exponents[2 * index]],
            rotation: fit::rotation_of_rows(rows).map_err(error)?,
        };
        raised += usize::from(!fit::push(&mut particles, fit, options).map_err(error)?);
        entry_column.push((index / parts) as f64);
        exist_column.push(exist[index]);
    }
    if entries > 1 {
        warnings.push(entries_warning(archive, entries));
    }
    warnings.extend(fit::raised_warning(raised));
    let columns = vec![("entry".to_owned(), entry_column), ("exist".to_owned(), exist_column)];
    particles.extra = extra_columns(columns, options)?;
    let reading = format!(
        "SuperDec: {} of {count} parts exist; semi-axes from scale, n = exponents[0], \
         e = exponents[1], rotation from body to world",
        particles.len()
    );
    Ok(Import { warnings, ..Import::new(Content::Particles(particles), reading) })
}

/// The numbers of an array of `width` numbers for each part.
fn sized(array: NumberArray, name: &str, count: usize, width: usize) -> Result<Vec<f64>, ReadError> {
    if Some(array.values.len()) == count.checked_mul(width) {
        return Ok(array.values);
    }
    let message = format!(
        "expected {width} numbers for each of the {count} parts in 'scale', found the shape {}",
        array.shape_text()
    );
    Err(ReadError::part(name, message))
}

fn entries_warning(archive: &Npz<'_>, entries: usize) -> String {
    // Names that are pickled cannot be read, and nothing else needs them.
    let names = match archive.array("names") {
        Ok(Some(NumpyArray::Text(names))) if !names.is_empty() => {
            let more = if names.len() > MOST_NAMES { ", ..." } else { "" };
            format!(" ({}{more})", names[..names.len().min(MOST_NAMES)].join(", "))
        }
        _ => String::new(),
    };
    format!("the {entries} entries{names} lie in one space; the column 'entry' numbers them")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rawzip::CompressionMethod;
    use superegg_geom::glam::{DMat3, DQuat};

    use super::*;
    use crate::read::arrays::npz::tests::npz;
    use crate::read::arrays::numpy::tests::{npy, npy_f64};

    fn f32_array(shape: &str, values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        npy("'<f4'", false, shape, &data)
    }

    fn names(names: &[&str]) -> Vec<u8> {
        let unit = |name: &&str| {
            format!("{name:\0<4}")
                .chars()
                .take(4)
                .flat_map(|c| u32::from(c).to_le_bytes())
                .collect::<Vec<u8>>()
        };
        npy("'<U4'", false, &format!("({},)", names.len()), &names.iter().flat_map(unit).collect::<Vec<u8>>())
    }

    fn read_bytes(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
        read(&Npz::open(bytes)?, options)
    }

    fn particles(import: Import) -> Particles {
        match import.content {
            Content::Particles(particles) => particles,
            Content::Script(script) => panic!("{script}"),
        }
    }

    proptest! {
        #[test]
        fn parts_that_exist_are_read(seed in prop::collection::vec((0.0..1.0_f64, prop::array::uniform3(-4.0..4.0_f64), prop::array::uniform3(0.01..2.0_f64), prop::array::uniform2(0.1..2.0_f64)), 6), in_f32 in any::<bool>()) {
            let array = if in_f32 { f32_array } else { npy_f64 };
            let round = |x: f64| if in_f32 { f64::from(x as f32) } else { x };
            let turns: Vec<DQuat> = seed.iter().map(|(_, t, _, _)| DQuat::from_rotation_z(t[0]) * DQuat::from_rotation_y(t[1])).collect();
            let mut translation: Vec<f64> = seed.iter().flat_map(|(_, t, _, _)| *t).collect();
            let scale: Vec<f64> = seed.iter().flat_map(|(_, _, s, _)| *s).collect();
            let exponents: Vec<f64> = seed.iter().flat_map(|(_, _, _, e)| *e).collect();
            let rotation: Vec<f64> = turns.iter().flat_map(|q| DMat3::from_quat(*q).transpose().to_cols_array()).collect();
            let exist: Vec<f64> = seed.iter().map(|(e, _, _, _)| *e).collect();
            let shown: Vec<usize> = (0..6).filter(|&i| round(exist[i]) > 0.5).collect();
            for i in (0..6).filter(|i| !shown.contains(i)) {
                translation[3 * i] = f64::NAN;
            }
            let bytes = npz(&[
                ("names", names(&["a", "b"])),
                ("scale", array("(2, 3, 3)", &scale)),
                ("rotation", array("(2, 3, 3, 3)", &rotation)),
                ("translation", array("(2, 3, 3)", &translation)),
                ("exponents", array("(2, 3, 2)", &exponents)),
                ("exist", array("(2, 3, 1)", &exist)),
            ], CompressionMethod::DEFLATE);
            let options = ReadOptions { all_extra: true, ..ReadOptions::default() };
            let import = read_bytes(&bytes, &options).unwrap();
            prop_assert_eq!(&import.warnings, &["the 2 entries (a, b) lie in one space; the column 'entry' numbers them"]);
            let found = particles(import);
            prop_assert_eq!(found.len(), shown.len());
            for (at, &i) in shown.iter().enumerate() {
                prop_assert_eq!(found.radii[at].to_array(), seed[i].2.map(round));
                prop_assert_eq!(found.positions[at].to_array(), seed[i].1.map(round));
                prop_assert_eq!(found.exponents[at], [round(seed[i].3[1]), round(seed[i].3[0])]);
                prop_assert!(found.rotations[at].dot(turns[i]).abs() > 1.0 - 1e-12);
                prop_assert_eq!(found.extra[0].1[at], (i / 3) as f64);
            }
        }
    }

    #[test]
    fn arrays_that_do_not_fit_are_errors() {
        let whole = |exponents: Vec<u8>, rotation: Vec<u8>| {
            npz(
                &[
                    ("scale", npy_f64("(1, 3)", &[1.0; 3])),
                    ("translation", npy_f64("(1, 3)", &[0.0; 3])),
                    ("exponents", exponents),
                    ("rotation", rotation),
                ],
                CompressionMethod::STORE,
            )
        };
        let unit = npy_f64("(1, 3, 3)", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let message = |bytes: &[u8]| read_bytes(bytes, &ReadOptions::default()).unwrap_err().to_string();
        let good = npy_f64("(1, 2)", &[0.5, 1.5]);
        let import = read_bytes(&whole(good.clone(), unit.clone()), &ReadOptions::default()).unwrap();
        assert_eq!(import.warnings, ["the archive has no 'exist': all parts are shown"]);
        assert_eq!(particles(import).exponents, [[1.5, 0.5]]);
        assert!(
            message(&whole(npy_f64("(1, 3)", &[0.5; 3]), unit.clone())).contains("'exponents': expected 2")
        );
        assert!(
            message(&whole(good.clone(), npy_f64("(1, 3, 3)", &[0.5; 9])))
                .starts_with("'[0, 0]': the matrix")
        );
        assert!(message(&whole(npy("'|O'", false, "(1, 2)", &[0; 64]), unit)).contains("pickled"));
        assert!(message(&npz(&[("exponents", good)], CompressionMethod::STORE)).contains("'scale'"));
    }
}
