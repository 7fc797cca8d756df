//! The AR blocks: initiator, responder and properties of the AR.

use crate::codes::codes;
use crate::error::Result;
use crate::ethernet::Mac;
use crate::octets::{Append, ByteOrder, ByteReader};
use crate::profinet::rpc::Uuid;
use alloc::vec::Vec;
use core::ops::BitOr;

codes! {
    /// The type of AR; 16 bits.
    pub struct ArType(u16) {
        0x0001 IOCAR_SINGLE iocar_single "An IO controller operates the device.",
        0x0003 IOCAR_CIR iocar_cir "An IO controller operates the device and may reconfigure it during operation.",
        0x0006 IOSAR iosar "An IO supervisor, or device access only.",
        0x0010 IOCAR_SINGLE_RTC3 iocar_single_rtc3 "An IO controller operates the device with RT class 3.",
        0x0020 IOCAR_SR iocar_sr "One of several ARs of a redundant system.",
    }
}

/// The properties of an AR; 32 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ArProperties(pub u32);

impl ArProperties {
    /// Bits 0 to 2: the state; 1 is the only defined value.
    pub const STATE: ArProperties = ArProperties(0x7);
    /// State 1: the AR is primary; every AR sets this.
    pub const ACTIVE: ArProperties = ArProperties(0x1);
    /// Bit 3: a supervisor may take over submodules.
    pub const SUPERVISOR_TAKEOVER_ALLOWED: ArProperties = ArProperties(1 << 3);
    /// Bit 4: the initiator of the AR parametrizes the device; clear if a parameter server does.
    pub const PARAMETRIZATION_BY_INITIATOR: ArProperties = ArProperties(1 << 4);
    /// Bit 8: only records, no submodules, no cyclic data.
    pub const DEVICE_ACCESS: ArProperties = ArProperties(1 << 8);
    /// Bits 9 and 10: 0 single AR, 1 first AR of a pair, 2 companion AR.
    pub const COMPANION_AR: ArProperties = ArProperties(0x3 << 9);
    /// Bit 11: the companion AR must be acknowledged.
    pub const ACKNOWLEDGE_COMPANION_AR: ArProperties = ArProperties(1 << 11);
    /// Bit 28: the AR belongs to a time-aware system.
    pub const TIME_AWARE_SYSTEM: ArProperties = ArProperties(1 << 28);
    /// Bit 29: ports and interface are in one container record.
    pub const COMBINED_OBJECT_CONTAINER: ArProperties = ArProperties(1 << 29);
    /// Bit 30: advanced start-up; clear for legacy.
    pub const STARTUP_ADVANCED: ArProperties = ArProperties(1 << 30);
    /// Bit 31: the device may send the alarm "pull module" for a whole module.
    pub const PULL_MODULE_ALARM_ALLOWED: ArProperties = ArProperties(1 << 31);

    /// Whether all bits of `properties` are set.
    pub fn has(self, properties: ArProperties) -> bool {
        self.0 & properties.0 == properties.0
    }

    /// The state in bits 0 to 2.
    pub fn state(self) -> u8 {
        (self.0 & 0x7) as u8
    }

    /// The companion AR in bits 9 and 10: 0 single, 1 first, 2 companion.
    pub fn companion_ar(self) -> u8 {
        ((self.0 >> 9) & 0x3) as u8
    }

    /// The reserved bits, which must be 0: 5 to 7 and 12 to 27.
    pub fn reserved(self) -> u32 {
        self.0 & 0x0FFF_F0E0
    }
}

impl BitOr for ArProperties {
    type Output = ArProperties;
    fn bitor(self, other: ArProperties) -> ArProperties {
        ArProperties(self.0 | other.0)
    }
}

/// ARBlockReq: the AR that the initiator requests.
///
/// Bytes of the body: 0-1 ARType, 2-17 ARUUID, 18-19 SessionKey, 20-25 CMInitiatorMacAdd, 26-41 CMInitiatorObjectUUID,
/// 42-45 ARProperties, 46-47 CMInitiatorActivityTimeoutFactor, 48-49 InitiatorUDPRTPort, 50-51 StationNameLength, then the name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ArBlockReq {
    /// The type of the AR.
    pub ar_type: ArType,
    /// The UUID that identifies the AR in all further calls.
    pub ar_uuid: Uuid,
    /// Session key of the AR.
    pub session_key: u16,
    /// MAC address of the initiator.
    pub cm_initiator_mac_add: Mac,
    /// Object UUID of the initiator.
    pub cm_initiator_object_uuid: Uuid,
    /// Properties of the AR.
    pub ar_properties: ArProperties,
    /// Timeout of the responder for the next call of the initiator; unit 100 ms, 1 to 1000.
    pub cm_initiator_activity_timeout_factor: u16,
    /// UDP port for RT over UDP; 0x8892 is usual.
    pub initiator_udp_rt_port: u16,
    /// Station name of the initiator, 1 to 240 bytes.
    pub cm_initiator_station_name: Vec<u8>,
}

