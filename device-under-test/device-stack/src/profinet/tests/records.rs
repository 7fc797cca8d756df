//! Records of the stack, records of the application, and unknown records.

use super::bench::*;
use super::toy::API;
use alloc::vec::Vec;
use rstest::rstest;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::identification::{ApiData, IdentificationData};
use wire::profinet::blocks::im::{Im0, ImText, padded};
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest, WriteResponse};
use wire::profinet::diagnosis::DiagnosisData;
use wire::profinet::rpc::{Opnum, Uuid};
use wire::profinet::status::PnioStatus;

fn header(ar_uuid: Uuid, place: (u32, u16, u16), index: u16) -> RecordHeader {
    let (api, slot_number, subslot_number) = place;
    RecordHeader { seq_number: 3, ar_uuid, api, slot_number, subslot_number, index, ..RecordHeader::default() }
}

fn read_at_most(bench: &mut StackBench, octets: u32, header: RecordHeader, opnum: Opnum) -> (PnioStatus, Vec<u8>) {
    let header = RecordHeader { record_data_length: octets, ..header };
    let mut blocks = Vec::new();
    ReadRequest { header, ..ReadRequest::default() }.write(&mut blocks);
    let (status, blocks) = bench.operate(opnum, &blocks);
    match ReadResponse::parse(&blocks) {
        Ok(response) => {
            assert_eq!((response.header.index, response.header.seq_number), (header.index, 3));
            (status, response.record().to_vec())
        }
        Err(_) => (status, blocks),
    }
}

pub(super) fn read(bench: &mut StackBench, place: (u32, u16, u16), index: u16) -> (PnioStatus, Vec<u8>) {
    read_at_most(bench, 8192, header(AR, place, index), Opnum::READ)
}

pub(super) fn implicit(bench: &mut StackBench, place: (u32, u16, u16), index: u16) -> (PnioStatus, Vec<u8>) {
    read_at_most(bench, 8192, header(Uuid::NIL, place, index), Opnum::READ_IMPLICIT)
}

fn write(bench: &mut StackBench, place: (u32, u16, u16), index: u16, data: &[u8]) -> PnioStatus {
    let mut blocks = Vec::new();
    WriteRequest::of(header(AR, place, index), data.to_vec()).write(&mut blocks);
    let (status, blocks) = bench.operate(Opnum::WRITE, &blocks);
    let response = WriteResponse::parse_all(&blocks).unwrap();
    assert_eq!(response.first().map_or(status, |response| response.status), status);
    status
}

const TELEGRAM: (u32, u16, u16) = (API, 1, 2);
const HEAD: (u32, u16, u16) = (0, 0, 1);

#[rstest]
#[case::of_the_application(TELEGRAM, 0x100, 0)]
#[case::unknown(TELEGRAM, 0x101, 0xDE80_B000)]
#[case::unknown_of_the_device(HEAD, 0xFBFF, 0xDE80_B000)]
#[case::no_subslot((API, 1, 9), 0x100, 0xDE80_B200)]
#[case::no_slot((API, 9, 2), 0x100, 0xDE80_B200)]
#[case::no_api((5, 1, 2), 0x100, 0xDE80_B400)]
#[case::real_of_nothing((API, 9, 2), 0x8001, 0xDE80_B200)]
#[case::real_of_no_api((5, 0, 0), 0xF000, 0xDE80_B400)]
fn reads_are_answered(#[case] place: (u32, u16, u16), #[case] index: u16, #[case] status: u32) {
    let mut bench = StackBench::new();
    bench.start();
    assert_eq!(read(&mut bench, place, index).0, PnioStatus::from(status));
    assert_eq!(implicit(&mut bench, place, index).0, PnioStatus::from(status));
}

#[rstest]
#[case::of_the_application(TELEGRAM, 0x100, 0)]
#[case::unknown(TELEGRAM, 0x101, 0xDF80_B000)]
#[case::read_only(HEAD, 0xAFF0, 0xDF80_B600)]
#[case::no_subslot((API, 1, 9), 0x100, 0xDF80_B200)]
fn writes_are_answered(#[case] place: (u32, u16, u16), #[case] index: u16, #[case] status: u32) {
    let mut bench = StackBench::new();
    bench.start();
    assert_eq!(write(&mut bench, place, index, &[5; 8]), PnioStatus::from(status));
    let record = &bench.device.application().record;
    assert_eq!(*record == [5; 8], status == 0);
}

#[test]
fn a_record_is_truncated_to_the_requested_length() {
    let mut bench = StackBench::new();
    bench.start();
    let record = read_at_most(&mut bench, 3, header(AR, TELEGRAM, 0x100), Opnum::READ);
    assert_eq!(record, (PnioStatus::OK, [1, 2, 3].into()));
}

