//! Answers that are empty, cannot be read, or do not fit their request: on PROFINET those to calls and DCP, on PROFIBUS those to polls.

use super::advice::{Advice, advised};
use super::coverage::{CapturePosition, FindingList, SettledFrames};
use super::slaves::on_bus;
use super::table::{ANSWER_MALFORMED, DP_FIXED_BIT, DP_INPUT_LENGTH, DP_WRONG_ANSWER, ProtocolCheck};
use super::text::times;
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, Dp, Observation, ObservedAr, PollFault, Traffic};
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::profibus::diag::{SlaveDiag, Status2};
use wire::profibus::sap::SapService;
use wire::profinet::dcp::{ServiceId, ServiceType};

/// What a single answer without a checksum means.
const CHANGED: Option<Advice> = Some((
    "The recorder or the file changed it, or the station sent it so once.",
    "Look whether it happens again in another capture: then the station is the cause.",
));
/// Upper limit of the remembered faults.
const MOST: usize = 4_096;
/// The byte of the second status in a diagnosis, and its fixed bit.
const FIXED_BIT: (usize, u8) = (1, 2);

/// How often, the first and the last frame.
#[derive(Clone, Copy, Debug)]
struct FaultCount {
    count: u64,
    first: u64,
    last: u64,
    /// Whether a checksum shows one of them to be captured as it was sent.
    is_proven: bool,
    ar: Option<ArId>,
}

/// What is wrong with the answers of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum SlaveFault {
    Poll(PollFault),
    FixedBit,
}

