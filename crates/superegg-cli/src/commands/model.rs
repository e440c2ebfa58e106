//! `superegg` and `superegg SCENE`: the modeller at a prompt, or on the lines of a pipe.

use std::io::{self, BufRead, IsTerminal, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, bail};

use crate::args::no_such_command;
use crate::commands::Outcome;
use crate::modeller::{Input, LONGEST_LINE, Modeller, Reply, Said, Voice, visible};
use crate::{prompt, say};

pub(crate) fn run(scene: Option<&Path>) -> Result<Outcome> {
    let scene =
        scene.map(|scene| scene.to_str().context("the name of the scene is not UTF-8")).transpose()?;
    if let Some(told) = scene.and_then(no_such_command) {
        bail!(told);
    }
    if io::stdin().is_terminal() && io::stdout().is_terminal() {
        return prompt::run(scene);
    }
    run_lines(&mut io::stdin().lock(), "<stdin>", scene, true)
}

/// Takes lines until there are no more.
pub(crate) fn run_lines(
    input: &mut dyn BufRead,
    name: &str,
    scene: Option<&str>,
    is_journaled: bool,
) -> Result<Outcome> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let mut modeller = Modeller::new(Input::Lines(name.to_owned()), is_journaled, plain_voice(), interrupt);
    let mut reply = scene.map_or(Reply::Continue, |scene| modeller.open(scene));
    let mut is_first = true;
    while reply == Reply::Continue {
        let Some(line) = read_line(input).with_context(|| format!("cannot read '{name}'"))? else { break };
        reply = take(&mut modeller, &line, is_first);
        is_first = false;
    }
    Ok(if modeller.leave()? { Outcome::ErrorsInInput } else { Outcome::Fine })
}

/// Answers go to standard output, complaints to standard error.
pub(crate) fn plain_voice() -> Voice {
    Arc::new(|said| {
        match said {
            Said::Progress(_) => {}
            Said::Text(line) => say::out(line)?,
            Said::Done(line) => say::out(visible(&line))?,
            Said::Complaint(line) => say::complain(line),
            Said::Failed(line) => say::complain(visible(&format!("superegg: {line}"))),
        }
        Ok(())
    })
}

/// A line of bytes, which may be no line at all.
fn take(modeller: &mut Modeller, line: &[u8], is_first: bool) -> Reply {
    let line = if is_first { line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line) } else { line };
    match std::str::from_utf8(line) {
        Ok(line) => modeller.enter(line),
        // Cut off where it was too long: in the middle of a character, perhaps.
        Err(_) if line.len() > LONGEST_LINE => modeller.enter(&String::from_utf8_lossy(line)),
        Err(error) => {
            let fault = superegg_lang::not_text(line, error.valid_up_to());
            modeller.refuse(&String::from_utf8_lossy(line), fault);
            Reply::Continue
        }
    }
}

/// The next line without its end. Of one that is too long only the beginning is kept.
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
