//! The scene at a frame.

use superegg_scene::{Scene, Track, TrackSubject};

use crate::diagnostic::Fault;
use crate::parse::number::format_number;
use crate::session::interpreter::Session;
use crate::session::keys::line_of;
use crate::text::shorten;

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

/// Runs the line with what its keys are of selected, and puts selection and cursor back.
fn carry_out(session: &mut Session, subject: &TrackSubject, line: &str) -> Result<(), Fault> {
    let selected = std::mem::replace(&mut session.selected, subject.selected.as_deref().map(str::to_owned));
    let mut cursor = None;
    if let (Some(object), Some(alias)) = (&subject.selected, &subject.cursor) {
        cursor = session.selection().cursor().map(str::to_owned);
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
