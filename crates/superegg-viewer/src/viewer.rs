//! The event loop with its window, and the handle that reaches it from any thread.

use std::sync::mpsc::Sender;

use winit::event_loop::{EventLoop, EventLoopProxy};

use crate::display_loss;
use crate::protocol::{FromViewer, NoWindow, Shown};
use crate::tracer::Pass;
use crate::window::App;
use crate::worker::Ready;

/// What reaches the event loop from other threads.
#[derive(Debug)]
pub(crate) enum Event {
    Open(Box<Shown>),
    Show(Box<Shown>),
    Notice(String),
    Interact,
    Close,
    Quit,
    Ready(Ready),
    Traced(Box<Pass>),
    GpuFault(String),
}

/// The event loop with its window. It belongs on the main thread.
#[derive(Debug)]
pub struct Viewer {
    event_loop: EventLoop<Event>,
}

/// The way to a viewer from any thread. All of it does nothing once the viewer has ended.
#[derive(Clone, Debug)]
pub struct ViewerHandle {
    proxy: EventLoopProxy<Event>,
}

impl Viewer {
    /// Connects to the display, and opens no window yet. A process can do this once.
    ///
    /// # Errors
    /// There is no display.
    pub fn new() -> Result<Self, NoWindow> {
        // Some systems have no library to ask, and say so by panicking.
        let built = std::panic::catch_unwind(|| EventLoop::with_user_event().build());
        match built {
            Ok(Ok(event_loop)) => Ok(Self { event_loop }),
            Ok(Err(error)) => {
                let text = first_line(&error.to_string());
                // It begins with the line of the library's source that says it.
                let reason = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
                Err(NoWindow::NoDisplay(reason.map_or(text.clone(), |(_, reason)| reason.to_owned())))
            }
            Err(_) => Err(NoWindow::NoDisplay("the window library is incomplete".to_owned())),
        }
    }

    /// The way to this viewer from other threads.
    pub fn handle(&self) -> ViewerHandle {
        ViewerHandle { proxy: self.event_loop.create_proxy() }
    }

    /// Runs the event loop until [`ViewerHandle::quit`], or until the receiver of `out` has gone and the window is closed. Opens the window at
    /// once where `first` is something to show.
    ///
    /// On X11 a display that goes away ends the process from within its library. Then `after_loss` is called in place of a
    /// return, on this thread, after [`FromViewer::Say`] and [`FromViewer::Closed`]: it should wait for what else the process does, and exit.
    /// If it returns, the thread sleeps for good.
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
        // The window library unwraps answers of the display; they are errors once it has gone.
        let run = std::panic::AssertUnwindSafe(|| event_loop.run_app(&mut app));
        let ended = std::panic::catch_unwind(run);
        if !matches!(ended, Ok(Ok(()))) {
            guard.tell_once();
        }
    }
}

impl ViewerHandle {
    fn send(&self, event: Event) {
        // An error says that the loop has ended.
        let _ = self.proxy.send_event(event);
    }

    /// Opens the window, or brings it to the front, with this.
    pub fn open(&self, shown: Shown) {
        self.send(Event::Open(Box::new(shown)));
    }

    /// Shows this from now on, if the window is open, and when it is opened.
    pub fn show(&self, shown: Shown) {
        self.send(Event::Show(Box::new(shown)));
    }

    /// Shows a line of text in the window for a while, such as the error of a command that came from there.
    pub fn notice(&self, text: String) {
        self.send(Event::Notice(text));
    }

    /// Asks the desktop to give the window the keyboard.
    pub fn interact(&self) {
        self.send(Event::Interact);
    }

    /// Closes the window; the event loop goes on.
    pub fn close(&self) {
        self.send(Event::Close);
    }

    /// Closes the window and lets [`Viewer::run`] return.
    pub fn quit(&self) {
        self.send(Event::Quit);
    }
}

pub(crate) fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().trim().to_owned()
}
