//! The blocks of a DCP frame: an element with its value.

use super::codes::{BlockError, BlockInfo, BlockQualifier, Element, ServiceId, ServiceType};
use crate::error::Result;
use crate::ethernet::Mac;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;
use core::net::Ipv4Addr;

/// An element with its value.
///
/// Octets: 0 option, 1 suboption, 2-3 length of what follows, then the word where there is one, then the value, then a
/// zero if the length is odd.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// The word before the value: a [`BlockQualifier`] in a Set request, a [`BlockInfo`] in a response or Hello, else none.
    pub word: Option<u16>,
    /// What the block is about and what it says.
    pub value: Value,
}

/// What blocks look like in the frames of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// The value alone.
    Plain,
    /// A word, then the value; [`Value::Response`] never has the word.
    Worded,
}

impl Form {
    /// The form of the blocks in the frames of a service, or `None` where there are elements only.
    pub(super) fn of(service_id: ServiceId, service_type: ServiceType) -> Option<Form> {
        match (service_id, service_type) {
            (ServiceId::GET, ServiceType::REQUEST) => None,
            (ServiceId::IDENTIFY, ServiceType::REQUEST) => Some(Form::Plain),
            _ => Some(Form::Worded),
        }
    }
}

/// IPv4 address, mask and gateway; all zero when there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct IpParameter {
    /// Address of the station.
    pub address: Ipv4Addr,
    /// Mask of its subnet.
    pub mask: Ipv4Addr,
    /// Gateway; the address itself or 0.0.0.0 when there is none.
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

/// What a block is about and what it says; names are octets as they came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Value {
    /// MAC address of the station.
    Mac(Mac),
    /// IPv4 address, mask, gateway.
    IpParameter(IpParameter),
    /// IPv4 address, mask, gateway and four name servers.
    FullIpSuite(IpParameter, [Ipv4Addr; 4]),
    /// Type of the station, in the words of its vendor.
    Vendor(Vec<u8>),
    /// Name of the station; empty when it has none.
    NameOfStation(Vec<u8>),
    /// Vendor and device number.
    DeviceId {
        /// Number of the vendor, given by PI.
        vendor_id: u16,
        /// Number of the device, given by the vendor.
        device_id: u16,
    },
    /// What the station can be.
    DeviceRole {
        /// Bit 0 IO device, 1 IO controller, 2 IO multidevice, 3 supervisor.
        role: u8,
        /// To be 0.
        reserved: u8,
    },
    /// The elements that the station knows.
    DeviceOptions(Vec<Element>),
    /// Name by position: `port.station` of the neighbour.
    AliasName(Vec<u8>),
    /// Number of the interface within the device.
    DeviceInstance {
        /// High octet.
        high: u8,
        /// Low octet.
        low: u8,
    },
    /// Vendor and device number of the maker behind the label.
    OemDeviceId {
        /// Number of the vendor, given by PI.
        vendor_id: u16,
        /// Number of the device, given by the vendor.
        device_id: u16,
    },
    /// The gateway that all stations of the subnet share.
    StandardGateway(Ipv4Addr),
    /// Bits of the remote service interface.
    RsiProperties(u16),
    /// A DHCP option, opaque.
    Dhcp {
        /// Number of the DHCP option, which is the suboption too.
        option: u8,
        /// What the block carries, the number and length of DHCP included.
        octets: Vec<u8>,
    },
    /// Begin of a transaction.
    Start,
    /// End of a transaction.
    Stop,
    /// Let a light flash; [`Value::FLASH_ONCE`].
    Signal(u16),
    /// How it went with an element.
    Response {
        /// The element that was asked for or set.
        element: Element,
        /// How it went.
        error: BlockError,
    },
    /// Reset by the older suboption 5.
    FactoryReset,
    /// Reset by suboption 6; what is reset stands in the qualifier.
    ResetToFactory,
    /// Bit 0: the device sends Hello after its start.
    DeviceInitiative(u16),
    /// Everybody is meant.
    AllSelector,
    /// An unknown element, or a value that has not the length of its element.
    Raw {
        /// What the block is about.
        element: Element,
        /// What it says.
        octets: Vec<u8>,
    },
}

impl Value {
    /// The value of [`Value::Signal`] that is in use.
    pub const FLASH_ONCE: u16 = 0x0100;

    /// What the value is about.
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

    /// Reads the value of `element` from all of `octets`; what does not fit is kept raw.
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

    /// What a Set request sets.
    pub fn set(qualifier: BlockQualifier, value: Value) -> Block {
        Block { word: Some(qualifier.0), value }
    }

    /// What a response or a Hello tells.
    pub fn tell(info: BlockInfo, value: Value) -> Block {
        Block { word: Some(info.0), value }
    }

    /// How it went with `element`: what a response to Set consists of, and what stands in one to Get for a refused element.
    pub fn outcome(element: Element, error: BlockError) -> Block {
        Block { word: None, value: Value::Response { element, error } }
    }

    /// The word as the qualifier of a Set request; temporary when there is none.
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
