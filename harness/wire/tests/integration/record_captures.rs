//! Identification, diagnosis, ModuleDiff and ERR-RTA of real devices; the values are those of tshark 4.0.17:
//! `tshark --disable-protocol wg -r FILE -Y 'frame.number == N' -V`.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::octets::ByteReader;
use encspec_wire::profinet::alarm::{RtaBody, RtaKind, RtaPdu};
use encspec_wire::profinet::blocks::identification::{ApiData, IdentificationData};
use encspec_wire::profinet::blocks::module_diff::{ArInfo, IdentInfo, ModuleDiffBlock, ModuleState, SubmoduleState};
use encspec_wire::profinet::blocks::{BlockHeader, BlockType};
use encspec_wire::profinet::diagnosis::{AlarmItem, DiagnosisData};
use rstest::rstest;
use testing::{hex, packets, shared};

/// The blocks with their headers in the RPC body of an untagged frame without IP options.
fn blocks(frame: &[u8]) -> Vec<(BlockType, Vec<u8>)> {
    let (udp, rpc_header, ndr_header) = (14 + 20 + 8, 80, 20);
    assert_eq!(frame[12..14], [0x08, 0x00], "IPv4");
    let body = &frame[udp + rpc_header + ndr_header..];
    let length = u32::from_le_bytes(frame[udp + rpc_header + 4..][..4].try_into().unwrap());
    let big_endian = frame[udp + 4] & 0x10 == 0;
    let length = if big_endian { length.swap_bytes() } else { length };
    let mut reader = ByteReader::new("blocks", &body[..length as usize]);
    let mut blocks = Vec::new();
    while !reader.is_empty() {
        let mut whole = reader;
        let start = reader.offset();
        let (header, _) = BlockHeader::read(&mut reader).unwrap();
        blocks.push((header.kind, whole.take(reader.offset() - start).unwrap().to_vec()));
    }
    blocks
}

fn block(file: &str, number: usize, kind: BlockType) -> Option<Vec<u8>> {
    let frames = packets(&shared(&format!("captures/profinet/{file}"))?);
    let found = blocks(&frames[number - 1]).into_iter().find(|(other, _)| *other == kind);
    Some(found.unwrap_or_else(|| panic!("frame {number} has no block {kind:?}")).1)
}

/// Slot, module ident, module state, then subslot, submodule ident, submodule state of each submodule.
type Diff = (u16, u32, ModuleState, Vec<(u16, u32, u16)>);

#[rstest]
#[case::submodule_missing_and_fault("office-noise-versamax.pcap", 18, 0, vec![
    (0, 0x1, ModuleState::PROPER_MODULE, vec![(2, 0, 0x9800)]),
    (1, 0xFFFF_8140, ModuleState::PROPER_MODULE, vec![(1, 0xFFFF_8140, 0x8040)]),
])]
#[case::with_application_ready("office-noise-versamax.pcap", 529, 0, vec![
    (0, 0x1, ModuleState::PROPER_MODULE, vec![(2, 0, 0x9800)]),
    (1, 0xFFFF_8140, ModuleState::PROPER_MODULE, vec![(1, 0xFFFF_8140, 0x8040)]),
])]
#[case::wrong_submodules("merged-many-devices.pcapng", 80, 0, vec![(0, 0x200, ModuleState::PROPER_MODULE,
    vec![(1, 0, 0x9000), (0x8000, 1, 0x9000), (0x8001, 2, 0x9000), (0x8002, 3, 0x9000)])])]
#[case::substitute_submodules("merged-many-devices.pcapng", 84, 0x3A00, vec![(1, 0x100, ModuleState::PROPER_MODULE,
    vec![(1, 0xFFFF, 0x8800), (2, 0x68, 0x8800)])])]
#[case::substitute_module("merged-many-devices.pcapng", 96, 0, vec![(0, 0x307, ModuleState::SUBSTITUTE,
    vec![(1, 0, 0x8800), (0x8000, 0x8002, 0x8800), (0x8001, 0xC000, 0x8800), (0x8002, 0xC000, 0x8800)])])]
#[case::maintenance_demanded("merged-many-devices.pcapng", 336, 0, vec![(0, 0x28, ModuleState::PROPER_MODULE,
    vec![(0x8000, 0x6000_FF00, 0x8020), (0x8001, 0x6004_8000, 0x8040)])])]
