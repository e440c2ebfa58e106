//! A thread that serves the latest request: a newer request replaces a pending one and cancels the
//! one in progress.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use parking_lot::{Condvar, Mutex};

/// The thread. Dropping it cancels the request in progress and ends the thread, without waiting for
/// it.
#[derive(Debug)]
pub(super) struct LatestWorker<R> {
    inbox: Arc<Inbox<R>>,
}

#[derive(Debug)]
struct Inbox<R> {
    state: Mutex<State<R>>,
    has_changed: Condvar,
    /// The request in progress is obsolete.
    cancel: AtomicBool,
}

#[derive(Debug)]
struct State<R> {
    pending: Option<R>,
    is_closed: bool,
}

impl<R: Send + 'static> LatestWorker<R> {
    /// Starts a thread that calls `serve` for one request after another. The flag given to `serve`
    /// becomes true when its request is obsolete.
    ///
    /// # Errors
    /// The system cannot start a thread.
    pub(super) fn start(
        name: &str,
        mut serve: impl FnMut(R, &AtomicBool) + Send + 'static,
    ) -> io::Result<Self> {
        let inbox = Arc::new(Inbox {
            state: Mutex::new(State { pending: None, is_closed: false }),
            has_changed: Condvar::new(),
            cancel: AtomicBool::new(false),
        });
        let worker = Self { inbox: Arc::clone(&inbox) };
        std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            while let Some(request) = inbox.next() {
                serve(request, &inbox.cancel);
            }
        })?;
        Ok(worker)
    }
}

impl<R> LatestWorker<R> {
    /// Replaces the pending request and cancels the one in progress.
    pub(super) fn request(&self, request: R) {
        self.inbox.update(|state| state.pending = Some(request));
    }

    /// Drops the pending request and cancels the one in progress.
    pub(super) fn clear(&self) {
        self.inbox.update(|state| state.pending = None);
    }
}

impl<R> Drop for LatestWorker<R> {
    fn drop(&mut self) {
        self.inbox.update(|state| state.is_closed = true);
    }
}

impl<R> Inbox<R> {
    fn update(&self, change: impl FnOnce(&mut State<R>)) {
        let mut state = self.state.lock();
        change(&mut state);
        // Under the lock: later, the flag could cancel this request just after `next` has taken it.
        self.cancel.store(true, Ordering::Relaxed);
        self.has_changed.notify_one();
    }

    /// Waits for a request. Returns `None` after the worker is dropped.
    fn next(&self) -> Option<R> {
        let mut state = self.state.lock();
        loop {
            if state.is_closed {
                return None;
            }
            if let Some(request) = state.pending.take() {
                self.cancel.store(false, Ordering::Relaxed);
                return Some(request);
            }
            self.has_changed.wait(&mut state);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    #[test]
    fn a_newer_request_replaces_the_pending_one_and_cancels_the_one_in_progress() {
        let (begun, begins) = mpsc::channel();
        let (served, all) = mpsc::channel();
        let worker = LatestWorker::start("test", move |request: u32, cancel| {
            begun.send(request).unwrap();
            while request == 0 && !cancel.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
            served.send(request).unwrap();
        })
        .unwrap();
        worker.request(0);
        assert_eq!(begins.recv(), Ok(0));
        // The thread serves request 0 until the first of these cancels it; of the others only the
        // last is certain.
        (1..=100).for_each(|request| worker.request(request));
        let mut served: Vec<u32> = Vec::new();
        while served.last() != Some(&100) {
            served.push(all.recv().unwrap());
        }
        assert!(served.is_sorted() && served[0] == 0, "{served:?}");
        drop(worker);
        assert_eq!(all.iter().count(), 0);
    }

    #[test]
    fn a_cleared_request_is_not_served() {
        let (served, all) = mpsc::channel();
        let (go, gate) = mpsc::channel::<()>();
        let worker = LatestWorker::start("test", move |request: u32, _| {
            served.send(request).unwrap();
            gate.recv().unwrap();
        })
        .unwrap();
        worker.request(1);
        assert_eq!(all.recv(), Ok(1));
        worker.request(2);
        worker.clear();
        go.send(()).unwrap();
        worker.request(3);
        go.send(()).unwrap();
        assert_eq!(all.recv(), Ok(3));
    }
}
