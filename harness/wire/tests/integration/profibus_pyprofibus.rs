//! Frames built with pyprofibus: each is parsed to the values it was built from and written as the same bytes.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::profibus::address::SetSlaveAddress;
use encspec_wire::profibus::cfg::{Identifier, IoLengths, Length, ManufacturerData, io_lengths};
use encspec_wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1, Status2, Status3};
use encspec_wire::profibus::dpv1::{Dpv1Pdu, Dpv1Record, Endpoint, InitiateFeatures, PduDirection};
use encspec_wire::profibus::fdl::{
    AnswerFunction, BROADCAST, DataFrame, Extension, FdlFormat, FdlFrame, FrameCount, FunctionCode, RequestFunction,
    StationType,
};
use encspec_wire::profibus::global_control::{GlobalCommand, GlobalControl};
use encspec_wire::profibus::prm::{
    AlarmMode, Dpv1Status1, Dpv1Status2, Isochronous, PrmBlock, PrmBlockType, SetPrm, StationStatus,
};
use encspec_wire::profibus::sap::{SapService, SlaveSap};
use rstest::rstest;
use testing::{golden, hex};

const MASTER: u8 = 2;
const SLAVE: u8 = 8;

fn octets(name: &str) -> Vec<u8> {
    golden("pyprofibus.txt").into_iter().find(|(other, _)| other == name).expect("a golden frame").1
}

fn data_frame(octets: &[u8]) -> DataFrame<'_> {
    match FdlFrame::parse(octets) {
        Ok(FdlFrame::Data(frame)) => frame,
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_frame_is_written_unchanged() {
    let frames = golden("pyprofibus.txt");
    assert_eq!(frames.len(), 33);
    for (name, octets) in frames {
        let frame = FdlFrame::parse(&octets).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(written(|out| frame.write(out)), octets, "{name}");
        assert_eq!(FdlFrame::length(&octets), Ok(Some(octets.len())), "{name}");
        if let FdlFrame::Data(frame) = frame {
            let DataFrame { da, destination, sa, source, fc, data, .. } = frame;
            let format = DataFrame::new((da, destination), (sa, source), fc, data).format;
            assert_eq!(format == frame.format, name != "set_ext_prm", "{name}: 8 bytes in SD2 only if requested");
        }
    }
}

#[test]
fn frames_without_a_function_code() {
    assert_eq!(FdlFrame::parse(&octets("token")), Ok(FdlFrame::Token { da: 2, sa: 126 }));
    assert_eq!(FdlFrame::parse(&octets("short_acknowledgement")), Ok(FdlFrame::ShortAcknowledgement));
}

#[rstest]
#[case(
    "fdl_status_request",
    RequestFunction::FDL_STATUS,
    FrameCount::Unused,
    SapService::Link(RequestFunction::FDL_STATUS)
)]
#[case("ident_request", RequestFunction::IDENT, FrameCount::Unused, SapService::Link(RequestFunction::IDENT))]
#[case(
    "lsap_request",
    RequestFunction::LSAP_STATUS,
    FrameCount::Unused,
    SapService::Link(RequestFunction::LSAP_STATUS)
)]
#[case(
    "slave_diag_request_first",
    RequestFunction::SRD_HIGH,
    FrameCount::First,
    SapService::Slave(SlaveSap::SLAVE_DIAG)
)]
#[case("set_prm_plain", RequestFunction::SRD_HIGH, FrameCount::Zero, SapService::Slave(SlaveSap::SET_PRM))]
#[case("set_prm_dpv1", RequestFunction::SRD_HIGH, FrameCount::One, SapService::Slave(SlaveSap::SET_PRM))]
#[case("chk_cfg", RequestFunction::SRD_HIGH, FrameCount::Zero, SapService::Slave(SlaveSap::CHK_CFG))]
#[case("data_exchange_request", RequestFunction::SRD_HIGH, FrameCount::One, SapService::DataExchange)]
#[case("data_exchange_request_empty", RequestFunction::SRD_HIGH, FrameCount::Unused, SapService::DataExchange)]
#[case("global_control", RequestFunction::SDN_HIGH, FrameCount::Unused, SapService::Slave(SlaveSap::GLOBAL_CONTROL))]
#[case("get_cfg_request", RequestFunction::SRD_HIGH, FrameCount::Unused, SapService::Slave(SlaveSap::GET_CFG))]
#[case(
    "set_slave_address",
    RequestFunction::SRD_LOW,
    FrameCount::Unused,
    SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS)
)]
#[case("set_ext_prm", RequestFunction::SRD_LOW, FrameCount::Unused, SapService::Slave(SlaveSap::SET_EXT_PRM))]
#[case("rd_inp", RequestFunction::SRD_LOW, FrameCount::Unused, SapService::Slave(SlaveSap::READ_INPUTS))]
#[case("rd_outp", RequestFunction::SRD_LOW, FrameCount::Unused, SapService::Slave(SlaveSap::READ_OUTPUTS))]
#[case("ms1_read", RequestFunction::SRD_LOW, FrameCount::Unused, SapService::Slave(SlaveSap::SERVER))]
#[case("ms1_alarm_ack", RequestFunction::SRD_LOW, FrameCount::Unused, SapService::Slave(SlaveSap::ALARM))]
#[case("ms2_initiate", RequestFunction::SRD_LOW, FrameCount::Unused, SapService::Slave(SlaveSap::RESOURCE_MANAGER))]
fn requests(
    #[case] name: &str,
    #[case] function: RequestFunction,
    #[case] count: FrameCount,
    #[case] service: SapService,
) {
    let octets = octets(name);
    let frame = data_frame(&octets);
    let da = if service == SapService::Slave(SlaveSap::GLOBAL_CONTROL) { BROADCAST } else { SLAVE };
    assert_eq!((frame.da, frame.sa), (da, MASTER));
    assert_eq!((frame.fc.requested(), frame.fc.count()), (Some(function), Some(count)));
    assert_eq!((frame.fc.answered(), frame.fc.station()), (None, None));
    assert_eq!(frame.fc, FunctionCode::request(function, count));
    assert_eq!(SapService::of(&frame), service);
    assert_eq!(function.expects_response(), service != SapService::Slave(SlaveSap::GLOBAL_CONTROL));
}

