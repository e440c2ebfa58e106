//! Reads scene files and the files that they source.

use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Result, bail};
use superegg_exchange::read::Input;
use superegg_geom::Aabb;
use superegg_lang::{
    Diagnostic, Effect, Fault, FaultCode, Flow, Request, Session, Settings, Severity, find_command, nearest,
    run_script, write_session,
};

use crate::annotate::Legend;
use crate::console;
use crate::files::access;
use crate::files::binary_scene::{self, open_input};
use crate::files::data::{self, DataOptions, FileKind, LoadedData, Note};
use crate::files::folders::Folders;
use crate::files::names::{folder_of, found_in, rename_for, unreadable};
use crate::files::no_scene::kind_of_no_scene;
use crate::files::surroundings::unreadable_picture;

/// The maximum nesting of sourced files.
const MOST_NESTED: usize = 16;
/// The maximum number of sourced files in all.
const MOST_SOURCED: usize = 1000;
/// The maximum number of bytes of files that are read again. Few lines can load a large file many
/// times.
const MOST_REPEATED_BYTES: u64 = 1 << 28;

/// A scene file as read, with its diagnostics; by default a new scene.
#[derive(Default)]
pub(crate) struct Loaded {
    pub(crate) session: Session,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// The lines that define the scene, with those of sourced files inserted; empty unless they are
    /// kept.
    pub(crate) lines: String,
    /// The output of the lines.
    pub(crate) prints: Vec<String>,
    /// How data of another program was read, one line each.
    pub(crate) notes: Vec<Note>,
    /// The legend of data that a column colours.
    pub(crate) legend: Option<Legend>,
    /// The index of the frame of data.
    pub(crate) frame: usize,
    /// The box of data that its camera shows.
    pub(crate) bounds: Option<Aabb>,
    /// Whether the user interrupted the load.
    pub(crate) is_interrupted: bool,
}

impl Loaded {
    /// Prints the notes and diagnostics on standard error.
    pub(crate) fn print_diagnostics(&self) {
        self.print_warnings(false);
    }

    /// Prints how data was read; if `is_quiet`, only its warnings.
    fn print_notes(&self, is_quiet: bool) {
        let notes = self.notes.iter().filter(|note| !is_quiet || note.is_warning());
        notes.for_each(|note| console::warn(format_args!("superegg: {note}")));
    }

    /// As [`Loaded::print_diagnostics`], without notes that are no warnings if `is_quiet`.
    pub(crate) fn print_warnings(&self, is_quiet: bool) {
        self.print_notes(is_quiet);
        self.diagnostics.iter().for_each(console::warn);
    }

    pub(crate) fn error_count(&self) -> usize {
        let errors = self.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error);
        errors.map(|diagnostic| diagnostic.count).sum()
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.error_count() > 0
    }

    /// Whether the file is a scene of which nothing is missing, so that saving to it loses nothing.
    pub(crate) fn is_whole_scene(&self) -> bool {
        self.bounds.is_none() && !self.has_errors()
    }

    /// The root of a command: `name`, or by default the final selection of the scene.
    ///
    /// # Errors
    /// The scene has no primitive or object called `name`.
    fn root(&self, name: Option<&str>) -> Result<Option<String>> {
        let Some(name) = name else { return Ok(self.session.selected().map(str::to_owned)) };
        if self.session.scene().get(name).is_some() {
            return Ok(Some(name.to_owned()));
        }
        match nearest(name, self.session.scene().entities().map(|(name, _)| name)) {
            Some(near) => bail!("the scene has nothing named '{name}'; did you mean '{near}'?"),
            None => bail!("the scene has nothing named '{name}'; 'superegg info SCENE' lists what it has"),
        }
    }

    /// The root of a command; prints a warning if there is none.
    ///
    /// # Errors
    /// The scene has no primitive or object called `name`.
    pub(crate) fn root_or_warn(&self, name: Option<&str>) -> Result<Option<String>> {
        let root = self.root(name)?;
        if root.is_none() {
            console::warn(
                "superegg: warning: nothing is selected at the end of the scene, so it is empty; --object NAME selects an object",
            );
        }
        Ok(root)
    }
}

