//! A run: every selected trial of every device under test, its rules over all of them, and the requirements at the end.

use super::around;
use super::driver;
use super::dut::DutSpec;
use super::failure;
use super::live::Excluded;
use super::needs;
use super::persona;
use super::plan::Plan;
use super::scan::check_covers;
use super::segment::Segment;
use super::trial::{DpLine, Place, Run};
use super::world::World;
use controllers::profinet_io::StationSeen;
use judge::violation::Violation;
use results::journal::Entry;
use results::outcome::{
    Blame, CaseKind, CaseResult, Covered, Decided, DeviceRun, Dut, Failure, Finding, RunResult, Severity,
};
use results::verdict::Verdict;
use station::Time;
use std::path::PathBuf;
use std::sync::Arc;
use suite::model::{Level, Manual, Rule, Trial, Variant};
use suite::persona::Persona;
use virtual_wire::Trace;
use wire::profibus::fdl::BaudRate;

/// The fastest rate that the standard has.
const FAST: BaudRate = BaudRate(12_000_000);

/// What a run is asked for.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// The devices under test.
    pub duts: Vec<DutSpec>,
    /// Only trials and rules whose full name contains this.
    pub filter: Option<String>,
    /// The filter is the whole name.
    pub exact: bool,
    /// Where captures of failed trials go.
    pub evidence: Option<PathBuf>,
    /// Where captures of all trials go.
    pub record: Option<PathBuf>,
    /// How many trials run at once; 0: as many as there are cores.
    pub threads: usize,
    /// Whether only `must` counts.
    pub gate_must: bool,
    /// In the manner of which controller every device is addressed; none: as its bench says, else in our own.
    pub persona: Option<Arc<Persona>>,
    /// Only every so-manieth trial, so that several benches share the work.
    pub part: Option<Part>,
}

/// A part of the trials: one of so many, dealt out like cards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which one, from 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl Part {
    pub(super) fn has(self, at: usize) -> bool {
        at % self.of.max(1) + 1 == self.number
    }
}

/// As `--part` has it: `2/8`.
impl std::str::FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Part, String> {
        let wrong = || format!("`{text}` is no part; write 2/8 for the second of eight");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of) = (number.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
        if (1..=of).contains(&number) { Ok(Part { number, of }) } else { Err(wrong()) }
    }
}

/// The bench cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BenchError(pub String);

/// Hears how far a run has come: the device under test of the last trial, trials done, trials in all.
pub type Progress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

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

/// Whether a filter leaves a trial or a rule in.
pub fn selects(options: &RunOptions, manual: &Manual, id: &str) -> bool {
    let full = format!("{}/{id}", manual.device.name);
    match &options.filter {
        None => true,
        Some(filter) if options.exact => full == *filter || id == filter,
        Some(filter) => full.contains(filter.as_str()),
    }
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
    let requirements = super::requirements::results(manual, variant, &cases);
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
        bugs: dut.bugs().to_vec(),
        bug_notes: dut.bug_notes(),
        findings,
    })
}

/// What one trial came to.
#[derive(Clone, Debug)]
pub struct TrialOutcome {
    /// The trial itself.
    pub case: CaseResult,
    /// What each rule of the variant saw in it, in their order.
    pub rules: Vec<RuleSeen>,
    /// What was found about the device: readings of the manual that are faults.
    pub findings: Vec<Finding>,
    /// What the device said it is.
    pub identity: Option<String>,
    /// Why what was seen says nothing about a live device: the line, the end of the run, or we ourselves were late.
    pub disturbed: Option<String>,
    /// Every frame.
    pub trace: Trace,
}

/// What a rule saw in a trial.
#[derive(Clone, Debug)]
pub struct RuleSeen {
    /// How often it was decided.
    pub decided: Decided,
    /// The first time it was broken, and what a person is told about it.
    pub broken: Option<(Violation, Failure)>,
    /// Whether the trial was disturbed, so that what was seen in it says nothing about the device.
    pub disturbed: bool,
}

