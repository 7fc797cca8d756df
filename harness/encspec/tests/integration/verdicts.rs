//! The weight of each verdict, the exit status of a run, and the ledger of known failures.

use crate::sample_run;
use encspec::ledger::{Date, Ledger};
use encspec::report::{ExitStatus, ResultColour};
use encspec::result::{CaseFailure, CaseKind, LedgerNote, RunResult};
use encspec::suite::model::Level::{self, Info, Must, Should};
use encspec::verdict::Verdict::{self, Error, Fail, Inconclusive, NotApplicable, NotRun, Pass, Xfail, Xpass};
use encspec::{ledger, report};
use rstest::rstest;
use std::path::Path;

#[rstest]
#[case(CaseKind::Trial, Pass, Must, "green", "green")]
#[case(CaseKind::Trial, Xfail, Must, "green", "green")]
#[case(CaseKind::Trial, NotApplicable, Must, "neutral", "neutral")]
#[case(CaseKind::Trial, Fail, Must, "red", "red")]
#[case(CaseKind::Trial, Fail, Should, "red", "neutral")]
#[case(CaseKind::Trial, Fail, Info, "neutral", "neutral")]
#[case(CaseKind::Trial, Inconclusive, Info, "red", "red")]
#[case(CaseKind::Trial, Error, Info, "red", "red")]
#[case(CaseKind::Trial, Xpass, Info, "red", "red")]
#[case(CaseKind::Trial, NotRun, Info, "red", "red")]
#[case(CaseKind::Rule, Fail, Must, "red", "red")]
#[case(CaseKind::Rule, Fail, Should, "red", "neutral")]
#[case(CaseKind::Rule, NotRun, Must, "red", "red")]
fn the_weight_of_a_verdict(
    #[case] kind: CaseKind,
    #[case] verdict: Verdict,
    #[case] level: Level,
    #[case] normal: &str,
    #[case] gated: &str,
) {
    for (gate_must, expected) in [(false, normal), (true, gated)] {
        let good = sample_run::case("a/good", CaseKind::Trial, Pass, Must);
        let mut result = sample_run::run(vec![good, sample_run::case("a/b", kind, verdict, level)]);
        result.gate_must = gate_must;
        let run = &result.runs[0];
        let weight = match report::result_colour(&result, run, &run.cases[1]) {
            ResultColour::Green => "green",
            ResultColour::Neutral(_) => "neutral",
            ResultColour::Red => "red",
        };
        assert_eq!(weight, expected, "gate_must {gate_must}");
        let green = expected != "red";
        assert_eq!(report::status(&result), if green { ExitStatus::Green } else { ExitStatus::Red });
    }
}

#[rstest]
#[case("model", false, ExitStatus::Red)]
#[case("model", true, ExitStatus::Green)]
#[case("null", false, ExitStatus::Red)]
#[case("nic", false, ExitStatus::Green)]
fn a_rule_that_never_applied(#[case] kind: &str, #[case] filtered: bool, #[case] expected: ExitStatus) {
    let good = sample_run::case("a/good", CaseKind::Trial, Pass, Must);
    let mut result = sample_run::run(vec![good, sample_run::case("rules/a", CaseKind::Rule, NotRun, Must)]);
    result.runs[0].dut.kind = kind.into();
    result.runs[0].filtered = filtered;
    assert_eq!(report::status(&result), expected);
}

#[rstest]
#[case(&[], false, ExitStatus::Red)]
#[case(&[Pass], false, ExitStatus::Green)]
#[case(&[Xfail], false, ExitStatus::Red)]
#[case(&[Xfail], true, ExitStatus::Green)]
#[case(&[NotApplicable], true, ExitStatus::Red)]
#[case(&[Xfail, Pass], false, ExitStatus::Green)]
#[case(&[NotApplicable, Pass], false, ExitStatus::Green)]
fn a_run_without_a_pass_is_red(#[case] verdicts: &[Verdict], #[case] filtered: bool, #[case] expected: ExitStatus) {
    let cases = verdicts.iter().map(|&verdict| sample_run::case("a/b", CaseKind::Trial, verdict, Must)).collect();
    let mut result = sample_run::run(cases);
    result.runs[0].filtered = filtered;
    assert_eq!(report::status(&result), expected);
}

