//! The objects of the agent: MIB-II system and interfaces, LLDP-MIB and its extension for PROFINET.
//!
//! RFC 1213 for MIB-II; IEEE 802.1AB-2005 for LLDP-MIB; LLDP-EXT-PNO-MIB of PI for 1.0.8802.1.1.2.1.5.3791.

use super::super::lldp::{LldpAgent, chassis_id, port_id};
use super::super::physical::port_name;
use super::super::plugged::PORT_SUBSLOT;
use super::super::stack::Stack;
use super::ber::{MibName, MibValue};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use station::Time;
use wire::lldp::Tlv;

const SYSTEM: [u32; 7] = [1, 3, 6, 1, 2, 1, 1];
const INTERFACES: [u32; 7] = [1, 3, 6, 1, 2, 1, 2];
const LLDP: [u32; 7] = [1, 0, 8802, 1, 1, 2, 1];
/// LLDP-EXT-PNO-MIB below the extensions of LLDP-MIB.
const PNO: [u32; 3] = [5, 3791, 1];
/// sysObjectID: the enterprise of PI.
const PI: [u32; 7] = [1, 3, 6, 1, 4, 1, 24686];
/// sysServices: a switch that is a host too (RFC 1213, 6.1: the sum of 2^(layer - 1), for the layers 2, 4 and 7).
const SERVICES: i32 = 0x02 | 0x08 | 0x40;
/// ifType of Ethernet.
const ETHERNET: i32 = 6;
/// ifMtu and ifSpeed.
const MTU: i32 = 1500;
const SPEED: u32 = 100_000_000;
const UP: i32 = 1;
const DOWN: i32 = 2;
/// LldpSystemCapabilitiesMap with stationOnly(7).
const STATION_ONLY: u8 = 0x01;
/// The address family of IPv4, and the subtype ifIndex of an interface number.
const IPV4: u32 = 1;
const BY_IF_INDEX: i32 = 2;

/// An object with its name and its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MibObject {
    /// Its name, the index of its instance included.
    pub name: MibName,
    /// The number of numbers in the name that name the instance.
    pub instance: usize,
    /// Its value.
    pub value: MibValue,
}

impl MibObject {
    /// The name without its instance.
    pub(super) fn object(&self) -> &[u32] {
        &self.name[..self.name.len().saturating_sub(self.instance)]
    }
}

/// The frames that the device has received and sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) struct TrafficCounters {
    received: DirectionCounters,
    sent: DirectionCounters,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct DirectionCounters {
    octets: u32,
    unicast: u32,
    group: u32,
}

impl DirectionCounters {
    fn count(&mut self, frame: &[u8]) {
        self.octets = self.octets.wrapping_add(frame.len() as u32);
        let is_group = frame.first().is_some_and(|first| first & 1 == 1);
        let number = if is_group { &mut self.group } else { &mut self.unicast };
        *number = number.wrapping_add(1);
    }
}

impl TrafficCounters {
    /// Counts a received frame.
    pub(in super::super) fn count_received(&mut self, frame: &[u8]) {
        self.received.count(frame);
    }

    /// Counts a sent frame.
    pub(in super::super) fn count_sent(&mut self, frame: &[u8]) {
        self.sent.count(frame);
    }
}

/// The objects, as they are collected.
#[derive(Default)]
struct MibList(Vec<MibObject>);

impl MibList {
    /// An object with one instance: `number` below `group`.
    fn scalar(&mut self, group: &[u32], number: &[u32], value: MibValue) {
        self.add(&[group, number], &[0], value);
    }

    /// An object whose name is joined of `object`, and one instance of it.
    fn add(&mut self, object: &[&[u32]], instance: &[u32], value: MibValue) {
        let mut name: MibName = object.concat();
        name.extend_from_slice(instance);
        self.0.push(MibObject { name, instance: instance.len(), value });
    }

    /// A row of a table of LLDP-EXT-PNO-MIB: no delays, the states of RT class 2 and 3 off, and the name of the station.
    fn pno_row(&mut self, table: u32, index: &[u32], station: &[u8]) {
        let delays = [MibValue::Gauge(0), MibValue::Gauge(0), MibValue::Gauge(0)];
        let rest = [MibValue::Integer(0), MibValue::Integer(0), octets(station)];
        for (column, value) in (1..).zip(delays.into_iter().chain(rest)) {
            self.add(&[&LLDP, &PNO, &[table, 1, 1, column]], index, value);
        }
    }
}

fn text(text: &str) -> MibValue {
    MibValue::Octets(text.as_bytes().to_vec())
}

fn octets(octets: &[u8]) -> MibValue {
    MibValue::Octets(octets.to_vec())
}

impl Stack {
    /// All objects at `now`, in any order.
    pub(in super::super) fn mib(&self, now: Time) -> Vec<MibObject> {
        let mut list = MibList::default();
        self.system(now, &mut list);
        self.interfaces(&mut list);
        self.lldp_configuration(&mut list);
        self.lldp_local(&mut list);
        self.lldp_remote(now, &mut list);
        list.0
    }

    fn description(&self) -> String {
        let [prefix, major, minor, patch] = self.identity.software_revision;
        format!(
            "{}, {}, {}, HW {}, SW {}{major}.{minor}.{patch}",
            self.identity.station_type,
            self.identity.order_id,
            self.identity.serial_number,
            self.identity.hardware_revision,
            char::from(prefix),
        )
    }

