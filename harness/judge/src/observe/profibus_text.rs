//! Formats PROFIBUS frames as text: one line for the frame and indented lines for its contents.
//!
//! Device-specific data are shown as bytes. An unreadable frame gets a line with the error and its position.

use super::describe::hex;
use super::dp::watchdog_base_ms;
use super::dp_services::{DpServices, LastDpRequest, service_word};
use std::fmt::Write as _;
use wire::WireError;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::cfg::{Identifier, Length, ManufacturerData, io_lengths};
use wire::profibus::diag::{
    DiagnosisBlock, DiagnosisMessage, NO_MASTER, SlaveDiag, Specifier, SpecifierChange, identifiers,
};
use wire::profibus::dpv1::{Dpv1Pdu, Dpv1Record, InitiateFeatures, PduDirection};
use wire::profibus::fdl::{DataFrame, Extension, FdlFormat, FdlFrame, FrameCount};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::{Dpv1Status1, Dpv1Status3, Isochronous, PrmBlock, PrmBlockType, SetPrm};
use wire::profibus::sap::{SapService, SlaveSap};

/// Formats the frames of one bus as text. It stores the last request, since some answers do not contain their service.
#[derive(Clone, Debug, Default)]
pub struct ProfibusWords {
    services: DpServices,
}

/// The lines of one frame.
#[derive(Default)]
struct Lines(Vec<String>);

impl Lines {
    fn say(&mut self, line: impl Into<String>) {
        self.0.push(line.into());
    }

    fn octets(&mut self, what: &str, octets: &[u8]) {
        if !octets.is_empty() {
            self.say(format!("{what} {}", hex(octets)));
        }
    }

    fn damage(&mut self, error: &WireError, octets: &[u8]) {
        self.say(format!("damaged: {error}"));
        self.octets("bytes", octets);
    }
}

impl ProfibusWords {
    /// The lines of the next frame on the bus: the frame, then its contents.
    pub fn lines(&mut self, octets: &[u8]) -> Vec<String> {
        let mut lines = Lines::default();
        match FdlFrame::parse(octets) {
            Err(error) => lines.damage(&error, octets),
            Ok(FdlFrame::Token { da, sa }) => lines.say(format!("{sa} -> {da} token")),
            Ok(FdlFrame::ShortAcknowledgement) => match self.services.acknowledged() {
                Some(LastDpRequest { da, sa, service }) => {
                    lines.say(format!("{da} -> {sa} {} short acknowledgement", service_word(service)));
                }
                None => lines.say("short acknowledgement"),
            },
            Ok(FdlFrame::Data(frame)) => self.data_frame(&frame, &mut lines),
        }
        lines.0
    }

    fn data_frame(&mut self, frame: &DataFrame<'_>, lines: &mut Lines) {
        let service = self.services.of(frame);
        let DataFrame { da, sa, fc, .. } = *frame;
        let mut line = format!("{sa} -> {da} ");
        if service != SapService::BareAnswer {
            let _ = write!(line, "{} ", service_word(service));
        }
        let known = |word: Option<&str>, number: u8| word.map_or_else(|| format!("{number:#04x}"), str::to_owned);
        if let (Some(function), Some(count)) = (fc.requested(), fc.count()) {
            let count = match count {
                FrameCount::Unused => "",
                FrameCount::First => ", first count",
                FrameCount::Zero => ", count 0",
                FrameCount::One => ", count 1",
            };
            let _ = write!(line, "request ({}{count})", known(function.word(), function.0));
        } else if let (Some(function), Some(station)) = (fc.answered(), fc.station()) {
            let _ =
                write!(line, "answer ({}, {})", known(function.word(), function.0), known(station.word(), station.0));
        }
        let segments = [(frame.destination, "to"), (frame.source, "from")];
        for (Extension { segment, sap }, word) in segments {
            let parts = [("segment", segment), ("SAP", sap)];
            let shown = parts.into_iter().filter_map(|(name, number)| Some(format!("{name} {}", number?)));
            let shown = shown.collect::<Vec<_>>().join(" ");
            if !shown.is_empty() {
                let _ = write!(line, " {word} {shown}");
            }
        }
        lines.say(line);
        if let Err(error) = carried(service, frame, lines) {
            let head = match frame.format {
                FdlFormat::Variable => 7,
                FdlFormat::NoData | FdlFormat::EightOctets => 4,
            };
            let error = error.at_offset(head + frame.destination.length() + frame.source.length());
            lines.damage(&error, frame.data);
        }
    }
}

