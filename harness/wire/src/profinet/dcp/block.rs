//! The blocks of a DCP frame.

use super::codes::{BlockError, BlockInfo, BlockQualifier, Element, ServiceId, ServiceType};
use crate::error::Result;
use crate::ethernet::Mac;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;
use core::net::Ipv4Addr;

/// An element with its value.
///
/// Bytes: 0 option, 1 suboption, 2-3 length of the rest, then the qualifier or info word if there is one, then the
/// value, then a zero if the length is odd.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DcpBlock {
    /// The word before the value: a [`BlockQualifier`] in a Set request, a [`BlockInfo`] in a response or Hello, otherwise `None`.
    pub word: Option<u16>,
    /// The element and its value.
    pub value: DcpValue,
}

/// The format of the blocks of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DcpBlockForm {
    /// Only the value.
    Plain,
    /// A word, then the value; [`DcpValue::Response`] never has the word.
    Worded,
}

impl DcpBlockForm {
    /// The format of the blocks of a service, or `None` if there are only elements.
    pub(super) fn of(service_id: ServiceId, service_type: ServiceType) -> Option<DcpBlockForm> {
        match (service_id, service_type) {
            (ServiceId::GET, ServiceType::REQUEST) => None,
            (ServiceId::IDENTIFY, ServiceType::REQUEST) => Some(DcpBlockForm::Plain),
            _ => Some(DcpBlockForm::Worded),
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

    fn read(reader: &mut ByteReader<'_>) -> Result<IpParameter> {
        Ok(IpParameter { address: address(reader)?, mask: address(reader)?, gateway: address(reader)? })
    }

    fn write(&self, out: &mut Vec<u8>) {
        for address in [self.address, self.mask, self.gateway] {
            out.put(&address.octets());
        }
    }
}

fn address(reader: &mut ByteReader<'_>) -> Result<Ipv4Addr> {
    reader.u32().map(Ipv4Addr::from)
}

/// The element of a block and its value; names are bytes, not validated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DcpValue {
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
    /// Makes the LED flash; [`DcpValue::FLASH_ONCE`].
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

impl DcpValue {
    /// The only defined value of [`DcpValue::Signal`].
    pub const FLASH_ONCE: u16 = 0x0100;

    /// The element of the value.
    pub fn element(&self) -> Element {
        match *self {
            DcpValue::Mac(_) => Element::MAC,
            DcpValue::IpParameter(_) => Element::IP_PARAMETER,
            DcpValue::FullIpSuite(..) => Element::FULL_IP_SUITE,
            DcpValue::Vendor(_) => Element::VENDOR,
            DcpValue::NameOfStation(_) => Element::NAME_OF_STATION,
            DcpValue::DeviceId { .. } => Element::DEVICE_ID,
            DcpValue::DeviceRole { .. } => Element::DEVICE_ROLE,
            DcpValue::DeviceOptions(_) => Element::DEVICE_OPTIONS,
            DcpValue::AliasName(_) => Element::ALIAS_NAME,
            DcpValue::DeviceInstance { .. } => Element::DEVICE_INSTANCE,
            DcpValue::OemDeviceId { .. } => Element::OEM_DEVICE_ID,
            DcpValue::StandardGateway(_) => Element::STANDARD_GATEWAY,
            DcpValue::RsiProperties(_) => Element::RSI_PROPERTIES,
            DcpValue::Dhcp { option, .. } => Element { option: Element::DHCP, suboption: option },
            DcpValue::Start => Element::START,
            DcpValue::Stop => Element::STOP,
            DcpValue::Signal(_) => Element::SIGNAL,
            DcpValue::Response { .. } => Element::RESPONSE,
            DcpValue::FactoryReset => Element::FACTORY_RESET,
            DcpValue::ResetToFactory => Element::RESET_TO_FACTORY,
            DcpValue::DeviceInitiative(_) => Element::DEVICE_INITIATIVE,
            DcpValue::AllSelector => Element::ALL,
            DcpValue::Raw { element, .. } => element,
        }
    }

    /// Parses the value of `element` from all of `octets`; a value that does not fit is preserved raw.
    fn parse(element: Element, octets: &[u8]) -> DcpValue {
        let mut reader = ByteReader::new("DCP block", octets);
        match DcpValue::known(element, &mut reader) {
            Ok(Some(value)) if reader.is_empty() => value,
            _ => DcpValue::Raw { element, octets: octets.into() },
        }
    }

    fn known(element: Element, reader: &mut ByteReader<'_>) -> Result<Option<DcpValue>> {
        Ok(Some(match element {
            Element::MAC => DcpValue::Mac(Mac::read(reader)?),
            Element::IP_PARAMETER => DcpValue::IpParameter(IpParameter::read(reader)?),
            Element::FULL_IP_SUITE => DcpValue::FullIpSuite(
                IpParameter::read(reader)?,
                [address(reader)?, address(reader)?, address(reader)?, address(reader)?],
            ),
            Element::VENDOR => DcpValue::Vendor(reader.rest().into()),
            Element::NAME_OF_STATION => DcpValue::NameOfStation(reader.rest().into()),
            Element::DEVICE_ID => DcpValue::DeviceId { vendor_id: reader.u16()?, device_id: reader.u16()? },
            Element::DEVICE_ROLE => DcpValue::DeviceRole { role: reader.u8()?, reserved: reader.u8()? },
            Element::DEVICE_OPTIONS => {
                let mut elements = Vec::new();
                while !reader.is_empty() {
                    elements.push(Element::read(reader)?);
                }
                DcpValue::DeviceOptions(elements)
            }
            Element::ALIAS_NAME => DcpValue::AliasName(reader.rest().into()),
            Element::DEVICE_INSTANCE => DcpValue::DeviceInstance { high: reader.u8()?, low: reader.u8()? },
            Element::OEM_DEVICE_ID => DcpValue::OemDeviceId { vendor_id: reader.u16()?, device_id: reader.u16()? },
            Element::STANDARD_GATEWAY => DcpValue::StandardGateway(address(reader)?),
            Element::RSI_PROPERTIES => DcpValue::RsiProperties(reader.u16()?),
            Element { option: Element::DHCP, suboption } => {
                DcpValue::Dhcp { option: suboption, octets: reader.rest().into() }
            }
            Element::START => DcpValue::Start,
            Element::STOP => DcpValue::Stop,
            Element::SIGNAL => DcpValue::Signal(reader.u16()?),
            Element::RESPONSE => {
                DcpValue::Response { element: Element::read(reader)?, error: BlockError(reader.u8()?) }
            }
            Element::FACTORY_RESET => DcpValue::FactoryReset,
            Element::RESET_TO_FACTORY => DcpValue::ResetToFactory,
            Element::DEVICE_INITIATIVE => DcpValue::DeviceInitiative(reader.u16()?),
            Element::ALL => DcpValue::AllSelector,
            _ => return Ok(None),
        }))
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            DcpValue::Mac(mac) => out.put(&mac.0),
            DcpValue::IpParameter(ip) => ip.write(out),
            DcpValue::FullIpSuite(ip, servers) => {
                ip.write(out);
                servers.iter().for_each(|server| out.put(&server.octets()));
            }
            DcpValue::Vendor(name) | DcpValue::NameOfStation(name) | DcpValue::AliasName(name) => out.put(name),
            DcpValue::DeviceId { vendor_id, device_id } | DcpValue::OemDeviceId { vendor_id, device_id } => {
                out.put_u16(*vendor_id);
                out.put_u16(*device_id);
            }
            DcpValue::DeviceRole { role: first, reserved: second }
            | DcpValue::DeviceInstance { high: first, low: second } => out.put(&[*first, *second]),
            DcpValue::DeviceOptions(elements) => elements.iter().for_each(|element| element.write(out)),
            DcpValue::StandardGateway(gateway) => out.put(&gateway.octets()),
            DcpValue::RsiProperties(word) | DcpValue::Signal(word) | DcpValue::DeviceInitiative(word) => {
                out.put_u16(*word)
            }
            DcpValue::Dhcp { octets, .. } | DcpValue::Raw { octets, .. } => out.put(octets),
            DcpValue::Response { element, error } => {
                element.write(out);
                out.put_u8(error.0);
            }
            DcpValue::Start
            | DcpValue::Stop
            | DcpValue::FactoryReset
            | DcpValue::ResetToFactory
            | DcpValue::AllSelector => {}
        }
    }
}

impl DcpBlock {
    /// A filter of an Identify request.
    pub fn plain(value: DcpValue) -> DcpBlock {
        DcpBlock { word: None, value }
    }

