//! Requirements that every conforming device meets, one function each. The hook tests check that a deviation breaks
//! them.

use super::bench::*;
use super::connection::abort;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use rstest::rstest;
use station::Duration;
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{Connect, ConnectContent, RtClass};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue, Element};
use wire::profinet::rpc::{NdrRequest, Opnum, RpcPdu};
use wire::profinet::rt::DataStatus;
use wire::profinet::status::PnioStatus;

/// Runs a device and returns whether it meets one requirement.
type RequirementTrial = fn(&mut StackBench) -> bool;

fn set(bench: &mut StackBench, qualifier: BlockQualifier, value: DcpValue) {
    bench.dcp(&Dcp::set(3, [DcpBlock::set(qualifier, value)].into()), DEVICE);
}

pub fn identify_waits(bench: &mut StackBench) -> bool {
    bench.dcp(&Dcp::identify(7, 0x103, [DcpValue::AllSelector].into()), Mac::DCP_MULTICAST).is_empty()
}

pub fn temporary_name_is_not_stored(bench: &mut StackBench) -> bool {
    set(bench, BlockQualifier::TEMPORARY, DcpValue::NameOfStation(b"new".to_vec()));
    bench.device.application().stored.name.is_empty()
}

pub fn reset_clears_the_name(bench: &mut StackBench) -> bool {
    set(bench, BlockQualifier(0), DcpValue::FactoryReset);
    bench.device.application().stored.name.is_empty()
}

pub fn answer_in_the_order_of_the_request(bench: &mut StackBench) -> bool {
    let header = wire::profinet::rpc::RpcHeader { drep: ByteOrder::Little.into(), ..bench.header(Opnum::CONNECT) };
    let (answer, _) = bench.call(&header, &NdrRequest::body(ByteOrder::Little, 100, &[])).unwrap();
    answer.order() == ByteOrder::Little
}

pub fn repeated_request_is_carried_out_once(bench: &mut StackBench) -> bool {
    let header = bench.header(Opnum::CONNECT);
    let body = NdrRequest::body(ByteOrder::Big, 4096, &full_connect().to_vec());
    for _ in 0..2 {
        bench.pdus(&[RpcPdu::new(header, &body).to_vec()]);
    }
    bench.device.application().log.len() == 1
}

pub fn output_length_is_compared(bench: &mut StackBench) -> bool {
    let mut modules = modules();
    modules[1].submodules[1].data_descriptions[1].submodule_data_length = 6;
    !bench.connect(&Connect::of(connect_blocks(&modules))).0.is_ok()
}

pub fn inputs_come_under_the_agreed_frame_id(bench: &mut StackBench) -> bool {
    bench.start();
    bench.exchange(1);
    bench.take().iter().any(|frame| frame[16..20] == [0x88, 0x92, 0x80, 0x01])
}

pub fn module_diff_is_reported(bench: &mut StackBench) -> bool {
    let mut modules = modules();
    modules[1].submodules[1].submodule_ident_number = 99;
    bench.connect(&Connect::of(connect_blocks(&modules))).1.block(BlockType::MODULE_DIFF).is_some()
}

pub fn ready_comes_after_the_parameters(bench: &mut StackBench) -> bool {
    bench.connect(&full_connect());
    bench.take();
    bench.exchange(2);
    let is_late = bench.ready_calls().is_empty();
    assert_eq!(bench.prm_end(), PnioStatus::OK, "PrmEnd is answered, early or late");
    is_late
}

pub fn record_is_cut(bench: &mut StackBench) -> bool {
    let place =
        RecordHeader { api: 0x3D00, slot_number: 1, subslot_number: 2, index: 0x100, ..RecordHeader::default() };
    let header = RecordHeader { record_data_length: 3, ..place };
    let mut blocks = Vec::new();
    ReadRequest { header, ..ReadRequest::default() }.write(&mut blocks);
    let (_, blocks) = bench.operate(Opnum::READ_IMPLICIT, &blocks);
    ReadResponse::parse(&blocks).unwrap().record().len() == 3
}

pub fn inputs_are_bad_at_first(bench: &mut StackBench) -> bool {
    bench.connect(&full_connect());
    bench.exchange(2);
    StackBench::inputs(&bench.take())[0].0[16] == 0
}

pub fn outputs_have_a_consumer_status(bench: &mut StackBench) -> bool {
    bench.start();
    bench.exchange(1);
    StackBench::inputs(&bench.take())[0].0[17] == 0x80
}

pub fn counter_counts(bench: &mut StackBench) -> bool {
    bench.start();
    bench.exchange(2);
    let frames = StackBench::inputs(&bench.take());
    frames[0].1.cycle_counter != frames[1].1.cycle_counter
}

pub fn problem_is_indicated(bench: &mut StackBench) -> bool {
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(2);
    StackBench::inputs(&bench.take()).last().unwrap().1.data_status == DataStatus(0x15)
}

