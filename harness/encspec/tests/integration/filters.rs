//! `FILTER`, `--exact` and `--failed` of `encspec run` and `encspec list`.

use crate::common::program::{ProgramOutput, encspec};
use rstest::rstest;
use serde_json::Value;
use std::collections::BTreeSet;
use testing::Folder;

const MANUAL: &str = "lika-xac77-profinet";
const MODEL: &str = "model:lika-xac77-profinet/xac7718";

/// The listed cases and rules: id and what each covers.
fn listed(said: &ProgramOutput) -> Vec<(String, Vec<String>)> {
    assert_eq!(said.status, Some(0), "{}", said.all());
    let report: Value = serde_json::from_str(&said.out).expect("JSON");
    let cases =
        report["manuals"].as_array().expect("manuals").iter().flat_map(|of| of["cases"].as_array().expect("cases"));
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    cases
        .map(|case| (text(&case["id"]), case["covers"].as_array().expect("a list").iter().map(text).collect()))
        .collect()
}

fn list(filters: &[&str]) -> Vec<(String, Vec<String>)> {
    let folder = Folder::new(&format!("list-{}", filters.join("-").replace(['/', ' ', '!', '.'], "_")));
    listed(&encspec(&folder, &[&["list", "--format", "json", "--"], filters].concat()))
}

#[rstest]
#[case::requirement(&["xac77-prk-004"], &["XAC77-PRK-004"])]
#[case::requirements_of_a_topic(&["XAC77-PRK"], &["XAC77-PRK-"])]
#[case::either(&["XAC77-PRK-004", "XAC77-PRK-010"], &["XAC77-PRK-004", "XAC77-PRK-010"])]
fn a_requirement_selects_what_covers_it(#[case] filters: &[&str], #[case] begin: &[&str]) {
    let all = list(&[MANUAL]);
    let covers =
        |(_, covers): &&(String, Vec<String>)| covers.iter().any(|id| begin.iter().any(|begin| id.starts_with(begin)));
    let expected: Vec<_> = all.iter().filter(covers).cloned().collect();
    assert!(!expected.is_empty() && expected.len() < all.len());
    assert_eq!(list(filters), expected);
}

/// Page 149 has the diagram of the parking sensor: its requirements are XAC77-PRK, and what covers none of that page is left out.
#[test]
fn a_clause_selects_what_cites_it() {
    let cited = list(&["16.3"]);
    assert!(cited.iter().any(|(_, covers)| covers.iter().any(|id| id == "XAC77-PRK-004")), "{cited:?}");
    assert!(
        cited.iter().all(|(id, _)| id.starts_with(MANUAL) || id.starts_with("sick") || id.starts_with("kuebler")),
        "{cited:?}"
    );
    let of_page = list(&[MANUAL, "p. 149"]);
    assert!(!of_page.is_empty() && of_page.len() < list(&[MANUAL]).len());
    assert!(of_page.iter().any(|(_, covers)| covers.iter().any(|id| id == "XAC77-PRK-004")), "{of_page:?}");
}

#[test]
fn levels_and_exclusions_narrow_a_manual() {
    let ids = |filters: &[&str]| list(filters).into_iter().map(|(id, _)| id).collect::<BTreeSet<String>>();
    let (all, must, not_must) = (ids(&[MANUAL]), ids(&[MANUAL, "must"]), ids(&[MANUAL, "!must"]));
    assert!(!must.is_empty() && !not_must.is_empty());
    assert!(must.is_disjoint(&not_must));
    assert_eq!(must.union(&not_must).cloned().collect::<BTreeSet<_>>(), all);
    let parking = ids(&[MANUAL, "parking/", "!parking/stays-parked"]);
    assert!(
        !parking.is_empty() && parking.iter().all(|id| id.starts_with("lika-xac77-profinet/parking/")),
        "{parking:?}"
    );
    assert!(parking.iter().all(|id| !id.contains("stays-parked")), "{parking:?}");
}

#[test]
fn failed_selects_what_was_not_green_before() {
    let folder = Folder::new("failed");
    let base = ["run", "--dut", MODEL, "parking/", "preset/absolute"];
    let with_bug = ["--bug", "parking-ignored"];
    let first = encspec(&folder, &[&base[..], &with_bug].concat());
    assert_eq!(first.status, Some(1), "{}", first.all());
    let before: BTreeSet<String> =
        listed(&encspec(&folder, &["list", "--failed", "--format", "json"])).into_iter().map(|(id, _)| id).collect();
    assert!(before.iter().any(|id| id.contains("parking/stays-parked")), "{before:?}");
    assert!(before.iter().all(|id| !id.contains("preset/absolute")), "{before:?}");
    let report = folder.join("again.json");
    let report = format!("json={}", report.display());
    let again = encspec(&folder, &["run", "--failed", "--dut", MODEL, "--bug", "parking-ignored", "--report", &report]);
    assert_eq!(again.status, Some(1), "{}", again.all());
    let read: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("again.json")).expect("a report")).expect("JSON");
    let cases = read["runs"][0]["cases"].as_array().expect("cases");
    let ran: BTreeSet<String> = cases.iter().map(|case| case["id"].as_str().expect("an id").to_owned()).collect();
    assert!(before.is_subset(&ran), "{before:?} {ran:?}");
    assert!(ran.iter().all(|id| !id.contains("preset/absolute")), "{ran:?}");
    let from_report = listed(&encspec(&folder, &["list", "--failed=again.json", "--format", "json"]));
    assert_eq!(from_report.into_iter().map(|(id, _)| id).collect::<BTreeSet<_>>(), before);
    let fixed = encspec(&folder, &["run", "--failed", "--dut", MODEL]);
    assert_eq!(fixed.status, Some(0), "{}", fixed.all());
    let nothing = encspec(&folder, &["run", "--failed", "--dut", MODEL]);
    assert_eq!(nothing.status, Some(2), "{}", nothing.all());
    assert!(nothing.err.contains("everything was green in encspec-evidence/last-run.json"), "{}", nothing.err);
}

/// A trial that passes may break a rule, so a broken rule runs again with all trials.
#[test]
fn a_broken_rule_is_judged_on_all_trials_again() {
    let folder = Folder::new("failed-rule");
    let rule = "lika-xac77-profinet/rules/parking-is-answered";
    let report = format!(
        r#"{{ "runs": [ {{ "dut": {{ "variant": "xac7718" }}, "cases": [ {{ "id": "{rule}", "verdict": "fail" }} ] }} ] }}"#
    );
    folder.write("report.json", &report);
    let run =
        encspec(&folder, &["run", "--failed=report.json", "--dut", MODEL, "--bug", "parking-ignored", "--no-evidence"]);
    assert_eq!(run.status, Some(1), "{}", run.all());
    assert!(run.out.contains(&format!("FAIL {rule}")), "{}", run.out);
}
