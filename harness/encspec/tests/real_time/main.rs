//! Everything that meets a device in real time: over network interfaces, sockets and pseudoterminals, `encspec` as a user calls it,
//! controllers and masters of ours and of strangers.
//!
//! These tests mostly wait for the clock. So all of them are in one binary, and many of them run at once, however few processors
//! there are. What takes longest comes first.

mod against;
#[path = "../common/mod.rs"]
mod common;
mod line;
mod nic;
mod profirust;
mod serial;
mod serve;

use libtest_mimic::{Arguments, Trial};
use std::process::ExitCode;
use testing::patience::patiently;

/// So many tests wait at the same time.
const AT_ONCE: usize = 16;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(AT_ONCE);
    let trials =
        [against::trials(), serial::trials(), nic::trials(), serve::trials(), profirust::trials(), line::trials()];
    libtest_mimic::run(&arguments, trials.into_iter().flatten().collect()).exit_code()
}

/// A test that a halt of this machine does not spoil.
fn trial(name: String, test: impl Fn() + Send + Sync + 'static) -> Trial {
    Trial::test(name, move || {
        patiently(&test);
        Ok(())
    })
}

/// Functions as tests that have their names.
macro_rules! tests {
    ($($test:ident),* $(,)?) => {
        vec![$($crate::trial(concat!(module_path!(), "::", stringify!($test)).replacen("real_time::", "", 1), $test)),*]
    };
}

/// A function as tests, one for each row: the name of the row and what the function is given.
macro_rules! table {
    ($test:ident: $($row:ident($($given:expr),* $(,)?)),* $(,)?) => {
        vec![$($crate::trial(
            concat!(module_path!(), "::", stringify!($test), "::", stringify!($row)).replacen("real_time::", "", 1),
            || $test($($given),*),
        )),*]
    };
}

use {table, tests};
