//! The ray traced picture of the window.

use std::sync::Arc;

use superegg_render::{Output, RenderSettings};
use superegg_scene::{Camera, Light, Picture, Scene};
use superegg_trace::CompiledScene;

use crate::input::ViewState;
use crate::live::tracer::{Pass, TraceJob, Tracer};

/// Most samples per pixel in the window. A file may have more.
const MOST_SAMPLES: u32 = 16;

/// The tracer and its last pass.
#[derive(Debug)]
pub(super) struct LiveTrace {
    /// `None` if the system could not start the thread.
    tracer: Option<Tracer>,
    /// Number of the last job.
    number: u64,
    /// Number of the first job since tracing began. Late passes of older jobs are rejected.
    first_number: u64,
    requested: Option<TraceKey>,
    pass: Option<Pass>,
}

/// Everything that a traced picture depends on. A change needs a new job.
#[derive(Clone, Debug, PartialEq)]
struct TraceKey {
    scene_number: u64,
    camera: Camera,
    lights: Vec<Light>,
    size: (u32, u32),
    output: Output,
}

impl LiveTrace {
    pub(super) fn new(tracer: Option<Tracer>) -> Self {
        Self { tracer, number: 0, first_number: 1, requested: None, pass: None }
    }

    /// The last pass.
    pub(super) fn pass(&self) -> Option<&Pass> {
        self.pass.as_ref()
    }

    /// Requests the traced picture of a view unless it is current. `compiled` comes with the number
    /// of its scene.
    pub(super) fn request(&mut self, scene: &Scene, compiled: (u64, &Arc<CompiledScene>), view: &ViewState) {
        let Some(tracer) = &self.tracer else { return };
        let (scene_number, compiled) = compiled;
        let key = TraceKey {
            scene_number,
            camera: view.eye.camera(),
            lights: view.eye.lights(&scene.lights(), view.settings.lights_turn),
            size: view.size_px(),
            output: view.output,
        };
        if self.requested.as_ref() == Some(&key) {
            return;
        }
        self.number += 1;
        let compiled = Arc::clone(compiled);
        tracer.trace(TraceJob { compiled, settings: settings(scene, &key), number: self.number });
        self.requested = Some(key);
    }

    /// Cancels the current job and drops the last pass.
    pub(super) fn stop(&mut self) {
        if self.requested.is_some() {
            self.forget();
            if let Some(tracer) = &self.tracer {
                tracer.rest();
            }
        }
    }

    /// Forgets the last pass and its request: its texture is lost.
    pub(super) fn forget(&mut self) {
        (self.requested, self.pass) = (None, None);
        self.first_number = self.number + 1;
    }

    /// Takes over a pass. Returns `None` if it is obsolete.
    pub(super) fn receive(&mut self, pass: Pass) -> Option<&Pass> {
        (pass.number >= self.first_number).then(|| &*self.pass.insert(pass))
    }
}

fn settings(scene: &Scene, key: &TraceKey) -> RenderSettings {
    let picture = Picture {
        width: key.size.0,
        height: key.size.1,
        samples: scene.picture.samples.clamp(1, MOST_SAMPLES),
        // The window has a background, and must be fast.
        transparent: false,
        noise: 0.0,
        ..scene.picture
    };
    let mut settings =
        RenderSettings::of(scene).with_picture(picture).with_camera(key.camera).with_output(key.output);
    settings.environment.lights.clone_from(&key.lights);
    settings
}
