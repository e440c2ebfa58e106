//! Keys of commands, and the scene at a frame.
//!
//! A key keeps the numbers of a command at a frame, with what was selected and the cursor when it was typed, where the command changes those. At
//! a frame the scene is what the other commands made, and then each keyed command carried out with its numbers at that frame
//! ([`superegg_scene::Track::numbers_at`]), in the order in which the tracks began, as if its line stood at the end of the file.

use std::sync::Arc;

use superegg_scene::{Light, Scene, Track, TrackSubject, TrackWord};

use crate::command::Command;
use crate::diagnostic::Fault;
use crate::number::{format_number, parse_number};
use crate::parser::{Parsed, shorten};
use crate::session::{Session, arguments, at_word, did_you_mean};
use crate::settings::{SettingKind, find_setting};
use crate::spec::{ArgKind, CommandSpec, Group, Needs, Of, Range};
use crate::table::{COMMANDS, commands_spelt, find_command};

/// The word for every frame.
const ALL: &str = "all";

impl CommandSpec {
    /// Whether there can be keys of it: it sets numbers of the scene. (Of `set`, only where the setting is a number of the scene.)
    pub fn is_keyable(&self) -> bool {
        let is_of_scene = matches!(self.group, Group::Primitives | Group::Objects | Group::Scene);
        let has_number = self.all_args().any(|arg| matches!(arg.kind, ArgKind::Number(_)));
        self.name == "set" || (is_of_scene && has_number)
    }
}

/// The scene at a frame, any finite number: a still, without keys.
///
/// # Errors
/// A keyed command cannot be carried out at this frame: its numbers there would be a scale of 0 or a direction of 0 0 0, or a transform that
/// cannot be undone. The message says which and when.
pub fn scene_at(session: &Session, frame: f64) -> Result<Scene, Fault> {
    let mut still = session.clone();
    still.scene.remove_keys(None, |_| true);
    for track in session.scene.tracks() {
        let line = line_at(track, frame);
        carry_out(&mut still, track.subject(), &line).map_err(|fault| {
            let when = format!("at frame {} '{}' cannot be: ", format_number(frame), shorten(&line));
            let help = "keys nearer to that frame lead around it; 'unkey FRAME' takes keys away";
            Fault::new(fault.code, when + &fault.message).help(help)
        })?;
    }
    Ok(still.scene)
}

/// The line of a track's command at a frame.
fn line_at(track: &Track, frame: f64) -> String {
    line_of(track.subject(), &track.numbers_at(frame))
}

/// The command with these numbers in their places; those that must be whole are rounded.
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
                word.to_string()
            }
        });
    }
    words.join(" ")
}

fn args_of(command: &str) -> impl Iterator<Item = ArgKind> {
    find_command(command).into_iter().flat_map(CommandSpec::all_args).map(|arg| arg.kind)
}

/// The numbers that an argument may be; `before` is the word before it, which may be a setting.
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

/// Runs the line with what its keys are of selected, and puts selection and cursor back.
fn carry_out(session: &mut Session, subject: &TrackSubject, line: &str) -> Result<(), Fault> {
    let selected = std::mem::replace(&mut session.selected, subject.selected.as_deref().map(str::to_owned));
    let mut cursor = None;
    if let (Some(object), Some(alias)) = (&subject.selected, &subject.cursor) {
        cursor = session.place().1.map(str::to_owned);
        // It is there: a track goes with its child.
        let _ = session.scene.move_cursor(object, alias);
    }
    let done = session.run_line(line);
    if let (Some(object), Some(alias)) = (&subject.selected, cursor) {
        let _ = session.scene.move_cursor(object, &alias);
    }
    session.selected = selected;
    done.map(drop)
}

/// What a keyed line is about, and its numbers.
fn subject_of(
    session: &Session,
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
                let Some(number) = number else { return Err(at_word(not_keyable(keyed.spec), keyed, i + 1)) };
                numbers.push(number);
                TrackWord::Number
            }
            ArgKind::Name(Of::Light | Of::New) => TrackWord::Light(name()),
            ArgKind::Name(Of::Setting) => {
                TrackWord::Word(find_setting(word).map_or_else(name, |spec| spec.name.into()))
            }
            ArgKind::Name(_) => TrackWord::Entity(name()),
            _ => TrackWord::Word(word.to_ascii_lowercase().into()),
        });
        before = word;
    }
    if numbers.is_empty() {
        return Err(at_word(not_keyable(keyed.spec), keyed, 0));
    }
    let (selected, cursor) = session.place();
    let moves_child = matches!(keyed.command, Command::TransformChild(_));
    let subject = TrackSubject {
        command: keyed.spec.name.into(),
        words: track_words,
        selected: selected.filter(|_| keyed.spec.needs != Needs::Nothing).map(Into::into),
        cursor: cursor.filter(|_| moves_child).map(Into::into),
    };
    Ok((subject, numbers))
}

