//! The codes of DCP; unknown numbers are preserved.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The service (IEC 61158-6-10, ServiceID).
    pub struct ServiceId(u8) {
        3 GET get "Reads the values of elements of one device.",
        4 SET set "Sets values of one device or triggers an action.",
        5 IDENTIFY identify "Requests the identity of all matching devices.",
        6 HELLO hello "A device reports that it has started.",
    }
}

codes! {
    /// Request or response (IEC 61158-6-10, ServiceType).
    pub struct ServiceType(u8) {
        0 REQUEST request "A request.",
        1 RESPONSE response "A response to a supported service; blocks may report errors.",
        5 NOT_SUPPORTED not_supported "The service is not supported.",
    }
}

codes! {
    /// Why an element was not read or set (IEC 61158-6-10, BlockError).
    pub struct BlockError(u8) {
        0 OK ok "The element was set.",
        1 OPTION_NOT_SUPPORTED option_not_supported "The device does not support the option.",
        2 SUBOPTION_NOT_SUPPORTED suboption_not_supported "The device does not support the suboption, or has no value for it.",
        3 SUBOPTION_NOT_SET suboption_not_set "The value was refused.",
        4 RESOURCE_ERROR resource_error "The device lacks the resources at present.",
        5 LOCAL_REASONS local_reasons "A local reason in the device prevents the change.",
        6 IN_OPERATION in_operation "The device exchanges data with a controller, which prevents the change.",
    }
}

/// The element of a block: option and suboption.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Element {
    /// The option, a group of elements.
    pub option: u8,
    /// The suboption within the option.
    pub suboption: u8,
}

macro_rules! elements {
    ($($option:literal $suboption:literal $constant:ident $word:ident $sentence:literal;)+) => {
        impl Element {
            $(
                #[doc = $sentence]
                pub const $constant: Element = Element { option: $option, suboption: $suboption };
            )+

            /// All elements that have a word, ascending.
            pub const KNOWN: &[Element] = &[$(Element::$constant),+];

            /// The word for this element, in snake_case; `None` for an element that is not in the table.
            pub fn word(self) -> Option<&'static str> {
                match (self.option, self.suboption) { $(($option, $suboption) => Some(stringify!($word)),)+ _ => None }
            }
        }
    };
}

elements! {
    1 1 MAC mac "The MAC address of the interface; read-only.";
    1 2 IP_PARAMETER ip_parameter "IPv4 address, mask and gateway.";
    1 3 FULL_IP_SUITE full_ip_suite "IPv4 address, mask, gateway and four name servers.";
    2 1 VENDOR vendor "The type of station, as text of the vendor.";
    2 2 NAME_OF_STATION name_of_station "The name by which a controller finds the device.";
    2 3 DEVICE_ID device_id "Vendor number and device number.";
    2 4 DEVICE_ROLE device_role "Whether the station is a device, a controller, a multidevice or a supervisor.";
    2 5 DEVICE_OPTIONS device_options "The list of elements that the station supports.";
    2 6 ALIAS_NAME alias_name "An alias name by topology: port and name of the neighbour.";
    2 7 DEVICE_INSTANCE device_instance "The number of the interface within the device.";
    2 8 OEM_DEVICE_ID oem_device_id "Vendor number and device number of the original manufacturer.";
    2 9 STANDARD_GATEWAY standard_gateway "The standard gateway of the subnet.";
    2 10 RSI_PROPERTIES rsi_properties "The properties of the remote service interface.";
    3 12 DHCP_HOST_NAME dhcp_host_name "DHCP: the host name.";
    3 43 DHCP_VENDOR dhcp_vendor "DHCP: vendor-specific information.";
    3 54 DHCP_SERVER dhcp_server "DHCP: the server.";
    3 55 DHCP_PARAMETER_LIST dhcp_parameter_list "DHCP: the parameters requested from the server.";
    3 60 DHCP_CLASS dhcp_class "DHCP: the class of the client.";
    3 61 DHCP_CLIENT dhcp_client "DHCP: the identifier of the client.";
    3 81 DHCP_FQDN dhcp_fqdn "DHCP: the fully qualified domain name.";
    3 97 DHCP_UUID dhcp_uuid "DHCP: a UUID as identifier of the client.";
    3 255 DHCP_CONTROL dhcp_control "DHCP: whether the station gets its address by DHCP.";
    5 1 START start "Starts a transaction.";
    5 2 STOP stop "Ends a transaction; the set values take effect.";
    5 3 SIGNAL signal "Makes an LED of the device flash.";
    5 4 RESPONSE response "The result for an element.";
    5 5 FACTORY_RESET factory_reset "The older reset, without a reset mode.";
    5 6 RESET_TO_FACTORY reset_to_factory "The reset with a reset mode in its qualifier.";
    6 1 DEVICE_INITIATIVE device_initiative "Whether the device sends Hello after its start.";
    255 255 ALL all "All stations.";
}

