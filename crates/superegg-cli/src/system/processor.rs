//! Processor cores and processor time.

/// The number of render threads where the user does not set it: one for each core.
pub(crate) fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The processor time of this thread in seconds.
pub(crate) fn thread_seconds() -> f64 {
    #[cfg(target_os = "linux")]
    if let Some(seconds) = clock_seconds(nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID) {
        return seconds;
    }
    wall_seconds()
}

/// The processor time of all threads of the process in seconds.
pub(crate) fn process_seconds() -> f64 {
    #[cfg(target_os = "linux")]
    if let Some(seconds) = clock_seconds(nix::time::ClockId::CLOCK_PROCESS_CPUTIME_ID) {
        return seconds;
    }
    wall_seconds()
}

#[cfg(target_os = "linux")]
fn clock_seconds(clock: nix::time::ClockId) -> Option<f64> {
    let time = nix::time::clock_gettime(clock).ok()?;
    Some(time.tv_sec() as f64 + 1e-9 * time.tv_nsec() as f64)
}

/// The time of day in seconds, for systems without a processor clock.
fn wall_seconds() -> f64 {
    std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}
