//! PROFIBUS slaves: those that left the data exchange, fell silent, ran into their watchdog, do not answer, or have two masters.

use super::coverage::{CapturePosition, FindingList, SettledFrames};
use super::table::{
    DP_ADDRESS, DP_ADDRESS_IGNORED, DP_LEFT, DP_OTHER_MASTER, DP_REFUSED, DP_REPEATED, DP_SILENT, DP_UNANSWERED,
    DP_WATCHDOG,
};
use super::text::{of, span, times};
use crate::finding::{CaptureBlame, CaptureFinding, FindingSeverity};
use judge::observe::{
    ArId, ArStage, CyclicStatus, Dp, FrameDirection, Leaving, Observation, ObservedAr, PollPart, Traffic,
};
use station::Duration;
use std::collections::BTreeMap;
use wire::profibus::diag::{SlaveDiag, Status2};
use wire::profibus::prm::{SetPrm, StationStatus};
use wire::profibus::sap::{SapService, SlaveSap};

/// Upper limit of the remembered refusals.
const MOST: usize = 4_096;
/// This many repeated or unanswered requests to one slave are a warning.
const OFTEN: u64 = 3;

/// The requests to one slave and their answers.
#[derive(Clone, Copy, Debug, Default)]
struct PollCounts {
    asked: u64,
    again: u64,
    first_again: u64,
    /// Requests without an answer to a slave that answers other requests.
    unanswered: u64,
    first_unanswered: u64,
    answered: u64,
    /// Requests without an answer since the last answer, and the first of them; added to `unanswered` when an answer comes.
    open: (u64, u64),
}

/// What the capture shows of a slave.
#[derive(Clone, Debug, Default)]
struct PolledSlave {
    polls: PollCounts,
    /// When its master last addressed it.
    asked: Option<CapturePosition>,
    /// The longest pause between two requests of its master, and the frame that ended it.
    pause: Option<(Duration, u64)>,
    watchdog: Option<Duration>,
    master: Option<u8>,
    ar: Option<ArId>,
    /// Whether its master has sent parameters or a configuration since the data exchange began.
    is_set_again: bool,
    /// Number of bytes of the last outputs.
    outputs: Option<usize>,
    /// How many frames had been lost or unreadable when it last answered in the data exchange.
    disturbed: u64,
    /// Whether a request since then had no answer and was not repeated: the capture lost the answer.
    has_lost_answer: bool,
    /// Whether that answer had high priority, or a request since then was repeated: then a master asks for the diagnosis.
    calls_for_diagnosis: bool,
}

/// A refused service: connection, service, reason.
type RefusedService = (Option<ArId>, &'static str, String);

/// The slaves of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct PolledSlaves {
    slaves: BTreeMap<u8, PolledSlave>,
    /// Number of frames lost or unreadable so far.
    disturbed: u64,
    refused: BTreeMap<RefusedService, (u64, u64, u64)>,
    /// Addresses that slaves acknowledged.
    given: BTreeMap<u8, GivenAddress>,
    /// The ident number in the last diagnosis of each station.
    idents: BTreeMap<u8, u16>,
}

/// An address that a slave acknowledged.
#[derive(Clone, Copy, Debug)]
struct GivenAddress {
    new: u8,
    frame: u64,
    /// The ident number in the request.
    ident: u16,
    /// How often the old address and the new one answered afterwards.
    answers: (u64, u64),
}

