//! Time that a stand lets go by at once.

use super::bench::{Bench, CYCLE};
use station::{Duration, Stand, StandAction};
use wire::ethernet::Mac;
use wire::profinet::dcp::{Dcp, Value};

const MINUTE: Duration = Duration::from_secs(60);

fn skip(bench: &mut Bench, time: Duration) {
    assert_eq!(bench.device.act(bench.now, &StandAction::Skip(time)), Ok(bench.now), "it is done at once");
}

#[test]
fn a_connection_outlives_the_time_that_goes_by_for_the_encoder() {
    let mut bench = Bench::new();
    bench.start();
    skip(&mut bench, MINUTE);
    bench.take();
    bench.exchange(10);
    let inputs = Bench::inputs(&bench.take());
    assert_eq!(inputs.len(), 10, "no watchdog fires, and no cycle is made up for");
    let ahead = bench.device.application().clock.since(bench.now - CYCLE);
    assert!(ahead >= MINUTE && ahead <= MINUTE + CYCLE, "the encoder's clock is ahead by {ahead:?}");
    bench.release();
    skip(&mut bench, MINUTE);
    bench.start();
    let ahead = bench.device.application().clock.since(bench.now - CYCLE);
    assert!(ahead >= MINUTE * 2 && ahead <= MINUTE * 2 + CYCLE, "both jumps count: {ahead:?}");
}

#[test]
fn a_device_without_connection_jumps_as_a_whole() {
    let mut bench = Bench::new();
    let all = Dcp::identify(7, 1, [Value::AllSelector].into());
    bench.device.power(bench.now, false);
    bench.device.power(bench.now, true);
    skip(&mut bench, Duration::from_millis(1_970));
    assert!(bench.dcp(&all, Mac::DCP_MULTICAST).is_empty(), "it still boots");
    skip(&mut bench, Duration::from_millis(10));
    bench.run(Duration::ZERO);
    assert_eq!(bench.dcp(&all, Mac::DCP_MULTICAST).len(), 1, "the boot time has gone by");
}
