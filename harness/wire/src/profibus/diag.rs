//! Slave_Diag: the standard diagnosis of six bytes, and the blocks of extended diagnosis.
//!
//! This module must not know the content of device-related blocks, nor manufacturer-specific error types: the manual of the
//! device defines them. Source: IEC 61158-6-3, Slave_Diag.

use crate::codes::{codes, flags};
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

flags! {
    /// The first byte (IEC 61158-6-3, Station_Status_1).
    pub struct Status1(u8) {
        0x01 STATION_NON_EXISTENT station_non_existent "The slave does not answer; set by the master, 0 from the slave.",
        0x02 STATION_NOT_READY station_not_ready "The slave is not ready for Data_Exchange.",
        0x04 CFG_FAULT cfg_fault "The last Chk_Cfg does not fit the slave.",
        0x08 EXT_DIAG ext_diag "The blocks after the six bytes report a fault; otherwise they are status, or there are none.",
        0x10 NOT_SUPPORTED not_supported "The slave does not support a requested function.",
        0x20 INVALID_SLAVE_RESPONSE invalid_slave_response "The response of the slave is invalid; set by the master, 0 from the slave.",
        0x40 PRM_FAULT prm_fault "The last Set_Prm was wrong.",
        0x80 MASTER_LOCK master_lock "The slave is locked by another master; set by the master, 0 from the slave.",
    }
}

flags! {
    /// The second byte (IEC 61158-6-3, Station_Status_2).
    pub struct Status2(u8) {
        0x01 PRM_REQ prm_req "The slave requests to be parameterised and configured again.",
        0x02 STAT_DIAG stat_diag "The slave has no valid data; the master must read the diagnosis until this is 0.",
        0x04 FIXED_ONE fixed_one "Set by every slave.",
        0x08 WD_ON wd_on "The watchdog is on.",
        0x10 FREEZE_MODE freeze_mode "The inputs are frozen.",
        0x20 SYNC_MODE sync_mode "The outputs are synchronised.",
        0x80 DEACTIVATED deactivated "The slave must not be addressed; set by the master, 0 from the slave.",
    }
}

flags! {
    /// The third byte (IEC 61158-6-3, Station_Status_3).
    pub struct Status3(u8) {
        0x80 EXT_DIAG_OVERFLOW ext_diag_overflow "There is more to report than fits into the blocks.",
    }
}

codes! {
    /// The data width of a channel: bits 7-5 of the third byte of a channel-related block.
    pub struct ChannelType(u8) {
        1 BIT bit "One bit.",
        2 BITS_2 bits_2 "Two bits.",
        3 BITS_4 bits_4 "Four bits.",
        4 BYTE byte "One byte.",
        5 WORD word "Two bytes.",
        6 TWO_WORDS two_words "Four bytes.",
    }
}

codes! {
    /// The error of a channel: bits 4-0 of the third byte; 10 to 15 are reserved, 16 to 31 are manufacturer-specific.
    pub struct ErrorType(u8) {
        1 SHORT_CIRCUIT short_circuit "A line has a short circuit.",
        2 UNDERVOLTAGE undervoltage "The voltage is too low.",
        3 OVERVOLTAGE overvoltage "The voltage is too high.",
        4 OVERLOAD overload "The load is too high.",
        5 OVERTEMPERATURE overtemperature "The temperature is too high.",
        6 LINE_BREAK line_break "A line is broken.",
        7 UPPER_LIMIT_EXCEEDED upper_limit_exceeded "The value is above its upper limit.",
        8 LOWER_LIMIT_EXCEEDED lower_limit_exceeded "The value is below its lower limit.",
        9 ERROR error "An error without further details.",
    }
}

codes! {
    /// The type of a DP-V1 alarm: the first byte after the header, with bit 7 = 0; 32 to 126 are manufacturer-specific.
    pub struct DpAlarmType(u8) {
        1 DIAGNOSIS diagnosis "A diagnosis appeared, changed or disappeared.",
        2 PROCESS process "An event in the process.",
        3 PULL pull "A module was pulled.",
        4 PLUG plug "A module was plugged.",
        5 STATUS status "A state changed that is not a fault.",
        6 UPDATE update "A parameter changed.",
    }
}

codes! {
    /// The type of a DP-V1 status: the first byte after the header, with bit 7 = 1; 0xA0 to 0xFE are manufacturer-specific.
    pub struct StatusType(u8) {
        0x81 STATUS_MESSAGE status_message "A status message.",
        0x82 MODULE_STATUS module_status "Two bits for each module: good, bad data, wrong module, no module.",
        0x83 DXB_LINK_STATUS dxb_link_status "The state of the links to publishers.",
        0x9E PRM_COMMAND_ACK prm_command_ack "The response to a redundancy command.",
        0x9F RED_STATE red_state "The state of redundancy.",
    }
}

