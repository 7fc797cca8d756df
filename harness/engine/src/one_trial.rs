//! One trial of a run: its segment, its outcome with its checks, and the results of the rules in it.
//!
//! This module must not know other trials.

use super::dut::DutSpec;
use super::environment::{DpLine, TrialEnvironment};
use super::live::TrialExclusion;
use super::options::RunOptions;
use super::outcome::{BenchError, TrialOutcome, TrialRuleResult};
use super::requirements::{level, worse};
use super::scan::{self, check_covers};
use super::segment::Segment;
use super::trial::{RunningTrial, failure};
use super::world::TrialWorld;
use super::{bus, described, evidence, live_run, needs, persona};
use judge::violation::RuleViolation;
use plain_text::count;
use results::journal::JournalEntry;
use results::outcome::{CaseFailure, CaseKind, CaseResult, Covered, DeviceFinding, FailureCause, FindingSeverity};
use results::verdict::Verdict;
use station::Time;
use std::cell::Cell;
use std::time::{SystemTime, UNIX_EPOCH};
use suite::model::{Manual, SuiteRule, SuiteVariant, Trial, TrialStep, Verb};
use wire::profibus::fdl::BaudRate;

/// The fastest baud rate of the standard, in bit/s.
const FAST: BaudRate = BaudRate(12_000_000);

