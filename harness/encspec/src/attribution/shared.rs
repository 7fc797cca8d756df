//! Which requirements have exactly the same cases, checks and rules as others, so that a failure cannot tell them apart.

use std::collections::{BTreeMap, BTreeSet};
use suite::model::{Level, Manual, TrialStep};
use suite::scan::{each_step_of, step_abouts};

/// What no check tells apart in one manual.
#[derive(Debug)]
pub struct SharedRequirements {
    /// Number of requirements that a case, check or rule covers.
    pub covered: usize,
    /// Requirements of a group have the same cases, checks and rules; the largest group comes first.
    pub groups: Vec<SharedGroup>,
    /// Cases, checks and rules that are judged as one and cover requirements of several levels.
    pub mixed: Vec<MixedLevels>,
}

/// Requirements that fail together, whatever is wrong.
#[derive(Debug)]
pub struct SharedGroup {
    /// Indices of the requirements.
    pub requirements: Vec<usize>,
    /// Their cases, checks and rules.
    pub units: Vec<String>,
}

/// A case, check or rule that is judged as one for requirements of several levels.
#[derive(Debug)]
pub struct MixedLevels {
    /// The case, check or rule.
    pub unit: String,
    /// Indices of its requirements, the higher level first.
    pub requirements: Vec<usize>,
}

impl SharedRequirements {
    /// Measures a manual.
    pub fn of(manual: &Manual) -> SharedRequirements {
        let units = units(manual);
        let mut of_requirement: BTreeMap<usize, BTreeSet<&str>> = BTreeMap::new();
        for (unit, covers) in &units {
            covers.iter().for_each(|&of| {
                of_requirement.entry(of).or_default().insert(unit);
            });
        }
        let mut groups: BTreeMap<&BTreeSet<&str>, Vec<usize>> = BTreeMap::new();
        of_requirement.iter().for_each(|(of, units)| groups.entry(units).or_default().push(*of));
        let mut groups: Vec<SharedGroup> = groups
            .into_iter()
            .filter(|(_, requirements)| requirements.len() > 1)
            .map(|(units, requirements)| SharedGroup {
                requirements,
                units: units.iter().map(|unit| (*unit).to_owned()).collect(),
            })
            .collect();
        groups.sort_by_key(|group| std::cmp::Reverse(group.requirements.len()));
        let level = |of: &usize| manual.requirements.get(*of).map(|of| of.level);
        let mixed = units.iter().filter_map(|(unit, covers)| {
            let levels: BTreeSet<Option<Level>> = covers.iter().map(level).collect();
            let mut requirements: Vec<usize> = covers.iter().copied().collect();
            requirements.sort_by_key(level);
            (levels.len() > 1).then(|| MixedLevels { unit: unit.clone(), requirements })
        });
        SharedRequirements { covered: of_requirement.len(), mixed: mixed.collect(), groups }
    }

    /// Number of requirements without a check of their own.
    pub fn shared(&self) -> usize {
        self.groups.iter().map(|group| group.requirements.len()).sum()
    }

    /// Their share of the manual's own requirements in percent.
    pub fn percent(&self, manual: &Manual) -> f64 {
        100.0 * self.shared() as f64 / manual.own_requirements().max(1) as f64
    }
}

/// Each unit that is judged as one, with the requirements that it covers in any variant: the row of a case apart from its checks, a
/// check with its own requirements, a rule.
fn units(manual: &Manual) -> BTreeMap<String, BTreeSet<usize>> {
    let mut units: BTreeMap<String, BTreeSet<usize>> = BTreeMap::new();
    let mut add = |unit: String, covers: &[usize]| {
        if !covers.is_empty() {
            units.entry(unit).or_default().extend(covers);
        }
    };
    for variant in &manual.variants {
        for trial in variant.trials.iter().filter(|trial| manual.is_own(trial)) {
            let of_steps = step_abouts(trial);
            let whole: Vec<usize> = trial.covers.iter().copied().filter(|of| !of_steps.contains(of)).collect();
            add(trial.id.clone(), &whole);
            each_step_of(trial, &mut |step: &TrialStep| {
                let unit = format!("{}, line {}: {}", trial.id, step.at.line, step.text);
                let about = step.about.requirements().iter().copied();
                let about = about.filter(|of| of_steps.contains(of) && trial.covers.contains(of));
                add(unit.clone(), &about.collect::<Vec<usize>>());
                if step.apart.is_empty() {
                    add(unit, &step.covers);
                } else {
                    step.apart.iter().for_each(|(name, covers)| add(format!("{unit}, name {name}"), covers));
                }
            });
        }
        variant.rules.iter().for_each(|rule| add(rule.id.clone(), &rule.covers));
    }
    units
}
