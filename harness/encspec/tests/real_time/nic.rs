//! `encspec run` with a live device on a network interface or socket: what is tested, what is not touched, what is restored.

use crate::common::program::{ProgramOutput, ServeProcess};
use crate::common::served::{MODEL, ask, assert_standing, connection, controller, private_network};
use crate::common::{program, served};
use crate::{table, tests};
use controllers::profinet_io::{Controller, ControllerRequest};
use libtest_mimic::Trial;
use link::{Clock, Nic, Port, Wire};
use serde_json::Value;
use station::Duration;
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use testing::stall::wait_for;
use testing::{Folder, unused_path};
use wire::ethernet::Mac;

const DEVICE: Mac = Mac([0x10, 0xB9, 0xFE, 0, 1, 0]);
/// The time between two checks whether a run has ended.
const POLL: Duration = Duration::from_millis(50);
/// How long a run on a device that is in use may take.
const LONGEST_RUN: Duration = Duration::from_secs(60);
const EVERYTHING: &str = "{ set_name: true, set_ip: true, im_records: true, nvm_write: 1000, position_reference: true, factory_reset: true, alone: true }";

pub fn trials() -> Vec<Trial> {
    let mut trials = tests![
        a_device_at_an_interface_is_tested_and_restored,
        a_device_that_reconnects_is_tested_further,
        a_device_that_disappears_ends_in_verdicts,
        an_unusable_bench_is_reported,
        frames_go_only_to_the_device_under_test,
        an_interrupted_run_releases_and_restores,
        a_killed_run_is_restored_from_its_journal,
        a_journal_is_closed_with_a_reason,
        web_pages_of_the_bench_file_are_requested,
        without_pages_in_the_bench_file_only_pages_with_a_printed_path_are_requested,
        a_connection_of_another_controller_is_not_touched,
        wrong_claims_of_the_bench_are_findings,
        beside_other_stations_only_cases_that_read_are_run,
        a_run_without_a_bench_file_has_results,
    ];
    trials.extend(table![a_persona_meets_the_device_over_a_socket:
        conforming(&[], "pass"),
        bug(&["--bug", "tag-needed"], "fail"),
    ]);
    trials.extend(table![cases_without_consent_are_not_applicable:
        preset("preset/absolute", "no consent to `position_reference`"),
        reset("factory-reset/every-effect", "no consent to `set_name`"),
        name("station/good-names", "no consent to `set_name`"),
        memory("parameter-values/save-and-confirm", "no consent to `nvm_write`"),
        shaft("parking/not-while-turning", "shaft"),
    ]);
    trials
}

/// A folder with a bench file.
struct NicBench {
    folder: Folder,
}

impl NicBench {
    /// A bench at `link` with the further lines `more`.
    fn new(name: &str, link: &str, more: &str) -> NicBench {
        let folder = Folder::new(name);
        let gsdml = testing::workspace().join("suites/lika-xac77-profinet");
        let gsdml = gsdml.join("GSDML-V2.43-encspec-XAC7718-20261121.xml");
        let text = format!(
            "device: lika-xac77-profinet/xac7718\nlink: {link}\nip: 192.168.0.10\nwatchdog: 200ms\ngsdml: {}\n{more}\n",
            gsdml.display()
        );
        std::fs::write(folder.join("bench.yaml"), text).expect("the bench file");
        NicBench { folder }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        program::command(self.folder.path(), arguments)
    }

    fn call(&self, arguments: &[&str]) -> ProgramOutput {
        program::encspec(&self.folder, arguments)
    }

    /// Runs the cases of `filter`. Returns the exit status, and verdict and reason of each case.
    fn run(&self, filter: &str) -> (Option<i32>, BTreeMap<String, (String, String)>) {
        let arguments = ["run", "--dut", "bench.yaml", "--report", "json=run.json", "--no-evidence", filter];
        let output = self.call(&arguments);
        let text = std::fs::read_to_string(self.folder.join("run.json")).expect("a report");
        let report: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {}", output.all()));
        let cases = report["runs"][0]["cases"].as_array().expect("cases").iter().map(|case| {
            let of = |key: &str| case[key].as_str().unwrap_or_default().to_owned();
            (of("id"), (of("verdict"), of("reason")))
        });
        (output.status, cases.collect())
    }
}

/// A stand with all abilities, and all consents.
fn unrestricted(control: &Path) -> String {
    format!("stand: {{ control: {}, shaft: [position(±0), speed(±0)] }}\nconsent: {EVERYTHING}", control.display())
}

