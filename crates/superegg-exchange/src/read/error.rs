//! Why a file cannot be read.

use thiserror::Error;

/// Why a file cannot be read. The text names the line, the array or the key, and what to do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The stream cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The content is none of the formats.
    #[error("the format is not recognized; --from NAME chooses one")]
    Unrecognized,
    /// The content fits several formats that mean different things.
    #[error("{what}; choose one with --from: {}", .candidates.join(", "))]
    Ambiguous {
        /// The question that cannot be decided.
        what: String,
        /// The names of the formats in question.
        candidates: Vec<&'static str>,
    },
    /// A line of a text file is wrong.
    #[error("line {line}: {message}")]
    Line {
        /// The line, counted from 1.
        line: u64,
        /// The fault, in words.
        message: String,
    },
    /// An array, key or section is wrong.
    #[error("'{name}': {message}")]
    Part {
        /// The name of the array, key or section.
        name: String,
        /// The fault, in words.
        message: String,
    },
    /// Anything else that is wrong with the file as a whole.
    #[error("{0}")]
    File(String),
}

impl ReadError {
    /// An error in a line of a text file, counted from 1.
    pub fn line(line: u64, message: impl Into<String>) -> Self {
        Self::Line { line, message: message.into() }
    }

    /// An error in an array, key or section.
    pub fn part(name: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Part { name: name.into(), message: message.into() }
    }
}
