//! Errors and warnings: what is wrong, where, and how to correct it.

use std::fmt;
use std::ops::Range;

use crate::suggest::Suggestions;
use crate::text::is_unseen;

/// Whether a line was carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The line was not carried out.
    Error,
    /// The line was carried out, but probably does not do what the user wants.
    Warning,
}

macro_rules! fault_codes {
    ($($(#[$doc:meta])* $variant:ident = $text:literal,)+) => {
        /// The kind of a fault or warning. Its text, for example `unknown-name`, is stable.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum FaultCode {
            $($(#[$doc])* $variant,)+
        }

        impl FaultCode {
            /// Every code.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The stable text of the code.
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                }
            }
        }
    };
}

fault_codes! {
    // Lines that cannot be read.
    /// No command has this name.
    UnknownCommand = "unknown-command",
    /// The number of arguments is wrong.
    ArgumentCount = "argument-count",
    /// An argument is not a number.
    NotANumber = "not-a-number",
    /// A number is outside its range.
    OutOfRange = "out-of-range",
    /// A word is not one of the allowed ones.
    UnknownWord = "unknown-word",
    /// The command has no such option.
    UnknownOption = "unknown-option",
    /// The file name is empty.
    NoFile = "no-file",
    /// The line is not UTF-8, or has a zero byte.
    NotText = "not-text",
    /// The line is too long.
    TooLong = "too-long",

    // Lines that do not fit the session.
    /// The command needs another selection.
    Selection = "selection",
    /// No entity, child or light has this name.
    UnknownName = "unknown-name",
    /// The name belongs to an entity of the other kind.
    WrongKind = "wrong-kind",
    /// A child of the object has this alias already.
    AliasExists = "alias-taken",
    /// A primitive or object has this name already.
    NameExists = "name-taken",
    /// The object has no child.
    NoChild = "no-child",
    /// The transform is not invertible.
    Transform = "transform",
    /// A direction is zero.
    NoDirection = "no-direction",
    /// The scene has no floor.
    NoFloor = "no-floor",
    /// No setting has this name.
    UnknownSetting = "unknown-setting",
    /// The command has no numbers that keys can interpolate.
    NotKeyable = "not-keyable",
    /// The keys of a track differ in their count of numbers.
    KeyNumbers = "key-numbers",
    /// No such key exists.
    NoKey = "no-key",
    /// There is nothing to undo, redo, stop or recover.
    NothingLeft = "nothing-left",

    // Requests that failed.
    /// The request was interrupted.
    Interrupted = "interrupted",
    /// The file has errors and was not loaded.
    NotLoaded = "not-loaded",
    /// The file was not written by this program and is not overwritten.
    NotOurs = "not-ours",
    /// The file or folder cannot be read.
    Unreadable = "unreadable",
    /// The file or folder cannot be written.
    Unwritable = "unwritable",
    /// The name is not that of a picture file.
    NotAPicture = "not-a-picture",
    /// The preview cannot be drawn.
    Preview = "preview",
    /// No viewer can be opened.
    NoViewer = "no-viewer",
    /// The command is not possible in a file.
    NotHere = "not-here",
    /// A file sources itself.
    SourceCycle = "source-circle",
    /// A file sources too many others.
    SourceLimit = "source-limit",

    /// The file has more faults than are described.
    Many = "many",

    // Warnings about a file.
    /// An object has no children.
    EmptyObject = "empty-object",
    /// A primitive or object is in no object, and not selected.
    Unused = "unused",
    /// The mirrored and transmitted weights add up to more than 1.
    Weights = "shares",
    /// A quaternion's length is far from 1.
    Quaternion = "quaternion",
    /// The scene is invalid at some frame.
    Keys = "keys",
    /// The camera looks along its up direction.
    CameraUp = "camera-up",
    /// Nothing is selected at the end of the file.
    NothingSelected = "nothing-selected",
}

impl fmt::Display for FaultCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Why a line was not carried out. It knows the columns within the line, but not the file;
/// [`Diagnostic`] adds that.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Fault {
    /// Error or warning.
    pub severity: Severity,
    /// The kind of the fault.
    pub code: FaultCode,
    /// The fault, in words.
    pub message: String,
    /// How to correct it.
    pub help: Option<String>,
    /// The characters of the line that are wrong, counted from 0; `None` for the whole line.
    pub columns: Option<Range<usize>>,
}

impl Fault {
    /// An error with a message only.
    pub fn new(code: FaultCode, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, code, message: message.into(), help: None, columns: None }
    }

    /// The same fault as a warning.
    #[must_use]
    pub fn warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }

    /// Sets the help.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The fault of a part of a line that begins at this column.
    #[must_use]
    pub fn moved(mut self, column: usize) -> Self {
        self.columns = self.columns.map(|columns| columns.start + column..columns.end + column);
        self
    }

    /// Sets the columns.
    #[must_use]
    pub fn at(mut self, columns: Range<usize>) -> Self {
        self.columns = Some(columns);
        self
    }
}

