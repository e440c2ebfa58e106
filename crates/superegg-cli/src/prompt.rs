//! The prompt: reads lines from a person at a terminal and runs them.

mod editor;
mod helper;
mod pager;
mod plain;
mod prompt_text;
mod reporter;
#[cfg(unix)]
mod typed_ahead;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::{Context, Result};
use rustyline::error::ReadlineError;
use superegg_lang::is_unseen;
use superegg_viewer::Viewer;
use terminal_size::terminal_size;

use crate::console;
use crate::modeller::{Input, Modeller, Reply};
use crate::outcome::Outcome;
use crate::prompt::editor::{PromptEditor, confirm, new_editor, open_history};
use crate::prompt::prompt_text::prompt_text;
use crate::prompt::reporter::{ProgressLine, prompt_reporter};
use crate::system::terminal::has_cursor;

/// Runs the modeller at the terminal, with a scene or without. With `is_course` the viewer begins as
/// the course program does.
pub(crate) fn run(scene: Option<&str>, is_course: bool) -> Result<Outcome> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let signal = Arc::clone(&interrupt);
    // The line editor reads ctrl-c as a key; at other times ctrl-c interrupts the running command.
    ctrlc::set_handler(move || signal.store(true, Ordering::Relaxed)).context("cannot take over ctrl-c")?;
    let prompt = if has_cursor() { Prompt::new(Arc::clone(&interrupt)).ok() } else { None };
    let Some(mut prompt) = prompt else {
        plain::run(scene, interrupt)?;
        return Ok(Outcome::Fine);
    };
    prompt.modeller().use_kept_settings(is_course);
    match Viewer::new() {
        Ok(viewer) => run_beside_viewer(prompt, viewer, scene.map(str::to_owned))?,
        Err(error) => {
            prompt.modeller().detach_viewer(error.to_string());
            prompt.run(scene)?;
        }
    }
    Ok(Outcome::Fine)
}

/// Runs the prompt on a thread of its own, because windows need the main thread.
fn run_beside_viewer(mut prompt: Prompt, viewer: Viewer, scene: Option<String>) -> Result<()> {
    let handle = viewer.handle();
    let modeller = Arc::clone(&prompt.modeller);
    prompt.modeller().attach_viewer(handle.clone());
    let first = prompt.modeller().snapshot();
    let (events, from_viewer) = channel();
    let modeller_after_loss = Arc::clone(&modeller);
    std::thread::spawn(move || {
        for event in from_viewer {
            modeller.lock().unwrap_or_else(PoisonError::into_inner).handle_viewer_event(event);
        }
    });
    let (ended, result) = channel();
    std::thread::spawn(move || {
        let result = prompt.run(scene.as_deref());
        // Restore the terminal before anything else can end the process.
        drop(prompt);
        let _ = ended.send(result);
        handle.quit();
    });
    let result = Arc::new(Mutex::new(result));
    let result_after_loss = Arc::clone(&result);
    let wait = |result: &Mutex<Receiver<Result<()>>>| {
        let result = result.lock().unwrap_or_else(PoisonError::into_inner);
        // A thread that panicked has reported it.
        result.recv().unwrap_or(Ok(()))
    };
    viewer.run(Some(first), events, move || {
        let mut modeller = modeller_after_loss.lock().unwrap_or_else(PoisonError::into_inner);
        modeller.detach_viewer("its display has gone away".to_owned());
        drop(modeller);
        let is_fine = wait(&result_after_loss).is_ok();
        std::process::exit(i32::from(!is_fine));
    });
    wait(&result)
}

/// The line editor of a terminal and the session that it controls.
struct Prompt {
    editor: PromptEditor,
    /// Shared with the thread that handles viewer events.
    modeller: Arc<Mutex<Modeller>>,
    progress: Arc<Mutex<ProgressLine>>,
    /// Whether the line was empty at the last ctrl-c.
    was_empty: Arc<AtomicBool>,
    interrupt: Arc<AtomicBool>,
    /// The history file.
    history: Option<PathBuf>,
    #[cfg(unix)]
    _typed_ahead: typed_ahead::KeepTypedAhead,
}

