//! The real binary, used as people use it.

// A test that is skipped says so.
#![allow(clippy::print_stderr)]

mod animate;
mod annotations;
mod attacks;
mod crashes;
mod denoise;
mod film;
mod fit;
mod gallery;
mod hidden;
mod language;
mod long;
mod measures;
mod modeller;
mod new_user;
#[cfg(unix)]
mod prompt;
mod real_scenes;
mod sessions;
mod support;
#[cfg(unix)]
mod terminal;