/// Diag_Master_Add of a slave that no master has parameterised.
pub const NO_MASTER: u8 = 255;

/// The diagnosis of a slave.
///
/// Bytes: 0-2 station status, 3 address of the master that parameterised the slave (255: none), 4-5 ident number, then blocks;
/// 6 to 244 bytes in all (IEC 61158-6-3, Slave_Diag response).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlaveDiag {
    /// Station_Status_1.
    pub status_1: Status1,
    /// Station_Status_2.
    pub status_2: Status2,
    /// Station_Status_3.
    pub status_3: Status3,
    /// Diag_Master_Add: 0 to 125, or [`NO_MASTER`].
    pub master: u8,
    /// Ident_Number of the type of device.
    pub ident: u16,
    /// Ext_Diag_Data: the bytes of the blocks.
    pub ext: Vec<u8>,
}

/// A block after the six bytes; bits 7-6 of its first byte are its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiagnosisBlock<'a> {
    /// 00: device-related. Byte 0: bits 5-0 length with this byte, 1 to 63; the rest is defined by the manual, or is an alarm or a
    /// status of DP-V1 ([`DiagnosisMessage`]).
    Device(&'a [u8]),
    /// 01: identifier-related. Byte 0: bits 5-0 length with this byte; then a bit for each configuration identifier, starting
    /// with bit 0 of byte 1.
    Identifier(&'a [u8]),
    /// 10: channel-related.
    Channel(DpChannelDiagnosis),
    /// 11: the revision of the device, bits 5-0; one byte.
    Revision(u8),
}

/// A channel-related diagnosis.
///
/// Bytes: 0 bits 7-6 10, bits 5-0 number of the configuration identifier; 1 bits 7-6 direction, bits 5-0 channel; 2 bits 7-5
/// type of the channel, bits 4-0 type of the error (IEC 61158-6-3, channel-related diagnosis).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct DpChannelDiagnosis {
    /// Number of the configuration identifier, from 0 to 63.
    pub identifier: u8,
    /// Bits 7-6 of the second byte: 1 input, 2 output, 3 both, 0 reserved.
    pub direction: u8,
    /// Number of the channel, 0 to 63.
    pub channel: u8,
    /// Data width of the channel.
    pub channel_type: ChannelType,
    /// The error of the channel.
    pub error_type: ErrorType,
}

/// An alarm or a status of DP-V1: a device-related block of a slave in DP-V1 mode.
///
/// Bytes after the header: 0 bit 7 status, else alarm, bits 6-0 type; 1 slot; 2 specifier; then data (IEC 61158-6-3,
/// Alarm-PDU and Status-PDU). In DP-V0 the manual defines these bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DiagnosisMessage<'a> {
    /// Alarm type, or, with bit 7 set, status type.
    pub kind: u8,
    /// Slot, 0 to 254.
    pub slot: u8,
    /// Sequence number, acknowledgement and coming or going.
    pub specifier: Specifier,
    /// The data of the alarm or status.
    pub data: &'a [u8],
}

/// The third byte of an alarm or a status; an alarm acknowledgement returns it.
///
/// Bits 7-3 sequence number, bit 2 additional acknowledgement by the user required (Add_Ack), bits 1-0 change of the fault; in a
/// status only bits 1-0 are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Specifier(pub u8);

/// The change of the fault: bits 1-0 of a specifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpecifierChange {
    /// 0: no further differentiation.
    NotDifferentiated,
    /// 1: the fault appears, and the slot is disturbed.
    Appears,
    /// 2: the fault disappears, and the slot is good.
    Disappears,
    /// 3: the fault disappears, and others remain.
    DisappearsOthersRemain,
}

impl Specifier {
    /// The sequence number of the alarm, 0 to 31.
    pub fn sequence(self) -> u8 {
        self.0 >> 3
    }
    /// Whether the user has to acknowledge in addition to Alarm_Ack, for instance by a write.
    pub fn requires_user_acknowledgement(self) -> bool {
        self.0 & 4 != 0
    }
    /// The change of the fault.
    pub fn change(self) -> SpecifierChange {
        match self.0 & 3 {
            0 => SpecifierChange::NotDifferentiated,
            1 => SpecifierChange::Appears,
            2 => SpecifierChange::Disappears,
            _ => SpecifierChange::DisappearsOthersRemain,
        }
    }
}

impl SlaveDiag {
    /// Length of the standard diagnosis, in bytes.
    pub const HEAD: usize = 6;
    /// The maximum length of a diagnosis, in bytes.
    pub const LONGEST: usize = 244;

    /// Parses the data of a Slave_Diag response; fails only if it has fewer than six bytes.
    pub fn parse(octets: &[u8]) -> Result<SlaveDiag> {
        let mut reader = ByteReader::new("Slave_Diag", octets);
        Ok(SlaveDiag {
            status_1: Status1(reader.u8()?),
            status_2: Status2(reader.u8()?),
            status_3: Status3(reader.u8()?),
            master: reader.u8()?,
            ident: reader.u16()?,
            ext: reader.rest().to_vec(),
        })
    }

