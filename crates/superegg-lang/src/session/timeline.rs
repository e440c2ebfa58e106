//! A session with its history: undo, redo, and the lines that made it.

use superegg_scene::Scene;

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::{Command, Request, SessionCommand};
use crate::parse::parser::Parsed;
use crate::session::interpreter::{Effect, Session, parse_typed};
use crate::session::selection::Selection;
use crate::session::settings::Settings;
use crate::suggest::Suggestions;

/// The number of latest steps that all keep a snapshot, so that undo is immediate.
const DENSE: usize = 1000;
/// Older steps keep a snapshot only every `SPARSE`th time; those between are replayed.
const SPARSE: usize = 64;

/// Messages of undo show at most this many characters of a line.
const LONGEST_LABEL: usize = 200;

/// A session with undo and redo.
///
/// Any number of changes can be undone and redone, including loads. Each change takes the memory of
/// its text, and each of the last thousand a few kilobytes more.
///
/// ```
/// use superegg_lang::Timeline;
///
/// let mut timeline = Timeline::default();
/// timeline.run_line("primitive egg")?;
/// timeline.run_line("setColor 1 0 0")?;
/// timeline.run_line("undo 2")?;
/// assert!(timeline.session().scene().get("egg").is_none());
/// timeline.run_line("redo")?;
/// assert_eq!(timeline.session().selected(), Some("egg"));
/// assert_eq!((timeline.undo_count(), timeline.redo_count()), (1, 1));
/// # Ok::<(), superegg_lang::Fault>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Timeline {
    now: Session,
    past: Vec<Step>,
    /// The undone steps; the next one to redo is the last.
    future: Vec<Undone>,
    /// The number of steps ever made.
    step_count: u64,
    /// The number of the last saved step, 0 for none.
    saved: u64,
    /// The number of steps that made the scene that the session started with. They are not undone.
    start: usize,
}

/// A snapshot that undo and redo restore. It does not include the settings of the session.
#[derive(Clone, Debug)]
struct Snapshot {
    scene: Scene,
    selected: Option<String>,
}

impl Snapshot {
    fn of(session: &Session) -> Self {
        Self { scene: session.scene.clone(), selected: session.selected.clone() }
    }

    fn selection(&self) -> Selection<'_> {
        Selection { scene: &self.scene, selected: self.selected.as_deref() }
    }

    /// Whether the selection and its cursor are those of a session.
    fn selects_as(&self, session: &Session) -> bool {
        self.selected.as_deref() == session.selected()
            && self.selection().cursor() == session.selection().cursor()
    }

    fn restore(self, session: &mut Session) {
        session.scene = self.scene;
        session.selected = self.selected;
    }
}

/// Whether a line only selects.
fn selects(line: &str, suggestions: Suggestions) -> bool {
    let parsed = parse_typed(line, suggestions).ok().flatten();
    parsed.is_none_or(|parsed| parsed.command.is_selection())
}

/// One change.
#[derive(Clone, Debug)]
struct Step {
    /// Counted from 1.
    number: u64,
    /// The line as typed, for messages.
    label: String,
    /// The lines that replay the step.
    lines: String,
    /// Whether the step starts from an empty scene.
    starts_empty: bool,
    /// Whether the step changes only the selection or a cursor.
    is_selection: bool,
    before: Option<Snapshot>,
}

#[derive(Clone, Debug)]
struct Undone {
    step: Step,
    after: Snapshot,
}

impl Timeline {
    /// A session without history. Selects `root` if it exists.
    pub fn beginning_with(mut session: Session, root: Option<&str>) -> Self {
        if let Some(root) = root.filter(|root| session.scene.get(root).is_some()) {
            session.selected = Some(root.to_owned());
        }
        Self { now: session, ..Self::default() }
    }

    /// The session as it is now.
    pub fn session(&self) -> &Session {
        &self.now
    }

    /// Sets the settings that do not belong to the scene.
    pub fn set_settings(&mut self, settings: Settings) {
        self.now.settings = settings;
    }

