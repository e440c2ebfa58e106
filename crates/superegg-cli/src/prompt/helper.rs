//! Completion, hints and syntax highlighting of the line that is being edited.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use rustyline::completion::{Completer, Pair};
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::{Hint as RustylineHint, Hinter};
use rustyline::validate::Validator;
use rustyline::{Context, Helper};
use superegg_lang::{Paint, Session, complete, find_command, highlight, hint, is_unseen, split_commands};

use crate::files::folders::Folders;

/// The maximum length of a line with highlighting and hints, which run at every key.
const LONGEST_HIGHLIGHTED: usize = 500;

/// The helper of the editor, with a snapshot of the session.
pub(super) struct PromptHelper {
    pub(super) session: Session,
    /// Whether the line is the answer to a question, and no command.
    pub(super) is_asking: bool,
    folders: Folders,
}

impl PromptHelper {
    pub(super) fn new() -> Self {
        Self { session: Session::default(), is_asking: false, folders: Folders::of_user() }
    }

    /// The files that begin with `partial` and suit the command. Folders end in a slash.
    fn files(&self, command: &str, partial: &str) -> Vec<Pair> {
        let extensions: &[&str] = match find_command(command).map(|spec| spec.name) {
            Some("render") => &[".png", ".exr"],
            Some("cd" | "dir") => &[],
            _ => &[".scn"],
        };
        let is_wanted = |name: &str, is_folder: bool| {
            is_folder || extensions.iter().any(|extension| name.ends_with(extension))
        };
        let (folder, start) =
            partial.rsplit_once('/').map_or(("", partial), |(folder, start)| (folder, start));
        let folder = match (folder, partial.starts_with('/')) {
            ("", true) => Path::new("/").to_owned(),
            ("", false) => Path::new(".").to_owned(),
            _ => self.folders.expand(folder),
        };
        let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
        let prefix = &partial[..partial.len() - start.len()];
        let mut pairs: Vec<Pair> = entries
            .flatten()
            .filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path().is_dir())))
            .filter(|(name, is_folder)| {
                if name.contains(is_unseen) {
                    return false;
                }
                let is_hidden = name.starts_with('.') && !start.starts_with('.');
                name.starts_with(start) && !is_hidden && is_wanted(name, *is_folder)
            })
            .map(|(name, is_folder)| {
                let display = if is_folder { name + "/" } else { name };
                let completed = format!("{prefix}{display}");
                let needs_quotes = completed.contains(|c: char| c.is_whitespace() || c == '#');
                let replacement = match (needs_quotes, is_folder) {
                    (true, true) => format!("\"{completed}"),
                    (true, false) => format!("\"{completed}\""),
                    (false, _) => completed,
                };
                Pair { display, replacement }
            })
            .collect();
        pairs.sort_by(|a, b| a.display.cmp(&b.display));
        pairs
    }
}

impl Completer for PromptHelper {
    type Candidate = Pair;

    fn complete(&self, line: &str, cursor: usize, _: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        if self.is_asking {
            return Ok((cursor, Vec::new()));
        }
        // The line with the cursor, among pasted lines.
        let begin = line[..cursor].rfind('\n').map_or(0, |end| end + 1);
        let begin = begin + last_command(&line[begin..cursor]);
        let completion = complete(&self.session, &line[begin..cursor], cursor - begin);
        let mut pairs: Vec<Pair> = completion
            .candidates
            .into_iter()
            // No name controls the terminal; one that could cannot be typed either.
            .filter(|word| !word.contains(is_unseen))
            .map(|word| Pair { replacement: word.clone(), display: word })
            .collect();
        if let Some(partial) = &completion.file {
            let command = line[begin..cursor].split_whitespace().next().unwrap_or_default();
            pairs.extend(self.files(command, partial));
        }
        if let [only] = &mut pairs[..] {
            // The next word follows a complete one.
            if !only.replacement.ends_with('/') {
                only.replacement.push(' ');
            }
        }
        Ok((begin + completion.start, pairs))
    }
}

/// The hint after the cursor. Only its first `name_length` bytes, the rest of a command name, can
/// be accepted.
pub(super) struct LineHint {
    display: String,
    name_length: usize,
}

impl RustylineHint for LineHint {
    fn display(&self) -> &str {
        &self.display
    }

    fn completion(&self) -> Option<&str> {
        (self.name_length > 0).then(|| &self.display[..self.name_length])
    }
}

impl Hinter for PromptHelper {
    type Hint = LineHint;

    fn hint(&self, line: &str, cursor: usize, _: &Context<'_>) -> Option<LineHint> {
        if self.is_asking || cursor < line.len() || line.len() > LONGEST_HIGHLIGHTED || line.contains('\n') {
            return None;
        }
        let hint = hint(&self.session, &line[last_command(line)..])?;
        let name_length = hint.rest_of_name.len();
        Some(LineHint { display: hint.rest_of_name + &hint.arguments, name_length })
    }
}

impl Highlighter for PromptHelper {
    fn highlight<'l>(&self, line: &'l str, _: usize) -> Cow<'l, str> {
        if self.is_asking || line.len() > LONGEST_HIGHLIGHTED {
            return Cow::Borrowed(line);
        }
        let mut highlighted = String::with_capacity(line.len() + 64);
        for (i, line) in line.split('\n').enumerate() {
            if i > 0 {
                highlighted.push('\n');
            }
            let mut end = 0;
            for (range, paint) in highlight_commands(&self.session, line) {
                highlighted.push_str(&line[end..range.start]);
                highlighted.push_str(color(paint));
                highlighted.push_str(&line[range.clone()]);
                highlighted.push_str("\x1b[0m");
                end = range.end;
            }
            highlighted.push_str(&line[end..]);
        }
        Cow::Owned(highlighted)
    }

    fn highlight_prompt<'b, 's: 'b, 'p: 'b>(&'s self, prompt: &'p str, _: bool) -> Cow<'b, str> {
        Cow::Owned(format!("\x1b[1m{prompt}\x1b[0m"))
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        Cow::Owned(format!("\x1b[2m{hint}\x1b[0m"))
    }

    fn highlight_char(&self, line: &str, _: usize, kind: CmdKind) -> bool {
        kind != CmdKind::MoveCursor && line.len() <= LONGEST_HIGHLIGHTED
    }
}

/// The byte at which the last command of a line begins.
fn last_command(line: &str) -> usize {
    // A blank command would be left out.
    let typed = format!("{line}x");
    split_commands(&typed).last().map_or(0, |(_, command)| typed.len() - command.len())
}

/// The classified parts of all commands of a line.
fn highlight_commands(session: &Session, line: &str) -> Vec<(Range<usize>, Paint)> {
    let mut parts = Vec::new();
    for (_, command) in split_commands(line) {
        let start = command.as_ptr() as usize - line.as_ptr() as usize;
        let moved = |(range, paint): (Range<usize>, Paint)| (range.start + start..range.end + start, paint);
        parts.extend(highlight(session, command).into_iter().map(moved));
    }
    parts
}

/// The escape sequence of a token class.
fn color(paint: Paint) -> &'static str {
    match paint {
        Paint::Command => "\x1b[1;34m",
        Paint::Name => "\x1b[32m",
        Paint::Value => "\x1b[36m",
        Paint::Wrong => "\x1b[4;31m",
        Paint::Comment => "\x1b[2m",
    }
}

impl Validator for PromptHelper {}

impl Helper for PromptHelper {}
