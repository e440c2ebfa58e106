//! Bytes as a file of another program: no panic, no hang, and particles that are always consistent.

#![no_main]

#[path = "../read_laws.rs"]
mod read_laws;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| read_laws::check(bytes));
