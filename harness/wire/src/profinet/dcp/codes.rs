//! The numbers of DCP with their names and their sentences; unknown ones are kept.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;

codes! {
    /// What is done (IEC 61158-6-10, ServiceID).
    pub struct ServiceId(u8) {
        3 GET get "One device is asked for the values of elements.",
        4 SET set "One device is given values or told to do something.",
        5 IDENTIFY identify "All devices that match are asked to tell who they are.",
        6 HELLO hello "A device tells that it has started.",
    }
}

codes! {
    /// Which side speaks (IEC 61158-6-10, ServiceType).
    pub struct ServiceType(u8) {
        0 REQUEST request "Something is asked.",
        1 RESPONSE response "The request was carried out, block errors apart.",
        5 NOT_SUPPORTED not_supported "The service is not supported.",
    }
}

codes! {
    /// Why an element was not given or set (IEC 61158-6-10, BlockError).
    pub struct BlockError(u8) {
        0 OK ok "The element was set.",
        1 OPTION_NOT_SUPPORTED option_not_supported "The device does not know the option.",
        2 SUBOPTION_NOT_SUPPORTED suboption_not_supported "The device does not know the suboption, or has no value for it.",
        3 SUBOPTION_NOT_SET suboption_not_set "The value was refused.",
        4 RESOURCE_ERROR resource_error "The device has not the means at the moment.",
        5 LOCAL_REASONS local_reasons "Something in the device itself forbids the change.",
        6 IN_OPERATION in_operation "The device exchanges data with a controller, which forbids the change.",
    }
}

/// What a block is about: option and suboption.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Element {
    /// The group.
    pub option: u8,
    /// The member of the group.
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

            /// The word for this element, in snake_case; none for one that the table does not know.
            pub fn word(self) -> Option<&'static str> {
                match (self.option, self.suboption) { $(($option, $suboption) => Some(stringify!($word)),)+ _ => None }
            }
        }
    };
}

elements! {
    1 1 MAC mac "The MAC address of the interface; it can only be read.";
    1 2 IP_PARAMETER ip_parameter "IPv4 address, mask and gateway.";
    1 3 FULL_IP_SUITE full_ip_suite "IPv4 address, mask, gateway and four name servers.";
    2 1 VENDOR vendor "The type of the station in the words of its vendor.";
    2 2 NAME_OF_STATION name_of_station "The name by which a controller finds the device.";
    2 3 DEVICE_ID device_id "Vendor number and device number.";
    2 4 DEVICE_ROLE device_role "Whether the station is a device, a controller, a multidevice or a supervisor.";
    2 5 DEVICE_OPTIONS device_options "The list of the elements that the station knows.";
    2 6 ALIAS_NAME alias_name "A name by position: the port of the neighbour and its name.";
    2 7 DEVICE_INSTANCE device_instance "The number of the interface within the device.";
    2 8 OEM_DEVICE_ID oem_device_id "Vendor number and device number of the maker behind the label.";
    2 9 STANDARD_GATEWAY standard_gateway "The gateway that all stations of the subnet share.";
    2 10 RSI_PROPERTIES rsi_properties "What the remote service interface of the station can do.";
    3 12 DHCP_HOST_NAME dhcp_host_name "DHCP: the host name.";
    3 43 DHCP_VENDOR dhcp_vendor "DHCP: what the vendor has defined.";
    3 54 DHCP_SERVER dhcp_server "DHCP: the server.";
    3 55 DHCP_PARAMETER_LIST dhcp_parameter_list "DHCP: the parameters that are asked of the server.";
    3 60 DHCP_CLASS dhcp_class "DHCP: the class of the client.";
    3 61 DHCP_CLIENT dhcp_client "DHCP: the client's own identifier.";
    3 81 DHCP_FQDN dhcp_fqdn "DHCP: the fully qualified domain name.";
    3 97 DHCP_UUID dhcp_uuid "DHCP: a UUID as identifier of the client.";
    3 255 DHCP_CONTROL dhcp_control "DHCP: whether the station is to get its address so.";
    5 1 START start "A transaction begins.";
    5 2 STOP stop "The transaction ends; what was set takes effect.";
    5 3 SIGNAL signal "A light of the device flashes.";
    5 4 RESPONSE response "How it went with an element.";
    5 5 FACTORY_RESET factory_reset "The older reset, which says not what is reset.";
    5 6 RESET_TO_FACTORY reset_to_factory "The reset whose qualifier says what is reset.";
    6 1 DEVICE_INITIATIVE device_initiative "Whether the device sends Hello after its start.";
    255 255 ALL all "Every station is meant.";
}