/// Reads a scene file. Errors in its lines are diagnostics of the result.
///
/// # Errors
/// The file cannot be read.
pub(crate) fn load(path: &Path) -> Result<Loaded> {
    load_with(path, &DataOptions::default())
}

/// Like [`load`]; reads a file of another program with these options.
pub(crate) fn load_with(path: &Path, options: &DataOptions) -> Result<Loaded> {
    match load_data(path, options)? {
        Some(loaded) => Ok(loaded),
        None => load_lines(path, Settings::default(), Lines::Dropped, &AtomicBool::new(false)),
    }
}

/// A binary scene or a data file of another program as a scene; `None` for any other file.
fn load_data(path: &Path, options: &DataOptions) -> Result<Option<Loaded>> {
    if access::is_standard_stream(path) && !options.are_for_data() || !path.is_file() {
        return Ok(None);
    }
    load_data_from(path, &mut *open_input(path)?, options)
}

/// As [`load_data`], of a file that is open.
fn load_data_from(path: &Path, input: &mut dyn Input, options: &DataOptions) -> Result<Option<Loaded>> {
    let (session, diagnostics, notes, legend, frame, bounds) = match data::kind_of(input, options)? {
        FileKind::Text => return Ok(None),
        FileKind::Binary => {
            let (session, diagnostics) = binary_scene::load(path, input)?;
            (session, diagnostics, Vec::new(), None, 0, None)
        }
        FileKind::Data => {
            let LoadedData { session, notes, key, frame, bounds } = data::load(path, input, options)?;
            (session, Vec::new(), notes, Legend::of(&options.coloring, &key), frame, Some(bounds))
        }
    };
    let (lines, prints, is_interrupted) = (String::new(), Vec::new(), false);
    Ok(Some(Loaded { session, diagnostics, lines, prints, notes, legend, frame, bounds, is_interrupted }))
}

/// As [`load_with`], of the bytes of a file. `path` stands for it in messages, and is where files
/// that it names are searched.
pub(crate) fn load_bytes(path: &Path, bytes: &[u8], options: &DataOptions) -> Result<Loaded> {
    match load_data_from(path, &mut Cursor::new(bytes), options)? {
        Some(loaded) => Ok(loaded),
        None => run_lines(path, bytes, Settings::default(), Lines::Dropped, &AtomicBool::new(false)),
    }
}

/// Tables of at most this many rows are journalled as lines; larger ones as the file to load again.
const MOST_JOURNALLED: usize = 10_000;

/// The lines that make a scene, for history and journal.
pub(crate) fn lines_of(path: &Path, session: &Session) -> String {
    let rows: usize = session.scene().tables().map(|(_, table)| table.len()).sum();
    if rows <= MOST_JOURNALLED {
        return write_session(session);
    }
    format!("load \"{}\"\n", identity(path).display())
}

/// Like [`load`], into a session with these settings, and keeps the lines. The files that the scene names
/// are then found from the working folder. Stops when `interrupt` becomes true.
pub(crate) fn load_into(path: &Path, settings: Settings, interrupt: &AtomicBool) -> Result<Loaded> {
    if let Some(mut loaded) = load_data(path, &DataOptions::default())? {
        loaded.session.settings = settings;
        rename_for(&mut loaded.session, folder_of(path), Path::new(""));
        loaded.lines = lines_of(path, &loaded.session);
        return Ok(loaded);
    }
    let mut loaded = load_lines(path, settings, Lines::Kept, interrupt)?;
    if rename_for(&mut loaded.session, folder_of(path), Path::new("")) {
        loaded.lines = write_session(&loaded.session);
    }
    Ok(loaded)
}

/// The fate of the lines of a scene file. Large ones take as much memory as the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lines {
    Kept,
    Dropped,
}

