//! The endpoint mapper: the registered interfaces of a station, their ports, and its annotation.
//!
//! PROFINET uses one operation of it, the lookup. All words are in the byte order of the RPC header, except those of a tower, which
//! are always little-endian, and its port and address, which are big-endian (C706, appendices I, L and O).

use super::Uuid;
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The inquiry type of a lookup; 32 bits.
    pub struct InquiryType(u32) {
        0 ALL all "All registered endpoints.",
        1 BY_INTERFACE by_interface "The endpoints of an interface.",
        2 BY_OBJECT by_object "The endpoints of an object.",
        3 BY_BOTH by_both "The endpoints of an interface and an object.",
    }
}

/// The position at which a lookup continues. Bytes: 0-3 attributes, 4-19 UUID; nil at the start and at the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LookupHandle {
    /// Attributes, 0.
    pub attributes: u32,
    /// The UUID that the server assigned to the lookup.
    pub uuid: Uuid,
}

impl LookupHandle {
    fn read(reader: &mut ByteReader) -> Result<LookupHandle> {
        Ok(LookupHandle { attributes: reader.u32()?, uuid: Uuid::read(reader)? })
    }

    fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        out.put_u32_in(order, self.attributes);
        self.uuid.write(out, order);
    }
}

/// The request of a lookup (`ept_lookup`).
///
/// Bytes with both pointers given: 0-3 inquiry type, 4-7 referent of the object, 8-23 object, 24-27 referent of the interface,
/// 28-43 interface, 44-45 major version, 46-47 minor version, 48-51 version option, 52-71 handle, 72-75 maximum number of entries.
/// After a referent of 0 its object is omitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LookupRequest {
    /// The inquiry type.
    pub inquiry_type: InquiryType,
    /// Referent, not 0, and the object; nil for any.
    pub object: Option<(u32, Uuid)>,
    /// Referent, not 0, the interface, its major and its minor version; nil and zeros for any.
    pub interface: Option<(u32, Uuid, u16, u16)>,
    /// How versions are compared: 1 any, 2 compatible, 3 exact, 4 same major, 5 up to.
    pub version_option: u32,
    /// The position at which to continue.
    pub handle: LookupHandle,
    /// The maximum number of entries in the response.
    pub max_entries: u32,
}

impl LookupRequest {
    /// A request for the next of all registered endpoints, from `handle` on.
    pub fn all(handle: LookupHandle) -> LookupRequest {
        LookupRequest {
            inquiry_type: InquiryType::ALL,
            object: Some((1, Uuid::NIL)),
            interface: Some((2, Uuid::NIL, 0, 0)),
            version_option: 1,
            handle,
            max_entries: 1,
        }
    }

    /// Reads the body of a lookup request in `order`.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<LookupRequest> {
        let reader = &mut ByteReader::new("ept_lookup request", body).order(order);
        let inquiry_type = InquiryType(reader.u32()?);
        let object = match reader.u32()? {
            0 => None,
            referent => Some((referent, Uuid::read(reader)?)),
        };
        let interface = match reader.u32()? {
            0 => None,
            referent => Some((referent, Uuid::read(reader)?, reader.u16()?, reader.u16()?)),
        };
        Ok(LookupRequest {
            inquiry_type,
            object,
            interface,
            version_option: reader.u32()?,
            handle: LookupHandle::read(reader)?,
            max_entries: reader.u32()?,
        })
    }

    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        out.put_u32_in(order, self.inquiry_type.0);
        let (referent, object) = self.object.unwrap_or((0, Uuid::NIL));
        out.put_u32_in(order, referent);
        if referent != 0 {
            object.write(out, order);
        }
        let (referent, interface, major, minor) = self.interface.unwrap_or((0, Uuid::NIL, 0, 0));
        out.put_u32_in(order, referent);
        if referent != 0 {
            interface.write(out, order);
            out.put_u16_in(order, major);
            out.put_u16_in(order, minor);
        }
        out.put_u32_in(order, self.version_option);
        self.handle.write(out, order);
        out.put_u32_in(order, self.max_entries);
    }
}

/// A registered endpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EndpointEntry {
    /// The object.
    pub object: Uuid,
    /// Interface, protocols, port and address; `None` if the pointer is null.
    pub tower: Option<Tower>,
    /// The annotation, a text about the station; 64 bytes in PROFINET, zero-terminated.
    ///
    /// In PROFINET it consists of device type (25), blank, order number (20), blank, hardware revision (5), blank, software
    /// revision (10).
    pub annotation: Vec<u8>,
}

impl EndpointEntry {
    /// The annotation without the zeros and blanks at its end.
    pub fn annotation(&self) -> &[u8] {
        let end = self.annotation.iter().position(|octet| *octet == 0).unwrap_or(self.annotation.len());
        self.annotation[..end].trim_ascii_end()
    }
}

/// The response of a lookup.
///
/// Bytes: 0-19 handle, 20-23 number of entries, 24-35 largest count, offset and count of the array; then per entry the object (16),
/// the referent of its tower (4), offset (4) and length (4) of the annotation, the annotation, padding to 4; then the towers, each
/// with its length twice and padding to 4; then the status (4).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LookupResponse {
    /// The position at which to continue.
    pub handle: LookupHandle,
    /// The requested maximum number of entries.
    pub max_entries: u32,
    /// The entries.
    pub entries: Vec<EndpointEntry>,
    /// 0, or [`LookupResponse::NOT_REGISTERED`].
    pub status: u32,
}

impl LookupResponse {
    /// Status: no further endpoint is registered.
    pub const NOT_REGISTERED: u32 = 0x16C9_A0D6;

