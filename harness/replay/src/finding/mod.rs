//! A finding: what is wrong in a capture, where, against which clause, expected and observed values, the frames around it, the
//! likely cause and the next step.
//!
//! Rules of the manuals, protocol checks and comparisons with another device all produce a [`CaptureFinding`]; reports and pages read
//! nothing else. This module must not know how a finding was made.

mod context;
mod rule;
mod times;

pub(super) use context::ContextCollector;
pub use context::{ContextFrame, FindingContext};
pub(super) use rule::rule_finding;

use judge::observe::ArId;
pub use results::outcome::FindingSeverity;
use serde::Serialize;
use suite::device::Bus;

/// Something that is wrong or worth knowing in a capture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaptureFinding {
    /// The ids of the requirements; without a requirement the id of the rule or protocol check.
    pub id: String,
    /// The ids of the requirements one by one; empty if it is about none.
    pub requirements: Vec<String>,
    /// The clauses of the manual that the requirements cite.
    pub clause: Option<String>,
    /// The ids of the requirements in one text, if there are any.
    pub requirement: Option<String>,
    pub severity: FindingSeverity,
    /// The number of the packet in the capture, from 1; 0 for a capture without frames.
    pub frame: u64,
    /// Seconds since the first frame of the same recording.
    pub time: Option<f64>,
    /// The time of the packet in the calendar, RFC 3339 in UTC, if the clock of the recorder was set.
    pub wall_clock: Option<String>,
    /// How often it was found, and in which packet last; the other values are those of the first time.
    pub count: u64,
    pub last_frame: u64,
    /// The byte of the frame, from 0 at the first captured one.
    pub octet: Option<usize>,
    /// The bit of that byte, 0 is the least significant.
    pub bit: Option<u8>,
    /// A Wireshark display filter that finds the packet; `None` on PROFIBUS, which Wireshark does not read.
    pub filter: Option<String>,
    /// The connection, as an index into the `ars` of the report.
    pub ar: Option<usize>,
    /// What is wrong, for people.
    pub text: String,
    /// The parts of it one by one, where there are several: the records of one request.
    pub details: Vec<String>,
    /// The expected value or frame.
    pub expected: Option<String>,
    /// The observed value or frame.
    pub seen: Option<String>,
    /// The party to blame, as far as a capture shows.
    pub blame: CaptureBlame,
    /// The most likely cause.
    pub cause: Option<String>,
    /// What to do next.
    pub next: Option<String>,
    /// What follows from it, and is no finding of its own.
    pub consequences: Vec<CaptureFinding>,
    /// The frames around it.
    pub context: FindingContext,
    /// The bus of the frame; it decides whether `ar` counts PROFINET connections or slaves.
    #[serde(skip)]
    pub(crate) bus: Bus,
}

/// The party to blame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CaptureBlame {
    /// A device or slave.
    Device,
    /// A controller or master, or its configuration.
    Controller,
    /// What is between them: cables, switches, another station.
    Network,
    /// The capture shows too little, or is damaged.
    Capture,
    /// One of two sides, and the capture does not show which.
    Undecided,
}

impl CaptureBlame {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            CaptureBlame::Device => "device",
            CaptureBlame::Controller => "controller",
            CaptureBlame::Network => "network",
            CaptureBlame::Capture => "capture",
            CaptureBlame::Undecided => "undecided",
        }
    }
}

impl CaptureFinding {
    /// A finding of a protocol check in packet `frame`; `id` is the id of the check (`PN-...`, `DP-...`).
    ///
    /// It is on PROFINET unless [`CaptureFinding::on`] sets another bus.
    pub fn protocol(
        id: impl Into<String>,
        severity: FindingSeverity,
        blame: CaptureBlame,
        frame: u64,
        text: impl Into<String>,
    ) -> CaptureFinding {
        CaptureFinding {
            id: id.into(),
            requirements: Vec::new(),
            clause: None,
            requirement: None,
            severity,
            frame,
            time: None,
            wall_clock: None,
            count: 1,
            last_frame: frame,
            octet: None,
            bit: None,
            filter: (frame > 0).then(|| format!("frame.number == {frame}")),
            ar: None,
            text: text.into(),
            details: Vec::new(),
            expected: None,
            seen: None,
            blame,
            cause: None,
            next: None,
            consequences: Vec::new(),
            context: FindingContext::default(),
            bus: Bus::Profinet,
        }
    }

