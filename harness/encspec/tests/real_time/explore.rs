//! `encspec explore` on served devices: nothing is found on a conforming one, a bug becomes a case, and after `kill -9` the device is put
//! back and what was found is on disk.

use crate::common::program::{self, ProgramOutput, ServeProcess};
use crate::common::served::{journal, private_network};
use crate::tests;
use libtest_mimic::Trial;
use std::process::Stdio;
use testing::Folder;
use testing::stall::wait_for;

const LIKA: (&str, &str) =
    ("lika-xac77-profinet/xac7718", "gsdml: {}/lika-xac77-profinet/GSDML-V2.43-encspec-XAC7718-20261121.xml");
const AMT58: (&str, &str) =
    ("datalogic-amt58-profibus/hm5816-16384", "gsd: {}/datalogic-amt58-profibus/encspec-amt58-hm5816-16384.gsd");
const CONSENTS: &str =
    "set_name: true, set_ip: true, set_address: true, nvm_write: 500, position_reference: true, alone: true";

pub fn trials() -> Vec<Trial> {
    tests![
        a_conforming_device_at_a_socket_shows_nothing,
        a_conforming_slave_shows_nothing,
        a_bug_at_an_interface_becomes_a_case,
        what_was_found_outlives_a_kill_and_the_device_is_put_back,
        nothing_is_changed_without_consents,
        another_variant_than_claimed_is_not_explored,
    ]
}

/// A served device with its bench file.
struct ExploredBench {
    folder: Folder,
    _serving: ServeProcess,
}

impl ExploredBench {
    /// Serves `device` with `bug`, if it is not empty; `link` is nic, socket or serial.
    fn new((device, description): (&str, &str), link: &str, bug: &str, consents: &str) -> ExploredBench {
        let folder = Folder::new("explore");
        let path = |name: &str| folder.join(name).display().to_string();
        let (model, control, wire) = (format!("model:{device}"), path("control"), path("wire"));
        let listen = format!("listen:{wire}");
        let (link, place) = match link {
            "nic" => ("nic:ours".to_owned(), ["--nic", "theirs", "--name", "pump-7"]),
            "socket" => (format!("socket:{wire}"), ["--socket", &listen, "--name", "pump-7"]),
            _ => (format!("serial:{wire}"), ["--pty", &wire, "--address", "8"]),
        };
        let mut arguments = vec![model.as_str(), "--control", &control];
        arguments.extend(place);
        if !bug.is_empty() {
            arguments.extend(["--bug", bug]);
        }
        let serving = ServeProcess::start(&arguments);
        let suites = testing::workspace().join("suites").display().to_string();
        let addresses = if link.starts_with("serial") {
            ""
        } else {
            "ip: 192.168.0.10\nwatchdog: 200ms\nip_permanence: permanent\n"
        };
        let text = format!(
            "device: {device}\nlink: {link}\n{}\n{addresses}stand: {{ control: {control}, shaft: [position(±0), speed(±0), uncoupled] }}\n\
             consent: {{ {consents} }}\n",
            description.replace("{}", &suites),
        );
        folder.write("bench.yaml", text);
        ExploredBench { folder, _serving: serving }
    }

    fn explore(&self, more: &[&str]) -> ProgramOutput {
        program::encspec(&self.folder, &[&["explore", "--dut", "bench.yaml", "--out", "found"], more].concat())
    }

    /// The text of the first finding; empty if there is none.
    fn found(&self) -> String {
        std::fs::read_to_string(self.folder.join("found/explored-1.yaml")).unwrap_or_default()
    }
}

#[track_caller]
fn assert_nothing_found(bench: &ExploredBench, output: &ProgramOutput) {
    let said = output.all();
    assert_eq!(output.status, Some(0), "{said}");
    assert!(said.contains("no difference from the reference device"), "{said}");
    assert_eq!(bench.found(), "", "{said}");
    assert!(journal(&bench.folder).contains("\"restored\""), "{said}");
}

fn a_conforming_device_at_a_socket_shows_nothing() {
    let bench = ExploredBench::new(LIKA, "socket", "", CONSENTS);
    assert_nothing_found(&bench, &bench.explore(&["--seed", "3", "--sequences", "6"]));
}

fn a_conforming_slave_shows_nothing() {
    let bench = ExploredBench::new(AMT58, "serial", "", CONSENTS);
    assert_nothing_found(&bench, &bench.explore(&["--seed", "3", "--sequences", "6"]));
}

fn a_bug_at_an_interface_becomes_a_case() {
    if !private_network() {
        return;
    }
    let bench = ExploredBench::new(LIKA, "nic", "error-clears-itself", CONSENTS);
    assert_is_found(&bench, &["--seed", "1", "--focus", "fault", "--time", "120", "--findings", "1"]);
}

#[track_caller]
fn assert_is_found(bench: &ExploredBench, more: &[&str]) {
    let output = bench.explore(more);
    let said = output.all();
    assert_eq!(output.status, Some(1), "{said}");
    assert!(said.contains("fails on the device and passes on the reference device"), "{said}");
    assert!(bench.found().contains("covers:"), "{said}");
    assert!(journal(&bench.folder).contains("\"restored\""), "{said}");
}

fn what_was_found_outlives_a_kill_and_the_device_is_put_back() {
    if !private_network() {
        return;
    }
    let bench = ExploredBench::new(LIKA, "nic", "error-clears-itself", CONSENTS);
    let arguments =
        ["explore", "--dut", "bench.yaml", "--out", "found", "--seed", "1", "--focus", "fault", "--time", "90"];
    let mut run = program::command(bench.folder.path(), &arguments);
    let mut run = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary");
    wait_for("the first finding", || (!bench.found().is_empty()).then_some(()));
    run.kill().expect("the process can be killed");
    run.wait().expect("its end");
    assert!(!journal(&bench.folder).contains("\"restored\""), "it was killed before");
    assert!(bench.found().contains("steps:"), "{}", bench.found());
    let restored = (0..3).map(|_| program::encspec(&bench.folder, &["bench", "restore", "--stand"]));
    let last = restored.into_iter().find(|output| output.status == Some(0));
    assert!(last.is_some(), "not restored: {}", journal(&bench.folder));
}

/// Without consents nothing but connections and parameters in the volatile memory is changed.
fn nothing_is_changed_without_consents() {
    let bench = ExploredBench::new(LIKA, "socket", "", "alone: true");
    let output = bench.explore(&["--seed", "5", "--sequences", "6"]);
    assert_ne!(output.status, Some(3), "{}", output.all());
    let journal = journal(&bench.folder);
    let journal = journal.lines().filter(|line| line.starts_with("{\"changes\"")).collect::<Vec<_>>().join("\n");
    assert!(!journal.is_empty());
    for change in ["position_reference", "nvm_write", "factory_reset", "set_name", "set_ip", "im_records"] {
        assert!(!journal.contains(change), "{change}: {journal}");
    }
}

fn another_variant_than_claimed_is_not_explored() {
    let bench = ExploredBench::new(LIKA, "socket", "", CONSENTS);
    let text = std::fs::read_to_string(bench.folder.join("bench.yaml")).expect("the bench file");
    let claimed = text.replace("device: lika-xac77-profinet/xac7718", "device: lika-xac77-profinet/xac7716-16384");
    let without = claimed.lines().filter(|line| !line.starts_with("gsdml")).collect::<Vec<_>>().join("\n");
    bench.folder.write("bench.yaml", without);
    let output = bench.explore(&["--sequences", "1"]);
    assert_eq!(output.status, Some(3), "{}", output.all());
}
