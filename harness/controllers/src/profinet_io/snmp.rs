//! SNMP requests to a device, and the first response to each.

use super::call::send;
use super::context::ControllerContext;
use super::jobs::ControllerJob;
use super::request::Partner;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::Datagram;
use wire::ethernet::Mac;
use wire::snmp::{PORT, SnmpMessage, SnmpPduKind};

/// The source port of requests.
pub(super) const MANAGER_PORT: u16 = 49_161;
/// A request that waits for its response.
#[derive(Debug)]
pub(super) struct SnmpJob {
    device: Mac,
    /// The request; `None` if it is no message, which every response answers.
    request: Option<SnmpMessage>,
    since: Time,
}

impl SnmpJob {
    /// How long the response is awaited; the request is sent once.
    pub(super) const WAIT: Duration = Duration::from_secs(2);

    /// When it gives up.
    pub(super) fn until(&self) -> Time {
        self.since + SnmpJob::WAIT
    }

    /// The response in a datagram, if it is one: version, community and request ID are those of the request (RFC 1157, 4.1.5).
    pub(super) fn response(&self, datagram: &Datagram) -> Option<SnmpMessage> {
        if (datagram.source_mac, datagram.source.port()) != (self.device, PORT) {
            return None;
        }
        let response = SnmpMessage::parse(datagram.payload).ok()?;
        let fits = self.request.as_ref().is_none_or(|request| {
            (request.version, &request.community, request.request_id)
                == (response.version, &response.community, response.request_id)
        });
        (fits && response.kind == SnmpPduKind::RESPONSE).then_some(response)
    }
}

/// Sends the payload of a request and begins to wait for its response; with `gets_id` its request ID is replaced by one of the controller.
pub(super) fn ask(
    context: &mut ControllerContext,
    now: Time,
    partner: Partner,
    (octets, gets_id): (Vec<u8>, bool),
    out: &mut Outbox,
) -> ControllerJob {
    let mut request = SnmpMessage::parse(&octets).ok();
    let payload = match &mut request {
        Some(message) if gets_id => {
            message.request_id = (context.ids.xid() >> 1) as i32;
            message.to_vec()
        }
        _ => octets,
    };
    send((context.own, MANAGER_PORT), (partner, PORT), &payload, out);
    ControllerJob::Snmp(SnmpJob { device: partner.mac, request, since: now })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::net::{Ipv4Addr, SocketAddrV4};
    use rstest::rstest;
    use wire::datagram::write_udp;
    use wire::snmp::SnmpVersion;

    const DEVICE: Mac = Mac([2, 0, 0, 0, 0, 1]);
    const OWN: Mac = Mac([2, 0, 0, 0, 0, 2]);

    fn message() -> SnmpMessage {
        SnmpMessage {
            version: SnmpVersion::V1,
            community: b"public".to_vec(),
            kind: SnmpPduKind::RESPONSE,
            request_id: 7,
            error_status: 0,
            error_index: 0,
            bindings: Vec::new(),
        }
    }

    fn is_response(response: &SnmpMessage, port: u16) -> bool {
        let request = SnmpMessage { kind: SnmpPduKind::GET, ..message() };
        let job = SnmpJob { device: DEVICE, request: Some(request), since: Time::ZERO };
        let end = |mac, port| (mac, SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1), port));
        let mut frame = Vec::new();
        write_udp(end(DEVICE, port), end(OWN, MANAGER_PORT), &response.to_vec(), &mut frame).expect("it fits");
        job.response(&Datagram::parse(&frame).expect("a datagram")).is_some()
    }

    #[test]
    fn a_response_has_the_numbers_of_its_request() {
        assert!(is_response(&message(), PORT));
    }

    #[rstest]
    #[case::version(SnmpMessage { version: SnmpVersion::V2C, ..message() }, PORT)]
    #[case::community(SnmpMessage { community: Vec::new(), ..message() }, PORT)]
    #[case::request_id(SnmpMessage { request_id: 8, ..message() }, PORT)]
    #[case::kind(SnmpMessage { kind: SnmpPduKind::GET, ..message() }, PORT)]
    #[case::port(message(), 1161)]
    fn others_are_none(#[case] response: SnmpMessage, #[case] port: u16) {
        assert!(!is_response(&response, port));
    }
}
