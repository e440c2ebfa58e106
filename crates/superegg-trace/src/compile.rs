//! Compiling: from the description of a scene to the graph of groups.

mod assemble;
mod bounds;
mod compiler;
mod described;
mod fold;
mod index;
mod parts;
mod patch;
mod proxy;
mod signature;
mod survey;
