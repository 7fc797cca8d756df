//! Linux packet sockets, see `packet(7)`.

use std::ffi::CString;
use std::io;
use std::mem::{MaybeUninit, zeroed};
use std::os::fd::{AsRawFd, BorrowedFd, FromRawFd, OwnedFd};

use super::set_option;
use station::Duration;

/// ETH_P_ALL in network byte order: frames of all protocols.
const EVERYTHING: u16 = (libc::ETH_P_ALL as u16).to_be();

/// The state of an interface, as the kernel reports it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterfaceStatus {
    /// The interface index, which changes when an interface of the same name is created again.
    pub index: i32,
    /// Whether the interface is up (IFF_UP).
    pub up: bool,
    /// Whether a cable with a peer is plugged in (IFF_RUNNING).
    pub running: bool,
    /// Whether it carries Ethernet frames.
    pub ethernet: bool,
    /// The MAC address.
    pub mac: [u8; 6],
}

/// The metadata of a received frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketMetadata {
    /// Its length in the buffer in bytes, including the virtio header of [`VIRTIO_HEAD`] bytes.
    pub length: usize,
    /// The kernel's timestamp of its arrival, since 1970.
    pub stamp: Option<Duration>,
    /// The VLAN tag that the kernel removed after the addresses: TPID and TCI.
    pub tag: Option<(u16, u16)>,
    /// Whether this host has sent it.
    pub outgoing: bool,
    /// Its length before it was cut to the buffer.
    pub original: usize,
    /// How many frames the socket had dropped when this one was received, modulo 2^32.
    pub dropped: Option<u32>,
}

/// The size of `virtio_net_hdr` in front of each frame in bytes: flags, GSO fields, and where a checksum is to be filled in.
pub const VIRTIO_HEAD: usize = 10;

/// Opens a packet socket that does not block and receives nothing yet.
pub fn open() -> io::Result<OwnedFd> {
    let kind = libc::SOCK_RAW | libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK;
    // SAFETY: no memory is passed.
    let socket = unsafe { libc::socket(libc::AF_PACKET, kind, 0) };
    if socket < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the kernel has just returned this descriptor, no other object owns it.
    Ok(unsafe { OwnedFd::from_raw_fd(socket) })
}

/// Enables VLAN tags, timestamps and incomplete checksums; returns whether each frame has a [`VIRTIO_HEAD`].
pub fn enable_metadata(socket: BorrowedFd<'_>) -> io::Result<bool> {
    set_option(socket, libc::SOL_PACKET, libc::PACKET_AUXDATA, 1_i32)?;
    set_option(socket, libc::SOL_SOCKET, libc::SO_TIMESTAMPNS, 1_i32)?;
    // Older kernels lack this option and mark outgoing frames one by one instead.
    let _ = set_option(socket, libc::SOL_PACKET, libc::PACKET_IGNORE_OUTGOING, 1_i32);
    /// The size of the receive buffer, in bytes.
    const RECEIVE_BUFFER: i32 = 4 << 20;
    if set_option(socket, libc::SOL_SOCKET, libc::SO_RCVBUFFORCE, RECEIVE_BUFFER).is_err() {
        // Without the privilege the kernel limits the buffer to `net.core.rmem_max`.
        let _ = set_option(socket, libc::SOL_SOCKET, libc::SO_RCVBUF, RECEIVE_BUFFER);
    }
    Ok(set_option(socket, libc::SOL_PACKET, libc::PACKET_VNET_HDR, 1_i32).is_ok())
}

/// Binds the socket to the interface `index` in promiscuous mode.
pub fn bind(socket: BorrowedFd<'_>, index: i32) -> io::Result<()> {
    // SAFETY: a structure of integers, for which zero is a value.
    let mut address: libc::sockaddr_ll = unsafe { zeroed() };
    address.sll_family = libc::AF_PACKET as u16;
    address.sll_protocol = EVERYTHING;
    address.sll_ifindex = index;
    let length = size_of::<libc::sockaddr_ll>() as libc::socklen_t;
    // SAFETY: `address` lives through the call and `length` is its size.
    let result = unsafe { libc::bind(socket.as_raw_fd(), (&raw const address).cast(), length) };
    if result != 0 {
        return Err(io::Error::last_os_error());
    }
    let all = libc::packet_mreq {
        mr_ifindex: index,
        mr_type: libc::PACKET_MR_PROMISC as u16,
        mr_alen: 0,
        mr_address: [0; 8],
    };
    set_option(socket, libc::SOL_PACKET, libc::PACKET_ADD_MEMBERSHIP, all)
}

