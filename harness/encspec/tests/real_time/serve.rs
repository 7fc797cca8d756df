//! `encspec serve` and `encspec discover`: devices at network interfaces of a private network, at Unix sockets and over TCP.

use crate::common::program::{self, ProgramOutput, ServeProcess};
use crate::common::served::{MODEL, ask, assert_standing, connection, controller, private_network, run, start_up_of};
use crate::{table, tests};
use controllers::profinet_io::{Controller, ControllerOutcome, ControllerRequest, IdentifyBy, RecordAddress};
use libtest_mimic::Trial;
use link::lines::LineClient;
use link::{FrameSocket, Nic, Wire};
use station::Duration;
use std::net::Ipv4Addr;
use std::path::Path;
use testing::unused_path;

const IM0: RecordAddress = RecordAddress { api: 0, slot: 0, subslot: 1, index: 0xAFF0 };
const FIRST: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 10);
const SECOND: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 11);
/// How long an expected event may take.
const TIMEOUT: Duration = Duration::from_secs(60);

/// How long one DCP Identify waits for answers.
const IDENTIFY: Duration = Duration::from_secs(1);
/// Watchdog and data hold factor of 1.92 s at a cycle of 2 ms.
const LONGEST_FACTOR: u16 = 960;

pub fn trials() -> Vec<Trial> {
    let mut trials = tests![devices_at_an_interface_are_controlled, the_stations_of_a_segment_are_discovered];
    trials.extend(table![a_device_at_a_socket_takes_a_new_peer: unix(true), tcp(false)]);
    trials.extend(table![a_usage_error_is_reported_at_once:
        no_port(&["serve", MODEL], 2, "--nic <IF>|--socket <ADDRESS>"),
        two_ports(&["serve", MODEL, "--nic", "a", "--socket", "b:1"], 2, "cannot be used with"),
        kind(&["serve", "lika-xac77-profinet", "--nic", "a"], 2, "write model:MANUAL[/VARIANT]"),
        manual(&["serve", "model:lika-xac78-profinet", "--nic", "a"], 2, "did you mean `lika-xac77-profinet`?"),
        variant(&["serve", "model:lika-xac77-profinet/xac7719", "--nic", "a"], 2, "did you mean `xac7718`?"),
        bug(&["serve", MODEL, "--nic", "a", "--bug", "preset-on-fallling-edge"], 2, "did you mean `preset-on-falling-edge`?"),
        address(&["serve", MODEL, "--nic", "a", "--ip", "192.168.0"], 2, "`192.168.0` is not an IPv4 address"),
        prefix(&["serve", MODEL, "--nic", "a", "--ip", "192.168.0.1/33"], 2, "from 1 to 32"),
        mac(&["serve", MODEL, "--nic", "a", "--mac", "02:00"], 2, "six pairs of hexadecimal digits"),
        socket(&["serve", MODEL, "--socket", "nowhere"], 2, "`nowhere` is not a socket address"),
        line_of_a_network(&["serve", MODEL, "--nic", "a", "--baud", "9600"], 2, "<--serial <TTY>|--pty <LINK>>"),
        other_bus(&["serve", MODEL, "--pty", "/nowhere/line"], 2, "serve it with --nic or --socket"),
        absent_folder(&["serve", "model:datalogic-amt58-profibus", "--pty", "/nowhere/line"], 3, "cannot create the link /nowhere/line"),
        scheduling(&["serve", MODEL, "--nic", "a", "--realtime", "--no-realtime"], 2, "cannot be used with"),
        absent_nic(&["serve", MODEL, "--nic", "encspec-none"], 3, "encspec-none"),
        absent_peer(&["discover", "--socket", "/nowhere/at-all"], 3, "/nowhere/at-all"),
        absent_channel(&["control", "/nowhere/control", "power", "up"], 3, "/nowhere/control"),
        no_command(&["control", "/nowhere/control"], 2, "<COMMAND>"),
        discover_nothing(&["discover"], 2, "--nic <IF>|--socket <ADDRESS>"),
    ]);
    trials
}

fn encspec(arguments: &[&str]) -> ProgramOutput {
    program::encspec(Path::new("."), arguments)
}

/// Sends `line` to the control socket at `path`. Returns the answer.
fn say(path: &Path, line: &str) -> String {
    let mut client = LineClient::connect(path).expect("the control socket");
    client.request(line, Duration::from_secs(10)).expect("an answer")
}

fn connect(names: &[(&str, Ipv4Addr)]) -> Vec<ControllerRequest> {
    names.iter().map(|(name, ip)| ControllerRequest::Connect(Box::new(connection(name, *ip)))).collect()
}

