//! LLDP as PROFINET devices send it, for neighbour detection (IEEE 802.1AB; IEC 61158-6-10, LLDP).
//!
//! This module must not know ports or neighbours.

use crate::error::Result;
use crate::ethernet::{EtherType, FrameHeader, Mac, pad};
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// The organisation (OUI) in an organisationally specific TLV.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Oui(pub [u8; 3]);

impl Oui {
    /// PROFIBUS and PROFINET International.
    pub const PNO: Oui = Oui([0x00, 0x0e, 0xcf]);
    /// IEEE 802.3.
    pub const IEEE_802_3: Oui = Oui([0x00, 0x12, 0x0f]);
}

/// A TLV (type, length, value) of an LLDP frame.
///
/// Bytes: 0-1 type in bits 15-9 and length in bits 8-0, then the value; in an organisationally specific one (type 127)
/// the value begins with three bytes of organisation and one of subtype.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tlv {
    /// Type 1: the chassis ID of the sender.
    ChassisId {
        /// 4 MAC address, 7 locally assigned (the name of station).
        subtype: u8,
        /// The ID.
        id: Vec<u8>,
    },
    /// Type 2: the ID of the sending port.
    PortId {
        /// 7 locally assigned (`port-001` or `port-001.name`).
        subtype: u8,
        /// The ID.
        id: Vec<u8>,
    },
    /// Type 3: how long the information is valid, in seconds.
    TimeToLive(u16),
    /// Type 4: a description of the port.
    PortDescription(Vec<u8>),
    /// Type 5: the name of the system.
    SystemName(Vec<u8>),
    /// Type 6: a description of the system.
    SystemDescription(Vec<u8>),
    /// Type 7: supported and enabled functions of the system; bit 7 station only.
    SystemCapabilities {
        /// Supported functions.
        capabilities: u16,
        /// Enabled functions.
        enabled: u16,
    },
    /// Type 8: the management address, not parsed.
    ManagementAddress(Vec<u8>),
    /// PI subtype 1: measured delays in nanoseconds: receive local and remote, transmit local and remote, cable.
    PortDelays([u32; 5]),
    /// PI subtype 2: states of the port for RT_CLASS_2 and RT_CLASS_3.
    PortStatus {
        /// Bits for RT_CLASS_2; 0 off.
        rt_class_2: u16,
        /// Bits for RT_CLASS_3; 0 off.
        rt_class_3: u16,
    },
    /// PI subtype 5: the MAC address of the device, which the ports share.
    ChassisMac(Mac),
    /// IEEE 802.3 subtype 1: autonegotiation and MAU type.
    MacPhy {
        /// Bit 0 autonegotiation supported, bit 1 enabled.
        autonegotiation: u8,
        /// The capabilities that autonegotiation advertises.
        advertised: u16,
        /// The MAU type (RFC 4836, dot3MauType): 16 is 100BASE-TX full duplex, 30 is 1000BASE-T full duplex.
        mau_type: u16,
    },
    /// Type 127 with another organisation or subtype, or of an unexpected length.
    Organizational {
        /// The organisation.
        oui: Oui,
        /// The subtype of the organisation.
        subtype: u8,
        /// The value.
        octets: Vec<u8>,
    },
    /// Another type, or a known one of an unexpected length.
    Raw {
        /// The type, 0..=127.
        kind: u8,
        /// The value.
        octets: Vec<u8>,
    },
}

impl Tlv {
    /// Subtype of a chassis ID that is a MAC address.
    pub const CHASSIS_MAC_ADDRESS: u8 = 4;
    /// Subtype of a chassis or port ID that the sender has assigned.
    pub const LOCALLY_ASSIGNED: u8 = 7;

    const ORGANIZATIONAL: u8 = 127;

    fn parse(kind: u8, octets: &[u8]) -> Tlv {
        let mut reader = ByteReader::new("LLDP", octets);
        match Tlv::known(kind, &mut reader) {
            Ok(Some(tlv)) if reader.is_empty() => tlv,
            _ => match octets {
                [a, b, c, subtype, rest @ ..] if kind == Tlv::ORGANIZATIONAL => {
                    Tlv::Organizational { oui: Oui([*a, *b, *c]), subtype: *subtype, octets: rest.into() }
                }
                _ => Tlv::Raw { kind, octets: octets.into() },
            },
        }
    }

