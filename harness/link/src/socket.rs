//! Ethernet frames over a stream, in the format of QEMU's `-netdev stream`: the length in four bytes, then the frame.

use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream, ToSocketAddrs};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::time::Instant;

use crate::interfaces::escaped;
use crate::lines::listen_at;
use crate::stream_frames::StreamFrames;
use crate::sys::{PollEvent, pause, set_option, wait};
use crate::{Clock, LinkError, Port, SocketAddress};
use station::{Duration, Time};

/// The size of the read buffer, in bytes.
const SCRATCH: usize = 1 << 16;
/// The size of the send queue for a slow peer, in bytes; further frames are dropped.
const WAITING: usize = 1 << 20;
/// A peer that accepts no data for this time counts as gone.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long [`FrameSocket::open`] waits for a peer to connect.
const WAIT_FOR_PEER: Duration = Duration::from_secs(30);
/// The timeout for connecting to a peer.
const CONNECT: Duration = Duration::from_secs(3);
/// The shortest timeout for connecting, even if the given time has passed.
const SHORTEST_CALL: Duration = Duration::from_millis(10);
/// How often [`Port::recover`] tries to connect.
const CALL_AGAIN: Duration = Duration::from_millis(50);
/// TCP keepalive: the first probe is sent after this many seconds of silence.
#[cfg(target_os = "linux")]
const KEEPALIVE_IDLE_S: i32 = 3;
/// TCP keepalive: seconds between probes.
#[cfg(target_os = "linux")]
const KEEPALIVE_INTERVAL_S: i32 = 1;
/// TCP keepalive: unanswered probes after which the connection counts as lost.
#[cfg(target_os = "linux")]
const KEEPALIVE_PROBES: i32 = 3;

/// A socket that carries Ethernet frames, to firmware under QEMU or to another encspec.
#[derive(Debug)]
pub struct FrameSocket {
    address: SocketAddress,
    listener: Option<SocketListener>,
    stream: Option<SocketStream>,
    /// The read buffer.
    scratch: Box<[u8]>,
    input: StreamFrames,
    read_at: Instant,
    output: Vec<u8>,
    /// How many bytes of `output` have been sent.
    written: usize,
    blocked_since: Option<Instant>,
    lost: u64,
}

impl FrameSocket {
    /// Connects to the peer, or listens and waits up to 30 s for it to connect.
    pub fn open(address: &SocketAddress) -> Result<FrameSocket, LinkError> {
        let mut socket = FrameSocket::bind(address)?;
        if socket.stream.is_none() {
            let clock = Clock::start();
            socket
                .recover(&clock, clock.now() + WAIT_FOR_PEER)
                .map_err(|error| LinkError::Unusable(error.to_string()))?;
        }
        Ok(socket)
    }

    /// Like [`open`](Self::open), but does not wait for the peer to connect: until it does, all calls fail with
    /// [`LinkError::Gone`], and [`Port::recover`] waits for it.
    pub fn bind(address: &SocketAddress) -> Result<FrameSocket, LinkError> {
        let (address, listener) = SocketListener::bind(address)?;
        let mut socket = FrameSocket {
            address,
            listener,
            stream: None,
            scratch: vec![0; SCRATCH].into_boxed_slice(),
            input: StreamFrames::default(),
            read_at: Instant::now(),
            output: Vec::new(),
            written: 0,
            blocked_since: None,
            lost: 0,
        };
        if socket.listener.is_none() {
            let stream = SocketStream::connect(&socket.address, CONNECT).map_err(|error| {
                LinkError::Unusable(format!(
                    "cannot connect to {}: {error}; start the peer first, or wait for it with the prefix listen:",
                    socket.describe()
                ))
            })?;
            socket.stream = Some(stream);
        }
        Ok(socket)
    }

    /// The address of the socket; with the actual port if any free port was requested.
    pub fn address(&self) -> &SocketAddress {
        &self.address
    }

    fn gone(&mut self, why: &str) -> LinkError {
        self.stream = None;
        LinkError::Gone(format!("the peer at {} is gone: {why}; start it again", self.describe()))
    }

    fn adopt(&mut self, stream: SocketStream) {
        self.stream = Some(stream);
        self.input.clear();
        self.output.clear();
        self.written = 0;
        self.blocked_since = None;
    }

