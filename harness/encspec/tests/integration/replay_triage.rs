//! The console report of every third-party capture is approved in `reports/triage/`, so that a change shows up in review.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::built_in;
use encspec::replay::{ReplayReport, capture, text};
use std::fs;
use std::path::PathBuf;

/// The number of approved lines of a report. The rest of a report with a thousand refusals is repetition.
const MOST_LINES: usize = 400;

fn captures() -> Vec<(String, PathBuf)> {
    let mut found = Vec::new();
    for folder in ["profinet", "damaged", "containers"] {
        let Some(path) = testing::shared(&format!("captures/{folder}")) else { continue };
        for entry in fs::read_dir(path).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_some_and(|of| of == "pcap" || of == "pcapng") {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                found.push((format!("{folder}.{name}"), path));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn every_third_party_capture_has_the_approved_report() {
    let manuals = built_in::manuals();
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../../../../reports/triage");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for (name, path) in captures() {
        let octets = fs::read(&path).expect("a readable file");
        let report = match capture(&name, &octets[..], manuals) {
            Ok(report) => report,
            Err(error) => panic!("{name}: {error}"),
        };
        let whole = text(&ReplayReport { captures: vec![report] });
        let lines = whole.lines().count();
        let mut shown: String = whole.lines().take(MOST_LINES).collect::<Vec<_>>().join("\n");
        if lines > MOST_LINES {
            shown += "\n(more lines follow)";
        }
        settings.bind(|| insta::assert_snapshot!(name.as_str(), shown.as_str()));
    }
}
