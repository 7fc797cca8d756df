//! `kill -9` of `encspec run` at a random time, then `encspec bench restore`: the device is as before, also after a power cycle.
//!
//! The number of a kill is its seed. `ENCSPEC_KILLS=20-319` makes these kills instead of the first 20, so that a long series can be
//! continued where it ended.

use crate::common::program::{self, ServeProcess};
use crate::common::served::{
    PATIENCE, act, ask_one, assert_standing, connection, controller_at, identify, journal, private_network,
};
use crate::tests;
use controllers::profibus_dp::{MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster};
use controllers::profinet_io::{
    ArConfig, ConnectSubmodule, Controller, ControllerOutcome, ControllerRequest, DcpOutcome, DeviceAddress,
    IoParameterOutcome, IoRecordOutcome, RecordAddress,
};
use controllers::random::SplitMix64;
use encspec::live::fdl::FdlFrames;
use encspec::results::bench_file::LinkSpec;
use libtest_mimic::Trial;
use link::{Serial, SerialBus, SerialSettings, Wire};
use std::fs::File;
use std::net::Ipv4Addr;
use std::ops::RangeInclusive;
use std::path::Path;
use std::process::Stdio;
use std::thread::park_timeout;
use std::time::{Duration, Instant};
use testing::Folder;
use testing::stall::wait_for;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::{BaudRate, BitTimes};
use wire::profidrive::{ParameterAddress, ParameterFormat, ParameterRequest, ParameterValue};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};

/// The kills of a usual run of the tests.
const USUAL: RangeInclusive<u64> = 0..=19;
/// The environment variable with other numbers, `FIRST-LAST`.
const NUMBERS: &str = "ENCSPEC_KILLS";
/// The name of the device.
const NAME: &str = "pump-7";
/// How often the restore is tried: a host that stalls may lose a connection.
const RESTORES: usize = 3;
/// How long a slave may take that is perhaps at another address.
const AWAITED: Duration = Duration::from_secs(4);
/// The preset value P65000 that the device has stored before the run.
const PRESET_VALUE: [u8; 4] = [0, 0, 0x12, 0x34];

/// The device on which a run is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Victim {
    /// An encoder with parameters, at an interface.
    EncoderAtInterface,
    /// A device with I&M1 to I&M3, at an interface.
    TaggedDevice,
    /// The encoder at a socket.
    EncoderAtSocket,
    /// A slave with Set_Slave_Address.
    Slave,
}

impl Victim {
    const ALL: [Victim; 4] = [Victim::EncoderAtInterface, Victim::TaggedDevice, Victim::EncoderAtSocket, Victim::Slave];

    fn device(self) -> &'static str {
        match self {
            Victim::EncoderAtInterface | Victim::EncoderAtSocket => "lika-xac77-profinet/xac7718",
            Victim::TaggedDevice => "profinet-io/plain",
            Victim::Slave => "datalogic-amt58-profibus/hm5816-16384",
        }
    }

    fn description(self) -> &'static str {
        match self {
            Victim::EncoderAtInterface | Victim::EncoderAtSocket => {
                "gsdml: {}/lika-xac77-profinet/GSDML-V2.43-encspec-XAC7718-20261121.xml"
            }
            Victim::TaggedDevice => "gsdml: {}/profinet-io/GSDML-V2.43-encspec-plain-20261121.xml",
            Victim::Slave => "gsd: {}/datalogic-amt58-profibus/encspec-amt58-hm5816-16384.gsd",
        }
    }

    /// Cases that change something.
    fn filters(self) -> &'static [&'static str] {
        match self {
            Victim::EncoderAtInterface | Victim::EncoderAtSocket => {
                &["/station/", "/factory-reset/", "/memory/", "/parameter-values/", "/preset/", "/faults/"]
            }
            Victim::TaggedDevice => &["/protocol-records/", "/protocol-discovery/"],
            Victim::Slave => &["/slave-address/", "/addresses/", "/memory/"],
        }
    }
}

pub fn trials() -> Vec<Trial> {
    let numbers = std::env::var(NUMBERS).ok().map_or(USUAL, |text| {
        let range = text.split_once('-').and_then(|(first, last)| Some(first.parse().ok()?..=last.parse().ok()?));
        range.unwrap_or_else(|| panic!("{NUMBERS} is `{text}`: write FIRST-LAST"))
    });
    let kill = |number: u64| {
        let victim = Victim::ALL[(number % Victim::ALL.len() as u64) as usize];
        Trial::test(format!("kills::{victim:?}::{number}"), move || {
            kill(victim, number);
            Ok(())
        })
    };
    let mut trials: Vec<Trial> = numbers.map(kill).collect();
    trials.extend(tests![a_slave_is_found_at_another_address_and_moved_back]);
    trials
}