/// Connect requests with the longest possible watchdog and data hold time, 1.92 s, so that the connections survive a stall of more
/// than a second.
fn connect_patiently(names: &[(&str, Ipv4Addr)]) -> Vec<ControllerRequest> {
    let mut requests = connect(names);
    for request in &mut requests {
        if let ControllerRequest::Connect(connection) = request {
            (connection.watchdog_factor, connection.data_hold_factor) = (LONGEST_FACTOR, LONGEST_FACTOR);
        }
    }
    requests
}

/// Whether the connection of a controller ends within [`TIMEOUT`].
fn ends(wire: &mut Wire, controllers: &mut [Controller], which: usize) -> bool {
    let mut ended = |controllers: &mut [Controller]| controllers[which].take_end().is_some();
    run(wire, controllers, TIMEOUT, &mut ended, &mut |_, _| {})
}

/// Searches for a station by its name until it answers, for [`TIMEOUT`] at most. Returns the number of stations that answered.
fn found(wire: &mut Wire, controllers: &mut [Controller], name: &str) -> usize {
    let by = IdentifyBy::Name(name.as_bytes().to_vec());
    let until = wire.now() + TIMEOUT;
    loop {
        let wait = IDENTIFY;
        let outcomes = ask(wire, controllers, vec![ControllerRequest::Identify { by: by.clone(), wait }]);
        let ControllerOutcome::Stations(stations) = &outcomes[0] else { panic!("{:?}", outcomes[0]) };
        if !stations.is_empty() || wire.now() >= until {
            return stations.len();
        }
    }
}

fn exchange(wire: &mut Wire, controllers: &mut [Controller], time: Duration) {
    run(wire, controllers, time, &mut |_| false, &mut |_, _| {});
}

fn devices_at_an_interface_are_controlled() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let socket = |number: u8| control.with_extension(number.to_string());
    let path = control.to_str().expect("a path in UTF-8");
    let mut serving =
        ServeProcess::start(&[MODEL, "--nic", "theirs", "--name", "encoder", "--count", "2", "--control", path]);
    assert_eq!(
        serving.said,
        [
            "station encoder-1 10:b9:fe:00:01:00 - model:lika-xac77-profinet/xac7718",
            "station encoder-2 10:b9:fe:00:01:01 - model:lika-xac77-profinet/xac7718",
            "ready 2 at the interface theirs",
        ]
    );
    // The control channel from the command line.
    let first = socket(1);
    let first = first.to_str().expect("a path in UTF-8");
    let help = encspec(&["control", first, "help"]);
    assert!(help.status == Some(0) && help.out.contains("\nturn counts N rpm R\n"), "{}", help.out);
    let refused = encspec(&["control", first, "turn", "counts", "-1", "rpm", "0"]);
    assert!(refused.status == Some(1) && refused.out.starts_with("cannot "), "{}", refused.out);
    let mut wire = Wire::new(Box::new(Nic::open("ours").expect("the interface")));
    let mut controllers = [controller(0), controller(1)];
    let both = [("encoder-1", FIRST), ("encoder-2", SECOND)];
    for outcome in ask(&mut wire, &mut controllers, connect_patiently(&both)) {
        assert_standing(&outcome);
    }
    let reads = || vec![ControllerRequest::Read { target: IM0, length: 64 }; 2];
    for outcome in ask(&mut wire, &mut controllers, reads()) {
        assert!(matches!(&outcome, ControllerOutcome::Record(outcome) if outcome.is_accepted()), "{outcome:?}");
    }

    // The clock of the first device advances by a minute: its connection continues.
    assert_eq!(say(&socket(1), "clock 60"), "ok");
    exchange(&mut wire, &mut controllers, Duration::from_millis(700));
    assert!(controllers.iter_mut().all(|controller| controller.take_end().is_none()), "a connection was lost");

    // The first device is switched off: its connection ends, the other continues.
    assert_eq!(say(&socket(1), "power down"), "ok");
    assert!(ends(&mut wire, &mut controllers, 0), "the connection did not end");
    assert!(controllers[1].take_end().is_none(), "the second device is still powered");

    // After booting, two seconds on its own clock, it answers to its stored name.
    assert_eq!(say(&socket(1), "power up"), "ok");
    assert_eq!(say(&socket(1), "clock 2"), "ok");
    assert_eq!(found(&mut wire, &mut controllers[..1], "encoder-1"), 1);

    assert_eq!(say(&socket(2), "turn revolutions 1 rpm 60"), "ok done-in 1000000000");
    let refused = "cannot the reference device does not support this action; there are fault.memory, fault.sensor";
    assert_eq!(say(&socket(2), "fault light present"), refused);
    let abilities =
        "ok clock device fault.memory fault.sensor link power renew shaft.acceleration shaft.counts shaft.speed turn";
    assert_eq!(say(&socket(2), "abilities"), abilities);

    // A renewed device has no connection and no address, and can be connected to.
    assert_eq!(say(&socket(2), "renew"), "ok");
    assert!(ends(&mut wire, &mut controllers, 1), "the connection did not end");
    let again = ask(&mut wire, &mut controllers[1..], connect_patiently(&[("encoder-2", SECOND)]));
    assert_standing(&again[0]);
    assert_eq!(start_up_of(&again[0]).address_set, Some(true), "the renewed device has no address yet");

    assert_eq!(serving.interrupt(), Some(0));
    assert!(!socket(1).exists() && !socket(2).exists(), "the control sockets are removed");
}

