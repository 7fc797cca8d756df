//! The search for a device: from a name or a MAC address to a device that can be called, by Identify, Set IP and ARP.
//!
//! The intended address is probed first, so that no two stations have it. This module ends before Connect.

use super::connection::{ArConfig, DeviceAddress};
use super::context::{ControllerContext, JobEvent};
use super::outcome::{ArFailureReason, ArStartUpFailure, ArStartUpResult, IdentifiedStation};
use super::request::Partner;
use super::state::{ArStartUpStage, AwaitedEvent, Wait};
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ServiceId, ServiceType};
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
pub(super) struct DeviceSearch {
    device: DeviceAddress,
    ip: IpParameter,
    gives_address: bool,
    limit: Duration,
    phase: SearchPhase,
    began: Time,
    next: Time,
    tries: u8,
}

/// The phase of a search.
#[derive(Debug)]
enum SearchPhase {
    /// Identify or Get was sent.
    Identify { xid: u32 },
    /// The device answered; a second one with the same name may follow.
    SameName { xid: u32, seen: Vec<IdentifiedStation> },
    /// Probes whether another station has the address.
    Probe { mac: Mac },
    /// Sets the address of the device.
    SetIp { mac: Mac, xid: u32 },
    /// Resolves the address by ARP.
    Resolve { mac: Mac },
}

impl DeviceSearch {
    pub(super) fn new(
        connection: &ArConfig,
        context: &mut ControllerContext,
        now: Time,
        out: &mut Outbox,
    ) -> DeviceSearch {
        let mut search = DeviceSearch {
            device: connection.device.clone(),
            ip: connection.ip,
            gives_address: connection.gives_address,
            limit: connection.search,
            phase: SearchPhase::Identify { xid: context.ids.xid() },
            began: now,
            next: now,
            tries: 0,
        };
        search.ask(context, now, out);
        search
    }

    pub(super) fn stage(&self) -> ArStartUpStage {
        match self.phase {
            SearchPhase::Identify { .. } | SearchPhase::SameName { .. } => ArStartUpStage::Identify,
            SearchPhase::Probe { .. } | SearchPhase::SetIp { .. } => ArStartUpStage::Address,
            SearchPhase::Resolve { .. } => ArStartUpStage::Resolve,
        }
    }

    pub(super) fn deadline(&self) -> Time {
        self.next
    }

