//! The values of the elements of DCP.

use super::super::stack::Stack;
use super::block_without_info;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, BlockInfo, DcpBlock, DcpValue, Element};

/// The elements that the device supports, in the order of DeviceOptions.
const KNOWN: [Element; 13] = [
    Element::MAC,
    Element::IP_PARAMETER,
    Element::VENDOR,
    Element::NAME_OF_STATION,
    Element::DEVICE_ID,
    Element::DEVICE_ROLE,
    Element::DEVICE_OPTIONS,
    Element::ALIAS_NAME,
    Element::DEVICE_INSTANCE,
    Element::SIGNAL,
    Element::FACTORY_RESET,
    Element::RESET_TO_FACTORY,
    Element::DEVICE_INITIATIVE,
];

/// Device role: IO device.
const IO_DEVICE: u8 = 1;
/// Device initiative: the device says Hello.
const SAYS_HELLO: u16 = 1;

/// The error for an unsupported `element`.
pub(super) fn unsupported_error(element: Element) -> BlockError {
    let knows_option = KNOWN.iter().any(|known| known.option == element.option);
    if knows_option { BlockError::SUBOPTION_NOT_SUPPORTED } else { BlockError::OPTION_NOT_SUPPORTED }
}

impl Stack {
    /// The value of `element`, if the device supports it and it has a value.
    pub(super) fn value(&self, element: Element) -> Option<DcpValue> {
        let identity = &self.identity;
        let value = match element {
            Element::MAC => DcpValue::Mac(self.retained.mac),
            Element::IP_PARAMETER => DcpValue::IpParameter(IpParameter {
                address: Ipv4Addr::from(self.station.ip),
                mask: Ipv4Addr::from(self.station.mask),
                gateway: Ipv4Addr::from(self.station.gateway),
            }),
            Element::VENDOR => DcpValue::Vendor(identity.station_type.as_bytes().to_vec()),
            Element::NAME_OF_STATION => DcpValue::NameOfStation(self.station.name.clone()),
            Element::DEVICE_ID => DcpValue::DeviceId { vendor_id: identity.vendor_id, device_id: identity.device_id },
            Element::DEVICE_ROLE => DcpValue::DeviceRole { role: IO_DEVICE, reserved: 0 },
            Element::DEVICE_OPTIONS => DcpValue::DeviceOptions(KNOWN.to_vec()),
            Element::ALIAS_NAME => DcpValue::AliasName(self.alias()?),
            Element::DEVICE_INSTANCE => DcpValue::DeviceInstance { high: 0, low: 1 },
            Element::DEVICE_INITIATIVE => {
                DcpValue::DeviceInitiative(self.hello_settings(true).map_or(0, |_| SAYS_HELLO))
            }
            _ => return None,
        };
        Some(self.hooks.apply(value, |hooks, value| hooks.element(value)))
    }

    /// The BlockInfo of an element.
    pub(super) fn info(&self, element: Element) -> BlockInfo {
        let has_address = self.station.ip != [0; 4];
        if element == Element::IP_PARAMETER && has_address { BlockInfo::IP_SET } else { BlockInfo::NONE }
    }

    fn blocks(&self, elements: &[Element]) -> Vec<DcpBlock> {
        let block = |element: &Element| {
            self.value(*element).map(|value| match self.info(*element) {
                BlockInfo::NONE => block_without_info(value),
                info => DcpBlock::report(info, value),
            })
        };
        elements.iter().filter_map(block).collect()
    }

    /// The blocks of an Identify response.
    pub(super) fn identify_blocks(&self) -> Vec<DcpBlock> {
        self.blocks(&[
            Element::DEVICE_OPTIONS,
            Element::VENDOR,
            Element::NAME_OF_STATION,
            Element::DEVICE_ID,
            Element::DEVICE_ROLE,
            Element::DEVICE_INSTANCE,
            Element::IP_PARAMETER,
            Element::DEVICE_INITIATIVE,
        ])
    }

    /// The blocks of the Hello after the start.
    pub(super) fn hello_blocks(&self) -> Vec<DcpBlock> {
        self.blocks(&[Element::NAME_OF_STATION, Element::IP_PARAMETER, Element::DEVICE_ID, Element::DEVICE_INITIATIVE])
    }
}