impl Prompt {
    fn new(interrupt: Arc<AtomicBool>) -> Result<Self> {
        #[cfg(unix)]
        let typed_ahead = typed_ahead::KeepTypedAhead::begin();
        let was_empty = Arc::new(AtomicBool::new(true));
        let mut editor = new_editor(&was_empty)?;
        let progress = Arc::new(Mutex::new(ProgressLine::default()));
        let reporter = prompt_reporter(&mut editor, &progress)?;
        let modeller = Modeller::new(Input::Person, true, reporter, Arc::clone(&interrupt));
        let history = open_history(&mut editor, modeller.folders());
        Ok(Self {
            editor,
            modeller: Arc::new(Mutex::new(modeller)),
            progress,
            was_empty,
            interrupt,
            history,
            #[cfg(unix)]
            _typed_ahead: typed_ahead,
        })
    }

    fn modeller(&self) -> MutexGuard<'_, Modeller> {
        self.modeller.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads and runs lines until the person leaves.
    fn run(&mut self, scene: Option<&str>) -> Result<()> {
        console::print(concat!(
            "Superegg ",
            env!("CARGO_PKG_VERSION"),
            ". 'help' shows the first steps, tab completes, ctrl-d leaves."
        ))?;
        self.modeller().offer_recovery();
        // Nothing can be lost yet, so the first load needs no confirmation.
        let mut reply = scene.map_or(Reply::Continue, |scene| self.modeller().open(scene));
        while reply != Reply::Leave {
            let text = self.prepare_line();
            ProgressLine::end(&self.progress);
            let typed = self.editor.readline(&text);
            ProgressLine::end(&self.progress);
            match typed {
                Ok(text) => reply = self.enter(&text),
                Err(ReadlineError::Interrupted) => {
                    if self.was_empty.load(Ordering::Relaxed) && !self.modeller().stop_renders() {
                        console::print("ctrl-d leaves, and so does 'stop'")?;
                    }
                }
                Err(ReadlineError::Eof) => reply = Reply::Leave,
                Err(error) => {
                    // The terminal is closed: unsaved changes stay in the journal.
                    self.modeller().leave()?;
                    return Err(error).context("cannot read from the terminal");
                }
            }
        }
        self.modeller().leave()?;
        Ok(())
    }

    /// Updates the history and the completion before a line is read. Returns the prompt text.
    fn prepare_line(&mut self) -> String {
        let (session, text) = {
            let mut modeller = self.modeller();
            if let Some((width, _)) = terminal_size() {
                modeller.set_columns(width.0);
            }
            (modeller.session().clone(), prompt_text(&modeller))
        };
        let from_viewer = self.modeller().drain_viewer_lines();
        // A name of the scene could control the terminal when its line is shown again.
        for line in from_viewer.into_iter().filter(|line| !line.contains(is_unseen)) {
            // The editor drops a line that repeats the previous one.
            let _ = self.editor.add_history_entry(line);
        }
        if let Some(helper) = self.editor.helper_mut() {
            helper.session = session;
        }
        text
    }

    /// Runs typed or pasted text line by line.
    fn enter(&mut self, text: &str) -> Reply {
        let mut is_remembered = false;
        let mut reply = Reply::Continue;
        for line in text.lines() {
            is_remembered |= !line.trim().is_empty() && self.editor.add_history_entry(line).unwrap_or(false);
            reply = self.modeller().enter(line);
            while let Reply::Ask(question) = &reply {
                let yes = confirm(&mut self.editor, question);
                reply = self.modeller().answer(yes);
            }
            // Ctrl-c also drops the rest of pasted lines.
            if reply != Reply::Continue || self.interrupt.load(Ordering::Relaxed) {
                break;
            }
        }
        if let Some(history) = self.history.as_ref().filter(|_| is_remembered) {
            // The session continues without a history file.
            let _ = self.editor.append_history(history);
        }
        reply
    }
}
