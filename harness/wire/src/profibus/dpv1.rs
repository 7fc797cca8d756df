//! The acyclic services of DP-V1: records, alarms, and the connections of class 2 masters.
//!
//! A class 1 master (MS1) uses access points 51 and 50 of a slave that is in Data_Exchange with it; a class 2 master (MS2)
//! requests a connection from access point 49 and then uses the assigned access point. While the slave processes a request, the
//! master polls it with empty SRD frames; Idle keeps a connection alive. This module must not know the content of records.
//! Source: IEC 61158-6-3, MS1 and MS2 PDUs.

use super::diag::Specifier;
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// Error_Code_1 if [`Dpv1ErrorDecode`] is DP-V1: class in bits 7-4, code in bits 3-0. PROFINET uses the same table.
pub use crate::profinet::status::RecordError;

codes! {
    /// The kind of a PDU: its first byte; bit 7 means that the request was refused (IEC 61158-6-3, Function_Num).
    pub struct Dpv1Function(u8) {
        0x48 IDLE idle "Keeps the connection alive.",
        0x51 DATA_TRANSPORT data_transport "Transfers data in both directions.",
        0x56 RESOURCE_MANAGER resource_manager "The slave assigns the access point of the new connection.",
        0x57 INITIATE initiate "Opens a connection.",
        0x58 ABORT abort "Closes a connection.",
        0x5C ALARM_ACK alarm_ack "Acknowledges an alarm.",
        0x5E READ read "Reads a record.",
        0x5F WRITE write "Writes a record.",
        0xD1 DATA_TRANSPORT_REFUSED data_transport_refused "The data transport was refused.",
        0xD7 INITIATE_REFUSED initiate_refused "The connection was refused.",
        0xDC ALARM_ACK_REFUSED alarm_ack_refused "The acknowledgement of an alarm was refused.",
        0xDE READ_REFUSED read_refused "Reading the record was refused.",
        0xDF WRITE_REFUSED write_refused "Writing the record was refused.",
    }
}

codes! {
    /// The meaning of the codes of a refusal (IEC 61158-6-3, Error_Decode).
    pub struct Dpv1ErrorDecode(u8) {
        0x80 DPV1 dpv1 "The third byte is a DP-V1 error, the fourth is manufacturer-specific.",
        0xFE FMS fms "The codes are those of FMS.",
        0xFF HART hart "The codes are those of HART.",
    }
}

codes! {
    /// The origin of an abort (IEC 61158-6-3, Subnet).
    pub struct Subnet(u8) {
        0 NO no "No subnet is given.",
        1 LOCAL local "The subnet of the sender.",
        2 REMOTE remote "Another subnet.",
    }
}

codes! {
    /// The layer that closed a connection in bits 5-4, the reason in bits 3-0 (IEC 61158-6-3, Instance and Reason_Code).
    pub struct Dpv1AbortReason(u8) {
        0x01 LINK_USER_ERROR link_user_error "Data link: the access point rejected the frame (UE).",
        0x02 LINK_NO_RESOURCE link_no_resource "Data link: no resource (RR).",
        0x03 LINK_NO_SERVICE link_no_service "Data link: the access point is not active (RS).",
        0x09 LINK_NO_DATA link_no_data "Data link: no data (NR).",
        0x0A LINK_DATA_HIGH link_data_high "Data link: data of high priority received (DH).",
        0x0B LINK_LOCAL_RESOURCE link_local_resource "Data link: no resource at the sender (LR).",
        0x0C LINK_NO_RESOURCE_DATA_LOW link_no_resource_data_low "Data link: no resource, data of low priority received (RDL).",
        0x0D LINK_NO_RESOURCE_DATA_HIGH link_no_resource_data_high "Data link: no resource, data of high priority received (RDH).",
        0x0E LINK_NOT_IN_RING link_not_in_ring "Data link: the master is not in the logical ring (DS).",
        0x0F LINK_NO_ANSWER link_no_answer "Data link: no response (NA).",
        0x11 SEQUENCE sequence "MS2: the service is not allowed in this state (ABT_SE).",
        0x12 BAD_REQUEST bad_request "MS2: the request was invalid (ABT_FE).",
        0x13 TIMEOUT timeout "MS2: the connection timed out (ABT_TO).",
        0x14 BAD_RESPONSE bad_response "MS2: the response was invalid (ABT_RE).",
        0x15 BAD_SERVICE bad_service "MS2: the user requested an unknown service (ABT_IV).",
        0x16 SEND_TIMEOUT_TOO_SMALL send_timeout_too_small "MS2: the requested Send_Timeout was too small (ABT_STO).",
        0x17 BAD_ADDRESS bad_address "MS2: the additional address was invalid (ABT_IA).",
        0x18 WAITING waiting "MS2: the confirmation of the data link was outstanding (ABT_OC).",
        0x1F NO_RESOURCE no_resource "MS2: no resource (ABT_RES).",
    }
}

