//! Lines of text to commands.

pub(crate) mod commands;
pub(crate) mod material_words;
pub(crate) mod number;
pub(crate) mod parser;
pub(crate) mod words;
