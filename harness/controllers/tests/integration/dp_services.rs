//! The acyclic services of the PROFIBUS master: DP-V1, addresses, the ring, damaged frames.

use crate::dp::{BAUD, MasterRig, SLAVE, ScriptedSlave, SlaveReaction, bits, connection, hex, settings};
use core::time::Duration;
use encspec_controllers::profibus_dp::{
    AcyclicError, DamagedDpFrame, DataLinkAnswer, DpParameterOutcome, DpRecordOutcome, MasterOutcome, MasterRequest,
    MasterSettings, ProfibusMaster, broken_frames,
};
use station::{Outbox, Station, Time};
use virtual_wire::VirtualBus;
use virtual_wire::null::{DiesAfter, Silent};
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::call::FunctionIndex;
use wire::profibus::diag::Specifier;
use wire::profibus::fdl::{AnswerFunction, FdlFrame, StationType};

fn acyclic(rig: &MasterRig) -> Vec<(usize, String)> {
    let services = rig.services();
    let is_exchange = |octets: &[u8]| octets.len() == 13 && octets[4] & 0x80 == 0;
    services.iter().filter(|entry| !is_exchange(&entry.3)).map(|entry| (entry.2, hex(&entry.3))).collect()
}

#[test]
fn a_record_is_requested_and_then_polled_without_data() {
    let mut rig = MasterRig::standing(connection());
    rig.log.clear();
    let outcome = rig.ask(MasterRequest::Read { to: SLAVE, slot: 1, index: 7, length: 10 });
    assert_eq!(outcome, MasterOutcome::Record(DpRecordOutcome::Accepted { data: vec![0xAB, 0xCD] }));
    // IEC 61158-6-3: DSAP and SSAP 51, SRD of low priority; two polls without an answer, then one with it.
    let frames = acyclic(&rig);
    let frames: Vec<_> = frames.iter().map(|(port, octets)| (*port, octets.as_str())).collect();
    let expected = [
        (0, "68 09 09 68 83 82 5C 33 33 5E 01 07 0A 37 16"),
        (1, "E5"),
        (0, "68 05 05 68 83 82 7C 33 33 E7 16"),
        (1, "E5"),
        (0, "68 05 05 68 83 82 5C 33 33 C7 16"),
        (1, "E5"),
        (0, "68 05 05 68 83 82 7C 33 33 E7 16"),
        (1, "A2 82 83 08 33 33 5E 01 07 02 AB CD 53 16"),
    ];
    // The parity of the frame count bit depends on the cycles before.
    let plain = |octets: &str| octets.replace("82 5C", "82 xC").replace("82 7C", "82 xC");
    let without_sum = |(port, octets): &(usize, &str)| {
        let octets = plain(octets);
        (*port, if *port == 0 { octets[..octets.len() - 6].to_string() } else { octets })
    };
    assert_eq!(
        frames.iter().map(without_sum).collect::<Vec<_>>(),
        expected.iter().map(without_sum).collect::<Vec<_>>()
    );
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn a_record_is_written_or_refused() {
    let mut rig = MasterRig::standing(connection());
    let write = MasterRequest::Write { to: SLAVE, slot: 1, index: 7, data: vec![1, 2, 3] };
    assert_eq!(rig.ask(write.clone()), MasterOutcome::Record(DpRecordOutcome::Accepted { data: vec![] }));
    rig.slave.say = |toy, dsap, data| {
        (dsap == Some(51) && !data.is_empty()).then(|| {
            toy.record = Some(vec![0xDF, 0x80, 0xB6, 0x00]);
            SlaveReaction::Short
        })
    };
    let MasterOutcome::Record(DpRecordOutcome::Refused(refusal)) = rig.ask(write.clone()) else {
        panic!("not refused")
    };
    assert_eq!((refusal.code_1, refusal.code_2), (0xB6, 0));
    rig.slave.say = |_, dsap, _| (dsap == Some(51)).then(|| SlaveReaction::Data(AnswerFunction::NO_SERVICE, vec![]));
    let MasterOutcome::Record(DpRecordOutcome::Failed(AcyclicError::Link(answer))) = rig.ask(write.clone()) else {
        panic!("the access point is not active")
    };
    assert_eq!(answer.refused(), Some(AnswerFunction::NO_SERVICE));
    rig.slave.say = |_, dsap, _| (dsap == Some(51)).then_some(SlaveReaction::Short);
    let outcome = rig.ask(write);
    let timeout = AcyclicError::Timeout(Duration::from_secs(5));
    assert_eq!(outcome, MasterOutcome::Record(DpRecordOutcome::Failed(timeout)));
}

/// Acknowledges a request to the meant access point and answers the next poll with `response`.
fn respond(slave: &mut ScriptedSlave, is_meant: bool, data: &[u8], response: &[u8]) -> Option<SlaveReaction> {
    if !is_meant {
        return None;
    }
    if data.is_empty() {
        return slave.record.take().map(|octets| SlaveReaction::Data(AnswerFunction::DATA_LOW, octets));
    }
    slave.record = Some(response.to_vec());
    Some(SlaveReaction::Short)
}

/// IEC 61158-6-3, MSAC1_Alarm_Ack: the response has to repeat slot, type and specifier.
#[test]
fn an_alarm_is_acknowledged() {
    let ask = |own_access_point: bool, say: fn(&mut ScriptedSlave, Option<u8>, &[u8]) -> Option<SlaveReaction>| {
        let mut rig = MasterRig::standing(connection());
        rig.slave.say = say;
        let (slot, alarm_type, specifier) = (1, 2, Specifier(0x19));
        let acknowledge = MasterRequest::AcknowledgeAlarm { to: SLAVE, own_access_point, slot, alarm_type, specifier };
        let outcome = rig.ask(acknowledge);
        let sap = Some(if own_access_point { 50 } else { 51 });
        assert!(rig.slave.executed.contains(&(sap, vec![0x5C, 1, 2, 0x19])), "{:?}", rig.slave.executed);
        match outcome {
            MasterOutcome::Record(outcome) => outcome,
            outcome => panic!("{outcome:?}"),
        }
    };
    let accepted = DpRecordOutcome::Accepted { data: Vec::new() };
    let good = ask(false, |slave, sap, data| respond(slave, sap == Some(51), data, &[0x5C, 1, 2, 0x19]));
    assert_eq!(good, accepted);
    let good = ask(true, |slave, sap, data| respond(slave, sap == Some(50), data, &[0x5C, 1, 2, 0x19]));
    assert_eq!(good, accepted);
    let refused = ask(false, |slave, sap, data| respond(slave, sap == Some(51), data, &[0xDC, 0x80, 0xB5, 0]));
    assert!(matches!(refused, DpRecordOutcome::Refused(_)), "{refused:?}");
    let other = ask(false, |slave, sap, data| respond(slave, sap == Some(51), data, &[0x5C, 1, 2, 0x11]));
    assert_eq!(other, DpRecordOutcome::Failed(AcyclicError::Unfit("function 0x5c".into())));
}

/// IEC 61158-6-3: the response of MS1 is fetched by polls; the request itself is only acknowledged.
#[test]
fn a_response_before_the_first_poll_does_not_fit() {
    let mut rig = MasterRig::standing(connection());
    rig.slave.say = |_, dsap, data| {
        (dsap == Some(51) && !data.is_empty())
            .then(|| SlaveReaction::Data(AnswerFunction::DATA_LOW, vec![0x5E, 1, 7, 2, 0xAB, 0xCD]))
    };
    let outcome = rig.ask(MasterRequest::Read { to: SLAVE, slot: 1, index: 7, length: 10 });
    let MasterOutcome::Record(DpRecordOutcome::Failed(AcyclicError::Unfit(why))) = outcome else {
        panic!("{outcome:?}")
    };
    assert!(why.contains("answer to the request itself"), "{why}");
}

/// The slave answers state conflict until the data are there; the response has to begin with the header of the same function.
#[test]
fn a_call_writes_its_header_and_reads_until_the_data_are_there() {
    let mut rig = MasterRig::standing(connection());
    rig.slave.say = |toy, dsap, data| {
        if dsap != Some(51) || data.is_empty() {
            return None;
        }
        let reads = toy.executed.iter().filter(|(_, data)| data.first() == Some(&0x5E)).count();
        toy.record = Some(match data {
            [0x5F, slot, 255, 4, 0x08, 0, 0xFD, 0xE8] => vec![0x5F, *slot, 255, 4],
            [0x5E, slot, 255, 240] if reads > 2 => vec![0x5E, *slot, 255, 6, 0x08, 0, 0xFD, 0xE8, 7, 9],
            [0x5F, slot, 255, 4, 0x08, 0, 0xFD, 0xE9] => vec![0x5F, *slot, 255, 4],
            _ => vec![0xDE, 0x80, 0xB5, 0],
        });
        Some(SlaveReaction::Short)
    };
    let call = |index| MasterRequest::Call { to: SLAVE, slot: 1, index };
    let accepted = DpRecordOutcome::Accepted { data: vec![7, 9] };
    assert_eq!(rig.ask(call(FunctionIndex::IM0)), MasterOutcome::Record(accepted));
    let reads = rig.slave.executed.iter().filter(|(_, data)| data.first() == Some(&0x5E)).count();
    assert_eq!(reads, 3);
    // The answer is still that of I&M0.
    let MasterOutcome::Record(DpRecordOutcome::Failed(AcyclicError::Unfit(why))) = rig.ask(call(FunctionIndex::IM1))
    else {
        panic!("another function")
    };
    assert!(why.contains("65000"), "{why}");
}

/// A slave whose answers all come from this station to that one.
struct Misaddressed {
    to: u8,
    from: u8,
    due: Option<Time>,
}

impl Station for Misaddressed {
    fn receive(&mut self, now: Time, octets: &[u8], _: &mut Outbox) {
        let is_asked = matches!(FdlFrame::parse(octets), Ok(FdlFrame::Data(frame)) if frame.da == SLAVE);
        self.due = is_asked.then(|| now.after_nanos(bits(20)));
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if self.due.take_if(|due| *due <= now).is_some() {
            out.push(&[0x10, self.to, self.from, 0x00, self.to + self.from, 0x16]);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.due
    }
}

#[test]
fn answers_with_other_addresses_are_kept_with_the_station_that_was_asked() {
    for (to, from, kept) in [(9, SLAVE, "an answer from station 3 to 9"), (2, 9, "an answer from station 9 to 2")] {
        let mut rig = MasterRig::with(Misaddressed { to, from, due: None });
        let MasterOutcome::Answer(answer) = rig.ask(MasterRequest::Diagnosis { to: SLAVE }) else {
            panic!("no answer")
        };
        assert_eq!(answer, DataLinkAnswer::Unfit(kept.into()));
        assert_eq!(rig.master.misfits(), [(SLAVE, kept.into()), (SLAVE, kept.into())], "the request and its retry");
    }
    let mut rig = MasterRig::with(Misaddressed { to: 2, from: SLAVE, due: None });
    rig.ask(MasterRequest::FdlStatus { to: SLAVE });
    assert_eq!(rig.master.misfits(), []);
}

#[test]
fn a_parameter_request_reads_again_while_the_answer_is_not_ready() {
    let mut rig = MasterRig::standing(connection());
    rig.slave.say = |toy, dsap, data| {
        let reads = toy.executed.iter().filter(|(sap, data)| *sap == Some(51) && data.first() == Some(&0x5E)).count();
        match (dsap, data.first()) {
            (Some(51), Some(0x5E)) => {
                toy.polls = 0;
                toy.record = Some(match reads {
                    ..3 => vec![0xDE, 0x80, 0xB5, 0x00],
                    _ => vec![0x5E, 1, 47, 4, 0x01, 0x01, 0x01, 0x00],
                });
                Some(SlaveReaction::Short)
            }
            _ => None,
        }
    };
    let request = vec![0x01, 0x01, 0x01, 0x01, 0x10, 0x01, 0x03, 0x9A, 0x00, 0x00];
    let outcome = rig.ask(MasterRequest::Parameter { to: SLAVE, slot: 1, request: request.clone() });
    assert_eq!(outcome, MasterOutcome::Parameter(DpParameterOutcome::Answer(vec![0x01, 0x01, 0x01, 0x00])));
    let written = rig.slave.executed.iter().find(|(_, data)| data.first() == Some(&0x5F)).cloned();
    let mut expected = vec![0x5F, 0x01, 0x2F, 0x0A];
    expected.extend(request);
    assert_eq!(written, Some((Some(51), expected)));
}

#[test]
fn eight_bytes_are_sent_in_sd2_and_accepted_in_sd3() {
    let mut rig = MasterRig::new();
    rig.slave.say = |_, _, data| Some(SlaveReaction::Data(AnswerFunction::DATA_LOW, data.to_vec()));
    rig.run(Duration::from_millis(10));
    rig.log.clear();
    let eight = vec![1, 2, 3, 4, 5, 6, 7, 8];
    let MasterOutcome::Answer(answer) = rig.ask(MasterRequest::DataExchange { to: SLAVE, octets: eight.clone() })
    else {
        panic!("a service has an answer")
    };
    assert_eq!(answer.data(), Some(&eight[..]));
    // The checksum of the request by hand: 03 + 02 + 6D + 24 = 96h.
    let frames: Vec<_> = rig.services().iter().map(|(_, _, _, octets)| hex(octets)).collect();
    assert_eq!(
        frames,
        ["68 0B 0B 68 03 02 6D 01 02 03 04 05 06 07 08 96 16", "A2 02 03 08 01 02 03 04 05 06 07 08 31 16"]
    );
}

#[test]
fn setting_an_address_resets_the_frame_count_of_both_addresses() {
    let mut rig = MasterRig::new();
    rig.slave.address = 126;
    rig.slave.say = |toy, dsap, data| {
        (dsap == Some(55)).then(|| {
            toy.address = data[0];
            SlaveReaction::Short
        })
    };
    let set = SetSlaveAddress { address: 5, ident: 0x1655, no_change: 0, slave_data: vec![] };
    assert_eq!(rig.ask(MasterRequest::SetSlaveAddress { to: 126, set }), MasterOutcome::Answer(DataLinkAnswer::Short));
    assert_eq!(rig.slave.executed.last(), Some(&(Some(55), vec![0x05, 0x16, 0x55, 0x00])));
    assert_eq!(rig.ask(MasterRequest::Diagnosis { to: 126 }), MasterOutcome::Answer(DataLinkAnswer::None));
    let MasterOutcome::Answer(answer) = rig.ask(MasterRequest::Diagnosis { to: 5 }) else { panic!("no answer") };
    assert_eq!(answer.diagnosis().map(|found| found.ident), Some(0x1655));
}

#[test]
fn single_services_report_the_answer_of_the_data_link() {
    let mut rig = MasterRig::new();
    let MasterOutcome::Answer(status) = rig.ask(MasterRequest::FdlStatus { to: SLAVE }) else { panic!("no answer") };
    assert!(matches!(status, DataLinkAnswer::Frame { function: AnswerFunction::OK, station: StationType::SLAVE, .. }));
    let MasterOutcome::Answer(cfg) = rig.ask(MasterRequest::Configuration { to: SLAVE }) else { panic!("no answer") };
    assert_eq!(cfg.data(), Some(&[0xD1, 0xE1][..]));
    let MasterOutcome::Answer(inputs) = rig.ask(MasterRequest::ReadInputs { to: SLAVE }) else { panic!("no answer") };
    assert_eq!((inputs.refused(), inputs.data()), (Some(AnswerFunction::NO_SERVICE), None));
    let MasterOutcome::Answer(data) = rig.ask(MasterRequest::DataExchange { to: SLAVE, octets: vec![1] }) else {
        panic!("none")
    };
    assert_eq!(data.refused(), Some(AnswerFunction::NO_SERVICE));
    assert_eq!(rig.ask(MasterRequest::FdlStatus { to: 77 }), MasterOutcome::Answer(DataLinkAnswer::None));
}

#[test]
fn every_tenth_token_polls_the_next_address_for_a_master() {
    let mut rig = MasterRig::new();
    rig.run(Duration::from_millis(60));
    let mut tokens = 0;
    let mut polled = Vec::new();
    for (_, _, port, octets) in &rig.log {
        match octets[..] {
            [0xDC, ..] => tokens += 1,
            [0x10, to, 2, 0x49, _, 0x16] if *port == 0 => polled.push((tokens, to)),
            _ => {}
        }
    }
    let (first, rest) = polled.split_first().expect("an address is polled");
    assert_eq!(*first, (2, 3));
    assert!(rest.len() >= 3, "{polled:?}");
    for (pair, to) in polled.windows(2).zip(4..) {
        assert_eq!((pair[1].0 - pair[0].0, pair[1].1), (10, to));
    }
}

/// Runs two masters and a slave on one bus; returns the frames with their senders.
fn two(
    second: &mut dyn station::Station,
    first: &mut ProfibusMaster,
    time: Duration,
) -> (VirtualBus, Vec<(usize, String)>) {
    let mut bus = VirtualBus::new(BAUD, settings().slot_time);
    let mut slave = ScriptedSlave::new();
    let mut log = Vec::new();
    bus.run(&mut [first, &mut slave, second], Time::ZERO + time, &mut |frame| log.push((frame.port, hex(frame.frame))));
    (bus, log)
}

#[test]
fn a_second_master_enters_the_ring_and_both_are_served() {
    let (mut first, mut second) = (ProfibusMaster::new(settings()), ProfibusMaster::new(MasterSettings::new(4, BAUD)));
    first.request(Time::ZERO, MasterRequest::Diagnosis { to: SLAVE }).expect("nothing else");
    second.request(Time::ZERO, MasterRequest::Diagnosis { to: SLAVE }).expect("nothing else");
    let (bus, log) = two(&mut second, &mut first, Duration::from_millis(200));
    let has = |port: usize, octets: &str| log.iter().any(|entry| (entry.0, entry.1.as_str()) == (port, octets));
    assert!(has(0, "DC 04 02") && has(2, "DC 02 04"), "the token rotates");
    for master in [&mut first, &mut second] {
        assert!(matches!(master.take_outcome(), Some(MasterOutcome::Answer(answer)) if answer.diagnosis().is_some()));
    }
    assert_eq!(bus.violations(), []);
}

#[test]
fn a_master_that_dies_leaves_the_ring() {
    let mut first = ProfibusMaster::new(settings());
    let mut second = DiesAfter::new(ProfibusMaster::new(MasterSettings::new(4, BAUD)), 40);
    let (bus, log) = two(&mut second, &mut first, Duration::from_millis(300));
    let passed = log.iter().filter(|(_, octets)| octets == "DC 04 02").count();
    assert!(passed > 3, "it was in the ring");
    let last: Vec<_> = log.iter().rev().take(5).map(|(_, octets)| octets.as_str()).collect();
    assert!(last.iter().filter(|octets| **octets == "DC 02 02").count() >= 3, "{last:?}");
    assert_eq!(bus.violations(), []);
}

#[test]
fn a_master_without_the_token_reports_it() {
    /// Sends a token from 9 to 9 every 500 µs, like a master that keeps the bus for itself.
    struct Greedy(Time);
    impl station::Station for Greedy {
        fn receive(&mut self, _: Time, _: &[u8], _: &mut station::Outbox) {}
        fn wake(&mut self, now: Time, out: &mut station::Outbox) {
            if now >= self.0 {
                out.push(&[0xDC, 9, 9]);
                self.0 = now + Duration::from_micros(500);
            }
        }
        fn deadline(&self) -> Option<Time> {
            Some(self.0)
        }
    }
    let mut rig = MasterRig::with(Greedy(Time::ZERO));
    let outcome = rig.ask(MasterRequest::Diagnosis { to: SLAVE });
    assert_eq!(outcome, MasterOutcome::Impossible("the master does not get the token"));
}

#[test]
fn after_a_damaged_frame_the_bus_stays_idle_for_the_slot_time() {
    for (word, _) in broken_frames() {
        let broken = DamagedDpFrame::by_word(word).expect("the table names itself");
        let mut rig = MasterRig::with(Silent);
        rig.run(Duration::from_millis(10));
        rig.log.clear();
        let outcome = rig.ask(MasterRequest::Broken { to: SLAVE, broken });
        let MasterOutcome::Broken { octets, answer } = outcome else { panic!("{outcome:?}") };
        assert_eq!(answer, DataLinkAnswer::None, "{word}");
        rig.run(Duration::from_millis(10));
        let at = rig.log.iter().position(|entry| entry.3 == octets).expect("it was sent");
        assert!(rig.log[at + 1].0 - rig.log[at].1 >= bits(300), "{word}");
        let is_frame = FdlFrame::parse(&octets).is_ok();
        let is_meant = matches!(
            broken,
            DamagedDpFrame::UnknownFunction | DamagedDpFrame::UnknownAccessPoint | DamagedDpFrame::SetPrmShort
        );
        assert_eq!(is_frame, is_meant, "{word}: {}", hex(&octets));
    }
}

/// A slave that answers whatever it receives.
struct AnswersEverything(Option<Time>);

impl Station for AnswersEverything {
    fn receive(&mut self, now: Time, octets: &[u8], _: &mut Outbox) {
        let is_token = matches!(FdlFrame::parse(octets), Ok(FdlFrame::Token { .. }));
        self.0 = (!is_token).then(|| now.after_nanos(bits(20)));
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if self.0.take_if(|due| *due <= now).is_some() {
            // SD1 from the slave to the master: service not activated (RS).
            out.push(&[0x10, 2, SLAVE, 0x03, 2 + SLAVE + 3, 0x16]);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.0
    }
}

#[test]
fn what_comes_after_a_damaged_frame_is_its_outcome() {
    for (word, _) in broken_frames() {
        let broken = DamagedDpFrame::by_word(word).expect("the table names itself");
        let mut rig = MasterRig::with(AnswersEverything(None));
        rig.run(Duration::from_millis(10));
        let outcome = rig.ask(MasterRequest::Broken { to: SLAVE, broken });
        let MasterOutcome::Broken { octets, answer } = outcome else { panic!("{outcome:?}") };
        assert_eq!(answer.refused(), Some(AnswerFunction::NO_SERVICE), "{word}");
        assert_eq!(rig.log.iter().filter(|entry| entry.3 == octets).count(), 1, "{word} is not repeated");
    }
}

#[test]
fn noise_on_the_line_is_not_an_answer() {
    let mut rig = MasterRig::standing(connection());
    rig.slave.say = |_, dsap, _| (dsap == Some(60)).then_some(SlaveReaction::Nothing);
    rig.log.clear();
    rig.master.request(rig.bus.now(), MasterRequest::Diagnosis { to: SLAVE }).expect("nothing else");
    // Noise after each request.
    for _ in 0..400 {
        let before = rig.log.len();
        rig.run(Duration::from_micros(10));
        if rig.log.get(before).is_some_and(|entry| entry.2 == 0 && entry.3.get(7) == Some(&60)) {
            let _ = rig.bus.inject(7, &[0x00, 0x55]);
        }
    }
    let outcome = rig.master.take_outcome().expect("it was given up");
    assert!(matches!(outcome, MasterOutcome::Answer(DataLinkAnswer::Unfit(_) | DataLinkAnswer::None)), "{outcome:?}");
}
