//! The window: events in, frames out.

pub(crate) mod app;
mod background;
mod content;
pub(crate) mod display_loss;
mod editing;
mod egui_layer;
mod file_actions;
mod frame;
mod keyboard;
mod live_trace;
mod notice;
mod outbox;
mod pointer;
mod screenshot;
mod status;
mod surface;
