//! The PROFIBUS master as class 2 master. The bytes are those of public documents: the Initiate of an encoder (Balluff BTL7-T500,
//! configuration guide, tables 4-15 to 4-20) and the establishment of a connection (felser.ch, PROFIBUS manual).

use crate::dp::{MasterRig, SLAVE, ScriptedSlave, SlaveReaction, connection, hex};
use core::time::Duration;
use encspec_controllers::profibus_dp::{
    AcyclicError, DataLinkAnswer, DpRecordOutcome, MasterOutcome, MasterRequest, Ms2End, Ms2Outcome, Ms2Parameters,
    Ms2Service,
};
use wire::profibus::dpv1::{Dpv1AbortReason, Subnet};
use wire::profibus::fdl::AnswerFunction;

/// Max_Len_Data_Unit 240, reading and writing, profile 0303h, API 0 at both ends.
const GRANTED: [u8; 16] = [0x57, 0xF0, 1, 0, 0, 0, 3, 3, 0, 2, 0, 2, 0, 0, 0, 0];

/// A resource manager that assigns the access point 48 with a Send_Timeout of 500 ms, and the connection behind it.
fn class_2(slave: &mut ScriptedSlave, dsap: Option<u8>, data: &[u8]) -> Option<SlaveReaction> {
    let low = |data: Vec<u8>| SlaveReaction::Data(AnswerFunction::DATA_LOW, data);
    let answer = match (dsap?, data) {
        (49, [0x57, ..]) => vec![0x56, 48, 0, 50],
        (48, [0x48]) => vec![0x48],
        (48, [0x5E, slot, index, _]) => vec![0x5E, *slot, *index, 2, 0xAB, 0xCD],
        (48, [0x5F, ..]) => vec![0xDF, 0x80, 0xB2, 5],
        (48, [0x58, ..]) => return Some(SlaveReaction::Short),
        (49, []) => {
            let manager = slave.record.replace(GRANTED.to_vec());
            return Some(manager.map_or(SlaveReaction::Short, low));
        }
        (48, []) => return Some(slave.record.take().map_or(SlaveReaction::Short, low)),
        _ => return None,
    };
    slave.record = Some(answer);
    Some(SlaveReaction::Short)
}

fn request(service: Ms2Service) -> MasterRequest {
    MasterRequest::Ms2 { to: SLAVE, service }
}

fn initiate() -> MasterRequest {
    request(Ms2Service::Initiate(Ms2Parameters::default()))
}

fn rig() -> MasterRig {
    let mut rig = MasterRig::new();
    rig.slave.say = class_2;
    rig
}

fn opened() -> MasterRig {
    let mut rig = rig();
    let MasterOutcome::Ms2(Ms2Outcome::Opened(opened)) = rig.ask(initiate()) else { panic!("refused") };
    assert_eq!((opened.sap, opened.most_data, opened.abilities.profile), (48, 240, 0x0303));
    assert_eq!(opened.send_timeout, Duration::from_secs(1), "the longer of both");
    rig
}

/// The PDUs to and from the slave on MS2, without polls and acknowledgements: the port, then the bytes from the access points on.
fn pdus(rig: &MasterRig) -> Vec<String> {
    let services = rig.services();
    let long = services.iter().filter(|entry| matches!(entry.3[0], 0x68 | 0xA2));
    let text = long.map(|entry| {
        let from = if entry.3[0] == 0x68 { 7 } else { 4 };
        format!("{} {}", entry.2, hex(&entry.3[from..entry.3.len() - 2]))
    });
    text.filter(|text| text.len() > 8).collect()
}