    /// Reads the body of a lookup response in `order`.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<LookupResponse> {
        let reader = &mut ByteReader::new("ept_lookup response", body).order(order);
        let handle = LookupHandle::read(reader)?;
        let _number = reader.u32()?;
        let max_entries = reader.u32()?;
        let _offset = reader.u32()?;
        let count = reader.u32()?;
        let mut entries = Vec::new();
        let mut referents = Vec::new();
        for _ in 0..count {
            let object = Uuid::read(reader)?;
            referents.push(reader.u32()?);
            let _offset = reader.u32()?;
            let length = reader.u32()?;
            let annotation = reader.take(length as usize)?.to_vec();
            reader.align(4);
            entries.push(EndpointEntry { object, tower: None, annotation });
        }
        for (entry, _) in entries.iter_mut().zip(&referents).filter(|(_, referent)| **referent != 0) {
            let _count = reader.u32()?;
            let length = reader.u32()?;
            entry.tower = Some(Tower::read(&mut reader.sub(length as usize)?)?);
            reader.align(4);
        }
        Ok(LookupResponse { handle, max_entries, entries, status: reader.u32()? })
    }

    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        let start = out.len();
        let pad = |out: &mut Vec<u8>| out.resize(start + (out.len() - start).next_multiple_of(4), 0);
        self.handle.write(out, order);
        let count = self.entries.len() as u32;
        for word in [count, self.max_entries, 0, count] {
            out.put_u32_in(order, word);
        }
        for (entry, referent) in self.entries.iter().zip(3_u32..) {
            entry.object.write(out, order);
            out.put_u32_in(order, if entry.tower.is_some() { referent } else { 0 });
            out.put_u32_in(order, 0);
            out.put_u32_in(order, entry.annotation.len() as u32);
            out.put(&entry.annotation);
            pad(out);
        }
        for tower in self.entries.iter().filter_map(|entry| entry.tower.as_ref()) {
            let octets = tower.to_vec();
            out.put_u32_in(order, octets.len() as u32);
            out.put_u32_in(order, octets.len() as u32);
            out.put(&octets);
            pad(out);
        }
        out.put_u32_in(order, self.status);
    }
}

/// The protocols to reach an interface, from top to bottom; each floor has a left side (protocol) and a right side (address).
///
/// Bytes: 0-1 number of floors, then per floor length of the left side (2), left side, length of the right side (2), right side.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tower {
    /// Left and right side of each floor; the first byte of the left side is the protocol.
    pub floors: Vec<(Vec<u8>, Vec<u8>)>,
}

impl Tower {
    const UUID: u8 = 0x0D;
    const CONNECTIONLESS: u8 = 0x0A;
    const UDP: u8 = 0x08;
    const IP: u8 = 0x09;

    /// Interface `interface` of version `major`.`minor` in NDR over connectionless RPC over UDP `port` at `address`.
    pub fn udp(interface: Uuid, major: u16, minor: u16, port: u16, address: [u8; 4]) -> Tower {
        let named = |uuid: Uuid, version: u16| {
            let mut left = alloc::vec![Tower::UUID];
            uuid.write(&mut left, ByteOrder::Little);
            left.put_u16_in(ByteOrder::Little, version);
            left
        };
        Tower {
            floors: alloc::vec![
                (named(interface, major), minor.to_le_bytes().to_vec()),
                (named(Uuid::NDR, 2), alloc::vec![0, 0]),
                (alloc::vec![Tower::CONNECTIONLESS], alloc::vec![0, 0]),
                (alloc::vec![Tower::UDP], port.to_be_bytes().to_vec()),
                (alloc::vec![Tower::IP], address.to_vec()),
            ],
        }
    }

    /// The interface with its major and minor version, from the first floor.
    pub fn interface(&self) -> Option<(Uuid, u16, u16)> {
        let (left, right) = self.floors.first()?;
        let mut left = ByteReader::new("tower", left).order(ByteOrder::Little);
        let is_uuid = left.u8().ok()? == Tower::UUID;
        let uuid = Uuid::read(&mut left).ok()?;
        let minor = ByteReader::new("tower", right).order(ByteOrder::Little).u16().ok()?;
        is_uuid.then_some((uuid, left.u16().ok()?, minor))
    }

    /// The UDP port.
    pub fn port(&self) -> Option<u16> {
        Some(u16::from_be_bytes(self.right(Tower::UDP)?.try_into().ok()?))
    }

    /// The IPv4 address.
    pub fn address(&self) -> Option<[u8; 4]> {
        self.right(Tower::IP)?.try_into().ok()
    }

    fn right(&self, protocol: u8) -> Option<&[u8]> {
        self.floors.iter().find(|(left, _)| left.first() == Some(&protocol)).map(|(_, right)| right.as_slice())
    }

    fn read(reader: &mut ByteReader) -> Result<Tower> {
        let mut inner = reader.order(ByteOrder::Little);
        let mut floors = Vec::new();
        for _ in 0..inner.u16()? {
            let length = inner.u16()?;
            let left = inner.take(length.into())?.to_vec();
            let length = inner.u16()?;
            floors.push((left, inner.take(length.into())?.to_vec()));
        }
        Ok(Tower { floors })
    }

    fn to_vec(&self) -> Vec<u8> {
        let mut out = Vec::new();
        out.put_u16_in(ByteOrder::Little, self.floors.len() as u16);
        for side in self.floors.iter().flat_map(|(left, right)| [left, right]) {
            out.put_u16_in(ByteOrder::Little, side.len() as u16);
            out.put(side);
        }
        out
    }
}
