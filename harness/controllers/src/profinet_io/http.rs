//! HTTP client: one TCP connection for one request and its answer, with smoltcp over a pipe of frames.
//!
//! Whatever the server does, the visit ends: after [`LONGEST_VISIT`], after [`LONGEST_ANSWER`] bytes, or before. This module must
//! not know the content of a page.

use super::request::{ControllerSettings, Partner};
use super::state::{AwaitedEvent, Wait};
use alloc::collections::VecDeque;
use alloc::string::ToString;
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;
use core::time::Duration;
use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet};
use smoltcp::phy::{self, DeviceCapabilities, Medium};
use smoltcp::socket::tcp::{Socket, SocketBuffer, State};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpCidr, Ipv4Cidr};
use station::{Outbox, Time};
use wire::ethernet::{FrameHeader, Mac, pad};
use wire::http::{HttpRequest, HttpResponse, PORT, ParseProgress};

/// Maximum duration of a visit.
const LONGEST_VISIT: Duration = Duration::from_secs(10);
/// Maximum length of an answer in bytes, including its head.
pub const LONGEST_ANSWER: usize = 1 << 16;
/// The network prefix length of the controller: every address counts as local.
const PREFIX_LENGTH: u8 = 0;
/// The resolution of smoltcp's clock: the next poll is at least this far ahead.
const SMOLTCP_TICK: Duration = Duration::from_micros(1);
/// TCP receive window in bytes.
const WINDOW: usize = 8192;
/// The first TCP port of the client, and the number of ports. Each visit uses the next one, with a random start, because a server
/// keeps the port of a closed connection for some minutes.
const PORTS: (u16, u16) = (49_152, 16_384);

/// The outcome of a visit to a web server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PageOutcome {
    /// The answer.
    Answer(HttpResponse),
    /// The server refused the connection, or closed it without an answer.
    Refused,
    /// No answer in time.
    NoAnswer(Wait),
    /// The answer is incomplete or invalid; the sentence says why.
    Unreadable(&'static str),
}

impl fmt::Display for PageOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PageOutcome::Answer(response) => write!(f, "HTTP status {}", response.status),
            PageOutcome::Refused => f.write_str("the connection was refused"),
            PageOutcome::NoAnswer(wait) => wait.fmt(f),
            PageOutcome::Unreadable(why) => write!(f, "the answer cannot be read: {why}"),
        }
    }
}

/// The client end of the connections to web servers, one at a time.
pub(super) struct Browser {
    pipe: BrowserPipe,
    interface: Interface,
    sockets: SocketSet<'static>,
    /// The connection of the current visit, or what remains of the last one.
    socket: Option<SocketHandle>,
    visit: Option<Visit>,
    /// The destination of all frames.
    server: Mac,
    visits: u16,
    due: Option<Time>,
}

/// A visit that has not ended.
#[derive(Debug)]
struct Visit {
    request: Vec<u8>,
    /// Whether there is an address to call; nothing is sent without one.
    is_addressed: bool,
    request_sent: bool,
    came: Vec<u8>,
    began: Time,
}

/// A number that depends on all bits of the seed.
fn hash_seed(seed: u64) -> u16 {
    (seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 48) as u16
}

impl Browser {
    pub(super) fn new(now: Time, settings: &ControllerSettings) -> Browser {
        let mut pipe = BrowserPipe::default();
        let mut config = Config::new(EthernetAddress(settings.mac.0).into());
        config.random_seed = settings.seed;
        let mut interface = Interface::new(config, &mut pipe, instant(now));
        interface.update_ip_addrs(|addresses| {
            // The list has room for at least one address and is empty.
            addresses.push(IpCidr::Ipv4(Ipv4Cidr::new(settings.ip, PREFIX_LENGTH))).ok();
        });
        let sockets = SocketSet::new(Vec::new());
        Browser {
            pipe,
            interface,
            sockets,
            socket: None,
            visit: None,
            server: Mac([0; 6]),
            visits: hash_seed(settings.seed),
            due: None,
        }
    }

    /// Begins a visit; discards what remains of the previous one.
    pub(super) fn visit(&mut self, now: Time, partner: Partner, request: &HttpRequest, out: &mut Outbox) {
        self.forget();
        let request = request.to_vec(&partner.ip.to_string());
        let buffer = |octets: usize| SocketBuffer::new(vec![0; octets]);
        let mut socket = Socket::new(buffer(WINDOW), buffer(request.len()));
        socket.set_ack_delay(None);
        socket.set_nagle_enabled(false);
        let port = PORTS.0 + self.visits % PORTS.1;
        self.visits = self.visits.wrapping_add(1);
        let is_addressed = socket.connect(self.interface.context(), (partner.ip, PORT), port).is_ok();
        self.socket = Some(self.sockets.add(socket));
        self.server = partner.mac;
        self.visit = Some(Visit { request, is_addressed, request_sent: false, came: Vec::new(), began: now });
        self.poll(now, None, out);
    }

    fn forget(&mut self) {
        if let Some(old) = self.socket.take() {
            self.sockets.remove(old);
        }
    }

    /// When something must be done without a frame.
    pub(super) fn due(&self) -> Option<Time> {
        let longest = |visit: &Visit| if visit.is_addressed { LONGEST_VISIT } else { Duration::ZERO };
        let end = self.visit.as_ref().map(|visit| visit.began + longest(visit));
        [self.due, end].into_iter().flatten().min()
    }

