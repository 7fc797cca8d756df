//! Requests to web servers that answer, refuse, delay or send without end. Server and client both use the TCP of smoltcp; a test
//! on real interfaces uses an independent server.

use crate::common::{DEVICE, DEVICE_IP, Rig};
use core::time::Duration;
use encspec_controllers::profinet_io::{LONGEST_ANSWER, Outcome, PageOutcome, Partner, Request};
use rstest::rstest;
use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet};
use smoltcp::phy::{self, DeviceCapabilities, Medium};
use smoltcp::socket::tcp::{Socket, SocketBuffer};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpCidr, Ipv4Cidr};
use station::{Outbox, Station, Time};
use std::collections::VecDeque;
use wire::http::{self, Response};

/// How a server handles a connection.
#[derive(Clone, Copy, PartialEq)]
enum Manner {
    /// Sends this and closes.
    Answers(&'static str),
    /// Sends this and leaves the connection open.
    Stays(&'static str),
    /// Sends this and, once it has arrived, resets the connection.
    Tears(&'static str),
    /// Sends this repeatedly without an end.
    Babbles(&'static str),
    /// Accepts no connections.
    Refuses,
    /// Is absent.
    Absent,
}

struct Server {
    manner: Manner,
    pipe: Pipe,
    interface: Interface,
    sockets: SocketSet<'static>,
    socket: SocketHandle,
    said: usize,
    request: Vec<u8>,
    due: Option<Time>,
}

impl Server {
    fn new(manner: Manner) -> Server {
        let mut pipe = Pipe::default();
        let mut interface = Interface::new(Config::new(EthernetAddress(DEVICE.0).into()), &mut pipe, Instant::ZERO);
        interface.update_ip_addrs(|list| {
            list.push(IpCidr::Ipv4(Ipv4Cidr::new(DEVICE_IP, 24))).expect("the list has a free entry")
        });
        let buffer = || SocketBuffer::new(vec![0; 4096]);
        let mut socket = Socket::new(buffer(), buffer());
        if manner != Manner::Refuses {
            socket.listen(http::PORT).expect("the socket is new");
        }
        let mut sockets = SocketSet::new(Vec::new());
        let socket = sockets.add(socket);
        Server { manner, pipe, interface, sockets, socket, said: 0, request: Vec::new(), due: None }
    }

    fn poll(&mut self, now: Time, out: &mut Outbox) {
        if self.manner == Manner::Absent {
            return;
        }
        let instant = Instant::from_micros((now.as_nanos() / 1000) as i64);
        self.interface.poll(instant, &mut self.pipe, &mut self.sockets);
        let socket = self.sockets.get_mut::<Socket<'_>>(self.socket);
        while socket.can_recv() {
            let request = &mut self.request;
            socket.recv(|octets| (octets.len(), request.extend_from_slice(octets))).expect("there is something");
        }
        if !self.request.is_empty() && socket.may_send() {
            match self.manner {
                Manner::Babbles(text) => while socket.send_slice(text.as_bytes()).is_ok_and(|sent| sent > 0) {},
                Manner::Answers(text) | Manner::Stays(text) | Manner::Tears(text) => {
                    let arrived = self.said == text.len() && socket.send_queue() == 0;
                    self.said += socket.send_slice(&text.as_bytes()[self.said..]).unwrap_or(0);
                    match self.manner {
                        Manner::Answers(_) if self.said == text.len() => socket.close(),
                        Manner::Tears(_) if arrived => socket.abort(),
                        _ => {}
                    }
                }
                Manner::Refuses | Manner::Absent => {}
            }
        }
        self.interface.poll(instant, &mut self.pipe, &mut self.sockets);
        self.pipe.outgoing.drain(..).for_each(|frame| out.push(&frame));
        let due = self.interface.poll_at(instant, &self.sockets);
        let soonest = now + Duration::from_micros(1);
        self.due = due.map(|due| soonest.max(Time::ZERO + Duration::from_micros(due.total_micros() as u64)));
    }
}

impl Station for Server {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.pipe.incoming = Some(frame.to_vec());
        self.poll(now, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.poll(now, out);
    }

    fn deadline(&self) -> Option<Time> {
        self.due
    }
}

#[derive(Default)]
struct Pipe {
    incoming: Option<Vec<u8>>,
    outgoing: VecDeque<Vec<u8>>,
}

struct Incoming(Vec<u8>);
struct Outgoing<'a>(&'a mut VecDeque<Vec<u8>>);

impl phy::Device for Pipe {
    type RxToken<'a> = Incoming;
    type TxToken<'a> = Outgoing<'a>;

    fn receive(&mut self, _: Instant) -> Option<(Incoming, Outgoing<'_>)> {
        Some((Incoming(self.incoming.take()?), Outgoing(&mut self.outgoing)))
    }

    fn transmit(&mut self, _: Instant) -> Option<Outgoing<'_>> {
        Some(Outgoing(&mut self.outgoing))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        (capabilities.medium, capabilities.max_transmission_unit) = (Medium::Ethernet, 1514);
        capabilities
    }
}

impl phy::RxToken for Incoming {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, take: F) -> R {
        take(&self.0)
    }
}

impl phy::TxToken for Outgoing<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let mut frame = vec![0; length];
        let result = fill(&mut frame);
        self.0.push_back(frame);
        result
    }
}

