//! Vectors of eleven numbers for each superquadric: EMS and Marching-Primitives, and robotology's
//! superquadric-lib, in .mat, .npy and text files.

use superegg_geom::glam::{DQuat, DVec3};

use super::fit::{self, Fit};
use crate::read::arrays::matlab::{self, Value, Variable};
use crate::read::arrays::npz;
use crate::read::arrays::number_array::NumberArray;
use crate::read::arrays::numpy;
use crate::read::columns::extra_columns;
use crate::read::error::ReadError;
use crate::read::format::Format;
use crate::read::import::{Content, Import};
use crate::read::options::ReadOptions;
use crate::read::particles::Particles;

/// The numbers of a vector.
const WIDTH: usize = 11;
/// The name that Marching-Primitives gives its result.
const USUAL_NAME: &str = "x";

/// The order and meaning of the eleven numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// e1 e2 a1 a2 a3, Euler angles Z Y X, centre.
    Ems,
    /// a1 a2 a3 e1 e2, centre, Euler angles Z Y Z.
    SuperquadricLib,
}

impl Layout {
    fn fit(self, v: &[f64]) -> Fit {
        let at = |first: usize| DVec3::new(v[first], v[first + 1], v[first + 2]);
        let turn = |[a, b, c]: [DVec3; 3], angles: DVec3| {
            let [x, y, z] = angles.to_array();
            DQuat::from_axis_angle(a, x) * DQuat::from_axis_angle(b, y) * DQuat::from_axis_angle(c, z)
        };
        match self {
            Self::Ems => Fit {
                position: at(8),
                radii: at(2),
                exponents: [v[1], v[0]],
                rotation: turn([DVec3::Z, DVec3::Y, DVec3::X], at(5)),
            },
            Self::SuperquadricLib => Fit {
                position: at(5),
                radii: at(0),
                exponents: [v[4], v[3]],
                rotation: turn([DVec3::Z, DVec3::Y, DVec3::Z], at(8)),
            },
        }
    }

    fn reading(self) -> &'static str {
        match self {
            Self::Ems => {
                "eleven numbers a shape, as EMS writes them: n = e1, e = e2, semi-axes a1 a2 a3, \
                 rotation Rz Ry Rx from radians, centre"
            }
            Self::SuperquadricLib => {
                "eleven numbers a shape, as superquadric-lib writes them: semi-axes a1 a2 a3, \
                 n = e1, e = e2, centre, rotation Rz Ry Rz from radians"
            }
        }
    }
}

/// The formats of a file with these first bytes that holds eleven numbers a shape; several if they
/// cannot be told apart.
pub(crate) fn recognize(head: &[u8]) -> Vec<Format> {
    if head.starts_with(matlab::MAGIC) {
        return vec![Format::Ems];
    }
    if head.starts_with(numpy::MAGIC) {
        return match numpy::shape_of(head).as_deref() {
            // Eleven points, or three shapes in columns.
            Some([WIDTH, 3]) => vec![Format::Ems, Format::NpyPoints],
            Some([WIDTH] | [WIDTH, _] | [_, WIDTH]) => vec![Format::Ems],
            _ => Vec::new(),
        };
    }
    let Ok(text) = std::str::from_utf8(head.get(..head.len().min(4096)).unwrap_or_default()) else {
        return Vec::new();
    };
    if names_columns(text) {
        return Vec::new();
    }
    // The last line may be cut off.
    let whole =
        if head.len() > text.len() { text.rsplit_once('\n').map_or("", |(whole, _)| whole) } else { text };
    match rows_of_text(whole) {
        Ok(rows) if !rows.is_empty() => vec![Format::Ems, Format::SuperquadricLib],
        _ => Vec::new(),
    }
}

/// Whether the text begins with a comment that names a table's columns: one word for each of eleven.
fn names_columns(text: &str) -> bool {
    let first = text.trim_start().lines().next().and_then(|line| line.strip_prefix('#'));
    let is_name = |word: &str| word.parse::<f64>().is_err();
    first.is_some_and(|names| {
        let words = names.split([' ', '\t', ',']).filter(|word| !word.is_empty());
        words.clone().count() == WIDTH && words.clone().all(is_name)
    })
}

/// Reads vectors of EMS.
pub(crate) fn read_ems(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    read(bytes, Layout::Ems, options)
}

/// Reads vectors of superquadric-lib.
pub(crate) fn read_superquadric_lib(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    read(bytes, Layout::SuperquadricLib, options)
}