    /// Whether faults of later lines suggest known words for unknown ones.
    pub fn suggest(&mut self, is_wanted: bool) {
        self.now.suggestions = if is_wanted { Suggestions::Given } else { Suggestions::Omitted };
    }

    /// The number of changes that can be undone.
    pub fn undo_count(&self) -> usize {
        self.past.len()
    }

    /// The number of changes that can be redone.
    pub fn redo_count(&self) -> usize {
        self.future.len()
    }

    /// Carries out one line as [`Session::run_line`] and records its change. Also carries out
    /// `undo` and `redo`.
    ///
    /// # Errors
    /// The line cannot be read or carried out. Nothing is then changed.
    pub fn run_line(&mut self, line: &str) -> Result<Effect, Fault> {
        let Some(parsed) = parse_typed(line, self.now.suggestions)? else { return Ok(Effect::Done) };
        match parsed.command {
            Command::Request(Request::Undo(count)) => self.undo(count, &parsed),
            Command::Request(Request::Redo(count)) => self.redo(count, &parsed),
            _ => self.execute(&parsed, line),
        }
    }

    fn execute(&mut self, parsed: &Parsed, line: &str) -> Result<Effect, Fault> {
        let before = Snapshot::of(&self.now);
        let entity_count = before.scene.entities().len();
        let effect = self.now.execute(parsed)?;
        if matches!(effect, Effect::Changed(_)) {
            let is_same = self.now.scene.entities().len() == entity_count;
            let selects = parsed.command.is_selection();
            if is_same && selects && before.selects_as(&self.now) {
                return Ok(Effect::Done);
            }
            let line = line.trim();
            let starts_empty = parsed.command == Command::Session(SessionCommand::Clear);
            let lines = if starts_empty { "" } else { line };
            self.push(before, line, lines, starts_empty, is_same && selects);
        }
        Ok(effect)
    }

    /// Replaces the session, for example by a loaded one, as one change. `lines` make it from an
    /// empty scene.
    pub fn replace(&mut self, session: Session, label: &str, lines: &str) {
        let before = Snapshot::of(&self.now);
        self.now = session;
        self.push(before, label, lines, true, false);
    }

    /// Carries out lines as one change, for example those of an included file.
    ///
    /// # Errors
    /// A line cannot be read or carried out. Nothing is then changed.
    pub fn run_lines(&mut self, label: &str, lines: &str) -> Result<(), Fault> {
        let mut session = self.now.clone();
        for line in lines.lines() {
            session.run_line(line)?;
        }
        let before = Snapshot::of(&self.now);
        let is_selection = before.scene.entities().len() == session.scene.entities().len()
            && lines.lines().all(|line| selects(line, session.suggestions));
        self.now = session;
        let is_same = is_selection && before.selects_as(&self.now);
        if !is_same {
            self.push(before, label, lines, false, is_selection);
        }
        Ok(())
    }

    fn push(&mut self, before: Snapshot, label: &str, lines: &str, starts_empty: bool, is_selection: bool) {
        self.future.clear();
        self.step_count += 1;
        self.past.push(Step {
            number: self.step_count,
            label: label.chars().take(LONGEST_LABEL).collect(),
            lines: lines.to_owned(),
            starts_empty,
            is_selection,
            before: Some(before),
        });
        if let Some(old) = self.past.len().checked_sub(DENSE + 1) {
            // The step after a load keeps its snapshot: replaying a load is slow.
            if old % SPARSE != 0 && !self.past[old - 1].starts_empty {
                self.past[old].before = None;
            }
        }
    }

