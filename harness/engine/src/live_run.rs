//! What a live run does before and after its trials: reads the state of the device, restores it, and reports findings.
//!
//! This module must not know how a single trial is run.

use super::bus;
use super::described::described;
use super::dut::DutSpec;
use super::live::{DeviceBackup, LiveDevice, RestoreOutcome, SequenceLimits, TrialExclusion};
use super::outcome::{BenchError, TrialOutcome, TrialRuleResult};
use super::requirements::level;
use super::scan::check_covers;
use super::trial::RunningTrial;
use super::trial::probe::ProbedDevice;
use description::gsdml::SensorFormat;
use description::variant::{VariantReading, candidates, refuted_claim};
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
    let (verdict, reason, bench_lines) = match excluded {
        TrialExclusion::NotApplicable { why, lines } => (Verdict::NotApplicable, why, lines),
        TrialExclusion::Inconclusive(why) => (Verdict::Inconclusive, why, Vec::new()),
        TrialExclusion::NotRun(why) => (Verdict::NotRun, why, Vec::new()),
    };
    let mut covers: Vec<Covered> = Vec::new();
    for requirement in trial.covers.iter().copied().chain(check_covers(trial)) {
        if covers.iter().all(|known| known.requirement != requirement) {
            covers.push(Covered { requirement, id: manual.requirements[requirement].id.clone(), verdict });
        }
    }
    let id = format!("{}/{}", manual.device.name, trial.id);
    let judged = (verdict, level(manual, &covers, verdict));
    let result = CaseResult::new(id, CaseKind::Trial, trial.why.clone(), judged, trial.at.clone());
    let case = CaseResult { covers, reason: Some(reason), bench_lines, ..result };
    let not_judged = TrialRuleResult { decided: DecisionCounts::default(), broken: None, slow: None, disturbed: false };
    TrialOutcome {
        case,
        rules: vec![not_judged; variant.rules.len()],
        findings: Vec::new(),
        identity: None,
        disturbed: None,
        likely_reading: None,
        bus: None,
        trace: Trace::new(),
        log: None,
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
    let notes = dut.live().zip(looked).map_or(Vec::new(), |(live, looked)| end(dut, live, &looked).left);
    Ok((done, notes))
}

/// Runs `work`, which draws sequences within `limits`, with a live device. Its state is read before and restored after, as in a run;
/// returns what was not restored.
///
/// # Errors
///
/// The device must not be touched, or is not of the claimed variant; the text says why.
pub fn with_claimed_device<R>(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    limits: SequenceLimits,
    work: impl FnOnce() -> R,
) -> Result<(R, RestoreOutcome), String> {
    let live = dut.live().ok_or_else(|| format!("{dut} is not a live device"))?;
    if let Some(why) = live.passive() {
        return Err(format!("the device is only read: {why}"));
    }
    let probed = probe_device(manual, variant, dut, live)?;
    if let Some(refuted) = &probed.refuted {
        let why = format!("the device is not the claimed variant: {}", refuted.text);
        let left = end(dut, live, &probed).left;
        return Err([vec![why], left].concat().join(" "));
    }
    live.limit_changes(Some(limits));
    let done = work();
    live.limit_changes(None);
    Ok((done, end(dut, live, &probed)))
}

/// Reads the state of a live device before the first trial, and notes its parameters in the journal.
pub(super) fn probe_device(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    live: &dyn LiveDevice,
) -> Result<ProbedDevice, String> {
    let mut looked = ProbedDevice { refuted: refuted(manual, variant, dut, live)?, ..ProbedDevice::default() };
    if looked.refuted.is_none() && live.passive().is_none() {
        looked = with_run(manual, variant, dut, |run| run.probe(live.bench()))?;
    }
    live.note(&JournalEntry::Parameters(looked.parameters.clone()))?;
    live.note(&JournalEntry::ImRecords(looked.im_records.clone()))?;
    Ok(looked)
}

/// The finding that a live device is not of the claimed variant. It is asked in a connection only if what is known leaves the claim open.
fn refuted(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    live: &dyn LiveDevice,
) -> Result<Option<DeviceFinding>, String> {
    let device = &manual.device;
    let claimed = device.variants.iter().position(|known| *known == variant.name).unwrap_or_default();
    let mut readings = live.variant_readings().to_vec();
    let is_open = !readings.iter().any(|reading| reading.speaks_of_device());
    if is_open && live.passive().is_none() {
        readings.extend(with_run(manual, variant, dut, |run| run.variant_readings())?);
    }
    Ok(refuted_claim(device, claimed, &readings))
}

