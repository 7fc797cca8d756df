//! `encspec run` with a live slave at a serial line: the same verdicts as on the virtual bus, the destinations of all frames, missing
//! consents, and disturbances of the bus.
//!
//! The line is a pseudoterminal. A test that inspects or changes bytes relays them between master and slave.

use crate::common::program::{self, ServeProcess};
use crate::{table, tests};
use controllers::profibus_dp::{MasterSettings, ProfibusMaster};
use encspec::live::fdl::FdlFrames;
use libtest_mimic::Trial;
use link::serial::pty;
use link::{Serial, SerialBus, SerialSettings};
use serde_json::Value;
use station::Time;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;
use testing::Folder;
use testing::stall::retry_check_on_stall;
use wire::profibus::fdl::{BaudRate, FdlFrame, FdlPiece, RequestFunction, Splitter, StartDelimiter};

const EVERYTHING: &str = "consent: { set_address: true, lock_address: true, nvm_write: 10000, position_reference: true, factory_reset: true, set_name: true }";
const AMT58: (&str, &str, u8) = ("datalogic-amt58-profibus", "hm5816-16384", 8);
const A3M60: (&str, &str, u8) = ("sick-a3m60-profibus", "a3m60", 5);

pub fn trials() -> Vec<Trial> {
    let mut trials = table![a_live_slave_has_the_verdicts_of_the_virtual_bus:
        telegrams_first_half(A3M60, "/telegrams/", "1/2"),
        telegrams_second_half(A3M60, "/telegrams/", "2/2"),
        parameters(AMT58, "/set-prm/", "1/1"),
    ];
    trials.extend(table![frames_go_to_the_device_except_tokens_fdl_status_and_global_control:
        first_third("1/3"),
        second_third("2/3"),
        last_third("3/3"),
    ]);
    trials.extend(table![a_bus_that_differs_from_the_bench_file_is_refused:
        no_slave("line: { address: 9 }", "no slave answers at station 9; there are stations at 8; set the address in a bench file"),
        master("line: { address: 2 }", "the device has the address 2 of one of our masters"),
        address_in_use("line: { address: 9, masters: [1, 8] }", "has the address 8 of our second master"),
    ]);
    trials.extend(table![cases_without_consent_are_not_applicable:
        address("consent: { nvm_write: 100 }", "not-taken", "the bench gives no consent to `set_address`"),
        memory("consent: { set_address: true }", "not-taken", "the bench gives no consent to `nvm_write`"),
        lock("consent: { set_address: true, nvm_write: 100 }", "never-locked[one]", "the bench gives no consent to `lock_address`"),
    ]);
    trials.extend(table![an_answer_in_time_that_is_wrong_fails:
        to_another_station(|octets| rewritten(octets, |da, _, _| *da = 3), "an answer from station 8 to 3"),
        from_another_station(|octets| rewritten(octets, |_, sa, _| *sa = 9), "an answer from station 9 to 1"),
        of_another_length(|octets| rewritten(octets, |_, _, data| data.push(0)), "Data_Exchange: data_low: "),
        with_a_wrong_length_field(miscounted, "because of the device: Data_Exchange: the answer does not fit"),
    ]);
    trials.extend(tests![
        a_late_answer_is_inconclusive,
        a_trial_with_a_late_answer_is_repeated,
        noise_on_the_line_is_inconclusive,
        a_line_that_holds_answers_back_is_inconclusive,
        cases_that_count_bit_times_are_not_applicable,
        a_bus_with_another_master_is_not_used,
        a_silent_bus_is_discovered_with_questions_only,
        a_bus_in_use_is_only_listened_to,
        a_bench_file_for_a_slave_is_written_and_runs,
        the_link_must_fit_the_bus,
    ]);
    trials
}

/// Verdict and reason of each case and rule.
type CaseVerdicts = BTreeMap<String, (String, String)>;

/// A folder with a bench file and the path of a line.
struct SerialBench {
    folder: Folder,
    manual: &'static str,
    variant: &'static str,
    address: String,
}