    fn undo(&mut self, count: u32, parsed: &Parsed) -> Result<Effect, Fault> {
        let most = self.past.len().saturating_sub(self.start);
        if most == 0 {
            let why = match self.past.last() {
                None => "every change of this session has been undone",
                Some(_) => "the scene is as it was when the session started; 'clear' empties it",
            };
            return Err(nothing("undo", why, parsed));
        }
        let count = most.min(count as usize);
        for _ in 0..count {
            let last = self.past.len() - 1;
            self.fill(last);
            let Some(mut step) = self.past.pop() else { break };
            let Some(before) = step.before.take() else { break };
            self.future.push(Undone { step, after: Snapshot::of(&self.now) });
            before.restore(&mut self.now);
        }
        let label = self.future.last().map_or("", |undone| &undone.step.label);
        let mut text = summary("undone", count, label);
        if self.start > 0 && self.past.len() == self.start {
            text.push_str("; the scene is as it was when the session started");
        }
        Ok(Effect::Changed(Some(text)))
    }

    fn redo(&mut self, count: u32, parsed: &Parsed) -> Result<Effect, Fault> {
        if self.future.is_empty() {
            return Err(nothing("redo", "nothing has been undone since the last change", parsed));
        }
        let count = self.future.len().min(count as usize);
        for _ in 0..count {
            let Some(Undone { mut step, after }) = self.future.pop() else { break };
            step.before = Some(Snapshot::of(&self.now));
            self.past.push(step);
            after.restore(&mut self.now);
        }
        let label = self.past.last().map_or("", |step| &step.label);
        Ok(Effect::Changed(Some(summary("redone", count, label))))
    }

    /// Restores the snapshot of a step by replaying from the nearest earlier step that has one.
    fn fill(&mut self, at: usize) {
        let kept = (0..=at).rev().find(|&i| self.past[i].before.is_some()).unwrap_or(0);
        let mut session = Session { settings: self.now.settings, ..Session::default() };
        if let Some(before) = &self.past[kept].before {
            before.clone().restore(&mut session);
        }
        for i in kept..at {
            let step = &self.past[i];
            if step.starts_empty {
                session.clear();
            }
            for line in step.lines.lines() {
                // It succeeded the first time, from the same state.
                let done = session.run_line(line);
                debug_assert!(done.is_ok(), "{line}: {done:?}");
            }
            self.past[i + 1].before = Some(Snapshot::of(&session));
        }
    }

    /// The lines that made the scene, as typed or as in the loaded files, without undone ones.
    pub fn typed_lines(&self) -> String {
        let first = self.past.iter().rposition(|step| step.starts_empty).unwrap_or(0);
        let mut text = String::from("# superegg history\n");
        for step in &self.past[first..] {
            text.push_str(&step.lines);
            if !step.lines.is_empty() && !step.lines.ends_with('\n') {
                text.push('\n');
            }
        }
        text
    }

    /// Makes the current scene the one that the session starts with: undo does not go behind it.
    pub fn mark_start(&mut self) {
        self.start = self.past.len();
    }

    /// Marks the current scene as saved.
    pub fn mark_saved(&mut self) {
        self.saved = self.last_change();
    }

    /// Whether the scene has unsaved changes. Selecting does not count, and an empty scene has
    /// none.
    pub fn has_unsaved_changes(&self) -> bool {
        self.last_change() != self.saved && self.now.scene != Scene::default()
    }

    fn last_change(&self) -> u64 {
        self.past.iter().rev().find(|step| !step.is_selection).map_or(0, |step| step.number)
    }
}

fn summary(verb: &str, count: usize, label: &str) -> String {
    if count == 1 {
        format!("{verb}: {label}")
    } else {
        format!("{verb}: {count} changes, the last of them: {label}")
    }
}

