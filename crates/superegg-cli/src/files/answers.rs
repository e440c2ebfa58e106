//! Answers to the rows of a table: one row out for each row in.

use std::path::Path;

use anyhow::Result;
use rayon::prelude::*;

use crate::console;
use crate::files::csv::{CsvRows, CsvText, RowFault, write_rows};

/// The questions of a table and their answers.
pub(crate) struct Answers<'a, T, const N: usize> {
    /// The columns of numbers that a question is made of.
    pub(crate) questions: [&'static str; N],
    /// The columns of an answer.
    pub(crate) answers: Vec<&'static str>,
    /// The question of a row's numbers, or what is wrong with them.
    pub(crate) make: &'a (dyn Fn([f64; N]) -> Result<T, RowFault> + Sync),
    /// The answer to a question: one field for each column; or why there is none.
    pub(crate) answer: &'a (dyn Fn(&T) -> Result<Vec<String>, RowFault> + Sync),
}

/// The rows that are answered at a time, on all cores.
const CHUNK: usize = 1 << 13;
/// The most errors of rows that are printed.
const MOST_PRINTED: usize = 20;

impl<T, const N: usize> Answers<'_, T, N> {
    /// Answers each row of `input`. The other columns of the input follow the answer. A wrong row
    /// is reported with its line and has an empty answer, and so has a row whose answer needs too
    /// much work. Returns whether all rows have an answer.
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
    fn answer(&self, rows: &CsvRows<'_, N>, line: (usize, &str)) -> (Vec<String>, Option<String>) {
        let mut row = rows.parse(line);
        let numbers = std::mem::replace(&mut row.numbers, Ok([0.0; N]));
        let answer = numbers.and_then(|numbers| {
            let question = (self.make)(numbers);
            let answer = question.and_then(|question| (self.answer)(&question));
            answer.map_err(|fault| rows.fault(&row, &fault))
        });
        let (mut fields, error) = match answer {
            Ok(fields) => (fields, None),
            Err(error) => (vec![String::new(); self.answers.len()], Some(error)),
        };
        fields.append(&mut row.others);
        (fields, error)
    }
}

/// Prints the first errors, and counts them.
#[derive(Default)]
struct Faults {
    errors: usize,
}

impl Faults {
    fn take(&mut self, error: Option<String>) {
        let Some(text) = error else { return };
        self.errors += 1;
        if self.errors <= MOST_PRINTED {
            console::warn(text);
        }
    }

    /// Prints how many were left out. Returns whether there was no error.
    fn finish(&self) -> bool {
        if let Some(more @ 1..) = self.errors.checked_sub(MOST_PRINTED) {
            console::warn(format_args!("superegg: {more} more errors of this kind"));
        }
        self.errors == 0
    }
}
