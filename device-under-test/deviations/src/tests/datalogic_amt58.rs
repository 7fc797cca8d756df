//! The AMT58 with each of its bugs, through its slave.

#[path = "../../../reference-devices/src/models/datalogic_amt58/tests/bench.rs"]
mod bench;
#[path = "../../../device-stack/src/profibus/tests/bench.rs"]
#[allow(dead_code, reason = "the tests of the slave use the rest")]
mod slave;

use self::bench::{HM, HS, act, bench_with, parameters};
use crate::subject;
use core::time::Duration;
use station::StandAction;

/// A device with any of its bugs can be started and stopped without a panic.
#[test]
fn bugs_do_not_panic() {
    let subject = subject("datalogic-amt58-profibus").expect("the manual has a reference device");
    for bug in subject.bugs() {
        let deviations = subject.attached(&[bug.name]).expect("the bug is listed");
        for variant in [HS, HM] {
            let mut bench = bench_with(variant, 0x1234, Some(&deviations));
            for operating in [0x00, 0x4A, 0xCB] {
                for (units, range) in [(262_144, 1 << 30), (50_000, 50_000), (0, 0), (8192, 360), (u32::MAX, u32::MAX)]
                {
                    bench.ask(Some((61, 62)), &parameters(operating, units, range, 2));
                    bench.ask(Some((60, 62)), &[]);
                    for cfg in [[0xD1, 0xE1], [0xD3, 0xE1]] {
                        bench.ask(Some((62, 62)), &cfg);
                    }
                    act(&mut bench, StandAction::TurnRevolutions { revolutions: -2.5, rpm: 60.0 });
                    for outputs in [[0x80, 0, 0x10, 0], [0x80, 0, 0x10, 0], [0x80, 0, 0x10, 0], [0, 0, 0, 0x80]] {
                        bench.ask(None, &outputs);
                    }
                    bench.ask(None, &[1]);
                    bench.ask(Some((60, 62)), &[]);
                }
            }
            act(&mut bench, StandAction::Power(false));
            act(&mut bench, StandAction::Power(true));
            bench.wait(Duration::from_secs(20));
            bench.ask(Some((60, 62)), &[]);
        }
    }
}
