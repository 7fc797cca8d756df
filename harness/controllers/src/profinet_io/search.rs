//! The search for a device: from a name or a MAC address to a device that can be called, by Identify, Set IP and ARP.
//!
//! The intended address is probed first, so that no two stations have it. This module ends before Connect.

use super::connection::{Connection, DeviceAddress};
use super::context::{Context, Event};
use super::outcome::{Failure, FailureReason, StartUp, StationSeen};
use super::request::Partner;
use super::state::{Stage, Wait, Waiting};
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{Block, BlockError, BlockQualifier, Dcp, Element, ServiceId, ServiceType, Value};
use wire::profinet::rt::FrameId;

/// Time between two Identify or Get requests for the device.
const IDENTIFY_REPEAT: Duration = Duration::from_millis(500);
/// Time after the first answer in which a second station with the same name may answer.
const SAME_NAME_WINDOW: Duration = Duration::from_millis(50);
/// Time between two repetitions of a DCP request to one station.
const DCP_REPEAT: Duration = Duration::from_secs(1);
/// Number of attempts of a DCP request to one station.
const DCP_TRIES: u8 = 3;
/// Time between two ARP probes for another owner of the address.
const PROBE_REPEAT: Duration = Duration::from_millis(100);
/// Number of ARP probes.
const PROBE_TRIES: u8 = 2;
/// Time between two ARP requests for the device.
const ARP_REPEAT: Duration = Duration::from_millis(500);
/// Number of ARP requests.
const ARP_TRIES: u8 = 6;
/// ResponseDelayFactor of an Identify request that one station answers: no delay.
const NO_DELAY: u16 = 1;

/// The search for a device.
#[derive(Debug)]
pub(super) struct Search {
    device: DeviceAddress,
    ip: IpParameter,
    gives_address: bool,
    limit: Duration,
    phase: Phase,
    began: Time,
    next: Time,
    tries: u8,
}

/// The phase of a search.
#[derive(Debug)]
enum Phase {
    /// Identify or Get was sent.
    Identify { xid: u32 },
    /// The device answered; a second one with the same name may follow.
    SameName { xid: u32, seen: Vec<StationSeen> },
    /// Probes whether another station has the address.
    Probe { mac: Mac },
    /// Sets the address of the device.
    SetIp { mac: Mac, xid: u32 },
    /// Resolves the address by ARP.
    Resolve { mac: Mac },
}

impl Search {
    pub(super) fn new(connection: &Connection, context: &mut Context, now: Time, out: &mut Outbox) -> Search {
        let mut search = Search {
            device: connection.device.clone(),
            ip: connection.ip,
            gives_address: connection.gives_address,
            limit: connection.search,
            phase: Phase::Identify { xid: context.ids.xid() },
            began: now,
            next: now,
            tries: 0,
        };
        search.ask(context, now, out);
        search
    }

    pub(super) fn stage(&self) -> Stage {
        match self.phase {
            Phase::Identify { .. } | Phase::SameName { .. } => Stage::Identify,
            Phase::Probe { .. } | Phase::SetIp { .. } => Stage::Address,
            Phase::Resolve { .. } => Stage::Resolve,
        }
    }

    pub(super) fn deadline(&self) -> Time {
        self.next
    }

