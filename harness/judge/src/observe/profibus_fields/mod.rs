//! The fields of PROFIBUS frames by name, for comparison with other programs.
//!
//! The names and words are in [`fields`]; [`dissector`] is a dissector for Wireshark that has the same fields.

mod dissector;
mod table;

pub use dissector::dissector;
pub use table::{DpField, DpFieldKind, fields};

use super::dp::watchdog_base_ms;
use super::dp_services::{DpServices, service_word};
use wire::WireError;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::cfg::{Identifier, Length, ManufacturerData, io_lengths};
use wire::profibus::diag::{DiagnosisBlock, DiagnosisMessage, SlaveDiag, identifiers};
use wire::profibus::dpv1::{Dpv1Pdu, InitiateFeatures, PduDirection};
use wire::profibus::fdl::{DataFrame, Extension, FdlFormat, FdlFrame, FrameCount, StartDelimiter};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::{Dpv1Status1, Dpv1Status3, Isochronous, PrmBlock, PrmBlockType, SetPrm};
use wire::profibus::sap::{SapService, SlaveSap};

/// The value of a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DpFieldValue {
    /// A number; a bit is 0 or 1.
    Number(u32),
    /// Bytes.
    Octets(Vec<u8>),
    /// A text.
    Text(String),
}

/// Splits the frames of one bus into fields. It stores the last request, since some answers do not contain their service.
#[derive(Clone, Debug, Default)]
pub struct ProfibusFields {
    services: DpServices,
}

/// The fields of a frame so far.
#[derive(Default)]
struct FieldList(Vec<(String, DpFieldValue)>);

impl FieldList {
    fn number(&mut self, name: &str, number: impl Into<u32>) {
        self.0.push((name.to_owned(), DpFieldValue::Number(number.into())));
    }

    fn octets(&mut self, name: &str, octets: &[u8]) {
        if !octets.is_empty() {
            self.0.push((name.to_owned(), DpFieldValue::Octets(octets.to_vec())));
        }
    }

    fn text(&mut self, name: &str, text: impl Into<String>) {
        self.0.push((name.to_owned(), DpFieldValue::Text(text.into())));
    }

    fn flags(&mut self, name: &str, octet: u8) {
        self.number(name, octet);
        let field = fields().iter().find(|field| field.name == name);
        for (bit, word, _) in field.into_iter().flat_map(|field| &field.words) {
            self.number(&format!("{name}.{word}"), u32::from(u32::from(octet) & bit != 0));
        }
    }
}

impl ProfibusFields {
    /// The fields of the next frame on the bus, by their names after `profibus.`; a field may occur several times.
    pub fn frame(&mut self, octets: &[u8]) -> Vec<(String, DpFieldValue)> {
        let mut list = FieldList::default();
        match FdlFrame::parse(octets) {
            Err(_) => {
                list.number("damaged", 1_u8);
                list.octets("data", octets);
            }
            Ok(FdlFrame::Token { da, sa }) => {
                list.number("start", StartDelimiter::SD4.0);
                list.number("da", da);
                list.number("sa", sa);
                list.text("service", "token");
            }
            Ok(FdlFrame::ShortAcknowledgement) => {
                list.number("start", StartDelimiter::SC.0);
                if let Some(asked) = self.services.acknowledged() {
                    list.text("service", service_word(asked.service));
                }
            }
            Ok(FdlFrame::Data(frame)) => self.data_frame(&frame, octets, &mut list),
        }
        list.0
    }

    fn data_frame(&mut self, frame: &DataFrame<'_>, octets: &[u8], list: &mut FieldList) {
        let service = self.services.of(frame);
        let DataFrame { format, da, sa, fc, .. } = *frame;
        let start = match format {
            FdlFormat::NoData => StartDelimiter::SD1,
            FdlFormat::EightOctets => StartDelimiter::SD3,
            FdlFormat::Variable => StartDelimiter::SD2,
        };
        list.number("start", start.0);
        if let (FdlFormat::Variable, Some(length)) = (format, octets.get(1)) {
            list.number("length", *length);
        }
        list.number("da", da);
        list.number("sa", sa);
        list.number("fc", fc.0);
        if let (Some(function), Some(count)) = (fc.requested(), fc.count()) {
            list.number("request", function.0);
            let count: u8 = match count {
                FrameCount::Unused => 0,
                FrameCount::First => 1,
                FrameCount::Zero => 2,
                FrameCount::One => 3,
            };
            list.number("count", count);
        }
        if let (Some(function), Some(station)) = (fc.answered(), fc.station()) {
            list.number("answer", function.0);
            list.number("station", station.0);
        }
        for (name, Extension { segment, sap }) in [("da", frame.destination), ("sa", frame.source)] {
            segment.into_iter().for_each(|segment| list.number(&format!("{name}.segment"), segment));
            sap.into_iter().for_each(|sap| list.number(&format!("{name}.sap"), sap));
        }
        list.text("service", service_word(service));
        if let Some(sum) = octets.len().checked_sub(2).and_then(|at| octets.get(at)) {
            list.number("fcs", *sum);
        }
        let before = list.0.len();
        if carried(service, frame, list).is_err() {
            list.0.truncate(before);
            list.number("damaged", 1_u8);
            list.octets("data", frame.data);
        }
    }
}

