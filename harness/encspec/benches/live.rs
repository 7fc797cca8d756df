//! Measures the timing of the harness on a real wire: a cycle of 1 ms with 32 served devices, one process for all controllers.
//!
//!     cargo bench -p encspec --bench live
//!
//! Needs root or `unshare -rn`, for a private network. `ENCSPEC_BENCH_SECONDS` (60) and `ENCSPEC_BENCH_DEVICES` (32) change the size.
//! If `ENCSPEC_PNIO` is the path of the program `rt_bringup` of the crate pnio, the timing of pnio is measured as well
//! (`cargo install pnio --version 0.1.0 --example rt_bringup`). A lost connection is a failure.
//!
//! For all senders the jitter is measured: the distance between consecutive frames minus the cycle. Received frames have the kernel's
//! time stamp, frames of the harness the time of sending.

#[path = "../tests/common/mod.rs"]
mod common;

use common::program::ServeProcess;
use common::served::{MASK, MODEL, ask, connection, controller, private_network, run, start_up_of};
use controllers::profinet_io::{ArConfig, ArEnd, ConnectSubmodule, Controller, ControllerRequest, DeviceAddress};
use link::{Histogram, Nic, Wire, namespace, realtime};
use station::{Duration, Time};
use std::collections::HashMap;
use std::fs;
use std::net::Ipv4Addr;
use std::process::{Command, ExitCode, Stdio};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::blocks::connect::RtClass;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::FrameId;

const CYCLE: Duration = Duration::from_millis(1);
/// The time between the last start-up and the measurement.
const SETTLE: Duration = Duration::from_millis(500);
/// Watchdog factor in both directions.
const WATCHDOG: u16 = 20;
/// The longest measurement with a single device.
const SINGLE: Duration = Duration::from_secs(20);

fn main() -> ExitCode {
    let number =
        |name: &str, default: u64| std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default);
    let time = Duration::from_secs(number("ENCSPEC_BENCH_SECONDS", 60).max(1));
    let devices = number("ENCSPEC_BENCH_DEVICES", 32).clamp(1, 90) as u8;
    if !private_network() {
        return ExitCode::SUCCESS;
    }
    let scheduling = realtime::raise();
    scheduling.granted.iter().chain(&scheduling.refused).for_each(|text| println!("harness: {text}"));
    let many = served(devices, time);
    let one = served(1, time.min(SINGLE));
    let lost = many.lost + one.lost;
    many.show();
    one.show();
    match std::env::var("ENCSPEC_PNIO") {
        Ok(program) => match pnio(&program, time.min(SINGLE)) {
            Ok(measured) => measured.show(),
            Err(why) => println!("pnio: not measured, {why}"),
        },
        Err(_) => println!("pnio: not measured, ENCSPEC_PNIO is not set"),
    }
    if lost == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The results of one measurement.
struct Measured {
    what: String,
    time: Duration,
    sent: u64,
    lost: usize,
    ends: Vec<ArEnd>,
    dropped: u64,
    late: Histogram,
    ours: Histogram,
    theirs: Histogram,
    cpu: [Duration; 2],
}

impl Measured {
    fn show(&self) {
        let seconds = self.time.as_secs_f64();
        println!("\n{}, cycle 1 ms, {seconds:.0} s", self.what);
        println!(
            "  lost connections {}, cyclic frames sent by encspec {}, frames dropped by the receiver {}",
            self.lost, self.sent, self.dropped
        );
        self.ends.iter().take(3).for_each(|end| println!("  {end:?}"));
        println!("  {:<44} {:>9} {:>9} {:>9} {:>9} {:>9}", "", "samples", "p50", "p99", "p99.9", "max");
        for (what, of) in [
            ("encspec: wake-up after the deadline", &self.late),
            ("encspec: jitter of cyclic frames", &self.ours),
            ("device: jitter of cyclic frames", &self.theirs),
        ] {
            let micros = |time: Duration| format!("{:.1} µs", time.as_secs_f64() * 1e6);
            let [p50, p99, p999, max] = [of.p50(), of.p99(), of.p999(), of.max()].map(micros);
            println!("  {what:<44} {:>9} {p50:>9} {p99:>9} {p999:>9} {max:>9}", of.count());
        }
        let share = |cpu: Duration| cpu.as_secs_f64() / seconds * 100.0;
        println!("  CPU of one core: encspec {:.1} %, device {:.1} %", share(self.cpu[0]), share(self.cpu[1]));
    }
}

/// Measures served devices, all in one process.
fn served(devices: u8, time: Duration) -> Measured {
    let count = devices.to_string();
    let serving = ServeProcess::start(&[MODEL, "--nic", "theirs", "--name", "encoder", "--count", &count]);
    let connections = (0..devices).map(|number| {
        let name = if devices == 1 { "encoder".to_owned() } else { format!("encoder-{}", number + 1) };
        let connection = connection(&name, Ipv4Addr::new(192, 168, 0, 10 + number));
        ArConfig { watchdog_factor: WATCHDOG, data_hold_factor: WATCHDOG, ..connection }
    });
    let what = format!("{devices} served device(s) in one process");
    measure(what, connections.collect(), serving.id(), time).expect("served devices start up")
}

