//! What is wrong in a capture, made whole: where, against which clause, what was expected and seen, the frames around it, the
//! likely cause and the next step.
//!
//! Rules of the manuals, checks of the protocol and divergences from another device all hand over a [`Finding`]; reports and
//! pages read nothing else. This room must not know how a finding came about.

mod context;
mod of_rule;

pub(super) use context::Surroundings;
pub use context::{Context, ContextFrame};
pub(super) use of_rule::of_rule;

use judge::observe::ArId;
pub use results::outcome::Severity;
use serde::Serialize;
use suite::device::Bus;

/// Something that is wrong, or worth knowing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The requirements, or the id of the rule or of the check of the protocol where it is about none.
    pub id: String,
    /// The requirements one by one; empty where it is about none.
    pub requirements: Vec<String>,
    /// The clauses of the manual, as its requirements cite them.
    pub clause: Option<String>,
    /// How bad it is.
    pub severity: Severity,
    /// Where it shows: the number of the packet in the capture, from 1; 0 for a capture that has no frame.
    pub frame: u64,
    /// The octet of the frame, from 0 at the first one that was captured.
    pub octet: Option<usize>,
    /// The bit of that octet, 0 is the least significant.
    pub bit: Option<u8>,
    /// A Wireshark display filter that finds the packet; none on PROFIBUS, which Wireshark does not read.
    pub filter: Option<String>,
    /// The connection, an index into the `ars` of the report.
    pub ar: Option<usize>,
    /// What is wrong, for people.
    pub text: String,
    /// What should have been there.
    pub expected: Option<String>,
    /// What was there.
    pub seen: Option<String>,
    /// Whose fault it is, as far as a capture can tell.
    pub blame: Blame,
    /// What it most likely comes from.
    pub cause: Option<String>,
    /// What to do next.
    pub next: Option<String>,
    /// The frames around it.
    pub context: Context,
    /// The bus of the frame, which decides what the index of a connection counts.
    #[serde(skip)]
    pub(crate) bus: Bus,
}

/// Whose fault something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Blame {
    /// A device or slave.
    Device,
    /// A controller or master, or who planned it.
    Controller,
    /// What lies between them: cables, switches, a third party.
    Network,
    /// The capture shows too little, or is damaged.
    Capture,
}

impl Blame {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Blame::Device => "device",
            Blame::Controller => "controller",
            Blame::Network => "network",
            Blame::Capture => "capture",
        }
    }
}

impl Finding {
    /// What a check of the protocol found in packet `frame`; `id` is the word of the check (`PN-...`, `DP-...`).
    ///
    /// It is on PROFINET until [`Finding::on`] says otherwise.
    pub fn protocol(
        id: impl Into<String>,
        severity: Severity,
        blame: Blame,
        frame: u64,
        text: impl Into<String>,
    ) -> Finding {
        Finding {
            id: id.into(),
            requirements: Vec::new(),
            clause: None,
            severity,
            frame,
            octet: None,
            bit: None,
            filter: (frame > 0).then(|| format!("frame.number == {frame}")),
            ar: None,
            text: text.into(),
            expected: None,
            seen: None,
            blame,
            cause: None,
            next: None,
            context: Context::default(),
            bus: Bus::Profinet,
        }
    }

    /// What a rule of a manual found: `id` is that of the rule, which gives way to the requirements where it covers some,
    /// each with its id and clause.
    pub fn rule(
        id: impl Into<String>,
        requirements: &[(&str, &str)],
        severity: Severity,
        frame: u64,
        text: impl Into<String>,
    ) -> Finding {
        let mut clauses: Vec<&str> = Vec::new();
        for (_, clause) in requirements.iter().filter(|(_, clause)| !clause.is_empty()) {
            if !clauses.contains(clause) {
                clauses.push(clause);
            }
        }
        let ids: Vec<String> = requirements.iter().map(|(id, _)| (*id).to_owned()).collect();
        let id = if ids.is_empty() { id.into() } else { ids.join(", ") };
        Finding {
            requirements: ids,
            clause: (!clauses.is_empty()).then(|| clauses.join("; ")),
            ..Finding::protocol(id, severity, Blame::Device, frame, text)
        }
    }

    /// Where a device answered otherwise than the one that it is compared with; `name` is that of the value.
    pub fn divergence(
        name: impl Into<String>,
        frame: u64,
        recorded: impl Into<String>,
        ours: impl Into<String>,
        text: impl Into<String>,
    ) -> Finding {
        Finding::protocol(name, Severity::Warning, Blame::Device, frame, text).expected(ours).seen(recorded)
    }

    /// Takes back that it is held against anybody: the capture may be what is wrong.
    pub(crate) fn doubt(&mut self) {
        self.severity = self.severity.min(Severity::Warning);
        self.blame = Blame::Capture;
    }

    /// The bus that the packet was captured on.
    #[must_use]
    pub fn on(mut self, bus: Bus) -> Finding {
        self.bus = bus;
        self.filter = match bus {
            Bus::Profinet => Some(format!("frame.number == {}", self.frame)),
            Bus::Profibus => None,
        };
        self
    }

    /// The same for PROFIBUS.
    #[must_use]
    pub fn on_profibus(self) -> Finding {
        self.on(Bus::Profibus)
    }

    /// The connection that it is about.
    #[must_use]
    pub fn ar(mut self, ar: ArId) -> Finding {
        self.ar = Some(ar.0 as usize);
        self
    }

    /// The octet of the frame, from 0, and the bit in it, 0 being the least significant.
    #[must_use]
    pub fn at(mut self, octet: usize, bit: Option<u8>) -> Finding {
        (self.octet, self.bit) = (Some(octet), bit);
        self
    }

    /// A better display filter than the one for the packet alone.
    #[must_use]
    pub fn filter(mut self, filter: impl Into<String>) -> Finding {
        self.filter = Some(filter.into());
        self
    }

    /// What should have been there.
    #[must_use]
    pub fn expected(mut self, what: impl Into<String>) -> Finding {
        self.expected = Some(what.into());
        self
    }

    /// What was there.
    #[must_use]
    pub fn seen(mut self, what: impl Into<String>) -> Finding {
        self.seen = Some(what.into());
        self
    }

    /// What it most likely comes from, in a sentence.
    #[must_use]
    pub fn cause(mut self, cause: impl Into<String>) -> Finding {
        self.cause = Some(cause.into());
        self
    }

    /// What to do next, in a sentence.
    #[must_use]
    pub fn next(mut self, next: impl Into<String>) -> Finding {
        self.next = Some(next.into());
        self
    }
}
