//! Help for an editor: completion, hints, highlighting, warnings about a file.

pub(crate) mod complete;
pub(crate) mod highlight;
pub(crate) mod hint;
pub(crate) mod lint;
pub(crate) mod names;