    fn known(kind: u8, reader: &mut ByteReader<'_>) -> Result<Option<Tlv>> {
        Ok(Some(match kind {
            1 => Tlv::ChassisId { subtype: reader.u8()?, id: reader.rest().into() },
            2 => Tlv::PortId { subtype: reader.u8()?, id: reader.rest().into() },
            3 => Tlv::TimeToLive(reader.u16()?),
            4 => Tlv::PortDescription(reader.rest().into()),
            5 => Tlv::SystemName(reader.rest().into()),
            6 => Tlv::SystemDescription(reader.rest().into()),
            7 => Tlv::SystemCapabilities { capabilities: reader.u16()?, enabled: reader.u16()? },
            8 => Tlv::ManagementAddress(reader.rest().into()),
            Tlv::ORGANIZATIONAL => match (Oui(reader.array()?), reader.u8()?) {
                (Oui::PNO, 1) => {
                    let mut delays = [0; 5];
                    for delay in &mut delays {
                        *delay = reader.u32()?;
                    }
                    Tlv::PortDelays(delays)
                }
                (Oui::PNO, 2) => Tlv::PortStatus { rt_class_2: reader.u16()?, rt_class_3: reader.u16()? },
                (Oui::PNO, 5) => Tlv::ChassisMac(Mac::read(reader)?),
                (Oui::IEEE_802_3, 1) => {
                    Tlv::MacPhy { autonegotiation: reader.u8()?, advertised: reader.u16()?, mau_type: reader.u16()? }
                }
                _ => return Ok(None),
            },
            _ => return Ok(None),
        }))
    }

    fn kind(&self) -> u8 {
        match self {
            Tlv::ChassisId { .. } => 1,
            Tlv::PortId { .. } => 2,
            Tlv::TimeToLive(_) => 3,
            Tlv::PortDescription(_) => 4,
            Tlv::SystemName(_) => 5,
            Tlv::SystemDescription(_) => 6,
            Tlv::SystemCapabilities { .. } => 7,
            Tlv::ManagementAddress(_) => 8,
            Tlv::PortDelays(_)
            | Tlv::PortStatus { .. }
            | Tlv::ChassisMac(_)
            | Tlv::MacPhy { .. }
            | Tlv::Organizational { .. } => Tlv::ORGANIZATIONAL,
            Tlv::Raw { kind, .. } => *kind & 0x7f,
        }
    }

    /// Appends the TLV; cuts a value of more than 511 bytes, the maximum of the length field.
    pub fn write(&self, out: &mut Vec<u8>) {
        let start = out.len();
        out.put_u16(0);
        let organization = |out: &mut Vec<u8>, oui: Oui, subtype: u8| {
            out.put(&oui.0);
            out.put_u8(subtype);
        };
        match self {
            Tlv::ChassisId { subtype, id } | Tlv::PortId { subtype, id } => {
                out.put_u8(*subtype);
                out.put(id);
            }
            Tlv::TimeToLive(seconds) => out.put_u16(*seconds),
            Tlv::PortDescription(octets)
            | Tlv::SystemName(octets)
            | Tlv::SystemDescription(octets)
            | Tlv::ManagementAddress(octets)
            | Tlv::Raw { octets, .. } => out.put(octets),
            Tlv::SystemCapabilities { capabilities, enabled } => {
                out.put_u16(*capabilities);
                out.put_u16(*enabled);
            }
            Tlv::PortDelays(delays) => {
                organization(out, Oui::PNO, 1);
                delays.iter().for_each(|delay| out.put_u32(*delay));
            }
            Tlv::PortStatus { rt_class_2, rt_class_3 } => {
                organization(out, Oui::PNO, 2);
                out.put_u16(*rt_class_2);
                out.put_u16(*rt_class_3);
            }
            Tlv::ChassisMac(mac) => {
                organization(out, Oui::PNO, 5);
                out.put(&mac.0);
            }
            Tlv::MacPhy { autonegotiation, advertised, mau_type } => {
                organization(out, Oui::IEEE_802_3, 1);
                out.put_u8(*autonegotiation);
                out.put_u16(*advertised);
                out.put_u16(*mau_type);
            }
            Tlv::Organizational { oui, subtype, octets } => {
                organization(out, *oui, *subtype);
                out.put(octets);
            }
        }
        out.truncate(start + 2 + 511);
        let head = (u16::from(self.kind()) << 9) | (out.len() - start - 2) as u16;
        out[start..start + 2].copy_from_slice(&head.to_be_bytes());
    }
}

/// An LLDP data unit: its TLVs without the End TLV.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lldp {
    /// The TLVs in order; the first three must be chassis ID, port ID and time to live.
    pub tlvs: Vec<Tlv>,
}

impl Lldp {
    /// Parses the payload of a frame of [`EtherType::LLDP`] up to the End TLV or the end of the payload.
    pub fn parse(payload: &[u8]) -> Result<Lldp> {
        let mut reader = ByteReader::new("LLDP", payload);
        let mut tlvs = Vec::new();
        while !reader.is_empty() {
            let head = reader.u16()?;
            if head == 0 {
                break;
            }
            tlvs.push(Tlv::parse((head >> 9) as u8, reader.take(usize::from(head & 0x01ff))?));
        }
        Ok(Lldp { tlvs })
    }

    /// Appends all TLVs and the End TLV.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.tlvs.iter().for_each(|tlv| tlv.write(out));
        out.put_u16(0);
    }

    /// Appends a whole frame to [`Mac::LLDP_MULTICAST`], untagged and padded.
    pub fn write_frame(&self, source: Mac, out: &mut Vec<u8>) {
        let start = out.len();
        FrameHeader::new(Mac::LLDP_MULTICAST, source, EtherType::LLDP).write(out);
        self.write(out);
        pad(out, start);
    }
}
