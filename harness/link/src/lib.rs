//! Network interfaces, QEMU sockets, serial lines, and text lines over Unix sockets. All sockets, terminals and `unsafe` code are
//! here.
//!
//! A [`Port`] carries Ethernet frames; [`Nic`] is one at a network interface, [`FrameSocket`] one at a socket. A [`Wire`]
//! puts any number of stations of this process on one port and runs them by the [`Clock`]. A [`SerialBus`] does the same with a
//! serial line; a [`Framing`] of the caller finds the frames in its bytes. [`realtime`], [`privileges`] and [`interrupt`] are for
//! the process that drives a real wire, [`lines`] is for a control channel.
//!
//! This crate must not know what the frames mean, nor which rules they are checked against.

mod address;
mod clock;
mod error;
mod interfaces;
pub mod interrupt;
mod lateness;
pub mod lines;
#[doc(hidden)]
pub mod namespace;
#[cfg(target_os = "linux")]
mod nic;
mod port;
#[doc(hidden)]
pub mod portable;
pub mod privileges;
pub mod realtime;
pub mod serial;
mod serial_bus;
mod shortage;
mod socket;
mod stream_frames;
mod sys;
pub mod system_log;
#[cfg(target_os = "linux")]
mod tap;
mod terminal;
pub mod text_server;
pub mod transmitted;
mod wire;

pub use address::{BadAddress, SocketAddress};
pub use clock::Clock;
pub use error::LinkError;
pub use interfaces::{InterfaceInfo, interfaces};
pub use lateness::{Histogram, Lateness};
#[cfg(target_os = "linux")]
pub use nic::Nic;
pub use port::Port;
#[cfg(not(target_os = "linux"))]
pub use portable::PortableNic as Nic;
pub use serial::{Serial, SerialSettings};
pub use serial_bus::{BusTransmission, Framing, LinePiece, SerialBus};
pub use shortage::ProcessorShortage;
pub use socket::FrameSocket;
pub use station::Parity;
pub use stream_frames::{BadFrameLength, StreamFrames};
pub use sys::pause;
#[cfg(target_os = "linux")]
pub use tap::{NicTap, TapFrame};
pub use terminal::terminal_size;
pub use wire::{LocalStation, Wire, WireStep};
