//! What differs between two runs: what fails now and did not, what passes now, what was read or explained otherwise, what is slower.
//!
//! Only what the device did is compared: no time of the host, no frame number, no path. Durations are compared where both are of the
//! virtual clock. Both runs are judged by the gate and options of the newer one.

mod json;
mod page;
mod text;

use super::status::{ResultColour, reasons, result_colour};
use results::ledger;
use results::outcome::{CaseResult, DeviceFinding, DeviceRun, FindingSeverity, RunResult};
use results::verdict::Verdict;
use std::time::Duration;

/// A virtual run is slower from so many times its duration before.
const SLOWER: (u32, u32) = (3, 2);
/// Differences below this are not reported.
const LEAST_DIFFERENCE: Duration = Duration::from_millis(10);

/// How a result differs, in the order of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChangeKind {
    /// It is red and was not.
    NewlyFails,
    /// It passed, and now it is not run, not applicable or not there.
    NoLongerTested,
    /// It has another verdict.
    OtherVerdict,
    /// It is red as before, for another reason.
    OtherReason,
    /// It passes as before, by another reading of the manual.
    OtherReading,
    /// It is later than before.
    Slower,
    /// It passes and did not.
    NewlyPasses,
}

impl ChangeKind {
    /// Every kind.
    pub const ALL: [ChangeKind; 7] = [
        ChangeKind::NewlyFails,
        ChangeKind::NoLongerTested,
        ChangeKind::OtherVerdict,
        ChangeKind::OtherReason,
        ChangeKind::OtherReading,
        ChangeKind::Slower,
        ChangeKind::NewlyPasses,
    ];

    /// The heading in reports.
    pub fn heading(self) -> &'static str {
        match self {
            ChangeKind::NewlyFails => "newly fails",
            ChangeKind::NoLongerTested => "no longer tested",
            ChangeKind::OtherVerdict => "other verdict",
            ChangeKind::OtherReason => "other reason",
            ChangeKind::OtherReading => "other reading",
            ChangeKind::Slower => "slower",
            ChangeKind::NewlyPasses => "newly passes",
        }
    }

    /// Whether it makes a comparison red.
    pub fn is_regression(self) -> bool {
        matches!(self, ChangeKind::NewlyFails | ChangeKind::NoLongerTested)
    }
}

/// One result that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResultChange {
    pub kind: ChangeKind,
    /// The id of the case or rule.
    pub id: String,
    /// Its requirements.
    pub covers: Vec<String>,
    /// What it was and why; `None` if it was not there.
    pub before: Option<String>,
    /// What it is and why; `None` if it is not there.
    pub after: Option<String>,
}

/// What differs on one device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceDiff {
    /// The manual and variant, and the persona if there is one.
    pub device: String,
    /// Firmware and identity before and after, where they differ: name, before, after.
    pub facts: Vec<(&'static str, String, String)>,
    /// The results that differ, in the order of [`ChangeKind`] and of the suite.
    pub changes: Vec<ResultChange>,
    /// The requirements whose status differs: id, before, after.
    pub requirements: Vec<(String, Verdict, Verdict)>,
    /// Errors that manual, description and device do not agree, which were not there before.
    pub new_errors: Vec<String>,
    /// How many results are the same in both.
    pub same: usize,
    /// How many results of the older run were left out by a filter of the newer one.
    pub left_out: usize,
}

/// What differs between two runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunDiff {
    pub devices: Vec<DeviceDiff>,
    /// Devices that only the older run has.
    pub gone: Vec<String>,
    /// Devices that only the newer run has.
    pub added: Vec<String>,
    /// Why the newer run as a whole is red and the older one was not.
    pub reasons: Vec<String>,
    /// What limits the comparison, for instance different versions of encspec.
    pub notes: Vec<String>,
}

impl RunDiff {
    /// Compares two runs; `versions` are those of encspec that made them. `None` if they have no device in common.
    pub fn of(before: &RunResult, after: &RunResult, versions: [&str; 2]) -> Option<RunDiff> {
        let before = RunResult {
            gate_must: after.gate_must,
            fail_on_not_applicable: after.fail_on_not_applicable,
            accept_flaky: after.accept_flaky,
            ..before.clone()
        };
        let mut diff = RunDiff::default();
        let mut rest: Vec<&DeviceRun> = before.runs.iter().collect();
        for run in &after.runs {
            match rest.iter().position(|old| name(old) == name(run)) {
                Some(at) => diff.devices.push(device((&before, rest.remove(at)), (after, run))),
                None => diff.added.push(name(run)),
            }
        }
        diff.gone = rest.into_iter().map(name).collect();
        let known = reasons(&before);
        diff.reasons = reasons(after).into_iter().filter(|reason| !known.contains(reason)).collect();
        let [old, new] = [(&before, versions[0]), (after, versions[1])].map(|(of, version)| match &of.origin.commit {
            Some(commit) => format!("{version} ({commit})"),
            None => version.to_owned(),
        });
        if old != new {
            diff.notes.push(format!("The runs are of encspec {old} and {new}, whose suites may differ."));
        }
        (!diff.devices.is_empty()).then_some(diff)
    }

