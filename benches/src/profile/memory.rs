//! Memory of this process, where the system tells (Linux).

use std::fs;

/// Resident memory now, bytes.
pub(crate) fn resident_bytes() -> Option<f64> {
    status("VmRSS:")
}

/// Largest resident memory since [`forget_peak`], bytes.
pub(crate) fn peak_bytes() -> Option<f64> {
    status("VmHWM:")
}

/// Starts a new peak at what is resident now; false where the system cannot.
pub(crate) fn forget_peak() -> bool {
    // proc(5): 5 resets the peak resident set size
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

fn status(key: &str) -> Option<f64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}