fn module_diff(#[case] file: &str, #[case] number: usize, #[case] api: u32, #[case] expected: Vec<Diff>) {
    let Some(octets) = block(file, number, BlockType::MODULE_DIFF) else { return };
    let diff = ModuleDiffBlock::parse(&octets).unwrap();
    assert_eq!(diff.apis.len(), 1);
    assert_eq!(diff.apis[0].api, api);
    assert_eq!(diff.apis[0].modules.len(), expected.len());
    for (module, expected) in diff.apis[0].modules.iter().zip(expected) {
        let submodules: Vec<_> =
            module.submodules.iter().map(|sub| (sub.subslot, sub.submodule_ident, sub.state.0)).collect();
        assert_eq!((module.slot, module.module_ident, module.state, submodules), expected);
    }
    assert_eq!(written(|out| diff.write(out)), octets);
}

/// The bits with the names of tshark in frames 18, 80, 84 and 336 above; the others from its list of values for each field.
#[rstest]
#[case(0x9800, IdentInfo::NO_SUBMODULE, ArInfo::OWN, 0)]
#[case(0x9000, IdentInfo::WRONG, ArInfo::OWN, 0)]
#[case(0x8800, IdentInfo::SUBSTITUTE, ArInfo::OWN, 0)]
#[case(0x8040, IdentInfo::OK, ArInfo::OWN, SubmoduleState::FAULT)]
#[case(0x8020, IdentInfo::OK, ArInfo::OWN, SubmoduleState::MAINTENANCE_DEMANDED)]
#[case(0x8018, IdentInfo::OK, ArInfo::OWN, SubmoduleState::MAINTENANCE_REQUIRED | SubmoduleState::ADVICE)]
#[case(0x8180, IdentInfo::OK, ArInfo::LOCKED_BY_CONTROLLER, 0)]
#[case(0x8201, IdentInfo::OK, ArInfo::LOCKED_BY_SUPERVISOR, 1)]
#[case(0x8080, IdentInfo::OK, ArInfo::APPLICATION_READY_PENDING, 0)]
fn submodule_state(#[case] state: u16, #[case] ident: IdentInfo, #[case] ar: ArInfo, #[case] flags: u16) {
    assert_eq!(SubmoduleState::new(ident, ar, flags), SubmoduleState(state));
    let state = SubmoduleState(state);
    assert!(state.format_indicator());
    assert_eq!((state.ident_info(), state.ar_info(), state.has(flags)), (ident, ar, true));
    assert_eq!(u16::from(state.add_info()), flags & 7);
}

/// Channel error type, extended type and additional value of each entry.
#[rstest]
#[case::two_entries("record-reads.pcapng", 6, 0x8001, &[(0x8001, 0x8005, 0), (0x8000, 0x8000, 0)])]
#[case::one_entry("record-reads.pcapng", 12, 0x8002, &[(0x8001, 0x8000, 0)])]
#[case::of_another_file("merged-many-devices.pcapng", 314, 0x8001, &[(0x8001, 0x8005, 0), (0x8000, 0x8000, 0)])]
fn diagnosis(#[case] file: &str, #[case] number: usize, #[case] subslot: u16, #[case] expected: &[(u16, u16, u32)]) {
    let Some(octets) = block(file, number, BlockType::DIAGNOSIS_DATA) else { return };
    let [data] = &DiagnosisData::parse_record(&octets).unwrap()[..] else { panic!("not one block") };
    assert_eq!((data.api, data.slot, data.subslot), (Some(0), 0, subslot));
    assert_eq!((data.channel, data.properties.0), (0x8000, 0x0800));
    let AlarmItem::ExtChannel(entries) = &data.item else { panic!("{:?}", data.item) };
    let observed: Vec<_> =
        entries.iter().map(|entry| (entry.channel.error_type.0, entry.ext_error_type, entry.add_value)).collect();
    assert_eq!(observed, expected);
    assert!(entries.iter().all(|entry| (entry.channel.channel, entry.channel.properties.0) == (0x8000, 0x0800)));
    assert_eq!(written(|out| data.write(out)), octets);
}

/// Version 1.0 has no API; tshark dissects the record as slot 1, subslot 2, channel diagnosis, error types 0x9000 and 0x9005.
#[test]
fn diagnosis_of_version_1_0() {
    let octets = hex("0010 0018 0100 0001 0002 8000 0800 8000 8000 0800 9000 8000 0A00 9005");
    let [data] = &DiagnosisData::parse_record(&octets).unwrap()[..] else { panic!("not one block") };
    assert_eq!((data.api, data.slot, data.subslot), (None, 1, 2));
    assert_eq!(data.item.channels().iter().map(|entry| entry.error_type.0).collect::<Vec<_>>(), [0x9000, 0x9005]);
    assert_eq!(written(|out| data.write(out)), octets);
}

