//! What takes time for a large scene, on a thread of its own: opening the preview, compiling, the grid of the inside-outside test. The latest
//! request wins; answers come as they are ready, the preview first.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use superegg_scene::{Camera, Scene};
use superegg_trace::CompiledScene;

use crate::io_grid::{GridSpec, IoGrid};
use crate::preview::{Preview, PreviewBudget, SceneIndex};

/// What is wanted.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    /// The snapshot, and its number: equal numbers are equal snapshots with equal roots.
    pub scene: Scene,
    /// See `scene`.
    pub number: u64,
    /// What of it is shown.
    pub root: Option<String>,
    /// The eye, for what is smaller than a pixel.
    pub camera: Camera,
    /// What may be opened.
    pub budget: PreviewBudget,
    /// The grid to be tested, if it is shown.
    pub grid: Option<GridSpec>,
    /// The primitive that is selected.
    pub selected: Option<String>,
}

/// What is ready.
#[derive(Debug)]
pub(crate) enum Ready {
    /// What to draw, and the shape of the selected primitive.
    Preview(Arc<Preview>, Option<u32>),
    /// What rays hit.
    Compiled(u64, Arc<CompiledScene>),
    /// The tested grid.
    Grid(Arc<IoGrid>),
}

/// The thread. Dropping it stops the work.
#[derive(Debug)]
pub(crate) struct Worker {
    desk: Arc<Desk>,
}

#[derive(Debug, Default)]
struct Desk {
    next: Mutex<(Option<Order>, bool)>,
    has_news: Condvar,
    cancel: AtomicBool,
}

impl Desk {
    fn lock(&self) -> MutexGuard<'_, (Option<Order>, bool)> {
        self.next.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Worker {
    /// Starts the thread; `done` is called on it.
    ///
    /// # Errors
    /// The system gives no thread.
    pub(crate) fn start(done: impl Fn(Ready) + Send + 'static) -> std::io::Result<Self> {
        let desk = Arc::new(Desk::default());
        let theirs = Arc::clone(&desk);
        std::thread::Builder::new().name("viewer-worker".to_owned()).spawn(move || work(&theirs, &done))?;
        Ok(Self { desk })
    }

    /// Asks for something; what was asked before and is not begun is forgotten.
    pub(crate) fn order(&self, order: Order) {
        self.desk.lock().0 = Some(order);
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.has_news.notify_one();
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.desk.lock().1 = true;
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.has_news.notify_one();
    }
}

/// What is kept from one order to the next.
#[derive(Default)]
struct Kept {
    number: Option<u64>,
    index: SceneIndex,
    compiled: Option<Arc<CompiledScene>>,
    /// The compiled scene of an older order, of which a newer one takes over what has not changed.
    before: Option<Arc<CompiledScene>>,
    grid: Option<(u64, GridSpec)>,
}

fn work(desk: &Desk, done: &impl Fn(Ready)) {
    let mut kept = Kept::default();
    loop {
        let order = {
            let mut next = desk.lock();
            loop {
                if next.1 {
                    return;
                }
                if let Some(order) = next.0.take() {
                    desk.cancel.store(false, Ordering::Relaxed);
                    break order;
                }
                next = desk.has_news.wait(next).unwrap_or_else(PoisonError::into_inner);
            }
        };
        carry_out(&order, &mut kept, &desk.cancel, done);
    }
}

fn carry_out(order: &Order, kept: &mut Kept, cancel: &AtomicBool, done: &impl Fn(Ready)) {
    if kept.number != Some(order.number) {
        let before = kept.compiled.take().or(kept.before.take());
        let index = SceneIndex::new(&order.scene);
        *kept = Kept { number: Some(order.number), index, before, ..Kept::default() };
    }
    let preview = kept.index.open(order.root.as_deref(), &order.camera, &order.budget);
    let selected = order.selected.as_deref().and_then(|name| kept.index.shape_of(name));
    done(Ready::Preview(Arc::new(preview), selected));
    // From here on only what a newer order does not make useless.
    let is_stale = || cancel.load(Ordering::Relaxed);
    if kept.compiled.is_none() && !is_stale() {
        let (root, depth) = (order.root.as_deref(), order.scene.depth);
        let compiled = Arc::new(match kept.before.take() {
            Some(before) => before.recompile(&order.scene, root, depth),
            None => CompiledScene::compile(&order.scene, root, depth),
        });
        kept.compiled = Some(Arc::clone(&compiled));
        done(Ready::Compiled(order.number, compiled));
    }
    let (Some(compiled), Some(spec)) = (&kept.compiled, order.grid) else { return };
    if kept.grid == Some((order.number, spec)) || is_stale() {
        return;
    }
    if let Some(grid) = IoGrid::test(compiled, &spec, cancel) {
        kept.grid = Some((order.number, spec));
        done(Ready::Grid(Arc::new(grid)));
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use superegg_scene::ViewSettings;

    use super::*;

    #[test]
    fn the_last_order_is_carried_out_whatever_came_before() {
        let (send, ready) = mpsc::channel();
        let worker = Worker::start(move |ready| drop(send.send(ready))).unwrap();
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        for number in 0..30 {
            worker.order(Order {
                scene: scene.clone(),
                number,
                root: Some("ball".to_owned()),
                camera: Camera::default(),
                budget: PreviewBudget { instances: 10, height_px: 100 },
                grid: Some(GridSpec::new(&ViewSettings::default())),
                selected: Some("ball".to_owned()),
            });
        }
        let (mut previews, mut compiled) = (0, None);
        for ready in &ready {
            match ready {
                Ready::Preview(made, selected) => {
                    assert_eq!((made.instances.len(), selected), (1, Some(0)));
                    previews += 1;
                }
                Ready::Compiled(number, _) => compiled = Some(number),
                Ready::Grid(_) if compiled == Some(29) => break,
                Ready::Grid(_) => (),
            }
        }
        assert!(previews > 0 && compiled == Some(29));
        drop(worker);
        assert!(ready.iter().count() == 0);
    }
}