    /// Processes a frame, if there is one, and does what is due; returns the outcome at the end of the visit.
    pub(super) fn go_on(
        &mut self,
        now: Time,
        frame: Option<(&FrameHeader, &[u8])>,
        out: &mut Outbox,
    ) -> Option<PageOutcome> {
        self.poll(now, frame, out);
        let socket = self.sockets.get_mut::<Socket<'_>>(self.socket?);
        let outcome = self.visit.as_mut()?.go_on(now, socket);
        let has_failed = matches!(&outcome, Some(outcome) if !matches!(outcome, PageOutcome::Answer(_)));
        if outcome.is_some() {
            self.visit = None;
            if has_failed { socket.abort() } else { socket.close() }
        }
        // Sends what was just written, or the end of the connection.
        self.poll(now, None, out);
        if has_failed {
            self.forget();
            self.poll(now, None, out);
        }
        outcome
    }

    fn poll(&mut self, now: Time, frame: Option<(&FrameHeader, &[u8])>, out: &mut Outbox) {
        self.pipe.incoming = frame.map(|(header, payload)| {
            let mut frame = Vec::with_capacity(FrameHeader::UNTAGGED_LENGTH + payload.len());
            FrameHeader { tag: None, inner_tag: None, ..*header }.write(&mut frame);
            frame.extend_from_slice(payload);
            frame
        });
        self.interface.poll(instant(now), &mut self.pipe, &mut self.sockets);
        let to = |frame: &[u8], mac: Mac| frame.starts_with(&mac.0);
        for frame in self.pipe.outgoing.drain(..) {
            if to(&frame, self.server) || to(&frame, Mac::BROADCAST) {
                out.push_with(|buffer| {
                    let start = buffer.len();
                    buffer.extend_from_slice(&frame);
                    pad(buffer, start);
                });
            }
        }
        let due = self.interface.poll_at(instant(now), &self.sockets);
        let soonest = now + SMOLTCP_TICK;
        self.due = due.map(|due| soonest.max(Time::ZERO + Duration::from_micros(due.total_micros().unsigned_abs())));
    }
}

impl fmt::Debug for Browser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Browser").field("visit", &self.visit).finish_non_exhaustive()
    }
}

impl Visit {
    fn go_on(&mut self, now: Time, socket: &mut Socket<'_>) -> Option<PageOutcome> {
        if !self.is_addressed {
            // Nothing was sent, so silence is not an answer.
            return Some(PageOutcome::Unreadable("the device has no IP address"));
        }
        if !self.request_sent && socket.may_send() {
            self.request_sent = socket.send_slice(&self.request).is_ok();
        }
        while socket.can_recv() {
            let came = &mut self.came;
            let taken = socket.recv(|octets| {
                came.extend_from_slice(octets);
                (octets.len(), ())
            });
            if taken.is_err() {
                break;
            }
        }
        if self.came.len() > LONGEST_ANSWER {
            return Some(PageOutcome::Unreadable("it is longer than 65536 bytes"));
        }
        let is_closed = if self.request_sent { !socket.may_recv() } else { !socket.is_open() };
        if is_closed && self.came.is_empty() {
            return Some(PageOutcome::Refused);
        }
        // An aborted answer is incomplete, even if the end of the connection marks its end.
        let is_torn = is_closed && socket.state() == State::Closed;
        if is_torn && HttpResponse::read(&self.came, false) == ParseProgress::More {
            return Some(PageOutcome::Unreadable("the connection was reset before its end"));
        }
        match HttpResponse::read(&self.came, is_closed) {
            ParseProgress::Whole(response) => Some(PageOutcome::Answer(response)),
            ParseProgress::Bad(why) => Some(PageOutcome::Unreadable(why)),
            ParseProgress::More if now < self.began + LONGEST_VISIT => None,
            ParseProgress::More if self.came.is_empty() => {
                Some(PageOutcome::NoAnswer(Wait { what: AwaitedEvent::Page, time: LONGEST_VISIT }))
            }
            ParseProgress::More => Some(PageOutcome::Unreadable("it did not end in time")),
        }
    }
}

fn instant(time: Time) -> Instant {
    Instant::from_micros(i64::try_from(time.as_nanos() / 1000).unwrap_or(i64::MAX))
}

/// A pair of queues: one frame in, any number of frames out.
#[derive(Debug, Default)]
struct BrowserPipe {
    incoming: Option<Vec<u8>>,
    outgoing: VecDeque<Vec<u8>>,
}

impl phy::Device for BrowserPipe {
    type RxToken<'a> = BrowserPipeRx;
    type TxToken<'a> = BrowserPipeTx<'a>;

    fn receive(&mut self, _: Instant) -> Option<(BrowserPipeRx, BrowserPipeTx<'_>)> {
        Some((BrowserPipeRx(self.incoming.take()?), BrowserPipeTx(&mut self.outgoing)))
    }

    fn transmit(&mut self, _: Instant) -> Option<BrowserPipeTx<'_>> {
        Some(BrowserPipeTx(&mut self.outgoing))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = 1514;
        capabilities
    }
}

struct BrowserPipeRx(Vec<u8>);

impl phy::RxToken for BrowserPipeRx {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, take: F) -> R {
        take(&self.0)
    }
}

struct BrowserPipeTx<'a>(&'a mut VecDeque<Vec<u8>>);

impl phy::TxToken for BrowserPipeTx<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let mut frame = vec![0; length];
        let result = fill(&mut frame);
        self.0.push_back(frame);
        result
    }
}