fn read(bytes: &[u8], layout: Layout, options: &ReadOptions) -> Result<Import, ReadError> {
    let mut particles = Particles::default();
    let mut warnings = Vec::new();
    let mut raised = 0;
    let mut push = |row: &[f64]| {
        let whole = fit::push(&mut particles, layout.fit(row), options)?;
        raised += usize::from(!whole);
        Ok(())
    };
    if bytes.starts_with(matlab::MAGIC) {
        let (name, array) = variable(matlab::read(bytes)?, &mut warnings)?;
        push_rows(&array, &name, &mut push)?;
    } else if bytes.starts_with(numpy::MAGIC) {
        push_rows(&numpy::read(bytes, "array")?.numbers("array")?, "array", &mut push)?;
    } else if bytes.starts_with(npz::MAGIC) {
        let archive = npz::Npz::open(bytes)?;
        let names = archive.names();
        let [name] = names[..] else {
            let message =
                format!("expected one array of {WIDTH} numbers a shape, found: {}", names.join(", "));
            return Err(ReadError::File(message));
        };
        push_rows(&archive.needed(name)?.numbers(name)?, name, &mut push)?;
    } else {
        let text = std::str::from_utf8(bytes)
            .map_err(|_| ReadError::File("the file is neither text nor .mat nor .npy".to_owned()))?;
        for (line, row) in rows_of_text(text)? {
            push(&row).map_err(|message: String| ReadError::line(line, message))?;
        }
    }
    if particles.is_empty() {
        return Err(ReadError::File("the file has no shapes".to_owned()));
    }
    particles.extra = extra_columns(Vec::new(), options)?;
    warnings.extend(fit::raised_warning(raised));
    Ok(Import { warnings, ..Import::new(Content::Particles(particles), layout.reading()) })
}

/// The variable of a MATLAB file with eleven numbers a shape.
fn variable(
    variables: Vec<Variable>,
    warnings: &mut Vec<String>,
) -> Result<(String, NumberArray), ReadError> {
    let mut fitting = Vec::new();
    let mut others = Vec::new();
    for Variable { name, value } in variables {
        match value {
            Value::Numbers(array) if array.shape.contains(&WIDTH) && array.shape.len() <= 2 => {
                fitting.push((name, array));
            }
            Value::Numbers(array) => others.push(format!("'{name}' is an array {}", array.shape_text())),
            Value::Other(what) => others.push(format!("'{name}' is {what}")),
        }
    }
    if fitting.len() > 1 {
        let names: Vec<String> = fitting.iter().map(|(name, _)| name.clone()).collect();
        let Some(usual) = names.iter().position(|name| name == USUAL_NAME) else {
            let message = format!(
                "several variables have {WIDTH} numbers a shape: {}; keep one, or name it '{USUAL_NAME}'",
                names.join(", ")
            );
            return Err(ReadError::File(message));
        };
        warnings.push(format!("of the variables {} only '{USUAL_NAME}' is read", names.join(", ")));
        return Ok(fitting.swap_remove(usual));
    }
    fitting.pop().ok_or_else(|| {
        let found =
            if others.is_empty() { "the file has no variables".to_owned() } else { others.join(", ") };
        ReadError::File(format!("no variable is a matrix of {WIDTH} numbers a shape: {found}"))
    })
}

/// Passes each row of an array of shape (11), (N, 11), or (11, N).
fn push_rows(
    array: &NumberArray,
    name: &str,
    push: &mut dyn FnMut(&[f64]) -> Result<(), String>,
) -> Result<(), ReadError> {
    let columns;
    let array = match array.shape[..] {
        [WIDTH, other] if other != WIDTH => {
            columns = array.transposed();
            &columns
        }
        _ => array,
    };
    for (index, row) in array.rows(WIDTH, name)?.into_iter().enumerate() {
        push(row).map_err(|message| ReadError::part(format!("{name}[{index}]"), message))?;
    }
    Ok(())
}

