//! Whether a result is green, neutral or red, and the result of the whole run. A run in which nothing passed is never green.

use plain_text::count;
use results::outcome::{CaseKind, CaseResult, DeviceRun, FindingSeverity, MinimumPass, RunResult};
use results::verdict::{Colour, Verdict};
use suite::model::Level;

/// The exit status of `encspec`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitStatus {
    /// All green.
    Green,
    /// Something is not green.
    Red,
    /// An error on the command line, in a suite or in a ledger.
    Usage,
    /// The bench is unusable.
    Bench,
}

impl ExitStatus {
    /// The exit status of the process, 0 to 3.
    pub fn code(self) -> u8 {
        match self {
            ExitStatus::Green => 0,
            ExitStatus::Red => 1,
            ExitStatus::Usage => 2,
            ExitStatus::Bench => 3,
        }
    }
}

/// How a result counts for the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultColour {
    /// It passed, or failed as the ledger says.
    Green,
    /// It does not count; the sentence says why.
    Neutral(&'static str),
    /// It makes the run fail.
    Red,
}

impl ResultColour {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            ResultColour::Green => "green",
            ResultColour::Neutral(_) => "neutral",
            ResultColour::Red => "red",
        }
    }
}

/// How `case` of `run` counts: the colour of its verdict, after the gate of levels and the rule about rules that never applied.
pub fn result_colour(result: &RunResult, run: &DeviceRun, case: &CaseResult) -> ResultColour {
    match (case.verdict.colour(), case.verdict) {
        (Colour::Green, _) => ResultColour::Green,
        (Colour::Red, _) if case.passed_in_attempt.is_some() && result.accept_flaky => {
            ResultColour::Neutral("flaky, which this run accepts")
        }
        (Colour::Neutral, _) if result.fail_on_not_applicable => ResultColour::Red,
        (Colour::Neutral, _) => ResultColour::Neutral("not applicable"),
        (Colour::Red, Verdict::Fail) if case.level == Level::Info => {
            ResultColour::Neutral("level info is reported only")
        }
        (Colour::Red, Verdict::Fail) if case.level == Level::Should && result.gate_must => {
            ResultColour::Neutral("only level must counts in this run")
        }
        (Colour::Red, Verdict::NotRun) if case.kind == CaseKind::Rule && run.filtered => {
            ResultColour::Neutral("only a part of the suite was run")
        }
        (Colour::Red, Verdict::NotRun) if case.kind == CaseKind::Rule && !run.is_virtual() => {
            ResultColour::Neutral("the device is a live device")
        }
        (Colour::Red, _) => ResultColour::Red,
    }
}

/// The reasons why the run as a whole fails: nothing passed, a finding is an error, the ledger is wrong.
///
/// Known failures do not prove that a device works, so a whole run needs a pass; a part of a suite may consist of known failures
/// only.
pub fn reasons(result: &RunResult) -> Vec<String> {
    let mut reasons: Vec<String> = Vec::new();
    if result.runs.is_empty() {
        reasons.push("no device was tested".into());
    }
    for run in &result.runs {
        let has_trials = run.cases.iter().any(|case| case.kind == CaseKind::Trial);
        let counts = |case: &&CaseResult| case.kind == CaseKind::Trial || !has_trials;
        let good =
            |case: &CaseResult| case.verdict == Verdict::Pass || (run.filtered && case.verdict == Verdict::Xfail);
        if !run.cases.iter().filter(counts).any(good) {
            let (device, variant) = (&run.dut.device, &run.dut.variant);
            reasons.push(match run.dut.kind.as_str() {
                "model" => format!("nothing passed on {}", run.dut.spec),
                _ => format!("nothing passed on {} as {device}/{variant}", run.dut.spec),
            });
        }
    }
    reasons.extend(result.min_pass.into_iter().flat_map(|least| too_few_passed(result, least)));
    for run in &result.runs {
        let errors: Vec<&str> =
            run.findings.iter().filter(|of| of.severity == FindingSeverity::Error).map(|of| of.id.as_str()).collect();
        if !errors.is_empty() {
            let found = count(errors.len(), "finding", "findings");
            reasons.push(format!("{found} on {}: {}", run.dut.spec, errors.join(", ")));
        }
    }
    reasons.extend(result.ledger_notes.iter().filter(|note| note.red).map(|note| note.text.clone()));
    reasons
}

/// The devices of which fewer results than `least` passed, each in words.
fn too_few_passed(result: &RunResult, least: MinimumPass) -> impl Iterator<Item = String> {
    result.runs.iter().filter_map(move |run| {
        let passed = run.cases.iter().filter(|case| case.verdict == Verdict::Pass).count();
        let all = run.cases.len();
        let spec = &run.dut.spec;
        (!least.is_reached(passed, all))
            .then(|| format!("only {passed} of {all} results passed on {spec}, and --min-pass is {least}"))
    })
}

/// The exit status of the run.
pub fn status(result: &RunResult) -> ExitStatus {
    let red = |run: &DeviceRun| run.cases.iter().any(|case| result_colour(result, run, case) == ResultColour::Red);
    if reasons(result).is_empty() && !result.runs.iter().any(red) { ExitStatus::Green } else { ExitStatus::Red }
}
