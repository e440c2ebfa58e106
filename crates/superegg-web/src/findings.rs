//! Errors and warnings about a text, where an editor finds them.

use serde::Serialize;
use superegg_lang::{Diagnostic, Severity};

use crate::text::{lines_of, units_of};

/// An error or a warning about a text.
#[derive(Serialize)]
pub(crate) struct Finding {
    severity: &'static str,
    code: &'static str,
    message: String,
    help: Option<String>,
    /// The line, counted from 1; 0 for the whole text.
    line: usize,
    /// The wrong columns, in UTF-16 units from 0.
    from: usize,
    to: usize,
}

impl Finding {
    /// A diagnostic about a line of this text.
    fn new(diagnostic: Diagnostic, line: &str) -> Self {
        let Diagnostic { severity, code, message, help, column, width, .. } = diagnostic;
        Self {
            severity: match severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            },
            code: code.as_str(),
            message,
            help,
            line: diagnostic.line.unwrap_or(0),
            from: units_of(line, column - 1),
            to: units_of(line, column - 1 + width),
        }
    }
}

/// Findings about a text.
pub(crate) fn findings(diagnostics: Vec<Diagnostic>, text: &str) -> Vec<Finding> {
    let lines: Vec<&str> = lines_of(text).collect();
    let line = |found: &Diagnostic| found.line.and_then(|line| lines.get(line - 1)).copied().unwrap_or("");
    diagnostics
        .into_iter()
        .map(|found| {
            let line = line(&found);
            Finding::new(found, line)
        })
        .collect()
}
