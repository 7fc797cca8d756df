//! Each knob of [`StackBehaviour`] turned: what a controller sees of it.

use super::bench::*;
use super::connection::abort;
use crate::profinet::StackBehaviour;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use rstest::rstest;
use station::Duration;
use wire::ethernet::Mac;
use wire::octets::Order;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{Connect, Content, RtClass};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{Block, BlockQualifier, Dcp, Element, Value};
use wire::profinet::rpc::{NdrRequest, Opnum, Pdu};
use wire::profinet::rt::DataStatus;
use wire::profinet::status::PnioStatus;

type Turn = fn(&mut StackBehaviour);
/// Does something with a device and says what a healthy one would have done.
type Trial = fn(&mut Bench) -> bool;

fn set(bench: &mut Bench, qualifier: BlockQualifier, value: Value) {
    bench.dcp(&Dcp::set(3, [Block::set(qualifier, value)].into()), DEVICE);
}

fn identify_waits(bench: &mut Bench) -> bool {
    bench.dcp(&Dcp::identify(7, 0x103, [Value::AllSelector].into()), Mac::DCP_MULTICAST).is_empty()
}

fn temporary_is_forgotten(bench: &mut Bench) -> bool {
    set(bench, BlockQualifier::TEMPORARY, Value::NameOfStation(b"new".to_vec()));
    bench.device.application().stored.name.is_empty()
}

fn reset_takes_place(bench: &mut Bench) -> bool {
    set(bench, BlockQualifier(0), Value::FactoryReset);
    bench.device.application().stored.name.is_empty()
}

fn answer_in_the_order_of_the_request(bench: &mut Bench) -> bool {
    let header = wire::profinet::rpc::Header { drep: Order::Little.into(), ..bench.header(Opnum::CONNECT) };
    let (answer, _) = bench.call(&header, &NdrRequest::body(Order::Little, 100, &[])).unwrap();
    answer.order() == Order::Little
}

fn repeated_request_is_carried_out_once(bench: &mut Bench) -> bool {
    let header = bench.header(Opnum::CONNECT);
    let body = NdrRequest::body(Order::Big, 4096, &full_connect().to_vec());
    for _ in 0..2 {
        bench.pdus(&[Pdu::new(header, &body).to_vec()]);
    }
    bench.device.application().log.len() == 1
}

fn output_length_is_compared(bench: &mut Bench) -> bool {
    let mut modules = modules();
    modules[1].submodules[1].data_descriptions[1].submodule_data_length = 6;
    !bench.connect(&Connect::of(connect_blocks(&modules))).0.is_ok()
}

fn inputs_come_under_the_agreed_frame_id(bench: &mut Bench) -> bool {
    bench.start();
    bench.exchange(1);
    bench.take().iter().any(|frame| frame[16..20] == [0x88, 0x92, 0x80, 0x01])
}

fn module_diff_is_told(bench: &mut Bench) -> bool {
    let mut modules = modules();
    modules[1].submodules[1].submodule_ident_number = 99;
    bench.connect(&Connect::of(connect_blocks(&modules))).1.block(BlockType::MODULE_DIFF).is_some()
}

fn ready_comes_after_the_parameters(bench: &mut Bench) -> bool {
    bench.connect(&full_connect());
    bench.take();
    bench.exchange(2);
    let is_late = bench.ready_calls().is_empty();
    assert_eq!(bench.prm_end(), PnioStatus::OK, "PrmEnd is answered whether early or late");
    is_late
}

fn record_is_cut(bench: &mut Bench) -> bool {
    let place =
        RecordHeader { api: 0x3D00, slot_number: 1, subslot_number: 2, index: 0x100, ..RecordHeader::default() };
    let header = RecordHeader { record_data_length: 3, ..place };
    let mut blocks = Vec::new();
    ReadRequest { header, ..ReadRequest::default() }.write(&mut blocks);
    let (_, blocks) = bench.operate(Opnum::READ_IMPLICIT, &blocks);
    ReadResponse::parse(&blocks).unwrap().record().len() == 3
}

fn inputs_are_bad_at_first(bench: &mut Bench) -> bool {
    bench.connect(&full_connect());
    bench.exchange(2);
    Bench::inputs(&bench.take())[0].0[16] == 0
}

fn outputs_have_a_consumer_status(bench: &mut Bench) -> bool {
    bench.start();
    bench.exchange(1);
    Bench::inputs(&bench.take())[0].0[17] == 0x80
}

