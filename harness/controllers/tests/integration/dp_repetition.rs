//! Requests that the PROFIBUS master sends again with the same frame count bit.

use crate::dp::{MasterRig, SLAVE, ScriptedSlave, bits, connection, hex};
use encspec_controllers::profibus_dp::{
    DataLinkAnswer, DpRecordOutcome, MasterOutcome, MasterRequest, RepeatedAnswers,
};
use station::{Outbox, Station, Time};
use virtual_wire::null::Silent;
use wire::profibus::fdl::{AnswerFunction, StationType};
use wire::profibus::global_control::GlobalControl;

fn repeated<D: Station>(rig: &mut MasterRig<D>, request: MasterRequest, times: u8) -> RepeatedAnswers {
    match rig.ask(MasterRequest::Repeated { request: Box::new(request), times }) {
        MasterOutcome::Repeated(answers) => *answers,
        other => panic!("{other:?}"),
    }
}

fn data(data: &[u8]) -> DataLinkAnswer {
    let function = AnswerFunction::DATA_LOW;
    DataLinkAnswer::Frame { function, station: StationType::SLAVE, data: data.to_vec() }
}

#[test]
fn each_frame_follows_its_answer_unchanged() {
    let mut rig = MasterRig::standing(connection());
    (rig.log, rig.slave.executed) = (Vec::new(), Vec::new());
    let outputs = MasterRequest::DataExchange { to: SLAVE, octets: vec![9, 8, 7, 6] };
    let answers = repeated(&mut rig, outputs, 2);
    assert_eq!(answers.outcome, MasterOutcome::Answer(data(&[10, 9, 8, 7])));
    assert_eq!((answers.answered, answers.difference), (2, None));
    let carried_out = rig.slave.executed.iter().filter(|(_, data)| data.as_slice() == [9, 8, 7, 6]).count();
    assert_eq!(carried_out, 1);
    let frames: Vec<(usize, String)> = rig.log.iter().map(|entry| (entry.2, hex(&entry.3))).collect();
    let is_request = |octets: &str| octets.contains("09 08 07 06");
    let first = frames.iter().position(|(_, octets)| is_request(octets)).expect("it was sent");
    let six = &frames[first..first + 6];
    assert!(six.iter().step_by(2).all(|frame| *frame == six[0]), "{six:?}");
    assert!(six.iter().skip(1).step_by(2).all(|frame| *frame == six[1]), "{six:?}");
    assert_eq!(frames.iter().filter(|(_, octets)| is_request(octets)).count(), 3);
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn the_request_and_the_polls_of_a_record_are_repeated() {
    let mut rig = MasterRig::standing(connection());
    let answers = repeated(&mut rig, MasterRequest::Read { to: SLAVE, slot: 1, index: 7, length: 10 }, 1);
    assert_eq!(answers.outcome, MasterOutcome::Record(DpRecordOutcome::Accepted { data: vec![0xAB, 0xCD] }));
    // The request, two polls without an answer and one with it.
    assert_eq!((answers.answered, answers.difference), (4, None));
    assert!(matches!(rig.ask(MasterRequest::Diagnosis { to: SLAVE }), MasterOutcome::Answer(_)));
}

/// A slave that carries out each request, also a repeated one.
struct Forgetful(ScriptedSlave);

impl Station for Forgetful {
    fn receive(&mut self, now: Time, octets: &[u8], out: &mut Outbox) {
        self.0.last = None;
        self.0.receive(now, octets, out);
    }
    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.0.wake(now, out);
    }
    fn deadline(&self) -> Option<Time> {
        self.0.deadline()
    }
}

#[test]
fn another_answer_to_the_same_frame_is_reported() {
    let mut rig = MasterRig::with(Forgetful(ScriptedSlave::new()));
    assert!(rig.start(connection()).standing);
    // Each new diagnosis shows how often it was read.
    rig.slave.0.say = |slave, dsap, _| {
        slave.diagnosis[2] += u8::from(dsap == Some(60));
        None
    };
    let answers = repeated(&mut rig, MasterRequest::Diagnosis { to: SLAVE }, 3);
    let diagnosis = |count| data(&[0x00, 0x0C, count, 2, 0x16, 0x55]);
    assert_eq!(answers.outcome, MasterOutcome::Answer(diagnosis(1)));
    assert_eq!((answers.answered, answers.difference), (0, Some((diagnosis(1), diagnosis(2)))));
}