fn serve(control: &Path, more: &[&str]) -> ServeProcess {
    let mut arguments = vec![MODEL, "--control", control.to_str().expect("UTF-8")];
    arguments.extend(more);
    ServeProcess::start(&arguments)
}

/// The lines in the journals of a bench.
fn journal(bench: &NicBench) -> Vec<String> {
    let folder = bench.folder.join("encspec-journal");
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let texts = files.map(|file| std::fs::read_to_string(file.path()).expect("a journal"));
    texts.flat_map(|text| text.lines().map(str::to_owned).collect::<Vec<_>>()).collect()
}

fn web_pages_of_the_bench_file_are_requested() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.77"]);
    let pages = "pages: { information: {}, parameters: {}, position: {}, preset: {}, upgrade: {} }";
    let bench = NicBench::new("web", "nic:ours", &format!("{pages}\n{}", unrestricted(&control)));
    let (status, cases) = bench.run("web/information");
    assert_eq!(status, Some(0), "{cases:?}");
    assert!(cases.len() > 2 && cases.values().all(|(verdict, _)| verdict == "pass"), "{cases:?}");
    let (_, cases) = bench.run("web/wrong-password");
    let is_excluded =
        |(verdict, why): &(String, String)| verdict == "not-applicable" && why.contains("no consent to `firmware`");
    assert!(cases.len() > 2 && cases.values().all(is_excluded), "{cases:?}");
}

fn without_pages_in_the_bench_file_only_pages_with_a_printed_path_are_requested() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.77"]);
    let bench = NicBench::new("web-unknown", "nic:ours", &unrestricted(&control));
    let (status, cases) = bench.run("web/");
    assert_eq!(status, Some(0), "{cases:?}");
    let unknown = cases
        .values()
        .filter(|(verdict, why)| verdict == "not-applicable" && why.contains("does not describe the web page"));
    let passed = cases.values().filter(|(verdict, _)| verdict == "pass");
    assert_eq!((unknown.count(), passed.count()), (cases.len() - 7, 7), "{cases:?}");
}

fn a_device_at_an_interface_is_tested_and_restored() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.77"]);
    let bench = NicBench::new("nic", "nic:ours", &unrestricted(&control));
    let (status, cases) = bench.run("station/good-names");
    assert_eq!(status, Some(0), "{cases:?}");
    assert!(cases.len() > 5 && cases.values().all(|(verdict, _)| verdict == "pass"), "{cases:?}");
    let journal = journal(&bench);
    assert!(journal[0].contains("\"found\"") && journal[0].contains("192.168.0.77"), "{}", journal[0]);
    let named = journal.iter().position(|line| line.contains("\"changes\"") && line.contains("set_name"));
    let first_verdict = journal.iter().position(|line| line.contains("\"verdict\""));
    assert!(named < first_verdict, "a change is logged before it is made: {journal:#?}");
    assert_eq!(journal.last().map(String::as_str), Some("\"restored\""));
    // Name and address are restored.
    let found = bench.call(&["discover", "--nic", "ours", "--wait", "1", "--format", "json"]);
    let found = found.all();
    assert!(found.contains("encoder-under-test") && found.contains("192.168.0.77"), "{found}");
}

fn cases_without_consent_are_not_applicable(filter: &str, reason: &str) {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs"]);
    let bench = NicBench::new("consent", "nic:ours", "consent: { alone: true }");
    let (status, cases) = bench.run(filter);
    assert_eq!(status, Some(1), "nothing passed, so the run is red");
    for (id, (verdict, why)) in &cases {
        assert_eq!(verdict, "not-applicable", "{id}: {why}");
    }
    assert!(cases.values().any(|(_, why)| why.contains(reason)), "{cases:?}");
    // The preflight sets the address of the bench, since the device had none.
    let changed = |line: &&String| line.contains("\"changes\"") && !line.contains("\"preflight\"");
    assert_eq!(journal(&bench).iter().find(changed), None);
}

