//! A run: all selected trials of all devices under test, the rules over them, and the requirements.

use super::dut::DutSpec;
use super::environment::TrialEnvironment;
use super::live::RestoreOutcome;
use super::one_trial::environment;
use super::options::{RunOptions, RunProgress, TrialPart};
use super::outcome::{BenchError, TrialOutcome};
use super::plan::{DevicePlan, STOPPED};
use super::requirements::{self, level};
use super::{bus, causes, live_run, persona};
use judge::slow::SlowReaction;
use results::outcome::{
    BusStatistics, CaseKind, CaseResult, Covered, DecisionCounts, DeviceRun, Dut, RunPart, RunResult, never_decided,
};
use results::verdict::Verdict;
use suite::model::{Manual, SuiteRule, SuiteVariant};

/// Why nothing is judged on a device that is not of the claimed variant.
const NOT_CLAIMED: &str = "not judged: the device is not the claimed variant";

/// Runs the selected trials.
pub fn run(manuals: &[Manual], options: &RunOptions, progress: RunProgress<'_>) -> Result<RunResult, BenchError> {
    let mut plans = Vec::new();
    for dut in &options.duts {
        let own = dut.live().map(|live| live.manual());
        let found = own.or_else(|| manuals.iter().find(|manual| manual.device.name == dut.manual));
        let manual = found.ok_or_else(|| BenchError(format!("no suite for {}", dut.manual)))?;
        let variant = manual.variants.iter().find(|variant| variant.name == dut.variant);
        let variant = variant.ok_or_else(|| BenchError(format!("{} has no variant {}", dut.manual, dut.variant)))?;
        plans.push(DevicePlan::new(manual, variant, dut, options));
    }
    // Models need no real time, so their trials run in parallel; live devices follow one after the other.
    let models: Vec<&DevicePlan<'_>> = plans.iter().filter(|plan| plan.dut.live().is_none()).collect();
    let mut models = DevicePlan::run_together(&models, options, progress).into_iter();
    let part = options.part.map(|TrialPart { number, of }| RunPart { number, of });
    let mut result = RunResult { gate_must: options.gate_must, part, ..RunResult::default() };
    let mut is_stopped = false;
    for plan in &plans {
        let mut outcomes = if plan.dut.live().is_none() { models.next() } else { None };
        if outcomes.is_none() && is_stopped {
            outcomes = Some(plan.not_judged(STOPPED));
        }
        let run = device(plan, outcomes, options, progress)?;
        let stops = options.fail_fast.as_ref();
        is_stopped |= stops.is_some_and(|stops| run.cases.iter().any(|case| (stops.0)(plan.dut, case)));
        result.runs.push(run);
    }
    Ok(result)
}

/// The result of one device: its live trials are run here, those of a model are in `outcomes`.
fn device(
    plan: &DevicePlan<'_>,
    outcomes: Option<Vec<Result<TrialOutcome, String>>>,
    options: &RunOptions,
    progress: RunProgress<'_>,
) -> Result<DeviceRun, BenchError> {
    let DevicePlan { manual, variant, dut, for_rules, .. } = *plan;
    let selection = &options.selection;
    let environment = environment(dut, options, manual, None);
    let filtered = !selection.is_all() || options.part.is_some();
    let probed =
        dut.live().map(|live| live_run::probe_device(manual, variant, dut, live)).transpose().map_err(BenchError)?;
    let is_refuted = probed.as_ref().is_some_and(|probed| probed.refuted.is_some());
    let outcomes = match outcomes {
        Some(outcomes) => outcomes,
        None if is_refuted => plan.not_judged(NOT_CLAIMED),
        None => plan.run_alone(options, progress),
    };
    let mut restored = RestoreOutcome::default();
    if let (Some(live), Some(probed)) = (dut.live(), &probed) {
        restored = live_run::end(dut, live, probed);
    }
    let outcomes: Vec<TrialOutcome> = outcomes.into_iter().collect::<Result<_, String>>().map_err(BenchError)?;
    let identity = outcomes.iter().find_map(|outcome| outcome.identity.clone());
    // Every rule is judged on every trial that ran; a broken one is reported unless a filter excludes it.
    let mut judged = Vec::new();
    for (index, rule) in variant.rules.iter().enumerate() {
        let mut result = rule_result(manual, rule, index, &outcomes, filtered, &environment);
        if is_refuted {
            result.reason = Some(NOT_CLAIMED.to_owned());
        }
        let is_selected = selection.rule(manual, variant, rule);
        // Only all parts together show that a rule was never decided, so each part reports it.
        let is_whole = selection.is_all();
        let is_requested = is_selected && (for_rules || is_whole || result.verdict != Verdict::NotRun);
        if is_requested || (result.verdict == Verdict::Fail && !selection.excludes(manual, rule)) {
            judged.push(result);
        }
    }
    let mut findings = live_run::findings(dut, probed.as_ref(), restored);
    for finding in outcomes.iter().flat_map(|outcome| &outcome.findings) {
        // Several rows of a case may have the same finding.
        if !findings.contains(finding) {
            findings.push(finding.clone());
        }
    }
    let mut bus: Option<BusStatistics> = None;
    for measured in outcomes.iter().filter_map(|outcome| outcome.bus.as_ref()) {
        bus.get_or_insert_default().merge(measured);
    }
    let mut cases = Vec::new();
    let selected = plan.trials.iter().map(|trial| !for_rules || selection.trial(manual, variant, trial));
    cases.extend(
        outcomes.into_iter().zip(selected).filter(|(_, is_selected)| *is_selected).map(|(outcome, _)| outcome.case),
    );
    cases.extend(judged);
    let requirements = requirements::results(manual, variant, &cases);
    let causes = causes::causes(manual, variant, &cases);
    Ok(DeviceRun {
        dut: Dut {
            kind: dut.kind_word().to_owned(),
            spec: dut.to_string(),
            firmware: match &probed {
                Some(probed) => probed.firmware.clone(),
                None => firmware(plan.described(), variant, dut, &environment),
            },
            details: probed.map(|probed| probed.identification).unwrap_or_default(),
            device: dut.manual.clone(),
            variant: dut.variant.clone(),
            identity: identity
                .or_else(|| dut.live().map(|live| live.identity()))
                .unwrap_or_else(|| "no identity reported".to_owned()),
        },
        cases,
        requirements,
        filtered,
        persona: environment.persona.as_ref().map(|persona| persona.name.clone()),
        bugs: dut.bugs(),
        variations: dut.variations(),
        bug_notes: dut.bug_notes(),
        findings,
        causes,
        bus,
    })
}

