//! On which live benches a requirement can be judged, derived from what its trials need.

use crate::device::NameKind;
pub use crate::model::Reach;
use crate::model::{Manual, SuiteRule, SuiteVariant};
use crate::needs::BenchNeed;

impl Reach {
    /// What these needs take together.
    pub fn of(needs: &[BenchNeed]) -> Reach {
        needs.iter().map(of_need).max().unwrap_or(Reach::NoStand)
    }

    /// What a rule takes: frames, or also what only a stand reads.
    pub fn of_rule(variant: &SuiteVariant, rule: &SuiteRule) -> Reach {
        let mut reach = Reach::NoStand;
        rule.body.each_name(&mut |name| {
            if let Some(NameKind::Led(_) | NameKind::Counter(_)) = variant.names.get(name.0 as usize) {
                reach = Reach::WithStand;
            }
        });
        reach
    }
}

/// For each requirement the least that a live bench must have for one of the trials and rules that cover it; `None` if none does.
pub fn of_requirements(manual: &Manual) -> Vec<Option<Reach>> {
    let mut least: Vec<Option<Reach>> = vec![None; manual.requirements.len()];
    let mut reached = |requirement: usize, reach: &Reach| {
        if let Some(of) = least.get_mut(requirement)
            && of.as_ref().is_none_or(|of| reach < of)
        {
            *of = Some(reach.clone());
        }
    };
    for variant in &manual.variants {
        for trial in &variant.trials {
            trial.outline.live.iter().for_each(|(requirement, reach)| reached(*requirement, reach));
        }
        for rule in &variant.rules {
            let reach = Reach::of_rule(variant, rule);
            rule.covers.iter().for_each(|requirement| reached(*requirement, &reach));
        }
    }
    least
}

fn of_need(need: &BenchNeed) -> Reach {
    match need {
        BenchNeed::Stand(_) => Reach::WithStand,
        need => need.never_live().map_or(Reach::NoStand, Reach::Never),
    }
}
