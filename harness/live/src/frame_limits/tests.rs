//! Frames that hide a change: each is built here byte by byte or from blocks, without the controllers of the harness.

use super::*;
use crate::fence::Fence;
use crate::guard::Guard;
use results::bench_file::{DeviceClaim, LinkSpec};
use rstest::rstest;
use std::net::{Ipv4Addr, SocketAddrV4};
use wire::datagram::write_udp;
use wire::ethernet::{EtherType, FrameHeader};
use wire::profidrive::{ParameterAddress, ParameterFormat, ParameterRequest, ParameterValue};
use wire::profinet::blocks::connect::{
    ArBlockReq, ArType, Connect, ConnectContent, DataDescription, ExpectedModule, ExpectedSubmodule,
    ExpectedSubmoduleBlockReq, FrameObject, IocrApi, IocrBlockReq, IocrType, SubmoduleProperties,
};
use wire::profinet::blocks::record::{RecordHeader, WriteRequest};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ResetMode};
use wire::profinet::rpc::{NdrRequest, Opnum, PacketType, RpcHeader, RpcPdu, Uuid, fragments};
use wire::profinet::rt::{ApduStatus, DataStatus};

const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);
const OTHER: Mac = Mac([2, 0, 0, 0, 1, 1]);
const OURS: Mac = Mac([2, 0, 0, 0, 0, 1]);
/// Bit 12 of G1_STW, after the two bytes of STW2_ENC.
const PRESET: [u8; 4] = [0, 0, 0x10, 0];
const PARK: [u8; 4] = [0, 0, 0x40, 0];

fn with(change: impl Fn(&mut Consents)) -> Consents {
    let mut consents = Consents::default();
    change(&mut consents);
    consents
}

fn everything() -> Consents {
    Consents {
        factory_reset: true,
        set_name: true,
        set_ip: true,
        set_address: true,
        im_records: true,
        lock_address: true,
        nvm_write: 10,
        position_reference: true,
        firmware: true,
        overstress: true,
        alone: true,
    }
}

fn limits(manual: &str, consent: Consents, uncoupled: bool) -> FrameLimits {
    let manuals = suite_yaml::load(&suites::sources(), Some(manual)).unwrap_or_else(|errors| panic!("{errors}"));
    let claim = DeviceClaim { manual: manual.to_owned(), variant: String::new() };
    let mut bench = BenchFile::bare(LinkSpec::Nic("eth1".to_owned()), claim);
    bench.consent = consent;
    bench.stand.shaft.uncoupled = uncoupled;
    FrameLimits::new(&manuals[0].device, &bench, consent.nvm_write)
}

/// The filter at the wire with these limits.
fn guard(consent: Consents, uncoupled: bool) -> Guard {
    let mut guard = Guard::new(Some(DEVICE), consent, vec!["/upgrade.htm".to_owned()]);
    *guard.limits_mut() = Some(Box::new(limits("lika-xac77-profinet", consent, uncoupled)));
    guard
}

fn udp(payload: &[u8]) -> Vec<u8> {
    let at = |last| SocketAddrV4::new(Ipv4Addr::new(192, 168, 0, last), 0x8894);
    let mut frame = Vec::new();
    write_udp((OURS, at(1)), (DEVICE, at(10)), payload, &mut frame).expect("a short payload");
    frame
}

fn header(opnum: Opnum) -> RpcHeader {
    let mut header = RpcHeader::new(PacketType::REQUEST, wire::octets::ByteOrder::Big);
    (header.interface, header.opnum) = (Uuid::DEVICE_INTERFACE, opnum);
    header
}

fn call(opnum: Opnum, blocks: &[u8]) -> Vec<u8> {
    let header = header(opnum);
    udp(&RpcPdu::new(header, &NdrRequest::body(header.order(), 4096, blocks)).to_vec())
}

fn write(slot: u16, subslot: u16, index: u16, data: &[u8]) -> WriteRequest {
    let header = RecordHeader { slot_number: slot, subslot_number: subslot, index, ..RecordHeader::default() };
    WriteRequest::of(header, data.to_vec())
}

