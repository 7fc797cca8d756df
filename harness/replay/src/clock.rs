//! The time of a frame in reports.

use station::Time;

/// Seconds since the first frame; negative where the clock stepped back.
pub(super) fn seconds(first: Option<Time>, time: Time) -> f64 {
    let nanos = |time: Time| i128::from(time.as_nanos());
    (nanos(time) - first.map_or(0, nanos)) as f64 / 1e9
}
