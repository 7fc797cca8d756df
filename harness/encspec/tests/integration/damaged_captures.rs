//! Damage to a capture is never blamed on a device: recordings of conforming devices, damaged in 1000 ways.
//!
//! The seed is fixed, so the damage is the same in every run. The undamaged recordings have no findings against a device, so every
//! such finding would be wrong.

use crate::built_in::manuals;
use crate::recordings::{self, TrialRecording, against_devices, file, some};
use encspec::replay::{CaptureBlame, capture};
use encspec::suite::model::Manual;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

const MUTATIONS: usize = 1_000;
/// Number of recordings of each manual.
const EACH: usize = 5;

/// Pseudo-random numbers (xorshift64, Marsaglia 2003).
struct Xorshift(u64);

impl Xorshift {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit.max(1) as u64) as usize
    }
}

/// Damages a recording in one of nine ways. Returns a description and the file.
fn damage(recording: &TrialRecording, chance: &mut Xorshift) -> (String, Vec<u8>) {
    let count = recording.frames.len();
    let at = chance.below(count - 1);
    let frames = |what: String, change: &dyn Fn(&mut Vec<_>)| (what, recording.changed(|frames| change(frames)).file());
    match chance.below(9) {
        0 => {
            let mut octets = recording.file();
            let octet = chance.below(octets.len());
            octets.truncate(octet);
            (format!("cut off at byte {octet}"), octets)
        }
        1 => {
            let mut octets = recording.file();
            let from = chance.below(octets.len());
            let to = (from + 1 + chance.below(2_000)).min(octets.len());
            octets.drain(from..to);
            (format!("without bytes {from} to {to}"), octets)
        }
        2 => {
            let mut octets = recording.file();
            let (octet, bit) = (chance.below(octets.len()), chance.below(8));
            octets[octet] ^= 1 << bit;
            (format!("bit {bit} of byte {octet} flipped"), octets)
        }
        3 => {
            let octet = chance.below(recording.frames[at].1.len());
            let bit = chance.below(8);
            let what = format!("frame {}: bit {bit} of byte {octet} flipped", at + 1);
            frames(what, &|frames| frames[at].1[octet] ^= 1 << bit)
        }
        4 => frames(format!("without frame {}", at + 1), &|frames| drop(frames.remove(at))),
        5 => {
            let to = (at + 2 + chance.below(20)).min(count);
            frames(format!("without frames {} to {to}", at + 1), &|frames| drop(frames.drain(at..to)))
        }
        6 => frames(format!("frames {} and {} swapped with their times", at + 1, at + 2), &|frames| {
            frames.swap(at, at + 1);
        }),
        7 => frames(format!("frames {} and {} swapped", at + 1, at + 2), &|frames| {
            let (one, other) = frames.split_at_mut(at + 1);
            std::mem::swap(&mut one[at].1, &mut other[0].1);
        }),
        _ => {
            let kept = chance.below(recording.frames[at].1.len());
            frames(format!("frame {} cut to {kept} bytes", at + 1), &|frames| frames[at].1.truncate(kept))
        }
    }
}

#[test]
fn damage_to_a_capture_is_not_blamed_on_a_device() {
    let manuals = manuals();
    let recordings: Vec<TrialRecording> = manuals.iter().flat_map(|manual| some(manual, EACH)).collect();
    assert!(recordings.len() >= 4 * EACH, "only {} recordings", recordings.len());
    for recording in &recordings {
        let report = recording.replayed(manuals);
        assert!(against_devices(&report).is_empty(), "{} undamaged: {:#?}", recording.name, against_devices(&report));
    }
    let wrong = Mutex::new(Vec::new());
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= MUTATIONS {
                        return;
                    }
                    let blamed = one(&recordings[number % recordings.len()], number, manuals);
                    wrong.lock().expect("no thread panics").extend(blamed);
                }
            });
        }
    });
    let wrong = wrong.into_inner().expect("no thread panics");
    assert!(wrong.is_empty(), "{} of {MUTATIONS}:\n{}", wrong.len(), wrong.join("\n"));
}

/// Applies one mutation. Returns the findings against a device, if any.
fn one(recording: &TrialRecording, number: usize, manuals: &[Manual]) -> Option<String> {
    let mut chance = Xorshift(0x9E37_79B9_7F4A_7C15 ^ (number as u64 + 1).wrapping_mul(0xBF58_476D_1CE4_E5B9));
    let (what, octets) = damage(recording, &mut chance);
    let Ok(report) = capture(&recording.name, &octets[..], manuals) else { return None };
    let blamed: Vec<String> = against_devices(&report)
        .iter()
        .map(|finding| format!("    {} in frame {}: {}", finding.id, finding.frame, finding.text))
        .collect();
    let mutation = format!("mutation {number} of {}: {what}", recording.name);
    (!blamed.is_empty()).then(|| format!("{mutation}\n{}", blamed.join("\n")))
}

/// The opposite: bugs are still found. A replay without any findings would pass the test above.
#[test]
fn a_bug_is_still_blamed_on_the_device() {
    let manuals = manuals();
    let manual = manuals.iter().find(|manual| manual.device.name == "lika-xac77-profinet").expect("the manual");
    let variant = &manual.variants[0];
    let (mut proven, mut shown) = (0, 0);
    for rule in variant.rules.iter().filter(|rule| !rule.catches.is_empty()) {
        let bug = rule.catches[0].as_str();
        let Some(trial) = variant.trials.iter().find(|trial| trial.catches.iter().any(|caught| caught == bug)) else {
            continue;
        };
        let report = recordings::record(manual, trial, &[bug]).replayed(manuals);
        let of_rule = report.rules.iter().find(|of| of.id.ends_with(&format!("/{}", rule.id)));
        match of_rule.map(|of| of.verdict) {
            Some("fail") => {
                proven += 1;
                shown += 1;
            }
            Some("inconclusive") => shown += 1,
            _ => {}
        }
    }
    println!("{shown} rules show their bug, {proven} are proven broken");
    assert!(proven >= 5 && proven * 2 > shown, "only {proven} of {shown}");
    // A file without frames blames neither side.
    let empty =
        capture("empty", &file(virtual_wire::capture::LinkType::ETHERNET, [].iter())[..], manuals).expect("a capture");
    let blamed: Vec<_> = empty.findings.iter().map(|finding| (finding.id.as_str(), finding.blame)).collect();
    assert_eq!(blamed, [("PN-CAPTURE-NOTHING", CaptureBlame::Capture)]);
}