/// A served device with its bench file.
struct KillBench {
    folder: Folder,
    victim: Victim,
    link: String,
    ip: IpParameter,
    is_permanent: bool,
    _serving: ServeProcess,
}

fn kill(victim: Victim, number: u64) {
    let is_at_interface = matches!(victim, Victim::EncoderAtInterface | Victim::TaggedDevice);
    if is_at_interface && !private_network() {
        return;
    }
    let mut random = SplitMix64::new(number);
    let mut below = |limit: u64| random.bits() % limit;
    let bench = KillBench::new(victim, below(2) == 0);
    bench.set_up();
    let filter = victim.filters()[below(victim.filters().len() as u64) as usize];
    let (in_preflight, delay) = (below(8) == 0, Duration::from_millis(below(4_000)));
    let mut run = program::command(bench.folder.path(), &["run", "--dut", "bench.yaml", "--no-evidence", filter]);
    let output = || File::create(bench.folder.join("run.txt")).expect("a file");
    let mut run = run.stdout(Stdio::null()).stderr(output()).spawn().expect("the binary");
    if !in_preflight {
        wait_for("the first case", || {
            let said = || std::fs::read_to_string(bench.folder.join("run.txt")).unwrap_or_default();
            assert_eq!(run.try_wait().expect("its status"), None, "the run ended early: {}", said());
            journal(&bench.folder).contains("\"verdict\"").then_some(())
        });
    }
    let begin = Instant::now();
    while begin.elapsed() < delay {
        park_timeout(delay.saturating_sub(begin.elapsed()));
    }
    run.kill().expect("the process can be killed");
    run.wait().expect("its end");
    let before = journal(&bench.folder);
    let mut said = String::new();
    let is_restored = (0..RESTORES).any(|_| {
        let restored = program::encspec(&bench.folder, &["bench", "restore", "--stand"]);
        said.push_str(&restored.all());
        restored.status == Some(0)
    });
    let context = format!("kill {number} in {filter} after {delay:?}\n{before}\n{said}");
    assert!(is_restored, "not restored: {context}");
    bench.check(true, &context);
    bench.cycle_power();
    bench.check(bench.is_permanent, &context);
}

/// The run left the slave at an address that its journal does not know.
fn a_slave_is_found_at_another_address_and_moved_back() {
    let bench = KillBench::new(Victim::Slave, true);
    let mut run =
        program::command(bench.folder.path(), &["run", "--dut", "bench.yaml", "--no-evidence", "/slave-address/"]);
    let mut run = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary");
    wait_for("the first case", || journal(&bench.folder).contains("\"verdict\"").then_some(()));
    run.kill().expect("the process can be killed");
    run.wait().expect("its end");
    // With its switches at 126 the slave takes addresses over the bus.
    act(&bench.folder, &["power down", "switch address 126", "power up"]);
    let line = bench.folder.join("line");
    let address = |address| SetSlaveAddress { address, ident: 0x1655, no_change: 0, slave_data: Vec::new() };
    let from = if slave_answers(&line, 126, AWAITED) { 126 } else { 8 };
    ask_slave(&line, &MasterRequest::SetSlaveAddress { to: from, set: address(44) });
    assert!(slave_answers(&line, 44, PATIENCE), "the slave has moved from {from}");
    let restored = program::encspec(&bench.folder, &["bench", "restore"]);
    assert_eq!(restored.status, Some(0), "{}", restored.all());
    assert!(restored.all().contains("station address 8"), "{}", restored.all());
    bench.check(true, &restored.all());
}

