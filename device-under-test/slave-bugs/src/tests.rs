//! Bugs of the slave that no manual lists, because no suite case can distinguish them from other faults.

#[path = "../../device-stack/src/profibus/tests/bench.rs"]
#[allow(dead_code, reason = "the tests of the slave use the rest")]
pub mod bench;
#[path = "../../device-stack/src/profibus/tests/toy.rs"]
#[allow(dead_code, reason = "the tests of the slave use the rest")]
mod toy;

use self::bench::{ObservedAnswer, SlaveBench};
use self::toy::{CFG, PRM, ToySlaveApplication, bench};
use crate::seams::Deviations;
use crate::slave::GROUPS;
use core::time::Duration;
use device_stack::profibus::DpDevice;
use rstest::rstest;

/// A slave with this bug, in data exchange.
fn with(name: &str) -> SlaveBench<DpDevice<ToySlaveApplication>> {
    let mut deviations = Deviations::default();
    let bug = GROUPS.iter().flat_map(|group| group.deviations).find(|bug| bug.name == name).expect("the bug is known");
    (bug.attach)(&mut deviations);
    let mut bench = bench(deviations.attached().slave);
    bench.ask(Some((61, 62)), &PRM);
    bench.ask(Some((62, 62)), &CFG);
    bench.ask(None, &[1, 2]);
    bench
}

fn outputs(bench: &SlaveBench<DpDevice<ToySlaveApplication>>) -> Option<&[u8]> {
    bench.device.application().outputs.as_deref()
}

#[test]
fn bugs_of_the_data_link() {
    let mut repeating = with("repetition-carried-out");
    let given = repeating.device.application().inputs_given;
    repeating.repeat(None, &[1, 2]);
    assert_eq!(repeating.device.application().inputs_given, given + 1);

    let mut early = with("answers-too-early");
    early.diagnosis();
    assert!(early.delay < Duration::from_nanos(7_333), "11 bits at 1.5 Mbit/s");
    let mut late = with("answers-after-max-tsdr");
    late.diagnosis();
    assert!(late.delay > Duration::from_micros(100), "150 bits at 1.5 Mbit/s");
    assert_eq!(with("answers-too-late").ask(None, &[1, 2]), ObservedAnswer::Silence);
    assert_eq!(with("fdl-status-not-answered").send_frame(&[0x10, 5, 2, 0x49, 0x50, 0x16]), None);

    let mut any = with("answers-every-address");
    let fdl_status_of_9 = [0x10, 9, 2, 0x49, 0x54, 0x16];
    assert!(any.send_frame(&fdl_status_of_9).is_some());
}

#[rstest]
#[case::clear("global-control-ignored", 0x02, 0, &[1, 2])]
#[case::another_group("groups-ignored", 0x02, 2, &[])]
fn ignored_global_control_leaves_the_outputs(
    #[case] bug: &str,
    #[case] command: u8,
    #[case] groups: u8,
    #[case] left: &[u8],
) {
    let mut bench = with(bug);
    bench.control(command, groups);
    assert_eq!(outputs(&bench).unwrap_or_default(), left);
}

#[test]
fn clear_zeroes_inputs() {
    let mut bench = with("clear-zeroes-inputs");
    bench.control(0x02, 0);
    assert_eq!(bench.exchange(&[1, 2]), [0, 0]);
}

#[test]
fn records_are_not_cut() {
    let mut bench = with("records-not-cut");
    bench.ask(Some((51, 51)), &[0x5E, 1, 47, 1]);
    bench.wait(Duration::from_millis(5));
    assert_eq!(bench.ask(Some((51, 51)), &[]), ObservedAnswer::Data(8, [0x5E, 1, 47, 3, 1, 2, 3].into()));
}

#[test]
fn parameters_read_one_byte_too_early_are_refused() {
    assert_eq!(with("user-bytes-shifted").diagnosis()[0] & 0x40, 0x40);
}
