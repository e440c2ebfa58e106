//! A display of our own with the real program in a window on it, used through keys and pointer.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use image::RgbImage;
use tempfile::TempDir;

/// Polls before a test gives up: no measure of speed, but the end of a wait for what does not come.
const PATIENCE: usize = 600;
const POLL: Duration = Duration::from_millis(100);

/// Servers that start at a time take each other's numbers.
static TURN: Mutex<()> = Mutex::new(());

/// An X server without a screen, the only one of the tests. Dropping it ends it.
pub(crate) struct Display {
    _turn: MutexGuard<'static, ()>,
    server: Child,
    name: String,
}

impl Display {
    /// Starts one, or says why not.
    pub(crate) fn start() -> Result<Self, String> {
        for tool in ["Xvfb", "xdotool", "import"] {
            let found = Command::new("which").arg(tool).stdout(Stdio::null()).status();
            if !found.is_ok_and(|status| status.success()) {
                return Err(format!("{tool} is not on this machine"));
            }
        }
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        // Without -noreset a server begins anew when its last client leaves, and refuses connections meanwhile.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-noreset", "-screen", "0", "1280x900x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| error.to_string())?;
        let mut number = String::new();
        if let Some(stdout) = server.stdout.take() {
            let _ = BufReader::new(stdout).read_line(&mut number);
        }
        if number.trim().is_empty() {
            let _ = server.kill();
            let _ = server.wait();
            return Err("Xvfb does not start".to_owned());
        }
        let display = Self { _turn: turn, server, name: format!(":{}", number.trim()) };
        // A server writes its number a moment before it takes connections.
        for _ in 0..PATIENCE {
            if display.takes_connections() {
                return Ok(display);
            }
            sleep(POLL);
        }
        Err("Xvfb takes no connections".to_owned())
    }

    fn takes_connections(&self) -> bool {
        let mut probe = Command::new("xdotool");
        let probe = probe.arg("getdisplaygeometry").env("DISPLAY", &self.name);
        probe.output().is_ok_and(|output| output.status.success())
    }

    pub(crate) fn kill(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }

    fn tool(&self, name: &str, args: &[&str]) -> Vec<u8> {
        let output = Command::new(name).args(args).env("DISPLAY", &self.name).output();
        output.unwrap_or_else(|error| panic!("{name}: {error}")).stdout
    }

    fn screenshot(&self) -> RgbImage {
        let png = self.tool("import", &["-window", "root", "png:-"]);
        image::load_from_memory(&png).expect("a screenshot").to_rgb8()
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        self.kill();
    }
}

/// The program with its window.
pub(crate) struct Viewer {
    pub(crate) display: Display,
    pub(crate) folder: TempDir,
    process: Child,
    report: Arc<Mutex<String>>,
}