/// Runs one trial against a fresh device and gives what it and the rules came to, with every frame.
pub fn run_trial(
    manual: &Manual,
    variant: &Variant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> Result<TrialOutcome, BenchError> {
    one(manual, variant, dut, trial, options).map_err(BenchError)
}

/// Asks the device for its firmware in a connection of its own.
fn firmware(manual: &Manual, variant: &Variant, dut: &DutSpec, place: &Place) -> Option<String> {
    let trial = variant.trials.iter().find(|trial| trial.start().is_some())?;
    let ours = driver::of(&manual.device).stations(manual, place, trial);
    let world = World::new(manual, variant, dut.segment(&trial.id, place.line).ok()?, ours);
    Run::new(world, trial, place).firmware()
}

/// Where everybody is on the PROFIBUS of a trial. On a virtual one a clock needs a fast bus: its cycle is short.
pub fn line(dut: &DutSpec, manual: &Manual, trial: Option<&Trial>) -> DpLine {
    let line = dut.place().line;
    if dut.live().is_some() {
        return line;
    }
    let said = trial.and_then(|trial| trial.start()?.baud);
    let usual = if trial.is_some_and(super::scan::has_clock) { FAST } else { line.baud };
    let baud = said.unwrap_or(usual);
    DpLine { station: manual.device.profibus().map_or(line.station, |slave| slave.address), baud, ..line }
}

/// Where the device is found, and in whose manner it is addressed.
fn place(dut: &DutSpec, options: &RunOptions, manual: &Manual, trial: Option<&Trial>) -> Place {
    let mut place = dut.place();
    // A trial that is run again asks anew, else the device takes its requests for late ones of the time before.
    place.seed = place.seed.wrapping_add(dut.live().map_or(0, |live| live.next_call()));
    place.line = line(dut, manual, trial);
    place.persona = options.persona.clone().or(place.persona);
    if let (Some(persona), None) = (&place.persona, &place.bench) {
        place.slack = persona::slack(persona, &manual.device);
    }
    place
}

/// Runs one trial, if the device may be given it.
pub(super) fn one(
    manual: &Manual,
    variant: &Variant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> Result<TrialOutcome, String> {
    let persona = options.persona.clone().or_else(|| dut.live()?.place().persona.clone());
    let unfit = persona.and_then(|persona| persona::unfit_trial(&persona, manual, variant, trial));
    if let Some(why) = unfit {
        return Ok(around::not_run(manual, variant, trial, Excluded::NotApplicable(why)));
    }
    let Some(live) = dut.live() else {
        let segment = dut.segment(&trial.id, line(dut, manual, Some(trial)))?;
        return Ok(run_trial_on(segment, manual, variant, dut, trial, options));
    };
    let outcome = match live.admit(variant, trial) {
        Ok(()) => {
            run_trial_on(dut.segment(&trial.id, line(dut, manual, Some(trial)))?, manual, variant, dut, trial, options)
        }
        Err(excluded) => around::not_run(manual, variant, trial, excluded),
    };
    let answered = outcome.identity.is_some() || outcome.case.frames == 0;
    live.counts(answered);
    let verdict = outcome.case.verdict.word().to_owned();
    if let Err(why) = live.note(&Entry::Verdict { trial: trial.id.clone(), verdict }) {
        live.lose(&why);
    }
    Ok(outcome)
}

/// Runs one trial on a segment that somebody has prepared.
pub fn run_trial_on(
    segment: Box<dyn Segment + '_>,
    manual: &Manual,
    variant: &Variant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> TrialOutcome {
    let mut place = place(dut, options, manual, Some(trial));
    if let Some(bench) = &place.bench {
        place.noise = needs::position_noise(&needs::needs(manual, variant, trial), bench);
    }
    let world = World::new(manual, variant, segment, driver::of(&manual.device).stations(manual, &place, trial));
    let mut run = Run::new(world, trial, &place);
    let decided = run.run();
    outcome(run, decided, dut, options)
}

fn outcome(mut run: Run<'_>, decided: Option<(Verdict, Failure)>, dut: &DutSpec, options: &RunOptions) -> TrialOutcome {
    let why = if run.world.segment.is_model() { None } else { run.not_the_device() };
    let disturbed = why.is_some();
    let bugs: String = dut.bugs().iter().map(|bug| format!(" --bug {bug}")).collect();
    let persona = run.place.persona.as_ref().map(|persona| format!(" --persona {}", persona.name));
    let repeat = format!("--dut {dut}{}{bugs}", persona.unwrap_or_default());
    let manual = run.world.manual;
    let trial = run.trial;
    let main = match (&decided, run.checks) {
        (Some((verdict, _)), _) => *verdict,
        (None, 0) => Verdict::Error,
        (None, _) => Verdict::Pass,
    };
    let mut covers: Vec<Covered> = Vec::new();
    let mut add = |requirement: usize, verdict: Verdict| {
        let id = manual.requirements[requirement].id.clone();
        match covers.iter_mut().find(|known| known.requirement == requirement) {
            Some(known) => known.verdict = super::requirements::worse(known.verdict, verdict),
            None => covers.push(Covered { requirement, id, verdict }),
        }
    };
    trial.covers.iter().for_each(|&requirement| add(requirement, main));
    let mut verdict = main;
    let mut failures: Vec<Failure> = Vec::new();
    let mut reached: Vec<usize> = Vec::new();
    let reason = decided.as_ref().map(|(_, failure)| failure.what.clone());
    for check in run.checked {
        check.covers.iter().for_each(|&requirement| add(requirement, check.verdict));
        reached.extend(&check.covers);
        if check.verdict != Verdict::NotApplicable {
            verdict = super::requirements::worse(verdict, check.verdict);
        }
        failures.extend(check.failure);
    }
    for requirement in check_covers(trial) {
        if !reached.contains(&requirement) {
            add(requirement, if main == Verdict::Pass { Verdict::NotApplicable } else { Verdict::NotRun });
        }
    }
    if let Some((_, failure)) = decided {
        failures.insert(0, failure);
    }
    let reason = reason.or_else(|| failures.first().map(|failure| failure.what.clone()));
    let level = level(manual, &covers, verdict);
    let saved = trial.how().saved.iter().zip(&run.world.scene.notebook().saved);
    let saved = saved.map(|(name, value)| (name.clone(), judge::format::plain(value))).collect();
    let objections = run.world.segment.objections();
    let with_persona = run.place.persona.is_some();
    run.world.judges.rules.settle();
    let rules = run.world.judges.rules.iter().map(|(of, rule)| {
        let is_seen =
            |violation: &&Violation| !with_persona || !persona::is_unseen(violation, &run.world.trace, run.mac);
        let broken = rule.violation().filter(is_seen).map(|violation| {
            let failure = rule_failure(&run.world, of, violation, trial, &repeat);
            (violation.clone(), failure)
        });
        RuleSeen { decided: rule.decided(), broken, disturbed }
    });
    let rules = rules.collect();
    let finding = |(reading, text): (String, String)| Finding {
        id: format!("{}:{reading}", trial.case()),
        severity: Severity::Error,
        text,
        manual: None,
        description: None,
        device: None,
    };
    let findings = run.findings.into_iter().map(finding).collect();
    let case = CaseResult {
        id: format!("{}/{}", manual.device.name, trial.id),
        kind: CaseKind::Trial,
        why: trial.why.clone(),
        verdict,
        level,
        covers,
        reason: (verdict != Verdict::Pass).then_some(reason).flatten(),
        failures,
        readings: run.readings,
        saved,
        notes: run.notes.into_iter().chain(objections).collect(),
        decided: None,
        duration: run.world.now().since(Time::ZERO),
        frames: run.world.trace.len() as u64,
        at: trial.at.clone(),
        evidence: None,
    };
    let case = super::evidence::keep(case, run.world.manual, run.world.variant, &run.world.trace, options);
    let identity = run.identity.as_ref().map(identity).or_else(|| run.slave.identity());
    TrialOutcome { case, rules, findings, identity, disturbed: why, trace: run.world.trace }
}

fn identity(station: &StationSeen) -> String {
    let (vendor, device) = station.id.unwrap_or_default();
    let text = |octets: &[u8]| String::from_utf8_lossy(octets).escape_debug().to_string();
    format!("{} (vendor 0x{vendor:04X}, device 0x{device:04X})", text(&station.station_type))
}

/// The weight of a result: the weightiest requirement that failed, else the weightiest that is covered.
pub(super) fn level(manual: &Manual, covers: &[Covered], verdict: Verdict) -> Level {
    let of = |covered: &Covered| manual.requirements[covered.requirement].level;
    let failed = covers.iter().filter(|covered| covered.verdict == verdict).map(of).min();
    failed.or_else(|| covers.iter().map(of).min()).unwrap_or(Level::Must)
}

fn rule_failure(world: &World<'_>, rule: &Rule, violation: &Violation, trial: &Trial, repeat: &str) -> Failure {
    let (octet, bit) = violation.place.map_or((None, None), |(_, octet, bit)| (Some(octet), bit));
    let frame = violation.frame();
    Failure {
        blame: Blame::Device,
        what: format!("The rule is broken: {}. It was seen in the trial {}.", violation.how, trial.id),
        step: rule.why.clone(),
        at: rule.at.clone(),
        requirements: failure::requirements(world.manual, &rule.covers),
        parts: violation.parts.clone(),
        place: Some(results::outcome::Place { frame, octet, bit, filter: format!("frame.number == {frame}") }),
        trace: failure::trace(world, frame),
        next: format!("Run the trial alone: encspec run {repeat} '{}' --exact", trial.id),
    }
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
