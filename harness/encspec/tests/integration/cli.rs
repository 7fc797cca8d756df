//! The command line: output, error messages and exit status.

use crate::common::program::{command, encspec};
use rstest::rstest;
use std::fs;
use std::io::Read;
use std::path::PathBuf;
use std::process::Stdio;
use testing::Folder;

const MANUAL: &str = "lika-xac77-profinet";
const MODEL: &str = "model:lika-xac77-profinet/xac7718";

#[rstest]
#[case::filter(&["run", "presett"], "no case or rule id contains `presett`; did you mean `preset`?")]
#[case::exact(&["run", "preset/absolut", "--exact"], "did you mean `preset/absolute`?")]
#[case::exact_alone(&["run", "--exact"], "--exact")]
#[case::kind(&["run", "--dut", "modle:x"], "did you mean `model:`?")]
#[case::device(&["run", "--dut", "model:lika-xac78-profinet"], "did you mean `lika-xac77-profinet`?")]
#[case::variant(&["run", "--dut", "model:lika-xac77-profinet/xac7719"], "did you mean `xac7718`?")]
#[case::null(&["run", "--dut", "null:silnet", "--device", MANUAL], "did you mean `silent`?")]
#[case::null_without_device(&["run", "--dut", "null:silent"], "needs `--device MANUAL[/VARIANT]`")]
#[case::claimed_twice(&["run", "--dut", MODEL, "--device", MANUAL], "remove `--device`")]
#[case::bug(&["run", "--bug", "preset-on-fallling-edge"], "did you mean `preset-on-falling-edge`?")]
#[case::bug_of_the_field(&["run", "--bug", "tag-neded"], "did you mean `tag-needed`?")]
#[case::bug_of_a_null_device(
    &["run", "--dut", "null:silent", "--device", MANUAL, "--bug", "preset-on-falling-edge"],
    "only reference devices"
)]
#[case::format(&["run", "--report", "jsn=a"], "did you mean `json`?")]
#[case::format_without_file(&["run", "--report", "json"], "FORMAT=FILE")]
#[case::report_nowhere(&["run", "--report", "json=no/such/folder/a.json"], "no/such/folder/a.json cannot be written")]
#[case::persona(&["run", "--persona", "advanced-fats"], "unknown persona `advanced-fats`; did you mean `advanced-fast`?")]
#[case::gate(&["run", "--gate", "most"], "must")]
#[case::ledger(&["run", "--ledger", "nowhere.yaml"], "nowhere.yaml cannot be read")]
#[case::suites(&["run", "--suites", "nowhere"], "nowhere")]
#[case::manual(&["list", "lika-xac78-profinet"], "did you mean `lika-xac77-profinet`?")]
#[case::requirement(&["list", "XAC77-PRE-0011"], "did you mean `XAC77-PRE-001`?")]
#[case::excluded(&["run", "!presett"], "no case or rule id contains `presett`; did you mean `preset`?")]
#[case::nothing_left(&["run", "preset/", "!lika", "!sick", "!kuebler", "!datalogic", "!dp-encoder", "!profidrive-encoder"], "the filters leave no case and no rule")]
#[case::no_last_run(&["run", "--failed"], "--failed: encspec-evidence/last-run.json: No such file")]
#[case::coverage(&["coverage", "lika-xac77"], "there is no manual `lika-xac77`")]
#[case::no_suites(&["list", "--suites", "."], "there is no suite here")]
#[case::explain(&["explain", "XAC77-PRE-0011"], "did you mean `XAC77-PRE-001`?")]
#[case::check(&["check", "nowhere"], "nowhere")]
#[case::replay(&["replay", "nowhere.pcap"], "nowhere.pcap")]
#[case::replay_time(&["replay", "a.pcap", "--from", "yesterday"], "write seconds since the first frame")]
#[case::replay_severity(&["replay", "a.pcap", "--severity", "bad"], "error, warning, info")]
#[case::replay_variant(&["replay", "a.pcap", "--device", "lika-xac77-profinet/xac7719"], "did you mean `xac7718`?")]
#[case::dissect(&["dissect", "nowhere.pcap"], "nowhere.pcap")]
#[case::replay_nothing(&["replay"], "<FILE>")]
#[case::command(&["coverge"], "'coverage'")]
fn a_usage_error_is_reported(#[case] arguments: &[&str], #[case] says: &str) {
    let folder = Folder::new(&format!("mistake-{}", arguments.join("-").replace(['/', ':', ' '], "_")));
    let said = encspec(&folder, arguments);
    assert_eq!(said.status, Some(2), "{}", said.err);
    assert!(said.err.contains(says), "{}", said.err);
    assert_eq!(said.out, "");
    assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 0, "no file is created");
}

