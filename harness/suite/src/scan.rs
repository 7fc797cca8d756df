//! Walks through the steps of a trial without running them.

use crate::model::{BlockObservation, RuleBody, Trial, TrialStep, Verb};
use expression::NameId;

/// Visits every step of a trial: `given`, the test, `finally`.
pub fn each_step_of<'a>(trial: &'a Trial, visit: &mut dyn FnMut(&'a TrialStep)) {
    for steps in trial.parts() {
        each_step(steps, visit);
    }
}

/// Visits steps, including those inside blocks and readings.
pub fn each_step<'a>(steps: &'a [TrialStep], visit: &mut dyn FnMut(&'a TrialStep)) {
    for step in steps {
        visit(step);
        match &step.verb {
            Verb::Block { steps, .. } => each_step(steps, visit),
            Verb::Either(readings) => readings.iter().for_each(|reading| each_step(&reading.steps, visit)),
            _ => {}
        }
    }
}

/// The names that expectations and observations of the steps use.
pub fn names(steps: &[TrialStep]) -> Vec<NameId> {
    let mut names = Vec::new();
    let mut add = |name: NameId| names.push(name);
    each_step(steps, &mut |step| match &step.verb {
        Verb::Expect { condition, .. } => condition.each_name(&mut add),
        Verb::Block { observe, .. } => observe.iter().for_each(|observation| observed_names(observation, &mut add)),
        _ => {}
    });
    names
}

pub(crate) fn observed_names(observation: &BlockObservation, add: &mut dyn FnMut(NameId)) {
    match observation {
        BlockObservation::Rule { body: RuleBody::Always(condition), .. } => condition.each_name(add),
        BlockObservation::Rule { body: RuleBody::When { premise, then, .. }, .. } => {
            premise.names().for_each(&mut *add);
            then.each_name(add);
        }
        BlockObservation::Count { condition, .. } => condition.names().for_each(add),
        BlockObservation::Sequence { names, .. } => {
            names.iter().for_each(|program| program.names().for_each(&mut *add))
        }
    }
}

/// Whether the second controller of the harness acts in this trial.
pub fn has_second(trial: &Trial) -> bool {
    let mut any = false;
    each_step_of(trial, &mut |step| {
        any |= match &step.verb {
            Verb::Connect { second, .. } | Verb::Disconnect { second } | Verb::Send { second, .. } => *second,
            Verb::Write(access) | Verb::Read { access, .. } => access.second,
            _ => false,
        };
    });
    any
}

/// Whether a connection of this trial is isochronous.
pub fn has_clock(trial: &Trial) -> bool {
    let mut any = trial.start().is_some_and(|start| start.isochronous.is_some());
    each_step_of(trial, &mut |step| {
        any |= matches!(&step.verb, Verb::Connect { start, .. } if start.isochronous.is_some());
    });
    any
}

/// The requirements of the checks that are judged separately.
pub fn check_covers(trial: &Trial) -> Vec<usize> {
    trial.outline.checks.clone()
}

/// The requirements that single steps of the case are about; what a procedure says besides is left out.
pub fn step_abouts(trial: &Trial) -> Vec<usize> {
    let mut list = Vec::new();
    each_step_of(trial, &mut |step| list.extend(step.about.of_case()));
    list
}