    /// Whether anything is worse than before.
    pub fn is_regression(&self) -> bool {
        let of_device =
            |of: &DeviceDiff| of.changes.iter().any(|change| change.kind.is_regression()) || !of.new_errors.is_empty();
        !self.reasons.is_empty() || !self.gone.is_empty() || self.devices.iter().any(of_device)
    }

    /// The number of results of this kind.
    pub fn count(&self, kind: ChangeKind) -> usize {
        self.devices.iter().flat_map(|of| &of.changes).filter(|change| change.kind == kind).count()
    }
}

fn name(run: &DeviceRun) -> String {
    let persona = run.persona.iter().map(|persona| format!(" with persona {persona}"));
    format!("{}/{}{}", run.dut.device, run.dut.variant, persona.collect::<String>())
}

fn device(before: (&RunResult, &DeviceRun), after: (&RunResult, &DeviceRun)) -> DeviceDiff {
    let (old, new) = (before.1, after.1);
    let mut changes = Vec::new();
    let (mut same, mut left_out) = (0, 0);
    for case in &new.cases {
        let known = old.cases.iter().find(|known| known.id == case.id);
        match kind_of(known.map(|known| (before, known)), Some((after, case))) {
            Some(kind) => changes.push(change(kind, known, Some(case))),
            None => same += 1,
        }
    }
    for known in &old.cases {
        if new.cases.iter().any(|case| case.id == known.id) {
            continue;
        }
        match kind_of(Some((before, known)), None) {
            _ if new.filtered => left_out += 1,
            Some(kind) => changes.push(change(kind, Some(known), None)),
            None => {}
        }
    }
    changes.sort_by_key(|change| change.kind);
    let status = |of: &DeviceRun, id: &str| of.requirements.iter().find(|known| known.id == id).map(|of| of.verdict);
    let requirements = new.requirements.iter().filter_map(|of| {
        let known = status(old, &of.id)?;
        (known != of.verdict).then(|| (of.id.clone(), known, of.verdict))
    });
    let is_error = |of: &&DeviceFinding| of.severity == FindingSeverity::Error;
    let errors = new.findings.iter().filter(is_error);
    let new_errors = errors.filter(|of| !old.findings.iter().any(|known| known.id == of.id && is_error(&known)));
    let text = |of: &Option<String>| of.clone().unwrap_or_else(|| "unknown".to_owned());
    let facts = [
        ("firmware", text(&old.dut.firmware), text(&new.dut.firmware)),
        ("identity", old.dut.identity.clone(), new.dut.identity.clone()),
        ("bugs", old.bugs.join(", "), new.bugs.join(", ")),
        ("variations", old.variations.join(", "), new.variations.join(", ")),
    ];
    DeviceDiff {
        device: name(new),
        facts: facts.into_iter().filter(|(_, old, new)| old != new).collect(),
        requirements: requirements.collect(),
        new_errors: new_errors.map(|of| format!("{}: {}", of.id, of.text)).collect(),
        changes,
        same,
        left_out,
    }
}

fn change(kind: ChangeKind, before: Option<&CaseResult>, after: Option<&CaseResult>) -> ResultChange {
    let of = after.or(before);
    let said = |case: &CaseResult| match kind {
        ChangeKind::OtherReading => readings(case),
        ChangeKind::Slower => slowness(case),
        _ => outcome(case),
    };
    ResultChange {
        kind,
        id: of.map(|case| case.id.clone()).unwrap_or_default(),
        covers: of.into_iter().flat_map(|case| &case.covers).map(|covered| covered.id.clone()).collect(),
        before: before.map(said),
        after: after.map(said),
    }
}

