//! Hostile devices live: whatever a device at a Unix socket or over veth sends, a run ends in bounded time and memory, says what is wrong,
//! and is never green.

use crate::common::program::{self, ProgramOutput};
use crate::common::served::private_network;
use crate::table;
use deviations::{Setup, subject};
use libtest_mimic::Trial;
use link::{FrameSocket, Nic, Port, SocketAddress, Wire};
use station::Duration;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use testing::Folder;
use virtual_wire::hostile::{HOSTILE_DEVICES, HostileDevice, SpoiltDevice};

const MANUAL: &str = "lika-xac77-profinet";
const VARIANT: &str = "xac7718";
/// The seconds that a run may take, on a host that runs other tests.
const LONGEST_RUN: u32 = 150;
/// The status of `timeout` when it had to end the run.
const TOO_LONG: i32 = 124;
/// The address space of a run, in KiB: half of it is what a run with a good device has.
const MOST_MEMORY: u32 = 1 << 20;
/// Few cases, since a device that cannot be started keeps each for 30 s: a record, and cyclic frames that are counted.
const CASES: [&str; 2] = ["identification/vendor-in-i-and-m-0", "sign-of-life/running-sign-of-life[compatibility-off]"];
/// How often the device looks whether the test is over.
const LOOKS_EACH: Duration = Duration::from_millis(50);

/// Exit status of a run that is red.
const RED: i32 = 1;
/// Exit status of a run whose bench cannot be used.
const UNUSABLE: i32 = 3;

/// How the device is connected.
#[derive(Clone, Copy, PartialEq, Eq)]
enum HostileLink {
    Socket,
    Veth,
}

use HostileLink::{Socket, Veth};

pub fn trials() -> Vec<Trial> {
    table![a_run_ends_and_says_what_is_wrong:
        dcp_late("dcp-late", Socket, UNUSABLE, "no station answers; check cable and power"),
        dcp_block_length("dcp-block-length", Socket, UNUSABLE, "no station answers; check cable and power"),
        dcp_flood("dcp-flood", Veth, RED, "a DCP answer went to a group of stations"),
        name_escapes("name-escapes", Socket, RED, "an answer to DCP Identify did not come"),
        sender_changes("sender-changes", Veth, UNUSABLE, "an answer to DCP Set did not come"),
        rpc_late("rpc-late", Socket, RED, "the answer to Connect did not come"),
        rpc_flood("rpc-flood", Veth, RED, "a datagram went to a group of stations"),
        rpc_length("rpc-length", Socket, RED, "the answer to Connect did not come"),
        rpc_fragments("rpc-fragments", Socket, RED, "the answer to Connect did not come"),
        cyclic_zeros("cyclic-zeros", Socket, RED, "the next cyclic frame did not come"),
        cyclic_cut("cyclic-cut", Veth, RED, "the next cyclic frame did not come"),
    ]
}

/// Runs the hostile device at `port` until `is_over`.
fn serve(how: &'static HostileDevice, port: Box<dyn Port>, is_over: &AtomicBool) {
    let of = subject(MANUAL).expect("a reference device");
    let mac = of.manual.mac([2, 0, 0, 0, 1, 0]);
    let setup = Setup { mac, shaft: 4097, station_name: "encoder", ..Setup::default() };
    let device = of.build(VARIANT, &setup).expect("a variant");
    let mut device = SpoiltDevice::new(device, how);
    let mut wire = Wire::new(port);
    while !is_over.load(Ordering::Relaxed) {
        let until = wire.now() + LOOKS_EACH;
        if wire.step(&mut [(mac, &mut device)], until, &mut |_| true, &mut |_, _| {}).is_err() {
            // The run has ended its connection, or has not made the first one.
            let _ = wire.recover(until);
        }
    }
}

/// A run whose memory and time are bounded; the status [`TOO_LONG`] says that it did not end.
fn bounded_run(folder: &Folder) -> ProgramOutput {
    let program = program::command(folder.path(), &[]).get_program().to_owned();
    let script = format!("ulimit -v {MOST_MEMORY}; exec timeout {LONGEST_RUN} \"$@\"");
    let run = Command::new("sh")
        .args(["-c", &script, "sh"])
        .arg(program)
        .args(["run", "--dut", "bench.yaml", "--no-evidence", "--report", "html=report.html"])
        .args(CASES)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output();
    ProgramOutput::of(&run.expect("a shell"))
}

fn a_run_ends_and_says_what_is_wrong(name: &str, connected: HostileLink, status: i32, says: &str) {
    if connected == Veth && !private_network() {
        return;
    }
    let how = HOSTILE_DEVICES.iter().find(|of| of.name == name).expect("a hostile device");
    let folder = Folder::new(name);
    let line = folder.join("line").display().to_string();
    let gsdml = testing::workspace().join("suites").join(MANUAL).join("GSDML-V2.43-encspec-XAC7718-20261121.xml");
    let link = if connected == Veth { "nic:ours".to_owned() } else { format!("socket:{line}") };
    folder.write(
        "bench.yaml",
        format!(
            "device: {MANUAL}/{VARIANT}\nlink: {link}\ngsdml: {}\nip: 192.168.0.10\nwatchdog: 500ms\n\
             consent: {{ position_reference: true }}\n",
            gsdml.display()
        ),
    );
    let port: Box<dyn Port> = match connected {
        Veth => Box::new(Nic::open("theirs").expect("the interface")),
        Socket => {
            let address: SocketAddress = format!("listen:{line}").parse().expect("an address");
            Box::new(FrameSocket::bind(&address).expect("a socket"))
        }
    };
    let is_over = AtomicBool::new(false);
    let said = thread::scope(|scope| {
        scope.spawn(|| serve(how, port, &is_over));
        let said = bounded_run(&folder);
        is_over.store(true, Ordering::Relaxed);
        said
    });
    assert_ne!(said.status, Some(TOO_LONG), "{name}: the run does not end: {}", said.all());
    assert_eq!(said.status, Some(status), "{name}: {}", said.all());
    assert!(said.all().contains(says), "{name}: {}", said.all());
    let report = std::fs::read_to_string(folder.join("report.html")).unwrap_or_default();
    for text in [&said.all(), &report] {
        assert!(!text.contains('\u{1B}'), "{name}: an escape sequence of the device");
        assert!(!text.contains("<script>alert"), "{name}: markup of the device");
    }
    assert!(!said.all().contains("fault of encspec") && !said.all().contains("panicked"), "{name}: {}", said.all());
}