#[rstest]
#[case("fdl_status_answer", AnswerFunction::OK, StationType::SLAVE, SapService::BareAnswer)]
#[case("answer_master_in_ring", AnswerFunction::OK, StationType::MASTER_IN_RING, SapService::BareAnswer)]
#[case("answer_user_error", AnswerFunction::USER_ERROR, StationType::SLAVE, SapService::BareAnswer)]
#[case("answer_no_resource", AnswerFunction::NO_RESOURCE, StationType::SLAVE, SapService::BareAnswer)]
#[case("answer_no_service", AnswerFunction::NO_SERVICE, StationType::SLAVE, SapService::BareAnswer)]
#[case("answer_no_data", AnswerFunction::NO_DATA, StationType::SLAVE, SapService::BareAnswer)]
#[case("slave_diag_answer", AnswerFunction::DATA_LOW, StationType::SLAVE, SapService::Slave(SlaveSap::SLAVE_DIAG))]
#[case("get_cfg_answer_empty", AnswerFunction::DATA_LOW, StationType::SLAVE, SapService::Slave(SlaveSap::GET_CFG))]
#[case("data_exchange_answer", AnswerFunction::DATA_LOW, StationType::SLAVE, SapService::DataExchange)]
#[case("data_exchange_answer_high", AnswerFunction::DATA_HIGH, StationType::SLAVE, SapService::DataExchange)]
fn answers(
    #[case] name: &str,
    #[case] function: AnswerFunction,
    #[case] station: StationType,
    #[case] service: SapService,
) {
    let octets = octets(name);
    let frame = data_frame(&octets);
    assert_eq!(frame.da, MASTER);
    assert_eq!((frame.fc.answered(), frame.fc.station()), (Some(function), Some(station)));
    assert_eq!((frame.fc.requested(), frame.fc.count()), (None, None));
    assert_eq!(frame.fc, FunctionCode::answer(function, station));
    assert_eq!(SapService::of(&frame), service);
    assert_eq!(function.is_high(), name == "data_exchange_answer_high");
    assert_eq!(function.has_data(), function.0 & 8 != 0 && name != "answer_no_data");
}

