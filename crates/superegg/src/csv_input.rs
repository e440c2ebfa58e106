//! Rows of numbers from CSV.

use std::path::Path;

use anyhow::Result;
use superegg_lang::{format_number, parse_number};

use crate::files;

/// What is wrong with a row, and in which column (from 1).
pub(crate) type RowFault = (usize, String);

/// Rows of `N` numbers under the header that `names` spell, each made into what is wanted of it, or every complaint about them with
/// file, line and column.
pub(crate) fn read_rows<T, const N: usize>(
    path: &Path,
    names: [&str; N],
    make: impl Fn([f64; N]) -> Result<T, RowFault>,
) -> Result<Result<Vec<T>, Vec<String>>> {
    let bytes = files::read(path)?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    Ok(parse_rows(&path.display().to_string(), bytes, names, make))
}

fn parse_rows<T, const N: usize>(
    file: &str,
    bytes: &[u8],
    names: [&str; N],
    make: impl Fn([f64; N]) -> Result<T, RowFault>,
) -> Result<Vec<T>, Vec<String>> {
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let header = names.join(",");
    let mut rows = Vec::new();
    let mut complaints = Vec::new();
    let mut record = csv::ByteRecord::new();
    let mut is_header = true;
    loop {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                complaints.push(format!("{file}: error: {error}"));
                break;
            }
        }
        let line = record.position().map_or(0, csv::Position::line);
        if is_header {
            is_header = false;
            let is_right = record.len() == N
                && record.iter().zip(names).all(|(field, name)| field.eq_ignore_ascii_case(name.as_bytes()));
            if !is_right {
                return Err(vec![format!(
                    "{file}:{line}:1: error: the first line must be the header {header}"
                )]);
            }
            continue;
        }
        match parse_row(&record, names).and_then(&make) {
            Ok(row) => rows.push(row),
            Err((column, complaint)) => {
                complaints.push(format!("{file}:{line}:{column}: error: {complaint}"));
            }
        }
    }
    if is_header {
        complaints
            .push(format!("{file}:1:1: error: it is empty; the first line must be the header {header}"));
    }
    if complaints.is_empty() { Ok(rows) } else { Err(complaints) }
}

fn parse_row<const N: usize>(record: &csv::ByteRecord, names: [&str; N]) -> Result<[f64; N], RowFault> {
    if record.len() != N {
        let column = record.len().min(N);
        return Err((column, format!("a row has {N} numbers ({}), not {}", names.join(","), record.len())));
    }
    let mut row = [0.0; N];
    for (i, field) in record.iter().enumerate() {
        let text = String::from_utf8_lossy(field);
        row[i] = parse_number(&text).map_err(|error| (i + 1, format!("{} '{text}' {error}", names[i])))?;
    }
    Ok(row)
}

/// Numbers as fields of an output row.
pub(crate) fn fields(numbers: &[f64]) -> impl Iterator<Item = String> {
    numbers.iter().map(|&x| format_number(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Result<Vec<[f64; 3]>, Vec<String>> {
        parse_rows("p.csv", text.as_bytes(), ["x", "y", "z"], Ok)
    }

    #[test]
    fn reads_numbers_under_the_header() {
        assert_eq!(
            rows("x,y,z\n1, .5,1e-3\r\n\n-2.,0,\"4\"").unwrap(),
            [[1.0, 0.5, 0.001], [-2.0, 0.0, 4.0]]
        );
        assert_eq!(rows("x,y,z").unwrap(), [[0.0; 3]; 0]);
    }

    #[test]
    fn complains_of_every_bad_row_with_its_place() {
        let complaints = rows("x,y,z\n1,2\n1,two,3\n1,2,3,4\n1,2,inf\n").unwrap_err();
        let places: Vec<_> = complaints.iter().map(|c| c.split(": ").next().unwrap()).collect();
        assert_eq!(places, ["p.csv:2:2", "p.csv:3:2", "p.csv:4:3", "p.csv:5:3"]);
        assert!(rows("").is_err() && rows("1,2,3\n").is_err() && rows("x,z,y\n").is_err());
    }
}
