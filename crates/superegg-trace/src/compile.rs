//! Compiling: from the description of a scene to the graph of groups.

mod assemble;
mod bounds;
mod compiler;
mod fold;
mod parts;
mod patch;
mod proxy;
mod signature;
mod survey;