/// Formats the data of a frame; offsets in errors are counted from the first byte of data.
fn carried(service: SapService, frame: &DataFrame<'_>, lines: &mut Lines) -> Result<(), WireError> {
    let (data, is_request) = (frame.data, frame.fc.is_request());
    if data.is_empty() {
        return Ok(());
    }
    match service {
        SapService::Slave(SlaveSap::SET_PRM) if is_request => set_prm(&SetPrm::parse(data)?, lines),
        SapService::Slave(SlaveSap::SET_EXT_PRM) if is_request => prm_blocks(data, lines),
        SapService::Slave(SlaveSap::CHK_CFG) if is_request => configuration(data, lines),
        SapService::Slave(SlaveSap::GET_CFG) if !is_request => configuration(data, lines),
        SapService::Slave(SlaveSap::SLAVE_DIAG) if !is_request => diagnosis(&SlaveDiag::parse(data)?, lines),
        SapService::Slave(SlaveSap::GLOBAL_CONTROL) if is_request => {
            let control = GlobalControl::parse(data)?;
            let groups = if control.groups == 0 { "all slaves".to_owned() } else { groups(control.groups) };
            let words = bits(control.command.words(), control.command.reserved());
            lines.say(format!("{} to {groups}", if words.is_empty() { "no command" } else { &words }));
            Ok(())
        }
        SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS) if is_request => {
            let set = SetSlaveAddress::parse(data)?;
            let again = if set.no_change == 0 { "further changes allowed" } else { "further changes locked" };
            lines.say(format!("new address {}, ident 0x{:04X}, {again}", set.address, set.ident));
            lines.octets("stored by the slave", &set.slave_data);
            Ok(())
        }
        SapService::Connection(_)
        | SapService::Slave(SlaveSap::RESOURCE_MANAGER | SlaveSap::ALARM | SlaveSap::SERVER) => {
            let side = if is_request { PduDirection::Request } else { PduDirection::Response };
            acyclic(&Dpv1Pdu::parse(data, side)?, lines);
            Ok(())
        }
        _ => {
            lines.octets("data", data);
            Ok(())
        }
    }
}

/// The names of the set bits, and the set bits without a name.
fn bits<'a>(words: impl Iterator<Item = &'a str>, reserved: u8) -> String {
    let mut text = words.collect::<Vec<_>>().join(" ");
    if reserved != 0 {
        let _ = write!(text, "{}reserved {reserved:#04x}", if text.is_empty() { "" } else { " " });
    }
    text
}

fn groups(groups: u8) -> String {
    let numbers: Vec<_> = (0..8).filter(|bit| groups >> bit & 1 != 0).map(|bit| (bit + 1).to_string()).collect();
    format!("groups {}", numbers.join(" "))
}

fn set_prm(prm: &SetPrm, lines: &mut Lines) -> Result<(), WireError> {
    let status = bits(prm.status.words(), prm.status.reserved());
    if !status.is_empty() {
        lines.say(status);
    }
    let dpv1 = prm.dpv1().filter(|dpv1| dpv1.status_1.has(Dpv1Status1::DPV1_ENABLE));
    let watchdog = match prm.watchdog_ms(watchdog_base_ms(dpv1)) {
        Some(time) => format!("watchdog {time} ms"),
        None => "no watchdog".to_owned(),
    };
    let belongs = if prm.groups == 0 { "no groups".to_owned() } else { groups(prm.groups) };
    lines.say(format!("{watchdog}, min TSDR {} bits, ident 0x{:04X}, {belongs}", prm.min_tsdr, prm.ident));
    let Some(dpv1) = dpv1 else {
        lines.octets("user", &prm.user);
        return Ok(());
    };
    lines.say(bits(dpv1.status_1.words(), dpv1.status_1.reserved()));
    lines.say(format!("alarms: {}", bits(dpv1.status_2.words(), dpv1.status_2.reserved())));
    let more = [
        (Dpv1Status3::PRM_STRUCTURE, "structured blocks"),
        (Dpv1Status3::ISOCHRONOUS, "isochronous"),
        (Dpv1Status3::PRM_COMMAND, "redundancy command"),
    ];
    let words = more.into_iter().filter(|(bit, _)| dpv1.status_3.has(*bit)).map(|(_, word)| word);
    lines.say(format!("alarm mode {} {}", dpv1.status_3.0 & 7, bits(words, dpv1.status_3.reserved())).trim_end());
    if dpv1.status_3.has(Dpv1Status3::PRM_STRUCTURE) {
        let head = SetPrm::HEAD + dpv1.octets().len();
        return prm_blocks(prm.user_after_dpv1(), lines).map_err(|error| error.at_offset(head));
    }
    lines.octets("user", prm.user_after_dpv1());
    Ok(())
}