impl PolledSlaves {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        match observation {
            Observation::Traffic(Traffic::Poll { master, station, service, part }) => {
                self.poll(now, (*master, *station), *service, *part);
            }
            Observation::Dp { event, ar } => self.event(now, ars, *ar, event, findings),
            Observation::Connected { ar: id } => {
                if let Some(slave) = of(ars, *id).and_then(|ar| self.slave(ar)) {
                    slave.ar = Some(*id);
                    (slave.pause, slave.outputs, slave.is_set_again) = (None, None, false);
                }
            }
            Observation::Cyclic { ar: id, direction: FrameDirection::ToDevice, data, .. } => {
                if let Some(slave) = of(ars, *id).and_then(|ar| self.slave(ar)) {
                    slave.outputs = Some(data.len());
                }
            }
            Observation::Cyclic { ar: id, direction: FrameDirection::ToController, status, .. } => {
                let disturbed = self.disturbed;
                if let Some(slave) = of(ars, *id).and_then(|ar| self.slave(ar)) {
                    (slave.disturbed, slave.has_lost_answer) = (disturbed, false);
                    slave.calls_for_diagnosis = *status == CyclicStatus::Fdl { diagnosis_pending: true };
                }
            }
            Observation::Unreadable { .. } | Observation::Gap { .. } => self.disturbed += 1,
            Observation::Starved { ar: id, direction } => self.starved(now, ars, *id, *direction, findings),
            Observation::CallFailed { ar, service, why } => {
                let key = (*ar, *service, (*why).to_owned());
                if self.refused.len() < MOST || self.refused.contains_key(&key) {
                    let entry = self.refused.entry(key).or_insert((0, now.frame, 0));
                    (entry.0, entry.2) = (entry.0 + 1, now.frame);
                }
            }
            _ => {}
        }
    }

    /// Frames may be missing here: what a slave does afterwards may have a cause among them.
    pub fn hole(&mut self) {
        self.disturbed += 1;
    }

    fn slave(&mut self, ar: &ObservedAr) -> Option<&mut PolledSlave> {
        match ar.device.address {
            judge::observe::Address::Fdl(station) => Some(self.slaves.entry(station).or_default()),
            judge::observe::Address::Mac(_) => None,
        }
    }

    fn poll(&mut self, now: CapturePosition, (master, station): (u8, u8), service: SapService, part: PollPart) {
        // A master searches for stations by requesting the FDL status of every address.
        if matches!(service, SapService::Link(_) | SapService::MasterMaster) {
            return;
        }
        if part == PollPart::Answered {
            for (old, given) in self.given.iter_mut() {
                given.answers.0 += u64::from(*old == station);
                given.answers.1 += u64::from(given.new == station);
            }
        }
        let slave = self.slaves.entry(station).or_default();
        let polls = &mut slave.polls;
        match part {
            PollPart::Asked => {
                polls.asked += 1;
                if slave.master.is_none_or(|of| of == master) {
                    if let Some(pause) = slave.asked.and_then(|before| now.since(before))
                        && slave.pause.is_none_or(|(longest, _)| longest < pause)
                    {
                        slave.pause = Some((pause, now.frame));
                    }
                    slave.asked = Some(now);
                    slave.is_set_again |= matches!(service, SapService::Slave(SlaveSap::SET_PRM | SlaveSap::CHK_CFG));
                }
            }
            PollPart::Again => {
                if slave.master.is_none_or(|of| of == master) {
                    (slave.has_lost_answer, slave.calls_for_diagnosis) = (false, true);
                }
                polls.again += 1;
                if polls.first_again == 0 {
                    polls.first_again = now.frame;
                }
            }
            PollPart::Answered => {
                polls.answered += 1;
                // It answered before and after: the requests in between were disturbed.
                if polls.open.0 > 0 && polls.answered > 1 {
                    polls.unanswered += polls.open.0;
                    if polls.first_unanswered == 0 {
                        polls.first_unanswered = polls.open.1;
                    }
                }
                polls.open = (0, 0);
            }
            PollPart::Unanswered => {
                slave.has_lost_answer = true;
                if polls.open.0 == 0 {
                    polls.open.1 = now.frame;
                }
                polls.open.0 += 1;
            }
        }
    }

    fn event(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        ar: Option<ArId>,
        event: &Dp<'_>,
        findings: &mut FindingList,
    ) {
        match *event {
            Dp::Parameters { master, station, octets } => {
                let Ok(prm) = SetPrm::parse(octets) else { return };
                let locks = prm.status.has(StationStatus::LOCK_REQ);
                let slave = self.slaves.entry(station).or_default();
                let owner = slave.ar.and_then(|ar| of(ars, ar)).filter(|ar| ar.stage == ArStage::Ready);
                if locks
                    && owner.is_some()
                    && let Some(other) = slave.master.filter(|of| *of != master)
                {
                    let text = format!(
                        "master {master} sends parameters to slave {station}, which exchanges data with master {other}"
                    );
                    let finding = on_bus(
                        DP_OTHER_MASTER.finding(FindingSeverity::Error, CaptureBlame::Controller, now.frame, text),
                        slave.ar,
                    );
                    findings.add(finding);
                    return;
                }
                if locks {
                    let base = prm.dpv1().filter(|dpv1| dpv1.status_1.reserved() == 0);
                    let base = base.map_or(10, |dpv1| dpv1.watchdog_base_ms());
                    slave.watchdog = prm.watchdog_ms(base).map(|ms| Duration::from_millis(ms.into()));
                    slave.master = Some(master);
                } else if prm.status.has(StationStatus::UNLOCK_REQ) {
                    slave.master = None;
                }
            }
            Dp::AddressGiven { master, station, address, ident } => {
                if station != address && self.given.len() < MOST {
                    findings.note(now.frame);
                    let (new, frame) = (address, now.frame);
                    self.given.insert(station, GivenAddress { new, frame, ident, answers: (0, 0) });
                }
                let slave = self.slaves.entry(station).or_default();
                let stands = slave.ar.and_then(|ar| of(ars, ar)).is_some_and(|ar| ar.stage == ArStage::Ready);
                if stands {
                    let text =
                        format!("master {master} gives slave {station} the address {address} while it exchanges data");
                    findings.add(on_bus(
                        DP_ADDRESS.finding(FindingSeverity::Error, CaptureBlame::Network, now.frame, text),
                        slave.ar,
                    ));
                }
            }
            Dp::Left { why: Leaving::NoService } => {
                self.left(now, ars, (ar, true), "it answers Data_Exchange with `no service` (RS)", findings);
            }
            Dp::Diagnosis { station, octets, .. } => {
                // The diagnosis that shows the end is observed before the end itself.
                let Ok(diag) = SlaveDiag::parse(octets) else { return };
                self.idents.insert(station, diag.ident);
                let Some(id) = ar.filter(|ar| of(ars, *ar).is_some_and(|ar| ar.stage == ArStage::Ready)) else {
                    return;
                };
                let slave = self.slaves.entry(station).or_default();
                let (master, is_explained) = (slave.master, slave.calls_for_diagnosis);
                if diag.status_2.has(Status2::PRM_REQ) {
                    let why = "its diagnosis requests new parameters (Prm_Req)";
                    self.left(now, ars, (Some(id), is_explained), why, findings);
                } else if master.is_some_and(|master| diag.master != master) {
                    let why = format!("its diagnosis names master {}", diag.master);
                    self.left(now, ars, (Some(id), is_explained), &why, findings);
                }
            }
            _ => {}
        }
    }

    /// A slave left the data exchange: because of its watchdog where its master paused for longer, else by itself. `is_explained`: the
    /// capture shows why its master asked for the diagnosis.
    fn left(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        (ar, is_explained): (Option<ArId>, bool),
        why: &str,
        findings: &mut FindingList,
    ) {
        let Some(known) = ar.and_then(|ar| of(ars, ar)) else { return };
        let (address, master) = (known.device.address, known.controller.address);
        let disturbed = self.disturbed;
        let Some(slave) = self.slave(known) else { return };
        let is_in_doubt = slave.has_lost_answer || slave.disturbed != disturbed;
        let configured = known.outputs.data_length;
        // The pause that has not ended yet may be the longest.
        let open = slave.asked.and_then(|before| now.since(before)).map(|pause| (pause, now.frame));
        let longest = slave.pause.into_iter().chain(open).max();
        // No master asks twice at the same time: the capture has no clock.
        let is_timeless = slave.watchdog.is_some() && longest.is_some_and(|(pause, _)| pause.is_zero());
        let mut finding = match (slave.watchdog, longest) {
            _ if slave.outputs.is_some_and(|octets| octets != configured) => {
                let text = format!(
                    "{address} left the data exchange with {master}: {why}; its master sent {} bytes of outputs instead of \
     {configured}",
                    slave.outputs.unwrap_or_default()
                );
                DP_LEFT.finding(FindingSeverity::Error, CaptureBlame::Controller, now.frame, text)
            }
            (Some(watchdog), Some((pause, frame))) if pause > watchdog => {
                let text = format!(
                    "{address} left the data exchange with {master}: {why}; its master did not address it for {} (up to frame \
     {frame}), longer than its watchdog of {}",
                    span(pause),
                    span(watchdog)
                );
                DP_WATCHDOG.finding(FindingSeverity::Error, CaptureBlame::Controller, now.frame, text)
            }
            _ if slave.is_set_again => {
                let text = format!(
                    "{address} left the data exchange with {master}: {why}; its master had sent it parameters or a configuration again"
                );
                DP_LEFT.finding(FindingSeverity::Error, CaptureBlame::Controller, now.frame, text)
            }
            (watchdog, pause) => {
                let watched = match (watchdog, pause) {
                    (Some(watchdog), Some((pause, _))) => {
                        format!(
                            "; the longest pause of its master was {}, its watchdog is {}",
                            span(pause),
                            span(watchdog)
                        )
                    }
                    _ => String::new(),
                };
                let text = format!("{address} left the data exchange with {master}: {why}{watched}");
                DP_LEFT.finding(FindingSeverity::Error, CaptureBlame::Device, now.frame, text)
            }
        };
        if is_in_doubt {
            // The lost frames may contain the cause, for instance other parameters.
            finding.blame_capture();
            finding.text.push_str("; the capture lost frames before it");
        } else if !is_explained && finding.blame == CaptureBlame::Device {
            finding.blame_capture();
            finding.text.push_str(
                "; no answer of high priority and no repeated request comes before this diagnosis, so a request that ended the data \
                 exchange may be missing",
            );
        } else if is_timeless && finding.blame == CaptureBlame::Device {
            finding.blame_capture();
            finding.text.push_str("; the capture has no clock, so the pauses of its master are unknown");
        }
        findings.add(on_bus(finding, ar));
    }

    fn starved(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        id: ArId,
        direction: FrameDirection,
        findings: &mut FindingList,
    ) {
        let Some(ar) = of(ars, id) else { return };
        let (address, master) = (ar.device.address, ar.controller.address);
        let finding = match direction {
            FrameDirection::ToController => {
                let last = ar
                    .inputs
                    .last
                    .map_or_else(String::new, |last| format!(", {} after its last answer", span(now.time.since(last))));
                let text = format!("{address} no longer answers Data_Exchange of {master}{last}");
                DP_SILENT.finding(FindingSeverity::Error, CaptureBlame::Network, now.frame, text)
            }
            FrameDirection::ToDevice => {
                let text = format!(
                    "{master} did not address {address} for longer than its watchdog of {}: the slave leaves the data exchange",
                    span(ar.outputs.watchdog)
                );
                DP_WATCHDOG.finding(FindingSeverity::Error, CaptureBlame::Controller, now.frame, text)
            }
        };
        findings.add(on_bus(finding, Some(id)));
    }

    pub fn end(self, _now: CapturePosition, ars: &[ObservedAr], findings: &mut FindingList) {
        let any_slave_answers = self.slaves.values().any(|slave| slave.polls.answered > 0);
        for (station, slave) in &self.slaves {
            let PollCounts { asked, again, unanswered, answered, .. } = slave.polls;
            if again > 0 {
                let severity = if again >= OFTEN { FindingSeverity::Warning } else { FindingSeverity::Info };
                let text =
                    format!("{again} of {asked} requests to slave {station} were repeated (the FCB did not change)");
                findings.add(on_bus(
                    DP_REPEATED.finding(severity, CaptureBlame::Network, slave.polls.first_again, text),
                    slave.ar,
                ));
            } else if unanswered > 0 {
                let severity = if unanswered >= OFTEN { FindingSeverity::Warning } else { FindingSeverity::Info };
                let text = format!(
                    "{unanswered} of {asked} requests to slave {station} were not answered; the slave answers the others"
                );
                let frame = slave.polls.first_unanswered;
                findings.add(on_bus(DP_UNANSWERED.finding(severity, CaptureBlame::Network, frame, text), slave.ar));
            }
            let is_configured = slave.ar.is_some() || slave.master.is_some();
            if answered == 0 && slave.polls.open.0 >= OFTEN && !is_configured && any_slave_answers {
                let text = format!("slave {station} answers none of its {asked} requests");
                let frame = slave.polls.open.1;
                findings.add(on_bus(
                    DP_UNANSWERED.finding(FindingSeverity::Warning, CaptureBlame::Device, frame, text),
                    None,
                ));
            }
        }
        for (old, GivenAddress { new, frame, ident, answers }) in self.given {
            // The answer that acknowledged it does not count.
            if answers.0 < OFTEN || answers.1 > 0 {
                continue;
            }
            let (own, blame) = match self.idents.get(&old) {
                Some(own) if *own != ident => {
                    let own = format!("; its ident number is 0x{own:04X}, the one in the request 0x{ident:04X}");
                    (own, CaptureBlame::Controller)
                }
                _ => (String::new(), CaptureBlame::Undecided),
            };
            let text = format!(
                "slave {old} acknowledged the address {new}, but goes on to answer at {old} ({} times), and {new} never answers{own}",
                answers.0
            );
            let finding = DP_ADDRESS_IGNORED.finding(FindingSeverity::Warning, blame, frame, text);
            findings.add(on_bus(finding.expected(format!("answers at address {new}")), None));
        }
        for ((ar, service, why), (count, first, last)) in self.refused {
            let who =
                ar.and_then(|ar| of(ars, ar)).map_or_else(|| "a slave".to_owned(), |ar| ar.device.address.to_string());
            let text = format!("{who} refuses {service}: {}{}", why.trim_end_matches('.'), times(count, last));
            findings.add(on_bus(
                DP_REFUSED.finding(FindingSeverity::Info, CaptureBlame::Controller, first, text).observed(why),
                ar,
            ));
        }
    }
}

/// A finding on PROFIBUS, with its connection where known.
pub(super) fn on_bus(finding: CaptureFinding, ar: Option<ArId>) -> CaptureFinding {
    let finding = finding.on_profibus();
    match ar {
        Some(ar) => finding.ar(ar),
        None => finding,
    }
}

impl PolledSlaves {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        let is_forgotten = |ar: Option<ArId>| ar.is_some_and(|ar| !settled.keeps(ar));
        for slave in self.slaves.values_mut() {
            let polls = &mut slave.polls;
            // That it answers at all is remembered.
            polls.answered = polls.answered.min(2);
            if polls.first_again <= settled.reported && polls.first_unanswered <= settled.reported {
                *polls = PollCounts { answered: polls.answered, open: polls.open, ..PollCounts::default() };
            }
            if is_forgotten(slave.ar) {
                slave.ar = None;
            }
        }
        self.refused.retain(|key, (.., last)| *last > settled.reported && !is_forgotten(key.0));
    }
}
