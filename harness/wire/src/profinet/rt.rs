//! PROFINET RT: frame IDs, and the cyclic frame with APDU status, IOPS and IOCS.
//!
//! This module must not know which submodule owns which bytes of the data: the Connect defines it.

use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// The minimum length of the data of a cyclic frame in bytes; shorter data are padded (IEC 61158-6-10, C_SDU).
pub const SHORTEST_DATA: usize = 40;
/// The maximum length of the data of a cyclic frame in bytes (IEC 61158-6-10, C_SDU).
pub const LONGEST_DATA: usize = 1440;

/// The frame ID of a PROFINET frame: the first two bytes after the EtherType.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FrameId(pub u16);

impl FrameId {
    /// Alarms of high priority.
    pub const ALARM_HIGH: FrameId = FrameId(0xfc01);
    /// Alarms of low priority.
    pub const ALARM_LOW: FrameId = FrameId(0xfe01);
    /// DCP Hello.
    pub const DCP_HELLO: FrameId = FrameId(0xfefc);
    /// DCP Get and Set, requests and responses.
    pub const DCP_GET_SET: FrameId = FrameId(0xfefd);
    /// DCP Identify request.
    pub const DCP_IDENTIFY_REQUEST: FrameId = FrameId(0xfefe);
    /// DCP Identify response.
    pub const DCP_IDENTIFY_RESPONSE: FrameId = FrameId(0xfeff);
    /// Sent by the controller if the device chooses the frame ID of the output CR (IEC 61158-6-10, FrameID in IOCRBlockReq).
    pub const DEVICE_CHOOSES: FrameId = FrameId(0xffff);

    /// The kind of the frame, by the range of its frame ID.
    #[inline]
    pub fn kind(self) -> FrameKind {
        match self.0 {
            0x0020..=0x0021 | 0x0080..=0x0081 | 0xff00..=0xff01 | 0xff20..=0xff21 | 0xff40..=0xff43 => FrameKind::Ptcp,
            0x0100..=0x0fff => FrameKind::RtClass3,
            0x8000..=0xbfff => FrameKind::RtClass2,
            0xc000..=0xfbff => FrameKind::RtClass1,
            0xfc01 => FrameKind::AlarmHigh,
            0xfe01 => FrameKind::AlarmLow,
            0xfe02 => FrameKind::Rsi,
            0xfefc => FrameKind::DcpHello,
            0xfefd => FrameKind::DcpGetSet,
            0xfefe => FrameKind::DcpIdentifyRequest,
            0xfeff => FrameKind::DcpIdentifyResponse,
            0xff80..=0xff8f => FrameKind::Fragment,
            _ => FrameKind::Reserved,
        }
    }

    /// Whether the frame is cyclic data of any class.
    #[inline]
    pub fn is_cyclic(self) -> bool {
        matches!(self.0, 0x0100..=0x0fff | 0x8000..=0xfbff)
    }

    /// Reads the frame ID at the start of the payload of a frame of [`crate::ethernet::EtherType::PROFINET`].
    #[inline]
    pub fn peek(payload: &[u8]) -> Result<FrameId> {
        ByteReader::new("PROFINET RT", payload).u16().map(FrameId)
    }
}

/// The ranges of frame IDs (IEC 61158-6-10, FrameID).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameKind {
    /// Time synchronisation, line delay measurement and their announcements.
    Ptcp,
    /// Cyclic data of RT_CLASS_3 (isochronous).
    RtClass3,
    /// Cyclic data that the Connect calls RT_CLASS_2; newer editions of the standard call it RT_CLASS_1.
    RtClass2,
    /// Cyclic data that the Connect calls RT_CLASS_1, which newer editions of the standard call legacy; also RT_CLASS_UDP.
    RtClass1,
    /// Alarm of high priority.
    AlarmHigh,
    /// Alarm of low priority.
    AlarmLow,
    /// Remote service interface (RSI): acyclic services of newer devices, without UDP.
    Rsi,
    /// DCP Hello.
    DcpHello,
    /// DCP Get or Set.
    DcpGetSet,
    /// DCP Identify request.
    DcpIdentifyRequest,
    /// DCP Identify response.
    DcpIdentifyResponse,
    /// A fragment of a frame.
    Fragment,
    /// Reserved.
    Reserved,
}

/// DataStatus: the state of the data of a cyclic frame, set by its provider; reserved bits are preserved (IEC 61158-6-10,
/// DataStatus).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DataStatus(pub u8);

impl DataStatus {
    /// Bit 0: the AR is primary, otherwise backup.
    pub const PRIMARY: u8 = 0x01;
    /// Bit 1: redundancy; its meaning depends on bit 0.
    pub const REDUNDANCY: u8 = 0x02;
    /// Bit 2: the data are valid.
    pub const DATA_VALID: u8 = 0x04;
    /// Bit 4: the provider is in the state run, otherwise stop.
    pub const RUN: u8 = 0x10;
    /// Bit 5: the station has no problem; 0 means that it has one.
    pub const NO_PROBLEM: u8 = 0x20;
    /// Bit 7: the receiver must ignore this status.
    pub const IGNORE: u8 = 0x80;
    /// Bits 3 and 6, which must be 0.
    pub const RESERVED: u8 = 0x48;
    /// The status of a station in normal operation: primary, valid, run, no problem.
    pub const NORMAL: DataStatus = DataStatus(0x35);