    /// Processes an event; returns the device once it can be called.
    pub(super) fn event(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        event: &JobEvent,
        result: &mut ArStartUpResult,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, ArStartUpFailure> {
        let stage = self.stage();
        let step = match event {
            JobEvent::Wake if now >= self.next => self.wake(context, now, result, out),
            JobEvent::Dcp(from, dcp) => self.dcp(context, now, *from, dcp, result, out),
            JobEvent::Arp(arp) if arp.sender_ip == self.ip.address => self.arp(arp.sender_mac),
            _ => Ok(None),
        };
        step.map_err(|why| ArStartUpFailure { stage, why })
    }

    /// Sends the request of the phase.
    fn ask(&mut self, context: &ControllerContext, now: Time, out: &mut Outbox) {
        let own = context.settings.mac;
        let dcp = |dcp: Dcp, to: Mac, out: &mut Outbox| out.push_with(|octets| dcp.write_frame(to, own, octets));
        let repeat = match &self.phase {
            SearchPhase::Identify { xid } => {
                match &self.device {
                    DeviceAddress::Name(name) => {
                        let filters = [DcpValue::NameOfStation(name.as_bytes().into())].into();
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
            SearchPhase::SameName { .. } => SAME_NAME_WINDOW,
            SearchPhase::Probe { .. } | SearchPhase::Resolve { .. } => {
                let request = Arp::request(own, context.settings.ip, self.ip.address);
                out.push_with(|octets| request.write_frame(octets));
                if matches!(self.phase, SearchPhase::Probe { .. }) { PROBE_REPEAT } else { ARP_REPEAT }
            }
            SearchPhase::SetIp { mac, xid } => {
                let blocks = [DcpBlock::set(BlockQualifier::TEMPORARY, DcpValue::IpParameter(self.ip))].into();
                dcp(Dcp::set(*xid, blocks), *mac, out);
                DCP_REPEAT
            }
        };
        self.tries += 1;
        self.next = now + repeat;
    }

    fn go(&mut self, phase: SearchPhase, context: &ControllerContext, now: Time, out: &mut Outbox) {
        (self.phase, self.began, self.tries) = (phase, now, 0);
        self.ask(context, now, out);
    }

    fn wake(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        result: &mut ArStartUpResult,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, ArFailureReason> {
        let waited = |what: AwaitedEvent| Err(ArFailureReason::Waited(Wait { what, time: now.since(self.began) }));
        match &mut self.phase {
            SearchPhase::Identify { .. } if now.since(self.began) >= self.limit => waited(match self.device {
                DeviceAddress::Name(_) => AwaitedEvent::Identify,
                DeviceAddress::Mac(_) => AwaitedEvent::StationGet,
            }),
            SearchPhase::SameName { seen, .. } => {
                let seen = core::mem::take(seen);
                self.found(context, now, seen, result, out)
            }
            SearchPhase::Probe { mac } if self.tries >= PROBE_TRIES => {
                let phase = SearchPhase::SetIp { mac: *mac, xid: context.ids.xid() };
                self.go(phase, context, now, out);
                Ok(None)
            }
            SearchPhase::SetIp { .. } if self.tries >= DCP_TRIES => waited(AwaitedEvent::StationSet),
            SearchPhase::Resolve { .. } if self.tries >= ARP_TRIES => waited(AwaitedEvent::Arp),
            SearchPhase::Identify { .. }
            | SearchPhase::Probe { .. }
            | SearchPhase::SetIp { .. }
            | SearchPhase::Resolve { .. } => {
                self.ask(context, now, out);
                Ok(None)
            }
        }
    }

    fn dcp(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        from: Mac,
        dcp: &Dcp,
        result: &mut ArStartUpResult,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, ArFailureReason> {
        match (&mut self.phase, &self.device) {
            (SearchPhase::Identify { xid }, DeviceAddress::Name(name)) if identifies(dcp, *xid, name) => {
                let (xid, seen) = (*xid, [IdentifiedStation::of(from, dcp)].into());
                self.go(SearchPhase::SameName { xid, seen }, context, now, out);
                Ok(None)
            }
            (SearchPhase::SameName { xid, seen }, DeviceAddress::Name(name)) if identifies(dcp, *xid, name) => {
                if seen.iter().all(|known| known.mac != from) {
                    seen.push(IdentifiedStation::of(from, dcp));
                }
                Ok(None)
            }
            (SearchPhase::Identify { xid }, DeviceAddress::Mac(mac))
                if from == *mac && answers(dcp, ServiceId::GET, *xid) =>
            {
                self.found(context, now, [IdentifiedStation::of(from, dcp)].into(), result, out)
            }
            (SearchPhase::SetIp { mac, xid }, _) if from == *mac && answers(dcp, ServiceId::SET, *xid) => {
                let error = set_error(dcp, Element::IP_PARAMETER);
                if error != BlockError::OK {
                    return Err(ArFailureReason::AddressRefused(error));
                }
                result.address_set = Some(true);
                let mac = *mac;
                self.go(SearchPhase::Resolve { mac }, context, now, out);
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    fn found(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        stations: Vec<IdentifiedStation>,
        result: &mut ArStartUpResult,
        out: &mut Outbox,
    ) -> Result<Option<Partner>, ArFailureReason> {
        if stations.len() > 1 {
            return Err(ArFailureReason::SameName(stations.iter().map(|station| station.mac).collect()));
        }
        let Some(station) = stations.into_iter().next() else { return Ok(None) };
        let (mac, has_it) = (station.mac, station.ip == self.ip);
        let address = station.ip.address;
        result.identify = Some(station);
        if !self.gives_address {
            if address.is_unspecified() {
                return Ok(Some(Partner { mac, ip: self.ip.address }));
            }
            self.ip.address = address;
            self.go(SearchPhase::Resolve { mac }, context, now, out);
            return Ok(None);
        }
        result.address_set = has_it.then_some(false);
        self.go(if has_it { SearchPhase::Resolve { mac } } else { SearchPhase::Probe { mac } }, context, now, out);
        Ok(None)
    }

    fn arp(&mut self, owner: Mac) -> Result<Option<Partner>, ArFailureReason> {
        match self.phase {
            SearchPhase::Probe { mac } | SearchPhase::Resolve { mac } if owner != mac => {
                Err(ArFailureReason::SameAddress(owner))
            }
            SearchPhase::Resolve { mac } => Ok(Some(Partner { mac, ip: self.ip.address })),
            _ => Ok(None),
        }
    }
}

/// Whether `dcp` answers the Identify request `xid` for the station `name`.
fn identifies(dcp: &Dcp, xid: u32, name: &str) -> bool {
    let named = |block: &DcpBlock| matches!(&block.value, DcpValue::NameOfStation(its) if its == name.as_bytes());
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
        DcpValue::Response { element: about, error } if about == element => Some(error),
        _ => None,
    });
    error.unwrap_or(BlockError::OK)
}
