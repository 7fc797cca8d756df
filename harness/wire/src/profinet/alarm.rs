//! Alarm PDUs (RTA), with frame ID 0xFC01 (high) or 0xFE01 (low) on EtherType 0x8892.
//!
//! The RTA header implements a window of one with sequence numbers and acknowledgements; alarm notifications and their
//! acknowledgements by the application are in DATA, the end of an AR is in ERR. Source: IEC 61158-6-10, RTA-PDU and
//! AlarmNotification-PDU.

use super::blocks::{BlockHeader, BlockType};
use super::diagnosis::AlarmItem;
use super::status::PnioStatus;
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The type of an alarm; unknown numbers are preserved.
    pub struct AlarmType(u16) {
        0x0001 DIAGNOSIS diagnosis "A diagnosis appeared or changed.",
        0x0002 PROCESS process "An event in the process.",
        0x0003 PULL pull "A submodule was pulled.",
        0x0004 PLUG plug "A submodule was plugged.",
        0x0005 STATUS status "A state changed that is not a fault.",
        0x0006 UPDATE update "A parameter changed.",
        0x0007 REDUNDANCY redundancy "The primary AR of a redundant pair changed.",
        0x0008 CONTROLLED_BY_SUPERVISOR controlled_by_supervisor "A supervisor took control of a submodule.",
        0x0009 RELEASED released "A submodule can be used again.",
        0x000A PLUG_WRONG plug_wrong "A submodule was plugged that is not the expected one.",
        0x000B RETURN_OF_SUBMODULE return_of_submodule "A submodule delivers good data again.",
        0x000C DIAGNOSIS_DISAPPEARS diagnosis_disappears "A diagnosis disappeared.",
        0x000D MULTICAST_MISMATCH multicast_mismatch "Multicast communication does not work as configured.",
        0x000E PORT_DATA_CHANGE port_data_change "The state of a port changed.",
        0x000F SYNC_DATA_CHANGE sync_data_change "The state of the synchronisation changed.",
        0x0010 ISOCHRONOUS_PROBLEM isochronous_problem "Isochronous operation has a problem.",
        0x0011 NETWORK_PROBLEM network_problem "A network component has a problem.",
        0x0012 TIME_DATA_CHANGE time_data_change "The state of the time synchronisation changed.",
        0x0013 FRAME_PACKING_PROBLEM frame_packing_problem "Dynamic frame packing has a problem.",
        0x0014 MEDIA_REDUNDANCY_PROBLEM media_redundancy_problem "Media redundancy with planned duplication has a problem.",
        0x0015 MULTIPLE_INTERFACE_PROBLEM multiple_interface_problem "Several interfaces do not match each other.",
        0x001E UPLOAD_AND_RETRIEVAL upload_and_retrieval "The device requests an upload or a retrieval of parameters.",
        0x001F PULL_MODULE pull_module "A module was pulled with all its submodules.",
    }
}

codes! {
    /// The kind of an RTA PDU: the low four bits of its PDU type; unknown numbers are preserved.
    pub struct RtaKind(u8) {
        0x1 DATA data "An alarm notification or its acknowledgement.",
        0x2 NACK nack "The transport rejects a DATA PDU.",
        0x3 ACK ack "The transport acknowledges a DATA PDU.",
        0x4 ERR err "The sender ends the AR.",
    }
}

/// The priority of an alarm; each priority has its own frame ID, sequence numbers and block types.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AlarmPriority {
    /// Frame ID 0xFE01, VLAN priority 5.
    Low,
    /// Frame ID 0xFC01, VLAN priority 6.
    High,
}

/// The alarm specifier: sequence number of the alarm and diagnosis state of the submodule.
///
/// Bits 0-10 sequence number, 11 channel diagnosis, 12 manufacturer diagnosis, 13 submodule diagnosis state, 14 reserved,
/// 15 AR diagnosis state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AlarmSpecifier(pub u16);