/// Runs one trial against a new device; returns the results of the trial and of the rules, with every frame.
pub fn run_trial(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> Result<TrialOutcome, BenchError> {
    run_described(manual, variant, dut, trial, options).map_err(BenchError)
}

/// The addresses and the baud rate on the PROFIBUS of a trial. A trial with a clock has the fast rate on a virtual bus, because its
/// cycle is short.
pub fn dp_line(dut: &DutSpec, manual: &Manual, trial: Option<&Trial>) -> DpLine {
    let line = dut.environment().line;
    if dut.live().is_some_and(|live| !live.is_virtual()) {
        return line;
    }
    let said = trial.and_then(baud);
    let usual = if trial.is_some_and(scan::has_clock) { FAST } else { line.baud };
    let baud = said.unwrap_or(usual);
    DpLine { station: manual.device.profibus().map_or(line.station, |slave| slave.address), baud, ..line }
}

/// The baud rate that a trial says for its connection, or for the first one in its steps.
fn baud(trial: &Trial) -> Option<BaudRate> {
    let of_step = |step: &TrialStep| match &step.verb {
        Verb::Connect { start, .. } => start.baud,
        _ => None,
    };
    let of_steps = || trial.parts().into_iter().flatten().find_map(of_step);
    trial.start().and_then(|start| start.baud).or_else(of_steps)
}

/// The addresses on the bench of a trial, and the persona of the controller.
pub(super) fn environment(
    dut: &DutSpec,
    options: &RunOptions,
    manual: &Manual,
    trial: Option<&Trial>,
) -> TrialEnvironment {
    let mut environment = dut.environment();
    // A repeated trial has other identifiers, else the device takes its requests for late ones of the first time.
    environment.seed = environment.seed.wrapping_add(dut.live().map_or(0, |live| live.next_call()));
    environment.line = dp_line(dut, manual, trial);
    environment.persona = options.persona.clone().or(environment.persona);
    if let (Some(persona), None) = (&environment.persona, &environment.bench) {
        environment.slack = persona::slack(persona, &manual.device);
    }
    environment
}

/// Runs one trial with the description that the variations of the device give it.
pub(super) fn run_described(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> Result<TrialOutcome, String> {
    let described = described::described(manual, dut);
    run_admitted(described.as_ref().unwrap_or(manual), variant, dut, trial, options)
}

/// Runs one trial, if the bench admits it, and writes its capture.
pub(super) fn run_admitted(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> Result<TrialOutcome, String> {
    let persona = options.persona.clone().or_else(|| dut.live()?.environment().persona.clone());
    let not_run = |excluded: TrialExclusion| live_run::not_run(manual, variant, trial, excluded);
    if let Some(why) = persona.and_then(|persona| persona::unfit_trial(&persona, manual, variant, trial)) {
        return Ok(not_run(TrialExclusion::NotApplicable { why, lines: vec!["persona".to_owned()] }));
    }
    let is_live = dut.live().is_some_and(|live| !live.is_virtual());
    let began = Cell::new(Time::ZERO);
    let run_once = || -> Result<TrialOutcome, String> {
        if is_live {
            began.set(now());
        }
        let segment = dut.segment(&trial.id, dp_line(dut, manual, Some(trial)), manual.device.profibus().is_some())?;
        Ok(run_trial_on(segment, manual, variant, dut, trial, options))
    };
    let with_capture = |mut outcome: TrialOutcome| {
        outcome.case = evidence::write_captures(outcome.case, manual, variant, (&outcome.trace, began.get()), options);
        outcome
    };
    let Some(live) = dut.live() else {
        return retried(options.retries, with_capture(run_once()?), &run_once, &|| true);
    };
    let admit = || live.admit(variant, trial);
    let outcome = match admit() {
        Ok(()) => {
            let admits = || admit().is_ok();
            let attempt = || repeat_stalled(options.stall_repeats, &run_once, &admits);
            retried(options.retries, with_capture(attempt()?), &attempt, &admits)?
        }
        Err(excluded) => not_run(excluded),
    };
    let answered = outcome.identity.is_some() || outcome.case.frames == 0;
    live.count_answer(answered);
    let verdict = outcome.case.verdict.word().to_owned();
    if let Err(why) = live.note(&JournalEntry::Verdict { trial: trial.id.clone(), verdict }) {
        live.end_tests(&why);
    }
    Ok(outcome)
}

/// The time since 1970.
fn now() -> Time {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Time::from_nanos(u64::try_from(since.as_nanos()).unwrap_or_default())
}

/// Runs a trial that did not pass again, `most` times at most, until it passes and breaks no rule. The verdict, the failures and the
/// capture stay those of the first attempt.
fn retried(
    most: u32,
    mut outcome: TrialOutcome,
    attempt: &dyn Fn() -> Result<TrialOutcome, String>,
    admits: &dyn Fn() -> bool,
) -> Result<TrialOutcome, String> {
    if !matches!(outcome.case.verdict, Verdict::Fail | Verdict::Inconclusive | Verdict::Error) {
        return Ok(outcome);
    }
    let mut attempts = 1;
    while attempts <= most && admits() {
        attempts += 1;
        let again = attempt()?;
        if again.case.verdict == Verdict::Pass && again.rules.iter().all(|rule| rule.broken.is_none()) {
            outcome.case.passed_in_attempt = Some(attempts);
            return Ok(outcome);
        }
    }
    if attempts > 1 {
        outcome.case.notes.push(format!("it did not pass in any of {attempts} attempts"));
    }
    Ok(outcome)
}

/// Runs an admitted trial, and again, `most` times at most, while a stall is its only trouble and the bench `admits` it.
fn repeat_stalled(
    most: u32,
    run_once: &dyn Fn() -> Result<TrialOutcome, String>,
    admits: &dyn Fn() -> bool,
) -> Result<TrialOutcome, String> {
    let mut outcome = run_once()?;
    let mut repeats = 0;
    let mut last = String::new();
    while let Some(stall) = outcome.spoilt_by_stall() {
        // A repetition needs the same consents, of which a memory write may be used up.
        if repeats == most || !admits() {
            break;
        }
        last = stall.to_owned();
        repeats += 1;
        outcome = run_once()?;
    }
    if repeats > 0 {
        let times = count(repeats as usize, "time", "times");
        outcome.case.notes.push(format!("repeated {times}, because {last}"));
    }
    outcome.case.repeats = repeats;
    Ok(outcome)
}

/// Runs one trial on a prepared segment; writes no capture.
pub fn run_trial_on(
    segment: Box<dyn Segment + '_>,
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    trial: &Trial,
    options: &RunOptions,
) -> TrialOutcome {
    let mut environment = environment(dut, options, manual, Some(trial));
    if let Some(bench) = &environment.bench {
        environment.noise = needs::position_noise(&needs::needs(manual, variant, trial), bench);
    }
    let mut run = bus::trial(manual, variant, segment, trial, &environment);
    let decided = if options.unjudged {
        run.run_unjudged()
    } else {
        run.world.use_leds(&trial.outline.leds);
        run.run()
    };
    outcome(run, decided, dut)
}

fn outcome(mut run: RunningTrial<'_>, decided: Option<(Verdict, CaseFailure)>, dut: &DutSpec) -> TrialOutcome {
    let why = if run.world.segment.is_model() { None } else { run.disturbance() };
    let disturbed = why.is_some();
    // A virtual wire is disturbed only by the program that is the device.
    let by_program = disturbed && run.world.segment.is_virtual();
    let decided = decided.map(|(verdict, failure)| {
        let next = "Fix the program and run the trial again; nothing was judged.".to_owned();
        let failure = if by_program { CaseFailure { blame: FailureCause::Device, next, ..failure } } else { failure };
        (verdict, failure)
    });
    let identity = run.driver.identity(&run);
    let option = |option: &str, names: Vec<String>| -> String {
        names.iter().map(|name| format!(" --{option} {name}")).collect()
    };
    let deviations = option("bug", dut.bugs()) + &option("vary", dut.variations());
    let persona = run.environment.persona.as_ref().map(|persona| format!(" --persona {}", persona.name));
    let repeat = format!("{}{}{deviations}", dut.option(), persona.unwrap_or_default());
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
            Some(known) => known.verdict = worse(known.verdict, verdict),
            None => covers.push(Covered { requirement, id, verdict }),
        }
    };
    for (requirement, verdict) in attributed(trial, main, run.failed_about.requirements(), &run.passed_about) {
        add(requirement, verdict);
    }
    let mut verdict = main;
    let mut failures: Vec<CaseFailure> = Vec::new();
    let mut reached: Vec<usize> = Vec::new();
    let reason = decided.as_ref().map(|(_, failure)| failure.what.clone());
    for check in run.checked {
        check.covers.iter().for_each(|&requirement| add(requirement, check.verdict));
        reached.extend(&check.covers);
        if check.verdict != Verdict::NotApplicable {
            verdict = worse(verdict, check.verdict);
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
    let with_persona = run.environment.persona.is_some();
    run.world.judges.rules.settle();
    let rules = run.world.judges.rules.iter().map(|(of, rule)| {
        let is_seen = |violation: &&RuleViolation| {
            !with_persona || !persona::is_without_frames(violation, &run.world.trace, run.mac)
        };
        let broken = rule.violation().filter(is_seen).map(|violation| {
            let failure = rule_failure(&run.world, of, violation, trial, &repeat);
            (violation.clone(), failure)
        });
        TrialRuleResult { decided: rule.decided(), broken, slow: rule.slow(), disturbed }
    });
    let rules = rules.collect();
    let finding = |(reading, text): (String, String)| DeviceFinding {
        id: format!("{}:{reading}", trial.case()),
        severity: FindingSeverity::Error,
        text,
        manual: None,
        description: None,
        device: None,
    };
    let findings = run.findings.into_iter().map(finding).collect();
    let slow = run.slow.iter().map(|(step, within, slow)| slow.note(within, &step.text));
    let id = format!("{}/{}", manual.device.name, trial.id);
    let case = CaseResult {
        covers,
        reason: (verdict != Verdict::Pass).then_some(reason).flatten(),
        failures,
        readings: run.readings,
        saved,
        notes: slow.chain(run.notes).chain(objections).collect(),
        duration: run.world.now().since(Time::ZERO),
        frames: run.world.trace.len() as u64,
        ..CaseResult::new(id, CaseKind::Trial, trial.why.clone(), (verdict, level), trial.at.clone())
    };
    let bus = run.world.stations.bus_statistics();
    TrialOutcome {
        case,
        rules,
        findings,
        identity,
        disturbed: why,
        likely_reading: None,
        bus,
        trace: run.world.trace,
        log: run.world.log,
    }
}

/// The verdict of each requirement of the whole trial, and of those that its failure is about.
///
/// A failed step that says what it is about fails that alone. Another failed step fails what no step is about, or everything if there
/// is nothing else, so that a failed trial always fails a requirement. What is left was not judged, unless a passed step is about it.
fn attributed(trial: &Trial, main: Verdict, failed: &[usize], passed: &[usize]) -> Vec<(usize, Verdict)> {
    if main != Verdict::Fail {
        return trial.covers.iter().map(|&requirement| (requirement, main)).collect();
    }
    let of_steps = scan::step_abouts(trial);
    let is_whole = |requirement: &usize| !of_steps.contains(requirement);
    let open = |requirement: &usize| !passed.contains(requirement);
    let blamed: Vec<usize> = if !failed.is_empty() {
        failed.to_vec()
    } else if trial.covers.iter().any(is_whole) {
        trial.covers.iter().copied().filter(is_whole).collect()
    } else if trial.covers.iter().any(open) {
        trial.covers.iter().copied().filter(open).collect()
    } else {
        trial.covers.clone()
    };
    let rest = trial.covers.iter().copied().filter(|requirement| !blamed.contains(requirement));
    let rest = rest.map(|requirement| {
        let verdict = if passed.contains(&requirement) { Verdict::Pass } else { Verdict::NotRun };
        (requirement, verdict)
    });
    let rest: Vec<(usize, Verdict)> = rest.collect();
    blamed.into_iter().map(|requirement| (requirement, Verdict::Fail)).chain(rest).collect()
}

fn rule_failure(
    world: &TrialWorld<'_>,
    rule: &SuiteRule,
    violation: &RuleViolation,
    trial: &Trial,
    repeat: &str,
) -> CaseFailure {
    let (octet, bit) = violation.place.map_or((None, None), |(_, octet, bit)| (Some(octet), bit));
    let frame = violation.frame();
    CaseFailure {
        blame: FailureCause::Device,
        what: format!("The rule was broken in trial {}: {}.", trial.id, violation.how),
        step: rule.why.clone(),
        at: rule.at.clone(),
        requirements: failure::requirements(world.manual, &rule.covers),
        parts: violation.parts.clone(),
        place: Some(results::outcome::FailurePosition {
            frame,
            octet,
            bit,
            filter: format!("frame.number == {frame}"),
        }),
        trace: failure::trace(world, frame),
        next: format!("Run this trial alone: encspec run {repeat} '{}' --exact", trial.id),
        before_test: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use judge::{JudgeTick, TickKind};
    use results::outcome::DecisionCounts;
    use std::path::PathBuf;
    use std::sync::Arc;
    use suite::Location;
    use suite::model::Level;
    use virtual_wire::Trace;

    fn violation() -> RuleViolation {
        RuleViolation {
            tick: JudgeTick { time: Time::ZERO, frame: 1, kind: TickKind::Event },
            trigger: None,
            how: String::new(),
            parts: Vec::new(),
            names: Vec::new(),
            place: None,
        }
    }

    fn attempt(verdict: Verdict, is_rule_broken: bool) -> TrialOutcome {
        let at = Location { file: Arc::new(PathBuf::from("a.yaml")), line: 1, column: 1 };
        let judged = (verdict, Level::Must);
        let case = CaseResult::new("a/b/c".into(), CaseKind::Trial, String::new(), judged, at.clone());
        let failure = CaseFailure {
            blame: FailureCause::Device,
            what: String::new(),
            step: String::new(),
            at,
            requirements: Vec::new(),
            parts: Vec::new(),
            place: None,
            trace: Vec::new(),
            next: String::new(),
            before_test: false,
        };
        let broken = is_rule_broken.then(|| (violation(), failure));
        let rule = TrialRuleResult { decided: DecisionCounts::default(), broken, slow: None, disturbed: false };
        TrialOutcome {
            case,
            rules: vec![rule],
            findings: Vec::new(),
            identity: None,
            disturbed: None,
            likely_reading: None,
            bus: None,
            trace: Trace::new(),
            log: None,
        }
    }

    /// The attempt in which a trial passed whose attempts have these verdicts, and how many there were.
    fn tried(most: u32, attempts: &[(Verdict, bool)]) -> (CaseResult, usize) {
        let number = Cell::new(0);
        let next = || {
            let (verdict, broken) = attempts[number.get()];
            number.set(number.get() + 1);
            Ok(attempt(verdict, broken))
        };
        let first = next().expect("the first attempt");
        (retried(most, first, &next, &|| true).expect("no error").case, number.get())
    }

    #[test]
    fn a_failed_trial_is_tried_again_and_keeps_its_verdict() {
        use Verdict::{Fail, Inconclusive, NotApplicable, Pass};
        let said = |most, attempts: &[(Verdict, bool)]| {
            let (case, number) = tried(most, attempts);
            (case.verdict, case.passed_in_attempt, number)
        };
        assert_eq!(said(0, &[(Fail, false)]), (Fail, None, 1));
        assert_eq!(said(2, &[(Pass, false)]), (Pass, None, 1));
        assert_eq!(said(2, &[(NotApplicable, false)]), (NotApplicable, None, 1));
        assert_eq!(said(2, &[(Fail, false), (Pass, false)]), (Fail, Some(2), 2));
        assert_eq!(said(2, &[(Inconclusive, false), (Fail, false), (Pass, false)]), (Inconclusive, Some(3), 3));
        assert_eq!(said(2, &[(Fail, false), (Fail, false), (Fail, false)]), (Fail, None, 3));
        assert_eq!(said(1, &[(Fail, false), (Pass, true)]), (Fail, None, 2), "a rule is broken in the second attempt");
        assert_eq!(tried(1, &[(Fail, false), (Fail, false)]).0.notes, ["it did not pass in any of 2 attempts"]);
    }

    #[test]
    fn without_consent_no_trial_is_tried_again() {
        let next = || -> Result<TrialOutcome, String> { panic!("it ran again") };
        let case = retried(3, attempt(Verdict::Fail, false), &next, &|| false).expect("no error").case;
        assert_eq!((case.passed_in_attempt, case.notes), (None, Vec::new()));
    }
}