fn counter_counts(bench: &mut Bench) -> bool {
    bench.start();
    bench.exchange(2);
    let frames = Bench::inputs(&bench.take());
    frames[0].1.cycle_counter != frames[1].1.cycle_counter
}

fn problem_is_indicated(bench: &mut Bench) -> bool {
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(2);
    Bench::inputs(&bench.take()).last().unwrap().1.data_status == DataStatus(0x15)
}

fn padding_is_passed_over(bench: &mut Bench) -> bool {
    bench.start();
    bench.output_frame(&[0x80; 40], DataStatus::HEALTHY, 8);
    bench.device.application().outputs.as_deref() == Some(&[0x80; 4])
}

fn stop_makes_outputs_bad(bench: &mut Bench) -> bool {
    bench.start();
    bench.output_frame(&[0x80; 40], DataStatus(0x25), 0);
    bench.device.application().outputs.is_none()
}

fn bad_status_makes_outputs_bad(bench: &mut Bench) -> bool {
    bench.start();
    bench.output_frame(&[0x00; 40], DataStatus::HEALTHY, 0);
    bench.device.application().outputs.is_none()
}

fn missing_outputs_are_noticed(bench: &mut Bench) -> bool {
    bench.start();
    bench.run(Duration::from_secs(1));
    abort(&bench.take()).is_some()
}

fn alarms(bench: &mut Bench) -> Vec<Vec<u8>> {
    bench.take().into_iter().filter(|frame| frame.get(16..20) == Some(&[0x88, 0x92, 0xFE, 0x01])).collect()
}

fn first_alarm_is_the_one_before_0(bench: &mut Bench) -> bool {
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(1);
    alarms(bench)[0][26..28] == [0xFF, 0xFF]
}

fn alarm_is_repeated(bench: &mut Bench) -> bool {
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(60);
    alarms(bench).len() == 2
}

fn pending_diagnosis_is_told(bench: &mut Bench) -> bool {
    bench.device.application_mut().change(0x9001, true);
    bench.connect(&full_connect());
    bench.exchange(1);
    bench.prm_end();
    bench.exchange(3);
    let call = bench.ready_calls().remove(0);
    bench.answer_ready(&call, PnioStatus::OK);
    !alarms(bench).is_empty()
}

fn answer_comes_at_once(bench: &mut Bench) -> bool {
    let header = bench.header(Opnum::CONNECT);
    !bench.pdus(&[Pdu::new(header, &NdrRequest::body(Order::Big, 100, &[])).to_vec()]).is_empty()
}

fn whole_name_is_compared(bench: &mut Bench) -> bool {
    let part = Value::NameOfStation(b"to".to_vec());
    bench.dcp(&Dcp::identify(7, 1, [part].into()), Mac::DCP_MULTICAST).is_empty()
}

fn own_type_is_told(bench: &mut Bench) -> bool {
    bench.dcp(&Dcp::identify(7, 1, [Value::Vendor(b"TOY".to_vec())].into()), Mac::DCP_MULTICAST).len() == 1
}

fn mask_is_taken(bench: &mut Bench) -> bool {
    let [address, mask] = [[10, 0, 0, 7], [255, 0, 0, 0]].map(Ipv4Addr::from);
    let ip = IpParameter { address, mask, gateway: Ipv4Addr::UNSPECIFIED };
    set(bench, BlockQualifier::PERMANENT, Value::IpParameter(ip));
    bench.device.application().stored.mask == [255, 0, 0, 0]
}

fn read(bench: &mut Bench, index: u16) -> (PnioStatus, Vec<u8>) {
    let place = RecordHeader { api: 0x3D00, slot_number: 1, subslot_number: 2, index, ..RecordHeader::default() };
    let header = RecordHeader { record_data_length: 100, ..place };
    let mut blocks = Vec::new();
    ReadRequest { header, ..ReadRequest::default() }.write(&mut blocks);
    let (status, blocks) = bench.operate(Opnum::READ_IMPLICIT, &blocks);
    (status, ReadResponse::parse(&blocks).unwrap().record().to_vec())
}

fn unknown_index_is_refused(bench: &mut Bench) -> bool {
    !read(bench, 0x101).0.is_ok()
}

fn im0_tells_its_length(bench: &mut Bench) -> bool {
    read(bench, 0xAFF0).1[2..4] == [0, 56]
}