impl Viewer {
    /// Opens a file of this name and text with these options, or says why that cannot be tried here.
    pub(crate) fn open_file(name: &str, text: &str, options: &[&str]) -> Result<Self, String> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(name), text).expect("a file");
        Self::open_in(folder, name, options)
    }

    /// Opens a file of a folder with these options, or says why that cannot be tried here.
    pub(crate) fn open_in(folder: TempDir, name: &str, options: &[&str]) -> Result<Self, String> {
        let mut program = Command::new(env!("CARGO_BIN_EXE_superegg"));
        program.args(["view", name]).args(options);
        Self::start(program, folder)
    }

    /// Opens the prompt at a terminal that `script` makes, with the window beside it, or says why
    /// that cannot be tried here.
    pub(crate) fn open_beside_prompt() -> Result<Self, String> {
        let can_script =
            Command::new("script").args(["-qec", "true", "/dev/null"]).stdin(Stdio::null()).output();
        if !can_script.is_ok_and(|output| output.status.success()) {
            return Err("script (util-linux) is not on this machine".to_owned());
        }
        let mut program = Command::new("script");
        program.args(["-qec", env!("CARGO_BIN_EXE_superegg"), "/dev/null"]).stdin(Stdio::piped());
        Self::start(program, tempfile::tempdir().expect("a folder"))
    }

    fn start(mut program: Command, folder: TempDir) -> Result<Self, String> {
        let display = Display::start()?;
        for name in ["HOME", "XDG_RUNTIME_DIR", "XDG_STATE_HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME"] {
            program.env(name, folder.path());
        }
        let mut process = program
            .current_dir(folder.path())
            .env("DISPLAY", &display.name)
            .env("TERM", "xterm-256color")
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program");
        let report = Arc::new(Mutex::new(String::new()));
        let streams: [Option<Box<dyn Read + Send>>; 2] = [
            process.stdout.take().map(|stream| Box::new(stream) as Box<dyn Read + Send>),
            process.stderr.take().map(|stream| Box::new(stream) as Box<dyn Read + Send>),
        ];
        for stream in streams.into_iter().flatten() {
            let report = Arc::clone(&report);
            std::thread::spawn(move || {
                for line in BufReader::new(stream).lines().map_while(Result::ok) {
                    *report.lock().expect("the text") += &format!("{line}\n");
                }
            });
        }
        let mut viewer = Self { display, folder, process, report };
        for _ in 0..PATIENCE {
            if viewer.report().contains("no graphics driver") {
                return Err("there is no graphics driver on this machine".to_owned());
            }
            let windows = viewer.display.tool("xdotool", &["search", "--onlyvisible", "--name", "Superegg$"]);
            if let Some(window) = String::from_utf8_lossy(&windows).lines().next() {
                viewer.xdotool(&["windowmove", window, "0", "0"]);
                viewer.xdotool(&["windowsize", window, "1000", "760"]);
                viewer.xdotool(&["windowfocus", window]);
                viewer.settled();
                return Ok(viewer);
            }
            assert!(viewer.process.try_wait().expect("a process").is_none(), "it ended: {}", viewer.report());
            sleep(POLL);
        }
        panic!("no window: {}", viewer.report());
    }

    /// Types a line at the prompt.
    pub(crate) fn line(&mut self, line: &str) {
        let keys = self.process.stdin.as_mut().expect("a prompt");
        writeln!(keys, "{line}").expect("the prompt takes it");
    }

    pub(crate) fn report(&self) -> String {
        self.report.lock().expect("the text").clone()
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn xdotool(&self, args: &[&str]) {
        self.display.tool("xdotool", args);
    }

    pub(crate) fn window(&self) -> String {
        let windows = self.display.tool("xdotool", &["search", "--name", "Superegg$"]);
        String::from_utf8_lossy(&windows).lines().next().unwrap_or_default().to_owned()
    }

    /// Waits until the title of the window is this.
    pub(crate) fn wait_for_title(&self, title: &str) {
        for _ in 0..PATIENCE {
            if self.display.tool("xdotool", &["search", "--name", &format!("^{title}$")]).is_empty() {
                sleep(POLL);
            } else {
                return;
            }
        }
        panic!("the title is never '{title}'; it reports: {}", self.report());
    }

    /// Ends the program as a crash does, and returns the folder that it worked in.
    pub(crate) fn crash(mut self) -> TempDir {
        let _ = self.process.kill();
        let _ = self.process.wait();
        std::mem::replace(&mut self.folder, tempfile::tempdir().expect("a folder"))
    }

    /// The picture once it stays the same.
    pub(crate) fn settled(&self) -> RgbImage {
        let mut last = self.display.screenshot();
        let mut equal = 0;
        for _ in 0..PATIENCE {
            sleep(POLL);
            let next = self.display.screenshot();
            equal = if next == last { equal + 1 } else { 0 };
            last = next;
            if equal >= 4 {
                return last;
            }
        }
        panic!("the picture never rests");
    }

    /// Does something and waits for a picture that holds.
    pub(crate) fn until(
        &self,
        what: &str,
        act: impl FnOnce(&Self),
        holds: impl Fn(&RgbImage) -> bool,
    ) -> RgbImage {
        act(self);
        for _ in 0..PATIENCE / 20 {
            let picture = self.settled();
            if holds(&picture) {
                return picture;
            }
        }
        let name = format!("{}.png", what.replace(|c: char| !c.is_alphanumeric(), "_"));
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
        let _ = self.display.screenshot().save(folder.join(&name));
        panic!(
            "{what}: never so; the screen is in {}; it report: {}",
            folder.join(name).display(),
            self.report()
        );
    }

    pub(crate) fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    pub(crate) fn drag(&self, button: &str, from: (i32, i32), to: (i32, i32)) {
        let sandbox = |(x, y): (i32, i32)| [x.to_string(), y.to_string()];
        let ([x, y], [to_x, to_y]) = (sandbox(from), sandbox(to));
        let middle = sandbox(((from.0 + to.0) / 2, (from.1 + to.1) / 2));
        self.xdotool(&["mousemove", &x, &y, "mousedown", button]);
        self.xdotool(&["mousemove", &middle[0], &middle[1], "mousemove", &to_x, &to_y, "mouseup", button]);
    }

    pub(crate) fn wait_until_said(&self, text: &str) {
        for _ in 0..PATIENCE {
            if self.report().contains(text) {
                return;
            }
            sleep(POLL);
        }
        panic!("it never report '{text}', but: {}", self.report());
    }

    /// Waits for the end of the program. Returns its exit code.
    pub(crate) fn exit_code(&mut self) -> Option<i32> {
        for _ in 0..PATIENCE {
            if let Some(status) = self.process.try_wait().expect("a process") {
                return status.code();
            }
            sleep(POLL);
        }
        panic!("it does not end: {}", self.report());
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
