//! Incoherent rays: streams that traverse the graph as lists (Tsakok 2009).
//!
//! A node tests its boxes for all rays that reach it, and each box that any ray hits gets a list of its own. Lists are
//! followed depth first, near boxes first. Where a list reaches a shape, its rays wait in a queue until the kernels have
//! full registers.

mod leaves;
mod lists;
mod query;
mod refine;
mod table;
mod traverse;