/// All frames on the segment go to the device under test or are discovery multicasts and broadcasts.
fn frames_go_only_to_the_device_under_test() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let arguments = ["--nic", "theirs", "--count", "2", "--name", "encoder", "--ip", "192.168.0.10"];
    let _serving = serve(&control, &arguments);
    let bench = NicBench::new("alone", "nic:ours", &format!("station_name: encoder-1\nconsent: {EVERYTHING}"));
    let clock = Clock::start();
    let mut monitor = Nic::open("theirs").expect("the interface");
    let mut run = bench.command(&["run", "--dut", "bench.yaml", "--no-evidence", "telegrams/"]);
    let mut run = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary");
    let mut to: BTreeMap<Mac, u64> = BTreeMap::new();
    let mut frame = Vec::new();
    while run.try_wait().expect("its status").is_none() {
        let until = clock.now() + POLL;
        while let Ok(Some(_)) = monitor.receive(&clock, until, &mut frame) {
            if let Some(Ok(octets)) = frame.get(..6).map(<[u8; 6]>::try_from) {
                *to.entry(Mac(octets)).or_default() += 1;
            }
        }
    }
    let status = run.wait().expect("its status");
    assert!(to.get(&DEVICE).is_some_and(|count| *count > 500), "{status}: {to:?}");
    let others: Vec<&Mac> = to.keys().filter(|mac| **mac != DEVICE && !mac.is_group()).collect();
    assert_eq!(others, [&DEVICE; 0], "frames to others: {to:?}");
    assert!(to.keys().all(|mac| [DEVICE, Mac::DCP_MULTICAST, Mac::BROADCAST].contains(mac)), "{to:?}");
}

fn beside_other_stations_only_cases_that_read_are_run() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--count", "2", "--name", "encoder", "--ip", "192.168.0.10"]);
    let more = format!("station_name: encoder-1\nconsent: {}", EVERYTHING.replace(", alone: true", ""));
    let bench = NicBench::new("others", "nic:ours", &more);
    let (status, cases) = bench.run("station/");
    let verdict = |id: &str| cases[&format!("lika-xac77-profinet/station/{id}")].0.as_str();
    assert_eq!(verdict("type-of-station"), "pass");
    assert_eq!(status, Some(1), "a run that may only read is red");
    let named = &cases["lika-xac77-profinet/station/good-names[digit-first]"];
    assert!(named.0 == "not-applicable" && named.1.contains("another station"), "{named:?}");
}

/// A device that disappears during a run results in inconclusive verdicts, and the run ends.
fn a_device_that_disappears_ends_in_verdicts() {
    let path = unused_path("wire");
    let listen = format!("listen:{}", path.display());
    let mut serving = ServeProcess::start(&[MODEL, "--socket", &listen]);
    let bench = NicBench::new("vanished", &format!("socket:{}", path.display()), &format!("consent: {EVERYTHING}"));
    let arguments = ["run", "--dut", "bench.yaml", "--report", "json=run.json", "telegrams/"];
    let mut run = bench.command(&arguments);
    let run = run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary");
    wait_for_verdict(&bench);
    serving.end();
    let output = ProgramOutput::of(&run.wait_with_output().expect("its end"));
    assert_eq!(output.status, Some(1), "{}", output.all());
    let text = std::fs::read_to_string(bench.folder.join("run.json")).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let cases = report["runs"][0]["cases"].as_array().expect("cases");
    let trials = || cases.iter().filter(|case| case["kind"] != "rule");
    let last = trials().next_back().map(|case| &case["verdict"]);
    assert_eq!(last.and_then(Value::as_str), Some("inconclusive"), "{text}");
    assert!(!trials().any(|case| case["verdict"] == "fail"), "a broken link is not a failure of the device: {text}");
}

/// A case passes on the reference device and fails with a bug that only this persona shows.
fn a_persona_meets_the_device_over_a_socket(bug: &[&str], expected: &str) {
    let path = unused_path("wire");
    let listen = format!("listen:{}", path.display());
    let arguments: Vec<&str> = [MODEL, "--socket", &listen].into_iter().chain(bug.iter().copied()).collect();
    let _serving = ServeProcess::start(&arguments);
    let more = format!("persona: untagged-rt\nconsent: {EVERYTHING}");
    let bench = NicBench::new("persona", &format!("socket:{}", path.display()), &more);
    let (status, cases) = bench.run("preset/absolute");
    let (verdict, _) = &cases["lika-xac77-profinet/preset/absolute"];
    assert_eq!((status == Some(0), verdict.as_str()), (expected == "pass", expected), "{cases:?}");
}

/// A device disappears during a run and reconnects: cases in between are inconclusive, later ones are tested.
fn a_device_that_reconnects_is_tested_further() {
    let path = unused_path("wire");
    let listen = format!("listen:{}", path.display());
    let mut serving = ServeProcess::start(&[MODEL, "--socket", &listen]);
    let bench = NicBench::new("back", &format!("socket:{}", path.display()), &format!("consent: {EVERYTHING}"));
    let mut run = bench.command(&["run", "--dut", "bench.yaml", "--report", "json=run.json", "telegrams/"]);
    let run = run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary");
    wait_for_verdict(&bench);
    serving.end();
    let _again = ServeProcess::start(&[MODEL, "--socket", &listen]);
    let output = ProgramOutput::of(&run.wait_with_output().expect("its end"));
    let text = std::fs::read_to_string(bench.folder.join("run.json")).unwrap_or_else(|_| panic!("{}", output.all()));
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let cases = report["runs"][0]["cases"].as_array().expect("cases").iter().filter(|case| case["kind"] != "rule");
    let verdicts: Vec<&str> = cases.map(|case| case["verdict"].as_str().unwrap_or_default()).collect();
    assert!(!verdicts.contains(&"fail") && !verdicts.contains(&"error"), "{verdicts:?}");
    assert_eq!(verdicts.last(), Some(&"pass"), "{verdicts:?}");
}

