//! How much memory the process has taken.

/// The most memory that the process has had resident so far, in bytes; `None` where the system does not tell.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    own_peak().or_else(peak_of_usage)
}

/// Starts counting the peak anew, where the system lets it, and returns the memory resident now, in bytes.
pub(crate) fn restart_peak() -> Option<u64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    status_bytes("VmRSS:")
}

/// Linux counts a process from its start there; what `getrusage` says begins with the program that started it.
fn own_peak() -> Option<u64> {
    status_bytes("VmHWM:")
}

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
    // Apple's systems count in bytes, the others in kibibytes.
    Some(if cfg!(target_vendor = "apple") { max_rss } else { max_rss * 1024 })
}

#[cfg(not(unix))]
fn peak_of_usage() -> Option<u64> {
    None
}
