//! Requests to web servers that answer, refuse, delay or send without end. Server and client both use the TCP of smoltcp; a test
//! on real interfaces uses an independent server.

use crate::common::{ControllerRig, DEVICE, DEVICE_IP};
use core::time::Duration;
use encspec_controllers::profinet_io::{ControllerOutcome, ControllerRequest, LONGEST_ANSWER, PageOutcome, Partner};
use rstest::rstest;
use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet};
use smoltcp::phy::{self, DeviceCapabilities, Medium};
use smoltcp::socket::tcp::{Socket, SocketBuffer};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpCidr, Ipv4Cidr};
use station::{Outbox, Station, Time};
use std::collections::VecDeque;
use wire::http::{self, HttpResponse};

/// How a server handles a connection.
#[derive(Clone, Copy, PartialEq)]
enum WebServerBehaviour {
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

struct ScriptedWebServer {
    behaviour: WebServerBehaviour,
    pipe: WebServerPipe,
    interface: Interface,
    sockets: SocketSet<'static>,
    socket: SocketHandle,
    sent: usize,
    request: Vec<u8>,
    due: Option<Time>,
}

impl ScriptedWebServer {
    fn new(behaviour: WebServerBehaviour) -> ScriptedWebServer {
        let mut pipe = WebServerPipe::default();
        let mut interface = Interface::new(Config::new(EthernetAddress(DEVICE.0).into()), &mut pipe, Instant::ZERO);
        interface.update_ip_addrs(|list| {
            list.push(IpCidr::Ipv4(Ipv4Cidr::new(DEVICE_IP, 24))).expect("the list has a free entry")
        });
        let buffer = || SocketBuffer::new(vec![0; 4096]);
        let mut socket = Socket::new(buffer(), buffer());
        if behaviour != WebServerBehaviour::Refuses {
            socket.listen(http::PORT).expect("the socket is new");
        }
        let mut sockets = SocketSet::new(Vec::new());
        let socket = sockets.add(socket);
        ScriptedWebServer { behaviour, pipe, interface, sockets, socket, sent: 0, request: Vec::new(), due: None }
    }

    fn poll(&mut self, now: Time, out: &mut Outbox) {
        if self.behaviour == WebServerBehaviour::Absent {
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
            match self.behaviour {
                WebServerBehaviour::Babbles(text) => {
                    while socket.send_slice(text.as_bytes()).is_ok_and(|sent| sent > 0) {}
                }
                WebServerBehaviour::Answers(text)
                | WebServerBehaviour::Stays(text)
                | WebServerBehaviour::Tears(text) => {
                    let arrived = self.sent == text.len() && socket.send_queue() == 0;
                    self.sent += socket.send_slice(&text.as_bytes()[self.sent..]).unwrap_or(0);
                    match self.behaviour {
                        WebServerBehaviour::Answers(_) if self.sent == text.len() => socket.close(),
                        WebServerBehaviour::Tears(_) if arrived => socket.abort(),
                        _ => {}
                    }
                }
                WebServerBehaviour::Refuses | WebServerBehaviour::Absent => {}
            }
        }
        self.interface.poll(instant, &mut self.pipe, &mut self.sockets);
        self.pipe.outgoing.drain(..).for_each(|frame| out.push(&frame));
        let due = self.interface.poll_at(instant, &self.sockets);
        let soonest = now + Duration::from_micros(1);
        self.due = due.map(|due| soonest.max(Time::ZERO + Duration::from_micros(due.total_micros() as u64)));
    }
}

impl Station for ScriptedWebServer {
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
struct WebServerPipe {
    incoming: Option<Vec<u8>>,
    outgoing: VecDeque<Vec<u8>>,
}

struct WebServerPipeRx(Vec<u8>);
struct WebServerPipeTx<'a>(&'a mut VecDeque<Vec<u8>>);

impl phy::Device for WebServerPipe {
    type RxToken<'a> = WebServerPipeRx;
    type TxToken<'a> = WebServerPipeTx<'a>;

    fn receive(&mut self, _: Instant) -> Option<(WebServerPipeRx, WebServerPipeTx<'_>)> {
        Some((WebServerPipeRx(self.incoming.take()?), WebServerPipeTx(&mut self.outgoing)))
    }

