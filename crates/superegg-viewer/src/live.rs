//! Background threads of the window: preview, compilation and tests in one, ray tracing in another.

mod latest;
pub(crate) mod tracer;
pub(crate) mod worker;