/// Receives one frame; `None` if none is waiting.
pub fn receive(socket: BorrowedFd<'_>, buffer: &mut [u8]) -> io::Result<Option<PacketMetadata>> {
    /// The buffer for control messages, with the alignment of their headers.
    #[repr(C, align(8))]
    struct ControlBuffer([MaybeUninit<u8>; 128]);
    let mut control = ControlBuffer([MaybeUninit::uninit(); 128]);
    let mut part = libc::iovec { iov_base: buffer.as_mut_ptr().cast(), iov_len: buffer.len() };
    // SAFETY: structures of integers and pointers, for which zero is a value.
    let (mut from, mut message): (libc::sockaddr_ll, libc::msghdr) = unsafe { (zeroed(), zeroed()) };
    message.msg_name = (&raw mut from).cast();
    message.msg_namelen = size_of::<libc::sockaddr_ll>() as libc::socklen_t;
    message.msg_iov = &raw mut part;
    message.msg_iovlen = 1;
    message.msg_control = control.0.as_mut_ptr().cast();
    message.msg_controllen = control.0.len() as _;
    // SAFETY: all that `message` points to lives through the call, with the sizes that it names.
    let length = unsafe { libc::recvmsg(socket.as_raw_fd(), &raw mut message, libc::MSG_DONTWAIT) };
    let Ok(length) = usize::try_from(length) else {
        let error = io::Error::last_os_error();
        let nothing = matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted);
        return if nothing { Ok(None) } else { Err(error) };
    };
    let mut packet = PacketMetadata {
        length: length.min(buffer.len()),
        outgoing: from.sll_pkttype == libc::PACKET_OUTGOING,
        ..PacketMetadata::default()
    };
    // SAFETY: the kernel has filled in `message`, whose control buffer is still alive and as long as it says.
    unsafe { read_control(&message, &mut packet) };
    Ok(Some(packet))
}

/// Reads the control messages of a received message.
///
/// # Safety
/// The kernel has filled in `message`, whose control buffer is alive.
unsafe fn read_control(message: &libc::msghdr, packet: &mut PacketMetadata) {
    // SAFETY: the caller ensures that the control buffer is there and as long as `message` says.
    let mut next = unsafe { libc::CMSG_FIRSTHDR(message) };
    while !next.is_null() {
        // SAFETY: `next` is a header inside the control buffer, as CMSG_FIRSTHDR and CMSG_NXTHDR ensure.
        let head = unsafe { std::ptr::read_unaligned(next) };
        match (head.cmsg_level, head.cmsg_type) {
            (libc::SOL_SOCKET, libc::SCM_TIMESTAMPNS) => {
                // SAFETY: `next` is such a header, and a message of this type holds a timespec.
                let stamp: libc::timespec = unsafe { content(next) };
                let seconds = u64::try_from(stamp.tv_sec).unwrap_or_default();
                packet.stamp = Some(Duration::new(seconds, u32::try_from(stamp.tv_nsec).unwrap_or_default()));
            }
            (libc::SOL_PACKET, libc::PACKET_AUXDATA) => {
                // SAFETY: `next` is such a header, and a message of this type holds a tpacket_auxdata.
                let auxdata: libc::tpacket_auxdata = unsafe { content(next) };
                packet.tag = tag(&auxdata);
            }
            (libc::SOL_SOCKET, libc::SO_RXQ_OVFL) => {
                // SAFETY: `next` is such a header, and a message of this type holds a 32-bit count.
                packet.dropped = Some(unsafe { content::<u32>(next) });
            }
            _ => {}
        }
        // SAFETY: as for CMSG_FIRSTHDR.
        next = unsafe { libc::CMSG_NXTHDR(message, next) };
    }
}

