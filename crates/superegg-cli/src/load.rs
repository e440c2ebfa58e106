//! Scene files, and the files that they source.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Result, bail};
use superegg_lang::{
    Diagnostic, Effect, Fault, Flow, Request, Session, Settings, Severity, nearest, run_script,
};

use crate::files;
use crate::folders::Folders;
use crate::say;

/// Files may source files so deep.
const MOST_NESTED: usize = 16;
/// One file may have so many files sourced in all.
const MOST_SOURCED: usize = 1000;

/// A scene as read, with what was found wrong.
pub(crate) struct Loaded {
    pub(crate) session: Session,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// The lines that made the scene, those of sourced files in their places.
    pub(crate) lines: String,
    /// What the lines of the file asked to be shown.
    pub(crate) prints: Vec<String>,
    /// Whether it was broken off.
    pub(crate) is_interrupted: bool,
}

impl Loaded {
    /// Prints what was found, to standard error.
    pub(crate) fn print_diagnostics(&self) {
        self.diagnostics.iter().for_each(say::complain);
    }

    pub(crate) fn error_count(&self) -> usize {
        self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count()
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.error_count() > 0
    }

    /// The name that a command works on: the one asked for, or the one selected at the end, if any.
    fn root(&self, asked: Option<&str>) -> Result<Option<String>> {
        let Some(name) = asked else { return Ok(self.session.selected().map(str::to_owned)) };
        if self.session.scene().get(name).is_some() {
            return Ok(Some(name.to_owned()));
        }
        match nearest(name, self.session.scene().entities().map(|(name, _)| name)) {
            Some(near) => bail!("the scene has nothing named '{name}'; did you mean '{near}'?"),
            None => bail!("the scene has nothing named '{name}'; 'superegg info SCENE' lists what it has"),
        }
    }

    /// The root for a command that needs one to say anything of use; a warning where there is none.
    pub(crate) fn root_or_warn(&self, asked: Option<&str>) -> Result<Option<String>> {
        let root = self.root(asked)?;
        if root.is_none() {
            say::complain(
                "superegg: warning: nothing is selected at the end of the scene, so it is empty; --object NAME takes an object",
            );
        }
        Ok(root)
    }
}

/// Reads a scene file. Errors in it are in the answer; a file that cannot be read is an error.
pub(crate) fn load(path: &Path) -> Result<Loaded> {
    load_into(path, Settings::default(), &AtomicBool::new(false))
}

/// The same into a session with these settings, broken off when `interrupt` turns true.
pub(crate) fn load_into(path: &Path, settings: Settings, interrupt: &AtomicBool) -> Result<Loaded> {
    let bytes = files::read(path)?;
    if bytes.contains(&0) {
        let line = 1 + bytes.iter().take_while(|&&byte| byte != 0).filter(|&&byte| byte == b'\n').count();
        bail!("'{}' is not a scene: line {line} has a zero byte, which no text has", path.display());
    }
    let mut session = Session::default();
    session.settings = settings;
    let mut loader = Loader {
        open: vec![identity(path)],
        sourced: 0,
        lines: String::new(),
        prints: Vec::new(),
        interrupt,
        is_interrupted: false,
    };
    let mut diagnostics = Vec::new();
    loader.run(&mut session, path, &bytes, &mut diagnostics);
    let Loader { lines, prints, is_interrupted, .. } = loader;
    Ok(Loaded { session, diagnostics, lines, prints, is_interrupted })
}

/// The same for every way of writing a file's name.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

struct Loader<'a> {
    /// The files that are being read, outermost first.
    open: Vec<PathBuf>,
    /// How many files have been sourced.
    sourced: usize,
    lines: String,
    prints: Vec<String>,
    interrupt: &'a AtomicBool,
    is_interrupted: bool,
}

impl Loader<'_> {
    fn run(
        &mut self,
        session: &mut Session,
        path: &Path,
        bytes: &[u8],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Flow {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let name = path.display().to_string();
        run_script(session, &name, bytes, diagnostics, &mut |session, line, effect, diagnostics| {
            if self.interrupt.load(Ordering::Relaxed) {
                self.is_interrupted = true;
                return Ok(Flow::Stop);
            }
            self.perform(session, line.trim(), effect, &folder, diagnostics)
        })
    }

    fn perform(
        &mut self,
        session: &mut Session,
        line: &str,
        effect: Effect,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        match effect {
            Effect::Done => Ok(Flow::Continue),
            Effect::Changed(_) => {
                self.lines.push_str(line);
                self.lines.push('\n');
                Ok(Flow::Continue)
            }
            Effect::Print(text) => {
                self.prints.push(text);
                Ok(Flow::Continue)
            }
            Effect::Ask(Request::Stop) => Ok(Flow::Stop),
            Effect::Ask(Request::Source { file, .. }) => {
                self.source(session, file.as_deref(), folder, diagnostics)
            }
            Effect::Ask(_) => {
                let command = line.split_whitespace().next().unwrap_or_default();
                let message = format!("{command} is not carried out when a scene is only read");
                let fault = Fault::new("not-here", message);
                Err(fault.help("'superegg run FILE' runs a file with all that it says").warning())
            }
        }
    }

    /// Clears the session and runs a file, looked for in the working folder and then beside the file that names it.
    fn source(
        &mut self,
        session: &mut Session,
        file: Option<&str>,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        let folders = Folders::of_user();
        let typed = file.map_or_else(|| folders.quicksave_to_load(), |file| folders.expand(file));
        // Not the bare name: '-' is a file here, not standard input.
        let candidates = [Path::new(".").join(&typed), folder.join(&typed)];
        let path = candidates.iter().find(|path| path.exists()).unwrap_or(&candidates[0]);
        self.sourced += 1;
        if self.open.contains(&identity(path)) {
            let message = format!("'{}' would be read within itself", typed.display());
            let fault = Fault::new("source-circle", message);
            return Err(fault.help("a file cannot source itself, directly or through others"));
        }
        if self.open.len() >= MOST_NESTED || self.sourced > MOST_SOURCED {
            let fault = Fault::new("source-limit", format!("'{}' is one file too many", typed.display()));
            let help = format!(
                "files source each other {MOST_NESTED} deep at most, and {MOST_SOURCED} files in all"
            );
            return Err(fault.help(help));
        }
        let bytes = files::read(path).map_err(|error| {
            Fault::new("unreadable", format!("{error:#}"))
                .help("the name is looked for in the working folder, then beside this file")
        })?;
        session.clear();
        self.lines.clear();
        self.open.push(identity(path));
        let flow = self.run(session, path, &bytes, diagnostics);
        self.open.pop();
        Ok(flow)
    }
}
