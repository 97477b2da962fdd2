//! Refusal of arrays that memory cannot hold. Without it the allocator ends the
//! interpreter, or the system does.

use crate::error::wrong_option;
use chladni_frf::{Error, ErrorKind};
use pyo3::prelude::*;

const GIB: f64 = (1u64 << 30) as f64;

/// Refuses an array of `T` with these axes where it does not fit into memory.
///
/// * `field`: the argument that errors name
/// * `help`: what makes the array smaller
pub fn check_room<T>(py: Python<'_>, field: &str, shape: &[usize], help: &str) -> PyResult<()> {
    let bytes = shape
        .iter()
        .try_fold(size_of::<T>(), |bytes, &length| bytes.checked_mul(length));
    let free = free_bytes();
    let fits = |&bytes: &usize| {
        free.is_none_or(|free| bytes as f64 <= free)
            && Vec::<u8>::new().try_reserve_exact(bytes).is_ok()
    };
    if bytes.filter(fits).is_some() {
        return Ok(());
    }
    let needed = shape.iter().map(|&length| length as f64).product::<f64>() * size_of::<T>() as f64;
    let axes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    let found = format!("{:.3} GiB for {} values", needed / GIB, axes.join(" x "));
    let expected = match free.filter(|&free| free < needed) {
        Some(free) => format!("at most {:.3} GiB, as much as is free", free / GIB),
        None => "as much as the system gives to this process".into(),
    };
    let error = Error::new(ErrorKind::Usage, "more memory is needed than there is");
    Err(wrong_option(
        py,
        field,
        error.found(found).expected(expected).help(help),
    ))
}

/// Memory that can be used without taking it from other programs, swap included; `None`
/// where the system does not say it (other systems than Linux).
fn free_bytes() -> Option<f64> {
    let said = std::fs::read_to_string("/proc/meminfo").ok()?;
    let kib = |name: &str| -> Option<f64> {
        let line = said.lines().find_map(|line| line.strip_prefix(name))?;
        line.trim_end_matches("kB").trim().parse().ok()
    };
    let swap = kib("SwapFree:").unwrap_or(0.0);
    Some(1024.0 * (kib("MemAvailable:")? + swap))
}