/// How many frames [`receive_batch`] takes from the kernel at once.
pub const BATCH: usize = 64;
/// The longest frame of a batch in bytes, with the virtio header; what is longer is cut.
pub const BATCH_FRAME: usize = 2_048;

/// Receives up to [`BATCH`] frames into `buffer`, one after the other in pieces of [`BATCH_FRAME`] bytes; none if none is waiting.
pub fn receive_batch(socket: BorrowedFd<'_>, buffer: &mut [u8], into: &mut Vec<PacketMetadata>) -> io::Result<()> {
    /// The buffer for control messages, with the alignment of their headers.
    #[repr(C, align(8))]
    #[derive(Clone, Copy)]
    struct ControlBuffer([u8; 128]);
    into.clear();
    let mut controls = [ControlBuffer([0; 128]); BATCH];
    // SAFETY: structures of integers and pointers, for which zero is a value.
    let (mut parts, mut froms): ([libc::iovec; BATCH], [libc::sockaddr_ll; BATCH]) = unsafe { (zeroed(), zeroed()) };
    // SAFETY: as above.
    let mut messages: [libc::mmsghdr; BATCH] = unsafe { zeroed() };
    let mut count = 0;
    for (place, piece) in buffer.chunks_exact_mut(BATCH_FRAME).take(BATCH).enumerate() {
        parts[place] = libc::iovec { iov_base: piece.as_mut_ptr().cast(), iov_len: piece.len() };
        let message = &mut messages[place].msg_hdr;
        message.msg_name = (&raw mut froms[place]).cast();
        message.msg_namelen = size_of::<libc::sockaddr_ll>() as libc::socklen_t;
        message.msg_iov = &raw mut parts[place];
        message.msg_iovlen = 1;
        message.msg_control = controls[place].0.as_mut_ptr().cast();
        message.msg_controllen = controls[place].0.len() as _;
        count += 1;
    }
    let flags = libc::MSG_DONTWAIT | libc::MSG_TRUNC;
    // SAFETY: all that the `count` messages point to lives through the call, with the sizes that they name; no timeout is given.
    let received =
        unsafe { libc::recvmmsg(socket.as_raw_fd(), messages.as_mut_ptr(), count, flags as _, std::ptr::null_mut()) };
    let Ok(received) = usize::try_from(received) else {
        let error = io::Error::last_os_error();
        let nothing = matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted);
        return if nothing { Ok(()) } else { Err(error) };
    };
    for (message, from) in messages.iter().zip(&froms).take(received) {
        let original = message.msg_len as usize;
        let mut packet = PacketMetadata {
            length: original.min(BATCH_FRAME),
            original,
            outgoing: from.sll_pkttype == libc::PACKET_OUTGOING,
            ..PacketMetadata::default()
        };
        // SAFETY: the kernel has filled in this message, and its control buffer is still alive.
        unsafe { read_control(&message.msg_hdr, &mut packet) };
        into.push(packet);
    }
    Ok(())
}

/// Has the socket receive the frames that this host sends, count the dropped frames at each one, and buffer `octets` bytes.
pub fn enable_watching(socket: BorrowedFd<'_>, octets: i32) -> io::Result<()> {
    // Older kernels lack this option and pass on outgoing frames anyway.
    let _ = set_option(socket, libc::SOL_PACKET, libc::PACKET_IGNORE_OUTGOING, 0_i32);
    if set_option(socket, libc::SOL_SOCKET, libc::SO_RCVBUFFORCE, octets).is_err() {
        // Without the privilege the kernel limits the buffer to `net.core.rmem_max`.
        let _ = set_option(socket, libc::SOL_SOCKET, libc::SO_RCVBUF, octets);
    }
    set_option(socket, libc::SOL_SOCKET, libc::SO_RXQ_OVFL, 1_i32)
}

/// The data of the control message at `head`.
///
/// # Safety
/// `head` points to the header of a control message that holds a `T`.
unsafe fn content<T: Copy>(head: *const libc::cmsghdr) -> T {
    // SAFETY: the caller ensures that a `T` is there; it need not be aligned.
    unsafe { std::ptr::read_unaligned(libc::CMSG_DATA(head).cast::<T>()) }
}