/// Measures the example `rt_bringup` of the crate pnio.
fn pnio(program: &str, time: Duration) -> Result<Measured, String> {
    let ip = Ipv4Addr::new(192, 168, 0, 50);
    namespace::run(&["addr", "add", &format!("{ip}/24"), "dev", "theirs"])?;
    // rt_bringup finds its interface in /sys, which must be mounted for the private network.
    let mut child = Command::new("unshare")
        .args(["--mount", "sh", "-c", "mount -t sysfs sysfs /sys && exec \"$0\" \"$@\"", program])
        .args(["--iface", "theirs", "--ip", &ip.to_string(), "--rt-priority", "40", "--lock-memory"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| format!("{program} cannot be started: {error}"))?;
    let submodule = |slot, module_ident, subslot, submodule_ident, input_octets, output_octets| ConnectSubmodule {
        api: 0,
        slot,
        module_ident,
        subslot,
        submodule_ident,
        input_octets,
        output_octets,
    };
    let ip = IpParameter { address: ip, mask: MASK, gateway: ip };
    let connection = ArConfig {
        vendor_id: 0x0493,
        device_id: 0x0002,
        rt_class: RtClass::RT_CLASS_2,
        // pnio sends its first cyclic frame late.
        watchdog_factor: 1_000,
        data_hold_factor: 1_000,
        frame_id_in: 0x8001,
        submodules: vec![
            submodule(0, 0x01, 1, 0x01, 0, 0),
            submodule(0, 0x01, 0x8000, 0x8000, 0, 0),
            submodule(0, 0x01, 0x8001, 0x8001, 0, 0),
            submodule(1, 0x30, 1, 0x130, 1, 0),
            submodule(2, 0x31, 1, 0x131, 0, 1),
            submodule(3, 0x32, 1, 0x132, 1, 1),
            submodule(4, 0x40, 1, 0x140, 8, 8),
        ],
        ..ArConfig::new(DeviceAddress::Name("rt-labs-dev".into()), ip)
    };
    let mut measured = measure("the device of the crate pnio".into(), vec![connection], child.id(), time);
    if let (Err(why), Ok(Some(status))) = (&mut measured, child.try_wait()) {
        *why = format!("{program} ended at once ({status})");
    }
    let _ = child.kill();
    let _ = child.wait();
    measured
}

/// Starts the connections, each with its own controller, and measures for `time`; `process` is the process id of the devices.
fn measure(what: String, connections: Vec<ArConfig>, process: u32, time: Duration) -> Result<Measured, String> {
    let mut wire = Wire::new(Box::new(Nic::open("ours").map_err(|error| error.to_string())?));
    let mut controllers: Vec<Controller> = (0..connections.len()).map(|number| controller(number as u8)).collect();
    let requests = connections.into_iter().map(|connection| {
        let connection = ArConfig { reduction_ratio: 1, ..connection };
        ControllerRequest::Connect(Box::new(connection))
    });
    for outcome in ask(&mut wire, &mut controllers, requests.collect()) {
        let start = start_up_of(&outcome);
        if !start.standing {
            return Err(format!("a start-up failed: {:?}", start.failed));
        }
    }
    // Wait until all start-ups are over, so that they are not measured.
    run(&mut wire, &mut controllers, SETTLE, &mut |_| false, &mut |_, _| {});
    let before = wire.port_mut().lost();
    wire.reset_lateness();
    let mut gaps = Gaps::default();
    let sent = |controllers: &[Controller]| controllers.iter().map(Controller::cycles_sent).sum::<u64>();
    let (cycles, cpu) = (sent(&controllers), cpus(process));
    let mut ends = Vec::new();
    let begin = wire.now();
    run(
        &mut wire,
        &mut controllers,
        time,
        &mut |controllers| {
            ends.extend(controllers.iter_mut().filter_map(Controller::take_end));
            false
        },
        &mut |time, frame| gaps.take(time, frame),
    );
    let after = cpus(process);
    Ok(Measured {
        what,
        time: wire.now().since(begin),
        sent: sent(&controllers) - cycles,
        lost: ends.len(),
        ends,
        dropped: wire.port_mut().lost() - before,
        late: wire.lateness().wakes().clone(),
        ours: gaps.ours,
        theirs: gaps.theirs,
        cpu: [after[0] - cpu[0], after[1] - cpu[1]],
    })
}

/// The jitter of cyclic frames: the distance between two frames of a sender minus the cycle.
#[derive(Default)]
struct Gaps {
    last: HashMap<Mac, Time>,
    ours: Histogram,
    theirs: Histogram,
}

impl Gaps {
    fn take(&mut self, time: Time, frame: &[u8]) {
        let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
        let is_cyclic = FrameId::peek(payload).is_ok_and(|id| id.is_cyclic());
        if header.ether_type != EtherType::PROFINET || !is_cyclic {
            return;
        }
        if let Some(before) = self.last.insert(header.source, time) {
            let gap = time.since(before);
            let is_ours = header.source.0[..5] == [2, 0, 0, 0, 2];
            let of = if is_ours { &mut self.ours } else { &mut self.theirs };
            of.record(gap.abs_diff(CYCLE));
        }
    }
}

/// The CPU time of this process and of the process `other`.
fn cpus(other: u32) -> [Duration; 2] {
    ["self".to_owned(), other.to_string()].map(|process| {
        let tasks = fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
        let nanos = tasks.filter_map(|task| {
            let text = fs::read_to_string(task.path().join("schedstat")).ok()?;
            text.split(' ').next()?.parse::<u64>().ok()
        });
        Duration::from_nanos(nanos.sum())
    })
}