fn written(request: &WriteRequest) -> Vec<u8> {
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    call(Opnum::WRITE, &blocks)
}

fn change(numbers: &[u16]) -> Vec<u8> {
    let value =
        |number: &u16| (ParameterAddress::value(*number, 0), ParameterValue::new(ParameterFormat(0x42), 1, vec![0, 1]));
    let mut octets = Vec::new();
    ParameterRequest::change_values(1, 1, numbers.iter().map(value).collect()).write(&mut octets);
    octets
}

fn parameters(numbers: &[u16]) -> Vec<u8> {
    written(&write(1, 1, 0xB02E, &change(numbers)))
}

/// A Connect with a submodule of this ident at slot 1, subslot 2, whose four bytes of outputs come first.
fn connect(ident: u32, ar_type: ArType) -> Vec<u8> {
    let submodule = ExpectedSubmodule {
        subslot_number: 2,
        submodule_ident_number: ident,
        // Inputs and outputs.
        submodule_properties: SubmoduleProperties(3),
        data_descriptions: vec![DataDescription::input(12), DataDescription::output(4)],
    };
    let module = ExpectedModule { slot_number: 1, submodules: vec![submodule], ..ExpectedModule::default() };
    let object = FrameObject { slot_number: 1, subslot_number: 2, frame_offset: 0 };
    let api = IocrApi { io_data_objects: vec![object], ..IocrApi::default() };
    let output =
        IocrBlockReq { iocr_type: IocrType::OUTPUT, data_length: 40, apis: vec![api], ..IocrBlockReq::default() };
    let connect = Connect::of([
        ConnectContent::ArReq(ArBlockReq { ar_type, ..ArBlockReq::default() }),
        ConnectContent::IocrReq(output),
        ConnectContent::ExpectedSubmodule(ExpectedSubmoduleBlockReq { modules: vec![module] }),
    ]);
    call(Opnum::CONNECT, &connect.to_vec())
}

/// A cyclic frame from `source` with these outputs and a good status.
fn outputs_from(source: Mac, outputs: &[u8]) -> Vec<u8> {
    let mut frame = Vec::new();
    FrameHeader::new(DEVICE, source, EtherType::PROFINET).write(&mut frame);
    let mut data = vec![0; 40];
    data[..outputs.len()].copy_from_slice(outputs);
    data[4] = 0x80;
    let status = ApduStatus { cycle_counter: 0, data_status: DataStatus::NORMAL, transfer_status: 0 };
    wire::profinet::rt::CyclicFrame {
        frame_id: wire::profinet::rt::FrameId(0x8001),
        data: &data,
        status,
        padding: &[],
    }
    .write(&mut frame);
    frame
}

fn outputs(outputs: &[u8]) -> Vec<u8> {
    outputs_from(OURS, outputs)
}

/// The filter after a Connect with telegram 81.
fn connected(consent: Consents, uncoupled: bool) -> Guard {
    let mut guard = guard(consent, uncoupled);
    assert!(guard.allows(&connect(81, ArType::IOCAR_SINGLE)), "{:?}", guard.withheld_frames().summary());
    guard
}

#[rstest]
#[case::without_consent(with(|of| of.nvm_write = 1), true, false)]
#[case::coupled(everything(), false, false)]
#[case::without_memory(with(|of| of.position_reference = true), true, false)]
#[case::permitted(with(|of| (of.position_reference, of.nvm_write) = (true, 1)), true, true)]
fn a_preset_hides_in_an_output_bit(#[case] consent: Consents, #[case] uncoupled: bool, #[case] goes: bool) {
    let mut guard = connected(consent, uncoupled);
    assert!(guard.allows(&outputs(&PARK)), "{:?}", guard.withheld_frames().summary());
    assert_eq!(guard.allows(&outputs(&PRESET)), goes, "{:?}", guard.withheld_frames().summary());
    assert_eq!(guard.withheld_frames().withheld().is_none(), goes);
}