/// A connection of another controller to the device is not disturbed, whatever the bench allows.
fn a_connection_of_another_controller_is_not_touched() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.10"]);
    let mut wire = Wire::new(Box::new(Nic::open("ours").expect("the interface")));
    let mut controllers = [controller(0)];
    let connection = connection("encoder-under-test", Ipv4Addr::new(192, 168, 0, 10));
    let outcomes = ask(&mut wire, &mut controllers, vec![ControllerRequest::Connect(Box::new(connection))]);
    assert_standing(&outcomes[0]);
    let bench = NicBench::new("foreign", "nic:ours", &unrestricted(&control));
    let mut run =
        bench.command(&["run", "--dut", "bench.yaml", "--report", "json=run.json", "--no-evidence", "preset/"]);
    let mut run = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary");
    let mut over = |_: &mut [Controller]| run.try_wait().expect("its status").is_some();
    assert!(served::run(&mut wire, &mut controllers, LONGEST_RUN, &mut over, &mut |_, _| {}));
    assert!(controllers[0].take_end().is_none(), "the connection was lost");
    assert_eq!(run.wait().expect("its status").code(), Some(1));
    let text = std::fs::read_to_string(bench.folder.join("run.json")).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let cases = report["runs"][0]["cases"].as_array().expect("cases");
    let reason = cases[0]["reason"].as_str().unwrap_or_default();
    assert!(reason.contains("is connected to the controller"), "{reason}");
    assert!(
        cases.iter().filter(|case| case["kind"] != "rule").all(|case| case["verdict"] == "not-applicable"),
        "{text}"
    );
}

fn wrong_claims_of_the_bench_are_findings() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs"]);
    let claims = "telegrams: [telegram_81, telegram_83, telegram_84]\nlacks: [P65000]\nfirmware: 9.9.9";
    let bench = NicBench::new("claims", "nic:ours", &format!("{claims}\n{}", unrestricted(&control)));
    let (status, cases) = bench.run("station/type-of-station");
    assert_eq!(status, Some(1), "a wrong claim makes the run red: {cases:?}");
    let text = std::fs::read_to_string(bench.folder.join("run.json")).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let findings = report["runs"][0]["findings"].as_array().expect("findings").iter();
    let errors = findings.filter(|finding| finding["severity"] == "error");
    let mut ids: Vec<&str> = errors.map(|finding| finding["id"].as_str().unwrap_or_default()).collect();
    ids.sort_unstable();
    assert_eq!(ids, ["claim.P65000", "claim.telegram_82", "firmware"]);
}

/// Waits until the journal has a verdict.
fn wait_for_verdict(bench: &NicBench) {
    let has_one = || journal(bench).iter().any(|line| line.contains("\"verdict\"")).then_some(());
    wait_for("the verdict of a trial", has_one);
}

fn an_interrupted_run_releases_and_restores() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.77"]);
    let bench = NicBench::new("interrupt", "nic:ours", &unrestricted(&control));
    let clock = Clock::start();
    let mut monitor = Nic::open("theirs").expect("the interface");
    let mut command = bench.command(&["run", "--dut", "bench.yaml", "--report", "json=run.json"]);
    let run: Child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary");
    wait_for_verdict(&bench);
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().expect("kill").success());
    let output = ProgramOutput::of(&run.wait_with_output().expect("its end"));
    assert_eq!(output.status, Some(1), "{}", output.all());
    let text = std::fs::read_to_string(bench.folder.join("run.json")).expect("the report of the finished cases");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let cases = report["runs"][0]["cases"].as_array().expect("cases");
    let with = |verdict: &str| cases.iter().filter(|case| case["verdict"] == verdict).count();
    assert!(with("pass") > 0 && with("not-run") > 0 && with("fail") == 0, "{text}");
    assert_eq!(journal(&bench).last().map(String::as_str), Some("\"restored\""), "{}", output.all());
    // The last cyclic frame to the device has all outputs 0.
    let mut last = None;
    let mut frame = Vec::new();
    while let Ok(Some(_)) = monitor.receive(&clock, clock.now(), &mut frame) {
        let is_output = frame.starts_with(&DEVICE.0) && frame.get(12..14) == Some(&[0x81, 0x00]);
        if is_output && frame.get(16..18) == Some(&[0x88, 0x92]) && frame.get(18) == Some(&0xC0) {
            last = Some(frame.clone());
        }
    }
    // STW2_ENC without its sign of life, and G1_STW; two status bytes of the other submodules precede them.
    if let Some(frame) = last {
        let data = &frame[20..];
        assert!(data.len() > 8, "{frame:02X?}");
        let outputs: Vec<u8> = data.iter().copied().filter(|octet| *octet != 0x80).take(4).collect();
        assert_eq!((outputs[0] & 0x0F, outputs[1]), (0, 0), "{frame:02X?}");
    }
    let found = bench.call(&["discover", "--nic", "ours", "--wait", "1", "--format", "json"]).all();
    assert!(found.contains("encoder-under-test") && found.contains("192.168.0.77"), "{found}");
}