#[rstest]
#[case::interface("nic:nowhere-at-all", 3, "nowhere-at-all")]
#[case::port("socket:127.0.0.1:1", 3, "127.0.0.1:1")]
#[case::path("socket:/nowhere/wire", 3, "/nowhere/wire")]
#[case::no_address("socket:nowhere", 3, "socket:nowhere")]
#[case::serial("serial:/dev/ttyUSB0", 2, "is a PROFINET device; its link is `nic:IF`")]
#[case::file("nowhere.yaml", 2, "remove `--device`")]
fn an_unusable_bench_is_reported(#[case] dut: &str, #[case] status: i32, #[case] says: &str) {
    let variant = format!("{MANUAL}/xac7718");
    let said = encspec(Folder::new("not-usable"), &["run", "--dut", dut, "--device", &variant]);
    assert_eq!(said.status, Some(status), "{}", said.err);
    assert!(said.err.contains(says), "{}", said.err);
}

#[rstest]
#[case::nothing(&["run", "--dut", "nic:nowhere"], "needs `--device MANUAL/VARIANT`")]
#[case::variant(&["run", "--dut", "nic:nowhere", "--device", MANUAL], "several variants")]
#[case::file(&["run", "--dut", "nowhere.yaml"], "nowhere.yaml")]
#[case::part(&["run", "--part", "9/8"], "not a part")]
fn an_incomplete_live_device_is_reported(#[case] arguments: &[&str], #[case] says: &str) {
    let said = encspec(Folder::new("said"), arguments);
    assert_eq!(said.status, Some(2), "{}", said.err);
    assert!(said.err.contains(says), "{}", said.err);
}

#[test]
fn a_device_in_use_by_another_process_is_reported() {
    let folder = Folder::new("in-use");
    let device = format!("nic:test-{}", std::process::id());
    let variant = format!("{MANUAL}/xac7718");
    let lock = encspec::lock::Lock::take(&device, &std::env::temp_dir(), std::time::Duration::ZERO, &mut |_| {});
    let lock = lock.expect("the device is free");
    let run = |wait: &str| encspec(&folder, &["run", "--dut", &device, "--device", &variant, "--lock-wait", wait]);
    let held = run("0");
    assert_eq!(held.status, Some(3), "{}", held.err);
    assert!(held.err.contains(&format!("in use by process {}", std::process::id())), "{}", held.err);
    assert!(!held.err.contains("interface"), "{}", held.err);
    drop(lock);
    // A process that another test starts may hold the file between its fork and its exec.
    let free = run("30");
    assert!(free.err.contains("interface"), "{}", free.err);
}

/// The words of each command below `above` that has no others below it, and its help.
fn helps_below(folder: &Folder, above: &[&str]) -> Vec<(String, String)> {
    let help = encspec(folder, &[above, &["--help"]].concat());
    assert_eq!(help.status, Some(0), "{}", help.err);
    let listed = help.out.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // A description that goes on in the next line is indented more.
    let names = listed.filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    let names = names.filter_map(|line| line.split(' ').next()).filter(|name| *name != "help");
    let below: Vec<_> = names.flat_map(|name| helps_below(folder, &[above, &[name]].concat())).collect();
    if below.is_empty() { vec![(above.join(" "), help.out)] } else { below }
}

