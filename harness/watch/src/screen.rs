//! The view in a terminal: totals, connections, and the last findings.

use crate::counts::{ConnectionCounts, WatchCounts};
use std::fmt::Write as _;

/// The share of the intervals whose deviation is shown.
const MOST_INTERVALS: f64 = 0.99;
/// Lines of the view that are neither connections nor findings.
const HEAD: usize = 6;

/// The view for a terminal of so many columns and rows.
pub fn screen<'r>(
    counts: &WatchCounts,
    source: &str,
    recent: impl Iterator<Item = &'r str>,
    (columns, rows): (usize, usize),
) -> String {
    let findings: u64 = counts.findings.values().sum();
    let up = counts.connections.values().filter(|of| of.is_up).count();
    let mut lines = vec![
        format!(
            "{source}: {} frames, {:.1} Mbit/s, {up} of {} connections up, {findings} findings, {} incidents",
            counts.frames,
            counts.load as f64 / 1e6,
            counts.connections.len(),
            counts.incidents
        ),
        losses(counts),
        String::new(),
        format!(
            "{:32} {:>4} {:>10} {:>7} {:>6} {:>8} {:>9} {:>7} {:>6} {:>6}",
            "controller > device", "", "frames", "lost", "gaps", "overtook", "jitter", "longest", "alarms", "ends"
        ),
    ];
    let recent: Vec<&str> = recent.collect();
    let room = rows.saturating_sub(HEAD + recent.len()).max(2);
    let mut connections: Vec<_> = counts.connections.iter().collect();
    // What is in trouble comes first.
    connections.sort_by_key(|(name, of)| (std::cmp::Reverse(trouble(of)), *name));
    let (shown, left) = (connections.len().min(room / 2), connections.len().saturating_sub(room / 2));
    for ((controller, device), of) in connections.into_iter().take(shown) {
        for (place, (word, direction)) in ["from", "to"].into_iter().zip(&of.directions).enumerate() {
            let name = if place == 0 { format!("{controller} > {device}") } else { String::new() };
            let jitter = match direction.jitter_below_us(MOST_INTERVALS) {
                _ if direction.frames < 2 => "-".to_owned(),
                Some(micros) => format!("<{micros} us"),
                None => ">10 ms".to_owned(),
            };
            let mut line = format!(
                "{name:32.32} {word:>4} {:>10} {:>7} {:>6} {:>8} {jitter:>9} {:>5} ms",
                direction.frames,
                direction.lost,
                direction.gaps,
                direction.overtaken,
                direction.longest_interval.as_millis()
            );
            if place == 0 {
                let _ = write!(line, " {:>5} {:>6}", of.alarms, of.aborts + of.failures);
            }
            lines.push(line);
        }
    }
    if left > 0 {
        lines.push(format!("... and {left} more connections"));
    }
    lines.push(String::new());
    lines.extend(recent.into_iter().map(str::to_owned));
    let cut = |line: &String| line.chars().take(columns).collect::<String>();
    lines.iter().take(rows.saturating_sub(1)).map(cut).collect::<Vec<_>>().join("\n")
}

fn losses(counts: &WatchCounts) -> String {
    match (counts.lost_by_kernel, counts.lost_by_ring, counts.not_judged) {
        (0, 0, 0) => "no frame lost by this host".to_owned(),
        (kernel, ring, watch) => format!(
            "{kernel} frames lost by the kernel (not judged), {ring} by the ring (judged, not kept), {watch} by this watch (kept, not \
             judged)"
        ),
    }
}

fn trouble(of: &ConnectionCounts) -> u64 {
    u64::from(!of.is_up) + of.aborts + of.failures + of.alarms + of.directions.iter().map(|of| of.lost).sum::<u64>()
}
