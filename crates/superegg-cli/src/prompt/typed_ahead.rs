//! The terminal between two lines, and at the end.

use std::io::{Write, stdin};

use nix::sys::termios::{InputFlags, LocalFlags, SetArg, Termios, tcgetattr, tcsetattr};
use signal_hook::consts::{SIGHUP, SIGTERM};
use signal_hook::iterator::Signals;

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
        put_back_when_ended(before.clone());
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

/// Puts the terminal back before a signal ends the process, in whatever state the editor had it. What the session changed is in its journal.
fn put_back_when_ended(before: Termios) {
    const STOP_BRACKETED_PASTE: &[u8] = b"\x1b[?2004l\n";
    let Ok(mut signals) = Signals::new([SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            // Where the terminal is gone there is nothing to put back.
            let _ = std::io::stdout().write_all(STOP_BRACKETED_PASTE);
            let _ = tcsetattr(stdin(), SetArg::TCSANOW, &before);
            std::process::exit(128 + signal);
        }
    });
}