#[test]
fn each_command_has_help_with_examples_that_it_understands() {
    let folder = Folder::new("help");
    let helps = helps_below(&folder, &[]);
    assert!(helps.len() > 25, "{helps:?}");
    for (command, help) in &helps {
        assert!(help.contains("Usage: encspec"), "{help}");
        let begin = format!("encspec {command}");
        let example = help.lines().map(|line| line.trim_start_matches("Example: ").trim_start());
        let examples: Vec<&str> = example.filter(|line| line.starts_with(&begin)).collect();
        assert!(help.contains("\nExample") && !examples.is_empty(), "{begin} has no example:\n{help}");
        for example in examples {
            // The shell takes what follows `>`; `--help` ends a command whose words are right, but is one more word of `control`.
            let words = example.split(" > ").next().unwrap_or(example).split(' ').skip(1).chain(["--help"]);
            let understood = encspec(&folder, &words.collect::<Vec<_>>());
            assert_ne!(understood.status, Some(2), "{example}: {}", understood.err);
        }
    }
    assert!(encspec(&folder, &["--help"]).out.contains("Exit status: 0"));
}

/// Copies the built-in suites and changes one file.
fn changed_suites(name: &str, file: &str, change: (&str, &str)) -> (Folder, PathBuf) {
    let folder = Folder::new(name);
    let suites = folder.join("suites");
    let shipped = testing::workspace().join("suites");
    let entries = fs::read_dir(shipped).expect("the shipped suites").map(|entry| entry.expect("an entry").path());
    for manual in entries.filter(|path| path.is_dir()) {
        let copy = suites.join(manual.file_name().expect("a name"));
        fs::create_dir_all(&copy).expect("a folder");
        for file in fs::read_dir(&manual).expect("a manual").map(|entry| entry.expect("an entry").path()) {
            fs::copy(&file, copy.join(file.file_name().expect("a name"))).expect("a copy");
        }
    }
    let path = suites.join(MANUAL).join(file);
    let text = fs::read_to_string(&path).expect("the file");
    let changed = text.replacen(change.0, change.1, 1);
    assert_ne!(changed, text, "the change must have an effect");
    fs::write(&path, changed).expect("the changed file");
    (folder, suites)
}

const CHECKS: &str = "      - expect: { G1_ZSW.home_position_executed: 1, G1_XIST1: 0x00012345 }\n";

#[rstest]
#[case::misspelt_key("preset.yaml", ("\n    covers:", "\n    cover:"), "unknown key of a case `cover`")]
#[case::unknown_signal("preset.yaml", ("G1_ZSW.home_position_executed: 1", "G1_ZWS.home_position_executed: 1"), "G1_ZSW")]
#[case::no_checks(
    "preset.yaml",
    ("cases:\n", "cases:\n  - id: empty\n    why: It checks nothing.\n    covers: [XAC77-PRE-001]\n    steps: [ { set: { G1_STW.park: 1 } } ]\n\n"),
    "checks nothing"
)]
#[case::wrong_type("preset.yaml", (CHECKS, "      - expect: { G1_ZSW.home_position_executed: 2 }\n"), "preset.yaml")]
fn an_error_in_a_suite_is_reported(#[case] file: &str, #[case] change: (&str, &str), #[case] says: &str) {
    let name = format!("suite-{}", says.replace([' ', '`', '.'], "-"));
    let (folder, suites) = changed_suites(&name, file, change);
    let suites = suites.display().to_string();
    for arguments in [vec!["run", "--suites", &suites], vec!["check", &suites], vec!["list", "--suites", &suites]] {
        let said = encspec(&folder, &arguments);
        assert_eq!(said.status, Some(2), "{arguments:?}: {}", said.err);
        assert!(said.err.contains(says), "{}", said.err);
        assert!(said.err.contains(&format!("{file}:")), "file, line and column are missing: {}", said.err);
        assert!(said.err.contains("\n   | "), "the line is missing: {}", said.err);
        assert_eq!(said.out, "");
    }
}