/// The header of an RTA PDU without its length.
///
/// Bytes: 0-1 destination endpoint, 2-3 source endpoint, 4 PDU type (version high, kind low nibble), 5 flags, 6-7 send
/// sequence number, 8-9 acknowledged sequence number, 10-11 length of the variable part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RtaHeader {
    /// AlarmDstEndpoint: the alarm reference of the receiver.
    pub dst_endpoint: u16,
    /// AlarmSrcEndpoint: the alarm reference of the sender.
    pub src_endpoint: u16,
    /// Version of the protocol, 0 to 15; normally 1.
    pub version: u8,
    /// The kind of the PDU.
    pub kind: RtaKind,
    /// AddFlags: bits 0-3 window size (1), bit 4 TACK, immediate acknowledgement requested.
    pub add_flags: u8,
    /// SendSeqNum: starts with 0xFFFF, then counts from 0 to 0x7FFF.
    pub send_seq_num: u16,
    /// AckSeqNum: the last sequence number received in order, 0xFFFE at first.
    pub ack_seq_num: u16,
}

/// An RTA PDU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RtaPdu {
    /// The header.
    pub header: RtaHeader,
    /// The variable part.
    pub body: RtaBody,
}

/// The variable part of an RTA PDU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RtaBody {
    /// An alarm: DATA with a block 0x0001 or 0x0002.
    Notification(AlarmNotification),
    /// The acknowledgement of an alarm by the application: DATA with a block 0x8001 or 0x8002.
    Acknowledgement(AlarmAck),
    /// The reason for the end of the AR: ERR. Bytes: 0-3 status, then optional additions of the sender.
    Error {
        /// The reason.
        status: PnioStatus,
        /// Bytes after the status; normally empty.
        more: Vec<u8>,
    },
    /// Anything else: empty in ACK and NACK, unparsed bytes in other kinds.
    Octets(Vec<u8>),
}

/// An alarm: block 0x0001 (high) or 0x0002 (low).
///
/// Bytes after the block header: 0-1 type, 2-5 API, 6-7 slot, 8-9 subslot, 10-13 module ident, 14-17 submodule ident,
/// 18-19 specifier, then the items.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlarmNotification {
    /// The priority.
    pub priority: AlarmPriority,
    /// The type of the alarm.
    pub alarm_type: AlarmType,
    /// The API of the submodule, which identifies its profile: 0, or 0x3D00 for encoders.
    pub api: u32,
    /// Slot of the submodule.
    pub slot: u16,
    /// Subslot of the submodule.
    pub subslot: u16,
    /// ModuleIdentNumber of the plugged module.
    pub module_ident: u32,
    /// SubmoduleIdentNumber of the plugged submodule.
    pub submodule_ident: u32,
    /// Sequence number and diagnosis state of the submodule.
    pub specifier: AlarmSpecifier,
    /// The alarm items.
    pub items: Vec<AlarmItem>,
}

/// The acknowledgement of an alarm by the application: block 0x8001 (high) or 0x8002 (low).
///
/// Bytes after the block header: 0-1 type, 2-5 API, 6-7 slot, 8-9 subslot, 10-11 specifier, 12-15 status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlarmAck {
    /// The priority.
    pub priority: AlarmPriority,
    /// The type of the alarm.
    pub alarm_type: AlarmType,
    /// The API of the alarm.
    pub api: u32,
    /// The slot of the alarm.
    pub slot: u16,
    /// The subslot of the alarm.
    pub subslot: u16,
    /// The specifier of the alarm.
    pub specifier: AlarmSpecifier,
    /// All zero if the alarm was accepted; otherwise the error.
    pub status: PnioStatus,
}

impl AlarmPriority {
    /// The frame ID of this priority.
    pub fn frame_id(self) -> u16 {
        match self {
            AlarmPriority::High => 0xFC01,
            AlarmPriority::Low => 0xFE01,
        }
    }

    /// The priority of a frame ID; `None` for other frame IDs.
    pub fn from_frame_id(frame_id: u16) -> Option<AlarmPriority> {
        match frame_id {
            0xFC01 => Some(AlarmPriority::High),
            0xFE01 => Some(AlarmPriority::Low),
            _ => None,
        }
    }

    /// The block of an alarm of this priority.
    pub fn notification_block(self) -> BlockType {
        match self {
            AlarmPriority::High => BlockType::ALARM_NOTIFICATION_HIGH,
            AlarmPriority::Low => BlockType::ALARM_NOTIFICATION_LOW,
        }
    }

