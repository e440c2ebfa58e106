//! Lists, restores and discards the sessions that ended without a save.

use superegg_lang::{Fault, FaultCode, Recovery};

use crate::modeller::state::{Modeller, Pending};
use crate::text::counted;

impl Modeller {
    /// Runs the command `recover`. Sessions are numbered from 1, newest first.
    pub(super) fn recover(&mut self, action: Recovery) -> Result<(), Fault> {
        let mut unsaved = self.unsaved_sessions();
        if unsaved.is_empty() {
            return Err(Fault::new(FaultCode::NothingLeft, "there is no session to recover")
                .help("every session that ended was saved, or has been recovered")
                .warning());
        }
        let number = match action {
            Recovery::Restore(number) | Recovery::Discard(Some(number)) => number as usize,
            Recovery::List | Recovery::Discard(None) => 1,
        };
        if number > unsaved.len() {
            let verb = if unsaved.len() == 1 { "is" } else { "are" };
            let message = format!("there {verb} {} to recover", counted(unsaved.len(), "session"));
            return Err(Fault::new(FaultCode::OutOfRange, message)
                .help("'recover list' lists them with their numbers"));
        }
        match action {
            Recovery::List => {
                let lines: Vec<String> = unsaved
                    .iter()
                    .enumerate()
                    .map(|(i, session)| format!("{:>3}  {}", i + 1, session.describe()))
                    .collect();
                self.print(&lines.join("\n"));
            }
            Recovery::Discard(only) => {
                let discarded = if only.is_some() { vec![unsaved.swap_remove(number - 1)] } else { unsaved };
                if !self.answers_person() {
                    return Err(Fault::new(
                        FaultCode::NotHere,
                        "unsaved sessions are only discarded at the prompt",
                    )
                    .help("without a terminal nobody can be asked; 'recover' alone keeps them, too")
                    .warning());
                }
                self.pending = Some(Pending::Discard(discarded));
            }
            Recovery::Restore(_) => {
                self.finish_or_confirm(Pending::Recover(unsaved.swap_remove(number - 1)), false);
            }
        }
        Ok(())
    }
}
