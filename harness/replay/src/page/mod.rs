//! The HTML page of a replay: each capture as a chapter with its findings, each connection as a timeline.
//!
//! A page needs data that the report does not keep. Therefore the capture is read a second time, for the packets of the findings
//! and the data of the connections. This module must not judge anything: the findings are those of the report.

mod packets;
mod timeline;

use super::finding::{CaptureFinding, ContextFrame};
use super::layout_guess::StationIdentity;
use super::read::order::OrderedFrame;
use super::report::{CaptureReport, ConnectionReport, DamageReport};
use super::text::not_judged;
use super::walk::{CaptureVisitor, walk};
use judge::observe::{Observation, ObservedAr};
use packets::{PacketData, Packets};
use report::page::{
    Chapter, HtmlPage, Lane, LanePhase, LaneShape, Mark, PageEntry, PagePacket, PageTable, Timeline, Tone,
};
use results::outcome::FindingSeverity;
use std::io::Read;
use suite::device::{Bus, PerBus};
use suite::model::Manual;
use timeline::Timelines;
use virtual_wire::capture::NotACapture;

/// Upper limit of the findings of one capture that are shown with their packet.
const MOST_FINDINGS: usize = 300;
/// Upper limit of the consequences of one finding that are marked in the timeline.
const MOST_CONSEQUENCES: usize = 8;

/// The page of several captures, with one chapter for each.
pub fn page(title: &str, chapters: Vec<Chapter>) -> HtmlPage {
    let all = || chapters.iter().flat_map(|chapter| &chapter.entries);
    let (bad, open) =
        (all().filter(|entry| entry.tone == Tone::Bad).count(), all().filter(|entry| entry.tone == Tone::Open).count());
    let verdict = match (bad, open) {
        (0, 0) => (Tone::Good, "No errors and no warnings.".to_owned()),
        (0, open) => (Tone::Open, format!("No errors. Warnings: {open}.")),
        (bad, _) => (Tone::Bad, format!("Errors: {bad}.")),
    };
    HtmlPage { title: title.to_owned(), verdict, chapters, ..HtmlPage::default() }
}

/// The chapter of one capture; `again` reads the same capture from its begin, `number` makes its anchors unique on the page.
///
/// # Errors
///
/// The capture cannot be read a second time.
pub fn chapter(
    number: usize,
    report: &CaptureReport,
    again: impl Read,
    manuals: &[Manual],
) -> Result<Chapter, NotACapture> {
    let shown = || report.findings.iter().take(MOST_FINDINGS);
    let frames = |finding: &CaptureFinding| {
        let consequences = finding.consequences.iter().take(MOST_CONSEQUENCES);
        [finding.frame].into_iter().chain(consequences.map(|of| of.frame)).collect::<Vec<u64>>()
    };
    let wanted = shown().flat_map(frames);
    let look = PageCapture::identified(again, wanted, manuals, &report.identities)?;
    let anchor = |index: usize| format!("finding-{number}-{}", index + 1);
    let shown = shown().enumerate();
    let entries: Vec<PageEntry> =
        shown.clone().map(|(index, finding)| entry(anchor(index), finding, &look, manuals)).collect();
    let marks: Vec<(Option<usize>, Mark)> = shown
        .flat_map(|(index, finding)| {
            let own = (finding, format!("{}: {}", finding.id, finding.text));
            let consequences = finding.consequences.iter().take(MOST_CONSEQUENCES);
            let followed = consequences.map(|of| (of, format!("{}: {} (follows from {})", of.id, of.text, finding.id)));
            [own].into_iter().chain(followed).map(move |(of, text)| (index, of, text)).collect::<Vec<_>>()
        })
        .filter_map(|(index, finding, text)| {
            let at = look.seconds(finding.frame)?;
            Some((finding.ar, Mark { at, is_finding: true, text, anchor: Some(anchor(index)) }))
        })
        .collect();
    let timelines = look.timelines.into_iter().map(|(index, mut timeline)| {
        timeline.heading = report.ars.get(index).map_or_else(String::new, |ar| who(index, ar));
        let own = marks.iter().filter(|(ar, _)| ar.is_none_or(|ar| ar == index)).map(|(_, mark)| mark);
        let own = own.filter(|mark| (timeline.from..=timeline.to).contains(&mark.at)).cloned();
        timeline.marks.extend(own);
        timeline
    });
    let mut timelines: Vec<Timeline> = timelines.collect();
    timelines.splice(0..0, overview(&timelines, marks.iter().map(|(_, mark)| mark)));
    Ok(Chapter { heading: report.file.clone(), facts: facts(report), timelines, entries, tables: tables(report) })
}