/// Adds the fields of the data of a frame.
fn carried(service: SapService, frame: &DataFrame<'_>, list: &mut FieldList) -> Result<(), WireError> {
    let (data, is_request) = (frame.data, frame.fc.is_request());
    if data.is_empty() {
        return Ok(());
    }
    match service {
        SapService::Slave(SlaveSap::SET_PRM) if is_request => set_prm(&SetPrm::parse(data)?, list),
        SapService::Slave(SlaveSap::SET_EXT_PRM) if is_request => prm_blocks(data, list),
        SapService::Slave(SlaveSap::CHK_CFG) if is_request => configuration(data, list),
        SapService::Slave(SlaveSap::GET_CFG) if !is_request => configuration(data, list),
        SapService::Slave(SlaveSap::SLAVE_DIAG) if !is_request => diagnosis(&SlaveDiag::parse(data)?, list),
        SapService::Slave(SlaveSap::GLOBAL_CONTROL) if is_request => {
            let control = GlobalControl::parse(data)?;
            list.flags("control.command", control.command.0);
            list.number("control.groups", control.groups);
            Ok(())
        }
        SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS) if is_request => {
            let set = SetSlaveAddress::parse(data)?;
            list.number("address.new", set.address);
            list.number("address.ident", set.ident);
            list.number("address.no_change", set.no_change);
            list.octets("address.data", &set.slave_data);
            Ok(())
        }
        SapService::Connection(_)
        | SapService::Slave(SlaveSap::RESOURCE_MANAGER | SlaveSap::ALARM | SlaveSap::SERVER) => {
            let side = if is_request { PduDirection::Request } else { PduDirection::Response };
            acyclic(&Dpv1Pdu::parse(data, side)?, list);
            Ok(())
        }
        _ => {
            list.octets("data", data);
            Ok(())
        }
    }
}

fn set_prm(prm: &SetPrm, list: &mut FieldList) -> Result<(), WireError> {
    list.flags("prm.status", prm.status.0);
    list.number("prm.watchdog_factor_1", prm.wd_fact_1);
    list.number("prm.watchdog_factor_2", prm.wd_fact_2);
    list.number("prm.min_tsdr", prm.min_tsdr);
    list.number("prm.ident", prm.ident);
    list.number("prm.groups", prm.groups);
    let dpv1 = prm.dpv1().filter(|dpv1| dpv1.status_1.has(Dpv1Status1::DPV1_ENABLE));
    if let Some(time) = prm.watchdog_ms(watchdog_base_ms(dpv1)) {
        list.number("prm.watchdog", time);
    }
    let Some(dpv1) = dpv1 else {
        list.octets("prm.user", &prm.user);
        return Ok(());
    };
    list.flags("prm.dpv1_status_1", dpv1.status_1.0);
    list.flags("prm.dpv1_status_2", dpv1.status_2.0);
    list.flags("prm.dpv1_status_3", dpv1.status_3.0);
    list.number("prm.alarm_mode", dpv1.status_3.0 & 7);
    if dpv1.status_3.has(Dpv1Status3::PRM_STRUCTURE) {
        return prm_blocks(prm.user_after_dpv1(), list);
    }
    list.octets("prm.user", prm.user_after_dpv1());
    Ok(())
}

fn prm_blocks(octets: &[u8], list: &mut FieldList) -> Result<(), WireError> {
    for block in PrmBlock::parse_all(octets)? {
        list.number("block.type", block.kind.0);
        list.number("block.slot", block.slot);
        match Isochronous::parse(&block.data) {
            Ok(times) if block.kind == PrmBlockType::ISOCHRONOUS => {
                list.number("iso.t_base_dp", times.t_base_dp);
                list.number("iso.t_dp", times.t_dp);
                list.number("iso.t_mapc", times.t_mapc);
                list.number("iso.t_base_io", times.t_base_io);
                list.number("iso.t_i", times.t_i);
                list.number("iso.t_o", times.t_o);
                list.number("iso.t_dx", times.t_dx);
                list.number("iso.t_pll_w", times.t_pll_w);
                list.number("iso.t_pll_d", times.t_pll_d);
            }
            _ => list.octets("block.data", &block.data),
        }
    }
    Ok(())
}