fn prm_blocks(octets: &[u8], lines: &mut Lines) -> Result<(), WireError> {
    for block in PrmBlock::parse_all(octets)? {
        let kind = block.kind.word().map_or_else(|| format!("block of type {}", block.kind.0), str::to_owned);
        match Isochronous::parse(&block.data) {
            Ok(times) if block.kind == PrmBlockType::ISOCHRONOUS => {
                lines.say(format!("{kind} slot {}: cycle {} ns", block.slot, times.cycle_nanoseconds()));
                lines.say(format!(
                    "  T_BASE_DP {} T_DP {} T_MAPC {} T_BASE_IO {} T_I {} T_O {} T_DX {} T_PLL_W {} T_PLL_D {}",
                    times.t_base_dp,
                    times.t_dp,
                    times.t_mapc,
                    times.t_base_io,
                    times.t_i,
                    times.t_o,
                    times.t_dx,
                    times.t_pll_w,
                    times.t_pll_d
                ));
            }
            _ => lines.say(format!("{kind} slot {}: {}", block.slot, hex(&block.data)).trim_end()),
        }
    }
    Ok(())
}

fn configuration(data: &[u8], lines: &mut Lines) -> Result<(), WireError> {
    let all = Identifier::parse_all(data)?;
    let amount = |length: Length, of: &str| {
        let unit = if length.words { "words" } else { "bytes" };
        format!("{} {unit} of {of}{}", length.count, if length.whole { ", consistent as a whole" } else { "" })
    };
    for identifier in &all {
        let mut parts: Vec<String> = Vec::new();
        parts.extend(identifier.outputs().map(|length| amount(length, "outputs")));
        parts.extend(identifier.inputs().map(|length| amount(length, "inputs")));
        if parts.is_empty() {
            parts.push("an empty slot".to_owned());
        }
        match identifier {
            Identifier::Special { maker: ManufacturerData::Octets(octets), .. } if !octets.is_empty() => {
                parts.push(format!("manufacturer data {}", hex(octets)));
            }
            Identifier::Special { maker: ManufacturerData::NotCompared, .. } => {
                parts.push("manufacturer data not compared".to_owned())
            }
            _ => {}
        }
        lines.say(parts.join("; "));
    }
    let sums = io_lengths(&all);
    lines.say(format!("total {} bytes of outputs, {} bytes of inputs", sums.outputs, sums.inputs));
    Ok(())
}

fn diagnosis(diag: &SlaveDiag, lines: &mut Lines) -> Result<(), WireError> {
    let status = [
        bits(diag.status_1.words(), diag.status_1.reserved()),
        bits(diag.status_2.words(), diag.status_2.reserved()),
        bits(diag.status_3.words(), diag.status_3.reserved()),
    ];
    let status: Vec<_> = status.into_iter().filter(|words| !words.is_empty()).collect();
    lines.say(if status.is_empty() { "no status bit".to_owned() } else { status.join(" ") });
    let master = match diag.master {
        NO_MASTER => "no master".to_owned(),
        master => format!("master {master}"),
    };
    lines.say(format!("{master}, ident 0x{:04X}", diag.ident));
    for block in diag.blocks() {
        match block? {
            DiagnosisBlock::Device(data) => {
                lines.say(format!("device: {}", hex(data)));
                if let Ok(message) = DiagnosisMessage::parse(data)
                    && let Some(word) = message_word(&message)
                {
                    let place = format!("slot {}, {}", message.slot, specifier(message.specifier));
                    lines.say(format!("  with DP-V1: {word}, {place}: {}", hex(message.data)).trim_end());
                }
            }
            DiagnosisBlock::Identifier(data) => {
                let numbers: Vec<_> = identifiers(data).map(|number| number.to_string()).collect();
                lines.say(format!("identifiers: {}", numbers.join(" ")).trim_end());
            }
            DiagnosisBlock::Channel(channel) => {
                let direction = ["reserved", "input", "output", "input and output"][usize::from(channel.direction & 3)];
                let width = channel.channel_type;
                let width = width.word().map_or_else(|| format!("type {}", width.0), str::to_owned);
                let error = channel.error_type;
                let error = error.word().map_or_else(|| format!("error type {}", error.0), str::to_owned);
                lines.say(format!(
                    "channel {} of identifier {}: {direction}, {width}, {error}",
                    channel.channel, channel.identifier
                ));
            }
            DiagnosisBlock::Revision(revision) => lines.say(format!("revision {revision}")),
        }
    }
    Ok(())
}