pub(crate) fn not_keyable(spec: &CommandSpec) -> Fault {
    let message =
        format!("there are no keys of {}: they need numbers that can go over into others", spec.name);
    Fault::new("not-keyable", message)
        .help("keys are of commands such as rotate, setColor, camera or 'set exposure'; for example: key 24 rotate 0 0 1 90")
}

/// Adds a key of a line.
///
/// # Errors
/// The line could not be carried out on its own, or has another count of numbers than the other keys of its track.
pub(crate) fn set_key(
    session: &mut Session,
    frame: f64,
    keyed: &Parsed,
    words: &[String],
) -> Result<(), Fault> {
    let (subject, numbers) = subject_of(session, keyed, words)?;
    check(session, keyed)?;
    session.scene.set_key(subject, frame, &numbers).map_err(|error| {
        let help = "give as many numbers; or take those keys away, for example: unkey all";
        Fault::new("key-numbers", error.to_string()).help(help).at(arguments(keyed))
    })
}

/// Refuses a line for what it says, and for names that are not there. Whether its transform can be undone depends on what other commands make,
/// now and later, and is not looked at: a scene that was saved must load.
fn check(session: &Session, keyed: &Parsed) -> Result<(), Fault> {
    const OF_NAMES: [&str; 5] = ["selection", "unknown-name", "wrong-kind", "no-child", "no-floor"];
    match session.clone().execute(keyed) {
        Err(fault) if OF_NAMES.contains(&fault.code) => return Err(fault),
        _ => {}
    }
    // A scene with nothing but what the line names.
    let mut alone = Session { selected: session.selected.clone(), ..Session::default() };
    let (selected, cursor) = session.place();
    let mut names: Vec<&str> = selected.into_iter().collect();
    match &keyed.command {
        Command::SetFloor { surface: Some(name), .. } => names.push(name),
        Command::SetLightRadius { name, .. } => alone.scene.set_light(name, Light::DEFAULT),
        _ => {}
    }
    // None is there yet, so each can be made.
    for name in names {
        let _ = match session.scene.primitive(name) {
            Ok(_) => alone.scene.ensure_primitive(name),
            Err(_) => alone.scene.ensure_object(name),
        };
    }
    if let (Some(object), Some(alias)) = (selected, cursor) {
        let _ = alone.scene.add_child(object, alias, object);
    }
    alone.scene.floor.clone_from(&session.scene.floor);
    alone.execute(keyed).map(drop)
}

/// Takes away the keys at a frame, or all: of every command, or of one on what is selected. Returns what there is to say.
///
/// # Errors
/// There is no such key.
pub(crate) fn remove_keys(
    session: &mut Session,
    frame: &str,
    command: Option<&str>,
    parsed: &Parsed,
) -> Result<String, Fault> {
    let at = if frame.eq_ignore_ascii_case(ALL) {
        None
    } else {
        let number = parse_number(frame).map_err(|error| {
            let fault = Fault::new("not-a-number", format!("'{}' {error}", shorten(frame)));
            at_word(fault.help("give a frame, or 'all'; for example: unkey 24"), parsed, 1)
        })?;
        Some(number)
    };
    let names: Vec<&str> = command.into_iter().flat_map(commands_spelt).map(|spec| spec.name).collect();
    if let Some(word) = command.filter(|_| names.is_empty()) {
        let known = COMMANDS.iter().filter(|spec| spec.is_keyable()).map(|spec| spec.name);
        let fault = Fault::new("unknown-command", format!("there is no command '{}'", shorten(word)));
        return Err(at_word(fault.help(did_you_mean(word, known, "'info' lists the keys")), parsed, 2));
    }
    let (selected, cursor) = session.place();
    let place = (selected.map(str::to_owned), cursor.map(str::to_owned));
    let is_meant = |subject: &TrackSubject| {
        let is_here = |held: Option<&str>, now: &Option<String>| held.is_none() || held == now.as_deref();
        command.is_none()
            || (names.contains(&&*subject.command)
                && is_here(subject.selected.as_deref(), &place.0)
                && is_here(subject.cursor.as_deref(), &place.1))
    };
    let count = session.scene.remove_keys(at, is_meant);
    if count == 0 {
        let of = command.map_or(String::new(), |word| format!(" of {} for what is selected", shorten(word)));
        let when = at.map_or(String::new(), |at| format!(" at frame {}", format_number(at)));
        let fault = Fault::new("no-key", format!("there is no key{of}{when}"));
        return Err(at_word(fault.help("'info' lists the keys with their frames"), parsed, 1));
    }
    Ok(format!("{count} {} taken away", if count == 1 { "key" } else { "keys" }))
}

