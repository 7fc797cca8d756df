//! What no wire carries, on either bus.

use station::Time;
use thiserror::Error;

/// What a station did that no wire carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Violation {
    /// A frame that cannot hold two addresses and an EtherType was not transmitted.
    #[error("port {port} sent a frame of {length} octets at {time}; the shortest has 14")]
    TooShort {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
        /// Its length in octets.
        length: usize,
    },
    /// A frame beyond 1514 octets (1518 with an 802.1Q tag), check sequence not counted, was not transmitted.
    #[error("port {port} sent a frame of {length} octets at {time}; the longest has 1514, tagged 1518")]
    TooLong {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
        /// Its length in octets.
        length: usize,
    },
    /// A frame was dropped because those queued before it keep the line busy for 100 ms.
    #[error("port {port} sent more at {time} than its line carries; the frame was dropped")]
    Congested {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
    },
    /// A frame of no octets, or of more than 255, was not transmitted on a bus.
    #[error("port {port} sent a frame of {length} octets at {time}; the longest on the bus has 255")]
    NoFrame {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
        /// Its length in octets.
        length: usize,
    },
    /// Two ports sent at once on a bus; the others received nonsense.
    #[error("port {port} sent at {time} while port {other} was sending; both frames are lost")]
    Collision {
        /// The port that began later.
        port: usize,
        /// When it began.
        time: Time,
        /// The port that was sending.
        other: usize,
    },
    /// A request began before the bus had been silent for TSYN.
    #[error("port {port} sent a request at {time} after {silent} bit times of silence; at least 33 are needed")]
    NoSilence {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
        /// How long the bus was silent, in bits.
        silent: u64,
    },
    /// An answer began before the least delay of a station was over.
    #[error("port {port} answered at {time} after {silent} bit times; min TSDR is 11")]
    TooEarly {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
        /// How long the bus was silent, in bits.
        silent: u64,
    },
    /// An answer began when nobody waited for it any more.
    #[error("port {port} answered at {time} after {silent} bit times; the slot time is {slot}")]
    TooLate {
        /// The port that sent it.
        port: usize,
        /// When.
        time: Time,
        /// How long the bus was silent, in bits.
        silent: u64,
        /// The slot time, in bits.
        slot: u64,
    },
    /// A station asks again and again to be woken at the same instant; it sleeps until the clock moves on.
    #[error("port {port} wants to be woken at {time} for ever")]
    Livelock {
        /// The port of the station.
        port: usize,
        /// The instant.
        time: Time,
    },
}
