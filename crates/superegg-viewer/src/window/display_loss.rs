//! Loss of the display. Xlib ends the process when its server is gone, but the prompt beside the
//! window must survive.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;

use parking_lot::Mutex;

use crate::protocol::FromViewer;

/// The report of the loss.
const REPORT: &str = "the display has gone away, and the viewer's window with it; everything else continues";

type AfterLoss = Box<dyn FnOnce() + Send>;

/// Reports the loss once, whichever of its clones notices it first.
#[derive(Clone)]
pub(crate) struct Guard(Arc<Inner>);

struct Inner {
    out: Sender<FromViewer>,
    after_loss: Mutex<Option<AfterLoss>>,
    is_reported: AtomicBool,
}

impl Guard {
    pub(crate) fn new(out: Sender<FromViewer>, after_loss: AfterLoss) -> Self {
        Self(Arc::new(Inner {
            out,
            after_loss: Mutex::new(Some(after_loss)),
            is_reported: AtomicBool::new(false),
        }))
    }

    /// Reports the loss of the display.
    pub(crate) fn report_once(&self) {
        if !self.0.is_reported.swap(true, Ordering::SeqCst) {
            let _ = self.0.out.send(FromViewer::Message(REPORT.to_owned()));
            let _ = self.0.out.send(FromViewer::Closed { by_user: false });
        }
    }

    /// Replaces the exit of the library. It does not return: the library must not continue without
    /// its server.
    fn outlive(&self) -> ! {
        self.report_once();
        let after_loss = self.0.after_loss.lock().take();
        if let Some(after_loss) = after_loss {
            after_loss();
        }
        loop {
            std::thread::park();
        }
    }

    /// Replaces Xlib's exit for the connection of an event loop, if it has one.
    #[cfg(all(unix, not(target_vendor = "apple")))]
    pub(crate) fn watch<T>(&self, event_loop: &winit::event_loop::EventLoop<T>) {
        x11::watch(self, event_loop);
    }

    /// Other systems do not lose their display.
    #[cfg(not(all(unix, not(target_vendor = "apple"))))]
    pub(crate) fn watch<T>(&self, _event_loop: &winit::event_loop::EventLoop<T>) {}
}

#[cfg(all(unix, not(target_vendor = "apple")))]
mod x11 {
    // Xlib calls exit() on this thread when its server is gone. Only a C function registered with
    // it runs before that.
    #![allow(unsafe_code)]

    use std::ffi::{c_int, c_void};

    use winit::event_loop::EventLoop;
    use winit::raw_window_handle::{HasDisplayHandle, RawDisplayHandle};

    use super::Guard;

    type OnError = unsafe extern "C" fn(*mut c_void) -> c_int;
    type OnExit = unsafe extern "C" fn(*mut c_void, *mut c_void);
    type SetOnError = unsafe extern "C" fn(Option<OnError>) -> Option<OnError>;
    type SetOnExit = unsafe extern "C" fn(*mut c_void, OnExit, *mut c_void);

    /// Called by Xlib instead of exit(), with the registered pointer.
    unsafe extern "C" fn on_exit(_display: *mut c_void, guard: *mut c_void) {
        // SAFETY: `watch` registered a leaked `Guard`. Nothing frees or writes it.
        let guard = unsafe { &*guard.cast::<Guard>() };
        // A panic must not unwind into C.
        let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| guard.outlive()));
        if ended.is_err() {
            std::process::abort();
        }
    }

    /// Replaces Xlib's default handler, which prints to the terminal and exits.
    unsafe extern "C" fn on_error(_display: *mut c_void) -> c_int {
        0
    }

    pub(super) fn watch<T>(guard: &Guard, event_loop: &EventLoop<T>) {
        let Ok(handle) = event_loop.display_handle() else { return };
        let RawDisplayHandle::Xlib(handle) = handle.as_raw() else { return };
        let Some(display) = handle.display else { return };
        // SAFETY: the event loop with this handle has loaded libX11 already; loading it again runs
        // nothing new, and it stays loaded. The functions have these types since libX11 1.7; older
        // versions lack `XSetIOErrorExitHandler`. Display and guard outlive the last call.
        unsafe {
            let Ok(library) = libloading::Library::new("libX11.so.6") else { return };
            let library = Box::leak(Box::new(library));
            let set_on_exit = library.get::<SetOnExit>(b"XSetIOErrorExitHandler\0");
            let set_on_error = library.get::<SetOnError>(b"XSetIOErrorHandler\0");
            if let (Ok(set_on_exit), Ok(set_on_error)) = (set_on_exit, set_on_error) {
                let guard: *mut Guard = Box::into_raw(Box::new(guard.clone()));
                set_on_exit(display.as_ptr(), on_exit, guard.cast());
                set_on_error(Some(on_error));
            }
        }
    }
}
