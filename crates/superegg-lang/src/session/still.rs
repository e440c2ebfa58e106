//! The scene at a frame.
//!
//! The scene at a frame is the scene without its keys, after each keyed command has been carried
//! out with its numbers at that frame ([`superegg_scene::Track::numbers_at`]), in the order of the
//! tracks, as if these lines stood at the end of the file.

use superegg_scene::{Scene, Track, TrackSubject};

use crate::diagnostic::Fault;
use crate::parse::number::format_number;
use crate::session::interpreter::Session;
use crate::session::keys::line_of;
use crate::text::shorten;

/// The scene at a frame, without keys. `frame` is any finite number.
///
/// # Errors
/// A keyed command cannot be carried out with its interpolated numbers: a scale of 0, a zero
/// direction, or a transform that is not invertible. The message names the command and the frame.
///
/// ```
/// use superegg_lang::{load_text, scene_at};
///
/// let (session, _) = load_text("fade.scn", "key 0 set exposure 0\nkey 10 set exposure 2\n");
/// assert_eq!(scene_at(&session, 5.0)?.picture.exposure, 1.0);
/// # Ok::<(), superegg_lang::Fault>(())
/// ```
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

/// The line of a track at a frame.
fn line_at(track: &Track, frame: f64) -> String {
    line_of(track.subject(), &track.numbers_at(frame))
}

/// Runs a line with the selection and cursor of its track, then restores them.
fn carry_out(session: &mut Session, subject: &TrackSubject, line: &str) -> Result<(), Fault> {
    let selected = std::mem::replace(&mut session.selected, subject.selected.as_deref().map(str::to_owned));
    let mut cursor = None;
    if let (Some(object), Some(alias)) = (&subject.selected, &subject.cursor) {
        cursor = session.selection().cursor().map(str::to_owned);
        // Cannot fail: a track is removed with its child.
        let _ = session.scene.move_cursor(object, alias);
    }
    let done = session.run_line(line);
    if let (Some(object), Some(alias)) = (&subject.selected, cursor) {
        let _ = session.scene.move_cursor(object, &alias);
    }
    session.selected = selected;
    done.map(drop)
}