impl KillBench {
    fn new(victim: Victim, is_permanent: bool) -> KillBench {
        let folder = Folder::new("kill");
        let path = |name: &str| folder.join(name).display().to_string();
        let (model, control) = (format!("model:{}", victim.device()), path("control"));
        let (link, place) = match victim {
            Victim::EncoderAtInterface | Victim::TaggedDevice => {
                ("nic:ours".to_owned(), ["--nic", "theirs"].map(str::to_owned))
            }
            Victim::EncoderAtSocket => {
                (format!("socket:{}", path("wire")), ["--socket".to_owned(), format!("listen:{}", path("wire"))])
            }
            Victim::Slave => (format!("serial:{}", path("line")), ["--pty".to_owned(), path("line")]),
        };
        let mut arguments = vec![model.as_str(), &place[0], &place[1], "--control", &control];
        arguments.extend(if victim == Victim::Slave { ["--address", "8"] } else { ["--name", NAME] });
        let serving = ServeProcess::start(&arguments);
        let suites = testing::workspace().join("suites").display().to_string();
        let permanence = if is_permanent { "permanent" } else { "temporary" };
        let (addresses, consents) = match victim {
            Victim::Slave => (String::new(), "set_address: true"),
            _ => (
                format!("ip: 192.168.0.10\nwatchdog: 200ms\nip_permanence: {permanence}\n"),
                "set_ip: true, im_records: true, alone: true",
            ),
        };
        let text = format!(
            "device: {}\nlink: {link}\n{}\n{addresses}stand: {{ control: {control}, shaft: [position(±0), speed(±0)] }}\n\
             consent: {{ set_name: true, nvm_write: 10000, position_reference: true, factory_reset: true, {consents} }}\n",
            victim.device(),
            victim.description().replace("{}", &suites),
        );
        folder.write("bench.yaml", text);
        let ip = IpParameter {
            address: Ipv4Addr::new(192, 168, 0, 77),
            mask: Ipv4Addr::new(255, 255, 240, 0),
            gateway: Ipv4Addr::new(192, 168, 15, 1),
        };
        KillBench { folder, victim, link, ip, is_permanent, _serving: serving }
    }

    fn link(&self) -> LinkSpec {
        let (kind, address) = self.link.split_once(':').expect("a link");
        LinkSpec::of(kind, address).expect("a link")
    }

    /// A controller at the link, for requests of the test.
    fn controller(&self) -> (Wire, [Controller; 1]) {
        controller_at(&self.link())
    }

    /// Gives the device an address with a gateway, plant tags, and a parameter that is not the default.
    fn set_up(&self) {
        if self.victim == Victim::Slave {
            return;
        }
        let (mut wire, mut controllers) = self.controller();
        let station = identify(&mut wire, &mut controllers);
        let qualifier = if self.is_permanent { BlockQualifier::PERMANENT } else { BlockQualifier::TEMPORARY };
        let blocks = vec![DcpBlock::set(qualifier, DcpValue::IpParameter(self.ip))];
        let set = ask_one(&mut wire, &mut controllers, ControllerRequest::DcpSet { to: station.mac, blocks });
        assert_eq!(set, ControllerOutcome::Dcp(DcpOutcome::Accepted));
        self.connect(&mut wire, &mut controllers);
        match self.victim {
            Victim::TaggedDevice => {
                for (target, data) in tags() {
                    let written = ask_one(&mut wire, &mut controllers, ControllerRequest::Write { target, data });
                    assert!(matches!(&written, ControllerOutcome::Record(of) if of.is_accepted()), "{written:?}");
                }
            }
            _ => {
                let change = |number, format, octets: &[u8]| {
                    let value = ParameterValue::new(format, 1, octets.to_vec());
                    ParameterRequest::change_values(1, 1, vec![(ParameterAddress::value(number, 0), value)])
                };
                parameter(&mut wire, &mut controllers, &change(65000, ParameterFormat(0x43), &PRESET_VALUE));
                parameter(&mut wire, &mut controllers, &change(971, ParameterFormat(0x42), &[0, 1]));
            }
        }
        ask_one(&mut wire, &mut controllers, ControllerRequest::Release);
    }

    fn connect(&self, wire: &mut Wire, controllers: &mut [Controller; 1]) {
        let mut config = connection(NAME, self.ip.address);
        config.ip = self.ip;
        if self.victim == Victim::TaggedDevice {
            config = plain_connection(self.ip);
        }
        assert_standing(&ask_one(wire, controllers, ControllerRequest::Connect(Box::new(config))));
    }

