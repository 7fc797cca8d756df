//! The shell parts of the workflows in `examples/ci`, run as they are, with an example application as the device.

use crate::common::program::command;
use rstest::rstest;
use std::fs;
use std::path::Path;
use std::process::Command;
use testing::{Folder, workspace};

/// The shell part of a job for the night.
const NIGHTLY: &str = "nightly";

/// The shell parts of an example, each with its name.
fn parts(file: &str) -> Vec<(String, String)> {
    let path = workspace().join("examples/ci").join(file);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut parts: Vec<(String, String)> = Vec::new();
    let mut is_open = false;
    for line in text.lines().map(str::trim) {
        match line.strip_prefix("# shell: ") {
            Some("end") => is_open = false,
            Some(name) => {
                parts.push((name.to_owned(), String::new()));
                is_open = true;
            }
            None if is_open => {
                let (_, script) = parts.last_mut().expect("an open part");
                script.push_str(line);
                script.push('\n');
            }
            None => {}
        }
    }
    assert!(!parts.is_empty() && !is_open, "{file} has no shell part, or one without an end");
    parts
}

/// A folder like a checkout: the example application in Python, with this mistake if it is not empty.
fn checkout(name: &str, mistake: &str) -> Folder {
    let folder = Folder::new(&format!("ci-{}-{mistake}", name.replace('.', "-")));
    let from = workspace().join("examples/applications");
    for file in ["GSDML-V2.43-encspec-example-encoder-20261128.xml", "encoder-io.yaml", "python/encoder.py"] {
        let to = folder.join(file);
        fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        fs::copy(from.join(file), to).expect("a copy");
    }
    let bench = fs::read_to_string(from.join("python/profinet.yaml")).expect("the bench file");
    let sick = format!("python3 encoder.py --mistake {mistake}");
    let bench = if mistake.is_empty() { bench } else { bench.replace("python3 encoder.py", &sick) };
    folder.write("python/bench.yaml", bench);
    folder
}

/// Runs a script as a CI service does, with `encspec` in its path; returns the exit status and everything that was printed.
fn shell(folder: &Path, script: &str, part: &str) -> (Option<i32>, String) {
    let program = command(folder, &[]).get_program().to_owned();
    let bin = Path::new(&program).parent().expect("the folder of the program").to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([bin].into_iter().chain(std::env::split_paths(&path))).expect("a path");
    let output = Command::new("sh")
        .args(["-e", "-c", script])
        .current_dir(folder)
        .env("PATH", path)
        .env("BENCH", "python/bench.yaml")
        .env("PART", part)
        .env("SEED", "6")
        .env("EXPLORE", "--focus park --sequences 30 --findings 1")
        .env_remove("GITHUB_STEP_SUMMARY")
        .output()
        .expect("a shell");
    let all = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&all).into_owned())
}

#[rstest]
#[case::gitlab("gitlab.yml", &["junit.xml", "report.html", "new.json"])]
#[case::jenkins("Jenkinsfile", &["junit.xml", "report.html"])]
fn a_workflow_is_green_for_a_good_device_and_red_for_a_bad_one(#[case] file: &str, #[case] reports: &[&str]) {
    for (mistake, expected) in [("", Some(0)), ("record", Some(1))] {
        let folder = checkout(file, mistake);
        for (_, script) in parts(file).into_iter().filter(|(name, _)| name != NIGHTLY) {
            let (status, said) = shell(folder.path(), &script, "");
            assert_eq!(status, expected, "{file} {mistake}: {said}");
        }
        for report in reports {
            assert!(folder.join(report).is_file(), "{file}: {report}");
        }
    }
}

#[test]
fn the_parts_of_the_github_workflow_are_merged() {
    let file = "github.yml";
    for (mistake, expected) in [("", Some(0)), ("record", Some(1))] {
        let folder = checkout(file, mistake);
        let mut statuses = Vec::new();
        for (name, script) in parts(file).into_iter().filter(|(name, _)| name != NIGHTLY) {
            if name == "whole" {
                let (status, said) = shell(folder.path(), &script, "");
                assert_eq!(status, expected, "{mistake}: {said}");
                continue;
            }
            for part in ["1/2", "2/2"] {
                let (status, said) = shell(folder.path(), &script, part);
                assert!(said.contains("::notice title=encspec::Green") != (status != Some(0)), "{said}");
                statuses.push(status);
            }
        }
        assert!(statuses.contains(&expected), "{mistake}: {statuses:?}");
        assert!(folder.join("report.html").is_file() && folder.join("junit.xml").is_file());
    }
}

#[test]
fn a_release_is_compared_with_the_one_before() {
    let folder = checkout("gitlab.yml", "");
    let (_, script) = parts("gitlab.yml").remove(0);
    assert_eq!(shell(folder.path(), &script, "").0, Some(0));
    fs::rename(folder.join("new.json"), folder.join("released.json")).expect("the report");
    let (status, said) = shell(folder.path(), &script, "");
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("Not worse: "), "{said}");
    assert!(folder.join("changes.md").is_file());
}

/// The mistake is one that no case finds.
#[rstest]
#[case::github("github.yml")]
#[case::gitlab("gitlab.yml")]
#[case::jenkins("Jenkinsfile")]
fn the_job_for_the_night_finds_what_no_case_names(#[case] file: &str) {
    for (mistake, expected) in [("", Some(0)), ("sequence", Some(1))] {
        let folder = checkout(file, mistake);
        // As an encoder of PROFIdrive, whose suite has a rule about parking.
        let bench = fs::read_to_string(folder.join("python/bench.yaml")).expect("the bench file");
        let is_kept = |line: &&str| !line.starts_with("description") && !line.starts_with("telegrams");
        let bench: Vec<&str> = bench.lines().filter(is_kept).collect();
        folder.write("python/bench.yaml", bench.join("\n"));
        let (_, script) = parts(file).into_iter().find(|(name, _)| name == NIGHTLY).expect("a job for the night");
        let (status, said) = shell(folder.path(), &script, "");
        assert_eq!(status, expected, "{file} {mistake}: {said}");
        assert!(folder.join("explored.xml").is_file(), "{file}");
        assert_eq!(folder.join("explored/explored-1.yaml").is_file(), mistake == "sequence", "{file}");
    }
}
