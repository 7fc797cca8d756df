//! Tests that cannot look at anything here say so.

use std::env;
use std::io::{self, Write as _};
use std::thread;

/// Says on the terminal, past the test runner's capture of output, that the current test looks at nothing.
pub fn skip(why: &str) {
    let thread = thread::current();
    let test = thread.name().unwrap_or("a test");
    // In one piece, as tests run side by side. A standard error that cannot be written to leaves nobody to tell.
    let _ = io::stderr().write_all(format!("skipped: {test}: {why}\n").as_bytes());
}

/// Whether this machine grants what a test needs; where it does not the test is skipped, which is said.
///
/// # Panics
///
/// If `ENCSPEC_REQUIRE_ALL` is set and it does not.
pub fn available(granted: Result<(), String>) -> bool {
    if let Err(why) = &granted {
        assert!(env::var_os("ENCSPEC_REQUIRE_ALL").is_none(), "{why}");
        skip(why);
    }
    granted.is_ok()
}
