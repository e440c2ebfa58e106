//! The modelling language: lines of text to commands, commands to changes of a scene, a scene back to text.
//!
//! One table ([`COMMANDS`]) declares every command; parsing, checks and help come from it. A [`Session`] is a scene with a selection; it
//! alone writes to a scene. What a command asks of the world outside (read a file, write one, stop) it returns as an
//! [`Effect`]; nothing here reads, writes or prints.

mod command;
mod diagnostic;
mod help;
mod info;
mod lint;
mod number;
mod parser;
mod script;
mod session;
mod suggest;
mod table;
mod writer;

pub use command::Command;
pub use diagnostic::{Diagnostic, Fault, Severity};
pub use help::help;
pub use lint::lint;
pub use number::{NumberError, format_number, parse_number};
pub use parser::{Parsed, parse_line};
pub use script::{Flow, Perform, load_text, run_script};
pub use session::{Effect, Session};
pub use suggest::nearest;
pub use table::{Arg, ArgKind, COMMANDS, CommandSpec, Group, Needs, Range, find_command};
pub use writer::write_session;