/// The rows of a text with their lines: eleven numbers a line, separated by blanks, commas or
/// semicolons, or one vector with a number a line. '#' and '%' start comments.
fn rows_of_text(text: &str) -> Result<Vec<(u64, Vec<f64>)>, ReadError> {
    let mut rows: Vec<(u64, Vec<f64>)> = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.split(['#', '%']).next().unwrap_or_default();
        let is_blank = |c: char| c.is_whitespace() || matches!(c, ',' | ';' | '[' | ']' | '(' | ')');
        let words = content.split(is_blank).filter(|word| !word.is_empty());
        let numbers = words.map(|word| {
            word.parse::<f64>()
                .map_err(|_| ReadError::line(line, format!("'{}' is no number", clipped(word))))
        });
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        match numbers.len() {
            0 => {}
            WIDTH | 1 => rows.push((line, numbers)),
            found => {
                return Err(ReadError::line(line, format!("expected {WIDTH} numbers, found {found}")));
            }
        }
    }
    match rows.iter().find(|(_, row)| row.len() == 1) {
        None => Ok(rows),
        Some(&(line, _)) if rows.len() == WIDTH && rows.iter().all(|(_, row)| row.len() == 1) => {
            Ok(vec![(line, rows.into_iter().map(|(_, row)| row[0]).collect())])
        }
        Some(&(line, _)) => Err(ReadError::line(line, format!("expected {WIDTH} numbers, found 1"))),
    }
}