/// What a live device and its description report about its variant, read before anything is judged, and remarks on its restoration.
///
/// It is connected only if what it reports otherwise leaves several variants; a description alone proves nothing.
///
/// # Errors
///
/// The device cannot be used; the text says why.
pub fn identify_live_variant(dut: &DutSpec) -> Result<(Vec<VariantReading>, Vec<String>), BenchError> {
    let live = dut.live().ok_or_else(|| BenchError(format!("{dut} is not a live device")))?;
    let manual = live.manual();
    let variant = manual.variants.iter().find(|variant| variant.name == dut.variant);
    let variant = variant.ok_or_else(|| BenchError(format!("{} has no variant {}", dut.manual, dut.variant)))?;
    let mut readings = live.variant_readings().to_vec();
    let of_device: Vec<VariantReading> = readings.iter().filter(|of| of.speaks_of_device()).cloned().collect();
    if candidates(&manual.device, &of_device).len() > 1 && live.passive().is_none() {
        readings.extend(with_run(manual, variant, dut, |run| run.variant_readings()).map_err(BenchError)?);
    }
    let RestoreOutcome { left, remarks } = end(dut, live, &ProbedDevice::default());
    Ok((readings, [left, remarks].concat()))
}

/// Connects to a device and reads by what it shows its variant; nothing is judged.
///
/// # Errors
///
/// There is no such device, or the manual has no case.
pub fn variant_readings(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
) -> Result<Vec<VariantReading>, BenchError> {
    with_run(manual, variant, dut, |run| run.variant_readings()).map_err(BenchError)
}

/// What a device says in P979 of its sensor, read in a connection of its own; `None` if it does not say it.
///
/// # Errors
///
/// There is no such device, or the manual has no case.
pub fn sensor_format(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
) -> Result<Option<SensorFormat>, BenchError> {
    let described = described(manual, dut);
    with_run(described.as_ref().unwrap_or(manual), variant, dut, |run| run.sensor_format()).map_err(BenchError)
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
    let segment = dut.segment(&trial.id, environment.line, manual.device.profibus().is_some())?;
    Ok(work(&mut bus::trial(manual, variant, segment, trial, &environment)))
}

/// Ends a live run: restores what was changed and notes it in the journal. Each sentence says what was not restored or what was
/// assumed.
pub(super) fn end(dut: &DutSpec, live: &dyn LiveDevice, looked: &ProbedDevice) -> RestoreOutcome {
    let changes = live.changes();
    if changes.is_empty() {
        return RestoreOutcome::default();
    }
    let kept = DeviceBackup { parameters: &looked.parameters, im_records: &looked.im_records, changes: &changes };
    let restored = restore_device(dut, live.found(), &kept);
    let mut outcome =
        restored.unwrap_or_else(|error| RestoreOutcome { left: vec![error.to_string()], remarks: Vec::new() });
    if !outcome.left.is_empty() {
        let left = outcome.left.join("; ");
        outcome.left = vec![format!("Not restored: {left}. Run `encspec bench restore` to try again.")];
    } else if let Err(why) = note_restored(live, &outcome.remarks) {
        outcome.left.push(why);
    }
    outcome
}

/// Closes the journal of a device that was restored.
pub fn note_restored(live: &dyn LiveDevice, remarks: &[String]) -> Result<(), String> {
    remarks.iter().try_for_each(|text| live.note(&JournalEntry::Remark { text: text.clone() }))?;
    live.note(&JournalEntry::Restored)
}

/// The findings about the device outside of its cases.
pub(super) fn findings(dut: &DutSpec, looked: Option<&ProbedDevice>, restored: RestoreOutcome) -> Vec<DeviceFinding> {
    // What else disagrees with a wrong claim says nothing of the device.
    let refuted = looked.and_then(|looked| looked.refuted.clone());
    let of_claim = || dut.live().map(|live| live.findings().to_vec()).unwrap_or_default();
    let before = refuted.map_or_else(of_claim, |refuted| vec![refuted]);
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
    let left = restored.left.into_iter().map(|text| remark(FindingSeverity::Error, "put-back", text));
    let assumed = restored.remarks.into_iter().map(|text| remark(FindingSeverity::Info, "put-back", text));
    before
        .into_iter()
        .chain(looked.map(|looked| looked.findings.clone()).unwrap_or_default())
        .chain(notes)
        .chain(passive)
        .chain(left)
        .chain(assumed)
        .collect()
}

/// Restores a live device to the state in its journal, by the suite of the device that it claims to be; returns what could not be
/// restored, in words.
pub fn restore_device(
    dut: &DutSpec,
    found: &InitialDevice,
    kept: &DeviceBackup<'_>,
) -> Result<RestoreOutcome, BenchError> {
    let live = dut.live().ok_or_else(|| BenchError(format!("{dut} is not a live device")))?;
    let manual = live.manual();
    let variant = manual.variants.iter().find(|variant| variant.name == dut.variant);
    let variant = variant.ok_or_else(|| BenchError(format!("{} has no variant {}", dut.manual, dut.variant)))?;
    with_run(manual, variant, dut, |run| run.restore(found, kept)).map_err(BenchError)
}
