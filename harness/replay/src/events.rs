//! The events of a capture in words: one entry for each, with an upper limit for each kind.

use super::clock::{CaptureClock, wall_clock};
use super::dcp::StationNames;
use super::decode::Decoder;
use super::read::reassembly::LostDatagram;
use super::report::{CaptureEvent, EventKind};
use judge::observe::{
    Address, ArId, ArStage, Dp, DpTracker, FrameDirection, Leaving, Observation, ObservedAr, Party, Role, Tracker,
};
use station::{Duration, Time};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use suite::model::Manual;
use wire::profibus::fdl::BROADCAST;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority};
use wire::profinet::status::PnioStatus;

/// Upper limit of the events of one kind that are listed one by one.
const MOST_OF_A_KIND: u64 = 1_000;
/// Upper limit of the unreadable frames that are listed one by one; later ones add little.
const MOST_UNREADABLE: u64 = 20;

/// The events so far.
#[derive(Debug, Default)]
pub(super) struct Events<'a> {
    decoder: Decoder<'a>,
    /// The ident number and the last diagnosis of each slave.
    slaves: BTreeMap<u8, (Option<u16>, Vec<u8>)>,
    list: Vec<CaptureEvent>,
    /// How many events of each kind there were, and the last one that is not listed: its frame and time.
    kinds: BTreeMap<EventKind, EventCount>,
    stations: StationNames,
    clock: CaptureClock,
    now: (u64, Time),
    cut: Option<(usize, u32)>,
}

#[derive(Clone, Copy, Debug, Default)]
struct EventCount {
    seen: u64,
    left_out: u64,
    last: (u64, Time),
}

