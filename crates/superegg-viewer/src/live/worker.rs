//! Slow work on the scene, on a thread of its own: preview, compilation, the grid of the
//! inside-outside test.
//!
//! The latest request wins. Results arrive as they are ready, the preview first.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use superegg_scene::{Camera, Scene};
use superegg_trace::CompiledScene;

use super::latest::LatestWorker;
use crate::preview::{Preview, PreviewBudget, SceneIndex};
use crate::queries::{GridChoice, GridSpec, IoGrid};

/// A request for everything that depends on a scene.
#[derive(Clone, Debug)]
pub(crate) struct SceneRequest {
    /// The scene.
    pub(crate) scene: Scene,
    /// Number of the snapshot: equal numbers have equal scenes and equal roots.
    pub(crate) number: u64,
    /// Name of the entity that is shown.
    pub(crate) root: Option<String>,
    /// The camera. It decides which branches are smaller than a pixel.
    pub(crate) camera: Camera,
    /// Limits of the preview.
    pub(crate) budget: PreviewBudget,
    /// The grid to test, if it is shown.
    pub(crate) grid: Option<GridChoice>,
    /// Name of the selected entity.
    pub(crate) selected: Option<String>,
}

/// A result.
#[derive(Debug)]
pub(crate) enum SceneResult {
    /// The preview, and the index of the selected primitive's shape.
    Preview(Arc<Preview>, Option<u32>),
    /// The number of the snapshot, and its compiled scene.
    Compiled(u64, Arc<CompiledScene>),
    /// The tested grid.
    Grid(Arc<IoGrid>),
}

/// The thread. Dropping it cancels the work.
#[derive(Debug)]
pub(crate) struct SceneWorker {
    worker: LatestWorker<SceneRequest>,
}

impl SceneWorker {
    /// Starts the thread, which calls `done` with every result.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub(crate) fn start(done: impl Fn(SceneResult) + Send + 'static) -> std::io::Result<Self> {
        let mut cache = Cache::default();
        let serve = move |request: SceneRequest, cancel: &AtomicBool| {
            serve(&request, &mut cache, cancel, &done);
        };
        Ok(Self { worker: LatestWorker::start("viewer-worker", serve)? })
    }

    /// Sends a request. It replaces one that has not begun.
    pub(crate) fn request(&self, request: SceneRequest) {
        self.worker.request(request);
    }
}

/// Results of the last request that the next one may use.
#[derive(Default)]
struct Cache {
    number: Option<u64>,
    index: SceneIndex,
    compiled: Option<Arc<CompiledScene>>,
    /// The compiled scene of an older snapshot. Recompilation takes over its unchanged parts.
    before: Option<Arc<CompiledScene>>,
    grid: Option<(u64, GridSpec)>,
}

fn serve(request: &SceneRequest, cache: &mut Cache, cancel: &AtomicBool, done: &impl Fn(SceneResult)) {
    if cache.number != Some(request.number) {
        let before = cache.compiled.take().or(cache.before.take());
        let index = SceneIndex::new(&request.scene);
        *cache = Cache { number: Some(request.number), index, before, ..Cache::default() };
    }
    let preview = cache.index.open(request.root.as_deref(), &request.camera, &request.budget);
    let selected = request.selected.as_deref().and_then(|name| cache.index.shape_of(name));
    let spec = request.grid.and_then(|choice| choice.spec(preview.bounds.as_ref(), &request.scene.camera));
    done(SceneResult::Preview(Arc::new(preview), selected));
    // A newer request makes the rest obsolete.
    let is_stale = || cancel.load(Ordering::Relaxed);
    if cache.compiled.is_none() && !is_stale() {
        let (root, depth) = (request.root.as_deref(), request.scene.depth);
        let compiled = Arc::new(match cache.before.take() {
            Some(before) => before.recompile(&request.scene, root, depth),
            None => CompiledScene::compile(&request.scene, root, depth),
        });
        cache.compiled = Some(Arc::clone(&compiled));
        done(SceneResult::Compiled(request.number, compiled));
    }
    let (Some(compiled), Some(spec)) = (&cache.compiled, spec) else { return };
    if cache.grid == Some((request.number, spec)) || is_stale() {
        return;
    }
    if let Some(grid) = IoGrid::test(compiled, &spec, cancel) {
        cache.grid = Some((request.number, spec));
        done(SceneResult::Grid(Arc::new(grid)));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use superegg_scene::ViewSettings;

    use super::*;

    #[test]
    fn the_last_request_is_served_whatever_came_before() {
        let (send, results) = mpsc::channel();
        let worker = SceneWorker::start(move |result| drop(send.send(result))).unwrap();
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        for number in 0..30 {
            worker.request(SceneRequest {
                scene: scene.clone(),
                number,
                root: Some("ball".to_owned()),
                camera: Camera::default(),
                budget: PreviewBudget { instances: 10, height_px: 100 },
                grid: Some(GridChoice::new(&ViewSettings::COURSE)),
                selected: Some("ball".to_owned()),
            });
        }
        let (mut previews, mut compiled) = (0, None);
        for result in &results {
            match result {
                SceneResult::Preview(made, selected) => {
                    assert_eq!((made.instances.len(), selected), (1, Some(0)));
                    previews += 1;
                }
                SceneResult::Compiled(number, _) => compiled = Some(number),
                SceneResult::Grid(_) if compiled == Some(29) => break,
                SceneResult::Grid(_) => (),
            }
        }
        assert!(previews > 0 && compiled == Some(29));
        drop(worker);
        assert!(results.iter().count() == 0);
    }
}
