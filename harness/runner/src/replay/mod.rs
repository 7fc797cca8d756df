//! Captures: which connections there are, what happened, and which rules of the manuals were broken where.
//!
//! A capture is read once, in flat memory, and what can be read is read: damage and what is unreadable become entries of the
//! report. The rules are the same as in a run. This room must not know how trials are run.

pub mod against;
mod dcp;
mod decode;
mod events;
pub mod finding;
mod layout;
mod page;
mod protocol;
mod read;
mod report;
mod rules;
mod text;
mod unseen;

pub use finding::{Blame, Context, ContextFrame, Finding, Severity};
pub use page::{Look, chapter, page};
pub use protocol::table::{CHECKS, Check};
pub use read::{CannotReplay, Progress, Told, each, files};
pub use report::{
    Abort, CaptureReport, ConnectionReport, ControllerReport, DamageReport, DeviceReport, Event, EventKind,
    ReplayReport, RuleReport, StreamReport,
};
pub use rules::{RuleJudge, RuleOutcome, judge_rules, speaks_to};
pub use text::text;

use crate::observe::{Ar, ArId, DpTracker, Observation, Tracker};
use crate::suite::device::Bus;
use crate::suite::model::Manual;
use bench::CaptureReader;
use bench::capture::{Item, LinkType, NotACapture};
use events::Events;
use finding::Surroundings;
use layout::Layouts;
use protocol::Protocol;
use read::damage::DamageList;
use read::order::{Line, Next};
use rules::{CaptureRules, News};
use std::io::Read;

/// Reads one capture, pcap or pcapng, packed or not, and judges it; `name` is how the report calls it.
///
/// An error says that `input` cannot be read or is no capture; whatever is wrong further on is damage in the report.
pub fn capture(name: &str, input: impl Read, manuals: &[Manual]) -> Result<CaptureReport, NotACapture> {
    capture_with(name, input, manuals, &mut |_, _| {})
}

/// The same; `told` hears after each frame how many were read, and at the end once more.
fn capture_with(
    name: &str,
    input: impl Read,
    manuals: &[Manual],
    told: &mut dyn FnMut(u64, bool),
) -> Result<CaptureReport, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut replay = Replay {
        tracker: Tracker::recorded(),
        slaves: DpTracker::recorded(),
        events: Events::new(manuals),
        rules: CaptureRules::new(manuals),
        protocol: Protocol::default(),
        layouts: Layouts::new(manuals),
        around: Surroundings::default(),
        damage: DamageList::default(),
        frames: 0,
    };
    let mut line = Line::default();
    while let Some(item) = reader.next() {
        match item {
            Item::Packet(packet) => {
                replay.frames += 1;
                told(replay.frames, false);
                let behind_damage = replay.damage.is_open();
                replay.damage.close(packet.number as u64);
                if let Some(next) = line.push(&packet, behind_damage) {
                    replay.next(&next);
                }
            }
            Item::Damage(damage) => replay.damage.add(damage, replay.frames),
        }
    }
    if let Some(next) = line.end() {
        replay.next(&next);
    }
    if replay.damage.is_open() {
        replay.protocol.hole();
    }
    told(replay.frames, true);
    Ok(replay.report(name))
}

struct Replay<'a> {
    tracker: Tracker,
    /// The same for the frames of PROFIBUS.
    slaves: DpTracker,
    events: Events<'a>,
    rules: CaptureRules<'a>,
    protocol: Protocol,
    /// What is guessed of connections without a Connect.
    layouts: Layouts<'a>,
    /// What is kept of the frames around the findings.
    around: Surroundings,
    damage: DamageList,
    frames: u64,
}

