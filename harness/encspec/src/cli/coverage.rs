//! `encspec coverage`: how much of each manual the cases and rules cover.

use super::{CommandResult, CoverageArgs, ListingFormat, show};
use report::ExitStatus;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use suite::model::{Manual, RequirementClass, Trial};

pub(super) fn coverage(args: &CoverageArgs) -> CommandResult {
    let manuals: Vec<Coverage> = args.suites.load()?.iter().map(Coverage::of).collect();
    match args.format {
        ListingFormat::Json => show(&super::list::json(manuals)),
        ListingFormat::Text => show(&manuals.iter().map(Coverage::text).collect::<String>()),
    }
    Ok(ExitStatus::Green)
}

/// The coverage of one manual. Other tools rely on the JSON keys.
#[derive(Debug, Serialize)]
struct Coverage {
    id: String,
    total: usize,
    by_class: BTreeMap<&'static str, usize>,
    /// Number of requirements that are neither untestable nor out of scope.
    testable: usize,
    /// Number of testable requirements that a case or rule covers, including contradictory ones.
    covered: usize,
    /// Number of covered requirements that need no stand: no turned shaft, no switched power, no LEDs.
    without_stand: usize,
    uncovered: Vec<String>,
}

impl Coverage {
    fn of(manual: &Manual) -> Coverage {
        let covering = covering(manual);
        let mut by_class: BTreeMap<&'static str, usize> =
            ["covered", "uncovered", "implicit", "untestable", "out-of-scope", "contradictory"]
                .map(|class| (class, 0))
                .into();
        let (mut uncovered, mut without_stand, mut testable) = (Vec::new(), 0, 0);
        let reached = without_stand_reached(manual);
        for ((of, cases), reached) in manual.requirements.iter().zip(&covering).zip(reached) {
            *by_class.entry(class(&of.class, !cases.is_empty())).or_default() += 1;
            if matches!(of.class, RequirementClass::Untestable(_) | RequirementClass::OutOfScope(_)) {
                continue;
            }
            testable += 1;
            without_stand += usize::from(reached);
            if cases.is_empty() {
                uncovered.push(of.id.clone());
            }
        }
        Coverage {
            id: manual.device.name.clone(),
            total: manual.requirements.len(),
            by_class,
            testable,
            covered: testable - uncovered.len(),
            without_stand,
            uncovered,
        }
    }

    fn text(&self) -> String {
        let mut out = String::new();
        let classes: Vec<String> = self.by_class.iter().map(|(class, n)| format!("{n} {class}")).collect();
        let Coverage { id, total, testable, covered, without_stand, .. } = self;
        let left_out = total - testable;
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "{id}: {covered} of {testable} testable requirements covered ({})",
            share(*covered, *testable)
        );
        let _ = writeln!(out, "  {total} requirements: {}", classes.join(", "));
        let _ = writeln!(out, "  {left_out} untestable or out of scope ({})", share(left_out, *total));
        let _ = writeln!(
            out,
            "  {without_stand} of the covered requirements need no stand ({})",
            share(*without_stand, *covered)
        );
        if !self.uncovered.is_empty() {
            let _ = writeln!(out, "  not covered:");
            columns(&mut out, &self.uncovered);
        }
        out
    }
}

/// Writes ids, six on a line.
pub(super) fn columns(out: &mut String, ids: &[String]) {
    for line in ids.chunks(6) {
        let _ = writeln!(out, "    {}", line.join(" "));
    }
}

/// A percentage with one decimal, rounded down, so that only a complete part is shown as 100.0 %.
pub(super) fn share(part: usize, of: usize) -> String {
    let thousandths = (part * 1000).checked_div(of).unwrap_or(0);
    format!("{}.{} %", thousandths / 10, thousandths % 10)
}

/// The name of a requirement class; `covered` is derived from the cases.
pub(super) fn class(class: &RequirementClass, is_covered: bool) -> &'static str {
    match class {
        RequirementClass::Testable if is_covered => "covered",
        RequirementClass::Testable => "uncovered",
        RequirementClass::Implicit(_) => "implicit",
        RequirementClass::Untestable(_) => "untestable",
        RequirementClass::OutOfScope(_) => "out-of-scope",
        RequirementClass::Contradictory(_) => "contradictory",
    }
}

/// For each requirement the ids of the trials and rules that cover it, in suite order without duplicates.
pub(super) fn covering(manual: &Manual) -> Vec<Vec<String>> {
    let mut covering = vec![Vec::new(); manual.requirements.len()];
    let mut note = |covers: &[usize], id: &str| {
        for &requirement in covers {
            if let Some(list) = covering.get_mut(requirement)
                && !list.iter().any(|known| known == id)
            {
                list.push(id.to_owned());
            }
        }
    };
    for variant in &manual.variants {
        for trial in &variant.trials {
            note(&covers(trial), &trial.id);
        }
        for rule in &variant.rules {
            note(&rule.covers, &rule.id);
        }
    }
    covering
}

/// For each requirement whether a rule, or a trial or check that needs no stand, covers it.
fn without_stand_reached(manual: &Manual) -> Vec<bool> {
    let mut reached = vec![false; manual.requirements.len()];
    let mut reach = |covers: &[usize]| {
        covers.iter().for_each(|&requirement| reached.iter_mut().skip(requirement).take(1).for_each(|of| *of = true));
    };
    for variant in &manual.variants {
        variant.rules.iter().for_each(|rule| reach(&rule.covers));
        variant.trials.iter().for_each(|trial| reach(&trial.outline.without_stand));
    }
    reached
}

/// Every requirement that a trial covers, including those of its checks.
pub(super) fn covers(trial: &Trial) -> Vec<usize> {
    let mut list = trial.covers.clone();
    list.extend(&trial.outline.checks);
    list.sort_unstable();
    list.dedup();
    list
}
