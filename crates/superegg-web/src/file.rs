//! Files of scenes and of other programs.

use std::io::Cursor;

use superegg_exchange::coloring::{Coloring, to_table};
use superegg_exchange::read::{Content, Particles, ReadOptions, Source, open, sniff};
use superegg_exchange::sqb::{self, BinaryScene};
use superegg_lang::{Diagnostic, Effect, Fault, FaultCode, Flow, Request, Session, load_text, run_script};
use superegg_render::frame_data;
use superegg_scene::Scene;

/// The number of bytes that decide the kind of a file.
const HEAD: usize = 1 << 16;
/// The most warnings of a file that are reported one by one.
const MOST_WARNINGS: usize = 20;

/// A file as a scene.
pub(crate) struct Read {
    pub(crate) session: Session,
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// How it was read, and what was left out.
    pub(crate) notes: Vec<String>,
}

/// Runs a text. A line that needs files is a warning.
pub(crate) fn run_text(session: &mut Session, text: &str) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    run_script(session, "scene", text.as_bytes(), &mut diagnostics, &mut |_, line, effect, _| match effect {
        Effect::Request(Request::Stop) => Ok(Flow::Stop),
        Effect::Request(Request::Source { .. } | Request::Include(_)) => Err(no_files(line)),
        _ => Ok(Flow::Continue),
    });
    diagnostics
}

fn no_files(line: &str) -> Fault {
    let command = line.split_whitespace().next().unwrap_or_default();
    let message = format!("'{command}' reads a file, and a page has none");
    Fault::new(FaultCode::NotHere, message).help("drop the file on the page, or put its lines here").warning()
}

/// Whether bytes are data of another program, which names no pictures.
pub(crate) fn is_data(bytes: &[u8]) -> bool {
    sniff(&bytes[..bytes.len().min(HEAD)]).is_some()
}

/// Reads a file by its content: a scene, a binary scene, or data of another program.
///
/// # Errors
/// The file's fault.
pub(crate) fn read(name: &str, bytes: &[u8]) -> Result<Read, String> {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.starts_with(&sqb::SIGNATURE) {
        return read_binary(name, bytes);
    }
    if sniff(head).is_some() {
        return read_data(name, bytes);
    }
    let text = std::str::from_utf8(bytes)
        .map_err(|_| format!("'{name}' is neither a scene nor data of a program that is known here"))?;
    let mut session = Session::default();
    let diagnostics = run_text(&mut session, text);
    Ok(Read { session, diagnostics, notes: Vec::new() })
}

fn read_binary(name: &str, bytes: &[u8]) -> Result<Read, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("cannot read '{name}': {error}");
    let BinaryScene { text, tables } = sqb::read(&mut Cursor::new(bytes)).map_err(|error| wrong(&error))?;
    let mut scene = Scene::default();
    for (table_name, table) in tables {
        scene.add_table(&table_name, table).map_err(|error| wrong(&error))?;
    }
    let mut session = Session::with_scene(scene, None);
    let diagnostics = run_text(&mut session, &text);
    Ok(Read { session, diagnostics, notes: Vec::new() })
}

fn read_data(name: &str, bytes: &[u8]) -> Result<Read, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("cannot read '{name}': {error}");
    let options = ReadOptions::default();
    let mut source = open(Cursor::new(bytes), &options).map_err(|error| wrong(&error))?;
    let format = source.format().description();
    let (frame, import) = first_frame(&mut source, &options).map_err(|error| wrong(&error))?;
    let frames = source.frames().len();
    let of_frames = if frames > 1 { format!(", frame {frame} of 0..{}", frames - 1) } else { String::new() };
    let (session, count) = match import.content {
        Content::Particles(particles) => (
            scene_of(name, &particles).map_err(|error| wrong(&error))?,
            format!("{} shapes", particles.len()),
        ),
        Content::Script(text) => {
            let (session, diagnostics) = load_text(name, &text);
            if let Some(found) = diagnostics.first() {
                return Err(wrong(found));
            }
            (session, "a scene".to_owned())
        }
        _ => return Err(format!("'{name}' holds nothing that can be shown")),
    };
    let mut notes = vec![format!("{format}{of_frames}: {count}; {}", import.reading)];
    let more = import.warnings.len().saturating_sub(MOST_WARNINGS);
    notes.extend(import.warnings.into_iter().take(MOST_WARNINGS));
    if more > 0 {
        notes.push(format!("{more} more warnings"));
    }
    Ok(Read { session, diagnostics: Vec::new(), notes })
}

/// The first frame that is not empty, or the last one.
fn first_frame(
    source: &mut Source<Cursor<&[u8]>>,
    options: &ReadOptions,
) -> Result<(usize, superegg_exchange::read::Import), superegg_exchange::read::ReadError> {
    let last = source.frames().len() - 1;
    for frame in 0..last {
        let import = source.read(frame, options)?;
        if !matches!(&import.content, Content::Particles(particles) if particles.is_empty()) {
            return Ok((frame, import));
        }
    }
    Ok((last, source.read(last, options)?))
}

/// Particles as a table of instances in a picture of the scene's own size.
fn scene_of(name: &str, particles: &Particles) -> Result<Session, String> {
    let table = to_table(particles, &Coloring::Own).map_err(|error| error.to_string())?.table;
    let mut scene = Scene::default();
    let size = (scene.picture.width, scene.picture.height);
    frame_data(&mut scene, &particles.reach(), size);
    let object = object_name(name);
    scene.add_table(&object, table).map_err(|error| error.to_string())?;
    Ok(Session::with_scene(scene, Some(&object)))
}

/// Letters, digits and underscores of a file's name without its ending.
fn object_name(file: &str) -> String {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let name: String = stem.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(char::is_alphabetic) { name } else { format!("data_{name}") }
}
