//! Turns of the shaft over everything where a position can go wrong, and velocities in every unit.

use super::*;

/// What was seen on the way, in order.
struct Turns<'a> {
    bench: Bench,
    seen: &'a mut Vec<u64>,
}

impl Turns<'_> {
    fn connect(&mut self, telegram: u32, record: &[u8]) {
        self.seen.push(self.bench.connect(telegram, record).map_or(1, |()| 0));
    }

    fn frames(&mut self, g1_stw: u16, count: usize) {
        self.bench.g1_stw = g1_stw;
        for _ in 0..count {
            let octets = self.bench.octets();
            self.seen.extend(octets.iter().map(|octet| u64::from(*octet)));
        }
    }

    fn act(&mut self, action: StandAction<'_>, count: usize) {
        self.bench.act(action);
        self.frames(0, count);
    }

    fn preset(&mut self, value: u64) {
        self.seen.push(self.bench.write(65000, value).map_or_else(u64::from, |()| 0));
        self.frames(HOME, 30);
        self.frames(0, 30);
    }
}

/// Turns over the physical zero, over the ends of ranges and from one range into the next; then the settings change.
fn positions(turns: &mut Turns<'_>, units: u64, range: u64) {
    turns.connect(81, &record(0x2A, units, range));
    for place in [442_236_920, 500_000_000, 1_073_741_800] {
        turns.act(StandAction::ShaftCounts(place), 2);
        turns.preset(range - 1);
        for steps in [7.0, 100.0, -100.0] {
            turns.act(StandAction::Turn { steps, rpm: 60.0 }, 1);
        }
    }
    turns.connect(81, &record(0x23, 65536, 1 << 30));
    turns.preset(5);
}

/// Starts, stops and presets, at more than a revolution in 100 ms.
fn velocities(turns: &mut Turns<'_>, unit: u8) {
    let mut record = record(0x2B, 3600, 3600);
    record[18] = unit;
    turns.connect(83, &record);
    for speed in [60.0, 6000.0, 0.0] {
        turns.act(StandAction::ShaftSpeed(speed), 120);
    }
    turns.preset(1234);
}

/// Tells what an encoder with the bug shows on these turns.
pub(super) fn walk(seen: &mut Vec<u64>, bug: Option<&Behaviour>) {
    for (units, range) in [(65536, 442_236_928), (65536, 1 << 28), (1000, 3000), (100, 1_638_400), (4096, 1024)] {
        positions(&mut Turns { bench: Bench::alone(MULTITURN, bug, 1_073_741_800), seen: &mut *seen }, units, range);
    }
    for unit in 0..=3 {
        velocities(&mut Turns { bench: Bench::alone(MULTITURN, bug, 0x0123_4567), seen: &mut *seen }, unit);
    }
}
