//! The modeller: an editing session with its files, renders, journal and window.
//!
//! Input arrives one line at a time, from the prompt, a pipe, a file or the window. Modules use
//! only modules that stand above them in this list.

mod sixel;

mod canvas;
mod document;
mod journal;
mod known_files;
mod render_queue;
mod reporter;
mod viewer_link;

mod state;

mod faults;
mod replace;
mod requests;

mod input;

pub(crate) use input::LONGEST_LINE;
pub(crate) use reporter::{Message, Reporter, console_reporter};
pub(crate) use state::{Input, Modeller, Reply};
pub(crate) use viewer_link::ShownFrame;
