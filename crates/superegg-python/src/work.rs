//! Work without the interpreter's lock: on other threads, stopped by ctrl-c, its panics as
//! exceptions.

use std::any::Any;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::errors;

/// How often a signal is looked for.
const POLL: Duration = Duration::from_millis(50);

/// The rays of the first slice of a query. Slices grow as long as they are quick.
const FIRST_SLICE: usize = 1 << 12;
/// The most rays of a slice.
const MOST_SLICE: usize = 1 << 17;
/// A slice that takes longer than this is followed by a smaller one, so that ctrl-c is quick.
const LONG_SLICE: Duration = Duration::from_millis(250);

/// Splits `count` rows into slices that each take a moment, and stops once `cancel` is true. The
/// sizes of the slices depend on the time only where rays are slow.
pub(crate) fn in_slices(count: usize, cancel: &AtomicBool, mut work: impl FnMut(Range<usize>)) {
    let (mut first, mut size) = (0, FIRST_SLICE);
    while first < count && !cancel.load(Ordering::Relaxed) {
        let end = count.min(first + size);
        let start = Instant::now();
        work(first..end);
        first = end;
        size = match start.elapsed() {
            long if long > 2 * LONG_SLICE => (size / 4).max(1),
            long if long > LONG_SLICE => size,
            _ => (2 * size).min(MOST_SLICE),
        };
    }
}

/// Runs short work here, without the interpreter's lock.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work)).map_err(|panic| message_of(&*panic)))
        .map_err(|message| errors::defect(&message))
}

/// Calls of fewer rows run on the thread that calls: they end before a signal would be looked for.
const FEW: usize = 1000;

/// Runs work on this many rows, or lines, where its length fits: [`detached`] or [`interruptible`].
pub(crate) fn by_length<T: Send>(
    py: Python<'_>,
    rows: usize,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    if rows < FEW {
        return detached(py, || work(&AtomicBool::new(false)));
    }
    interruptible(py, |_| Ok(()), work)
}

/// Runs long work on another thread. A signal such as ctrl-c sets the flag that the work gets, and
/// the exception of its handler is returned once the work has stopped. `tick` is called about every
/// twentieth of a second, with the lock.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    mut tick: impl FnMut(Python<'_>) -> PyResult<()>,
    work: impl FnOnce(&AtomicBool) -> T + Send,
) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    let (sender, receiver) = sync_channel(1);
    std::thread::scope(|scope| {
        let (cancel, work) = (&cancel, AssertUnwindSafe(work));
        std::thread::Builder::new()
            .spawn_scoped(scope, move || {
                let AssertUnwindSafe(work) = work;
                let done = catch_unwind(AssertUnwindSafe(|| work(cancel)));
                // The receiver waits until it has the answer.
                let _ = sender.send(done.map_err(|panic| message_of(&*panic)));
            })
            .map_err(|error| errors::defect(&format!("no thread can be started: {error}")))?;
        let mut stopped = None;
        let receiver = Mutex::new(receiver);
        loop {
            match received(py, &receiver) {
                Ok(done) => {
                    let done = done.map_err(|message| errors::defect(&message));
                    return stopped.map_or(done, Err);
                }
                Err(RecvTimeoutError::Disconnected) => return Err(errors::defect("the work has no answer")),
                Err(RecvTimeoutError::Timeout) if stopped.is_some() => {}
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(error) = py.check_signals().and_then(|()| tick(py)) {
                        cancel.store(true, Ordering::Relaxed);
                        stopped = Some(error);
                    }
                }
            }
        }
    })
}

/// Runs long work that cannot be stopped on a thread of its own, which has all that it needs. After a signal such
/// as ctrl-c the exception of its handler is returned at once; the thread ends by itself, and its answer is
/// dropped.
pub(crate) fn abandonable<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (sender, receiver) = sync_channel(1);
    std::thread::Builder::new()
        .spawn(move || {
            let done = catch_unwind(AssertUnwindSafe(work));
            // Nobody may be waiting any more.
            let _ = sender.send(done.map_err(|panic| message_of(&*panic)));
        })
        .map_err(|error| errors::defect(&format!("no thread can be started: {error}")))?;
    let receiver = Mutex::new(receiver);
    loop {
        match received(py, &receiver) {
            Ok(done) => return done.map_err(|message| errors::defect(&message)),
            Err(RecvTimeoutError::Disconnected) => return Err(errors::defect("the work has no answer")),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
        }
    }
}

/// The answer of a thread, if it comes before a signal is to be looked for. Waits without the interpreter's lock.
fn received<T: Send>(py: Python<'_>, receiver: &Mutex<Receiver<T>>) -> Result<T, RecvTimeoutError> {
    py.detach(AssertUnwindSafe(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(POLL)))
}

/// The number of threads; 0 stands for one for each core.
pub(crate) fn thread_count(threads: usize) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    if threads == 0 { all() } else { threads }
}

/// Splits rows over threads, and returns the answers in their order. Threads end early once `cancel`
/// is true; `rows` must look at it.
pub(crate) fn in_parallel<T: Send>(
    count: usize,
    threads: usize,
    rows: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let part = count.div_ceil(thread_count(threads).min(count.max(1))).max(1);
    if part >= count {
        return rows(0..count);
    }
    let rows = &rows;
    std::thread::scope(|scope| {
        let parts = (0..count).step_by(part).map(|first| first..count.min(first + part));
        let threads: Vec<_> = parts.map(|part| scope.spawn(move || rows(part))).collect();
        let mut all = Vec::with_capacity(count);
        for thread in threads {
            match thread.join() {
                Ok(answers) => all.extend(answers),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    })
}

fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic").to_owned()
}
