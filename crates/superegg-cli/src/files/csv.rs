//! Reads rows of numbers from CSV, and writes rows.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use superegg_lang::{format_number, parse_number, visible};
use superegg_trace::{CompiledScene, InstancePath};

use crate::files::access;

/// The index (from 0) of a wrong number in a row, and the error message.
pub(crate) type RowFault = (usize, String);

/// The text of a CSV file.
pub(crate) struct CsvText {
    file: String,
    text: String,
}

impl CsvText {
    /// Reads a file, or standard input for `-`.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let bytes = access::read(path)?;
        let text = String::from_utf8(bytes)
            .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned());
        Ok(Self { file: path.display().to_string(), text })
    }

    /// The rows of `N` numbers under a header that has the columns `names`, in any order and any
    /// case, among others.
    ///
    /// # Errors
    /// The first line is no such header.
    pub(crate) fn rows<'t, const N: usize>(
        &'t self,
        names: [&'static str; N],
    ) -> Result<CsvRows<'t, N>, String> {
        let text = self.text.strip_prefix('\u{feff}').unwrap_or(&self.text);
        let mut lines = text.lines().enumerate();
        let header = lines.by_ref().find(|(_, line)| !line.trim().is_empty());
        let (number, header) = header.map_or((1, ""), |(i, line)| (i + 1, line));
        let fault =
            |column: usize, message: String| format!("{}:{number}:{column}: error: {message}", self.file);
        let fields = split_fields(header).ok_or_else(|| fault(1, UNCLOSED.to_owned()))?;
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            let mut found = (0..fields.len()).filter(|&i| fields[i].text.eq_ignore_ascii_case(name));
            let must = || format!("the first line must be the header {}", names.join(","));
            *column = found.next().ok_or_else(|| {
                fault(1, format!("{}, in any order and with any other columns; '{name}' is missing", must()))
            })?;
            if let Some(second) = found.next() {
                return Err(fault(
                    fields[second].column,
                    format!("the header has the column '{name}' twice"),
                ));
            }
        }
        let others = (0..fields.len()).filter(|i| !columns.contains(i)).collect();
        let header = fields.iter().map(|field| field.text.clone().into_owned()).collect();
        Ok(CsvRows { file: &self.file, lines, names, columns, others, header })
    }
}

/// The rows below a header.
pub(crate) struct CsvRows<'t, const N: usize> {
    file: &'t str,
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
    names: [&'static str; N],
    /// The index of each wanted column.
    columns: [usize; N],
    /// The indices of the other columns.
    others: Vec<usize>,
    /// The names of all columns.
    header: Vec<String>,
}

/// A row: its numbers, or its error with file, line and column; and the other fields.
pub(crate) struct CsvRow<const N: usize> {
    pub(crate) numbers: Result<[f64; N], String>,
    pub(crate) others: Vec<String>,
    position: RowPosition<N>,
}

/// Where the numbers of a row are.
struct RowPosition<const N: usize> {
    line: usize,
    columns: [usize; N],
}

impl<'t, const N: usize> CsvRows<'t, N> {
    /// The names of the other columns. One that would be taken for a column of `answers` gets `_in`
    /// at its end.
    pub(crate) fn other_names(&self, answers: &[&str]) -> Vec<String> {
        let mut taken: Vec<String> = answers.iter().map(|&name| name.to_owned()).collect();
        for &i in &self.others {
            let mut name = self.header[i].clone();
            while taken.iter().any(|other| other.eq_ignore_ascii_case(&name)) && !name.is_empty() {
                name.push_str("_in");
            }
            taken.push(name);
        }
        taken.split_off(answers.len())
    }

    /// The next lines that are not blank, up to `most`.
    pub(crate) fn next_lines(&mut self, most: usize) -> Vec<(usize, &'t str)> {
        self.lines.by_ref().filter(|(_, line)| !line.trim().is_empty()).take(most).collect()
    }

    /// The row of a line (index from 0, text).
    pub(crate) fn parse(&self, (line, text): (usize, &str)) -> CsvRow<N> {
        let fields = split_fields(text);
        let place = |i: usize| fields.as_ref().and_then(|fields| fields.get(i)).map(|field| field.column);
        let end = text.chars().count() + 1;
        let position = RowPosition { line: line + 1, columns: self.columns.map(|i| place(i).unwrap_or(end)) };
        let fields = fields.as_deref();
        let other = |&i: &usize| {
            fields.and_then(|fields| fields.get(i)).map_or_else(String::new, |field| field.text.to_string())
        };
        let others = self.others.iter().map(other).collect();
        let numbers = match fields {
            None => Err((end, UNCLOSED.to_owned())),
            Some(fields) => self.numbers(fields, end),
        };
        let numbers = numbers.map_err(|(column, message)| self.error(position.line, column, &message));
        CsvRow { numbers, others, position }
    }

    /// The error for a number of a row.
    pub(crate) fn fault(&self, row: &CsvRow<N>, (number, message): &RowFault) -> String {
        self.error(row.position.line, row.position.columns[(*number).min(N - 1)], message)
    }

    fn error(&self, line: usize, column: usize, message: &str) -> String {
        format!("{}:{line}:{column}: error: {message}", self.file)
    }