impl<'a> Events<'a> {
    /// No events yet; `manuals` give the words for what slaves receive and report.
    pub fn new(manuals: &'a [Manual]) -> Events<'a> {
        Events { decoder: Decoder::new(manuals), ..Events::default() }
    }

    /// A frame begins; if the capture kept only a part of it, `cut` has the number of bytes kept and of all bytes.
    pub fn begin(&mut self, number: u64, time: Time, cut: Option<(usize, u32)>) {
        self.clock.take(time);
        self.now = (number, time);
        self.cut = cut;
    }

    /// A packet that is not an Ethernet frame.
    pub fn other_link(&mut self, number: u64, time: Time, link: u16) {
        self.begin(number, time, None);
        if !self.kinds.contains_key(&EventKind::OtherLink) {
            self.add(
                EventKind::OtherLink,
                format!(
                    "packets of link type {link}{} are not Ethernet frames and are not read; capture at an Ethernet interface",
                    link_word(link)
                ),
            );
        }
    }

    /// A datagram that cannot be reassembled: an event of the last frame with a fragment of it.
    pub fn lost(&mut self, datagram: &LostDatagram) {
        self.now = (datagram.frame, datagram.time);
        self.add(EventKind::Unreadable, datagram.why.clone());
    }

    /// Takes in an observation of a tracker.
    pub fn observe(&mut self, ars: &[ObservedAr], observation: &Observation<'_>) {
        let ar = |id: &ArId| ars.get(id.0 as usize);
        match observation {
            Observation::Cyclic { .. }
            | Observation::Lldp { .. }
            | Observation::Traffic(_)
            | Observation::Gap { .. } => {}
            Observation::Dp { ar: id, event } => self.slave(id.as_ref().and_then(ar), event),
            Observation::Connected { ar: id } => {
                if let Some(ar) = ar(id) {
                    self.add(EventKind::Connect, connected(ar));
                }
            }
            Observation::ConnectRefused { ar: id, status } => {
                let text = format!(
                    "the connection request of {} is refused by {}: {}",
                    who(ar(id), FrameDirection::ToDevice),
                    device(ar(id)),
                    words(status)
                );
                self.add(EventKind::ConnectRefused, text);
            }
            Observation::Record { written, target: (_, slot, subslot, index), status, ar: id, .. }
                if !status.is_ok() =>
            {
                let (kind, verb) =
                    if *written { (EventKind::WriteRefused, "to write") } else { (EventKind::ReadRefused, "to read") };
                let by = id.as_ref().map_or_else(|| "the device".to_owned(), |id| device(ar(id)));
                let record = format!("record 0x{index:04X} of slot {slot} subslot 0x{subslot:04X}");
                self.add(kind, format!("{by} refuses {verb} {record}: {}", words(status)));
            }
            Observation::Record { .. } | Observation::RecordRequested { .. } => {}
            Observation::ParameterEnd { ar: id } => {
                self.add(EventKind::ParameterEnd, format!("{} accepted the end of the parameters", device(ar(id))));
            }
            Observation::ApplicationReady { ar: id } => {
                self.add(EventKind::ApplicationReady, format!("{} reports ApplicationReady", device(ar(id))));
            }
            Observation::PlugReady { ar: id, alarm } => {
                let text = format!("{} reports that the submodule of alarm {alarm} is ready", device(ar(id)));
                self.add(EventKind::ApplicationReady, text);
            }
            Observation::Alarm { ar: id, priority, notification } => {
                self.add(EventKind::Alarm, alarm(ar(id), *priority, notification));
            }
            Observation::AlarmAcknowledged { ar: id, status } if !status.is_ok() => {
                let text = format!("{} refuses an alarm: {}", who(ar(id), FrameDirection::ToDevice), words(status));
                self.add(EventKind::AlarmRefused, text);
            }
            Observation::AlarmAcknowledged { .. } => {}
            Observation::CallFailed { ar: id, service, why } => {
                let by = id.as_ref().map_or_else(|| "the other side".to_owned(), |id| device(ar(id)));
                self.add(EventKind::CallFailed, format!("{service} failed at {by}: {why}"));
            }
            Observation::Aborted { ar: id, direction, status } => {
                let text = format!("{} ends the connection: {}", who(ar(id), *direction), words(status));
                self.add(EventKind::Abort, text);
            }
            Observation::Released { ar: id } => {
                let text =
                    format!("{} releases the connection to {}", who(ar(id), FrameDirection::ToDevice), device(ar(id)));
                self.add(EventKind::Release, text);
            }
            Observation::Starved { ar: id, direction } => {
                let watchdog = ar(id).map_or(Duration::ZERO, |ar| ar.stream(*direction).watchdog);
                let text = format!(
                    "{} sent no frame for longer than its watchdog of {}",
                    who(ar(id), *direction),
                    span(watchdog)
                );
                self.add(EventKind::Starved, text);
            }
            Observation::Dcp { source, destination, pdu } => {
                for (kind, text) in self.stations.observe(*source, *destination, pdu) {
                    self.add(kind, text);
                }
            }
            Observation::Unreadable { why } => {
                let mut text = (*why).to_owned();
                if let Some((kept, whole)) = self.cut {
                    let _ = write!(text, " (the capture kept {kept} of its {whole} bytes)");
                }
                self.add(EventKind::Unreadable, text);
            }
        }
    }

    /// Events of PROFIBUS only.
    fn slave(&mut self, ar: Option<&ObservedAr>, event: &Dp<'_>) {
        match *event {
            Dp::Parameters { master, station, octets } => {
                let ident = octets.get(4..6).map(|ident| u16::from_be_bytes([ident[0], ident[1]]));
                self.slaves.entry(station).or_default().0 = ident;
                let said = self.decoder.parameters(octets);
                self.add(
                    EventKind::SetPrm,
                    format!("station {station} accepts parameters from master {master}: {said}"),
                );
            }
            Dp::Configuration { master, station, octets } => {
                let ident = self.slaves.get(&station).and_then(|(ident, _)| *ident);
                let said = self.decoder.configuration(ident, octets);
                let text = format!("station {station} accepts a configuration from master {master}: {said}");
                self.add(EventKind::ChkCfg, text);
            }
            Dp::Diagnosis { station, octets, .. } => {
                let known = self.slaves.entry(station).or_default();
                if known.1 != octets {
                    known.1 = octets.to_vec();
                    let said = self.decoder.diagnosis(octets);
                    self.add(EventKind::Diagnosis, format!("station {station} reports the diagnosis {said}"));
                }
            }
            Dp::AddressGiven { master, station, address, ident } => {
                let text =
                    format!("station {station} takes the address {address} from master {master}, ident 0x{ident:04X}");
                self.add(EventKind::SlaveAddress, text);
            }
            // The clock of isochronous mode is a Global_Control without a command.
            Dp::Control { control, .. } if control.command.0 == 0 => {}
            Dp::Control { master, station, control } => {
                let words: Vec<&str> = control.command.words().collect();
                let to = if station == BROADCAST { "all".to_owned() } else { format!("station {station}") };
                let groups =
                    if control.groups == 0 { String::new() } else { format!(", groups 0x{:02X}", control.groups) };
                let text = format!("master {master} commands {to}: {}{groups}", words.join(" "));
                self.add(EventKind::GlobalControl, text);
            }
            Dp::Left { why } => {
                let why = match why {
                    Leaving::NoService => "it answers Data_Exchange with `no service`",
                    Leaving::Diagnosis => "its diagnosis shows it",
                };
                self.add(EventKind::Left, format!("{} has left its master: {why}", device(ar)));
            }
        }
    }

    fn add(&mut self, kind: EventKind, text: String) {
        let most = if kind == EventKind::Unreadable { MOST_UNREADABLE } else { MOST_OF_A_KIND };
        let of = self.kinds.entry(kind).or_default();
        of.seen += 1;
        if of.seen > most {
            of.left_out += 1;
            of.last = self.now;
            return;
        }
        let (frame, time) = self.now;
        self.list.push(event(&self.clock, (frame, time), kind, text));
    }

    /// All events by frame.
    pub fn end(mut self, tracker: &Tracker, slaves: &DpTracker) -> Vec<CaptureEvent> {
        for ar in tracker.ars().iter().filter(|ar| ar.stage == ArStage::Asked) {
            let (Some(frame), Some(time)) = (ar.connect_frame, ar.connect_time) else { continue };
            // A controller that goes on has received an answer, whether the capture shows it or not. At the end of the capture it is open.
            let text = format!(
                "the capture has no answer to the connection request of {} to {}",
                name(&ar.controller),
                name(&ar.device)
            );
            self.now = (frame, time);
            self.add(EventKind::ConnectUnanswered, text);
        }
        for stray in tracker.strays() {
            let text = format!(
                "{} cyclic frames 0x{:04X} from {} to {} belong to no connection whose start-up is in the capture",
                stray.frames, stray.frame_id, stray.source, stray.destination
            );
            self.now = (stray.first_frame, stray.first_time);
            self.add(EventKind::Unassigned, text);
        }
        let strays = slaves.counts().strays;
        if strays > 0 {
            let text = format!("{strays} answers of Data_Exchange belong to no known connection");
            self.add(EventKind::Unassigned, text);
        }
        for (kind, of) in self.kinds.iter().filter(|(_, of)| of.left_out > 0) {
            let text = format!("{} more events of this kind up to here", of.left_out);
            self.list.push(event(&self.clock, of.last, *kind, text));
        }
        self.list.sort_by_key(|event| event.frame);
        self.list
    }
}

fn event(clock: &CaptureClock, (frame, time): (u64, Time), kind: EventKind, text: String) -> CaptureEvent {
    CaptureEvent { frame, time: clock.seconds(time), wall_clock: wall_clock(time), kind, text }
}

/// The link types that are often captured by mistake.
fn link_word(link: u16) -> &'static str {
    match link {
        0 => " (loopback)",
        101 | 228 | 229 => " (IP without Ethernet)",
        105 | 127 => " (wireless LAN)",
        113 | 276 => " (Linux cooked, as of the interface `any`)",
        189 | 220 | 249 => " (USB)",
        _ => "",
    }
}

