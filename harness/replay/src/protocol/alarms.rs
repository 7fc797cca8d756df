//! Alarms: which were not acknowledged, which were refused, and which faults still stand, or stand in a record that was read.

use super::sight::{Now, Sight, Told};
use super::table::{ALARM_DIAGNOSIS, ALARM_REFUSED, ALARM_UNACKNOWLEDGED};
use super::words::{of, sender, span, status, times};
use crate::finding::{Blame, Severity};
use judge::observe::{Ar, ArId, CallPart, Direction, Observation, Traffic};
use station::Duration;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use wire::ethernet::Mac;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmType, RtaKind};
use wire::profinet::diagnosis::{Change, ChannelDiagnosis, DiagnosisData};

/// The transport acknowledges within so long, repetitions included.
const TRANSPORT: Duration = Duration::from_secs(2);
/// The application of the controller acknowledges within so long.
const APPLICATION: Duration = Duration::from_secs(10);
/// Alarms and faults that are remembered.
const MOST: usize = 4_096;

/// An alarm on its way.
#[derive(Clone, Copy, Debug)]
struct Sent {
    first: Now,
    last: Now,
    sequence: u16,
    again: u32,
    acknowledged: bool,
    answered: bool,
    /// Whether it is an alarm, and not the acknowledgement of one.
    is_alarm: bool,
}

/// Where a fault is: slot, subslot, channel, error.
type Place = (ArId, u16, u16, u16, u16);

/// Where a diagnosis stands in a record: who tells it, slot, subslot, channel, error.
type Written = (Mac, u16, u16, u16, u16);

/// A diagnosis that was read: how often, the first and the last frame, the record, the connection, in words.
#[derive(Debug)]
struct Read {
    count: u64,
    first: u64,
    last: u64,
    index: u16,
    ar: Option<ArId>,
    text: String,
}

/// The records whose contents are diagnoses: of a subslot, a slot, an AR, an API, a device; see [`DiagnosisData`].
const RECORDS: [u16; 13] =
    [0x800A, 0x800B, 0x800C, 0xC00A, 0xC00B, 0xC00C, 0xE00A, 0xE00B, 0xE00C, 0xF00A, 0xF00B, 0xF00C, 0xF80C];
/// What a device reports of its link, its neighbours or its clock, which others may be to blame for.
const OF_THE_NETWORK: RangeInclusive<u16> = 0x8000..=0x800F;

/// The alarms of a capture.
#[derive(Debug, Default)]
pub(super) struct Alarms {
    sent: BTreeMap<(ArId, AlarmPriority, bool), Sent>,
    faults: BTreeMap<Place, (u64, u64, Option<u64>, String)>,
    /// Who sent the last answer to a call.
    answers: Option<Mac>,
    read: BTreeMap<Written, Read>,
    unacknowledged: BTreeMap<(ArId, bool), (u64, u64, u64, u32)>,
}

