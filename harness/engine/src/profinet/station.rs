//! Name, address and identity of the station, read and written by DCP.
//!
//! This module must not know records, nor whether there is a connection.

use super::{IDENTIFY, unexpected};
use crate::trial::RunningTrial;
use crate::trial::access::AccessAnswer;
use crate::trial::step_error::BoxedStepError;
use controllers::profinet_io::{ControllerOutcome, ControllerRequest, DcpOutcome, IdentifyBy};
use expression::Value;
use judge::answer::{NegativeResponse, ReceivedReply};
use judge::observe::Address;
use std::net::Ipv4Addr;
use suite::device::{NameKind, StationName};
use suite::model::{AcyclicAccess, RequestDeviation};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ServiceId, ServiceType};
use wire::profinet::rt::{FrameId, FrameKind};

impl<'a> RunningTrial<'a> {
    /// Reads or writes name, address and identity of the station.
    pub(super) fn station(&mut self, access: &'a AcyclicAccess, write: bool) -> Result<AccessAnswer, BoxedStepError> {
        let names: Vec<StationName> = access
            .items
            .iter()
            .filter_map(|item| match self.kind(item.name) {
                Some(NameKind::Station(name)) => Some(*name),
                _ => None,
            })
            .collect();
        if write {
            return self.station_write(access, &names);
        }
        let mut elements: Vec<Element> = names.iter().filter_map(|name| element(*name)).collect();
        elements.dedup();
        let mut answered = AccessAnswer::whole(ReceivedReply::Accepted, access.items.len());
        if !elements.is_empty() {
            let outcome = self.ask(access.second, ControllerRequest::DcpGet { to: self.mac, elements })?;
            let ControllerOutcome::Dcp(outcome) = outcome else { return Err(unexpected(&outcome)) };
            answered = AccessAnswer::whole(dcp(&outcome), access.items.len());
            if let DcpOutcome::Values(blocks) = &outcome {
                answered.values = names.iter().map(|name| station_value(*name, blocks)).collect();
            }
        }
        if names.contains(&StationName::Mac) {
            match self.mac_now(access.second)? {
                Some(mac) => {
                    let values = names.iter().zip(&mut answered.values);
                    values
                        .filter(|(name, _)| **name == StationName::Mac)
                        .for_each(|(_, value)| *value = Value::bytes(&mac.0[..]));
                }
                None => {
                    let silent = ReceivedReply::Silent("no station with this identity answers, or several do".into());
                    return Ok(AccessAnswer::whole(silent, access.items.len()));
                }
            }
        }
        Ok(answered)
    }

    fn station_write(
        &mut self,
        access: &'a AcyclicAccess,
        names: &[StationName],
    ) -> Result<AccessAnswer, BoxedStepError> {
        self.may_end = true;
        self.renamed |= names.contains(&StationName::Name);
        let before_write = self.station_ip;
        let blocks = self.station_blocks(access, names)?;
        let other = access.instead.iter().find_map(|instead| match instead {
            RequestDeviation::Destination(mac) => Some(*mac),
            _ => None,
        });
        let before = self.world.trace.len();
        let outcome = self.ask(access.second, ControllerRequest::DcpSet { to: other.unwrap_or(self.mac), blocks })?;
        let ControllerOutcome::Dcp(outcome) = outcome else { return Err(unexpected(&outcome)) };
        let mut reply = dcp(&outcome);
        if matches!(reply, ReceivedReply::Refused(_)) {
            self.station_ip = before_write;
        } else if other.is_none() && !self.station_ip.address.is_unspecified() {
            self.last_ip = self.station_ip.address;
        }
        if other.is_some() {
            // The request went to another station, so the device must keep its address and must not answer.
            self.station_ip = before_write;
            if (before + 1..=self.world.trace.len()).any(|number| self.is_set_answer(number)) {
                reply = ReceivedReply::Wrong("the device answered a request to another station".into());
            }
        }
        Ok(AccessAnswer::whole(reply, access.items.len()))
    }

    /// Whether a frame of the trace is the device's answer to a DCP Set.
    fn is_set_answer(&self, number: usize) -> bool {
        let Some(frame) = self.world.trace.get(number) else { return false };
        let Ok((header, payload)) = FrameHeader::parse(frame.octets) else { return false };
        let is_answer = |dcp: Dcp| dcp.service_id == ServiceId::SET && dcp.service_type != ServiceType::REQUEST;
        header.source == self.mac
            && header.ether_type == EtherType::PROFINET
            && FrameId::peek(payload).is_ok_and(|id| id.kind() == FrameKind::DcpGetSet)
            && Dcp::parse(payload).is_ok_and(is_answer)
    }

