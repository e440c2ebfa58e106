//! The records that cross to JavaScript as JSON. `package/types.d.ts` declares the same.

use std::fmt::Display;

use serde::{Deserialize, Serialize};
use wasm_bindgen::JsError;

/// JSON text of a record.
pub(crate) fn json(record: &impl Serialize) -> String {
    // Records of plain fields always have a text.
    serde_json::to_string(record).unwrap_or_default()
}

/// A JavaScript error with this message.
pub(crate) fn error(message: impl Display) -> JsError {
    JsError::new(&message.to_string())
}

/// The contents of a scene.
#[derive(Serialize)]
pub(crate) struct Summary {
    pub(crate) root: Option<String>,
    /// The number of instances: text, because it has no bound.
    pub(crate) instances: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) samples: u32,
    /// The number of frames that its keys make, from frame 0 to the last key; 0 without keys.
    pub(crate) frames: usize,
    /// The pictures that the scene names: of its surroundings and on its surfaces.
    pub(crate) files: Vec<FileNamed>,
}

/// A file that a scene names.
#[derive(Serialize)]
pub(crate) struct FileNamed {
    pub(crate) name: String,
    #[serde(rename = "given")]
    pub(crate) is_given: bool,
    /// Why it cannot be read.
    pub(crate) fault: Option<String>,
}

/// A primitive, object or table.
#[derive(Serialize)]
pub(crate) struct Name {
    pub(crate) name: String,
    pub(crate) kind: &'static str,
}

/// The first hit of one ray.
#[derive(Serialize)]
pub(crate) struct FirstHit {
    pub(crate) t: f64,
    pub(crate) point: [f64; 3],
    pub(crate) normal: [f64; 3],
    pub(crate) path: String,
    pub(crate) primitive: String,
    /// `None` for a shape that is not convex.
    pub(crate) steps: Option<u32>,
}

/// A picture to render. Missing fields are those of the scene.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub(crate) struct PictureRequest {
    pub(crate) width: Option<u32>,
    pub(crate) height: Option<u32>,
    pub(crate) samples: Option<u32>,
    /// Overrides the noise threshold of the scene; 0 for none.
    pub(crate) noise: Option<f64>,
    pub(crate) output: Option<String>,
    /// Position, target, up, field of view in degrees, and height of an orthographic picture or 0.
    pub(crate) camera: Option<[f64; 11]>,
    /// The map of the lights, in columns.
    pub(crate) light_map: Option<[f64; 12]>,
    /// Part K of N, such as `2/8`.
    pub(crate) shard: Option<String>,
}
