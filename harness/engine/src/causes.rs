//! Groups the failures of a run by their probable cause: what the failed trials need, and the passed ones do not.
//!
//! A feature is something that a trial needs: a procedure, a name, a module, a start parameter, a requirement; for a failed check also
//! the name that was wrong, and its suite. A feature is suspicious if many of the trials that have it failed; failures that suspicious
//! features connect are a group. It is named after the features that tell it best from the passed trials. The result says what to look
//! at first; it changes no verdict.

use results::outcome::{CaseKind, CaseResult, ProbableCause};
use results::verdict::Verdict;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use suite::model::{Manual, SuiteVariant, Trial, TrialStep, Verb};
use suite::scan::{each_step, each_step_of};

/// A group is formed of so many failures at least.
const FEWEST: usize = 2;
/// A feature is suspicious if one of so many cases that have it failed.
const SUSPICIOUS: usize = 3;
/// It is suspicious as well if those that have it fail so many times as often as all.
const LIFT: usize = 4;
/// How many features of a group are named.
const NAMED: usize = 3;

/// A failed or passed trial or rule, with its features.
struct JudgedCase<'a> {
    case: &'a CaseResult,
    failed: bool,
    features: BTreeSet<String>,
    /// Number of steps of the trial.
    steps: usize,
}

/// The groups, the largest first; a failure that has nothing in common with another one is a group of its own.
pub fn causes(manual: &Manual, variant: &SuiteVariant, cases: &[CaseResult]) -> Vec<ProbableCause> {
    let is_failed = |case: &&CaseResult| case.verdict == Verdict::Fail;
    if cases.iter().filter(is_failed).count() < FEWEST {
        return Vec::new();
    }
    let trials: HashMap<String, &Trial> =
        variant.trials.iter().map(|trial| (format!("{}/{}", manual.device.name, trial.id), trial)).collect();
    let judged = cases.iter().filter(|case| matches!(case.verdict, Verdict::Pass | Verdict::Fail));
    let judged = judged.map(|case| judge(manual, variant, &trials, case));
    let (failed, passed): (Vec<JudgedCase<'_>>, Vec<JudgedCase<'_>>) = judged.partition(|of| of.failed);
    let features = count(&failed, &passed);
    let all = FeatureCount { failed: failed.len(), passed: passed.len() };
    let mut groups: Vec<Vec<&JudgedCase<'_>>> = connected(&failed, &features, all);
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    groups.into_iter().map(|group| group_of(group, &features)).collect()
}

/// How many failed and how many passed cases have a feature.
#[derive(Clone, Copy, Default)]
struct FeatureCount {
    failed: usize,
    passed: usize,
}

impl FeatureCount {
    /// Whether enough of those that have it failed, or clearly more than of `all`, that it may be the cause.
    fn is_suspicious(self, all: FeatureCount) -> bool {
        let is_often = self.failed * SUSPICIOUS >= self.total();
        let is_more = self.failed * all.total() >= LIFT * all.failed * self.total();
        self.failed >= FEWEST && (is_often || is_more)
    }

    fn total(self) -> usize {
        self.failed + self.passed
    }
}

