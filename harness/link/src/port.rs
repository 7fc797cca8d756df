//! What carries Ethernet frames.

use crate::{Clock, LinkError};
use station::Time;

/// One end of a line that carries Ethernet frames, from the destination address to the payload, without check sequence.
pub trait Port: Send {
    /// Sends `frame` at once.
    ///
    /// A frame that the line has no room for at the moment is dropped as a switch would drop it, without an error.
    fn send(&mut self, frame: &[u8]) -> Result<(), LinkError>;

    /// Waits until a frame is here or `clock` shows `until`, and says when the frame arrived.
    ///
    /// The frame replaces what is in `into`. It is as it was on the wire: an 802.1Q tag stands where it stood, a
    /// checksum that the sender left to its hardware is filled in. What this port itself has sent does not come back. With an
    /// `until` that has gone by, what waits already is handed out and nothing is waited for.
    fn receive(&mut self, clock: &Clock, until: Time, into: &mut Vec<u8>) -> Result<Option<Time>, LinkError>;

    /// After [`LinkError::Gone`]: tries to get the line back until `clock` shows `until`.
    fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError>;

    /// The MAC address of the interface; none on a socket.
    fn mac(&self) -> Option<[u8; 6]>;

    /// What it is, for messages: `the interface eth0`, `the socket /run/qemu.sock`.
    fn describe(&self) -> String;

    /// Whether something is plugged in at the other end; without it there is silence, but no error.
    fn carrier(&self) -> bool {
        true
    }

    /// How many frames have been lost at this end since the port was opened: they arrived and nobody took them in time,
    /// or they were to be sent and there was no room for them.
    fn lost(&mut self) -> u64 {
        0
    }
}