#[test]
fn a_connection_is_opened_by_the_resource_manager() {
    let rig = opened();
    let expected = [
        "0 31 32 57 00 00 00 00 64 01 00 00 00 00 00 00 02 00 02 00 00 00 00",
        "1 32 31 56 30 00 32",
        "1 32 30 57 F0 01 00 00 00 03 03 00 02 00 02 00 00 00 00",
    ];
    assert_eq!(pdus(&rig), expected);
    assert_eq!(rig.master.ms2_slave(), Some(SLAVE));
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn records_go_over_the_connection_with_and_without_data_exchange() {
    for is_standing in [false, true] {
        let mut rig = opened();
        if is_standing {
            assert!(rig.start(connection()).standing);
        }
        let read = Ms2Service::Read { slot: 1, index: 7, length: 10 };
        let accepted = DpRecordOutcome::Accepted { data: vec![0xAB, 0xCD] };
        assert_eq!(rig.ask(request(read)), MasterOutcome::Ms2(Ms2Outcome::Record(accepted)));
        let write = Ms2Service::Write { slot: 1, index: 7, data: vec![1] };
        let MasterOutcome::Ms2(Ms2Outcome::Record(DpRecordOutcome::Refused(refusal))) = rig.ask(request(write)) else {
            panic!("accepted")
        };
        assert_eq!((refusal.decode.0, refusal.code_1, refusal.code_2), (0x80, 0xB2, 5));
        assert_eq!(rig.master.ms2_slave(), Some(SLAVE), "a refusal closes nothing");
    }
}

#[test]
fn idle_keeps_a_connection_that_nothing_uses() {
    let mut rig = opened();
    rig.log.clear();
    rig.run(Duration::from_secs(3));
    let pdus = pdus(&rig);
    // Each half of the Send_Timeout of 1 s.
    assert!((5..=6).contains(&pdus.iter().filter(|pdu| *pdu == "0 30 32 48").count()), "{pdus:?}");
    assert!((5..=6).contains(&pdus.iter().filter(|pdu| *pdu == "1 32 30 48").count()), "{pdus:?}");
    assert_eq!(rig.master.take_outcome(), None);
    assert!(!rig.master.is_busy());
}

#[test]
fn a_request_waits_for_the_answer_to_idle() {
    let mut rig = opened();
    // Idle is not answered until the slave is asked for something else.
    rig.slave.say = |slave, dsap, data| match (dsap, data) {
        (Some(48), [0x48]) => Some(SlaveReaction::Short),
        _ => class_2(slave, dsap, data),
    };
    rig.run(Duration::from_millis(600));
    assert!(!rig.master.is_busy(), "Idle is no request of the caller");
    rig.master.request(rig.bus.now(), MasterRequest::Diagnosis { to: SLAVE }).expect("the caller has asked nothing");
    assert!(rig.master.is_busy());
    rig.slave.record = Some(vec![0x48]);
    rig.run(Duration::from_millis(10));
    assert!(matches!(rig.master.take_outcome(), Some(MasterOutcome::Answer(_))));
    assert_eq!(rig.master.ms2_slave(), Some(SLAVE));
}

#[test]
fn the_master_aborts_a_connection_on_which_nothing_comes_back() {
    let mut rig = opened();
    rig.slave.say = |_, dsap, _| (dsap == Some(48)).then_some(SlaveReaction::Short);
    rig.log.clear();
    rig.run(Duration::from_secs(4));
    // No subnet, instance MS2, reason TO.
    assert_eq!(pdus(&rig).last().map(String::as_str), Some("0 30 32 58 00 13"));
    let end = rig.master.take_ms2_end();
    assert!(matches!(end, Some(Ms2Outcome::Failed(AcyclicError::Timeout(_)))), "{end:?}");
    assert_eq!((rig.master.ms2_slave(), rig.master.is_busy()), (None, false));
}

#[test]
fn a_slow_slave_keeps_the_connection_by_idle() {
    let mut rig = opened();
    rig.slave.polls = 0;
    rig.slave.say = |slave, dsap, data| match (dsap, data) {
        (Some(48), [0x5E, ..]) => Some(SlaveReaction::Short),
        // Idle each 1000 polls, the response after 3000: longer than the timeout of 2 s.
        (Some(48), []) => {
            slave.polls += 1;
            match slave.polls {
                1_000 | 2_000 => Some(SlaveReaction::Data(AnswerFunction::DATA_LOW, vec![0x48])),
                3_000 => Some(SlaveReaction::Data(AnswerFunction::DATA_LOW, vec![0x5E, 1, 7, 1, 9])),
                _ => Some(SlaveReaction::Short),
            }
        }
        _ => class_2(slave, dsap, data),
    };
    let read = Ms2Service::Read { slot: 1, index: 7, length: 10 };
    let accepted = DpRecordOutcome::Accepted { data: vec![9] };
    assert_eq!(rig.ask(request(read)), MasterOutcome::Ms2(Ms2Outcome::Record(accepted)));
}

#[test]
fn a_connection_is_closed_by_either_side() {
    let mut rig = opened();
    let abort = Ms2Service::Abort { subnet: Subnet::LOCAL, reason: Dpv1AbortReason(0x21) };
    let closed = MasterOutcome::Ms2(Ms2Outcome::Aborted(DataLinkAnswer::Short));
    assert_eq!(rig.ask(request(abort.clone())), closed);
    assert_eq!(pdus(&rig).last().map(String::as_str), Some("0 30 32 58 01 21"));
    assert!(matches!(rig.ask(request(abort)), MasterOutcome::Impossible(_)), "nothing to close");

    let mut rig = opened();
    rig.slave.say = |slave, dsap, data| match (dsap, data) {
        (Some(48), [0x5E, ..]) => {
            slave.record = Some(vec![0x58, 0, 0x12]);
            Some(SlaveReaction::Short)
        }
        _ => class_2(slave, dsap, data),
    };
    let read = Ms2Service::Read { slot: 1, index: 7, length: 10 };
    let end = Ms2End { subnet: Subnet::NO, reason: Dpv1AbortReason::BAD_REQUEST };
    assert_eq!(rig.ask(request(read)), MasterOutcome::Ms2(Ms2Outcome::Record(DpRecordOutcome::Aborted(end))));
    assert_eq!(rig.master.ms2_slave(), None);
}

#[test]
fn initiate_is_refused_by_the_slave_or_its_data_link() {
    let mut rig = rig();
    rig.slave.say = |slave, dsap, data| {
        let said = class_2(slave, dsap, data);
        if (dsap, data) == (Some(49), &[][..]) && slave.record.as_deref() == Some(&GRANTED) {
            slave.record = Some(vec![0xD7, 0x80, 0xC3, 0]);
        }
        said
    };
    let MasterOutcome::Ms2(Ms2Outcome::Refused(refusal)) = rig.ask(initiate()) else { panic!("opened") };
    assert_eq!((refusal.function.0, refusal.code_1), (0xD7, 0xC3));
    for function in [AnswerFunction::NO_SERVICE, AnswerFunction::NO_RESOURCE] {
        let mut rig = MasterRig::new();
        rig.slave.say = match function {
            AnswerFunction::NO_SERVICE => {
                |_, dsap, _| (dsap == Some(49)).then(|| SlaveReaction::Data(AnswerFunction::NO_SERVICE, vec![]))
            }
            _ => |_, dsap, _| (dsap == Some(49)).then(|| SlaveReaction::Data(AnswerFunction::NO_RESOURCE, vec![])),
        };
        let MasterOutcome::Ms2(Ms2Outcome::Failed(AcyclicError::Link(answer))) = rig.ask(initiate()) else {
            panic!("opened")
        };
        assert_eq!((answer.refused(), rig.master.ms2_slave()), (Some(function), None));
    }
}

#[test]
fn a_master_has_one_connection_and_loses_it_by_abort() {
    let mut rig = opened();
    assert!(matches!(rig.ask(initiate()), MasterOutcome::Impossible(_)));
    rig.ask(MasterRequest::Abort);
    assert_eq!(rig.master.ms2_slave(), None);
    assert!(matches!(rig.ask(initiate()), MasterOutcome::Ms2(Ms2Outcome::Opened(_))));
}
