//! Keyframes: the subject and the numbers of a keyed command.
//!
//! A key stores the numbers of a command at a frame. If the command changes the selected entity or
//! the child at the cursor, the key also stores those.

use std::sync::Arc;

use superegg_scene::{Key, Scene, Track, TrackSubject, TrackWord};

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::{Command, Needs, ObjectCommand};
use crate::grammar::spec::{ArgKind, CommandSpec, NameKind, Range, not_keyable};
use crate::grammar::table::find_command;
use crate::parse::number::{format_number, parse_number};
use crate::parse::parser::Parsed;
use crate::session::selection::Selection;
use crate::session::settings::{SettingKind, find_setting};

/// The word for every frame.
pub(crate) const ALL_FRAMES: &str = "all";

/// The line of a keyed command with these numbers; whole numbers are rounded.
pub(crate) fn line_of(subject: &TrackSubject, numbers: &[f64]) -> String {
    let mut words = vec![subject.command.to_string()];
    let mut numbers = numbers.iter();
    let mut before = "";
    for (word, arg) in subject.words.iter().zip(args_of(&subject.command)) {
        words.push(match word {
            TrackWord::Number => {
                let number = numbers.next().copied().unwrap_or_default();
                let is_whole = matches!(number_range(arg, before), Some(Range::Whole(..)));
                format_number(if is_whole { number.round() } else { number })
            }
            TrackWord::Word(word) | TrackWord::Entity(word) | TrackWord::Light(word) => {
                before = word;
                let is_split = word.is_empty() || word.contains(|c: char| c.is_whitespace() || c == '#');
                if arg == ArgKind::File && is_split { format!("\"{word}\"") } else { word.to_string() }
            }
        });
    }
    words.join(" ")
}

fn args_of(command: &str) -> impl Iterator<Item = ArgKind> {
    find_command(command).into_iter().flat_map(CommandSpec::all_args).map(|arg| arg.kind)
}

/// The range of a keyable argument; `before` is the previous word, which may be a setting of the
/// scene.
fn number_range(arg: ArgKind, before: &str) -> Option<Range> {
    let of_setting =
        |setting: &str| find_setting(setting).filter(|spec| spec.is_of_scene).map(|spec| spec.kind);
    match arg {
        ArgKind::Number(range) => Some(range),
        ArgKind::Value => match of_setting(before) {
            Some(SettingKind::Number(range)) => Some(range),
            _ => None,
        },
        _ => None,
    }
}

/// The subject of a keyed line, and its numbers.
pub(crate) fn subject_of(
    selection: Selection<'_>,
    keyed: &Parsed,
    words: &[String],
) -> Result<(TrackSubject, Vec<f64>), Fault> {
    let mut numbers = Vec::new();
    let mut track_words = Vec::new();
    let mut before = "";
    for (i, (word, arg)) in words.iter().zip(keyed.spec.all_args()).enumerate() {
        let name = || Arc::from(word.as_str());
        track_words.push(match arg.kind {
            ArgKind::Number(_) | ArgKind::Value => {
                let number = number_range(arg.kind, before).and_then(|_| parse_number(word).ok());
                let Some(number) = number else {
                    return Err(not_keyable(keyed.spec).at(keyed.word_columns(i + 1)));
                };
                numbers.push(number);
                TrackWord::Number
            }
            ArgKind::Name(NameKind::Light | NameKind::New) => TrackWord::Light(name()),
            ArgKind::Name(NameKind::Setting) => {
                TrackWord::Word(find_setting(word).map_or_else(name, |spec| spec.name.into()))
            }
            ArgKind::Name(_) => TrackWord::Entity(name()),
            // Case matters in names of files.
            ArgKind::File => TrackWord::Word(name()),
            _ => TrackWord::Word(word.to_ascii_lowercase().into()),
        });
        before = word;
    }
    if numbers.is_empty() {
        return Err(without_numbers(keyed.spec).at(keyed.word_columns(0)));
    }
    let (selected, cursor) = (selection.selected, selection.cursor());
    let moves_child = matches!(keyed.command, Command::Object(ObjectCommand::TransformChild(_)));
    let subject = TrackSubject {
        command: keyed.spec.name.into(),
        words: track_words,
        selected: selected.filter(|_| keyed.spec.needs() != Needs::Nothing).map(Into::into),
        cursor: cursor.filter(|_| moves_child).map(Into::into),
    };
    Ok((subject, numbers))
}

/// The fault of a keyed line without the number that the command may do without elsewhere.
fn without_numbers(spec: &CommandSpec) -> Fault {
    let message = format!("a key of {} needs a number: that is what changes from key to key", spec.name);
    Fault::new(FaultCode::NotKeyable, message).help(format!("add it: {} {}", spec.name, spec.usage()))
}

/// Gives other names to files, as [`Scene::rename_files`], in the commands of keys, too.
pub fn rename_files(scene: &mut Scene, new_name: &mut dyn FnMut(&str) -> Option<String>) -> bool {
    let is_scene_changed = scene.rename_files(new_name);
    let mut is_changed = false;
    let tracks: Vec<(TrackSubject, Vec<Key>)> = scene
        .tracks()
        .map(|track| {
            let mut subject = track.subject().clone();
            let args = find_command(&subject.command).into_iter().flat_map(CommandSpec::all_args);
            for (word, arg) in subject.words.iter_mut().zip(args) {
                if let (TrackWord::Word(file), ArgKind::File) = (&mut *word, arg.kind)
                    && let Some(new) = new_name(file)
                {
                    *word = TrackWord::Word(new.into());
                    is_changed = true;
                }
            }
            (subject, track.keys().cloned().collect())
        })
        .collect();
    if is_changed {
        scene.remove_keys(None, |_| true);
        for (subject, keys) in tracks {
            for key in keys {
                // Cannot fail: the keys of a track have one count of numbers.
                let _ = scene.set_key(subject.clone(), key.frame, &key.numbers);
            }
        }
    }
    is_scene_changed || is_changed
}

/// The frames that have keys, in rising order, each once.
pub fn key_frames(scene: &Scene) -> Vec<f64> {
    let mut frames: Vec<f64> = scene.tracks().flat_map(Track::keys).map(|key| key.frame).collect();
    frames.sort_by(f64::total_cmp);
    frames.dedup();
    frames
}