fn load_lines(path: &Path, settings: Settings, kept: Lines, interrupt: &AtomicBool) -> Result<Loaded> {
    run_lines(path, &access::read(path)?, settings, kept, interrupt)
}

/// Runs the lines of the file `path`, which has these bytes.
fn run_lines(
    path: &Path,
    bytes: &[u8],
    settings: Settings,
    kept: Lines,
    interrupt: &AtomicBool,
) -> Result<Loaded> {
    if let Some(kind) = kind_of_no_scene(bytes) {
        bail!("'{}' is not a scene but {kind}", path.display());
    }
    if bytes.contains(&0) {
        let line = 1 + bytes.iter().take_while(|&&byte| byte != 0).filter(|&&byte| byte == b'\n').count();
        bail!("'{}' is not a scene: line {line} has a zero byte, which no text has", path.display());
    }
    let mut session = Session::default();
    session.settings = settings;
    let mut loader = Loader {
        open: vec![identity(path)],
        sourced: 0,
        seen: HashSet::new(),
        repeated_bytes: 0,
        kept,
        lines: String::new(),
        prints: Vec::new(),
        interrupt,
        is_interrupted: false,
    };
    let mut diagnostics = Vec::new();
    loader.run(&mut session, path, bytes, &mut diagnostics);
    let Loader { lines, prints, is_interrupted, .. } = loader;
    let (notes, legend, frame, bounds) = (Vec::new(), None, 0, None);
    Ok(Loaded { session, diagnostics, lines, prints, notes, legend, frame, bounds, is_interrupted })
}

/// The canonical path, equal for all names of a file.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The state of a load.
struct Loader<'a> {
    /// The files being read, outermost first.
    open: Vec<PathBuf>,
    /// The number of sourced files so far.
    sourced: usize,
    /// The sourced files so far.
    seen: HashSet<PathBuf>,
    /// The lengths of those that were sourced again.
    repeated_bytes: u64,
    kept: Lines,
    lines: String,
    prints: Vec<String>,
    interrupt: &'a AtomicBool,
    is_interrupted: bool,
}

