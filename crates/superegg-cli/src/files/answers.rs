//! Answers to the rows of a table: one row out for each row in.

use std::path::Path;

use anyhow::Result;
use rayon::prelude::*;

use crate::console;
use crate::files::csv::{CsvRow, CsvRows, CsvText, RowFault, write_rows};

/// One field for each column of an answer, and a warning.
pub(crate) type Answer = (Vec<String>, Option<&'static str>);

/// The questions of a table and their answers.
pub(crate) struct Answers<'a, T, const N: usize> {
    /// The columns of numbers that a question is made of.
    pub(crate) questions: [&'static str; N],
    /// The columns of an answer.
    pub(crate) answers: Vec<&'static str>,
    /// The question of a row's numbers, or what is wrong with them.
    pub(crate) make: &'a (dyn Fn([f64; N]) -> Result<T, RowFault> + Sync),
    /// The answer to a question: one field for each column, and a warning.
    pub(crate) answer: &'a (dyn Fn(&T) -> Answer + Sync),
}

/// The rows that are answered at a time, on all cores.
const CHUNK: usize = 1 << 13;
/// The most errors of rows that are printed.
const MOST_PRINTED: usize = 20;

impl<T, const N: usize> Answers<'_, T, N> {
    /// Answers each row of `input`. The other columns of the input follow the answer. A wrong row
    /// is reported with its line and has an empty answer. Returns whether all rows were right.
    ///
    /// # Errors
    /// The input cannot be read or the output cannot be written.
    pub(crate) fn write(&self, input: &Path, output: Option<&Path>) -> Result<bool> {
        let text = CsvText::read(input)?;
        let mut rows = match text.rows(self.questions) {
            Ok(rows) => rows,
            Err(error) => {
                console::warn(error);
                return Ok(false);
            }
        };
        let mut faults = Faults::default();
        write_rows(output, |writer| {
            let names = self.answers.iter().map(|&name| name.to_owned());
            writer.write_record(names.chain(rows.other_names(&self.answers)))?;
            loop {
                let lines = rows.next_lines(CHUNK);
                if lines.is_empty() {
                    return Ok(());
                }
                let answered: Vec<_> = lines.par_iter().map(|&line| self.answer(&rows, line)).collect();
                for (row, fault) in answered {
                    faults.take(fault);
                    writer.write_record(row)?;
                }
            }
        })?;
        Ok(faults.finish())
    }

    /// The output row for a line, and what there is to report.
    fn answer(&self, rows: &CsvRows<'_, N>, line: (usize, &str)) -> (Vec<String>, Option<Fault>) {
        let mut row = rows.parse(line);
        let numbers = std::mem::replace(&mut row.numbers, Ok([0.0; N]));
        let question =
            numbers.and_then(|numbers| (self.make)(numbers).map_err(|fault| rows.fault(&row, &fault)));
        let (mut fields, fault) = match question {
            Ok(question) => {
                let (fields, warning) = (self.answer)(&question);
                (fields, warning.map(|text| Fault::Warning(warning_at(rows, &row, text))))
            }
            Err(error) => (vec![String::new(); self.answers.len()], Some(Fault::Error(error))),
        };
        fields.append(&mut row.others);
        (fields, fault)
    }
}

fn warning_at<const N: usize>(rows: &CsvRows<'_, N>, row: &CsvRow<N>, text: &str) -> String {
    rows.fault(row, &(0, String::new())).replace("error: ", &format!("warning: {text}"))
}

/// What there is to report of a row.
enum Fault {
    Error(String),
    Warning(String),
}

/// Prints the first errors and warnings, and counts them.
#[derive(Default)]
struct Faults {
    errors: usize,
    warnings: usize,
}

impl Faults {
    fn take(&mut self, fault: Option<Fault>) {
        let (count, text) = match fault {
            None => return,
            Some(Fault::Error(text)) => (&mut self.errors, text),
            Some(Fault::Warning(text)) => (&mut self.warnings, text),
        };
        *count += 1;
        if *count <= MOST_PRINTED {
            console::warn(text);
        }
    }

    /// Prints how many were left out. Returns whether there was no error.
    fn finish(&self) -> bool {
        for (count, kind) in [(self.errors, "errors"), (self.warnings, "warnings")] {
            if let Some(more @ 1..) = count.checked_sub(MOST_PRINTED) {
                console::warn(format_args!("superegg: {more} more {kind} of this kind"));
            }
        }
        self.errors == 0
    }
}