impl ArBlockReq {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<ArBlockReq> {
        Ok(ArBlockReq {
            ar_type: ArType(reader.u16()?),
            ar_uuid: Uuid::read(reader)?,
            session_key: reader.u16()?,
            cm_initiator_mac_add: Mac::read(reader)?,
            cm_initiator_object_uuid: Uuid::read(reader)?,
            ar_properties: ArProperties(reader.u32()?),
            cm_initiator_activity_timeout_factor: reader.u16()?,
            initiator_udp_rt_port: reader.u16()?,
            cm_initiator_station_name: read_name(reader)?,
        })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.ar_type.0);
        self.ar_uuid.write(out, ByteOrder::Big);
        out.put_u16(self.session_key);
        out.put(&self.cm_initiator_mac_add.0);
        self.cm_initiator_object_uuid.write(out, ByteOrder::Big);
        out.put_u32(self.ar_properties.0);
        out.put_u16(self.cm_initiator_activity_timeout_factor);
        out.put_u16(self.initiator_udp_rt_port);
        write_name(out, &self.cm_initiator_station_name);
    }
}

/// ARBlockRes: the AR that the responder established.
///
/// Bytes of the body: 0-1 ARType, 2-17 ARUUID, 18-19 SessionKey, 20-25 CMResponderMacAdd, 26-27 ResponderUDPRTPort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ArBlockRes {
    /// The type of the AR, as requested.
    pub ar_type: ArType,
    /// The UUID of the AR, as requested.
    pub ar_uuid: Uuid,
    /// Session key, as requested.
    pub session_key: u16,
    /// MAC address of the responder.
    pub cm_responder_mac_add: Mac,
    /// UDP port for RT over UDP; 0x8892 is usual.
    pub responder_udp_rt_port: u16,
}

impl ArBlockRes {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<ArBlockRes> {
        Ok(ArBlockRes {
            ar_type: ArType(reader.u16()?),
            ar_uuid: Uuid::read(reader)?,
            session_key: reader.u16()?,
            cm_responder_mac_add: Mac::read(reader)?,
            responder_udp_rt_port: reader.u16()?,
        })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.ar_type.0);
        self.ar_uuid.write(out, ByteOrder::Big);
        out.put_u16(self.session_key);
        out.put(&self.cm_responder_mac_add.0);
        out.put_u16(self.responder_udp_rt_port);
    }
}

/// ARServerBlockRes: the station name of the responder; part of advanced start-up.
///
/// Bytes of the body: 0-1 StationNameLength, then the name, then padding of the whole block to a multiple of four bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ArServerBlockRes {
    /// Station name of the responder, 1 to 240 bytes.
    pub cm_responder_station_name: Vec<u8>,
}

impl ArServerBlockRes {
    /// Reads the body of the block; padding stays in the reader.
    pub fn read(reader: &mut ByteReader) -> Result<ArServerBlockRes> {
        Ok(ArServerBlockRes { cm_responder_station_name: read_name(reader)? })
    }

    /// Appends the body of the block without padding.
    pub fn write(&self, out: &mut Vec<u8>) {
        write_name(out, &self.cm_responder_station_name);
    }
}

/// PrmServerBlockReq: a parameter server parametrizes the device instead of the initiator.
///
/// Bytes of the body: 0-15 ParameterServerObjectUUID, 16-19 ParameterServerProperties, 20-21 CMInitiatorActivityTimeoutFactor,
/// 22-23 StationNameLength, then the name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrmServerBlockReq {
    /// Object UUID of the parameter server.
    pub parameter_server_object_uuid: Uuid,
    /// Properties of the parameter server; 0.
    pub parameter_server_properties: u32,
    /// Timeout of the responder for the parameter server; unit 100 ms.
    pub cm_initiator_activity_timeout_factor: u16,
    /// Station name of the parameter server.
    pub parameter_server_station_name: Vec<u8>,
}

impl PrmServerBlockReq {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<PrmServerBlockReq> {
        Ok(PrmServerBlockReq {
            parameter_server_object_uuid: Uuid::read(reader)?,
            parameter_server_properties: reader.u32()?,
            cm_initiator_activity_timeout_factor: reader.u16()?,
            parameter_server_station_name: read_name(reader)?,
        })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.parameter_server_object_uuid.write(out, ByteOrder::Big);
        out.put_u32(self.parameter_server_properties);
        out.put_u16(self.cm_initiator_activity_timeout_factor);
        write_name(out, &self.parameter_server_station_name);
    }
}

/// ARRPCBlockReq and ARRPCBlockRes: the port at which the sender serves RPC calls for this AR. Bytes of the body: 0-1 port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ArRpcBlock {
    /// UDP port of the sender's RPC server.
    pub rpc_server_port: u16,
}

impl ArRpcBlock {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<ArRpcBlock> {
        Ok(ArRpcBlock { rpc_server_port: reader.u16()? })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.rpc_server_port);
    }
}

fn read_name(reader: &mut ByteReader) -> Result<Vec<u8>> {
    let length = reader.u16()?;
    Ok(reader.take(length.into())?.to_vec())
}

fn write_name(out: &mut Vec<u8>, name: &[u8]) {
    out.put_u16(name.len() as u16);
    out.put(name);
}
