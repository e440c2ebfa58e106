//! Laws that hold for every session and any input. Shared by the fuzz target and by a plain test.

use std::collections::HashMap;

use superegg_lang::{
    Effect, Request, Session, Settings, Timeline, complete, highlight, hint, load_text, scene_at,
    write_session,
};

/// Longer input takes time and finds nothing new.
const MOST_LINES: usize = 200;
const LONGEST_LINE: usize = 2000;

/// Runs the bytes as typed lines, with files kept in memory, and checks every law.
pub(crate) fn check(bytes: &[u8]) {
    let mut timeline = Timeline::default();
    let mut files: HashMap<String, String> = HashMap::new();
    for line in bytes.split(|&byte| byte == b'\n').take(MOST_LINES) {
        let text = String::from_utf8_lossy(&line[..line.len().min(LONGEST_LINE)]).into_owned();
        type_line(timeline.session(), &text);
        let before = timeline.session().clone();
        match timeline.run_line(&text) {
            Ok(Effect::Request(request)) => {
                assert_eq!(timeline.session(), &before, "a request changed something: {text:?}");
                carry_out(&mut timeline, &mut files, request);
            }
            Ok(Effect::Print(_)) => {
                assert_eq!(timeline.session(), &before, "printing changed something: {text:?}");
            }
            Ok(Effect::Done | Effect::Changed(_)) => {}
            Err(fault) => {
                assert_eq!(timeline.session(), &before, "a fault changed something: {text:?}");
                let columns = fault.columns.expect("a fault has columns");
                assert!(
                    columns.start < columns.end && columns.end <= text.chars().count(),
                    "{text:?} {columns:?}"
                );
                assert!(fault.help.is_some(), "{text:?}: {}", fault.message);
            }
        }
    }
    consistent(timeline.session());
    comes_back(&timeline);
    goes_back_and_forth(&mut timeline);
}

/// The calls of an editor while a line is typed.
fn type_line(session: &Session, line: &str) {
    let _ = hint(session, line);
    let mut end = 0;
    for (range, _) in highlight(session, line) {
        assert!(range.start >= end && line.get(range.clone()).is_some(), "{line:?} {range:?}");
        end = range.end;
    }
    let completion = complete(session, line, line.len());
    assert!(line.is_char_boundary(completion.start), "{line:?}");
}

fn carry_out(timeline: &mut Timeline, files: &mut HashMap<String, String>, request: Request) {
    match request {
        Request::Save { file, as_history, .. } => {
            let session = timeline.session();
            let text = if as_history { timeline.typed_lines() } else { write_session(session) };
            files.insert(file.unwrap_or_default(), text);
            timeline.mark_saved();
        }
        Request::Source { file, .. } => {
            let name = file.unwrap_or_default();
            if let Some(text) = files.get(&name) {
                let (session, diagnostics) = load_text(&name, text);
                assert!(diagnostics.is_empty(), "{diagnostics:?}\n{text}");
                timeline.replace(session, "load", text);
            }
        }
        _ => {}
    }
}

/// Every child refers to an existing entity with a valid transform, and selection and cursors
/// exist.
fn consistent(session: &Session) {
    let scene = session.scene();
    for (name, object) in scene.objects() {
        for (alias, child) in object.children() {
            assert!(scene.get(child.target()).is_some(), "{name:?}/{alias:?} stands for nothing");
            assert!(object.parent_from_child(child).is_ok());
        }
        assert_eq!(object.cursor().is_none(), object.children().len() == 0, "the cursor of {name:?}");
    }
    assert!(session.selected().is_none_or(|name| scene.get(name).is_some()));
}

/// A session loads to itself, saved as a scene or as typed.
fn comes_back(timeline: &Timeline) {
    let session = of_scene(timeline.session());
    for text in [write_session(&session), timeline.typed_lines()] {
        let (loaded, diagnostics) = load_text("saved", &text);
        assert!(diagnostics.is_empty(), "{diagnostics:?}\n{text}");
        assert_eq!(of_scene(&loaded), session, "{text}");
        for frame in [0.0, 7.5] {
            assert_eq!(scene_at(&loaded, frame), scene_at(&session, frame), "{text}");
        }
    }
}

fn goes_back_and_forth(timeline: &mut Timeline) {
    let last = of_scene(timeline.session());
    let steps = timeline.undo_count();
    if steps > 0 {
        timeline.run_line("undo 4000000000").expect("it can be undone");
        assert_eq!(of_scene(timeline.session()), Session::default());
        timeline.run_line(&format!("redo {steps}")).expect("it can be redone");
        assert_eq!(of_scene(timeline.session()), last);
    }
}

/// The part of a session that files and undo restore.
fn of_scene(session: &Session) -> Session {
    let mut session = session.clone();
    session.settings = Settings::default();
    session
}
