//! Scene files, with the files and pictures that they name.
//!
//! A name is searched in the working folder, then beside the file that has the line.

use std::fs;
use std::path::{Path, PathBuf};

use superegg_lang::{Diagnostic, Effect, Fault, FaultCode, Flow, Request, Session, run_script};
use superegg_render::{EnvironmentPixels, RenderSettings, TexturePixels, TextureSet};
use superegg_scene::{Scene, TextureChannel};

use crate::error::Error;

/// The most files that include each other, one in the other.
const MOST_NESTED: usize = 16;
/// The most files that a scene includes.
const MOST_FILES: usize = 1000;

/// Runs the lines of a text that has no folder: lines that read other files are errors.
pub(crate) fn run_text(name: &str, text: &str) -> (Session, Vec<Diagnostic>) {
    let (mut session, mut diagnostics) = (Session::default(), Vec::new());
    run_script(&mut session, name, text.as_bytes(), &mut diagnostics, &mut |_, _, effect, _| match effect {
        Effect::Request(Request::Include(_) | Request::Source { .. }) => {
            let fault = Fault::new(FaultCode::NotHere, "a text cannot read other files");
            Err(fault.help("Model::load reads a scene file and the files that it names"))
        }
        effect => Ok(flow_after(&effect)),
    });
    (session, diagnostics)
}

/// Runs the lines of a file and of those that it includes or loads.
///
/// # Errors
/// The file cannot be read. Faults of the other files are diagnostics.
pub(crate) fn run_file(path: &Path) -> Result<(Session, Vec<Diagnostic>), Error> {
    let bytes = read(path)?;
    let (mut session, mut diagnostics) = (Session::default(), Vec::new());
    Loader { open: vec![identity(path)], count: 0 }.run(&mut session, path, &bytes, &mut diagnostics);
    name_pictures(&mut session, folder_of(path));
    Ok((session, diagnostics))
}

/// The settings of a scene's picture, with the pictures that it names.
///
/// # Errors
/// A picture cannot be read.
pub(crate) fn settings_with_pictures(scene: &Scene) -> Result<RenderSettings, Error> {
    let settings = RenderSettings::of(scene).with_surroundings(scene, |picture| {
        let path = PathBuf::from(&*picture.file);
        let bytes = read(&path)?;
        EnvironmentPixels::of_file(&bytes).map_err(|error| Error::Environment { path, error })
    })?;
    let textures = TextureSet::of(scene, |texture, channel| {
        let path = PathBuf::from(&*texture.file);
        let bytes = read(&path)?;
        TexturePixels::of_file(&bytes, channel == TextureChannel::Color)
            .map_err(|error| Error::Texture { path, error })
    })?;
    Ok(settings.with_textures(textures))
}

/// The state of a load: the files that are being read, outermost first, and the number of files so far.
struct Loader {
    open: Vec<PathBuf>,
    count: usize,
}

impl Loader {
    fn run(
        &mut self,
        session: &mut Session,
        path: &Path,
        bytes: &[u8],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Flow {
        let folder = folder_of(path);
        let name = path.display().to_string();
        run_script(session, &name, bytes, diagnostics, &mut |session, _, effect, diagnostics| match effect {
            Effect::Request(Request::Include(file)) => {
                let mut added = Session::default();
                self.nested(&mut added, &file, folder, diagnostics)?;
                for line in session.lines_to_include(&added)?.lines() {
                    session.run_line(line)?;
                }
                Ok(Flow::Continue)
            }
            Effect::Request(Request::Source { file: Some(file), .. }) => {
                session.clear();
                self.nested(session, &file, folder, diagnostics)
            }
            effect => Ok(flow_after(&effect)),
        })
    }

    /// Runs the lines of a file that another one in `folder` names.
    fn nested(
        &mut self,
        session: &mut Session,
        file: &str,
        folder: &Path,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<Flow, Fault> {
        let path = found(file, folder);
        self.count += 1;
        if self.open.contains(&identity(&path)) {
            let fault = Fault::new(FaultCode::SourceCycle, format!("'{file}' would be read within itself"));
            return Err(fault.help("a file cannot load or include itself, directly or through others"));
        }
        if self.open.len() >= MOST_NESTED || self.count > MOST_FILES {
            let fault = Fault::new(FaultCode::SourceLimit, format!("'{file}' is one file too many"));
            return Err(fault.help(format!(
                "files include each other {MOST_NESTED} deep at most, and {MOST_FILES} files in all"
            )));
        }
        let bytes = read(&path).map_err(|error| {
            Fault::new(FaultCode::Unreadable, error.to_string())
                .help("the file is searched in the working folder, then beside the file that names it")
        })?;
        self.open.push(identity(&path));
        let flow = self.run(session, &path, &bytes, diagnostics);
        self.open.pop();
        name_pictures(session, folder_of(&path));
        Ok(flow)
    }
}

fn flow_after(effect: &Effect) -> Flow {
    if *effect == Effect::Request(Request::Stop) { Flow::Stop } else { Flow::Continue }
}

fn read(path: &Path) -> Result<Vec<u8>, Error> {
    fs::read(path).map_err(|error| Error::File { action: "read", path: path.to_owned(), error })
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// A file that a line in `folder` names.
fn found(file: &str, folder: &Path) -> PathBuf {
    let beside = folder.join(file);
    if Path::new(file).exists() || !beside.exists() { PathBuf::from(file) } else { beside }
}

/// The canonical path, equal for all names of a file.
fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Gives the pictures of a scene in `folder` names that are found from the working folder.
fn name_pictures(session: &mut Session, folder: &Path) {
    session.rename_files(&mut |file| found(file, folder).to_str().map(str::to_owned));
}
