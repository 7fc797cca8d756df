//! A network interface that is only listened at: there is no way to send through it.

use std::fmt;
use std::io;
use std::os::fd::{AsFd, OwnedFd};

use crate::interfaces::escaped;
use crate::nic::{ADDRESSES, NEEDS_CHECKSUM, fill_in_checksum, open_socket, removed, require_usable};
use crate::sys::packet::{self, BATCH, BATCH_FRAME, PacketMetadata, VIRTIO_HEAD};
use crate::sys::{PollEvent, wait};
use crate::{Clock, LinkError};
use station::{Duration, Time};

/// The receive buffer of the kernel in bytes: about half a second of 64,000 frames a second.
const RECEIVE_BUFFER: i32 = 32 << 20;

/// A frame as it was on the wire.
#[derive(Clone, Copy, Debug)]
pub struct TapFrame<'a> {
    /// When the kernel received it, since 1970; `None` if the kernel does not say.
    pub time: Option<Duration>,
    /// From the destination address on, with its VLAN tag.
    pub octets: &'a [u8],
    /// Its length before it was cut.
    pub original: usize,
    /// How many frames the kernel dropped before it, since the frame before.
    pub lost_before: u64,
}

/// A network interface in promiscuous mode, at which this process sends nothing.
///
/// Frames that other programs of this host send are received, too.
pub struct NicTap {
    name: String,
    socket: OwnedFd,
    has_virtio_header: bool,
    buffer: Box<[u8]>,
    batch: Vec<PacketMetadata>,
    restored: Vec<u8>,
    dropped: u32,
    lost: u64,
}

impl fmt::Debug for NicTap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NicTap").field("name", &self.name).finish_non_exhaustive()
    }
}

impl NicTap {
    /// Opens the interface `name`, which must exist, be up and carry Ethernet frames; needs root or CAP_NET_RAW.
    pub fn open(name: &str) -> Result<NicTap, LinkError> {
        let (socket, _, has_virtio_header) =
            open_socket(name, |socket| packet::enable_watching(socket, RECEIVE_BUFFER))?;
        Ok(NicTap {
            name: name.to_string(),
            socket,
            has_virtio_header,
            buffer: vec![0; BATCH * BATCH_FRAME].into_boxed_slice(),
            batch: Vec::with_capacity(BATCH),
            restored: Vec::with_capacity(BATCH_FRAME),
            dropped: 0,
            lost: 0,
        })
    }

    /// The largest number that [`receive`](Self::receive) returns; more frames may be waiting then.
    pub const MOST_AT_ONCE: usize = BATCH;

    /// Passes on the frames that have arrived, some at a time; waits for them until `clock` shows `until`. Returns how many there were.
    pub fn receive(
        &mut self,
        clock: &Clock,
        until: Time,
        sink: &mut dyn FnMut(TapFrame<'_>),
    ) -> Result<usize, LinkError> {
        self.take(sink)?;
        if self.batch.is_empty() && !clock.remaining(until).is_zero() {
            wait(self.socket.as_fd(), PollEvent::Reading, clock, until).map_err(|error| self.gone(&error))?;
            self.take(sink)?;
        }
        Ok(self.batch.len())
    }

    fn take(&mut self, sink: &mut dyn FnMut(TapFrame<'_>)) -> Result<(), LinkError> {
        let taken = packet::receive_batch(self.socket.as_fd(), &mut self.buffer, &mut self.batch);
        taken.map_err(|error| self.gone(&error))?;
        let NicTap { buffer, batch, restored, has_virtio_header, dropped, lost, .. } = self;
        for (packet, octets) in batch.iter().zip(buffer.chunks_exact_mut(BATCH_FRAME)) {
            let lost_before = packet.dropped.map_or(0, |now| u64::from(now.wrapping_sub(*dropped)));
            *dropped = packet.dropped.unwrap_or(*dropped);
            *lost += lost_before;
            let head = if *has_virtio_header { VIRTIO_HEAD } else { 0 };
            let Some((head, frame)) = octets.get_mut(..packet.length).and_then(|of| of.split_at_mut_checked(head))
            else {
                continue;
            };
            if let [NEEDS_CHECKSUM, _, _, _, _, _, a, b, c, d] = *head {
                fill_in_checksum(frame, u16::from_ne_bytes([a, b]).into(), u16::from_ne_bytes([c, d]).into());
            }
            let mut original = packet.original - head.len();
            let octets: &[u8] = match packet.tag {
                Some((kind, content)) if frame.len() >= ADDRESSES => {
                    restored.clear();
                    restored.extend_from_slice(&frame[..ADDRESSES]);
                    restored.extend_from_slice(&kind.to_be_bytes());
                    restored.extend_from_slice(&content.to_be_bytes());
                    restored.extend_from_slice(&frame[ADDRESSES..]);
                    original += restored.len() - frame.len();
                    restored
                }
                _ => frame,
            };
            sink(TapFrame { time: packet.stamp, octets, original, lost_before });
        }
        Ok(())
    }

    fn gone(&self, error: &io::Error) -> LinkError {
        let label = escaped(&self.name);
        LinkError::Gone(match error.raw_os_error() {
            Some(libc::ENETDOWN) => format!("the interface {label} is down"),
            Some(libc::ENODEV | libc::ENXIO) => removed(&label),
            _ => format!("the interface {label} has failed: {error}"),
        })
    }

    /// After [`LinkError::Gone`]: listens again if the interface is back.
    pub fn recover(&mut self) -> Result<(), LinkError> {
        let label = escaped(&self.name);
        let found = packet::interface_status(self.socket.as_fd(), &self.name).map_err(|error| self.gone(&error))?;
        let status = require_usable(&label, found)?;
        packet::bind(self.socket.as_fd(), status.index).map_err(|error| self.gone(&error))
    }

    /// The number of frames lost since the interface was opened, because the receive buffer was full.
    ///
    /// It may be ahead of the sum of [`TapFrame::lost_before`], which counts up to the last frame received.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// The kind and name for messages: `the interface eth0`.
    pub fn describe(&self) -> String {
        format!("the interface {}", escaped(&self.name))
    }
}
