//! A text that is edited: its errors, and help at a cursor. The language's own functions answer; this file only knows
//! where in the text the cursor is.
//!
//! Lines are counted from 0, columns in UTF-16 units, as editors in JavaScript count.

use std::ops::Range;

use serde::Serialize;
use superegg_lang::{
    Hint, Paint, Session, complete, find_command, help, highlight, hint, lint, split_commands,
};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::answers::json;
use crate::exponents;
use crate::file::run_text;
use crate::findings::{Finding, findings};
use crate::text::units;

/// The columns that help is broken at.
const HELP_COLUMNS: u16 = 64;

/// A text with the session that its lines make.
#[wasm_bindgen]
pub struct Document {
    text: String,
    session: Session,
    findings: Vec<Finding>,
}

#[derive(Serialize)]
struct Completions {
    /// The column from which the word is replaced.
    from: usize,
    words: Vec<Word>,
}

#[derive(Serialize)]
struct Word {
    word: String,
    /// The arguments of a command.
    detail: String,
    /// The effect of a command.
    info: &'static str,
}

#[wasm_bindgen]
impl Document {
    /// Runs a text.
    #[wasm_bindgen(constructor)]
    pub fn new(text: &str) -> Self {
        let mut session = Session::default();
        let mut diagnostics = run_text(&mut session, text);
        diagnostics.extend(lint(&session, "scene"));
        let findings = findings(diagnostics, text);
        Self { text: text.to_owned(), session, findings }
    }

    /// The errors and warnings, as JSON.
    pub fn findings(&self) -> String {
        json(&self.findings)
    }

    /// The session before a line.
    fn session_before(&self, line: usize) -> Session {
        let start = match line.checked_sub(1) {
            Some(before) => {
                self.text.match_indices('\n').nth(before).map_or(self.text.len(), |(at, _)| at + 1)
            }
            None => 0,
        };
        let mut session = Session::default();
        // The errors of these lines are already known.
        drop(run_text(&mut session, &self.text[..start]));
        session
    }

    /// The words that fit at the end of `before`, the part of a line before the cursor, as JSON.
    pub fn complete(&self, line: usize, before: &str) -> String {
        let session = self.session_before(line);
        let found = complete(&session, before, before.len());
        let is_command = words_before(before) == 0;
        let words = found.candidates.into_iter().map(|word| {
            let spec = find_command(&word).filter(|_| is_command);
            let (detail, info) = spec.map_or((String::new(), ""), |spec| (spec.usage(), spec.summary));
            Word { word, detail, info }
        });
        json(&Completions { from: units(&before[..found.start]), words: words.collect() })
    }

    /// The arguments that are still to come after `before`, as text; `None` if there are none.
    pub fn hint(&self, line: usize, before: &str) -> Option<String> {
        let session = self.session_before(line);
        let Hint { rest_of_name, arguments } = hint(&session, before)?;
        Some(format!("{rest_of_name}{arguments}"))
    }

    /// The painted parts of a line: start, end and kind each; kinds are 0 command, 1 name, 2 value, 3 wrong, 4 comment.
    pub fn highlight(&self, text: &str) -> Vec<u32> {
        let number = |(range, paint): (Range<usize>, Paint)| {
            let kind = match paint {
                Paint::Command => 0,
                Paint::Name => 1,
                Paint::Value => 2,
                Paint::Wrong => 3,
                Paint::Comment => 4,
            };
            [units(&text[..range.start]) as u32, units(&text[..range.end]) as u32, kind]
        };
        let parts = highlight(&self.session, text);
        parts.into_iter().flat_map(number).collect()
    }

    /// The exponents of a primitive and the edit that changes them, as JSON. `name` is the primitive; without one it is the
    /// one that is selected behind a line. `None` if there is none.
    pub fn exponents(&self, name: Option<String>, line: usize) -> Option<String> {
        let name = match name {
            Some(name) => name,
            None => self.session_before(line + 1).selected()?.to_owned(),
        };
        exponents::find(&self.text, &self.session, &name).map(|found| json(&found))
    }

    /// The text for a line with `setExponent` that keeps its word.
    #[wasm_bindgen(js_name = exponentLine)]
    pub fn exponent_line(word: &str, e: f64, n: f64) -> String {
        exponents::line(word, e, n)
    }
}

/// The number of whole words before the word at the end of a line, in its last command.
fn words_before(before: &str) -> usize {
    let last = split_commands(before).last().map_or(before, |(_, command)| *command);
    let words = last.split_whitespace().count();
    if before.ends_with(char::is_whitespace) { words } else { words.saturating_sub(1) }
}

/// The help for words: a command, a setting, a topic, anything; `None` if nothing is known of them.
#[wasm_bindgen(js_name = helpFor)]
pub fn help_for(words: &str) -> Option<String> {
    let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
    help(&words, HELP_COLUMNS).ok()
}

/// The help for a command by any of its spellings; `None` for another word.
#[wasm_bindgen(js_name = helpForCommand)]
pub fn help_for_command(word: &str) -> Option<String> {
    find_command(word).and_then(|_| help_for(word))
}
