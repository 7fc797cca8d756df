//! Dispatches received frames to DCP, a connection, LLDP or the IP stack.

use super::alarm::Outcome;
use super::ar::Ar;
use super::hooks::{Connection, StackCheck};
use super::ip::{Ip, Port, Received};
use super::phase::Event;
use super::plugged::Scope;
use super::rpc::{Progress, Taken};
use super::stack::{Env, Stack};
use crate::profinet::DiagnosisChange;
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use wire::datagram::arp::{Arp, Operation};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::http::Request;
use wire::profinet::alarm::{AlarmPriority, RtaPdu};
use wire::profinet::rt::{FrameId, FrameKind};

impl Stack {
    /// Processes a received frame.
    pub(super) fn receive(&mut self, env: &mut Env<'_>, frame: &[u8]) {
        let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
        let is_unicast =
            self.hooks.check(StackCheck::Addressed(header.destination), header.destination == self.kept.mac);
        if self.sends_as(header.source) || !(is_unicast || header.destination.is_group()) {
            return;
        }
        match header.ether_type {
            EtherType::PROFINET => self.receive_profinet(env, &header, payload, is_unicast),
            EtherType::LLDP if header.destination == Mac::LLDP_MULTICAST => {
                self.lldp.hear(header.source, payload);
            }
            EtherType::ARP if self.receive_arp(env, payload) => {}
            other if Ip::takes(other) => {
                self.serve_pages(env);
                self.ip.receive(env.now, &header, payload, env.out);
                self.receive_datagrams(env);
                self.serve_pages(env);
            }
            _ => {}
        }
    }

    /// Whether frames of this device come from `mac`: the address of the device, or of one of its ports.
    fn sends_as(&self, mac: Mac) -> bool {
        let is_of_ports = || self.plugged.ports().any(|port| mac == self.port_mac(port.subslot));
        // What distinguishes the addresses of a device is not in their first half.
        mac == self.kept.mac || mac.0[..3] == self.kept.mac.0[..3] && is_of_ports()
    }

    /// Answers an ARP probe (sender address 0.0.0.0), which smoltcp ignores. Returns whether the packet is a probe.
    fn receive_arp(&self, env: &mut Env<'_>, payload: &[u8]) -> bool {
        let Ok(arp) = Arp::parse(payload) else { return false };
        let is_probe = arp.operation == Operation::REQUEST && arp.sender_ip.is_unspecified();
        if is_probe && !arp.target_ip.is_unspecified() && arp.target_ip.octets() == self.station.ip {
            env.out.push_with(|frame| arp.reply(self.kept.mac).write_frame(frame));
        }
        is_probe
    }

    fn receive_profinet(&mut self, env: &mut Env<'_>, header: &FrameHeader, payload: &[u8], is_unicast: bool) {
        let Ok(frame_id) = FrameId::peek(payload) else { return };
        match frame_id.kind() {
            FrameKind::RtClass1 | FrameKind::RtClass2 if is_unicast => {
                self.receive_cyclic(env, header.source, frame_id, payload);
            }
            FrameKind::AlarmHigh if is_unicast => self.receive_alarm(env, header.source, AlarmPriority::High, payload),
            FrameKind::AlarmLow if is_unicast => self.receive_alarm(env, header.source, AlarmPriority::Low, payload),
            FrameKind::DcpIdentifyRequest | FrameKind::DcpGetSet => self.receive_dcp(env, header, payload, is_unicast),
            FrameKind::RtClass1
            | FrameKind::RtClass2
            | FrameKind::AlarmHigh
            | FrameKind::AlarmLow
            | FrameKind::Ptcp
            | FrameKind::RtClass3
            | FrameKind::Rsi
            | FrameKind::DcpHello
            | FrameKind::DcpIdentifyResponse
            | FrameKind::Fragment
            | FrameKind::Reserved => {}
        }
    }