fn missing_im_is_refused(bench: &mut Bench) -> bool {
    bench.device.application_mut().identity.im_supported = 0;
    bench.connect(&access_connect(AR));
    let header = RecordHeader { ar_uuid: AR, subslot_number: 1, index: 0xAFF1, ..RecordHeader::default() };
    let mut blocks = Vec::new();
    WriteRequest::of(header, alloc::vec![0; 60]).write(&mut blocks);
    bench.operate(Opnum::WRITE, &blocks).0 == PnioStatus::from(0xDF80_B000)
}

fn tells_its_name_as_it_is(bench: &mut Bench) -> bool {
    let answers = bench.dcp(&Dcp::get(3, [Element::NAME_OF_STATION].into()), DEVICE);
    answers[0].blocks()[0].value == Value::NameOfStation(b"toy".to_vec())
}

fn sets_of_others_are_passed_over(bench: &mut Bench) -> bool {
    let name = Value::NameOfStation(b"new".to_vec());
    let other = Mac([2, 0, 0, 0, 7, 7]);
    bench.dcp(&Dcp::set(3, [Block::set(BlockQualifier::PERMANENT, name)].into()), other);
    bench.device.application().stored.name == b"toy"
}

fn has_its_own_mac(bench: &mut Bench) -> bool {
    bench.dcp(&Dcp::identify(7, 1, [Value::Mac(DEVICE)].into()), Mac::DCP_MULTICAST).len() == 1
}

fn uses_the_stored_address(bench: &mut Bench) -> bool {
    let filter = Value::IpParameter(IpParameter {
        address: Ipv4Addr::new(192, 168, 0, 10),
        mask: Ipv4Addr::new(255, 255, 255, 0),
        gateway: Ipv4Addr::UNSPECIFIED,
    });
    bench.dcp(&Dcp::identify(7, 1, [filter].into()), Mac::DCP_MULTICAST).len() == 1
}

fn answers_after_a_reset(bench: &mut Bench) -> bool {
    set(bench, BlockQualifier(0), Value::FactoryReset);
    bench.dcp(&Dcp::identify(7, 1, [Value::AllSelector].into()), Mac::DCP_MULTICAST).len() == 1
}

fn class_3_is_refused(bench: &mut Bench) -> bool {
    let mut blocks = connect_blocks(&modules());
    for block in &mut blocks {
        if let Content::IocrReq(iocr) = block {
            iocr.iocr_properties = RtClass::RT_CLASS_3.into();
            iocr.frame_id = if iocr.frame_id == 0xFFFF { 0xFFFF } else { 0x0100 };
        }
    }
    !bench.connect(&Connect::of(blocks)).0.is_ok()
}

fn connections_come_and_go(bench: &mut Bench) -> bool {
    let first = bench.connect(&full_connect()).0.is_ok() && bench.release().is_ok();
    first && bench.connect(&full_connect()).0.is_ok()
}

fn a_read_from_outside_is_harmless(bench: &mut Bench) -> bool {
    bench.start();
    record_is_cut(bench);
    abort(&bench.take()).is_none()
}

