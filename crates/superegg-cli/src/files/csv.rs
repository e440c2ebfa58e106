//! Reads rows of numbers from CSV, and writes rows.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use superegg_lang::{format_number, parse_number};

use crate::files::access;

/// The index (from 0) of a wrong number in a row, and the error message.
pub(crate) type RowFault = (usize, String);

/// Reads rows of `N` numbers under the header `names` and converts each with `make`. Blank lines
/// are skipped. The inner error lists every wrong row with file, line and column.
///
/// # Errors
/// The file cannot be read.
pub(crate) fn read_rows<T, const N: usize>(
    path: &Path,
    names: [&str; N],
    make: impl Fn([f64; N]) -> Result<T, RowFault>,
) -> Result<Result<Vec<T>, Vec<String>>> {
    let bytes = access::read(path)?;
    Ok(parse_rows(&path.display().to_string(), &String::from_utf8_lossy(&bytes), names, make))
}

/// A value between commas, and the column (from 1) of its first character.
struct Field<'a> {
    text: &'a str,
    column: usize,
}

fn split_fields(line: &str) -> Vec<Field<'_>> {
    let mut column = 1;
    line.split(',')
        .map(|field| {
            let blanks = field.chars().take_while(|c| c.is_whitespace()).count();
            let begins = column + blanks;
            column += field.chars().count() + 1;
            let text = field.trim();
            let unquoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
            Field { text: unquoted.unwrap_or(text), column: begins }
        })
        .collect()
}

fn parse_rows<T, const N: usize>(
    file: &str,
    text: &str,
    names: [&str; N],
    make: impl Fn([f64; N]) -> Result<T, RowFault>,
) -> Result<Vec<T>, Vec<String>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let is_header = |line: &str| {
        let fields = split_fields(line);
        fields.len() == N
            && fields.iter().zip(names).all(|(field, name)| field.text.eq_ignore_ascii_case(name))
    };
    let first = lines.next();
    if !first.is_some_and(|(_, line)| is_header(line)) {
        let line = first.map_or(1, |(i, _)| i + 1);
        return Err(vec![format!(
            "{file}:{line}:1: error: the first line must be the header {}",
            names.join(",")
        )]);
    }
    let mut rows = Vec::new();
    let mut errors = Vec::new();
    for (i, line) in lines {
        let fields = split_fields(line);
        match parse_fields(&fields, names).and_then(&make) {
            Ok(row) => rows.push(row),
            Err((field, message)) => {
                let column = fields.get(field).map_or(line.chars().count() + 1, |field| field.column);
                errors.push(format!("{file}:{}:{column}: error: {message}", i + 1));
            }
        }
    }
    if errors.is_empty() { Ok(rows) } else { Err(errors) }
}

fn parse_fields<const N: usize>(fields: &[Field<'_>], names: [&str; N]) -> Result<[f64; N], RowFault> {
    if fields.len() != N {
        let message = format!("a row has {N} numbers ({}), not {}", names.join(","), fields.len());
        return Err((fields.len().min(N), message));
    }
    let mut row = [0.0; N];
    for (i, (field, name)) in fields.iter().zip(names).enumerate() {
        row[i] = parse_number(field.text)
            .map_err(|error| (i, format!("{name} '{}' {error}", field.text.escape_debug())))?;
    }
    Ok(row)
}

/// Writes rows of CSV: to a file completely or not at all, or to standard output as they come.
///
/// # Errors
/// The output cannot be written.
pub(crate) fn write_rows(
    output: Option<&Path>,
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> csv::Result<()>,
) -> Result<()> {
    const CANNOT_WRITE: &str = "cannot write the answers";
    let file = output.filter(|path| !access::is_standard_stream(path));
    let mut buffer = Vec::new();
    let mut stdout = io::stdout().lock();
    let sink: &mut dyn Write = if file.is_some() { &mut buffer } else { &mut stdout };
    let mut writer = csv::Writer::from_writer(sink);
    rows(&mut writer).map_err(io_error).context(CANNOT_WRITE)?;
    writer.flush().context(CANNOT_WRITE)?;
    drop(writer);
    file.map_or(Ok(()), |path| access::write(path, &buffer))
}

/// The I/O error of a CSV error. It keeps its kind, so that a closed pipe is recognised.
fn io_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// Formats numbers as fields of an output row.
pub(crate) fn fields(numbers: &[f64]) -> impl Iterator<Item = String> {
    numbers.iter().map(|&x| format_number(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Result<Vec<[f64; 3]>, Vec<String>> {
        parse_rows("p.csv", text, ["x", "y", "z"], Ok)
    }

    #[test]
    fn reads_numbers_under_the_header() {
        assert_eq!(
            rows("x,y,z\n1, .5,1e-3\r\n\n  \n-2.,0,\"4\"").unwrap(),
            [[1.0, 0.5, 0.001], [-2.0, 0.0, 4.0]]
        );
        assert_eq!(rows("\u{feff}X, y ,z\r\n").unwrap(), [[0.0; 3]; 0]);
    }

    #[test]
    fn every_bad_row_is_reported_with_its_position() {
        let errors = rows("x,y,z\r\n1,2\r\n\r\n1, two,3\n1,2,3,4\n1,2,inf\n").unwrap_err();
        let positions: Vec<_> = errors.iter().map(|c| c.split(": ").next().unwrap()).collect();
        assert_eq!(positions, ["p.csv:2:4", "p.csv:4:4", "p.csv:5:7", "p.csv:6:5"]);
        assert!(rows("").is_err() && rows("1,2,3\n").is_err() && rows("x,z,y\n").is_err());
    }
}
