//! Shows a text that is longer than the screen in a pager.

use std::io::Write;
use std::process::{Command, Stdio};

use terminal_size::terminal_size;

/// The pagers where the user has chosen none.
const PAGERS: [&str; 2] = ["less", "more"];
/// The options of `less` where the user has chosen none: leave the text on the screen.
const LESS: &str = "FRX";
/// The exit code of a shell that does not find the program.
const NOT_FOUND: i32 = 127;

/// Shows a text in the pager of the environment (`PAGER`) if the screen is too small for it. Returns
/// false if the caller has to print it: it fits, or there is no pager.
pub(super) fn show(text: &str) -> bool {
    let Some((_, rows)) = terminal_size().filter(|_| cfg!(unix)) else { return false };
    // The prompt takes a line.
    if text.lines().count() < usize::from(rows.0) {
        return false;
    }
    match std::env::var("PAGER") {
        Ok(pager) if !pager.trim().is_empty() => show_in(&pager, text),
        Ok(_) | Err(_) => PAGERS.iter().any(|pager| show_in(pager, text)),
    }
}

/// Runs a pager, a command of the shell. Returns whether there is one.
fn show_in(pager: &str, text: &str) -> bool {
    let mut command = Command::new("sh");
    command.args(["-c", pager]).stdin(Stdio::piped());
    if std::env::var_os("LESS").is_none() {
        command.env("LESS", LESS);
    }
    let Ok(mut running) = command.spawn() else { return false };
    if let Some(mut input) = running.stdin.take() {
        // A pager that is left early reads no further.
        let _ = input.write_all(text.as_bytes()).and_then(|()| input.write_all(b"\n"));
    }
    running.wait().is_ok_and(|status| status.code() != Some(NOT_FOUND))
}
