//! Prints messages above the line that is being edited.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use rustyline::ExternalPrinter;
use superegg_lang::visible;

use crate::console;
use crate::modeller::{Message, Reporter};
use crate::prompt::editor::PromptEditor;
use crate::prompt::pager;

/// Whether the line above the prompt is a progress message, which the next message replaces.
#[derive(Default)]
pub(super) struct ProgressLine {
    is_above: bool,
}

impl ProgressLine {
    /// Other output follows: the progress message stays.
    pub(super) fn end(line: &Mutex<Self>) {
        line.lock().unwrap_or_else(PoisonError::into_inner).is_above = false;
    }
}

/// A reporter that prints above the line that is being edited.
pub(super) fn prompt_reporter(
    editor: &mut PromptEditor,
    progress: &Arc<Mutex<ProgressLine>>,
) -> Result<Reporter> {
    /// Moves the cursor up by one line and erases that line.
    const ERASE_LINE_ABOVE: &str = "\x1b[1A\r\x1b[2K";
    let printer = Mutex::new(editor.create_external_printer().context("cannot set up the prompt")?);
    let progress = Arc::clone(progress);
    let paints = console::paints_output();
    Ok(Arc::new(move |message| {
        let (text, is_progress) = match message {
            Message::Page(text) if pager::show(&text) => return Ok(()),
            Message::Text(text) | Message::Page(text) => (text, false),
            Message::Diagnostic(text) if paints => (console::painted(&text), false),
            Message::Diagnostic(text) => (text, false),
            Message::Done(text) => (visible(&text), false),
            Message::Progress(text) => (visible(&text), true),
            Message::Failed(text) => (visible(&format!("superegg: {text}")), false),
        };
        let mut line = progress.lock().unwrap_or_else(PoisonError::into_inner);
        let erase = if line.is_above { ERASE_LINE_ABOVE } else { "" };
        line.is_above = is_progress;
        let mut printer = printer.lock().unwrap_or_else(PoisonError::into_inner);
        printer.print(format!("{erase}{text}\n")).context("cannot write to the terminal")
    }))
}