    /// Processes an event; returns the device once it can be called.
    pub(super) fn event(
        &mut self,
        context: &mut Context,
        now: Time,
        event: &Event,
        result: &mut StartUp,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, Failure> {
        let stage = self.stage();
        let step = match event {
            Event::Wake if now >= self.next => self.wake(context, now, result, out),
            Event::Dcp(from, dcp) => self.dcp(context, now, *from, dcp, result, out),
            Event::Arp(arp) if arp.sender_ip == self.ip.address => self.arp(arp.sender_mac),
            _ => Ok(None),
        };
        step.map_err(|why| Failure { stage, why })
    }

    /// Sends the request of the phase.
    fn ask(&mut self, context: &Context, now: Time, out: &mut Outbox) {
        let own = context.settings.mac;
        let dcp = |dcp: Dcp, to: Mac, out: &mut Outbox| out.push_with(|octets| dcp.write_frame(to, own, octets));
        let repeat = match &self.phase {
            Phase::Identify { xid } => {
                match &self.device {
                    DeviceAddress::Name(name) => {
                        let filters = [Value::NameOfStation(name.as_bytes().into())].into();
                        dcp(Dcp::identify(*xid, NO_DELAY, filters), Mac::DCP_MULTICAST, out);
                    }
                    DeviceAddress::Mac(mac) => {
                        let elements =
                            [Element::NAME_OF_STATION, Element::IP_PARAMETER, Element::DEVICE_ID, Element::VENDOR];
                        dcp(Dcp::get(*xid, elements.into()), *mac, out);
                    }
                }
                IDENTIFY_REPEAT
            }
            Phase::SameName { .. } => SAME_NAME_WINDOW,
            Phase::Probe { .. } | Phase::Resolve { .. } => {
                let request = Arp::request(own, context.settings.ip, self.ip.address);
                out.push_with(|octets| request.write_frame(octets));
                if matches!(self.phase, Phase::Probe { .. }) { PROBE_REPEAT } else { ARP_REPEAT }
            }
            Phase::SetIp { mac, xid } => {
                let blocks = [Block::set(BlockQualifier::TEMPORARY, Value::IpParameter(self.ip))].into();
                dcp(Dcp::set(*xid, blocks), *mac, out);
                DCP_REPEAT
            }
        };
        self.tries += 1;
        self.next = now + repeat;
    }

    fn go(&mut self, phase: Phase, context: &Context, now: Time, out: &mut Outbox) {
        (self.phase, self.began, self.tries) = (phase, now, 0);
        self.ask(context, now, out);
    }

    fn wake(
        &mut self,
        context: &mut Context,
        now: Time,
        result: &mut StartUp,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, FailureReason> {
        let waited = |what: Waiting| Err(FailureReason::Waited(Wait { what, time: now.since(self.began) }));
        match &mut self.phase {
            Phase::Identify { .. } if now.since(self.began) >= self.limit => waited(match self.device {
                DeviceAddress::Name(_) => Waiting::Identify,
                DeviceAddress::Mac(_) => Waiting::StationGet,
            }),
            Phase::SameName { seen, .. } => {
                let seen = core::mem::take(seen);
                self.found(context, now, seen, result, out)
            }
            Phase::Probe { mac } if self.tries >= PROBE_TRIES => {
                let phase = Phase::SetIp { mac: *mac, xid: context.ids.xid() };
                self.go(phase, context, now, out);
                Ok(None)
            }
            Phase::SetIp { .. } if self.tries >= DCP_TRIES => waited(Waiting::StationSet),
            Phase::Resolve { .. } if self.tries >= ARP_TRIES => waited(Waiting::Arp),
            Phase::Identify { .. } | Phase::Probe { .. } | Phase::SetIp { .. } | Phase::Resolve { .. } => {
                self.ask(context, now, out);
                Ok(None)
            }
        }
    }

    fn dcp(
        &mut self,
        context: &mut Context,
        now: Time,
        from: Mac,
        dcp: &Dcp,
        result: &mut StartUp,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, FailureReason> {
        match (&mut self.phase, &self.device) {
            (Phase::Identify { xid }, DeviceAddress::Name(name)) if identifies(dcp, *xid, name) => {
                let (xid, seen) = (*xid, [StationSeen::of(from, dcp)].into());
                self.go(Phase::SameName { xid, seen }, context, now, out);
                Ok(None)
            }
            (Phase::SameName { xid, seen }, DeviceAddress::Name(name)) if identifies(dcp, *xid, name) => {
                if seen.iter().all(|known| known.mac != from) {
                    seen.push(StationSeen::of(from, dcp));
                }
                Ok(None)
            }
            (Phase::Identify { xid }, DeviceAddress::Mac(mac))
                if from == *mac && answers(dcp, ServiceId::GET, *xid) =>
            {
                self.found(context, now, [StationSeen::of(from, dcp)].into(), result, out)
            }
            (Phase::SetIp { mac, xid }, _) if from == *mac && answers(dcp, ServiceId::SET, *xid) => {
                let error = set_error(dcp, Element::IP_PARAMETER);
                if error != BlockError::OK {
                    return Err(FailureReason::AddressRefused(error));
                }
                result.address_set = Some(true);
                let mac = *mac;
                self.go(Phase::Resolve { mac }, context, now, out);
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    fn found(
        &mut self,
        context: &mut Context,
        now: Time,
        seen: Vec<StationSeen>,
        result: &mut StartUp,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, FailureReason> {
        if seen.len() > 1 {
            return Err(FailureReason::SameName(seen.iter().map(|station| station.mac).collect()));
        }
        let Some(station) = seen.into_iter().next() else { return Ok(None) };
        let (mac, has_it) = (station.mac, station.ip == self.ip);
        let address = station.ip.address;
        result.identify = Some(station);
        if !self.gives_address {
            if address.is_unspecified() {
                return Ok(Some(Partner { mac, ip: self.ip.address }));
            }
            self.ip.address = address;
            self.go(Phase::Resolve { mac }, context, now, out);
            return Ok(None);
        }
        result.address_set = has_it.then_some(false);
        self.go(if has_it { Phase::Resolve { mac } } else { Phase::Probe { mac } }, context, now, out);
        Ok(None)
    }

    fn arp(&mut self, owner: Mac) -> Result<Option<Partner>, FailureReason> {
        match self.phase {
            Phase::Probe { mac } | Phase::Resolve { mac } if owner != mac => Err(FailureReason::SameAddress(owner)),
            Phase::Resolve { mac } => Ok(Some(Partner { mac, ip: self.ip.address })),
            _ => Ok(None),
        }
    }
}

/// Whether `dcp` answers the Identify request `xid` for the station `name`.
fn identifies(dcp: &Dcp, xid: u32, name: &str) -> bool {
    let named = |block: &Block| matches!(&block.value, Value::NameOfStation(its) if its == name.as_bytes());
    is_identification(dcp, xid) && dcp.blocks().iter().any(named)
}

/// Whether `dcp` answers the Identify request `xid`.
pub(super) fn is_identification(dcp: &Dcp, xid: u32) -> bool {
    let kind = (dcp.frame_id, dcp.service_id, dcp.service_type);
    kind == (FrameId::DCP_IDENTIFY_RESPONSE, ServiceId::IDENTIFY, ServiceType::RESPONSE) && dcp.xid == xid
}

/// Whether `dcp` answers the Get or Set request `xid`, including the answer "not supported".
pub(super) fn answers(dcp: &Dcp, service: ServiceId, xid: u32) -> bool {
    let answer = matches!(dcp.service_type, ServiceType::RESPONSE | ServiceType::NOT_SUPPORTED);
    answer && (dcp.frame_id, dcp.service_id, dcp.xid) == (FrameId::DCP_GET_SET, service, xid)
}

/// The result for `element` in the answer to Set; an element missing in the response was set.
fn set_error(dcp: &Dcp, element: Element) -> BlockError {
    if dcp.service_type == ServiceType::NOT_SUPPORTED {
        return BlockError::OPTION_NOT_SUPPORTED;
    }
    let error = dcp.blocks().iter().find_map(|block| match block.value {
        Value::Response { element: about, error } if about == element => Some(error),
        _ => None,
    });
    error.unwrap_or(BlockError::OK)
}