fn count<'a>(failed: &'a [JudgedCase<'_>], passed: &'a [JudgedCase<'_>]) -> HashMap<&'a str, FeatureCount> {
    let mut counts: HashMap<&str, FeatureCount> = HashMap::new();
    for feature in failed.iter().flat_map(|of| &of.features) {
        counts.entry(feature).or_default().failed += 1;
    }
    for feature in passed.iter().flat_map(|of| &of.features) {
        if let Some(count) = counts.get_mut(feature.as_str()) {
            count.passed += 1;
        }
    }
    counts
}

/// Groups of failed cases that suspicious features connect.
fn connected<'a, 'c>(
    failed: &'a [JudgedCase<'c>],
    features: &HashMap<&str, FeatureCount>,
    all: FeatureCount,
) -> Vec<Vec<&'a JudgedCase<'c>>> {
    let mut groups: Vec<(BTreeSet<&str>, Vec<&JudgedCase<'_>>)> = Vec::new();
    for of in failed {
        let is_suspicious = |name: &&str| features.get(name).is_some_and(|count| count.is_suspicious(all));
        let own: BTreeSet<&str> = of.features.iter().map(String::as_str).filter(is_suspicious).collect();
        let (same, others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|(known, _)| !known.is_disjoint(&own));
        let mut group = (own, vec![of]);
        for (known, cases) in same {
            group.0.extend(known);
            group.1.extend(cases);
        }
        groups = others;
        groups.push(group);
    }
    groups.into_iter().map(|(_, cases)| cases).collect()
}

fn group_of(mut group: Vec<&JudgedCase<'_>>, features: &HashMap<&str, FeatureCount>) -> ProbableCause {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    group.iter().flat_map(|of| &of.features).for_each(|name| *counts.entry(name).or_default() += 1);
    // The harmonic mean of how many of the group have it and how many of those that have it are in the group.
    let score = |name: &str, own: usize| {
        let all = features.get(name).map_or(own, |count| count.total());
        2.0 * own as f64 / (group.len() + all) as f64
    };
    let mut named: Vec<(&str, f64)> = counts.iter().map(|(name, own)| (*name, score(name, *own))).collect();
    named.sort_by(|one, other| other.1.total_cmp(&one.1).then_with(|| one.0.cmp(other.0)));
    named.truncate(if group.len() < FEWEST { 0 } else { NAMED });
    let common: Vec<String> = named.iter().map(|(name, _)| (*name).to_owned()).collect();
    let has = |of: &&JudgedCase<'_>| common.first().is_some_and(|name| of.features.contains(name));
    group.sort_by_key(|of| (!has(of), of.case.kind == CaseKind::Rule, of.steps, of.case.frames));
    cause(&group, common)
}

fn cause(group: &[&JudgedCase<'_>], common: Vec<String>) -> ProbableCause {
    let mut requirements: Vec<String> = Vec::new();
    for covered in group.iter().flat_map(|of| &of.case.covers).filter(|of| of.verdict == Verdict::Fail) {
        if !requirements.contains(&covered.id) {
            requirements.push(covered.id.clone());
        }
    }
    ProbableCause { common, cases: group.iter().map(|of| of.case.id.clone()).collect(), requirements }
}

fn judge<'a>(
    manual: &Manual,
    variant: &SuiteVariant,
    trials: &HashMap<String, &Trial>,
    case: &'a CaseResult,
) -> JudgedCase<'a> {
    let failed = case.verdict == Verdict::Fail;
    let mut of = JudgedCase { case, failed, features: BTreeSet::new(), steps: 0 };
    for covered in case.covers.iter().filter(|covered| covered.verdict == case.verdict) {
        of.features.insert(format!("requirement {}", covered.id));
    }
    let topic = case.id.split('/').nth(1).unwrap_or_default();
    of.features.insert(format!("suite {topic}"));
    if let Some(trial) = trials.get(&case.id) {
        let trial: &Trial = trial;
        each_step_of(trial, &mut |step| {
            of.steps += 1;
            needed(&mut of.features, variant, step, failed);
        });
        if let Some(start) = trial.start() {
            let module = manual.device.modules.get(start.module);
            of.features.extend(module.map(|module| format!("module {}", module.name)));
            for parameter in &start.parameters {
                let record = manual.device.records.get(parameter.record);
                let field = record.and_then(|record| record.fields.get(parameter.field));
                of.features.extend(field.map(|field| format!("start parameter {}", field.name)));
            }
        }
    }
    for part in case.failures.iter().flat_map(|failure| &failure.parts).filter(|part| !part.held) {
        of.features.insert(format!("check of {}", name_of(&part.text)));
    }
    of
}

/// What a step needs. A failed trial may have ended before its checks, so only its failures say what was wrong.
fn needed(features: &mut BTreeSet<String>, variant: &SuiteVariant, step: &TrialStep, failed: bool) {
    let path = |name: &expression::NameId| variant.paths.get(name.0 as usize).cloned().unwrap_or_default();
    let mut add = |kind: &str, name: String| {
        features.insert(format!("{kind} {name}"));
    };
    if let Some(procedure) = step.text.strip_prefix("do: ") {
        add("procedure", procedure.split(',').next().unwrap_or_default().to_owned());
    }
    match &step.verb {
        Verb::Set(settings) => settings.iter().for_each(|setting| add("name", path(&setting.name))),
        Verb::Exchange(entries) => {
            entries.iter().flat_map(|entry| &entry.set).for_each(|setting| add("name", path(&setting.name)));
        }
        Verb::Write(access) => access.items.iter().for_each(|item| add("write of", path(&item.name))),
        Verb::Read { access, .. } => access.items.iter().for_each(|item| {
            add("name", path(&item.name));
            if !failed {
                add("check of", path(&item.name));
            }
        }),
        Verb::Expect { condition, .. } => condition.parts.iter().for_each(|part| {
            add("name", name_of(&part.text).to_owned());
            if !failed {
                add("check of", name_of(&part.text).to_owned());
            }
        }),
        Verb::Connect { .. } => add("name", "connect".to_owned()),
        Verb::Turn(_) => add("name", "shaft".to_owned()),
        Verb::Send { .. } => {
            add("service", step.text.split([',', ':']).nth(1).unwrap_or_default().trim_matches([' ', '{']).to_owned());
        }
        Verb::Either(readings) if !failed => {
            for reading in readings {
                each_step(&reading.steps, &mut |step| {
                    if let Verb::Expect { condition, .. } = &step.verb {
                        condition.parts.iter().for_each(|part| add("check of", name_of(&part.text).to_owned()));
                    }
                });
            }
        }
        _ => {}
    }
}

/// The name at the begin of a part of a condition; of a reading the part after its name.
fn name_of(part: &str) -> &str {
    let is_end = |c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '.');
    part.trim_start().split(is_end).next().unwrap_or_default()
}