impl Loader<'_> {
    /// Runs the lines of a file.
    fn run(
        &mut self,
        session: &mut Session,
        path: &Path,
        bytes: &[u8],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Flow {
        let folder = folder_of(path).to_owned();
        let name = path.display().to_string();
        run_script(session, &name, bytes, diagnostics, &mut |session, line, effect, diagnostics| {
            if self.interrupt.load(Ordering::Relaxed) {
                self.is_interrupted = true;
                return Ok(Flow::Stop);
            }
            if let Some(fault) = unreadable_picture(line, &effect, &folder) {
                return Err(fault);
            }
            // Nearly every line.
            if self.kept == Lines::Dropped && matches!(effect, Effect::Changed(None)) {
                return Ok(Flow::Continue);
            }
            self.perform(session, line, effect, &folder, diagnostics)
        })
    }

    /// Applies the effect of a line. Commands with side effects are not run.
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
            Effect::Changed(note) => {
                if self.kept == Lines::Kept {
                    self.lines.push_str(line.trim());
                    self.lines.push('\n');
                }
                match note.filter(|_| sets_quaternion(line)) {
                    Some(note) => Err(Fault::new(FaultCode::Quaternion, note).warning()),
                    None => Ok(Flow::Continue),
                }
            }
            Effect::Print(text) => {
                self.prints.push(text);
                Ok(Flow::Continue)
            }
            Effect::Request(Request::Stop) => Ok(Flow::Stop),
            Effect::Request(Request::Source { file, .. }) => {
                self.source(session, file.as_deref(), folder, diagnostics)
            }
            Effect::Request(Request::Include(file)) => self.include(session, &file, folder, diagnostics),
            Effect::Request(_) => {
                let command = line.split_whitespace().next().unwrap_or_default();
                let message = format!("{command} is not carried out when a scene is only read");
                let fault = Fault::new(FaultCode::NotHere, message);
                Err(fault.help("'superegg run FILE' runs all commands of a file").warning())
            }
        }
    }

    /// Clears the session and runs another file. Searches the working folder, then the folder of
    /// the current file.
    fn source(
        &mut self,
        session: &mut Session,
        file: Option<&str>,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        let folders = Folders::of_user();
        let typed = file.map_or_else(|| folders.quicksave_to_load(), |file| folders.expand(file));
        let path = self.find_nested(&typed, folder)?;
        let bytes = read_nested(&path)?;
        session.clear();
        self.lines.clear();
        self.open.push(identity(&path));
        let flow = self.run(session, &path, &bytes, diagnostics);
        self.open.pop();
        if rename_for(session, folder_of(&path), folder) && self.kept == Lines::Kept {
            self.lines = write_session(session);
        }
        Ok(flow)
    }

    /// Adds the contents of another file to the session. Searches as [`Self::source`].
    fn include(
        &mut self,
        session: &mut Session,
        file: &str,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        let path = self.find_nested(&Folders::of_user().expand(file), folder)?;
        let mut added = match load_data(&path, &DataOptions::default()).map_err(|error| unreadable(&error))? {
            Some(loaded) => loaded.session,
            None => {
                let bytes = read_nested(&path)?;
                let mut added = Session::default();
                let lines = std::mem::take(&mut self.lines);
                self.open.push(identity(&path));
                self.run(&mut added, &path, &bytes, diagnostics);
                self.open.pop();
                self.lines = lines;
                added
            }
        };
        if self.is_interrupted {
            return Ok(Flow::Stop);
        }
        rename_for(&mut added, folder_of(&path), folder);
        let lines = session.lines_to_include(&added)?;
        for line in lines.lines() {
            session.run_line(line)?;
        }
        if self.kept == Lines::Kept {
            self.lines.push_str(&lines);
        }
        Ok(Flow::Continue)
    }

    /// Finds a file that another one names: in the working folder, else in `folder`.
    fn find_nested(&mut self, typed: &Path, folder: &Path) -> Result<PathBuf, Fault> {
        let path = found_in(typed, folder);
        self.sourced += 1;
        if self.open.contains(&identity(&path)) {
            let message = format!("'{}' would be read within itself", typed.display());
            let fault = Fault::new(FaultCode::SourceCycle, message);
            return Err(fault.help("a file cannot load or include itself, directly or through others"));
        }
        if self.open.len() >= MOST_NESTED || self.sourced > MOST_SOURCED {
            let fault =
                Fault::new(FaultCode::SourceLimit, format!("'{}' is one file too many", typed.display()));
            let help = format!(
                "files load and include each other {MOST_NESTED} deep at most, and {MOST_SOURCED} files in all"
            );
            return Err(fault.help(help));
        }
        if !self.seen.insert(identity(&path)) {
            self.repeated_bytes += path.metadata().map_or(0, |metadata| metadata.len());
        }
        if self.repeated_bytes > MOST_REPEATED_BYTES {
            let message = format!("'{}' is loaded once too often", typed.display());
            let help = format!(
                "files that are loaded again may have {} MiB together; load each once",
                MOST_REPEATED_BYTES >> 20
            );
            return Err(Fault::new(FaultCode::SourceLimit, message).help(help));
        }
        Ok(path)
    }
}

/// Reads a scene file that another one names.
fn read_nested(path: &Path) -> Result<Vec<u8>, Fault> {
    let bytes = access::read(path).map_err(|error| unreadable(&error))?;
    match kind_of_no_scene(&bytes) {
        Some(kind) => {
            let message = format!("'{}' is not a scene but {kind}", path.display());
            Err(Fault::new(FaultCode::NotText, message).help("load and include read scene files"))
        }
        None => Ok(bytes),
    }
}

/// Whether a line rotates by a quaternion.
fn sets_quaternion(line: &str) -> bool {
    let first = line.split_whitespace().next().unwrap_or_default();
    find_command(first).is_some_and(|spec| ["orient", "orientAll"].contains(&spec.name))
}