    fn receive_cyclic(&mut self, env: &mut Env<'_>, source: Mac, frame_id: FrameId, payload: &[u8]) {
        for ar in &mut self.ars {
            let is_ready = ar.phase.is_ready();
            let Some(exchange) = &mut ar.exchange else { continue };
            if exchange.consumer.expects(source, frame_id)
                && exchange.consumer.receive(env.now, payload, is_ready, env.application)
            {
                ar.step(env.now, Event::OutputsCame);
            }
        }
    }

    fn receive_alarm(&mut self, env: &mut Env<'_>, source: Mac, priority: AlarmPriority, payload: &[u8]) {
        let Some(Ok(pdu)) = payload.get(2..).map(RtaPdu::parse) else { return };
        for at in 0..self.ars.len() {
            let Some(exchange) = &mut self.ars[at].exchange else { continue };
            if self.hooks.check(StackCheck::AlarmEndpoint, exchange.alarms.is_for(source, &pdu)) {
                match exchange.alarms.receive(priority, &pdu, env.out) {
                    Outcome::GoesOn => {}
                    Outcome::Ended => self.end(env, at, Connection::Aborted, None),
                    Outcome::End(reason) => self.abort(env, at, reason),
                }
                return;
            }
        }
    }

    pub(super) fn receive_datagrams(&mut self, env: &mut Env<'_>) {
        while let Some(Received { port, from, payload }) = self.ip.next() {
            match port {
                Port::Server => {
                    let address = self.station.ip;
                    match self.server.take(&payload, from, address) {
                        Taken::Nothing => {}
                        Taken::Say(pdus) => self.send(env, Port::Server, from, &pdus),
                        Taken::Execute(request) => {
                            let reply = self.execute(env, request.clone());
                            let pdus = self.server.answer(&request, &reply);
                            self.send(env, Port::Server, from, &pdus);
                        }
                    }
                }
                Port::Client => {
                    for at in 0..self.ars.len() {
                        let Some(call) = &mut self.ars[at].call else { continue };
                        let progress = call.take(env.now, &payload, from);
                        if self.follow(env, at, progress) {
                            break;
                        }
                    }
                }
            }
        }
    }

    pub(super) fn serve_pages(&mut self, env: &mut Env<'_>) {
        let (now, is_open) = (env.now, env.application.serves_pages());
        let mut pages = |request: &Request| env.application.page(now, request);
        self.ip.serve(now, is_open, &mut pages, env.out);
    }

    /// Draws the conclusion from how ApplicationReady is getting on; says whether the call is over.
    pub(super) fn follow(&mut self, env: &mut Env<'_>, at: usize, progress: Progress) -> bool {
        match progress {
            Progress::Open => return false,
            Progress::Failed(reason) => self.abort(env, at, reason),
            Progress::Done => {
                let ar = &mut self.ars[at];
                ar.call = None;
                ar.step(env.now, Event::ReadyConfirmed);
                let has_outputs = ar.exchange.as_ref().is_some_and(|exchange| exchange.consumer.expires().is_some());
                if has_outputs {
                    ar.step(env.now, Event::OutputsCame);
                }
                self.tell_pending(at);
            }
        }
        true
    }

    fn tell_pending(&mut self, at: usize) {
        let Ar { expected, exchange, .. } = &mut self.ars[at];
        let Some(exchange) = exchange else { return };
        let scope = Scope::Connection(expected);
        for diagnosis in self.diagnoses.pending(scope) {
            let change = DiagnosisChange { appears: true, diagnosis: *diagnosis };
            if let Some(alarm) = self.diagnoses.alarm(&change, scope, &self.plugged) {
                exchange.alarms.push(alarm);
            }
        }
    }

    fn send(&mut self, env: &mut Env<'_>, port: Port, to: SocketAddrV4, pdus: &[Vec<u8>]) {
        for pdu in pdus {
            self.ip.send(env.now, port, to, pdu, env.out);
        }
    }
}
