//! A running machine: cyclic frames of stations in pairs, without their Connect (IEC 61158-6-10: FrameID, data, cycle counter in units
//! of 31.25 us, DataStatus, TransferStatus).

use encspec_watch::{LiveWatch, WatchLine};
use station::{Duration, Time};
use virtual_wire::capture::LinkType;

/// Primary, data valid, run, no problem.
pub const GOOD: u8 = 0x35;
pub const STOP: u8 = 0x25;
/// The counter step of 1 ms.
const STEP: u16 = 32;
/// 2026-11-28.
const BEGIN: u64 = 1_795_824_000_000_000_000;

/// A cyclic frame of station `from` to its peer.
pub fn frame(from: u8, cycle: u64, status: u8) -> Vec<u8> {
    let to = from ^ 1;
    let mut octets = vec![2, 0, 0, 0, 0, to, 2, 0, 0, 0, 0, from, 0x88, 0x92, 0x80, 0x01];
    octets.extend([0x80; 40]);
    octets.extend((cycle as u16).wrapping_mul(STEP).to_be_bytes());
    octets.extend([status, 0]);
    octets
}

pub fn time(cycle: u64) -> Time {
    Time::from_nanos(BEGIN + cycle * 1_000_000)
}

/// Passes `cycles` of two pairs of stations to the watch, as `change` makes them: no frame, or one with this status.
pub fn run(
    watch: &mut LiveWatch<'_>,
    cycles: std::ops::Range<u64>,
    change: impl Fn(u8, u64) -> Option<u8>,
) -> Vec<(Time, WatchLine)> {
    let mut lines = Vec::new();
    for cycle in cycles {
        for from in 0x10..0x14 {
            if let Some(status) = change(from, cycle) {
                let octets = frame(from, cycle, status);
                let at = time(cycle) + Duration::from_micros(u64::from(from) * 10);
                watch.frame(at, LinkType::ETHERNET, &octets, octets.len() as u32);
            }
        }
        let now = time(cycle + 1);
        if watch.is_due(now) {
            lines.extend(watch.tick(now).into_iter().map(|line| (now, line)));
        }
    }
    lines
}

/// Id, severity and time of each finding.
pub fn findings(lines: &[(Time, WatchLine)]) -> Vec<(String, &'static str, Time)> {
    let of = |(now, line): &(Time, WatchLine)| match line {
        WatchLine::Finding(line) => Some((line.finding.id.clone(), line.severity, *now)),
        _ => None,
    };
    lines.iter().filter_map(of).collect()
}