/// The sender of a direction.
fn who(ar: Option<&ObservedAr>, direction: FrameDirection) -> String {
    match direction {
        FrameDirection::ToDevice => ar.map_or_else(
            || "the controller".to_owned(),
            |ar| match ar.controller.address {
                Address::Mac(_) => format!("controller {}", name(&ar.controller)),
                Address::Fdl(_) => format!("master {}", name(&ar.controller)),
            },
        ),
        FrameDirection::ToController => device(ar),
    }
}

fn device(ar: Option<&ObservedAr>) -> String {
    ar.map_or_else(|| "the device".to_owned(), |ar| format!("device {}", name(&ar.device)))
}

fn name(party: &Party) -> String {
    match &party.station {
        Some(station) => format!("'{station}' ({})", party.address),
        None => party.address.to_string(),
    }
}

fn connected(ar: &ObservedAr) -> String {
    let mut text = format!("{} is connected to {}", who(Some(ar), FrameDirection::ToDevice), device(Some(ar)));
    if ar.connect_frame.is_none() && ar.slave.is_none() {
        text.push_str(" since before the capture began");
    }
    match ar.role {
        Role::Access => text.push_str(" for access to records"),
        Role::Exchange if ar.slave.is_some() => {
            let _ = write!(
                text,
                ": {} bytes out, {} in, watchdog {}",
                ar.outputs.data_length,
                ar.inputs.data_length,
                if ar.outputs.watchdog.is_zero() { "off".to_owned() } else { span(ar.outputs.watchdog) }
            );
        }
        Role::Exchange => {
            let _ = write!(
                text,
                ": {} submodules, every {} in (0x{:04X}) and {} out (0x{:04X}), watchdog {}",
                ar.submodules.len(),
                span(ar.inputs.cycle),
                ar.inputs.frame_id,
                span(ar.outputs.cycle),
                ar.outputs.frame_id,
                span(ar.outputs.watchdog),
            );
        }
    }
    text
}

fn alarm(ar: Option<&ObservedAr>, priority: AlarmPriority, alarm: &AlarmNotification) -> String {
    let kind = alarm.alarm_type.word().map_or_else(|| format!("0x{:04X}", alarm.alarm_type.0), str::to_owned);
    let priority = match priority {
        AlarmPriority::Low => "low",
        AlarmPriority::High => "high",
    };
    let mut text = format!(
        "{} sends the {priority} alarm {kind} for slot {} subslot 0x{:04X}",
        device(ar),
        alarm.slot,
        alarm.subslot
    );
    for channel in alarm.items.iter().flat_map(|item| item.channels()) {
        let error = channel.error_type.word().map_or_else(|| format!("0x{:04X}", channel.error_type.0), str::to_owned);
        let (severity, change) = (channel.properties.severity().word(), channel.properties.change().word());
        let _ = write!(text, ", channel 0x{:04X}: {error} ({severity}, {change})", channel.channel);
    }
    text
}

/// A PNIO status as a sentence with its numbers.
fn words(status: &PnioStatus) -> String {
    match status.sentence() {
        Some(sentence) => format!("{} [{status}]", sentence.trim_end_matches('.')),
        None => status.to_string(),
    }
}

/// A duration as `8 ms` or `31.25 us`.
pub(super) fn span(duration: Duration) -> String {
    let nanos = duration.as_nanos();
    match nanos {
        0..1_000_000 => format!("{} us", nanos as f64 / 1e3),
        _ => format!("{} ms", nanos as f64 / 1e6),
    }
}