#[test]
fn a_preset_that_is_held_is_written_once() {
    let mut guard = connected(with(|of| (of.position_reference, of.nvm_write) = (true, 1)), true);
    assert!(guard.allows(&outputs(&PRESET)) && guard.allows(&outputs(&PRESET)));
    assert!(guard.allows(&outputs(&[0; 4])));
    assert!(!guard.allows(&outputs(&PRESET)), "the second one is beyond the limit");
    let limits = guard.limits_mut().as_mut().expect("the limits");
    assert_eq!(limits.take_new_changes(), [change::POSITION_REFERENCE, change::MEMORY]);
    assert!(limits.take_new_changes().is_empty(), "once");
}

/// STW2_ENC: bits 0 to 9 and 11 are reserved or not used; what is after the four bytes is a status, of which five bits are reserved.
#[rstest]
#[case::reserved(&[0x00, 0x01, 0, 0])]
#[case::not_used(&[0x00, 0x80, 0, 0])]
#[case::not_used_of_the_sensor(&[0, 0, 0, 0x01])]
#[case::after_the_outputs(&[0, 0, 0, 0, 0x80, 0x10])]
fn an_output_without_a_name_stays_zero(#[case] octets: &[u8]) {
    let mut guard = connected(everything(), true);
    assert!(!guard.allows(&outputs(octets)));
}

#[test]
fn outputs_are_those_of_the_connection() {
    let mut guard = guard(everything(), true);
    assert!(!guard.allows(&outputs(&PARK)), "before a Connect");
    assert!(guard.allows(&connect(99, ArType::IOCAR_SINGLE)));
    assert!(!guard.allows(&outputs(&PARK)), "of a submodule without a name");
    assert!(guard.allows(&outputs(&[0; 4])));
    assert!(guard.allows(&connect(81, ArType::IOCAR_SINGLE)) && guard.allows(&outputs(&PARK)));
    assert!(!guard.allows(&outputs_from(OTHER, &PARK)), "from another controller");
    let mut unsaid = self::guard(with(|of| of.nvm_write = 9), true);
    assert!(!unsaid.allows(&connect(81, ArType::IOSAR)), "a supervisor takes the device from others");
}

#[rstest]
#[case::save(&[971], with(|of| of.set_name = true), false)]
#[case::save_permitted(&[971], with(|of| of.nvm_write = 1), true)]
#[case::save_twice(&[971, 971], with(|of| of.nvm_write = 1), false)]
#[case::save_among_others(&[65000, 971], Consents::default(), false)]
#[case::preset_value(&[65000], Consents::default(), true)]
#[case::reset_of_the_drive(&[972], everything(), false)]
#[case::reset_among_others(&[65000, 972], everything(), false)]
#[case::without_a_name(&[60999], everything(), false)]
#[case::only_read(&[964], everything(), false)]
fn parameters_are_judged_one_by_one(#[case] numbers: &[u16], #[case] consent: Consents, #[case] goes: bool) {
    let mut guard = guard(consent, true);
    assert_eq!(guard.allows(&parameters(numbers)), goes, "{:?}", guard.withheld_frames().summary());
    // The same in a write of several records, and by an access that the manual does not name.
    let inner = [write(1, 1, 0xB02F, &change(numbers))];
    let mut guard = self::guard(consent, true);
    assert_eq!(guard.allows(&written(&WriteRequest::multiple(Uuid::NIL, 1, &inner))), goes);
}

#[test]
fn a_request_that_cannot_be_read_is_not_sent_unless_it_reads() {
    let mut guard = guard(everything(), true);
    let mut longer = change(&[65000]);
    longer.extend([0x10, 0x01]);
    assert!(!guard.allows(&written(&write(1, 1, 0xB02E, &longer))), "more values than it says");
    let mut unknown = change(&[971]);
    unknown[1] = 0x42;
    let mut without = self::guard(Consents::default(), true);
    assert!(!without.allows(&written(&write(1, 1, 0xB02E, &unknown))), "perhaps taken for a change");
    assert!(guard.allows(&written(&write(1, 1, 0xB02E, &[1, 1, 1, 9, 0x10]))), "it reads");
    assert!(!guard.allows(&call(Opnum::WRITE, &[0, 8, 0, 4])), "a write that ends too early");
}