    /// The numbers of a row, or the column in the line of what is wrong, and why.
    fn numbers(&self, fields: &[Field<'_>], end: usize) -> Result<[f64; N], (usize, String)> {
        let count = self.header.len();
        if fields.len() != count {
            let what = if self.others.is_empty() { "numbers" } else { "fields" };
            let message =
                format!("a row has {count} {what} ({}), not {}", self.header.join(","), fields.len());
            return Err((fields.get(count).map_or(end, |field| field.column), message));
        }
        let mut row = [0.0; N];
        for ((number, &i), name) in row.iter_mut().zip(&self.columns).zip(self.names) {
            *number = parse_number(&fields[i].text).map_err(|error| {
                (fields[i].column, format!("{name} '{}' {error}", fields[i].text.escape_debug()))
            })?;
        }
        Ok(row)
    }
}

const UNCLOSED: &str = "a quotation mark is not closed on its line";

/// A value between commas, and the column (from 1) of its first character.
struct Field<'a> {
    text: std::borrow::Cow<'a, str>,
    column: usize,
}

/// The fields of a line. A field in quotation marks may have commas, and `""` for a quotation mark.
/// `None` if a quotation mark is not closed.
fn split_fields(line: &str) -> Option<Vec<Field<'_>>> {
    let mut fields = Vec::new();
    let (mut rest, mut column) = (line, 1);
    loop {
        let blanks = rest.chars().take_while(|c| c.is_whitespace()).count();
        let begins = column + blanks;
        let trimmed = rest.trim_start();
        let is_quoted = trimmed.starts_with('"');
        let end = if is_quoted {
            let start = rest.len() - trimmed.len();
            let close = start + 1 + closing_quote(&trimmed[1..])?;
            close + rest[close..].find(',').unwrap_or(rest.len() - close)
        } else {
            rest.find(',').unwrap_or(rest.len())
        };
        let text = rest[..end].trim();
        let unquoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        let text = match unquoted {
            Some(text) if text.contains('"') => text.replace("\"\"", "\"").into(),
            _ => unquoted.unwrap_or(text).into(),
        };
        fields.push(Field { text, column: begins });
        if end == rest.len() {
            return Some(fields);
        }
        column += rest[..=end].chars().count();
        rest = &rest[end + 1..];
    }
}

/// The index of the quotation mark that ends a quoted text; `""` stands for one within it.
fn closing_quote(text: &str) -> Option<usize> {
    let mut from = 0;
    loop {
        let quote = from + text[from..].find('"')?;
        if !text[quote + 1..].starts_with('"') {
            return Some(quote);
        }
        from = quote + 2;
    }
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

/// The path of an instance as a field: a terminal may show it.
pub(crate) fn path_field(scene: &CompiledScene, path: &InstancePath) -> String {
    visible(&scene.path_name(path))
}

/// Formats numbers as fields of an output row.
pub(crate) fn fields(numbers: &[f64]) -> impl Iterator<Item = String> {
    numbers.iter().map(|&x| format_number(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 3] = ["x", "y", "z"];

    /// The numbers and other fields of each row, or the error of the header.
    #[expect(clippy::type_complexity)]
    fn rows(text: &str) -> Result<Vec<(Result<[f64; 3], String>, Vec<String>)>, String> {
        let text = CsvText { file: "p.csv".to_owned(), text: text.to_owned() };
        let mut rows = text.rows(NAMES)?;
        let lines = rows.next_lines(usize::MAX);
        Ok(lines.into_iter().map(|line| rows.parse(line)).map(|row| (row.numbers, row.others)).collect())
    }

    fn numbers(text: &str) -> Vec<[f64; 3]> {
        rows(text).unwrap().into_iter().map(|(numbers, _)| numbers.unwrap()).collect()
    }

    #[test]
    fn reads_numbers_under_the_header() {
        assert_eq!(numbers("x,y,z\n1, .5,1e-3\r\n\n  \n-2.,0,\"4\""), [[1.0, 0.5, 0.001], [-2.0, 0.0, 4.0]]);
        assert_eq!(numbers("\u{feff}X, y ,z\r\n"), [[0.0; 3]; 0]);
        assert_eq!(numbers("z,X, \"Y\"\n1,2,3\n"), [[2.0, 3.0, 1.0]]);
    }

    #[test]
    fn other_columns_are_kept_as_they_are() {
        let rows = rows("id, x,note ,y,z\n007,1,\"a, \"\"b\"\"\",2,3\n,1, c d ,2,x\n8,1\n").unwrap();
        assert_eq!(rows[0], (Ok([1.0, 2.0, 3.0]), vec!["007".to_owned(), "a, \"b\"".to_owned()]));
        assert_eq!(rows[1].1, ["", "c d"]);
        assert!(rows[1].0.as_ref().unwrap_err().starts_with("p.csv:3:12: error: z 'x'"));
        assert_eq!(rows[2].1, ["8", ""]);
    }

    #[test]
    fn a_name_of_an_answer_is_told_apart() {
        let text = CsvText { file: String::new(), text: "x,y,z,Path,id,path\n".to_owned() };
        let rows = text.rows(NAMES).unwrap();
        assert_eq!(rows.other_names(&["x", "path"]), ["Path_in", "id", "path_in_in"]);
    }

    #[test]
    fn every_bad_row_is_reported_with_its_position() {
        let found = rows("x,y,z\r\n1,2\r\n\r\n1, two,3\n1,2,3,4\n1,2,inf\n1,\"2,3\n").unwrap();
        let errors: Vec<_> = found.into_iter().map(|(numbers, _)| numbers.unwrap_err()).collect();
        let positions: Vec<_> = errors.iter().map(|c| c.split(": ").next().unwrap()).collect();
        assert_eq!(positions, ["p.csv:2:4", "p.csv:4:4", "p.csv:5:7", "p.csv:6:5", "p.csv:7:7"]);
        for header in ["", "1,2,3\n", "x,y\n", "x,y,z,X\n", "x,\"y,z\n"] {
            assert!(rows(header).is_err(), "{header}");
        }
    }
}
