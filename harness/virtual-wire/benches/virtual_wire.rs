//! Steps per second of a virtual wire with stations that exchange cyclic frames.

mod rate;

use encspec_virtual_wire::VirtualWire;
use rate::rate;
use station::{Duration, Outbox, Station, Time};

const CYCLE: Duration = Duration::from_millis(1);
const CYCLES: u64 = 50_000;

/// Sends one frame in each cycle and reads none.
struct Cyclic {
    next: Time,
}

impl Station for Cyclic {
    fn receive(&mut self, _now: Time, _frame: &[u8], _out: &mut Outbox) {}

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        out.push(&[0x5A; 64]);
        self.next = now + CYCLE;
    }

    fn deadline(&self) -> Option<Time> {
        Some(self.next)
    }
}

fn steps(stations: usize) {
    // Each frame is one step to send and one to deliver.
    rate(&format!("{stations} stations"), "steps", 2 * CYCLES as usize * stations, || {
        let mut all: Vec<Cyclic> = (0..stations).map(|_| Cyclic { next: Time::ZERO }).collect();
        let mut ports: Vec<&mut dyn Station> = all.iter_mut().map(|station| station as &mut dyn Station).collect();
        let mut frames = 0u64;
        let until = Time::ZERO + CYCLE * CYCLES as u32 - Duration::from_nanos(1);
        VirtualWire::new().run(&mut ports, until, &mut |_| frames += 1);
        assert_eq!(frames, CYCLES * stations as u64);
    });
}

fn main() {
    [2, 8, 32].into_iter().for_each(steps);
}