/// Slot, module ident, then subslot and submodule ident of each submodule.
type IdentifiedSlot = (u16, u32, Vec<(u16, u32)>);

#[rstest]
#[case::real("implicit-reads-ns.pcapng", 17, BlockType::REAL_IDENTIFICATION, vec![
    (0, 0x1, vec![(1, 0x1), (0x8000, 0x1000), (0x8001, 0x1001)]),
    (1, 0x1001, vec![(1, 0x1001)]),
])]
#[case::filter_submodule("record-reads.pcapng", 2, BlockType::IM0_FILTER_SUBMODULE, vec![
    (0, 0x1, vec![(1, 0x1), (3, 0xFFFF_010A)]),
    (1, 0xFFFF_8140, vec![(1, 0xFFFF_8140)]),
])]
#[case::filter_module("record-reads.pcapng", 2, BlockType::IM0_FILTER_MODULE, vec![(1, 0xFFFF_8140, vec![(1, 0xFFFF_8140)])])]
#[case::filter_device("record-reads.pcapng", 14, BlockType::IM0_FILTER_DEVICE, vec![(0, 0x000F_C700, vec![(1, 0x1)])])]
fn identification(
    #[case] file: &str,
    #[case] number: usize,
    #[case] kind: BlockType,
    #[case] expected: Vec<IdentifiedSlot>,
) {
    let Some(octets) = block(file, number, kind) else { return };
    let [data] = &IdentificationData::parse_record(&octets).unwrap()[..] else { panic!("not one block") };
    assert_eq!(data.kind, kind);
    assert!(data.with_apis);
    assert_eq!((data.apis.len(), data.apis[0].api), (1, 0));
    assert_eq!(data.apis[0].slots.len(), expected.len());
    for (slot, expected) in data.apis[0].slots.iter().zip(expected) {
        let subslots: Vec<_> = slot.subslots.iter().map(|sub| (sub.subslot, sub.submodule_ident)).collect();
        assert_eq!((slot.slot, slot.module_ident, subslots), expected);
    }
    assert_eq!(written(|out| data.write(out)), octets);
}

/// Version 1.0 has one list of slots; bytes built by hand, slot 1 with module 7 and submodule 8 at subslot 1.
#[test]
fn identification_of_version_1_0() {
    let octets = hex("0013 0012 0100 0001 0001 00000007 0001 0001 00000008");
    let [data] = &IdentificationData::parse_record(&octets).unwrap()[..] else { panic!("not one block") };
    assert!(!data.with_apis);
    assert_eq!((data.apis[0].slots[0].slot, data.apis[0].slots[0].module_ident), (1, 7));
    assert_eq!(written(|out| data.write(out)), octets);
}

#[test]
fn api_data() {
    let Some(octets) = block("implicit-reads-ns.pcapng", 13, BlockType::API_DATA) else { return };
    let data = ApiData::parse(&octets).unwrap();
    assert_eq!(data.apis, [0]);
    assert_eq!(written(|out| data.write(out)), octets);
}

/// The two aborts of the capture, after the Ethernet header and the frame ID 0xFE01.
#[rstest]
#[case(584, 15)]
#[case(602, 2)]
fn abort(#[case] number: usize, #[case] code: u8) {
    let Some(path) = shared("captures/profinet/office-noise-versamax.pcap") else { return };
    let frame = &packets(&path)[number - 1];
    assert_eq!(frame[12..16], [0x88, 0x92, 0xFE, 0x01]);
    let pdu = RtaPdu::parse(&frame[16..]).unwrap();
    let header = pdu.header;
    assert_eq!((header.dst_endpoint, header.src_endpoint), (0x8001, 0x8001));
    assert_eq!((header.kind, header.version, header.window_size(), header.tack()), (RtaKind::ERR, 1, 1, false));
    assert_eq!((header.send_seq_num, header.ack_seq_num), (0xFFFF, 0xFFFE));
    let RtaBody::Error { status, more } = &pdu.body else { panic!("{:?}", pdu.body) };
    assert_eq!((status.error_code.0, status.error_decode.0), (0xCF, 0x81));
    assert_eq!((status.error_code1, status.error_code2), (253, code));
    assert!(more.is_empty());
    assert_eq!(written(|out| pdu.write(out)), frame[16..32]);
}