impl Element {
    /// The option of all control elements.
    pub const CONTROL: u8 = 5;
    /// The option of all DHCP elements.
    pub const DHCP: u8 = 3;

    /// Reads option and suboption.
    pub fn read(reader: &mut Reader<'_>) -> Result<Element> {
        Ok(Element { option: reader.u8()?, suboption: reader.u8()? })
    }

    /// Appends option and suboption.
    pub fn write(self, out: &mut Vec<u8>) {
        out.put(&[self.option, self.suboption]);
    }
}

/// How a value of a Set request is to be kept; reserved bits are kept (IEC 61158-6-10, BlockQualifier).
///
/// Bit 0: permanent, else temporary. With [`Element::RESET_TO_FACTORY`], bits 1-15 hold the [`ResetMode`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlockQualifier(pub u16);

impl BlockQualifier {
    /// The value is lost with the power, and the name or the address is empty after it.
    pub const TEMPORARY: BlockQualifier = BlockQualifier(0);
    /// The value survives a loss of power.
    pub const PERMANENT: BlockQualifier = BlockQualifier(1);

    /// Whether the value is to survive a loss of power.
    pub fn is_permanent(self) -> bool {
        self.0 & 1 != 0
    }

    /// What a reset by suboption 6 is to reset.
    pub fn reset_mode(self) -> ResetMode {
        ResetMode(self.0 >> 1)
    }
}

codes! {
    /// What a reset by suboption 6 resets; the bits 1-15 of its qualifier (IEC 61158-6-10, BlockQualifier with ResetToFactory).
    pub struct ResetMode(u16) {
        1 APPLICATION application "Data of the application is reset; name and address stay.",
        2 COMMUNICATION communication "Name, address and the other communication parameters are reset; every device must be able to.",
        3 ENGINEERING engineering "What an engineering tool has stored is reset.",
        4 ALL all "Everything that the application, the communication and an engineering tool have stored is reset.",
        8 DEVICE device "Everything in the device takes its factory value.",
        9 FACTORY_IMAGE factory_image "Everything in the device takes its factory value and the firmware is restored from its image.",
    }
}

impl ResetMode {
    /// The qualifier that asks for this mode, with bit 0 clear.
    pub fn qualifier(self) -> BlockQualifier {
        BlockQualifier(self.0 << 1)
    }
}

/// What a device tells about a value; reserved bits are kept (IEC 61158-6-10, BlockInfo).
///
/// With the IP elements: bits 0-1 where the address comes from, bit 7 another station has the same address. Else 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct BlockInfo(pub u16);

impl BlockInfo {
    /// Nothing is told: what stands with all elements but the IP ones.
    pub const NONE: BlockInfo = BlockInfo(0);
    /// IP element: there is no address.
    pub const IP_NOT_SET: BlockInfo = BlockInfo(0);
    /// IP element: the address was set by DCP or is stored.
    pub const IP_SET: BlockInfo = BlockInfo(1);
    /// IP element: the address came by DHCP.
    pub const IP_BY_DHCP: BlockInfo = BlockInfo(2);
    /// IP element: another station has the same address; added to the others.
    pub const IP_CONFLICT: u16 = 0x80;

    /// IP element: whether another station has the same address.
    pub fn is_conflict(self) -> bool {
        self.0 & BlockInfo::IP_CONFLICT != 0
    }
}