#[test]
fn check_takes_a_folder_a_manual_or_a_file() {
    let (folder, suites) = changed_suites("check-paths", "preset.yaml", ("cases:\n", "# a remark\ncases:\n"));
    for path in [suites.clone(), suites.join(MANUAL), suites.join(MANUAL).join("preset.yaml"), suites.join("common")] {
        let said = encspec(&folder, &["check", &path.display().to_string()]);
        assert_eq!(said.status, Some(0), "{}: {}", path.display(), said.err);
        assert!(said.out.contains("no errors"), "{}", said.out);
    }
}

#[test]
fn the_built_in_suites_are_those_of_the_folder() {
    let folder = Folder::new("same-suites");
    let suites = testing::workspace().join("suites").display().to_string();
    let built_in = encspec(&folder, &["list", "--format", "json"]);
    let from_folder = encspec(&folder, &["list", "--format", "json", "--suites", &suites]);
    assert_eq!(
        built_in.out.replace(&format!("{suites}/"), "suites/"),
        from_folder.out.replace(&format!("{suites}/"), "suites/")
    );
}

#[test]
fn a_truncated_capture_is_read_up_to_the_damage() {
    let folder = Folder::new("truncated");
    encspec(&folder, &["run", "preset/held-request", "--dut", MODEL, "--record", "captures"]);
    let whole =
        fs::read_dir(folder.join("captures")).expect("a capture").next().expect("a capture").expect("an entry").path();
    let octets = fs::read(&whole).expect("the capture");
    fs::write(folder.join("cut.pcapng"), &octets[..octets.len() - 7]).expect("a shorter capture");
    let said = encspec(&folder, &["replay", "cut.pcapng", "--report", "json=-"]);
    assert_eq!(said.status, Some(2), "{}", said.err);
    assert_eq!(said.err.lines().count(), 1, "one clear message: {}", said.err);
    assert!(said.err.contains("cut.pcapng is damaged at byte"), "{}", said.err);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    let capture = &report["captures"][0];
    assert!(capture["frames"].as_u64() > Some(10), "{capture:#}");
    assert_eq!(capture["damage"].as_array().map(Vec::len), Some(1));
    let dissected = encspec(&folder, &["dissect", "cut.pcapng"]);
    assert_eq!(dissected.status, Some(2));
    assert!(dissected.out.lines().count() > 10);
}

#[test]
fn an_invalid_capture_does_not_stop_the_others() {
    let folder = Folder::new("no-capture");
    encspec(&folder, &["run", "preset/held-request", "--dut", MODEL, "--record", "."]);
    let good = fs::read_dir(&folder).expect("the folder").next().expect("a capture").expect("an entry").path();
    fs::write(folder.join("text.pcap"), "this is no capture").expect("a text");
    let good = good.file_name().expect("a name").to_string_lossy().into_owned();
    let said = encspec(&folder, &["replay", "text.pcap", &good]);
    assert_eq!(said.status, Some(2));
    assert!(said.err.contains("text.pcap"), "{}", said.err);
    assert!(said.out.contains(&good), "{}", said.out);
}

#[rstest]
#[case(&["run", "--dut", MODEL])]
#[case(&["run", "--dut", MODEL, "-v"])]
#[case(&["list"])]
#[case(&["list", "--format", "json"])]
#[case(&["bugs"])]
#[case(&["bugs", "--format", "json"])]
#[case(&["errata"])]
#[case(&["errata", "--format", "json"])]
#[case(&["schema"])]
#[case(&["coverage"])]
fn a_closed_pipe_is_not_an_error(#[case] arguments: &[&str]) {
    let folder = Folder::new(&format!("pipe-{}", arguments.join("-").replace(['/', ':'], "_")));
    let mut child =
        command(folder.path(), arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary");
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut err).expect("UTF-8");
    assert_eq!(child.wait().expect("an end").code(), Some(0), "{err}");
    assert_eq!(err, "");
}

