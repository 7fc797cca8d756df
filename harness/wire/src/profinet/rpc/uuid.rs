//! UUIDs of objects, interfaces and activities.

use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use alloc::vec::Vec;
use core::fmt;
use core::str::FromStr;

/// A UUID of 16 bytes in canonical order, in which it is printed.
///
/// On the wire its first three fields (32, 16 and 16 bits) are in the byte order of their context: that of drep in an RPC header,
/// big-endian in a block.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Uuid(pub [u8; 16]);

impl Uuid {
    /// The nil UUID: no object, no AR.
    pub const NIL: Uuid = Uuid([0; 16]);
    /// The interface of an IO device.
    pub const DEVICE_INTERFACE: Uuid = Uuid::interface(1);
    /// The interface of an IO controller, called for ApplicationReady.
    pub const CONTROLLER_INTERFACE: Uuid = Uuid::interface(2);
    /// The interface of an IO supervisor.
    pub const SUPERVISOR_INTERFACE: Uuid = Uuid::interface(3);
    /// The interface of a parameter server.
    pub const PARAMETER_SERVER_INTERFACE: Uuid = Uuid::interface(4);
    /// The interface of a CIM device.
    pub const CIM_INTERFACE: Uuid = Uuid::interface(5);
    /// The interface of the endpoint mapper, version 3.0.
    pub const ENDPOINT_MAPPER: Uuid =
        Uuid([0xE1, 0xAF, 0x83, 0x08, 0x5D, 0x1F, 0x11, 0xC9, 0x91, 0xA4, 0x08, 0x00, 0x2B, 0x14, 0xA0, 0xFA]);
    /// The transfer syntax NDR, version 2.0.
    pub const NDR: Uuid =
        Uuid([0x8A, 0x88, 0x5D, 0x04, 0x1C, 0xEB, 0x11, 0xC9, 0x9F, 0xE8, 0x08, 0x00, 0x2B, 0x10, 0x48, 0x60]);

    const fn interface(number: u8) -> Uuid {
        Uuid([0xDE, 0xA0, 0, number, 0x6C, 0x97, 0x11, 0xD1, 0x82, 0x71, 0x00, 0xA0, 0x24, 0x42, 0xDF, 0x7D])
    }

    /// Whether all bytes are zero.
    pub fn is_nil(&self) -> bool {
        *self == Uuid::NIL
    }

    /// Reads a UUID in the byte order of the reader.
    pub fn read(reader: &mut ByteReader) -> Result<Uuid> {
        let mut octets = [0; 16];
        octets[..4].copy_from_slice(&reader.u32()?.to_be_bytes());
        octets[4..6].copy_from_slice(&reader.u16()?.to_be_bytes());
        octets[6..8].copy_from_slice(&reader.u16()?.to_be_bytes());
        octets[8..].copy_from_slice(reader.take(8)?);
        Ok(Uuid(octets))
    }

    /// Appends the UUID in `order`.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        let [a, b, c, d, e, f, g, h, node @ ..] = self.0;
        out.put_u32_in(order, u32::from_be_bytes([a, b, c, d]));
        out.put_u16_in(order, u16::from_be_bytes([e, f]));
        out.put_u16_in(order, u16::from_be_bytes([g, h]));
        out.put(&node);
    }
}

impl fmt::Display for Uuid {
    /// Lower-case hexadecimal digits in groups of 8, 4, 4, 4 and 12.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, octet) in self.0.iter().enumerate() {
            if matches!(index, 4 | 6 | 8 | 10) {
                f.write_str("-")?;
            }
            write!(f, "{octet:02x}")?;
        }
        Ok(())
    }
}

impl FromStr for Uuid {
    type Err = NotAUuid;

    /// Parses the format of `Display`; accepts upper-case digits, too.
    fn from_str(text: &str) -> Result<Uuid, NotAUuid> {
        let dashed = |index: usize| matches!(index, 8 | 13 | 18 | 23);
        if text.len() != 36 || text.bytes().enumerate().any(|(index, octet)| dashed(index) != (octet == b'-')) {
            return Err(NotAUuid);
        }
        let mut octets = [0; 16];
        let digits = text.bytes().filter(|octet| *octet != b'-');
        for (index, digit) in digits.enumerate() {
            let digit = char::from(digit).to_digit(16).ok_or(NotAUuid)? as u8;
            octets[index / 2] = octets[index / 2] << 4 | digit;
        }
        Ok(Uuid(octets))
    }
}

/// The text is not a UUID: not 32 hexadecimal digits in groups of 8, 4, 4, 4 and 12.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a UUID: expected 32 hexadecimal digits in groups of 8, 4, 4, 4 and 12")]
pub struct NotAUuid;

