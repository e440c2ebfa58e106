//! Scene files: lines of commands.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, Fault, FaultCode, FaultList, Severity};
use crate::grammar::command::Request;
use crate::parse::commands::split_commands;
use crate::session::interpreter::{Effect, Session};
use crate::session::pictures::may_name_picture;

/// Whether to continue after a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Go on with the next line.
    Continue,
    /// Ignore the rest of the file.
    Stop,
}

/// Called with each line that succeeded and its effect, to carry the effect out. It may run another
/// script with the same diagnostics. A fault that it returns is reported for the line; an error about a picture that the line
/// names takes back what the line changed.
pub type Perform<'a> =
    dyn FnMut(&mut Session, &str, Effect, &mut Vec<Diagnostic>) -> Result<Flow, Fault> + 'a;

/// Runs the lines of a file. A line with a fault is reported and changes nothing; the other lines
/// take effect. A line that is no command may be several with `;` between. The first hundred faults of a file are described, the others counted. A
/// byte order mark, CRLF line ends and a missing last newline are allowed.
pub fn run_script(
    session: &mut Session,
    file: &str,
    bytes: &[u8],
    diagnostics: &mut Vec<Diagnostic>,
    perform: &mut Perform<'_>,
) -> Flow {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut faults = FaultList::new(file);
    let mut flow = Flow::Continue;
    let suggestions_before = session.suggestions;
    session.suggestions = faults.suggestions(diagnostics);
    // It is faster to check all lines at once.
    let text = std::str::from_utf8(bytes).ok();
    for (index, range) in lines(bytes).enumerate() {
        let line = &bytes[range.clone()];
        let checked = text.and_then(|text| text.get(range)).map_or_else(|| std::str::from_utf8(line), Ok);
        let outcome = match checked {
            Ok(text) => run_line(session, text, diagnostics, perform),
            Err(error) => Err(not_text(line, error.valid_up_to())),
        };
        match outcome {
            Ok(Flow::Continue) => {}
            Ok(Flow::Stop) => {
                flow = Flow::Stop;
                break;
            }
            Err(fault) => {
                faults.add(diagnostics, fault.severity, || {
                    Diagnostic::of_line(file, index + 1, &String::from_utf8_lossy(line), fault)
                });
                session.suggestions = faults.suggestions(diagnostics);
            }
        }
    }
    session.suggestions = suggestions_before;
    faults.finish(diagnostics);
    flow
}

/// Runs a line. One that is no command may be several.
fn run_line(
    session: &mut Session,
    line: &str,
    diagnostics: &mut Vec<Diagnostic>,
    perform: &mut Perform<'_>,
) -> Result<Flow, Fault> {
    let before = may_name_picture(line).then(|| session.clone());
    let fault = match session.run_line(line) {
        Ok(effect) => {
            let performed = perform(session, line, effect, diagnostics);
            if let (Err(Fault { severity: Severity::Error, .. }), Some(before)) = (&performed, before) {
                *session = before;
            }
            return performed;
        }
        Err(fault) => fault,
    };
    let commands = if line.contains(';') { split_commands(line) } else { Vec::new() };
    if commands.iter().all(|(_, command)| command.len() == line.len()) {
        return Err(fault);
    }
    for (column, command) in commands {
        let done = run_line(session, command, diagnostics, perform).map_err(|fault| fault.moved(column))?;
        if done == Flow::Stop {
            return Ok(Flow::Stop);
        }
    }
    Ok(Flow::Continue)
}

/// The lines of a text, without their ends. Text after the last end is a line, too.
fn lines(bytes: &[u8]) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    let ends = memchr::memchr_iter(b'\n', bytes).chain([bytes.len()]);
    ends.map(move |end| {
        let line = start..end;
        start = end + 1;
        line
    })
}

/// The fault of a line that is valid UTF-8 only up to a byte.
pub fn not_text(line: &[u8], valid_up_to: usize) -> Fault {
    let column = String::from_utf8_lossy(&line[..valid_up_to]).chars().count();
    Fault::new(FaultCode::NotText, "this is not UTF-8 text")
        .help("scene files are plain text; save it as UTF-8")
        .at(column..column + 1)
}

/// Loads a text into a new session. Requests (such as reading or writing files) are ignored, except
/// `stop`.
pub fn load_text(file: &str, text: &str) -> (Session, Vec<Diagnostic>) {
    let mut session = Session::default();
    let mut diagnostics = Vec::new();
    run_script(&mut session, file, text.as_bytes(), &mut diagnostics, &mut |_, _, effect, _| {
        Ok(if effect == Effect::Request(Request::Stop) { Flow::Stop } else { Flow::Continue })
    });
    (session, diagnostics)
}
