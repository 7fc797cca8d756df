//! Measures the speed of replay on one core in cyclic frames per second. The budget is 3 million with the rules of all manuals.
//!
//! `cargo bench -p encspec --bench replay`
//!
//! Two million frames of eight encoders with signs of life, four of which turn and have another position in each frame. For comparison the same file is
//! read by `pcap-parser` alone, and by `tshark -q -z io,stat,0` if tshark is installed.

#[path = "../tests/common/mod.rs"]
mod common;

use common::handmade::{self, ConnectionFrames};
use encspec::observe::{Observation, Tracker};
use encspec::replay::capture;
use encspec::suite_yaml::load;
use pcap_parser::traits::PcapReaderIterator;
use pcap_parser::{PcapBlockOwned, PcapError, PcapNGReader};
use station::Duration;
use std::hint::black_box;
use std::process::{Command, Stdio};
use std::time::Instant;
use virtual_wire::capture::CaptureItem;
use virtual_wire::{CaptureReader, PcapngWriter};
use wire::ethernet::Mac;
use wire::profinet::rpc::Uuid;

const FRAMES: usize = 2_000_000;
const DEVICES: usize = 8;
const ROUNDS: usize = 5;

/// An encoder with telegram 81 and the idents of its suite.
fn encoder(number: u8) -> ConnectionFrames {
    ConnectionFrames {
        device: Mac([2, 0, 0, 0, 1, number]),
        ar: Uuid([number + 1; 16]),
        activity: number * 4 + 1,
        ..ConnectionFrames::to_xac77()
    }
}

/// Eight start-ups, then frames in both directions every 2 ms; `turning` of the encoders turn.
fn recorded(turning: usize) -> Vec<u8> {
    let mut writer = PcapngWriter::new(Vec::new(), "bench").expect("a vector takes all");
    let interface = writer.interface("wire", virtual_wire::capture::LinkType::ETHERNET).expect("a vector takes all");
    let mut time = station::Time::ZERO;
    let mut lines: Vec<ConnectionFrames> = (0..DEVICES as u8).map(encoder).collect();
    for line in &mut lines {
        line.now = line.now.max(time);
        line.start();
        for (_, time, frame) in line.iter() {
            writer.packet(interface, time, frame, None).expect("a vector takes all");
        }
        time = line.now;
    }
    let mut inputs = [0x80, 0x80, 0, 0, 0x20, 0, 0, 0, 0, 77, 0, 0, 0, 77];
    for cycle in 0..FRAMES / 2 / DEVICES {
        for (device, line) in lines.iter().enumerate() {
            let position = if device < turning { 77 + cycle as u32 % 10_000 } else { 77 };
            inputs[6..10].copy_from_slice(&position.to_be_bytes());
            inputs[10..14].copy_from_slice(&position.to_be_bytes());
            // The sign of life of the encoder, 1 to 15.
            inputs[2] = ((1 + cycle % 15) << 4) as u8;
            for by_device in [false, true] {
                let data = if by_device { &inputs[..] } else { &[] };
                let mut frame = handmade::cyclic(by_device, (cycle as u16).wrapping_mul(64), data);
                let at = if by_device { 6 } else { 0 };
                frame[at..at + 6].copy_from_slice(&line.device.0);
                writer.packet(interface, time, &frame, None).expect("a vector takes all");
                time += Duration::from_micros(100);
            }
        }
        time += Duration::from_micros(400);
    }
    writer.finish().expect("a vector takes all")
}

/// The best of [`ROUNDS`] rounds, in frames per second.
fn measure(name: &str, mut work: impl FnMut() -> u64) -> f64 {
    let mut best = f64::MAX;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        assert!(work() >= FRAMES as u64, "{name}: frames are missing");
        best = best.min(begin.elapsed().as_secs_f64());
    }
    let rate = FRAMES as f64 / best;
    println!("{name:<44} {:>6.2} million frames/s", rate / 1e6);
    rate
}

