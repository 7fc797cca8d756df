//! The alarm CR (alarm connection) of an AR.

use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// The properties of an alarm connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct AlarmCrProperties(pub u32);

impl AlarmCrProperties {
    /// Bit 0: all alarms have low priority; clear if each alarm has its own priority.
    pub const PRIORITY_LOW: AlarmCrProperties = AlarmCrProperties(1);
    /// Bit 1: alarms are sent over UDP; clear for Ethernet.
    pub const TRANSPORT_UDP: AlarmCrProperties = AlarmCrProperties(2);

    /// Whether all bits of `properties` are set.
    pub fn has(self, properties: AlarmCrProperties) -> bool {
        self.0 & properties.0 == properties.0
    }
}

/// AlarmCRBlockReq: the alarm connection that the initiator requests.
///
/// Bytes of the body: 0-1 AlarmCRType, 2-3 LT, 4-7 AlarmCRProperties, 8-9 RTATimeoutFactor, 10-11 RTARetries,
/// 12-13 LocalAlarmReference, 14-15 MaxAlarmDataLength, 16-17 AlarmCRTagHeaderHigh, 18-19 AlarmCRTagHeaderLow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlarmCrBlockReq {
    /// 1, the only defined type.
    pub alarm_cr_type: u16,
    /// Ethertype, 0x8892; 0x0800 over UDP.
    pub lt: u16,
    /// Priority and transport.
    pub alarm_cr_properties: AlarmCrProperties,
    /// Timeout for an acknowledgement; unit 100 ms, 1 to 100.
    pub rta_timeout_factor: u16,
    /// Number of retries; 3 to 15.
    pub rta_retries: u16,
    /// The number of the initiator's alarm endpoint.
    pub local_alarm_reference: u16,
    /// The maximum length of an alarm that the initiator accepts, in bytes; 200 to 1432.
    pub max_alarm_data_length: u16,
    /// 802.1Q tag for alarms of high priority; 0xC000 for priority 6.
    pub alarm_cr_tag_header_high: u16,
    /// 802.1Q tag for alarms of low priority; 0xA000 for priority 5.
    pub alarm_cr_tag_header_low: u16,
}

impl AlarmCrBlockReq {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<AlarmCrBlockReq> {
        Ok(AlarmCrBlockReq {
            alarm_cr_type: reader.u16()?,
            lt: reader.u16()?,
            alarm_cr_properties: AlarmCrProperties(reader.u32()?),
            rta_timeout_factor: reader.u16()?,
            rta_retries: reader.u16()?,
            local_alarm_reference: reader.u16()?,
            max_alarm_data_length: reader.u16()?,
            alarm_cr_tag_header_high: reader.u16()?,
            alarm_cr_tag_header_low: reader.u16()?,
        })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.alarm_cr_type);
        out.put_u16(self.lt);
        out.put_u32(self.alarm_cr_properties.0);
        for word in [
            self.rta_timeout_factor,
            self.rta_retries,
            self.local_alarm_reference,
            self.max_alarm_data_length,
            self.alarm_cr_tag_header_high,
            self.alarm_cr_tag_header_low,
        ] {
            out.put_u16(word);
        }
    }
}

/// AlarmCRBlockRes: the alarm connection that the responder established.
///
/// Bytes of the body: 0-1 AlarmCRType, 2-3 LocalAlarmReference, 4-5 MaxAlarmDataLength.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AlarmCrBlockRes {
    /// 1, as requested.
    pub alarm_cr_type: u16,
    /// The number of the responder's alarm endpoint.
    pub local_alarm_reference: u16,
    /// The maximum length of an alarm that the responder accepts, in bytes; 200 to 1432.
    pub max_alarm_data_length: u16,
}

impl AlarmCrBlockRes {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<AlarmCrBlockRes> {
        Ok(AlarmCrBlockRes {
            alarm_cr_type: reader.u16()?,
            local_alarm_reference: reader.u16()?,
            max_alarm_data_length: reader.u16()?,
        })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.alarm_cr_type);
        out.put_u16(self.local_alarm_reference);
        out.put_u16(self.max_alarm_data_length);
    }
}
