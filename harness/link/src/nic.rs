//! Raw Ethernet on a network interface, through a Linux packet socket.
//!
//! The portable library (`pnet_datalink`) reads neither 802.1Q tags, which the kernel removes from the frame and passes as
//! auxiliary data, nor the kernel's timestamps; this module does.

use std::fmt;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::interfaces::{escaped, interface_names};
use crate::sys::packet::{self, InterfaceStatus, PacketMetadata, VIRTIO_HEAD};
use crate::sys::{PollEvent, pause, wait};
use crate::{Clock, LinkError, Port};
use station::{Duration, Time};

/// Longer than any frame that the kernel delivers in one piece.
const BUFFER: usize = VIRTIO_HEAD + (1 << 16) + 256;
/// Destination and source address, in bytes.
pub(crate) const ADDRESSES: usize = 12;
/// A timestamp older than this is wrong: the system date was changed in between.
const LONGEST_WAIT: Duration = Duration::from_secs(10);
/// How long [`Nic::open`] and [`Port::recover`] wait for the carrier; without it they succeed, and the line is silent.
const WAIT_FOR_CARRIER: Duration = Duration::from_secs(3);
/// How often [`Port::recover`] checks whether the interface is back.
const LOOK_AGAIN: Duration = Duration::from_millis(20);
/// VIRTIO_NET_HDR_F_NEEDS_CSUM: the checksum of the frame is still to be filled in.
pub(crate) const NEEDS_CHECKSUM: u8 = 1;

/// A network interface in promiscuous mode: sends frames with any source address and receives frames for any destination.
pub struct Nic {
    name: String,
    socket: OwnedFd,
    status: InterfaceStatus,
    /// Whether each frame has a virtio header of [`VIRTIO_HEAD`] bytes, in both directions.
    has_virtio_header: bool,
    buffer: Box<[u8]>,
    outgoing: Vec<u8>,
    lost: u64,
    /// Why the interface is gone, until it is recovered: the kernel reports the error only once.
    gone: Option<LinkError>,
}

impl fmt::Debug for Nic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Nic").field("name", &self.name).field("facts", &self.status).finish_non_exhaustive()
    }
}

impl Nic {
    /// Opens the interface `name`, which needs no IP configuration.
    ///
    /// The interface must exist, be up and carry Ethernet frames; the process needs root or CAP_NET_RAW. Waits up to 3 s for the
    /// carrier, but succeeds without it: see [`Port::carrier`].
    pub fn open(name: &str) -> Result<Nic, LinkError> {
        let (socket, facts, headed) = open_socket(name, |_| Ok(()))?;
        let buffer = vec![0; BUFFER].into_boxed_slice();
        let outgoing = Vec::new();
        let nic = Nic {
            name: name.to_string(),
            socket,
            status: facts,
            has_virtio_header: headed,
            buffer,
            outgoing,
            lost: 0,
            gone: None,
        };
        nic.wait_for_carrier(&Clock::start(), Time::MAX);
        Ok(nic)
    }

    /// The name of the interface.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Maps the error of a call to a lost interface; no error if only the frame is lost, as a switch may lose it.
    fn classify_error(&mut self, error: &io::Error) -> Result<(), LinkError> {
        let label = escaped(&self.name);
        let why = match error.raw_os_error() {
            Some(libc::ENOBUFS | libc::EAGAIN | libc::EINTR | libc::EMSGSIZE | libc::EINVAL) => return Ok(()),
            Some(libc::ENETDOWN) => self.why_down(&label),
            Some(libc::ENODEV | libc::ENXIO) => removed(&label),
            _ => format!("the interface {label} has failed: {error}; open it again"),
        };
        let gone = LinkError::Gone(why);
        self.gone = Some(gone.clone());
        Err(gone)
    }

    /// Waits until the interface has carrier, at most [`WAIT_FOR_CARRIER`]: it takes a moment after it was brought up.
    fn wait_for_carrier(&self, clock: &Clock, until: Time) {
        let until = until.min(clock.now() + WAIT_FOR_CARRIER);
        while !self.carrier() && !clock.remaining(until).is_zero() {
            pause(clock, until.min(clock.now() + LOOK_AGAIN));
        }
    }

    fn check_gone(&self) -> Result<(), LinkError> {
        self.gone.clone().map_or(Ok(()), Err)
    }

    fn why_down(&self, label: &str) -> String {
        match packet::interface_status(self.socket.as_fd(), &self.name) {
            Ok(None) => removed(label),
            _ => format!("the interface {label} was taken down; bring it up with `ip link set {label} up`"),
        }
    }