    /// Checks that the device is as before the run; without `has_ip` it has no IP address.
    fn check(&self, has_ip: bool, context: &str) {
        if self.victim == Victim::Slave {
            assert!(slave_answers(&self.folder.join("line"), 8, PATIENCE), "no slave at station 8: {context}");
            return;
        }
        let (mut wire, mut controllers) = self.controller();
        let station = identify(&mut wire, &mut controllers);
        let name = String::from_utf8_lossy(&station.name).into_owned();
        let expected = if has_ip { self.ip } else { IpParameter::NONE };
        assert_eq!((name.as_str(), station.ip), (NAME, expected), "{context}");
        self.connect(&mut wire, &mut controllers);
        match self.victim {
            Victim::TaggedDevice => {
                for (target, data) in tags() {
                    let read = ask_one(&mut wire, &mut controllers, ControllerRequest::Read { target, length: 100 });
                    let expected = ControllerOutcome::Record(IoRecordOutcome::Accepted { data });
                    assert_eq!(read, expected, "{context}");
                }
            }
            _ => {
                let request = ParameterRequest::read_values(1, 1, vec![ParameterAddress::value(65000, 0)]);
                let response = parameter(&mut wire, &mut controllers, &request);
                assert!(response.ends_with(&PRESET_VALUE), "P65000 differs: {response:02X?}: {context}");
            }
        }
        ask_one(&mut wire, &mut controllers, ControllerRequest::Release);
    }

    fn cycle_power(&self) {
        act(&self.folder, &["power down", "power up"]);
    }
}

/// I&M1 of the access point and of the module, and I&M3 of the access point, as a plant has them.
fn tags() -> Vec<(RecordAddress, Vec<u8>)> {
    let record = |slot: u16, index: u16, length: usize, text: &str| {
        let number = (index - 0xAFF0) as u8;
        let mut octets = vec![0, 0x20 + number, 0, length as u8 + 2, 1, 0];
        octets.extend(text.bytes().chain(std::iter::repeat(b' ')).take(length));
        (RecordAddress { api: 0, slot, subslot: 1, index }, octets)
    };
    vec![
        record(0, 0xAFF1, 54, "=A1+P7-B12                      HALL 3"),
        record(0, 0xAFF3, 54, "feed pump, do not turn"),
    ]
}

/// The connection with all submodules of the plain device.
fn plain_connection(ip: IpParameter) -> ArConfig {
    let submodule = |slot, module_ident, ident, octets: (u16, u16)| ConnectSubmodule {
        api: 0,
        slot,
        module_ident,
        subslot: 1,
        submodule_ident: ident,
        input_octets: octets.0,
        output_octets: octets.1,
    };
    let mut config = ArConfig::new(DeviceAddress::Name(NAME.into()), ip);
    (config.vendor_id, config.device_id) = (0xFEED, 0x00D0);
    (config.watchdog_factor, config.data_hold_factor) = (250, 250);
    config.submodules =
        vec![submodule(0, 1, 1, (0, 0)), submodule(1, 0x20, 0x21, (4, 4)), submodule(2, 0x30, 0x31, (2, 0))];
    config
}

/// The answer to a parameter request in the connection.
fn parameter(wire: &mut Wire, controllers: &mut [Controller; 1], request: &ParameterRequest) -> Vec<u8> {
    let at = RecordAddress { api: 0x3D00, slot: 1, subslot: 1, index: 0xB02E };
    let mut octets = Vec::new();
    request.write(&mut octets);
    match ask_one(wire, controllers, ControllerRequest::Parameter { at, request: octets }) {
        ControllerOutcome::Parameter(IoParameterOutcome::Answer(octets)) if octets[1] & 0x80 == 0 => octets,
        other => panic!("no parameter: {other:?}"),
    }
}

/// Whether a slave at the end of `line` answers Slave_Diag at this address.
fn slave_answers(line: &Path, address: u8, within: Duration) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < within {
        let outcome = ask_slave(line, &MasterRequest::Diagnosis { to: address });
        if matches!(&outcome, MasterOutcome::Answer(answer) if answer.diagnosis().is_some()) {
            return true;
        }
    }
    false
}

/// Sends a request by a master at the end of `line`.
fn ask_slave(line: &Path, request: &MasterRequest) -> MasterOutcome {
    let baud = BaudRate(1_500_000);
    let serial = Serial::open(line, &SerialSettings::new(baud.0)).expect("the line");
    let mut bus = SerialBus::new(serial, Box::<FdlFrames>::default());
    let mut settings = MasterSettings::new(1, baud);
    settings.slot_time = BitTimes(75_000);
    let mut master = ProfibusMaster::new(settings);
    master.request(bus.now(), request.clone()).expect("an idle master");
    loop {
        if let Some(outcome) = master.take_outcome() {
            return outcome;
        }
        let until = bus.now() + Duration::from_millis(10);
        bus.step(&mut [&mut master], until, &mut |_| true, &mut |_| ()).expect("the line works");
    }
}
