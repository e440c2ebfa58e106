//! The modelling language: lines of text to commands, commands to changes of a scene, a scene back to text.
//!
//! One table ([`COMMANDS`]) declares every command; parsing, checks and help come from it. A [`Session`] is a scene with a selection; it
//! alone writes to a scene. What a command asks of the world outside (read a file, write one, stop) it returns as an
//! [`Effect`]; nothing here reads, writes or prints.

mod animation;
mod command;
mod complete;
mod diagnostic;
mod help;
mod highlight;
mod hint;
mod info;
mod lint;
mod names;
mod number;
mod parser;
mod script;
mod session;
mod settings;
mod spec;
mod suggest;
mod table;
mod timeline;
mod writer;

pub use animation::scene_at;
pub use command::{Command, Recovery, Request};
pub use complete::{Completion, complete};
pub use diagnostic::{Diagnostic, Fault, Severity};
pub use help::help;
pub use highlight::{Paint, highlight};
pub use hint::{Hint, hint};
pub use lint::lint;
pub use number::{NumberError, format_number, parse_number};
pub use parser::{Parsed, is_unseen, parse_line};
pub use script::{Flow, Perform, load_text, not_text, run_script};
pub use session::{Effect, Session};
pub use settings::{PreviewStyle, SETTINGS, SettingKind, SettingSpec, Settings};
pub use spec::{Arg, ArgKind, CommandSpec, Group, Needs, Of, Range, parse_size};
pub use suggest::nearest;
pub use table::{COMMANDS, find_command};
pub use timeline::Timeline;
pub use writer::{write_scene, write_session};