    /// Appends the data.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.status_1.0, self.status_2.0, self.status_3.0, self.master]);
        out.put_u16(self.ident);
        out.put(&self.ext);
    }

    /// Iterates over the blocks; an error ends the iteration, and its offset counts from the start of the diagnosis.
    pub fn blocks(&self) -> SlaveDiagBlocks<'_> {
        SlaveDiagBlocks { octets: &self.ext, at: 0 }
    }
}

/// The blocks of a diagnosis; see [`SlaveDiag::blocks`].
#[derive(Clone, Debug)]
pub struct SlaveDiagBlocks<'a> {
    octets: &'a [u8],
    at: usize,
}

impl<'a> Iterator for SlaveDiagBlocks<'a> {
    type Item = Result<DiagnosisBlock<'a>>;

    fn next(&mut self) -> Option<Result<DiagnosisBlock<'a>>> {
        let mut reader =
            ByteReader::new("diagnosis block", self.octets.get(self.at..).filter(|rest| !rest.is_empty())?);
        match DiagnosisBlock::read(&mut reader) {
            Ok(block) => {
                self.at += reader.offset();
                Some(Ok(block))
            }
            Err(error) => {
                let error = error.at_offset(SlaveDiag::HEAD + self.at);
                self.at = self.octets.len();
                Some(Err(error))
            }
        }
    }
}

impl<'a> DiagnosisBlock<'a> {
    /// Parses one block; fails if its length is 0 or longer than the rest of the diagnosis.
    pub fn read(reader: &mut ByteReader<'a>) -> Result<DiagnosisBlock<'a>> {
        let header = reader.u8()?;
        let low = header & 0x3F;
        match header >> 6 {
            2 => {
                let (channel, kind) = (reader.u8()?, reader.u8()?);
                Ok(DiagnosisBlock::Channel(DpChannelDiagnosis {
                    identifier: low,
                    direction: channel >> 6,
                    channel: channel & 0x3F,
                    channel_type: ChannelType(kind >> 5),
                    error_type: ErrorType(kind & 0x1F),
                }))
            }
            3 => Ok(DiagnosisBlock::Revision(low)),
            kind => {
                let Some(length) = low.checked_sub(1) else {
                    return Err(reader.wrong("block length", 1, "1 to 63, with the header", 0));
                };
                let data = reader.take(length.into())?;
                Ok(if kind == 0 { DiagnosisBlock::Device(data) } else { DiagnosisBlock::Identifier(data) })
            }
        }
    }

    /// Appends the block; the caller ensures that it has at most 62 bytes after its header.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            DiagnosisBlock::Device(data) => {
                out.put_u8((data.len() as u8).wrapping_add(1) & 0x3F);
                out.put(data);
            }
            DiagnosisBlock::Identifier(data) => {
                out.put_u8(0x40 | (data.len() as u8).wrapping_add(1) & 0x3F);
                out.put(data);
            }
            DiagnosisBlock::Channel(channel) => out.put(&[
                0x80 | channel.identifier & 0x3F,
                channel.direction << 6 | channel.channel & 0x3F,
                channel.channel_type.0 << 5 | channel.error_type.0 & 0x1F,
            ]),
            DiagnosisBlock::Revision(revision) => out.put_u8(0xC0 | revision & 0x3F),
        }
    }
}

/// The numbers of the configuration identifiers whose bit is set in an identifier-related block, from 0 on.
pub fn identifiers(data: &[u8]) -> impl Iterator<Item = usize> + '_ {
    (0..data.len() * 8).filter(|bit| data.get(bit / 8).is_some_and(|octet| octet >> (bit % 8) & 1 != 0))
}

impl<'a> DiagnosisMessage<'a> {
    /// Parses the data of a device-related block as an alarm or a status; fails if it has fewer than three bytes.
    pub fn parse(data: &'a [u8]) -> Result<DiagnosisMessage<'a>> {
        let mut reader = ByteReader::new("DP-V1 alarm or status", data);
        Ok(DiagnosisMessage {
            kind: reader.u8()?,
            slot: reader.u8()?,
            specifier: Specifier(reader.u8()?),
            data: reader.rest(),
        })
    }

    /// Appends the data of the block, without its header.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.kind, self.slot, self.specifier.0]);
        out.put(self.data);
    }

    /// The alarm type; `None` for a status.
    pub fn alarm(&self) -> Option<DpAlarmType> {
        (self.kind & 0x80 == 0).then_some(DpAlarmType(self.kind))
    }

    /// The status type; `None` for an alarm.
    pub fn status(&self) -> Option<StatusType> {
        (self.kind & 0x80 != 0).then_some(StatusType(self.kind))
    }
}
