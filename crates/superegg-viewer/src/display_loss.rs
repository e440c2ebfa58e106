//! A display that goes away. Xlib ends the process when its server has gone; a prompt beside the window must outlive that.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};

use crate::protocol::FromViewer;

/// Told in the place of the window.
const SENTENCE: &str = "the display has gone away, and the viewer's window with it; everything else goes on";

type AfterLoss = Box<dyn FnOnce() + Send>;

/// Tells of the loss once, whoever notices it first.
#[derive(Clone)]
pub(crate) struct Guard(Arc<Inner>);

struct Inner {
    out: Mutex<Sender<FromViewer>>,
    after_loss: Mutex<Option<AfterLoss>>,
    is_told: AtomicBool,
}

impl Guard {
    pub(crate) fn new(out: Sender<FromViewer>, after_loss: AfterLoss) -> Self {
        Self(Arc::new(Inner {
            out: Mutex::new(out),
            after_loss: Mutex::new(Some(after_loss)),
            is_told: AtomicBool::new(false),
        }))
    }

    /// Says that the display has gone.
    pub(crate) fn tell_once(&self) {
        if !self.0.is_told.swap(true, Ordering::SeqCst) {
            let out = self.0.out.lock().unwrap_or_else(PoisonError::into_inner);
            let _ = out.send(FromViewer::Say(SENTENCE.to_owned()));
            let _ = out.send(FromViewer::Closed);
        }
    }

    /// What happens in the place of the library's exit. Does not return: the library must not go on without its server.
    fn outlive(&self) -> ! {
        self.tell_once();
        let after_loss = self.0.after_loss.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(after_loss) = after_loss {
            after_loss();
        }
        loop {
            std::thread::park();
        }
    }

    /// Takes the place of Xlib's exit for the connection of an event loop, where it has one.
    #[cfg(all(unix, not(target_vendor = "apple")))]
    pub(crate) fn watch<T>(&self, event_loop: &winit::event_loop::EventLoop<T>) {
        x11::watch(self, event_loop);
    }

    /// Elsewhere a display does not go away.
    #[cfg(not(all(unix, not(target_vendor = "apple"))))]
    pub(crate) fn watch<T>(&self, _event_loop: &winit::event_loop::EventLoop<T>) {}
}

#[cfg(all(unix, not(target_vendor = "apple")))]
mod x11 {
    // Xlib calls exit() on this thread when its server has gone, and only a C function registered with it can come before that.
    #![allow(unsafe_code)]

    use std::ffi::{c_int, c_void};

    use winit::event_loop::EventLoop;
    use winit::raw_window_handle::{HasDisplayHandle, RawDisplayHandle};

    use super::Guard;

    type OnError = unsafe extern "C" fn(*mut c_void) -> c_int;
    type OnExit = unsafe extern "C" fn(*mut c_void, *mut c_void);
    type SetOnError = unsafe extern "C" fn(Option<OnError>) -> Option<OnError>;
    type SetOnExit = unsafe extern "C" fn(*mut c_void, OnExit, *mut c_void);

    /// Called by Xlib instead of exit(), with what was registered.
    unsafe extern "C" fn on_exit(_display: *mut c_void, guard: *mut c_void) {
        // SAFETY: `watch` registered a leaked `Guard`, which nothing frees and which is only read.
        let guard = unsafe { &*guard.cast::<Guard>() };
        // A panic must not leave a function of C.
        let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| guard.outlive()));
        if ended.is_err() {
            std::process::abort();
        }
    }

    /// Takes the place of Xlib's message on the terminal, after which it would exit by itself.
    unsafe extern "C" fn on_error(_display: *mut c_void) -> c_int {
        0
    }

    pub(super) fn watch<T>(guard: &Guard, event_loop: &EventLoop<T>) {
        let Ok(handle) = event_loop.display_handle() else { return };
        let RawDisplayHandle::Xlib(handle) = handle.as_raw() else { return };
        let Some(display) = handle.display else { return };
        // SAFETY: libX11 is loaded already, by the event loop that has this handle; loading it runs nothing new, and it stays loaded. The
        // functions have these types since libX11 1.7, and the second is missing before. Display and guard outlive the last call.
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