/// The beginning of a word, for messages.
fn clipped(word: &str) -> String {
    word.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use superegg_geom::glam::DMat3;

    use super::*;
    use crate::read::arrays::matlab::tests::{Layout as MatLayout, mat, matrix};
    use crate::read::arrays::npz::tests::npz as archive;
    use crate::read::arrays::numpy::tests::{npy, npy_f64};

    fn particles(import: Import) -> Particles {
        match import.content {
            Content::Particles(particles) => particles,
            Content::Script(script) => panic!("{script}"),
        }
    }

    fn ems(bytes: &[u8]) -> Particles {
        particles(read_ems(bytes, &ReadOptions::default()).unwrap())
    }

    fn message(bytes: &[u8]) -> String {
        read_ems(bytes, &ReadOptions::default()).unwrap_err().to_string()
    }

    /// A turn about an axis by its textbook matrix.
    fn turn(axis: usize, angle: f64) -> DMat3 {
        let (s, c) = angle.sin_cos();
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut columns = [[0.0; 3]; 3];
        columns[axis][axis] = 1.0;
        columns[i][i] = c;
        columns[j][j] = c;
        columns[i][j] = s;
        columns[j][i] = -s;
        DMat3::from_cols_array_2d(&columns)
    }

    fn vector() -> impl Strategy<Value = Vec<f64>> {
        let exponent = 0.01..2.0_f64;
        let axis = 1e-3..1e3_f64;
        let angle = -3.2..3.2_f64;
        let centre = -1e3..1e3_f64;
        (
            (exponent.clone(), exponent),
            (axis.clone(), axis.clone(), axis),
            (angle.clone(), angle.clone(), angle),
            (centre.clone(), centre.clone(), centre),
        )
            .prop_map(|((e, n), (a, b, c), (u, v, w), (x, y, z))| vec![e, n, a, b, c, u, v, w, x, y, z])
    }

    fn check(found: &Particles, vectors: &[Vec<f64>]) -> Result<(), TestCaseError> {
        prop_assert_eq!(found.len(), vectors.len());
        for (index, v) in vectors.iter().enumerate() {
            prop_assert_eq!(found.exponents[index], [v[1], v[0]]);
            prop_assert_eq!(found.radii[index].to_array(), [v[2], v[3], v[4]]);
            prop_assert_eq!(found.positions[index].to_array(), [v[8], v[9], v[10]]);
            let expected = turn(2, v[5]) * turn(1, v[6]) * turn(0, v[7]);
            prop_assert!(
                (DMat3::from_quat(found.rotations[index]) - expected)
                    .to_cols_array()
                    .iter()
                    .all(|d| d.abs() < 1e-14)
            );
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn vectors_are_read_from_every_file_to_their_digits(vectors in prop::collection::vec(vector(), 1..20)) {
            let count = vectors.len();
            let flat: Vec<f64> = vectors.concat();
            let columns: Vec<f64> = (0..WIDTH).flat_map(|c| vectors.iter().map(move |v| v[c])).collect();
            let shape = format!("({count}, 11)");
            check(&ems(&npy_f64(&shape, &flat)), &vectors)?;
            let data: Vec<u8> = columns.iter().flat_map(|x| x.to_be_bytes()).collect();
            check(&ems(&npy("'>f8'", true, &shape, &data)), &vectors)?;
            if count != WIDTH {
                check(&ems(&npy_f64(&format!("(11, {count})"), &columns)), &vectors)?;
            }
            check(&ems(&archive(&[("x", npy_f64(&shape, &flat))], rawzip::CompressionMethod::DEFLATE)), &vectors)?;
            for layout in [MatLayout::Plain, MatLayout::BigEndian, MatLayout::Compressed] {
                let matrix = matrix(6, "x", [count as u32, 11], &columns, layout);
                check(&ems(&mat(&[matrix], layout)), &vectors)?;
            }
            let lines = |separator: &str| {
                let line = |v: &Vec<f64>| v.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(separator);
                vectors.iter().map(line).collect::<Vec<_>>().join("\n")
            };
            for separator in [" ", ",", "; ", "\t"] {
                check(&ems(format!("# e1 e2 a1\n\n{}\n", lines(separator)).as_bytes()), &vectors)?;
            }
        }

        #[test]
        fn vectors_of_the_library_have_their_own_order(v in vector()) {
            // As in EMS's order: sizes, exponents, centre, angles.
            let row = [&v[2..5], &v[0..2], &v[8..11], &v[5..8]].concat();
            let bytes = npy_f64("(11,)", &row);
            let found = particles(read_superquadric_lib(&bytes, &ReadOptions::default()).unwrap());
            prop_assert_eq!(found.exponents[0], [v[1], v[0]]);
            prop_assert_eq!(found.radii[0].to_array(), [v[2], v[3], v[4]]);
            prop_assert_eq!(found.positions[0].to_array(), [v[8], v[9], v[10]]);
            let expected = turn(2, v[5]) * turn(1, v[6]) * turn(2, v[7]);
            prop_assert!((DMat3::from_quat(found.rotations[0]) - expected).to_cols_array().iter().all(|d| d.abs() < 1e-14));
        }

        #[test]
        fn any_text_is_vectors_or_an_error(text in "[0-9a-z.,;# \n-]{0,200}") {
            let _ = read_ems(text.as_bytes(), &ReadOptions::default());
            let _ = recognize(text.as_bytes());
        }
    }

    #[test]
    fn formats_are_told_apart_or_named() {
        let row = "1 1 1 1 1 0 0 0 0 0 0\n";
        assert_eq!(recognize(row.as_bytes()), [Format::Ems, Format::SuperquadricLib]);
        assert_eq!(recognize(row.repeat(1000).as_bytes()), [Format::Ems, Format::SuperquadricLib]);
        assert_eq!(recognize("1\n".repeat(11).as_bytes()), [Format::Ems, Format::SuperquadricLib]);
        for other in ["", "1 2 3\n", "primitive ball\n", "1\n2\n", "a b c d e f g h i j k\n"] {
            assert!(recognize(other.as_bytes()).is_empty(), "{other}");
        }
        assert_eq!(recognize(&npy_f64("(5, 11)", &[0.0; 55])), [Format::Ems]);
        assert_eq!(recognize(&npy_f64("(11, 3)", &[0.0; 33])), [Format::Ems, Format::NpyPoints]);
        assert!(recognize(&npy_f64("(5, 3)", &[0.0; 15])).is_empty());
        assert_eq!(recognize(&mat(&[], MatLayout::Plain)), [Format::Ems]);
    }

    #[test]
    fn errors_name_the_row() {
        assert_eq!(message(b"1 1 1 1 1 0 0 0 0 0 0\n\n1 2 3\n"), "line 3: expected 11 numbers, found 3");
        assert_eq!(
            message(b"1 1 1 -1 1 0 0 0 0 0 0\n"),
            "line 1: a semi-axis of -1 is not above 0; --min-axis X raises small ones"
        );
        assert!(message(b"1 1 1 1 1 0 0 nan 0 0 0\n").starts_with("line 1: the quaternion NaN"));
        let mut values = vec![1.0; 22];
        values[11] = f64::INFINITY;
        assert!(
            message(&npy_f64("(2, 11)", &values))
                .starts_with("'array[1]': the exponents e = 1, n = inf are not finite")
        );
        assert!(message(&npy_f64("(2, 10)", &[0.0; 20])).contains("found the shape (2, 10)"));
        assert!(message(&npy_f64("(0, 11)", &[])).contains("no shapes"));
        let plain = MatLayout::Plain;
        let of_class = |class| mat(&[matrix(class, "q", [1, 11], &[1.0; 11], plain)], plain);
        assert!(message(&of_class(1)).contains("'q' is a cell array"));
        assert!(message(&of_class(2)).contains("'q' is a structure"));
        let two =
            |names: [&str; 2]| mat(&names.map(|name| matrix(6, name, [1, 11], &[1.0; 11], plain)), plain);
        assert!(message(&two(["p", "q"])).contains("several variables"));
        let import = read_ems(&two(["p", "x"]), &ReadOptions::default()).unwrap();
        assert_eq!(import.warnings, ["of the variables p, x only 'x' is read"]);
    }
}