fn visit(rig: &mut Rig<Server>, request: http::Request) -> PageOutcome {
    let partner = Partner { mac: DEVICE, ip: DEVICE_IP };
    match rig.ask(Request::Page { partner, request }) {
        Outcome::Page(outcome) => outcome,
        other => panic!("expected the outcome of a page: {other:?}"),
    }
}

const WHOLE: &str = "HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\n4711";
const UNTIL_CLOSE: &str = "HTTP/1.0 200 OK\r\n\r\n4711";
const CUT: &str = "HTTP/1.1 200 OK\r\nContent-Length: 40\r\n\r\n4711";

#[rstest]
#[case::with_its_length(Manner::Answers(WHOLE), Ok(()))]
#[case::connection_left_open(Manner::Stays(WHOLE), Ok(()))]
#[case::until_the_end(Manner::Answers(UNTIL_CLOSE), Ok(()))]
#[case::without_an_end(Manner::Stays(UNTIL_CLOSE), Err("did not end in time"))]
#[case::cut(Manner::Answers(CUT), Err("closed before its end"))]
#[case::torn_off(Manner::Tears(UNTIL_CLOSE), Err("reset before its end"))]
#[case::too_long(Manner::Babbles("HTTP/1.1 200 OK\r\n\r\n..."), Err("longer than 65536 bytes"))]
#[case::no_http(Manner::Babbles("what is this?\r\n\r\n"), Err("not that of an answer"))]
#[case::refused(Manner::Refuses, Err("refused"))]
#[case::without_a_word(Manner::Answers(""), Err("refused"))]
#[case::silent(Manner::Stays(""), Err("did not come within 10s"))]
#[case::absent(Manner::Absent, Err("did not come within 10s"))]
fn every_visit_ends(#[case] manner: Manner, #[case] ends: Result<(), &str>) {
    let mut rig = Rig::with(Server::new(manner));
    let outcome = visit(&mut rig, http::Request::get("/"));
    match ends {
        Ok(()) => assert_eq!(outcome, PageOutcome::Answer(Response::page(200, "4711"))),
        Err(why) => assert!(outcome.to_string().contains(why), "{outcome}"),
    }
    assert!(rig.now <= Time::ZERO + Duration::from_secs(11), "{:?}", rig.now);
    let octets: usize =
        rig.log.iter().filter(|(_, from_controller, _)| !from_controller).map(|(.., frame)| frame.len()).sum();
    assert!(octets < 2 * LONGEST_ANSWER, "{octets} bytes arrived");
    // The connection has no work left.
    rig.run(Duration::from_secs(120));
    let now = rig.now;
    assert!(rig.sent().all(|(time, _)| time + Duration::from_secs(60) < now));
}

#[test]
fn nothing_is_sent_to_a_server_without_an_address() {
    let mut rig = Rig::with(Server::new(Manner::Answers(WHOLE)));
    let partner = Partner { mac: DEVICE, ip: core::net::Ipv4Addr::UNSPECIFIED };
    let outcome = rig.ask(Request::Page { partner, request: http::Request::get("/") });
    assert!(
        matches!(outcome, Outcome::Page(PageOutcome::Unreadable(_))),
        "silence must not count as an answer: {outcome:?}"
    );
}

#[test]
fn a_form_is_sent_as_it_is_entered() {
    let mut rig = Rig::with(Server::new(Manner::Answers(WHOLE)));
    visit(&mut rig, http::Request::post("/preset.htm", &[("value", "1000")]));
    let http::Progress::Whole(request) = http::Request::read(&rig.device.request) else { panic!("a whole request") };
    assert_eq!((request.method.as_str(), request.path.as_str()), ("POST", "/preset.htm"));
    assert_eq!(request.field("value").as_deref(), Some("1000"));
}
