//! Connect with one invalid field, and the status of the refusal.

use super::bench::*;
use alloc::vec::Vec;
use rstest::rstest;
use wire::ethernet::Mac;
use wire::profinet::blocks::RawBlock;
use wire::profinet::blocks::connect::{
    AlarmCrBlockReq, AlarmCrProperties, ArBlockReq, ArProperties, ArType, Connect, ConnectContent, ExpectedModule,
    IocrBlockReq, IocrProperties, IocrType, RtClass, SubmoduleProperties, SubmoduleType,
};
use wire::profinet::rpc::{Opnum, Uuid};
use wire::profinet::status::PnioStatus;

/// The status, as bytes, of a Connect that `spoil` has changed.
fn answer(spoil: impl FnOnce(&mut Vec<ConnectContent>)) -> [u8; 4] {
    let mut bench = StackBench::new();
    let mut contents = connect_blocks(&modules());
    spoil(&mut contents);
    let (status, blocks) = bench.operate(Opnum::CONNECT, &Connect::of(contents).to_vec());
    assert!(status.is_ok() || blocks.is_empty());
    assert_eq!(bench.device.application().log.is_empty(), !status.is_ok());
    u32::from(status).to_be_bytes()
}

fn ar(spoil: impl FnOnce(&mut ArBlockReq)) -> [u8; 4] {
    answer(|contents| {
        if let ConnectContent::ArReq(block) = &mut contents[0] {
            spoil(block)
        }
    })
}

fn iocrs(kind: IocrType, spoil: impl FnOnce(&mut IocrBlockReq)) -> [u8; 4] {
    let at = if kind == IocrType::INPUT { 1 } else { 2 };
    answer(|contents| {
        if let ConnectContent::IocrReq(block) = &mut contents[at] {
            spoil(block)
        }
    })
}

fn alarms(spoil: impl FnOnce(&mut AlarmCrBlockReq)) -> [u8; 4] {
    answer(|contents| {
        if let Some(ConnectContent::AlarmCrReq(block)) = contents.last_mut() {
            spoil(block)
        }
    })
}

/// Changes the expected module of the encoder and nothing else.
fn expected(spoil: impl FnOnce(&mut ExpectedModule)) -> [u8; 4] {
    answer(|contents| {
        if let ConnectContent::ExpectedSubmodule(block) = &mut contents[4] {
            spoil(&mut block.modules[0])
        }
    })
}

#[test]
fn the_unchanged_connect_is_accepted() {
    assert_eq!(answer(|_| {}), [0; 4]);
}

#[rstest]
#[case::kind(|ar: &mut ArBlockReq| ar.ar_type = ArType::IOCAR_SR, 4)]
#[case::uuid(|ar: &mut ArBlockReq| ar.ar_uuid = Uuid::NIL, 5)]
#[case::group_address(|ar: &mut ArBlockReq| ar.cm_initiator_mac_add = Mac::BROADCAST, 7)]
#[case::no_address(|ar: &mut ArBlockReq| ar.cm_initiator_mac_add = Mac::ZERO, 7)]
#[case::object(|ar: &mut ArBlockReq| ar.cm_initiator_object_uuid = Uuid::NIL, 8)]
#[case::state(|ar: &mut ArBlockReq| ar.ar_properties = ArProperties(0x12), 9)]
#[case::reserved(|ar: &mut ArBlockReq| ar.ar_properties = ArProperties(0x1011), 9)]
#[case::companion(|ar: &mut ArBlockReq| ar.ar_properties = ArProperties(0x0211), 9)]
#[case::parameter_server(|ar: &mut ArBlockReq| ar.ar_properties = ArProperties(0x01), 9)]
#[case::access_of_controller(|ar: &mut ArBlockReq| ar.ar_properties = ArProperties(0x0111), 9)]
#[case::no_timeout(|ar: &mut ArBlockReq| ar.cm_initiator_activity_timeout_factor = 0, 10)]
#[case::long_timeout(|ar: &mut ArBlockReq| ar.cm_initiator_activity_timeout_factor = 1001, 10)]
#[case::port(|ar: &mut ArBlockReq| ar.initiator_udp_rt_port = 0x3FF, 11)]
#[case::no_name(|ar: &mut ArBlockReq| ar.cm_initiator_station_name.clear(), 12)]
#[case::name(|ar: &mut ArBlockReq| ar.cm_initiator_station_name = b"no_name".to_vec(), 13)]
fn a_wrong_ar_block(#[case] spoil: fn(&mut ArBlockReq), #[case] field: u8) {
    assert_eq!(ar(spoil), [0xDB, 0x81, 1, field]);
}

