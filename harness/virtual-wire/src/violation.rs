//! Violations of the rules of a virtual wire or bus.

use station::Time;
use thiserror::Error;

/// A frame, or its time, that a real wire or bus does not allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum WireViolation {
    /// A frame too short for two addresses and an EtherType; it was not transmitted.
    #[error("port {port} sent a frame of {length} bytes at {time}; the shortest has 14")]
    TooShort { port: usize, time: Time, length: usize },
    /// A frame beyond 1514 bytes (1518 with an 802.1Q tag), without check sequence; it was not transmitted.
    #[error("port {port} sent a frame of {length} bytes at {time}; the longest has 1514, tagged 1518")]
    TooLong { port: usize, time: Time, length: usize },
    /// A frame was dropped because queued frames keep the line busy for 100 ms.
    #[error("port {port} sent more at {time} than its line carries; the frame was dropped")]
    Congested { port: usize, time: Time },
    /// A frame of no bytes, or of more than 255, on a bus; it was not transmitted.
    #[error("port {port} sent a frame of {length} bytes at {time}; the longest on the bus has 255")]
    NoFrame { port: usize, time: Time, length: usize },
    /// Two ports sent at the same time on a bus; the others received noise.
    #[error("port {port} sent at {time} while port {other} was sending; both frames are lost")]
    Collision {
        /// The port that began later.
        port: usize,
        time: Time,
        /// The port that was already sending.
        other: usize,
    },
    /// A request began before the bus had been silent for TSYN.
    #[error("port {port} sent a request at {time} after {silent} bit times of silence; at least 33 are needed")]
    NoSilence {
        port: usize,
        time: Time,
        /// Duration of the silence, in bit times.
        silent: u64,
    },
    /// An answer began before min TSDR.
    #[error("port {port} answered at {time} after {silent} bit times; min TSDR is {least}")]
    TooEarly {
        port: usize,
        time: Time,
        /// Duration of the silence, in bit times.
        silent: u64,
        /// Min TSDR, in bit times: 11, or that of a Set_Prm in force.
        least: u64,
    },
    /// An answer began after max TSDR, although within the slot time.
    #[error("port {port} answered at {time} after {silent} bit times; max TSDR is {most}")]
    AfterMaxTsdr {
        port: usize,
        time: Time,
        /// Duration of the silence, in bit times.
        silent: u64,
        /// Max TSDR, in bit times.
        most: u64,
    },
    /// An answer began after the slot time.
    #[error("port {port} answered at {time} after {silent} bit times; the slot time is {slot}")]
    TooLate {
        port: usize,
        time: Time,
        /// Duration of the silence, in bit times.
        silent: u64,
        /// Slot time, in bit times.
        slot: u64,
    },
    /// A station repeatedly requests to be woken at the same instant; it is not woken until the clock advances.
    #[error("port {port} requests to be woken at {time} without end")]
    Livelock { port: usize, time: Time },
}