fn nothing(verb: &str, why: &str, parsed: &Parsed) -> Fault {
    Fault::new(FaultCode::NothingLeft, format!("there is nothing to {verb}"))
        .help(why)
        .at(parsed.columns[0].clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::script::load_text;

    fn run(timeline: &mut Timeline, line: &str) -> Effect {
        timeline.run_line(line).unwrap_or_else(|fault| panic!("{line}: {fault:?}"))
    }

    #[test]
    fn undo_and_redo_go_back_and_forth_over_a_load() {
        let mut timeline = Timeline::default();
        let mut moments = vec![timeline.session().clone()];
        for line in ["prm a", "coeff 2 2 2", "obj o", "ap a"] {
            run(&mut timeline, line);
            moments.push(timeline.session().clone());
        }
        let lines = "prm z\nobj y\nap z\n";
        timeline.replace(load_text("z.scn", lines).0, "load z.scn", lines);
        moments.push(timeline.session().clone());
        run(&mut timeline, "xs 1 2 3");
        moments.push(timeline.session().clone());
        assert_eq!(timeline.typed_lines(), format!("# superegg history\n{lines}xs 1 2 3\n"));
        for expected in moments.iter().rev().skip(1) {
            run(&mut timeline, "undo");
            assert_eq!(timeline.session(), expected);
        }
        assert_eq!(timeline.run_line("undo").unwrap_err().code.as_str(), "nothing-left");
        for expected in moments.iter().skip(1) {
            run(&mut timeline, "redo");
            assert_eq!(timeline.session(), expected);
        }
        run(&mut timeline, "undo 1000");
        assert_eq!(timeline.session(), &Session::default());
        run(&mut timeline, "redo 3");
        // Selecting the selected object is not a step.
        assert_eq!(run(&mut timeline, "obj o"), Effect::Done);
        assert_eq!(timeline.redo_count(), 3);
        run(&mut timeline, "deselect");
        assert_eq!((timeline.redo_count(), timeline.session().scene().entities().len()), (0, 2));
    }

    #[test]
    fn old_steps_are_found_again_by_doing() {
        let mut timeline = Timeline::default();
        run(&mut timeline, "prm a");
        run(&mut timeline, "obj o");
        run(&mut timeline, "ap a");
        for i in 0..3 * DENSE {
            run(&mut timeline, &format!("xs {i} 0 0"));
        }
        let kept = timeline.past.iter().filter(|step| step.before.is_some()).count();
        assert!(kept < DENSE + 2 * DENSE / SPARSE + 2, "{kept} moments are kept");
        let steps = |timeline: &Timeline| {
            timeline.session().scene().object("o").unwrap().cursor().unwrap().1.steps().count()
        };
        for left in (0..3 * DENSE).rev() {
            run(&mut timeline, "undo");
            assert_eq!(steps(&timeline), left);
        }
        run(&mut timeline, "redo 2500");
        assert_eq!(steps(&timeline), 2500);
    }

    #[test]
    fn lines_that_only_select_are_one_step_of_selection() {
        let mut timeline = Timeline::default();
        for line in ["prm a", "obj o", "ap a", "ap a b"] {
            run(&mut timeline, line);
        }
        timeline.mark_saved();
        run(&mut timeline, "prm a");
        timeline.run_lines("object o; setCursor a", "object o\nsetCursor a\n").unwrap();
        assert_eq!((timeline.has_unsaved_changes(), timeline.undo_count()), (false, 6));
        timeline.run_lines("the same again", "object o\nsetCursor a\n").unwrap();
        assert_eq!(timeline.undo_count(), 6);
        run(&mut timeline, "undo");
        assert_eq!(timeline.session().selected(), Some("a"));
        timeline.run_lines("new", "object p\n").unwrap();
        assert!(timeline.has_unsaved_changes());
    }

    #[test]
    fn what_is_saved_is_known_through_undo_and_redo() {
        let mut timeline = Timeline::default();
        run(&mut timeline, "set wireframe on");
        assert!(!timeline.has_unsaved_changes());
        run(&mut timeline, "prm a");
        assert!(timeline.has_unsaved_changes());
        timeline.mark_saved();
        run(&mut timeline, "deselect");
        assert!(!timeline.has_unsaved_changes());
        run(&mut timeline, "prm b");
        assert!(timeline.has_unsaved_changes());
        run(&mut timeline, "undo");
        assert!(!timeline.has_unsaved_changes());
        run(&mut timeline, "undo 2");
        run(&mut timeline, "redo 2");
        assert!(!timeline.has_unsaved_changes());
    }
}
