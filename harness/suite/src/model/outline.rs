//! What the steps of a trial come to: all that listings ask of them, so that these need not read the steps.

use super::{Manual, Step, Trial, Variant, Verb};
use crate::needs::{self, Need};
use crate::scan::{each_step, each_step_of};
use serde::{Deserialize, Serialize};
use std::slice;

/// What the steps of a trial come to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Outline {
    /// Requirements of the checks that are judged for themselves, in the order of the steps.
    pub checks: Vec<usize>,
    /// The requirements that it covers on a bench without a stand, those of its checks included.
    pub without_stand: Vec<usize>,
    /// Names of readings that it accepts, each with the requirement that is read so: those of the checks that cover it for
    /// themselves, or of the whole trial.
    pub readings: Vec<(usize, String)>,
}

impl Outline {
    fn of(manual: &Manual, variant: &Variant, trial: &Trial) -> Outline {
        let mut outline = Outline::default();
        each_step_of(trial, &mut |step| outline.checks.extend(&step.covers));
        let stands = |needs: &[Need]| needs.iter().any(|need| matches!(need, Need::Stand(_)));
        if !stands(&needs::needs(manual, variant, trial)) {
            outline.without_stand.extend(&trial.covers);
            each_step_of(trial, &mut |step| {
                if !step.covers.is_empty() && !stands(&needs::of_step(manual, variant, step)) {
                    outline.without_stand.extend(&step.covers);
                }
            });
        }
        let mut covered: Vec<usize> = trial.covers.iter().chain(&outline.checks).copied().collect();
        covered.sort_unstable();
        covered.dedup();
        for requirement in covered {
            readings(trial, requirement, &mut |name| outline.readings.push((requirement, name.to_owned())));
        }
        outline
    }
}

impl Manual {
    /// The manual with the outlines of its trials.
    pub(crate) fn outlined(mut self) -> Manual {
        let of_variant = |variant| Variant::outlines(variant, &self);
        let outlines: Vec<Vec<Outline>> = self.variants.iter().map(of_variant).collect();
        for (variant, outlines) in self.variants.iter_mut().zip(outlines) {
            variant.trials.iter_mut().zip(outlines).for_each(|(trial, outline)| trial.outline = outline);
        }
        self
    }
}

impl Variant {
    fn outlines(&self, manual: &Manual) -> Vec<Outline> {
        self.trials.iter().map(|trial| Outline::of(manual, self, trial)).collect()
    }
}

/// The readings by name that a trial accepts for a requirement.
fn readings(trial: &Trial, requirement: usize, visit: &mut dyn FnMut(&str)) {
    let mut named = |step: &Step| {
        if let Verb::Either(readings) = &step.verb {
            readings.iter().for_each(|reading| visit(&reading.name));
        }
    };
    let covers = |step: &Step| step.covers.contains(&requirement);
    each_step_of(trial, &mut |step| {
        if covers(step) {
            each_step(slice::from_ref(step), &mut named);
        } else if step.covers.is_empty() && trial.covers.contains(&requirement) {
            named(step);
        }
    });
}
