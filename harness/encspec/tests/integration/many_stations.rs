//! Several devices and controllers on one segment do not disturb each other.

use crate::common::served::{connection, controller};
use controllers::profinet_io::{
    ArConfig, ArState, Controller, ControllerOutcome, ControllerRequest, DeviceAddress, RecordAddress,
};
use deviations::{ReferenceDevice, Setup, build};
use station::{Duration, Station, Time};
use std::net::Ipv4Addr;
use virtual_wire::VirtualWire;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

const STATIONS: u8 = 5;

fn name(number: u8) -> String {
    format!("encoder-{number}")
}

fn device(number: u8) -> Box<dyn ReferenceDevice> {
    let station_name = name(number);
    let setup = Setup {
        mac: [2, 0, 0, 0, 1, number],
        shaft: 1000 + u64::from(number),
        station_name: &station_name,
        ..Setup::default()
    };
    build("lika-xac77-profinet", "xac7718", &setup).expect("a reference device")
}

/// The connection to the device `number`, with the default watchdog, which suffices on a virtual wire.
fn connection_to(number: u8) -> ArConfig {
    let default = ArConfig::new(DeviceAddress::Name(name(number)), IpParameter::NONE);
    let mut connection = connection(&name(number), Ipv4Addr::new(192, 168, 0, 10 + number));
    connection.watchdog_factor = default.watchdog_factor;
    connection.data_hold_factor = default.data_hold_factor;
    connection
}

#[test]
fn each_controller_reaches_its_own_device() {
    let mut devices: Vec<_> = (1..=STATIONS).map(device).collect();
    let mut controllers: Vec<_> = (1..=STATIONS).map(controller).collect();
    for (controller, number) in controllers.iter_mut().zip(1..) {
        let request = ControllerRequest::Connect(Box::new(connection_to(number)));
        controller.request(Time::ZERO, request).expect("an idle controller");
    }
    let mut wire = VirtualWire::new();
    let mut run = |controllers: &mut Vec<Controller>, until: Duration| {
        let mut stations: Vec<&mut dyn Station> = Vec::new();
        stations.extend(controllers.iter_mut().map(|controller| controller as &mut dyn Station));
        stations.extend(devices.iter_mut().map(|device| &mut **device as &mut dyn Station));
        wire.run(&mut stations, Time::ZERO + until, &mut |_| {});
    };
    run(&mut controllers, Duration::from_secs(3));
    for (controller, number) in controllers.iter_mut().zip(1..) {
        match controller.take_outcome() {
            Some(ControllerOutcome::StartUp(start)) => {
                assert!(start.standing, "controller {number}: {:?}", start.failed);
                let mac = start.identify.map(|station| station.mac);
                assert_eq!(mac, Some(Mac([2, 0, 0, 0, 1, number])), "controller {number} has its own device");
            }
            outcome => panic!("controller {number}: {outcome:?}"),
        }
        assert_eq!(controller.state(), ArState::Data);
        let target = RecordAddress { api: 0, slot: 0, subslot: 1, index: 0xAFF0 };
        controller
            .request(Time::ZERO + Duration::from_secs(3), ControllerRequest::Read { target, length: 64 })
            .expect("idle");
    }
    run(&mut controllers, Duration::from_secs(4));
    for (controller, number) in controllers.iter_mut().zip(1..) {
        assert!(
            matches!(controller.take_outcome(), Some(ControllerOutcome::Record(outcome)) if outcome.is_accepted()),
            "controller {number} reads I&M0"
        );
        assert!(controller.cycles_sent() > 1000, "controller {number} exchanged data all the time");
        assert!(controller.take_end().is_none(), "controller {number} kept its connection");
    }
    assert_eq!(wire.violation_count(), 0);
}