    fn transmit(&mut self, _: Instant) -> Option<WebServerPipeTx<'_>> {
        Some(WebServerPipeTx(&mut self.outgoing))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        (capabilities.medium, capabilities.max_transmission_unit) = (Medium::Ethernet, 1514);
        capabilities
    }
}

impl phy::RxToken for WebServerPipeRx {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, take: F) -> R {
        take(&self.0)
    }
}

impl phy::TxToken for WebServerPipeTx<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let mut frame = vec![0; length];
        let result = fill(&mut frame);
        self.0.push_back(frame);
        result
    }
}

fn visit(rig: &mut ControllerRig<ScriptedWebServer>, request: http::HttpRequest) -> PageOutcome {
    let partner = Partner { mac: DEVICE, ip: DEVICE_IP };
    match rig.ask(ControllerRequest::Page { partner, request }) {
        ControllerOutcome::Page(outcome) => outcome,
        other => panic!("expected the outcome of a page: {other:?}"),
    }
}

const WHOLE: &str = "HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\n4711";
const UNTIL_CLOSE: &str = "HTTP/1.0 200 OK\r\n\r\n4711";
const CUT: &str = "HTTP/1.1 200 OK\r\nContent-Length: 40\r\n\r\n4711";

#[rstest]
#[case::with_its_length(WebServerBehaviour::Answers(WHOLE), Ok(()))]
#[case::connection_left_open(WebServerBehaviour::Stays(WHOLE), Ok(()))]
#[case::until_the_end(WebServerBehaviour::Answers(UNTIL_CLOSE), Ok(()))]
#[case::without_an_end(WebServerBehaviour::Stays(UNTIL_CLOSE), Err("did not end in time"))]
#[case::cut(WebServerBehaviour::Answers(CUT), Err("closed before its end"))]
#[case::torn_off(WebServerBehaviour::Tears(UNTIL_CLOSE), Err("reset before its end"))]
#[case::too_long(WebServerBehaviour::Babbles("HTTP/1.1 200 OK\r\n\r\n..."), Err("longer than 65536 bytes"))]
#[case::no_http(WebServerBehaviour::Babbles("what is this?\r\n\r\n"), Err("not that of an HTTP/1 response"))]
#[case::refused(WebServerBehaviour::Refuses, Err("refused"))]
#[case::without_a_word(WebServerBehaviour::Answers(""), Err("refused"))]
#[case::silent(WebServerBehaviour::Stays(""), Err("did not come within 10s"))]
#[case::absent(WebServerBehaviour::Absent, Err("did not come within 10s"))]
fn every_visit_ends(#[case] behaviour: WebServerBehaviour, #[case] ends: Result<(), &str>) {
    let mut rig = ControllerRig::with(ScriptedWebServer::new(behaviour));
    let outcome = visit(&mut rig, http::HttpRequest::get("/"));
    match ends {
        Ok(()) => assert_eq!(outcome, PageOutcome::Answer(HttpResponse::page(200, "4711"))),
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
    let mut rig = ControllerRig::with(ScriptedWebServer::new(WebServerBehaviour::Answers(WHOLE)));
    let partner = Partner { mac: DEVICE, ip: core::net::Ipv4Addr::UNSPECIFIED };
    let outcome = rig.ask(ControllerRequest::Page { partner, request: http::HttpRequest::get("/") });
    assert!(
        matches!(outcome, ControllerOutcome::Page(PageOutcome::Unreadable(_))),
        "silence must not count as an answer: {outcome:?}"
    );
}

#[test]
fn a_form_is_sent_as_it_is_entered() {
    let mut rig = ControllerRig::with(ScriptedWebServer::new(WebServerBehaviour::Answers(WHOLE)));
    visit(&mut rig, http::HttpRequest::post("/preset.htm", &[("value", "1000")]));
    let http::ParseProgress::Whole(request) = http::HttpRequest::read(&rig.device.request) else {
        panic!("a whole request")
    };
    assert_eq!((request.method.as_str(), request.path.as_str()), ("POST", "/preset.htm"));
    assert_eq!(request.field("value").as_deref(), Some("1000"));
}
