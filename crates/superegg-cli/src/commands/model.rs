//! `superegg` and `superegg SCENE`: the modeller at a prompt, or on the lines of a pipe.

use std::io::{self, BufRead, IsTerminal, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, bail};
use superegg_lang::not_text;

use crate::args::unknown_command;
use crate::modeller::{Input, LONGEST_LINE, Modeller, Reply, console_reporter};
use crate::outcome::Outcome;
use crate::prompt;

const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

pub(crate) fn run(scene: Option<&Path>, is_course: bool) -> Result<Outcome> {
    let scene =
        scene.map(|scene| scene.to_str().context("the name of the scene is not UTF-8")).transpose()?;
    if let Some(error) = scene.and_then(unknown_command) {
        bail!(error);
    }
    if io::stdin().is_terminal() && io::stdout().is_terminal() {
        return prompt::run(scene, is_course);
    }
    let source = Input::Lines { name: "<stdin>".to_owned(), is_file: false };
    run_lines(&mut io::stdin().lock(), source, scene, true)
}

/// Runs a session on the lines of `input`.
///
/// # Errors
/// The input cannot be read, or standard output cannot be written.
pub(crate) fn run_lines(
    input: &mut dyn BufRead,
    source: Input,
    scene: Option<&str>,
    is_journaled: bool,
) -> Result<Outcome> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let mut modeller = Modeller::new(source, is_journaled, console_reporter(), interrupt);
    let mut reply = scene.map_or(Reply::Continue, |scene| modeller.open(scene));
    let mut is_first = true;
    while reply == Reply::Continue {
        let Some(line) = read_line(input).context("cannot read the input")? else { break };
        reply = enter_bytes(&mut modeller, &line, is_first);
        is_first = false;
    }
    Ok(Outcome::of_input(modeller.leave()?))
}

/// Runs a line of bytes, or rejects it if it is not UTF-8.
fn enter_bytes(modeller: &mut Modeller, line: &[u8], is_first: bool) -> Reply {
    let line = if is_first { line.strip_prefix(UTF8_MARK).unwrap_or(line) } else { line };
    match std::str::from_utf8(line) {
        Ok(line) => modeller.enter(line),
        // A line that is too long may have been cut within a character.
        Err(_) if line.len() > LONGEST_LINE => modeller.enter(&String::from_utf8_lossy(line)),
        Err(error) => {
            modeller.reject(&String::from_utf8_lossy(line), not_text(line, error.valid_up_to()));
            Reply::Continue
        }
    }
}

/// The next line without its line break. A line that is too long is cut after [`LONGEST_LINE`] + 1
/// bytes.
fn read_line(input: &mut dyn BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    let most = LONGEST_LINE as u64 + 1;
    if (&mut *input).take(most).read_until(b'\n', &mut line)? == 0 {
        return Ok(None);
    }
    if line.last() == Some(&b'\n') {
        line.pop();
    } else if line.len() as u64 == most {
        input.skip_until(b'\n')?;
    }
    Ok(Some(line))
}
