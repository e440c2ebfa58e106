//! A real pseudo-terminal with the real binary in it.

use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use portable_pty::{Child, CommandBuilder, PtySize, native_pty_system};

use crate::support::Sandbox;

/// A terminal that shows nothing new for so long is taken to hang.
const HANGING: Duration = Duration::from_secs(120);
pub(crate) const COLUMNS: u16 = 100;
const ROWS: u16 = 40;

/// `superegg` at a terminal of 100 columns and 40 rows, in a sandbox.
pub(crate) struct Terminal {
    child: Box<dyn Child + Send + Sync>,
    keys: Box<dyn Write + Send>,
    output: Receiver<Vec<u8>>,
    screen: vt100::Parser,
    /// Everything that came, escape sequences included.
    pub(crate) raw: String,
    master: Box<dyn portable_pty::MasterPty + Send>,
}

impl Terminal {
    pub(crate) fn open(sandbox: &Sandbox, words: &str) -> Self {
        Self::open_with(sandbox, words, &[])
    }

    /// As [`Terminal::open`], with these variables in the environment.
    pub(crate) fn open_with(sandbox: &Sandbox, words: &str, environment: &[(&str, &str)]) -> Self {
        let size = PtySize { rows: ROWS, cols: COLUMNS, pixel_width: 0, pixel_height: 0 };
        let pair = native_pty_system().openpty(size).unwrap();
        let mut command = CommandBuilder::new(env!("CARGO_BIN_EXE_superegg"));
        command.args(words.split_whitespace());
        command.cwd(sandbox.path(""));
        command.env("TERM", "xterm-256color");
        command.env_remove("DISPLAY");
        command.env_remove("WAYLAND_DISPLAY");
        for name in ["NO_COLOR", "PAGER", "LESS", "CLICOLOR", "CLICOLOR_FORCE"] {
            command.env_remove(name);
        }
        for (name, value) in sandbox.user() {
            command.env(name, value);
        }
        for (name, value) in environment {
            command.env(name, value);
        }
        let child = pair.slave.spawn_command(command).unwrap();
        drop(pair.slave);
        let mut reader = pair.master.try_clone_reader().unwrap();
        let (sender, output) = channel();
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = reader.read(&mut bytes) {
                if sender.send(bytes[..count].to_vec()).is_err() {
                    break;
                }
            }
        });
        let keys = pair.master.take_writer().unwrap();
        let screen = vt100::Parser::new(ROWS.try_into().unwrap(), COLUMNS.try_into().unwrap(), 10_000);
        Self { child, keys, output, screen, raw: String::new(), master: pair.master }
    }

    /// A modeller whose prompt is there.
    pub(crate) fn modeller(sandbox: &Sandbox) -> Self {
        let mut terminal = Self::open(sandbox, "");
        terminal.wait_for("superegg> ");
        terminal
    }

    pub(crate) fn press(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
        self.keys.flush().unwrap();
    }

    /// Types a line, and waits until a new prompt is there.
    #[track_caller]
    pub(crate) fn line(&mut self, line: &str, prompt: &str) {
        self.press(line);
        self.press_and_wait("\r", line, prompt);
    }

    /// Presses keys that end a line, and waits until a new prompt is there.
    #[track_caller]
    pub(crate) fn press_and_wait(&mut self, keys: &str, line: &str, prompt: &str) {
        let before = self.prompts();
        self.press(keys);
        self.wait_until(&format!("{prompt} after {line}"), |terminal| {
            terminal.prompts() > before && last_line(&terminal.contents()) == prompt.trim_end()
        });
    }

    /// How many lines have been read: each begins with turning on the pasting in brackets.
    fn prompts(&self) -> usize {
        self.raw.matches("\x1b[?2004h").count()
    }

    pub(crate) fn contents(&self) -> String {
        self.screen.screen().contents()
    }

    #[track_caller]
    pub(crate) fn wait_for(&mut self, text: &str) {
        self.wait_until(text, |terminal| terminal.contents().contains(text));
    }

    /// Waits until the last line of the screen is as it should be.
    #[track_caller]
    pub(crate) fn wait_for_last(&mut self, what: &str, is_so: impl Fn(&str) -> bool) {
        self.wait_until(what, |terminal| is_so(last_line(&terminal.contents())));
    }

    /// Waits until something is so.
    #[track_caller]
    pub(crate) fn wait_until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !is_so(self) {
            match self.output.recv_timeout(Duration::from_millis(100)) {
                Ok(bytes) => {
                    self.screen.process(&bytes);
                    self.raw.push_str(&String::from_utf8_lossy(&bytes));
                }
                Err(_) => assert!(start.elapsed() < HANGING, "no '{what}' comes:\n{}", self.contents()),
            }
        }
    }

    /// The exit code, once the program has left.
    #[track_caller]
    pub(crate) fn left(&mut self) -> u32 {
        let start = Instant::now();
        loop {
            while let Ok(bytes) = self.output.try_recv() {
                self.screen.process(&bytes);
            }
            if let Some(status) = self.child.try_wait().unwrap() {
                return status.exit_code();
            }
            assert!(start.elapsed() < HANGING, "it does not leave:\n{}", self.contents());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// As `kill` does.
    pub(crate) fn end_by_signal(&self) {
        let process = nix::unistd::Pid::from_raw(i32::try_from(self.child.process_id().unwrap()).unwrap());
        nix::sys::signal::kill(process, nix::sys::signal::Signal::SIGTERM).unwrap();
    }

    /// Whether the terminal itself shows what is typed.
    pub(crate) fn echoes(&self) -> bool {
        use nix::sys::termios::LocalFlags;
        // The terminal's crate has another version of these flags.
        let flags = LocalFlags::from_bits_truncate(self.master.get_termios().unwrap().local_flags.bits());
        flags.contains(LocalFlags::ECHO | LocalFlags::ICANON)
    }

    pub(crate) fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
    }
}

/// The last line that has anything on it.
fn last_line(screen: &str) -> &str {
    screen.trim_end().lines().next_back().unwrap_or_default().trim_end()
}
