//! Scene files, and the files that they source.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use superegg_lang::{Diagnostic, Effect, Fault, Flow, Session, Severity, nearest, run_script, write_session};

use crate::files;
use crate::say;

/// Where `source` and `save` go without a file.
const QUICKSAVE: &str = "data/quicksave.scn";
/// Files may source files so deep.
const MOST_NESTED: usize = 16;
/// One file may have so many files sourced in all.
const MOST_SOURCED: usize = 1000;

/// What the commands of a file may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Describe a scene, sourcing other files; nothing is written or printed.
    Scene,
    /// All that they say.
    Session,
}

/// A scene as read, with what was found wrong.
pub(crate) struct Loaded {
    pub(crate) session: Session,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// How many of them a session has told while it ran.
    told: usize,
}

impl Loaded {
    /// Prints what was found and not yet told, to standard error.
    pub(crate) fn print_diagnostics(&self) {
        self.diagnostics[self.told..].iter().for_each(say::complain);
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

/// Reads a file of commands. Errors in it are in the answer; a file that cannot be read is an error.
pub(crate) fn load(path: &Path, mode: Mode) -> Result<Loaded> {
    let bytes = files::read(path)?;
    let mut loaded = Loaded { session: Session::default(), diagnostics: Vec::new(), told: 0 };
    let mut loader = Loader { mode, open: vec![identity(path)], sourced: 0, told: 0 };
    loader.run(&mut loaded.session, path, &bytes, &mut loaded.diagnostics);
    loaded.told = loader.told;
    Ok(loaded)
}

/// The same for every way of writing a file's name.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

struct Loader {
    mode: Mode,
    /// The files that are being read, outermost first.
    open: Vec<PathBuf>,
    /// How many files have been sourced.
    sourced: usize,
    /// How many diagnostics have been told.
    told: usize,
}

impl Loader {
    fn run(
        &mut self,
        session: &mut Session,
        path: &Path,
        bytes: &[u8],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Flow {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let name = path.display().to_string();
        run_script(session, &name, bytes, diagnostics, &mut |session, effect, diagnostics| {
            self.perform(session, effect, &folder, diagnostics)
        })
    }

    fn perform(
        &mut self,
        session: &mut Session,
        effect: Effect,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        match effect {
            Effect::Done => Ok(Flow::Continue),
            Effect::Stop => Ok(Flow::Stop),
            Effect::Source(file) => {
                self.source(session, file.as_deref().unwrap_or(QUICKSAVE), folder, diagnostics)
            }
            Effect::Print(text) => {
                if self.mode == Mode::Session {
                    // What was wrong before comes before.
                    diagnostics[self.told..].iter().for_each(say::complain);
                    self.told = diagnostics.len();
                    say::out(text).map_err(|error| Fault::new("unwritable", format!("{error:#}")))?;
                }
                Ok(Flow::Continue)
            }
            Effect::Save(file) if self.mode == Mode::Session => {
                save(session, Path::new(file.as_deref().unwrap_or(QUICKSAVE)))?;
                Ok(Flow::Continue)
            }
            Effect::Save(_) => {
                Err(Fault::new("not-here", "save is not carried out when a scene is only read")
                    .help("'superegg run FILE' runs a file with all that it says")
                    .warning())
            }
            Effect::Interact => {
                Err(Fault::new("not-here", "there is no viewer here to hand the keyboard to")
                    .help("leave the line out")
                    .warning())
            }
        }
    }

    /// Clears the session and runs a file, looked for in the working folder and then beside the file that names it.
    fn source(
        &mut self,
        session: &mut Session,
        file: &str,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        // Not the bare name: '-' is a file here, not standard input.
        let candidates = [Path::new(".").join(file), folder.join(file)];
        let path = candidates.iter().find(|path| path.exists()).unwrap_or(&candidates[0]);
        self.sourced += 1;
        let is_too_much = self.open.len() >= MOST_NESTED || self.sourced > MOST_SOURCED;
        if self.open.contains(&identity(path)) || is_too_much {
            let message = format!("'{file}' would be read within itself, too deep or too often");
            let fault = Fault::new("source-circle", message);
            return Err(fault.help("a file cannot source itself, directly or through others"));
        }
        let bytes = files::read(path).map_err(|error| {
            Fault::new("unreadable", format!("{error:#}"))
                .help("the name is looked for in the working folder, then beside this file")
        })?;
        session.clear();
        self.open.push(identity(path));
        let flow = self.run(session, path, &bytes, diagnostics);
        self.open.pop();
        Ok(flow)
    }
}

fn save(session: &Session, path: &Path) -> Result<(), Fault> {
    let is_quicksave = path == Path::new(QUICKSAVE);
    let made = if is_quicksave { std::fs::create_dir_all("data").map_err(Into::into) } else { Ok(()) };
    made.and_then(|()| files::write(path, write_session(session).as_bytes())).map_err(
        |error: anyhow::Error| {
            Fault::new("unwritable", format!("{error:#}"))
                .help("name a file in a folder that can be written to")
        },
    )
}