#[rstest]
#[case::told_name(|knobs: &mut StackBehaviour| knobs.told_name = |name| [name, &[0]].concat(), tells_its_name_as_it_is)]
#[case::is_addressed(|knobs: &mut StackBehaviour| knobs.is_addressed = |_, _| true, sets_of_others_are_passed_over)]
#[case::mac(|knobs: &mut StackBehaviour| knobs.mac = |_, _| Mac([0, 0, 0, 0, 0, 9]), has_its_own_mac)]
#[case::at_start(|knobs: &mut StackBehaviour| knobs.at_start = |station| station.ip = [0; 4], uses_the_stored_address)]
#[case::survives_reset(|knobs: &mut StackBehaviour| knobs.survives_reset = false, answers_after_a_reset)]
#[case::takes_rt_class(|knobs: &mut StackBehaviour| knobs.takes_rt_class = |_| true, class_3_is_refused)]
#[case::connections_ever(|knobs: &mut StackBehaviour| knobs.connections_ever = 1, connections_come_and_go)]
#[case::survives_implicit_read(|knobs: &mut StackBehaviour| knobs.survives_implicit_read = false, a_read_from_outside_is_harmless)]
#[case::answers_to(|knobs: &mut StackBehaviour| knobs.answers_to = |own, asked| own.starts_with(asked), whole_name_is_compared)]
#[case::station_type(|knobs: &mut StackBehaviour| knobs.station_type = |_| "SAMPLE", own_type_is_told)]
#[case::after_set(|knobs: &mut StackBehaviour| knobs.after_set = |before, now, stored| (now.mask, stored.mask) = (before.mask, before.mask), mask_is_taken)]
#[case::checks_submodule_ident(|knobs: &mut StackBehaviour| knobs.checks_submodule_ident = false, module_diff_is_told)]
#[case::refuses_unknown_index(|knobs: &mut StackBehaviour| knobs.refuses_unknown_index = false, unknown_index_is_refused)]
#[case::refuses_missing_im(|knobs: &mut StackBehaviour| knobs.refuses_missing_im = false, missing_im_is_refused)]
#[case::im0_octets(|knobs: &mut StackBehaviour| knobs.im0_octets = |octets| octets[3] += 6, im0_tells_its_length)]
#[case::delays_identify(|knobs: &mut StackBehaviour| knobs.delays_identify = false, identify_waits)]
#[case::forgets_temporary(|knobs: &mut StackBehaviour| knobs.forgets_temporary = false, temporary_is_forgotten)]
#[case::executes_reset(|knobs: &mut StackBehaviour| knobs.executes_reset = false, reset_takes_place)]
#[case::answer_order(|knobs: &mut StackBehaviour| knobs.answer_order = |_| Order::Big, answer_in_the_order_of_the_request)]
#[case::answer_time(|knobs: &mut StackBehaviour| knobs.answer_time = Duration::from_secs(1), answer_comes_at_once)]
#[case::keeps_answers(|knobs: &mut StackBehaviour| knobs.keeps_answers = false, repeated_request_is_carried_out_once)]
#[case::checks_output_length(|knobs: &mut StackBehaviour| knobs.checks_output_length = false, output_length_is_compared)]
#[case::input_frame_id(|knobs: &mut StackBehaviour| knobs.input_frame_id = |_| 0x8000, inputs_come_under_the_agreed_frame_id)]
#[case::reports_module_diff(|knobs: &mut StackBehaviour| knobs.reports_module_diff = false, module_diff_is_told)]
#[case::waits_for_parameters(|knobs: &mut StackBehaviour| knobs.waits_for_parameters = false, ready_comes_after_the_parameters)]
#[case::cuts_records(|knobs: &mut StackBehaviour| knobs.cuts_records = false, record_is_cut)]
#[case::inputs_wait_for_ready(|knobs: &mut StackBehaviour| knobs.inputs_wait_for_ready = false, inputs_are_bad_at_first)]
#[case::sends_consumer_status(|knobs: &mut StackBehaviour| knobs.sends_consumer_status = false, outputs_have_a_consumer_status)]
#[case::cycle_counter(|knobs: &mut StackBehaviour| knobs.cycle_counter = |_| 0, counter_counts)]
#[case::indicates_problem(|knobs: &mut StackBehaviour| knobs.indicates_problem = false, problem_is_indicated)]
#[case::finds_status_behind_data(|knobs: &mut StackBehaviour| knobs.finds_status_behind_data = false, padding_is_passed_over)]
#[case::heeds_data_status(|knobs: &mut StackBehaviour| knobs.heeds_data_status = false, stop_makes_outputs_bad)]
#[case::heeds_provider_status(|knobs: &mut StackBehaviour| knobs.heeds_provider_status = false, bad_status_makes_outputs_bad)]
#[case::watches_outputs(|knobs: &mut StackBehaviour| knobs.watches_outputs = false, missing_outputs_are_noticed)]
#[case::first_alarm_sequence(|knobs: &mut StackBehaviour| knobs.first_alarm_sequence = 0, first_alarm_is_the_one_before_0)]
#[case::repeats_alarms(|knobs: &mut StackBehaviour| knobs.repeats_alarms = false, alarm_is_repeated)]
#[case::tells_pending(|knobs: &mut StackBehaviour| knobs.tells_pending_diagnoses = false, pending_diagnosis_is_told)]
fn a_knob_makes_the_difference(#[case] turn: Turn, #[case] healthy: Trial) {
    assert!(healthy(&mut Bench::new()), "the healthy device");
    assert!(!healthy(&mut Bench::with(turn)), "the device with the knob turned");
}

#[test]
fn an_early_application_ready_is_the_only_one() {
    let mut bench = Bench::with(|knobs| knobs.waits_for_parameters = false);
    let mut connect = full_connect();
    assert!(matches!(connect.blocks.remove(0).content, Content::ArReq(_)));
    bench.connect(&full_connect());
    bench.exchange(2);
    let calls = bench.ready_calls();
    assert_eq!(calls.len(), 1);
    bench.answer_ready(&calls[0], PnioStatus::OK);
    bench.prm_end();
    bench.exchange(10);
    assert!(bench.ready_calls().is_empty());
}
