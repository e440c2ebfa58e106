//! Bytes as a whole session: no panic, no hang, and a scene that is always consistent.

#![no_main]

#[path = "../session_laws.rs"]
mod session_laws;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| session_laws::check(bytes));