#[test]
fn a_bug_of_the_reference_device_is_reported() {
    let folder = Folder::new("bug");
    let arguments = ["run", "preset/absolute", "--exact", "--dut", MODEL, "--bug", "preset-adds-instead-of-assigns"];
    let whole: Vec<&str> = arguments.to_vec();
    let said = encspec(&folder, &whole);
    assert_eq!(said.status, Some(1), "{}{}", said.out, said.err);
    let needed = [
        "FAIL lika-xac77-profinet/preset/absolute (must)",
        "XAC77-PRE-010, section 10.1",
        "not held   G1_XIST1: 0x00012345",
        "expected 0x12345 (74565)",
        "observed 0x",
        "where      frame ",
        ", byte ",
        "Wireshark  frame.number == ",
        "blame      device",
        "trace ",
        "reproduce  encspec run --dut model:lika-xac77-profinet/xac7718 --bug preset-adds-instead-of-assigns \
         lika-xac77-profinet/preset/absolute --exact",
    ];
    for text in needed {
        assert!(said.out.contains(text), "`{text}` is not in:\n{}", said.out);
    }
    assert!(
        said.out.lines().last().expect("a last line").starts_with("Red: 1 result on 1 device: 1 fail"),
        "{}",
        said.out
    );
    let evidence = folder.join("encspec-evidence");
    let names: Vec<_> =
        fs::read_dir(&evidence).expect("the evidence").map(|entry| entry.expect("an entry").file_name()).collect();
    let captures = names.iter().filter(|name| name.to_string_lossy().ends_with(".pcapng")).count();
    assert_eq!((captures, names.len()), (1, 2), "a capture and the last run: {names:?}");
    let mut without: Vec<&str> = whole.clone();
    fs::remove_dir_all(&evidence).expect("the evidence");
    without.push("--no-evidence");
    assert_eq!(encspec(&folder, &without).status, Some(1));
    assert!(!evidence.exists());
}

/// A field bug, which no manual lists, is explained; a case fails with the persona that shows it and passes without.
#[test]
fn a_field_bug_is_found_with_a_persona() {
    let folder = Folder::new("field");
    let sentence = "Cyclic frames without a VLAN tag are ignored.";
    let base = ["run", "preset/absolute", "--exact", "--dut", MODEL, "--bug", "tag-needed", "--no-evidence"];
    let plain = encspec(&folder, &base);
    assert_eq!(plain.status, Some(0), "{}{}", plain.out, plain.err);
    let with_persona = encspec(&folder, &[&base[..], &["--persona", "untagged-rt"]].concat());
    assert_eq!(with_persona.status, Some(1), "{}{}", with_persona.out, with_persona.err);
    for said in [&plain, &with_persona] {
        assert!(said.out.contains(&format!("tag-needed: {sentence}")), "{}", said.out);
    }
    let explained = encspec(&folder, &["explain", "tag-needed"]);
    assert!(explained.status == Some(0) && explained.out.contains(sentence), "{}{}", explained.out, explained.err);
}