fn a_killed_run_is_restored_from_its_journal() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.77"]);
    let bench = NicBench::new("killed", "nic:ours", &unrestricted(&control));
    let mut command = bench.command(&["run", "--dut", "bench.yaml", "station/good-names"]);
    let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary");
    wait_for_verdict(&bench);
    run.kill().expect("the process is running");
    run.wait().expect("its end");
    let restored = bench.call(&["bench", "restore"]);
    assert_eq!(restored.status, Some(0), "{}", restored.all());
    assert!(restored.all().contains("restored the state"), "{}", restored.all());
    let found = bench.call(&["discover", "--nic", "ours", "--wait", "1", "--format", "json"]).all();
    assert!(found.contains("encoder-under-test") && found.contains("192.168.0.77"), "{found}");
    let again = bench.call(&["bench", "restore"]);
    assert!(again.all().contains("nothing to restore"), "{}", again.all());
}

fn a_journal_is_closed_with_a_reason() {
    if !private_network() {
        return;
    }
    let control = unused_path("control");
    let _serving = serve(&control, &["--nic", "theirs", "--ip", "192.168.0.77"]);
    let bench = NicBench::new("closed", "nic:ours", &unrestricted(&control));
    let mut command = bench.command(&["run", "--dut", "bench.yaml", "station/good-names"]);
    let mut run = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary");
    wait_for_verdict(&bench);
    run.kill().expect("the process is running");
    run.wait().expect("its end");
    let closed = bench.call(&["bench", "restore", "--close", "the encoder was replaced"]);
    assert_eq!(closed.status, Some(0), "{}", closed.all());
    assert!(
        closed.out.contains("closed, and nothing was restored of: power_cycle, temporary_ip, set_name"),
        "{}",
        closed.all()
    );
    assert_eq!(
        journal(&bench).last().map(String::as_str),
        Some("{\"closed\":{\"reason\":\"the encoder was replaced\"}}")
    );
    let again = bench.call(&["bench", "restore"]);
    assert!(again.all().contains("nothing to restore"), "{}", again.all());
}

fn an_unusable_bench_is_reported() {
    if !private_network() {
        return;
    }
    let device = ["--device", "lika-xac77-profinet/xac7718"];
    let call = |dut: &str| {
        let output = program::encspec(std::env::temp_dir(), &["run", "--dut", dut, device[0], device[1]]);
        (output.status, output.all())
    };
    let (status, text) = call("nic:nowhere");
    assert!(status == Some(3) && text.contains("nowhere"), "{text}");
    let (status, text) = call("nic:ours");
    assert!(status == Some(3) && text.contains("no station answers"), "{text}");
    let _serving = ServeProcess::start(&["model:profinet-io/plain", "--nic", "theirs", "--ip", "192.168.0.10"]);
    let (status, text) = call("nic:ours");
    assert!(status == Some(3) && text.contains("does not answer"), "{text}");
}

fn a_run_without_a_bench_file_has_results() {
    if !private_network() {
        return;
    }
    let _serving = ServeProcess::start(&[MODEL, "--nic", "theirs", "--ip", "192.168.0.10"]);
    // Without a bench file, idents that the manual does not print are read from the device, and no lasting change is made.
    let arguments =
        ["run", "--dut", "nic:ours", "--device", "lika-xac77-profinet/xac7718", "--no-evidence", "station/"];
    let output = program::encspec(std::env::temp_dir(), &arguments);
    let lines: Vec<&str> = output.out.lines().collect();
    assert!(lines.iter().any(|line| line.contains("pass")), "{}", output.all());
    assert!(lines.iter().any(|line| line.contains("not-applicable")), "{}", output.all());
}