/// The direction of a PDU; a request and its response have the same function number but different fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PduDirection {
    /// From a master.
    Request,
    /// From a slave.
    Response,
}

/// A record in a read or write request or response, or in a data transport.
///
/// Bytes after the function number: 0 slot, 0 to 254; 1 index; 2 length, 0 to 240; then data in a write request, a read
/// response and both data transports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dpv1Record {
    /// Slot_Number.
    pub slot: u8,
    /// Index.
    pub index: u8,
    /// Length: of the data, or the maximum length in a read request, or the written length in a write response.
    pub length: u8,
    /// The data; empty in a read request and in a write response.
    pub data: Vec<u8>,
}

/// Why a request was refused.
///
/// Bytes: 0 function number with bit 7, 1 Error_Decode, 2 Error_Code_1, 3 Error_Code_2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dpv1Refusal {
    /// The refused function, with bit 7 set.
    pub function: Dpv1Function,
    /// Error_Decode.
    pub decode: Dpv1ErrorDecode,
    /// Error_Code_1.
    pub code_1: u8,
    /// Error_Code_2.
    pub code_2: u8,
}

/// One end of a connection: type and content of its additional address.
///
/// Type 0: bytes 0 API, 1 SCL. Type 1: API, SCL, six bytes network address, then MAC address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Endpoint {
    /// S_Type or D_Type.
    pub kind: u8,
    /// S_Addr or D_Addr.
    pub address: Vec<u8>,
}

/// Features and addresses of a master or a slave in Initiate. Bytes: 0-1 features, 2-3 profile features, 4-5 profile, then
/// S_Type, S_Len, D_Type, D_Len, S_Addr and D_Addr.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InitiateFeatures {
    /// Features_Supported_1 and _2; bit 0 of the first: reading and writing.
    pub features: [u8; 2],
    /// Profile_Features_Supported_1 and _2.
    pub profile_features: [u8; 2],
    /// Profile_Ident_Number; 0 for none.
    pub profile: u16,
    /// The sending end.
    pub source: Endpoint,
    /// The addressed end.
    pub destination: Endpoint,
}