#[rstest]
#[case::kind(|iocr: &mut IocrBlockReq| iocr.iocr_type = IocrType::MULTICAST_PROVIDER, 4)]
#[case::reference(|iocr: &mut IocrBlockReq| iocr.iocr_reference = 2, 5)]
#[case::ether_type(|iocr: &mut IocrBlockReq| iocr.lt = 0x0800, 6)]
#[case::class_3(|iocr: &mut IocrBlockReq| iocr.iocr_properties = RtClass::RT_CLASS_3.into(), 7)]
#[case::reserved(|iocr: &mut IocrBlockReq| iocr.iocr_properties = IocrProperties(0x12), 7)]
#[case::short(|iocr: &mut IocrBlockReq| iocr.data_length = 39, 8)]
#[case::long(|iocr: &mut IocrBlockReq| iocr.data_length = 1441, 8)]
#[case::frame_id_of_class_1(|iocr: &mut IocrBlockReq| iocr.frame_id = 0xC001, 9)]
#[case::frame_id_of_multicast(|iocr: &mut IocrBlockReq| iocr.frame_id = 0xBC00, 9)]
#[case::no_frame_id(|iocr: &mut IocrBlockReq| iocr.frame_id = 0xFFFF, 9)]
#[case::send_clock_0(|iocr: &mut IocrBlockReq| iocr.send_clock_factor = 0, 10)]
#[case::send_clock_33(|iocr: &mut IocrBlockReq| iocr.send_clock_factor = 33, 10)]
#[case::reduction_0(|iocr: &mut IocrBlockReq| iocr.reduction_ratio = 0, 11)]
#[case::reduction_3(|iocr: &mut IocrBlockReq| iocr.reduction_ratio = 3, 11)]
#[case::reduction_1024(|iocr: &mut IocrBlockReq| iocr.reduction_ratio = 1024, 11)]
#[case::phase_0(|iocr: &mut IocrBlockReq| iocr.phase = 0, 12)]
#[case::phase_above_reduction(|iocr: &mut IocrBlockReq| iocr.phase = 3, 12)]
#[case::send_offset(|iocr: &mut IocrBlockReq| iocr.frame_send_offset = 1_000_000, 14)]
#[case::watchdog_0(|iocr: &mut IocrBlockReq| iocr.watchdog_factor = 0, 15)]
#[case::watchdog_long(|iocr: &mut IocrBlockReq| iocr.watchdog_factor = 961, 15)]
#[case::hold_0(|iocr: &mut IocrBlockReq| iocr.data_hold_factor = 0, 16)]
#[case::hold_long(|iocr: &mut IocrBlockReq| iocr.data_hold_factor = 961, 16)]
#[case::tag(|iocr: &mut IocrBlockReq| iocr.iocr_tag_header = 0xA000, 17)]
#[case::no_api(|iocr: &mut IocrBlockReq| iocr.apis.clear(), 19)]
#[case::api(|iocr: &mut IocrBlockReq| iocr.apis[0].api = 7, 20)]
#[case::data_missing(|iocr: &mut IocrBlockReq| iocr.apis[1].io_data_objects.retain(|data| data.subslot_number != 2), 21)]
#[case::data_twice(|iocr: &mut IocrBlockReq| { let twice = iocr.apis[0].io_data_objects[0]; iocr.apis[0].io_data_objects.push(twice); }, 23)]
#[case::slot(|iocr: &mut IocrBlockReq| iocr.apis[0].io_data_objects[0].slot_number = 9, 22)]
#[case::subslot(|iocr: &mut IocrBlockReq| iocr.apis[1].io_data_objects[1].subslot_number = 9, 23)]
#[case::overlap(|iocr: &mut IocrBlockReq| iocr.apis[0].io_data_objects[1].frame_offset = 2, 24)]
#[case::beyond_the_data(|iocr: &mut IocrBlockReq| iocr.apis[1].io_data_objects[0].frame_offset = 24, 24)]
#[case::status_missing(|iocr: &mut IocrBlockReq| iocr.apis[1].iocs.clear(), 25)]
#[case::status_slot(|iocr: &mut IocrBlockReq| iocr.apis[1].iocs[0].slot_number = 9, 26)]
#[case::status_subslot(|iocr: &mut IocrBlockReq| iocr.apis[1].iocs[0].subslot_number = 1, 27)]
#[case::status_overlap(|iocr: &mut IocrBlockReq| iocr.apis[1].iocs[0].frame_offset = 16, 28)]
fn a_wrong_iocr_block(#[case] spoil: fn(&mut IocrBlockReq), #[case] field: u8) {
    let spoil_input = |iocr: &mut IocrBlockReq| {
        // Sorts by API, so that the cases above can use fixed indices: slot 0 is first, the telegram second.
        iocr.apis.sort_by_key(|api| api.api);
        spoil(iocr);
    };
    assert_eq!(iocrs(IocrType::INPUT, spoil_input), [0xDB, 0x81, 2, field]);
}