    /// Reads the data that has arrived; returns false if there is none.
    fn fill(&mut self) -> Result<bool, LinkError> {
        let Some(stream) = &mut self.stream else { return Err(self.gone("no peer is connected")) };
        match stream.read(&mut self.scratch) {
            Ok(0) if self.input.is_in_frame() => Err(self.gone("it closed the connection in the middle of a frame")),
            Ok(0) => Err(self.gone("it closed the connection")),
            Ok(count) => {
                self.input.push(&self.scratch[..count]);
                self.read_at = Instant::now();
                Ok(true)
            }
            Err(error) if nothing_now(&error) => Ok(false),
            Err(error) => Err(self.gone(&error.to_string())),
        }
    }

    /// Writes as much of the send queue as the peer accepts now.
    fn flush(&mut self) -> Result<(), LinkError> {
        while self.written < self.output.len() {
            let Some(stream) = &mut self.stream else { return Err(self.gone("no peer is connected")) };
            match stream.write(&self.output[self.written..]) {
                Ok(0) => return Err(self.gone("it accepts no more data")),
                Ok(count) => {
                    self.written += count;
                    self.blocked_since = None;
                }
                Err(error) if nothing_now(&error) => {
                    let since = *self.blocked_since.get_or_insert_with(Instant::now);
                    if since.elapsed() > PATIENCE {
                        return Err(self.gone(&format!("it has accepted no data for {} s", PATIENCE.as_secs())));
                    }
                    return Ok(());
                }
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
        self.output.clear();
        self.written = 0;
        Ok(())
    }
}

/// Whether a non-blocking call has nothing to do now, which is no error.
fn nothing_now(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

impl Port for FrameSocket {
    fn ends_on_this_host(&self) -> bool {
        match &self.stream {
            Some(SocketStream::Unix(_)) => true,
            Some(SocketStream::Tcp(stream)) => stream.peer_addr().is_ok_and(|peer| peer.ip().is_loopback()),
            None => false,
        }
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), LinkError> {
        if self.stream.is_none() {
            return Err(self.gone("no peer is connected"));
        }
        self.flush()?;
        let Some(length) = u32::try_from(frame.len()).ok().filter(|_| self.output.len() - self.written < WAITING)
        else {
            self.lost += 1;
            return Ok(());
        };
        self.output.extend_from_slice(&length.to_be_bytes());
        self.output.extend_from_slice(frame);
        self.flush()
    }

    fn receive(&mut self, clock: &Clock, until: Time, into: &mut Vec<u8>) -> Result<Option<Time>, LinkError> {
        loop {
            match self.input.next(into) {
                Ok(true) => return Ok(Some(clock.at(self.read_at))),
                Ok(false) => {}
                Err(why) => return Err(self.gone(&why.to_string())),
            }
            self.flush()?;
            if self.fill()? {
                continue;
            }
            if clock.remaining(until).is_zero() {
                return Ok(None);
            }
            let events = if self.written < self.output.len() { PollEvent::Both } else { PollEvent::Reading };
            let Some(stream) = &self.stream else { return Err(self.gone("no peer is connected")) };
            if let Err(error) = wait(stream.as_fd(), events, clock, until) {
                return Err(self.gone(&error.to_string()));
            }
        }
    }

    fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        self.stream = None;
        loop {
            let made = match &self.listener {
                Some(listener) => listener.accept(clock, until),
                None => SocketStream::connect(&self.address, clock.remaining(until).clamp(SHORTEST_CALL, CONNECT)),
            };
            let why = match made {
                Ok(stream) => {
                    self.adopt(stream);
                    return Ok(());
                }
                Err(error) if nothing_now(&error) => "no peer has connected".to_string(),
                Err(error) => error.to_string(),
            };
            if clock.remaining(until).is_zero() {
                return Err(LinkError::Gone(format!("no peer at {}: {why}; start it", self.describe())));
            }
            if self.listener.is_none() {
                pause(clock, until.min(clock.now() + CALL_AGAIN));
            }
        }
    }

    fn mac(&self) -> Option<[u8; 6]> {
        None
    }

    fn describe(&self) -> String {
        format!("the socket {}", escaped(&self.address.to_string()))
    }

    fn carrier(&self) -> bool {
        self.stream.is_some()
    }

    fn lost(&mut self) -> u64 {
        self.lost
    }
}

#[derive(Debug)]
enum SocketStream {
    Tcp(TcpStream),
    Unix(UnixStream),
}

impl SocketStream {
    fn connect(address: &SocketAddress, timeout: Duration) -> io::Result<SocketStream> {
        let stream = match address {
            SocketAddress::Tcp(host) | SocketAddress::ListenTcp(host) => {
                let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
                let mut found = None;
                for target in host.to_socket_addrs()? {
                    match TcpStream::connect_timeout(&target, timeout) {
                        Ok(stream) => {
                            found = Some(stream);
                            break;
                        }
                        Err(error) => last = error,
                    }
                }
                SocketStream::Tcp(found.ok_or(last)?)
            }
            SocketAddress::Unix(path) | SocketAddress::ListenUnix(path) => {
                SocketStream::Unix(UnixStream::connect(path)?)
            }
        };
        stream.prepare()?;
        Ok(stream)
    }

    /// Makes the stream non-blocking, disables Nagle's algorithm, and enables keepalive.
    fn prepare(&self) -> io::Result<()> {
        match self {
            SocketStream::Tcp(stream) => {
                stream.set_nonblocking(true)?;
                stream.set_nodelay(true)?;
                notice_silence(stream.as_fd())
            }
            SocketStream::Unix(stream) => stream.set_nonblocking(true),
        }
    }

    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            SocketStream::Tcp(stream) => stream.as_fd(),
            SocketStream::Unix(stream) => stream.as_fd(),
        }
    }

    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            SocketStream::Tcp(stream) => stream.read(into),
            SocketStream::Unix(stream) => stream.read(into),
        }
    }

    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        match self {
            SocketStream::Tcp(stream) => stream.write(octets),
            SocketStream::Unix(stream) => stream.write(octets),
        }
    }
}

