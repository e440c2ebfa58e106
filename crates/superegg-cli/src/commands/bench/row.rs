//! The figures of a scene: a row of the table, or an object of the JSON file.

use std::fmt::Write;

use serde::Serialize;

/// The figures of one scene. The field names are the keys of the JSON file, which scripts read.
/// Rates are in millions of rays per second on one core.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    /// The number of primitive instances in the picture, as digits because it can exceed 64 bits.
    pub(super) instances: String,
    /// The number of primitives, or of children if larger, of the scene description.
    pub(super) described: usize,
    /// Camera rays in packets, by the f32 kernels.
    pub(super) camera_mrays: f64,
    /// Camera rays with hits refined in f64.
    pub(super) camera_settled_mrays: f64,
    /// The fraction of camera rays that hit.
    pub(super) camera_hits: f64,
    pub(super) shadow_mrays: f64,
    /// The fraction of occluded shadow rays.
    pub(super) shadow_stopped: f64,
    /// Random rays as a stream, by the f32 kernels.
    pub(super) random_mrays: f64,
    /// Random rays with hits refined in f64.
    pub(super) random_settled_mrays: f64,
    /// The fraction of random rays that hit.
    pub(super) random_hits: f64,
    pub(super) random_occlusion_mrays: f64,
    /// The processor time of a whole picture with one sample per pixel and shadows.
    pub(super) picture_seconds: f64,
    pub(super) compile_seconds: f64,
    /// The processor time of all cores for the compilation; independent of other load on the
    /// machine.
    pub(super) compile_processor_seconds: f64,
    /// The time to compile again after a change of one primitive.
    pub(super) recompile_seconds: f64,
    /// The peak memory of the compilation beyond the memory before it, per described primitive.
    pub(super) peak_bytes_per_primitive: Option<f64>,
    /// The memory of the compiled scene per described primitive.
    pub(super) bytes_per_primitive: f64,
    pub(super) compiled_bytes: usize,
    /// The area of boxes around eight transformed corners, as a multiple of the boxes in use.
    pub(super) box_area_spared: f64,
}

/// The header of the table.
pub(super) const HEADER: &str = "\
| scene | instances | camera | settled | shadow | random | random settled | random shadow | picture s | compile s | processor s | again s | peak bytes | bytes |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|";
/// The explanation below the table.
pub(super) const LEGEND: &str = "\
camera, shadow, random: millions of rays per second on one core, the best of the rounds; settled: the same rays with hits refined in f64
picture s: processor seconds of a whole picture with shadows, one sample per pixel; compile s: wall time on all cores
processor s: processor time of all cores; again s: after a change of one primitive
bytes: per primitive of the description, at the peak of compiling (of the first scene of a run) and after it";

impl Row {
    /// The row of the table.
    pub(super) fn line(&self) -> String {
        let mut line = String::new();
        let instances = match self.instances.len() {
            0..=9 => self.instances.clone(),
            digits => format!("{}e{}", &self.instances[..1], digits - 1),
        };
        // Writing to a String cannot fail.
        let _ = write!(line, "| {} | {instances} |", self.scene);
        let rates = [
            self.camera_mrays,
            self.camera_settled_mrays,
            self.shadow_mrays,
            self.random_mrays,
            self.random_settled_mrays,
            self.random_occlusion_mrays,
        ];
        for rate in rates {
            let _ = write!(line, " {rate:.2} |");
        }
        let seconds = [
            self.picture_seconds,
            self.compile_seconds,
            self.compile_processor_seconds,
            self.recompile_seconds,
        ];
        for seconds in seconds {
            let _ = write!(line, " {seconds:.3} |");
        }
        match self.peak_bytes_per_primitive {
            Some(bytes) => {
                let _ = write!(line, " {bytes:.0} |");
            }
            None => line.push_str(" - |"),
        }
        let _ = write!(line, " {:.0} |", self.bytes_per_primitive);
        line
    }
}
