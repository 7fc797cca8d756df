//! Packet sockets of Linux.

use std::ffi::CString;
use std::io;
use std::mem::{MaybeUninit, zeroed};
use std::os::fd::{AsRawFd, BorrowedFd, FromRawFd, OwnedFd};

use super::set_option;
use station::Duration;

/// A number as the network has it, in the kernel's field for a protocol.
const EVERYTHING: u16 = (libc::ETH_P_ALL as u16).to_be();

/// What the kernel tells of an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Its number, which changes when an interface of the same name is made anew.
    pub index: i32,
    /// Whether it is switched on.
    pub up: bool,
    /// Whether something is plugged in.
    pub running: bool,
    /// Whether it carries Ethernet frames.
    pub ethernet: bool,
    /// Its MAC address.
    pub mac: [u8; 6],
}

/// A frame as the kernel hands it over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packet {
    /// How many octets of the buffer it takes, the head of [`VIRTIO_HEAD`] octets included.
    pub length: usize,
    /// When it arrived, since 1970.
    pub stamp: Option<Duration>,
    /// The tag that was taken out behind the addresses: type and content.
    pub tag: Option<(u16, u16)>,
    /// Whether this machine has sent it.
    pub outgoing: bool,
}

/// Octets in front of each frame: flags, kinds, and where a checksum is still to be filled in.
pub const VIRTIO_HEAD: usize = 10;

/// Opens a packet socket that does not block and receives nothing yet.
pub fn open() -> io::Result<OwnedFd> {
    let kind = libc::SOCK_RAW | libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK;
    // SAFETY: no memory is handed over.
    let socket = unsafe { libc::socket(libc::AF_PACKET, kind, 0) };
    if socket < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the kernel has just handed out this descriptor, nobody else owns it.
    Ok(unsafe { OwnedFd::from_raw_fd(socket) })
}

/// Asks for tags, times of arrival, and unfinished checksums; says whether each frame has a [`VIRTIO_HEAD`].
pub fn ask_for_everything(socket: BorrowedFd<'_>) -> io::Result<bool> {
    set_option(socket, libc::SOL_PACKET, libc::PACKET_AUXDATA, 1_i32)?;
    set_option(socket, libc::SOL_SOCKET, libc::SO_TIMESTAMPNS, 1_i32)?;
    // Older kernels know no such option: what is outgoing is then told frame by frame.
    let _ = set_option(socket, libc::SOL_PACKET, libc::PACKET_IGNORE_OUTGOING, 1_i32);
    let room = 4 << 20;
    if set_option(socket, libc::SOL_SOCKET, libc::SO_RCVBUFFORCE, room).is_err() {
        // Without the privilege the kernel gives as much as it allows to everybody.
        let _ = set_option(socket, libc::SOL_SOCKET, libc::SO_RCVBUF, room);
    }
    Ok(set_option(socket, libc::SOL_PACKET, libc::PACKET_VNET_HDR, 1_i32).is_ok())
}

/// Ties the socket to the interface `index` and lets it see frames for every address.
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

/// Takes one frame off the socket, or none where none is waiting.
pub fn receive(socket: BorrowedFd<'_>, buffer: &mut [u8]) -> io::Result<Option<Packet>> {
    /// Room for what comes with a frame, aligned as its heads have to be.
    #[repr(C, align(8))]
    struct Control([MaybeUninit<u8>; 128]);
    let mut control = Control([MaybeUninit::uninit(); 128]);
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
    let mut packet = Packet {
        length: length.min(buffer.len()),
        outgoing: from.sll_pkttype == libc::PACKET_OUTGOING,
        ..Packet::default()
    };
    // SAFETY: the kernel has filled in `message`, whose control buffer is still alive and as long as it says.
    let mut next = unsafe { libc::CMSG_FIRSTHDR(&raw const message) };
    while !next.is_null() {
        // SAFETY: `next` is a head inside the control buffer, as CMSG_FIRSTHDR and CMSG_NXTHDR make sure.
        let head = unsafe { std::ptr::read_unaligned(next) };
        match (head.cmsg_level, head.cmsg_type) {
            (libc::SOL_SOCKET, libc::SCM_TIMESTAMPNS) => {
                // SAFETY: `next` is such a head, and a message of this type holds a timespec.
                let stamp: libc::timespec = unsafe { content(next) };
                let seconds = u64::try_from(stamp.tv_sec).unwrap_or_default();
                packet.stamp = Some(Duration::new(seconds, u32::try_from(stamp.tv_nsec).unwrap_or_default()));
            }
            (libc::SOL_PACKET, libc::PACKET_AUXDATA) => {
                // SAFETY: `next` is such a head, and a message of this type holds a tpacket_auxdata.
                let told: libc::tpacket_auxdata = unsafe { content(next) };
                packet.tag = tag(&told);
            }
            _ => {}
        }
        // SAFETY: as for CMSG_FIRSTHDR.
        next = unsafe { libc::CMSG_NXTHDR(&raw const message, next) };
    }
    Ok(Some(packet))
}

/// What follows the head at `head`.
///
/// # Safety
/// `head` points to the head of a control message that holds a `T`.
unsafe fn content<T: Copy>(head: *const libc::cmsghdr) -> T {
    // SAFETY: the caller vouches that a `T` stands there; it need not be aligned.
    unsafe { std::ptr::read_unaligned(libc::CMSG_DATA(head).cast::<T>()) }
}

fn tag(told: &libc::tpacket_auxdata) -> Option<(u16, u16)> {
    let valid = told.tp_status & libc::TP_STATUS_VLAN_VALID != 0 || told.tp_vlan_tci != 0;
    let named = told.tp_status & libc::TP_STATUS_VLAN_TPID_VALID != 0;
    valid.then_some((if named { told.tp_vlan_tpid } else { libc::ETH_P_8021Q as u16 }, told.tp_vlan_tci))
}

/// Sends what is in `octets`; a socket tied to an interface needs no address.
pub fn send(socket: BorrowedFd<'_>, octets: &[u8]) -> io::Result<()> {
    // SAFETY: `octets` lives through the call and its length is handed over.
    let sent = unsafe {
        libc::send(socket.as_raw_fd(), octets.as_ptr().cast(), octets.len(), libc::MSG_DONTWAIT | libc::MSG_NOSIGNAL)
    };
    if sent < 0 { Err(io::Error::last_os_error()) } else { Ok(()) }
}

/// How many frames were dropped since the last call because nobody took them.
pub fn dropped(socket: BorrowedFd<'_>) -> u64 {
    // SAFETY: a structure of integers, for which zero is a value.
    let mut counts: libc::tpacket_stats = unsafe { zeroed() };
    let mut length = size_of::<libc::tpacket_stats>() as libc::socklen_t;
    // SAFETY: `counts` and `length` live through the call; the kernel writes no more than `length` octets.
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

/// What the kernel tells of the interface `name`; none where there is no such interface.
pub fn facts(socket: BorrowedFd<'_>, name: &str) -> io::Result<Option<Facts>> {
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
    let ask = |question: libc::Ioctl, request: &mut libc::ifreq| {
        // SAFETY: `request` is what these questions take, and it lives through the call.
        let result = unsafe { libc::ioctl(socket.as_raw_fd(), question, &raw mut *request) };
        if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
    };
    let mut all = || -> io::Result<Facts> {
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
        Ok(Facts {
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
