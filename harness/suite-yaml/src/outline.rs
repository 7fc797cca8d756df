//! Works out the outline of each trial from its steps.

use std::collections::BTreeSet;
use std::slice;
use suite::device::{NameId, NameKind};
use suite::model::{Manual, Outline, SuiteVariant, Trial, TrialStep, Verb};
use suite::needs;
use suite::reach::Reach;
use suite::scan::{each_step, each_step_of};

/// The manual with the outlines of its trials.
pub(super) fn outlined(mut manual: Manual) -> Manual {
    let of_variant = |variant: &SuiteVariant| {
        let always = leds_of_rules(variant);
        variant.trials.iter().map(|trial| of(&manual, variant, trial, &always)).collect()
    };
    let outlines: Vec<Vec<Outline>> = manual.variants.iter().map(of_variant).collect();
    for (variant, outlines) in manual.variants.iter_mut().zip(outlines) {
        variant.trials.iter_mut().zip(outlines).for_each(|(trial, outline)| trial.outline = outline);
    }
    manual
}

/// The LEDs that are read in every trial of a variant: those in a rule or in a derived value.
fn leds_of_rules(variant: &SuiteVariant) -> BTreeSet<usize> {
    let mut leds = BTreeSet::new();
    let mut visit = |name: NameId| {
        if let Some(NameKind::Led(led)) = variant.names.get(name.0 as usize) {
            leds.insert(*led);
        }
    };
    variant.derived.iter().flat_map(|(_, program)| program.names()).for_each(&mut visit);
    variant.rules.iter().for_each(|rule| rule.body.each_name(&mut visit));
    leds
}

fn of(manual: &Manual, variant: &SuiteVariant, trial: &Trial, always: &BTreeSet<usize>) -> Outline {
    let leds: BTreeSet<usize> = trial.outline.leds.iter().chain(always).copied().collect();
    let mut outline = Outline { leds: leds.into_iter().collect(), ..Outline::default() };
    each_step_of(trial, &mut |step| outline.checks.extend(&step.covers));
    let reach = Reach::of(&needs::needs(manual, variant, trial));
    outline.live.extend(trial.covers.iter().map(|&requirement| (requirement, reach.clone())));
    each_step_of(trial, &mut |step| {
        if !step.covers.is_empty() {
            let reach = Reach::of(&needs::of_step(manual, variant, step)).max(reach.clone());
            outline.live.extend(step.covers.iter().map(|&requirement| (requirement, reach.clone())));
        }
    });
    let mut covered: Vec<usize> = trial.covers.iter().chain(&outline.checks).copied().collect();
    covered.sort_unstable();
    covered.dedup();
    for requirement in covered {
        readings(trial, requirement, &mut |name| outline.readings.push((requirement, name.to_owned())));
    }
    outline
}

/// The readings by name that a trial accepts for a requirement.
fn readings(trial: &Trial, requirement: usize, visit: &mut dyn FnMut(&str)) {
    let mut named = |step: &TrialStep| {
        if let Verb::Either(readings) = &step.verb {
            readings.iter().for_each(|reading| visit(&reading.name));
        }
    };
    let covers = |step: &TrialStep| step.covers.contains(&requirement);
    each_step_of(trial, &mut |step| {
        if covers(step) {
            each_step(slice::from_ref(step), &mut named);
        } else if step.covers.is_empty() && trial.covers.contains(&requirement) {
            named(step);
        }
    });
}
