//! The modelling language: it parses lines to commands, carries commands out on a scene, and writes
//! a scene back as text.
//!
//! - One table, [`COMMANDS`], declares every command. Parser, checks, help, completion and hints
//!   read it.
//! - A [`Session`] is a scene with a selection. Commands change it; a fault leaves it unchanged.
//! - A [`Timeline`] is a session with undo and redo.
//! - [`load_text`] loads a scene file; [`write_session`] writes one.
//!
//! The crate reads no files, writes none, and prints nothing: commands that need that return
//! [`Effect::Request`].
//!
//! ```
//! use superegg_lang::{load_text, write_session};
//!
//! let text = "primitive egg\nsetCoeff 1 1 1.3\nobject nest\naddPrimitive egg\n";
//! let (session, diagnostics) = load_text("nest.scn", text);
//! assert!(diagnostics.is_empty());
//! assert_eq!(session.selected(), Some("nest"));
//!
//! let (again, _) = load_text("again.scn", &write_session(&session));
//! assert_eq!(again, session);
//! ```

mod assist;
mod color;
mod diagnostic;
mod grammar;
mod include;
mod parse;
mod session;
mod suggest;
mod text;
mod writer;

pub use assist::complete::{Completion, complete};
pub use assist::highlight::{Paint, highlight};
pub use assist::hint::{Hint, hint};
pub use assist::lint::lint;
pub use color::parse_color;
pub use diagnostic::{Diagnostic, Fault, FaultCode, Severity};
pub use grammar::command::{
    Command, Needs, ObjectCommand, PrimitiveCommand, Recovery, Request, SceneCommand, SessionCommand,
};
pub use grammar::spec::{Arg, ArgKind, CommandSpec, Group, NameKind, Range, Shorthand, parse_size};
pub use grammar::table::{COMMANDS, find_command};
pub use parse::commands::split_commands;
pub use parse::number::{NumberError, format_number, parse_number};
pub use parse::parser::{Columns, Parsed, parse_line};
pub use session::help::{example_line, help};
pub use session::interpreter::{Effect, Session};
pub use session::keys::{key_frames, rename_files};
pub use session::notes::creation_note;
pub use session::pictures::{NamedPicture, PictureUse, picture_files, picture_of_line, rename_in_line};
pub use session::script::{Flow, Perform, load_text, not_text, run_script};
pub use session::selection::Selection;
pub use session::settings::{PreviewStyle, SETTINGS, SettingKind, SettingSpec, Settings};
pub use session::still::scene_at;
pub use session::timeline::Timeline;
pub use suggest::nearest;
pub use text::{is_unseen, visible};
pub use writer::{fingerprint_text, write_scene, write_session, write_without_tables};

/// Compiles the examples of the crate's README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