    /// A finding of a rule of a manual. If the rule covers requirements, given with id and clause, their ids replace the `id` of the
    /// rule.
    pub fn rule(
        id: impl Into<String>,
        requirements: &[(&str, &str)],
        severity: FindingSeverity,
        frame: u64,
        text: impl Into<String>,
    ) -> CaptureFinding {
        let mut clauses: Vec<&str> = Vec::new();
        for (_, clause) in requirements.iter().filter(|(_, clause)| !clause.is_empty()) {
            if !clauses.contains(clause) {
                clauses.push(clause);
            }
        }
        let ids: Vec<String> = requirements.iter().map(|(id, _)| (*id).to_owned()).collect();
        let id = if ids.is_empty() { id.into() } else { ids.join(", ") };
        CaptureFinding {
            requirement: (!ids.is_empty()).then(|| ids.join(", ")),
            requirements: ids,
            clause: (!clauses.is_empty()).then(|| clauses.join("; ")),
            ..CaptureFinding::protocol(id, severity, CaptureBlame::Device, frame, text)
        }
    }

    /// A difference between the recorded device and the one that it is compared with; `name` is the name of the value.
    pub fn divergence(
        name: impl Into<String>,
        frame: u64,
        recorded: impl Into<String>,
        ours: impl Into<String>,
        text: impl Into<String>,
    ) -> CaptureFinding {
        CaptureFinding::protocol(name, FindingSeverity::Warning, CaptureBlame::Device, frame, text)
            .expected(ours)
            .observed(recorded)
    }

    /// Blames the capture instead of a party, with severity warning at most.
    pub(crate) fn blame_capture(&mut self) {
        self.severity = self.severity.min(FindingSeverity::Warning);
        self.blame = CaptureBlame::Capture;
    }

    /// Sets the bus on which the packet was captured.
    #[must_use]
    pub fn on(mut self, bus: Bus) -> CaptureFinding {
        self.bus = bus;
        self.filter = match bus {
            Bus::Profinet => Some(format!("frame.number == {}", self.frame)),
            Bus::Profibus => None,
        };
        self
    }

    /// Sets PROFIBUS as the bus.
    #[must_use]
    pub fn on_profibus(self) -> CaptureFinding {
        self.on(Bus::Profibus)
    }

    /// Sets the connection.
    #[must_use]
    pub fn ar(mut self, ar: ArId) -> CaptureFinding {
        self.ar = Some(ar.0 as usize);
        self
    }

    /// Sets the byte of the frame, from 0, and the bit in it, 0 being the least significant.
    #[must_use]
    pub fn at(mut self, octet: usize, bit: Option<u8>) -> CaptureFinding {
        (self.octet, self.bit) = (Some(octet), bit);
        self
    }

    /// Sets a better display filter than the one for the packet alone.
    #[must_use]
    pub fn filter(mut self, filter: impl Into<String>) -> CaptureFinding {
        self.filter = Some(filter.into());
        self
    }

    /// Sets the parts of the finding, if there are several.
    #[must_use]
    pub fn details(mut self, details: Vec<String>) -> CaptureFinding {
        self.details = details;
        self
    }

    /// Sets the expected value.
    #[must_use]
    pub fn expected(mut self, what: impl Into<String>) -> CaptureFinding {
        self.expected = Some(what.into());
        self
    }

    /// Sets the observed value.
    #[must_use]
    pub fn observed(mut self, what: impl Into<String>) -> CaptureFinding {
        self.seen = Some(what.into());
        self
    }

    /// Sets the most likely cause, a sentence.
    #[must_use]
    pub fn cause(mut self, cause: impl Into<String>) -> CaptureFinding {
        self.cause = Some(cause.into());
        self
    }

    /// Sets the next step, a sentence.
    #[must_use]
    pub fn next(mut self, next: impl Into<String>) -> CaptureFinding {
        self.next = Some(next.into());
        self
    }
}
