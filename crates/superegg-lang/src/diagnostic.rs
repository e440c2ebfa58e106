//! What is wrong, where, and what to do about it.

use std::fmt;
use std::ops::Range;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The line was not carried out.
    Error,
    /// It was, but may not be what was meant.
    Warning,
}

/// Why a line was not carried out. It knows the place within the line, not the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// How bad it is.
    pub severity: Severity,
    /// A short fixed word for the kind of fault.
    pub code: &'static str,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
    /// The characters of the line that are meant, counted from 0; `None` for the line as a whole.
    pub columns: Option<Range<usize>>,
}

impl Fault {
    /// A fault with nothing but a message.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, code, message: message.into(), help: None, columns: None }
    }

    /// The same as a warning.
    #[must_use]
    pub fn warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }

    /// Says what would be right.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Says which characters of the line are meant.
    #[must_use]
    pub fn at(mut self, columns: Range<usize>) -> Self {
        self.columns = Some(columns);
        self
    }
}

/// A fault or a warning with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// A short fixed word for the kind.
    pub code: &'static str,
    /// The file, as the user named it; empty for a line that was typed and is still to be seen.
    pub file: String,
    /// The line, from 1; `None` where the file as a whole is meant.
    pub line: Option<usize>,
    /// The column of the first character meant, from 1.
    pub column: usize,
    /// How many characters are meant, at least 1.
    pub width: usize,
    /// The text of the line, for showing.
    pub excerpt: String,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
}

/// Longer lines are not shown.
const LONGEST_EXCERPT: usize = 160;

impl Diagnostic {
    /// A fault at a line of a file.
    pub fn of_line(file: &str, line: usize, text: &str, fault: Fault) -> Self {
        let columns = fault.columns.unwrap_or_else(|| {
            let start = text.chars().take_while(|c| c.is_whitespace()).count();
            start..text.trim_end().chars().count()
        });
        let is_showable =
            text.chars().count() <= LONGEST_EXCERPT && !text.chars().any(|c| c.is_control() && c != '\t');
        Self {
            severity: fault.severity,
            code: fault.code,
            file: file.to_owned(),
            line: Some(line),
            column: columns.start + 1,
            width: columns.len().max(1),
            excerpt: if is_showable { text.trim_end().replace('\t', " ") } else { String::new() },
            message: fault.message,
            help: fault.help,
        }
    }

    /// A warning about a file as a whole.
    pub fn of_file(
        file: &str,
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            severity: Severity::Warning,
            code,
            file: file.to_owned(),
            line: None,
            column: 1,
            width: 1,
            excerpt: String::new(),
            message: message.into(),
            help: Some(help.into()),
        }
    }
}

/// `file:line:column: error[code]: message` (without the place where there is no file), the line with the place marked, and the help.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        if !self.file.is_empty() {
            write!(f, "{}:", self.file)?;
            if let Some(line) = self.line {
                write!(f, "{line}:{}:", self.column)?;
            }
            f.write_str(" ")?;
        }
        write!(f, "{severity}[{}]: {}", self.code, self.message)?;
        if !self.excerpt.is_empty() {
            let indent = " ".repeat(self.column - 1);
            write!(f, "\n    | {}\n    | {indent}{}", self.excerpt, "^".repeat(self.width))?;
        }
        match &self.help {
            Some(help) => write!(f, "\n    = help: {help}"),
            None => Ok(()),
        }
    }
}