#[test]
fn write_multiple_answers_each_record() {
    let mut bench = StackBench::new();
    bench.start();
    let one = |index, data: &[u8]| WriteRequest::of(header(AR, TELEGRAM, index), data.to_vec());
    let nested = WriteRequest::of(header(AR, TELEGRAM, 0xE040), Vec::new());
    let other = WriteRequest::of(header(Uuid([1; 16]), TELEGRAM, 0x100), Vec::new());
    let records = [one(0x100, &[1, 2, 3]), one(0x101, &[4]), nested, other, one(0x100, &[7])];
    let mut blocks = Vec::new();
    WriteRequest::multiple(AR, 9, &records).write(&mut blocks);
    let (status, blocks) = bench.operate(Opnum::WRITE, &blocks);
    let answers: Vec<u32> = WriteResponse::parse_all(&blocks).unwrap().iter().map(|one| one.status.into()).collect();
    assert_eq!(status, PnioStatus::OK);
    assert_eq!(answers, [0, 0, 0xDF80_B000, 0xDF81_080A, 0xDF81_0805, 0]);
    assert_eq!(bench.device.application().record, [7]);
}

#[test]
fn im0_and_its_filter() {
    let mut bench = StackBench::new();
    let im0 = Im0::parse(&implicit(&mut bench, TELEGRAM, 0xAFF0).1).unwrap();
    assert_eq!((im0.vendor_id, &im0.order_id, &im0.serial_number), (0x0239, &padded("TOY-1"), &padded("0042")));
    assert_eq!((im0.software_revision.prefix, im0.software_revision.internal_change), (b'V', 3));
    let filter = IdentificationData::parse_record(&implicit(&mut bench, HEAD, 0xF840).1).unwrap();
    let kinds: Vec<_> = filter.iter().map(|block| block.kind).collect();
    assert_eq!(kinds, [BlockType::IM0_FILTER_SUBMODULE, BlockType::IM0_FILTER_DEVICE]);
}

#[test]
fn texts_survive_a_loss_of_power() {
    let mut bench = StackBench::new();
    bench.start();
    let blank = ImText::parse(&read(&mut bench, HEAD, 0xAFF2).1).unwrap();
    assert_eq!(blank, ImText::Date([b' '; 16]));
    let date = ImText::Date(*b"2026-11-21 12:00");
    let mut octets = Vec::new();
    date.write(&mut octets);
    assert_eq!(write(&mut bench, HEAD, 0xAFF2, &octets), PnioStatus::OK);
    assert_eq!(write(&mut bench, HEAD, 0xAFF3, &octets), PnioStatus::from(0xDF80_B800));
    assert_eq!(write(&mut bench, HEAD, 0xAFF2, &octets[1..]), PnioStatus::from(0xDF80_B100));
    assert_eq!(write(&mut bench, HEAD, 0xAFF2, &[&octets[..], b"  "].concat()), PnioStatus::from(0xDF80_B100));
    bench.device.power(bench.now, false);
    bench.device.power(bench.now, true);
    bench.run(core::time::Duration::from_secs(3));
    assert_eq!(ImText::parse(&implicit(&mut bench, HEAD, 0xAFF2).1).unwrap(), date);
    bench.device.application_mut().identity.im_supported = 0;
    // A device takes its identity when it starts.
    bench.device.power(bench.now, false);
    bench.device.power(bench.now, true);
    bench.run(core::time::Duration::from_secs(3));
    assert_eq!(implicit(&mut bench, HEAD, 0xAFF2).0, PnioStatus::from(0xDE80_B000));
}

#[rstest]
#[case::subslot(0x8001, TELEGRAM, 1)]
#[case::slot(0xC001, TELEGRAM, 2)]
#[case::connection(0xE001, TELEGRAM, 6)]
#[case::api(0xF000, TELEGRAM, 2)]
#[case::expected_subslot(0x8000, TELEGRAM, 1)]
#[case::expected_slot(0xC000, HEAD, 4)]
#[case::expected_connection(0xE000, HEAD, 6)]
fn real_and_expected_identification(#[case] index: u16, #[case] place: (u32, u16, u16), #[case] count: usize) {
    let mut bench = StackBench::new();
    bench.start();
    let (status, record) = read(&mut bench, place, index);
    assert_eq!(status, PnioStatus::OK);
    let blocks = IdentificationData::parse_record(&record).unwrap();
    let subslots: Vec<_> = blocks
        .iter()
        .flat_map(|block| &block.apis)
        .flat_map(|api| &api.slots)
        .flat_map(|slot| &slot.subslots)
        .collect();
    assert_eq!(subslots.len(), count);
    if place == TELEGRAM && index != 0xC000 {
        assert!(subslots.iter().any(|subslot| subslot.submodule_ident == 83), "the Connect has plugged the submodule");
    }
}

#[test]
fn records_with_connection_scope_need_a_connection() {
    let mut bench = StackBench::new();
    assert_eq!(implicit(&mut bench, HEAD, 0xE001).0, PnioStatus::from(0xDE80_B800));
    assert_eq!(read(&mut bench, HEAD, 0xE001).0, PnioStatus::from(0xDE81_4005));
    bench.start();
    let target = ReadRequest {
        header: RecordHeader { record_data_length: 1000, ..header(Uuid::NIL, HEAD, 0xE001) },
        target_ar_uuid: AR,
        ..ReadRequest::default()
    };
    let mut blocks = Vec::new();
    target.write(&mut blocks);
    assert_eq!(bench.operate(Opnum::READ_IMPLICIT, &blocks).0, PnioStatus::OK);
    let (_, record) = read(&mut bench, HEAD, 0xE002);
    assert_eq!(ModuleDiffBlock::parse(&record).unwrap().apis, []);
}

