//! `encspec coverage`: how much of each manual is covered.

use super::{CoverageArgs, Ended, Format, show};
use crate::report::ExitStatus;
use crate::suite::model::{Class, Manual, Step, Trial, Verb};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;

pub(super) fn coverage(args: &CoverageArgs) -> Ended {
    let manuals: Vec<Coverage> = args.suites.load()?.iter().map(Coverage::of).collect();
    match args.format {
        Format::Json => {
            #[derive(Serialize)]
            struct Report {
                manuals: Vec<Coverage>,
            }
            show(&super::list::pretty(&Report { manuals }));
        }
        Format::Text => show(&manuals.iter().map(Coverage::text).collect::<String>()),
    }
    Ok(ExitStatus::Green)
}

/// How much of one manual is covered; the keys are the contract with other tools.
#[derive(Debug, Serialize)]
struct Coverage {
    id: String,
    total: usize,
    by_class: BTreeMap<&'static str, usize>,
    testable: usize,
    covered: usize,
    uncovered: Vec<String>,
}

impl Coverage {
    fn of(manual: &Manual) -> Coverage {
        let covering = covering(manual);
        let mut by_class: BTreeMap<&'static str, usize> =
            ["covered", "uncovered", "implicit", "untestable", "out-of-scope", "contradictory"]
                .map(|class| (class, 0))
                .into();
        let mut uncovered = Vec::new();
        for (of, cases) in manual.requirements.iter().zip(&covering) {
            *by_class.entry(class(&of.class, !cases.is_empty())).or_default() += 1;
            if of.class == Class::Testable && cases.is_empty() {
                uncovered.push(of.id.clone());
            }
        }
        let testable = manual.requirements.iter().filter(|of| of.class == Class::Testable).count();
        Coverage {
            id: manual.device.name.clone(),
            total: manual.requirements.len(),
            by_class,
            testable,
            covered: testable - uncovered.len(),
            uncovered,
        }
    }

    fn text(&self) -> String {
        let mut out = String::new();
        let classes: Vec<String> = self.by_class.iter().map(|(class, n)| format!("{n} {class}")).collect();
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}: {} of {} testable requirements are covered", self.id, self.covered, self.testable);
        let _ = writeln!(out, "  {} requirements: {}", self.total, classes.join(", "));
        if !self.uncovered.is_empty() {
            let _ = writeln!(out, "  not covered:");
            for line in self.uncovered.chunks(6) {
                let _ = writeln!(out, "    {}", line.join(" "));
            }
        }
        out
    }
}

/// The word of a class; `covered` is derived from the cases.
pub(super) fn class(class: &Class, is_covered: bool) -> &'static str {
    match class {
        Class::Testable if is_covered => "covered",
        Class::Testable => "uncovered",
        Class::Implicit(_) => "implicit",
        Class::Untestable(_) => "untestable",
        Class::OutOfScope(_) => "out-of-scope",
        Class::Contradictory(_) => "contradictory",
    }
}

/// The ids of the trials and rules that cover each requirement, in the order of the suites, each once.
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

/// Every requirement that a trial covers, those of its checks included.
pub(super) fn covers(trial: &Trial) -> Vec<usize> {
    let mut list = trial.covers.clone();
    for steps in [&trial.given, &trial.steps, &trial.finally] {
        walk(steps, &mut |step| list.extend(&step.covers));
    }
    list.sort_unstable();
    list.dedup();
    list
}

/// Visits every step, those inside blocks and readings included.
fn walk(steps: &[Step], visit: &mut impl FnMut(&Step)) {
    for step in steps {
        visit(step);
        match &step.verb {
            Verb::Block { steps, .. } => walk(steps, visit),
            Verb::Either(readings) => readings.iter().for_each(|reading| walk(&reading.steps, visit)),
            _ => {}
        }
    }
}
