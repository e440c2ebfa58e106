//! The modelling language: lines of text to commands, commands to changes of a scene, a scene back to text.
//!
//! One table ([`COMMANDS`]) declares every command; parsing, checks and help come from it. A [`Session`] is a scene with a selection; it
//! alone writes to a scene. What a command asks of the world outside (read a file, write one, stop) it returns as an
//! [`Effect`]; nothing here reads, writes or prints.

mod assist;
mod diagnostic;
mod grammar;
mod parse;
mod session;
mod suggest;
mod text;
mod writer;

pub use assist::complete::{Completion, complete};
pub use assist::highlight::{Paint, highlight};
pub use assist::hint::{Hint, hint};
pub use assist::lint::lint;
pub use diagnostic::{Diagnostic, Fault, FaultCode, Severity};
pub use grammar::command::{
    Command, Needs, ObjectCommand, PrimitiveCommand, Recovery, Request, SceneCommand, SessionCommand,
};
pub use grammar::spec::{Arg, ArgKind, CommandSpec, Group, NameKind, Range, parse_size};
pub use grammar::table::{COMMANDS, find_command};
pub use parse::number::{NumberError, format_number, parse_number};
pub use parse::parser::{Parsed, parse_line};
pub use session::help::help;
pub use session::interpreter::{Effect, Session};
pub use session::script::{Flow, Perform, load_text, not_text, run_script};
pub use session::selection::Selection;
pub use session::settings::{PreviewStyle, SETTINGS, SettingKind, SettingSpec, Settings};
pub use session::still::scene_at;
pub use session::timeline::Timeline;
pub use suggest::nearest;
pub use text::is_unseen;
pub use writer::{write_scene, write_session};
