//! Stops work on ctrl-c or SIGTERM, in time to write the finished part.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context, Result};

use crate::console;

/// The exit code after ctrl-c, as shells report it.
const EXIT_INTERRUPTED: u8 = 130;
/// The exit code after SIGTERM, as shells report it.
#[cfg(unix)]
const EXIT_TERMINATED: u8 = 143;

/// Handles ctrl-c and SIGTERM, which schedulers send before they kill. A second signal ends the
/// program at once.
pub(crate) struct Interrupt {
    is_requested: Arc<AtomicBool>,
    is_terminated: Arc<AtomicBool>,
    has_stopped: Arc<AtomicBool>,
}

/// The maximum time from a signal to the end of the work; then the program ends.
const STOP_TIMEOUT: Duration = Duration::from_secs(10);
/// The interval of the checks.
const POLL: Duration = Duration::from_millis(200);

impl Interrupt {
    /// Installs the handlers.
    ///
    /// # Errors
    /// The system rejects a handler.
    pub(crate) fn listen() -> Result<Self> {
        let [is_requested, is_terminated, has_stopped] = [(); 3].map(|()| Arc::new(AtomicBool::new(false)));
        let requested = Arc::clone(&is_requested);
        let on_interrupt = move || {
            if requested.swap(true, Ordering::Relaxed) {
                std::process::exit(EXIT_INTERRUPTED.into());
            }
        };
        ctrlc::set_handler(on_interrupt).context("cannot take over ctrl-c")?;
        #[cfg(unix)]
        {
            use signal_hook::consts::SIGTERM;
            use signal_hook::flag::{register, register_conditional_shutdown};
            let registered =
                register_conditional_shutdown(SIGTERM, EXIT_TERMINATED.into(), Arc::clone(&is_requested))
                    .and_then(|_| register(SIGTERM, Arc::clone(&is_terminated)))
                    .and_then(|_| register(SIGTERM, Arc::clone(&is_requested)));
            registered.context("cannot take over the signal to terminate")?;
        }
        let interrupt = Self { is_requested, is_terminated, has_stopped };
        interrupt.watch();
        Ok(interrupt)
    }

    /// Ends the program when the work does not stop: a single ray through a deep fractal with
    /// overlapping parts can take very long.
    fn watch(&self) {
        let watched = Self {
            is_requested: Arc::clone(&self.is_requested),
            is_terminated: Arc::clone(&self.is_terminated),
            has_stopped: Arc::clone(&self.has_stopped),
        };
        std::thread::spawn(move || {
            while !watched.flag().load(Ordering::Relaxed) {
                std::thread::sleep(POLL);
            }
            std::thread::sleep(STOP_TIMEOUT);
            if !watched.has_stopped.load(Ordering::Relaxed) {
                console::warn(
                    "superegg: stopped within an unfinished tile; finished tiles stay in the partial file, and finished frames in their folder",
                );
                std::process::exit(watched.exit_code().into());
            }
        });
    }

    /// Reports that the work has ended. From now on the program waits for its files to be written.
    pub(crate) fn work_ended(&self) {
        self.has_stopped.store(true, Ordering::Relaxed);
    }

    /// Becomes true when the work must stop.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.is_requested
    }

    /// The exit code of a program that a signal stopped.
    pub(crate) fn exit_code(&self) -> u8 {
        #[cfg(unix)]
        if self.is_terminated.load(Ordering::Relaxed) {
            return EXIT_TERMINATED;
        }
        EXIT_INTERRUPTED
    }
}
