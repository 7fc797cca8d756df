//! The header of 80 bytes of each connectionless RPC PDU.

use super::Uuid;
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use alloc::vec::Vec;
use core::ops::BitOr;

codes! {
    /// The kind of an RPC PDU (C706, 12.5.2); one byte.
    pub struct PacketType(u8) {
        0 REQUEST request "The client calls an operation.",
        1 PING ping "The client asks for the state of a call.",
        2 RESPONSE response "The server responds to a call.",
        3 FAULT fault "The server started the operation, and it failed.",
        4 WORKING working "The server is still processing the call.",
        5 NOCALL nocall "The server does not know the call that the client pinged.",
        6 REJECT reject "The server did not start the operation.",
        7 ACK ack "The client has received the response.",
        8 CANCEL cancel "The client requests to cancel its call.",
        9 FACK fack "One side acknowledges received fragments.",
        10 CANCEL_ACK cancel_ack "The server has received the cancel.",
    }
}

codes! {
    /// The operation number of a PDU on a PROFINET interface; 16 bits.
    pub struct Opnum(u16) {
        0 CONNECT connect "Opens an AR.",
        1 RELEASE release "Closes an AR.",
        2 READ read "Reads a record inside an AR.",
        3 WRITE write "Writes one or several records inside an AR.",
        4 CONTROL control "Ends parametrization, reports ApplicationReady, and other commands.",
        5 READ_IMPLICIT read_implicit "Reads a record without an AR.",
    }
}

impl Opnum {
    /// The operation of the endpoint mapper that lists registered endpoints; it has its own operation numbers.
    pub const EPT_LOOKUP: Opnum = Opnum(2);
}

/// The first set of header flags (flags1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flags1(pub u8);

impl Flags1 {
    /// The last fragment of a body.
    pub const LAST_FRAGMENT: Flags1 = Flags1(0x02);
    /// A fragment of a body.
    pub const FRAGMENT: Flags1 = Flags1(0x04);
    /// The sender requests no fack for this fragment.
    pub const NO_FACK: Flags1 = Flags1(0x08);
    /// Maybe semantics: the call may be lost; no response is needed.
    pub const MAYBE: Flags1 = Flags1(0x10);
    /// Idempotent: the call may be executed twice.
    pub const IDEMPOTENT: Flags1 = Flags1(0x20);
    /// The call is a broadcast.
    pub const BROADCAST: Flags1 = Flags1(0x40);

    /// Whether all bits of `flags` are set.
    pub fn has(self, flags: Flags1) -> bool {
        self.0 & flags.0 == flags.0
    }

    /// The flags without those of `flags`.
    pub fn without(self, flags: Flags1) -> Flags1 {
        Flags1(self.0 & !flags.0)
    }
}

impl BitOr for Flags1 {
    type Output = Flags1;
    fn bitor(self, other: Flags1) -> Flags1 {
        Flags1(self.0 | other.0)
    }
}

/// The second set of header flags (flags2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Flags2(pub u8);

impl Flags2 {
    /// A cancel was pending when the call ended.
    pub const CANCEL_PENDING: Flags2 = Flags2(0x02);

    /// Whether all bits of `flags` are set.
    pub fn has(self, flags: Flags2) -> bool {
        self.0 & flags.0 == flags.0
    }
}

/// The data representation (drep) of the sender: three bytes; the high nibble of the first is the byte order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Drep(pub [u8; 3]);

impl Drep {
    /// Big-endian integers, ASCII, IEEE floating point.
    pub const BIG: Drep = Drep([0x00, 0, 0]);
    /// Little-endian integers, ASCII, IEEE floating point.
    pub const LITTLE: Drep = Drep([0x10, 0, 0]);

    /// The byte order of the integers in header, NDR frame and control bodies.
    pub fn order(self) -> ByteOrder {
        match self.0[0] >> 4 {
            0 => ByteOrder::Big,
            _ => ByteOrder::Little,
        }
    }
}

impl From<ByteOrder> for Drep {
    fn from(order: ByteOrder) -> Drep {
        match order {
            ByteOrder::Big => Drep::BIG,
            ByteOrder::Little => Drep::LITTLE,
        }
    }
}

/// The header of a connectionless RPC PDU.
///
/// Bytes: 0 version, 1 packet type, 2 flags1, 3 flags2, 4-6 drep, 7 serial high, 8-23 object, 24-39 interface, 40-55 activity,
/// 56-59 server boot time, 60-63 interface version, 64-67 sequence number, 68-69 opnum, 70-71 interface hint, 72-73 activity hint,
/// 74-75 length of body, 76-77 fragment number, 78 authentication protocol, 79 serial low (C706, 12.5.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RpcHeader {
    /// Version of the protocol, 4.
    pub version: u8,
    /// The kind of the PDU.
    pub packet_type: PacketType,
    /// First set of flags.
    pub flags1: Flags1,
    /// Second set of flags.
    pub flags2: Flags2,
    /// Data representation of the sender.
    pub drep: Drep,
    /// Serial number of the fragment, which its fack repeats.
    pub serial: u16,
    /// The called object.
    pub object: Uuid,
    /// The called interface.
    pub interface: Uuid,
    /// The calling activity (thread of the client).
    pub activity: Uuid,
    /// Boot time of the server; 0 while the client does not know it.
    pub server_boot: u32,
    /// Version of the interface: minor in the high half, major in the low half; 1 on the PROFINET interfaces.
    pub interface_version: u32,
    /// Sequence number of the call within its activity.
    pub sequence: u32,
    /// The called operation.
    pub opnum: Opnum,
    /// Interface hint of the server; 0xFFFF if unknown.
    pub interface_hint: u16,
    /// Activity hint of the server; 0xFFFF if unknown.
    pub activity_hint: u16,
    /// Length of the body in this PDU, in bytes.
    pub body_length: u16,
    /// Number of the fragment, from 0.
    pub fragment: u16,
    /// Authentication protocol; 0 for none.
    pub auth_protocol: u8,
}