fn configuration(data: &[u8], list: &mut FieldList) -> Result<(), WireError> {
    let all = Identifier::parse_all(data)?;
    let number = |octets: usize| u32::try_from(octets).unwrap_or(u32::MAX);
    let mut add = |name: &str, length: Option<Length>| {
        length.into_iter().for_each(|length| list.number(name, number(length.octets())));
    };
    for identifier in &all {
        add("cfg.outputs", identifier.outputs());
        add("cfg.inputs", identifier.inputs());
    }
    for identifier in &all {
        if let Identifier::Special { maker: ManufacturerData::Octets(octets), .. } = identifier {
            list.octets("cfg.manufacturer", octets);
        }
    }
    let sums = io_lengths(&all);
    list.number("cfg.all_outputs", number(sums.outputs));
    list.number("cfg.all_inputs", number(sums.inputs));
    Ok(())
}

fn diagnosis(diag: &SlaveDiag, list: &mut FieldList) -> Result<(), WireError> {
    list.flags("diag.status_1", diag.status_1.0);
    list.flags("diag.status_2", diag.status_2.0);
    list.flags("diag.status_3", diag.status_3.0);
    list.number("diag.master", diag.master);
    list.number("diag.ident", diag.ident);
    for block in diag.blocks() {
        match block? {
            DiagnosisBlock::Device(data) => {
                list.octets("diag.device", data);
                if let Ok(message) = DiagnosisMessage::parse(data) {
                    message_fields(&message, list);
                }
            }
            DiagnosisBlock::Identifier(data) => {
                identifiers(data).filter_map(|number| u32::try_from(number).ok()).for_each(|number| {
                    list.number("diag.identifier", number);
                });
            }
            DiagnosisBlock::Channel(channel) => {
                list.number("diag.channel.identifier", channel.identifier);
                list.number("diag.channel.direction", channel.direction);
                list.number("diag.channel.number", channel.channel);
                list.number("diag.channel.type", channel.channel_type.0);
                list.number("diag.channel.error", channel.error_type.0);
            }
            DiagnosisBlock::Revision(revision) => list.number("diag.revision", revision),
        }
    }
    Ok(())
}

/// Adds the fields of an alarm or a status whose type has a name.
fn message_fields(message: &DiagnosisMessage<'_>, list: &mut FieldList) {
    if let Some(alarm) = message.alarm().filter(|alarm| alarm.word().is_some()) {
        list.number("diag.alarm", alarm.0);
    } else if let Some(status) = message.status().filter(|status| status.word().is_some()) {
        list.number("diag.status_type", status.0);
    } else {
        return;
    }
    list.number("diag.slot", message.slot);
    list.number("diag.specifier", message.specifier.0);
}

fn acyclic(pdu: &Dpv1Pdu, list: &mut FieldList) {
    list.number("dpv1.function", pdu.function().0);
    match pdu {
        Dpv1Pdu::Idle(more) | Dpv1Pdu::Other(_, more) => list.octets("dpv1.more", more),
        Dpv1Pdu::DataTransport(record) | Dpv1Pdu::Read(record) | Dpv1Pdu::Write(record) => {
            list.number("dpv1.slot", record.slot);
            list.number("dpv1.index", record.index);
            list.number("dpv1.length", record.length);
            list.octets("dpv1.record", &record.data);
        }
        Dpv1Pdu::ResourceManager { sap, send_timeout } => {
            list.number("dpv1.sap", *sap);
            list.number("dpv1.send_timeout", *send_timeout);
        }
        Dpv1Pdu::InitiateRequest { send_timeout, abilities, .. } => {
            list.number("dpv1.send_timeout", *send_timeout);
            initiate(abilities, list);
        }
        Dpv1Pdu::InitiateResponse { most_data, abilities } => {
            list.number("dpv1.most_data", *most_data);
            initiate(abilities, list);
        }
        Dpv1Pdu::Abort { subnet, reason, more } => {
            list.number("dpv1.subnet", subnet.0);
            list.number("dpv1.reason", reason.0);
            list.octets("dpv1.more", more);
        }
        Dpv1Pdu::AlarmAck { slot, alarm_type, specifier } => {
            list.number("dpv1.slot", *slot);
            list.number("dpv1.alarm_type", *alarm_type);
            list.number("dpv1.specifier", specifier.0);
        }
        Dpv1Pdu::Refused(refusal) => {
            list.number("dpv1.error_decode", refusal.decode.0);
            list.number("dpv1.error_code_1", refusal.code_1);
            list.number("dpv1.error_code_2", refusal.code_2);
        }
    }
}

fn initiate(abilities: &InitiateFeatures, list: &mut FieldList) {
    list.octets("dpv1.features", &abilities.features);
    list.octets("dpv1.profile_features", &abilities.profile_features);
    list.number("dpv1.profile", abilities.profile);
    list.octets("dpv1.source", &abilities.source.address);
    list.octets("dpv1.destination", &abilities.destination.address);
}

#[cfg(test)]
mod tests;
