//! Alarms: those not acknowledged, those refused, and diagnoses that are still pending or were read from a record.

use super::advice::{advised, of_alarm, of_channel, of_refusal};
use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::table::{ALARM_DIAGNOSIS, ALARM_PRIORITY, ALARM_REFUSED, ALARM_UNACKNOWLEDGED};
use super::text::{of, sender, span, status, times};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, CallPart, FrameDirection, Observation, ObservedAr, Traffic};
use station::Duration;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use wire::ethernet::Mac;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmType, RtaKind};
use wire::profinet::diagnosis::{ChannelChange, ChannelDiagnosis, DiagnosisData};

/// No channel error type has these bits and an alarm type in the others.
const OF_ALARM: u16 = 0xFF00;
/// RTA acknowledges an alarm within this time, repetitions included.
const TRANSPORT: Duration = Duration::from_secs(2);
/// The controller's application acknowledges an alarm within this time.
const APPLICATION: Duration = Duration::from_secs(10);
/// Upper limit of the remembered alarms, faults and diagnoses.
const MOST: usize = 4_096;

/// An alarm, or the acknowledgement of one, that was sent as RTA DATA.
#[derive(Clone, Copy, Debug)]
struct SentAlarm {
    first: CapturePosition,
    last: CapturePosition,
    sequence: u16,
    again: u32,
    acknowledged: bool,
    answered: bool,
    /// Whether it is an alarm and not the acknowledgement of one.
    is_alarm: bool,
}

/// A fault reported by alarm: connection, slot, subslot, channel, error type.
type FaultAddress = (ArId, u16, u16, u16, u16);

/// A diagnosis in a record: reporting station, slot, subslot, channel, error type.
type DiagnosisAddress = (Mac, u16, u16, u16, u16);

/// A diagnosis read from a record: how often, its first and last frame, record index, connection, and its text.
#[derive(Clone, Debug)]
struct ReadDiagnosis {
    count: u64,
    first: u64,
    last: u64,
    index: u16,
    ar: Option<ArId>,
    text: String,
}

/// The records that contain diagnoses: of a subslot, a slot, an AR, an API or a device; see [`DiagnosisData`].
const RECORDS: [u16; 13] =
    [0x800A, 0x800B, 0x800C, 0xC00A, 0xC00B, 0xC00C, 0xE00A, 0xE00B, 0xE00C, 0xF00A, 0xF00B, 0xF00C, 0xF80C];
/// Channel error types about link, neighbours or clock: the cause may be outside the device.
const OF_THE_NETWORK: RangeInclusive<u16> = 0x8000..=0x800F;

/// The alarms and diagnoses of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct AlarmCheck {
    sent: BTreeMap<(ArId, AlarmPriority, bool), SentAlarm>,
    faults: BTreeMap<FaultAddress, (u64, u64, Option<u64>, String)>,
    /// The station that sent the last answer to a call.
    answers: Option<Mac>,
    read: BTreeMap<DiagnosisAddress, ReadDiagnosis>,
    unacknowledged: BTreeMap<(ArId, bool), (u64, u64, u64, u32)>,
    /// The number of alarms and acknowledgements of two priorities, and the first and the last of them. The key is the connection, whether
    /// they go to the device, and the priority of the frame ID.
    mixed: BTreeMap<(ArId, bool, AlarmPriority), (u64, u64, u64)>,
}