/// The wrong answers of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct AnswerCheck {
    /// Whether the capture kept only a part of the current frame, whose end is then missing and not malformed.
    is_cut: bool,
    /// By service, the station that answers, the one that asked, and what is wrong.
    calls: BTreeMap<(&'static str, Mac, Mac, String), FaultCount>,
    /// By station, name of the service, and what is wrong; with the offset of the byte that shows it.
    slaves: BTreeMap<(u8, &'static str, SlaveFault), (FaultCount, Option<usize>)>,
}

impl AnswerCheck {
    /// Forgets what a watch that never ends has reported.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.calls.retain(|_, fault| fault.last > settled.reported);
    }

    /// The same for the slaves.
    pub fn forget_slaves(&mut self, settled: SettledFrames<'_>) {
        self.slaves.retain(|_, (fault, _)| fault.last > settled.reported);
    }

    /// A frame begins.
    #[inline]
    pub fn begin(&mut self, is_cut: bool) {
        self.is_cut = is_cut;
    }

    pub fn observe(&mut self, now: CapturePosition, observation: &Observation<'_>, findings: &mut FindingList) {
        if self.is_cut {
            return;
        }
        match observation {
            Observation::Traffic(Traffic::AnswerMalformed { ar, service, source, destination, is_proven, why }) => {
                self.call(now, (service, *source, *destination, why), (*is_proven, *ar), findings);
            }
            Observation::Dcp { source, destination, pdu } => {
                let is_answer = pdu.service_type == ServiceType::RESPONSE
                    && [ServiceId::IDENTIFY, ServiceId::GET].contains(&pdu.service_id);
                if is_answer && pdu.blocks().is_empty() {
                    self.call(now, ("DCP", *source, *destination, "it has no block"), (false, None), findings);
                }
            }
            Observation::Traffic(Traffic::PollFault { ar, station, service, fault, .. }) => {
                let word = word(*service);
                self.slave(now, (*station, word, SlaveFault::Poll(*fault)), (*ar, None), findings);
            }
            Observation::Dp { ar, event: Dp::Diagnosis { station, octets, at, .. } }
                if SlaveDiag::parse(octets).is_ok_and(|diag| !diag.status_2.has(Status2::FIXED_ONE)) =>
            {
                let place = Some(at + FIXED_BIT.0);
                self.slave(now, (*station, "Slave_Diag", SlaveFault::FixedBit), (*ar, place), findings);
            }
            _ => {}
        }
    }

    fn call(
        &mut self,
        now: CapturePosition,
        (service, source, destination, why): (&'static str, Mac, Mac, &str),
        (is_proven, ar): (bool, Option<ArId>),
        findings: &mut FindingList,
    ) {
        let key = (service, source, destination, why.to_owned());
        if self.calls.len() < MOST || self.calls.contains_key(&key) {
            let of = self.calls.entry(key).or_insert_with(|| FaultCount::new(now, ar, findings));
            of.add(now);
            of.is_proven |= is_proven;
        }
    }

    fn slave(
        &mut self,
        now: CapturePosition,
        key: (u8, &'static str, SlaveFault),
        (ar, place): (Option<ArId>, Option<usize>),
        findings: &mut FindingList,
    ) {
        if self.slaves.len() < MOST || self.slaves.contains_key(&key) {
            let of = self.slaves.entry(key).or_insert_with(|| (FaultCount::new(now, ar, findings), place));
            of.0.add(now);
            of.0.ar = of.0.ar.or(ar);
        }
    }

    pub fn end(self, _ars: &[ObservedAr], _slaves: &[ObservedAr], findings: &mut FindingList) {
        for ((service, source, destination, why), of) in self.calls {
            let blame = if service == "ApplicationReady" { CaptureBlame::Controller } else { CaptureBlame::Device };
            // One frame without a checksum is no proof.
            let (severity, blame) = match (of.is_proven, of.count) {
                (true, _) => (FindingSeverity::Error, blame),
                (false, 1) => (FindingSeverity::Warning, CaptureBlame::Capture),
                (false, _) => (FindingSeverity::Warning, blame),
            };
            let text = format!(
                "{source} sends an answer to {service} of {destination} that is empty or cannot be read: {}{}",
                why.trim_end_matches('.'),
                times(of.count, of.last)
            );
            let finding = ANSWER_MALFORMED.finding(severity, blame, of.first, text);
            let finding = if blame == CaptureBlame::Capture { advised(finding, CHANGED) } else { finding };
            findings.add(match of.ar {
                Some(ar) => finding.ar(ar),
                None => finding,
            });
        }
        for ((station, service, fault), (of, place)) in self.slaves {
            let (check, what, expected) = words(fault, service);
            let (severity, blame) = match (of.count, check == DP_INPUT_LENGTH) {
                (1, _) => (FindingSeverity::Warning, CaptureBlame::Capture),
                (_, true) => (FindingSeverity::Error, CaptureBlame::Device),
                (_, false) => (FindingSeverity::Warning, CaptureBlame::Device),
            };
            let text = format!("slave {station} {what}{}", times(of.count, of.last));
            let finding = check.finding(severity, blame, of.first, text).expected(expected);
            let finding = if blame == CaptureBlame::Capture { advised(finding, CHANGED) } else { finding };
            let finding = match place {
                Some(octet) => finding.at(octet, Some(FIXED_BIT.1)),
                None => finding,
            };
            findings.add(on_bus(finding, of.ar));
        }
    }
}

impl FaultCount {
    fn new(now: CapturePosition, ar: Option<ArId>, findings: &mut FindingList) -> FaultCount {
        findings.note(now.frame);
        FaultCount { count: 0, first: now.frame, last: now.frame, is_proven: false, ar }
    }

    fn add(&mut self, now: CapturePosition) {
        (self.count, self.last) = (self.count + 1, now.frame);
    }
}

fn word(service: SapService) -> &'static str {
    match service {
        SapService::DataExchange => "Data_Exchange",
        service => service.word().unwrap_or("a service"),
    }
}

/// The check of a fault, what the slave does, and what was expected.
fn words(fault: SlaveFault, service: &str) -> (&'static ProtocolCheck, String, String) {
    let point = |point: Option<u8>| point.map_or_else(|| "the default SAP".to_owned(), |point| format!("SAP {point}"));
    match fault {
        SlaveFault::Poll(PollFault::InputLength { expected, observed }) => (
            DP_INPUT_LENGTH,
            format!("sends {observed} bytes of inputs, but its accepted configuration has {expected}"),
            format!("{expected} bytes"),
        ),
        SlaveFault::Poll(PollFault::ShortDiagnosis { octets }) => (
            DP_WRONG_ANSWER,
            format!("sends a diagnosis of {octets} bytes, which is too short"),
            "6 bytes or more".to_owned(),
        ),
        SlaveFault::Poll(PollFault::Unreadable { octets }) => (
            DP_WRONG_ANSWER,
            format!("sends an answer to {service} of {octets} bytes that cannot be read"),
            "an answer of DP-V1".to_owned(),
        ),
        SlaveFault::Poll(PollFault::OtherAccessPoint { requested, answered }) => (
            DP_WRONG_ANSWER,
            format!("answers {service} from {} instead of {}", point(answered), point(requested)),
            point(requested),
        ),
        SlaveFault::Poll(PollFault::OtherReceiver { receiver }) => (
            DP_WRONG_ANSWER,
            format!("sends its answer to {service} to station {receiver}, which did not request it"),
            "an answer to the station that requested it".to_owned(),
        ),
        SlaveFault::FixedBit => (
            DP_FIXED_BIT,
            "sends diagnoses in which bit 2 of the second byte is 0".to_owned(),
            "1, in every diagnosis".to_owned(),
        ),
    }
}
