//! `encspec coverage`: how much of each manual the cases and rules cover.

use super::{CommandResult, CoverageArgs, ListingFormat, show};
use report::ExitStatus;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use suite::model::{GenericSuite, LeftOutPart, Manual, RequirementClass, Trial};
use suite::reach::{self, Reach};

pub(super) fn coverage(args: &CoverageArgs) -> CommandResult {
    let manuals: Vec<Coverage> = args.suites.load_one(args.manual.as_deref())?.iter().map(Coverage::of).collect();
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
    uncovered: Vec<String>,
    /// Those of the uncovered requirements of which it is known what check is missing.
    no_check: Vec<Unreached>,
    /// The suites that the manual uses too, whose requirements are among the others.
    also: Vec<GenericCoverage>,
    live: LiveCoverage,
}

/// The part of the coverage that comes from a suite that the manual uses too.
#[derive(Debug, Serialize)]
struct GenericCoverage {
    suite: String,
    total: usize,
    covered: usize,
    /// What the manual leaves out, each with the reason and with the clause that says otherwise, if one does.
    left_out: Vec<Unreached>,
}

impl GenericCoverage {
    fn of(suite: &GenericSuite, covering: &[Vec<String>]) -> GenericCoverage {
        let why = |of: &LeftOutPart| match &of.cites {
            Some(clause) => format!("{clause}: {}", of.why),
            None => of.why.clone(),
        };
        GenericCoverage {
            suite: suite.name.clone(),
            total: suite.requirements.len(),
            covered: covering[suite.requirements.clone()].iter().filter(|cases| !cases.is_empty()).count(),
            left_out: suite.except.iter().map(|of| Unreached { id: of.what.clone(), why: why(of) }).collect(),
        }
    }

    fn text(&self, out: &mut String) {
        let GenericCoverage { suite, total, covered, left_out } = self;
        // Writing into a String cannot fail.
        let _ = writeln!(out, "  of these from {suite}: {covered} of {total} requirements covered; left out:");
        for Unreached { id, why } in left_out {
            let _ = writeln!(out, "    {id}: {why}");
        }
    }
}

/// Where the covered requirements can be judged on a live device, each by the trial or rule that takes least.
#[derive(Debug, Serialize)]
struct LiveCoverage {
    /// The kind of link to the device: `nic` or `serial`.
    link: &'static str,
    /// With the link, a description of the vendor, all consents, and no more.
    no_stand: Vec<String>,
    /// Only with a stand: control of shaft, power or faults, or LEDs that it reads.
    with_stand: Vec<String>,
    /// On the virtual wire only.
    never: Vec<Unreached>,
}

#[derive(Debug, Serialize)]
struct Unreached {
    id: String,
    why: String,
}

impl Coverage {
    fn of(manual: &Manual) -> Coverage {
        let covering = covering(manual);
        let mut by_class: BTreeMap<&'static str, usize> =
            ["covered", "uncovered", "no-check", "implicit", "untestable", "out-of-scope", "contradictory"]
                .map(|class| (class, 0))
                .into();
        let (mut uncovered, mut no_check, mut testable) = (Vec::new(), Vec::new(), 0);
        for (of, cases) in manual.requirements.iter().zip(&covering) {
            *by_class.entry(class(&of.class, !cases.is_empty())).or_default() += 1;
            if !is_testable(&of.class) {
                continue;
            }
            testable += 1;
            if cases.is_empty() {
                uncovered.push(of.id.clone());
                if let RequirementClass::NoCheck(why) = &of.class {
                    no_check.push(Unreached { id: of.id.clone(), why: why.clone() });
                }
            }
        }
        Coverage {
            id: manual.device.name.clone(),
            total: manual.requirements.len(),
            by_class,
            testable,
            covered: testable - uncovered.len(),
            uncovered,
            no_check,
            also: manual.also.iter().map(|suite| GenericCoverage::of(suite, &covering)).collect(),
            live: LiveCoverage::of(manual),
        }
    }

    fn text(&self) -> String {
        let mut out = String::new();
        let classes: Vec<String> = self.by_class.iter().map(|(class, n)| format!("{n} {class}")).collect();
        let Coverage { id, total, testable, covered, .. } = self;
        let left_out = total - testable;
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "{id}: {covered} of {testable} testable requirements covered ({})",
            share(*covered, *testable)
        );
        let _ = writeln!(out, "  {total} requirements: {}", classes.join(", "));
        let _ = writeln!(out, "  {left_out} untestable or out of scope ({})", share(left_out, *total));
        if !self.uncovered.is_empty() {
            let _ = writeln!(out, "  not covered:");
            columns(&mut out, &self.uncovered);
        }
        for Unreached { id, why } in &self.no_check {
            let _ = writeln!(out, "    {id}: {why}");
        }
        self.also.iter().for_each(|suite| suite.text(&mut out));
        self.live.text(&mut out);
        out
    }
}

impl LiveCoverage {
    fn of(manual: &Manual) -> LiveCoverage {
        let link = if manual.device.bus.kind().is_profibus() { "serial" } else { "nic" };
        let mut live = LiveCoverage { link, no_stand: Vec::new(), with_stand: Vec::new(), never: Vec::new() };
        let reached = manual.requirements.iter().zip(reach::of_requirements(manual));
        for (of, reach) in reached.filter(|(of, _)| is_testable(&of.class)) {
            let id = of.id.clone();
            match reach {
                Some(Reach::NoStand) => live.no_stand.push(id),
                Some(Reach::WithStand) => live.with_stand.push(id),
                Some(Reach::Never(why)) => live.never.push(Unreached { id, why }),
                None => {}
            }
        }
        live
    }

    fn text(&self, out: &mut String) {
        let LiveCoverage { link, no_stand, with_stand, never } = self;
        let link = if *link == "serial" { "at a serial line" } else { "at a network interface" };
        let all = no_stand.len() + with_stand.len() + never.len();
        // Writing into a String cannot fail.
        let _ = writeln!(out, "  live, {link}:");
        for (what, of) in
            [("without a stand", no_stand.len()), ("only with a stand", with_stand.len()), ("never", never.len())]
        {
            let _ = writeln!(out, "    {what:<17} {of:>4} ({})", share(of, all));
        }
        let mut reasons: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        never.iter().for_each(|of| reasons.entry(&of.why).or_default().push(of.id.clone()));
        for (why, ids) in reasons {
            let _ = writeln!(out, "  never live, {why}:");
            columns(out, &ids);
        }
    }
}

/// Whether a requirement counts: it is neither untestable nor out of scope.
fn is_testable(class: &RequirementClass) -> bool {
    !matches!(class, RequirementClass::Untestable(_) | RequirementClass::OutOfScope(_))
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
        RequirementClass::NoCheck(_) => "no-check",
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

/// Every requirement that a trial covers, including those of its checks.
pub(super) fn covers(trial: &Trial) -> Vec<usize> {
    let mut list = trial.covers.clone();
    list.extend(&trial.outline.checks);
    list.sort_unstable();
    list.dedup();
    list
}
