//! Shared by the tests: a scripted device, the wire between it and the controller under test, a usual connection.

mod device;
mod rig;

pub use device::{Reaction, ReceivedCall, ScriptedDevice, call_header};
pub use rig::ControllerRig;

use core::net::Ipv4Addr;
use encspec_controllers::profinet_io::{
    ArConfig, ConnectSubmodule, ControllerSettings, DeviceAddress, RecordAddress, StartUpRecord,
};
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

pub const OWN: Mac = Mac([2, 0, 0, 0, 0, 1]);
pub const OWN_IP: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 1);
pub const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);
pub const DEVICE_IP: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 10);
pub const NAME: &str = "encoder-under-test";
/// Another port than the one the device listens at, as devices use for their own calls.
pub const DEVICE_PORT: u16 = 49_153;
pub const ALARM_REFERENCE: u16 = 0x0205;
pub const OUTPUT_FRAME_ID: u16 = 0xC000;
pub const PARAMETERS: RecordAddress = RecordAddress { api: 0x3D00, slot: 1, subslot: 1, index: 0xB02E };

pub fn ip() -> IpParameter {
    IpParameter { address: DEVICE_IP, mask: Ipv4Addr::new(255, 255, 255, 0), gateway: DEVICE_IP }
}

pub fn settings() -> ControllerSettings {
    ControllerSettings {
        mac: OWN,
        ip: OWN_IP,
        mask: Ipv4Addr::new(255, 255, 255, 0),
        gateway: OWN_IP,
        station_name: b"controller".to_vec(),
        vendor_id: 0xFFFF,
        device_id: 1,
        seed: 7,
    }
}

/// An encoder with telegram 81: a DAP with interface and port, a parameter access submodule, 12 bytes in, 4 out.
pub fn connection() -> ArConfig {
    let dap = ConnectSubmodule { module_ident: 0x11, ..ConnectSubmodule::default() };
    let module = ConnectSubmodule { api: 0x3D00, slot: 1, module_ident: 0x22, ..ConnectSubmodule::default() };
    let mut connection = ArConfig::new(DeviceAddress::Name(NAME.into()), ip());
    (connection.vendor_id, connection.device_id) = (0x012A, 0x0007);
    connection.submodules = vec![
        ConnectSubmodule { subslot: 1, submodule_ident: 1, ..dap },
        ConnectSubmodule { subslot: 0x8000, submodule_ident: 2, ..dap },
        ConnectSubmodule { subslot: 0x8001, submodule_ident: 3, ..dap },
        ConnectSubmodule { subslot: 1, submodule_ident: 0xFFFF, ..module },
        ConnectSubmodule { subslot: 2, submodule_ident: 81, input_octets: 12, output_octets: 4, ..module },
    ];
    connection.records =
        vec![StartUpRecord { target: RecordAddress { index: 0xBF00, ..PARAMETERS }, data: vec![0, 1, 2, 3, 4] }];
    connection
}
