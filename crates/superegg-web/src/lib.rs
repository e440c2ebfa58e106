//! Superegg in WebAssembly: the engine of the npm package `superegg` and of the page.
//!
//! - `document`: a text that is edited: its errors, completion, hints, help, the exponents of a primitive.
//! - `scene`: a scene that answers: rays, points, meshes, files.
//! - `pictures`: the picture files that scenes name.
//! - `picture`: a picture of a scene that is rendered in slices of time, in shards.
//! - `eye`: the arcball and the eye of the viewer, and the table of keys.
//!
//! Numbers cross to JavaScript as typed arrays, records as JSON text (`answers`), whose types are those of the
//! package. An error is a JavaScript `Error` with a message. There are no threads: the package runs a module in each of
//! several workers.

mod answers;
mod clock;
pub mod document;
mod exponents;
pub mod eye;
mod file;
mod findings;
mod picture;
pub mod pictures;
mod scene;
mod text;

use wasm_bindgen::prelude::wasm_bindgen;

/// The version of the engine.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Prints panics, which end the module, to the console.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| clock::console_error(&panic.to_string())));
}