impl Replay<'_> {
    fn next(&mut self, next: &Next<'_>) {
        if next.interrupted {
            self.interrupted(next);
        }
        match next.link {
            LinkType::ETHERNET => self.frame(next),
            LinkType::PROFIBUS => self.bus_frame(next),
            LinkType(other) => self.events.other_link(next.number, next.time, other),
        }
    }

    /// What was remembered is not simply continued.
    fn interrupted(&mut self, next: &Next<'_>) {
        let Replay { tracker, slaves, events, rules, protocol, .. } = self;
        let at = (next.time, next.number);
        protocol.hole();
        events.begin(next.number, next.time, next.cut);
        tracker.gap(next.time, &mut |ars, observation| {
            events.observe(ars, &observation);
            rules.observe(Bus::Profinet, ars, at, &observation);
        });
        slaves.gap(next.time, &mut |ars, observation| rules.observe(Bus::Profibus, ars, at, &observation));
    }

    fn frame(&mut self, next: &Next<'_>) {
        let Replay { tracker, events, rules, protocol, layouts, around, .. } = self;
        let at = (next.time, next.number);
        around.keep(Bus::Profinet, next.number, next.time, next.octets);
        events.begin(next.number, next.time, next.cut);
        protocol.begin(Bus::Profinet, next.number, next.time, next.octets);
        tracker.frame(next.number, next.time, next.octets, &mut |ars, observation| {
            layouts.observe(&observation);
            events.observe(ars, &observation);
            protocol.observe(Bus::Profinet, ars, &observation);
            rules.observe(Bus::Profinet, ars, at, &observation);
        });
        if let Some((met, guess)) = layouts.guessed(tracker) {
            let mut tell = |ars: &[Ar], observation: Observation<'_>| {
                events.observe(ars, &observation);
                protocol.observe(Bus::Profinet, ars, &observation);
                rules.observe(Bus::Profinet, ars, at, &observation);
            };
            if let Some(ar) = tracker.adopt(met, &mut tell) {
                layouts.took(ar, guess);
            }
        }
        self.look_around(Bus::Profinet);
    }

    fn bus_frame(&mut self, next: &Next<'_>) {
        let Replay { slaves, events, rules, protocol, around, .. } = self;
        let at = (next.time, next.number);
        around.keep(Bus::Profibus, next.number, next.time, next.octets);
        events.begin(next.number, next.time, next.cut);
        protocol.begin(Bus::Profibus, next.number, next.time, next.octets);
        slaves.frame(next.number, next.time, next.octets, &mut |ars, observation| {
            events.observe(ars, &observation);
            protocol.observe(Bus::Profibus, ars, &observation);
            rules.observe(Bus::Profibus, ars, at, &observation);
        });
        self.look_around(Bus::Profibus);
    }

    /// Keeps what lies around the frames in which something was just found.
    fn look_around(&mut self, bus: Bus) {
        let Replay { tracker, slaves, protocol, rules, around, .. } = self;
        let ars = match bus {
            Bus::Profinet => tracker.ars(),
            Bus::Profibus => slaves.ars(),
        };
        if around.is_waiting() {
            around.fill(ars);
        }
        for News { frame, trigger, ar } in rules.news(bus) {
            around.want(frame, trigger, ar, ars);
        }
        for frame in protocol.news() {
            around.want(frame, None, None, ars);
        }
    }

    fn report(mut self, name: &str) -> CaptureReport {
        let (rules, broken) = self.rules.end();
        let events = self.events.end(&self.tracker, &self.slaves);
        let mut findings = self.protocol.end(&self.tracker, &self.slaves);
        for finding in &findings {
            let ars = if finding.bus == Bus::Profibus { self.slaves.ars() } else { self.tracker.ars() };
            self.around.want(finding.frame, None, None, ars);
        }
        findings.extend(broken);
        findings.sort_by_key(|finding| finding.frame);
        if self.damage.is_untrusted() {
            findings.iter_mut().for_each(Finding::doubt);
        }
        let connections = self.tracker.ars().len();
        for finding in &mut findings {
            if let Some((context, ar)) = self.around.of(finding.frame) {
                finding.context = context.clone();
                finding.ar = finding.ar.or(ar.map(|ar| ar.0 as usize));
            }
            self.layouts.mark(finding);
            // The slaves come behind the connections of PROFINET.
            let before = if finding.bus == Bus::Profibus { connections } else { 0 };
            finding.ar = finding.ar.map(|ar| ar + before);
        }
        let ars = self.tracker.ars().iter().chain(self.slaves.ars());
        let mut ars: Vec<ConnectionReport> = ars.map(ConnectionReport::from).collect();
        for (index, ar) in ars.iter_mut().enumerate().take(connections) {
            if let Some(guess) = self.layouts.guess(ArId(index as u32)) {
                ar.layout = Some(format!("guessed: {}", guess.what));
            }
        }
        let damage = self.damage.end(self.frames);
        CaptureReport {
            file: name.to_owned(),
            frames: self.frames,
            damage,
            ars,
            events,
            findings,
            rules,
            against: None,
        }
    }
}
