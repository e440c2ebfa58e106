//! The terminal mode between two lines, and its restoration at the end.

use std::io::{Write, stdin};

use nix::sys::termios::{InputFlags, LocalFlags, SetArg, Termios, tcgetattr, tcsetattr};
use signal_hook::consts::{SIGHUP, SIGTERM};
use signal_hook::iterator::Signals;

/// Keeps keys that are typed while a command runs for the next line: the terminal neither echoes
/// nor interprets them. Ctrl-c still interrupts. Dropping it restores the terminal.
pub(super) struct KeepTypedAhead(Option<Termios>);

impl KeepTypedAhead {
    pub(super) fn begin() -> Self {
        let Ok(before) = tcgetattr(stdin()) else { return Self(None) };
        let mut raw = before.clone();
        raw.local_flags.remove(LocalFlags::ICANON | LocalFlags::ECHO);
        raw.input_flags.remove(InputFlags::ICRNL);
        // A terminal that rejects this mode still works, except for keys typed ahead.
        let _ = tcsetattr(stdin(), SetArg::TCSADRAIN, &raw);
        restore_on_signal(before.clone());
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

/// Restores the terminal before a signal ends the process, in any state of the editor. The journal
/// has the unsaved changes.
fn restore_on_signal(before: Termios) {
    const STOP_BRACKETED_PASTE: &[u8] = b"\x1b[?2004l\n";
    let Ok(mut signals) = Signals::new([SIGTERM, SIGHUP]) else { return };
    std::thread::spawn(move || {
        if let Some(signal) = signals.forever().next() {
            // A closed terminal needs no restoration.
            let _ = std::io::stdout().write_all(STOP_BRACKETED_PASTE);
            let _ = tcsetattr(stdin(), SetArg::TCSANOW, &before);
            std::process::exit(128 + signal);
        }
    });
}