impl SerialBench {
    fn new((manual, variant, address): (&'static str, &'static str, u8)) -> SerialBench {
        let folder = Folder::new("serial");
        SerialBench { folder, manual, variant, address: address.to_string() }
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    /// Serves the reference device; `line` is `--pty` or `--serial` with its path.
    fn serve(&self, line: [&str; 2]) -> ServeProcess {
        let model = format!("model:{}/{}", self.manual, self.variant);
        let control = self.path("control");
        ServeProcess::start(&[&model, line[0], line[1], "--address", &self.address, "--control", &control])
    }

    /// Runs the cases that the arguments `what` select on the line `link`, with the further lines `more` in the bench file.
    fn run(&self, link: &str, more: &str, what: &[&str]) -> (Option<i32>, CaseVerdicts, String) {
        let suites = testing::workspace().join("suites").join(self.manual);
        let gsd = std::fs::read_dir(suites).expect("the suite").flatten().map(|entry| entry.path());
        let gsd = gsd.filter(|path| path.extension().is_some_and(|end| end == "gsd"));
        let gsd = gsd.map(|path| path.display().to_string()).find(|path| path.contains(self.variant)).expect("its GSD");
        let text = format!("device: {}/{}\nlink: serial:{link}\ngsd: {gsd}\n{more}\n", self.manual, self.variant);
        std::fs::write(self.folder.join("bench.yaml"), text).expect("the bench file");
        self.call(&[&["run", "--dut", "bench.yaml"], what].concat())
    }

    /// The same with all consents and a stand with all abilities.
    fn run_unrestricted(&self, link: &str, what: &[&str]) -> (Option<i32>, CaseVerdicts, String) {
        let stand = format!("stand: {{ control: {}, shaft: [position(±0), speed(±0)] }}", self.path("control"));
        self.run(link, &format!("{stand}\n{EVERYTHING}"), what)
    }

    fn call(&self, arguments: &[&str]) -> (Option<i32>, CaseVerdicts, String) {
        let report = self.folder.join("run.json");
        let _ = std::fs::remove_file(&report);
        let said = program::encspec(
            &self.folder,
            [arguments, &["--report", "json=run.json", "--no-evidence"]].concat().as_slice(),
        );
        let text = std::fs::read_to_string(&report).unwrap_or_default();
        let report: Value = serde_json::from_str(&text).unwrap_or_default();
        let cases = report["runs"][0]["cases"].as_array().cloned().unwrap_or_default();
        let of = |case: &Value, key: &str| case[key].as_str().unwrap_or_default().to_owned();
        let cases = cases.iter().map(|case| (of(case, "id"), (of(case, "verdict"), of(case, "reason")))).collect();
        (said.status, cases, said.all())
    }
}

/// Cases with a different verdict are run again if the host stalled, since the harness or the slave may have been late.
fn a_live_slave_has_the_verdicts_of_the_virtual_bus(
    device: (&'static str, &'static str, u8),
    filter: &str,
    part: &str,
) {
    let bench = SerialBench::new(device);
    let line = bench.path("line");
    let _serving = bench.serve(["--pty", &line]);
    let model = format!("model:{}/{}", bench.manual, bench.variant);
    let what = [filter, "--part", part];
    let (_, expected, _) = bench.call(&[&["run", "--dut", &model], &what[..]].concat());
    assert!(expected.len() > 5, "{expected:?}");
    let mut open: BTreeMap<&String, &(String, String)> = expected.iter().collect();
    let mut not_timed = 0;
    retry_check_on_stall(|| {
        let (_, observed, said) = bench.run_unrestricted(&line, &what);
        let mut is_as_expected = |id: &String, expected: &(String, String)| match observed.get(id) {
            // Cases that count bit times run on the virtual bus only.
            Some((_, why)) if why == "link cannot time bits" => {
                not_timed += 1;
                true
            }
            Some((verdict, _)) => *verdict == expected.0,
            None => false,
        };
        open.retain(|id, expected| !is_as_expected(id, expected));
        if open.is_empty() { Ok(()) } else { Err(format!("expected {open:#?}, observed {observed:#?}: {said}")) }
    });
    assert!(not_timed < 5, "{not_timed} cases count bit times");
}

fn cases_without_consent_are_not_applicable(consent: &str, case: &str, reason: &str) {
    let bench = SerialBench::new(AMT58);
    let line = bench.path("line");
    let _serving = bench.serve(["--pty", &line]);
    let stand = format!("stand: {{ control: {} }}", bench.path("control"));
    let (status, cases, said) = bench.run(&line, &format!("{stand}\n{consent}"), &[&format!("slave-address/{case}")]);
    assert_eq!(status, Some(1), "nothing passed, so the run is red: {said}");
    assert!(!cases.is_empty(), "{said}");
    let expected = ("not-applicable".to_owned(), reason.to_owned());
    assert!(cases.values().all(|case| *case == expected), "{cases:?}");
}

fn cases_that_count_bit_times_are_not_applicable() {
    let bench = SerialBench::new(A3M60);
    let line = bench.path("line");
    let _serving = bench.serve(["--pty", &line]);
    let (_, cases, _) = bench.run_unrestricted(&line, &["slave-start-up/rate-of-the-bus"]);
    assert!(!cases.is_empty());
    let expected = ("not-applicable".to_owned(), "link cannot time bits".to_owned());
    assert!(cases.values().all(|case| *case == expected), "{cases:?}");
}

/// A line in two parts with a relay between them.
struct LineRelay {
    /// The end of the harness.
    ours: PathBuf,
    /// The end of the slave.
    theirs: PathBuf,
    /// The bytes that the harness has sent.
    sent: Arc<Mutex<Vec<u8>>>,
    _open: [Serial; 2],
}

/// Decides what happens to bytes from the slave.
type RelayFilter = Box<dyn FnMut(&[u8]) -> RelayAction + Send>;

/// What happens to bytes from the slave.
enum RelayAction {
    /// These bytes are forwarded.
    Now(Vec<u8>),
    /// The bytes are forwarded after the next token of the harness.
    Later,
}

fn relay(mut change: RelayFilter) -> LineRelay {
    let (left, ours) = pty::open().expect("there are pseudoterminals");
    let (right, theirs) = pty::open().expect("there are pseudoterminals");
    // A pseudoterminal echoes until it is opened as a serial line.
    let open = |path: &Path| Serial::open(path, &SerialSettings::new(1_500_000)).expect("the other end");
    let held = [open(&ours), open(&theirs)];
    let sent: Arc<Mutex<Vec<u8>>> = Arc::default();
    let late: Arc<Mutex<Vec<u8>>> = Arc::default();
    let copy = |file: &File| file.try_clone().expect("a copy");
    let (mut from, mut to, mut back) = (copy(&left), copy(&right), copy(&left));
    let (log, waiting) = (Arc::clone(&sent), Arc::clone(&late));
    thread::spawn(move || {
        let mut octets = [0; 1024];
        while let Ok(count @ 1..) = from.read(&mut octets) {
            log.lock().expect("a log").extend_from_slice(&octets[..count]);
            to.write_all(&octets[..count]).expect("it takes them");
            // No station is polled directly after a token, so an answer there is certainly late.
            if octets[0] == StartDelimiter::SD4.0 {
                back.write_all(&std::mem::take(&mut *waiting.lock().expect("octets"))).expect("it takes them");
            }
        }
    });
    let (mut from, mut to) = (right, left);
    thread::spawn(move || {
        let mut octets = [0; 1024];
        while let Ok(count @ 1..) = from.read(&mut octets) {
            match change(&octets[..count]) {
                RelayAction::Now(octets) => to.write_all(&octets).expect("it takes them"),
                RelayAction::Later => late.lock().expect("octets").extend_from_slice(&octets[..count]),
            }
        }
    });
    LineRelay { ours, theirs, sent, _open: held }
}

/// Forwards everything unchanged.
fn unchanged() -> RelayFilter {
    Box::new(|octets| RelayAction::Now(octets.to_vec()))
}

/// The number of the Data_Exchange answer that is disturbed in each trial, after its start-up.
const DISTURBED: usize = 8;

/// Forwards everything unchanged except one Data_Exchange answer (without SAPs, to the first master) in each trial.
fn disturbed(disturb: fn(&[u8]) -> RelayAction) -> RelayFilter {
    let mut exchanged = 0;
    Box::new(move |octets| {
        match octets {
            [0x68, _, _, 0x68, 1, 8, ..] => exchanged += 1,
            // The slave acknowledges parameters or configuration: a new start-up.
            [0xE5] => exchanged = 0,
            _ => {}
        }
        if exchanged == DISTURBED {
            exchanged += 1;
            return disturb(octets);
        }
        RelayAction::Now(octets.to_vec())
    })
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn frames_go_to_the_device_except_tokens_fdl_status_and_global_control(part: &str) {
    let bench = SerialBench::new(AMT58);
    let line = relay(unchanged());
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let (_, cases, said) = bench.run_unrestricted(text(&line.ours), &["/diagnosis/", "--part", part]);
    assert!(cases.len() > 10, "{said}");
    let mut splitter = Splitter::new();
    splitter.push(&line.sent.lock().expect("a log"));
    let mut counted: BTreeMap<&str, usize> = BTreeMap::new();
    while let Some(piece) = splitter.next_piece() {
        let FdlPiece::Frame(octets) = piece else { continue };
        let what = match FdlFrame::parse(&octets) {
            Ok(FdlFrame::Token { da: 1 | 2, sa: 1 | 2 }) => "token",
            Ok(FdlFrame::Data(frame)) if frame.fc.requested() == Some(RequestFunction::FDL_STATUS) => "fdl_status",
            Ok(FdlFrame::Data(frame)) if frame.da == 127 && frame.destination.sap == Some(58) => "control",
            Ok(FdlFrame::Data(frame)) if frame.da == 8 && matches!(frame.sa, 1 | 2) => "device",
            // The second master answers the FDL_Status request of the first.
            Ok(FdlFrame::Data(frame)) if !frame.fc.is_request() && (frame.sa, frame.da) == (2, 1) => "answer",
            other => panic!("{other:?} was sent"),
        };
        *counted.entry(what).or_default() += 1;
    }
    // Every other address gets an FDL_Status request and, without an answer, a retry.
    assert!(counted["fdl_status"] >= 2 * 125, "{counted:?}");
    assert!(counted["device"] > 100 && counted["token"] > 100 && counted["control"] > 0, "{counted:?}");
}

/// One answer in each trial arrives after the request was repeated and answered.
fn a_late_answer_is_inconclusive() {
    let bench = SerialBench::new(AMT58);
    let line = relay(disturbed(|_| RelayAction::Later));
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let what = ["preset/binary-value", "--stall-repeats", "1"];
    let (status, cases, said) = bench.run_unrestricted(text(&line.ours), &what);
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("repeated 1 time, because"), "{said}");
    let says_so = |(verdict, why): &(String, String)| verdict == "inconclusive" && why.contains("may be a late answer");
    assert!(cases.values().any(says_so), "{cases:#?}");
    assert!(cases.values().all(|(verdict, _)| verdict != "fail"), "{cases:#?}");
}

fn a_trial_with_a_late_answer_is_repeated() {
    let bench = SerialBench::new(AMT58);
    let mut is_late = disturbed(|_| RelayAction::Later);
    let mut was_late = false;
    let line = relay(Box::new(move |octets| match is_late(octets) {
        RelayAction::Later if was_late => RelayAction::Now(octets.to_vec()),
        action => {
            was_late |= matches!(action, RelayAction::Later);
            action
        }
    }));
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let (status, cases, said) = bench.run_unrestricted(text(&line.ours), &["preset/binary-value[0x00000000]"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(cases.values().all(|(verdict, _)| verdict == "pass"), "{cases:#?}");
    assert!(said.contains("  stalls        1 repetition of 1 case"), "{said}");
}

fn noise_on_the_line_is_inconclusive() {
    let bench = SerialBench::new(AMT58);
    let line = relay(disturbed(|octets| RelayAction::Now([&[0xFF, 0x00, 0xFF], octets].concat())));
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let (status, cases, said) =
        bench.run_unrestricted(text(&line.ours), &["preset/binary-value", "--stall-repeats", "0"]);
    assert_eq!(status, Some(1), "{said}");
    let says_so =
        |(verdict, why): &(String, String)| verdict == "inconclusive" && why.contains("the line is disturbed");
    assert!(cases.values().any(says_so), "{cases:#?}");
    assert!(cases.values().all(|(verdict, _)| verdict != "fail"), "{cases:#?}");
}

/// The line delivers the answers to three cycles, each requested twice, only after the master has given them up.
fn a_line_that_holds_answers_back_is_inconclusive() {
    let bench = SerialBench::new(AMT58);
    let (mut exchanged, mut held) = (0, 0);
    let line = relay(Box::new(move |octets| {
        match octets {
            [0x68, _, _, 0x68, 1, 8, ..] => exchanged += 1,
            [0xE5] => (exchanged, held) = (0, 0),
            _ => {}
        }
        if exchanged >= DISTURBED && held < 6 {
            held += 1;
            return RelayAction::Later;
        }
        RelayAction::Now(octets.to_vec())
    }));
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let what = ["preset/binary-value", "--stall-repeats", "0"];
    let (status, cases, said) = bench.run_unrestricted(text(&line.ours), &what);
    assert_eq!(status, Some(1), "{said}");
    let says_so = |(verdict, why): &(String, String)| verdict == "inconclusive" && why.contains("late answer");
    assert!(cases.values().any(says_so), "{cases:#?}");
    assert!(cases.values().all(|(verdict, _)| verdict != "fail"), "{cases:#?}");
}

/// A Data_Exchange answer (SD2 without access points) whose stations and data `change` has changed, with its length and checksum right.
fn rewritten(octets: &[u8], change: fn(&mut u8, &mut u8, &mut Vec<u8>)) -> Vec<u8> {
    let [0x68, _, _, 0x68, da, sa, function, data @ .., _, 0x16] = octets else { panic!("no answer: {octets:02X?}") };
    let (mut da, mut sa, mut data) = (*da, *sa, data.to_vec());
    change(&mut da, &mut sa, &mut data);
    let length = data.len() as u8 + 3;
    let body = [&[da, sa, *function][..], &data].concat();
    let sum = body.iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
    [&[0x68, length, length, 0x68][..], &body, &[sum, 0x16]].concat()
}

/// The same answer with a length that is one too high in both fields.
fn miscounted(octets: &[u8]) -> Vec<u8> {
    let mut octets = octets.to_vec();
    (octets[1], octets[2]) = (octets[1] + 1, octets[2] + 1);
    octets
}

/// The first Data_Exchange answer that is changed, after the start-up and what is given.
const WRONG_FROM: usize = 20;

/// From a Data_Exchange answer in the test of a trial on, every one of them is changed.
fn an_answer_in_time_that_is_wrong_fails(change: fn(&[u8]) -> Vec<u8>, why: &str) {
    let bench = SerialBench::new(AMT58);
    let mut exchanged = 0;
    let line = relay(Box::new(move |octets| {
        match octets {
            [0x68, _, _, 0x68, 1, 8, ..] => exchanged += 1,
            [0xE5] => exchanged = 0,
            _ => return RelayAction::Now(octets.to_vec()),
        }
        RelayAction::Now(if exchanged >= WRONG_FROM { change(octets) } else { octets.to_vec() })
    }));
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let what = ["preset/binary-value[0x00000000]", "--stall-repeats", "0"];
    let (status, cases, said) = bench.run_unrestricted(text(&line.ours), &what);
    assert_eq!(status, Some(1), "{said}");
    let says_so = |(verdict, reason): &(String, String)| verdict == "fail" && reason.contains(why);
    assert!(cases.values().any(says_so), "{cases:#?}");
}

/// Runs the master 4 at the other end of a line, until the line is gone.
fn run_master_4(theirs: PathBuf) {
    thread::spawn(move || {
        let serial = Serial::open(&theirs, &SerialSettings::new(1_500_000)).expect("the other end");
        let mut bus = SerialBus::new(serial, Box::<FdlFrames>::default());
        let mut master = ProfibusMaster::new(MasterSettings::new(4, BaudRate(1_500_000)));
        while bus.step(&mut [&mut master], Time::MAX, &mut |_| true, &mut |_| ()).is_ok() {}
    });
}

fn a_bus_with_another_master_is_not_used() {
    let bench = SerialBench::new(AMT58);
    let line = relay(unchanged());
    run_master_4(line.theirs.clone());
    let (status, cases, said) = bench.run(text(&line.ours), "", &["preset/binary-value"]);
    assert_eq!((status, cases.len()), (Some(3), 0), "{said}");
    assert!(said.contains("is in use: received a token from station 4 to station 4"), "{said}");
    let sent = line.sent.lock().expect("a log");
    assert!(sent.is_empty(), "frames were sent: {sent:02X?}");
}

fn a_silent_bus_is_discovered_with_questions_only() {
    let bench = SerialBench::new(AMT58);
    let line = relay(unchanged());
    let _serving = bench.serve(["--serial", text(&line.theirs)]);
    let said = program::encspec(&bench.folder, &["discover", "--serial", text(&line.ours), "--format", "json"]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    let listing: Value = serde_json::from_str(&said.out).expect("JSON");
    let stations = listing["stations"].as_array().expect("a list");
    assert_eq!(stations.len(), 1, "{listing}");
    // The ident number that the manual prints; a slave without parameters requests them.
    assert_eq!((&stations[0]["address"], &stations[0]["ident"]), (&8.into(), &0x1655.into()), "{listing}");
    assert_eq!(stations[0]["suite"], "datalogic-amt58-profibus");
    assert!(stations[0]["status"].as_array().expect("words").contains(&"prm_req".into()), "{listing}");
    assert_eq!((&listing["received"]["frames"], &stations[0]["master"]), (&0.into(), &Value::Null), "{listing}");
    let mut splitter = Splitter::new();
    splitter.push(&line.sent.lock().expect("a log"));
    let mut asked = std::collections::BTreeSet::new();
    while let Some(piece) = splitter.next_piece() {
        let FdlPiece::Frame(octets) = piece else { panic!("{piece:?} was sent") };
        match FdlFrame::parse(&octets) {
            Ok(FdlFrame::Token { .. }) => {}
            Ok(FdlFrame::Data(frame)) if frame.fc.requested() == Some(RequestFunction::FDL_STATUS) => {
                asked.insert(frame.da);
            }
            Ok(FdlFrame::Data(frame)) if frame.da == 8 && frame.destination.sap == Some(60) => {}
            other => panic!("{other:?} was sent"),
        }
    }
    assert_eq!(asked.into_iter().collect::<Vec<_>>(), (0..=126).collect::<Vec<_>>());
}

fn a_bus_in_use_is_only_listened_to() {
    let bench = SerialBench::new(AMT58);
    let line = relay(unchanged());
    run_master_4(line.theirs.clone());
    let said = program::encspec(&bench.folder, &["discover", "--serial", text(&line.ours)]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    for what in ["is in use; received in 1.0 s:", "master 4, ", " tokens", "token rotation ", "Nothing was sent."] {
        assert!(said.out.contains(what), "{what}: {}", said.all());
    }
    let said = program::encspec(&bench.folder, &["bench", "init", "--serial", text(&line.ours), "-o", "new.yaml"]);
    assert_eq!(said.status, Some(3), "{}", said.all());
    assert!(said.all().contains("Nothing was sent."), "{}", said.all());
    assert!(!bench.folder.join("new.yaml").exists());
    let sent = line.sent.lock().expect("a log");
    assert!(sent.is_empty(), "frames were sent: {sent:02X?}");
}

fn a_bench_file_for_a_slave_is_written_and_runs() {
    let bench = SerialBench::new(AMT58);
    let line = bench.path("line");
    let _serving = bench.serve(["--pty", &line]);
    let said = program::encspec(&bench.folder, &["bench", "init", "--serial", &line, "-o", "new.yaml"]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    let written = std::fs::read_to_string(bench.folder.join("new.yaml")).expect("the bench file");
    assert!(written.contains("\ndevice: datalogic-amt58-profibus/"), "{written}");
    assert!(written.contains("\n  address: 8\n  masters: [1, 2]"), "{written}");
    let (status, cases, said) = bench.call(&["run", "--dut", "new.yaml", "/diagnosis/", "--part", "1/40"]);
    assert!(matches!(status, Some(0 | 1)) && !cases.is_empty(), "{said}");
}

fn a_bus_that_differs_from_the_bench_file_is_refused(more: &str, why: &str) {
    let bench = SerialBench::new(AMT58);
    let line = bench.path("line");
    let _serving = bench.serve(["--pty", &line]);
    let (status, cases, said) = bench.run(&line, more, &["preset/binary-value"]);
    assert_eq!((status, cases.len()), (Some(3), 0), "{said}");
    assert!(said.contains(why), "{said}");
}

fn the_link_must_fit_the_bus() {
    let bench = SerialBench::new(AMT58);
    let device = format!("{}/{}", bench.manual, bench.variant);
    let (status, _, said) = bench.call(&["run", "--dut", "nic:eth1", "--device", &device]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("is a PROFIBUS device; its link is `serial:TTY`, not nic:eth1"), "{said}");
    let (status, _, said) =
        bench.call(&["run", "--dut", "serial:/dev/ttyUSB0", "--device", "lika-xac77-profinet/xac7718"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("is a PROFINET device; its link is `nic:IF` or `socket:ADDRESS`"), "{said}");
}