    fn system(&self, now: Time, list: &mut MibList) {
        let ticks = now.since(self.started).as_millis() / 10;
        let values = [
            text(&self.description()),
            MibValue::Name(PI.to_vec()),
            MibValue::Ticks(ticks as u32),
            text(""),
            octets(&self.station.name),
            text(""),
            MibValue::Integer(SERVICES),
        ];
        for (number, value) in (1..).zip(values) {
            list.scalar(&SYSTEM, &[number], value);
        }
    }

    /// The ports, and after them the interface that they share.
    fn interfaces(&self, list: &mut MibList) {
        let ports: Vec<u16> = self.plugged.ports().map(|port| port.subslot).collect();
        let count = ports.len() as u32 + 1;
        list.scalar(&INTERFACES, &[1], MibValue::Integer(count as i32));
        let rows = ports.into_iter().map(Some).chain([None]);
        for (index, subslot) in (1..).zip(rows) {
            let is_linked = subslot.is_none_or(|subslot| subslot == PORT_SUBSLOT);
            let mac = subslot.map_or(self.retained.mac, |subslot| self.port_mac(subslot));
            let name = subslot.map_or_else(|| "interface".into(), port_name);
            let traffic = if is_linked { self.traffic } else { TrafficCounters::default() };
            let values = [
                MibValue::Integer(index as i32),
                text(&name),
                MibValue::Integer(ETHERNET),
                MibValue::Integer(MTU),
                MibValue::Gauge(SPEED),
                octets(&mac.0),
                MibValue::Integer(UP),
                MibValue::Integer(if is_linked { UP } else { DOWN }),
                MibValue::Ticks(0),
                MibValue::Counter(traffic.received.octets),
                MibValue::Counter(traffic.received.unicast),
                MibValue::Counter(traffic.received.group),
                MibValue::Counter(0),
                MibValue::Counter(0),
                MibValue::Counter(0),
                MibValue::Counter(traffic.sent.octets),
                MibValue::Counter(traffic.sent.unicast),
                MibValue::Counter(traffic.sent.group),
                MibValue::Counter(0),
                MibValue::Counter(0),
                MibValue::Gauge(0),
                MibValue::Name([0, 0].to_vec()),
            ];
            for (column, value) in (1..).zip(values) {
                list.add(&[&INTERFACES, &[2, 1, column]], &[index], value);
            }
        }
    }

    fn lldp_configuration(&self, list: &mut MibList) {
        let interval = LldpAgent::INTERVAL.as_secs() as i32;
        let hold = i32::from(LldpAgent::TIME_TO_LIVE) / interval;
        for (number, value) in (1..).zip([interval, hold, 2, 1, interval]) {
            list.scalar(&LLDP, &[1, number], MibValue::Integer(value));
        }
    }

    fn lldp_local(&self, list: &mut MibList) {
        let name = &self.station.name;
        let (subtype, chassis) = chassis_id(&self.retained.mac, name);
        let values = [
            MibValue::Integer(subtype.into()),
            octets(chassis),
            octets(name),
            text(&self.description()),
            octets(&[STATION_ONLY]),
            octets(&[STATION_ONLY]),
        ];
        for (number, value) in (1..).zip(values) {
            list.scalar(&LLDP, &[3, number], value);
        }
        let ports: Vec<u16> = self.plugged.ports().map(|port| port.subslot).collect();
        for (number, subslot) in (1..).zip(&ports) {
            let port = port_name(*subslot);
            let id = MibValue::Octets(port_id(&port, name));
            let values = [MibValue::Integer(Tlv::LOCALLY_ASSIGNED.into()), id, text(&port)];
            for (column, value) in (2..).zip(values) {
                list.add(&[&LLDP, &[3, 7, 1, column]], &[number], value);
            }
            list.pno_row(2, &[number], name);
        }
        if self.station.ip != [0; 4] {
            let [a, b, c, d] = self.station.ip.map(u32::from);
            let values = [
                MibValue::Integer(5),
                MibValue::Integer(BY_IF_INDEX),
                MibValue::Integer(ports.len() as i32 + 1),
                MibValue::Name([0, 0].to_vec()),
            ];
            for (column, value) in (3..).zip(values) {
                list.add(&[&LLDP, &[3, 8, 1, column]], &[IPV4, 4, a, b, c, d], value);
            }
        }
    }

    /// The neighbour at port 1, until its announcement is no longer valid.
    fn lldp_remote(&self, now: Time, list: &mut MibList) {
        let Some(of) = self.lldp.announcement(now) else { return };
        // The time mark, the number of the port, and the number of the neighbour.
        let index = [0, 1, 1];
        let values = [
            MibValue::Integer(of.chassis.0.into()),
            octets(&of.chassis.1),
            MibValue::Integer(of.port.0.into()),
            octets(&of.port.1),
            octets(&of.port_description),
            octets(&of.system_name),
            octets(&of.system_description),
            octets(&of.capabilities.0.reverse_bits().to_be_bytes()),
            octets(&of.capabilities.1.reverse_bits().to_be_bytes()),
        ];
        for (column, value) in (4..).zip(values) {
            list.add(&[&LLDP, &[4, 1, 1, column]], &index, value);
        }
        let station = self.neighbour().map_or(&[][..], |neighbour| neighbour.name.as_slice());
        list.pno_row(3, &index, station);
    }
}