#[rstest]
#[case::longest_watchdog(|iocr: &mut IocrBlockReq| iocr.watchdog_factor = 960)]
#[case::any_offset_in_the_cycle(|iocr: &mut IocrBlockReq| iocr.frame_send_offset = 999_999)]
#[case::without_data_left_out(|iocr: &mut IocrBlockReq| iocr.apis.retain(|api| api.api != 0))]
#[case::last_phase(|iocr: &mut IocrBlockReq| iocr.phase = 2)]
#[case::longest(|iocr: &mut IocrBlockReq| iocr.data_length = 1440)]
#[case::class_1(|iocr: &mut IocrBlockReq| {
    iocr.iocr_properties = RtClass::RT_CLASS_1.into();
    iocr.frame_id = 0xC001;
})]
fn an_iocr_block_at_its_limits_is_accepted(#[case] change: fn(&mut IocrBlockReq)) {
    assert_eq!(iocrs(IocrType::INPUT, change), [0; 4]);
}

#[rstest]
#[case::module_ident(|module: &mut ExpectedModule| module.module_ident_number = 0, 7)]
#[case::module_properties(|module: &mut ExpectedModule| module.module_properties = 1, 8)]
#[case::no_submodule(|module: &mut ExpectedModule| module.submodules.clear(), 9)]
#[case::subslot_twice(|module: &mut ExpectedModule| module.submodules[0].subslot_number = 2, 10)]
#[case::shared_input(|module: &mut ExpectedModule| module.submodules[1].submodule_properties = SubmoduleProperties(7), 12)]
#[case::data_without_status(|module: &mut ExpectedModule| module.submodules[1].submodule_properties = SubmoduleProperties(0x23), 12)]
#[case::direction(|module: &mut ExpectedModule| module.submodules[1].data_descriptions[1].data_description = 1, 13)]
#[case::input_length(|module: &mut ExpectedModule| module.submodules[1].data_descriptions[0].submodule_data_length = 15, 14)]
#[case::output_length(|module: &mut ExpectedModule| module.submodules[1].data_descriptions[1].submodule_data_length = 6, 14)]
#[case::provider_status(|module: &mut ExpectedModule| module.submodules[1].data_descriptions[1].length_iops = 2, 15)]
#[case::consumer_status(|module: &mut ExpectedModule| module.submodules[1].data_descriptions[1].length_iocs = 0, 16)]
fn a_wrong_expected_submodule_block(#[case] spoil: fn(&mut ExpectedModule), #[case] field: u8) {
    assert_eq!(expected(spoil), [0xDB, 0x81, 3, field]);
}

#[rstest]
#[case::kind(|alarm: &mut AlarmCrBlockReq| alarm.alarm_cr_type = 2, 4)]
#[case::ether_type(|alarm: &mut AlarmCrBlockReq| alarm.lt = 0x0800, 5)]
#[case::over_udp(|alarm: &mut AlarmCrBlockReq| alarm.alarm_cr_properties = AlarmCrProperties::TRANSPORT_UDP, 6)]
#[case::timeout_0(|alarm: &mut AlarmCrBlockReq| alarm.rta_timeout_factor = 0, 7)]
#[case::timeout_101(|alarm: &mut AlarmCrBlockReq| alarm.rta_timeout_factor = 101, 7)]
#[case::retries_2(|alarm: &mut AlarmCrBlockReq| alarm.rta_retries = 2, 8)]
#[case::retries_16(|alarm: &mut AlarmCrBlockReq| alarm.rta_retries = 16, 8)]
#[case::short(|alarm: &mut AlarmCrBlockReq| alarm.max_alarm_data_length = 199, 10)]
#[case::long(|alarm: &mut AlarmCrBlockReq| alarm.max_alarm_data_length = 1433, 10)]
#[case::high_tag(|alarm: &mut AlarmCrBlockReq| alarm.alarm_cr_tag_header_high = 0xA000, 11)]
#[case::low_tag(|alarm: &mut AlarmCrBlockReq| alarm.alarm_cr_tag_header_low = 0xC000, 12)]
fn a_wrong_alarm_cr_block(#[case] spoil: fn(&mut AlarmCrBlockReq), #[case] field: u8) {
    assert_eq!(alarms(spoil), [0xDB, 0x81, 4, field]);
}

