//! Whether station name and IP address are stored is learned by a power cycle before the first change, and both are afterwards as found.

use crate::common::program::{self, ServeProcess};
use crate::common::served::{ask, controller, private_network};
use crate::{table, tests};
use controllers::profinet_io::{
    Controller, ControllerOutcome, ControllerRequest, DcpOutcome, IdentifiedStation, IdentifyBy,
};
use encspec::live::preflight;
use encspec::results::bench_file::LinkSpec;
use libtest_mimic::Trial;
use link::Wire;
use link::lines::LineClient;
use std::net::Ipv4Addr;
use std::time::{Duration, Instant};
use testing::Folder;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};

const NAME: &str = "pump-7";
const IP: IpParameter = IpParameter {
    address: Ipv4Addr::new(192, 168, 0, 77),
    mask: Ipv4Addr::new(255, 255, 240, 0),
    gateway: Ipv4Addr::new(192, 168, 15, 1),
};
/// How long the device may take to answer.
const PATIENCE: Duration = Duration::from_secs(30);
/// How long answers to an Identify are collected.
const IDENTIFY: Duration = Duration::from_millis(400);

pub fn trials() -> Vec<Trial> {
    let mut trials = table![permanence_is_learned_and_put_back:
        both_permanent("permanent", "permanent"),
        temporary_address("permanent", "temporary"),
        temporary_name("temporary", "permanent"),
        both_temporary("temporary", "temporary"),
    ];
    trials.extend(tests![without_consent_the_power_stays_on]);
    trials
}

/// A served plain device and its bench.
struct PermanenceBench {
    folder: Folder,
    _serving: ServeProcess,
}

impl PermanenceBench {
    fn new(consent: &str) -> PermanenceBench {
        let folder = Folder::new("permanence");
        let control = folder.join("control").display().to_string();
        let _serving = ServeProcess::start(&["model:profinet-io/plain", "--nic", "theirs", "--control", &control]);
        let gsdml = testing::workspace().join("suites/profinet-io/GSDML-V2.43-encspec-plain-20261121.xml");
        let text = format!(
            "device: profinet-io/plain\nlink: nic:ours\ngsdml: {}\nwatchdog: 200ms\nip: 192.168.0.10\n\
             stand: {{ control: {control}, shaft: [position(±0), speed(±0)] }}\nconsent: {{ alone: true, {consent} }}\n",
            gsdml.display()
        );
        folder.write("bench.yaml", text);
        PermanenceBench { folder, _serving }
    }

    /// Gives the device name and address, each for good or until power-off.
    fn set_up(&self, name: &str, ip: &str) {
        let qualifier =
            |word: &str| if word == "permanent" { BlockQualifier::PERMANENT } else { BlockQualifier::TEMPORARY };
        let (mut wire, mut controllers) = wire();
        let station = identify(&mut wire, &mut controllers);
        let values =
            [(qualifier(name), DcpValue::NameOfStation(NAME.into())), (qualifier(ip), DcpValue::IpParameter(IP))];
        for (qualifier, value) in values {
            let blocks = vec![DcpBlock::set(qualifier, value)];
            let request = ControllerRequest::DcpSet { to: station.mac, blocks };
            let outcome = ask(&mut wire, &mut controllers, vec![request]).remove(0);
            assert_eq!(outcome, ControllerOutcome::Dcp(DcpOutcome::Accepted));
        }
    }

    fn cycle_power(&self) {
        let mut stand = LineClient::connect(&self.folder.join("control")).expect("the control channel");
        for command in ["power down", "power up"] {
            let answer = stand.request(command, PATIENCE).expect("an answer");
            assert!(answer.starts_with("ok"), "{answer}");
        }
    }

    /// Runs one case; returns what the run says and its journal.
    fn run(&self) -> (String, String) {
        let arguments = ["run", "--dut", "bench.yaml", "--no-evidence", "profinet-io/protocol-identification/"];
        let said = program::encspec(&self.folder, &arguments);
        assert!(matches!(said.status, Some(0 | 1)), "{}", said.all());
        let files = std::fs::read_dir(self.folder.join("encspec-journal")).expect("a journal").flatten();
        let journal = files.map(|file| std::fs::read_to_string(file.path()).expect("it is read")).collect();
        (said.all(), journal)
    }
}

fn wire() -> (Wire, [Controller; 1]) {
    let link = LinkSpec::of("nic", "ours").expect("a link");
    let port = preflight::open(&link).unwrap_or_else(|why| panic!("{why}"));
    (Wire::new(port), [controller(0)])
}

/// The only station, once it answers.
fn identify(wire: &mut Wire, controllers: &mut [Controller; 1]) -> IdentifiedStation {
    let begin = Instant::now();
    loop {
        let request = ControllerRequest::Identify { by: IdentifyBy::All, wait: IDENTIFY };
        if let ControllerOutcome::Stations(stations) = ask(wire, controllers, vec![request]).remove(0)
            && let [station] = stations.as_slice()
        {
            return station.clone();
        }
        assert!(begin.elapsed() < PATIENCE, "the device does not answer");
    }
}

fn permanence_is_learned_and_put_back(name: &str, ip: &str) {
    if !private_network() {
        return;
    }
    let bench = PermanenceBench::new("set_name: true, set_ip: true");
    bench.set_up(name, ip);
    let (said, journal) = bench.run();
    let learned = format!("{{\"permanence\":{{\"name\":\"{name}\",\"ip\":\"{ip}\"}}}}");
    let (cycled, learned_at) = (journal.find("power_cycle"), journal.find(&learned));
    assert!(cycled < learned_at && cycled.is_some(), "{said}\n{journal}");
    assert!(journal.trim_end().ends_with("\"restored\""), "{said}\n{journal}");
    let present = || {
        let (mut wire, mut controllers) = wire();
        let IdentifiedStation { name, ip, .. } = identify(&mut wire, &mut controllers);
        (String::from_utf8_lossy(&name).into_owned(), ip)
    };
    assert_eq!(present(), (NAME.to_owned(), IP), "{said}\n{journal}");
    bench.cycle_power();
    let kept = if name == "permanent" { NAME } else { "" };
    let kept_ip = if ip == "permanent" { IP } else { IpParameter::NONE };
    assert_eq!(present(), (kept.to_owned(), kept_ip), "{said}\n{journal}");
}

/// Without the consents that put back what a power cycle erases there is none, and the journal says that nothing is known.
fn without_consent_the_power_stays_on() {
    if !private_network() {
        return;
    }
    let bench = PermanenceBench::new("set_name: true");
    bench.set_up("permanent", "temporary");
    let (said, journal) = bench.run();
    assert!(!journal.contains("power_cycle") && !journal.contains("permanence\":{"), "{said}\n{journal}");
    assert!(journal.contains("\"ip_permanence\":\"unknown\""), "{said}\n{journal}");
}