/// How a result differs; `None` if it is the same.
fn kind_of(
    before: Option<((&RunResult, &DeviceRun), &CaseResult)>,
    after: Option<((&RunResult, &DeviceRun), &CaseResult)>,
) -> Option<ChangeKind> {
    let is_red = |((result, run), case): ((&RunResult, &DeviceRun), &CaseResult)| {
        result_colour(result, run, case) == ResultColour::Red
    };
    let is_tested = |case: &CaseResult| !matches!(case.verdict, Verdict::NotApplicable | Verdict::NotRun);
    let (before, after) = match (before, after) {
        (None, None) => return None,
        // A case that was not there has no result that could be worse, unless it is red.
        (None, Some(after)) => return is_red(after).then_some(ChangeKind::NewlyFails),
        (Some((_, old)), None) => return is_tested(old).then_some(ChangeKind::NoLongerTested),
        (Some(before), Some(after)) => (before, after),
    };
    let (was_red, red) = (is_red(before), is_red(after));
    let (old, new) = (before.1, after.1);
    if red && !was_red {
        return Some(ChangeKind::NewlyFails);
    }
    if is_tested(old) && !is_tested(new) {
        return Some(ChangeKind::NoLongerTested);
    }
    if old.verdict != new.verdict {
        let passes = new.verdict == Verdict::Pass;
        return Some(if passes { ChangeKind::NewlyPasses } else { ChangeKind::OtherVerdict });
    }
    if new.verdict != Verdict::Pass && compared(old) != compared(new) {
        return Some(ChangeKind::OtherReason);
    }
    if old.readings != new.readings {
        return Some(ChangeKind::OtherReading);
    }
    let is_virtual = before.0.1.is_virtual() && after.0.1.is_virtual();
    is_slower(old, new, is_virtual).then_some(ChangeKind::Slower)
}

fn is_slower(old: &CaseResult, new: &CaseResult, is_virtual: bool) -> bool {
    let is_longer = new.duration * SLOWER.1 >= old.duration * SLOWER.0;
    let is_much = new.duration.saturating_sub(old.duration) >= LEAST_DIFFERENCE;
    // On a live device the duration is that of this host as well; that it is later than a limit is not.
    old.slow().next().is_none() && new.slow().next().is_some() || is_virtual && is_longer && is_much
}

/// Verdict and reason in words.
fn outcome(case: &CaseResult) -> String {
    let flaky = case.passed_in_attempt.map(|attempt| format!(", flaky: it passed in attempt {attempt}"));
    let reason = case.reason.iter().map(|reason| format!(": {reason}"));
    format!("{}{}{}", case.verdict, flaky.unwrap_or_default(), reason.collect::<String>())
}

fn readings(case: &CaseResult) -> String {
    let each: Vec<String> = case.readings.iter().map(|(step, reading)| format!("{reading} ({step})")).collect();
    if each.is_empty() { "no reading".to_owned() } else { each.join("; ") }
}

fn slowness(case: &CaseResult) -> String {
    let late: Vec<&str> = case.slow().collect();
    if late.is_empty() { format!("{:.3} s", case.duration.as_secs_f64()) } else { late.join("; ") }
}

/// What is compared of a result that did not pass: the signatures of its failures, or its reason without times and frame numbers.
fn compared(case: &CaseResult) -> (Vec<String>, String) {
    let signatures: Vec<String> = case.failures.iter().map(|of| without_times(&ledger::signature(of))).collect();
    let reason = if signatures.is_empty() { case.reason.as_deref().unwrap_or_default() } else { "" };
    (signatures, without_times(reason))
}

/// The text with `#` for each time, frame number and count of frames: these differ from run to run.
fn without_times(text: &str) -> String {
    const UNITS: [&str; 8] = ["ns", "us", "µs", "ms", "s", "seconds", "frames", "samples"];
    let mut words: Vec<String> = Vec::new();
    let mut after_frame = false;
    for word in text.split(' ') {
        let digits = word.trim_end_matches(|c: char| !c.is_ascii_digit());
        let unit = word[digits.len()..].trim_end_matches(['.', ',', ';', ')', ':']);
        let is_number = !digits.is_empty() && digits.bytes().all(|octet| octet.is_ascii_digit() || octet == b'.');
        let is_frame = after_frame && is_number;
        if is_number && (is_frame || UNITS.contains(&unit)) {
            words.push(format!("#{}", &word[digits.len()..]));
        } else if UNITS.contains(&word.trim_end_matches(['.', ',', ';', ')', ':']))
            && words.last().is_some_and(|last| last.bytes().all(|octet| octet.is_ascii_digit() || octet == b'.'))
        {
            words.pop();
            words.push(format!("# {word}"));
        } else {
            words.push(word.to_owned());
        }
        after_frame = matches!(word, "frame" | "frames");
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::without_times;
    use rstest::rstest;

    #[rstest]
    #[case("the harness was 22.651407ms late, more than 4ms.", "the harness was #ms late, more than #ms.")]
    #[case("in frame 41: 0x1000 (4096)", "in frame #: 0x1000 (4096)")]
    #[case("never occurred in 4312 frames and events", "never occurred in # frames and events")]
    #[case("expect: { position: 100 }, for: 5 ms", "expect: { position: 100 }, for: # ms")]
    #[case("G1_XIST1: 100", "G1_XIST1: 100")]
    #[case("byte 3 is 12 and not 13", "byte 3 is 12 and not 13")]
    fn times_and_frame_numbers_are_not_compared(#[case] text: &str, #[case] compared: &str) {
        assert_eq!(without_times(text), compared);
    }
}