    /// Writes the received frame to `into` as it was on the wire; returns false for frames that this host has sent.
    fn restore(&mut self, packet: &PacketMetadata, into: &mut Vec<u8>) -> bool {
        let head = if self.has_virtio_header { VIRTIO_HEAD } else { 0 };
        if packet.outgoing || packet.length < head {
            return false;
        }
        let (head, frame) = self.buffer[..packet.length].split_at_mut(head);
        if let [NEEDS_CHECKSUM, _, _, _, _, _, a, b, c, d] = *head {
            fill_in_checksum(frame, u16::from_ne_bytes([a, b]).into(), u16::from_ne_bytes([c, d]).into());
        }
        into.clear();
        match packet.tag {
            Some((kind, content)) if frame.len() >= ADDRESSES => {
                into.extend_from_slice(&frame[..ADDRESSES]);
                into.extend_from_slice(&kind.to_be_bytes());
                into.extend_from_slice(&content.to_be_bytes());
                into.extend_from_slice(&frame[ADDRESSES..]);
            }
            _ => into.extend_from_slice(frame),
        }
        true
    }
}

impl Port for Nic {
    fn send(&mut self, frame: &[u8]) -> Result<(), LinkError> {
        self.check_gone()?;
        self.outgoing.clear();
        self.outgoing.resize(if self.has_virtio_header { VIRTIO_HEAD } else { 0 }, 0);
        self.outgoing.extend_from_slice(frame);
        packet::send(self.socket.as_fd(), &self.outgoing).or_else(|error| {
            self.lost += 1;
            self.classify_error(&error)
        })
    }

    fn receive(&mut self, clock: &Clock, until: Time, into: &mut Vec<u8>) -> Result<Option<Time>, LinkError> {
        self.check_gone()?;
        loop {
            let packet = match packet::receive(self.socket.as_fd(), &mut self.buffer) {
                Ok(packet) => packet,
                Err(error) => self.classify_error(&error).map(|()| None)?,
            };
            if let Some(packet) = packet {
                if self.restore(&packet, into) {
                    return Ok(Some(arrival(clock.now(), packet.stamp)));
                }
            } else if clock.remaining(until).is_zero() {
                return Ok(None);
            } else if let Err(error) = wait(self.socket.as_fd(), PollEvent::Reading, clock, until) {
                self.classify_error(&error)?;
            }
        }
    }

    fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        let label = escaped(&self.name);
        loop {
            let found = packet::interface_status(self.socket.as_fd(), &self.name)
                .map_err(|error| LinkError::Gone(format!("the interface {label} has failed: {error}")));
            let why = match found.and_then(|facts| require_usable(&label, facts)) {
                // The same socket is bound again: unlike opening a new one, this needs no privilege.
                Ok(facts) => match packet::bind(self.socket.as_fd(), facts.index) {
                    Ok(()) => {
                        self.status = facts;
                        self.gone = None;
                        // A pending error of the old interface would be taken for one of the new interface.
                        while packet::receive(self.socket.as_fd(), &mut self.buffer).is_err_and(|error| is_down(&error))
                        {
                        }
                        self.wait_for_carrier(clock, until);
                        return Ok(());
                    }
                    Err(error) => format!("the interface {label} cannot be used again: {error}"),
                },
                Err(error) => error.to_string(),
            };
            if clock.remaining(until).is_zero() {
                return Err(LinkError::Gone(why));
            }
            pause(clock, until.min(clock.now() + LOOK_AGAIN));
        }
    }

    fn mac(&self) -> Option<[u8; 6]> {
        Some(self.status.mac)
    }

    fn describe(&self) -> String {
        format!("the interface {}", escaped(&self.name))
    }

    fn carrier(&self) -> bool {
        matches!(
            packet::interface_status(self.socket.as_fd(), &self.name),
            Ok(Some(InterfaceStatus { running: true, .. }))
        )
    }

    /// As the kernel describes the interface below `/sys`: one end of a veth pair, or a TUN/TAP device.
    fn ends_on_this_host(&self) -> bool {
        let folder = std::path::Path::new("/sys/class/net").join(&self.name);
        let read = |file: &str| std::fs::read_to_string(folder.join(file)).ok();
        let is_pair = || read("iflink").is_some_and(|peer| read("ifindex").is_some_and(|own| own != peer));
        // A VLAN or the like, which is on another interface, says its type.
        let is_typed = || read("uevent").is_none_or(|text| text.contains("DEVTYPE="));
        read("tun_flags").is_some() || is_pair() && !is_typed()
    }

    fn lost(&mut self) -> u64 {
        self.lost += packet::dropped(self.socket.as_fd());
        self.lost
    }
}