/// The first request to a station is carried out each time, so it cannot be repeated (IEC 61158-4-3, frame count bit).
#[test]
fn a_diagnosis_goes_ahead_to_a_station_that_was_not_addressed_yet() {
    let mut rig = MasterRig::new();
    let answers = repeated(&mut rig, MasterRequest::Configuration { to: SLAVE }, 1);
    assert_eq!(answers.outcome, MasterOutcome::Answer(data(&[0xD1, 0xE1])));
    assert_eq!((answers.answered, answers.difference), (1, None));
    let points: Vec<Option<u8>> = rig.slave.executed.iter().map(|(sap, _)| *sap).collect();
    assert_eq!(points, [Some(60), Some(59)]);
}

/// Answers new requests and no repetition.
struct OnceOnly(ScriptedSlave);

impl Station for OnceOnly {
    fn receive(&mut self, now: Time, octets: &[u8], out: &mut Outbox) {
        let done = self.0.executed.len();
        self.0.receive(now, octets, out);
        if self.0.executed.len() == done {
            self.0.reply = None;
        }
    }
    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.0.wake(now, out);
    }
    fn deadline(&self) -> Option<Time> {
        self.0.deadline()
    }
}

#[test]
fn silence_after_a_repetition_is_a_difference() {
    let mut rig = MasterRig::with(OnceOnly(ScriptedSlave::new()));
    assert!(rig.start(connection()).standing);
    let answers = repeated(&mut rig, MasterRequest::Configuration { to: SLAVE }, 1);
    assert_eq!((answers.answered, answers.difference), (0, Some((data(&[0xD1, 0xE1]), DataLinkAnswer::None))));
    let mut rig = MasterRig::with(Silent);
    let answers = repeated(&mut rig, MasterRequest::Configuration { to: SLAVE }, 1);
    assert_eq!((answers.outcome, answers.difference), (MasterOutcome::Answer(DataLinkAnswer::None), None));
}

/// A slave after whose answer to Get_Cfg another master sends a token, before the repetition.
struct WithIntruder(ScriptedSlave, Option<Time>);

impl Station for WithIntruder {
    fn receive(&mut self, now: Time, octets: &[u8], out: &mut Outbox) {
        self.0.receive(now, octets, out);
    }
    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if self.1.take_if(|due| *due <= now).is_some() {
            out.push(&[0xDC, 9, 9]);
        }
        let is_answer = self.0.reply.as_ref().is_some_and(|(due, answer)| *due <= now && answer.contains(&0xE1));
        self.0.wake(now, out);
        if is_answer {
            // The answer has 13 bytes; 20 bits of silence, where the master waits for 37.
            self.1 = Some(now.after_nanos(bits(13 * 11 + 20)));
        }
    }
    fn deadline(&self) -> Option<Time> {
        self.0.deadline().into_iter().chain(self.1).min()
    }
}

#[test]
fn a_token_of_another_master_ends_the_repetition_without_accusing_the_slave() {
    let mut rig = MasterRig::with(WithIntruder(ScriptedSlave::new(), None));
    rig.ask(MasterRequest::Diagnosis { to: SLAVE });
    let answers = repeated(&mut rig, MasterRequest::Configuration { to: SLAVE }, 1);
    assert_eq!(answers.outcome, MasterOutcome::Answer(data(&[0xD1, 0xE1])));
    assert_eq!((answers.answered, answers.difference), (0, None));
}

#[test]
fn requests_without_a_frame_count_bit_are_not_repeated() {
    let mut rig = MasterRig::standing(connection());
    let requests = [
        MasterRequest::FdlStatus { to: SLAVE },
        MasterRequest::GlobalControl { to: SLAVE, control: GlobalControl { command: Default::default(), groups: 0 } },
        MasterRequest::Connect(Box::new(connection())),
        MasterRequest::Raw(vec![0xE5]),
    ];
    for request in requests {
        let outcome = rig.ask(MasterRequest::Repeated { request: Box::new(request.clone()), times: 1 });
        assert!(matches!(outcome, MasterOutcome::Impossible(_)), "{request:?}: {outcome:?}");
    }
    assert!(matches!(rig.ask(MasterRequest::FdlStatus { to: SLAVE }), MasterOutcome::Answer(_)));
}
