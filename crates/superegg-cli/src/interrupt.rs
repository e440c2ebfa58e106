//! Being asked to stop while there is still time to write what there is.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context, Result};

use crate::say;

/// What a shell says of a program that ctrl-c ended.
const EXIT_INTERRUPTED: u8 = 130;
/// What it says of one that was told to terminate.
#[cfg(unix)]
const EXIT_TERMINATED: u8 = 143;

/// Ctrl-c, and the termination that schedulers send before they kill. The second time the program ends at once.
pub(crate) struct Interrupt {
    is_asked: Arc<AtomicBool>,
    is_terminated: Arc<AtomicBool>,
    has_stopped: Arc<AtomicBool>,
}

/// Work that has not stopped so long after it was asked to is not waited for.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often that is looked at.
const LOOK: Duration = Duration::from_millis(200);

impl Interrupt {
    /// Listens from now on.
    ///
    /// # Errors
    /// The system does not let us.
    pub(crate) fn listen() -> Result<Self> {
        let [is_asked, is_terminated, has_stopped] = [(); 3].map(|()| Arc::new(AtomicBool::new(false)));
        let asked = Arc::clone(&is_asked);
        let on_interrupt = move || {
            if asked.swap(true, Ordering::Relaxed) {
                std::process::exit(EXIT_INTERRUPTED.into());
            }
        };
        ctrlc::set_handler(on_interrupt).context("cannot take over ctrl-c")?;
        #[cfg(unix)]
        {
            use signal_hook::consts::SIGTERM;
            use signal_hook::flag::{register, register_conditional_shutdown};
            let registered =
                register_conditional_shutdown(SIGTERM, EXIT_TERMINATED.into(), Arc::clone(&is_asked))
                    .and_then(|_| register(SIGTERM, Arc::clone(&is_terminated)))
                    .and_then(|_| register(SIGTERM, Arc::clone(&is_asked)));
            registered.context("cannot take over the signal to terminate")?;
        }
        let interrupt = Self { is_asked, is_terminated, has_stopped };
        interrupt.watch();
        Ok(interrupt)
    }

    /// Ends the program when work does not stop: one ray through a deep fractal whose parts overlap may take longer than anyone waits.
    fn watch(&self) {
        let watched = Self {
            is_asked: Arc::clone(&self.is_asked),
            is_terminated: Arc::clone(&self.is_terminated),
            has_stopped: Arc::clone(&self.has_stopped),
        };
        std::thread::spawn(move || {
            while !watched.flag().load(Ordering::Relaxed) {
                std::thread::sleep(LOOK);
            }
            std::thread::sleep(PATIENCE);
            if !watched.has_stopped.load(Ordering::Relaxed) {
                say::complain(
                    "superegg: stopped in the middle of a tile that does not come to its end; those that did stay in the partial file, and finished frames in their folder",
                );
                std::process::exit(watched.exit_code().into());
            }
        });
    }

    /// The work has stopped, or is done: what is still to be written is waited for.
    pub(crate) fn has_stopped(&self) {
        self.has_stopped.store(true, Ordering::Relaxed);
    }

    /// Turns true when the work is to stop.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.is_asked
    }

    /// The exit code of a program that was asked to stop, and has.
    pub(crate) fn exit_code(&self) -> u8 {
        #[cfg(unix)]
        if self.is_terminated.load(Ordering::Relaxed) {
            return EXIT_TERMINATED;
        }
        EXIT_INTERRUPTED
    }
}