    /// The block of an acknowledgement of this priority.
    pub fn ack_block(self) -> BlockType {
        match self {
            AlarmPriority::High => BlockType::ALARM_ACK_HIGH,
            AlarmPriority::Low => BlockType::ALARM_ACK_LOW,
        }
    }
}

impl AlarmSpecifier {
    /// A channel diagnosis is pending on the submodule.
    pub const CHANNEL_DIAGNOSIS: u16 = 0x0800;
    /// A manufacturer-specific diagnosis is pending on the submodule.
    pub const MANUFACTURER_DIAGNOSIS: u16 = 0x1000;
    /// A diagnosis of severity fault is pending on the submodule.
    pub const SUBMODULE_DIAGNOSIS_STATE: u16 = 0x2000;
    /// A diagnosis of severity fault is pending somewhere in the AR.
    pub const AR_DIAGNOSIS_STATE: u16 = 0x8000;

    /// A specifier with this sequence number, truncated to 11 bits, and these flags.
    pub fn new(sequence_number: u16, flags: u16) -> AlarmSpecifier {
        AlarmSpecifier(sequence_number & 0x07FF | flags & 0xF800)
    }

    /// The sequence number of the alarm, 0 to 2047.
    pub fn sequence_number(self) -> u16 {
        self.0 & 0x07FF
    }

    /// Whether a channel diagnosis is pending on the submodule.
    pub fn channel_diagnosis(self) -> bool {
        self.0 & Self::CHANNEL_DIAGNOSIS != 0
    }

    /// Whether a manufacturer-specific diagnosis is pending on the submodule.
    pub fn manufacturer_diagnosis(self) -> bool {
        self.0 & Self::MANUFACTURER_DIAGNOSIS != 0
    }

    /// Whether a diagnosis of severity fault is pending on the submodule.
    pub fn submodule_diagnosis_state(self) -> bool {
        self.0 & Self::SUBMODULE_DIAGNOSIS_STATE != 0
    }

    /// Whether a diagnosis of severity fault is pending somewhere in the AR.
    pub fn ar_diagnosis_state(self) -> bool {
        self.0 & Self::AR_DIAGNOSIS_STATE != 0
    }
}

impl RtaHeader {
    /// The flag of [`RtaHeader::add_flags`] that requests an immediate acknowledgement.
    pub const TACK: u8 = 0x10;

    /// A header of version 1 with a window of 1; TACK is set only in DATA.
    pub fn new(kind: RtaKind, dst_endpoint: u16, src_endpoint: u16, send_seq_num: u16, ack_seq_num: u16) -> RtaHeader {
        let add_flags = if kind == RtaKind::DATA { 0x01 | Self::TACK } else { 0x01 };
        RtaHeader { dst_endpoint, src_endpoint, version: 1, kind, add_flags, send_seq_num, ack_seq_num }
    }

    /// The window size, 1 to 15.
    pub fn window_size(&self) -> u8 {
        self.add_flags & 0x0F
    }

    /// Whether an immediate acknowledgement is requested.
    pub fn tack(&self) -> bool {
        self.add_flags & Self::TACK != 0
    }
}

impl RtaPdu {
    /// Parses the bytes after the frame ID; bytes after the variable part are padding of the frame and are ignored.
    ///
    /// Blocks of another type or version than 1.0 are preserved as bytes. Fails if bytes are missing or a known block is
    /// inconsistent.
    pub fn parse(octets: &[u8]) -> Result<RtaPdu> {
        let mut reader = ByteReader::new("alarm", octets);
        let (dst_endpoint, src_endpoint) = (reader.u16()?, reader.u16()?);
        let pdu_type = reader.u8()?;
        let header = RtaHeader {
            dst_endpoint,
            src_endpoint,
            version: pdu_type >> 4,
            kind: RtaKind(pdu_type & 0x0F),
            add_flags: reader.u8()?,
            send_seq_num: reader.u16()?,
            ack_seq_num: reader.u16()?,
        };
        let length = reader.u16()?;
        let mut part = reader.sub(length.into())?;
        let body = match header.kind {
            RtaKind::DATA => RtaBody::read_data(&mut part)?,
            RtaKind::ERR => RtaBody::Error { status: PnioStatus::read(&mut part)?, more: part.rest().to_vec() },
            _ => RtaBody::Octets(part.rest().to_vec()),
        };
        Ok(RtaPdu { header, body })
    }

