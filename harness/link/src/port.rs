//! The trait of everything that carries Ethernet frames.

use crate::{Clock, LinkError};
use station::Time;

/// One end of a line that carries Ethernet frames, from the destination address to the payload, without frame check sequence.
pub trait Port: Send {
    /// Sends `frame` at once.
    ///
    /// A frame for which the line has no buffer is dropped without an error, as in a switch.
    fn send(&mut self, frame: &[u8]) -> Result<(), LinkError>;

    /// Waits until a frame arrives or `clock` shows `until`, and returns the time at which the frame arrived.
    ///
    /// The frame replaces the content of `into`. It is the frame as on the wire: with its 802.1Q tag, and with the checksum that
    /// the sender left to its hardware. Frames that this port has sent do not come back. If `until` has passed, a frame that has
    /// already arrived is returned without waiting.
    fn receive(&mut self, clock: &Clock, until: Time, into: &mut Vec<u8>) -> Result<Option<Time>, LinkError>;

    /// After [`LinkError::Gone`]: tries to restore the line until `clock` shows `until`.
    fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError>;

    /// The MAC address of the interface; `None` on a socket.
    fn mac(&self) -> Option<[u8; 6]>;

    /// The kind and name of the port for messages: `the interface eth0`, `the socket /run/qemu.sock`.
    fn describe(&self) -> String;

    /// Whether the other end is connected; without it the port is silent, but this is no error.
    fn carrier(&self) -> bool {
        true
    }

    /// Whether what is at the other end runs on this host too: a program, or a virtual machine.
    fn ends_on_this_host(&self) -> bool {
        false
    }

    /// The number of frames lost at this end since the port was opened, because a receive or transmit buffer was full.
    fn lost(&mut self) -> u64 {
        0
    }
}
