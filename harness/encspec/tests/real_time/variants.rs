//! The variant of a live device: `encspec bench init` reads it, and `encspec run` judges nothing on a device of another one.

use crate::common::program::{self, ServeProcess};
use crate::common::served::private_network;
use crate::tests;
use libtest_mimic::Trial;
use serde_json::Value;
use testing::Folder;

pub fn trials() -> Vec<Trial> {
    tests![
        the_variant_of_a_device_is_read,
        an_open_variant_is_asked_for_once,
        the_variant_of_a_slave_is_read,
        start_parameters_are_written_with_comments,
    ]
}

/// The bench file that `bench init` writes with these arguments.
fn written(folder: &Folder, arguments: &[&str]) -> String {
    let said = program::encspec(folder, &[&["bench", "init", "-o", "bench.yaml"], arguments].concat());
    assert_eq!(said.status, Some(0), "{}", said.all());
    std::fs::read_to_string(folder.join("bench.yaml")).expect("the bench file")
}

/// Claims another variant in the bench file, and checks that the run has one finding and no verdict.
fn assert_not_judged(folder: &Folder, bench: &str, (is, claimed): (&str, &str), filter: &str) {
    let line = |device: &str| format!("\ndevice: {device}\n");
    assert!(bench.contains(&line(is)), "{bench}");
    folder.write("wrong.yaml", bench.replace(&line(is), &line(claimed)));
    let arguments = ["run", "--dut", "wrong.yaml", "--report", "json=run.json", "--no-evidence", filter];
    let said = program::encspec(folder, &arguments);
    assert_eq!(said.status, Some(1), "{}", said.all());
    assert!(!said.all().contains("blame      device"), "{}", said.all());
    let text = std::fs::read_to_string(folder.join("run.json")).expect("a report");
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let run = &report["runs"][0];
    let errors: Vec<&Value> =
        run["findings"].as_array().expect("findings").iter().filter(|of| of["severity"] == "error").collect();
    assert_eq!(errors.len(), 1, "{}", said.all());
    let text = errors[0]["text"].as_str().expect("a text");
    assert!(text.contains(claimed) && text.contains(&format!("`device: {is}`")), "{text}");
    let cases = run["cases"].as_array().expect("cases");
    assert!(!cases.is_empty() && cases.iter().all(|case| case["verdict"] == "not-run"), "{}", said.all());
}

fn the_variant_of_a_device_is_read() {
    if !private_network() {
        return;
    }
    let folder = Folder::new("variant");
    let _serving = ServeProcess::start(&["model:sick-afx60-profinet/afm60", "--nic", "theirs"]);
    let bench = written(&folder, &["--nic", "ours"]);
    assert!(bench.contains("as read: the order number in I&M0 is `AFM60A-xxNx018x12`"), "{bench}");
    let claim = ("sick-afx60-profinet/afm60", "sick-afx60-profinet/afs60");
    assert_not_judged(&folder, &bench, claim, "identification/");
}

fn an_open_variant_is_asked_for_once() {
    if !private_network() {
        return;
    }
    let folder = Folder::new("open-variant");
    let _serving = ServeProcess::start(&["model:kuebler-sendix58xx-profinet/sendix-singleturn", "--nic", "theirs"]);
    let bench = written(&folder, &["--nic", "ours"]);
    assert!(bench.contains("\ndevice: kuebler-sendix58xx-profinet\n"), "{bench}");
    let said = program::encspec(&folder, &["run", "--dut", "bench.yaml"]);
    assert_eq!(said.status, Some(2), "{}", said.all());
    assert_eq!(said.err.matches("5868").count(), 1, "{}", said.all());
    assert!(said.err.contains("`kuebler-sendix58xx-profinet/sendix-multiturn`"), "{}", said.all());
}

fn the_variant_of_a_slave_is_read() {
    let folder = Folder::new("slave-variant");
    let line = folder.join("line").display().to_string();
    let model = "model:datalogic-amt58-profibus/hm5816-16384";
    let _serving = ServeProcess::start(&[model, "--pty", &line, "--address", "8"]);
    let bench = written(&folder, &["--serial", &line]);
    assert!(bench.contains("diag.hardware_revolutions is 16384") && bench.contains("address: 8"), "{bench}");
    let claim = ("datalogic-amt58-profibus/hm5816-16384", "datalogic-amt58-profibus/hs5818");
    assert_not_judged(&folder, &bench, claim, "configuration/");
}

/// A parameter in doubt is commented out and in the table; the others are lines that a run reads.
fn start_parameters_are_written_with_comments() {
    if !private_network() {
        return;
    }
    let folder = Folder::new("mapping");
    let (_, text) = suites::gsdml().iter().find(|(path, _)| path.contains("AFM60A")).expect("it is shipped");
    assert!(text.contains("Sampling interval"), "the parameter has this name");
    folder.write("vendor.xml", text.replace("Sampling interval", "Abtastintervall"));
    let _serving = ServeProcess::start(&["model:sick-afx60-profinet/afm60", "--nic", "theirs"]);
    let gsdml = ["--nic", "ours", "--gsdml", "vendor.xml", "-o", "bench.yaml"];
    let said = program::encspec(&folder, &[&["bench", "init"], &gsdml[..]].concat());
    assert_eq!(said.status, Some(0), "{}", said.all());
    assert!(said.err.contains("sampling_interval  -  ") || said.err.contains("decision"), "{}", said.all());
    let bench = std::fs::read_to_string(folder.join("bench.yaml")).expect("the bench file");
    assert!(bench.contains("\nstart_parameters:\n") && bench.contains("\n#  sampling_interval: "), "{bench}");
    assert!(bench.contains("found by its meaning"), "{bench}");
    let run = program::encspec(&folder, &["run", "--dut", "bench.yaml", "--no-evidence", "identification/"]);
    assert!(run.all().contains("sampling_interval: no parameter has a name that means it"), "{}", run.all());
}
