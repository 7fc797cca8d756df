//! The cycle of the PROFIBUS master: frame counts, repetitions, priorities, ends, Clear, the clock.

use crate::dp::{IDENT, MasterRig, ScriptedSlave, SlaveReaction, bits, connection};
use core::time::Duration;
use encspec_controllers::outputs::{OutputSignal, SignalCounter};
use encspec_controllers::profibus_dp::{
    ClearOutputs, ConnectionState, DataLinkAnswer, IsoModeClock, MasterOutcome, MasterRequest, OUTPUT_SLOT,
    OUTPUT_SUBSLOT, SlaveConnectionEnd,
};
use virtual_wire::null::DiesAfter;
use wire::profibus::fdl::{AnswerFunction, FdlFrame};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};

fn cyclic() -> MasterRig {
    let mut rig = MasterRig::standing(connection());
    rig.log.clear();
    rig.run(Duration::from_millis(10));
    rig
}

#[test]
fn data_are_exchanged_each_cycle_and_the_frame_count_bit_toggles() {
    let rig = cyclic();
    let exchanges = rig.exchanges();
    assert_eq!(exchanges.len(), 10);
    for pair in exchanges.windows(2) {
        assert_eq!(pair[1].0 - pair[0].0, 1_000_000);
        // FC 5D and 7D: SRD of high priority with FCV, FCB 0 and 1.
        let codes = (pair[0].1[6], pair[1].1[6]);
        assert!(matches!(codes, (0x5D, 0x7D) | (0x7D, 0x5D)), "{codes:02X?}");
    }
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn outputs_are_sent_and_inputs_are_received() {
    let mut rig = cyclic();
    rig.master.set_outputs(&[0x80, 0x00, 0x10, 0x07]);
    rig.run(Duration::from_millis(2));
    assert_eq!(rig.master.inputs(), [0x81, 0x01, 0x11, 0x08]);
    rig.master.outputs_mut().pause(true);
    let done = rig.master.cycles_done();
    rig.run(Duration::from_millis(5));
    assert_eq!(rig.master.cycles_done(), done);
    assert_eq!(rig.master.state(), ConnectionState::Exchange);
    rig.master.outputs_mut().pause(false);
    rig.run(Duration::from_millis(5));
    assert!((done + 4..=done + 6).contains(&rig.master.cycles_done()));
}

#[test]
fn a_counter_is_incremented_with_each_new_request_but_not_with_repetitions() {
    let mut rig = MasterRig::standing(connection());
    let counter = SignalCounter { low: 12, width: 4, first: 1, last: 15 };
    rig.master.outputs_mut().declare([OutputSignal { bytes: 2, little_endian: false, counters: vec![counter] }]);
    rig.master.outputs_mut().lay_out([((OUTPUT_SLOT, OUTPUT_SUBSLOT), &[0][..])]);
    rig.run(Duration::from_millis(3));
    rig.log.clear();
    rig.slave.deaf = 1;
    rig.run(Duration::from_millis(3));
    let lives: Vec<_> = rig.exchanges().iter().map(|(_, octets)| octets[7] >> 4).collect();
    let first = lives[0];
    assert_eq!(lives, [first, first, first + 1, first + 2]);
}

#[test]
fn an_unanswered_request_is_repeated_once_and_not_executed_twice() {
    let mut rig = cyclic();
    let executed = rig.slave.executed.len();
    rig.log.clear();
    rig.slave.deaf = 1;
    rig.run(Duration::from_micros(1_500));
    let exchanges = rig.exchanges();
    assert!(exchanges.len() >= 2);
    assert_eq!(exchanges[0].1, exchanges[1].1);
    // The request has 13 bytes; the slot time of 300 bits follows.
    assert_eq!(exchanges[1].0 - exchanges[0].0, bits(13 * 11) + bits(300));
    assert_eq!(rig.slave.executed.len(), executed + exchanges.len() - 1);
    assert_eq!(rig.master.state(), ConnectionState::Exchange);
}

#[test]
fn a_silent_slave_is_lost_when_the_retries_of_one_poll_are_used_up() {
    let mut rig = MasterRig::with(DiesAfter::new(ScriptedSlave::new(), 10));
    let result = rig.start(connection());
    assert!(result.standing, "{result:?}");
    rig.run(Duration::from_millis(20));
    assert_eq!(rig.master.state(), ConnectionState::None);
    assert_eq!(rig.master.take_end(), Some(SlaveConnectionEnd::Answer(DataLinkAnswer::None)));
    let exchanges = rig.exchanges();
    // Two attempts with the same frame count bit; the poll before was answered, so it had another one.
    let last: Vec<_> = exchanges.iter().rev().take(3).map(|(_, octets)| octets[6]).collect();
    assert!(matches!(last[..], [retry, first, answered] if retry == first && first != answered), "{last:02X?}");
}

#[test]
fn a_slave_that_leaves_data_exchange_ends_the_connection_at_once() {
    let mut rig = cyclic();
    rig.slave.is_exchanging = false;
    rig.run(Duration::from_millis(2));
    assert_eq!(rig.master.state(), ConnectionState::None);
    let end = rig.master.take_end().expect("it ended");
    let SlaveConnectionEnd::Answer(answer) = end else { panic!("{end:?}") };
    assert_eq!(answer.refused(), Some(AnswerFunction::NO_SERVICE));
}

#[test]
fn inputs_of_another_length_end_the_connection() {
    let mut rig = cyclic();
    rig.slave.say = |_, dsap, _| dsap.is_none().then(|| SlaveReaction::Data(AnswerFunction::DATA_LOW, vec![0; 5]));
    rig.run(Duration::from_millis(2));
    assert!(
        matches!(rig.master.take_end(), Some(SlaveConnectionEnd::Answer(DataLinkAnswer::Frame { data, .. })) if data.len() == 5)
    );
}

#[test]
fn high_priority_makes_the_master_read_the_diagnosis_once() {
    let mut rig = cyclic();
    rig.slave.executed.clear();
    rig.slave.is_high = true;
    rig.run(Duration::from_millis(10));
    let read = rig.slave.executed.iter().filter(|(sap, _)| *sap == Some(60)).count();
    assert_eq!(read, 1);
    assert_eq!(rig.master.state(), ConnectionState::Exchange);
    assert!(!rig.master.is_diagnosis_pending());
}

#[test]
fn a_static_diagnosis_is_read_once_a_cycle_and_leaves_time_for_other_requests() {
    let mut rig = cyclic();
    rig.slave.is_high = true;
    rig.slave.diagnosis[1] |= 0x02;
    rig.run(Duration::from_millis(5));
    rig.slave.executed.clear();
    rig.run(Duration::from_millis(10));
    let count = |rig: &MasterRig, sap| rig.slave.executed.iter().filter(|(dsap, _)| *dsap == sap).count();
    let (cycles, read) = (count(&rig, None), count(&rig, Some(60)));
    assert!((9..=11).contains(&cycles) && cycles.abs_diff(read) <= 1, "{cycles} cycles, {read} diagnoses");
    assert!(
        matches!(rig.ask(MasterRequest::Configuration { to: 3 }), MasterOutcome::Answer(answer) if answer.is_positive())
    );
    rig.slave.diagnosis[1] &= !0x02;
    rig.run(Duration::from_millis(3));
    rig.slave.executed.clear();
    rig.run(Duration::from_millis(5));
    assert_eq!(count(&rig, Some(60)), 0);
}

#[test]
fn a_diagnosis_with_prm_req_ends_the_connection() {
    let mut rig = cyclic();
    rig.slave.is_high = true;
    rig.slave.diagnosis = [0x02, 0x05, 0x00, 0xFF, IDENT[0], IDENT[1]];
    rig.run(Duration::from_millis(3));
    assert!(matches!(rig.master.take_end(), Some(SlaveConnectionEnd::Diagnosis(found)) if found.master == 0xFF));
    assert_eq!(rig.master.state(), ConnectionState::None);
}

#[test]
fn in_clear_the_outputs_are_zero_or_omitted() {
    for (clear, expected) in
        [(ClearOutputs::Zeros, vec![0; 4]), (ClearOutputs::Empty, vec![]), (ClearOutputs::AsSet, vec![9; 4])]
    {
        let mut rig = MasterRig::new();
        rig.slave.say = |_, dsap, _| dsap.is_none().then(|| SlaveReaction::Data(AnswerFunction::DATA_LOW, vec![1; 4]));
        let mut connection = connection();
        connection.clear = clear;
        assert!(rig.start(connection).standing);
        rig.master.set_outputs(&[9; 4]);
        let control = GlobalControl { command: GlobalCommand::CLEAR_DATA, groups: 0 };
        assert_eq!(rig.ask(MasterRequest::GlobalControl { to: 127, control }), MasterOutcome::Sent);
        rig.slave.executed.clear();
        rig.run(Duration::from_millis(3));
        assert!(rig.slave.executed.iter().any(|(sap, _)| sap.is_none()));
        assert!(rig.slave.executed.iter().filter(|(sap, _)| sap.is_none()).all(|(_, data)| *data == expected));
        let control = GlobalControl { command: GlobalCommand::default(), groups: 0 };
        rig.ask(MasterRequest::GlobalControl { to: 127, control });
        rig.run(Duration::from_millis(3));
        assert_eq!(rig.slave.executed.last(), Some(&(None, vec![9; 4])));
    }
}

/// The start times of all Global_Control frames.
fn clocks(rig: &MasterRig) -> Vec<u64> {
    let is_clock =
        |octets: &[u8]| matches!(FdlFrame::parse(octets), Ok(FdlFrame::Data(frame)) if frame.data == [0x00, 0x80]);
    rig.log.iter().filter(|entry| is_clock(&entry.3)).map(|entry| entry.0).collect()
}

#[test]
fn the_clock_of_isochronous_mode_is_exact_to_the_nanosecond_under_load() {
    let mut connection = connection();
    connection.clock = Some(IsoModeClock::default());
    connection.cycle = Duration::from_millis(2);
    let mut rig = MasterRig::standing(connection);
    rig.log.clear();
    for _ in 0..5 {
        rig.ask(MasterRequest::Read { to: 3, slot: 1, index: 7, length: 240 });
    }
    rig.run(Duration::from_millis(20));
    let clocks = clocks(&rig);
    assert!(clocks.len() > 20);
    assert!(clocks.windows(2).all(|pair| pair[1] - pair[0] == 2_000_000), "{clocks:?}");
    // Data_Exchange follows each of them: 13 bytes of clock, then max TSDR because no station answers.
    let exchanges: Vec<_> = rig.exchanges().iter().map(|(begin, _)| *begin).collect();
    assert!(clocks.iter().take(20).all(|clock| exchanges.contains(&(clock + bits(13 * 11) + bits(150)))));
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn the_clock_can_be_stopped_and_shifted_while_the_exchange_goes_on() {
    let mut connection = connection();
    connection.clock = Some(IsoModeClock::default());
    let mut rig = MasterRig::standing(connection);
    rig.run(Duration::from_millis(5));
    let before = clocks(&rig);
    rig.log.clear();
    rig.master.stop_clock(true);
    rig.run(Duration::from_millis(10));
    assert!(clocks(&rig).len() <= 1);
    assert!((9..=11).contains(&rig.exchanges().len()));
    rig.log.clear();
    rig.master.stop_clock(false);
    rig.master.shift_clock(Duration::from_micros(100));
    rig.run(Duration::from_millis(10));
    let after = clocks(&rig);
    assert!(after.len() >= 9, "{after:?}");
    assert!(after.windows(2).skip(1).all(|pair| pair[1] - pair[0] == 1_000_000), "{after:?}");
    let shift = (after[3] - before[0]) % 1_000_000;
    assert_eq!(shift, 100_000);
    assert_eq!(rig.bus.violations(), []);
}