/// A PDU of MS1 or MS2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dpv1Pdu {
    /// Idle, and the data after it, normally none.
    Idle(Vec<u8>),
    /// Data in both directions.
    DataTransport(Dpv1Record),
    /// The response of the resource manager. Bytes: 0 function number, 1 access point, 2-3 Send_Timeout in 10 ms.
    ResourceManager {
        /// Server_SAP: the access point of the connection, 0 to 48.
        sap: u8,
        /// The Send_Timeout that the slave supports, in 10 ms.
        send_timeout: u16,
    },
    /// The request for a connection. Bytes: 0 function number, 1-3 reserved, 4-5 Send_Timeout in 10 ms, from 6 features and
    /// addresses.
    InitiateRequest {
        /// Reserved, must be 0.
        reserved: [u8; 3],
        /// The maximum time without a PDU on the connection, in 10 ms.
        send_timeout: u16,
        /// Features and addresses of the master.
        abilities: InitiateFeatures,
    },
    /// The connection is accepted. Bytes: 0 function number, 1 Max_Len_Data_Unit, from 2 features and addresses.
    InitiateResponse {
        /// Max_Len_Data_Unit: the maximum length of a record in bytes, up to 240.
        most_data: u8,
        /// Features and addresses of the slave.
        abilities: InitiateFeatures,
    },
    /// The connection is closed. Bytes: 0 function number, 1 subnet, 2 reason, then details that some senders add.
    Abort {
        /// The origin of the abort.
        subnet: Subnet,
        /// Instance and reason.
        reason: Dpv1AbortReason,
        /// Additional details.
        more: Vec<u8>,
    },
    /// The acknowledgement of an alarm, and its response. Bytes: 0 function number, 1 slot, 2 alarm type, 3 specifier.
    AlarmAck {
        /// Slot of the alarm.
        slot: u8,
        /// Type of the alarm.
        alarm_type: u8,
        /// Specifier of the alarm.
        specifier: Specifier,
    },
    /// A read request or response.
    Read(Dpv1Record),
    /// A write request or response.
    Write(Dpv1Record),
    /// A refusal by the slave.
    Refused(Dpv1Refusal),
    /// An unknown function number, and the data after it.
    Other(Dpv1Function, Vec<u8>),
}

impl Dpv1Pdu {
    /// Parses the data of an MS1 or MS2 frame; fails if fields are missing, the data are shorter than their length, or bytes
    /// follow.
    pub fn parse(octets: &[u8], side: PduDirection) -> Result<Dpv1Pdu> {
        let mut reader = ByteReader::new("DP-V1", octets);
        let function = Dpv1Function(reader.u8()?);
        let pdu = match function {
            Dpv1Function::IDLE => Dpv1Pdu::Idle(reader.rest().to_vec()),
            Dpv1Function::DATA_TRANSPORT => Dpv1Pdu::DataTransport(Dpv1Record::read(&mut reader, true)?),
            Dpv1Function::READ => Dpv1Pdu::Read(Dpv1Record::read(&mut reader, side == PduDirection::Response)?),
            Dpv1Function::WRITE => Dpv1Pdu::Write(Dpv1Record::read(&mut reader, side == PduDirection::Request)?),
            Dpv1Function::RESOURCE_MANAGER => {
                Dpv1Pdu::ResourceManager { sap: reader.u8()?, send_timeout: reader.u16()? }
            }
            Dpv1Function::INITIATE if side == PduDirection::Request => Dpv1Pdu::InitiateRequest {
                reserved: reader.array()?,
                send_timeout: reader.u16()?,
                abilities: InitiateFeatures::read(&mut reader)?,
            },
            Dpv1Function::INITIATE => {
                Dpv1Pdu::InitiateResponse { most_data: reader.u8()?, abilities: InitiateFeatures::read(&mut reader)? }
            }
            Dpv1Function::ABORT => Dpv1Pdu::Abort {
                subnet: Subnet(reader.u8()?),
                reason: Dpv1AbortReason(reader.u8()?),
                more: reader.rest().to_vec(),
            },
            Dpv1Function::ALARM_ACK => {
                Dpv1Pdu::AlarmAck { slot: reader.u8()?, alarm_type: reader.u8()?, specifier: Specifier(reader.u8()?) }
            }
            Dpv1Function(number) if number & 0x80 != 0 => Dpv1Pdu::Refused(Dpv1Refusal {
                function,
                decode: Dpv1ErrorDecode(reader.u8()?),
                code_1: reader.u8()?,
                code_2: reader.u8()?,
            }),
            _ => Dpv1Pdu::Other(function, reader.rest().to_vec()),
        };
        reader.end("nothing after the PDU")?;
        Ok(pdu)
    }

