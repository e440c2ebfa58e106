//! The event loop with its window, and its handle for other threads.

use std::sync::mpsc::Sender;

use winit::event_loop::{EventLoop, EventLoopProxy};

use crate::event::Event;
use crate::protocol::{FromViewer, NoWindow, Shown};
use crate::text::first_line;
use crate::window::app::App;
use crate::window::display_loss;

/// The event loop and its window. It must run on the main thread.
#[derive(Debug)]
pub struct Viewer {
    event_loop: EventLoop<Event>,
}

/// Access to a viewer from any thread. Its methods do nothing after the viewer has ended.
#[derive(Clone, Debug)]
pub struct ViewerHandle {
    proxy: EventLoopProxy<Event>,
}

impl Viewer {
    /// Connects to the display without opening a window. A process can do this once.
    ///
    /// # Errors
    /// There is no display.
    pub fn new() -> Result<Self, NoWindow> {
        // The window library panics where the system's own library is missing.
        let built = std::panic::catch_unwind(|| EventLoop::with_user_event().build());
        match built {
            Ok(Ok(event_loop)) => Ok(Self { event_loop }),
            Ok(Err(error)) => {
                let text = first_line(&error.to_string());
                // The text begins with a position in the library's source.
                let reason = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
                Err(NoWindow::NoDisplay(reason.map_or(text.clone(), |(_, reason)| reason.to_owned())))
            }
            Err(_) => Err(NoWindow::NoDisplay("the window library is incomplete".to_owned())),
        }
    }

    /// A handle for other threads.
    pub fn handle(&self) -> ViewerHandle {
        ViewerHandle { proxy: self.event_loop.create_proxy() }
    }

    /// Runs the event loop until [`ViewerHandle::quit`], or until the receiver of `out` is dropped
    /// and the next message fails. It opens the window at once if there is a `first` snapshot.
    ///
    /// On X11 the loss of the display ends the process from within Xlib. In that case this function
    /// does not return: it sends [`FromViewer::Message`] and [`FromViewer::Closed`] and calls
    /// `after_loss` on this thread. `after_loss` should wait for the other work of the process and
    /// exit. If it returns, the thread sleeps forever.
    pub fn run(
        self,
        first: Option<Shown>,
        out: Sender<FromViewer>,
        after_loss: impl FnOnce() + Send + 'static,
    ) {
        let guard = display_loss::Guard::new(out.clone(), Box::new(after_loss));
        guard.watch(&self.event_loop);
        let proxy = self.event_loop.create_proxy();
        let mut app = App::new(proxy, out, first);
        let event_loop = self.event_loop;
        // The window library unwraps replies of the display, which are errors after its loss.
        let run = std::panic::AssertUnwindSafe(|| event_loop.run_app(&mut app));
        let ended = std::panic::catch_unwind(run);
        if !matches!(ended, Ok(Ok(()))) {
            guard.report_once();
        }
    }
}

impl ViewerHandle {
    fn send(&self, event: Event) {
        // An error means that the loop has ended.
        let _ = self.proxy.send_event(event);
    }

    /// Opens the window, or brings it to the front, with this snapshot.
    pub fn open(&self, shown: Shown) {
        self.send(Event::Open(Box::new(shown)));
    }

    /// Shows this snapshot, now or when the window opens.
    pub fn show(&self, shown: Shown) {
        self.send(Event::Show(Box::new(shown)));
    }

    /// Shows a line of text in the window for a while, such as the error of a command from the
    /// window.
    pub fn notice(&self, text: String) {
        self.send(Event::Notice(text));
    }

    /// Shows a line of text in the window for a while, such as the answer to a command from the
    /// window.
    pub fn inform(&self, text: String) {
        self.send(Event::Inform(text));
    }

    /// Shows the progress of a picture in the window until its end, which `None` reports.
    pub fn rendering(&self, progress: Option<String>) {
        self.send(Event::Rendering(progress));
    }

    /// Requests the keyboard for the window.
    pub fn interact(&self) {
        self.send(Event::Interact);
    }

    /// Closes the window. The event loop continues.
    pub fn close(&self) {
        self.send(Event::Close);
    }

    /// Closes the window and makes [`Viewer::run`] return.
    pub fn quit(&self) {
        self.send(Event::Quit);
    }
}
