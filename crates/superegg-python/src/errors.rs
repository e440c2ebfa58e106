//! Errors as exceptions.

use std::fmt::Display;
use std::io;

use pyo3::create_exception;
use pyo3::exceptions::{PyKeyError, PyMemoryError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use superegg::exchange::read::ReadError;
use superegg::lang::{Diagnostic, Severity};

create_exception!(
    superegg,
    FormatError,
    PyValueError,
    "A file or a text is in no known format, or is wrong.\n\n\
     Attributes\n----------\nfile : str or None\n    The file.\nline : int or None\n    Its line, counted from 1.\n\
     column : int or None\n    The column, counted from 1."
);

/// A [`FormatError`] with its place.
pub(crate) fn format_error(
    text: &str,
    file: Option<&str>,
    line: Option<u64>,
    column: Option<usize>,
) -> PyErr {
    let error = FormatError::new_err(text.to_owned());
    Python::attach(|py| {
        let value = error.value(py);
        // A new exception takes attributes.
        let _ = value.setattr("file", file);
        let _ = value.setattr("line", line);
        let _ = value.setattr("column", column);
    });
    error
}

/// The exception of the first error among diagnostics; `None` if there is none.
pub(crate) fn of_diagnostics(diagnostics: &[Diagnostic]) -> Option<PyErr> {
    let mut errors = diagnostics.iter().filter(|found| found.severity == Severity::Error);
    let first = errors.next()?;
    let others: usize = errors.map(|other| other.count).sum();
    let more = if others > 0 { format!("\n({others} more)") } else { String::new() };
    let line = first.line.map(|line| line as u64);
    Some(format_error(&format!("{first}{more}"), Some(&first.file), line, Some(first.column)))
}

/// A failed load or save: an `OSError` if the system is the reason, else a [`FormatError`].
pub(crate) fn of_file(error: &anyhow::Error, file: &str) -> PyErr {
    for cause in error.chain() {
        if let Some(cause) = cause.downcast_ref::<io::Error>()
            && let Some(code) = cause.raw_os_error()
        {
            return PyOSError::new_err((code, cause.to_string(), file.to_owned()));
        }
    }
    let line = error.chain().find_map(|cause| match cause.downcast_ref::<ReadError>() {
        Some(ReadError::Line { line, .. }) => Some(*line),
        _ => None,
    });
    format_error(
        &format!("{error:#}").replace("--from NAME", "convention=NAME").replace("--from", "convention"),
        Some(file),
        line,
        None,
    )
}

/// A `ValueError`.
pub(crate) fn value(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A `KeyError`.
pub(crate) fn key(error: impl Display) -> PyErr {
    PyKeyError::new_err(error.to_string())
}

/// A `MemoryError`.
pub(crate) fn memory(error: impl Display) -> PyErr {
    PyMemoryError::new_err(format!("the answers do not fit into memory; ask for fewer at a time: {error}"))
}

/// The exception of a defect.
pub(crate) fn defect(message: &str) -> PyErr {
    PyRuntimeError::new_err(format!("superegg failed, which is a defect; please report it: {message}"))
}