    /// The function number of the PDU.
    pub fn function(&self) -> Dpv1Function {
        match self {
            Dpv1Pdu::Idle(_) => Dpv1Function::IDLE,
            Dpv1Pdu::DataTransport(_) => Dpv1Function::DATA_TRANSPORT,
            Dpv1Pdu::ResourceManager { .. } => Dpv1Function::RESOURCE_MANAGER,
            Dpv1Pdu::InitiateRequest { .. } | Dpv1Pdu::InitiateResponse { .. } => Dpv1Function::INITIATE,
            Dpv1Pdu::Abort { .. } => Dpv1Function::ABORT,
            Dpv1Pdu::AlarmAck { .. } => Dpv1Function::ALARM_ACK,
            Dpv1Pdu::Read(_) => Dpv1Function::READ,
            Dpv1Pdu::Write(_) => Dpv1Function::WRITE,
            Dpv1Pdu::Refused(refusal) => refusal.function,
            Dpv1Pdu::Other(function, _) => *function,
        }
    }

    /// Appends the PDU.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u8(self.function().0);
        match self {
            Dpv1Pdu::Idle(more) | Dpv1Pdu::Other(_, more) => out.put(more),
            Dpv1Pdu::DataTransport(record) | Dpv1Pdu::Read(record) | Dpv1Pdu::Write(record) => {
                out.put(&[record.slot, record.index, record.length]);
                out.put(&record.data);
            }
            Dpv1Pdu::ResourceManager { sap, send_timeout } => {
                out.put_u8(*sap);
                out.put_u16(*send_timeout);
            }
            Dpv1Pdu::InitiateRequest { reserved, send_timeout, abilities } => {
                out.put(reserved);
                out.put_u16(*send_timeout);
                abilities.write(out);
            }
            Dpv1Pdu::InitiateResponse { most_data, abilities } => {
                out.put_u8(*most_data);
                abilities.write(out);
            }
            Dpv1Pdu::Abort { subnet, reason, more } => {
                out.put(&[subnet.0, reason.0]);
                out.put(more);
            }
            Dpv1Pdu::AlarmAck { slot, alarm_type, specifier } => out.put(&[*slot, *alarm_type, specifier.0]),
            Dpv1Pdu::Refused(refusal) => out.put(&[refusal.decode.0, refusal.code_1, refusal.code_2]),
        }
    }
}

impl Dpv1Refusal {
    /// The DP-V1 error; `None` if the codes have another meaning.
    pub fn record_error(&self) -> Option<RecordError> {
        (self.decode == Dpv1ErrorDecode::DPV1).then_some(RecordError(self.code_1))
    }
}

impl Dpv1Record {
    fn read(reader: &mut ByteReader<'_>, has_data: bool) -> Result<Dpv1Record> {
        let (slot, index, length) = (reader.u8()?, reader.u8()?, reader.u8()?);
        let data = if has_data { reader.take(length.into())?.to_vec() } else { Vec::new() };
        Ok(Dpv1Record { slot, index, length, data })
    }
}

impl InitiateFeatures {
    fn read(reader: &mut ByteReader<'_>) -> Result<InitiateFeatures> {
        let (features, profile_features, profile) = (reader.array()?, reader.array()?, reader.u16()?);
        let [source, source_length, destination, destination_length] = reader.array()?;
        Ok(InitiateFeatures {
            features,
            profile_features,
            profile,
            source: Endpoint { kind: source, address: reader.take(source_length.into())?.to_vec() },
            destination: Endpoint { kind: destination, address: reader.take(destination_length.into())?.to_vec() },
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put(&self.features);
        out.put(&self.profile_features);
        out.put_u16(self.profile);
        let InitiateFeatures { source, destination, .. } = self;
        out.put(&[source.kind, source.address.len() as u8, destination.kind, destination.address.len() as u8]);
        out.put(&source.address);
        out.put(&destination.address);
    }
}