#[test]
fn the_last_fragment_of_a_call_is_judged_as_the_whole() {
    let mut guard = guard(everything(), true);
    let mut blocks = Vec::new();
    write(1, 1, 0xB02E, &change(&[972])).write(&mut blocks);
    let header = header(Opnum::WRITE);
    let pieces = fragments(&header, &NdrRequest::body(header.order(), 4096, &blocks), 48);
    assert!(pieces.len() > 2);
    let sent: Vec<bool> = pieces.iter().map(|piece| guard.allows(&udp(piece))).collect();
    assert_eq!(sent.iter().filter(|sent| !**sent).count(), 1);
    assert_eq!(sent.last(), Some(&false));
}

/// The start record has a bit without a name in byte 0 (bit 6), and 31 bytes.
#[rstest]
#[case::named(1, 0xBF00, &[0x03; 1], 31, true)]
#[case::bit_without_a_name(1, 0xBF00, &[0x40], 31, false)]
#[case::longer(1, 0xBF00, &[0], 32, false)]
#[case::elsewhere(2, 0xBF00, &[0], 31, false)]
#[case::without_a_name(1, 0xBF01, &[0], 31, false)]
#[case::identification_with_its_serial_number(1, 0xAFF0, &[0], 60, false)]
#[case::plant_tag_that_the_manual_does_not_have(1, 0xAFF1, &[0], 60, false)]
#[case::port(1, 0x802B, &[0], 20, false)]
fn only_records_with_a_name_are_written(
    #[case] subslot: u16,
    #[case] index: u16,
    #[case] begin: &[u8],
    #[case] length: usize,
    #[case] goes: bool,
) {
    let mut data = vec![0; length];
    data[..begin.len()].copy_from_slice(begin);
    let mut guard = guard(everything(), true);
    assert_eq!(guard.allows(&written(&write(1, subslot, index, &data))), goes);
}

#[test]
fn plant_tags_need_their_consent_and_a_memory_write() {
    let tag = |limits: &mut FrameLimits| {
        let device = limits.device.clone();
        let record = device.records.iter().find(|record| record.index == 0xAFF1).expect("I&M1");
        let at = device.submodules.get(record.at).expect("its submodule");
        limits.judge_frame(&written(&write(at.slot, at.subslot, 0xAFF1, &[0; 60])))
    };
    assert!(tag(&mut limits("profinet-io", with(|of| of.nvm_write = 1), true)).is_err());
    assert!(tag(&mut limits("profinet-io", with(|of| of.im_records = true), true)).is_err());
    assert!(tag(&mut limits("profinet-io", with(|of| (of.im_records, of.nvm_write) = (true, 1)), true)).is_ok());
}

fn set(qualifier: BlockQualifier, value: DcpValue) -> Dcp {
    Dcp::set(7, vec![DcpBlock::set(qualifier, value)])
}

fn dcp(to: Mac, dcp: &Dcp) -> Vec<u8> {
    let mut frame = Vec::new();
    dcp.write_frame(to, OURS, &mut frame);
    frame
}