/// The name of an alarm or status, if it is known.
fn message_word(message: &DiagnosisMessage<'_>) -> Option<String> {
    let alarm = message.alarm().and_then(|alarm| alarm.word()).map(|word| format!("{word} alarm"));
    alarm.or_else(|| message.status().and_then(|status| status.word()).map(|word| format!("status {word}")))
}

fn specifier(specifier: Specifier) -> String {
    let change = match specifier.change() {
        SpecifierChange::NotDifferentiated => "",
        SpecifierChange::Appears => ", appears",
        SpecifierChange::Disappears => ", disappears",
        SpecifierChange::DisappearsOthersRemain => ", disappears, others remain",
    };
    let user = if specifier.requires_user_acknowledgement() { ", user acknowledgement required" } else { "" };
    format!("sequence {}{change}{user}", specifier.sequence())
}

fn acyclic(pdu: &Dpv1Pdu, lines: &mut Lines) {
    let function = pdu.function();
    let word = function.word().map_or_else(|| format!("function {:#04x}", function.0), str::to_owned);
    match pdu {
        Dpv1Pdu::Idle(more) | Dpv1Pdu::Other(_, more) => lines.say(format!("{word} {}", hex(more)).trim_end()),
        Dpv1Pdu::DataTransport(record) | Dpv1Pdu::Read(record) | Dpv1Pdu::Write(record) => {
            let Dpv1Record { slot, index, length, data } = record;
            lines.say(format!("{word} slot {slot} index {index} length {length}"));
            lines.octets("record", data);
        }
        Dpv1Pdu::ResourceManager { sap, send_timeout } => {
            lines.say(format!("{word}: use SAP {sap}, {} ms", u32::from(*send_timeout) * 10));
        }
        Dpv1Pdu::InitiateRequest { send_timeout, abilities, .. } => {
            lines.say(format!("{word}, {} ms", u32::from(*send_timeout) * 10));
            able(abilities, lines);
        }
        Dpv1Pdu::InitiateResponse { most_data, abilities } => {
            lines.say(format!("{word}, at most {most_data} bytes of data"));
            able(abilities, lines);
        }
        Dpv1Pdu::Abort { subnet, reason, more } => {
            let reason = reason.word().map_or_else(|| format!("reason {:#04x}", reason.0), str::to_owned);
            let subnet = subnet.word().map_or_else(|| subnet.0.to_string(), str::to_owned);
            lines.say(format!("{word}: {reason}, subnet {subnet}"));
            lines.octets("more", more);
        }
        Dpv1Pdu::AlarmAck { slot, alarm_type, specifier: of } => {
            lines.say(format!("{word} slot {slot} alarm type {alarm_type}, {}", specifier(*of)));
        }
        Dpv1Pdu::Refused(refusal) => {
            let error = refusal.record_error().and_then(|error| error.word()).unwrap_or("unknown error");
            let codes = [function.0, refusal.decode.0, refusal.code_1, refusal.code_2];
            lines.say(format!("{word}: {error} ({})", hex(&codes)));
        }
    }
}

fn able(abilities: &InitiateFeatures, lines: &mut Lines) {
    let InitiateFeatures { features, profile_features, profile, source, destination } = abilities;
    lines.say(format!(
        "features {}, profile features {}, profile 0x{profile:04X}, from {} to {}",
        hex(features),
        hex(profile_features),
        hex(&source.address),
        hex(&destination.address)
    ));
}
