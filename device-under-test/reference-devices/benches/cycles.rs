//! Measures what the hooks cost a device without deviations: frame pairs per second, with the hooks compiled in and without.
//!
//!     cargo bench -p reference-devices --bench cycles
//!     cargo bench -p reference-devices --bench cycles --no-default-features
//!
//! Controller, wire and device run in virtual time; only the device differs between the two commands.

use controllers::profibus_dp::{self, ProfibusMaster};
use controllers::profinet_io::{
    ArConfig, ArState, ConnectSubmodule, Controller, ControllerRequest, ControllerSettings, DeviceAddress,
};
use device_stack::profinet::StationData;
use encoder_profile::encoder_object::EncoderSpecimen;
use reference_devices::deviations::DeviceDeviations;
use reference_devices::{DeviceManual, Line, ReferenceDevice, manuals};
use station::{Duration, Station, Time};
use std::net::Ipv4Addr;
use std::time::Instant;
use virtual_wire::{VirtualBus, VirtualWire};
use wire::ethernet::Mac;
use wire::profibus::fdl::BaudRate;
use wire::profinet::dcp::block::IpParameter;

const ROUNDS: usize = 15;
const TIME: Duration = Duration::from_secs(20);
const NAME: &str = "encoder";
const MASK: Ipv4Addr = Ipv4Addr::new(255, 255, 255, 0);
const BAUD: BaudRate = BaudRate(1_500_000);
/// AMT58, class 2: 65536 steps in each of 16384 revolutions.
const SET_PRM: [u8; 21] = [0x88, 0x14, 0x05, 0x0B, 0x16, 0x55, 0, 0, 0, 0, 0x0A, 0, 1, 0, 0, 0x40, 0, 0, 0, 0, 0];
const CHK_CFG: [u8; 2] = [0xD1, 0xE1];

fn main() {
    let hooks = if cfg!(feature = "deviations") { "with" } else { "without" };
    println!("{hooks} hooks: frame pairs per second, best of {ROUNDS} rounds");
    for (name, run) in [("XAC77, PROFINET", profinet as fn() -> u64), ("AMT58, PROFIBUS DP", profibus)] {
        let mut best = 0.0_f64;
        for _ in 0..ROUNDS {
            let begin = Instant::now();
            let pairs = run();
            best = best.max(pairs as f64 / begin.elapsed().as_secs_f64());
        }
        println!("{name:<20} {best:>12.0}");
    }
}

fn device(manual: &DeviceManual, variant: &str) -> Box<dyn ReferenceDevice> {
    let station = StationData { name: NAME.as_bytes().to_vec(), ..StationData::default() };
    let piece = EncoderSpecimen { mac: [2, 0, 0, 0, 1, 1], shaft: 5_000, station };
    let built = manual.build(variant, &DeviceDeviations::default(), piece, Line { address: 3, baud: BAUD });
    built.expect("the manual has this variant")
}

/// Cycles of 1 ms with a standard telegram.
fn profinet() -> u64 {
    let mut device = device(&manuals::LIKA_XAC77, "xac7718");
    let submodule = |slot, subslot, submodule_ident, [input_octets, output_octets]: [u16; 2]| ConnectSubmodule {
        api: if slot == 0 { 0 } else { 0x3D00 },
        slot,
        module_ident: 1,
        subslot,
        submodule_ident,
        input_octets,
        output_octets,
    };
    let ip = IpParameter { address: Ipv4Addr::new(192, 168, 0, 10), mask: MASK, gateway: Ipv4Addr::UNSPECIFIED };
    let mut connection = ArConfig::new(DeviceAddress::Name(NAME.into()), ip);
    (connection.vendor_id, connection.device_id) = (0x0239, 0x0001);
    connection.submodules = vec![submodule(0, 1, 1, [0, 0]), submodule(1, 1, 2, [0, 0]), submodule(1, 2, 81, [12, 4])];
    let mut controller = Controller::new(ControllerSettings {
        mac: Mac([2, 0, 0, 0, 2, 1]),
        ip: Ipv4Addr::new(192, 168, 0, 100),
        mask: MASK,
        gateway: Ipv4Addr::UNSPECIFIED,
        station_name: b"controller".to_vec(),
        vendor_id: 0xFEED,
        device_id: 1,
        seed: 1,
    });
    controller
        .request(Time::ZERO, ControllerRequest::Connect(Box::new(connection)))
        .expect("no other request is pending");
    let mut stations: [&mut dyn Station; 2] = [&mut controller, &mut *device];
    let mut frames = 0;
    VirtualWire::new().run(&mut stations, Time::ZERO + TIME, &mut |_| frames += 1);
    assert_eq!(controller.state(), ArState::Data);
    frames / 2
}

/// Back-to-back cycles, as fast as the bus permits.
fn profibus() -> u64 {
    let mut device = device(&manuals::DATALOGIC_AMT58, "hm5816-16384");
    let settings = profibus_dp::MasterSettings::new(2, BAUD);
    let mut bus = VirtualBus::new(BAUD, settings.slot_time);
    let mut master = ProfibusMaster::new(settings);
    let connection = profibus_dp::SlaveConfig::new(3, SET_PRM.to_vec(), CHK_CFG.to_vec(), (4, 4));
    let request = profibus_dp::MasterRequest::Connect(Box::new(connection));
    master.request(Time::ZERO, request).expect("no other request is pending");
    let mut frames = 0;
    bus.run(&mut [&mut master, &mut *device], Time::ZERO + TIME, &mut |_| frames += 1);
    assert_eq!(master.state(), profibus_dp::ConnectionState::Exchange);
    frames / 2
}
