//! Captures: their connections, the events, and the rules of the manuals that were broken, each with its frame.
//!
//! A capture is read once, in bounded memory. Whatever is readable is read; damage and unreadable frames become entries of the
//! report. The rules are the same as in a run. This module must not know how trials are run.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod against;
mod annotate;
mod checks;
mod clock;
mod dcp;
mod decode;
mod events;
mod filter;
pub mod finding;
mod grouping;
mod layout_guess;
mod live;
mod missing_values;
mod page;
mod protocol;
mod read;
mod report;
mod rules;
mod text;
mod walk;

pub use against::{AgainstReport, DifferenceReport, LeftOutReport};
pub use annotate::{CannotAnnotate, annotate};
pub use clock::utc;
pub use filter::{CaptureTime, ReportFilter};
pub use finding::{CaptureBlame, CaptureFinding, ContextFrame, FindingContext, FindingSeverity};
pub use live::{LiveFinding, LiveReplay};
pub use page::{PageCapture, chapter, page};
pub use protocol::table::{CHECKS, ProtocolCheck};
pub use read::reassembly::{IpReassembler, LostDatagram, Reassembled};
pub use read::{CannotReplay, ProgressCallback, ReadProgress, each, files};
pub use report::{
    AbortReport, CaptureEvent, CaptureReport, ConnectionReport, ControllerReport, DamageReport, DeviceReport,
    EventKind, JudgedReport, NotJudged, RecordingReport, ReplayReport, RuleReport, StreamCoverage, StreamReport,
};
pub use rules::{RuleJudge, RuleOutcome, fits_manual, fits_modules, judge_rules};
pub use text::{TextOptions, text, text_with};

use checks::FrameChecks;
use events::Events;
use grouping::{folded, under_their_causes};
use judge::observe::{ArId, Observation, ObservedAr};
use layout_guess::StationIdentity;
use read::order::OrderedFrame;
use std::io::Read;
use suite::device::Bus;
use suite::model::Manual;
use virtual_wire::capture::NotACapture;
use walk::{CaptureVisitor, TrackedCapture, walk};

/// Reads and judges one capture, pcap or pcapng, packed or not; `name` is its name in the report.
///
/// # Errors
///
/// `input` cannot be read or is not a capture. Damage after its begin is part of the report.
pub fn capture(name: &str, input: impl Read, manuals: &[Manual]) -> Result<CaptureReport, NotACapture> {
    capture_with(name, input, manuals, &[], &mut |_, _| {}).map(|(report, _)| report)
}

/// Like [`capture`]; `identities` are of stations that the capture identifies too late, and such stations are returned. Calls
/// `progress` with the number of frames read after each frame, and at the end once more with `true`.
fn capture_with(
    name: &str,
    input: impl Read,
    manuals: &[Manual],
    identities: &[StationIdentity],
    progress: &mut dyn FnMut(u64, bool),
) -> Result<(CaptureReport, Vec<StationIdentity>), NotACapture> {
    let mut replay = Replay { events: Events::new(manuals), checks: FrameChecks::new(manuals) };
    let walked = walk(input, manuals, identities, &mut replay, progress)?;
    let late = walked.layouts.late(&walked.tracker);
    let mut report = replay.report(name, walked);
    report.identities = identities.to_vec();
    Ok((report, late))
}

struct Replay<'a> {
    events: Events<'a>,
    checks: FrameChecks<'a>,
}

impl CaptureVisitor for Replay<'_> {
    fn begin(&mut self, bus: Bus, next: &OrderedFrame<'_>) {
        self.events.begin(next.number, next.time, next.cut);
        self.checks.begin(bus, next);
    }

    #[inline]
    fn observe(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        self.events.observe(ars, observation);
        self.checks.observe(bus, ars, next, observation);
    }

    fn frame_done(&mut self, bus: Bus, ars: &[ObservedAr]) {
        self.checks.frame_done(bus, ars);
    }

    fn gap(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        self.checks.gap(bus, ars, next, observation);
    }

    fn lost(&mut self, ars: &[ObservedAr], datagram: &LostDatagram) {
        self.events.lost(datagram);
        self.checks.lost(ars, datagram);
    }

    fn hole(&mut self) {
        self.checks.hole();
    }

    fn other_link(&mut self, next: &OrderedFrame<'_>) {
        self.events.other_link(next.number, next.time, next.link.0);
        self.checks.other_link(next);
    }
}

impl Replay<'_> {
    fn report(self, name: &str, walked: TrackedCapture<'_>) -> CaptureReport {
        let TrackedCapture { tracker, slaves, layouts, damage, frames, .. } = walked;
        let Replay { events, checks: FrameChecks { rules, protocol, mut contexts } } = self;
        let (rules, broken) = rules.end();
        let events = events.end(&tracker, &slaves);
        let (mut findings, judged) = protocol.end(&tracker, &slaves);
        findings.extend(broken);
        findings.sort_by_key(|finding| finding.frame);
        if damage.is_untrusted() {
            findings.iter_mut().for_each(CaptureFinding::blame_capture);
        }
        let connections = tracker.ars().len();
        for finding in &mut findings {
            let ars = if finding.bus.is_profibus() { slaves.ars() } else { tracker.ars() };
            contexts.complete(finding, ars);
            layouts.mark(finding);
            // The slaves follow the connections of PROFINET.
            let before = if finding.bus.is_profibus() { connections } else { 0 };
            finding.ar = finding.ar.map(|ar| ar + before);
        }
        let ars = tracker.ars().iter().chain(slaves.ars());
        let mut ars: Vec<ConnectionReport> = ars.map(ConnectionReport::from).collect();
        for (index, ar) in ars.iter_mut().enumerate().take(connections) {
            if let Some(guess) = layouts.guess(ArId(index as u32)) {
                ar.layout = Some(format!("guessed: {}", guess.what));
            }
        }
        let findings = folded(under_their_causes(findings, &ars), &ars);
        CaptureReport {
            file: name.to_owned(),
            frames,
            damage: damage.end(frames),
            recordings: contexts.times.clock.recordings().iter().map(RecordingReport::from).collect(),
            coverage: JudgedReport::new(ars.len(), frames, &judged),
            judged,
            hidden_findings: 0,
            identities: Vec::new(),
            ars,
            events,
            findings,
            rules,
            against: None,
        }
    }
}