pub fn padding_is_ignored(bench: &mut StackBench) -> bool {
    bench.start();
    bench.output_frame(&[0x80; 40], DataStatus::NORMAL, 8);
    bench.device.application().outputs.as_deref() == Some(&[0x80; 4])
}

pub fn stop_makes_outputs_bad(bench: &mut StackBench) -> bool {
    bench.start();
    bench.output_frame(&[0x80; 40], DataStatus(0x25), 0);
    bench.device.application().outputs.is_none()
}

pub fn bad_status_makes_outputs_bad(bench: &mut StackBench) -> bool {
    bench.start();
    bench.output_frame(&[0x00; 40], DataStatus::NORMAL, 0);
    bench.device.application().outputs.is_none()
}

pub fn missing_outputs_are_detected(bench: &mut StackBench) -> bool {
    bench.start();
    bench.run(Duration::from_secs(1));
    abort(&bench.take()).is_some()
}

fn alarms(bench: &mut StackBench) -> Vec<Vec<u8>> {
    bench.take().into_iter().filter(|frame| frame.get(16..20) == Some(&[0x88, 0x92, 0xFE, 0x01])).collect()
}

pub fn first_alarm_is_the_one_before_0(bench: &mut StackBench) -> bool {
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(1);
    alarms(bench)[0][26..28] == [0xFF, 0xFF]
}

pub fn alarm_is_repeated(bench: &mut StackBench) -> bool {
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(60);
    alarms(bench).len() == 2
}

pub fn pending_diagnosis_is_reported(bench: &mut StackBench) -> bool {
    bench.device.application_mut().change(0x9001, true);
    bench.connect(&full_connect());
    bench.exchange(1);
    bench.prm_end();
    bench.exchange(3);
    let call = bench.ready_calls().remove(0);
    bench.answer_ready(&call, PnioStatus::OK);
    !alarms(bench).is_empty()
}

pub fn answer_comes_at_once(bench: &mut StackBench) -> bool {
    let header = bench.header(Opnum::CONNECT);
    !bench.pdus(&[RpcPdu::new(header, &NdrRequest::body(ByteOrder::Big, 100, &[])).to_vec()]).is_empty()
}

pub fn whole_name_is_compared(bench: &mut StackBench) -> bool {
    let part = DcpValue::NameOfStation(b"to".to_vec());
    bench.dcp(&Dcp::identify(7, 1, [part].into()), Mac::DCP_MULTICAST).is_empty()
}

pub fn filter_by_type_matches(bench: &mut StackBench) -> bool {
    bench.dcp(&Dcp::identify(7, 1, [DcpValue::Vendor(b"TOY".to_vec())].into()), Mac::DCP_MULTICAST).len() == 1
}

pub fn mask_is_taken(bench: &mut StackBench) -> bool {
    let [address, mask] = [[10, 0, 0, 7], [255, 0, 0, 0]].map(Ipv4Addr::from);
    let ip = IpParameter { address, mask, gateway: Ipv4Addr::UNSPECIFIED };
    set(bench, BlockQualifier::PERMANENT, DcpValue::IpParameter(ip));
    bench.device.application().stored.mask == [255, 0, 0, 0]
}

fn read(bench: &mut StackBench, index: u16) -> (PnioStatus, Vec<u8>) {
    let place = RecordHeader { api: 0x3D00, slot_number: 1, subslot_number: 2, index, ..RecordHeader::default() };
    let header = RecordHeader { record_data_length: 100, ..place };
    let mut blocks = Vec::new();
    ReadRequest { header, ..ReadRequest::default() }.write(&mut blocks);
    let (status, blocks) = bench.operate(Opnum::READ_IMPLICIT, &blocks);
    (status, ReadResponse::parse(&blocks).unwrap().record().to_vec())
}

pub fn unknown_index_is_refused(bench: &mut StackBench) -> bool {
    !read(bench, 0x101).0.is_ok()
}

pub fn im0_has_the_right_length(bench: &mut StackBench) -> bool {
    read(bench, 0xAFF0).1[2..4] == [0, 56]
}

pub fn missing_im_is_refused(bench: &mut StackBench) -> bool {
    bench.device.application_mut().identity.im_supported = 0;
    // A device takes its identity when it starts.
    bench.device.power(bench.now, false);
    bench.device.power(bench.now, true);
    bench.run(core::time::Duration::from_secs(3));
    bench.connect(&access_connect(AR));
    let header = RecordHeader { ar_uuid: AR, subslot_number: 1, index: 0xAFF1, ..RecordHeader::default() };
    let mut blocks = Vec::new();
    WriteRequest::of(header, alloc::vec![0; 60]).write(&mut blocks);
    bench.operate(Opnum::WRITE, &blocks).0 == PnioStatus::from(0xDF80_B000)
}

pub fn reports_its_name(bench: &mut StackBench) -> bool {
    let answers = bench.dcp(&Dcp::get(3, [Element::NAME_OF_STATION].into()), DEVICE);
    answers[0].blocks()[0].value == DcpValue::NameOfStation(b"toy".to_vec())
}

