//! The meaning of observations, rules and expectations in corner cases: at the borders of a block, for unknown values and for events;
//! and the failures of verbs that the built-in suites do not show. Each small suite here runs against the reference device.

use encspec::engine::{DutKind, DutSpec, RunOptions, TrialOutcome, run_trial};
use encspec::suite_yaml::load;
use encspec::verdict::Verdict::{self, Fail, Inconclusive, Pass};
use rstest::rstest;

const MANUAL: &str = "lika-xac77-profinet";
/// How long a trial of a minute of device time may take.
const LONGEST: std::time::Duration = std::time::Duration::from_secs(20);

/// Runs a case with these keys, together with these rules.
fn tried(case: &str, rules: &str) -> TrialOutcome {
    with_bugs(case, rules, &[])
}

fn with_bugs(case: &str, rules: &str, bugs: &[&str]) -> TrialOutcome {
    let topic = format!(
        "suite: tried\ndefaults: {{ start: {{ module: telegram_81 }} }}\ncases:\n  - id: tried\n    why: Tries a meaning.\n    \
         covers: [XAC77-PRK-001]\n{case}{rules}"
    );
    let sources = suites::sources().with(&format!("{MANUAL}/tried.yaml"), topic);
    let manuals = load(&sources, Some(MANUAL)).unwrap_or_else(|errors| panic!("the suite loads:\n{errors}"));
    let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
    let trial = variant.trials.iter().find(|trial| trial.id.ends_with("tried/tried")).expect("the trial is there");
    let kind = DutKind::Model { deviations: bugs.iter().map(|bug| (*bug).to_owned()).collect() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run")
}

/// Runs a case that consists of one block with these observations and steps.
fn block(observe: &[&str], steps: &[&str]) -> TrialOutcome {
    let lines = |list: &[&str]| list.iter().map(|line| format!("          - {line}\n")).collect::<String>();
    let given = "    given:\n      - do: preset\n        give: { preset_value: 0x1234 }\n";
    let alive = "      - read: { station.vendor_id: 0x0239 }\n";
    let (observe, steps) = (lines(observe), lines(steps));
    tried(&format!("{given}    steps:\n{alive}      - observe:\n{observe}        steps:\n{steps}"), "")
}

const PARK: &str = "set: { G1_STW.park: 1 }";
const CONNECT: &str = "connect: {}";
const PARKED: &str = "{ when: rises(G1_STW.park), then: G1_ZSW.parked, within: 100ms, for: 1s }";
const ALARM: &str = "set: { fault.memory: present }";

#[rstest]
#[case::a_change_in_the_first_frame(&["{ count: rises(G1_STW.park), is: 1 }"], &[PARK], Pass)]
#[case::a_premise_in_the_first_frame(&[PARKED], &[PARK], Pass)]
#[case::frames_after_the_last_step_are_not_counted(
    &[PARKED, "{ count: changes(ZSW2_ENC.sign_of_life), is: { to: 20 } }"], &[PARK, "wait: 10 cycles"], Pass)]
#[case::positions_are_compared_as_positions(
    &["{ sequence: [G1_STW.park, G1_XIST1], is: [[0, 0x1234], [1, 0x1234], [1, 0]] }"], &["wait: 10 cycles", PARK, "wait: 10 cycles"], Pass)]
#[case::other_positions_are_not_equal(
    &["{ sequence: [G1_STW.park, G1_XIST1], is: [[0, 0x1235], [1, 0x1235], [1, 0]] }"], &["wait: 10 cycles", PARK, "wait: 10 cycles"], Fail)]
#[case::an_uncertain_count(&["{ count: G1_ZSW.sensor_error, is: 0 }"], &[CONNECT], Inconclusive)]
#[case::a_count_that_holds_in_any_case(&["{ count: G1_ZSW.sensor_error, is: { from: 0 } }"], &[CONNECT], Pass)]
#[case::a_count_that_fails_in_any_case(
    &["{ count: not G1_ZSW.sensor_error, is: 3 }"], &["wait: 10 cycles", CONNECT], Fail)]
#[case::a_sequence_with_a_gap(&["{ sequence: [G1_ZSW.parked], is: [[0], [1]] }"], &[CONNECT], Inconclusive)]
#[case::a_sequence_that_fails_before_the_gap(&["{ sequence: [G1_ZSW.parked], is: [[1], [0]] }"], &[CONNECT], Fail)]
#[case::a_failure_outweighs_an_uncertain_count(
    &["{ count: G1_ZSW.sensor_error, is: 0 }", "always: G1_ZSW.parked"], &[CONNECT], Fail)]
