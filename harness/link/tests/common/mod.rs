//! What the tests of this room share.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::env;
use std::io::{self, Write as _};

use encspec_link::{Clock, Port, namespace};
use station::{Duration, Time};

/// Whether this thread is now in a network of its own, with the interfaces `left` and `right` connected to each other.
///
/// Where that cannot be had the reason is written past the test runner's capture, and nothing is to be tested;
/// with `ENCSPEC_REQUIRE_ALL` it is a failure.
pub fn two_ends() -> bool {
    match namespace::enter_private_network().and_then(|()| namespace::veth("left", "right")) {
        Ok(()) => true,
        Err(why) => {
            assert!(env::var_os("ENCSPEC_REQUIRE_ALL").is_none(), "{why}");
            // A standard error that cannot be written to leaves nobody to tell.
            let _ = io::stderr().write_all(format!("skipped: {why}\n").as_bytes());
            false
        }
    }
}

/// Long enough for anything that happens at all.
pub const LONG: Duration = Duration::from_secs(5);
/// Long enough for what must not happen.
pub const A_WHILE: Duration = Duration::from_millis(30);

/// The next frame, which has to come.
#[track_caller]
pub fn next(port: &mut dyn Port, clock: &Clock) -> (Time, Vec<u8>) {
    let mut frame = Vec::new();
    let arrived = port.receive(clock, clock.now() + LONG, &mut frame).expect("the line works");
    (arrived.expect("a frame arrives"), frame)
}

/// Whether nothing comes for a while.
pub fn silent(port: &mut dyn Port, clock: &Clock) -> bool {
    port.receive(clock, clock.now() + A_WHILE, &mut Vec::new()).expect("the line works").is_none()
}

/// A frame for `to` of `length` octets, of an EtherType for experiments (IEEE 802, 88-B5).
pub fn frame(to: [u8; 6], length: usize) -> Vec<u8> {
    let mut frame = to.to_vec();
    frame.extend_from_slice(&[0x02, 0, 0, 0, 0, 0x99, 0x88, 0xB5]);
    frame.extend((frame.len()..length).map(|at| at as u8));
    frame
}