#[test]
fn a_passed_rule_does_not_replace_a_passed_trial() {
    let mut result = sample_run::run(vec![
        sample_run::case("a/b", CaseKind::Trial, NotApplicable, Must),
        sample_run::case("rules/a", CaseKind::Rule, Pass, Must),
    ]);
    assert_eq!(report::status(&result), ExitStatus::Red);
    result.runs[0].cases.remove(0);
    assert_eq!(report::status(&result), ExitStatus::Green);
}

#[test]
fn each_device_needs_a_pass() {
    let mut result = sample_run::run(vec![sample_run::case("a/b", CaseKind::Trial, Pass, Must)]);
    let mut other = result.runs[0].clone();
    other.cases[0].verdict = NotApplicable;
    result.runs.push(other);
    assert_eq!(report::status(&result), ExitStatus::Red);
}

#[test]
fn no_device_is_not_green() {
    assert_eq!(report::status(&RunResult::default()), ExitStatus::Red);
}

#[test]
fn red_notes_of_the_ledger_make_the_run_red() {
    let mut result = sample_run::run(vec![sample_run::case("a/b", CaseKind::Trial, Pass, Must)]);
    result.ledger_notes.push(LedgerNote { text: "Good to know.".into(), red: false });
    assert_eq!(report::status(&result), ExitStatus::Green);
    result.ledger_notes.push(LedgerNote { text: "It expired.".into(), red: true });
    assert_eq!(report::status(&result), ExitStatus::Red);
}

const ENTRY: &str = "known_failures:\n- test: preset/late\n  device: acme-profinet\n  reason: It is late.\n  ticket: FW-7\n  \
                     expires: 2027-01-31\n  signature: 'expect: { status.done: 1, position: 0x1000 } | position: 0x1000'\n";

fn today() -> Date {
    "2026-06-01".parse().expect("a day")
}

/// Applies the entry, with `change`, to one case with this verdict and one that passes.
fn applied(verdict: Verdict, failures: Vec<CaseFailure>, change: (&str, &str)) -> RunResult {
    let text = ENTRY.replacen(change.0, change.1, 1);
    assert!(change.0.is_empty() || text != ENTRY, "the change must have an effect");
    let ledger = Ledger::parse(Path::new("ledger.yaml"), &text).map_err(|error| error.to_string()).expect("a ledger");
    let mut late = sample_run::case("preset/late", CaseKind::Trial, verdict, Must);
    late.failures = failures;
    let mut result = sample_run::run(vec![sample_run::case("preset/good", CaseKind::Trial, Pass, Must), late]);
    result.runs[0].requirements = vec![sample_run::requirement(
        1,
        "section 1",
        Must,
        encspec::verdict::worse(Pass, verdict),
        &["preset/good", "preset/late"],
    )];
    ledger::apply(&ledger, &mut result, today());
    result
}

const SAME: (&str, &str) = ("", "");

#[rstest]
#[case::known(Fail, SAME, Xfail, ExitStatus::Green)]
#[case::fixed(Pass, SAME, Xpass, ExitStatus::Red)]
#[case::other_failure(Fail, ("position: 0x1000'", "position: 0x2000'"), Fail, ExitStatus::Red)]
#[case::pattern_of_the_failure(Fail, ("position: 0x1000'", "position: *'"), Xfail, ExitStatus::Green)]
#[case::expired(Fail, ("2027-01-31", "2026-05-31"), Fail, ExitStatus::Red)]
#[case::last_day(Fail, ("2027-01-31", "2026-06-01"), Xfail, ExitStatus::Green)]
#[case::expired_and_fixed(Pass, ("2027-01-31", "2026-05-31"), Pass, ExitStatus::Red)]
#[case::unmatched(Fail, ("preset/late", "preset/lost"), Fail, ExitStatus::Red)]
#[case::unmatched_and_green(Pass, ("preset/late", "preset/lost"), Pass, ExitStatus::Red)]
#[case::pattern_of_tests(Fail, ("preset/late", "'*/late'"), Xfail, ExitStatus::Green)]
#[case::with_the_manual(Fail, ("preset/late", "acme-profinet/preset/late"), Xfail, ExitStatus::Green)]
#[case::variant(Fail, ("  reason", "  variant: single\n  reason"), Xfail, ExitStatus::Green)]
#[case::other_variant(Fail, ("  reason", "  variant: multi\n  reason"), Fail, ExitStatus::Red)]
#[case::other_device(Fail, ("acme-profinet", "other-profinet"), Fail, ExitStatus::Red)]
#[case::other_device_and_green(Pass, ("acme-profinet", "other-profinet"), Pass, ExitStatus::Green)]
#[case::inconclusive_is_never_known(Inconclusive, SAME, Inconclusive, ExitStatus::Red)]
#[case::error_is_never_known(Error, SAME, Error, ExitStatus::Red)]
#[case::not_applicable(NotApplicable, SAME, NotApplicable, ExitStatus::Green)]
fn the_ledger_changes_the_verdict(
    #[case] found: Verdict,
    #[case] change: (&str, &str),
    #[case] expected: Verdict,
    #[case] status: ExitStatus,
) {
    let failures = if found == Fail { vec![sample_run::failure()] } else { Vec::new() };
    let result = applied(found, failures, change);
    let case = &result.runs[0].cases[1];
    assert_eq!(case.verdict, expected);
    assert_eq!(case.covers[0].verdict, expected);
    assert_eq!(result.runs[0].requirements[0].verdict, encspec::verdict::worse(Pass, expected));
    assert_eq!(report::status(&result), status, "{:?}", report::reasons(&result));
}