    /// A block of a Set request.
    pub fn set(qualifier: BlockQualifier, value: DcpValue) -> DcpBlock {
        DcpBlock { word: Some(qualifier.0), value }
    }

    /// A block of a response or a Hello.
    pub fn report(info: BlockInfo, value: DcpValue) -> DcpBlock {
        DcpBlock { word: Some(info.0), value }
    }

    /// The result for `element`: a block of a response to Set, and of a response to Get for a refused element.
    pub fn outcome(element: Element, error: BlockError) -> DcpBlock {
        DcpBlock { word: None, value: DcpValue::Response { element, error } }
    }

    /// The word as the qualifier of a Set request; temporary if there is none.
    pub fn qualifier(&self) -> BlockQualifier {
        BlockQualifier(self.word.unwrap_or(0))
    }

    /// The word as the info of a response.
    pub fn info(&self) -> BlockInfo {
        BlockInfo(self.word.unwrap_or(0))
    }

    pub(super) fn read(form: DcpBlockForm, reader: &mut ByteReader<'_>) -> Result<DcpBlock> {
        let element = Element::read(reader)?;
        let length = usize::from(reader.u16()?);
        let mut body = reader.sub(length)?;
        if !length.is_multiple_of(2) && !reader.is_empty() {
            reader.u8()?;
        }
        let word = match form {
            DcpBlockForm::Worded if element != Element::RESPONSE && length >= 2 => Some(body.u16()?),
            _ => None,
        };
        Ok(DcpBlock { word, value: DcpValue::parse(element, body.rest()) })
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