impl AlarmCheck {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        match observation {
            Observation::Traffic(Traffic::Rta {
                ar,
                direction,
                priority,
                of_block,
                kind,
                sequence,
                acknowledges,
                again,
            }) => {
                let to_device = *direction == FrameDirection::ToDevice;
                if !again && of_block.is_some_and(|of_block| of_block != *priority) && self.mixed.len() < MOST {
                    let mixed = self.mixed.entry((*ar, to_device, *priority)).or_insert((0, now.frame, 0));
                    (mixed.0, mixed.2) = (mixed.0 + 1, now.frame);
                }
                if *kind == RtaKind::DATA || *kind == RtaKind::ACK {
                    // Any frame on the channel carries the sequence number that its sender has received last.
                    if let Some(sent) = self.sent.get_mut(&(*ar, *priority, !to_device)) {
                        sent.acknowledged |= *acknowledges == sent.sequence;
                        sent.answered |= *kind == RtaKind::DATA && to_device && *acknowledges == sent.sequence;
                    }
                }
                if *kind == RtaKind::DATA {
                    let key = (*ar, *priority, to_device);
                    match self.sent.get_mut(&key).filter(|_| *again) {
                        Some(sent) => (sent.last, sent.again) = (now, sent.again + 1),
                        None => {
                            if let Some(before) = self.sent.remove(&key) {
                                self.missed(key, before);
                            }
                            let (first, last, sequence) = (now, now, *sequence);
                            let (acknowledged, answered) = (false, false);
                            let is_alarm = !to_device;
                            let sent = SentAlarm { first, last, sequence, again: 0, acknowledged, answered, is_alarm };
                            if self.sent.len() < MOST {
                                self.sent.insert(key, sent);
                            }
                        }
                    }
                }
            }
            Observation::Alarm { ar, notification, .. } => self.alarm(now, *ar, notification),
            Observation::Traffic(Traffic::Call { part: CallPart::Answered, source, .. }) => {
                self.answers = Some(*source)
            }
            Observation::Record { ar, written: false, target: (.., index), data, status }
                if status.is_ok() && RECORDS.contains(index) =>
            {
                self.record(now, *ar, *index, data, findings);
            }
            Observation::AlarmAcknowledged { ar: id, status: code } => {
                for priority in [AlarmPriority::Low, AlarmPriority::High] {
                    if let Some(sent) = self.sent.get_mut(&(*id, priority, false)) {
                        sent.answered = true;
                    }
                }
                if let Some(ar) = of(ars, *id).filter(|_| !code.is_ok()) {
                    let text = format!("{} refuses an alarm: {}", sender(ar, FrameDirection::ToDevice), status(code));
                    let finding =
                        ALARM_REFUSED.finding(FindingSeverity::Warning, CaptureBlame::Controller, now.frame, text);
                    findings.add(advised(finding, of_refusal(code, false)).ar(*id));
                }
            }
            // The connection has ended: nothing more is expected on it.
            Observation::Released { ar } | Observation::Aborted { ar, .. } | Observation::Starved { ar, .. } => {
                let open: Vec<_> = self.sent.keys().filter(|key| key.0 == *ar).copied().collect();
                for key in open {
                    if let Some(sent) = self.sent.remove(&key)
                        && now.since(sent.first).is_some_and(|waited| waited >= TRANSPORT)
                    {
                        self.missed(key, sent);
                    }
                }
            }
            Observation::Unreadable { .. } => self.sent.clear(),
            _ => {}
        }
    }

    /// Closes an alarm whose time is over: the next DATA came, or the connection ended.
    fn missed(&mut self, (ar, _, to_device): (ArId, AlarmPriority, bool), sent: SentAlarm) {
        // A sender that misses its acknowledgement repeats; without a repetition the capture has lost the acknowledgement.
        if !sent.acknowledged && sent.again > 0 && self.unacknowledged.len() < MOST {
            let of = self.unacknowledged.entry((ar, to_device)).or_insert((0, sent.first.frame, 0, 0));
            (of.0, of.2, of.3) = (of.0 + 1, sent.first.frame, of.3.max(sent.again));
        }
    }

    /// Collects the diagnoses of a record.
    fn record(&mut self, now: CapturePosition, ar: Option<ArId>, index: u16, data: &[u8], findings: &mut FindingList) {
        let (Some(station), Ok(blocks)) = (self.answers, DiagnosisData::parse_record(data)) else { return };
        for block in &blocks {
            for channel in block.item.channels() {
                let key = (station, block.slot, block.subslot, channel.channel, channel.error_type.0);
                if self.read.len() >= MOST && !self.read.contains_key(&key) {
                    continue;
                }
                let (first, last, text) = (now.frame, now.frame, words(&channel));
                let read = self.read.entry(key).or_insert(ReadDiagnosis { count: 0, first, last, index, ar, text });
                if read.count == 0 {
                    findings.note(now.frame);
                }
                (read.count, read.last) = (read.count + 1, now.frame);
            }
        }
    }

    fn alarm(&mut self, now: CapturePosition, ar: ArId, alarm: &AlarmNotification) {
        // The kind of an alarm without channels stands in place of an error type; it is none of those.
        let place = (ar, alarm.slot, alarm.subslot, 0, OF_ALARM | alarm.alarm_type.0);
        if let Some((what, ..)) = of_alarm(alarm.alarm_type)
            && self.faults.len() < MOST
        {
            self.faults.entry(place).or_insert((0, now.frame, None, what.to_owned())).0 += 1;
        }
        if [AlarmType::PLUG, AlarmType::RELEASED, AlarmType::RETURN_OF_SUBMODULE].contains(&alarm.alarm_type) {
            let all = (ar, alarm.slot, alarm.subslot, 0, OF_ALARM)..=(ar, alarm.slot, alarm.subslot, 0, u16::MAX);
            for (_, fault) in self.faults.range_mut(all) {
                fault.2 = Some(now.frame);
            }
        }
        for channel in alarm.items.iter().flat_map(|item| item.channels()) {
            let place = (ar, alarm.slot, alarm.subslot, channel.channel, channel.error_type.0);
            match channel.properties.change() {
                ChannelChange::Appears if self.faults.len() < MOST => {
                    let fault = self.faults.entry(place).or_insert((0, now.frame, None, words(&channel)));
                    (fault.0, fault.2) = (fault.0 + 1, None);
                }
                ChannelChange::Appears => {}
                _ => {
                    if let Some(fault) = self.faults.get_mut(&place) {
                        fault.2 = Some(now.frame);
                    }
                }
            }
        }
    }

    pub fn end(mut self, sight: &CaptureCoverage, ars: &[ObservedAr], findings: &mut FindingList) {
        let now = sight.now;
        for (key, sent) in std::mem::take(&mut self.sent) {
            let Some(ar) = of(ars, key.0) else { continue };
            let waited = now.since(sent.last).unwrap_or_default();
            if !sent.acknowledged && waited >= TRANSPORT {
                self.missed(key, sent);
            } else if sent.is_alarm && sent.acknowledged && !sent.answered && waited >= APPLICATION && ar.stage.stands()
            {
                let text = format!(
                    "{} received the alarm, but its application did not acknowledge it in the remaining {} of the capture",
                    sender(ar, FrameDirection::ToDevice),
                    span(waited)
                );
                let finding = ALARM_UNACKNOWLEDGED.finding(
                    FindingSeverity::Info,
                    CaptureBlame::Controller,
                    sent.first.frame,
                    text,
                );
                findings.add(finding.ar(key.0));
            }
        }
        for ((id, to_device, priority), (count, first, _)) in &self.mixed {
            let (id, to_device, first) = (*id, *to_device, *first);
            let Some(ar) = of(ars, id) else { continue };
            // Who acknowledges may copy the priorities of the alarm.
            let is_answer = self.mixed.contains_key(&(id, !to_device, *priority));
            let (frame, block, blame) = match (priority, to_device) {
                (AlarmPriority::High, true) if is_answer => ("high", "low", CaptureBlame::Undecided),
                (AlarmPriority::High, true) => ("high", "low", CaptureBlame::Controller),
                (AlarmPriority::High, false) => ("high", "low", CaptureBlame::Device),
                // A connection may have low alarms only, and what its blocks then say is not printed.
                (AlarmPriority::Low, _) => ("low", "high", CaptureBlame::Undecided),
            };
            let direction = if to_device { FrameDirection::ToDevice } else { FrameDirection::ToController };
            let what = if to_device { "acknowledgement" } else { "alarm" };
            let text = format!(
                "{} sends {count} {what}{} with the frame ID of {frame} and the block of {block} priority",
                sender(ar, direction),
                if *count == 1 { "" } else { "s" }
            );
            findings.add(ALARM_PRIORITY.finding(FindingSeverity::Warning, blame, first, text).ar(id));
        }
        for ((id, to_device), (count, first, last, again)) in self.unacknowledged {
            let Some(ar) = of(ars, id) else { continue };
            let (own, other) = if to_device {
                (FrameDirection::ToDevice, FrameDirection::ToController)
            } else {
                (FrameDirection::ToController, FrameDirection::ToDevice)
            };
            let ends = |direction| match direction {
                FrameDirection::ToController => (ar.device.mac(), ar.controller.mac()),
                FrameDirection::ToDevice => (ar.controller.mac(), ar.device.mac()),
            };
            let (source, destination) = ends(other);
            if !sight.shows(source, destination) {
                continue;
            }
            let blame = if to_device { CaptureBlame::Device } else { CaptureBlame::Controller };
            let what = if to_device { "acknowledgement of an alarm" } else { "alarm" };
            let again = if again > 0 { format!(", repeated {again} times") } else { String::new() };
            let text = format!(
                "{} did not acknowledge the {what} from {}{again}{}",
                sender(ar, other),
                sender(ar, own),
                times(count, last)
            );
            findings.add(
                ALARM_UNACKNOWLEDGED.finding(FindingSeverity::Error, blame, first, text).ar(id).expected("RTA ACK"),
            );
        }
        // What one answer reports is one finding.
        let mut answers: BTreeMap<_, Vec<(DiagnosisAddress, ReadDiagnosis)>> = BTreeMap::new();
        for (address, read) in self.read {
            answers.entry((address.0, read.first, read.last, read.count)).or_default().push((address, read));
        }
        for diagnoses in answers.into_values() {
            let line = |((_, slot, subslot, ..), read): &(DiagnosisAddress, ReadDiagnosis)| {
                format!("slot {slot} subslot 0x{subslot:04X}: {}", read.text)
            };
            let lines: Vec<String> = diagnoses.iter().map(line).collect();
            let Some(((station, .., error), read)) = diagnoses.into_iter().next() else { continue };
            let who = read.ar.and_then(|ar| of(ars, ar)).map(|ar| sender(ar, FrameDirection::ToController));
            let (what, details) = match &lines[..] {
                [one] => (format!("a diagnosis for {one}"), Vec::new()),
                several => (format!("{} diagnoses", several.len()), lines),
            };
            let text = format!(
                "{} reports {what}; read from record 0x{:04X}{}",
                who.unwrap_or_else(|| format!("device {station}")),
                read.index,
                times(read.count, read.last)
            );
            let finding = ALARM_DIAGNOSIS.finding(FindingSeverity::Warning, blame(error), read.first, text);
            let finding = advised(finding, of_channel(error)).details(details);
            findings.add(match read.ar {
                Some(ar) => finding.ar(ar),
                None => finding,
            });
        }
        for ((id, slot, subslot, _, error), (count, first, gone, what)) in self.faults {
            let Some(ar) = of(ars, id) else { continue };
            let (severity, until) = match gone {
                Some(frame) => (FindingSeverity::Info, format!("cleared in frame {frame}")),
                None => (FindingSeverity::Warning, "still pending at the end of the capture".to_owned()),
            };
            let text = format!(
                "{} reports a fault at slot {slot} subslot 0x{subslot:04X}: {what}{}; {until}",
                sender(ar, FrameDirection::ToController),
                if count > 1 { format!(", {count} times") } else { String::new() }
            );
            let advice = match error & OF_ALARM {
                OF_ALARM => of_alarm(AlarmType(error & !OF_ALARM)).map(|(_, cause, next)| (cause, next)),
                _ => of_channel(error),
            };
            findings.add(advised(ALARM_DIAGNOSIS.finding(severity, blame(error), first, text), advice).ar(id));
        }
    }
}