#[rstest]
#[case::permanent_address(set(BlockQualifier::PERMANENT, DcpValue::IpParameter(IpParameter::NONE)), with(|of| of.nvm_write = 9), false)]
#[case::permanent_address_beyond_the_limit(set(BlockQualifier::PERMANENT, DcpValue::IpParameter(IpParameter::NONE)), with(|of| of.set_ip = true), false)]
#[case::permanent_address_permitted(set(BlockQualifier::PERMANENT, DcpValue::IpParameter(IpParameter::NONE)), with(|of| (of.set_ip, of.nvm_write) = (true, 1)), true)]
#[case::name(set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(b"a".to_vec())), with(|of| of.nvm_write = 9), false)]
#[case::name_beyond_the_limit(set(BlockQualifier::TEMPORARY, DcpValue::NameOfStation(b"a".to_vec())), with(|of| of.set_name = true), false)]
#[case::reset(Dcp::reset_to_factory(7, ResetMode::COMMUNICATION), with(|of| of.nvm_write = 9), false)]
#[case::older_reset(Dcp::factory_reset(7), with(|of| of.nvm_write = 9), false)]
#[case::reset_permitted(Dcp::factory_reset(7), with(|of| (of.factory_reset, of.nvm_write) = (true, 1)), true)]
#[case::firmware_image(Dcp::reset_to_factory(7, ResetMode::FACTORY_IMAGE), everything(), false)]
#[case::mac(set(BlockQualifier::PERMANENT, DcpValue::Mac(OTHER)), everything(), false)]
#[case::device_id(set(BlockQualifier::PERMANENT, DcpValue::DeviceId { vendor_id: 1, device_id: 2 }), everything(), false)]
#[case::get(Dcp::get(2, vec![Element::DEVICE_ID]), Consents::default(), true)]
#[case::signal(Dcp::signal(3), Consents::default(), true)]
fn dcp_changes_need_their_consents(#[case] request: Dcp, #[case] consent: Consents, #[case] goes: bool) {
    let mut guard = guard(consent, true);
    assert_eq!(guard.allows(&dcp(DEVICE, &request)), goes, "{:?}", guard.withheld_frames().summary());
    let mut all = self::guard(everything(), true);
    assert!(!all.allows(&dcp(OTHER, &request)), "another station");
}

/// A frame with TCP to the web server.
fn request(data: &[u8]) -> Vec<u8> {
    let mut frame = Vec::new();
    FrameHeader::new(DEVICE, OURS, EtherType::IPV4).write(&mut frame);
    frame.extend([0x45, 0]);
    frame.extend((40 + data.len() as u16).to_be_bytes());
    frame.extend([0, 0, 0, 0, 64, 6, 0, 0, 192, 168, 0, 1, 192, 168, 0, 10]);
    frame.extend([0xC0, 0x30, 0, 80, 0, 0, 0, 1, 0, 0, 0, 1, 0x50, 0x18, 0x10, 0, 0, 0, 0, 0]);
    frame.extend(data);
    frame
}

#[test]
fn no_form_is_submitted_and_no_other_packet_sent() {
    let mut guard = guard(everything(), true);
    assert!(guard.allows(&request(b"")));
    assert!(!guard.allows(&request(b"POST /preset.htm HTTP/1.1")));
    assert!(!guard.allows(&request(b"GET /upgrade.htm HTTP/1.1")));
    assert!(!guard.allows(&udp(&[0x30, 0x03, 2, 1, 0])), "no call: perhaps SNMP");
    let mut lldp = Vec::new();
    FrameHeader::new(Mac::LLDP_MULTICAST, OURS, EtherType::LLDP).write(&mut lldp);
    lldp.extend([0; 46]);
    assert!(!guard.allows(&lldp), "a switch is between");
}

/// A frame with data of master 2 to station 8 according to IEC 61158-4-3: SD2, twice the length, SD2, and so on.
fn bus_frame(to: u8, saps: Option<(u8, u8)>, data: &[u8]) -> Vec<u8> {
    let mut body = vec![if saps.is_some() { to | 0x80 } else { to }, if saps.is_some() { 0x82 } else { 2 }, 0x7D];
    body.extend(saps.into_iter().flat_map(|(dsap, ssap)| [dsap, ssap]));
    body.extend(data);
    let (length, sum) = (body.len() as u8, body.iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet)));
    [&[0x68, length, length, 0x68][..], &body, &[sum, 0x16]].concat()
}

fn fence(manual: &str, consent: Consents, uncoupled: bool, others: &[u8]) -> Fence {
    let mut fence = Fence::new(8, consent);
    fence.set_other_stations(others.to_vec());
    *fence.limits_mut() = Some(Box::new(limits(manual, consent, uncoupled)));
    fence
}

