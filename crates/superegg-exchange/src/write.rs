//! Writers of other programs' formats, one module each.

pub mod points;
pub mod povray;
