//! Skipped tests are reported as skipped.

use std::env;
use std::io::{self, Write as _};
use std::thread;

/// Reports on standard error, past the output capture of the test runner, that the current test is skipped.
pub fn skip(why: &str) {
    let thread = thread::current();
    let test = thread.name().unwrap_or("a test");
    // In one write, since tests run in parallel. If standard error cannot be written there is no one left to report to.
    let _ = io::stderr().write_all(format!("skipped: {test}: {why}\n").as_bytes());
}

/// Whether the host grants what a test needs. If not, the test is reported as skipped.
///
/// # Panics
///
/// If the host does not grant it and `ENCSPEC_REQUIRE_ALL` is set.
pub fn available(granted: Result<(), String>) -> bool {
    if let Err(why) = &granted {
        assert!(env::var_os("ENCSPEC_REQUIRE_ALL").is_none(), "{why}");
        skip(why);
    }
    granted.is_ok()
}
