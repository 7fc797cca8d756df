//! LLDP as PROFINET devices send it: who is at the other end of the cable (IEEE 802.1AB; IEC 61158-6-10, LLDP).
//!
//! This room must not know ports or neighbours.

use crate::error::Result;
use crate::ethernet::{EtherType, FrameHeader, Mac, pad};
use crate::octets::{Append, Reader};
use alloc::vec::Vec;

/// An organisation in an organisationally specific TLV.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Oui(pub [u8; 3]);

impl Oui {
    /// PROFIBUS and PROFINET International.
    pub const PNO: Oui = Oui([0x00, 0x0e, 0xcf]);
    /// IEEE 802.3.
    pub const IEEE_802_3: Oui = Oui([0x00, 0x12, 0x0f]);
}

/// One piece of an LLDP frame.
///
/// Octets: 0-1 type in bits 15-9 and length in bits 8-0, then the value; in an organisationally specific one (type 127)
/// the value begins with three octets of organisation and one of subtype.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tlv {
    /// Type 1: who sends.
    ChassisId {
        /// 4 MAC address, 7 locally assigned (the name of station).
        subtype: u8,
        /// The identity.
        id: Vec<u8>,
    },
    /// Type 2: from which port.
    PortId {
        /// 7 locally assigned (`port-001` or `port-001.name`).
        subtype: u8,
        /// The identity.
        id: Vec<u8>,
    },
    /// Type 3: how long this is true, in seconds.
    TimeToLive(u16),
    /// Type 4: the port in words.
    PortDescription(Vec<u8>),
    /// Type 5: the name of the system.
    SystemName(Vec<u8>),
    /// Type 6: the system in words.
    SystemDescription(Vec<u8>),
    /// Type 7: what the system can be and what it is; bit 7 station only.
    SystemCapabilities {
        /// What it can be.
        capabilities: u16,
        /// What it is.
        enabled: u16,
    },
    /// Type 8: the address for management, opaque.
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
    /// IEEE 802.3 subtype 1: autonegotiation and the kind of the line.
    MacPhy {
        /// Bit 0 autonegotiation supported, bit 1 enabled.
        autonegotiation: u8,
        /// What autonegotiation offers.
        advertised: u16,
        /// The kind of the line (RFC 4836, dot3MauType): 16 is 100BASE-TX full duplex, 30 is 1000BASE-T full duplex.
        mau_type: u16,
    },
    /// Type 127 with another organisation or subtype, or of an unexpected length.
    Organizational {
        /// Whose.
        oui: Oui,
        /// Which of theirs.
        subtype: u8,
        /// What it says.
        octets: Vec<u8>,
    },
    /// Another type, or a known one of an unexpected length.
    Raw {
        /// 0..=127.
        kind: u8,
        /// What it says.
        octets: Vec<u8>,
    },
}

impl Tlv {
    /// Subtype of a chassis id that is a MAC address.
    pub const CHASSIS_MAC_ADDRESS: u8 = 4;
    /// Subtype of a chassis or port id that the sender has assigned.
    pub const LOCALLY_ASSIGNED: u8 = 7;

    const ORGANIZATIONAL: u8 = 127;

    fn parse(kind: u8, octets: &[u8]) -> Tlv {
        let mut reader = Reader::new("LLDP", octets);
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

    fn known(kind: u8, reader: &mut Reader<'_>) -> Result<Option<Tlv>> {
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

    /// Appends the TLV; a value of more than 511 octets does not fit its length field and is cut.
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

/// An LLDP data unit: TLVs up to the one that ends it, which is not listed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lldp {
    /// The TLVs in their order; chassis id, port id and time to live are to be the first three.
    pub tlvs: Vec<Tlv>,
}

impl Lldp {
    /// Reads the payload of a frame of [`EtherType::LLDP`] up to the end TLV or the end of the octets.
    pub fn parse(payload: &[u8]) -> Result<Lldp> {
        let mut reader = Reader::new("LLDP", payload);
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

    /// Appends all TLVs and the one that ends them.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.tlvs.iter().for_each(|tlv| tlv.write(out));
        out.put_u16(0);
    }

    /// Appends the whole frame to the nearest bridge, untagged and padded.
    pub fn write_frame(&self, source: Mac, out: &mut Vec<u8>) {
        let start = out.len();
        FrameHeader::new(Mac::LLDP_MULTICAST, source, EtherType::LLDP).write(out);
        self.write(out);
        pad(out, start);
    }
}
