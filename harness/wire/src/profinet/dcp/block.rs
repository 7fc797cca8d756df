//! The blocks of a DCP frame.

use super::codes::{BlockError, BlockInfo, BlockQualifier, Element, ServiceId, ServiceType};
use crate::error::Result;
use crate::ethernet::Mac;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;
use core::net::Ipv4Addr;

/// An element with its value.
///
/// Bytes: 0 option, 1 suboption, 2-3 length of the rest, then the qualifier or info word if there is one, then the
/// value, then a zero if the length is odd.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The word before the value: a [`BlockQualifier`] in a Set request, a [`BlockInfo`] in a response or Hello, otherwise `None`.
    pub word: Option<u16>,
    /// The element and its value.
    pub value: Value,
}

/// The format of the blocks of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Only the value.
    Plain,
    /// A word, then the value; [`Value::Response`] never has the word.
    Worded,
}

impl Form {
    /// The format of the blocks of a service, or `None` if there are only elements.
    pub(super) fn of(service_id: ServiceId, service_type: ServiceType) -> Option<Form> {
        match (service_id, service_type) {
            (ServiceId::GET, ServiceType::REQUEST) => None,
            (ServiceId::IDENTIFY, ServiceType::REQUEST) => Some(Form::Plain),
            _ => Some(Form::Worded),
        }
    }
}

/// IPv4 address, mask and gateway; all zero if there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct IpParameter {
    /// IPv4 address of the station.
    pub address: Ipv4Addr,
    /// Subnet mask.
    pub mask: Ipv4Addr,
    /// Gateway; the address of the station or 0.0.0.0 if there is none.
    pub gateway: Ipv4Addr,
}

impl IpParameter {
    /// No address.
    pub const NONE: IpParameter =
        IpParameter { address: Ipv4Addr::UNSPECIFIED, mask: Ipv4Addr::UNSPECIFIED, gateway: Ipv4Addr::UNSPECIFIED };

    fn read(reader: &mut Reader<'_>) -> Result<IpParameter> {
        Ok(IpParameter { address: address(reader)?, mask: address(reader)?, gateway: address(reader)? })
    }

    fn write(&self, out: &mut Vec<u8>) {
        for address in [self.address, self.mask, self.gateway] {
            out.put(&address.octets());
        }
    }
}

fn address(reader: &mut Reader<'_>) -> Result<Ipv4Addr> {
    reader.u32().map(Ipv4Addr::from)
}

/// The element of a block and its value; names are bytes, not validated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// MAC address of the station.
    Mac(Mac),
    /// IPv4 address, mask, gateway.
    IpParameter(IpParameter),
    /// IPv4 address, mask, gateway and four name servers.
    FullIpSuite(IpParameter, [Ipv4Addr; 4]),
    /// DeviceVendorValue: the type of station, as text of the vendor.
    Vendor(Vec<u8>),
    /// Name of the station; empty if it has none.
    NameOfStation(Vec<u8>),
    /// Vendor and device number.
    DeviceId {
        /// VendorID, assigned by PI.
        vendor_id: u16,
        /// DeviceID, assigned by the vendor.
        device_id: u16,
    },
    /// The role of the station.
    DeviceRole {
        /// Bit 0 IO device, 1 IO controller, 2 IO multidevice, 3 supervisor.
        role: u8,
        /// Reserved, must be 0.
        reserved: u8,
    },
    /// The elements that the station supports.
    DeviceOptions(Vec<Element>),
    /// Alias name by topology: `port.station` of the neighbour.
    AliasName(Vec<u8>),
    /// Number of the interface within the device.
    DeviceInstance {
        /// High byte.
        high: u8,
        /// Low byte.
        low: u8,
    },
    /// Vendor and device number of the original manufacturer.
    OemDeviceId {
        /// VendorID, assigned by PI.
        vendor_id: u16,
        /// DeviceID, assigned by the vendor.
        device_id: u16,
    },
    /// The standard gateway of the subnet.
    StandardGateway(Ipv4Addr),
    /// Properties of the remote service interface (RSI).
    RsiProperties(u16),
    /// A DHCP option, not parsed.
    Dhcp {
        /// Number of the DHCP option, which is also the suboption.
        option: u8,
        /// The content of the block, including the DHCP option number and length.
        octets: Vec<u8>,
    },
    /// Start of a transaction.
    Start,
    /// End of a transaction.
    Stop,
    /// Makes the LED flash; [`Value::FLASH_ONCE`].
    Signal(u16),
    /// The result for an element.
    Response {
        /// The requested or set element.
        element: Element,
        /// The result.
        error: BlockError,
    },
    /// Reset with the older suboption 5.
    FactoryReset,
    /// Reset with suboption 6; the qualifier has the reset mode.
    ResetToFactory,
    /// Bit 0: the device sends Hello after its start.
    DeviceInitiative(u16),
    /// All stations.
    AllSelector,
    /// An unknown element, or a value with an invalid length for its element.
    Raw {
        /// The element.
        element: Element,
        /// The value.
        octets: Vec<u8>,
    },
}

