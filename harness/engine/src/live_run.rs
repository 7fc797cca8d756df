//! What a live run does before and after its trials: reads the state of the device, restores it, and reports findings.
//!
//! This module must not know how a single trial is run.

use super::bus;
use super::dut::DutSpec;
use super::live::{LiveDevice, ParameterBackup, TrialExclusion};
use super::outcome::{BenchError, TrialOutcome, TrialRuleResult};
use super::requirements::level;
use super::scan::check_covers;
use super::trial::RunningTrial;
use super::trial::probe::ProbedDevice;
use results::journal::{InitialDevice, JournalEntry};
use results::outcome::{CaseKind, CaseResult, Covered, DecisionCounts, DeviceFinding, FindingSeverity};
use results::verdict::Verdict;
use suite::model::{Manual, SuiteVariant, Trial};
use virtual_wire::Trace;

/// The outcome of a trial that does not run on this bench.
pub(super) fn not_run(
    manual: &Manual,
    variant: &SuiteVariant,
    trial: &Trial,
    excluded: TrialExclusion,
) -> TrialOutcome {
    let (verdict, reason) = match excluded {
        TrialExclusion::NotApplicable(why) => (Verdict::NotApplicable, why),
        TrialExclusion::Inconclusive(why) => (Verdict::Inconclusive, why),
        TrialExclusion::NotRun(why) => (Verdict::NotRun, why),
    };
    let mut covers: Vec<Covered> = Vec::new();
    for requirement in trial.covers.iter().copied().chain(check_covers(trial)) {
        if covers.iter().all(|known| known.requirement != requirement) {
            covers.push(Covered { requirement, id: manual.requirements[requirement].id.clone(), verdict });
        }
    }
    let case = CaseResult {
        id: format!("{}/{}", manual.device.name, trial.id),
        kind: CaseKind::Trial,
        why: trial.why.clone(),
        verdict,
        level: level(manual, &covers, verdict),
        covers,
        reason: Some(reason),
        failures: Vec::new(),
        readings: Vec::new(),
        saved: Vec::new(),
        notes: Vec::new(),
        decided: None,
        duration: std::time::Duration::ZERO,
        frames: 0,
        at: trial.at.clone(),
        evidence: None,
    };
    let not_judged = TrialRuleResult { decided: DecisionCounts::default(), broken: None, slow: None, disturbed: false };
    TrialOutcome {
        case,
        rules: vec![not_judged; variant.rules.len()],
        findings: Vec::new(),
        identity: None,
        disturbed: None,
        likely_reading: None,
        trace: Trace::new(),
    }
}

/// Runs `work` with a device. The state of a live device is read before and restored after, as in a run; returns the remarks on it.
///
/// # Errors
///
/// The live device must not be touched; the text says why.
pub fn with_restored_device<R>(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    work: impl FnOnce() -> R,
) -> Result<(R, Vec<String>), String> {
    let looked = dut.live().map(|live| probe_device(manual, variant, dut, live)).transpose()?;
    let done = work();
    let notes = dut.live().zip(looked).map_or(Vec::new(), |(live, looked)| end(dut, live, &looked));
    Ok((done, notes))
}

/// Reads the state of a live device before the first trial, and notes its parameters in the journal.
pub(super) fn probe_device(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    live: &dyn LiveDevice,
) -> Result<ProbedDevice, String> {
    let mut looked = ProbedDevice::default();
    if live.passive().is_none() {
        looked = with_run(manual, variant, dut, |run| run.probe(live.bench()))?;
    }
    live.note(&JournalEntry::Parameters(looked.parameters.clone()))?;
    Ok(looked)
}

/// Does `work` with a device under test outside of any trial.
fn with_run<R>(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    work: impl FnOnce(&mut RunningTrial<'_>) -> R,
) -> Result<R, String> {
    let mut environment = dut.environment();
    // Each call has its own identifiers, else the device takes its requests for repetitions of the call before.
    environment.seed = environment.seed.wrapping_add(dut.live().map_or(0, |live| live.next_call()));
    let trial = variant.trials.first().ok_or_else(|| format!("{} has no case", manual.device.name))?;
    let segment = dut.segment(&trial.id, environment.line)?;
    Ok(work(&mut bus::trial(manual, variant, segment, trial, &environment)))
}

/// Ends a live run: restores what was changed and reports what could not be restored.
pub(super) fn end(dut: &DutSpec, live: &dyn LiveDevice, looked: &ProbedDevice) -> Vec<String> {
    if !live.has_changed() {
        return Vec::new();
    }
    let left = match restore_device(dut, live.found(), &live.parameter_backup(&looked.parameters)) {
        Ok(left) if left.is_empty() => return live.note(&JournalEntry::Restored).err().into_iter().collect(),
        Ok(left) => left.join(", "),
        Err(error) => error.to_string(),
    };
    vec![format!("Not restored: {left}. Run `encspec bench restore` to try again.")]
}

/// The findings about the device outside of its cases.
pub(super) fn findings(dut: &DutSpec, looked: Option<&ProbedDevice>, left: Vec<String>) -> Vec<DeviceFinding> {
    let before = dut.live().map(|live| live.findings().to_vec()).unwrap_or_default();
    let remark = |severity: FindingSeverity, id: &str, text: String| DeviceFinding {
        id: id.to_owned(),
        severity,
        text,
        manual: None,
        description: None,
        device: None,
    };
    let passive = dut.live().and_then(|live| live.passive()).map(|why| {
        remark(
            FindingSeverity::Error,
            "passive",
            format!("Only reading cases were run, so this is not a verdict on the device: {why}."),
        )
    });
    let notes = dut.live().map(|live| live.notes().to_vec()).unwrap_or_default();
    let notes = notes.into_iter().map(|text| remark(FindingSeverity::Info, "bench", text));
    let left = left.into_iter().map(|text| remark(FindingSeverity::Error, "put-back", text));
    before
        .into_iter()
        .chain(looked.map(|looked| looked.findings.clone()).unwrap_or_default())
        .chain(notes)
        .chain(passive)
        .chain(left)
        .collect()
}

/// Restores a live device to the state in its journal, by the suite of the device that it claims to be; returns what could not be
/// restored, in words.
pub fn restore_device(
    dut: &DutSpec,
    found: &InitialDevice,
    kept: &ParameterBackup<'_>,
) -> Result<Vec<String>, BenchError> {
    let live = dut.live().ok_or_else(|| BenchError(format!("{dut} is not a live device")))?;
    let manual = live.manual();
    let variant = manual.variants.iter().find(|variant| variant.name == dut.variant);
    let variant = variant.ok_or_else(|| BenchError(format!("{} has no variant {}", dut.manual, dut.variant)))?;
    with_run(manual, variant, dut, |run| run.restore(found, kept)).map_err(BenchError)
}
