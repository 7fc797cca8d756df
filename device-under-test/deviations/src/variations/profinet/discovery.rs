//! DCP, LLDP and ARP of a PROFINET device.

use super::state::{AnnouncesAddress, repeat};
use crate::needs::Need;
use crate::seams::late::FrameTopic;
use crate::seams::stack::{Stack, change_dcp};
use crate::tables::Group;
use alloc::vec::Vec;
use core::time::Duration;
use wire::lldp::{Lldp, Tlv};
use wire::profinet::dcp::{Dcp, DcpBlock, DcpValue, Element, ServiceId};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            // DCP
            "identify-blocks-reversed" "The blocks of an Identify response come in reverse order."
                "IEC 61158-6-10, DCP Identify: the blocks come in any order"
                => |d| identify(&mut d.stack, |blocks| blocks.reverse());
            "identify-by-option" "The blocks of an Identify response come in the order of their options, the address first."
                "IEC 61158-6-10, DCP Identify: the blocks come in any order"
                => |d| identify(&mut d.stack, |blocks| blocks.sort_by_key(|block| {
                    let element = block.value.element();
                    (element.option, element.suboption)
                }));
            "identify-without-instance" "An Identify response has no DeviceInstance and no DeviceInitiative."
                "IEC 61158-6-10, DCP Identify: both blocks are optional"
                => |d| identify(&mut d.stack, |blocks| blocks.retain(|block| {
                    !matches!(block.value.element(), Element::DEVICE_INSTANCE | Element::DEVICE_INITIATIVE)
                }));
            "identify-with-own-block" "An Identify response has a block of the manufacturer."
                "IEC 61158-6-10, DCP Identify: options 0x80 to 0xFE belong to the manufacturer"
                => |d| identify(&mut d.stack, |blocks| {
                    let element = Element { option: 0x80, suboption: 1 };
                    blocks.push(DcpBlock::plain(DcpValue::Raw { element, octets: [0, 0, 1, 2, 3, 4].into() }));
                });
            "identify-answered-twice" "DCP Identify is answered twice, the second time after 5 ms, as over two paths of a ring."
                "IEC 61158-6-10, DCP Identify: a client takes any number of responses and compares their MAC addresses"
                => |d| d.late.added(|topic, frame| repeat(topic, frame, FrameTopic::Identify, Duration::from_millis(5)));

            // LLDP
            "lldp-chassis-is-mac" "LLDP announces the MAC address as chassis ID and the name within the port ID."
                "IEC 61158-6-10, LLDP_ChassisID: name of station or MAC address; PROFINET from V2.3 on, port.name"
                => |d| d.stack.lldp(chassis_is_mac);
            "lldp-port-id-short" "LLDP announces the name as chassis ID and the port without the name."
                "IEC 61158-6-10, LLDP_PortID: up to PROFINET V2.2, the port alone"
                => |d| d.stack.lldp(short_port_id);
            "lldp-with-system" "LLDP also carries port description, system name, system description, capabilities and management address."
                "IEEE 802.1AB: these TLVs are optional"
                => |d| d.stack.lldp(with_system);
            "lldp-with-delays" "LLDP also carries the measured line delays."
                "IEC 61158-6-10, LLDP_PNIO_DELAY: optional"
                => |d| d.stack.lldp(|lldp| {
                    lldp.tlvs.push(Tlv::PortDelays([0, 0, 0, 0, 0]));
                    true
                });
            "lldp-without-port-status" "LLDP carries no state of the port for RT_CLASS_2 and 3."
                "IEC 61158-6-10, LLDP_PNIO_PORTSTATUS: for devices of conformance class C"
                => |d| d.stack.lldp(|lldp| {
                    lldp.tlvs.retain(|tlv| !matches!(tlv, Tlv::PortStatus { .. }));
                    true
                });
            "lldp-tlvs-reordered" "The organisational TLVs of LLDP come in reverse order."
                "IEEE 802.1AB, 8.2: after the first three the order is free"
                => |d| d.stack.lldp(|lldp| {
                    if let [_, _, _, others @ ..] = &mut lldp.tlvs[..] {
                        others.reverse();
                    }
                    true
                });

            // IP
            "address-announced" "A new IP address is announced by a gratuitous ARP."
                "RFC 5227: announcing an address is recommended"
                => |d| d.stack.add(AnnouncesAddress::default());
        },
    },
    Group {
        // The plain device says Hello on request only.
        needs: &[Need::Profinet, Need::Encoder],
        deviations: permitted! {
            "hello-only-on-request" "The device says no Hello after its start: no record has switched it on."
                "IEC 61158-6-10, FSHelloBlock: without it there is no Hello, and DeviceInitiative is 0"
                => |d| {
                    d.stack.sent_frame(|_, frame| {
                        if let Some((_, dcp)) = crate::seams::stack::dcp(frame)
                            && dcp.service_id == ServiceId::HELLO
                        {
                            frame.clear();
                        }
                    });
                    d.stack.element(|value| match value {
                        DcpValue::DeviceInitiative(_) => DcpValue::DeviceInitiative(0),
                        other => other,
                    });
                };
        },
    },
];