impl fmt::Debug for Uuid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// The content of the object UUID of a PROFINET station: `dea00000-6c97-11d1-8271-`, then these six bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ObjectUuid {
    /// Instance of the station, 1 in most devices.
    pub instance: u16,
    /// DeviceID, assigned by the vendor.
    pub device_id: u16,
    /// VendorID, assigned by PI.
    pub vendor_id: u16,
}

impl ObjectUuid {
    const HEAD: [u8; 10] = [0xDE, 0xA0, 0, 0, 0x6C, 0x97, 0x11, 0xD1, 0x82, 0x71];

    /// Parses `uuid`; `None` if it is not the object UUID of a PROFINET station.
    pub fn of(uuid: Uuid) -> Option<ObjectUuid> {
        let [head @ .., a, b, c, d, e, f] = uuid.0;
        (head == ObjectUuid::HEAD).then_some(ObjectUuid {
            instance: u16::from_be_bytes([a, b]),
            device_id: u16::from_be_bytes([c, d]),
            vendor_id: u16::from_be_bytes([e, f]),
        })
    }
}

impl From<ObjectUuid> for Uuid {
    fn from(object: ObjectUuid) -> Uuid {
        let mut octets = [0; 16];
        octets[..10].copy_from_slice(&ObjectUuid::HEAD);
        octets[10..12].copy_from_slice(&object.instance.to_be_bytes());
        octets[12..14].copy_from_slice(&object.device_id.to_be_bytes());
        octets[14..].copy_from_slice(&object.vendor_id.to_be_bytes());
        Uuid(octets)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;
    use rstest::rstest;

    #[rstest]
    #[case::device(Uuid::DEVICE_INTERFACE, "dea00001-6c97-11d1-8271-00a02442df7d")]
    #[case::controller(Uuid::CONTROLLER_INTERFACE, "dea00002-6c97-11d1-8271-00a02442df7d")]
    #[case::supervisor(Uuid::SUPERVISOR_INTERFACE, "dea00003-6c97-11d1-8271-00a02442df7d")]
    #[case::parameter_server(Uuid::PARAMETER_SERVER_INTERFACE, "dea00004-6c97-11d1-8271-00a02442df7d")]
    #[case::cim(Uuid::CIM_INTERFACE, "dea00005-6c97-11d1-8271-00a02442df7d")]
    #[case::mapper(Uuid::ENDPOINT_MAPPER, "e1af8308-5d1f-11c9-91a4-08002b14a0fa")]
    #[case::ndr(Uuid::NDR, "8a885d04-1ceb-11c9-9fe8-08002b104860")]
    fn known_uuids_are_formatted_as_in_the_standards(#[case] uuid: Uuid, #[case] text: &str) {
        assert_eq!(uuid.to_string(), text);
        assert_eq!(text.parse(), Ok(uuid));
        assert_eq!(text.to_uppercase().parse(), Ok(uuid));
    }

    #[rstest]
    #[case("")]
    #[case("dea00001-6c97-11d1-8271-00a02442df7")]
    #[case("dea000016-c97-11d1-8271-00a02442df7d")]
    #[case("dea00001-6c97-11d1-8271-00a02442df7g")]
    #[case("dea00001-6c97-11d1-8271-00a0244\u{e9}f7d")]
    fn other_text_is_not_a_uuid(#[case] text: &str) {
        assert_eq!(text.parse::<Uuid>(), Err(NotAUuid));
    }

    // Packets 1 and 2 of one-ar-life.pcapng have the object UUID of device 0003 of vendor 015A; that of packet 2 is little-endian.
    #[rstest]
    #[case(ByteOrder::Big, [0xDE, 0xA0, 0, 0, 0x6C, 0x97, 0x11, 0xD1, 0x82, 0x71, 0, 1, 0, 3, 1, 0x5A])]
    #[case(ByteOrder::Little, [0, 0, 0xA0, 0xDE, 0x97, 0x6C, 0xD1, 0x11, 0x82, 0x71, 0, 1, 0, 3, 1, 0x5A])]
    fn an_object_uuid_names_instance_device_and_vendor(#[case] order: ByteOrder, #[case] octets: [u8; 16]) {
        let uuid = Uuid::read(&mut ByteReader::new("test", &octets).order(order)).expect("16 bytes");
        let object = ObjectUuid { instance: 1, device_id: 3, vendor_id: 0x015A };
        assert_eq!(ObjectUuid::of(uuid), Some(object));
        assert_eq!(Uuid::from(object), uuid);
        let mut again = Vec::new();
        uuid.write(&mut again, order);
        assert_eq!(again, octets);
        assert_eq!(ObjectUuid::of(Uuid::DEVICE_INTERFACE), None);
    }
}
