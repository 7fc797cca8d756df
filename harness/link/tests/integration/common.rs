//! Shared by the tests of this crate.

use encspec_link::{Clock, Port, namespace};
use station::{Duration, Time};

/// Moves this thread into a network namespace with the interfaces `left` and `right` connected to each other; returns false, and
/// the test is skipped, if the host does not permit it.
pub fn two_ends() -> bool {
    testing::available(namespace::enter_private_network().and_then(|()| namespace::veth("left", "right")))
}

/// The timeout for events that must happen.
pub const LONG: Duration = Duration::from_secs(5);
/// The time to wait for events that must not happen.
pub const A_WHILE: Duration = Duration::from_millis(30);

/// Receives the next frame, which must arrive within [`LONG`].
#[track_caller]
pub fn next(port: &mut dyn Port, clock: &Clock) -> (Time, Vec<u8>) {
    let mut frame = Vec::new();
    let arrived = port.receive(clock, clock.now() + LONG, &mut frame).expect("the line works");
    (arrived.expect("a frame arrives"), frame)
}

/// Whether no frame arrives within [`A_WHILE`].
pub fn silent(port: &mut dyn Port, clock: &Clock) -> bool {
    port.receive(clock, clock.now() + A_WHILE, &mut Vec::new()).expect("the line works").is_none()
}

/// A frame for `to` of `length` bytes, with an EtherType for experiments (IEEE 802, 88-B5).
pub fn frame(to: [u8; 6], length: usize) -> Vec<u8> {
    let mut frame = to.to_vec();
    frame.extend_from_slice(&[0x02, 0, 0, 0, 0, 0x99, 0x88, 0xB5]);
    frame.extend((frame.len()..length).map(|at| at as u8));
    frame
}
