//! Tests in real time: devices at network interfaces, sockets and pseudoterminals, with the `encspec` binary, the controllers and
//! masters of the harness, and profirust.
//!
//! These tests mostly wait. All of them are in one binary, and many run at the same time, however few processors there are. The
//! longest ones start first.

mod against;
#[path = "../common/mod.rs"]
mod common;
mod explore;
mod hostile;
mod kills;
mod nic;
mod permanence;
mod profibus_line;
mod profirust;
mod serial;
mod serve;
mod variants;
mod vendor_records;

use libtest_mimic::{Arguments, Trial};
use std::process::ExitCode;
use testing::stall::retry_on_stall;

/// The number of tests that run at the same time.
const AT_ONCE: usize = 16;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(AT_ONCE);
    let trials = [
        kills::trials(),
        explore::trials(),
        hostile::trials(),
        against::trials(),
        serial::trials(),
        nic::trials(),
        serve::trials(),
        variants::trials(),
        permanence::trials(),
        vendor_records::trials(),
        profirust::trials(),
        profibus_line::trials(),
    ];
    libtest_mimic::run(&arguments, trials.into_iter().flatten().collect()).exit_code()
}

/// A test that is retried while the host stalls.
fn trial(name: String, test: impl Fn() + Send + Sync + 'static) -> Trial {
    Trial::test(name, move || {
        retry_on_stall(&test);
        Ok(())
    })
}

/// Turns functions into tests of the same name.
macro_rules! tests {
    ($($test:ident),* $(,)?) => {
        vec![$($crate::trial(concat!(module_path!(), "::", stringify!($test)).replacen("real_time::", "", 1), $test)),*]
    };
}

/// Turns a function into tests, one for each row with a name and arguments.
macro_rules! table {
    ($test:ident: $($row:ident($($given:expr),* $(,)?)),* $(,)?) => {
        vec![$($crate::trial(
            concat!(module_path!(), "::", stringify!($test), "::", stringify!($row)).replacen("real_time::", "", 1),
            || $test($($given),*),
        )),*]
    };
}

use {table, tests};
