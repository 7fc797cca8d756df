//! Whether station name and IP address are stored is learned by a power cycle before the first change, and both are afterwards as found.

use crate::common::program::{self, ServeProcess};
use crate::common::served::{act, ask_one, controller_at, identify, journal, private_network};
use crate::{table, tests};
use controllers::profinet_io::{ControllerOutcome, ControllerRequest, DcpOutcome, IdentifiedStation};
use encspec::results::bench_file::LinkSpec;
use libtest_mimic::Trial;
use std::net::Ipv4Addr;
use testing::Folder;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};

const NAME: &str = "pump-7";
const IP: IpParameter = IpParameter {
    address: Ipv4Addr::new(192, 168, 0, 77),
    mask: Ipv4Addr::new(255, 255, 240, 0),
    gateway: Ipv4Addr::new(192, 168, 15, 1),
};

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
        let (mut wire, mut controllers) = controller_at(&LinkSpec::of("nic", "ours").expect("a link"));
        let station = identify(&mut wire, &mut controllers);
        let values =
            [(qualifier(name), DcpValue::NameOfStation(NAME.into())), (qualifier(ip), DcpValue::IpParameter(IP))];
        for (qualifier, value) in values {
            let blocks = vec![DcpBlock::set(qualifier, value)];
            let request = ControllerRequest::DcpSet { to: station.mac, blocks };
            let outcome = ask_one(&mut wire, &mut controllers, request);
            assert_eq!(outcome, ControllerOutcome::Dcp(DcpOutcome::Accepted));
        }
    }

    fn cycle_power(&self) {
        act(&self.folder, &["power down", "power up"]);
    }

    /// Runs one case; returns what the run says and its journal.
    fn run(&self) -> (String, String) {
        let arguments = ["run", "--dut", "bench.yaml", "--no-evidence", "profinet-io/protocol-identification/"];
        let said = program::encspec(&self.folder, &arguments);
        assert!(matches!(said.status, Some(0 | 1)), "{}", said.all());
        (said.all(), journal(&self.folder))
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
        let (mut wire, mut controllers) = controller_at(&LinkSpec::of("nic", "ours").expect("a link"));
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
