//! Helpers for tests and benchmarks with served devices: a private network, and controllers in it.

use controllers::profinet_io::{
    ArConfig, ArStartUpResult, ConnectSubmodule, Controller, ControllerOutcome, ControllerRequest, ControllerSettings,
    DeviceAddress, IdentifiedStation, IdentifyBy,
};
use encspec::live::preflight;
use encspec::results::bench_file::LinkSpec;
use link::lines::LineClient;
use link::{Wire, namespace};
use station::{Duration, Station, Time};
use std::net::Ipv4Addr;
use std::time::Instant;
use testing::Folder;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

/// The served reference device.
pub const MODEL: &str = "model:lika-xac77-profinet/xac7718";
/// The subnet mask of the segment.
pub const MASK: Ipv4Addr = Ipv4Addr::new(255, 255, 255, 0);

/// The time between two checks whether a run is done.
const POLL: Duration = Duration::from_millis(5);
/// How long a device may take to answer after power-on.
pub const PATIENCE: Duration = Duration::from_secs(30);
/// How long answers to an Identify are collected.
const IDENTIFY: Duration = Duration::from_millis(400);
/// How long a request may take.
const TIMEOUT: Duration = Duration::from_secs(60);

/// Moves this thread to a private network whose interfaces `ours` and `theirs` are connected to each other.
///
/// Returns false, and reports the test as skipped, if the host does not allow it.
pub fn private_network() -> bool {
    testing::available(namespace::enter_private_network().and_then(|()| namespace::veth("ours", "theirs")))
}

/// The controller with this index, from 0.
pub fn controller(number: u8) -> Controller {
    Controller::new(ControllerSettings {
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

/// A connection with telegram 81 to the station `name`, which gets the address `ip`.
pub fn connection(name: &str, ip: Ipv4Addr) -> ArConfig {
    let submodule = |slot, subslot, ident, octets: (u16, u16)| ConnectSubmodule {
        api: if slot == 0 { 0 } else { 0x3D00 },
        slot,
        module_ident: 1,
        subslot,
        submodule_ident: ident,
        input_octets: octets.0,
        output_octets: octets.1,
    };
    let ip = IpParameter { address: ip, mask: MASK, gateway: Ipv4Addr::UNSPECIFIED };
    let mut connection = ArConfig::new(DeviceAddress::Name(name.into()), ip);
    connection.vendor_id = 0x0239;
    connection.device_id = 0x0001;
    // A host that runs other tests at the same time misses deadlines of a few milliseconds.
    connection.watchdog_factor = 250;
    connection.data_hold_factor = 250;
    connection.submodules = vec![submodule(0, 1, 1, (0, 0)), submodule(1, 1, 2, (0, 0)), submodule(1, 2, 81, (12, 4))];
    connection
}

/// Runs `controllers` on `wire` until `done` returns true, for `time` at most. Returns whether it did.
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
        let until = end.min(wire.now() + POLL);
        let mut stations: Vec<([u8; 6], &mut dyn Station)> =
            controllers.iter_mut().map(|one| (one.settings().mac.0, one as &mut dyn Station)).collect();
        while wire.step(&mut stations, until, &mut |_| true, tap).expect("the line works") == link::WireStep::Worked
            && wire.now() < until
        {}
    }
    done(controllers)
}

/// Each controller carries out its request. Returns the outcomes.
pub fn ask(
    wire: &mut Wire,
    controllers: &mut [Controller],
    requests: Vec<ControllerRequest>,
) -> Vec<ControllerOutcome> {
    let now = wire.now();
    for (controller, request) in controllers.iter_mut().zip(requests) {
        controller.request(now, request).expect("an idle controller");
    }
    let mut idle = |controllers: &mut [Controller]| controllers.iter().all(|controller| !controller.is_busy());
    assert!(run(wire, controllers, TIMEOUT, &mut idle, &mut |_, _| {}), "a request did not finish");
    controllers.iter_mut().map(|controller| controller.take_outcome().expect("an outcome")).collect()
}

/// The outcome of one request.
pub fn ask_one(wire: &mut Wire, controllers: &mut [Controller; 1], request: ControllerRequest) -> ControllerOutcome {
    ask(wire, controllers, vec![request]).remove(0)
}

/// A controller at a link, for requests of the test.
pub fn controller_at(link: &LinkSpec) -> (Wire, [Controller; 1]) {
    let port = preflight::open(link).unwrap_or_else(|why| panic!("{why}"));
    (Wire::new(port), [controller(0)])
}

/// The only station, once it answers.
pub fn identify(wire: &mut Wire, controllers: &mut [Controller; 1]) -> IdentifiedStation {
    let begin = Instant::now();
    loop {
        let request = ControllerRequest::Identify { by: IdentifyBy::All, wait: IDENTIFY };
        if let ControllerOutcome::Stations(stations) = ask_one(wire, controllers, request)
            && let [station] = stations.as_slice()
        {
            return station.clone();
        }
        assert!(begin.elapsed() < PATIENCE, "the device does not answer");
    }
}

/// Sends commands to the stand of the served device, whose control channel is `control` in the folder.
pub fn act(folder: &Folder, commands: &[&str]) {
    let mut stand = LineClient::connect(&folder.join("control")).expect("the control channel");
    for command in commands {
        let answer = stand.request(command, PATIENCE).expect("an answer");
        assert!(answer.starts_with("ok"), "{answer}");
    }
}

/// All lines of the journals in a folder.
pub fn journal(folder: &Folder) -> String {
    let files = std::fs::read_dir(folder.join("encspec-journal")).into_iter().flatten().flatten();
    files.map(|file| std::fs::read_to_string(file.path()).unwrap_or_default()).collect()
}

/// The start-up in an outcome.
#[track_caller]
pub fn start_up_of(outcome: &ControllerOutcome) -> &ArStartUpResult {
    match outcome {
        ControllerOutcome::StartUp(start) => start,
        other => panic!("no start-up: {other:?}"),
    }
}

/// Asserts that a start-up succeeded.
#[track_caller]
pub fn assert_standing(outcome: &ControllerOutcome) {
    let start = start_up_of(outcome);
    assert!(start.standing && start.failed.is_none(), "the start-up failed: {:?}", start.failed);
}
