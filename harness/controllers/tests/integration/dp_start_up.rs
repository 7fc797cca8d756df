//! How the PROFIBUS master obtains the token and starts up a slave, frame by frame according to the standard.

use crate::dp::{MasterRig, SLAVE, ScriptedSlave, SlaveReaction, bits, connection, hex};
use core::time::Duration;
use encspec_controllers::profibus_dp::{
    ConnectionState, DataLinkAnswer, MasterOutcome, MasterRequest, SlaveFailureReason, SlaveReleaseOutcome,
    SlaveStartUpResult, SlaveStartUpStage, StartUpService,
};
use wire::profibus::fdl::AnswerFunction;

#[test]
fn the_master_listens_for_tto_and_then_sends_the_token_to_itself_twice() {
    let mut rig = MasterRig::new();
    rig.run(Duration::from_millis(4));
    // TTO = (6 + 2 * 2) slot times of 300 bits.
    let octets: Vec<_> = rig.log.iter().take(2).map(|(_, _, _, octets)| hex(octets)).collect();
    assert_eq!(octets, ["DC 02 02", "DC 02 02"]);
    assert_eq!(rig.log[0].0, bits(3_000));
    assert_eq!(rig.log[1].0, rig.log[0].1 + bits(37));
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn a_start_up_has_its_frames_in_the_usual_order() {
    let mut rig = MasterRig::new();
    let result = rig.start(connection());
    let short = Some(DataLinkAnswer::Short);
    assert_eq!((result.standing, &result.failed, &result.set_prm, &result.chk_cfg), (true, &None, &short, &short));
    assert_eq!(result.diagnosis_before.and_then(|answer| answer.diagnosis()).map(|found| found.ident), Some(0x1655));
    // IEC 61158-4-3: SD2, LE, LEr, SD2, DA, SA, FC, DAE, SAE, data, FCS, ED, with the FCS added up by hand; SD3 where eight bytes
    // follow the function code.
    let expected = [
        (0, "68 05 05 68 83 82 6D 3C 3E EC 16"),
        (1, "A2 82 83 08 3E 3C 02 05 00 FF 16 55 F8 16"),
        (0, "68 0C 0C 68 83 82 5D 3D 3E 80 01 01 0B 16 55 00 D5 16"),
        (1, "E5"),
        (0, "68 07 07 68 83 82 7D 3E 3E D1 E1 B0 16"),
        (1, "E5"),
        (0, "68 05 05 68 83 82 5D 3C 3E DC 16"),
        (1, "A2 82 83 08 3E 3C 00 0C 00 02 16 55 00 16"),
        (0, "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16"),
        (0, "68 07 07 68 03 02 7D 00 00 00 00 82 16"),
        (1, "68 07 07 68 02 03 08 01 01 01 01 11 16"),
    ];
    let frames: Vec<_> = rig.services().iter().map(|(_, _, port, octets)| (*port, hex(octets))).collect();
    let frames: Vec<_> = frames.iter().map(|(port, octets)| (*port, octets.as_str())).collect();
    assert_eq!(frames, expected);
    assert_eq!(rig.master.inputs(), [1; 4]);
    assert_eq!(rig.master.state(), ConnectionState::Exchange);
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn between_two_messages_of_a_start_up_the_token_rotates() {
    let mut rig = MasterRig::new();
    rig.start(connection());
    let order: Vec<_> = rig.log.iter().map(|(_, _, port, octets)| (*port, octets[0])).collect();
    for pair in order.windows(2) {
        let both_ask = pair.iter().all(|(port, start)| *port == 0 && *start == 0x68);
        assert!(!both_ask || rig.services().len() < 2 || order.len() > 2, "{order:02X?}");
    }
    let tokens = order.iter().filter(|(_, start)| *start == 0xDC).count();
    assert!(tokens >= 6, "{tokens} tokens");
}

#[test]
fn the_search_for_an_absent_slave_times_out() {
    let mut rig = MasterRig::with(ScriptedSlave { address: 9, ..ScriptedSlave::new() });
    let result = rig.start(connection());
    let failed = result.failed.expect("no station answered");
    assert_eq!(
        (failed.stage, failed.why),
        (SlaveStartUpStage::Diagnosis, SlaveFailureReason::Answer(DataLinkAnswer::None))
    );
    assert!(rig.bus.now().as_nanos() >= 3_000_000_000);
    assert_eq!(rig.master.state(), ConnectionState::None);
    // Each request is sent twice (one repetition) with the same bytes, a slot time apart.
    let diagnoses: Vec<_> = rig.services();
    assert_eq!(diagnoses[0].3, diagnoses[1].3);
    assert_eq!(diagnoses[1].0, diagnoses[0].1 + bits(300));
}

#[test]
fn the_diagnosis_reports_refused_parameters() {
    let mut rig = MasterRig::with(ScriptedSlave {
        say: |toy, dsap, _| match dsap {
            Some(61) => {
                toy.diagnosis[0] |= 0x40;
                Some(SlaveReaction::Short)
            }
            Some(62) => Some(SlaveReaction::Data(AnswerFunction::NO_SERVICE, Vec::new())),
            _ => None,
        },
        ..ScriptedSlave::new()
    });
    let result = rig.start(connection());
    assert_eq!(result.set_prm, Some(DataLinkAnswer::Short));
    assert_eq!(result.chk_cfg.and_then(|answer| answer.refused()), Some(AnswerFunction::NO_SERVICE));
    let failed = result.failed.expect("the parameters were refused");
    assert_eq!(failed.stage, SlaveStartUpStage::Ready);
    assert!(matches!(failed.why, SlaveFailureReason::Diagnosis(found) if found.status_1.0 == 0x42));
}

#[test]
fn a_slave_is_polled_until_it_is_ready() {
    let mut rig = MasterRig::with(ScriptedSlave {
        say: |toy, dsap, _| {
            let diagnoses = toy.executed.iter().filter(|(sap, _)| *sap == Some(60)).count();
            if dsap == Some(60) && diagnoses > 4 {
                toy.diagnosis[0] = 0;
            } else if dsap == Some(62) {
                toy.diagnosis[0] = 0x02;
                (toy.diagnosis[1], toy.is_exchanging) = (0x04, true);
                return Some(SlaveReaction::Short);
            }
            None
        },
        ..ScriptedSlave::new()
    });
    let result = rig.start(connection());
    assert!(result.standing, "{result:?}");
    let diagnoses = rig.slave.executed.iter().filter(|(sap, _)| *sap == Some(60)).count();
    assert_eq!(diagnoses, 5);
}

#[test]
fn the_order_of_services_may_be_wrong() {
    let mut rig = MasterRig::new();
    let services = vec![StartUpService::CheckConfiguration, StartUpService::SetPrm, StartUpService::Exchange];
    let mut wrong = connection();
    wrong.services = services;
    let result: SlaveStartUpResult = rig.start(wrong);
    let order: Vec<_> = rig.slave.executed.iter().map(|(sap, _)| *sap).take(3).collect();
    assert_eq!(order, [Some(62), Some(61), None]);
    assert!(result.standing);
}

#[test]
fn release_unlocks_the_slave_and_abort_sends_nothing() {
    let mut rig = MasterRig::standing(connection());
    assert_eq!(
        rig.ask(MasterRequest::Release),
        MasterOutcome::Ended(SlaveReleaseOutcome::Released(DataLinkAnswer::Short))
    );
    // Status 40: unlock; then the factors, min TSDR, ident and groups of the connection.
    let last = rig.slave.executed.last().cloned();
    assert_eq!(last, Some((Some(61), vec![0x40, 0x01, 0x01, 0x0B, 0x16, 0x55, 0x00])));
    assert_eq!(rig.master.state(), ConnectionState::None);
    assert_eq!(rig.ask(MasterRequest::Release), MasterOutcome::Ended(SlaveReleaseOutcome::NoConnection));

    let mut rig = MasterRig::standing(connection());
    let frames = rig.slave.executed.len();
    assert_eq!(rig.ask(MasterRequest::Abort), MasterOutcome::Ended(SlaveReleaseOutcome::Aborted));
    rig.run(Duration::from_millis(20));
    assert!(rig.slave.executed.len() <= frames + 1);
    assert_eq!(rig.master.state(), ConnectionState::None);
}

#[test]
fn abort_ends_a_running_start_up() {
    let mut rig = MasterRig::with(ScriptedSlave { address: 9, ..ScriptedSlave::new() });
    let connect = MasterRequest::Connect(Box::new(connection()));
    rig.master.request(rig.bus.now(), connect).expect("nothing else is under way");
    rig.run(Duration::from_millis(50));
    assert!(rig.master.request(rig.bus.now(), MasterRequest::Diagnosis { to: SLAVE }).is_err());
    assert_eq!(rig.ask(MasterRequest::Abort), MasterOutcome::Ended(SlaveReleaseOutcome::Aborted));
    assert!(!rig.master.is_busy());
}