const AMT58: &str = "datalogic-amt58-profibus";
const A3M60: &str = "sick-a3m60-profibus";

#[rstest]
#[case::without_consent(with(|of| of.nvm_write = 9), true, false)]
#[case::coupled(everything(), false, false)]
#[case::permitted(everything(), true, true)]
fn a_preset_hides_in_data_exchange(#[case] consent: Consents, #[case] uncoupled: bool, #[case] goes: bool) {
    let mut fence = fence(AMT58, consent, uncoupled, &[]);
    let preset = bus_frame(8, None, &[0x80, 0, 0, 5]);
    assert!(!fence.allows(&preset), "before Chk_Cfg no output is known");
    assert!(fence.allows(&bus_frame(8, None, &[0; 4])));
    assert!(fence.allows(&bus_frame(8, Some((62, 62)), &[0xD1, 0xE1])));
    assert!(fence.allows(&bus_frame(8, None, &[0, 0, 0, 5])), "{:?}", fence.withheld_frames().summary());
    assert_eq!(fence.allows(&preset), goes, "{:?}", fence.withheld_frames().summary());
}

#[rstest]
#[case::save(A3M60, 51, &change(&[971]), Consents::default(), false)]
#[case::save_permitted(A3M60, 51, &change(&[971]), with(|of| of.nvm_write = 1), true)]
#[case::save_by_class_2(A3M60, 7, &change(&[971]), Consents::default(), false)]
#[case::reset(A3M60, 51, &change(&[972]), everything(), false)]
#[case::without_a_name(A3M60, 51, &change(&[60999]), everything(), false)]
fn parameters_on_profibus(
    #[case] manual: &str,
    #[case] sap: u8,
    #[case] request: &[u8],
    #[case] consent: Consents,
    #[case] goes: bool,
) {
    let mut fence = fence(manual, consent, true, &[]);
    let data = [&[0x5F, 1, 47, request.len() as u8][..], request].concat();
    let master = if sap == 51 { 51 } else { 50 };
    assert_eq!(
        fence.allows(&bus_frame(8, Some((sap, master)), &data)),
        goes,
        "{:?}",
        fence.withheld_frames().summary()
    );
}

#[test]
fn addresses_other_slaves_records_and_parameter_data_on_profibus() {
    let lock = bus_frame(8, Some((55, 62)), &[9, 0x16, 0x55, 1]);
    let without_lock = with(|of| (of.set_address, of.nvm_write) = (true, 9));
    assert!(!fence(AMT58, without_lock, true, &[]).allows(&lock));
    assert!(fence(AMT58, everything(), true, &[]).allows(&lock));
    assert!(!fence(AMT58, Consents { nvm_write: 0, ..everything() }, true, &[]).allows(&lock), "it is stored");
    let mut near_others = fence(AMT58, Consents { alone: false, ..everything() }, true, &[9]);
    let clear = bus_frame(127, Some((58, 62)), &[0x02, 0]);
    assert!(!near_others.allows(&clear), "the other slave obeys too");
    assert!(fence(AMT58, Consents::default(), true, &[]).allows(&clear));
    let record = bus_frame(8, Some((51, 51)), &[0x5F, 1, 2, 1, 0]);
    assert!(!fence(AMT58, everything(), true, &[]).allows(&record), "no manual names it");
    // Seven standard bytes, three of DP-V1, then user parameter data, whose bit 2 is reserved.
    let prm = |first: u8| {
        let mut data = vec![0x88, 1, 1, 11, 0x16, 0x55, 0, 0, 0, 0, first];
        data.extend([0; 10]);
        bus_frame(8, Some((61, 62)), &data)
    };
    assert!(fence(AMT58, everything(), true, &[]).allows(&prm(0x0A)));
    assert!(!fence(AMT58, everything(), true, &[]).allows(&prm(0x0E)));
    let mut damaged = bus_frame(8, None, &[0x80, 0, 0, 5]);
    damaged[8] ^= 1;
    assert!(!fence(AMT58, everything(), true, &[]).allows(&damaged), "a slave may take it all the same");
}
