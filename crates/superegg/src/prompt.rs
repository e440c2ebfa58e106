//! The prompt: lines typed by a person at a terminal.

mod helper;
#[cfg(unix)]
mod typed_ahead;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use rustyline::error::ReadlineError;
use rustyline::history::FileHistory;
use rustyline::{
    Cmd, ConditionalEventHandler, Config, Editor, Event, EventContext, EventHandler, ExternalPrinter,
    KeyEvent, RepeatCount,
};
use superegg_lang::Fault;

use crate::commands::Outcome;
use crate::modeller::{Input, LONGEST_LINE, Modeller, Reply, Said, Voice, visible};
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
    #[cfg(unix)]
    let _typed_ahead = typed_ahead::KeepTypedAhead::begin();
    let was_empty = Arc::new(AtomicBool::new(true));
    let mut editor = new_editor(&was_empty)?;
    let progress = Arc::new(Mutex::new(ProgressLine::default()));
    let voice = voice_of(&mut editor, &progress)?;
    let mut modeller = Modeller::new(Input::Person, true, voice, interrupt);
    let history = open_history(&mut editor, &modeller);

    say::out(concat!(
        "Superegg ",
        env!("CARGO_PKG_VERSION"),
        ". 'help' lists the commands, tab completes, ctrl-d leaves."
    ))?;
    modeller.offer_recovery();
    let mut reply = scene.map_or(Reply::Continue, |scene| modeller.open(scene));
    // Nothing is to be lost yet, so nothing is asked.
    while reply != Reply::Leave {
        if let Some(helper) = editor.helper_mut() {
            helper.session = modeller.session().clone();
        }
        ProgressLine::end(&progress);
        let typed = editor.readline(&prompt_text(&modeller));
        ProgressLine::end(&progress);
        match typed {
            Ok(text) => reply = enter(&mut modeller, &mut editor, &text, history.as_deref()),
            Err(ReadlineError::Interrupted) => {
                if was_empty.load(Ordering::Relaxed) && !modeller.stop_renders() {
                    say::out("ctrl-d leaves, and so does 'stop'")?;
                }
            }
            Err(ReadlineError::Eof) => reply = Reply::Leave,
            Err(error) => {
                // The terminal is gone: what was not saved stays in the journal.
                modeller.leave()?;
                return Err(error).context("cannot read from the terminal");
            }
        }
    }
    modeller.leave()?;
    Ok(Outcome::Fine)
}

/// Enters what was typed or pasted, line by line.
fn enter(
    modeller: &mut Modeller,
    editor: &mut PromptEditor,
    text: &str,
    history: Option<&std::path::Path>,
) -> Reply {
    let mut lines = text.lines();
    let mut reply = Reply::Continue;
    let mut is_remembered = false;
    for line in lines.by_ref() {
        is_remembered |= !line.trim().is_empty() && editor.add_history_entry(line).unwrap_or(false);
        if line.len() > LONGEST_LINE {
            let fault = Fault::new("too-long", format!("a line has {LONGEST_LINE} bytes at most"));
            modeller.refuse("", fault.help("is it a text at all?").at(0..1));
            continue;
        }
        reply = modeller.enter(line);
        if let Reply::Ask(question) = &reply {
            let yes = ask(editor, question);
            reply = modeller.answer(yes);
        }
        if reply != Reply::Continue {
            break;
        }
    }
    if let Some(history) = history.filter(|_| is_remembered) {
        // A history that cannot be kept is no reason to stop.
        let _ = editor.append_history(history);
    }
    reply
}

/// Asks a question whose answer is no unless it is yes.
fn ask(editor: &mut PromptEditor, question: &str) -> bool {
    let answer = editor.readline(&format!("{question} [y/N] "));
    answer.is_ok_and(|answer| ["y", "yes"].contains(&answer.trim().to_lowercase().as_str()))
}

fn new_editor(was_empty: &Arc<AtomicBool>) -> Result<PromptEditor> {
    let config = Config::builder()
        .max_history_size(LONGEST_HISTORY)
        .and_then(|config| config.history_ignore_dups(true))
        .context("cannot set up the prompt")?
        .auto_add_history(false)
        .completion_type(rustyline::CompletionType::List)
        .completion_prompt_limit(200)
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
    match modeller.place() {
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