#[test]
fn the_ledger_excuses_exactly_the_failure_that_it_describes() {
    let folder = Folder::new("ledger");
    let id = format!("{MANUAL}/preset/absolute");
    let base = ["run", &id, "--exact", "--dut", MODEL, "--bug", "preset-adds-instead-of-assigns", "--no-evidence"];
    let with = |more: &[&str]| encspec(&folder, &[&base[..], more].concat());
    let json: serde_json::Value = serde_json::from_str(&with(&["--report", "json=-"]).out).expect("JSON");
    let signature = json["runs"][0]["cases"][0]["failure"]["signature"].as_str().expect("a signature").to_owned();
    let write = |signature: &str| {
        let signature = serde_json::Value::from(signature);
        let entry = format!(
            "known_failures:\n- test: preset/absolute\n  device: {MANUAL}\n  reason: It is so.\n  ticket: FW-7\n  \
             expires: 9999-12-31\n  signature: {signature}\n"
        );
        fs::write(folder.join("known.yaml"), entry).expect("the ledger");
    };
    write(&signature);
    let known = with(&["--ledger", "known.yaml"]);
    assert_eq!(known.status, Some(0), "{}{}", known.out, known.err);
    assert!(known.out.contains("1 xfail"), "{}", known.out);
    write("expect: something else");
    assert_eq!(with(&["--ledger", "known.yaml"]).status, Some(1));
    write(&signature);
    let fixed = encspec(&folder, &["run", &id, "--exact", "--dut", MODEL, "--ledger", "known.yaml", "--no-evidence"]);
    assert_eq!(fixed.status, Some(1));
    assert!(fixed.out.contains("xpass"), "{}", fixed.out);
}

#[test]
fn reports_go_to_files_and_to_standard_output() {
    let folder = Folder::new("reports");
    let files = ["json=a.json", "junit=a.xml", "tap=a.tap", "text=a.txt", "console=a.log"];
    let mut arguments = vec!["run", "preset", "--dut", MODEL];
    files.iter().for_each(|file| arguments.extend(["--report", file]));
    let said = encspec(&folder, &arguments);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.out.lines().last().is_some_and(|line| line.starts_with("Green: ")), "{}", said.out);
    let begins =
        [("a.json", "{"), ("a.xml", "<?xml"), ("a.tap", "TAP version 14\n1.."), ("a.txt", MANUAL), ("a.log", MODEL)];
    for (file, begin) in begins {
        let text = fs::read_to_string(folder.join(file)).expect("a report");
        assert!(text.starts_with(begin), "{file}: {text}");
    }
    let only = encspec(&folder, &["run", "preset", "--dut", MODEL, "--report", "json=-"]);
    assert_eq!(only.out, fs::read_to_string(folder.join("a.json")).expect("a report"), "the same bytes on every run");
}

