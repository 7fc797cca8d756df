//! The example applications: each passes the generic suites on both buses, each of its mistakes is found, and a program that fails
//! makes no run green.

#[path = "../common/mod.rs"]
mod common;

use common::program::{ProgramOutput, encspec};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use testing::Folder;

fn examples() -> PathBuf {
    testing::workspace().canonicalize().expect("the workspace").join("examples/applications")
}

/// An example, by its folder, and the command that starts it; `None` where it cannot be built.
fn command(language: &str, folder: &Folder) -> Option<String> {
    let sources = examples().join(language);
    let skipped = |why: &str| {
        eprintln!("skipped: {why}");
        None
    };
    let runs = |command: &mut Command| command.output().is_ok_and(|output| output.status.success());
    match language {
        "python" if !runs(Command::new("python3").arg("--version")) => skipped("there is no python3"),
        "python" => Some(format!("python3 '{}'", sources.join("encoder.py").display())),
        "c" if !runs(Command::new("cc").arg("--version")) => skipped("there is no C compiler"),
        "c" => {
            let program = folder.path().join("encoder");
            let mut compile = Command::new("cc");
            compile.args(["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-o"]);
            compile.arg(&program).arg(sources.join("encoder.c")).arg("-lm");
            let compiled = compile.output().expect("cc");
            assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
            Some(format!("'{}'", program.display()))
        }
        _ => {
            // With the profile of this test, whose dependencies are compiled already.
            let programs = Path::new(env!("CARGO_BIN_EXE_encspec")).parent().expect("the folder of the profile");
            let name = programs.file_name().and_then(OsStr::to_str).expect("the profile");
            let profile = if name == "debug" { "dev" } else { name };
            let mut build = Command::new(env!("CARGO"));
            build.args(["build", "--quiet", "--package", "application-protocol", "--example", "encoder"]);
            build.args(["--profile", profile, "--target-dir"]);
            build.arg(programs.parent().expect("the target folder")).current_dir(&sources);
            let built = build.output().expect("cargo");
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            Some(format!("'{}'", programs.join("examples/encoder").display()))
        }
    }
}

/// Writes the bench file of an example for a command; returns its name.
fn bench(folder: &Folder, bus: &str, command: &str) -> String {
    let bench = fs::read_to_string(examples().join(format!("python/{bus}.yaml"))).expect("the bench file");
    let descriptions = examples().display().to_string();
    let lines = bench.lines().map(|line| match line.split_once(": ") {
        Some(("link", _)) => format!("link: \"app:{command}\"\n"),
        _ => format!("{}\n", line.replace("../", &format!("{descriptions}/"))),
    });
    let name = format!("{bus}.yaml");
    folder.write(&name, lines.collect::<String>());
    name
}

/// Runs the suite of a bus against a command, with the bench file of an example.
fn run(folder: &Folder, bus: &str, command: &str) -> ProgramOutput {
    let name = bench(folder, bus, command);
    encspec(folder.path(), &["run", "--dut", &name, "--no-evidence", "-v"])
}

fn check_example(language: &str, sequence: (&str, &str, &[&str])) {
    let folder = Folder::new("application");
    let Some(command) = command(language, &folder) else { return };
    for (bus, fewest) in [("profinet", 380), ("profibus", 180), ("profidrive", 270)] {
        let ran = run(&folder, bus, &command);
        assert_eq!(ran.status, Some(0), "{language} on {bus}: {}", ran.all());
        let passed = ran.out.lines().filter(|line| line.starts_with("  pass ")).count();
        assert!(passed >= fewest, "{language} on {bus}: only {passed} results pass: {}", ran.out);
    }
    for (mistake, bus, found) in MISTAKES {
        let ran = run(&folder, bus, &format!("{command} --mistake {mistake}"));
        let line = ran.out.lines().find(|line| line.starts_with("  fail ") && line.contains(found));
        assert!(ran.status == Some(1) && line.is_some(), "{language}, {mistake}: {}", ran.all());
    }
    check_explored(language, &command, &folder, sequence);
}

/// Deliberate mistakes, each with a bus on which it shows and a case that finds it.
const MISTAKES: [(&str, &str, &str); 7] = [
    ("diagnosis", "profinet", "profinet-io/protocol-alarms/comes-and-goes"),
    ("diagnosis", "profibus", "dp-slave/diagnosis/fault-"),
    ("record", "profinet", "profinet-io/protocol-records/unknown-index-is-refused"),
    ("configuration", "profibus", "dp-slave/configuration/"),
    ("direction", "profibus", "dp-slave/encoder-position/direction[reversed]"),
    ("preset", "profibus", "dp-slave/encoder-preset"),
    ("preset", "profidrive", "profidrive-encoder/preset/"),
];

