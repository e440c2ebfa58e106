//! The interpreter: a scene with a selection, and everything that changes or prints it.

pub(crate) mod checks;
pub(crate) mod faults;
pub(crate) mod help;
pub(crate) mod help_topics;
pub(crate) mod info;
pub(crate) mod interpreter;
pub(crate) mod keys;
pub(crate) mod notes;
pub(crate) mod pictures;
pub(crate) mod script;
pub(crate) mod selection;
pub(crate) mod settings;
pub(crate) mod still;
pub(crate) mod timeline;
