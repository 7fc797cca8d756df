//! A run: every selected trial of every device under test, its rules over all of them, and the requirements at the end.

use super::dut::DutSpec;
use super::one_trial::place;
use super::options::{Progress, RunOptions, selects};
use super::outcome::{BenchError, TrialOutcome};
use super::place::Place;
use super::plan::Plan;
use super::requirements::{self, level};
use super::{around, bus, persona};
use results::outcome::{CaseKind, CaseResult, Covered, Decided, DeviceRun, Dut, RunResult};
use results::verdict::Verdict;
use suite::model::{Manual, Rule, Variant};
use suite::persona::Persona;

/// Runs what is asked for.
pub fn run(manuals: &[Manual], options: &RunOptions, progress: Progress<'_>) -> Result<RunResult, BenchError> {
    let mut plans = Vec::new();
    for dut in &options.duts {
        let own = dut.live().map(|live| live.manual());
        let found = own.or_else(|| manuals.iter().find(|manual| manual.device.name == dut.manual));
        let manual = found.ok_or_else(|| BenchError(format!("there is no suite for {}", dut.manual)))?;
        let variant = manual.variants.iter().find(|variant| variant.name == dut.variant);
        let variant = variant.ok_or_else(|| BenchError(format!("{} has no variant {}", dut.manual, dut.variant)))?;
        plans.push(Plan::new(manual, variant, dut, options));
    }
    // Models wait for nobody, so the trials of all of them are one heap of work; live devices have their turn afterwards.
    let ahead: Vec<&Plan<'_>> = plans.iter().filter(|plan| plan.dut.live().is_none()).collect();
    let mut ahead = Plan::run_together(&ahead, options, progress).into_iter();
    let mut result = RunResult { gate_must: options.gate_must, ..RunResult::default() };
    for plan in &plans {
        let outcomes = if plan.dut.live().is_none() { ahead.next() } else { None };
        result.runs.push(device(plan, outcomes, options, progress)?);
    }
    Ok(result)
}

/// What one device came to: its live trials are run here, those of a model come in `outcomes`.
fn device(
    plan: &Plan<'_>,
    outcomes: Option<Vec<Result<TrialOutcome, String>>>,
    options: &RunOptions,
    progress: Progress<'_>,
) -> Result<DeviceRun, BenchError> {
    let Plan { manual, variant, dut, only_rules, .. } = *plan;
    let is_selected = |rule: &Rule| selects(options, manual, &rule.id);
    let place = place(dut, options, manual, None);
    let filtered = options.filter.is_some() || options.part.is_some();
    let looked =
        dut.live().map(|live| around::look_around(manual, variant, dut, live)).transpose().map_err(BenchError)?;
    let outcomes = outcomes.unwrap_or_else(|| plan.run_alone(options, progress));
    let mut notes = Vec::new();
    if let (Some(live), Some(looked)) = (dut.live(), &looked) {
        notes = around::end(dut, live, looked);
    }
    let outcomes: Vec<TrialOutcome> = outcomes.into_iter().collect::<Result<_, String>>().map_err(BenchError)?;
    let identity = outcomes.iter().find_map(|outcome| outcome.identity.clone());
    // Every rule is judged on every trial that ran; a broken one is told whatever the filter says.
    let mut judged = Vec::new();
    for (index, rule) in variant.rules.iter().enumerate() {
        let result = rule_result(manual, rule, index, &outcomes, filtered, place.persona.as_deref());
        let asked_for = is_selected(rule) && (only_rules || !filtered || result.verdict != Verdict::NotRun);
        if asked_for || result.verdict == Verdict::Fail {
            judged.push(result);
        }
    }
    let mut findings = around::findings(dut, looked.as_ref(), notes);
    for finding in outcomes.iter().flat_map(|outcome| &outcome.findings) {
        // The rows of a case find the same.
        if !findings.contains(finding) {
            findings.push(finding.clone());
        }
    }
    let mut cases = Vec::new();
    if !only_rules {
        cases.extend(outcomes.into_iter().map(|outcome| outcome.case));
    }
    cases.extend(judged);
    let requirements = requirements::results(manual, variant, &cases);
    Ok(DeviceRun {
        dut: Dut {
            kind: dut.kind_word().to_owned(),
            spec: dut.to_string(),
            firmware: match &looked {
                Some(looked) => looked.firmware.clone(),
                None => firmware(manual, variant, dut, &place),
            },
            device: dut.manual.clone(),
            variant: dut.variant.clone(),
            identity: identity
                .or_else(|| dut.live().map(|live| live.identity()))
                .unwrap_or_else(|| "nobody said who he is".to_owned()),
        },
        cases,
        requirements,
        filtered,
        persona: place.persona.as_ref().map(|persona| persona.name.clone()),
        bugs: dut.bugs(),
        variations: dut.variations(),
        bug_notes: dut.bug_notes(),
        findings,
    })
}

/// Asks the device for its firmware in a connection of its own.
fn firmware(manual: &Manual, variant: &Variant, dut: &DutSpec, place: &Place) -> Option<String> {
    let trial = variant.trials.iter().find(|trial| trial.start().is_some())?;
    bus::trial(manual, variant, dut.segment(&trial.id, place.line).ok()?, trial, place).firmware()
}

fn rule_result(
    manual: &Manual,
    rule: &Rule,
    index: usize,
    outcomes: &[TrialOutcome],
    filtered: bool,
    persona: Option<&Persona>,
) -> CaseResult {
    let unfit = persona.and_then(|persona| persona::unfit_rule(persona, &manual.device, rule));
    let mut decided = Decided::default();
    let mut failures = Vec::new();
    let mut disturbed: Option<String> = None;
    for outcome in outcomes {
        let seen = &outcome.rules[index];
        // What was seen of a device in a trial that did not pass proves nothing in its favour.
        if outcome.case.verdict == Verdict::Pass {
            decided.premises += seen.decided.premises;
        }
        decided.undecided += seen.decided.undecided;
        decided.looked_at += seen.decided.looked_at;
        match &seen.broken {
            Some((_, failure)) if seen.disturbed => {
                disturbed.get_or_insert_with(|| failure.what.clone());
            }
            Some((_, failure)) if failures.is_empty() => failures.push(failure.clone()),
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
            disturbed.map(|what| format!("{what} That trial was disturbed, so it says nothing.")),
        ),
        (None, 0) if persona.is_some() => {
            let name = persona.map(|persona| persona.name.as_str()).unwrap_or_default();
            (Verdict::NotApplicable, Some(format!("persona {name}: the premise never came up")))
        }
        (None, 0) => {
            let red = if filtered { "" } else { "; every rule has to be decided at least once in a whole run" };
            let reason = format!("premise never seen ({} frames and events looked at){red}", decided.looked_at);
            (Verdict::NotRun, Some(reason))
        }
        (None, _) => (Verdict::Pass, None),
    };
    let covers: Vec<Covered> = rule
        .covers
        .iter()
        .map(|&requirement| Covered { requirement, id: manual.requirements[requirement].id.clone(), verdict })
        .collect();
    CaseResult {
        id: format!("{}/{}", manual.device.name, rule.id),
        kind: CaseKind::Rule,
        why: rule.why.clone(),
        verdict,
        level: level(manual, &covers, verdict),
        covers,
        reason,
        failures,
        readings: Vec::new(),
        saved: Vec::new(),
        notes: Vec::new(),
        decided: Some(decided),
        duration: std::time::Duration::ZERO,
        frames: decided.looked_at,
        at: rule.at.clone(),
        evidence: None,
    }
}