/// All connections of a capture on one time axis, with the findings; `None` if there are not several.
fn overview<'m>(timelines: &[Timeline], marks: impl Iterator<Item = &'m Mark>) -> Option<Timeline> {
    if timelines.len() < 2 {
        return None;
    }
    let from = timelines.iter().map(|of| of.from).fold(f64::INFINITY, f64::min);
    let to = timelines.iter().map(|of| of.to).fold(f64::NEG_INFINITY, f64::max);
    let phases = |of: &Timeline| {
        let known = of.lanes.iter().find_map(|lane| match &lane.shape {
            LaneShape::Phases(phases) => Some(phases.clone()),
            LaneShape::Line(_) | LaneShape::Bit(_) => None,
        });
        known.unwrap_or_else(|| vec![LanePhase { from: of.from, to: of.to, word: "data exchange".to_owned() }])
    };
    let lanes = timelines.iter().map(|of| Lane { name: of.heading.clone(), shape: LaneShape::Phases(phases(of)) });
    Some(Timeline {
        heading: "All connections".to_owned(),
        from,
        to,
        lanes: lanes.collect(),
        marks: marks.filter(|mark| (from..=to).contains(&mark.at)).cloned().collect(),
        steady: String::new(),
    })
}

/// The packets and timelines of a capture that a page shows.
#[derive(Debug)]
pub struct PageCapture {
    packets: Packets,
    /// The data of its connections over time, each with the index of the connection.
    pub timelines: Vec<(usize, Timeline)>,
}

impl PageCapture {
    /// Reads the capture `again` and keeps the packets with these numbers; signal names come from `manuals`.
    ///
    /// # Errors
    ///
    /// The capture cannot be read.
    pub fn at(
        again: impl Read,
        wanted: impl Iterator<Item = u64>,
        manuals: &[Manual],
    ) -> Result<PageCapture, NotACapture> {
        PageCapture::identified(again, wanted, manuals, &[])
    }

    /// Like [`at`](Self::at), with the identities of stations that the capture identifies too late.
    fn identified(
        again: impl Read,
        wanted: impl Iterator<Item = u64>,
        manuals: &[Manual],
        identities: &[StationIdentity],
    ) -> Result<PageCapture, NotACapture> {
        let mut keeper = PageCollector {
            packets: Packets::new(wanted),
            is_kept: false,
            timelines: PerBus::new(|_| Timelines::new(manuals)),
        };
        let walked = walk(again, manuals, identities, &mut keeper, &mut |_, _| {})?;
        let PageCollector { mut packets, timelines: PerBus { profinet, profibus }, .. } = keeper;
        let (connections, slaves) = (walked.tracker.ars(), walked.slaves.ars());
        packets.connections(connections, slaves);
        // The slaves follow the connections of PROFINET.
        let of_slaves = profibus.end().into_iter().map(|(index, timeline)| (index + connections.len(), timeline));
        Ok(PageCapture { packets, timelines: profinet.end().into_iter().chain(of_slaves).collect() })
    }

    /// A kept packet in its parts, with the byte and the bit to mark.
    pub fn packet(&self, frame: u64, mark: Option<(usize, Option<u8>)>, manuals: &[Manual]) -> Option<PagePacket> {
        self.packets.packet(frame, mark, manuals)
    }

    /// The time of a kept packet, in seconds since the first one.
    pub fn seconds(&self, frame: u64) -> Option<f64> {
        self.packets.seconds(frame)
    }
}

/// Keeps what the page shows while the capture is read.
struct PageCollector<'a> {
    packets: Packets,
    /// Whether the current packet is kept.
    is_kept: bool,
    timelines: PerBus<Timelines<'a>>,
}

impl<'a> PageCollector<'a> {
    fn timelines(&mut self, bus: Bus) -> &mut Timelines<'a> {
        self.timelines.of_mut(bus)
    }

    fn keep(&mut self, next: &OrderedFrame<'_>) {
        self.timelines.profinet.begin(next.time);
        self.timelines.profibus.begin(next.time);
        self.is_kept = self.packets.keep(next.number, next.time, next.link, next.octets);
    }
}

impl CaptureVisitor for PageCollector<'_> {
    fn begin(&mut self, _: Bus, next: &OrderedFrame<'_>) {
        self.keep(next);
    }

    fn observe(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        if let Observation::Cyclic { ar, direction, at, .. } = observation
            && self.is_kept
        {
            self.packets.carries(next.number, PacketData { bus, ar: *ar, direction: *direction, at: *at });
        }
        self.timelines(bus).observe(ars, next.time, observation);
    }

    fn frame_done(&mut self, _: Bus, _: &[ObservedAr]) {}

    fn gap(&mut self, _: Bus, _: &[ObservedAr], _: &OrderedFrame<'_>, _: &Observation<'_>) {}

    fn hole(&mut self) {}

    fn other_link(&mut self, next: &OrderedFrame<'_>) {
        self.keep(next);
    }
}

/// A big-endian number; of more than eight bytes the last ones count.
fn unsigned(octets: &[u8]) -> u64 {
    octets.iter().fold(0, |sum, octet| sum << 8 | u64::from(*octet))
}