#[rstest]
#[case::no_ar(|contents: &mut Vec<ConnectContent>| { contents.remove(0); }, 1)]
#[case::two_ars(|contents: &mut Vec<ConnectContent>| contents.push(ConnectContent::ArReq(ar_block())), 1)]
#[case::unknown(|contents: &mut Vec<ConnectContent>| contents.push(ConnectContent::ArServerRes(Default::default())), 1)]
#[case::no_input(|contents: &mut Vec<ConnectContent>| { contents.remove(1); }, 2)]
#[case::no_output(|contents: &mut Vec<ConnectContent>| { contents.remove(2); }, 2)]
#[case::no_alarm(|contents: &mut Vec<ConnectContent>| { contents.pop(); }, 3)]
#[case::two_alarms(|contents: &mut Vec<ConnectContent>| contents.push(ConnectContent::AlarmCrReq(alarm_cr())), 3)]
#[case::two_inputs(|contents: &mut Vec<ConnectContent>| {
    contents.push(ConnectContent::IocrReq(IocrBlockReq { iocr_reference: 3, ..iocr(IocrType::INPUT) }));
}, 7)]
fn a_wrong_number_of_blocks(#[case] spoil: fn(&mut Vec<ConnectContent>), #[case] error: u8) {
    assert_eq!(answer(spoil), [0xDB, 0x81, 64, error]);
}

#[test]
fn no_expected_submodule() {
    let none = |contents: &mut Vec<ConnectContent>| {
        contents.retain(|block| !matches!(block, ConnectContent::ExpectedSubmodule(_)))
    };
    assert_eq!(answer(none), [0xDB, 0x81, 3, 4]);
}

#[rstest]
#[case::ar(0, 1)]
#[case::iocr(1, 2)]
#[case::expected(3, 3)]
#[case::alarm_cr(5, 4)]
fn a_wrong_block_header(#[case] at: usize, #[case] finder: u8) {
    let spoilt = |spoil: fn(&mut Vec<u8>, usize)| {
        let mut bench = StackBench::new();
        let connect = full_connect();
        let before = Connect { blocks: connect.blocks[..at].to_vec() }.to_vec().len();
        let mut octets = connect.to_vec();
        spoil(&mut octets, before);
        u32::from(bench.operate(Opnum::CONNECT, &octets).0).to_be_bytes()
    };
    assert_eq!(spoilt(|octets, at| octets[at + 2] = 0x7F), [0xDB, 0x81, finder, 1], "length");
    assert_eq!(spoilt(|octets, at| octets[at + 4] = 2), [0xDB, 0x81, finder, 2], "version high");
    assert_eq!(spoilt(|octets, at| octets[at + 5] = 1), [0xDB, 0x81, finder, 3], "version low");
    assert_eq!(spoilt(|octets, at| octets[at] = 0x7F), [0xDB, 0x81, 64, 1], "type");
}

#[test]
fn surplus_bytes_in_a_block() {
    let mut bench = StackBench::new();
    let mut connect = full_connect();
    connect.blocks[0].rest.push(0);
    assert_eq!(bench.connect(&connect).0, PnioStatus::from(0xDB81_0101));
    let raw = RawBlock::parse(&full_connect().to_vec());
    assert!(raw.is_ok());
}

#[test]
fn the_device_supports_one_connection_with_data_and_two_for_records() {
    let mut bench = StackBench::new();
    bench.start();
    let mut other = full_connect();
    if let ConnectContent::ArReq(ar) = &mut other.blocks[0].content {
        ar.ar_uuid = Uuid([8; 16]);
        ar.cm_initiator_mac_add = Mac([2, 0, 0, 0, 0, 2]);
    }
    let out_of_resources = PnioStatus::from(0xDB81_4004);
    assert_eq!(bench.connect(&other).0, out_of_resources);
    assert_eq!(bench.connect(&access_connect(Uuid([1; 16]))).0, PnioStatus::OK);
    assert_eq!(bench.connect(&access_connect(Uuid([2; 16]))).0, PnioStatus::OK);
    assert_eq!(bench.connect(&access_connect(Uuid([3; 16]))).0, out_of_resources);
    assert_eq!(
        bench.connect(&access_connect(Uuid([2; 16]))).0,
        PnioStatus::OK,
        "the same UUID replaces its connection"
    );
}

#[test]
fn a_connection_for_records_only_has_no_other_block() {
    let mut bench = StackBench::new();
    let mut connect = access_connect(AR);
    connect.blocks.push(ConnectContent::AlarmCrReq(alarm_cr()).into());
    assert_eq!(bench.connect(&connect).0, PnioStatus::from(0xDB81_4001));
}

#[test]
fn a_supervisor_may_exchange_data() {
    let status = ar(|ar| ar.ar_type = ArType::IOSAR);
    assert_eq!(status, [0; 4]);
    assert_ne!(SubmoduleType::INPUT, SubmoduleType::OUTPUT);
}
