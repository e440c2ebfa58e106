//! The memory use of the process.

/// The peak resident memory in bytes; `None` where the system does not report it.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    status_bytes("VmHWM:").or_else(peak_of_usage)
}

/// Resets the peak, where the system supports it, and returns the current resident memory in bytes.
pub(crate) fn reset_peak() -> Option<u64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    status_bytes("VmRSS:")
}

/// A field of Linux's process status, in bytes. Unlike `getrusage` it excludes the parent program.
fn status_bytes(field: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(field))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(unix)]
fn peak_of_usage() -> Option<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let max_rss = u64::try_from(getrusage(UsageWho::RUSAGE_SELF).ok()?.max_rss()).ok()?;
    // Apple's systems report bytes, the others kibibytes.
    Some(if cfg!(target_vendor = "apple") { max_rss } else { max_rss * 1024 })
}

#[cfg(not(unix))]
fn peak_of_usage() -> Option<u64> {
    None
}