/// The frames that have keys, rising, each once.
pub(crate) fn key_frames(scene: &Scene) -> Vec<f64> {
    let mut frames: Vec<f64> = scene.tracks().flat_map(Track::keys).map(|key| key.frame).collect();
    frames.sort_by(f64::total_cmp);
    frames.dedup();
    frames
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;
    use crate::{load_text, write_session};

    const ARM: [&str; 7] =
        ["prm ball", "obj arm", "ap ball hand", "xs 1 0 0", "ap ball elbow", "cursor hand", "prm other"];

    fn session(lines: &[&str]) -> Session {
        let mut session = Session::default();
        for line in ARM.iter().chain(lines) {
            session.run_line(line).unwrap_or_else(|fault| panic!("{line}: {fault:?}"));
        }
        session
    }

    fn place_of_hand(session: &Session, frame: f64) -> DVec3 {
        let scene = scene_at(session, frame).unwrap();
        let arm = scene.object("arm").unwrap();
        let hand = arm.parent_from_child(arm.child("hand").unwrap()).unwrap();
        hand.forward().transform_point3(DVec3::ZERO)
    }

    #[test]
    fn a_hand_turns_while_something_else_is_selected() {
        let session =
            session(&["obj arm", "key 48 rotate 0 0 1 90", "key 0 rs 0 0 1 0", "cur elbow", "deselect"]);
        for (frame, angle_deg) in [(-7.0, 0.0f64), (0.0, 0.0), (24.0, 45.0), (48.0, 90.0), (1e9, 90.0)] {
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let place = place_of_hand(&session, frame);
            assert!((place - DVec3::new(cos, sin, 0.0)).length() < 1e-12, "{frame}: {place}");
        }
        let still = scene_at(&session, 24.0).unwrap();
        assert_eq!(still.object("arm").unwrap().cursor().unwrap().0, "elbow");
        let text = write_session(&session);
        assert!(text.contains("key 0 rotate 0 0 1 0\nkey 48 rotate 0 0 1 90\nsetCursor elbow\n"), "{text}");
        assert_eq!(load_text("saved", &text).0, session);
    }

    #[test]
    fn tracks_are_told_apart_and_are_carried_out_in_the_order_they_began() {
        let session = session(&[
            "light lamp 0 0 5",
            "key 0 light lamp 0 0 5",
            "key 0 lightRadius lamp 1",
            "key 10 light lamp 10 0 5",
            "key 10 lightRadius lamp 3",
            "key 0 set exposure 0",
            "key 10 set EXPOSURE 2",
            "key 0 set samples 1",
            "key 10 set samples 4",
            "key 0 pattern checker 1 0 0 1",
        ]);
        assert_eq!(session.scene().tracks().len(), 5);
        let scene = scene_at(&session, 5.0).unwrap();
        let lamp = scene.light("lamp").unwrap();
        // Carried out the other way round the light would be a new one, of no radius.
        assert_eq!((lamp.position(), lamp.radius), (Some(DVec3::new(5.0, 0.0, 5.0)), 2.0));
        // Samples are whole: 2.5 is rounded.
        assert_eq!((scene.picture.exposure, scene.picture.samples), (1.0, 3));
        let told = session.describe(&[]).unwrap();
        assert!(told.contains("keys (9)\n  light lamp: frames 0, 10\n"), "{told}");
        assert!(told.contains("\n  setPattern checker of other: frame 0"), "{told}");
        let told = session.describe(&["other".into()]).unwrap();
        assert!(told.ends_with("\n  key 0 setPattern checker 1 0 0 1"), "{told}");
    }

    #[test]
    fn keys_follow_what_they_are_of() {
        let mut session = session(&[
            "floor 0 other",
            "key 0 floor 1 other",
            "key 0 floorUp 0 0 1",
            "key 0 color 1 0 0",
            "light lamp 0 0 5",
            "key 0 spot lamp 0 0 5 0 0 0 30",
            "key 0 sky 1 1 1",
            "obj arm",
            "key 0 rotate 0 0 1 0",
            "key 0 rotateAll 0 0 1 0",
        ]);
        let tracks = |session: &Session| session.scene().tracks().len();
        let mut after = |line: &str| {
            session.run_line(line).unwrap();
            let loaded = load_text("saved", &write_session(&session));
            assert_eq!((&loaded.0, loaded.1.len()), (&session, 0), "{line}");
            tracks(&session)
        };
        assert_eq!([after("rename arm limb"), after("rename other tile")], [7, 7]);
        assert_eq!([after("cursor elbow"), after("remove elbow"), after("remove hand")], [7, 7, 6]);
        assert_eq!([after("unlight lamp"), after("unsky")].len(), 2);
        // Its colour, and the floor that has its surface.
        assert_eq!([after("delete tile"), after("unfloor"), after("delete limb")], [2, 1, 0]);
    }

    #[test]
    fn keys_are_taken_away_by_frame_and_by_command() {
        let mut session = session(&[
            "key 0 color 1 0 0",
            "key 5 color 0 1 0",
            "key 5 background 1 1 1",
            "obj arm",
            "key 5 rs 0 0 1 2",
        ]);
        let told = session.run_line("unkey 5 rotate").unwrap();
        assert_eq!(told, crate::Effect::Changed(Some("1 key taken away".into())));
        // The colour is that of another.
        assert_eq!(session.run_line("unkey 5 color").unwrap_err().code, "no-key");
        session.run_line("unkey 5").unwrap();
        assert_eq!(key_frames(session.scene()), [0.0]);
        session.run_line("unkey ALL").unwrap();
        assert_eq!(session.scene().tracks().len(), 0);
    }

    #[test]
    fn faults_of_a_key_are_those_of_its_line_in_their_place() {
        let before = session(&["obj arm", "key 0 light lamp 0 0 5", "key 9 light lamp 0 0 5"]);
        for (line, code, columns) in [
            ("key", "argument-count", 0..3),
            ("key 5", "argument-count", 0..5),
            ("key x rotate 0 0 1 0", "not-a-number", 4..5),
            ("key 5 rotat 0 0 1 0", "unknown-command", 6..11),
            ("key 5 rotate 0 0 1", "argument-count", 6..18),
            ("key 5 rotate 0 0 0 1", "transform", 13..20),
            ("key 5 scale 1 0 1", "out-of-range", 14..15),
            ("key 5 color 1 0 0", "selection", 6..11),
            ("key 5 lightRadius lmp 2", "unknown-name", 18..21),
            ("key 5 floorUp 0 0 1", "no-floor", 6..13),
            ("key 5 floor 0 bal", "unknown-name", 14..17),
            ("key 5 camera 0 0 0 0 0 0", "no-direction", 13..24),
            ("key 5 delete arm", "not-keyable", 6..12),
            ("key 5 key 6 rotate 0 0 1 0", "not-keyable", 6..9),
            ("key 5 ao arm again", "not-keyable", 6..8),
            ("key 5 set size 64x48", "not-keyable", 15..20),
            ("key 5 set threads 2", "not-keyable", 18..19),
            ("key 5 set exposure 99", "out-of-range", 19..21),
            ("key 5 set exposure", "not-keyable", 6..9),
            ("key 5 light lamp 0 0 5 1 1 1", "key-numbers", 12..28),
            ("unkey 7", "no-key", 6..7),
            ("unkey soon", "not-a-number", 6..10),
            ("unkey 0 rotat", "unknown-command", 8..13),
        ] {
            let mut after = before.clone();
            let fault = after.run_line(line).unwrap_err();
            assert_eq!(
                (fault.code, fault.columns.clone()),
                (code, Some(columns)),
                "{line}: {}",
                fault.message
            );
            assert!(fault.help.is_some() && after == before, "{line}");
        }
    }

    #[test]
    fn a_frame_that_cannot_be_says_which_and_why() {
        let session = session(&["obj arm", "key 0 scale 1 1 -1", "key 10 scale 1 1 1"]);
        assert!(scene_at(&session, 4.0).is_ok());
        let fault = scene_at(&session, 5.0).unwrap_err();
        assert_eq!(fault.code, "out-of-range");
        assert!(fault.message.starts_with("at frame 5 'scale 1 1 0' cannot be: "), "{}", fault.message);
    }
}