impl Value {
    /// The only defined value of [`Value::Signal`].
    pub const FLASH_ONCE: u16 = 0x0100;

    /// The element of the value.
    pub fn element(&self) -> Element {
        match *self {
            Value::Mac(_) => Element::MAC,
            Value::IpParameter(_) => Element::IP_PARAMETER,
            Value::FullIpSuite(..) => Element::FULL_IP_SUITE,
            Value::Vendor(_) => Element::VENDOR,
            Value::NameOfStation(_) => Element::NAME_OF_STATION,
            Value::DeviceId { .. } => Element::DEVICE_ID,
            Value::DeviceRole { .. } => Element::DEVICE_ROLE,
            Value::DeviceOptions(_) => Element::DEVICE_OPTIONS,
            Value::AliasName(_) => Element::ALIAS_NAME,
            Value::DeviceInstance { .. } => Element::DEVICE_INSTANCE,
            Value::OemDeviceId { .. } => Element::OEM_DEVICE_ID,
            Value::StandardGateway(_) => Element::STANDARD_GATEWAY,
            Value::RsiProperties(_) => Element::RSI_PROPERTIES,
            Value::Dhcp { option, .. } => Element { option: Element::DHCP, suboption: option },
            Value::Start => Element::START,
            Value::Stop => Element::STOP,
            Value::Signal(_) => Element::SIGNAL,
            Value::Response { .. } => Element::RESPONSE,
            Value::FactoryReset => Element::FACTORY_RESET,
            Value::ResetToFactory => Element::RESET_TO_FACTORY,
            Value::DeviceInitiative(_) => Element::DEVICE_INITIATIVE,
            Value::AllSelector => Element::ALL,
            Value::Raw { element, .. } => element,
        }
    }

    /// Parses the value of `element` from all of `octets`; a value that does not fit is preserved raw.
    fn parse(element: Element, octets: &[u8]) -> Value {
        let mut reader = Reader::new("DCP block", octets);
        match Value::known(element, &mut reader) {
            Ok(Some(value)) if reader.is_empty() => value,
            _ => Value::Raw { element, octets: octets.into() },
        }
    }

