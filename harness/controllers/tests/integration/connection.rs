//! The Connect request of a connection, byte by byte, and the value ranges of a connection.
#![allow(clippy::unwrap_used, reason = "a test that unwraps nothing has failed")]

use crate::common::*;
use encspec_controllers::profinet_io::*;
use rstest::rstest;
use wire::datagram::Datagram;
use wire::octets::ByteOrder;
use wire::profinet::blocks::connect::{ArProperties, Connect, FrameObject, RtClass};
use wire::profinet::rpc::{NdrRequest, RpcPdu};

#[test]
fn the_connect_request_has_the_values_of_the_connection() {
    let mut rig = ControllerRig::new();
    let connection = ArConfig {
        startup: StartUpMode::Advanced,
        properties: ArProperties::PULL_MODULE_ALARM_ALLOWED,
        activity_timeout_factor: 200,
        send_clock_factor: 64,
        reduction_ratio: 4,
        rt_class: RtClass::RT_CLASS_2,
        frame_id_in: 0x8002,
        watchdog_factor: 5,
        data_hold_factor: 6,
        rta_timeout_factor: 2,
        rta_retries: 4,
        max_alarm_data_length: 300,
        station_name: Some(b"plc".to_vec()),
        little_endian: true,
        ..connection()
    };
    let result = rig.start(connection);
    assert!(result.standing, "{result:?}");
    let datagram = rig.sent().find_map(|(_, frame)| Datagram::parse(frame).ok()).unwrap();
    let pdu = RpcPdu::parse(datagram.payload).unwrap();
    assert_eq!((pdu.header.order(), datagram.destination.port()), (ByteOrder::Little, 0x8894));
    let (ndr, blocks) = NdrRequest::parse(ByteOrder::Little, pdu.body).unwrap();
    assert_eq!((ndr.args_length as usize, ndr.actual_count as usize), (blocks.len(), blocks.len()));
    let connect = Connect::parse(blocks).unwrap();
    let ar = connect.ar_req().unwrap();
    assert_eq!(ar.ar_properties.0, 0xC000_0011);
    assert_eq!((ar.cm_initiator_activity_timeout_factor, ar.cm_initiator_station_name.as_slice()), (200, &b"plc"[..]));
    let [input, output]: [_; 2] = connect.iocr_requests().collect::<Vec<_>>().try_into().unwrap();
    for iocr in [input, output] {
        assert_eq!((iocr.send_clock_factor, iocr.reduction_ratio, iocr.iocr_properties.0), (64, 4, 2));
        assert_eq!((iocr.watchdog_factor, iocr.data_hold_factor, iocr.data_length), (5, 6, 40));
    }
    assert_eq!((input.frame_id, output.frame_id), (0x8002, 0xFFFF));
    let offsets = |list: &[FrameObject]| -> Vec<(u16, u16, u16)> {
        list.iter().map(|object| (object.slot_number, object.subslot_number, object.frame_offset)).collect()
    };
    // Three submodules of the DAP with only their IOPS; then the parameter access with its IOPS, 12 bytes with theirs.
    assert_eq!(input.apis.iter().map(|api| api.api).collect::<Vec<_>>(), [0, 0x3D00]);
    assert_eq!(offsets(&input.apis[0].io_data_objects), [(0, 1, 0), (0, 0x8000, 1), (0, 0x8001, 2)]);
    assert_eq!(offsets(&input.apis[1].io_data_objects), [(1, 1, 3), (1, 2, 4)]);
    assert_eq!(offsets(&input.apis[1].iocs), [(1, 2, 17)]);
    assert_eq!(offsets(&output.apis[0].io_data_objects), [(1, 2, 0)]);
    let (profile, dap) = (&output.apis[0], &output.apis[1]);
    assert_eq!(offsets(&dap.iocs), [(0, 1, 5), (0, 0x8000, 6), (0, 0x8001, 7)]);
    assert_eq!(offsets(&profile.iocs), [(1, 1, 8), (1, 2, 9)]);
    let alarms = connect.alarm_cr_req().unwrap();
    assert_eq!((alarms.rta_timeout_factor, alarms.rta_retries, alarms.max_alarm_data_length), (2, 4, 300));
    assert_eq!((alarms.alarm_cr_tag_header_high, alarms.alarm_cr_tag_header_low), (0xC000, 0xA000));
}

