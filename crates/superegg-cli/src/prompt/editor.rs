//! The line editor: configuration, keys, history and questions.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};
use rustyline::history::FileHistory;
use rustyline::{
    Cmd, ColorMode, CompletionType, ConditionalEventHandler, Config, Editor, Event, EventContext,
    EventHandler, KeyEvent, RepeatCount,
};

use crate::console;
use crate::files::folders::Folders;
use crate::prompt::helper::PromptHelper;

/// The maximum number of lines in the history.
const MOST_HISTORY: usize = 10_000;
/// More completions than this need a confirmation.
const MOST_COMPLETIONS: usize = 200;

pub(super) type PromptEditor = Editor<PromptHelper, FileHistory>;

/// A line editor. At ctrl-c it stores in `was_empty` whether the line is empty.
pub(super) fn new_editor(was_empty: &Arc<AtomicBool>) -> Result<PromptEditor> {
    let config = Config::builder()
        .max_history_size(MOST_HISTORY)
        .and_then(|config| config.history_ignore_dups(true))
        .context("cannot set up the prompt")?
        .auto_add_history(false)
        .completion_type(CompletionType::List)
        .completion_prompt_limit(MOST_COMPLETIONS)
        .completion_show_all_if_ambiguous(true)
        .bracketed_paste(true)
        .color_mode(color_mode())
        .build();
    let mut editor = PromptEditor::with_config(config).context("cannot set up the prompt")?;
    editor.set_helper(Some(PromptHelper::new()));
    let handler = InterruptHandler(Arc::clone(was_empty));
    editor.bind_sequence(Event::from(KeyEvent::ctrl('C')), EventHandler::Conditional(Box::new(handler)));
    Ok(editor)
}

/// No colours if the user or the terminal does not want them.
fn color_mode() -> ColorMode {
    if console::paints_output() { ColorMode::Forced } else { ColorMode::Disabled }
}

/// Stores whether the line was empty at ctrl-c: it stops renders then, and otherwise clears the
/// line.
struct InterruptHandler(Arc<AtomicBool>);

impl ConditionalEventHandler for InterruptHandler {
    fn handle(&self, _: &Event, _: RepeatCount, _: bool, context: &EventContext<'_>) -> Option<Cmd> {
        /// Erases what is behind the cursor.
        const ERASE: &[u8] = b"\x1b[J";
        self.0.store(context.line().is_empty(), Ordering::Relaxed);
        // A hint stands behind the end of the line, and would stay on the screen.
        if context.pos() == context.line().len() {
            let mut output = std::io::stdout();
            let _ = output.write_all(ERASE).and_then(|()| output.flush());
        }
        Some(Cmd::Interrupt)
    }
}

/// Loads the history of earlier sessions and returns the path of its file.
pub(super) fn open_history(editor: &mut PromptEditor, folders: &Folders) -> Option<PathBuf> {
    let state = folders.state.clone()?;
    std::fs::create_dir_all(&state).ok()?;
    let path = state.join("history");
    // The file does not exist at the first start.
    let _ = editor.load_history(&path);
    Some(path)
}

/// Repeats a yes-or-no question until it is answered. An empty line and ctrl-c mean no.
pub(super) fn confirm(editor: &mut PromptEditor, question: &str) -> bool {
    set_asking(editor, true);
    let answer = ask(question, &mut |question| editor.readline(question).unwrap_or_default());
    set_asking(editor, false);
    answer
}

/// Without commands there is nothing to complete, to hint at or to paint.
fn set_asking(editor: &mut PromptEditor, is_asking: bool) {
    if let Some(helper) = editor.helper_mut() {
        helper.is_asking = is_asking;
    }
}

/// Repeats a yes-or-no question until `read` returns an answer to it. An empty answer means no.
pub(super) fn ask(question: &str, read: &mut dyn FnMut(&str) -> String) -> bool {
    let mut question = format!("{question} [y/N] ");
    loop {
        match read(&question).trim().to_lowercase().as_str() {
            "y" | "yes" => return true,
            "" | "n" | "no" => return false,
            _ => question = "y or n? ".to_owned(),
        }
    }
}