#[test]
fn formats_and_extensions() {
    let format = |name: &str| data_frame(&octets(name)).format;
    assert_eq!(format("fdl_status_request"), FdlFormat::NoData);
    assert_eq!(format("slave_diag_answer"), FdlFormat::EightOctets);
    assert_eq!(format("data_exchange_answer_high"), FdlFormat::EightOctets);
    assert_eq!(format("data_exchange_longest"), FdlFormat::Variable);
    let octets = octets("segments");
    let frame = data_frame(&octets);
    assert_eq!(frame.destination, Extension { segment: Some(5), sap: Some(60) });
    assert_eq!(frame.source, Extension { segment: Some(63), sap: None });
    assert_eq!((frame.da, frame.sa, frame.data.len()), (SLAVE, MASTER, 0));
}

#[test]
fn set_prm() {
    let octets = octets("set_prm_plain");
    let prm = SetPrm::parse(data_frame(&octets).data).unwrap();
    let status = StationStatus::LOCK_REQ
        .with(StationStatus::WD_ON)
        .with(StationStatus::SYNC_REQ)
        .with(StationStatus::FREEZE_REQ);
    let expected =
        SetPrm { status, wd_fact_1: 20, wd_fact_2: 5, min_tsdr: 11, ident: 0x1655, groups: 0x81, user: Vec::new() };
    assert_eq!(prm, expected);
    assert_eq!((prm.watchdog_ms(10), prm.dpv1()), (Some(1000), None));
}

#[test]
fn set_prm_with_dpv1_and_isochronous_times() {
    let octets = octets("set_prm_dpv1");
    let prm = SetPrm::parse(data_frame(&octets).data).unwrap();
    let dpv1 = prm.dpv1().unwrap();
    assert_eq!(dpv1.status_1, Dpv1Status1::DPV1_ENABLE.with(Dpv1Status1::FAIL_SAFE).with(Dpv1Status1::WD_BASE_1MS));
    let alarms = Dpv1Status2::DIAGNOSIS_ALARM.with(Dpv1Status2::PULL_PLUG_ALARM).with(Dpv1Status2::CHECK_CFG_MODE);
    assert_eq!(dpv1.status_2, alarms);
    assert_eq!((dpv1.status_3.alarms(), dpv1.status_3.0), (AlarmMode::InAll(12), 0x1C));
    assert_eq!(prm.watchdog_ms(dpv1.watchdog_base_ms()), Some(100));
    let blocks = PrmBlock::parse_all(prm.user_after_dpv1()).unwrap();
    assert_eq!(blocks.len(), 1);
    assert_eq!((blocks[0].kind, blocks[0].slot, blocks[0].reserved), (PrmBlockType::ISOCHRONOUS, 0, 0));
    let times = Isochronous::parse(&blocks[0].data).unwrap();
    let expected = Isochronous {
        version: 1,
        t_base_dp: 1500,
        t_dp: 8,
        t_mapc: 1,
        t_base_io: 1500,
        t_i: 1,
        t_o: 2,
        t_dx: 750,
        t_pll_w: 12,
        t_pll_d: 0,
    };
    assert_eq!(times, expected);
    assert_eq!(times.cycle_nanoseconds(), 1_000_000);
    assert_eq!(written(|out| times.write(out)), blocks[0].data);
}