pub fn sets_for_other_devices_are_ignored(bench: &mut StackBench) -> bool {
    let name = DcpValue::NameOfStation(b"new".to_vec());
    let other = Mac([2, 0, 0, 0, 7, 7]);
    bench.dcp(&Dcp::set(3, [DcpBlock::set(BlockQualifier::PERMANENT, name)].into()), other);
    bench.device.application().stored.name == b"toy"
}

pub fn has_its_own_mac(bench: &mut StackBench) -> bool {
    bench.dcp(&Dcp::identify(7, 1, [DcpValue::Mac(DEVICE)].into()), Mac::DCP_MULTICAST).len() == 1
}

pub fn uses_the_stored_address(bench: &mut StackBench) -> bool {
    let filter = DcpValue::IpParameter(IpParameter {
        address: Ipv4Addr::new(192, 168, 0, 10),
        mask: Ipv4Addr::new(255, 255, 255, 0),
        gateway: Ipv4Addr::UNSPECIFIED,
    });
    bench.dcp(&Dcp::identify(7, 1, [filter].into()), Mac::DCP_MULTICAST).len() == 1
}

pub fn answers_after_a_reset(bench: &mut StackBench) -> bool {
    set(bench, BlockQualifier(0), DcpValue::FactoryReset);
    bench.dcp(&Dcp::identify(7, 1, [DcpValue::AllSelector].into()), Mac::DCP_MULTICAST).len() == 1
}

pub fn class_3_is_refused(bench: &mut StackBench) -> bool {
    let mut blocks = connect_blocks(&modules());
    for block in &mut blocks {
        if let ConnectContent::IocrReq(iocr) = block {
            iocr.iocr_properties = RtClass::RT_CLASS_3.into();
            iocr.frame_id = if iocr.frame_id == 0xFFFF { 0xFFFF } else { 0x0100 };
        }
    }
    !bench.connect(&Connect::of(blocks)).0.is_ok()
}

pub fn connections_come_and_go(bench: &mut StackBench) -> bool {
    let first = bench.connect(&full_connect()).0.is_ok() && bench.release().is_ok();
    first && bench.connect(&full_connect()).0.is_ok()
}

pub fn an_implicit_read_does_not_disturb(bench: &mut StackBench) -> bool {
    bench.start();
    record_is_cut(bench);
    abort(&bench.take()).is_none()
}

#[rstest]
#[case::reports_its_name(reports_its_name)]
#[case::sets_for_other_devices_are_ignored(sets_for_other_devices_are_ignored)]
#[case::has_its_own_mac(has_its_own_mac)]
#[case::uses_the_stored_address(uses_the_stored_address)]
#[case::answers_after_a_reset(answers_after_a_reset)]
#[case::class_3_is_refused(class_3_is_refused)]
#[case::connections_come_and_go(connections_come_and_go)]
#[case::an_implicit_read_does_not_disturb(an_implicit_read_does_not_disturb)]
#[case::whole_name_is_compared(whole_name_is_compared)]
#[case::filter_by_type_matches(filter_by_type_matches)]
#[case::mask_is_taken(mask_is_taken)]
#[case::module_diff_is_reported(module_diff_is_reported)]
#[case::unknown_index_is_refused(unknown_index_is_refused)]
#[case::missing_im_is_refused(missing_im_is_refused)]
#[case::im0_has_the_right_length(im0_has_the_right_length)]
#[case::identify_waits(identify_waits)]
#[case::temporary_name_is_not_stored(temporary_name_is_not_stored)]
#[case::reset_clears_the_name(reset_clears_the_name)]
#[case::answer_in_the_order_of_the_request(answer_in_the_order_of_the_request)]
#[case::answer_comes_at_once(answer_comes_at_once)]
#[case::repeated_request_is_carried_out_once(repeated_request_is_carried_out_once)]
#[case::output_length_is_compared(output_length_is_compared)]
#[case::inputs_come_under_the_agreed_frame_id(inputs_come_under_the_agreed_frame_id)]
#[case::ready_comes_after_the_parameters(ready_comes_after_the_parameters)]
#[case::record_is_cut(record_is_cut)]
#[case::inputs_are_bad_at_first(inputs_are_bad_at_first)]
#[case::outputs_have_a_consumer_status(outputs_have_a_consumer_status)]
#[case::counter_counts(counter_counts)]
#[case::problem_is_indicated(problem_is_indicated)]
#[case::padding_is_ignored(padding_is_ignored)]
#[case::stop_makes_outputs_bad(stop_makes_outputs_bad)]
#[case::bad_status_makes_outputs_bad(bad_status_makes_outputs_bad)]
#[case::missing_outputs_are_detected(missing_outputs_are_detected)]
#[case::first_alarm_is_the_one_before_0(first_alarm_is_the_one_before_0)]
#[case::alarm_is_repeated(alarm_is_repeated)]
#[case::pending_diagnosis_is_reported(pending_diagnosis_is_reported)]
fn a_device(#[case] meets_it: RequirementTrial) {
    assert!(meets_it(&mut StackBench::new()));
}