/// The message alone.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

/// A fault or warning with its file and line.
///
/// ```
/// let (_, diagnostics) = superegg_lang::load_text("egg.scn", "primitive egg\nsetColor 1 0 2\n");
/// assert_eq!(diagnostics[0].code.as_str(), "out-of-range");
/// assert_eq!(
///     diagnostics[0].to_string(),
///     "egg.scn:2:14: error[out-of-range]: b of setColor must be from 0 to 1, not 2
///     | setColor 1 0 2
///     |              ^
///     = help: setColor r g b, for example: setColor 0.8 0.2 0.1"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// The kind of the fault.
    pub code: FaultCode,
    /// The file, as the user named it; empty for a line typed at the prompt, which is still on the
    /// screen.
    pub file: String,
    /// The line, counted from 1; `None` for the whole file.
    pub line: Option<usize>,
    /// The first wrong column, counted from 1.
    pub column: usize,
    /// The number of wrong characters, at least 1.
    pub width: usize,
    /// The text of the line; empty if it cannot be shown.
    pub excerpt: String,
    /// The fault, in words.
    pub message: String,
    /// How to correct it.
    pub help: Option<String>,
    /// The number of faults that this one stands for: 1, or more in the summary at the end of a file
    /// with many.
    pub count: usize,
}

/// The most faults of one file that are described one by one.
const MOST_DESCRIBED: usize = 100;
/// The most faults of a file and of all that it loads that are described one by one.
const MOST_DESCRIBED_IN_ALL: usize = 1000;

/// The faults of one file: the first ones, and the number of the others.
#[derive(Debug)]
pub(crate) struct FaultList<'a> {
    file: &'a str,
    described: usize,
    more_errors: usize,
    more_warnings: usize,
}

impl<'a> FaultList<'a> {
    pub(crate) fn new(file: &'a str) -> Self {
        Self { file, described: 0, more_errors: 0, more_warnings: 0 }
    }

    /// Adds a fault to `to`, or counts it if the file has many. `describe` is called only for a
    /// fault that is added.
    pub(crate) fn add(
        &mut self,
        to: &mut Vec<Diagnostic>,
        severity: Severity,
        describe: impl FnOnce() -> Diagnostic,
    ) {
        if self.has_room(to) {
            self.described += 1;
            to.push(describe());
            return;
        }
        match severity {
            Severity::Error => self.more_errors += 1,
            Severity::Warning => self.more_warnings += 1,
        }
    }

    /// Whether another fault is described, of a file with these diagnostics so far.
    fn has_room(&self, diagnostics: &[Diagnostic]) -> bool {
        self.described < MOST_DESCRIBED && diagnostics.len() < MOST_DESCRIBED_IN_ALL
    }

    /// Whether faults need suggestions, of a file with these diagnostics so far.
    pub(crate) fn suggestions(&self, diagnostics: &[Diagnostic]) -> Suggestions {
        if self.has_room(diagnostics) { Suggestions::Given } else { Suggestions::Omitted }
    }

    /// Adds the numbers of the faults that were not described.
    pub(crate) fn finish(self, to: &mut Vec<Diagnostic>) {
        let kinds = [
            (Severity::Error, self.more_errors, "error"),
            (Severity::Warning, self.more_warnings, "warning"),
        ];
        for (severity, count, kind) in kinds.into_iter().filter(|(_, count, _)| *count > 0) {
            let plural = if count == 1 { "" } else { "s" };
            let message = format!("{count} more {kind}{plural} in this file");
            let help = match self.described {
                0 => "the faults before are described; correct them first".to_owned(),
                described => format!("the first {described} are described; correct them first"),
            };
            let summary = Diagnostic::of_file(self.file, FaultCode::Many, message, help);
            to.push(Diagnostic { severity, count, ..summary });
        }
    }
}

/// Longer lines are not shown.
const LONGEST_EXCERPT: usize = 160;

impl Diagnostic {
    /// A fault in a line of a file.
    pub fn of_line(file: &str, line: usize, text: &str, fault: Fault) -> Self {
        let columns = fault.columns.unwrap_or_else(|| {
            let start = text.chars().take_while(|c| c.is_whitespace()).count();
            start..text.trim_end().chars().count()
        });
        let is_showable =
            text.chars().count() <= LONGEST_EXCERPT && !text.chars().any(|c| is_unseen(c) && c != '\t');
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
            count: 1,
        }
    }

    /// A warning about a whole file.
    pub fn of_file(file: &str, code: FaultCode, message: impl Into<String>, help: impl Into<String>) -> Self {
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
            count: 1,
        }
    }
}

/// `file:line:column: error[code]: message` (without the position if there is no file), the line
/// with the wrong characters marked, and the help.
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

impl std::error::Error for Diagnostic {}