impl RpcHeader {
    /// Length of a header in bytes.
    pub const LENGTH: usize = 80;

    /// A header of version 4 with unknown hints, interface version 1 and all other fields zero.
    pub fn new(packet_type: PacketType, order: ByteOrder) -> RpcHeader {
        RpcHeader {
            version: 4,
            packet_type,
            flags1: Flags1(0),
            flags2: Flags2(0),
            drep: order.into(),
            serial: 0,
            object: Uuid::NIL,
            interface: Uuid::NIL,
            activity: Uuid::NIL,
            server_boot: 0,
            interface_version: 1,
            sequence: 0,
            opnum: Opnum(0),
            interface_hint: 0xFFFF,
            activity_hint: 0xFFFF,
            body_length: 0,
            fragment: 0,
            auth_protocol: 0,
        }
    }

    /// The header of a response to this PDU: same call, same objects, only the flag `NO_FACK`, byte order `order`.
    pub fn answer(&self, packet_type: PacketType, order: ByteOrder) -> RpcHeader {
        RpcHeader {
            packet_type,
            flags1: Flags1::NO_FACK,
            flags2: Flags2(0),
            drep: order.into(),
            serial: 0,
            body_length: 0,
            fragment: 0,
            ..*self
        }
    }

    /// The byte order of this PDU.
    pub fn order(&self) -> ByteOrder {
        self.drep.order()
    }

    /// Parses a header; fails on a version other than 4 and a byte order other than 0 and 1.
    pub fn read(reader: &mut ByteReader) -> Result<RpcHeader> {
        *reader = reader.layer("RPC header");
        let version = reader.u8()?;
        if version != 4 {
            return Err(reader.wrong("rpc_vers", 1, "4", version.into()));
        }
        let packet_type = PacketType(reader.u8()?);
        let flags1 = Flags1(reader.u8()?);
        let flags2 = Flags2(reader.u8()?);
        let drep = Drep(reader.array()?);
        if drep.0[0] >> 4 > 1 {
            return Err(reader.wrong("drep", 3, "0x0- or 0x1-", drep.0[0].into()));
        }
        let serial_high = reader.u8()?;
        *reader = reader.order(drep.order());
        let object = Uuid::read(reader)?;
        let interface = Uuid::read(reader)?;
        let activity = Uuid::read(reader)?;
        Ok(RpcHeader {
            version,
            packet_type,
            flags1,
            flags2,
            drep,
            object,
            interface,
            activity,
            server_boot: reader.u32()?,
            interface_version: reader.u32()?,
            sequence: reader.u32()?,
            opnum: Opnum(reader.u16()?),
            interface_hint: reader.u16()?,
            activity_hint: reader.u16()?,
            body_length: reader.u16()?,
            fragment: reader.u16()?,
            auth_protocol: reader.u8()?,
            serial: u16::from_be_bytes([serial_high, reader.u8()?]),
        })
    }

    /// Appends the header, with `body_length` unchanged.
    pub fn write(&self, out: &mut Vec<u8>) {
        let order = self.order();
        let [serial_high, serial_low] = self.serial.to_be_bytes();
        out.put(&[self.version, self.packet_type.0, self.flags1.0, self.flags2.0]);
        out.put(&self.drep.0);
        out.put_u8(serial_high);
        for uuid in [self.object, self.interface, self.activity] {
            uuid.write(out, order);
        }
        for word in [self.server_boot, self.interface_version, self.sequence] {
            out.put_u32_in(order, word);
        }
        for word in [self.opnum.0, self.interface_hint, self.activity_hint, self.body_length, self.fragment] {
            out.put_u16_in(order, word);
        }
        out.put(&[self.auth_protocol, serial_low]);
    }
}

/// An RPC PDU, the payload of one UDP datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RpcPdu<'a> {
    /// The header.
    pub header: RpcHeader,
    /// The body or a fragment of it.
    pub body: &'a [u8],
    /// Bytes after the body that the header does not count, such as an authentication trailer.
    pub rest: &'a [u8],
}

impl<'a> RpcPdu<'a> {
    /// Parses the payload of a datagram.
    pub fn parse(octets: &'a [u8]) -> Result<RpcPdu<'a>> {
        let mut reader = ByteReader::new("RPC", octets);
        let header = RpcHeader::read(&mut reader)?;
        let body = reader.take(header.body_length.into())?;
        Ok(RpcPdu { header, body, rest: reader.rest() })
    }

    /// Appends header, body and rest; the length in the header is unchanged.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.put(self.body);
        out.put(self.rest);
    }

    /// A PDU in one piece; fills in the length in the header.
    ///
    /// The length field is truncated for a body of more than 65,535 bytes: use [`fragments`](super::fragments()) for large bodies.
    pub fn new(header: RpcHeader, body: &'a [u8]) -> RpcPdu<'a> {
        RpcPdu { header: RpcHeader { body_length: body.len() as u16, ..header }, body, rest: &[] }
    }

    /// Serializes the PDU.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(RpcHeader::LENGTH + self.body.len());
        self.write(&mut out);
        out
    }
}
