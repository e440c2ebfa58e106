//! The terminal between two lines.

use std::io::stdin;

use nix::sys::termios::{InputFlags, LocalFlags, SetArg, Termios, tcgetattr, tcsetattr};

/// While it lives, keys that are typed or pasted while a line is carried out wait for the next one: the terminal neither shows them itself
/// nor takes them for the end of its input. Ctrl-c still interrupts. When dropped it puts the terminal back as it was.
pub(super) struct KeepTypedAhead(Option<Termios>);

impl KeepTypedAhead {
    pub(super) fn begin() -> Self {
        let Ok(before) = tcgetattr(stdin()) else { return Self(None) };
        let mut between = before.clone();
        between.local_flags.remove(LocalFlags::ICANON | LocalFlags::ECHO);
        between.input_flags.remove(InputFlags::ICRNL);
        // A terminal that does not take it works as well, but for keys that come early.
        let _ = tcsetattr(stdin(), SetArg::TCSADRAIN, &between);
        Self(Some(before))
    }
}

impl Drop for KeepTypedAhead {
    fn drop(&mut self) {
        if let Some(before) = &self.0 {
            let _ = tcsetattr(stdin(), SetArg::TCSADRAIN, before);
        }
    }
}