#[test]
fn the_record_of_the_apis() {
    let mut bench = StackBench::new();
    assert_eq!(ApiData::parse(&implicit(&mut bench, (0, 0, 0), 0xF821).1).unwrap().apis, [0, API]);
}

#[rstest]
#[case::subslot(0x800A, TELEGRAM, 1)]
#[case::another_subslot(0x800A, HEAD, 0)]
#[case::slot(0xC00B, TELEGRAM, 1)]
#[case::connection(0xE00C, HEAD, 1)]
#[case::api(0xF00A, TELEGRAM, 1)]
#[case::another_api(0xF00A, HEAD, 0)]
#[case::device(0xF80C, HEAD, 1)]
fn diagnosis_records(#[case] index: u16, #[case] place: (u32, u16, u16), #[case] count: usize) {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(1);
    let (status, record) = read(&mut bench, place, index);
    let blocks = DiagnosisData::parse_record(&record).unwrap();
    assert_eq!((status, blocks.len()), (PnioStatus::OK, count));
    assert!(blocks.iter().all(|block| block.item.channels()[0].error_type.0 == 0x9001));
}

#[test]
fn tshark_dissects_all_records() {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(1);
    for index in [0xAFF0, 0xAFF1, 0xAFF2, 0xAFF3, 0x8000, 0x8001, 0x800A, 0x800B, 0x800C, 0xC000, 0xC001] {
        assert_eq!(read(&mut bench, TELEGRAM, index).0, PnioStatus::OK);
    }
    for index in [0xE000, 0xE001, 0xE002, 0xE00C, 0xF000, 0xF00C, 0xF80C, 0xF821, 0xF840] {
        assert_eq!(read(&mut bench, HEAD, index).0, PnioStatus::OK);
    }
    bench.check_with_tshark();
}

#[rstest]
#[case::kind(0, 0x7F, 0xDE81_0800)]
#[case::length(3, 0x3D, 0xDE81_0801)]
#[case::version_high(4, 2, 0xDE81_0802)]
#[case::version_low(5, 1, 0xDE81_0803)]
#[case::unknown_connection(8, 9, 0xDE81_4005)]
fn a_wrong_read_header_is_refused(#[case] at: usize, #[case] byte: u8, #[case] status: u32) {
    let mut bench = StackBench::new();
    bench.start();
    let mut blocks = Vec::new();
    ReadRequest { header: header(AR, TELEGRAM, 0x100), ..ReadRequest::default() }.write(&mut blocks);
    blocks[at] = byte;
    assert_eq!(bench.operate(Opnum::READ, &blocks).0, PnioStatus::from(status));
}

#[test]
fn a_write_with_a_wrong_length_is_refused() {
    let mut bench = StackBench::new();
    bench.start();
    let mut blocks = Vec::new();
    WriteRequest::of(header(AR, TELEGRAM, 0x100), alloc::vec![1, 2]).write(&mut blocks);
    for data in [[1].as_slice(), &[1, 2, 3]] {
        let octets = [&blocks[..64], data].concat();
        assert_eq!(bench.operate(Opnum::WRITE, &octets).0, PnioStatus::from(0xDF81_080B));
    }
}

#[test]
fn a_connection_for_records_only_reads_and_writes() {
    let mut bench = StackBench::new();
    assert_eq!(bench.connect(&access_connect(AR)).0, PnioStatus::OK);
    assert_eq!(write(&mut bench, TELEGRAM, 0x100, &[8]), PnioStatus::OK);
    assert_eq!(read(&mut bench, TELEGRAM, 0x100), (PnioStatus::OK, [8].into()));
    assert_eq!(bench.prm_end(), PnioStatus::from(0xDD81_4006));
    assert_eq!(bench.release(), PnioStatus::OK);
    assert_eq!(read(&mut bench, TELEGRAM, 0x100).0, PnioStatus::from(0xDE81_4005));
}

/// The layout of ARData in version 1.1 is that of IEC 61158-6-10: one connection, then none.
#[test]
fn connections_are_listed_until_they_are_released() {
    let mut bench = StackBench::new();
    bench.start();
    let (status, record) = implicit(&mut bench, HEAD, 0xF820);
    assert_eq!(status, PnioStatus::from(0));
    assert_eq!((&record[..2], &record[4..24]), (&[0, 0x18][..], &[&[1, 1, 0, 1][..], &AR.0].concat()[..]));
    assert_eq!((usize::from(u16::from_be_bytes([record[2], record[3]])), record.len() % 4), (record.len() - 4, 0));
    assert_eq!(implicit(&mut bench, TELEGRAM, 0xF020).1, record);
    bench.release();
    assert_eq!(implicit(&mut bench, HEAD, 0xF820).1, [0, 0x18, 0, 4, 1, 1, 0, 0]);
}
