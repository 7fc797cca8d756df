//! What tests and benches with served devices share: a network of their own, and controllers in it.

use controllers::profinet_io::{Connection, Controller, DeviceAddress, Outcome, Request, Settings, StartUp, Submodule};
use link::{Wire, namespace};
use station::{Duration, Station, Time};
use std::net::Ipv4Addr;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

/// What is served.
pub const MODEL: &str = "model:lika-xac77-profinet/xac7718";
/// The mask of the segment.
pub const MASK: Ipv4Addr = Ipv4Addr::new(255, 255, 255, 0);

/// Whether this thread is now in a network of its own, with the interfaces `ours` and `theirs` connected to each other; where that
/// cannot be had the test is skipped.
pub fn private_network() -> bool {
    testing::available(namespace::enter_private_network().and_then(|()| namespace::veth("ours", "theirs")))
}

/// The controller `number`, from 0.
pub fn controller(number: u8) -> Controller {
    Controller::new(Settings {
        mac: Mac([2, 0, 0, 0, 2, number]),
        ip: Ipv4Addr::new(192, 168, 0, 100 + number),
        mask: MASK,
        gateway: Ipv4Addr::UNSPECIFIED,
        station_name: format!("controller-{number}").into_bytes(),
        vendor_id: 0xFEED,
        device_id: 1,
        seed: number.into(),
    })
}

/// A connection to the station `name`, which gets the address `ip`; telegram 81 of the model that is served.
pub fn connection(name: &str, ip: Ipv4Addr) -> Connection {
    let submodule = |slot, subslot, ident, octets: (u16, u16)| Submodule {
        api: if slot == 0 { 0 } else { 0x3D00 },
        slot,
        module_ident: 1,
        subslot,
        submodule_ident: ident,
        input_octets: octets.0,
        output_octets: octets.1,
    };
    let ip = IpParameter { address: ip, mask: MASK, gateway: Ipv4Addr::UNSPECIFIED };
    let mut connection = Connection::new(DeviceAddress::Name(name.into()), ip);
    connection.vendor_id = 0x0239;
    connection.device_id = 0x0001;
    // A machine that is busy with other tests keeps no deadline of a few milliseconds.
    connection.watchdog_factor = 250;
    connection.data_hold_factor = 250;
    connection.submodules = vec![submodule(0, 1, 1, (0, 0)), submodule(1, 1, 2, (0, 0)), submodule(1, 2, 81, (12, 4))];
    connection
}

/// Runs `controllers` on `wire` until `done` says so, for `time` at most; whether it said so.
pub fn run(
    wire: &mut Wire,
    controllers: &mut [Controller],
    time: Duration,
    done: &mut dyn FnMut(&mut [Controller]) -> bool,
    tap: &mut dyn FnMut(Time, &[u8]),
) -> bool {
    let end = wire.now() + time;
    while wire.now() < end {
        if done(controllers) {
            return true;
        }
        let until = end.min(wire.now() + Duration::from_millis(5));
        let mut stations: Vec<([u8; 6], &mut dyn Station)> =
            controllers.iter_mut().map(|one| (one.settings().mac.0, one as &mut dyn Station)).collect();
        while wire.step(&mut stations, until, &mut |_| true, tap).expect("the line works") == link::Step::Worked
            && wire.now() < until
        {}
    }
    done(controllers)
}

/// Lets each controller carry out its request and gives what came of them.
pub fn ask(wire: &mut Wire, controllers: &mut [Controller], requests: Vec<Request>) -> Vec<Outcome> {
    let now = wire.now();
    for (controller, request) in controllers.iter_mut().zip(requests) {
        controller.request(now, request).expect("a controller that has nothing to do");
    }
    let mut idle = |controllers: &mut [Controller]| controllers.iter().all(|controller| !controller.is_busy());
    assert!(run(wire, controllers, Duration::from_secs(60), &mut idle, &mut |_, _| {}), "a request has no end");
    controllers.iter_mut().map(|controller| controller.take_outcome().expect("an outcome")).collect()
}

/// What came of a start-up.
#[track_caller]
pub fn started(outcome: &Outcome) -> &StartUp {
    match outcome {
        Outcome::StartUp(start) => start,
        other => panic!("no start-up: {other:?}"),
    }
}

/// Whether a start-up went well; it says why where it did not.
#[track_caller]
pub fn assert_standing(outcome: &Outcome) {
    let start = started(outcome);
    assert!(start.standing && start.failed.is_none(), "the start-up failed: {:?}", start.failed);
}