/// Reads the firmware of the device in a separate connection.
fn firmware(manual: &Manual, variant: &SuiteVariant, dut: &DutSpec, environment: &TrialEnvironment) -> Option<String> {
    let trial = variant.trials.iter().find(|trial| trial.start().is_some())?;
    let segment = dut.segment(&trial.id, environment.line, manual.device.profibus().is_some()).ok()?;
    bus::trial(manual, variant, segment, trial, environment).firmware()
}

fn rule_result(
    manual: &Manual,
    rule: &SuiteRule,
    index: usize,
    outcomes: &[TrialOutcome],
    filtered: bool,
    environment: &TrialEnvironment,
) -> CaseResult {
    let persona = environment.persona.as_deref();
    let unfit = persona.and_then(|persona| persona::unfit_rule(persona, &manual.device, rule));
    let mut decided = DecisionCounts::default();
    let mut failures = Vec::new();
    let mut disturbed: Option<String> = None;
    let mut notes = Vec::new();
    let mut slow: Option<(SlowReaction, &str)> = None;
    for outcome in outcomes {
        let result = &outcome.rules[index];
        // A trial that did not pass does not count in favour of the device.
        if outcome.case.verdict == Verdict::Pass {
            decided.premises += result.decided.premises;
        }
        decided.undecided += result.decided.undecided;
        decided.checked += result.decided.checked;
        if let Some(late) = result.slow.filter(|_| !result.disturbed) {
            let trial = outcome.case.id.as_str();
            slow = Some(match slow {
                Some((before, known)) => (before.and(late), if late.took > before.took { trial } else { known }),
                None => (late, trial),
            });
        }
        match &result.broken {
            Some((_, failure)) if result.disturbed => {
                disturbed.get_or_insert_with(|| failure.what.clone());
            }
            Some((_, failure)) if failures.is_empty() => {
                failures.push(failure.clone());
                notes.extend(outcome.likely_reading.clone());
            }
            _ => {}
        }
    }
    if unfit.is_some() {
        failures.clear();
    }
    let (verdict, reason) = match (failures.first(), decided.premises) {
        _ if unfit.is_some() => (Verdict::NotApplicable, unfit),
        (Some(failure), _) => (Verdict::Fail, Some(failure.what.clone())),
        (None, _) if disturbed.is_some() => (
            Verdict::Inconclusive,
            disturbed.map(|what| format!("{what} This trial was disturbed, so it says nothing about the device.")),
        ),
        (None, 0) if persona.is_some() => {
            let name = persona.map(|persona| persona.name.as_str()).unwrap_or_default();
            (Verdict::NotApplicable, Some(format!("persona {name}: the premise never occurred")))
        }
        // What a device without a manual lacks, no case brings about.
        (None, 0) if environment.is_other_model => {
            let why = "only its description says what the device has, and the premise never occurred";
            (Verdict::NotApplicable, Some(why.to_owned()))
        }
        (None, 0) => (Verdict::NotRun, Some(never_decided(&decided, filtered))),
        (None, _) => (Verdict::Pass, None),
    };
    notes.extend(slow.and_then(|(slow, trial)| slow.note_of_rule(rule, Some(trial))));
    let covers: Vec<Covered> = rule
        .covers
        .iter()
        .map(|&requirement| Covered { requirement, id: manual.requirements[requirement].id.clone(), verdict })
        .collect();
    let id = format!("{}/{}", manual.device.name, rule.id);
    let judged = (verdict, level(manual, &covers, verdict));
    let result = CaseResult::new(id, CaseKind::Rule, rule.why.clone(), judged, rule.at.clone());
    CaseResult { covers, reason, failures, notes, decided: Some(decided), frames: decided.checked, ..result }
}
