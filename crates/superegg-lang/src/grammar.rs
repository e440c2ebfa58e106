//! The commands and the table that declares them.

pub(crate) mod command;
pub(crate) mod spec;
pub(crate) mod table;