#[test]
fn the_json_keys_of_coverage_are_stable() {
    let said = encspec(Folder::new("coverage"), &["coverage", "--format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    for manual in report["manuals"].as_array().expect("manuals") {
        let number = |key: &str| manual[key].as_u64().unwrap_or_else(|| panic!("{key} of {manual:#}"));
        let classes = manual["by_class"].as_object().expect("classes");
        let sum: u64 = classes.values().map(|n| n.as_u64().expect("a number")).sum();
        assert_eq!(sum, number("total"), "every requirement has one class");
        let uncovered = manual["uncovered"].as_array().expect("a list").len() as u64;
        assert_eq!(number("covered") + uncovered, number("testable"));
        let left_out = ["untestable", "out-of-scope"].map(|class| classes[class].as_u64().expect("a number"));
        assert_eq!(number("testable") + left_out.iter().sum::<u64>(), number("total"));
        let live = |key: &str| manual["live"][key].as_array().expect("a list").len() as u64;
        assert_eq!(live("no_stand") + live("with_stand") + live("never"), number("covered"));
        assert!(["nic", "serial"].contains(&manual["live"]["link"].as_str().expect("a link")));
        assert!(manual["id"].is_string());
    }
}

#[test]
fn at_least_95_percent_of_the_requirements_are_covered() {
    let said = encspec(Folder::new("covered"), &["coverage", "--format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    for manual in report["manuals"].as_array().expect("manuals") {
        let number = |key: &str| manual[key].as_u64().expect("a number");
        let uncovered = &manual["uncovered"];
        assert!(number("covered") * 100 >= number("testable") * 95, "{}: {uncovered}", manual["id"]);
        // What a manual leaves out of a suite that it uses too has a reason each; here its own requirements count.
        let others = |key: &str| -> u64 {
            let also = manual["also"].as_array().into_iter().flatten();
            also.map(|suite| suite[key].as_u64().expect("a number")).sum()
        };
        let left_out = number("total") - number("testable") - (others("total") - others("covered"));
        assert!(
            left_out * 10 < number("total") - others("total"),
            "{}: too many are untestable or out of scope",
            manual["id"]
        );
        assert!(manual["by_class"]["implicit"].as_u64() <= Some(3), "{}: too many are implicit", manual["id"]);
    }
}

#[rstest]
#[case("XAC77-PRE-010", &["covered by lika-xac77-profinet/preset/absolute", "level      must", "broken by  preset-adds-instead-of-assigns"])]
#[case("xac77-pre-010", &["requirement XAC77-PRE-010"])]
#[case("preset/absolute", &["case lika-xac77-profinet/preset/absolute", "- write: { P65000: 0x00012345 }"])]
#[case("rules/position-or-error-never-both", &["rule lika-xac77-profinet/rules/position-or-error-never-both", "XAC77-SIG-036"])]
#[case("preset-adds-instead-of-assigns", &["breaks     XAC77-PRE-010", "caught by  lika-xac77-profinet/preset/absolute"])]
fn explain_knows_requirements_cases_rules_and_bugs(#[case] id: &str, #[case] says: &[&str]) {
    let said = encspec(Folder::new("explain"), &["explain", id]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    for text in says {
        assert!(said.out.contains(text), "`{text}` is not in:\n{}", said.out);
    }
}

#[test]
fn errata_and_schema_have_output() {
    let folder = Folder::new("errata");
    let errata = encspec(&folder, &["errata", MANUAL]);
    assert_eq!(errata.status, Some(0));
    assert!(errata.out.contains("XAC77-TLG-001") && errata.out.contains("    open: "), "{}", errata.out);
    let schema = encspec(&folder, &["schema"]);
    serde_json::from_str::<serde_json::Value>(&schema.out).expect("JSON");
}

/// The capture in the repository, at its device, its controller and another address, and at a time without a finding.
#[test]
fn a_replay_shows_what_is_asked_for() {
    let folder = Folder::new("replay-filter");
    let capture = testing::workspace().join("captures/profinet-py-and-pnio.pcap");
    let capture = capture.to_string_lossy();
    let replay = |arguments: &[&str]| encspec(&folder, &[&["replay", &*capture], arguments].concat());
    let all = replay(&[]);
    assert!(all.out.contains("PN-ALARM-DIAGNOSIS") && !all.out.contains('\x1b'), "{}", all.out);
    assert!(replay(&["--color", "always"]).out.contains("\x1b["));
    for station in ["encoder-1", "02:00:00:00:01:00", "tp"] {
        assert!(replay(&["--station", station]).out.contains("PN-ALARM-DIAGNOSIS"), "{station}");
    }
    for hides in
        [&["--station", "02:00:00:00:09:09"][..], &["--severity", "error"], &["--from", "2.5"], &["--to", "0.1"]]
    {
        let shown = replay(hides);
        assert!(
            !shown.out.contains("PN-ALARM-DIAGNOSIS") && shown.out.contains("not shown"),
            "{hides:?}: {}",
            shown.out
        );
    }
}

/// A damaged capture is annotated as far as it can be read.
#[test]
fn a_damaged_capture_is_annotated() {
    let folder = Folder::new("annotate-damaged");
    let capture = fs::read(testing::workspace().join("captures/profinet-py-and-pnio.pcap")).expect("the capture");
    folder.write("cut.pcap", &capture[..capture.len() - 7]);
    let said = encspec(&folder, &["replay", "cut.pcap", "--annotate", "found.pcapng"]);
    assert_eq!(said.status, Some(2), "{}", said.err);
    let annotated = fs::read(folder.join("found.pcapng")).expect("the annotated capture");
    let text = String::from_utf8_lossy(&annotated);
    assert!(text.contains("encspec PN-ALARM-DIAGNOSIS"), "{} bytes", annotated.len());
}
