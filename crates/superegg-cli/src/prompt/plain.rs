//! The prompt of a terminal that no line editor can serve: plain lines.

use std::io::{BufRead, Write, stdin, stdout};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};

use crate::console;
use crate::modeller::{Input, Modeller, Reply, console_reporter};
use crate::prompt::editor::ask;
use crate::prompt::prompt_text::prompt_text;

/// Reads and runs lines until the person leaves.
pub(super) fn run(scene: Option<&str>, interrupt: Arc<AtomicBool>) -> Result<()> {
    console::print(concat!(
        "Superegg ",
        env!("CARGO_PKG_VERSION"),
        ". 'help' shows the first steps, ctrl-d leaves."
    ))?;
    let mut modeller = Modeller::new(Input::Person, true, console_reporter(), interrupt);
    modeller.detach_viewer("the terminal is a plain one; 'superegg view SCENE' opens a window".to_owned());
    modeller.offer_recovery();
    // Nothing can be lost yet, so the first load needs no confirmation.
    let mut reply = scene.map_or(Reply::Continue, |scene| modeller.open(scene));
    while reply != Reply::Leave {
        let Some(line) = read_line(&prompt_text(&modeller))? else { break };
        reply = modeller.enter(&line);
        while let Reply::Ask(question) = &reply {
            let yes = ask(question, &mut |question| read_line(question).ok().flatten().unwrap_or_default());
            reply = modeller.answer(yes);
        }
    }
    modeller.leave()?;
    Ok(())
}

/// The next line; `None` at the end of the input.
fn read_line(prompt: &str) -> Result<Option<String>> {
    let mut output = stdout();
    write!(output, "{prompt}").and_then(|()| output.flush()).context("cannot write to the terminal")?;
    let mut line = Vec::new();
    let count = stdin().lock().read_until(b'\n', &mut line).context("cannot read from the terminal")?;
    let line = String::from_utf8_lossy(&line).trim_end_matches(['\r', '\n']).to_owned();
    Ok((count > 0).then_some(line))
}