    /// Appends the PDU without its frame ID; fills in the length of the variable part.
    pub fn write(&self, out: &mut Vec<u8>) {
        let RtaHeader { dst_endpoint, src_endpoint, version, kind, add_flags, send_seq_num, ack_seq_num } = self.header;
        out.put_u16(dst_endpoint);
        out.put_u16(src_endpoint);
        out.put(&[version << 4 | kind.0 & 0x0F, add_flags]);
        out.put_u16(send_seq_num);
        out.put_u16(ack_seq_num);
        let mut part = Vec::new();
        match &self.body {
            RtaBody::Notification(notification) => notification.write(&mut part),
            RtaBody::Acknowledgement(ack) => ack.write(&mut part),
            RtaBody::Error { status, more } => {
                status.write(&mut part);
                part.put(more);
            }
            RtaBody::Octets(octets) => part.put(octets),
        }
        out.put_u16(part.len() as u16);
        out.put(&part);
    }
}

impl RtaBody {
    fn read_data(reader: &mut ByteReader<'_>) -> Result<RtaBody> {
        let mut lookahead = *reader;
        let (header, mut block) = BlockHeader::read(&mut lookahead)?;
        let priority = match header.kind {
            BlockType::ALARM_NOTIFICATION_HIGH | BlockType::ALARM_ACK_HIGH => AlarmPriority::High,
            BlockType::ALARM_NOTIFICATION_LOW | BlockType::ALARM_ACK_LOW => AlarmPriority::Low,
            _ => return Ok(RtaBody::Octets(reader.rest().to_vec())),
        };
        if (header.version_high, header.version_low) != (1, 0) || !lookahead.is_empty() {
            return Ok(RtaBody::Octets(reader.rest().to_vec()));
        }
        if header.kind == priority.ack_block() {
            let ack = AlarmAck::read(priority, &mut block)?;
            // Bytes after an acknowledgement do not belong to it; the whole PDU is then preserved unparsed.
            return Ok(if block.is_empty() {
                RtaBody::Acknowledgement(ack)
            } else {
                RtaBody::Octets(reader.rest().to_vec())
            });
        }
        Ok(RtaBody::Notification(AlarmNotification::read(priority, &mut block)?))
    }
}

impl AlarmNotification {
    /// The acknowledgement of this alarm.
    pub fn acknowledgement(&self, status: PnioStatus) -> AlarmAck {
        let AlarmNotification { priority, alarm_type, api, slot, subslot, specifier, .. } = *self;
        AlarmAck { priority, alarm_type, api, slot, subslot, specifier, status }
    }

    fn read(priority: AlarmPriority, reader: &mut ByteReader<'_>) -> Result<AlarmNotification> {
        Ok(AlarmNotification {
            priority,
            alarm_type: AlarmType(reader.u16()?),
            api: reader.u32()?,
            slot: reader.u16()?,
            subslot: reader.u16()?,
            module_ident: reader.u32()?,
            submodule_ident: reader.u32()?,
            specifier: AlarmSpecifier(reader.u16()?),
            items: AlarmItem::read_all(reader)?,
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(self.priority.notification_block(), out, |out| {
            out.put_u16(self.alarm_type.0);
            out.put_u32(self.api);
            out.put_u16(self.slot);
            out.put_u16(self.subslot);
            out.put_u32(self.module_ident);
            out.put_u32(self.submodule_ident);
            out.put_u16(self.specifier.0);
            self.items.iter().for_each(|item| item.write(out));
        });
    }
}

impl AlarmAck {
    fn read(priority: AlarmPriority, reader: &mut ByteReader<'_>) -> Result<AlarmAck> {
        Ok(AlarmAck {
            priority,
            alarm_type: AlarmType(reader.u16()?),
            api: reader.u32()?,
            slot: reader.u16()?,
            subslot: reader.u16()?,
            specifier: AlarmSpecifier(reader.u16()?),
            status: PnioStatus::read(reader)?,
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(self.priority.ack_block(), out, |out| {
            out.put_u16(self.alarm_type.0);
            out.put_u32(self.api);
            out.put_u16(self.slot);
            out.put_u16(self.subslot);
            out.put_u16(self.specifier.0);
            self.status.write(out);
        });
    }
}