/// Each range of a connection: the last valid value at either end, and the first invalid one.
#[rstest]
#[case("CMInitiatorActivityTimeoutFactor", &[(0, false), (1, true), (1000, true), (1001, false)], |c: &mut ArConfig, v| c.activity_timeout_factor = v)]
#[case("SendClockFactor", &[(0, false), (1, true), (128, true), (129, false)], |c: &mut ArConfig, v| c.send_clock_factor = v)]
#[case("ReductionRatio", &[(0, false), (1, true), (3, false), (512, true), (1024, false)], |c: &mut ArConfig, v| { c.reduction_ratio = v; c.watchdog_factor = 3 })]
#[case("SendClockFactor x ReductionRatio", &[(128, true), (256, false)], |c: &mut ArConfig, v| { c.send_clock_factor = 128; c.reduction_ratio = v; c.watchdog_factor = 3 })]
#[case("WatchdogFactor", &[(0, false), (1, true), (10, true)], |c: &mut ArConfig, v| c.watchdog_factor = v)]
#[case("SendClockFactor x ReductionRatio x WatchdogFactor", &[(7680, true)], |c: &mut ArConfig, v| { c.send_clock_factor = 8; c.reduction_ratio = 1; c.watchdog_factor = v; c.data_hold_factor = v })]
#[case("SendClockFactor x ReductionRatio x WatchdogFactor", &[(960, true), (961, false)], |c: &mut ArConfig, v| { c.watchdog_factor = v; c.data_hold_factor = v })]
#[case("WatchdogFactor", &[(7681, false)], |c: &mut ArConfig, v| { c.send_clock_factor = 8; c.reduction_ratio = 1; c.watchdog_factor = v; c.data_hold_factor = v })]
#[case("DataHoldFactor", &[(9, false), (10, true), (7680, true), (7681, false)], |c: &mut ArConfig, v| c.data_hold_factor = v)]
#[case("RTATimeoutFactor", &[(0, false), (1, true), (100, true), (101, false)], |c: &mut ArConfig, v| c.rta_timeout_factor = v)]
#[case("RTARetries", &[(2, false), (3, true), (15, true), (16, false)], |c: &mut ArConfig, v| c.rta_retries = v)]
#[case("MaxAlarmDataLength", &[(199, false), (200, true), (1432, true), (1433, false)], |c: &mut ArConfig, v| c.max_alarm_data_length = v)]
#[case("RTClass", &[(1, true), (3, false), (4, false)], |c: &mut ArConfig, v| c.rt_class = RtClass(v as u8))]
#[case("FrameID (input)", &[(0x8000, false), (0xC000, true), (0xF7FF, true), (0xF800, false), (0xFFFF, false)], |c: &mut ArConfig, v| c.frame_id_in = v)]
#[case("FrameID (output)", &[(0xFFFF, true), (0xC000, true), (0xBFFF, false)], |c: &mut ArConfig, v| c.frame_id_out = v)]
#[case("DataLength (input)", &[(1434, true), (1435, false)], |c: &mut ArConfig, v| c.submodules[4].input_octets = v)]
#[case("DataLength (output)", &[(1434, true), (1435, false)], |c: &mut ArConfig, v| c.submodules[4].output_octets = v)]
#[case("SubslotNumber", &[(0x8000, false), (0x8002, true)], |c: &mut ArConfig, v| c.submodules[2].subslot = v)]
#[case("CMInitiatorStationName length", &[(0, false), (240, true), (241, false)], |c: &mut ArConfig, v: u16| c.station_name = Some(vec![b'a'; usize::from(v)]))]
#[case("NameOfStation length", &[(0, false), (240, true), (241, false)], |c: &mut ArConfig, v: u16| c.device = DeviceAddress::Name("a".repeat(usize::from(v))))]
fn limits(#[case] field: &str, #[case] values: &[(u16, bool)], #[case] set: fn(&mut ArConfig, u16)) {
    for (value, good) in values {
        let mut connection = connection();
        set(&mut connection, *value);
        let field_at_fault = connection.check().map_err(|error| error.field);
        assert_eq!(field_at_fault, if *good { Ok(()) } else { Err(field) }, "{field} of {value}");
    }
}

#[test]
fn a_value_out_of_range_is_sent_only_with_unchecked() {
    let connection = ArConfig { rta_retries: 99, ..connection() };
    let mut rig = ControllerRig::new();
    let result = rig.start(connection.clone());
    assert_eq!(result.failed.unwrap().to_string(), "check: RTARetries is 99, allowed is 3 to 15");
    assert_eq!(rig.sent().count(), 0);
    assert!(rig.start(ArConfig { unchecked: true, ..connection }).standing);
}
