//! The process and its machine: signals, memory and processor time.

pub(crate) mod interrupt;
pub(crate) mod memory;
pub(crate) mod processor;
pub(crate) mod terminal;