/// Enables TCP keepalive: a peer that does not respond for about 6 s counts as lost.
fn notice_silence(socket: BorrowedFd<'_>) -> io::Result<()> {
    set_option(socket, libc::SOL_SOCKET, libc::SO_KEEPALIVE, 1_i32)?;
    #[cfg(target_os = "linux")]
    for (option, value) in [
        (libc::TCP_KEEPIDLE, KEEPALIVE_IDLE_S),
        (libc::TCP_KEEPINTVL, KEEPALIVE_INTERVAL_S),
        (libc::TCP_KEEPCNT, KEEPALIVE_PROBES),
        (libc::TCP_USER_TIMEOUT, PATIENCE.as_millis() as i32),
    ] {
        set_option(socket, libc::IPPROTO_TCP, option, value)?;
    }
    Ok(())
}

#[derive(Debug)]
enum SocketListener {
    Tcp(TcpListener),
    Unix(UnixListener, PathBuf),
}

impl SocketListener {
    /// Listens if `address` is one to listen on; the returned address has the actual port.
    fn bind(address: &SocketAddress) -> Result<(SocketAddress, Option<SocketListener>), LinkError> {
        match address {
            SocketAddress::ListenTcp(target) => {
                let unusable = |error: io::Error| {
                    LinkError::Unusable(format!("cannot listen at {}: {error}; choose another port", escaped(target)))
                };
                let listener = TcpListener::bind(target).map_err(unusable)?;
                listener.set_nonblocking(true).map_err(unusable)?;
                let port = listener.local_addr().map_err(unusable)?.port();
                let host = target.rsplit_once(':').map_or(target.as_str(), |(host, _)| host);
                Ok((SocketAddress::ListenTcp(format!("{host}:{port}")), Some(SocketListener::Tcp(listener))))
            }
            SocketAddress::ListenUnix(path) => {
                Ok((address.clone(), Some(SocketListener::Unix(listen_at(path)?, path.to_owned()))))
            }
            SocketAddress::Tcp(_) | SocketAddress::Unix(_) => Ok((address.clone(), None)),
        }
    }

    /// Waits for a peer to connect until `clock` shows `until`.
    fn accept(&self, clock: &Clock, until: Time) -> io::Result<SocketStream> {
        let socket = match self {
            SocketListener::Tcp(listener) => listener.as_fd(),
            SocketListener::Unix(listener, _) => listener.as_fd(),
        };
        wait(socket, PollEvent::Reading, clock, until)?;
        let stream = match self {
            SocketListener::Tcp(listener) => SocketStream::Tcp(listener.accept()?.0),
            SocketListener::Unix(listener, _) => SocketStream::Unix(listener.accept()?.0),
        };
        stream.prepare()?;
        Ok(stream)
    }
}

impl Drop for SocketListener {
    fn drop(&mut self) {
        if let SocketListener::Unix(_, path) = self {
            // The file may have been removed already.
            let _ = std::fs::remove_file(path);
        }
    }
}