#[case::a_count_of_aborts_expects_no_alarm(&["{ count: abort, is: 0 }"], &[ALARM, "wait: 200ms"], Fail)]
#[case::a_count_of_alarms_does(&["{ count: alarm, is: 1 }"], &[ALARM, "wait: 200ms"], Pass)]
#[case::a_rule_about_alarms_does(
    &["{ when: alarm, then: alarm.error == memory, within: 0 }"], &[ALARM, "wait: 200ms"], Pass)]
#[case::a_rule_that_requires_an_alarm_does(
    &["{ when: rises(G1_STW.request_absolute_value), then: alarm, within: 1s }"], &["set: { G1_STW.request_absolute_value: 1 }", ALARM, "wait: 200ms"], Pass)]
fn a_block(#[case] observe: &[&str], #[case] steps: &[&str], #[case] verdict: Verdict) {
    let outcome = block(observe, steps);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

/// The sensor is parked in the middle of the block, so the frame to look at has the second byte of G1_ZSW bit 14 set (encoder
/// profile 3.162, 6.3.2), and the last frames have not.
#[rstest]
#[case::a_rule("always: { G1_ZSW.parked: 0 }")]
#[case::a_count("{ count: rises(G1_ZSW.parked), is: 0 }")]
#[case::a_sequence("{ sequence: [G1_ZSW.parked, G1_ZSW.sensor_error], is: [[0, 0], [1, 1]] }")]
fn the_frame_that_breaks_a_block_is_named(#[case] observe: &str) {
    let steps = ["wait: 10 cycles", PARK, "wait: 20 cycles", "set: { G1_STW.park: 0 }", "wait: 1s"];
    let outcome = block(&[observe], &steps);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
    let failure = outcome.case.failures.first().expect("the reason");
    let place = failure.place.as_ref().expect("the frame");
    assert!(place.octet.is_some(), "{place:?}");
    let marked = failure.trace.iter().find(|line| line.starts_with('>')).expect("the frame among those shown");
    assert!(marked.contains(&format!("{} ", place.frame)), "{marked}");
    let data = marked.split(" cycle ").nth(1).and_then(|data| data.split(' ').nth(3)).expect("the data");
    let octet = u8::from_str_radix(data, 16).expect("a byte");
    assert_eq!(octet & 0x40, 0x40, "{marked}");
}

#[test]
fn a_count_without_frames_is_inconclusive() {
    let outcome = tried(
        "    start: none\n    steps:\n      - observe: [ { count: G1_ZSW.sensor_error, is: 0 } ]\n        steps:\n          \
         - read: { station.vendor_id: 0x0239 }\n",
        "",
    );
    assert_eq!(outcome.case.verdict, Inconclusive, "{:?}", outcome.case.reason);
}

#[test]
fn a_deadline_in_cycles_without_a_connection_is_not_the_next_sample() {
    let outcome = tried(
        "    start: none\n    steps:\n      - read: { station.vendor_id: 0x0239 }\n      - expect: { connection: none }\n        \
         within: 5 cycles\n",
        "",
    );
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[test]
fn a_premise_that_stays_true_is_counted_at_every_frame() {
    let rules = "rules:\n  - id: level\n    why: A premise that stays true.\n    covers: [XAC77-PRK-001]\n    \
                 when: not G1_ZSW.parked\n    then: not G1_ZSW.parked\n    within: 0\n    until: G1_ZSW.parked\n";
    let case = "    given:\n      - set: { STW2_ENC.control_by_plc: 1 }\n    steps:\n      - wait: 60s\n      - set: { G1_STW.park: 1 }\n      - expect: { G1_ZSW.parked: 1 }\n";
    let began = std::time::Instant::now();
    let outcome = tried(case, rules);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let decided = outcome.rules.iter().map(|rule| rule.decided).max_by_key(|decided| decided.premises);
    let decided = decided.expect("there are rules");
    assert!((29_500..31_000).contains(&decided.premises), "{decided:?}: one for each frame of a minute at 4 ms");
    assert!(began.elapsed() < LONGEST, "it took {:?}", began.elapsed());
}

/// Runs a case with these keys and these steps.
fn steps(keys: &str, steps: &[&str]) -> TrialOutcome {
    let lines: String = steps.iter().map(|line| format!("      - {line}\n")).collect();
    tried(&format!("{keys}    steps:\n{lines}"), "")
}

const NONE: &str = "    start: none\n";
const ALIVE: &str = "read: { station.vendor_id: 0x0239 }";
const RESET: &str = "send: { dcp_reset: { mode: factory } }";
const CONNECTED: &str = "connect: { module: telegram_81 }";

/// A start-up with a changed part is refused, and the correct start-up works afterwards.
#[rstest]
#[case::rt_class("{ rt_class: 3 }", "{ connect: { refused: any } }")]
#[case::slot("{ slot: 0 }", "[ { connect: { refused: any } }, { module_diff.telegram_81: { in: [missing, wrong] } } ]")]
#[case::other_slot(
    "{ slot: 7 }",
    "[ { connect: { refused: any } }, { module_diff.telegram_81: { in: [missing, wrong] } } ]"
)]
#[case::dap_ident("{ dap_ident: 0x7777 }", "[ { connect: { refused: any } }, { module_diff.dap: wrong } ]")]
fn a_changed_start_up_is_refused(#[case] instead: &str, #[case] answer: &str) {
    let wrong = format!("{{ connect: {{ module: telegram_81, instead: {instead} }}, answer: {answer} }}");
    let outcome = steps(NONE, &[&wrong, CONNECTED, "expect: { G1_ZSW.sensor_error: 0 }"]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let accepted = "{ connect: accepted, module_diff.telegram_81: proper, module_diff.dap: proper }";
    let wrong = format!("{{ connect: {{ module: telegram_81, instead: {instead} }}, answer: {accepted} }}");
    let outcome = steps(NONE, &[&wrong]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[test]
fn a_supported_rt_class_is_accepted() {
    let outcome =
        steps(NONE, &["{ connect: { module: telegram_81, instead: { rt_class: 1 } }, answer: { connection: data } }"]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
}

/// A start-up without setting the address reaches the device at its own address. A device without an address does not answer, and the
/// normal start-up sets one.
#[test]
fn a_start_up_that_gives_no_address() {
    let own = "write: { station.ip: 192.168.0.77, station.mask: 255.255.255.0, station.gateway: 0.0.0.0 }";
    let none = "connect: { module: telegram_81, instead: { ip: none } }";
    let keeps = "read: { station.ip: 192.168.0.77 }";
    let outcome = steps(NONE, &[own, none, keeps]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let blank = "{ read: { station.ip: 0.0.0.0 }, within: =timing.power_up }";
    let silent =
        "{ connect: { module: telegram_81, instead: { ip: none } }, answer: { connect: none, connection: none } }";
    let outcome = steps(NONE, &[RESET, blank, silent, blank, CONNECTED, "expect: { G1_ZSW.sensor_error: 0 }"]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let outcome = steps(NONE, &[RESET, blank, none]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[rstest]
#[case("{ subslot: 2 }")]
#[case("{ slot: 0 }")]
#[case("{ slot: 9 }")]
#[case("{ api: 5 }")]
fn parameters_at_another_slot_are_refused(#[case] instead: &str) {
    let refused = format!("{{ read: {{ P922: {{ refused: any }} }}, instead: {instead} }}");
    let outcome = steps("", &[&refused, "read: { P922: 81 }"]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let outcome = steps("", &[&format!("{{ read: {{ P922: 81 }}, instead: {instead} }}")]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[test]
fn requests_to_another_station_are_ignored() {
    let other = "{ write: { station.name: 'enc-9' }, instead: { destination: \"02 00 00 00 00 99\" }, answer: none }";
    let kept = "read: { station.name: 'enc-1' }";
    let outcome = steps(NONE, &["write: { station.name: 'enc-1' }", other, kept]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let accepted = other.replace(", answer: none", "");
    let outcome = steps(NONE, &[&accepted, ALIVE]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[test]
fn the_mac_address_is_the_one_that_answers() {
    let read = "read: { station.mac: \".. .. .. .. .. ..\", station.vendor_id: 0x0239 }";
    let again = "{ read: { station.mac: =before }, within: =timing.power_up }";
    let outcome = steps(NONE, &[read, "save: { before: station.mac }", "do: power_cycle", again]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let outcome = steps(NONE, &["read: { station.mac: \"02 00 00 00 00 01\" }"]);
    assert_eq!(outcome.case.verdict, Fail, "the one of the controller: {:?}", outcome.case.reason);
}

/// An LLDP announcement is one event with its parts, with and without a connection. Other contents do not match.
#[rstest]
#[case("", "{ lldp: 1, lldp.name: 'encoder-under-test', lldp.port: 'port-001' }", Pass)]
#[case(NONE, "{ lldp: 1, lldp.name: 'encoder-under-test', lldp.port: 'port-001' }", Pass)]
#[case(NONE, "lldp.mac == mac and lldp.chassis != mac", Pass)]
#[case(NONE, "lldp.chassis == mac", Fail)]
#[case(NONE, "{ lldp.name: 'encoder-under-tes' }", Fail)]
#[case(NONE, "{ lldp.port: 'port-002' }", Fail)]
#[case("", "{ lldp.mac: \"02 00 00 00 00 01\" }", Fail)]
fn parts_of_an_lldp_announcement(#[case] keys: &str, #[case] expected: &str, #[case] verdict: Verdict) {
    let mac = "read: { station.mac: any }";
    let expect = format!("{{ expect: {expected}, within: 12s }}");
    let outcome = steps(keys, &[mac, "save: { mac: station.mac }", &expect]);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

#[test]
fn announcements_of_the_controller_do_not_match() {
    let own = "send: { lldp: { chassis: 'controller-1', port: 'port-001' } }";
    let outcome = steps(NONE, &[ALIVE, own, "{ expect: { lldp: 1, lldp.name: 'controller-1' }, within: 12s }"]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

/// The second controller reads without a connection, and the connection of the first controller continues.
#[test]
fn a_second_controller_reads_without_a_connection() {
    let identity = "{ send: { record_read: { slot: 0, subslot: 1, index: 0xAFF0, length: 64 } }, as: second }";
    let bytes = "expect: { answer.bytes: \"00 20 00 38 01 00 02 39 *\" }";
    let outcome = steps("", &[identity, bytes, "{ expect: not G1_ZSW.sensor_error, for: 50ms }"]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let missing = identity.replace("0xAFF0", "0x1234");
    let outcome = steps("", &[&missing]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
    let outcome = steps(NONE, &[identity]);
    assert_eq!(outcome.case.verdict, Fail, "it has no address yet: {:?}", outcome.case.reason);
}

/// Nothing was sent, so neither `answer: any` nor `answer: none` holds.
#[rstest]
#[case("{ send: { record_read: { slot: 0, subslot: 1, index: 0xAFF0, length: 64 } }, answer: any }")]
#[case("{ send: { record_write: { slot: 1, subslot: 1, index: 0xBF00, bytes: \"00\" } }, answer: none }")]
#[case("{ write: { P65000: 1 }, answer: none }")]
#[case("{ write: { P65000: 1 }, as: second, answer: none }")]
#[case("read: { P922: { refused: any } }")]
fn a_request_that_cannot_be_sent_fails(#[case] step: &str) {
    let outcome = steps(NONE, &[ALIVE, step]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[test]
fn a_device_in_factory_state_has_no_name_no_address_and_nothing_stored() {
    let given = ["write: { P65000: 77 }", "do: save_parameters", "read: { P65000: 77 }", "connect: none"];
    let deliver = "set: { device: as_delivered }";
    let blank = "{ read: { station.name: '', station.ip: 0.0.0.0 }, within: =timing.power_up }";
    let then = [deliver, blank, CONNECTED, "read: { P65000: 0 }"];
    let outcome = steps("", &[&given[..], &then[..]].concat());
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let kept = ["{ read: { station.name: 'encoder-under-test' } }"];
    let outcome = steps("", &[&given[..], &[deliver], &kept[..]].concat());
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[rstest]
#[case(&[CONNECTED, "send: { arp: {} }", "send: { arp_probe: {} }"], Pass)]
#[case(&[CONNECTED, "send: { arp_probe: { ip: 192.168.0.10 } }"], Pass)]
#[case(&[CONNECTED, "{ send: { arp_probe: { ip: 192.168.0.99 } }, answer: none }"], Pass)]
#[case(&[CONNECTED, "send: { arp: { ip: 192.168.0.99 } }"], Fail)]
#[case(&[CONNECTED, "{ send: { arp: {} }, answer: none }"], Fail)]
// The controller's own address is the controller's.
#[case(&[CONNECTED, "send: { arp: { ip: 192.168.0.2 } }"], Fail)]
fn only_the_owner_of_an_address_answers_arp(#[case] list: &[&str], #[case] verdict: Verdict) {
    let outcome = steps(NONE, list);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

/// The address of the device and a free address of the bench: 192.168.0.10 and .200 on the virtual segment.
#[rstest]
#[case(&[CONNECTED, "read: { station.ip: =bench.ip, station.mask: =bench.mask }", "read: { P61001: = number(bench.ip) }"], Pass)]
#[case(&[CONNECTED, "read: { station.ip: 192.168.0.10, station.mask: 255.255.255.0 }", "read: { P61001: 0xC0A8000A }"], Pass)]
#[case(&[CONNECTED, "read: { station.ip: =bench.free_ip }"], Fail)]
#[case(&[CONNECTED, "read: { P61001: = number(bench.free_ip) }"], Fail)]
#[case(&[CONNECTED, "{ send: { arp_probe: { ip: =bench.free_ip } }, answer: none }", "send: { arp: { ip: =bench.ip } }"], Pass)]
#[case(&[CONNECTED, "send: { arp_probe: { ip: =bench.free_ip } }"], Fail)]
#[case(&["write: { station.ip: =bench.free_ip }", "read: { station.ip: 192.168.0.200 }", CONNECTED, "read: { station.ip: =bench.ip }"], Pass)]
fn the_addresses_of_the_bench(#[case] list: &[&str], #[case] verdict: Verdict) {
    let outcome = steps(NONE, list);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

#[test]
fn a_station_is_found_by_its_neighbour() {
    let neighbour = "send: { lldp: { chassis: 'switch-1', port: 'port-003' } }";
    let found = "send: { dcp_identify: { alias: 'port-003.switch-1' } }";
    let outcome = steps(NONE, &[neighbour, found]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let outcome = steps(NONE, &[neighbour, &found.replace("003", "004")]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

/// Acknowledgement held back: the device repeats its alarm, which counts once, and aborts. Given in time: the connection continues.
#[rstest]
#[case::held(&["set: { io.alarm_acknowledge: held, fault.memory: present }", "expect: alarm", "{ expect: abort, within: 5s }"], Pass)]
#[case::received(&["set: { io.alarm_acknowledge: received, fault.memory: present }", "expect: alarm", "{ expect: connection == data, for: 2s }"], Pass)]
#[case::given_in_time(
    &["set: { io.alarm_acknowledge: held, fault.memory: present }", "expect: alarm", "set: { io.alarm_acknowledge: given }",
      "{ expect: connection == data, for: 2s }"], Pass)]
#[case::held_is_no_connection(
    &["set: { io.alarm_acknowledge: held, fault.memory: present }", "expect: alarm", "{ expect: connection == data, for: 5s }"], Fail)]
fn unacknowledged_alarms(#[case] list: &[&str], #[case] verdict: Verdict) {
    let outcome = steps("", list);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

/// A diagnosis is an alarm of low priority (IEC 61158-6-10), its item the channel, the properties and the error type: 9000h in the manual.
#[rstest]
#[case::as_it_is(r#"{ alarm.type: diagnosis, alarm.priority: low, alarm.payload: "80 00 .. .. 90 00" }"#, Pass)]
#[case::another_type("{ alarm.type: process }", Fail)]
#[case::another_priority("{ alarm.priority: high }", Fail)]
#[case::another_payload(r#"{ alarm.payload: "80 00 .. .. 90 11" }"#, Fail)]
fn type_priority_and_payload_of_an_alarm(#[case] expected: &str, #[case] verdict: Verdict) {
    let outcome = steps("", &["set: { fault.memory: present }", &format!("expect: {expected}")]);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

/// An expectation that already held is an error of the suite, but a failure if the device deviates.
#[test]
fn an_idle_expectation_is_no_error_where_the_device_deviates() {
    let case = "    steps:\n      - set: { STW2_ENC.control_by_plc: 1, fault.memory: present }\n      \
                - expect: { alarm: 1, G1_ZSW.sensor_error: 1 }\n        within: 2s\n      - wait: 10 cycles\n      \
                - set: { G1_STW.acknowledge_error: 1 }\n      - expect: { G1_ZSW.acknowledge_in_process: 1 }\n";
    let conforming = tried(case, "");
    assert_eq!(conforming.case.verdict, Pass, "{:?}", conforming.case.reason);
    let early = with_bugs(case, "", &["acknowledge-answer-without-request"]);
    assert_eq!(early.case.verdict, Fail, "{:?}", early.case.reason);
    let idle = tried(&case.replace("acknowledge_in_process: 1", "sensor_error: 1"), "");
    assert_eq!(idle.case.verdict, Verdict::Error, "{:?}", idle.case.reason);
}

/// Requests to the web server of a device that lost its address go to its last address.
#[test]
fn a_web_server_without_an_address_is_requested_at_the_last_address() {
    let moved = "write: { station.ip: 192.168.0.77, station.mask: 255.255.255.0, station.gateway: 0.0.0.0 }";
    let blank = "write: { station.ip: 0.0.0.0, station.mask: 0.0.0.0, station.gateway: 0.0.0.0 }";
    let gone = "{ send: { http_get: { page: home } }, answer: none }";
    let outcome = steps(NONE, &[moved, "read: { station.ip: 192.168.0.77 }", blank, gone]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let arp_requests = |number: usize| {
        let octets = outcome.trace.get(number)?.octets;
        let is_request = octets.get(12..14)? == [8, 6] && octets.get(20..22)? == [0, 1];
        (is_request && octets.get(38..42)? == [192, 168, 0, 77]).then_some(number)
    };
    assert!((1..=outcome.trace.len()).find_map(arp_requests).is_some(), "no ARP request for the last address");
}

/// An address that the device refuses is not used to reach it.
#[test]
fn a_refused_address_is_not_used() {
    let bad = "{ write: { station.ip: 224.0.0.1, station.mask: 255.255.255.0, station.gateway: 0.0.0.0 }, \
               answer: { refused: any } }";
    let outcome = steps("", &[bad, "{ send: { http_get: { page: home } }, answer: { status: 200 } }"]);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
}

/// `lacks` does not hold for an error page.
#[test]
fn lacks_does_not_hold_for_an_error_page() {
    let case = "    steps:\n      - send: { http_get: { page: position } }\n        answer: { lacks: \"kohlrabi\" }\n";
    let conforming = tried(case, "");
    assert_eq!(conforming.case.verdict, Pass, "{:?}", conforming.case.reason);
    let refused = with_bugs(case, "", &["password-for-every-page"]);
    assert_eq!(refused.case.verdict, Fail, "{:?}", refused.case.reason);
}

/// A common suite runs with the parameters, rows and requirements of the manual, beside the manual's own cases.
#[test]
fn a_common_case_runs_with_the_rows_of_the_manual() {
    let common = "common: tried\nwhy: Tries.\ntakes:\n  parked: { is: name, why: the bit }\n  \
                  checked: { is: requirements, why: those of the second check }\ncases:\n  - id: rows\n    why: Rows.\n    \
                  catches: [parking-ignored]\n    with: { bit: { is: number, why: what is asked }, seen: { is: number, why: what is seen } }\n    \
                  steps:\n      - set: { G1_STW.park: =bit }\n      - expect: { =parked: =seen }\n      \
                  - read: { P922: =seen }\n        covers: =checked\n";
    let uses = "suite: tried\nuse: tried\ndefaults: { start: { module: telegram_81 }, given: [ { set: { STW2_ENC.control_by_plc: 1 } } ] }\n\
                give: { parked: G1_ZSW.parked, checked: [XAC77-PAR-001] }\nomit: {}\nrows:\n  rows:\n    \
                - { row: right, bit: 1, seen: 1, covers: [XAC77-PRK-001] }\n    \
                - { row: wrong, bit: 0, seen: 1, covers: [XAC77-PRK-001] }\ncases:\n  - id: own\n    why: Own.\n    \
                covers: [XAC77-PRK-001]\n    steps: [ { read: { P922: 81 } } ]\n";
    let sources = suites::sources().with("common/tried.yaml", common).with(&format!("{MANUAL}/tried.yaml"), uses);
    let manuals = load(&sources, Some(MANUAL)).unwrap_or_else(|errors| panic!("the suite loads:\n{errors}"));
    let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let verdicts: Vec<(String, Verdict, Vec<Verdict>)> = variant
        .trials
        .iter()
        .filter(|trial| trial.id.starts_with("tried/"))
        .map(|trial| {
            let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
            let covers = outcome.case.covers.iter().map(|of| of.verdict).collect();
            (trial.id.clone(), outcome.case.verdict, covers)
        })
        .collect();
    // The second check fails for its own requirement, and the first for that of the row.
    let expected = [
        ("tried/rows[right]", Fail, vec![Pass, Fail]),
        ("tried/rows[wrong]", Fail, vec![Fail, Verdict::NotRun]),
        ("tried/own", Pass, vec![Pass]),
    ];
    let expected: Vec<(String, Verdict, Vec<Verdict>)> =
        expected.into_iter().map(|(id, of, covers)| (id.to_owned(), of, covers)).collect();
    assert_eq!(verdicts, expected);
}

/// A reading with a finding fails the step with its text; the correct reading does not.
#[test]
fn a_reading_with_a_finding_fails() {
    let either = |right: u32, fault: u32| {
        format!(
            "{{ either: {{ right: [ {{ read: {{ P922: {right} }} }} ], printed: [ {{ read: {{ P922: {fault} }} }} ] }}, \
             finding: {{ printed: It is as printed. }} }}"
        )
    };
    let conforming = steps("", &[&either(81, 82)]);
    assert_eq!((conforming.case.verdict, conforming.findings.len()), (Pass, 0), "{:?}", conforming.case.reason);
    let found = steps("", &[&either(82, 81)]);
    assert_eq!((found.case.verdict, found.case.reason.as_deref()), (Fail, Some("It is as printed.")));
    let findings: Vec<(&str, &str)> = found.findings.iter().map(|of| (of.id.as_str(), of.text.as_str())).collect();
    assert_eq!(findings, [("tried/tried:printed", "It is as printed.")]);
    let neither = steps("", &[&either(82, 83)]);
    assert_eq!((neither.case.verdict, neither.findings.len()), (Fail, 0), "{:?}", neither.case.reason);
}

#[rstest]
#[case::exactly_these("{ G1_ZSW: [parked] }", Pass)]
#[case::one_more("{ G1_ZSW: [parked, sensor_error] }", Fail)]
#[case::one_of_several("{ G1_ZSW: { in: [[sensor_error], [parked]] } }", Pass)]
#[case::anything_else("{ G1_ZSW: { not: [parked] } }", Fail)]
fn bits_by_name_are_the_whole_word(#[case] expected: &str, #[case] verdict: Verdict) {
    let outcome = block(&[PARKED], &[PARK, &format!("{{ expect: {expected}, for: 1s }}")]);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

#[test]
fn a_failure_names_the_fields_of_octets() {
    let steps =
        format!("    steps:\n      - {PARK}\n      - expect: {{ io.inputs: \"ZSW2_ENC: .. .. G1_ZSW: 80 00 *\" }}\n");
    let failure = format!("{:?}", tried(&steps, "").case.failures);
    assert!(failure.contains("G1_ZSW: 80 00 *") && failure.contains("G1_ZSW: 00 00 rest: "), "{failure}");
}

/// What comes after a damaged frame on PROFIBUS: a slave ignores a wrong checksum, and refuses an access point that it does not have
/// (IEC 61158-4-3, RS).
#[rstest]
#[case("checksum", "none", Pass)]
#[case("checksum", "accepted", Fail)]
#[case("noise", "any", Fail)]
#[case("unknown_access_point", "{ refused: any }", Pass)]
#[case("unknown_access_point", "none", Fail)]
#[case("unknown_access_point", "accepted", Fail)]
fn what_comes_after_a_damaged_frame_is_judged(#[case] damage: &str, #[case] answer: &str, #[case] verdict: Verdict) {
    const SLAVE: &str = "datalogic-amt58-profibus";
    let topic = format!(
        "suite: tried\ndefaults: {{ start: none }}\ncases:\n  - id: tried\n    why: Tries a damaged frame.\n    \
         covers: [AMT58-DXC-014]\n    steps:\n      - send: {{ broken: {{ frame: {damage} }} }}\n        answer: {answer}\n      \
         - read: {{ diag.ident: 0x1655 }}\n"
    );
    let sources = suites::sources().with(&format!("{SLAVE}/tried.yaml"), topic);
    let manuals = load(&sources, Some(SLAVE)).unwrap_or_else(|errors| panic!("the suite loads:\n{errors}"));
    let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
    let trial = variant.trials.iter().find(|trial| trial.id.ends_with("tried/tried")).expect("the trial is there");
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}