fn identify(stack: &mut Stack, change: fn(&mut Vec<DcpBlock>)) {
    stack.sent_frame(move |_, frame| {
        change_dcp(frame, |dcp: &Dcp, blocks| {
            if dcp.service_id == ServiceId::IDENTIFY {
                change(blocks);
            }
        });
    });
}

/// The name and the port that LLDP announces, whatever its format; `None` without a name.
fn name_and_port(lldp: &Lldp) -> Option<(Vec<u8>, Vec<u8>)> {
    let port = lldp.tlvs.iter().find_map(|tlv| if let Tlv::PortId { id, .. } = tlv { Some(id) } else { None })?;
    let mut parts = port.splitn(2, |byte| *byte == b'.');
    let port = parts.next()?.to_vec();
    let chassis = lldp.tlvs.iter().find_map(|tlv| match tlv {
        Tlv::ChassisId { subtype: Tlv::LOCALLY_ASSIGNED, id } => Some(id.clone()),
        _ => None,
    });
    Some((chassis.or(parts.next().map(Vec::from))?, port))
}

fn chassis_is_mac(lldp: &mut Lldp) -> bool {
    let mac = lldp.tlvs.iter().find_map(|tlv| if let Tlv::ChassisMac(mac) = tlv { Some(*mac) } else { None });
    if let (Some((name, port)), Some(mac)) = (name_and_port(lldp), mac) {
        announce(lldp, (Tlv::CHASSIS_MAC_ADDRESS, &mac.0), &[&port[..], b".", &name].concat());
    }
    true
}

fn short_port_id(lldp: &mut Lldp) -> bool {
    if let Some((name, port)) = name_and_port(lldp) {
        announce(lldp, (Tlv::LOCALLY_ASSIGNED, &name), &port);
    }
    true
}

fn announce(lldp: &mut Lldp, (chassis_type, chassis): (u8, &[u8]), port: &[u8]) {
    for tlv in &mut lldp.tlvs {
        match tlv {
            Tlv::ChassisId { subtype, id } => (*subtype, *id) = (chassis_type, chassis.to_vec()),
            Tlv::PortId { id, .. } => *id = port.to_vec(),
            _ => {}
        }
    }
}

fn with_system(lldp: &mut Lldp) -> bool {
    let name = name_and_port(lldp).map(|(name, _)| name).unwrap_or_default();
    lldp.tlvs.extend([
        Tlv::PortDescription(b"Port 1".to_vec()),
        Tlv::SystemName(name),
        Tlv::SystemDescription(b"Encoder, HW 1, FW V1.0.0".to_vec()),
        Tlv::SystemCapabilities { capabilities: 0x0080, enabled: 0x0080 },
        Tlv::ManagementAddress([5, 1, 192, 168, 20, 40, 2, 0, 0, 0, 1, 0].into()),
    ]);
    true
}
