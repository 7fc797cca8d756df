//! A capture held against a device: heard, driven again, compared.

use super::ask::Ask;
use super::compare::compare;
use super::drive::{Bench, CannotDrive};
use super::heard::Conversation;
use super::infer::{Shaft, shaft};
use super::listen::{Ear, Whom};
use super::masks::Masks;
use super::report::{AgainstReport, DifferenceReport, LeftOutReport};
use super::script::script;
use crate::engine::DutSpec;
use crate::suite::device::Bus;
use bench::CaptureReader;
use bench::capture::{Item, LinkType, NotACapture};
use station::Time;
use std::io::Read;

/// What was heard in a capture, and when its first frame came.
#[derive(Clone, Debug)]
pub struct Heard {
    /// What was said between the controller and the device.
    pub said: Conversation,
    /// The time of the first frame.
    pub begin: Time,
}

/// Listens to a capture, pcap or pcapng; of several devices the first one that speaks as the manual has it is followed.
///
/// An error says that `input` is no capture; damage further on is passed over, and what could be read is what was heard.
pub fn hear(input: impl Read, whom: Whom<'_>) -> Result<Heard, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut ear = Ear::new(whom);
    let mut begin = None;
    while let Some(item) = reader.next() {
        let Item::Packet(packet) = item else { continue };
        begin.get_or_insert(packet.time);
        let bus = match packet.link_type {
            LinkType::ETHERNET => Bus::Profinet,
            LinkType::PROFIBUS => Bus::Profibus,
            LinkType(_) => continue,
        };
        if bus == whom.manual.device.bus {
            ear.frame(packet.number as u64, packet.time, packet.captured);
        }
    }
    Ok(Heard { said: ear.end(), begin: begin.unwrap_or_default() })
}

/// Why a conversation cannot be driven again; none where it can.
pub fn nothing_to_drive(said: &Conversation) -> Option<String> {
    if said.asked.iter().any(|asked| matches!(asked.ask, Ask::Connect(_))) {
        return None;
    }
    Some(match said.asked.is_empty() && said.left_out.is_empty() {
        true => "the capture has no controller that speaks to a device of this manual".to_owned(),
        false => "the capture does not have the start-up of the connection, so it cannot be made again".to_owned(),
    })
}

/// Drives a device with the controller side of what was heard, and compares its answers with the recorded ones.
pub fn hold(bench: &Bench<'_>, dut: &DutSpec, heard: &Heard, masks: &Masks) -> Result<AgainstReport, CannotDrive> {
    let mut report = AgainstReport {
        against: dut.to_string(),
        left_out: heard.said.left_out.iter().map(LeftOutReport::from).collect(),
        inconclusive: nothing_to_drive(&heard.said),
        ..AgainstReport::default()
    };
    if report.inconclusive.is_some() {
        report.masked = masks.names.clone();
        return Ok(report);
    }
    let mut steps = script(&heard.said);
    report.steps = steps.len();
    let shaft = match dut.live() {
        Some(_) => Shaft { ask: None, text: "unknown: a live device stands where it stands".to_owned(), name: None },
        None => shaft(bench, dut, &heard.said, &steps)?,
    };
    let mut masks = masks.clone();
    if shaft.ask.is_none() {
        let places = heard.said.tracks.iter().filter(|(_, track)| track.is_place);
        masks.names.extend(places.map(|(name, _)| (name.clone(), "the place of the shaft is unknown".to_owned())));
    }
    steps.splice(0..0, shaft.ask);
    let ours = bench.drive(&steps, dut)?;
    let found = compare(&heard.said, &ours, &masks);
    let whom = bench.whom();
    report.differences =
        found.iter().map(|of| DifferenceReport::new(whom.manual, whom.variant, heard.begin, of)).collect();
    report.shaft = shaft.text;
    report.masked = masks.names;
    Ok(report)
}