    fn known(element: Element, reader: &mut Reader<'_>) -> Result<Option<Value>> {
        Ok(Some(match element {
            Element::MAC => Value::Mac(Mac::read(reader)?),
            Element::IP_PARAMETER => Value::IpParameter(IpParameter::read(reader)?),
            Element::FULL_IP_SUITE => Value::FullIpSuite(
                IpParameter::read(reader)?,
                [address(reader)?, address(reader)?, address(reader)?, address(reader)?],
            ),
            Element::VENDOR => Value::Vendor(reader.rest().into()),
            Element::NAME_OF_STATION => Value::NameOfStation(reader.rest().into()),
            Element::DEVICE_ID => Value::DeviceId { vendor_id: reader.u16()?, device_id: reader.u16()? },
            Element::DEVICE_ROLE => Value::DeviceRole { role: reader.u8()?, reserved: reader.u8()? },
            Element::DEVICE_OPTIONS => {
                let mut elements = Vec::new();
                while !reader.is_empty() {
                    elements.push(Element::read(reader)?);
                }
                Value::DeviceOptions(elements)
            }
            Element::ALIAS_NAME => Value::AliasName(reader.rest().into()),
            Element::DEVICE_INSTANCE => Value::DeviceInstance { high: reader.u8()?, low: reader.u8()? },
            Element::OEM_DEVICE_ID => Value::OemDeviceId { vendor_id: reader.u16()?, device_id: reader.u16()? },
            Element::STANDARD_GATEWAY => Value::StandardGateway(address(reader)?),
            Element::RSI_PROPERTIES => Value::RsiProperties(reader.u16()?),
            Element { option: Element::DHCP, suboption } => {
                Value::Dhcp { option: suboption, octets: reader.rest().into() }
            }
            Element::START => Value::Start,
            Element::STOP => Value::Stop,
            Element::SIGNAL => Value::Signal(reader.u16()?),
            Element::RESPONSE => Value::Response { element: Element::read(reader)?, error: BlockError(reader.u8()?) },
            Element::FACTORY_RESET => Value::FactoryReset,
            Element::RESET_TO_FACTORY => Value::ResetToFactory,
            Element::DEVICE_INITIATIVE => Value::DeviceInitiative(reader.u16()?),
            Element::ALL => Value::AllSelector,
            _ => return Ok(None),
        }))
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Value::Mac(mac) => out.put(&mac.0),
            Value::IpParameter(ip) => ip.write(out),
            Value::FullIpSuite(ip, servers) => {
                ip.write(out);
                servers.iter().for_each(|server| out.put(&server.octets()));
            }
            Value::Vendor(name) | Value::NameOfStation(name) | Value::AliasName(name) => out.put(name),
            Value::DeviceId { vendor_id, device_id } | Value::OemDeviceId { vendor_id, device_id } => {
                out.put_u16(*vendor_id);
                out.put_u16(*device_id);
            }
            Value::DeviceRole { role: first, reserved: second }
            | Value::DeviceInstance { high: first, low: second } => out.put(&[*first, *second]),
            Value::DeviceOptions(elements) => elements.iter().for_each(|element| element.write(out)),
            Value::StandardGateway(gateway) => out.put(&gateway.octets()),
            Value::RsiProperties(word) | Value::Signal(word) | Value::DeviceInitiative(word) => out.put_u16(*word),
            Value::Dhcp { octets, .. } | Value::Raw { octets, .. } => out.put(octets),
            Value::Response { element, error } => {
                element.write(out);
                out.put_u8(error.0);
            }
            Value::Start | Value::Stop | Value::FactoryReset | Value::ResetToFactory | Value::AllSelector => {}
        }
    }
}

impl Block {
    /// A filter of an Identify request.
    pub fn plain(value: Value) -> Block {
        Block { word: None, value }
    }

    /// A block of a Set request.
    pub fn set(qualifier: BlockQualifier, value: Value) -> Block {
        Block { word: Some(qualifier.0), value }
    }

    /// A block of a response or a Hello.
    pub fn tell(info: BlockInfo, value: Value) -> Block {
        Block { word: Some(info.0), value }
    }

    /// The result for `element`: a block of a response to Set, and of a response to Get for a refused element.
    pub fn outcome(element: Element, error: BlockError) -> Block {
        Block { word: None, value: Value::Response { element, error } }
    }

    /// The word as the qualifier of a Set request; temporary if there is none.
    pub fn qualifier(&self) -> BlockQualifier {
        BlockQualifier(self.word.unwrap_or(0))
    }

    /// The word as the info of a response.
    pub fn info(&self) -> BlockInfo {
        BlockInfo(self.word.unwrap_or(0))
    }

    pub(super) fn read(form: Form, reader: &mut Reader<'_>) -> Result<Block> {
        let element = Element::read(reader)?;
        let length = usize::from(reader.u16()?);
        let mut body = reader.sub(length)?;
        if !length.is_multiple_of(2) && !reader.is_empty() {
            reader.u8()?;
        }
        let word = match form {
            Form::Worded if element != Element::RESPONSE && length >= 2 => Some(body.u16()?),
            _ => None,
        };
        Ok(Block { word, value: Value::parse(element, body.rest()) })
    }

    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.value.element().write(out);
        let length_at = out.len();
        out.put_u16(0);
        if let Some(word) = self.word {
            out.put_u16(word);
        }
        self.value.write(out);
        let length = out.len() - length_at - 2;
        out[length_at..length_at + 2].copy_from_slice(&(length as u16).to_be_bytes());
        if !length.is_multiple_of(2) {
            out.put_u8(0);
        }
    }
}