/// The error type, severity and channel in words.
fn words(channel: &ChannelDiagnosis) -> String {
    let error = channel.error_type;
    let word = error.word().map_or_else(|| format!("error 0x{:04X}", error.0), |word| word.replace('_', " "));
    format!("{word} ({}), channel 0x{:04X}", channel.properties.severity().word(), channel.channel)
}

/// The party to blame for an error type.
fn blame(error: u16) -> CaptureBlame {
    if OF_THE_NETWORK.contains(&error) { CaptureBlame::Network } else { CaptureBlame::Device }
}

impl AlarmCheck {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.sent.retain(|key, _| settled.keeps(key.0));
        self.faults
            .retain(|key, (.., gone, _)| settled.keeps(key.0) && gone.is_none_or(|gone| gone > settled.reported));
        self.read.retain(|_, read| read.last > settled.reported);
        self.mixed.retain(|key, (.., last)| settled.keeps(key.0) && *last > settled.reported);
        self.unacknowledged.retain(|key, (_, _, last, _)| settled.keeps(key.0) && *last > settled.reported);
        let is_forgotten = |ar: Option<ArId>| ar.is_some_and(|ar| !settled.keeps(ar));
        self.read.values_mut().filter(|read| is_forgotten(read.ar)).for_each(|read| read.ar = None);
    }
}
