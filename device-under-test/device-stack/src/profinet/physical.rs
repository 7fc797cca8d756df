//! The records of the interface and the ports: 0x8080, 0x802A and 0xF841.

use super::lldp::FAST_ETHERNET;
use super::plugged::{INTERFACE_SUBSLOT, PORT_SUBSLOT, SubmoduleAddress};
use super::stack::Stack;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use wire::ethernet::Mac;
use wire::profinet::blocks::physical::{InterfaceDataReal, MultipleBlock, Peer, PortDataReal};

const PORT_STATE_UNKNOWN: u8 = 0;
const LINK_UP: u8 = 1;
const LINK_DOWN: u8 = 2;
const COPPER: u32 = 1;

/// The MAC address of port `number`, from 1: that of the device, `station`, plus `number`. Only the last three bytes
/// are counted.
pub fn port_mac(station: Mac, number: u16) -> Mac {
    let Mac([a, b, c, d, e, f]) = station;
    let [_, d, e, f] = (u32::from_be_bytes([0, d, e, f]) + u32::from(number)).to_be_bytes();
    Mac([a, b, c, d, e, f])
}

/// The name of the port at `subslot`.
pub(super) fn port_name(subslot: u16) -> String {
    format!("port-{:03}", subslot - INTERFACE_SUBSLOT)
}

impl Stack {
    /// The MAC address of the port at `subslot`.
    pub(super) fn port_mac(&self, subslot: u16) -> Mac {
        port_mac(self.retained.mac, subslot - INTERFACE_SUBSLOT)
    }

    /// The PDInterfaceDataReal block.
    pub(super) fn interface(&self) -> InterfaceDataReal {
        InterfaceDataReal {
            chassis: self.station.name.clone(),
            mac: self.retained.mac,
            address: Ipv4Addr::from(self.station.ip),
            mask: Ipv4Addr::from(self.station.mask),
            gateway: Ipv4Addr::from(self.station.gateway),
        }
    }

    /// The PDPortDataReal block of the port at `place`, if it exists. The cable is in the first port, because the
    /// request came through it.
    pub(super) fn port(&self, place: SubmoduleAddress) -> Option<PortDataReal> {
        let plug = self.plugged.ports().find(|plug| SubmoduleAddress::from(*plug) == place)?;
        let is_linked = plug.subslot == PORT_SUBSLOT;
        let peers = self.neighbour().filter(|_| is_linked).map(|neighbour| Peer {
            port: neighbour.port.clone(),
            chassis: neighbour.chassis().into_owned(),
            line_delay: 0,
            mac: neighbour.mac,
        });
        Some(PortDataReal {
            slot: place.slot,
            subslot: place.subslot,
            port: port_name(plug.subslot).into_bytes(),
            peers: peers.into_iter().collect(),
            mau_type: if is_linked { FAST_ETHERNET } else { 0 },
            domain_boundary: self.domain_boundary(place),
            multicast_boundary: 0,
            port_state: PORT_STATE_UNKNOWN,
            link_state: if is_linked { LINK_UP } else { LINK_DOWN },
            media_type: COPPER,
        })
    }

    /// The blocks of the interface and all ports.
    pub(super) fn physical(&self) -> Vec<MultipleBlock> {
        let block = |place: SubmoduleAddress, write: &dyn Fn(&mut Vec<u8>)| {
            let mut blocks = Vec::new();
            write(&mut blocks);
            MultipleBlock { api: place.api, slot: place.slot, subslot: place.subslot, blocks }
        };
        let interface = SubmoduleAddress { api: 0, slot: 0, subslot: INTERFACE_SUBSLOT };
        let places = self.plugged.ports().map(SubmoduleAddress::from);
        let ports = places.map(|place| block(place, &|out| self.port(place).iter().for_each(|port| port.write(out))));
        core::iter::once(block(interface, &|out| self.interface().write(out))).chain(ports).collect()
    }
}
