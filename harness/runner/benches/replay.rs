//! How many cyclic frames a second are replayed on one core; the budget is 3 million.
//!
//! `cargo bench -p encspec --bench replay`

#[path = "../tests/made/mod.rs"]
mod made;

use bench::capture::Item;
use bench::{CaptureReader, PcapngWriter};
use encspec::observe::{Observation, Tracker};
use encspec::replay::capture;
use encspec::suite::{Sources, load};
use made::{Line, Submodule};
use station::Duration;
use std::hint::black_box;
use std::time::Instant;

const FRAMES: usize = 1_000_000;
const ROUNDS: usize = 5;

/// A start-up, then frames in both directions every millisecond.
fn recorded(mut line: Line, inputs: &[u8]) -> Vec<u8> {
    line.start();
    let mut writer = PcapngWriter::new(Vec::new(), "bench").expect("a vector takes all");
    let interface = writer.interface("wire", bench::capture::LinkType::ETHERNET).expect("a vector takes all");
    for (_, time, frame) in line.iter() {
        writer.packet(interface, time, frame, None).expect("a vector takes all");
    }
    let mut time = line.now;
    for cycle in 0..FRAMES / 2 {
        for by_device in [false, true] {
            let data = if by_device { inputs } else { &[] };
            let frame = made::cyclic(by_device, (cycle as u16).wrapping_mul(64), data);
            writer.packet(interface, time, &frame, None).expect("a vector takes all");
            time += Duration::from_millis(1);
        }
    }
    writer.finish().expect("a vector takes all")
}

/// The best of some rounds, in frames a second.
fn measure(name: &str, mut work: impl FnMut() -> u64) {
    let mut best = f64::MAX;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        assert!(work() >= FRAMES as u64, "{name}: frames are missing");
        best = best.min(begin.elapsed().as_secs_f64());
    }
    println!("{name:<36} {:>6.2} million frames a second", FRAMES as f64 / best / 1e6);
}

fn main() {
    let plain = recorded(Line::new(), &[]);
    measure("capture file alone", || {
        let mut reader = CaptureReader::new(&plain[..]).expect("a capture");
        let mut frames = 0;
        while let Some(Item::Packet(packet)) = reader.next() {
            frames += u64::from(!black_box(packet.captured).is_empty());
        }
        frames
    });
    let mut frames = Vec::new();
    let mut reader = CaptureReader::new(&plain[..]).expect("a capture");
    while let Some(Item::Packet(packet)) = reader.next() {
        frames.push((packet.time, packet.captured.to_vec()));
    }
    measure("tracker alone", || {
        let (mut tracker, mut seen) = (Tracker::new(), 0);
        for (number, (time, octets)) in (1..).zip(&frames) {
            tracker.frame(number, *time, octets, &mut |_, observation| {
                seen += u64::from(matches!(black_box(observation), Observation::Cyclic { .. }));
            });
        }
        seen
    });
    measure("replay without rules", || capture("bench", &plain[..], &[]).expect("a capture").frames);

    let one =
        |slot, subslot, api, ident, input, output| Submodule { api, slot, subslot, module: 1, ident, input, output };
    let submodules = vec![one(0, 1, 0, 1, 0, 0), one(1, 1, 0x3D00, 2, 0, 0), one(1, 2, 0x3D00, 81, 12, 4)];
    let manuals = load(&Sources::embedded(), Some("lika-xac77-profinet")).expect("a suite without mistakes");
    let encoder = recorded(
        Line { submodules, ids: (0x0239, 0x0001), ..Line::new() },
        &[0x80, 0x80, 0, 0, 0x20, 0, 0, 0, 0, 77, 0, 0, 0, 77],
    );
    measure("replay, rules of another device", || capture("bench", &plain[..], &manuals).expect("a capture").frames);
    measure("replay, all rules of the device", || capture("bench", &encoder[..], &manuals).expect("a capture").frames);
}
