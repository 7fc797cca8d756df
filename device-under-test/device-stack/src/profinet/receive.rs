//! Dispatches received frames to DCP, a connection, LLDP or the IP stack.

use super::alarm::AlarmOutcome;
use super::ar::DeviceAr;
use super::hooks::{ArEvent, StackCheck};
use super::ip::{IpStack, ReceivedDatagram, RpcSocket};
use super::phase::StartUpEvent;
use super::plugged::RecordScope;
use super::rpc::{CallProgress, PduAction};
use super::snmp;
use super::stack::{Stack, StackEnv};
use crate::profinet::DiagnosisChange;
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use wire::datagram::arp::{Arp, ArpOperation};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::http::HttpRequest;
use wire::profinet::alarm::{AlarmPriority, RtaPdu};
use wire::profinet::rt::{FrameId, FrameKind};

impl Stack {
    /// Processes a received frame.
    pub(super) fn receive(&mut self, env: &mut StackEnv<'_>, frame: &[u8]) {
        self.traffic.count_received(frame);
        let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
        let is_unicast =
            self.hooks.check(StackCheck::Addressed(header.destination), header.destination == self.retained.mac);
        if self.is_own_mac(header.source) || !(is_unicast || header.destination.is_group()) {
            return;
        }
        match header.ether_type {
            EtherType::PROFINET => self.receive_profinet(env, &header, payload, is_unicast),
            EtherType::LLDP if header.destination == Mac::LLDP_MULTICAST => {
                self.lldp.receive(env.now, header.source, payload);
            }
            EtherType::ARP if self.receive_arp(env, payload) => {}
            other if IpStack::takes(other) => {
                self.serve_pages(env);
                self.ip.receive(env.now, &header, payload, env.out);
                self.receive_datagrams(env);
                self.serve_pages(env);
            }
            _ => {}
        }
    }

    /// Whether frames of this device come from `mac`: the address of the device, or of one of its ports.
    fn is_own_mac(&self, mac: Mac) -> bool {
        let is_of_ports = || self.plugged.ports().any(|port| mac == self.port_mac(port.subslot));
        // What distinguishes the addresses of a device is not in their first half.
        mac == self.retained.mac || mac.0[..3] == self.retained.mac.0[..3] && is_of_ports()
    }

    /// Answers an ARP probe (sender address 0.0.0.0), which smoltcp ignores. Returns whether the packet is a probe.
    fn receive_arp(&self, env: &mut StackEnv<'_>, payload: &[u8]) -> bool {
        let Ok(arp) = Arp::parse(payload) else { return false };
        let is_probe = arp.operation == ArpOperation::REQUEST && arp.sender_ip.is_unspecified();
        if is_probe && !arp.target_ip.is_unspecified() && arp.target_ip.octets() == self.station.ip {
            env.out.push_with(|frame| arp.reply(self.retained.mac).write_frame(frame));
        }
        is_probe
    }

    fn receive_profinet(&mut self, env: &mut StackEnv<'_>, header: &FrameHeader, payload: &[u8], is_unicast: bool) {
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

    fn receive_cyclic(&mut self, env: &mut StackEnv<'_>, source: Mac, frame_id: FrameId, payload: &[u8]) {
        for ar in &mut self.ars {
            let is_ready = ar.phase.is_ready();
            let Some(exchange) = &mut ar.exchange else { continue };
            if exchange.consumer.expects(source, frame_id)
                && exchange.consumer.receive(env.now, payload, is_ready, env.application)
            {
                ar.step(env.now, StartUpEvent::OutputsCame);
            }
        }
    }

    fn receive_alarm(&mut self, env: &mut StackEnv<'_>, source: Mac, priority: AlarmPriority, payload: &[u8]) {
        let Some(Ok(pdu)) = payload.get(2..).map(RtaPdu::parse) else { return };
        for at in 0..self.ars.len() {
            let Some(exchange) = &mut self.ars[at].exchange else { continue };
            if self.hooks.check(StackCheck::AlarmEndpoint, exchange.alarms.is_for(source, &pdu)) {
                match exchange.alarms.receive(priority, &pdu, env.out) {
                    AlarmOutcome::GoesOn => {}
                    AlarmOutcome::Ended => self.end(env, at, ArEvent::Aborted, None),
                    AlarmOutcome::End(reason) => self.abort(env, at, reason),
                }
                return;
            }
        }
    }

    pub(super) fn receive_datagrams(&mut self, env: &mut StackEnv<'_>) {
        while let Some(ReceivedDatagram { port, from, payload }) = self.ip.next() {
            match port {
                RpcSocket::Server => {
                    let address = self.station.ip;
                    match self.server.take(&payload, from, address) {
                        PduAction::Nothing => {}
                        PduAction::Say(pdus) => self.send(env, RpcSocket::Server, from, &pdus),
                        PduAction::Execute(request) => {
                            let reply = self.execute(env, request.clone());
                            let pdus = self.server.answer(&request, &reply);
                            self.send(env, RpcSocket::Server, from, &pdus);
                        }
                    }
                }
                RpcSocket::Agent => {
                    if let Some(answer) = snmp::answer(&payload, &self.hooks, || self.mib(env.now)) {
                        self.ip.send(env.now, RpcSocket::Agent, from, &answer, env.out);
                    }
                }
                RpcSocket::Client => {
                    for at in 0..self.ars.len() {
                        let Some(call) = &mut self.ars[at].call else { continue };
                        let progress = call.take(env.now, &payload, from);
                        if self.process_call_progress(env, at, progress) {
                            break;
                        }
                    }
                }
            }
        }
    }

    pub(super) fn serve_pages(&mut self, env: &mut StackEnv<'_>) {
        let (now, is_open) = (env.now, env.application.serves_pages());
        let mut pages = |request: &HttpRequest| env.application.page(now, request);
        self.ip.serve(now, is_open, &mut pages, env.out);
    }

    /// Draws the conclusion from how ApplicationReady is getting on; says whether the call is over.
    pub(super) fn process_call_progress(&mut self, env: &mut StackEnv<'_>, at: usize, progress: CallProgress) -> bool {
        match progress {
            CallProgress::Open => return false,
            CallProgress::Failed(reason) => self.abort(env, at, reason),
            CallProgress::Done => {
                let ar = &mut self.ars[at];
                ar.call = None;
                if !ar.step(env.now, StartUpEvent::ReadyConfirmed) {
                    return true;
                }
                let has_outputs = ar.exchange.as_ref().is_some_and(|exchange| exchange.consumer.expires().is_some());
                if has_outputs {
                    ar.step(env.now, StartUpEvent::OutputsCame);
                }
                self.queue_pending_diagnoses(at);
            }
        }
        true
    }

    fn queue_pending_diagnoses(&mut self, at: usize) {
        let DeviceAr { owned, exchange, .. } = &mut self.ars[at];
        let Some(exchange) = exchange else { return };
        let scope = RecordScope::Connection(owned);
        for diagnosis in self.diagnoses.pending(scope) {
            let change = DiagnosisChange { appears: true, diagnosis: *diagnosis };
            if let Some(alarm) = self.diagnoses.alarm(&change, scope, &self.plugged) {
                exchange.alarms.push(alarm);
            }
        }
    }

    fn send(&mut self, env: &mut StackEnv<'_>, port: RpcSocket, to: SocketAddrV4, pdus: &[Vec<u8>]) {
        for pdu in pdus {
            self.ip.send(env.now, port, to, pdu, env.out);
        }
    }
}
