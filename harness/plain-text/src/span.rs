//! Durations.

use alloc::{format, string::String};
use core::time::Duration;

/// A duration as `1.25 s`, `8 ms` or `31.25 us`.
pub fn span(duration: Duration) -> String {
    let nanos = duration.as_nanos();
    match nanos {
        0..1_000_000 => format!("{} us", nanos as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{} ms", (nanos / 1_000) as f64 / 1e3),
        _ => format!("{} s", (nanos / 1_000_000) as f64 / 1e3),
    }
}
