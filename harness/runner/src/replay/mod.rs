//! Captures: which connections there are, what happened, and which rules of the manuals were broken where.
//!
//! A capture is read once, in flat memory, and what can be read is read: damage and what is unreadable become entries of the
//! report. The rules are the same as in a run. This room must not know how trials are run.

mod dcp;
mod decode;
mod events;
mod report;
mod rules;
mod text;

pub use report::{
    Abort, CaptureReport, ConnectionReport, ControllerReport, DamageReport, DeviceReport, Event, EventKind, Finding,
    ReplayReport, RuleReport, Severity, StreamReport,
};
pub use rules::{RuleJudge, RuleOutcome, judge_rules, speaks_to};
pub use text::text;

use crate::observe::{DpTracker, Tracker};
use crate::suite::device::Bus;
use crate::suite::model::Manual;
use bench::CaptureReader;
use bench::capture::{Item, LinkType, NotACapture};
use events::Events;
use rules::CaptureRules;
use station::Time;
use std::fs::File;
use std::io::{self, Read};

/// Places of damage that are listed one by one; the rest is counted.
const MOST_DAMAGE: usize = 1_000;

/// Why a file cannot be replayed at all.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {why}")]
pub struct CannotReplay {
    /// The file as it was named.
    pub file: String,
    /// Why.
    pub why: NotACapture,
}

/// Reads the capture files, `-` being standard input, and judges them by the rules of `manuals`.
pub fn files(files: &[String], manuals: &[Manual]) -> Result<ReplayReport, CannotReplay> {
    let captures = files.iter().map(|name| file(name, manuals)).collect::<Result<_, _>>()?;
    Ok(ReplayReport { captures })
}

fn file(name: &str, manuals: &[Manual]) -> Result<CaptureReport, CannotReplay> {
    let report = match name {
        "-" => capture(name, io::stdin().lock(), manuals),
        _ => File::open(name).map_err(NotACapture::from).and_then(|file| capture(name, file, manuals)),
    };
    report.map_err(|why| CannotReplay { file: name.to_owned(), why })
}

/// Reads one capture, pcap or pcapng, and judges it; `name` is how the report calls it.
///
/// An error says that `input` cannot be read or is no capture; whatever is wrong further on is damage in the report.
pub fn capture(name: &str, input: impl Read, manuals: &[Manual]) -> Result<CaptureReport, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut replay = Replay {
        tracker: Tracker::new(),
        slaves: DpTracker::new(),
        events: Events::new(manuals),
        rules: CaptureRules::new(manuals),
        damage: Vec::new(),
        more_damage: 0,
        frames: 0,
    };
    while let Some(item) = reader.next() {
        match item {
            Item::Packet(packet) => {
                replay.frames += 1;
                match packet.link_type {
                    LinkType::ETHERNET => {
                        let cut = packet.is_sliced().then_some((packet.captured.len(), packet.original_length));
                        replay.frame(packet.number as u64, packet.time, packet.captured, cut);
                    }
                    LinkType::PROFIBUS => {
                        let cut = packet.is_sliced().then_some((packet.captured.len(), packet.original_length));
                        replay.bus_frame(packet.number as u64, packet.time, packet.captured, cut);
                    }
                    LinkType(other) => replay.events.other_link(packet.number as u64, packet.time, other),
                }
            }
            Item::Damage(damage) if replay.damage.len() < MOST_DAMAGE => {
                replay.damage.push(DamageReport { at: damage.at, what: damage.what });
            }
            Item::Damage(_) => replay.more_damage += 1,
        }
    }
    Ok(replay.report(name))
}

struct Replay<'a> {
    tracker: Tracker,
    /// The same for the frames of PROFIBUS.
    slaves: DpTracker,
    events: Events<'a>,
    rules: CaptureRules<'a>,
    damage: Vec<DamageReport>,
    more_damage: u64,
    frames: u64,
}

impl Replay<'_> {
    fn frame(&mut self, number: u64, time: Time, octets: &[u8], cut: Option<(usize, u32)>) {
        let Replay { tracker, events, rules, .. } = self;
        events.begin(number, time, cut);
        rules.time(time, number);
        tracker.frame(number, time, octets, &mut |ars, observation| {
            events.observe(ars, &observation);
            rules.observe(Bus::Profinet, ars, (time, number), &observation);
        });
    }

    fn bus_frame(&mut self, number: u64, time: Time, octets: &[u8], cut: Option<(usize, u32)>) {
        let Replay { slaves, events, rules, .. } = self;
        events.begin(number, time, cut);
        rules.time(time, number);
        slaves.frame(number, time, octets, &mut |ars, observation| {
            events.observe(ars, &observation);
            rules.observe(Bus::Profibus, ars, (time, number), &observation);
        });
    }

    fn report(mut self, name: &str) -> CaptureReport {
        if self.more_damage > 0 {
            let at = self.damage.last().map_or(0, |last| last.at);
            self.damage
                .push(DamageReport { at, what: format!("{} more places of damage behind this", self.more_damage) });
        }
        let (rules, broken) = self.rules.end();
        let (events, mut findings) = self.events.end(&self.tracker, &self.slaves);
        findings.extend(broken);
        findings.sort_by_key(|finding| finding.frame);
        let ars = self.tracker.ars().iter().chain(self.slaves.ars());
        CaptureReport {
            file: name.to_owned(),
            frames: self.frames,
            damage: self.damage,
            ars: ars.map(ConnectionReport::from).collect(),
            events,
            findings,
            rules,
        }
    }
}
