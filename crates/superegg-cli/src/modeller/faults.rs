//! Faults of requests that use files and folders.

use superegg_exchange::write::export::ExportError;
use superegg_lang::{Fault, FaultCode, parse_line};
use superegg_trace::LimitReached;

use crate::files::names::is_not_found;

/// Gives a fault without columns the columns of this argument, or of the command if there is no
/// such argument.
pub(super) fn at_argument(fault: Fault, line: &str, argument: usize) -> Fault {
    if fault.columns.is_some() {
        return fault;
    }
    let columns = parse_line(line).ok().flatten().map(|parsed| parsed.columns).unwrap_or_default();
    match columns.get(argument).or(columns.first()) {
        Some(columns) => fault.at(columns.clone()),
        None => fault,
    }
}

/// A folder cannot be read.
pub(super) fn unreadable(error: &anyhow::Error) -> Fault {
    Fault::new(FaultCode::Unreadable, format!("{error:#}"))
        .help("'dir' lists the working folder, 'cd' changes it")
}

/// A file cannot be written.
pub(super) fn unwritable(error: &anyhow::Error) -> Fault {
    Fault::new(FaultCode::Unwritable, format!("{error:#}"))
        .help("name a file in a folder that can be written to")
}

/// A scene cannot be exported: the format does not exist or cannot hold the scene, or the file cannot be written.
pub(super) fn not_exportable(error: &anyhow::Error) -> Fault {
    let unwritable = unwritable(error);
    match error.downcast_ref::<ExportError>() {
        Some(ExportError::Format { file, known }) => {
            Fault::new(FaultCode::Unwritable, format!("'{file}' names no format that can be written"))
                .help(format!("end the name in {known}"))
        }
        Some(_) => unwritable.help("change the scene, or export it in another format"),
        None => unwritable,
    }
}

/// A scene file cannot be read; `file` is `None` for the quicksave.
pub(super) fn not_loadable(error: &anyhow::Error, file: Option<&str>) -> Fault {
    let fault = Fault::new(FaultCode::Unreadable, format!("{error:#}"));
    fault.help(match file {
        None => "there is no quicksave yet: 'save' makes one, 'load FILE' loads a file",
        Some(_) if is_not_found(error) => "'dir' lists the working folder, 'pwd' prints its name",
        Some(_) => "name a scene file, a text of commands, that you may read",
    })
}

/// The user interrupted an inside-outside test.
pub(super) fn interrupted_test() -> Fault {
    Fault::new(FaultCode::Interrupted, "the test was interrupted")
        .help("reduce the recursion depth with 'setDepth'")
        .warning()
}

/// An exact answer needs more work than a prompt waits for.
pub(super) fn too_deep(error: LimitReached) -> Fault {
    Fault::new(FaultCode::OutOfRange, error.to_string()).help("reduce the recursion depth with 'setDepth'")
}

/// A file name in quotes if a line needs them.
pub(super) fn quoted(file: &str) -> String {
    if file.contains(|c: char| c.is_whitespace() || c == '#') {
        format!("\"{file}\"")
    } else {
        file.to_owned()
    }
}
