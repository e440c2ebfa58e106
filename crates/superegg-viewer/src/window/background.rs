//! Everything that background threads make for the window.

use std::sync::Arc;

use superegg_geom::Aabb;
use superegg_scene::Camera;
use superegg_trace::CompiledScene;
use winit::event_loop::EventLoopProxy;

use super::content::Content;
use super::live_trace::LiveTrace;
use crate::event::Event;
use crate::input::ViewState;
use crate::live::tracer::Tracer;
use crate::live::worker::{SceneRequest, SceneResult, SceneWorker};
use crate::preview::{Preview, PreviewBudget};
use crate::queries::{GridChoice, IoGrid};

/// The background threads and their latest results.
#[derive(Debug)]
pub(super) struct Background {
    /// `None` if the system could not start the thread.
    worker: Option<SceneWorker>,
    requested: Option<RequestKey>,
    preview: Arc<Preview>,
    selected_shape: Option<u32>,
    /// The compiled scene and the number of its snapshot.
    compiled: Option<(u64, Arc<CompiledScene>)>,
    grid: Option<Arc<IoGrid>>,
    pub(super) trace: LiveTrace,
}

/// Everything that a request depends on. A change needs a new request.
#[derive(Clone, Debug, PartialEq)]
struct RequestKey {
    number: u64,
    /// Camera and picture height, if the preview depends on them.
    camera: Option<(Camera, u32)>,
    grid: Option<GridChoice>,
}

impl Background {
    /// Starts the threads. They send their results as events.
    pub(super) fn start(proxy: &EventLoopProxy<Event>) -> Self {
        let (worker_proxy, tracer_proxy) = (proxy.clone(), proxy.clone());
        let worker = SceneWorker::start(move |result| {
            let _ = worker_proxy.send_event(Event::Ready(result));
        });
        let tracer = Tracer::start(move |pass| {
            let _ = tracer_proxy.send_event(Event::Traced(Box::new(pass)));
        });
        Self {
            worker: worker.ok(),
            requested: None,
            preview: Arc::default(),
            selected_shape: None,
            compiled: None,
            grid: None,
            trace: LiveTrace::new(tracer.ok()),
        }
    }

    pub(super) fn preview(&self) -> &Preview {
        &self.preview
    }

    /// Index of the selected primitive's shape in the preview.
    pub(super) fn selected_shape(&self) -> Option<u32> {
        self.selected_shape
    }

    pub(super) fn compiled(&self) -> Option<&CompiledScene> {
        self.compiled.as_ref().map(|(_, compiled)| &**compiled)
    }

    pub(super) fn grid(&self) -> Option<&IoGrid> {
        self.grid.as_deref()
    }

    /// Bounding box of everything shown.
    pub(super) fn bounds(&self) -> Aabb {
        self.preview.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Requests everything that is not up to date.
    pub(super) fn update(&mut self, content: &Content, view: &ViewState) {
        self.request_scene(content, view);
        match &self.compiled {
            _ if !view.is_traced => self.trace.stop(),
            Some((number, compiled)) => self.trace.request(content.scene(), (*number, compiled), view),
            None => (),
        }
    }

    fn request_scene(&mut self, content: &Content, view: &ViewState) {
        let Some(worker) = &self.worker else { return };
        let (_, height_px) = view.size_px();
        let camera = view.eye.camera();
        let key = RequestKey {
            number: content.number(),
            camera: self.preview.depends_on_camera().then_some((camera, height_px)),
            grid: view.settings.io_test.then(|| GridChoice::new(&view.settings)),
        };
        if self.requested.as_ref() == Some(&key) {
            return;
        }
        worker.request(SceneRequest {
            scene: content.scene().clone(),
            number: key.number,
            root: content.root().map(str::to_owned),
            camera,
            budget: PreviewBudget { instances: PreviewBudget::WINDOW_INSTANCES, height_px },
            grid: key.grid,
            selected: content.selected().map(str::to_owned),
        });
        self.requested = Some(key);
    }

    /// Takes over a result.
    pub(super) fn receive(&mut self, result: SceneResult, view: &ViewState) {
        match result {
            SceneResult::Preview(preview, selected) => {
                self.preview = preview;
                self.selected_shape = selected;
                self.add_camera_to_key(view);
            }
            SceneResult::Compiled(number, compiled) => self.compiled = Some((number, compiled)),
            SceneResult::Grid(grid) => self.grid = Some(grid),
        }
    }

    /// Completes the key of a request whose preview turns out to depend on the camera: it was made
    /// for this camera.
    fn add_camera_to_key(&mut self, view: &ViewState) {
        if let Some(key) = &mut self.requested
            && self.preview.depends_on_camera()
            && key.camera.is_none()
        {
            key.camera = Some((view.eye.camera(), view.size_px().1));
        }
    }
}
