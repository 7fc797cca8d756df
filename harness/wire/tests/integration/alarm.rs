//! Alarms and I&M blocks against frames built with scapy and tshark's dissection of them.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::profinet::alarm::{
    AlarmAck, AlarmNotification, AlarmPriority, AlarmSpecifier, AlarmType, RtaBody, RtaHeader, RtaKind, RtaPdu,
};
use encspec_wire::profinet::blocks::im::{Im0, ImText, SoftwareRevision, padded};
use encspec_wire::profinet::diagnosis::{
    AlarmItem, ChannelChange, ChannelDiagnosis, ChannelErrorType, ChannelProperties, ExtChannelDiagnosis,
    MaintenanceSeverity,
};
use encspec_wire::profinet::status::{AbortReason, PnioStatus};
use rstest::rstest;
use testing::{golden, hex};

/// Fields in the order in which they were added, with the names of `alarm.py`.
struct AlarmLine(Vec<(&'static str, Vec<u64>)>);

impl AlarmLine {
    fn put(&mut self, field: &'static str, value: impl Into<u64>) {
        match self.0.iter_mut().find(|(name, _)| *name == field) {
            Some((_, values)) => values.push(value.into()),
            None => self.0.push((field, vec![value.into()])),
        }
    }

    fn of(pdu: &RtaPdu, length: usize) -> AlarmLine {
        let mut reading = AlarmLine(Vec::new());
        let header = pdu.header;
        let (block, priority) = match &pdu.body {
            RtaBody::Notification(alarm) => {
                (Some(if alarm.priority == AlarmPriority::High { 1u16 } else { 2 }), Some(alarm.priority))
            }
            RtaBody::Acknowledgement(ack) => {
                (Some(if ack.priority == AlarmPriority::High { 0x8001 } else { 0x8002 }), Some(ack.priority))
            }
            _ => (None, None),
        };
        priority.into_iter().for_each(|priority| reading.put("frame_id", priority.frame_id()));
        reading.put("dst", header.dst_endpoint);
        reading.put("src", header.src_endpoint);
        reading.put("kind", header.kind.0);
        reading.put("version", header.version);
        reading.put("window", header.window_size());
        reading.put("tack", header.tack());
        reading.put("send", header.send_seq_num);
        reading.put("ack", header.ack_seq_num);
        reading.put("length", (length - 12) as u64);
        block.into_iter().for_each(|block| reading.put("block", block));
        match &pdu.body {
            RtaBody::Notification(alarm) => reading.notification(alarm),
            RtaBody::Acknowledgement(ack) => {
                reading.submodule(ack.alarm_type, ack.api, ack.slot, ack.subslot);
                reading.specifier(ack.specifier);
                reading.status(&ack.status);
            }
            RtaBody::Error { status, .. } => reading.status(status),
            RtaBody::Octets(_) => {}
        }
        reading
    }

    fn submodule(&mut self, alarm_type: AlarmType, api: u32, slot: u16, subslot: u16) {
        self.put("alarm_type", alarm_type.0);
        self.put("api", api);
        self.put("slot", slot);
        self.put("subslot", subslot);
    }

    fn specifier(&mut self, specifier: AlarmSpecifier) {
        self.put("sequence", specifier.sequence_number());
        self.put("channel_diagnosis", specifier.channel_diagnosis());
        self.put("manufacturer", specifier.manufacturer_diagnosis());
        self.put("submodule_state", specifier.submodule_diagnosis_state());
        self.put("ar_state", specifier.ar_diagnosis_state());
    }

    fn notification(&mut self, alarm: &AlarmNotification) {
        self.submodule(alarm.alarm_type, alarm.api, alarm.slot, alarm.subslot);
        self.put("module", alarm.module_ident);
        self.put("submodule", alarm.submodule_ident);
        self.specifier(alarm.specifier);
        let mut maintenance = None;
        for item in &alarm.items {
            self.put("structure", item.identifier());
            for channel in item.channels() {
                self.channel(&channel);
            }
            match item {
                AlarmItem::ExtChannel(entries) => {
                    entries.iter().for_each(|entry| self.put("add_value", entry.add_value))
                }
                AlarmItem::QualifiedChannel(entries) => entries.iter().for_each(|entry| {
                    self.put("add_value", entry.detail.add_value);
                    self.put("qualifier", entry.qualifier);
                }),
                AlarmItem::Maintenance(state) => {
                    self.put("block", 0x0F00u16);
                    maintenance = Some(*state);
                }
                _ => {}
            }
        }
        maintenance.into_iter().for_each(|state| self.put("maintenance", state));
    }

    fn channel(&mut self, channel: &ChannelDiagnosis) {
        let severity = [
            MaintenanceSeverity::Diagnosis,
            MaintenanceSeverity::MaintenanceRequired,
            MaintenanceSeverity::MaintenanceDemanded,
            MaintenanceSeverity::Qualified,
        ];
        let change = [
            ChannelChange::AllDisappear,
            ChannelChange::Appears,
            ChannelChange::Disappears,
            ChannelChange::DisappearsOthersRemain,
        ];
        let properties = channel.properties;
        self.put("channel", channel.channel);
        self.put("type", properties.channel_type());
        self.put("accumulative", properties.accumulative());
        self.put("severity", severity.iter().position(|other| *other == properties.severity()).unwrap() as u64);
        self.put("change", change.iter().position(|other| *other == properties.change()).unwrap() as u64);
        self.put("direction", properties.direction());
        self.put("error_type", channel.error_type.0);
    }

    fn status(&mut self, status: &PnioStatus) {
        self.put("error_code", status.error_code.0);
        self.put("error_decode", status.error_decode.0);
        self.put("error_code1", status.error_code1);
        self.put("error_code2", status.error_code2);
    }

    fn fields(self) -> Vec<String> {
        let values = |values: Vec<u64>| values.iter().map(|value| format!("{value:#x}")).collect::<Vec<_>>().join(",");
        self.0.into_iter().map(|(name, read)| format!("{name}={}", values(read))).collect()
    }
}

#[test]
fn frames_of_scapy_are_parsed_like_tshark() {
    let frames = golden("scapy-alarm.txt");
    let lines = include_str!("../golden/tshark-alarm.txt").lines().filter(|line| !line.starts_with('#'));
    let mut compared = 0;
    for line in lines {
        let mut fields: Vec<&str> = line.split(' ').collect();
        let name = fields.remove(0);
        let octets = &frames.iter().find(|(other, _)| other == name).unwrap().1;
        let pdu = RtaPdu::parse(octets).unwrap();
        if matches!(pdu.body, RtaBody::Octets(_) | RtaBody::Error { .. }) {
            fields.remove(0); // the frame ID, which only notifications and their acknowledgements have
        }
        assert_eq!(AlarmLine::of(&pdu, octets.len()).fields(), fields, "{name}");
        assert_eq!(written(|out| pdu.write(out)), *octets, "{name}");
        compared += 1;
    }
    assert_eq!(compared, 12, "all lines of the file were compared");
}

/// The parser gets the bytes after the frame ID, including the padding of short frames.
#[test]
fn padding_of_the_frame_is_ignored() {
    let mut octets = hex("0102030414010005 00040004 cf81fd05");
    octets.resize(44, 0);
    let pdu = RtaPdu::parse(&octets).unwrap();
    assert_eq!(pdu.body, RtaBody::Error { status: PnioStatus::abort(AbortReason(5)), more: Vec::new() });
}

fn named(name: &str) -> Vec<u8> {
    golden("scapy-alarm.txt").into_iter().find(|(other, _)| other == name).unwrap().1
}

fn notification(sequence: u16, flags: u16, alarm_type: AlarmType, item: AlarmItem) -> AlarmNotification {
    AlarmNotification {
        priority: AlarmPriority::Low,
        alarm_type,
        api: 0x3D00,
        slot: 1,
        subslot: 2,
        module_ident: 0x1122_3344,
        submodule_ident: 0x51,
        specifier: AlarmSpecifier::new(sequence, flags),
        items: vec![item],
    }
}

/// A device builds from names the same frame that scapy builds from numbers.
#[test]
fn a_diagnosis_built_by_name() {
    let flags = AlarmSpecifier::CHANNEL_DIAGNOSIS
        | AlarmSpecifier::SUBMODULE_DIAGNOSIS_STATE
        | AlarmSpecifier::AR_DIAGNOSIS_STATE;
    let memory_error = ChannelDiagnosis {
        channel: ChannelDiagnosis::WHOLE_SUBMODULE,
        properties: ChannelProperties::new(MaintenanceSeverity::Diagnosis, ChannelChange::Appears),
        error_type: ChannelErrorType(0x9000),
    };
    let alarm = notification(5, flags, AlarmType::DIAGNOSIS, AlarmItem::Channel(vec![memory_error]));
    let header = RtaHeader::new(RtaKind::DATA, 0x0102, 0x0304, 0xFFFF, 0xFFFE);
    let pdu = RtaPdu { header, body: RtaBody::Notification(alarm.clone()) };
    assert_eq!(written(|out| pdu.write(out)), named("channel"));

    let header = RtaHeader::new(RtaKind::DATA, 0x0102, 0x0304, 5, 4);
    let ack: AlarmAck = alarm.acknowledgement(PnioStatus::OK);
    assert_eq!(written(|out| RtaPdu { header, body: RtaBody::Acknowledgement(ack) }.write(out)), named("ack"));

    let gone = ChannelDiagnosis {
        properties: ChannelProperties::new(MaintenanceSeverity::Diagnosis, ChannelChange::Disappears),
        ..memory_error
    };
    let alarm = notification(6, 0, AlarmType::DIAGNOSIS_DISAPPEARS, AlarmItem::Channel(vec![gone]));
    let header = RtaHeader::new(RtaKind::DATA, 0x0102, 0x0304, 0, 0);
    assert_eq!(written(|out| RtaPdu { header, body: RtaBody::Notification(alarm) }.write(out)), named("disappears"));
}

#[test]
fn transport_acknowledgement_and_abort_built_by_name() {
    let header = RtaHeader::new(RtaKind::ACK, 0x0102, 0x0304, 5, 4);
    assert_eq!(written(|out| RtaPdu { header, body: RtaBody::Octets(Vec::new()) }.write(out)), named("transport_ack"));
    let header = RtaHeader::new(RtaKind::ERR, 0x0102, 0x0304, 5, 4);
    let body = RtaBody::Error { status: PnioStatus::abort(AbortReason(5)), more: Vec::new() };
    assert_eq!(written(|out| RtaPdu { header, body }.write(out)), named("error"));
}

#[test]
fn extended_diagnosis_keeps_its_detail() {
    let RtaBody::Notification(alarm) = RtaPdu::parse(&named("extended")).unwrap().body else { panic!("no alarm") };
    let channel = ChannelDiagnosis {
        channel: 3,
        properties: ChannelProperties(0x2B05),
        error_type: ChannelErrorType::REMOTE_MISMATCH,
    };
    let entry = ExtChannelDiagnosis { channel, ext_error_type: 0x8005, add_value: 0xDEAD_BEEF };
    assert_eq!(alarm.items, [AlarmItem::ExtChannel(vec![entry])]);
    assert_eq!(channel.properties.severity().word(), "maintenance_required");
    assert_eq!(channel.properties.change().word(), "appears");
    assert_eq!(
        ChannelProperties::new(MaintenanceSeverity::MaintenanceRequired, ChannelChange::Appears)
            .with_type(5)
            .with_direction(1)
            .0,
        0x2A05
    );
}

/// One identifier with several entries, as in diagnosis blocks, and vendor data: also preserved in an alarm.
#[rstest]
#[case::two_entries_under_one_identifier("8000 800008009000 80001a009005")]
#[case::four_items_of_one_entry("8000 800008009000 8000 800008009001 8000 800008009002 8000 800008009005")]
#[case::vendor("0010 aabbccdd")]
#[case::unusual_maintenance_block("8100 0f00000401000000 0001")]
#[case::diagnosis_blocks("8001 001000160101 00003d00 0001 0002 8000 0800 8000 8000 0800 9000")]
fn items_are_preserved(#[case] items: &str) {
    let items = hex(items);
    let mut block = hex("0002 0000 0100 0001 00003d00 0001 0002 11223344 00000051 a805");
    block.extend(&items);
    let length = block.len() as u16;
    block[2..4].copy_from_slice(&(length - 4).to_be_bytes());
    let mut octets = hex("01020304 11 11 ffff fffe");
    octets.extend(length.to_be_bytes());
    octets.extend(&block);
    let pdu = RtaPdu::parse(&octets).unwrap();
    assert!(matches!(pdu.body, RtaBody::Notification(_)));
    assert_eq!(written(|out| pdu.write(out)), octets);
}

/// Other blocks, other versions and other kinds of PDU are preserved as bytes.
#[rstest]
#[case::unknown_block("01020304 11 11 ffff fffe 0008 0777 0004 0100 aabb")]
#[case::other_version("01020304 11 11 ffff fffe 001a 0002 0016 0101 0001 00003d00 0001 0002 11223344 00000051 a805")]
#[case::bytes_after_the_block(
    "01020304 11 11 ffff fffe 001c 0002 0016 0100 0001 00003d00 0001 0002 11223344 00000051 a805 ffff"
)]
#[case::unknown_kind("01020304 17 e1 ffff fffe 0002 1234")]
#[case::error_with_more("01020304 14 01 ffff fffe 0006 cf81fd05 1234")]
fn unknown_content_is_preserved(#[case] octets: &str) {
    let octets = hex(octets);
    let pdu = RtaPdu::parse(&octets).unwrap();
    assert!(matches!(pdu.body, RtaBody::Octets(_) | RtaBody::Error { .. }));
    assert_eq!(written(|out| pdu.write(out)), octets);
}

#[test]
fn im0_field_by_field() {
    let im0 = Im0 {
        vendor_id: 0x0239,
        order_id: padded("XAC77 27/2048"),
        serial_number: padded("SN0000000001"),
        hardware_revision: 3,
        software_revision: SoftwareRevision { prefix: b'V', functional_enhancement: 1, bug_fix: 2, internal_change: 7 },
        revision_counter: 9,
        profile_id: 0x3D00,
        profile_specific_type: 1,
        im_version: [1, 1],
        im_supported: 0x001E,
    };
    assert_eq!(written(|out| im0.write(out)), named("im0"));
    assert_eq!(Im0::parse(&named("im0")), Ok(im0));
}

#[rstest]
#[case("im1", ImText::Tag { function: padded("height of the crane"), location: padded("hall 4") })]
#[case("im2", ImText::Date(padded("2024-02-29 12:34")))]
#[case("im3", ImText::Descriptor(padded("a descriptor")))]
#[case("im4", ImText::Signature(core::array::from_fn(|at| at as u8)))]
fn im1_to_im4(#[case] name: &str, #[case] text: ImText) {
    assert_eq!(written(|out| text.write(out)), named(name));
    assert_eq!(ImText::parse(&named(name)), Ok(text));
}
