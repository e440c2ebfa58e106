//! The prompt: lines typed by a person at a terminal.

mod helper;
#[cfg(unix)]
mod typed_ahead;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::{Context, Result};
use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{
    Cmd, ConditionalEventHandler, Config, Editor, Event, EventContext, EventHandler, ExternalPrinter,
    KeyEvent, RepeatCount,
};

use superegg_viewer::Viewer;

use crate::commands::Outcome;
use crate::modeller::{Input, Modeller, Reply, Said, Voice, visible};
use crate::prompt::helper::PromptHelper;
use crate::say;

/// Lines that are remembered over sessions.
const LONGEST_HISTORY: usize = 10_000;
/// Longer names are cut in the prompt.
const LONGEST_NAME: usize = 24;

type PromptEditor = Editor<PromptHelper, FileHistory>;

/// Opens the modeller at the terminal, with a scene or without.
pub(crate) fn run(scene: Option<&str>) -> Result<Outcome> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let signal = Arc::clone(&interrupt);
    // While a line is edited ctrl-c is a key; at other times it breaks off what runs.
    ctrlc::set_handler(move || signal.store(true, Ordering::Relaxed)).context("cannot take over ctrl-c")?;
    let mut prompt = Prompt::new(interrupt)?;
    match Viewer::new() {
        Ok(viewer) => beside_viewer(prompt, viewer, scene.map(str::to_owned))?,
        Err(why) => {
            prompt.modeller().do_without_viewer(why.to_string());
            prompt.converse(scene)?;
        }
    }
    Ok(Outcome::Fine)
}

/// The conversation on a thread of its own: windows want the main one.
fn beside_viewer(mut prompt: Prompt, viewer: Viewer, scene: Option<String>) -> Result<()> {
    let handle = viewer.handle();
    let modeller = Arc::clone(&prompt.modeller);
    prompt.modeller().attach_viewer(handle.clone());
    let first = prompt.modeller().shown();
    let (out, from_viewer) = channel();
    let modeller_after_loss = Arc::clone(&modeller);
    std::thread::spawn(move || {
        for said in from_viewer {
            modeller.lock().unwrap_or_else(PoisonError::into_inner).take_from_viewer(said);
        }
    });
    let (ended, conversation) = channel();
    std::thread::spawn(move || {
        let result = prompt.converse(scene.as_deref());
        // The terminal is put back before anything else can end the process.
        drop(prompt);
        let _ = ended.send(result);
        handle.quit();
    });
    let conversation = Arc::new(Mutex::new(conversation));
    let end = Arc::clone(&conversation);
    let result_of = |conversation: &Mutex<Receiver<Result<()>>>| {
        let conversation = conversation.lock().unwrap_or_else(PoisonError::into_inner);
        // A conversation that panicked has told of it.
        conversation.recv().unwrap_or(Ok(()))
    };
    viewer.run(Some(first), out, move || {
        let mut modeller = modeller_after_loss.lock().unwrap_or_else(PoisonError::into_inner);
        modeller.do_without_viewer("its display has gone away".to_owned());
        drop(modeller);
        let is_fine = result_of(&end).is_ok();
        std::process::exit(i32::from(!is_fine));
    });
    result_of(&conversation)
}

/// A terminal with a person at it, and the session that they talk to.
struct Prompt {
    editor: PromptEditor,
    /// Shared with whatever else enters lines.
    modeller: Arc<Mutex<Modeller>>,
    progress: Arc<Mutex<ProgressLine>>,
    /// Whether the last ctrl-c met an empty line.
    was_empty: Arc<AtomicBool>,
    interrupt: Arc<AtomicBool>,
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
        let voice = voice_of(&mut editor, &progress)?;
        let modeller = Modeller::new(Input::Person, true, voice, Arc::clone(&interrupt));
        let history = open_history(&mut editor, &modeller);
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

    /// Takes lines until the person leaves.
    fn converse(&mut self, scene: Option<&str>) -> Result<()> {
        say::out(concat!(
            "Superegg ",
            env!("CARGO_PKG_VERSION"),
            ". 'help' lists the commands, tab completes, ctrl-d leaves."
        ))?;
        self.modeller().offer_recovery();
        // Nothing is to be lost yet, so nothing is asked.
        let mut reply = scene.map_or(Reply::Continue, |scene| self.modeller().open(scene));
        while reply != Reply::Leave {
            let (session, text) = {
                let modeller = self.modeller();
                (modeller.session().clone(), prompt_text(&modeller))
            };
            let from_viewer = self.modeller().drain_viewer_lines();
            for line in from_viewer {
                // A line that repeats the one before is left out.
                let _ = self.editor.add_history_entry(line);
            }
            if let Some(helper) = self.editor.helper_mut() {
                helper.session = session;
            }
            ProgressLine::end(&self.progress);
            let typed = self.editor.readline(&text);
            ProgressLine::end(&self.progress);
            match typed {
                Ok(text) => reply = self.enter(&text),
                Err(ReadlineError::Interrupted) => {
                    if self.was_empty.load(Ordering::Relaxed) && !self.modeller().stop_renders() {
                        say::out("ctrl-d leaves, and so does 'stop'")?;
                    }
                }
                Err(ReadlineError::Eof) => reply = Reply::Leave,
                Err(error) => {
                    // The terminal is gone: what was not saved stays in the journal.
                    self.modeller().leave()?;
                    return Err(error).context("cannot read from the terminal");
                }
            }
        }
        self.modeller().leave()?;
        Ok(())
    }