fn is_down(error: &io::Error) -> bool {
    error.raw_os_error() == Some(libc::ENETDOWN)
}

/// Converts the kernel's timestamp, which counts from 1970, to the time of a clock that now shows `now`.
fn arrival(now: Time, stamp: Option<Duration>) -> Time {
    let date = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    match stamp.and_then(|stamp| date.checked_sub(stamp)) {
        Some(waited) if waited <= LONGEST_WAIT => now - waited,
        _ => now,
    }
}

/// Fills in a checksum that the sender left to its hardware: the ones' complement sum from `start` on, at `start + offset`.
pub(crate) fn fill_in_checksum(frame: &mut [u8], start: usize, offset: usize) {
    let Some(covered) = frame.get_mut(start..).filter(|covered| covered.len() >= offset + 2) else { return };
    let mut sum: u64 =
        covered.chunks(2).map(|pair| u64::from(pair[0]) << 8 | u64::from(*pair.get(1).unwrap_or(&0))).sum();
    while sum > 0xFFFF {
        sum = (sum & 0xFFFF) + (sum >> 16);
    }
    // Zero means "no checksum" (RFC 768); 0xFFFF is the same sum in ones' complement.
    let checksum = match !(sum as u16) {
        0 => 0xFFFF,
        checksum => checksum,
    };
    covered[offset..offset + 2].copy_from_slice(&checksum.to_be_bytes());
}

/// Opens a packet socket at an interface and sets it up with `prepare` before it receives: the socket, what the kernel says of the
/// interface, and whether each frame has a virtio header.
pub(crate) fn open_socket(
    name: &str,
    prepare: impl FnOnce(BorrowedFd<'_>) -> io::Result<()>,
) -> Result<(OwnedFd, InterfaceStatus, bool), LinkError> {
    let label = escaped(name);
    let unusable = |error: io::Error| match error.kind() {
        io::ErrorKind::PermissionDenied => no_privilege(&label),
        _ => LinkError::Unusable(format!("the interface {label} cannot be opened: {error}")),
    };
    check(name)?;
    let socket = packet::open().map_err(unusable)?;
    let status = require_usable(&label, packet::interface_status(socket.as_fd(), name).map_err(unusable)?)?;
    let has_virtio_header = packet::enable_metadata(socket.as_fd()).map_err(unusable)?;
    prepare(socket.as_fd()).map_err(unusable)?;
    packet::bind(socket.as_fd(), status.index).map_err(unusable)?;
    Ok((socket, status, has_virtio_header))
}

/// Checks the interface `name` as far as this needs no privilege.
fn check(name: &str) -> Result<(), LinkError> {
    let label = escaped(name);
    let known = crate::interfaces();
    let Some(found) = known.iter().find(|known| known.name == name) else { return Err(absent(&label)) };
    if found.loopback {
        return Err(no_ethernet(&label));
    }
    if !found.up {
        return Err(down(&label));
    }
    Ok(())
}

/// Fails if the interface is absent, is down or carries no Ethernet frames.
pub(crate) fn require_usable(label: &str, facts: Option<InterfaceStatus>) -> Result<InterfaceStatus, LinkError> {
    match facts {
        None => Err(absent(label)),
        Some(facts) if !facts.ethernet => Err(no_ethernet(label)),
        Some(facts) if !facts.up => Err(down(label)),
        Some(facts) => Ok(facts),
    }
}

fn absent(label: &str) -> LinkError {
    LinkError::Unusable(format!("there is no interface {label}: {}", interface_names()))
}

pub(crate) fn removed(label: &str) -> String {
    format!("the interface {label} was removed; plug its adapter in again")
}

fn no_ethernet(label: &str) -> LinkError {
    LinkError::Unusable(format!("the interface {label} carries no Ethernet frames: {}", interface_names()))
}

fn down(label: &str) -> LinkError {
    LinkError::Unusable(format!("the interface {label} is down: bring it up with `ip link set {label} up`"))
}

fn no_privilege(label: &str) -> LinkError {
    let program =
        std::env::current_exe().map_or_else(|_| "encspec".to_string(), |path| escaped(&path.to_string_lossy()));
    LinkError::Unusable(format!(
        "the interface {label} needs root or CAP_NET_RAW: grant it with `{}`, or run as root",
        crate::privileges::how_to_grant(&program)
    ))
}