fn tag(auxdata: &libc::tpacket_auxdata) -> Option<(u16, u16)> {
    let valid = auxdata.tp_status & libc::TP_STATUS_VLAN_VALID != 0 || auxdata.tp_vlan_tci != 0;
    let has_tpid = auxdata.tp_status & libc::TP_STATUS_VLAN_TPID_VALID != 0;
    valid.then_some((if has_tpid { auxdata.tp_vlan_tpid } else { libc::ETH_P_8021Q as u16 }, auxdata.tp_vlan_tci))
}

/// Sends `octets`; a socket bound to an interface needs no address.
pub fn send(socket: BorrowedFd<'_>, octets: &[u8]) -> io::Result<()> {
    // SAFETY: `octets` lives through the call and its length is passed.
    let sent = unsafe {
        libc::send(socket.as_raw_fd(), octets.as_ptr().cast(), octets.len(), libc::MSG_DONTWAIT | libc::MSG_NOSIGNAL)
    };
    if sent < 0 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

/// The number of frames dropped since the last call because the receive buffer was full.
pub fn dropped(socket: BorrowedFd<'_>) -> u64 {
    // SAFETY: a structure of integers, for which zero is a value.
    let mut counts: libc::tpacket_stats = unsafe { zeroed() };
    let mut length = size_of::<libc::tpacket_stats>() as libc::socklen_t;
    // SAFETY: `counts` and `length` live through the call; the kernel writes no more than `length` bytes.
    let result = unsafe {
        libc::getsockopt(
            socket.as_raw_fd(),
            libc::SOL_PACKET,
            libc::PACKET_STATISTICS,
            (&raw mut counts).cast(),
            &raw mut length,
        )
    };
    if result == 0 { u64::from(counts.tp_drops) } else { 0 }
}

/// Reads the state of the interface `name`; `None` if there is no such interface.
pub fn interface_status(socket: BorrowedFd<'_>, name: &str) -> io::Result<Option<InterfaceStatus>> {
    let Ok(name) = CString::new(name) else { return Ok(None) };
    let octets = name.as_bytes_with_nul();
    if octets.len() > libc::IFNAMSIZ {
        return Ok(None);
    }
    // SAFETY: a structure of integers and arrays of them, for which zero is a value.
    let mut request: libc::ifreq = unsafe { zeroed() };
    for (to, from) in request.ifr_name.iter_mut().zip(octets) {
        *to = *from as libc::c_char;
    }
    let ask = |question: libc::c_ulong, request: &mut libc::ifreq| {
        // SAFETY: these requests take an `ifreq`, and it lives through the call.
        let result = unsafe { libc::ioctl(socket.as_raw_fd(), question as _, &raw mut *request) };
        if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
    };
    let mut all = || -> io::Result<InterfaceStatus> {
        ask(libc::SIOCGIFINDEX, &mut request)?;
        // SAFETY: the kernel has filled in this member of the union.
        let index = unsafe { request.ifr_ifru.ifru_ifindex };
        ask(libc::SIOCGIFFLAGS, &mut request)?;
        // SAFETY: as above.
        let flags = libc::c_int::from(unsafe { request.ifr_ifru.ifru_flags });
        ask(libc::SIOCGIFHWADDR, &mut request)?;
        // SAFETY: as above.
        let address = unsafe { request.ifr_ifru.ifru_hwaddr };
        let mut mac = [0; 6];
        for (to, from) in mac.iter_mut().zip(address.sa_data) {
            *to = from as u8;
        }
        Ok(InterfaceStatus {
            index,
            up: flags & libc::IFF_UP != 0,
            running: flags & libc::IFF_RUNNING != 0,
            ethernet: address.sa_family == libc::ARPHRD_ETHER,
            mac,
        })
    };
    match all() {
        Ok(facts) => Ok(Some(facts)),
        Err(error) if error.raw_os_error() == Some(libc::ENODEV) => Ok(None),
        Err(error) => Err(error),
    }
}