    /// Enters what was typed or pasted, line by line.
    fn enter(&mut self, text: &str) -> Reply {
        let mut is_remembered = false;
        let mut reply = Reply::Continue;
        for line in text.lines() {
            is_remembered |= !line.trim().is_empty() && self.editor.add_history_entry(line).unwrap_or(false);
            reply = self.modeller().enter(line);
            if let Reply::Ask(question) = &reply {
                let yes = ask(&mut self.editor, question);
                reply = self.modeller().answer(yes);
            }
            // Ctrl-c breaks off the rest of what was pasted too.
            if reply != Reply::Continue || self.interrupt.load(Ordering::Relaxed) {
                break;
            }
        }
        if let Some(history) = self.history.as_ref().filter(|_| is_remembered) {
            // A history that cannot be kept is no reason to stop.
            let _ = self.editor.append_history(history);
        }
        reply
    }
}

/// Asks a question until it is answered. Nothing typed, or ctrl-c, is no.
fn ask(editor: &mut PromptEditor, question: &str) -> bool {
    let mut question = format!("{question} [y/N] ");
    loop {
        let answer = editor.readline(&question).unwrap_or_default();
        match answer.trim().to_lowercase().as_str() {
            "y" | "yes" => return true,
            "" | "n" | "no" => return false,
            _ => question = "y or n? ".to_owned(),
        }
    }
}

fn new_editor(was_empty: &Arc<AtomicBool>) -> Result<PromptEditor> {
    let config = Config::builder()
        .max_history_size(LONGEST_HISTORY)
        .and_then(|config| config.history_ignore_dups(true))
        .context("cannot set up the prompt")?
        .auto_add_history(false)
        .completion_type(rustyline::CompletionType::List)
        .completion_prompt_limit(200)
        .completion_show_all_if_ambiguous(true)
        .bracketed_paste(true)
        .color_mode(color_mode())
        .build();
    let mut editor = PromptEditor::with_config(config).context("cannot set up the prompt")?;
    editor.set_helper(Some(PromptHelper::new()));
    let watch = WatchInterrupt(Arc::clone(was_empty));
    editor.bind_sequence(Event::from(KeyEvent::ctrl('C')), EventHandler::Conditional(Box::new(watch)));
    Ok(editor)
}

/// No colours where the user or the terminal does not want them (no-color.org).
fn color_mode() -> rustyline::ColorMode {
    let is_unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
        || std::env::var_os("TERM").is_some_and(|term| term == "dumb")
        || !std::io::stdout().is_terminal();
    if is_unwanted { rustyline::ColorMode::Disabled } else { rustyline::ColorMode::Enabled }
}

/// Sees whether ctrl-c met an empty line, where it stops what runs, or one that it only clears.
struct WatchInterrupt(Arc<AtomicBool>);

impl ConditionalEventHandler for WatchInterrupt {
    fn handle(&self, _: &Event, _: RepeatCount, _: bool, context: &EventContext<'_>) -> Option<Cmd> {
        self.0.store(context.line().is_empty(), Ordering::Relaxed);
        Some(Cmd::Interrupt)
    }
}

/// Reads the history of earlier sessions, and returns where it is kept.
fn open_history(editor: &mut PromptEditor, modeller: &Modeller) -> Option<PathBuf> {
    let state = modeller.folders().state.clone()?;
    std::fs::create_dir_all(&state).ok()?;
    let path = state.join("history");
    // There is none at the first start.
    let _ = editor.load_history(&path);
    Some(path)
}

/// What is selected and the child at its cursor: `snowman[head]> `.
fn prompt_text(modeller: &Modeller) -> String {
    let selection = modeller.session().selection();
    match (selection.selected, selection.cursor()) {
        (None, _) => "superegg> ".to_owned(),
        (Some(name), None) => format!("{}> ", shown_name(name)),
        (Some(name), Some(cursor)) => format!("{}[{}]> ", shown_name(name), shown_name(cursor)),
    }
}

fn shown_name(name: &str) -> String {
    let mut shown: String = name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
    if name.chars().nth(LONGEST_NAME).is_some() {
        shown.push('…');
    }
    shown
}

/// Whether the line above the prompt is one of progress, which the next may take the place of.
#[derive(Default)]
struct ProgressLine {
    is_above: bool,
}

impl ProgressLine {
    /// Something else has been printed.
    fn end(line: &Mutex<Self>) {
        line.lock().unwrap_or_else(PoisonError::into_inner).is_above = false;
    }
}

/// Says things above the line that is being typed, if one is.
fn voice_of(editor: &mut PromptEditor, progress: &Arc<Mutex<ProgressLine>>) -> Result<Voice> {
    const OVER_LINE_ABOVE: &str = "\x1b[1A\r\x1b[2K";
    let printer = Mutex::new(editor.create_external_printer().context("cannot set up the prompt")?);
    let progress = Arc::clone(progress);
    Ok(Arc::new(move |said| {
        let (text, is_progress) = match said {
            Said::Text(text) | Said::Complaint(text) => (text, false),
            Said::Done(text) => (visible(&text), false),
            Said::Progress(text) => (visible(&text), true),
            Said::Failed(text) => (visible(&format!("superegg: {text}")), false),
        };
        let mut line = progress.lock().unwrap_or_else(PoisonError::into_inner);
        let over = if line.is_above { OVER_LINE_ABOVE } else { "" };
        line.is_above = is_progress;
        let mut printer = printer.lock().unwrap_or_else(PoisonError::into_inner);
        printer.print(format!("{over}{text}\n")).context("cannot write to the terminal")
    }))
}
