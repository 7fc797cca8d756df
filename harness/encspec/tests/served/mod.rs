//! What tests and benches with served devices share: a network of their own, the served process, controllers.
#![allow(dead_code, reason = "each user needs a part of it")]

use controllers::profinet_io::{Connection, Controller, DeviceAddress, Outcome, Request, Settings, StartUp, Submodule};
use link::{Wire, namespace};
use station::{Duration, Station, Time};
use std::io::{BufRead, BufReader, Write};
use std::net::Ipv4Addr;
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

/// What is served.
pub const MODEL: &str = "model:lika-xac77-profinet/xac7718";
/// The mask of the segment.
pub const MASK: Ipv4Addr = Ipv4Addr::new(255, 255, 255, 0);

/// Whether this thread is now in a network of its own, with the interfaces `ours` and `theirs` connected to each other.
///
/// Where that cannot be had the reason is written past the test runner's capture, and nothing is to be tested;
/// with `ENCSPEC_REQUIRE_ALL` it is a failure.
pub fn private_network() -> bool {
    match namespace::enter_private_network().and_then(|()| namespace::veth("ours", "theirs")) {
        Ok(()) => true,
        Err(why) => {
            assert!(std::env::var_os("ENCSPEC_REQUIRE_ALL").is_none(), "{why}");
            // A standard error that cannot be written to leaves nobody to tell.
            let _ = std::io::stderr().write_all(format!("skipped: {why}\n").as_bytes());
            false
        }
    }
}

/// A name for a socket that nobody else uses.
pub fn socket_path(name: &str) -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("encspec-{}-{number}-{name}", std::process::id()))
}

/// `encspec serve` at work; it ends with this.
pub struct Serving {
    child: Child,
    out: BufReader<ChildStdout>,
    /// What it has said before it was ready, line by line.
    pub said: Vec<String>,
}

impl Serving {
    /// Serves with these arguments and waits until it is ready.
    pub fn start(arguments: &[&str]) -> Serving {
        let mut child = Command::new(env!("CARGO_BIN_EXE_encspec"))
            .arg("serve")
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary");
        let out = BufReader::new(child.stdout.take().expect("its output"));
        let mut serving = Serving { child, out, said: Vec::new() };
        loop {
            let mut line = String::new();
            if serving.out.read_line(&mut line).expect("text") == 0 {
                panic!("it ended before it was ready: {}", serving.end());
            }
            serving.said.push(line.trim_end().to_owned());
            if line.starts_with("ready ") {
                return serving;
            }
        }
    }

    /// Its process number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Asks it to end as Ctrl-C does and gives its status.
    pub fn interrupt(&mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status().expect("kill");
        assert!(sent.success(), "it is still there");
        self.child.wait().expect("its end").code()
    }

    /// Ends it and gives what it has complained about.
    pub fn end(&mut self) -> String {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let mut text = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            std::io::Read::read_to_string(&mut errors, &mut text).expect("text");
        }
        text
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.end();
    }
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