    /// Whether all bits of `mask` are set.
    #[inline]
    pub fn has(self, mask: u8) -> bool {
        self.0 & mask == mask
    }
    /// Whether the data are valid.
    pub fn is_valid(self) -> bool {
        self.has(DataStatus::DATA_VALID)
    }
    /// Whether the provider is in the state run.
    pub fn is_run(self) -> bool {
        self.has(DataStatus::RUN)
    }
    /// Whether the station reports a problem (the bit is then 0).
    pub fn has_problem(self) -> bool {
        !self.has(DataStatus::NO_PROBLEM)
    }
    /// The reserved bits, which must be 0.
    pub fn reserved(self) -> u8 {
        self.0 & DataStatus::RESERVED
    }
}

/// The APDU status: the four bytes after the data of a cyclic frame.
///
/// Bytes: 0-1 cycle counter, 2 data status, 3 transfer status (IEC 61158-6-10, APDU_Status).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ApduStatus {
    /// Cycle counter: the time of sending in units of 31.25 us.
    pub cycle_counter: u16,
    /// The state of the data.
    pub data_status: DataStatus,
    /// Transfer status: 0 if the transfer was good; in RT_CLASS_3 the bits are transfer errors.
    pub transfer_status: u8,
}

impl ApduStatus {
    /// Length in bytes.
    pub const LENGTH: usize = 4;
}

/// IOxS, the status of the data of a submodule: IOPS from the provider, IOCS from the consumer.
///
/// Bit 7 good, 6-5 instance that detected the bad state, 4-1 reserved, 0 another byte follows (IEC 61158-6-10, IOxS).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct IoxS(pub u8);

impl IoxS {
    /// Good.
    pub const GOOD: IoxS = IoxS(0x80);
    /// Bad, detected by the submodule.
    pub const BAD: IoxS = IoxS(0x00);
    /// Bad, detected by `instance`.
    pub const fn bad(instance: Instance) -> IoxS {
        IoxS((instance as u8) << 5)
    }
    /// Whether the status is good.
    #[inline]
    pub fn is_good(self) -> bool {
        self.0 & 0x80 != 0
    }
    /// The instance that detected the bad state; meaningless if the status is good.
    pub fn instance(self) -> Instance {
        match self.0 >> 5 & 3 {
            0 => Instance::Subslot,
            1 => Instance::Slot,
            2 => Instance::Device,
            _ => Instance::Controller,
        }
    }
    /// The reserved bits, which must be 0.
    pub fn reserved(self) -> u8 {
        self.0 & 0x1e
    }
    /// Whether another status byte follows.
    pub fn is_extended(self) -> bool {
        self.0 & 1 != 0
    }
}

/// The instance that detected a bad state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Instance {
    /// The submodule.
    Subslot = 0,
    /// The module.
    Slot = 1,
    /// The IO device.
    Device = 2,
    /// The IO controller.
    Controller = 3,
}

/// A cyclic frame, starting with its frame ID.
///
/// Bytes: 0-1 frame ID, then the data, then four of APDU status, then padding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CyclicFrame<'a> {
    /// The frame ID, which identifies the CR of the sender.
    pub frame_id: FrameId,
    /// Values of all submodules with their IOPS and IOCS.
    pub data: &'a [u8],
    /// The APDU status.
    pub status: ApduStatus,
    /// The bytes after the status: padding of short frames, or a trailer of the capture.
    pub padding: &'a [u8],
}

impl<'a> CyclicFrame<'a> {
    /// Offset of the data from the frame ID, in bytes.
    pub const DATA_OFFSET: usize = 2;

    /// Parses `payload`, which starts with the frame ID, with `data_length` bytes of data as defined in the Connect.
    #[inline]
    pub fn parse(payload: &'a [u8], data_length: usize) -> Result<CyclicFrame<'a>> {
        let mut reader = ByteReader::new("PROFINET RT", payload);
        Ok(CyclicFrame {
            frame_id: FrameId(reader.u16()?),
            data: reader.take(data_length)?,
            status: ApduStatus {
                cycle_counter: reader.u16()?,
                data_status: DataStatus(reader.u8()?),
                transfer_status: reader.u8()?,
            },
            padding: reader.rest(),
        })
    }

    /// Parses `payload` without knowledge of the Connect: takes the last four bytes as the status.
    ///
    /// The result is wrong if padding or a trailer follows. Data of at least the minimum length have no padding.
    #[inline]
    pub fn parse_to_end(payload: &'a [u8]) -> Result<CyclicFrame<'a>> {
        CyclicFrame::parse(payload, payload.len().saturating_sub(CyclicFrame::DATA_OFFSET + ApduStatus::LENGTH))
    }

    /// Appends the frame, starting with its frame ID; the caller ensures the length of the data.
    #[inline]
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.frame_id.0);
        out.put(self.data);
        out.put_u16(self.status.cycle_counter);
        out.put_u8(self.status.data_status.0);
        out.put_u8(self.status.transfer_status);
        out.put(self.padding);
    }
}