/// Counts the packets of the file with pcap-parser alone.
fn plain_iteration(file: &[u8]) -> u64 {
    let mut reader = PcapNGReader::new(256 * 1024, file).expect("a capture");
    let mut frames = 0;
    loop {
        match reader.next() {
            Ok((offset, block)) => {
                if let PcapBlockOwned::NG(pcap_parser::Block::EnhancedPacket(packet)) = block {
                    frames += u64::from(!black_box(packet.data).is_empty());
                }
                reader.consume(offset);
            }
            Err(PcapError::Eof) => return frames,
            Err(PcapError::Incomplete(_)) => reader.refill().expect("memory can be read"),
            Err(error) => panic!("{error:?}"),
        }
    }
}

/// Seconds that tshark takes to count the packets of a file; `None` without tshark.
fn tshark(file: &std::path::Path) -> Option<f64> {
    let begin = Instant::now();
    let mut command = Command::new("tshark");
    command.arg("-r").arg(file).args(["-q", "-z", "io,stat,0"]).stdout(Stdio::null()).stderr(Stdio::null());
    let status = command.status().ok()?;
    status.success().then(|| begin.elapsed().as_secs_f64())
}

fn main() {
    let file = recorded(DEVICES / 2);
    let plain = measure("pcap-parser", || plain_iteration(&file));
    measure("reading the capture", || {
        let mut reader = CaptureReader::new(&file[..]).expect("a capture");
        let mut frames = 0;
        while let Some(CaptureItem::Packet(packet)) = reader.next() {
            frames += u64::from(!black_box(packet.captured).is_empty());
        }
        frames
    });
    let mut frames = Vec::new();
    let mut reader = CaptureReader::new(&file[..]).expect("a capture");
    while let Some(CaptureItem::Packet(packet)) = reader.next() {
        frames.push((packet.time, packet.captured.to_vec()));
    }
    measure("tracker", || {
        let (mut tracker, mut cyclic) = (Tracker::new(), 0);
        for (number, (time, octets)) in (1..).zip(&frames) {
            tracker.frame(number, *time, octets, &mut |_, observation| {
                cyclic += u64::from(matches!(black_box(observation), Observation::Cyclic { .. }));
            });
        }
        cyclic
    });
    drop(frames);
    measure("replay without rules", || capture("bench", &file[..], &[]).expect("a capture").frames);
    let manuals = load(&suites::sources(), None).expect("the built-in suites load");
    let checked = capture("bench", &file[..], &manuals).expect("a capture");
    assert_eq!((checked.ars.len(), checked.findings.len()), (DEVICES, 0), "{:?}", checked.findings.first());
    let decided = checked.rules.iter().filter(|rule| rule.premises > 0).count();
    assert!(decided >= 10, "only {decided} rules were decided");
    let all = measure("replay, all rules, 4 of 8 encoders turn", || {
        capture("bench", &file[..], &manuals).expect("a capture").frames
    });
    println!("{:<44} {:>6.2}", "  relative to pcap-parser", all / plain);
    let path = std::env::temp_dir().join(format!("encspec-bench-{}.pcapng", std::process::id()));
    let seconds = std::fs::write(&path, &file).ok().and_then(|()| tshark(&path));
    let _ = std::fs::remove_file(&path);
    match seconds {
        Some(seconds) => {
            let rate = FRAMES as f64 / seconds;
            println!("{:<44} {:>6.2} million frames/s", "tshark -q -z io,stat,0", rate / 1e6);
            println!("{:<44} {:>6.2}", "  replay with all rules, relative to tshark", all / rate);
        }
        None => println!("tshark                                       skipped: not installed, or it failed"),
    }
    let still = recorded(0);
    measure("replay, all rules, no encoder turns", || {
        capture("bench", &still[..], &manuals).expect("a capture").frames
    });
    let moving = recorded(DEVICES);
    measure("replay, all rules, all encoders turn", || {
        capture("bench", &moving[..], &manuals).expect("a capture").frames
    });
}
