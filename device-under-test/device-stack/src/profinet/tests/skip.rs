//! Time that a stand skips.

use super::bench::{CYCLE, StackBench};
use station::{Duration, Stand, StandAction};
use wire::ethernet::Mac;
use wire::profinet::dcp::{Dcp, DcpValue};

const MINUTE: Duration = Duration::from_secs(60);

fn skip(bench: &mut StackBench, time: Duration) {
    assert_eq!(bench.device.act(bench.now, &StandAction::Skip(time)), Ok(bench.now), "skipping takes no time");
}

#[test]
fn a_connection_survives_skipped_time() {
    let mut bench = StackBench::new();
    bench.start();
    skip(&mut bench, MINUTE);
    bench.take();
    bench.exchange(10);
    let inputs = StackBench::inputs(&bench.take());
    assert_eq!(inputs.len(), 10, "no watchdog expires, and no missed cycle is sent");
    let ahead = bench.device.application().clock.since(bench.now - CYCLE);
    assert!(ahead >= MINUTE && ahead <= MINUTE + CYCLE, "the clock of the application is ahead by {ahead:?}");
    bench.release();
    skip(&mut bench, MINUTE);
    bench.start();
    let ahead = bench.device.application().clock.since(bench.now - CYCLE);
    assert!(ahead >= MINUTE * 2 && ahead <= MINUTE * 2 + CYCLE, "both jumps add up: {ahead:?}");
}

#[test]
fn without_a_connection_the_clock_of_the_whole_device_jumps() {
    let mut bench = StackBench::new();
    let all = Dcp::identify(7, 1, [DcpValue::AllSelector].into());
    bench.device.power(bench.now, false);
    bench.device.power(bench.now, true);
    skip(&mut bench, Duration::from_millis(1_970));
    assert!(bench.dcp(&all, Mac::DCP_MULTICAST).is_empty(), "the device is still booting");
    skip(&mut bench, Duration::from_millis(10));
    bench.run(Duration::ZERO);
    assert_eq!(bench.dcp(&all, Mac::DCP_MULTICAST).len(), 1, "the boot time has elapsed");
}