#[test]
fn chk_cfg() {
    let octets = octets("chk_cfg");
    let data = data_frame(&octets).data;
    let identifiers = Identifier::parse_all(data).unwrap();
    let length = |count, words, whole| Length { count, words, whole };
    let special = |outputs, inputs, maker: &str| Identifier::Special {
        outputs,
        inputs,
        maker: ManufacturerData::Octets(hex(maker)),
    };
    let expected = [
        Identifier::General { outputs: false, inputs: true, length: length(4, true, true) },
        Identifier::General { outputs: true, inputs: false, length: length(2, false, false) },
        Identifier::General { outputs: true, inputs: true, length: length(16, true, false) },
        special(Some(length(2, true, true)), Some(length(6, true, true)), "fd0051"),
        special(None, Some(length(64, false, false)), ""),
        special(Some(length(8, true, false)), None, ""),
        special(None, None, ""),
    ];
    assert_eq!(identifiers, expected);
    assert_eq!(io_lengths(&identifiers), IoLengths { inputs: 8 + 32 + 12 + 64, outputs: 2 + 32 + 4 + 16 });
    assert_eq!(written(|out| identifiers.iter().for_each(|identifier| identifier.write(out))), data);
}

#[test]
fn slave_diag() {
    let octets = octets("slave_diag_answer");
    let expected = SlaveDiag {
        status_1: Status1::STATION_NOT_READY.with(Status1::PRM_FAULT),
        status_2: Status2::FIXED_ONE.with(Status2::WD_ON).with(Status2::PRM_REQ),
        status_3: Status3::EXT_DIAG_OVERFLOW,
        master: NO_MASTER,
        ident: 0x1655,
        ext: Vec::new(),
    };
    assert_eq!(SlaveDiag::parse(data_frame(&octets).data), Ok(expected));
}

#[test]
fn small_services() {
    let frame = octets("global_control");
    let control = GlobalControl::parse(data_frame(&frame).data).unwrap();
    assert_eq!(control, GlobalControl { command: GlobalCommand::SYNC.with(GlobalCommand::FREEZE), groups: 0x81 });
    assert_eq!([0x80, 0x01, 0x02].map(|own| control.is_for(own)), [true, true, false]);
    let frame = octets("global_control_clear");
    let control = GlobalControl::parse(data_frame(&frame).data).unwrap();
    assert_eq!((control.command, control.is_for(0)), (GlobalCommand::CLEAR_DATA, true));
    let frame = octets("set_slave_address");
    let expected = SetSlaveAddress { address: 5, ident: 0x1655, no_change: 0, slave_data: Vec::new() };
    assert_eq!(SetSlaveAddress::parse(data_frame(&frame).data), Ok(expected));
    let frame = octets("set_ext_prm");
    let block = PrmBlock { kind: PrmBlockType::USER_PRM_DATA, slot: 0, reserved: 0, data: vec![1, 0xFF] };
    assert_eq!(PrmBlock::parse_all(data_frame(&frame).data), Ok(vec![block]));
}

#[test]
fn acyclic_requests() {
    let parsed = |name: &str| Dpv1Pdu::parse(data_frame(&octets(name)).data, PduDirection::Request).unwrap();
    let record = Dpv1Record { slot: 0, index: 47, length: 240, data: Vec::new() };
    assert_eq!(parsed("ms1_read"), Dpv1Pdu::Read(record));
    let Dpv1Pdu::AlarmAck { slot: 1, alarm_type: 1, specifier } = parsed("ms1_alarm_ack") else {
        panic!("no alarm ack")
    };
    assert_eq!((specifier.sequence(), specifier.requires_user_acknowledgement()), (1, false));
    let end = Endpoint { kind: 0, address: vec![0, 0] };
    let abilities = InitiateFeatures {
        features: [1, 0],
        profile_features: [0, 0],
        profile: 0x0303,
        source: end.clone(),
        destination: end,
    };
    assert_eq!(parsed("ms2_initiate"), Dpv1Pdu::InitiateRequest { reserved: [0; 3], send_timeout: 100, abilities });
}