#[rstest]
#[case(Fail, SAME, "known failure FW-7: It is late.")]
#[case(Pass, SAME, "remove the entry")]
#[case(Fail, ("position: 0x1000'", "position: 0x2000'"), "This is not the failure")]
#[case(Fail, ("2027-01-31", "2026-05-31"), "expired on 2026-05-31")]
#[case(Fail, ("preset/late", "preset/lost"), "matches no test")]
fn the_report_names_the_ledger_entry(#[case] found: Verdict, #[case] change: (&str, &str), #[case] note: &str) {
    let failures = if found == Fail { vec![sample_run::failure()] } else { Vec::new() };
    let text = encspec::report::console(
        &applied(found, failures, change),
        report::ConsoleOptions { colour: false, verbose: true, quiet: false },
    );
    assert!(text.contains(note), "{text}");
}

#[test]
fn a_second_failure_is_not_excused_by_the_first() {
    let second = CaseFailure { step: "read: { P5: 1 }".into(), ..sample_run::failure() };
    let result = applied(Fail, vec![sample_run::failure(), second], SAME);
    assert_eq!(result.runs[0].cases[1].verdict, Fail);
}

#[rstest]
#[case(Some("1.3.0"), Xfail)]
#[case(Some("1.5"), Fail)]
#[case(None, Fail)]
fn an_entry_for_some_firmware(#[case] firmware: Option<&str>, #[case] expected: Verdict) {
    let text = ENTRY.replacen("  reason", "  firmware: { from: \"1.2\", to: \"1.4\" }\n  reason", 1);
    let ledger = Ledger::parse(Path::new("ledger.yaml"), &text).map_err(|error| error.to_string()).expect("a ledger");
    let mut late = sample_run::case("preset/late", CaseKind::Trial, Fail, Must);
    late.failures = vec![sample_run::failure()];
    let mut result = sample_run::run(vec![late]);
    result.runs[0].dut.firmware = firmware.map(str::to_owned);
    ledger::apply(&ledger, &mut result, today());
    assert_eq!(result.runs[0].cases[0].verdict, expected);
}

#[test]
fn a_filtered_run_ignores_unmatched_entries() {
    let ledger = Ledger::parse(Path::new("ledger.yaml"), ENTRY).map_err(|error| error.to_string()).expect("a ledger");
    let mut result = sample_run::run(vec![sample_run::case("preset/good", CaseKind::Trial, Pass, Must)]);
    result.runs[0].filtered = true;
    ledger::apply(&ledger, &mut result, today());
    assert_eq!(result.ledger_notes, []);
}

#[test]
fn the_suggested_entry_excuses_the_failure() {
    let mut late = sample_run::case("preset/it's[row 1]", CaseKind::Trial, Fail, Must);
    late.failures = vec![sample_run::failure()];
    let mut result = sample_run::run(vec![late, sample_run::case("preset/good", CaseKind::Trial, Pass, Must)]);
    let run = &result.runs[0];
    let offered = ledger::entry(run, &run.cases[0], &run.cases[0].failures[0]);
    let text = format!("known_failures:\n{}", offered.replace("YYYY-MM-DD", "2027-01-31"));
    let ledger = Ledger::parse(Path::new("ledger.yaml"), &text).map_err(|error| error.to_string()).expect("a ledger");
    ledger::apply(&ledger, &mut result, today());
    assert_eq!(result.runs[0].cases[0].verdict, Xfail);
    assert_eq!(report::status(&result), ExitStatus::Green);
}