    /// The MAC address of the device, found by its identity since the address itself is what is read.
    fn mac_now(&mut self, second: bool) -> Result<Option<Mac>, BoxedStepError> {
        let outcome = self.ask(second, ControllerRequest::Identify { by: IdentifyBy::All, wait: IDENTIFY })?;
        let ControllerOutcome::Stations(stations) = outcome else { return Err(unexpected(&outcome)) };
        let claimed = self.world.manual.device.ids();
        let own = &self.world.addresses;
        let found: Vec<Mac> = stations
            .iter()
            .filter(|station| station.id == claimed && !own.contains(&Address::Mac(station.mac)))
            .map(|station| station.mac)
            .collect();
        Ok(match found.as_slice() {
            several if several.contains(&self.mac) => Some(self.mac),
            [only] => Some(*only),
            _ => None,
        })
    }

    fn station_blocks(
        &mut self,
        access: &'a AcyclicAccess,
        names: &[StationName],
    ) -> Result<Vec<DcpBlock>, BoxedStepError> {
        let mut qualifier = BlockQualifier::PERMANENT;
        let mut octets = None;
        for instead in &access.instead {
            match instead {
                RequestDeviation::Qualifier(other) => qualifier = BlockQualifier(*other),
                RequestDeviation::StationValue(value) => octets = Some(value.clone()),
                _ => {}
            }
        }
        let mut ip = self.station_ip;
        let mut blocks = Vec::new();
        let mut has_ip = false;
        for (name, item) in names.iter().zip(&access.items) {
            let value = self.written(&item.value)?;
            let address = |value: &Value| match value {
                Value::Address(octets) => Ipv4Addr::from(*octets),
                _ => Ipv4Addr::UNSPECIFIED,
            };
            match (name, &value) {
                (StationName::Name, Value::Text(text)) => {
                    let text = octets.clone().unwrap_or_else(|| text.as_bytes().to_vec());
                    blocks.push(DcpBlock::set(qualifier, DcpValue::NameOfStation(text)));
                }
                (StationName::Ip, value) => (ip.address, has_ip) = (address(value), true),
                (StationName::Mask, value) => (ip.mask, has_ip) = (address(value), true),
                (StationName::Gateway, value) => (ip.gateway, has_ip) = (address(value), true),
                _ => {}
            }
        }
        if has_ip {
            let value = match octets {
                Some(octets) => DcpValue::Raw { element: Element::IP_PARAMETER, octets },
                None => DcpValue::IpParameter(ip),
            };
            self.station_ip = ip;
            blocks.push(DcpBlock::set(qualifier, value));
        }
        Ok(blocks)
    }
}

/// The reply for a DCP service.
pub fn dcp(outcome: &DcpOutcome) -> ReceivedReply {
    match outcome {
        DcpOutcome::Accepted | DcpOutcome::Values(_) => ReceivedReply::Accepted,
        DcpOutcome::Refused(errors) => {
            ReceivedReply::Refused(NegativeResponse::Dcp(errors.first().map_or(0, |(_, error)| error.0)))
        }
        DcpOutcome::NotSupported => ReceivedReply::Refused(NegativeResponse::NotSupported),
        DcpOutcome::NoAnswer(wait) => ReceivedReply::Silent(wait.to_string()),
    }
}

/// The element that DCP Get requests for a name; `None` for the MAC address, which DCP Get does not have.
fn element(name: StationName) -> Option<Element> {
    Some(match name {
        StationName::Name => Element::NAME_OF_STATION,
        StationName::Ip | StationName::Mask | StationName::Gateway => Element::IP_PARAMETER,
        StationName::VendorId | StationName::DeviceId => Element::DEVICE_ID,
        StationName::Type => Element::VENDOR,
        StationName::Mac | StationName::Address => return None,
    })
}

fn station_value(name: StationName, blocks: &[DcpBlock]) -> Value {
    let text = |octets: &[u8]| Value::text(String::from_utf8_lossy(octets).into_owned());
    let address = |pick: fn(&IpParameter) -> Ipv4Addr| {
        blocks.iter().find_map(|block| match &block.value {
            DcpValue::IpParameter(ip) | DcpValue::FullIpSuite(ip, _) => Some(Value::Address(pick(ip).octets())),
            _ => None,
        })
    };
    let found = match name {
        StationName::Name => blocks.iter().find_map(|block| match &block.value {
            DcpValue::NameOfStation(octets) => Some(text(octets)),
            _ => None,
        }),
        StationName::Type => blocks.iter().find_map(|block| match &block.value {
            DcpValue::Vendor(octets) => Some(text(octets)),
            _ => None,
        }),
        StationName::Mac | StationName::Address => None,
        StationName::Ip => address(|ip| ip.address),
        StationName::Mask => address(|ip| ip.mask),
        StationName::Gateway => address(|ip| ip.gateway),
        StationName::VendorId | StationName::DeviceId => blocks.iter().find_map(|block| match &block.value {
            DcpValue::DeviceId { vendor_id, device_id } => {
                Some(Value::whole(if name == StationName::VendorId { *vendor_id } else { *device_id }))
            }
            _ => None,
        }),
    };
    found.unwrap_or(Value::Unknown)
}
