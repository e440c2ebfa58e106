//! Files of commands.

use crate::diagnostic::{Diagnostic, Fault, FaultCode};
use crate::grammar::command::Request;
use crate::session::interpreter::{Effect, Session};

/// Whether to go on after a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// With the next line.
    Continue,
    /// No further.
    Stop,
}

/// What carries out the effects of a script's lines, and is told each line that went well. It may run another script into the same
/// diagnostics. A fault becomes the line's.
pub type Perform<'a> =
    dyn FnMut(&mut Session, &str, Effect, &mut Vec<Diagnostic>) -> Result<Flow, Fault> + 'a;

/// Runs the lines of a file. Every fault is reported and changes nothing; the good lines count. A byte order mark, CRLF and a missing
/// last newline are nothing.
pub fn run_script(
    session: &mut Session,
    file: &str,
    bytes: &[u8],
    diagnostics: &mut Vec<Diagnostic>,
    perform: &mut Perform<'_>,
) -> Flow {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let outcome = match std::str::from_utf8(line) {
            Ok(text) => session.run_line(text).and_then(|effect| perform(session, text, effect, diagnostics)),
            Err(error) => Err(not_text(line, error.valid_up_to())),
        };
        match outcome {
            Ok(Flow::Continue) => {}
            Ok(Flow::Stop) => return Flow::Stop,
            Err(fault) => {
                let text = String::from_utf8_lossy(line);
                diagnostics.push(Diagnostic::of_line(file, index + 1, &text, fault));
            }
        }
    }
    Flow::Continue
}

/// What is wrong with a line of bytes that is UTF-8 only so far.
pub fn not_text(line: &[u8], valid_up_to: usize) -> Fault {
    let column = String::from_utf8_lossy(&line[..valid_up_to]).chars().count();
    Fault::new(FaultCode::NotText, "this is not UTF-8 text")
        .help("scene files are plain text; save it as UTF-8")
        .at(column..column + 1)
}

/// Loads a text into a new session. What a line asks of the world outside (to read or write files) is not done.
pub fn load_text(file: &str, text: &str) -> (Session, Vec<Diagnostic>) {
    let mut session = Session::default();
    let mut diagnostics = Vec::new();
    run_script(&mut session, file, text.as_bytes(), &mut diagnostics, &mut |_, _, effect, _| {
        Ok(if effect == Effect::Request(Request::Stop) { Flow::Stop } else { Flow::Continue })
    });
    (session, diagnostics)
}