/// No case finds the mistake of a sequence; exploring with this seed and focus shows that it breaks the rule, and finds nothing in the
/// example without it.
fn check_explored(language: &str, command: &str, folder: &Folder, (rule, seed, focus): (&str, &str, &[&str])) {
    let mistake = format!("{command} --mistake sequence");
    let ran = run(folder, "profidrive", &mistake);
    assert_eq!(ran.status, Some(0), "{language}: {}", ran.all());
    let explored = |bus: &str, command: &str, sequences: &str| {
        let dut = bench(folder, bus, command);
        let mut arguments =
            vec!["explore", "--dut", &dut, "--sequences", sequences, "--findings", "1", "--out", "found"];
        arguments.extend(["--seed", seed]);
        arguments.extend(focus.iter().flat_map(|word| ["--focus", word]));
        encspec(folder.path(), &arguments)
    };
    for (bus, sequences) in [("profidrive", "20"), ("profibus", "10"), ("profinet", "20")] {
        let said = explored(bus, command, sequences);
        assert_eq!(said.status, Some(0), "{language} on {bus}: {}", said.all());
    }
    let said = explored("profidrive", &mistake, "30");
    assert_eq!(said.status, Some(1), "{language}: {}", said.all());
    assert!(said.out.contains(&format!("the rule {rule} breaks")), "{language}: {}", said.out);
    let case = fs::read_to_string(folder.path().join("found/explored-1.yaml")).expect("the written steps");
    assert!(case.contains("- connect: { module: telegram_81 }"), "{case}");
}

#[test]
fn example_in_python() {
    check_example("python", ("rules/parked-state-ends", "6", &["park"]));
}

#[test]
fn example_in_c() {
    check_example("c", ("rules/error-acknowledgement-ends", "6", &["acknowledge_error"]));
}

#[test]
fn example_in_rust() {
    check_example("rust", ("rules/position-or-error-never-both", "1", &["fault", "park"]));
}

#[test]
fn examples_stay_small() {
    for file in ["python/encoder.py", "c/encoder.c", "rust/encoder.rs"] {
        let text = fs::read_to_string(examples().join(file)).expect("the example");
        let is_code = |line: &&str| !line.is_empty() && !["//", "/*", "# "].iter().any(|begin| line.starts_with(begin));
        let lines = text.lines().map(str::trim).filter(is_code).count();
        assert!(lines <= 500, "{file} has {lines} lines of code");
    }
}

#[test]
fn same_run_twice_has_the_same_report() {
    let folder = Folder::new("application");
    let Some(command) = command("python", &folder) else { return };
    let report = || {
        run(&folder, "profinet", &command);
        encspec(folder.path(), &["run", "--dut", "profinet.yaml", "--no-evidence", "--report", "json=-"]).out
    };
    assert_eq!(report(), report());
}

/// A program that answers `hello` like the example and then does `script` at the message after the first `reset`.
fn failing(folder: &Folder, script: &str) -> ProgramOutput {
    let hello = r#"{"answer":"hello","description":{"version":1,"name":"test","profibus":{"ident":65261,"configuration":"D1E1"}}}"#;
    let program =
        format!("read line\necho '{hello}'\nread line\necho '{{\"answer\":\"reset\"}}'\nread line\n{script}\n");
    folder.write("program.sh", &program);
    run(folder, "profibus", "sh program.sh")
}

#[test]
fn program_that_fails_makes_no_trial_green() {
    for (script, said) in [
        ("echo broken >&2; exit 3", "the program ended (exit status: 3) instead of answering"),
        ("echo nonsense; read line", "is not an answer"),
        ("echo '{\"answer\":\"led\"}'; read line", "the program answered `led` when it was asked"),
    ] {
        let ran = failing(&Folder::new("application"), script);
        assert_eq!(ran.status, Some(1), "{}", ran.all());
        assert!(ran.out.contains(said), "{script}: {}", ran.all());
        assert!(!ran.out.lines().any(|line| line.starts_with("  pass ") || line.starts_with("  fail ")), "{}", ran.out);
    }
}

#[test]
fn program_that_does_not_start_is_a_bench_that_cannot_be_used() {
    let folder = Folder::new("application");
    let ran = run(&folder, "profibus", "./no-such-program");
    assert_eq!(ran.status, Some(3), "{}", ran.all());
    assert!(ran.err.contains("the program ./no-such-program cannot be started"), "{}", ran.err);
    let ran = encspec(folder.path(), &["run", "--dut", "app:./no-such-program"]);
    assert_eq!(ran.status, Some(2), "{}", ran.all());
    assert!(ran.err.contains("needs `--device MANUAL/VARIANT`"), "{}", ran.err);
    let ran = encspec(folder.path(), &["run", "--dut", "app:'open", "--device", "dp-slave/plain"]);
    assert!(ran.status == Some(3) && ran.err.contains("the quote ' is not closed"), "{}", ran.all());
}

#[test]
fn command_needs_no_bench_file() {
    let folder = Folder::new("application");
    let Some(command) = command("python", &folder) else { return };
    let dut = format!("app:{command}");
    // The example is not the plain slave, and the run says so instead of judging it.
    let ran =
        encspec(Path::new("."), &["run", "--dut", &dut, "--device", "dp-slave/plain", "--no-evidence", "parameters/"]);
    assert_eq!(ran.status, Some(1), "{}", ran.all());
    assert!(ran.out.contains("example encoder in Python") || ran.out.contains("0xFEED"), "{}", ran.out);
    // Nothing that is permitted explains how it differs from the plain slave.
    let dut = ["--dut", &dut, "--device", "dp-slave/plain"];
    let said = encspec(Path::new("."), &[&["explore"], &dut[..], &["--sequences", "1"]].concat());
    assert!(said.status == Some(1) && said.out.contains("reference device: "), "{}", said.all());
}