fn a_device_at_a_socket_takes_a_new_peer(unix: bool) {
    let path = unused_path("frames");
    let address = if unix {
        path.display().to_string()
    } else {
        // The port is free now and will very likely stay free until it is served.
        let free = FrameSocket::bind(&"listen:127.0.0.1:0".parse().expect("an address")).expect("a free port");
        free.address().to_string().trim_start_matches("listen:").to_owned()
    };
    let mut serving = ServeProcess::start(&[MODEL, "--socket", &format!("listen:{address}"), "--name", "encoder"]);
    for round in 0..2 {
        let port = FrameSocket::open(&address.parse().expect("an address")).expect("the served device");
        let mut wire = Wire::new(Box::new(port));
        let mut controllers = [controller(round)];
        let outcome = &ask(&mut wire, &mut controllers, connect(&[("encoder", FIRST)]))[0];
        assert_standing(outcome);
        exchange(&mut wire, &mut controllers, Duration::from_millis(100));
        assert!(controllers[0].take_end().is_none());
        // The peer disconnects during data exchange; the watchdog of the device ends the connection.
    }
    let said = serving.end();
    assert!(said.contains("is gone") && said.contains("back at"), "{said}");
}

fn the_stations_of_a_segment_are_discovered() {
    if !private_network() {
        return;
    }
    let none = encspec(&["discover", "--nic", "ours", "--wait", "1"]);
    assert_eq!(none.status, Some(3));
    assert_eq!(none.err, "encspec: no station answered at the interface ours within 1 s\n");

    let twin = |mac: &str| {
        ServeProcess::start(&[MODEL, "--nic", "theirs", "--name", "press", "--ip", "192.168.0.10/16", "--mac", mac])
    };
    let (_first, _second) = (twin("02:00:00:00:01:00"), twin("02:00:00:00:01:05"));
    let _third = ServeProcess::start(&[MODEL, "--nic", "theirs", "--name", "", "--mac", "02:00:00:00:01:09"]);
    let found = encspec(&["discover", "--nic", "ours"]);
    assert_eq!(found.status, Some(0), "{}", found.err);
    let one = |mac: &str, ip: &str, name: &str| {
        format!(
            "{mac}  {ip}  {name}\n    vendor 0x0239, device 0x0001, LIKA ROTACOD, device\n    suite lika-xac77-profinet\n"
        )
    };
    assert_eq!(
        found.out,
        one("02:00:00:00:01:00", "192.168.0.10", "press")
            + &one("02:00:00:00:01:05", "192.168.0.10", "press")
            + &one("02:00:00:00:01:09", "no address", "(no name)")
    );
    assert_eq!(
        found.err,
        "encspec: 2 stations have the name press: 02:00:00:00:01:00, 02:00:00:00:01:05\n\
         encspec: 2 stations have the address 192.168.0.10: 02:00:00:00:01:00, 02:00:00:00:01:05\n"
    );
    let json = encspec(&["discover", "--nic", "ours", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).expect("JSON");
    let first = &json["stations"][0];
    assert_eq!(
        (first["vendor_id"].as_u64(), first["suite"].as_str(), first["roles"][0].as_str(), first["mask"].as_str()),
        (Some(0x0239), Some("lika-xac77-profinet"), Some("device"), Some("255.255.0.0"))
    );
    assert_eq!((json["stations"][2]["ip"].as_str(), json["stations"][2]["name"].as_str()), (None, Some("")));
    assert_eq!(json["remarks"].as_array().map(Vec::len), Some(2));
}

fn a_usage_error_is_reported_at_once(arguments: &[&str], status: i32, says: &str) {
    let output = encspec(arguments);
    assert_eq!(output.status, Some(status), "{}", output.err);
    assert!(output.err.contains(says), "{}", output.err);
    assert_eq!(output.out, "");
}