impl Alarms {
    pub fn observe(&mut self, now: Now, ars: &[Ar], observation: &Observation<'_>, told: &mut Told) {
        match observation {
            Observation::Traffic(Traffic::Rta { ar, direction, priority, kind, sequence, acknowledges, again }) => {
                let to_device = *direction == Direction::ToDevice;
                if *kind == RtaKind::DATA || *kind == RtaKind::ACK {
                    // Who sends anything on the channel says what he has received so far.
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
                            let sent = Sent { first, last, sequence, again: 0, acknowledged, answered, is_alarm };
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
                self.record(now, *ar, *index, data, told);
            }
            Observation::AlarmAcknowledged { ar: id, status: code } => {
                for priority in [AlarmPriority::Low, AlarmPriority::High] {
                    if let Some(sent) = self.sent.get_mut(&(*id, priority, false)) {
                        sent.answered = true;
                    }
                }
                if let Some(ar) = of(ars, *id).filter(|_| !code.is_ok()) {
                    let text = format!("{} refuses an alarm: {}", sender(ar, Direction::ToDevice), status(code));
                    told.add(ALARM_REFUSED.finding(Severity::Warning, Blame::Controller, now.frame, text).ar(*id));
                }
            }
            // What is open then is not waited for any more.
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

    /// The next DATA came, or the connection ended: the one before had its time.
    fn missed(&mut self, (ar, _, to_device): (ArId, AlarmPriority, bool), sent: Sent) {
        // Who misses an acknowledgement repeats; else the capture has lost it.
        if !sent.acknowledged && sent.again > 0 && self.unacknowledged.len() < MOST {
            let of = self.unacknowledged.entry((ar, to_device)).or_insert((0, sent.first.frame, 0, 0));
            (of.0, of.2, of.3) = (of.0 + 1, sent.first.frame, of.3.max(sent.again));
        }
    }

    /// Takes in a record of diagnoses.
    fn record(&mut self, now: Now, ar: Option<ArId>, index: u16, data: &[u8], told: &mut Told) {
        let (Some(station), Ok(blocks)) = (self.answers, DiagnosisData::parse_record(data)) else { return };
        for block in &blocks {
            for channel in block.item.channels() {
                let key = (station, block.slot, block.subslot, channel.channel, channel.error_type.0);
                if self.read.len() >= MOST && !self.read.contains_key(&key) {
                    continue;
                }
                let (first, last, text) = (now.frame, now.frame, words(&channel));
                let read = self.read.entry(key).or_insert(Read { count: 0, first, last, index, ar, text });
                if read.count == 0 {
                    told.note(now.frame);
                }
                (read.count, read.last) = (read.count + 1, now.frame);
            }
        }
    }

    fn alarm(&mut self, now: Now, ar: ArId, alarm: &AlarmNotification) {
        if alarm.alarm_type == AlarmType::PULL && self.faults.len() < MOST {
            let place = (ar, alarm.slot, alarm.subslot, 0, 0);
            self.faults.entry(place).or_insert((0, now.frame, None, "module pulled".to_owned())).0 += 1;
        }
        if alarm.alarm_type == AlarmType::PLUG {
            let place = (ar, alarm.slot, alarm.subslot, 0, 0);
            if let Some(fault) = self.faults.get_mut(&place) {
                fault.2 = Some(now.frame);
            }
        }
        for channel in alarm.items.iter().flat_map(|item| item.channels()) {
            let place = (ar, alarm.slot, alarm.subslot, channel.channel, channel.error_type.0);
            match channel.properties.change() {
                Change::Appears if self.faults.len() < MOST => {
                    let fault = self.faults.entry(place).or_insert((0, now.frame, None, words(&channel)));
                    (fault.0, fault.2) = (fault.0 + 1, None);
                }
                Change::Appears => {}
                _ => {
                    if let Some(fault) = self.faults.get_mut(&place) {
                        fault.2 = Some(now.frame);
                    }
                }
            }
        }
    }

    pub fn end(mut self, sight: &Sight, ars: &[Ar], told: &mut Told) {
        let now = sight.now;
        for (key, sent) in std::mem::take(&mut self.sent) {
            let Some(ar) = of(ars, key.0) else { continue };
            let waited = now.since(sent.last).unwrap_or_default();
            if !sent.acknowledged && waited >= TRANSPORT {
                self.missed(key, sent);
            } else if sent.is_alarm && sent.acknowledged && !sent.answered && waited >= APPLICATION && ar.stage.stands()
            {
                let text = format!(
                    "{} took the alarm but its application did not acknowledge it in the {} up to the end of the capture",
                    sender(ar, Direction::ToDevice),
                    span(waited)
                );
                let finding = ALARM_UNACKNOWLEDGED.finding(Severity::Info, Blame::Controller, sent.first.frame, text);
                told.add(finding.ar(key.0));
            }
        }
        for ((id, to_device), (count, first, last, again)) in self.unacknowledged {
            let Some(ar) = of(ars, id) else { continue };
            let (own, other) = match to_device {
                true => (Direction::ToDevice, Direction::ToController),
                false => (Direction::ToController, Direction::ToDevice),
            };
            let ends = |direction| match direction {
                Direction::ToController => (ar.device.mac(), ar.controller.mac()),
                Direction::ToDevice => (ar.controller.mac(), ar.device.mac()),
            };
            let (source, destination) = ends(other);
            if !sight.shows(source, destination) {
                continue;
            }
            let blame = if to_device { Blame::Device } else { Blame::Controller };
            let what = if to_device { "acknowledgement of an alarm" } else { "alarm" };
            let again = if again > 0 { format!(", repeated {again} times") } else { String::new() };
            let text = format!(
                "{} does not acknowledge the {what} of {}{again}{}",
                sender(ar, other),
                sender(ar, own),
                times(count, last)
            );
            told.add(ALARM_UNACKNOWLEDGED.finding(Severity::Error, blame, first, text).ar(id).expected("RTA ACK"));
        }
        for ((station, slot, subslot, _, error), read) in self.read {
            let who = read.ar.and_then(|ar| of(ars, ar)).map(|ar| sender(ar, Direction::ToController));
            let text = format!(
                "{} has a diagnosis for slot {slot} subslot 0x{subslot:04X}: {}, as record 0x{:04X} tells{}",
                who.unwrap_or_else(|| format!("device {station}")),
                read.text,
                read.index,
                times(read.count, read.last)
            );
            let finding = ALARM_DIAGNOSIS.finding(Severity::Warning, blame(error), read.first, text);
            told.add(match read.ar {
                Some(ar) => finding.ar(ar),
                None => finding,
            });
        }
        for ((id, slot, subslot, _, error), (count, first, gone, what)) in self.faults {
            let Some(ar) = of(ars, id) else { continue };
            let (severity, until) = match gone {
                Some(frame) => (Severity::Info, format!("it went in frame {frame}")),
                None => (Severity::Warning, "it still stands at the end of the capture".to_owned()),
            };
            let text = format!(
                "{} reports for slot {slot} subslot 0x{subslot:04X}: {what}{}; {until}",
                sender(ar, Direction::ToController),
                if count > 1 { format!(", {count} times") } else { String::new() }
            );
            told.add(ALARM_DIAGNOSIS.finding(severity, blame(error), first, text).ar(id));
        }
    }
}

/// What is wrong with a channel.
fn words(channel: &ChannelDiagnosis) -> String {
    let error = channel.error_type;
    let word = error.word().map_or_else(|| format!("error 0x{:04X}", error.0), |word| word.replace('_', " "));
    format!("{word} ({}), channel 0x{:04X}", channel.properties.severity().word(), channel.channel)
}

/// Who is to blame for an error of a channel.
fn blame(error: u16) -> Blame {
    if OF_THE_NETWORK.contains(&error) { Blame::Network } else { Blame::Device }
}