fn entry(anchor: String, finding: &CaptureFinding, look: &PageCapture, manuals: &[Manual]) -> PageEntry {
    let (tone, word) = match finding.severity {
        FindingSeverity::Error => (Tone::Bad, "error"),
        FindingSeverity::Warning => (Tone::Open, "warning"),
        FindingSeverity::Info => (Tone::Plain, "info"),
    };
    let mut facts = Vec::new();
    let mut fact = |name: &str, value: Option<String>| {
        facts.extend(value.filter(|value| !value.is_empty()).map(|value| (name.to_owned(), value)));
    };
    fact("requirement", Some(finding.requirements.join(", ")));
    fact("clause", finding.clause.clone());
    fact("packet", Some(finding.frame.to_string()));
    fact("time", finding.time.map(|time| when(time, finding.wall_clock.as_deref())));
    fact(
        "how often",
        (finding.count > 1).then(|| format!("{} times, last in packet {}", finding.count, finding.last_frame)),
    );
    fact("one by one", Some(finding.details.join("\n")));
    fact("followed by", Some(finding.consequences.iter().map(consequence).collect::<Vec<_>>().join("\n")));
    fact("expected", finding.expected.clone());
    fact("observed", finding.seen.clone());
    fact("blame", Some(finding.blame.word().to_owned()));
    fact("likely cause", finding.cause.clone());
    fact("next step", finding.next.clone());
    fact("display filter", finding.filter.clone());
    let context = &finding.context;
    let around = context.before.iter().chain(&context.at).chain(&context.after);
    let line = |frame: &ContextFrame| {
        let here = if frame.frame == finding.frame { '>' } else { ' ' };
        format!("{here}{:>7} {} {}", frame.frame, when(frame.time, frame.wall_clock.as_deref()), frame.text)
    };
    fact("frames around it", Some(around.map(line).collect::<Vec<_>>().join("\n")));
    let mark = finding.octet.map(|octet| (octet, finding.bit));
    let packet = look.packet(finding.frame, mark, manuals);
    let head = format!("{} in packet {}: {}", finding.id, finding.frame, finding.text);
    PageEntry { anchor, tone, word: word.to_owned(), head, facts, packet, timelines: Vec::new() }
}

fn consequence(of: &CaptureFinding) -> String {
    format!("{} in packet {}: {}", of.id, of.frame, of.text)
}

/// Seconds, and the time in the calendar if there is one.
fn when(seconds: f64, wall_clock: Option<&str>) -> String {
    match wall_clock {
        Some(time) => format!("{seconds:>12.6} s, {time}"),
        None => format!("{seconds:>12.6} s"),
    }
}

fn facts(report: &CaptureReport) -> Vec<(String, String)> {
    let mut facts = vec![("frames".to_owned(), report.frames.to_string())];
    facts.push(("connections".to_owned(), report.ars.len().to_string()));
    if report.findings.len() > MOST_FINDINGS {
        let text = format!("{}; the first {MOST_FINDINGS} are shown", report.findings.len());
        facts.push(("findings".to_owned(), text));
    }
    facts.extend(not_judged(report).into_iter().map(|line| ("not judged".to_owned(), line)));
    facts
}

fn who(index: usize, ar: &ConnectionReport) -> String {
    let controller = name(&ar.controller.station, &ar.controller.mac, ar.controller.address);
    let device = name(&ar.device.station, &ar.device.mac, ar.device.address);
    format!("Connection {}: {controller} with {device}, {}", index + 1, ar.stage)
}

fn name(station: &Option<String>, mac: &Option<String>, address: Option<u8>) -> String {
    match (station, mac, address) {
        (Some(station), _, _) => format!("'{station}'"),
        (None, Some(mac), _) => mac.clone(),
        (None, None, Some(address)) => format!("station {address}"),
        (None, None, None) => "unknown station".to_owned(),
    }
}

fn tables(report: &CaptureReport) -> Vec<PageTable> {
    let columns = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let rules = report.rules.iter().map(|rule| {
        let tone = match rule.verdict {
            "pass" => Tone::Good,
            "fail" => Tone::Bad,
            _ => Tone::Open,
        };
        let cells = vec![
            rule.verdict.to_owned(),
            rule.id.clone(),
            rule.premises.to_string(),
            rule.undecided.to_string(),
            rule.reason.clone().unwrap_or_default(),
        ];
        (tone, cells)
    });
    let events = report.events.iter().map(|event| {
        let cells = vec![
            event.frame.to_string(),
            format!("{:.6}", event.time),
            event.wall_clock.clone().unwrap_or_default(),
            event.kind.word().to_owned(),
            event.text.clone(),
        ];
        (Tone::Plain, cells)
    });
    let damage =
        report.damage.iter().map(|DamageReport { at, what, .. }| (Tone::Open, vec![at.to_string(), what.clone()]));
    vec![
        PageTable {
            heading: "Rules".to_owned(),
            columns: columns(&["verdict", "rule", "decided", "undecided", "reason"]),
            rows: rules.collect(),
        },
        PageTable {
            heading: "Events".to_owned(),
            columns: columns(&["packet", "seconds", "time in UTC", "kind", "event"]),
            rows: events.collect(),
        },
        PageTable {
            heading: "Damage".to_owned(),
            columns: columns(&["byte of the file", "damage"]),
            rows: damage.collect(),
        },
    ]
}