impl Element {
    /// The option of all control elements.
    pub const CONTROL: u8 = 5;
    /// The option of all DHCP elements.
    pub const DHCP: u8 = 3;

    /// Reads option and suboption.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<Element> {
        Ok(Element { option: reader.u8()?, suboption: reader.u8()? })
    }

    /// Appends option and suboption.
    pub fn write(self, out: &mut Vec<u8>) {
        out.put(&[self.option, self.suboption]);
    }
}

/// How a device stores a value of a Set request; reserved bits are preserved (IEC 61158-6-10, BlockQualifier).
///
/// Bit 0: permanent, otherwise temporary. With [`Element::RESET_TO_FACTORY`], bits 1-15 hold the [`ResetMode`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlockQualifier(pub u16);

impl BlockQualifier {
    /// The value is lost at power-off; the name or the address is empty after that.
    pub const TEMPORARY: BlockQualifier = BlockQualifier(0);
    /// The value survives power-off.
    pub const PERMANENT: BlockQualifier = BlockQualifier(1);

    /// Whether the value survives power-off.
    pub fn is_permanent(self) -> bool {
        self.0 & 1 != 0
    }

    /// The mode of a reset with suboption 6.
    pub fn reset_mode(self) -> ResetMode {
        ResetMode(self.0 >> 1)
    }
}

codes! {
    /// The mode of a reset with suboption 6: bits 1-15 of its qualifier (IEC 61158-6-10, BlockQualifier with ResetToFactory).
    pub struct ResetMode(u16) {
        1 APPLICATION application "Resets application data; name and address stay.",
        2 COMMUNICATION communication "Resets name, address and the other communication parameters; mandatory for every device.",
        3 ENGINEERING engineering "Resets data stored by an engineering tool.",
        4 ALL all "Resets all stored data of application, communication and engineering tool.",
        8 DEVICE device "Resets the whole device to its factory state.",
        9 FACTORY_IMAGE factory_image "Resets the whole device to its factory state and restores the firmware from its factory image.",
    }
}

impl ResetMode {
    /// The qualifier that requests this mode, with bit 0 clear.
    pub fn qualifier(self) -> BlockQualifier {
        BlockQualifier(self.0 << 1)
    }
}

/// Information of a device about a value; reserved bits are preserved (IEC 61158-6-10, BlockInfo).
///
/// With the IP elements: bits 0-1 origin of the address, bit 7 another station has the same address. Otherwise 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct BlockInfo(pub u16);

impl BlockInfo {
    /// No information; used with all elements except the IP elements.
    pub const NONE: BlockInfo = BlockInfo(0);
    /// IP element: there is no address.
    pub const IP_NOT_SET: BlockInfo = BlockInfo(0);
    /// IP element: the address was set by DCP or was stored.
    pub const IP_SET: BlockInfo = BlockInfo(1);
    /// IP element: the address was assigned by DHCP.
    pub const IP_BY_DHCP: BlockInfo = BlockInfo(2);
    /// IP element: another station has the same address; combined with the other values.
    pub const IP_CONFLICT: u16 = 0x80;

    /// IP element: whether another station has the same address.
    pub fn is_conflict(self) -> bool {
        self.0 & BlockInfo::IP_CONFLICT != 0
    }
}
